//! A circle in the plane: what lies inside, decided exactly, and where it crosses an edge.
//!
//! As in [`crate::exact`], a comparison is first made in doubles with a bound of its rounding
//! error, and only if that does not decide it in whole numbers. No square or product underflows: a
//! difference of two admitted coordinates is zero or at least 2⁻¹⁸⁵ in size, and so is the radius.

use std::cmp::Ordering;

use asphera_geometry::predicates::Limbs;
use asphera_geometry::predicates::Place;
use asphera_geometry::{RANGE_MM, TINY_MM};

use super::SectionError;

/// A disc with the circle around it.
pub(super) struct Disc {
    pub(super) centre: Place,
    pub(super) radius_mm: f64,
}

impl Disc {
    pub(super) fn new(centre: Place, radius_mm: f64) -> Result<Disc, SectionError> {
        if (TINY_MM..=RANGE_MM).contains(&radius_mm) {
            Ok(Disc { centre, radius_mm })
        } else {
            Err(SectionError::Radius { radius_mm })
        }
    }

    /// Where an admitted place lies: `Less` is inside, `Greater` outside, `Equal` on the circle.
    pub(super) fn side(&self, place: Place) -> Ordering {
        let [x, y] = [place[0] - self.centre[0], place[1] - self.centre[1]];
        let (squared, radius_squared) = (x * x + y * y, self.radius_mm * self.radius_mm);
        let difference = squared - radius_squared;
        if difference.abs() > BOUND * (squared + radius_squared) {
            return difference.total_cmp(&0.0);
        }
        let [x, y] = whole_difference(place, self.centre);
        x.times::<8>(x).plus(y.times(y)).minus(self.radius().times(self.radius())).sign()
    }

    /// Whether the line through two different admitted places passes through the inside.
    pub(super) fn meets_line(&self, a: Place, b: Place) -> bool {
        let [dx, dy] = [b[0] - a[0], b[1] - a[1]];
        let [cx, cy] = [self.centre[0] - a[0], self.centre[1] - a[1]];
        let (left, right) = (dx * cy, dy * cx);
        let (distance, reach) = ((left - right).abs(), self.radius_mm * dx.hypot(dy));
        let difference = reach - distance;
        if difference.abs() > BOUND * (left.abs() + right.abs() + reach) {
            return difference > 0.0;
        }
        let ([dx, dy], [cx, cy]) = (whole_difference(b, a), whole_difference(self.centre, a));
        let twice_area = dx.times::<8>(cy).minus(dy.times(cx));
        let (radius, length) = (self.radius().times::<8>(self.radius()), dx.times::<8>(dx));
        let reach = radius.times::<16>(length.plus(dy.times(dy)));
        reach.minus(twice_area.times(twice_area)).sign().is_gt()
    }

    /// How far from `a` to `b` the circle crosses the line between them: the first crossing, or the
    /// second. Kept between 0 and 1.
    pub(super) fn share(&self, a: Place, b: Place, second: bool) -> f64 {
        // Scaled by the radius and the edge, so that nothing overflows or vanishes.
        let [dx, dy] = [b[0] - a[0], b[1] - a[1]];
        let length = dx.hypot(dy);
        let (ux, uy) = (dx / length, dy / length);
        let [fx, fy] = [a[0] - self.centre[0], a[1] - self.centre[1]];
        let away = fx.hypot(fy);
        // t² + 2·half·t + product = 0 for the distance t from `a`; the smaller root in size is
        // taken from the product, which loses no digits.
        let half = ux * fx + uy * fy;
        let across = (ux * fy - uy * fx).abs();
        let product = (away - self.radius_mm) * (away + self.radius_mm);
        let root = ((self.radius_mm - across).max(0.0) * (self.radius_mm + across)).sqrt();
        let larger = if half > 0.0 { -half - root } else { -half + root };
        let smaller = if larger == 0.0 { 0.0 } else { product / larger };
        // The larger in size comes second where it lies ahead.
        let t = if second == (larger > smaller) { larger } else { smaller };
        let share = t / length;
        if share.is_finite() { share.clamp(0.0, 1.0) } else { 0.5 }
    }

    fn radius(&self) -> Limbs<4> {
        Limbs::from_double(self.radius_mm, UNIT)
    }
}

/// `to - from` in units of 2⁻¹⁸⁵ mm: below 2²²⁶ in size. So products of two, and sums of two such,
/// stay below 2⁴⁵³, and products of two of these below 2⁹⁰⁶.
fn whole_difference(to: Place, from: Place) -> [Limbs<4>; 2] {
    [0, 1].map(|axis| {
        let [to, from] = [to, from].map(|place| Limbs::from_double(place[axis], UNIT));
        to.minus(from)
    })
}

/// Admitted coordinates are zero or above 2⁻¹³³, hence multiples of 2⁻¹⁸⁵, and below 2⁴⁰.
const UNIT: i32 = -185;

/// Each difference, product, sum and root is rounded by at most an ulp or so: what is compared is
/// off by less than six halves of an ulp of the sum of sizes, and the bound is more.
const BOUND: f64 = 8.0 * f64::EPSILON;

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;
    use crate::regressions::beside_source;

    #[test]
    fn tells_what_doubles_cannot() {
        let disc = Disc::new([0.0, 0.0], 5.0).unwrap();
        assert_eq!(disc.side([3.0, 4.0]), Ordering::Equal);
        assert_eq!(disc.side([3.0, 4.0_f64.next_up()]), Ordering::Greater);
        assert_eq!(disc.side([3.0, 4.0_f64.next_down()]), Ordering::Less);
        assert_eq!(disc.side([5.0, 1e-40]), Ordering::Greater);
        assert!(!disc.meets_line([-1.0, 5.0], [1.0, 5.0]));
        assert!(disc.meets_line([-1.0, 5.0], [1.0, 5.0_f64.next_down()]));
        assert!(!disc.meets_line([5.0, 1e-40], [5.0, 1.0]));
        // The tangent at (3, 4) has the direction (4, -3).
        assert!(!disc.meets_line([7.0, 1.0], [-1.0, 7.0]));
        assert!(disc.meets_line([7.0, 1.0], [-1.0, 7.0_f64.next_down()]));
        assert!(disc.meets_line([7.0, 1.0_f64.next_down()], [-1.0, 7.0]));
    }

    #[test]
    fn shares_are_those_of_both_crossings() {
        let disc = Disc::new([1.0, 0.0], 5.0).unwrap();
        let (a, b) = ([-9.0, 3.0], [11.0, 3.0]);
        assert!((disc.share(a, b, false) - 0.3).abs() < 1e-15);
        assert!((disc.share(a, b, true) - 0.7).abs() < 1e-15);
        assert!((disc.share(b, a, true) - 0.7).abs() < 1e-15);
        // From the circle inwards, and away from it.
        assert_eq!(disc.share([4.0, 4.0], [-2.0, 4.0], false), 0.0);
        assert!((disc.share([4.0, 4.0], [-8.0, 4.0], true) - 0.5).abs() < 1e-15);
        assert_eq!(disc.share([4.0, 4.0], [7.0, 8.0], true), 0.0);
    }

    proptest! {
        #![proptest_config(beside_source())]

        #[test]
        fn agrees_with_integers(
            places in prop::array::uniform3(prop::array::uniform2(-15_i64..=15)),
            radius in 1_i64..=15,
            offset in prop::array::uniform2(-1_000_000_000_i64..=1_000_000_000),
        ) {
            // Multiples of 2⁻²⁰ about a far centre.
            let [a, b, centre] = places.map(|place| {
                let at = |axis: usize| (place[axis] + offset[axis]) as f64 / 1_048_576.0;
                [at(0), at(1)]
            });
            prop_assume!(a != b);
            let disc = Disc::new(centre, radius as f64 / 1_048_576.0).unwrap();
            let [p, q, c] = places;
            let squared = (p[0] - c[0]).pow(2) + (p[1] - c[1]).pow(2);
            prop_assert_eq!(disc.side(a), squared.cmp(&radius.pow(2)));
            let [dx, dy] = [q[0] - p[0], q[1] - p[1]];
            let twice_area = dx * (c[1] - p[1]) - dy * (c[0] - p[0]);
            let meets = twice_area.pow(2) < radius.pow(2) * (dx * dx + dy * dy);
            prop_assert_eq!(disc.meets_line(a, b), meets);
        }
    }
}
