//! Many points of one reading.

/// Profile of a line scanner: its points from one end of the laser line to the other, each valid or missing.
///
/// A point is `[x, z]` in mm in the scanner's own plane: x along the line, z as the scanner gives distances.
/// Missing is a gap, never a zero.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Profile {
    points_mm: Box<[Option<[f64; 2]>]>,
    valid: usize,
}

impl Profile {
    /// The points in the order of the line.
    pub fn points_mm(&self) -> &[Option<[f64; 2]>] {
        &self.points_mm
    }

    /// How many points have a value.
    pub fn valid(&self) -> usize {
        self.valid
    }
}

impl FromIterator<Option<[f64; 2]>> for Profile {
    /// A point with a coordinate that is not finite is missing.
    fn from_iter<I: IntoIterator<Item = Option<[f64; 2]>>>(points: I) -> Profile {
        let is_finite = |point: &[f64; 2]| point.iter().all(|value| value.is_finite());
        let points = points.into_iter().map(|point| point.filter(is_finite));
        let points_mm: Box<[Option<[f64; 2]>]> = points.collect();
        let valid = points_mm.iter().flatten().count();
        Profile { points_mm, valid }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn missing_points_keep_their_place() {
        let points = [Some([1.0, 2.0]), None, Some([f64::NAN, 1.0]), Some([0.0, 0.0])];
        let profile: Profile = points.into_iter().collect();
        assert_eq!(profile.points_mm(), [Some([1.0, 2.0]), None, None, Some([0.0, 0.0])]);
        assert_eq!(profile.valid(), 2);
    }
}
