//! Whether samples are denser than their noise allows.
//!
//! The conditions and the advice are those of [`crate::noise::assess_spacing`], found in the same pass
//! over the triangles as the coverage and for one noise all over.

use asphera_geometry::{Sum, Triangle, greater};

use super::block::{BLOCK, Block, Row, largest, total};
use crate::noise::{Advice, Noise, SpacingCriteria};

/// The noise of the heights, where it is known, and what is asked for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Density {
    /// The noise everywhere; none if it is not known.
    pub noise: Option<Noise>,
    /// The limits of ε and of the tilt of facets by noise. Where the target is one of ρ, ε is to be the smaller of
    /// both.
    pub criteria: SpacingCriteria,
}

/// Facets as noise turns them.
#[derive(Clone, Copy)]
pub(super) struct Crumpling {
    noise: Noise,
    /// The square of twice the largest tilt.
    limit: f64,
    /// The area in space of those turned too far.
    pub(super) overdense: Sum,
    /// The largest noise along a normal in mm.
    pub(super) loudest_mm: f64,
}

impl Crumpling {
    /// Of no facet yet; `None` if the noise is not known.
    pub(super) fn new(density: &Density) -> Option<Crumpling> {
        let limit = 2.0 * density.criteria.tilt_limit_rad();
        Some(Crumpling {
            noise: density.noise?,
            limit: limit * limit,
            overdense: Sum::default(),
            loudest_mm: 0.0,
        })
    }

    /// Takes in a facet. It is turned too far if [`crate::noise::facet_tilt_rad`] is above the limit; the squares
    /// of both are compared, which spares a root.
    #[inline(always)]
    pub(super) fn add(&mut self, facet: &Facet) {
        let sigma_mm = self.noise.along_normal_mm(facet.projected_mm2 / facet.area_mm2);
        let limit_mm4 = self.limit * facet.area_mm2 * facet.area_mm2;
        if sigma_mm * sigma_mm * facet.squares_mm2 > limit_mm4 {
            self.overdense.add(facet.area_mm2);
        }
        self.loudest_mm = greater(sigma_mm, self.loudest_mm);
    }

    /// Takes in all facets of a block that count.
    pub(super) fn add_block(&mut self, block: &Block) {
        let Block { area_mm2, projected_mm2, squares_mm2, .. } = block;
        let mut sigmas_mm: Row = [0.0; BLOCK];
        for (row, sigma_mm) in sigmas_mm.iter_mut().enumerate() {
            // What does not count has no area: NaN.
            *sigma_mm = self.noise.along_normal_mm(projected_mm2[row] / area_mm2[row]);
        }
        let overdense_mm2 = total(|row| {
            let limit_mm4 = self.limit * area_mm2[row] * area_mm2[row];
            let square_mm4 = sigmas_mm[row] * sigmas_mm[row] * squares_mm2[row];
            if square_mm4 > limit_mm4 { area_mm2[row] } else { 0.0 }
        });
        self.overdense.add(overdense_mm2);
        self.loudest_mm = greater(largest(&sigmas_mm), self.loudest_mm);
    }
}

/// What decides how far noise turns a facet.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Facet {
    /// Area in space in mm².
    pub(super) area_mm2: f64,
    /// Area of the projection in mm².
    pub(super) projected_mm2: f64,
    /// Sum of the squares of its sides in mm².
    pub(super) squares_mm2: f64,
}

impl Facet {
    pub(super) fn of(triangle: &Triangle) -> Facet {
        Facet {
            area_mm2: triangle.area_mm2(),
            projected_mm2: triangle.projected_area_mm2().abs(),
            squares_mm2: triangle.squares_mm2(),
        }
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
    /// feature size, or, where the target asks for more, the reach. None where one of them is not known.
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
        median_mm2: Option<f64>,
        lfs_min_mm: Option<f64>,
    ) -> Dense {
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
            let triangle = Triangle::new(&corners, [0, 1, 2]);
            let expected_rad = facet_tilt_rad(corners, noise).unwrap();
            for (factor, expected) in [(1.0 - 1e-12, true), (1.0 + 1e-12, false)] {
                let criteria = SpacingCriteria::new(0.05, Some(factor * expected_rad)).unwrap();
                let density = Density { noise: Some(noise), criteria };
                let mut crumpling = Crumpling::new(&density).unwrap();
                crumpling.add(&Facet::of(&triangle));
                assert_eq!(crumpling.overdense.total() > 0.0, expected, "{factor}");
            }
        }
    }
}
