//! How well places are known that were joined by time.

use asphera_clocks::ClockState;
use asphera_link::Flags;
use asphera_report::{ClockFigures, PlaceFigures};

use super::joiner::JoinSettings;
use super::kinematics::Point;

/// Holds the places of points against their limit, and sums up how well they are known.
#[derive(Debug)]
pub(super) struct Places {
    /// Largest standard uncertainty of a good point along an axis, mm; `None` where readings are joined by count.
    limit_mm: Option<f64>,
    good: u64,
    largest_mm: f64,
    squares_mm2: f64,
}

impl Places {
    pub(super) fn new(join: &JoinSettings) -> Places {
        let limit_mm = match join {
            JoinSettings::Count { .. } => None,
            JoinSettings::Time { u_limit_mm, .. } => Some(*u_limit_mm),
        };
        Places { limit_mm, good: 0, largest_mm: 0.0, squares_mm2: 0.0 }
    }

    /// Flags a point whose place is known less well than the limit.
    pub(super) fn judge(&mut self, point: &mut Point) {
        let Some(limit_mm) = self.limit_mm.filter(|_| point.is_good()) else { return };
        // What is no number is not known at all.
        if !point.u_mm.iter().all(|u_mm| *u_mm <= limit_mm) {
            point.flags |= Flags::UNCERTAIN_PLACE;
            return;
        }
        let u_mm = point.u_mm.into_iter().fold(0.0, f64::max);
        self.good += 1;
        self.largest_mm = self.largest_mm.max(u_mm);
        self.squares_mm2 += u_mm * u_mm;
    }

    pub(super) fn figures(&self) -> Option<PlaceFigures> {
        (self.limit_mm.is_some() && self.good > 0).then(|| PlaceFigures {
            largest_um: self.largest_mm * 1e3,
            rms_um: (self.squares_mm2 / self.good as f64).sqrt() * 1e3,
        })
    }
}

/// Figures of a device's clock as the report has them.
pub(super) fn clock_figures(state: ClockState) -> ClockFigures {
    let us = |seconds: Option<f64>| seconds.map(|seconds| seconds * 1e6);
    ClockFigures {
        offset_s: state.offset_s,
        drift_ppm: state.drift_ppm,
        u_drift_ppm: state.u_drift_ppm,
        u_us: us(state.u_s),
        jitter_us: us(state.jitter_s),
        wraps: state.wraps,
        jumps: state.jumps,
        repeated: state.repeated,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use asphera_clocks::TimeSettings;
    use asphera_link::Nanos;
    use std::time::Duration;

    #[test]
    fn what_is_known_less_well_than_the_limit_is_no_good_point() {
        let second = Duration::from_secs(1);
        let (devices, coordinates) = (Vec::new(), Vec::new());
        let settings =
            TimeSettings { wait: second, capacity: 1, gap: second, devices, coordinates };
        let mut places = Places::new(&JoinSettings::Time { settings, u_limit_mm: 0.01 });
        let mut is_good = |u_mm: [f64; 3]| {
            let (count, host, flags) = (None, Nanos::ZERO, Flags::empty());
            let mut point = Point { count, host, position_mm: [0.0; 3], flags, u_mm };
            places.judge(&mut point);
            point.is_good()
        };
        assert!(is_good([0.003, 0.0, 0.001]) && is_good([0.0, 0.01, 0.0]));
        assert!(!is_good([0.0, 0.0, 0.011]) && !is_good([f64::INFINITY, 0.0, 0.0]));
        assert!(!is_good([f64::NAN, 0.0, 0.0]));
        let figures = places.figures().unwrap();
        assert_eq!(figures.largest_um, 10.0);
        assert!((figures.rms_um - (54.5_f64).sqrt()).abs() < 1e-9);
    }
}
