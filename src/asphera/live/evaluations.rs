//! When a full evaluation of the mesh may hold points up.

/// Decides whether the pipeline may evaluate the whole mesh now.
///
/// An evaluation takes time in proportion to the points, and points that arrive meanwhile wait. It is put off while more than
/// [`WAITING_POINTS`] would wait, unless it takes less than a hundredth of the time since the one before.
#[derive(Default)]
pub(super) struct Evaluations {
    last: Option<Evaluation>,
}

/// An evaluation that was made.
struct Evaluation {
    /// When it ended, s.
    at_s: f64,
    /// How long it took, s.
    took_s: f64,
    /// The points then.
    points: u64,
}

impl Evaluations {
    /// Whether one of `points` may begin at `now_s`, while `rate_hz` points a second arrive and `waiting` wait already.
    pub(super) fn may_begin(&self, now_s: f64, points: u64, rate_hz: f64, waiting: u64) -> bool {
        if waiting > WAITING_POINTS {
            return false;
        }
        let Some(last) = &self.last else { return true };
        let takes_s = last.took_s * points as f64 / last.points.max(1) as f64;
        takes_s * rate_hz <= WAITING_POINTS as f64 || now_s - last.at_s >= SHARE * takes_s
    }

    /// One of `points` began and ended, times in s.
    pub(super) fn took(&mut self, began_s: f64, ended_s: f64, points: u64) {
        self.last = Some(Evaluation { at_s: ended_s, took_s: ended_s - began_s, points });
    }
}

/// A tenth of a second of 1,000,000 points a second.
const WAITING_POINTS: u64 = 100_000;
/// Times longer than an evaluation that the time since the last one must be.
const SHARE: f64 = 100.0;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_fast_scan_is_not_held_up_and_a_slow_one_is_evaluated() {
        let mut evaluations = Evaluations::default();
        assert!(evaluations.may_begin(0.0, 2000, 1e6, 0), "nothing is known of the first");
        assert!(!evaluations.may_begin(0.0, 2000, 0.0, 100_001), "enough wait already");
        // 1 µs a point: 100,000 points take 0.1 s.
        evaluations.took(1.0, 1.1, 100_000);
        assert!(evaluations.may_begin(1.2, 125_000, 500_000.0, 0), "62,500 would wait");
        assert!(!evaluations.may_begin(1.2, 400_000, 500_000.0, 0), "200,000 would wait");
        assert!(evaluations.may_begin(1.2, 400_000, 100_000.0, 0), "40,000 would wait");
        assert!(evaluations.may_begin(1.2, 400_000, 0.0, 0), "no point comes");
        // It takes 1 s; the last one was made less than 100 s ago, then more.
        assert!(!evaluations.may_begin(101.0, 1_000_000, 500_000.0, 0));
        assert!(evaluations.may_begin(101.2, 1_000_000, 500_000.0, 0));
    }
}
