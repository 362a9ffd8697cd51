//! Normal and principal curvatures from slopes and second derivatives, with their uncertainties.

use super::jet::{Jet, Model};
use super::rings::Surroundings;
use crate::noise::Noise;

/// What the samples about a vertex tell of the surface at it.
///
/// A curvature is positive where the surface bends towards +z, as z = x² does.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LocalShape {
    /// Height of the fitted surface at the vertex in mm, in the frame of the points.
    pub height_mm: f64,
    /// Unit normal on the +z side.
    pub normal: [f64; 3],
    /// Principal curvatures in 1/mm, the larger first.
    pub curvatures_per_mm: [f64; 2],
    /// Unit vectors in the tangent plane along which these are; the first, the second and the normal
    /// are right-handed. Where both curvatures are equal, any two.
    pub directions: [[f64; 3]; 2],
    /// What noise does to all that; `None` if none was given.
    pub uncertainty: Option<ShapeUncertainty>,
    /// Standard deviation of the heights from the fitted surface in mm, estimated from the residuals
    /// and their degrees of freedom; `None` if there are none. Far above the noise it tells of
    /// features finer than the neighbourhood, or of wrong readings.
    pub residual_mm: Option<f64>,
    /// Samples beyond those the fit needs.
    pub degrees_of_freedom: u32,
    /// Samples in the neighbourhood, the vertex included.
    pub samples: u32,
    /// The polynomial that was fitted.
    pub model: Model,
    /// The largest ratio of the length of a term of the fit to its distance from the span of those
    /// before it, over the samples: 1 for independent terms, infinite where they cannot be told apart.
    pub condition: f64,
    /// Whether the neighbourhood is whole or cut by the border.
    pub surroundings: Surroundings,
}

/// Standard uncertainties that white noise of the heights causes.
///
/// They are propagated to first order through the fit and hold for the noise they were given, not
/// for what the polynomial cannot follow.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ShapeUncertainty {
    /// Of the height, in mm.
    pub height_mm: f64,
    /// Of the normal's angle in rad: its tilt towards either principal direction.
    pub normal_rad: [f64; 2],
    /// Covariance in rad² of these two tilts.
    pub normal_covariance_rad2: f64,
    /// Of the principal curvatures in 1/mm. Noise also drives the two apart, the more the nearer they
    /// are; what that is estimated to have done is included.
    pub curvatures_per_mm: [f64; 2],
    /// Covariance in 1/mm² of the principal curvatures.
    pub curvature_covariance_per_mm2: f64,
    /// Of the mean curvature in 1/mm.
    pub mean_per_mm: f64,
    /// Of the Gaussian curvature in 1/mm².
    pub gaussian_per_mm2: f64,
    /// Of the principal directions, an angle about the normal in rad; `None` where the curvatures are
    /// too alike to tell directions.
    pub direction_rad: Option<f64>,
}

impl LocalShape {
    /// Mean curvature in 1/mm.
    pub fn mean_per_mm(&self) -> f64 {
        0.5 * (self.curvatures_per_mm[0] + self.curvatures_per_mm[1])
    }

    /// Gaussian curvature in 1/mm².
    pub fn gaussian_per_mm2(&self) -> f64 {
        self.curvatures_per_mm[0] * self.curvatures_per_mm[1]
    }

    /// The shape at a vertex of height `z_mm`.
    pub(super) fn of(
        jet: &Jet,
        z_mm: f64,
        surroundings: Surroundings,
        noise: Option<Noise>,
    ) -> LocalShape {
        let tangent = Tangent::of(jet);
        let [gx, gy] = tangent.slope;
        let secant = tangent.secant;
        let freedom = jet.freedom();
        LocalShape {
            height_mm: z_mm + jet.terms[0],
            normal: [-gx / secant, -gy / secant, 1.0 / secant],
            curvatures_per_mm: tangent.curvatures_per_mm,
            directions: tangent.along.map(|[x, y]| [x, y, gx * x + gy * y]),
            uncertainty: noise.map(|noise| tangent.uncertainty(jet, noise)),
            residual_mm: (freedom > 0).then(|| (jet.squares_mm2 / freedom as f64).sqrt()),
            degrees_of_freedom: freedom as u32,
            samples: jet.samples as u32,
            model: jet.model,
            condition: jet.condition,
            surroundings,
        }
    }
}

/// The tangent plane: z changes by slope · (x, y), an area of it is `secant` times its projection.
struct Tangent {
    slope: [f64; 2],
    secant: f64,
    curvatures_per_mm: [f64; 2],
    /// x and y of the unit vectors along which these are.
    along: [[f64; 2]; 2],
}

impl Tangent {
    /// The principal curvatures are the eigenvalues of the second fundamental form H / s relative to
    /// the first, 1 + g gᵀ, with the slope g, s² = 1 + g² and the second derivatives H (M. do Carmo,
    /// Differential Geometry of Curves and Surfaces, 1976, section 3-3). In coordinates along the
    /// slope and across, the former divided by s, the first form is the unit matrix.
    fn of(jet: &Jet) -> Tangent {
        let [_, gx, gy, xx, xy, yy] = jet.terms;
        let steepness = gx.hypot(gy);
        let secant = steepness.hypot(1.0);
        let [cos, sin] =
            if steepness > 0.0 { [gx / steepness, gy / steepness] } else { [1.0, 0.0] };
        let along = (cos * cos * xx + 2.0 * cos * sin * xy + sin * sin * yy) / secant.powi(3);
        let mixed = (cos * sin * (yy - xx) + (cos * cos - sin * sin) * xy) / secant.powi(2);
        let across = (sin * sin * xx - 2.0 * cos * sin * xy + cos * cos * yy) / secant;
        let (mean, half) = (0.5 * (along + across), 0.5 * (along - across));
        let apart = half.hypot(mixed);
        // Twice the angle of the larger curvature's direction against that of the slope.
        let (sin_turn, cos_turn) = (0.5 * mixed.atan2(half)).sin_cos();
        let in_plane = |p: f64, q: f64| [cos * p / secant - sin * q, sin * p / secant + cos * q];
        Tangent {
            slope: [gx, gy],
            secant,
            curvatures_per_mm: [mean + apart, mean - apart],
            along: [in_plane(cos_turn, sin_turn), in_plane(-sin_turn, cos_turn)],
        }
    }

    /// By first-order perturbation: with vectors v, w of the eigenvectors, the element v·w of the
    /// curvature tensor changes by vᵀ d(H/s) w, less the mean of the two curvatures times vᵀ d(g gᵀ) w.
    fn weights(&self, first: usize, second: usize) -> [f64; 6] {
        let ([vx, vy], [wx, wy]) = (self.along[first], self.along[second]);
        let [gx, gy] = self.slope;
        let curvature = 0.5 * (self.curvatures_per_mm[first] + self.curvatures_per_mm[second]);
        let (rise_v, rise_w) = (vx * gx + vy * gy, wx * gx + wy * gy);
        // The change of 1/s acts on vᵀ H w / s, which is zero for different eigenvectors.
        let shared = if first == second { curvature / (self.secant * self.secant) } else { 0.0 };
        [
            0.0,
            -shared * gx - curvature * (vx * rise_w + rise_v * wx),
            -shared * gy - curvature * (vy * rise_w + rise_v * wy),
            vx * wx / self.secant,
            (vx * wy + vy * wx) / self.secant,
            vy * wy / self.secant,
        ]
    }

    /// How much the normal tilts towards a principal direction for a change of the slopes.
    fn tilt(&self, direction: usize) -> [f64; 6] {
        let [x, y] = self.along[direction].map(|part| -part / self.secant);
        [0.0, x, y, 0.0, 0.0, 0.0]
    }

    fn uncertainty(&self, jet: &Jet, noise: Noise) -> ShapeUncertainty {
        let sigma_mm = noise.along_z_mm(1.0 / self.secant);
        let variance = sigma_mm * sigma_mm;
        let [larger, smaller, mixed] = [(0, 0), (1, 1), (0, 1)].map(|(i, j)| self.weights(i, j));
        let tilts = [0, 1].map(|direction| self.tilt(direction));
        let deviation = |weights: &[f64; 6]| sigma_mm * jet.variance(weights).sqrt();
        // Half the difference of the curvatures is the length of a vector of two components, whose
        // mean square noise enlarges by the variances of both; the one across lengthens it.
        let across = deviation(&mixed);
        let along = deviation(&sum(&larger, 0.5, &smaller, -0.5));
        let apart = 0.5 * (self.curvatures_per_mm[0] - self.curvatures_per_mm[1]);
        let without_noise = (apart * apart - across * across - along * along).max(0.0).sqrt();
        let driven = without_noise.hypot(across) - without_noise;
        let [first, second] = self.curvatures_per_mm;
        ShapeUncertainty {
            height_mm: deviation(&[1.0, 0.0, 0.0, 0.0, 0.0, 0.0]),
            normal_rad: tilts.map(|tilt| deviation(&tilt)),
            normal_covariance_rad2: variance * jet.covariance(&tilts[0], &tilts[1]),
            curvatures_per_mm: [larger, smaller].map(|weights| deviation(&weights).hypot(driven)),
            mean_per_mm: deviation(&sum(&larger, 0.5, &smaller, 0.5)),
            gaussian_per_mm2: deviation(&sum(&larger, second, &smaller, first)),
            curvature_covariance_per_mm2: variance * jet.covariance(&larger, &smaller),
            direction_rad: (without_noise > 0.0).then(|| across / (2.0 * without_noise)),
        }
    }
}

fn sum(left: &[f64; 6], times: f64, right: &[f64; 6], times_right: f64) -> [f64; 6] {
    std::array::from_fn(|i| times * left[i] + times_right * right[i])
}
