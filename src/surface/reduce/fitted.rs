//! A height polynomial laid through points about a place, by least squares.

use nalgebra::{SMatrix, SVector};

/// A height polynomial about a place: `N` is 3 for a plane, 6 for a quadric, 15 for a quartic.
///
/// Its terms are the monomials of u and v by their degree, with u and v the offsets from the place, divided by
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
            normal.ger(1.0, &terms, &terms, 1.0);
            right.axpy(w, &terms, 1.0);
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
        self.terms_at(u_mm, v_mm).dot(&self.coefficients)
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

    /// How much [`Fitted::height_mm`] rises with the height of a point it was fitted to.
    fn height_weight(&self, u_mm: f64, v_mm: f64) -> f64 {
        self.terms_at(u_mm, v_mm).dot(&self.inverse.column(0))
    }

    fn terms_at(&self, u_mm: f64, v_mm: f64) -> SVector<f64, N> {
        terms(u_mm / self.scale_mm, v_mm / self.scale_mm)
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

impl Fitted<15> {
    /// How far the height of `lower`, fitted to `offsets_mm`, would be off if the surface were this quartic, in mm;
    /// and what the standard deviation of the heights is multiplied by to give that of it.
    ///
    /// The height of a fit is a sum over heights with weights w. So it is off by Σw·q - q(0), which is linear in the
    /// coefficients of the quartic q.
    pub(super) fn bias_of<const M: usize>(
        &self,
        lower: &Fitted<M>,
        offsets_mm: &[[f64; 3]],
    ) -> [f64; 2] {
        let mut along = SVector::<f64, 15>::zeros();
        for &[u, v, _] in offsets_mm {
            along.axpy(lower.height_weight(u, v), &self.terms_at(u, v), 1.0);
        }
        along[0] -= 1.0;
        let variance = along.dot(&(self.inverse * along));
        [along.dot(&self.coefficients), variance.max(0.0).sqrt()]
    }
}

fn terms<const N: usize>(u: f64, v: f64) -> SVector<f64, N> {
    let mut all = [1.0; 15];
    let (mut term, mut before, mut degree) = (1, 0, 1);
    while term < N {
        // Those of the degree before times u, and the last of them times v.
        for number in 0..degree {
            all[term + number] = u * all[before + number];
        }
        all[term + degree] = v * all[before + degree - 1];
        before = term;
        degree += 1;
        term += degree;
    }
    SVector::from_fn(|term, _| all[term])
}

/// Below this share of its own size a term is taken to follow from the others.
const DETERMINED: f64 = 1e-9;
