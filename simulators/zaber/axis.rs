//! An axis: runs from rest to rest, and stops on the way.

/// Axis of a stage.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AxisSettings {
    /// Worth of a microstep in µm.
    pub microstep_um: f64,
    /// Travel from 0, mm.
    pub travel_mm: f64,
    /// Where it stands at first, mm.
    pub at_mm: f64,
}

/// An axis at work; positions in microsteps, times in s.
#[derive(Clone, Debug)]
pub(crate) struct Axis {
    pub(crate) settings: AxisSettings,
    /// Data of the setting `maxspeed`.
    pub(crate) maxspeed: i64,
    /// Data of the setting `accel`.
    pub(crate) accel: i64,
    run: Run,
}

#[derive(Clone, Copy, Debug)]
enum Run {
    Still {
        at: f64,
    },
    /// A trapezoid.
    To {
        begin_s: f64,
        from: f64,
        to: f64,
        speed: f64,
        acceleration: f64,
    },
    /// It slows down to rest.
    Slowing {
        begin_s: f64,
        from: f64,
        speed: f64,
        acceleration: f64,
    },
}

impl Axis {
    pub(crate) fn new(settings: AxisSettings) -> Axis {
        let at = (settings.at_mm * 1000.0 / settings.microstep_um).round();
        Axis { settings, maxspeed: 153_600, accel: 205, run: Run::Still { at } }
    }

    /// Largest position in microsteps.
    pub(crate) fn longest(&self) -> i64 {
        (self.settings.travel_mm * 1000.0 / self.settings.microstep_um).round() as i64
    }

    /// Position and speed, in microsteps and per s.
    pub(crate) fn state(&self, now_s: f64) -> (f64, f64) {
        match self.run {
            Run::Still { at } => (at, 0.0),
            Run::To { begin_s, from, to, speed, acceleration } => {
                let (length, sign) = ((to - from).abs(), (to - from).signum());
                let peak = speed.min((length * acceleration).sqrt());
                let ramp_s = peak / acceleration;
                let even_s = (length - peak * ramp_s).max(0.0) / peak;
                let t_s = (now_s - begin_s).clamp(0.0, 2.0 * ramp_s + even_s);
                let left_s = 2.0 * ramp_s + even_s - t_s;
                let (way, rate) = if t_s <= ramp_s {
                    (0.5 * acceleration * t_s * t_s, acceleration * t_s)
                } else if left_s >= ramp_s {
                    (0.5 * peak * ramp_s + peak * (t_s - ramp_s), peak)
                } else {
                    (length - 0.5 * acceleration * left_s * left_s, acceleration * left_s)
                };
                if left_s <= 0.0 { (to, 0.0) } else { (from + sign * way, sign * rate) }
            }
            Run::Slowing { begin_s, from, speed, acceleration } => {
                let ramp_s = speed.abs() / acceleration;
                let t_s = (now_s - begin_s).clamp(0.0, ramp_s);
                let slowed = acceleration * t_s;
                (
                    from + speed.signum() * (speed.abs() - 0.5 * slowed) * t_s,
                    speed - speed.signum() * slowed,
                )
            }
        }
    }

    pub(crate) fn is_busy(&self, now_s: f64) -> bool {
        match self.run {
            Run::Still { .. } => false,
            Run::To { to, .. } => self.state(now_s).0 != to,
            Run::Slowing { .. } => self.state(now_s).1.abs() > 0.0,
        }
    }

    /// Position as it is shown: a whole number of microsteps.
    pub(crate) fn shown(&self, now_s: f64) -> i64 {
        self.state(now_s).0.round() as i64
    }

    /// Runs to a position, from rest.
    pub(crate) fn go(&mut self, now_s: f64, to: f64) {
        let (from, _) = self.state(now_s);
        let speed = self.maxspeed as f64 / 1.6384;
        let acceleration = self.accel as f64 * 10_000.0 / 1.6384;
        self.run = if from == to {
            Run::Still { at: to }
        } else {
            Run::To { begin_s: now_s, from, to, speed, acceleration }
        };
    }

    /// Slows down to rest.
    pub(crate) fn stop(&mut self, now_s: f64) {
        let (from, speed) = self.state(now_s);
        let acceleration = self.accel as f64 * 10_000.0 / 1.6384;
        self.run = match speed == 0.0 {
            true => Run::Still { at: from },
            false => Run::Slowing { begin_s: now_s, from, speed, acceleration },
        };
    }

    /// Stands at once: something blocks it.
    pub(crate) fn block(&mut self, now_s: f64) {
        self.run = Run::Still { at: self.state(now_s).0 };
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn axis() -> Axis {
        let settings = AxisSettings { microstep_um: 1.0, travel_mm: 100.0, at_mm: 0.0 };
        // 10,000 microsteps/s and 100,000 microsteps/s².
        Axis { maxspeed: 16_384, ..Axis::new(settings) }
    }

    /// 10 mm at 10 mm/s: the ramps by the data of `accel`, by hand.
    #[test]
    fn a_run_is_a_trapezoid() {
        let mut axis = axis();
        axis.accel = 16;
        let acceleration = 160_000.0 / 1.6384;
        axis.go(1.0, 10_000.0);
        let ramp_s = 10_000.0 / acceleration;
        assert_eq!(axis.state(1.0), (0.0, 0.0));
        let (at, speed) = axis.state(1.0 + ramp_s);
        assert!((at - 0.5 * 10_000.0 * ramp_s).abs() < 1e-6 && (speed - 10_000.0).abs() < 1e-6);
        let (at, _) = axis.state(1.5);
        assert!((at - (5000.0 - 0.5 * 10_000.0 * ramp_s)).abs() < 1e-6);
        let whole_s = 1.0 + ramp_s;
        assert!(axis.is_busy(1.0 + whole_s - 1e-6) && !axis.is_busy(1.0 + whole_s + 1e-6));
        assert_eq!(axis.shown(5.0), 10_000);
    }

    #[test]
    fn a_stop_takes_the_way_of_its_speed() {
        let mut axis = axis();
        axis.accel = 16;
        let acceleration = 160_000.0 / 1.6384;
        axis.go(0.0, 90_000.0);
        let (from, speed) = axis.state(2.0);
        axis.stop(2.0);
        assert!(axis.is_busy(2.01));
        let (at, left) = axis.state(3.0);
        assert!((at - from - 0.5 * speed * speed / acceleration).abs() < 1e-6, "{at} {from}");
        assert_eq!((left, axis.is_busy(3.0)), (0.0, false));
    }

    #[test]
    fn a_short_run_reaches_no_constant_speed() {
        let mut axis = axis();
        axis.go(0.0, -10.0);
        let acceleration = axis.accel as f64 * 10_000.0 / 1.6384;
        let half_s = (10.0 / acceleration).sqrt();
        assert!((axis.state(half_s).0 + 5.0).abs() < 1e-6);
        assert_eq!(axis.state(2.0 * half_s + 1e-9).0, -10.0);
    }
}
