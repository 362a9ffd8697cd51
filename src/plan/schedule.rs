//! Pieces run one after the other within the limits of a machine: where and when each point is taken.

use crate::error::positive;
use crate::piece::distance_mm;
use crate::speed::Speeds;
use crate::{Machine, Piece, PlanError, Trapezoid};

/// What a machine may do while it scans.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Limits {
    /// Its axes.
    pub machine: Machine,
    /// Speed of the probe along a path in mm/s, as far as the axes allow it.
    pub scan_speed_mm_s: f64,
    /// Time at each listed place in s.
    pub dwell_s: f64,
}

/// How points follow each other along a piece.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Spacing {
    /// Evenly from end to end, no farther apart than this.
    AtMost {
        /// Largest distance in mm.
        mm: f64,
    },
    /// By a trigger at every such length from the beginning of the piece.
    Every {
        /// Distance in mm.
        mm: f64,
    },
}

/// A point to be taken.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TimedPoint {
    /// Its place in mm.
    pub at_mm: [f64; 2],
    /// Positions of the axes: x and y in mm, or r in mm and c in rad.
    pub axes: [f64; 2],
    /// When it is taken, in s after the start.
    pub t_s: f64,
}

/// A path with its times.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Schedule {
    /// The points in the order in which they are taken.
    pub points: Vec<TimedPoint>,
    /// Time of the whole path in s.
    pub total_s: f64,
    /// Time on pieces in s.
    pub scan_s: f64,
    /// Time between pieces in s.
    pub move_s: f64,
    /// Time at listed places in s.
    pub dwell_s: f64,
    /// Length of the pieces in mm.
    pub scan_mm: f64,
    /// Length of pieces in mm that is run at the scan speed, without ramps and where the axes allow it.
    pub full_speed_mm: f64,
    /// Straight distance between pieces in mm.
    pub move_mm: f64,
}

/// Runs pieces from where the probe stands, or else from their first place.
///
/// Each piece begins and ends at rest. On a piece the probe keeps the scan speed but for its ramps and where an axis allows less. Between pieces
/// each axis takes its shortest run, and the slower one counts. A turning table takes the shorter way round where its travel allows it.
///
/// # Errors
///
/// When a limit is no positive number, a piece leaves the travel of an axis, the machine cannot follow it, or there are more than
/// [`MOST_POINTS`] points.
pub fn schedule(
    pieces: &[Piece],
    spacing: Spacing,
    limits: &Limits,
    from_mm: Option<[f64; 2]>,
) -> Result<Schedule, PlanError> {
    let each: Vec<(Piece, Spacing)> = pieces.iter().map(|&piece| (piece, spacing)).collect();
    schedule_each(&each, limits, from_mm)
}

/// The same where every piece has a spacing of its own.
///
/// # Errors
///
/// As [`schedule`].
pub fn schedule_each(
    pieces: &[(Piece, Spacing)],
    limits: &Limits,
    from_mm: Option<[f64; 2]>,
) -> Result<Schedule, PlanError> {
    limits.validate()?;
    let mut expected = 0.0;
    for (piece, Spacing::AtMost { mm } | Spacing::Every { mm }) in pieces {
        let mm = positive("spacing", *mm, "give the distance of points in mm")?;
        expected += piece.length_mm() / mm + 1.0;
    }
    if expected > MOST_POINTS as f64 {
        return Err(PlanError::new(
            "spacing",
            format!("at most {MOST_POINTS} points"),
            format!("about {expected:.0}"),
            "give a larger spacing, or plan a smaller aperture",
        ));
    }
    let mut run = Run { limits, axes: None, found: Schedule::default() };
    if let Some(at_mm) = from_mm {
        run.go_to(&Piece::Stop { at_mm })?;
    }
    for (piece, spacing) in pieces {
        run.take(piece, *spacing)?;
    }
    Ok(run.found)
}

impl Limits {
    pub(crate) fn validate(&self) -> Result<(), PlanError> {
        self.machine.validate()?;
        positive("scan_speed", self.scan_speed_mm_s, "give the speed of the scan in mm/s")?;
        if self.dwell_s.is_finite() && self.dwell_s >= 0.0 {
            return Ok(());
        }
        let found = self.dwell_s.to_string();
        Err(PlanError::new("dwell", "a time from 0 s", found, "give the time at a place"))
    }
}

/// A machine on its way.
struct Run<'a> {
    limits: &'a Limits,
    /// Where the axes stand, and the probe.
    axes: Option<([f64; 2], [f64; 2])>,
    found: Schedule,
}

impl Run<'_> {
    /// Moves to the beginning of a piece; the turns that are added to the table.
    fn go_to(&mut self, piece: &Piece) -> Result<f64, PlanError> {
        let machine = &self.limits.machine;
        let c_rad = self.axes.map_or(0.0, |([_, c], _)| c);
        let added = machine.enter(piece, c_rad)?;
        let mut to = machine.motion(piece, 0.0).at;
        to[1] += added;
        // On its axis a table need not turn.
        if machine.is_polar() && matches!(piece, Piece::Stop { .. }) && to[0] == 0.0 {
            to[1] = c_rad;
        }
        let place = piece.at(0.0);
        if let Some((from, stood)) = self.axes {
            let axes = machine.axes();
            let times = [0, 1].map(|k| {
                let length = (to[k] - from[k]).abs();
                Trapezoid::new(length, axes[k].speed, axes[k].acceleration).duration_s()
            });
            let moved_s = times[0].max(times[1]);
            self.found.total_s += moved_s;
            self.found.move_s += moved_s;
            self.found.move_mm += distance_mm(stood, place);
        }
        self.axes = Some((to, place));
        Ok(added)
    }

    fn take(&mut self, piece: &Piece, spacing: Spacing) -> Result<(), PlanError> {
        let added = self.go_to(piece)?;
        if matches!(piece, Piece::Stop { .. }) || piece.length_mm() <= 0.0 {
            self.found.total_s += self.limits.dwell_s;
            self.found.dwell_s += self.limits.dwell_s;
            let Some((axes, at_mm)) = self.axes else { return Ok(()) };
            self.found.points.push(TimedPoint { at_mm, axes, t_s: self.found.total_s });
            return Ok(());
        }
        let machine = &self.limits.machine;
        let length_mm = piece.length_mm();
        let pace = self.pace(piece);
        let axes_at = |way_mm: f64| {
            let mut axes = machine.motion(piece, way_mm).at;
            axes[1] += if machine.is_polar() { added } else { 0.0 };
            axes
        };
        // Where a piece goes on from the last point, as a turn from its spiral, no place is measured twice.
        let last = self.found.points.last().map(|point| point.at_mm);
        let is_last = |at_mm| last.is_some_and(|last| distance_mm(last, at_mm) <= SAME_MM);
        for way_mm in spacing.ways_mm(piece) {
            let t_s = self.found.total_s + pace.time_at_s(way_mm);
            let (at_mm, axes) = (piece.at(way_mm), axes_at(way_mm));
            if way_mm == 0.0 && is_last(at_mm) {
                continue;
            }
            self.found.points.push(TimedPoint { at_mm, axes, t_s });
        }
        self.found.total_s += pace.duration_s();
        self.found.scan_s += pace.duration_s();
        self.found.scan_mm += length_mm;
        self.found.full_speed_mm += pace.length_at(self.limits.scan_speed_mm_s);
        self.axes = Some((axes_at(length_mm), piece.end()));
        Ok(())
    }

    /// The run of a piece: in closed form where its axes move evenly.
    fn pace(&self, piece: &Piece) -> Pace {
        let (machine, speed) = (&self.limits.machine, self.limits.scan_speed_mm_s);
        let even = match piece {
            Piece::Stop { .. } | Piece::Line { .. } => true,
            Piece::Arc { .. } => machine.is_polar(),
            Piece::Spiral { .. } => false,
        };
        if !even {
            return Pace::Curved(Speeds::new(piece, machine, speed));
        }
        let rate = machine.motion(piece, 0.0).rate;
        let (mut speed, mut acceleration) = (speed, f64::INFINITY);
        for (axis, rate) in machine.axes().iter().zip(rate.map(f64::abs)) {
            if rate > 0.0 {
                speed = speed.min(axis.speed / rate);
                acceleration = acceleration.min(axis.acceleration / rate);
            }
        }
        Pace::Even(Trapezoid::new(piece.length_mm(), speed, acceleration))
    }
}

impl Spacing {
    /// Lengths of way in mm at which a point is taken.
    pub fn ways_mm(self, piece: &Piece) -> Vec<f64> {
        let length_mm = piece.length_mm();
        if length_mm <= 0.0 {
            return vec![0.0];
        }
        match self {
            Spacing::AtMost { mm } => {
                let count = ((length_mm / mm - ROUNDING).ceil() as usize).max(1);
                // The end of a whole turn is its beginning.
                let last = count - usize::from(piece.is_closed());
                (0..=last).map(|k| length_mm * k as f64 / count as f64).collect()
            }
            Spacing::Every { mm } => {
                let last = (length_mm / mm + ROUNDING).floor() as usize;
                let ways = (0..=last).map(|k| (k as f64 * mm).min(length_mm));
                let is_first_again =
                    |way: f64| piece.is_closed() && way > length_mm - ROUNDING * mm;
                ways.filter(|&way| way == 0.0 || !is_first_again(way)).collect()
            }
        }
    }
}

/// A run of a piece.
enum Pace {
    Even(Trapezoid),
    Curved(Speeds),
}

impl Pace {
    fn duration_s(&self) -> f64 {
        match self {
            Pace::Even(run) => run.duration_s(),
            Pace::Curved(run) => run.duration_s(),
        }
    }

    fn time_at_s(&self, way_mm: f64) -> f64 {
        match self {
            Pace::Even(run) => run.time_at_s(way_mm),
            Pace::Curved(run) => run.time_at_s(way_mm),
        }
    }

    fn length_at(&self, speed: f64) -> f64 {
        match self {
            Pace::Even(run) => run.length_at(speed),
            Pace::Curved(run) => run.length_at(speed),
        }
    }
}

/// Most points of a plan.
pub const MOST_POINTS: usize = 10_000_000;

/// Places no farther apart are one.
const SAME_MM: f64 = 1e-9;

/// So small a share of a step is none.
const ROUNDING: f64 = 1e-9;
