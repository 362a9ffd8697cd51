//! Boxes with sides along the axes.

/// A box in the plane, or in D dimensions, with sides along the axes, in mm; its boundary belongs to it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BoundsMm<const D: usize = 2> {
    /// The smallest coordinates.
    pub low: [f64; D],
    /// The largest coordinates.
    pub high: [f64; D],
}

/// A box in space.
pub type BoxMm = BoundsMm<3>;

impl<const D: usize> BoundsMm<D> {
    /// The box of no places, from +∞ to −∞: what is joined to it stays as it is.
    pub const EMPTY: BoundsMm<D> =
        BoundsMm { low: [f64::INFINITY; D], high: [f64::NEG_INFINITY; D] };

    /// The smallest box about places; [`EMPTY`](BoundsMm::EMPTY) without any. NaN widens no box.
    #[inline(always)]
    pub fn about(places: impl IntoIterator<Item = [f64; D]>) -> BoundsMm<D> {
        let mut bounds = BoundsMm::EMPTY;
        for place in places {
            bounds.add(place);
        }
        bounds
    }

    /// Widens the box to a place.
    #[inline(always)]
    pub fn add(&mut self, place: [f64; D]) {
        // One instruction each, where `f64::min` takes four. NaN is never below or above.
        for (axis, value) in place.into_iter().enumerate() {
            let (low, high) = (self.low[axis], self.high[axis]);
            self.low[axis] = if value < low { value } else { low };
            self.high[axis] = if value > high { value } else { high };
        }
    }

    /// Widens the box to another.
    #[inline(always)]
    pub fn join(&mut self, other: &BoundsMm<D>) {
        for axis in 0..D {
            self.low[axis] = self.low[axis].min(other.low[axis]);
            self.high[axis] = self.high[axis].max(other.high[axis]);
        }
    }

    /// Its sides in mm; −∞ where it is empty.
    #[inline]
    pub fn size_mm(&self) -> [f64; D] {
        std::array::from_fn(|axis| self.high[axis] - self.low[axis])
    }

    /// Its lowest and highest corner; `None` where it is empty along an axis.
    pub fn corners(&self) -> Option<[[f64; D]; 2]> {
        let is_some = (0..D).all(|axis| self.low[axis] <= self.high[axis]);
        is_some.then_some([self.low, self.high])
    }

    /// The place of the box that is nearest to a place.
    #[inline]
    pub fn nearest(&self, place: [f64; D]) -> [f64; D] {
        std::array::from_fn(|axis| place[axis].max(self.low[axis]).min(self.high[axis]))
    }
}

impl<const D: usize> Default for BoundsMm<D> {
    /// The box of no places.
    fn default() -> BoundsMm<D> {
        BoundsMm::EMPTY
    }
}

impl BoxMm {
    /// Square of the distance from a place to the nearest place of the box in mm², but for rounding.
    pub fn squared_distance_mm2(&self, place: [f64; 3]) -> f64 {
        let [x, y, z] = std::array::from_fn(|axis| {
            (self.low[axis] - place[axis]).max(place[axis] - self.high[axis]).max(0.0)
        });
        x * x + y * y + z * z
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;
    use crate::regressions::beside_source;

    #[test]
    fn no_place_has_no_box_and_one_has_itself() {
        assert_eq!(BoundsMm::<2>::about([]).corners(), None);
        assert_eq!(BoundsMm::about([[f64::NAN, 1.0]]).corners(), None);
        let one = BoundsMm::about([[3.0, -4.0]]);
        assert_eq!(one.corners(), Some([[3.0, -4.0]; 2]));
        assert_eq!(one.size_mm(), [0.0; 2]);
        assert_eq!(BoundsMm::<2>::EMPTY.size_mm(), [f64::NEG_INFINITY; 2]);
    }

    proptest! {
        #![proptest_config(beside_source())]

        #[test]
        fn it_holds_all_its_places_and_each_side_touches_one(
            places in prop::collection::vec(prop::array::uniform3(-1e3..1e3), 1..30),
            split in 0_usize..30,
        ) {
            let bounds = BoundsMm::about(places.iter().copied());
            for axis in 0..3 {
                let along = || places.iter().map(|place| place[axis]);
                prop_assert!(along().all(|at| (bounds.low[axis]..=bounds.high[axis]).contains(&at)));
                prop_assert!(along().any(|at| at == bounds.low[axis]));
                prop_assert!(along().any(|at| at == bounds.high[axis]));
            }
            prop_assert!(places.iter().all(|&place| bounds.nearest(place) == place));
            let (first, second) = places.split_at(split.min(places.len()));
            let mut joined = BoundsMm::about(first.iter().copied());
            joined.join(&BoundsMm::about(second.iter().copied()));
            prop_assert_eq!(joined, bounds);
        }
    }
}
