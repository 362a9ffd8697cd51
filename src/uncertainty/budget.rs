//! What is known of the errors of the points before they are looked at.

use thiserror::Error;

/// The sources of error of the points.
///
/// A source that is left out counts as zero, and the uncertainties are those of the sources named.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Budget {
    /// The part that differs from point to point.
    pub noise: Noise,
    /// How many points share their noise with a point, itself included: 2π·ℓ² times the points on a unit of area, for a correlation
    /// exp(−h²/(2ℓ²)) over a few point distances. 1 or less: none does. It widens the interval of the RMS; what such noise does to the
    /// pose is to be a long wave.
    pub noise_shared_by: f64,
    /// Parts that change slowly over the surface: drift, guide ways, reference artefact, air.
    pub long_waves: Vec<LongWave>,
    /// Errors of the machine that displace every point in proportion to its coordinates.
    pub effects: Vec<Effect>,
}

/// The part of the error along the normal that is independent from point to point.
#[derive(Clone, Debug, Default, PartialEq)]
pub enum Noise {
    /// Measured by the scatter of neighbouring points about what is smooth in them.
    #[default]
    Measured,
    /// One standard uncertainty for all points.
    Uniform {
        /// The standard uncertainty in mm, not below 0.
        sigma_mm: f64,
        /// Degrees of freedom it is known with, above 0; infinite if it is certain.
        dof: f64,
    },
    /// One standard uncertainty for each point given, in mm, those left out included.
    EachPoint(Vec<f64>),
}

/// How the correlation of a long-wave error falls with the distance h of two places.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kernel {
    /// exp(−h²/(2ℓ²)): smooth errors.
    Gaussian,
    /// (1 + h/ℓ)·exp(−h/ℓ), Matérn's with ν = 3/2: errors with a slope but no curvature, as polished form has.
    Matern,
    /// exp(−h/ℓ): errors that wander, as those of a drift scanned line by line.
    Exponential,
}

impl Kernel {
    /// Its name: `gaussian`, `matern` or `exponential`.
    pub const fn name(self) -> &'static str {
        match self {
            Kernel::Gaussian => "gaussian",
            Kernel::Matern => "matern",
            Kernel::Exponential => "exponential",
        }
    }

    /// The correlation at a distance of `h` correlation lengths.
    pub(crate) fn correlation(self, h: f64) -> f64 {
        match self {
            Kernel::Gaussian => (-0.5 * h * h).exp(),
            Kernel::Matern => (1.0 + h) * (-h).exp(),
            Kernel::Exponential => (-h).exp(),
        }
    }
}

/// An error along the normal that is correlated over the surface: a random function of zero mean, the same
/// everywhere and in every direction, over the x-y plane of the part frame.
///
/// Its value is another in the next measurement. Taking it for independent noise makes the uncertainties of
/// the pose too small by a factor of 2 to 4 (Forbes, Metrologia 43 (2006) S282).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LongWave {
    /// Standard deviation at one place in mm, not below 0.
    pub sigma_mm: f64,
    /// Correlation length ℓ in mm, above 0.
    pub length_mm: f64,
    /// How the correlation falls.
    pub kernel: Kernel,
    /// Degrees of freedom `sigma_mm` is known with, above 0; infinite if it is certain.
    pub dof: f64,
}

/// An error of the machine that displaces the point p by `displacement`·(p − `about_mm`), both in the
/// measured frame.
#[derive(Clone, Debug, PartialEq)]
pub struct Effect {
    /// Name in reports.
    pub name: String,
    /// Displacement in mm a mm of coordinate, row after row, for one standard uncertainty of the effect.
    pub displacement: [[f64; 3]; 3],
    /// The place that stays, in mm.
    pub about_mm: [f64; 3],
    /// Degrees of freedom, above 0; infinite if the standard uncertainty is certain.
    pub dof: f64,
}

impl Effect {
    /// The scale of one axis (0, 1, 2 for x, y, z), with its relative standard uncertainty.
    ///
    /// Panics if there is no such axis.
    pub fn scale(axis: usize, u: f64) -> Effect {
        let mut displacement = [[0.0; 3]; 3];
        displacement[axis][axis] = u;
        Effect::new(format!("scale of {}", AXES[axis]), displacement)
    }

    /// The thermal expansion of the part against the machine: coefficient in 1/K times standard uncertainty
    /// of the temperature in K.
    pub fn thermal(coefficient_per_k: f64, u_k: f64) -> Effect {
        let u = coefficient_per_k * u_k;
        Effect::new("thermal expansion".to_owned(), [[u, 0.0, 0.0], [0.0, u, 0.0], [0.0, 0.0, u]])
    }

    /// The angle between two axes (0, 1, 2), with its standard uncertainty in rad: motion along `second`
    /// also moves along `first`.
    ///
    /// Panics if there is no such axis.
    pub fn squareness(first: usize, second: usize, u_rad: f64) -> Effect {
        let mut displacement = [[0.0; 3]; 3];
        displacement[first][second] = u_rad;
        Effect::new(format!("squareness of {} and {}", AXES[first], AXES[second]), displacement)
    }

    fn new(name: String, displacement: [[f64; 3]; 3]) -> Effect {
        Effect { name, displacement, about_mm: [0.0; 3], dof: f64::INFINITY }
    }

    /// The displacement of a point in mm.
    pub(crate) fn at(&self, measured_mm: [f64; 3]) -> [f64; 3] {
        let from: [f64; 3] = std::array::from_fn(|axis| measured_mm[axis] - self.about_mm[axis]);
        self.displacement.map(|row| row[0] * from[0] + row[1] * from[1] + row[2] * from[2])
    }
}

/// Why a budget is refused, or does not go with a fit.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum UncertaintyError {
    /// A number out of its range.
    #[error("{name} is {found}, expected {expected}")]
    Number {
        /// Which.
        name: &'static str,
        /// The number.
        found: f64,
        /// Allowed values.
        expected: &'static str,
    },
    /// Not one uncertainty for each point.
    #[error("{found} uncertainties for {points} points, expected one for each")]
    Lengths {
        /// Points given.
        points: usize,
        /// Uncertainties given.
        found: usize,
    },
    /// Fewer points than the scatter of neighbours needs.
    #[error(
        "{used} points are too few to measure noise by, at least {needed}: state the noise instead"
    )]
    TooFewPoints {
        /// Points used.
        used: usize,
        /// How many are needed.
        needed: usize,
    },
    /// The points are not those of the fit.
    #[error(
        "the fit used {used} points, but {found} count under its pose: give the points, aperture and uncertainties of that fit"
    )]
    OtherPoints {
        /// Points that count.
        found: usize,
        /// Points the fit used.
        used: usize,
    },
    /// The fit left nothing to judge by.
    #[error("{used} points determine {parameters} parameters and no deviation")]
    NoFreedom {
        /// Points used.
        used: usize,
        /// Parameters estimated.
        parameters: usize,
    },
}

impl Budget {
    /// Fails unless every number is in its range and there is one uncertainty for each of `points` points,
    /// if there are any.
    pub fn validate(&self, points: usize) -> Result<(), UncertaintyError> {
        match &self.noise {
            Noise::Measured => {}
            Noise::Uniform { sigma_mm, dof } => {
                not_negative("standard uncertainty of the noise in mm", *sigma_mm)?;
                freedom(*dof)?;
            }
            Noise::EachPoint(sigma_mm) => {
                if sigma_mm.len() != points {
                    return Err(UncertaintyError::Lengths { points, found: sigma_mm.len() });
                }
                for sigma_mm in sigma_mm {
                    not_negative("standard uncertainty of a point in mm", *sigma_mm)?;
                }
            }
        }
        for wave in &self.long_waves {
            not_negative("standard deviation of a long-wave error in mm", wave.sigma_mm)?;
            let length = wave.length_mm;
            check(
                "correlation length in mm",
                length,
                length > 0.0 && length.is_finite(),
                POSITIVE,
            )?;
            freedom(wave.dof)?;
        }
        for effect in &self.effects {
            freedom(effect.dof)?;
            for number in effect.displacement.iter().flatten().chain(&effect.about_mm) {
                check("entry of an effect", *number, number.is_finite(), "a finite number")?;
            }
        }
        Ok(())
    }
}

fn not_negative(name: &'static str, found: f64) -> Result<(), UncertaintyError> {
    check(name, found, found.is_finite() && found >= 0.0, "a finite number not below 0")
}

fn freedom(dof: f64) -> Result<(), UncertaintyError> {
    check("number of degrees of freedom", dof, dof > 0.0, POSITIVE)
}

/// Fails unless `valid`.
pub(crate) fn check(
    name: &'static str,
    found: f64,
    valid: bool,
    expected: &'static str,
) -> Result<(), UncertaintyError> {
    if valid { Ok(()) } else { Err(UncertaintyError::Number { name, found, expected }) }
}

const POSITIVE: &str = "a number above 0";
const AXES: [&str; 3] = ["x", "y", "z"];

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn impossible_budgets_are_refused_by_name() {
        let wave = |sigma_mm, length_mm, dof| Budget {
            long_waves: vec![LongWave { sigma_mm, length_mm, kernel: Kernel::Gaussian, dof }],
            ..Budget::default()
        };
        assert_eq!(wave(0.0, 1.0, f64::INFINITY).validate(3), Ok(()));
        for bad in [wave(-1.0, 1.0, 1.0), wave(1.0, 0.0, 1.0), wave(1.0, 1.0, f64::NAN)] {
            assert!(matches!(bad.validate(3), Err(UncertaintyError::Number { .. })));
        }
        let each = |sigma_mm: &[f64]| {
            Budget { noise: Noise::EachPoint(sigma_mm.to_vec()), ..Budget::default() }.validate(2)
        };
        assert_eq!(each(&[1.0]), Err(UncertaintyError::Lengths { points: 2, found: 1 }));
        assert!(each(&[1.0, f64::INFINITY]).is_err() && each(&[1.0, 0.0]).is_ok());
    }

    #[test]
    fn effects_displace_as_named() {
        let point = [3.0, 5.0, 7.0];
        assert_eq!(Effect::scale(1, 0.5).at(point), [0.0, 2.5, 0.0]);
        assert_eq!(Effect::squareness(0, 2, 0.5).at(point), [3.5, 0.0, 0.0]);
        let warm = Effect { about_mm: [3.0, 0.0, 0.0], ..Effect::thermal(0.25, 2.0) };
        assert_eq!(warm.at(point), [0.0, 2.5, 3.5]);
    }
}
