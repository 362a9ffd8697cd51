//! A plane or a quadric laid through points about a place, by least squares.

use nalgebra::{SMatrix, SVector};

/// A height polynomial about a place: `N` is 3 for a plane, 6 for a quadric.
///
/// Its terms are 1, u, v, u², u·v, v², with u and v the offsets from the place, divided by
/// `scale_mm`.
pub(super) struct Fitted<const N: usize> {
    coefficients: SVector<f64, N>,
    /// The inverse of the normal matrix: times σ², the covariance of the coefficients.
    inverse: SMatrix<f64, N, N>,
    scale_mm: f64,
}

impl<const N: usize> Fitted<N> {
    /// Fits to offsets (along x, y, z) from the place; `None` where they do not determine it.
    pub(super) fn to(offsets_mm: &[[f64; 3]]) -> Option<Fitted<N>> {
        if offsets_mm.len() < N {
            return None;
        }
        let scale_mm = offsets_mm.iter().map(|&[u, v, _]| u.abs().max(v.abs())).fold(0.0, f64::max);
        if !(scale_mm > 0.0 && scale_mm.is_finite()) {
            return None;
        }
        let mut normal = SMatrix::<f64, N, N>::zeros();
        let mut right = SVector::<f64, N>::zeros();
        for &[u, v, w] in offsets_mm {
            let terms = terms::<N>(u / scale_mm, v / scale_mm);
            normal += terms * terms.transpose();
            right += terms * w;
        }
        let cholesky = normal.cholesky()?;
        // The squared pivots over the diagonal: what is left of each term beside those before it.
        let factor = cholesky.l_dirty();
        let determined = (0..N).all(|i| factor[(i, i)].powi(2) > DETERMINED * normal[(i, i)]);
        determined.then(|| Fitted {
            coefficients: cholesky.solve(&right),
            inverse: cholesky.inverse(),
            scale_mm,
        })
    }

    /// The height at an offset from the place, over its zero, in mm.
    pub(super) fn height_at_mm(&self, u_mm: f64, v_mm: f64) -> f64 {
        terms::<N>(u_mm / self.scale_mm, v_mm / self.scale_mm).dot(&self.coefficients)
    }

    /// The height at the place over its zero, in mm.
    pub(super) fn height_mm(&self) -> f64 {
        self.coefficients[0]
    }

    /// What the standard deviation of the heights is multiplied by to give that of
    /// [`Fitted::height_mm`].
    pub(super) fn height_factor(&self) -> f64 {
        self.inverse[(0, 0)].sqrt()
    }

    /// The slopes at the place along x and y.
    pub(super) fn slopes(&self) -> [f64; 2] {
        [self.coefficients[1] / self.scale_mm, self.coefficients[2] / self.scale_mm]
    }
}

impl Fitted<6> {
    /// The second derivatives at the place, ∂²/∂x², ∂²/∂x∂y, ∂²/∂y², in 1/mm.
    pub(super) fn second_per_mm(&self) -> [f64; 3] {
        let squared = self.scale_mm * self.scale_mm;
        let [uu, uv, vv] = [3, 4, 5].map(|term| self.coefficients[term] / squared);
        [2.0 * uu, uv, 2.0 * vv]
    }

    /// What the standard deviation of the heights is multiplied by to give that of each of those.
    pub(super) fn second_factors_per_mm2(&self) -> [f64; 3] {
        let squared = self.scale_mm * self.scale_mm;
        let [uu, uv, vv] = [3, 4, 5].map(|term| self.inverse[(term, term)].sqrt() / squared);
        [2.0 * uu, uv, 2.0 * vv]
    }
}

fn terms<const N: usize>(u: f64, v: f64) -> SVector<f64, N> {
    let all = [1.0, u, v, u * u, u * v, v * v];
    SVector::from_fn(|term, _| all[term])
}

/// Below this share of its own size a term is taken to follow from the others.
const DETERMINED: f64 = 1e-9;
