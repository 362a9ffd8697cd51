//! What errors of grey values do to the points of a face.

use std::f64::consts::TAU;

use asphera_measure::Part;
use asphera_uncertainty::{Budget, Draws, Kernel, LongWave, Noise};

use crate::edge::Edge;

/// Standard uncertainties of the points of a face along its normal.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Errors {
    /// By the threshold: the whole face moves, mm.
    pub(crate) shift_mm: f64,
    /// By levels that differ over the face, mm, and the width over which they do.
    pub(crate) uneven_mm: f64,
    pub(crate) uneven_length_mm: f64,
    /// By noise, mm, with what the correction for blur adds to it.
    pub(crate) noise_mm: f64,
    /// The same without that, and its correlation length: its waves are longer than those that the correction looks at.
    pub(crate) grey_noise_mm: f64,
    pub(crate) noise_length_mm: f64,
    /// Points on a mm².
    density_per_mm2: f64,
}

impl Errors {
    /// From the edge, the standard uncertainty of the threshold, the points on a mm², and the growth of the noise's variance by the
    /// correction for blur.
    pub(crate) fn new(
        edge: &Edge,
        u_threshold: f64,
        density_per_mm2: f64,
        noise_gain: f64,
    ) -> Errors {
        let grey_noise_mm = edge.noise / edge.slope_per_mm;
        Errors {
            shift_mm: u_threshold / edge.slope_per_mm,
            uneven_mm: edge.uneven / edge.slope_per_mm,
            uneven_length_mm: edge.patch_mm,
            noise_mm: grey_noise_mm * noise_gain.sqrt(),
            grey_noise_mm,
            noise_length_mm: edge.noise_length_mm,
            density_per_mm2,
        }
    }

    /// Adds them to the budget of a part, for a face of the width `across_mm`. A noise that the nominal file states stays.
    ///
    /// The field of a long wave has few functions, so the noise of blurred values, which is correlated over a few spacings, is
    /// parted. A wave of a length that they can follow has its spectral density at long wavelengths, 2π·σ²·ℓ², which is what moves a
    /// fit, less that of independent noise, σ² over the points on a mm². The rest of the variance is that of each point, and as many
    /// points share it as give the same spectral density.
    pub(crate) fn add_to(&self, part: &mut Part, across_mm: f64) {
        let wave = |sigma_mm: f64, length_mm: f64| LongWave {
            sigma_mm,
            length_mm,
            kernel: Kernel::Gaussian,
            dof: f64::INFINITY,
        };
        let length_mm = self.noise_length_mm.max(across_mm / FOLLOWED);
        let density_mm2 = TAU * self.noise_length_mm.powi(2) - self.density_per_mm2.recip();
        let smooth_mm = self.grey_noise_mm * (density_mm2.max(0.0) / TAU).sqrt() / length_mm;
        let rest_mm2 = (self.noise_mm.powi(2) - smooth_mm.powi(2)).max(0.0);
        let draws = Draws { count: DRAWS, seed: 0 };
        let stated = part.judging.uncertainty.take();
        let (mut budget, draws) = stated.unwrap_or((Budget::default(), draws));
        budget.long_waves.extend([
            wave(self.shift_mm, WHOLE * across_mm),
            wave(self.uneven_mm, self.uneven_length_mm),
        ]);
        if budget.noise == Noise::Measured {
            let sigma_mm = rest_mm2.sqrt();
            let density_mm4 = TAU * (self.grey_noise_mm * self.noise_length_mm).powi(2);
            if rest_mm2 > 0.0 {
                budget.noise_shared_by = density_mm4 * self.density_per_mm2 / rest_mm2;
            }
            budget.noise = Noise::Uniform { sigma_mm, dof: f64::INFINITY };
            budget.long_waves.push(wave(smooth_mm, length_mm));
        }
        budget.long_waves.retain(|wave| wave.sigma_mm > 0.0);
        part.judging.uncertainty = Some((budget, draws));
    }
}

/// A wave this many times as long as the face is the same all over it.
const WHOLE: f64 = 100.0;
/// The shortest wave that a field follows, as a share of the face.
const FOLLOWED: f64 = 10.0;
/// As of nominal files: tells a standard uncertainty to 5 %.
const DRAWS: u32 = 200;
