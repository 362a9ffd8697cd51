//! Pieces as runs of the axes: from rest to rest, straight in the positions of the axes.

use crate::schedule::Limits;
use crate::{Machine, Piece, PlanError, Spacing, Trapezoid};

/// Run of both axes from where they stand. Positions are x and y in mm, or r in mm and c in rad.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AxisRun {
    /// Positions at its beginning.
    pub from: [f64; 2],
    /// Positions at its end.
    pub to: [f64; 2],
    /// Speed of each axis, per s; that of an axis that stands counts for nothing.
    pub speed: [f64; 2],
    /// Acceleration of each axis, per s².
    pub acceleration: [f64; 2],
    /// Time it takes in s, without the dwell.
    pub duration_s: f64,
    /// Kind of the run.
    pub kind: RunKind,
}

/// Kind of a run.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum RunKind {
    /// Between pieces: each axis takes its shortest run.
    Transit,
    /// Along a piece that is measured: both axes begin and end together.
    Line,
    /// To a place that is measured at rest.
    Stop,
}

/// Runs along pieces, from where the axes stand.
///
/// A piece that is straight in the positions of the axes is one run: a line of two stages; on a turning table a line from its axis, a circle
/// about it, a spiral of Archimedes. Other pieces become stops at their points.
///
/// # Errors
///
/// When a piece leaves the travel of an axis.
pub fn axis_runs(
    pieces: &[(Piece, Spacing)],
    limits: &Limits,
    stand: [f64; 2],
) -> Result<Vec<AxisRun>, PlanError> {
    limits.validate()?;
    let mut run = Runs { limits, stand, runs: Vec::new() };
    for (piece, spacing) in pieces {
        run.take(piece, *spacing)?;
    }
    Ok(run.runs)
}

struct Runs<'a> {
    limits: &'a Limits,
    stand: [f64; 2],
    runs: Vec<AxisRun>,
}

impl Runs<'_> {
    fn take(&mut self, piece: &Piece, spacing: Spacing) -> Result<(), PlanError> {
        let length_mm = piece.length_mm();
        if length_mm <= 0.0 {
            let [x, y] = piece.at(0.0);
            return self.stop([x, y]);
        }
        if !self.is_straight(piece) {
            return spacing
                .ways_mm(piece)
                .into_iter()
                .try_for_each(|way_mm| self.stop(piece.at(way_mm)));
        }
        let from = self.enter(piece)?;
        let machine = &self.limits.machine;
        let ends = [0.0, length_mm].map(|way_mm| machine.motion(piece, way_mm).at);
        let to = [from[0] + ends[1][0] - ends[0][0], from[1] + ends[1][1] - ends[0][1]];
        self.transit(from);
        self.push(to, self.line_rate(piece, from, to), RunKind::Line);
        Ok(())
    }

    fn stop(&mut self, at_mm: [f64; 2]) -> Result<(), PlanError> {
        let to = self.enter(&Piece::Stop { at_mm })?;
        let (speed, acceleration, duration_s) = self.shortest(to);
        let from = std::mem::replace(&mut self.stand, to);
        let kind = RunKind::Stop;
        self.runs.push(AxisRun { from, to, speed, acceleration, duration_s, kind });
        Ok(())
    }

    /// Positions of the axes at the beginning of a piece, with whole turns of a table added.
    fn enter(&self, piece: &Piece) -> Result<[f64; 2], PlanError> {
        let machine = &self.limits.machine;
        let added = machine.enter(piece, self.stand[1])?;
        let mut at = machine.motion(piece, 0.0).at;
        at[1] += added;
        // On its axis a table need not turn.
        if machine.is_polar() && matches!(piece, Piece::Stop { .. }) && at[0] == 0.0 {
            at[1] = self.stand[1];
        }
        Ok(at)
    }

    fn is_straight(&self, piece: &Piece) -> bool {
        match (&self.limits.machine, piece) {
            (_, Piece::Stop { .. }) => true,
            (Machine::Cartesian { .. }, Piece::Line { .. }) => true,
            (Machine::Cartesian { .. }, _) => false,
            // Another line than one from the axis is stopped along.
            (Machine::Polar { .. }, piece) => {
                self.limits.machine.enter(piece, self.stand[1]).is_ok()
            }
        }
    }

    fn transit(&mut self, to: [f64; 2]) {
        let is_there = (0..2).all(|axis| (to[axis] - self.stand[axis]).abs() <= SAME);
        if is_there {
            return;
        }
        let (speed, acceleration, duration_s) = self.shortest(to);
        let from = std::mem::replace(&mut self.stand, to);
        let kind = RunKind::Transit;
        self.runs.push(AxisRun { from, to, speed, acceleration, duration_s, kind });
    }

    /// Each axis at its own limits.
    fn shortest(&self, to: [f64; 2]) -> ([f64; 2], [f64; 2], f64) {
        let axes = self.limits.machine.axes();
        let durations = [0, 1].map(|k| {
            let length = (to[k] - self.stand[k]).abs();
            Trapezoid::new(length, axes[k].speed, axes[k].acceleration).duration_s()
        });
        let duration_s = durations[0].max(durations[1]);
        (axes.map(|axis| axis.speed), axes.map(|axis| axis.acceleration), duration_s)
    }

    /// Largest share of a line per s, for the scan speed where the probe is fastest.
    fn line_rate(&self, piece: &Piece, from: [f64; 2], to: [f64; 2]) -> f64 {
        let [first, second] = [to[0] - from[0], to[1] - from[1]].map(f64::abs);
        let fastest_mm = match self.limits.machine {
            Machine::Cartesian { .. } => first.hypot(second),
            Machine::Polar { .. } => first.hypot(second * from[0].abs().max(to[0].abs())),
        };
        debug_assert!(fastest_mm > 0.0, "{piece:?}");
        self.limits.scan_speed_mm_s / fastest_mm
    }

    /// A run on which both axes keep their share: they stay on the line.
    fn push(&mut self, to: [f64; 2], most_rate: f64, kind: RunKind) {
        let from = std::mem::replace(&mut self.stand, to);
        let (mut rate, mut gain) = (most_rate, f64::INFINITY);
        let lengths = [0, 1].map(|k| (to[k] - from[k]).abs());
        for (axis, length) in self.limits.machine.axes().iter().zip(lengths) {
            if length > 0.0 {
                rate = rate.min(axis.speed / length);
                gain = gain.min(axis.acceleration / length);
            }
        }
        let duration_s = Trapezoid::new(1.0, rate, gain).duration_s();
        let axes = self.limits.machine.axes();
        // An axis that stands keeps limits that can be.
        let share =
            |k: usize, of: f64, limit: f64| if lengths[k] > 0.0 { of * lengths[k] } else { limit };
        self.runs.push(AxisRun {
            from,
            to,
            speed: [0, 1].map(|k| share(k, rate, axes[k].speed)),
            acceleration: [0, 1].map(|k| share(k, gain, axes[k].acceleration)),
            duration_s,
            kind,
        });
    }
}

/// Positions no farther apart are one.
const SAME: f64 = 1e-9;

#[cfg(test)]
mod tests {
    use std::f64::consts::TAU;

    use super::*;
    use crate::{Aperture, Axis, Path, Way, lay, schedule_each};

    fn limits(machine: Machine) -> Limits {
        Limits { machine, scan_speed_mm_s: 5.0, dwell_s: 0.0 }
    }

    fn cartesian() -> Machine {
        let axis = Axis { low: -20.0, high: 20.0, speed: 10.0, acceleration: 100.0 };
        Machine::Cartesian { x: axis, y: Axis { acceleration: 50.0, ..axis } }
    }

    fn polar() -> Machine {
        let r = Axis { low: -1.0, high: 20.0, speed: 10.0, acceleration: 100.0 };
        Machine::Polar { r, c: Axis::about_zero(f64::INFINITY, TAU, 10.0 * TAU) }
    }

    fn pieces(path: &Path, aperture: &Aperture) -> Vec<(Piece, Spacing)> {
        let pieces = lay(path, aperture, [0.0; 2]).unwrap();
        pieces.into_iter().map(|piece| (piece, Spacing::AtMost { mm: 1.0 })).collect()
    }

    /// Each run begins where the last one ended, and the time is that of the schedule, which counts in another way.
    #[test]
    fn a_raster_is_lines_and_transits_in_the_time_of_its_schedule() {
        let aperture = Aperture::Rectangle { width_mm: 10.0, height_mm: 4.0 };
        let pieces = pieces(&Path::Raster { pitch_mm: 1.0, one_way: true }, &aperture);
        let limits = limits(cartesian());
        let runs = axis_runs(&pieces, &limits, [1.0, 2.0]).unwrap();
        let kinds: Vec<RunKind> = runs.iter().map(|run| run.kind).collect();
        assert_eq!(kinds, [RunKind::Transit, RunKind::Line].repeat(5));
        assert!(runs.windows(2).all(|pair| pair[0].to == pair[1].from));
        assert_eq!((runs[1].from, runs[1].to), ([-5.0, -2.0], [5.0, -2.0]));
        assert_eq!(runs[1].speed[0], 5.0);
        let time_s: f64 = runs.iter().map(|run| run.duration_s).sum();
        let schedule = schedule_each(&pieces, &limits, Some([1.0, 2.0])).unwrap();
        assert!((time_s - schedule.total_s).abs() < 1e-9, "{time_s} {}", schedule.total_s);
    }

    /// Both axes of a slanted line have the same ramps and the same time: by the formula of a trapezoid.
    #[test]
    fn axes_of_a_slanted_line_begin_and_end_together() {
        let line = Piece::Line { from_mm: [0.0, 0.0], to_mm: [3.0, 4.0] };
        let runs =
            axis_runs(&[(line, Spacing::AtMost { mm: 1.0 })], &limits(cartesian()), [0.0; 2])
                .unwrap();
        let [run] = runs[..] else { panic!("{runs:?}") };
        assert!((run.speed[0] - 3.0).abs() < 1e-12 && (run.speed[1] - 4.0).abs() < 1e-12);
        // y has 50 mm/s² at 4 of 5 mm: 62.5 mm/s² along the line.
        assert!(
            (run.acceleration[0] - 37.5).abs() < 1e-9 && (run.acceleration[1] - 50.0).abs() < 1e-9
        );
        let times = [0, 1]
            .map(|k| Trapezoid::new([3.0, 4.0][k], run.speed[k], run.acceleration[k]).duration_s());
        assert!((times[0] - times[1]).abs() < 1e-12 && (times[0] - run.duration_s).abs() < 1e-12);
    }

    #[test]
    fn a_table_runs_spirals_and_circles_and_two_stages_stop_along_them() {
        let aperture = Aperture::Circle { radius_mm: 4.0 };
        let spiral = pieces(&Path::Spiral { pitch_mm: 1.0, way: Way::Out }, &aperture);
        let runs = axis_runs(&spiral, &limits(polar()), [0.0; 2]).unwrap();
        assert_eq!(runs.len(), 2, "the spiral, and the turn at the edge: {runs:?}");
        assert!((runs[0].to[0] - 4.0).abs() < 1e-9 && (runs[0].to[1] - 4.0 * TAU).abs() < 1e-9);
        assert!((runs[1].to[1] - 5.0 * TAU).abs() < 1e-9, "a whole turn");
        // 5 mm/s at the edge.
        assert!(runs[0].speed[0].hypot(4.0 * runs[0].speed[1]) <= 5.0 + 1e-9);
        assert!((4.0 * runs[1].speed[1] - 5.0).abs() < 1e-9);
        let stops = axis_runs(&spiral, &limits(cartesian()), [0.0; 2]).unwrap();
        assert!(stops.len() > 50 && stops.iter().all(|run| run.kind == RunKind::Stop));
        // A line beside the axis of a table becomes stops, too.
        let beside = Piece::Line { from_mm: [-2.0, 1.0], to_mm: [2.0, 1.0] };
        let runs = axis_runs(&[(beside, Spacing::AtMost { mm: 1.0 })], &limits(polar()), [0.0; 2])
            .unwrap();
        assert_eq!((runs.len(), runs[0].kind), (5, RunKind::Stop));
        assert!((runs[2].to[0] - 1.0).abs() < 1e-12);
    }

    #[test]
    fn a_piece_beyond_the_travel_is_refused_with_its_axis() {
        let line = Piece::Line { from_mm: [0.0, 0.0], to_mm: [0.0, 21.0] };
        let error =
            axis_runs(&[(line, Spacing::AtMost { mm: 1.0 })], &limits(cartesian()), [0.0; 2])
                .unwrap_err();
        assert_eq!(error.key, "y.travel");
        let stop = Piece::Stop { at_mm: [21.0, 0.0] };
        let error = axis_runs(&[(stop, Spacing::AtMost { mm: 1.0 })], &limits(polar()), [0.0; 2])
            .unwrap_err();
        assert_eq!(error.key, "r.travel");
    }
}
