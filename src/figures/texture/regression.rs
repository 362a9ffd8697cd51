//! The weighted polynomial about a node, from its moments.

use super::Order;

/// The value of a filter at a node.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct FittedNode {
    pub(super) value_nm: f64,
    /// Terms of the polynomial that the neighbours determine; 0 if there is no weight at all.
    pub(super) terms: u8,
}

/// Sums of s·u^i·v^j over the neighbours of a node, for each (i, j) of [`MOMENTS`], and of s·z·u^i·v^j for
/// each of [`TERMS`]; s is the weight, (u, v) the distance in units of the filter, z the height.
#[derive(Clone, Copy, Default)]
pub(super) struct Sums {
    pub(super) moments: [f64; MOMENTS.len()],
    pub(super) heights: [f64; TERMS.len()],
}

/// Exponents (i, j) of the terms u^i·v^j, in the order in which they are determined.
pub(super) const TERMS: [(usize, usize); 6] = [(0, 0), (1, 0), (0, 1), (2, 0), (1, 1), (0, 2)];

/// Exponents of the products of two terms.
pub(super) const MOMENTS: [(usize, usize); 15] = [
    (0, 0),
    (1, 0),
    (2, 0),
    (3, 0),
    (4, 0),
    (0, 1),
    (1, 1),
    (2, 1),
    (3, 1),
    (0, 2),
    (1, 2),
    (2, 2),
    (0, 3),
    (1, 3),
    (0, 4),
];

/// Terms of a polynomial, as indices of [`TERMS`]: without those along a direction a profile has not.
pub(super) fn terms_of(order: Order, along_x: bool, along_y: bool) -> Vec<usize> {
    let degree = match order {
        Order::Zero => 0,
        Order::Two => 2,
    };
    let belongs = |&term: &usize| {
        let (i, j) = TERMS[term];
        i + j <= degree && (i == 0 || along_x) && (j == 0 || along_y)
    };
    (0..TERMS.len()).filter(belongs).collect()
}

impl Sums {
    /// Value at the node of the polynomial of the terms that minimises the weighted squares.
    ///
    /// The normal equations are factored as L·D·Lᵀ in the order of the terms (Golub & Van Loan, Matrix
    /// Computations, 4th ed., 4.1.2). A term whose pivot vanishes beside its diagonal depends on those
    /// before it and is left out. With the unit of the filter the pivots of a full neighbourhood are between
    /// 0.01 and 1, so the squared condition does no harm.
    pub(super) fn fit(&self, terms: &[usize]) -> FittedNode {
        if self.moments[0] <= 0.0 {
            return FittedNode::default();
        }
        let count = terms.len();
        let gram = |a: usize, b: usize| {
            let ((i, j), (k, l)) = (TERMS[terms[a]], TERMS[terms[b]]);
            self.moments[moment(i + k, j + l)]
        };
        let mut lower = [[0.0; TERMS.len()]; TERMS.len()];
        let mut pivots = [0.0; TERMS.len()];
        let mut right = [0.0; TERMS.len()];
        let mut determined = 0;
        for a in 0..count {
            for b in 0..a {
                if pivots[b] > 0.0 {
                    let done: f64 = (0..b).map(|c| lower[a][c] * pivots[c] * lower[b][c]).sum();
                    lower[a][b] = (gram(a, b) - done) / pivots[b];
                }
            }
            let done: f64 = (0..a).map(|b| lower[a][b] * lower[a][b] * pivots[b]).sum();
            let pivot = gram(a, a) - done;
            if pivot > LEAST_PIVOT * gram(a, a) {
                pivots[a] = pivot;
                let done: f64 = (0..a).map(|b| lower[a][b] * right[b]).sum();
                right[a] = self.heights[terms[a]] - done;
                determined += 1;
            }
        }
        // Back substitution; a term left out has the coefficient 0.
        let mut coefficients = [0.0; TERMS.len()];
        for a in (0..count).rev().filter(|&a| pivots[a] > 0.0) {
            let after: f64 = (a + 1..count).map(|b| lower[b][a] * coefficients[b]).sum();
            coefficients[a] = right[a] / pivots[a] - after;
        }
        FittedNode { value_nm: coefficients[0], terms: determined }
    }

    /// What the value at the node is to each of [`Sums::heights`]: it is linear in them. `None` if there is no weight.
    pub(super) fn answer(&self, terms: &[usize]) -> Option<[f64; TERMS.len()]> {
        if self.moments[0] <= 0.0 {
            return None;
        }
        Some(std::array::from_fn(|term| {
            let mut unit = Sums { moments: self.moments, ..Sums::default() };
            unit.heights[term] = 1.0;
            unit.fit(terms).value_nm
        }))
    }
}

/// Where in [`MOMENTS`] the exponents (i, j) are: rows of 5, 4, 3, 2 and 1.
fn moment(i: usize, j: usize) -> usize {
    j * (11 - j) / 2 + i
}

/// Pivots below this share of their diagonal are rounding: moments of up to 10⁷ nodes carry about 1e-13.
const LEAST_PIVOT: f64 = 1e-9;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn moments_are_found_by_their_exponents() {
        for (index, &(i, j)) in MOMENTS.iter().enumerate() {
            assert_eq!(moment(i, j), index);
        }
    }

    fn sums(points: &[(f64, f64, f64, f64)]) -> Sums {
        let mut sums = Sums::default();
        for &(weight, u, v, z) in points {
            for (sum, &(i, j)) in sums.moments.iter_mut().zip(&MOMENTS) {
                *sum += weight * u.powi(i as i32) * v.powi(j as i32);
            }
            for (sum, &(i, j)) in sums.heights.iter_mut().zip(&TERMS) {
                *sum += weight * z * u.powi(i as i32) * v.powi(j as i32);
            }
        }
        sums
    }

    #[test]
    fn a_quadric_is_its_own_fit() {
        let place = |i: i32| (0.3 * f64::from(i % 5) - 0.4, 0.2 * f64::from(i / 5) - 0.3);
        let points: Vec<_> = (0..25)
            .map(place)
            .map(|(u, v)| (1.0 + u * v, u, v, 7.0 - u + 2.0 * v + 3.0 * u * u - u * v + v * v))
            .collect();
        let fitted = sums(&points).fit(&terms_of(Order::Two, true, true));
        assert_eq!(fitted.terms, 6);
        assert!((fitted.value_nm - 7.0).abs() < 1e-12, "{}", fitted.value_nm);
    }

    #[test]
    fn what_points_do_not_determine_is_left_out() {
        let all = terms_of(Order::Two, true, true);
        let one = sums(&[(0.5, 0.0, 0.0, 3.0)]).fit(&all);
        assert_eq!((one.terms, one.value_nm), (1, 3.0));
        // Three points on a diagonal: a constant, a slope and a curvature along it.
        let line: Vec<_> = (-1..=1)
            .map(|i| f64::from(i) * 0.3)
            .map(|t| (1.0, t, t, 2.0 + t + 5.0 * t * t))
            .collect();
        let line = sums(&line).fit(&all);
        assert_eq!(line.terms, 3);
        assert!((line.value_nm - 2.0).abs() < 1e-12);
        assert_eq!(sums(&[]).fit(&all), FittedNode::default());
    }
}
