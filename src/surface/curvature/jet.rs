//! Height, slopes and second derivatives at a vertex by least squares over its neighbourhood.
//!
//! **Model.** z is expanded about the vertex up to the third order; where the neighbourhood does not
//! determine that, up to the second (F. Cazals, M. Pouget, Comput. Aided Geom. Des. 22 (2005)
//! 121-146, doi:10.1016/j.cagd.2004.09.004, "osculating jets"). A polynomial of order n over a
//! neighbourhood of size h gives a k-th derivative to order h^(n-k+1) (their theorem 3.1): curvature
//! with n = 2 only to order h, unless the samples lie symmetrically about the vertex and third
//! derivatives cancel. With n = 3 it is h² everywhere, on scattered samples and along the border,
//! and where samples lie symmetrically the cubic terms cost the second derivatives no precision.
//!
//! **Weights.** All samples weigh the same: with equal noise that gives the smallest variance.
//!
//! **Scale.** Coordinates are differences from the vertex, transformed by the Cholesky factor of
//! their second moments, so that all terms are of the order of 1: neither the distance from the
//! origin, nor the unit of length, nor the ratio of the distance of samples along a scan line to that
//! of the lines matters to the normal equations. One step of iterative refinement takes back what
//! squaring the matrix costs.

use asphera_geometry::{PointMm, RANGE_MM};

use super::Undetermined;

/// The terms up to the second order.
pub(crate) const QUADRIC: usize = 6;
/// The terms up to the third order.
pub(crate) const CUBIC: usize = 10;

/// Fewest samples for a cubic: four more than it has terms, so that no single one decides.
const CUBIC_SAMPLES: usize = 14;
/// Second moments are those of a line if their ratio, smaller to larger, is below this: if the
/// samples lie within a millionth of its length of a line.
const LINE: f64 = 1e-12;
/// Largest condition (see [`Jet::condition`]) of a cubic that is used.
const CUBIC_CONDITION: f64 = 1e3;
/// Largest condition of a quadric that is used. Samples on a conic have an infinite one, but for
/// rounding.
const QUADRIC_CONDITION: f64 = 1e5;

/// Which polynomial was fitted.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Model {
    /// Up to the second order: curvature is known to the order of the sample distance, where samples
    /// lie symmetrically about the vertex to that of its square.
    Quadric,
    /// Up to the third order: curvature is known to the order of the square of the sample distance.
    Cubic,
}

/// What a fit tells of the surface at the vertex.
pub(super) struct Jet {
    /// Height over the vertex in mm, slopes along x and y, and second derivatives along xx, xy, yy
    /// in 1/mm.
    pub(super) terms: [f64; 6],
    /// Half of the covariance of these terms for heights of variance 1 mm²: C = F Fᵀ.
    factor: [[f64; 6]; 6],
    pub(super) model: Model,
    /// Sum of the squared residuals in mm².
    pub(super) squares_mm2: f64,
    pub(super) samples: usize,
    /// How near the terms are to depend on each other over these samples: the largest ratio of the
    /// length of a term to its distance from the span of those before it. At least 1.
    pub(super) condition: f64,
}

impl Jet {
    /// Fits the heights of the samples, the vertex first.
    pub(super) fn of(
        points: &[PointMm],
        samples: &[u32],
        places: &mut Vec<[f64; 3]>,
    ) -> Result<Jet, Undetermined> {
        let local = Local::of(points, samples, places)?;
        if samples.len() >= CUBIC_SAMPLES
            && let Some(system) = System::<CUBIC>::of(places, CUBIC_CONDITION)
        {
            return Ok(system.jet(places, &local, Model::Cubic));
        }
        if samples.len() < QUADRIC {
            return Err(Undetermined::TooFew { vertices: samples.len() });
        }
        match System::<QUADRIC>::of(places, QUADRIC_CONDITION) {
            Some(system) => Ok(system.jet(places, &local, Model::Quadric)),
            None => Err(Undetermined::OnConic { vertices: samples.len() }),
        }
    }

    /// How many samples there are beyond those that the terms need.
    pub(super) fn freedom(&self) -> usize {
        self.samples
            - match self.model {
                Model::Quadric => QUADRIC,
                Model::Cubic => CUBIC,
            }
    }

    /// Variance of a linear combination of the terms for heights of variance 1 mm².
    pub(super) fn variance(&self, weights: &[f64; 6]) -> f64 {
        self.along(weights).iter().map(|part| part * part).sum()
    }

    /// Covariance of two linear combinations of the terms for heights of variance 1 mm².
    pub(super) fn covariance(&self, left: &[f64; 6], right: &[f64; 6]) -> f64 {
        self.along(left).iter().zip(self.along(right)).map(|(p, q)| p * q).sum()
    }

    /// A linear combination in coordinates in which its variance is its squared length.
    fn along(&self, weights: &[f64; 6]) -> [f64; 6] {
        let mut along = [0.0; 6];
        for (weight, row) in weights.iter().zip(&self.factor) {
            along.iter_mut().zip(row).for_each(|(sum, entry)| *sum += weight * entry);
        }
        along
    }
}

/// The coordinates in which a neighbourhood is of size 1 in all directions.
pub(crate) struct Local {
    /// The scaled coordinates' derivatives along x and y: u = a·x, v = b·x + d·y.
    a: f64,
    b: f64,
    d: f64,
}

impl Local {
    /// Fills `places` with u, v and the height over the first sample in mm.
    pub(crate) fn of(
        points: &[PointMm],
        samples: &[u32],
        places: &mut Vec<[f64; 3]>,
    ) -> Result<Local, Undetermined> {
        let vertices = samples.len();
        let origin = points[samples[0] as usize];
        places.clear();
        places.extend(samples.iter().map(|&sample| {
            let point = points[sample as usize];
            [point[0] - origin[0], point[1] - origin[1], point[2] - origin[2]]
        }));
        // Written so that NaN fails.
        if !places.as_flattened().iter().all(|coordinate| coordinate.abs() <= 2.0 * RANGE_MM) {
            return Err(Undetermined::NotFinite);
        }
        let [mut xx, mut xy, mut yy] = [0.0; 3];
        for [x, y, _] in places.iter() {
            xx += x * x;
            xy += x * y;
            yy += y * y;
        }
        // The determinant over the squared trace is the ratio of the eigenvalues, if that is small.
        let trace = xx + yy;
        if vertices < 3 || trace == 0.0 {
            return Err(Undetermined::TooFew { vertices });
        }
        let (share_x, cross, share_y) = (xx / trace, xy / trace, yy / trace);
        if share_x * share_y - cross * cross < LINE {
            return Err(Undetermined::Collinear { vertices });
        }
        let count = vertices as f64;
        let (first, mixed) = ((xx / count).sqrt(), xy / count);
        let lower = mixed / first;
        let second = (yy / count - lower * lower).sqrt();
        let local = Local { a: first.recip(), b: -lower / (first * second), d: second.recip() };
        for place in places.iter_mut() {
            let [x, y, z] = *place;
            *place = [local.a * x, local.b * x + local.d * y, z];
        }
        Ok(local)
    }

    /// Height, slopes and second derivatives along x and y from those along u and v.
    pub(crate) fn in_mm(&self, terms: [f64; 6]) -> [f64; 6] {
        let Local { a, b, d } = *self;
        let [height, gu, gv, huu, huv, hvv] = terms;
        [
            height,
            a * gu + b * gv,
            d * gv,
            a * a * huu + 2.0 * a * b * huv + b * b * hvv,
            d * (a * huv + b * hvv),
            d * d * hvv,
        ]
    }
}

/// The normal equations of a fit of N terms, factorised: AᵀA = L Lᵀ.
pub(crate) struct System<const N: usize> {
    /// L below its diagonal.
    lower: [[f64; N]; N],
    /// One over the diagonal of L.
    inverse: [f64; N],
    condition: f64,
}

impl<const N: usize> System<N> {
    /// `None` if the condition is above the limit.
    pub(crate) fn of(places: &[[f64; 3]], condition_limit: f64) -> Option<System<N>> {
        let moments = moments::<N>(places);
        let powers = &POWERS[CUBIC - N..];
        let mut lower = [[0.0; N]; N];
        for (row, p) in lower.iter_mut().zip(powers) {
            for (entry, q) in row.iter_mut().zip(powers) {
                *entry = moments[p[0] + q[0]][p[1] + q[1]];
            }
        }
        let mut inverse = [0.0; N];
        let mut smallest_share = 1.0_f64;
        for j in 0..N {
            let whole = lower[j][j];
            let (above, rest) = lower.split_at_mut(j + 1);
            let row = &mut above[j];
            let pivot = whole - row[..j].iter().map(|entry| entry * entry).sum::<f64>();
            // Written so that NaN fails.
            if !(pivot * condition_limit * condition_limit >= whole && whole > 0.0) {
                return None;
            }
            smallest_share = smallest_share.min(pivot / whole);
            inverse[j] = pivot.sqrt().recip();
            for other in rest {
                let known: f64 = other[..j].iter().zip(&row[..j]).map(|(p, q)| p * q).sum();
                other[j] = (other[j] - known) * inverse[j];
            }
        }
        Some(System { lower, inverse, condition: smallest_share.sqrt().recip() })
    }

    /// L⁻¹ of a vector.
    pub(crate) fn forward(&self, mut vector: [f64; N]) -> [f64; N] {
        for i in 0..N {
            let known: f64 = self.lower[i][..i].iter().zip(&vector).map(|(p, q)| p * q).sum();
            vector[i] = (vector[i] - known) * self.inverse[i];
        }
        vector
    }

    /// L⁻ᵀ of a vector.
    fn backward(&self, mut vector: [f64; N]) -> [f64; N] {
        for i in (0..N).rev() {
            vector[i] *= self.inverse[i];
            for j in 0..i {
                vector[j] -= self.lower[i][j] * vector[i];
            }
        }
        vector
    }

    /// The terms, and the sum of the squared residuals.
    pub(crate) fn solve(&self, places: &[[f64; 3]]) -> ([f64; N], f64) {
        let mut found = [0.0; N];
        let mut squares = 0.0;
        // The second time what the first left is solved for.
        for _ in 0..2 {
            let mut moments = [0.0; N];
            squares = 0.0;
            for place in places {
                let row = terms_at::<N>(place);
                let residual = place[2] - dot(&row, &found);
                squares += residual * residual;
                for (moment, term) in moments.iter_mut().zip(row) {
                    *moment += residual * term;
                }
            }
            let fitted = self.forward(moments);
            // Pythagoras: what is left is at right angles to what is fitted.
            squares -= fitted.iter().map(|part| part * part).sum::<f64>();
            let step = self.backward(fitted);
            found.iter_mut().zip(step).for_each(|(term, step)| *term += step);
        }
        (found, squares.max(0.0))
    }

    fn jet(&self, places: &[[f64; 3]], local: &Local, model: Model) -> Jet {
        let (found, squares_mm2) = self.solve(places);
        // The inverse of AᵀA has at its end the inverse of the end of L times its transpose.
        let skipped = N - QUADRIC;
        let mut factor = [[0.0; 6]; 6];
        for column in 0..QUADRIC {
            let mut unit = [0.0; N];
            unit[skipped + column] = 1.0;
            // Row `column` of L⁻ᵀ at the end: nothing before it takes part.
            let inverse = self.backward_end(unit);
            let terms = local.in_mm(derivatives(&inverse));
            for (row, term) in factor.iter_mut().zip(terms) {
                row[column] = term;
            }
        }
        Jet {
            terms: local.in_mm(derivatives(&found)),
            factor,
            model,
            squares_mm2,
            samples: places.len(),
            condition: self.condition,
        }
    }

    /// L⁻ᵀ of a vector, but for the terms before the last six.
    fn backward_end(&self, mut vector: [f64; N]) -> [f64; N] {
        for i in (N - QUADRIC..N).rev() {
            vector[i] *= self.inverse[i];
            for j in N - QUADRIC..i {
                vector[j] -= self.lower[i][j] * vector[i];
            }
        }
        vector
    }
}

/// The powers of u and v that are the terms, those of the highest order first, so that the covariance
/// of the last six needs the end of the factor only.
const POWERS: [[usize; 2]; CUBIC] =
    [[3, 0], [2, 1], [1, 2], [0, 3], [0, 0], [1, 0], [0, 1], [2, 0], [1, 1], [0, 2]];

/// The terms at a place.
pub(crate) fn terms_at<const N: usize>(&[u, v, _]: &[f64; 3]) -> [f64; N] {
    let (uu, vv) = (u * u, v * v);
    let terms = [u * uu, uu * v, u * vv, v * vv, 1.0, u, v, uu, u * v, vv];
    std::array::from_fn(|i| terms[CUBIC - N + i])
}

/// Sums of uᵃ·vᵇ, by a and b, up to twice the order of the terms: products of two terms are such
/// powers, and there are half as many of them as of pairs of terms.
fn moments<const N: usize>(places: &[[f64; 3]]) -> [[f64; 7]; 7] {
    let order = if N == CUBIC { 6 } else { 4 };
    let mut moments = [[0.0; 7]; 7];
    for &[u, v, _] in places {
        let mut powers = [1.0; 7];
        for i in 1..=order {
            powers[i] = powers[i - 1] * v;
        }
        let mut power = 1.0;
        for (a, sums) in moments.iter_mut().enumerate().take(order + 1) {
            for (sum, other) in sums.iter_mut().zip(powers).take(order + 1 - a) {
                *sum += power * other;
            }
            power *= u;
        }
    }
    moments
}

/// Scalar product in four sums, each of which need not wait for the others.
pub(crate) fn dot<const N: usize>(left: &[f64; N], right: &[f64; N]) -> f64 {
    let mut sums = [0.0; 4];
    for i in 0..N {
        sums[i % 4] += left[i] * right[i];
    }
    (sums[0] + sums[1]) + (sums[2] + sums[3])
}

/// Height, slopes and second derivatives along u and v, from coefficients of all terms.
pub(crate) fn derivatives<const N: usize>(terms: &[f64; N]) -> [f64; 6] {
    let [height, u, v, uu, uv, vv] = std::array::from_fn(|i| terms[N - QUADRIC + i]);
    [height, u, v, 2.0 * uu, uv, 2.0 * vv]
}
