//! The circle through a profile.
//!
//! Distances are those to the circle, in the plane of arc position and height. A shallow arc has a
//! centre far away that it hardly determines, and a straight profile has none. So the circle is not
//! told by its centre and radius but by its curvature κ, its direction θ and its distance c from the
//! middle of the profile: with
//!
//! ```text
//! F(u, v) = κ/2·(u² + v²) + m·(u·sin θ - v·cos θ) + c,    m² = 1 + 2κc,
//! ```
//!
//! F = 0 is the circle, and d = 2F / (1 + √(1 + 2κF)) the distance from it, since F = d + κd²/2.
//! With κ = 0 it is a line. The parameters are of the kind of V. Karimäki, Nucl. Instrum. Meth. A 305
//! (1991) 187-191, doi:10.1016/0168-9002(91)90533-V; the constraint on m is V. Pratt's (SIGGRAPH 1987,
//! doi:10.1145/37402.37420). They are found by Gauss's and Newton's iteration, from the circle that
//! makes F small where its direction is that of u.

use nalgebra::DVector;

use super::normal_equations::{NormalEquations, Solution, ensure_enough};
use super::profile::{Profile, ProfileError};

/// A circle fitted to a profile by orthogonal least squares over the arc position.
///
/// Uncertainties are standard ones for noise of the vertices that is independent and of one size,
/// as large as what the fit leaves tells.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CircleFit {
    /// Curvature in 1/mm; positive where the profile bends upwards, as a hollow does.
    pub curvature_per_mm: f64,
    /// Its standard uncertainty in 1/mm; none where a fit can leave nothing.
    pub u_curvature_per_mm: Option<f64>,
    /// Root of the mean square of the distances from the circle in mm.
    pub rms_mm: f64,
    circle: Circle,
}

/// θ is small unless the profile is tilted much.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Circle {
    /// The place in the profile from which u and v are counted: arc position and value in mm.
    origin_mm: [f64; 2],
    curvature_per_mm: f64,
    direction_rad: f64,
    c_mm: f64,
}

impl Profile {
    /// The circle that fits best. Takes some passes over the samples.
    ///
    /// # Errors
    ///
    /// If the profile comes from no more than three vertices, does not determine a circle, or the
    /// iteration does not converge, as for profiles that are not near any circle.
    pub fn circle(&self) -> Result<CircleFit, ProfileError> {
        let length_mm = ensure_enough(self, 3)?;
        let mean = |of: fn(&super::Sample) -> f64| {
            self.samples().iter().map(|sample| sample.length_mm * of(sample)).sum::<f64>()
                / length_mm
        };
        let origin_mm = [mean(|sample| sample.s_mm), mean(|sample| sample.value_mm)];
        let [low, high] = self.extent_mm();
        let reach_mm = high - low;
        let mut circle = self.first_circle(origin_mm, reach_mm)?;
        for _ in 0..MOST_STEPS {
            let (solution, squares) = self.step(&circle, reach_mm)?;
            let step = &solution.parameters;
            circle.curvature_per_mm -= step[0] / reach_mm;
            circle.direction_rad -= step[1];
            circle.c_mm -= step[2] * reach_mm;
            // Beyond, the place from which it is told would lie on the far side of the centre.
            let squared = 1.0 + 2.0 * circle.curvature_per_mm * circle.c_mm;
            if squared.is_nan() || squared <= 0.0 {
                break;
            }
            if step.amax() <= STEP_LEFT {
                return Ok(CircleFit {
                    curvature_per_mm: circle.curvature_per_mm,
                    u_curvature_per_mm: solution.uncertainty(0, squares).map(|u| u / reach_mm),
                    rms_mm: (squares * reach_mm * reach_mm / length_mm).sqrt(),
                    circle,
                });
            }
        }
        Err(ProfileError::NotConverged { steps: MOST_STEPS })
    }

    /// The circle that makes κ/2·(u² + v²) + a·u - v + c small.
    fn first_circle(&self, origin_mm: [f64; 2], reach_mm: f64) -> Result<Circle, ProfileError> {
        let mut sums = NormalEquations::new(3);
        for (sample, source) in self.samples().iter().zip(self.sources()) {
            let u = (sample.s_mm - origin_mm[0]) / reach_mm;
            let v = (sample.value_mm - origin_mm[1]) / reach_mm;
            let row = DVector::from_row_slice(&[(u * u + v * v) / 2.0, u, 1.0]);
            sums.add(sample.length_mm, &row, v, source, 1.0);
        }
        let parameters = sums.solve()?.parameters;
        let [curvature, a, c] = [0, 1, 2].map(|index| parameters[index]);
        // Divided by the length of the gradient on the circle.
        let squared = a * a + 1.0 - 2.0 * curvature * c;
        if squared.is_nan() || squared <= 0.0 {
            return Err(ProfileError::Indeterminate { parameters: 3 });
        }
        let scale = squared.sqrt();
        Ok(Circle {
            origin_mm,
            curvature_per_mm: curvature / scale / reach_mm,
            direction_rad: a.atan2(1.0),
            c_mm: c / scale * reach_mm,
        })
    }

    /// The step to be taken back, in parameters without a unit, and the sum of squares before, all
    /// in units of `reach_mm`.
    fn step(&self, circle: &Circle, reach_mm: f64) -> Result<(Solution, f64), ProfileError> {
        let mut sums = NormalEquations::new(3);
        for (sample, source) in self.samples().iter().zip(self.sources()) {
            let Distance { d, row, per_value } =
                circle.distance([sample.s_mm, sample.value_mm], reach_mm);
            if !d.is_finite() {
                return Err(ProfileError::NotConverged { steps: MOST_STEPS });
            }
            sums.add(sample.length_mm, &row, d, source, per_value);
        }
        Ok((sums.solve()?, sums.squares()))
    }
}

/// The distance of a place from the circle, in units of the reach.
struct Distance {
    d: f64,
    /// Its derivatives by κ, θ and c, without a unit.
    row: DVector<f64>,
    /// Its derivative by the value.
    per_value: f64,
}

impl Circle {
    fn distance(&self, [s_mm, value_mm]: [f64; 2], reach_mm: f64) -> Distance {
        let [u, v] =
            [(s_mm - self.origin_mm[0]) / reach_mm, (value_mm - self.origin_mm[1]) / reach_mm];
        let (curvature, c) = (self.curvature_per_mm * reach_mm, self.c_mm / reach_mm);
        let m = (1.0 + 2.0 * curvature * c).sqrt();
        let (sin, cos) = self.direction_rad.sin_cos();
        let across = u * sin - v * cos;
        let f = curvature / 2.0 * (u * u + v * v) + m * across + c;
        let gradient = (1.0 + 2.0 * curvature * f).sqrt();
        let d = 2.0 * f / (1.0 + gradient);
        let row = DVector::from_row_slice(&[
            (u * u + v * v) / 2.0 + across * c / m - d * d / 2.0,
            m * (u * cos + v * sin),
            1.0 + across * curvature / m,
        ]) / gradient;
        Distance { d, row, per_value: (curvature * v - m * cos) / gradient }
    }
}

impl CircleFit {
    /// The radius in mm with its standard uncertainty in mm; its sign is that of the curvature.
    /// None if the curvature is not told from zero: if it is below three times its uncertainty, or
    /// that is not known.
    pub fn radius_mm(&self) -> Option<(f64, f64)> {
        let (curvature, u) = (self.curvature_per_mm, self.u_curvature_per_mm?);
        let radius_mm = 1.0 / curvature;
        (curvature.abs() > 3.0 * u && radius_mm.is_finite())
            .then_some((radius_mm, u * radius_mm * radius_mm))
    }

    /// The centre: arc position and height in mm. None as the radius.
    pub fn centre_mm(&self) -> Option<[f64; 2]> {
        self.radius_mm()?;
        let Circle { origin_mm, curvature_per_mm, direction_rad, c_mm } = self.circle;
        // Where the gradient of F vanishes.
        let m = (1.0 + 2.0 * curvature_per_mm * c_mm).sqrt() / curvature_per_mm;
        let (sin, cos) = direction_rad.sin_cos();
        Some([origin_mm[0] - m * sin, origin_mm[1] + m * cos])
    }

    /// What it leaves of a profile: the distances from the circle, positive above it.
    pub fn residual(&self, profile: &Profile) -> Profile {
        // F falls upwards.
        profile.map(|sample| -self.circle.distance([sample.s_mm, sample.value_mm], 1.0).d)
    }
}

/// As a rule three or four are made.
const MOST_STEPS: usize = 50;
/// A step of so little, measured in lengths of the profile, ends the iteration.
const STEP_LEFT: f64 = 1e-13;
