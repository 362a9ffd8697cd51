//! The noise of the heights: as given, or taken from the points.

use std::str::FromStr;

use asphera_geometry::{PointMm, VertexId};
use asphera_surface::curvature::Adjacency;
use asphera_surface::noise::{
    Along, Noise as Deviation, NoiseEstimate, NoiseSettings, estimate_noise,
};

use super::figures::Noise;
use crate::cli::output::Failure;

/// Where the noise comes from.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum NoiseWanted {
    Auto,
    SigmaNm(f64),
}

impl FromStr for NoiseWanted {
    type Err = String;

    fn from_str(word: &str) -> Result<NoiseWanted, String> {
        if word == "auto" {
            return Ok(NoiseWanted::Auto);
        }
        match word.parse::<f64>() {
            Ok(sigma_nm) if (0.0..=MAX_SIGMA_NM).contains(&sigma_nm) => {
                Ok(NoiseWanted::SigmaNm(sigma_nm))
            }
            _ => Err(format!("expected a number from 0 to 1e9 in nm or `auto`, found `{word}`")),
        }
    }
}

/// The noise asked for, and how it is told.
pub(super) fn noise(
    points: &[PointMm],
    triangles: &[[VertexId; 3]],
    wanted: NoiseWanted,
    name: &str,
) -> Result<(Deviation, Noise), Failure> {
    match wanted {
        NoiseWanted::SigmaNm(sigma_nm) => {
            let deviation = Deviation::new(sigma_nm * 1e-6, Along::Z)?;
            let told = Noise {
                sigma_nm,
                source: "given",
                uncertainty_nm: None,
                residuals: None,
                outlier_share: None,
            };
            Ok((deviation, told))
        }
        NoiseWanted::Auto => {
            let reach_mm = REACH * typical_spacing_mm(points, triangles);
            let adjacency = Adjacency::new(points, triangles, Some(reach_mm))?;
            let found = estimate_noise(points, &adjacency, &NoiseSettings::default());
            let found = found.map_err(|unknown| {
                format!("{name}: the noise cannot be taken from the points: {unknown}; give it with --noise")
            })?;
            let NoiseEstimate {
                noise: deviation, uncertainty_mm, residuals, outlier_share, ..
            } = found;
            let told = Noise {
                sigma_nm: deviation.sigma_mm() * 1e6,
                source: "points",
                uncertainty_nm: Some(uncertainty_mm * 1e6),
                residuals: Some(residuals),
                outlier_share: Some(outlier_share),
            };
            Ok((deviation, told))
        }
    }
}

/// The median spacing of the places of a mesh in mm: a wrong height has no part in it, and few
/// triangles that bridge gaps little.
fn typical_spacing_mm(points: &[PointMm], triangles: &[[VertexId; 3]]) -> f64 {
    let mut spacings_mm: Vec<f64> = triangles
        .iter()
        .map(|corners| {
            let [a, b, c] = corners.map(|corner| points[corner as usize]);
            let twice_mm2 = (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
            twice_mm2.abs().sqrt()
        })
        .collect();
    let middle = spacings_mm.len() / 2;
    *spacings_mm.select_nth_unstable_by(middle, f64::total_cmp).1
}

/// How many spacings apart neighbours are at most when the noise is taken from them: lines of a scan
/// may lie farther apart than the points along them, while what bridges a gap is longer.
const REACH: f64 = 8.0;
/// A metre.
const MAX_SIGMA_NM: f64 = 1e9;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn noise_is_a_length_or_auto() {
        assert_eq!("auto".parse(), Ok(NoiseWanted::Auto));
        assert_eq!("12.5".parse(), Ok(NoiseWanted::SigmaNm(12.5)));
        assert_eq!("0".parse(), Ok(NoiseWanted::SigmaNm(0.0)));
        for word in ["-1", "NaN", "inf", "1e10", "some", ""] {
            assert!(word.parse::<NoiseWanted>().is_err(), "{word}");
        }
    }
}
