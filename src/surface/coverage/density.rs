//! Whether samples are denser than their noise allows.
//!
//! The conditions and the advice are those of [`crate::noise::assess_spacing`], found in the same pass
//! over the triangles as the coverage and for one noise all over.

use super::spread::spread;
use crate::noise::{Advice, Noise, SpacingCriteria};
use crate::triangle::Triangle;

/// The noise of the heights, where it is known, and what is asked for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Density {
    /// The noise everywhere; none if it is not known.
    pub noise: Option<Noise>,
    /// The limits of ε and of the tilt of facets by noise.
    pub criteria: SpacingCriteria,
}

impl Density {
    /// By what angle in rad noise turns a facet of this area in space, root mean square: see
    /// [`crate::noise::facet_tilt_rad`]. Also the noise along its normal.
    pub(super) fn tilt_rad(&self, triangle: &Triangle, area_mm2: f64) -> Option<[f64; 2]> {
        let cosine = triangle.projected_area_mm2().abs() / area_mm2;
        let sigma_mm = self.noise?.along_normal_mm(cosine);
        Some([sigma_mm * triangle.squares_mm2().sqrt() / (2.0 * area_mm2), sigma_mm])
    }
}

/// How dense samples are for their noise, over the facets inside the aperture that bridge nothing.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Dense {
    /// Half of the area has facets of this spacing in mm or less: the side of a square of which the
    /// facet is half.
    pub spacing_median_mm: Option<f64>,
    /// Share of the area whose facets noise turns by more than the limit: where samples are denser than
    /// it allows. None where the noise is not known.
    pub overdense_fraction: Option<f64>,
    /// The one spacing for all of the surface: for the largest noise along a normal and the smallest local
    /// feature size. None where one of them is not known.
    pub advice: Option<Advice>,
}

/// What the figures are made of, besides the areas of facets.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Crumpled {
    pub(super) area_mm2: f64,
    pub(super) overdense_mm2: f64,
    /// The largest noise along a normal.
    pub(super) loudest_mm: Option<f64>,
}

impl Crumpled {
    pub(super) fn dense(
        &self,
        density: &Density,
        facets_mm2: &[f64],
        lfs_min_mm: Option<f64>,
    ) -> Dense {
        let median_mm2 = spread(facets_mm2, facets_mm2).map(|spread| spread.median);
        let known = self.loudest_mm.filter(|_| self.area_mm2 > 0.0);
        Dense {
            spacing_median_mm: median_mm2.map(|area_mm2| (2.0 * area_mm2).sqrt()),
            overdense_fraction: known.map(|_| self.overdense_mm2 / self.area_mm2),
            advice: known
                .zip(lfs_min_mm)
                .and_then(|(sigma_mm, lfs_min_mm)| density.criteria.advice(sigma_mm, lfs_min_mm)),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::noise::{Along, facet_tilt_rad};

    #[test]
    fn facets_tilt_as_they_do_one_by_one() {
        let corners = [[0.0, 0.0, 0.1], [0.3, 0.05, 0.4], [0.1, 0.2, -0.3]];
        for along in [Along::Z, Along::Normal] {
            let noise = Noise::new(1e-3, along).unwrap();
            let criteria = SpacingCriteria::new(0.05, None).unwrap();
            let density = Density { noise: Some(noise), criteria };
            let triangle = Triangle::new(&corners, [0, 1, 2]);
            let [tilt_rad, _] = density.tilt_rad(&triangle, triangle.area_mm2()).unwrap();
            let expected_rad = facet_tilt_rad(corners, noise).unwrap();
            assert!((tilt_rad / expected_rad - 1.0).abs() < 1e-12);
        }
    }
}
