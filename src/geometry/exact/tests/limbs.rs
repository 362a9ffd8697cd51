//! The arithmetic of limbs.

use std::cmp::Ordering;

use proptest::prelude::*;

use crate::exact::limbs::{Limbs, odd_part};
use crate::regressions::beside_source;

proptest! {
    #![proptest_config(beside_source())]

    #[test]
    fn one_limb_multiplies_like_integers(left: i64, right: i64) {
        // As two limbs, the integer is an i64 times 2⁶⁴ and 32 bits twice.
        let expected = i128::from(left) * i128::from(right);
        let part = |value: i128, unit: i32| Limbs::<2>::from_double(value as f64, unit);
        let mut sum = part(expected >> 96, -96);
        for shift in [64, 32, 0] {
            sum = sum.plus(part(expected >> shift & 0xffff_ffff, -shift));
        }
        let product: Limbs<2> = Limbs::from(left).times(Limbs::from(right));
        prop_assert_eq!(product.minus(sum).sign(), Ordering::Equal);
        prop_assert_eq!(product.sign(), expected.cmp(&0));
    }

    /// (x + y)² = (x - y)² + 4xy, with carries through all limbs.
    #[test]
    fn limbs_obey_the_binomial_law(
        terms in prop::array::uniform2(prop::array::uniform5((-(1_i64 << 53)..=1 << 53, 0..199))),
    ) {
        let [x, y] = terms.map(|parts| {
            let limbs = parts.map(|(mantissa, exponent)| {
                Limbs::<4>::from_double(mantissa as f64 * 2.0_f64.powi(exponent), 0)
            });
            limbs.into_iter().reduce(Limbs::plus).unwrap()
        });
        let (sum, difference) = (x.plus(y), x.minus(y));
        let twice: Limbs<8> = x.times(y).plus(x.times(y));
        let left: Limbs<8> = sum.times(sum).minus(difference.times(difference));
        prop_assert_eq!(left.minus(twice.plus(twice)).sign(), Ordering::Equal);
        prop_assert_eq!(x.minus(y).sign(), y.minus(x).sign().reverse());
        prop_assert_ne!(sum.times::<8>(sum).sign(), Ordering::Less);
    }
}

#[test]
fn limbs_hold_their_limits() {
    let [low, high] = [i64::MIN, i64::MAX].map(Limbs::<1>::from);
    let one = Limbs::<1>::from(1);
    assert_eq!(low.times::<2>(high).sign(), Ordering::Less);
    assert_eq!(high.plus(low).plus(one).sign(), Ordering::Equal);
    // -2⁶³·(2⁶³-1) + 2¹²⁶ = 2⁶³.
    let rest = low.times::<2>(high).plus(Limbs::from_double(2.0_f64.powi(126), 0));
    assert_eq!(rest.minus(Limbs::from_double(2.0_f64.powi(63), 0)).sign(), Ordering::Equal);
    // Borrow and carry through a limb of zeros or ones.
    let [far, near] = [2.0_f64.powi(100), 1.0].map(|value| Limbs::<2>::from_double(value, 0));
    let below = far.minus(near);
    assert_eq!(below.minus(far).sign(), Ordering::Less);
    assert_eq!(below.plus(near).minus(far).sign(), Ordering::Equal);
}

#[test]
fn doubles_of_any_size_come_apart() {
    let largest_odd = (1 << 53) - 1;
    for (value, parts) in [
        (0.0, None),
        (-0.0, None),
        (1.5, Some((3, -1))),
        (-1e6, Some((15_625, 6))),
        (f64::MAX, Some((largest_odd, 971))),
        (f64::MIN_POSITIVE, Some((1, -1022))),
        (f64::MIN_POSITIVE / 4.0, Some((1, -1024))),
        (f64::from_bits(3), Some((3, -1074))),
    ] {
        assert_eq!(odd_part(value), parts, "{value}");
    }
}
