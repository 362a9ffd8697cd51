//! The quickest run of a length from rest to rest under limits of speed and acceleration.

/// A run from rest to rest: a ramp up, constant speed, and a ramp down. A short run reaches no constant speed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Trapezoid {
    length: f64,
    /// Speed between the ramps.
    speed: f64,
    acceleration: f64,
}

impl Trapezoid {
    /// The run of a length with limits above 0, all of one unit: mm or rad, and seconds.
    pub fn new(length: f64, speed: f64, acceleration: f64) -> Trapezoid {
        let speed = speed.min((length * acceleration).sqrt());
        Trapezoid { length, speed, acceleration }
    }

    /// How long it takes in s.
    pub fn duration_s(&self) -> f64 {
        if self.length <= 0.0 {
            return 0.0;
        }
        self.length / self.speed + self.speed / self.acceleration
    }

    /// When a part of the length is behind, in s.
    pub fn time_at_s(&self, way: f64) -> f64 {
        if self.length <= 0.0 {
            return 0.0;
        }
        let way = way.clamp(0.0, self.length);
        let ramp = 0.5 * self.speed * self.speed / self.acceleration;
        if way <= ramp {
            return (2.0 * way / self.acceleration).sqrt();
        }
        if way <= self.length - ramp {
            return 0.5 * self.speed / self.acceleration + way / self.speed;
        }
        self.duration_s() - (2.0 * (self.length - way) / self.acceleration).sqrt()
    }

    /// The length that is run at a speed, without the ramps to it.
    pub fn length_at(&self, speed: f64) -> f64 {
        if self.speed < speed * (1.0 - 1e-9) {
            return 0.0;
        }
        (self.length - self.speed * self.speed / self.acceleration).max(0.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn runs_take_the_time_of_their_formulas() {
        // 10 mm at 5 mm/s with 100 mm/s²: ramps of 0.05 s, 0.125 mm each.
        let long = Trapezoid::new(10.0, 5.0, 100.0);
        assert!((long.duration_s() - 2.05).abs() < 1e-12);
        assert!((long.time_at_s(0.125) - 0.05).abs() < 1e-12);
        assert!((long.time_at_s(5.0) - 1.025).abs() < 1e-12);
        assert!((long.time_at_s(9.875) - 2.0).abs() < 1e-12);
        assert!((long.length_at(5.0) - 9.75).abs() < 1e-12);
        // 0.04 mm: half of it in √(2·0.02/100) s, at 2 mm/s at most.
        let short = Trapezoid::new(0.04, 5.0, 100.0);
        assert!((short.duration_s() - 0.04).abs() < 1e-12);
        assert!((short.time_at_s(0.02) - 0.02).abs() < 1e-12);
        assert_eq!(
            (short.length_at(5.0), Trapezoid::new(0.0, 5.0, 100.0).duration_s()),
            (0.0, 0.0)
        );
    }
}
