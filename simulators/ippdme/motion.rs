//! Paths of the probe in time.

/// Place of the centre of the ball in mm.
pub(crate) type Place = [f64; 3];

/// Path under way: straight pieces at constant speed, and a stop where it ends. Times in s.
#[derive(Clone, Debug)]
pub(crate) struct Path {
    /// Times that grow, with the place at each.
    knots: Vec<(f64, Place)>,
}

impl Path {
    /// A path that begins here and now.
    pub(crate) fn new(now_s: f64, place: Place) -> Path {
        Path { knots: vec![(now_s, place)] }
    }

    /// Goes on in a straight line. Gives the time of arrival.
    pub(crate) fn go(&mut self, to: Place, speed_mm_s: f64) -> f64 {
        let (from_s, from) = self.end();
        let until_s = from_s + distance(from, to) / speed_mm_s;
        self.knots.push((until_s, to));
        until_s
    }

    /// Time and place of the end.
    pub(crate) fn end(&self) -> (f64, Place) {
        // Invariant: never empty.
        self.knots.last().copied().unwrap_or_default()
    }

    /// Place at a time.
    pub(crate) fn at(&self, now_s: f64) -> Place {
        let after = self.knots.partition_point(|(at_s, _)| *at_s <= now_s);
        match (after.checked_sub(1).map(|before| self.knots[before]), self.knots.get(after)) {
            (Some((begin_s, from)), Some((end_s, to))) => {
                let part = (now_s - begin_s) / (end_s - begin_s);
                [0, 1, 2].map(|k| from[k] + part * (to[k] - from[k]))
            }
            (Some((_, place)), None) | (None, Some(&(_, place))) => place,
            (None, None) => Place::default(),
        }
    }
}

pub(crate) fn distance(a: Place, b: Place) -> f64 {
    (0..3).map(|k| (a[k] - b[k]).powi(2)).sum::<f64>().sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_path_has_the_length_of_its_pieces() {
        let mut path = Path::new(1.0, [0.0; 3]);
        assert_eq!(path.go([3.0, 4.0, 0.0], 5.0), 2.0);
        assert_eq!(path.go([3.0, 4.0, 0.0], 5.0), 2.0, "no way, no time");
        assert_eq!(path.go([3.0, 4.0, 2.0], 1.0), 4.0);
        assert_eq!(path.at(0.0), [0.0; 3]);
        assert_eq!(path.at(1.5), [1.5, 2.0, 0.0]);
        assert_eq!(path.at(3.0), [3.0, 4.0, 1.0]);
        assert_eq!(path.at(9.0), [3.0, 4.0, 2.0]);
    }
}
