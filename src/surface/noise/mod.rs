//! The noise of the heights: how large it is, what it does to facets, and how dense samples may be.
//!
//! [`estimate_noise`] and [`noise_map`] find the noise from the points alone; [`facet_tilt_rad`] is
//! what it does to a triangle, and [`assess_spacing`] says where the samples are denser than it
//! allows, and which spacing would satisfy noise and sampling condition.

mod cells;
mod estimate;
mod facet;
mod packed;
mod residuals;
mod spacing;
mod steps;
#[cfg(test)]
mod tests;

use thiserror::Error;

pub use self::cells::{NoiseMap, noise_map};
pub use self::estimate::{
    NoiseEstimate, NoiseSettings, NoiseSettingsError, NoiseUnknown, UnevenNoise, estimate_noise,
    estimate_noise_about,
};
pub use self::facet::facet_tilt_rad;
pub(crate) use self::spacing::truest_mm;
pub use self::spacing::{Advice, Spacing, SpacingCriteria, SpacingCriteriaError, assess_spacing};
pub use self::steps::{HeightSteps, edges_of, height_steps, step_sigma_mm};

/// Along which direction the measured points deviate.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Along {
    /// Along z, as with a probe on a fixed axis.
    #[default]
    Z,
    /// Along the normal of the surface, as with a probe that is turned towards it.
    Normal,
}

/// White noise: deviations of single points, independent of each other.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Noise {
    sigma_mm: f64,
    along: Along,
}

/// A standard deviation that is none.
#[derive(Clone, Copy, Debug, PartialEq, Error)]
#[error("noise of {sigma_mm} mm is not finite and at least 0")]
pub struct NoiseError {
    /// What was given, in mm.
    pub sigma_mm: f64,
}

impl Noise {
    /// Noise of standard deviation `sigma_mm` in mm.
    pub fn new(sigma_mm: f64, along: Along) -> Result<Noise, NoiseError> {
        if sigma_mm >= 0.0 && sigma_mm.is_finite() {
            Ok(Noise { sigma_mm, along })
        } else {
            Err(NoiseError { sigma_mm })
        }
    }

    /// Its standard deviation in mm.
    pub fn sigma_mm(&self) -> f64 {
        self.sigma_mm
    }

    /// The direction of the deviations.
    pub fn along(&self) -> Along {
        self.along
    }

    /// Standard deviation along z in mm where the unit normal has the z component `cosine`.
    ///
    /// A point moved by δ along the normal lies δ / cosine above the tangent plane along z.
    pub(crate) fn along_z_mm(&self, cosine: f64) -> f64 {
        match self.along {
            Along::Z => self.sigma_mm,
            Along::Normal => self.sigma_mm / cosine,
        }
    }

    /// Standard deviation along the normal in mm, the other way round.
    pub(crate) fn along_normal_mm(&self, cosine: f64) -> f64 {
        match self.along {
            Along::Z => self.sigma_mm * cosine,
            Along::Normal => self.sigma_mm,
        }
    }
}
