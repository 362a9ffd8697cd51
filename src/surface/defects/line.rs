//! The line of a step: on which side of it a place lies.

/// A line by its offsets from a straight one.
#[derive(Clone, Debug)]
pub(super) struct Line {
    pub(super) origin_mm: [f64; 2],
    /// Unit vector along the straight line.
    pub(super) along: [f64; 2],
    /// Ways along it and offsets to its left in mm, ascending by the way. Not empty.
    pub(super) knots_mm: Vec<[f64; 2]>,
    /// How far from it the level has risen by 0.76 of the way to either side, in mm; 0 where it jumps.
    pub(super) soft_mm: f64,
}

impl Line {
    /// The place at a way along the straight line and an offset to its left.
    pub(super) fn place_mm(&self, [way, offset]: [f64; 2]) -> [f64; 2] {
        let [x, y] = self.along;
        [self.origin_mm[0] + way * x - offset * y, self.origin_mm[1] + way * y + offset * x]
    }

    /// One half to the left of the line, minus one half to the right, and between them where it is soft. Beyond its ends it
    /// goes on straight.
    pub(super) fn side(&self, place_mm: [f64; 2]) -> f64 {
        side(self.away_mm(place_mm), self.soft_mm)
    }

    /// How far to the left of the line a place is, square to the straight one, in mm.
    pub(super) fn away_mm(&self, place_mm: [f64; 2]) -> f64 {
        let [way, offset] = local_mm(self.origin_mm, self.along, place_mm);
        offset - self.offset_mm(way)
    }

    fn offset_mm(&self, way: f64) -> f64 {
        let after = self.knots_mm.partition_point(|knot| knot[0] <= way);
        let last = self.knots_mm.len() - 1;
        if after == 0 {
            return self.knots_mm[0][1];
        }
        if after > last {
            return self.knots_mm[last][1];
        }
        let [from, to] = [self.knots_mm[after - 1], self.knots_mm[after]];
        from[1] + (to[1] - from[1]) * (way - from[0]) / (to[0] - from[0])
    }

    /// Whether the line comes into a square of a centre and half a side.
    pub(super) fn crosses(&self, centre_mm: [f64; 2], half_mm: f64) -> bool {
        let places = self.knots_mm.iter().map(|&knot| self.place_mm(knot));
        let inside =
            |place: [f64; 2]| (0..2).all(|axis| (place[axis] - centre_mm[axis]).abs() <= half_mm);
        let ends: Vec<[f64; 2]> = places.collect();
        ends.iter().any(|&end| inside(end))
            || ends.windows(2).any(|pair| {
                (1..8).any(|part| {
                    let share = f64::from(part) / 8.0;
                    inside(
                        [0, 1].map(|axis| pair[0][axis] + share * (pair[1][axis] - pair[0][axis])),
                    )
                })
            })
    }
}

/// Height of a step between its levels, from -1/2 to 1/2, at an offset from it.
pub(super) fn side(offset_mm: f64, soft_mm: f64) -> f64 {
    if soft_mm > 0.0 {
        0.5 * (offset_mm / soft_mm).tanh()
    } else if offset_mm >= 0.0 {
        0.5
    } else {
        -0.5
    }
}

/// Way along a straight line and offset to its left.
pub(super) fn local_mm(origin_mm: [f64; 2], along: [f64; 2], place_mm: [f64; 2]) -> [f64; 2] {
    let [x, y] = [place_mm[0] - origin_mm[0], place_mm[1] - origin_mm[1]];
    [x * along[0] + y * along[1], y * along[0] - x * along[1]]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sides_of_a_bent_line() {
        let line = Line {
            origin_mm: [1.0, 0.0],
            along: [0.0, 1.0],
            knots_mm: vec![[0.0, 0.0], [1.0, 0.5], [2.0, 0.5]],
            soft_mm: 0.0,
        };
        // To the left of +y is -x.
        assert_eq!(line.side([0.9, 0.0]), 0.5);
        assert_eq!(line.side([1.1, 0.0]), -0.5);
        assert_eq!(line.side([0.7, 0.5]), 0.5);
        assert_eq!(line.side([0.8, 0.5]), -0.5);
        assert_eq!(line.side([0.4, 9.0]), 0.5);
        assert_eq!(line.side([0.6, 9.0]), -0.5);
        assert_eq!(line.place_mm([1.0, 0.5]), [0.5, 1.0]);
        assert!(line.crosses([0.75, 0.5], 0.1) && !line.crosses([1.25, 0.5], 0.1));
    }
}
