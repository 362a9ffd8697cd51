//! Place of the axis over time, in counts.

/// Run of the axis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Profile {
    /// It stands.
    Still(f64),
    /// It runs from rest to a place: a trapezoid of speed.
    Run { begin_s: f64, from: f64, to: f64, speed: f64, acceleration: f64 },
    /// It brakes.
    Brake { begin_s: f64, from: f64, speed: f64, deceleration: f64 },
}

impl Profile {
    /// Place and speed at a time.
    pub(crate) fn state(&self, now_s: f64) -> (f64, f64) {
        match *self {
            Profile::Still(at) => (at, 0.0),
            Profile::Brake { begin_s, from, speed, deceleration } => {
                let t = (now_s - begin_s).clamp(0.0, speed.abs() / deceleration);
                let direction = speed.signum();
                let way = speed.abs() * t - deceleration * t * t / 2.0;
                (from + direction * way, speed - direction * deceleration * t)
            }
            Profile::Run { begin_s, from, to, speed, acceleration } => {
                let (way, direction) = ((to - from).abs(), (to - from).signum());
                let top = speed.min((way * acceleration).sqrt());
                let ramp_s = top / acceleration;
                let flat_s = (way - top * ramp_s) / top.max(f64::MIN_POSITIVE);
                let t = now_s - begin_s;
                let (done, velocity) = if t <= 0.0 {
                    (0.0, 0.0)
                } else if t < ramp_s {
                    (acceleration * t * t / 2.0, acceleration * t)
                } else if t < ramp_s + flat_s {
                    (top * (t - ramp_s / 2.0), top)
                } else if t < 2.0 * ramp_s + flat_s {
                    let left = 2.0 * ramp_s + flat_s - t;
                    (way - acceleration * left * left / 2.0, acceleration * left)
                } else {
                    (way, 0.0)
                };
                (from + direction * done, direction * velocity)
            }
        }
    }

    /// When it stands; `None`: it does.
    pub(crate) fn end_s(&self) -> Option<f64> {
        match *self {
            Profile::Still(_) => None,
            Profile::Brake { begin_s, speed, deceleration, .. } => {
                Some(begin_s + speed.abs() / deceleration)
            }
            Profile::Run { begin_s, from, to, speed, acceleration } => {
                let way = (to - from).abs();
                let top = speed.min((way * acceleration).sqrt());
                let flat_s = (way - top * top / acceleration) / top.max(f64::MIN_POSITIVE);
                Some(begin_s + 2.0 * top / acceleration + if way > 0.0 { flat_s } else { 0.0 })
            }
        }
    }

    /// The same, standing where its time is over.
    pub(crate) fn settled(self, now_s: f64) -> Profile {
        match self.end_s() {
            Some(end_s) if end_s <= now_s => Profile::Still(self.state(end_s + 1.0).0),
            _ => self,
        }
    }

    pub(crate) fn is_still(&self) -> bool {
        matches!(self, Profile::Still(_))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_run_is_a_trapezoid_and_a_brake_is_its_end() {
        // 1 s up to 100/s, 1 s on, 1 s down.
        let run = Profile::Run {
            begin_s: 10.0,
            from: 50.0,
            to: 250.0,
            speed: 100.0,
            acceleration: 100.0,
        };
        assert_eq!(run.end_s(), Some(13.0));
        for (t, place, speed) in [
            (9.0, 50.0, 0.0),
            (11.0, 100.0, 100.0),
            (11.5, 150.0, 100.0),
            (12.5, 237.5, 50.0),
            (14.0, 250.0, 0.0),
        ] {
            assert_eq!(run.state(t), (place, speed), "{t} s");
        }
        let brake = Profile::Brake { begin_s: 0.0, from: 0.0, speed: -100.0, deceleration: 50.0 };
        assert_eq!((brake.end_s(), brake.state(5.0)), (Some(2.0), (-100.0, 0.0)));
        assert_eq!(run.settled(13.0), Profile::Still(250.0));
        let nowhere =
            Profile::Run { begin_s: 0.0, from: 1.0, to: 1.0, speed: 1.0, acceleration: 1.0 };
        assert_eq!(nowhere.settled(0.0), Profile::Still(1.0));
    }
}
