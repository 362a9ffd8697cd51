//! Comparisons of distances and angles in the plane, decided exactly for any places the mesh
//! admits.
//!
//! As in [`crate::exact`], a comparison is first made in doubles with a bound of its rounding
//! error, and only if that does not decide it in whole numbers. No square or product underflows: a
//! difference of two admitted coordinates is zero or at least 2⁻¹⁸⁵ in size.

use std::cmp::Ordering;

use crate::exact::Place;
use crate::exact::limbs::Limbs;

/// Compares the distance from `from` to `p` with that from `from` to `q`.
#[inline]
pub fn compare_distances_from(from: Place, p: Place, q: Place) -> Ordering {
    let squared = |to: Place| {
        let [x, y] = [to[0] - from[0], to[1] - from[1]];
        x * x + y * y
    };
    let (to_p, to_q) = (squared(p), squared(q));
    let difference = to_p - to_q;
    if difference.abs() > BOUND * (to_p + to_q) {
        difference.total_cmp(&0.0)
    } else {
        let squared = |to: Place| {
            let [x, y] = whole_difference(to, from);
            x.times::<8>(x).plus(y.times(y))
        };
        squared(p).minus(squared(q)).sign()
    }
}

/// Whether the angle at `at` between the directions to `p` and to `q` is below 90° (`Greater`, as
/// its cosine), right (`Equal`) or above (`Less`). `Equal` as well if `p` or `q` stands at `at`.
#[inline]
pub fn compare_with_right_angle(at: Place, p: Place, q: Place) -> Ordering {
    let [px, py] = [p[0] - at[0], p[1] - at[1]];
    let [qx, qy] = [q[0] - at[0], q[1] - at[1]];
    let (along, across) = (px * qx, py * qy);
    let product = along + across;
    if product.abs() > BOUND * (along.abs() + across.abs()) {
        product.total_cmp(&0.0)
    } else {
        let ([px, py], [qx, qy]) = (whole_difference(p, at), whole_difference(q, at));
        px.times::<8>(qx).plus(py.times(qy)).sign()
    }
}

/// `to - from` in units of 2⁻¹⁸⁵ mm: below 2²²⁶ in size, so that sums of its squares stay well
/// below 2⁵¹¹.
fn whole_difference(to: Place, from: Place) -> [Limbs<4>; 2] {
    [0, 1].map(|axis| {
        let [to, from] = [to, from].map(|place| Limbs::from_double(place[axis], UNIT));
        to.minus(from)
    })
}

/// Admitted coordinates are zero or above 2⁻¹³³, hence multiples of 2⁻¹⁸⁵, and below 2⁴⁰.
const UNIT: i32 = -185;

/// Each difference, product and sum is rounded by at most half an ulp: a sum of two products of two
/// differences is off by less than five halves of an ulp, the comparison of two such by three.
const BOUND: f64 = 4.0 * f64::EPSILON;

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;
    use crate::RANGE_MM;
    use crate::regressions::beside_source;

    #[test]
    fn tells_what_doubles_cannot() {
        // The squares differ by one unit of 2⁻¹⁰⁴ and less beside 2.
        let up = 1.0_f64.next_up();
        assert_eq!(compare_distances_from([0.0; 2], [1.0, up], [up, 1.0]), Ordering::Equal);
        let (p, q) = ([1.0, up], [-1.0, up.next_up()]);
        assert_eq!(compare_distances_from([0.0; 2], p, q), Ordering::Less);
        assert_eq!(compare_distances_from([1e-40, 0.0], p, [-p[0], p[1]]), Ordering::Less);
        assert_eq!(compare_distances_from([0.0, 1e-40], p, [-p[0], p[1]]), Ordering::Equal);
        let far = [RANGE_MM, -RANGE_MM];
        assert_eq!(compare_with_right_angle(far, [-1.0, 1.0], [1.0, -1.0]), Ordering::Greater);
        assert_eq!(compare_with_right_angle(p, p, q), Ordering::Equal);
        let across = [-up, 1.0];
        assert_eq!(compare_with_right_angle([0.0; 2], p, across), Ordering::Equal);
        let nearly = [-up, 1.0_f64.next_down()];
        assert_eq!(compare_with_right_angle([0.0; 2], p, nearly), Ordering::Less);
    }

    proptest! {
        #![proptest_config(beside_source())]

        #[test]
        fn agrees_with_integers(
            places in prop::array::uniform3(prop::array::uniform2(-20_i64..=20)),
            offset in prop::array::uniform2(-1_000_000_000_i64..=1_000_000_000),
        ) {
            // Multiples of 2⁻²⁰ about a far centre.
            let [at, p, q] = places.map(|place| {
                let at = |axis: usize| (place[axis] + offset[axis]) as f64 / 1_048_576.0;
                [at(0), at(1)]
            });
            let to = |other: [i64; 2]| [other[0] - places[0][0], other[1] - places[0][1]];
            let ([px, py], [qx, qy]) = (to(places[1]), to(places[2]));
            let expected = (px * px + py * py).cmp(&(qx * qx + qy * qy));
            prop_assert_eq!(compare_distances_from(at, p, q), expected);
            prop_assert_eq!(compare_with_right_angle(at, p, q), (px * qx + py * qy).cmp(&0));
        }
    }
}
