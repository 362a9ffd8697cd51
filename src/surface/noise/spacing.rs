//! Where samples are denser than their noise allows, and which spacing satisfies both conditions.
//!
//! Two conditions bound the spacing h of samples.
//!
//! **Sampling.** Every place of the surface needs a sample within ε·lfs (see `sampling.rs`). On an
//! even raster the farthest place lies h/√2 from the nearest samples, so h ≤ √2·ε·lfs.
//!
//! **Noise.** Reconstruction chooses facets by their normals: Cocone takes those that lie across the
//! direction in which a vertex' Voronoi cell is long (W. El-Hayek et al., J. Phys.: Conf. Ser. 483
//! (2014) 012003, doi:10.1088/1742-6596/483/1/012003, section 4.2). Noise σ turns a facet by 2σ/h
//! (see [`crate::noise::facet_tilt_rad`]): the denser the samples, the more. There two measured lenses could
//! not be reconstructed before they were reduced from 2,782,224 to 1,023,300 and from 1,044,336 to
//! 301,698 points, spacings 1.65 and 1.86 times as wide (section 6); a sampling condition that only
//! bounds the spacing from above cannot say why.
//!
//! *How much tilt is too much?* The normals of two places of a surface ρ·lfs apart differ by up to
//! ρ/(1 - 3ρ) rad (N. Amenta, M. Bern, Discrete & Computational Geometry 22 (1999) 481-504,
//! doi:10.1007/PL00009475, lemma 2): over a gap of ε·lfs the surface itself turns by about ε rad. So
//! much turning of the surface over a facet is what the sampling condition already admits. The
//! default lets noise have as much again: 2σ/h ≤ ε, so h ≥ 2σ/ε. Both together can be satisfied
//! while σ ≤ ε²·lfs/√2. That has the form of the condition under which surfaces can be reconstructed
//! from noisy samples, deviations up to ε²·lfs (T. K. Dey, S. Goswami, Computational Geometry 35
//! (2006) 124-141, doi:10.1016/j.comgeo.2005.10.006).
//!
//! This is the one criterion of density: a facet that noise turns by more than the limit is too small
//! for it, here and in [`crate::reduce`]. For facets of any shape the spacing has to be wider than for
//! the even raster above: see [`SpacingCriteria::packed_bound_mm`].
//!
//! **The two lenses.** By that bound the first lens, 5 mm × 5 mm in a grid of 3.00 µm, fails at its own
//! spacing and passes at 1.65 times that if the noise is above 75 and up to 124 nm; the second, a
//! spiral of 15.6 µm over a lens of 18 mm, fails and passes at 1.86 times if it is above 390 and up to
//! 726 nm (along the normal, ε = 0.05). No noise is in both intervals. The paper states neither the
//! noise nor, of the second lens, the diameter: this is what the failures imply if tilt by white
//! noise was their only cause.
//!
//! **Best.** Between these bounds lies the spacing at which facets have the truest normals: noise
//! turns them by 2σ/h, and at their corners a sphere of radius lfs is turned against them by h/(√2·lfs).
//! The sum of the squares is smallest where both are equal, at h = √(2√2·σ·lfs).

use std::f64::consts::SQRT_2;

use asphera_geometry::quantile::weighted_quantile;
use asphera_geometry::{PointMm, Sum, Triangle, VertexId};
use thiserror::Error;

use super::{Noise, facet_tilt_rad};
use crate::rim::cut_by_outline;

/// The limits of both conditions.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SpacingCriteria {
    epsilon_limit: f64,
    tilt_limit_rad: f64,
}

/// Why [`SpacingCriteria`] are not usable.
#[derive(Clone, Copy, Debug, PartialEq, Error)]
pub enum SpacingCriteriaError {
    /// The limit of ε is not positive and finite.
    #[error("limit {epsilon_limit} of ε is not finite and above 0")]
    Epsilon {
        /// The limit.
        epsilon_limit: f64,
    },
    /// The limit of the tilt is no angle between level and upright.
    #[error("limit {tilt_limit_rad} rad of the tilt is not between 0 and π/2")]
    Tilt {
        /// The limit in rad.
        tilt_limit_rad: f64,
    },
}

impl SpacingCriteria {
    /// Samples within ε times the local feature size, and facets that noise turns by at most
    /// `tilt_limit_rad`, root mean square, above 0 and below π/2; without that limit, by as much as
    /// the surface itself may turn over a gap: ε rad.
    pub fn new(
        epsilon_limit: f64,
        tilt_limit_rad: Option<f64>,
    ) -> Result<SpacingCriteria, SpacingCriteriaError> {
        if !(epsilon_limit > 0.0 && epsilon_limit.is_finite()) {
            return Err(SpacingCriteriaError::Epsilon { epsilon_limit });
        }
        let tilt_limit_rad = tilt_limit_rad.unwrap_or(epsilon_limit);
        if !(tilt_limit_rad > 0.0 && tilt_limit_rad < std::f64::consts::FRAC_PI_2) {
            return Err(SpacingCriteriaError::Tilt { tilt_limit_rad });
        }
        Ok(SpacingCriteria { epsilon_limit, tilt_limit_rad })
    }

    /// The largest ε.
    pub fn epsilon_limit(&self) -> f64 {
        self.epsilon_limit
    }

    /// The largest tilt by noise in rad.
    pub fn tilt_limit_rad(&self) -> f64 {
        self.tilt_limit_rad
    }

    /// Whether noise turns the facet of these three corners by more than the limit: the criterion of
    /// [`assess_spacing`] and of [`crate::reduce`]. `None` where the tilt is not known, as
    /// [`facet_tilt_rad`].
    pub fn is_overdense(&self, corners: [PointMm; 3], noise: Noise) -> Option<bool> {
        facet_tilt_rad(corners, noise).map(|tilt_rad| tilt_rad > self.tilt_limit_rad)
    }

    /// The spacing that satisfies both conditions where the noise along the normal is `sigma_mm` and
    /// the local feature size `lfs_mm`, both in mm, the latter infinite over a plane. Negative or NaN:
    /// of noise, nothing is advised; of a feature size, a conflict, since nothing is dense enough.
    pub fn advice(&self, sigma_mm: f64, lfs_mm: f64) -> Option<Advice> {
        if !(sigma_mm >= 0.0 && sigma_mm.is_finite()) {
            return None;
        }
        let noise_bound_mm = self.even_bound_mm(sigma_mm);
        let lfs_mm = if lfs_mm > 0.0 { lfs_mm } else { 0.0 };
        let epsilon_bound_mm = SQRT_2 * self.epsilon_limit * lfs_mm;
        Some(if noise_bound_mm > epsilon_bound_mm || epsilon_bound_mm == 0.0 {
            Advice::Conflict { noise_bound_mm, epsilon_bound_mm }
        } else if epsilon_bound_mm.is_infinite() {
            Advice::AtLeast { noise_bound_mm }
        } else {
            let recommended_mm =
                truest_mm(sigma_mm, lfs_mm).clamp(noise_bound_mm, epsilon_bound_mm);
            Advice::Between { noise_bound_mm, epsilon_bound_mm, recommended_mm }
        })
    }
}

/// The spacing in mm of an even cloud at which facets have the truest normals.
pub(crate) fn truest_mm(sigma_mm: f64, lfs_mm: f64) -> f64 {
    (2.0 * SQRT_2 * sigma_mm * lfs_mm).sqrt()
}

/// Which spacing of an even cloud satisfies both conditions.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Advice {
    /// Any from one bound to the other.
    Between {
        /// Smallest spacing in mm: below, noise turns facets too far.
        noise_bound_mm: f64,
        /// Largest spacing in mm: above, the surface bends too much between samples.
        epsilon_bound_mm: f64,
        /// The spacing in mm within the bounds at which facets have the truest normals. Without
        /// noise that is zero: the denser the better.
        recommended_mm: f64,
    },
    /// Any from this bound on: the surface is a plane.
    AtLeast {
        /// Smallest spacing in mm.
        noise_bound_mm: f64,
    },
    /// None: what noise needs is wider than what the surface allows. Only less noise helps, by repeated
    /// measurement or by averaging, or a wider limit.
    Conflict {
        /// Smallest spacing in mm that noise allows.
        noise_bound_mm: f64,
        /// Largest spacing in mm that the surface allows, perhaps 0.
        epsilon_bound_mm: f64,
    },
}

/// How dense samples are for their noise.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Spacing {
    /// Half of the area has facets of this spacing in mm or less: the side of a square of which the
    /// facet is half. `None` without area.
    pub median_mm: Option<f64>,
    /// Half of the area has facets that noise turns by this angle in rad or less, root mean square.
    /// `None` without area or where half of it has unknown noise.
    pub tilt_median_rad: Option<f64>,
    /// Area in space in mm².
    pub area_mm2: f64,
    /// Area in mm² of the facets that noise turns by more than the limit: where samples are denser
    /// than it allows. Without those of [`Spacing::outline_area_mm2`].
    pub overdense_area_mm2: f64,
    /// Area in mm² of the facets that noise turns by more than the limit for another reason: they
    /// lie along the outline, which cuts them thin however far apart the samples are.
    pub outline_area_mm2: f64,
    /// Area in mm² of the facets whose noise is not known.
    pub unknown_area_mm2: f64,
    /// The overdense area over that whose noise is known; `None` without such.
    pub overdense_fraction: Option<f64>,
    /// The one spacing for all of the surface: for its largest noise and smallest local feature
    /// size. `None` where no noise is known. Where they vary, ask [`SpacingCriteria::advice`] place
    /// by place.
    pub advice: Option<Advice>,
}

/// Gauges the density of the samples of `triangles`, whose corners are indices into `points`.
///
/// `noise(x, y)` is that of the heights, `None` where it is not known; `lfs_mm(x, y)` the local
/// feature size as in [`crate::assess`]. Both are asked at the centre of each facet. Triangles that
/// bridge gaps are to be left out by not passing them. Along the outline of a Delaunay mesh lie
/// triangles whose circumcentre is outside: their shape tells of the outline, not of the density,
/// and they are told apart. Linear time on average, and 44 bytes of memory a triangle; where such
/// triangles are too thin for the noise, another 50.
///
/// # Panics
///
/// When a corner is not the index of a point.
pub fn assess_spacing(
    points: &[PointMm],
    triangles: impl IntoIterator<Item = [VertexId; 3]>,
    criteria: &SpacingCriteria,
    noise: impl Fn(f64, f64) -> Option<Noise>,
    lfs_mm: impl Fn(f64, f64) -> f64,
) -> Spacing {
    let triangles: Vec<[VertexId; 3]> = triangles.into_iter().collect();
    let (mut area, mut unknown) = (Sum::default(), Sum::default());
    let (mut spacings, mut tilts) = (Vec::new(), Vec::new());
    let mut turned = Vec::new();
    let mut loudest_mm: Option<f64> = None;
    let mut finest_mm = f64::INFINITY;
    for (index, &numbers) in triangles.iter().enumerate() {
        let triangle = Triangle::new(points, numbers);
        let corners = numbers.map(|corner| points[corner as usize]);
        let [x, y] =
            [0, 1].map(|axis| corners.iter().map(|corner| corner[axis]).sum::<f64>() / 3.0);
        let area_mm2 = triangle.area_mm2();
        if area_mm2 <= 0.0 {
            continue;
        }
        area.add(area_mm2);
        spacings.push(((2.0 * area_mm2).sqrt(), area_mm2));
        let lfs_mm = lfs_mm(x, y);
        finest_mm = if lfs_mm > 0.0 { finest_mm.min(lfs_mm) } else { 0.0 };
        let known = noise(x, y).and_then(|noise| Some((noise, facet_tilt_rad(corners, noise)?)));
        let Some((noise, tilt_rad)) = known else {
            unknown.add(area_mm2);
            tilts.push((f64::INFINITY, area_mm2));
            continue;
        };
        let cosine = triangle.projected_area_mm2().abs() / area_mm2;
        let sigma_mm = noise.along_normal_mm(cosine);
        loudest_mm = Some(loudest_mm.map_or(sigma_mm, |loudest_mm| loudest_mm.max(sigma_mm)));
        tilts.push((tilt_rad, area_mm2));
        if tilt_rad > criteria.tilt_limit_rad {
            turned.push((index, area_mm2));
        }
    }
    let (mut overdense, mut outline) = (Sum::default(), Sum::default());
    let cut = if turned.is_empty() { Vec::new() } else { cut_by_outline(points, &triangles) };
    for (index, area_mm2) in turned {
        let sum = if cut.binary_search(&index).is_ok() { &mut outline } else { &mut overdense };
        sum.add(area_mm2);
    }
    let known_mm2 = area.total() - unknown.total();
    Spacing {
        median_mm: weighted_quantile(&mut spacings, 0.5),
        tilt_median_rad: weighted_quantile(&mut tilts, 0.5).filter(|tilt| tilt.is_finite()),
        area_mm2: area.total(),
        overdense_area_mm2: overdense.total(),
        outline_area_mm2: outline.total(),
        unknown_area_mm2: unknown.total(),
        overdense_fraction: loudest_mm.is_some().then(|| overdense.total() / known_mm2),
        advice: loudest_mm.and_then(|sigma_mm| criteria.advice(sigma_mm, finest_mm)),
    }
}
