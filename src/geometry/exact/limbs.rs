//! Signed whole numbers of a fixed number of 64-bit limbs, on the stack.

use std::cmp::Ordering;

/// A whole number in two's complement of `N` limbs, the least significant first.
///
/// Sums, differences and products are right modulo 2⁶⁴ᴺ, hence right wherever the true result lies
/// from -2⁶⁴ᴺ⁻¹ to below 2⁶⁴ᴺ⁻¹. That it does is for the caller to prove.
#[derive(Clone, Copy, Debug)]
pub struct Limbs<const N: usize>([u64; N]);

impl<const N: usize> Limbs<N> {
    /// `value` / 2^`unit`, which must be whole and below 2⁶⁴ᴺ⁻¹ in size.
    pub fn from_double(value: f64, unit: i32) -> Self {
        let mut limbs = [0; N];
        let Some((odd, exponent)) = odd_part(value) else {
            return Self(limbs);
        };
        let shift = (exponent - unit) as usize;
        // A 53-bit number moved by less than 64 reaches into two limbs.
        let moved = u128::from(odd) << (shift % 64);
        limbs[shift / 64] = moved as u64;
        if let Some(upper) = limbs.get_mut(shift / 64 + 1) {
            *upper = (moved >> 64) as u64;
        }
        if value < 0.0 { Self([0; N]).minus(Self(limbs)) } else { Self(limbs) }
    }

    /// The sum.
    #[inline]
    pub fn plus(self, other: Self) -> Self {
        let mut carry = false;
        let mut sum = self.0;
        for (limb, term) in sum.iter_mut().zip(other.0) {
            (*limb, carry) = limb.carrying_add(term, carry);
        }
        Self(sum)
    }

    /// The difference.
    #[inline]
    pub fn minus(self, other: Self) -> Self {
        let mut borrow = false;
        let mut rest = self.0;
        for (limb, term) in rest.iter_mut().zip(other.0) {
            (*limb, borrow) = limb.borrowing_sub(term, borrow);
        }
        Self(rest)
    }

    /// Number in more limbs.
    #[inline]
    pub(crate) fn widened<const M: usize>(self) -> Limbs<M> {
        const { assert!(M >= N) };
        let mut limbs = [if self.is_negative() { u64::MAX } else { 0 }; M];
        limbs[..N].copy_from_slice(&self.0);
        Limbs(limbs)
    }

    /// The product. `M` must be 2`N`, so that it always fits but for (-2⁶⁴ᴺ⁻¹)².
    #[inline]
    pub fn times<const M: usize>(self, other: Self) -> Limbs<M> {
        const { assert!(M == 2 * N) };
        let mut product = [0; M];
        for (i, left) in self.0.into_iter().enumerate() {
            let mut carry = 0;
            for (j, right) in other.0.into_iter().enumerate() {
                (product[i + j], carry) = left.carrying_mul_add(right, product[i + j], carry);
            }
            product[i + N] = carry;
        }
        // A negative factor was taken for itself plus 2⁶⁴ᴺ: the other is too much in the upper half.
        let mut excess = [0; M];
        excess[N..].copy_from_slice(&self.where_negative(other).0);
        let rest = Limbs(product).minus(Limbs(excess));
        excess[N..].copy_from_slice(&other.where_negative(self).0);
        rest.minus(Limbs(excess))
    }

    /// The product with a number of `K` limbs. `M` must be `N` + `K`, so that it always fits but for the least times the least.
    #[inline]
    pub fn product<const K: usize, const M: usize>(self, other: Limbs<K>) -> Limbs<M> {
        const { assert!(M == N + K) };
        let mut product = [0; M];
        for (i, left) in self.0.into_iter().enumerate() {
            let mut carry = 0;
            for (j, right) in other.0.into_iter().enumerate() {
                (product[i + j], carry) = left.carrying_mul_add(right, product[i + j], carry);
            }
            product[i + K] = carry;
        }
        // As in `times`: a negative factor was taken for itself plus a power of two.
        let mut excess = [0; M];
        if self.is_negative() {
            excess[N..].copy_from_slice(&other.0);
        }
        let rest = Limbs(product).minus(Limbs(excess));
        excess = [0; M];
        if other.is_negative() {
            excess[K..].copy_from_slice(&self.0);
        }
        rest.minus(Limbs(excess))
    }

    /// Its comparison with zero.
    #[inline]
    pub fn sign(self) -> Ordering {
        if self.is_negative() {
            Ordering::Less
        } else if self.0.iter().all(|&limb| limb == 0) {
            Ordering::Equal
        } else {
            Ordering::Greater
        }
    }

    #[inline]
    fn is_negative(self) -> bool {
        (self.0[N - 1] as i64) < 0
    }

    /// `value` where `self` is negative, else zero.
    #[inline]
    fn where_negative(self, value: Self) -> Self {
        let mask = ((self.0[N - 1] as i64) >> 63) as u64;
        Self(value.0.map(|limb| limb & mask))
    }
}

impl From<i64> for Limbs<1> {
    #[inline]
    fn from(value: i64) -> Self {
        Self([value as u64])
    }
}

/// The odd number m below 2⁵³ and the exponent e with |`value`| = m·2^e. None for zero.
pub(crate) fn odd_part(value: f64) -> Option<(u64, i32)> {
    let bits = value.to_bits();
    let biased = (bits >> 52 & 0x7ff) as i32;
    let fraction = bits & ((1 << 52) - 1);
    let mantissa = if biased == 0 { fraction } else { fraction | 1 << 52 };
    let zeros = mantissa.trailing_zeros();
    (mantissa != 0).then(|| (mantissa >> zeros, biased.max(1) - 1075 + zeros as i32))
}
