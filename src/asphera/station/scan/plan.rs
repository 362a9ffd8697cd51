//! The plan of a scan as a configuration gives it.

use std::time::Duration;

use asphera_link::AxisMove;
use asphera_plan::{
    AdaptiveScan, Aperture, AxisRun, Batch, Ending, Goal, Limits, Machine, Piece, PlanError,
    Spacing,
};

/// Plan of a scan, checked.
#[derive(Clone, Debug, PartialEq)]
pub struct ScanPlan {
    /// Axes of the machine: x and y, or r and c.
    pub axes: [ScanAxis; 2],
    /// What the axes may do.
    pub limits: Limits,
    /// Pieces of the first pass.
    pub pieces: Vec<(Piece, Spacing)>,
    /// Time at a stop.
    pub dwell: Duration,
    /// Points nearer to the last one do not count, mm.
    pub point_spacing_mm: f64,
    /// Time in which the axes find home before the first piece; `None`: they know their places.
    pub home_within: Option<Duration>,
    /// Silence of a device after which the axes are halted.
    pub watchdog: Duration,
    /// Time after which no piece begins.
    pub time_limit: Option<Duration>,
    /// Points after which the scan ends.
    pub points_max: Option<u64>,
    /// What follows the first pass; `None`: nothing.
    pub adaptive: Option<AdaptivePlan>,
}

/// Axis that a plan drives.
#[derive(Clone, Debug, PartialEq)]
pub struct ScanAxis {
    /// Name of the channel, by which its driver knows it.
    pub name: String,
    /// Which stream of the synchronizer it is read from.
    pub stream: usize,
    /// Which channel of that stream.
    pub channel: usize,
    /// Position per unit of the channel: mm or rad.
    pub scale: f64,
    /// Position at 0 of the channel.
    pub offset: f64,
    /// So far an axis may be from where it should be: mm or rad.
    pub tolerance: f64,
}

/// Passes after the first.
#[derive(Clone, Debug, PartialEq)]
pub struct AdaptivePlan {
    /// What is to be reached.
    pub goal: Goal,
    /// Region of the scan.
    pub aperture: Aperture,
    /// Its centre, mm.
    pub centre_mm: [f64; 2],
    /// Spacing of the first pass in mm.
    pub spacing_mm: f64,
}

/// What follows a pass.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum ScanDecision {
    /// Another pass, along these.
    Measure(Vec<Stroke>),
    /// The scan ends.
    End(Ending),
}

/// A line or a stop of a pass. Whole nanometres are recorded without loss.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Stroke {
    /// First place, nm.
    pub from_nm: [i64; 2],
    /// Last place, nm; of a stop the first.
    pub to_nm: [i64; 2],
    /// Largest distance of points, nm.
    pub spacing_nm: i64,
}

impl AdaptivePlan {
    fn scan(&self) -> Result<AdaptiveScan, PlanError> {
        AdaptiveScan::new(self.goal, self.aperture, self.centre_mm, self.spacing_mm)
    }

    /// Lines of a raster that later passes refine: those of their lattice.
    ///
    /// # Errors
    ///
    /// When goal, aperture or spacing cannot be.
    pub fn first_pass(&self) -> Result<Vec<(Piece, Spacing)>, PlanError> {
        Ok(self.scan()?.begin(self.centre_mm).pieces)
    }
}

impl ScanDecision {
    /// The pass of a batch.
    pub fn measure(batch: &Batch) -> ScanDecision {
        let strokes =
            batch.pieces.iter().map(|&(piece, Spacing::AtMost { mm } | Spacing::Every { mm })| {
                Stroke {
                    from_nm: piece.at(0.0).map(nm),
                    to_nm: piece.end().map(nm),
                    spacing_nm: nm(mm).max(1),
                }
            });
        ScanDecision::Measure(strokes.collect())
    }
}

/// Why a scan ended, in words.
pub(super) fn ending_words(ending: Ending) -> &'static str {
    match ending {
        Ending::Reached => "coverage, uncertainty and verdict are as wanted",
        Ending::FailCertain => "a limit is broken whatever comes",
        Ending::BudgetSpent => "the time is spent",
        Ending::NothingToGain => "no place is left that helps",
    }
}

impl Stroke {
    /// The piece it stands for.
    pub(super) fn piece(&self) -> (Piece, Spacing) {
        let [from_mm, to_mm] = [self.from_nm, self.to_nm].map(|nm| nm.map(mm));
        let piece = match self.from_nm == self.to_nm {
            true => Piece::Stop { at_mm: from_mm },
            false => Piece::Line { from_mm, to_mm },
        };
        (piece, Spacing::AtMost { mm: mm(self.spacing_nm) })
    }
}

impl ScanPlan {
    /// The passes after the first; `None`: there are none. The places of the first pass count as measured.
    pub fn adaptive_scan(&self) -> Option<AdaptiveScan> {
        let plan = self.adaptive.as_ref()?;
        // That it can be was checked with the configuration.
        let mut scan = plan.scan().ok()?;
        let _ = scan.begin(plan.centre_mm);
        Some(scan)
    }

    /// The moves of a run, by axis. An axis that stands is not moved.
    pub(super) fn moves(&self, run: &AxisRun) -> Vec<(usize, AxisMove)> {
        let mut moves = Vec::new();
        for (axis, of) in self.axes.iter().enumerate() {
            if (run.to[axis] - run.from[axis]).abs() <= STANDS * of.tolerance {
                continue;
            }
            moves.push((
                axis,
                AxisMove {
                    axis: of.name.clone(),
                    to: (run.to[axis] - of.offset) / of.scale,
                    speed: run.speed[axis] / of.scale.abs(),
                    acceleration: Some(run.acceleration[axis] / of.scale.abs()),
                },
            ));
        }
        moves
    }

    /// Place of the probe in mm where the axes are.
    pub(super) fn place_mm(&self, [first, second]: [f64; 2]) -> [f64; 2] {
        match self.limits.machine {
            Machine::Cartesian { .. } => [first, second],
            Machine::Polar { .. } => {
                let (sin, cos) = second.sin_cos();
                [first * cos, first * sin]
            }
        }
    }
}

fn nm(mm: f64) -> i64 {
    (mm * 1e6).round() as i64
}

fn mm(nm: i64) -> f64 {
    nm as f64 * 1e-6
}

/// So small a share of the tolerance is no way.
const STANDS: f64 = 1e-3;
