//! How densely a mesh in space samples its surface, and where to measure next.
//!
//! A facet counts as sampled where its farthest place is within the limits. What is missing of a sphere is the solid angle that no
//! facet takes; of other surfaces the openings inside the rim. Beyond a rim nothing is asked for.

use asphera_geometry::quantile::weighted_quantile;
use asphera_geometry::vector::{Vector, cross, dot, length, minus, unit};
use asphera_geometry::{PointMm, Sets, Triangle};
use asphera_report::{NextFigures, SamplingFigures};
use asphera_surface::noise::NoiseEstimate;
use rayon::prelude::*;

use super::feature_size::FeatureSize;
use super::meshed::Meshed;
use super::openings::Opening;
use super::shape::{Laid, Shape};
use crate::sampling::{Wanted, differs, of_noise};

/// One look at a mesh.
pub(super) struct Sampling<'a> {
    pub(super) meshed: &'a Meshed,
    pub(super) wanted: Wanted,
    pub(super) laid: Option<&'a Laid>,
    pub(super) openings: &'a [Opening],
    pub(super) noise: &'a Result<NoiseEstimate, String>,
    pub(super) size: &'a Result<FeatureSize, String>,
    pub(super) as_of_points: u64,
}

/// What it tells.
pub(super) struct Sampled {
    pub(super) figures: SamplingFigures,
    /// For each facet whether it is sampled densely enough.
    pub(super) covered: Vec<bool>,
}

/// A facet as sampled.
struct Facet {
    gap_mm: f64,
    at_mm: PointMm,
    /// Area that it stands for: of a sphere as seen from its centre.
    area_mm2: f64,
    lfs_mm: Option<f64>,
}

impl Facet {
    fn epsilon(&self) -> Option<f64> {
        self.lfs_mm.map(|lfs_mm| self.gap_mm / lfs_mm)
    }
}

impl Sampling<'_> {
    pub(super) fn sampled(&self) -> Sampled {
        let size = self.size.as_ref().ok();
        let facets: Vec<Facet> =
            self.meshed.facets.par_iter().map(|&facet| self.facet(facet, size)).collect();
        let mut unknown = Vec::new();
        unknown.extend(self.size.as_ref().err().cloned());
        unknown.extend(self.noise.as_ref().err().map(|why| format!("noise: {why}")));
        unknown.extend(self.noise.as_ref().ok().and_then(differs));
        let area_mm2 = facets.iter().fold(0.0, |sum, facet| sum + facet.area_mm2);
        let vertices = self.meshed.used().iter().filter(|used| **used).count();
        let distance_mm = (area_mm2 / vertices as f64).sqrt();
        let gap_limit_mm = self.wanted.gap_mm.unwrap_or(GAP * distance_mm);
        let reach_mm = facets.iter().filter_map(|facet| facet.lfs_mm).reduce(f64::min);
        let covered: Vec<bool> =
            facets.iter().map(|facet| self.is_dense(facet, gap_limit_mm, reach_mm)).collect();
        let dense_mm2 = facets
            .iter()
            .zip(&covered)
            .filter(|(_, covered)| **covered)
            .map(|(facet, _)| facet.area_mm2)
            .fold(0.0, |sum, mm2| sum + mm2);
        let gaps: Vec<&Opening> = self.openings.iter().filter(|opening| opening.is_gap).collect();
        let open_mm2 = self.open_mm2(area_mm2, &gaps);
        let whole_mm2 = area_mm2 + open_mm2;
        let is_known = whole_mm2 > 0.0 && (size.is_some() || self.wanted.epsilon.is_none());
        if whole_mm2.is_nan() || whole_mm2 <= 0.0 {
            unknown.insert(0, NO_AREA.to_owned());
        }
        let coverage =
            is_known.then(|| if dense_mm2 >= whole_mm2 { 1.0 } else { dense_mm2 / whole_mm2 });
        let allowed = Allowed { gap_limit_mm, reach_mm, whole_mm2 };
        let mut next = self.next(&facets, &covered, &gaps, &allowed);
        next.sort_by(|a, b| b.area_mm2.total_cmp(&a.area_mm2));
        let more = next.split_off(next.len().min(MOST_REGIONS));
        let finite = |value: &f64| value.is_finite();
        let gap = |facet: &Facet| Some(facet.gap_mm);
        let at_max = facets.iter().max_by(|a, b| {
            let of = |facet: &Facet| facet.epsilon().filter(|epsilon| *epsilon > 0.0);
            of(a)
                .unwrap_or(0.0)
                .total_cmp(&of(b).unwrap_or(0.0))
                .then(a.gap_mm.total_cmp(&b.gap_mm))
        });
        let mut medians: Vec<(f64, f64)> =
            facets.iter().map(|facet| (facet.area_mm2, facet.area_mm2)).collect();
        let figures = SamplingFigures {
            lfs_min_mm: reach_mm.filter(finite),
            lfs_source: size.map(|size| size.source().to_owned()),
            gap_max_mm: largest(&facets, gap),
            gap_p99_mm: ninety_nine(&facets, gap),
            gap_limit_mm: Some(gap_limit_mm).filter(finite),
            epsilon_target: self.wanted.epsilon,
            epsilon_max: largest(&facets, Facet::epsilon),
            epsilon_p99: ninety_nine(&facets, Facet::epsilon),
            rho_target: self.wanted.rho,
            rho_max: reach_mm.and_then(|reach_mm| Some(largest(&facets, gap)? / reach_mm)),
            reach_mm: reach_mm.filter(finite),
            at_max_mm: at_max.map(|facet| facet.at_mm),
            coverage,
            undersampled_area_mm2: is_known.then(|| (area_mm2 - dense_mm2).max(0.0)),
            uncovered_area_mm2: is_known.then_some(open_mm2),
            spacing_median_mm: weighted_quantile(&mut medians, 0.5).map(|mm2| (2.0 * mm2).sqrt()),
            next_more: more.len() as u64,
            next_more_area_mm2: more.iter().map(|region| region.area_mm2).sum(),
            next,
            holes: Some(gaps.len() as u64),
            hole_max_mm2: gaps.iter().filter_map(|gap| gap.area_mm2).reduce(f64::max),
            islands: Some(self.meshed.proof.components as u64),
            unknown,
            as_of_points: self.as_of_points,
            ..of_noise(self.noise.as_ref().ok())
        };
        Sampled { figures, covered }
    }

    fn facet(&self, facet: [u32; 3], size: Option<&FeatureSize>) -> Facet {
        let triangle = Triangle::new(&self.meshed.points_mm, facet);
        let gap = triangle.gap();
        let area_mm2 = match self.laid {
            Some(Laid { shape: Shape::Sphere { radius_mm }, centre_mm, .. }) => {
                let places = facet.map(|corner| self.meshed.points_mm[corner as usize]);
                solid_angle(places.map(|place| minus(place, *centre_mm))) * radius_mm * radius_mm
            }
            _ => triangle.area_mm2(),
        };
        let lfs_mm = size.and_then(|size| {
            let corners = facet.map(|corner| size.at_mm(self.meshed.points_mm[corner as usize]));
            corners.into_iter().flatten().reduce(f64::min)
        });
        Facet { gap_mm: gap.mm, at_mm: gap.at_mm, area_mm2, lfs_mm }
    }

    fn is_dense(&self, facet: &Facet, gap_limit_mm: f64, reach_mm: Option<f64>) -> bool {
        let within = |limit: Option<f64>, of_mm: Option<f64>| match (limit, of_mm) {
            (None, _) => true,
            (Some(limit), Some(of_mm)) => facet.gap_mm <= limit * of_mm,
            (Some(_), None) => false,
        };
        facet.gap_mm <= gap_limit_mm
            && within(self.wanted.epsilon, facet.lfs_mm)
            && within(self.wanted.rho, reach_mm)
    }

    /// Area in mm² that no facet takes.
    fn open_mm2(&self, area_mm2: f64, gaps: &[&Opening]) -> f64 {
        if let Some(Laid { shape: Shape::Sphere { radius_mm }, .. }) = self.laid {
            let whole_mm2 = 2.0 * std::f64::consts::TAU * radius_mm * radius_mm;
            let open_mm2 = whole_mm2 - area_mm2;
            // A closed mesh takes all of it but for rounding.
            return if open_mm2 > 1e-9 * whole_mm2 { open_mm2 } else { 0.0 };
        }
        gaps.iter().filter_map(|gap| gap.area_mm2).fold(0.0, |sum, mm2| sum + mm2)
    }

    /// The openings that are gaps, and pieces that are sampled too coarsely.
    fn next(
        &self,
        facets: &[Facet],
        covered: &[bool],
        gaps: &[&Opening],
        allowed: &Allowed,
    ) -> Vec<NextFigures> {
        let lfs_at = |at_mm: PointMm| self.size.as_ref().ok().and_then(|size| size.at_mm(at_mm));
        let open = gaps.iter().map(|gap| {
            let area_mm2 = gap.area_mm2.unwrap_or(0.0);
            let spacing_mm = allowed.spacing_mm(&self.wanted, lfs_at(gap.at_mm));
            NextFigures {
                area_mm2,
                undersampled_mm2: 0.0,
                uncovered_mm2: area_mm2,
                adds_coverage: allowed.adds(area_mm2),
                epsilon_max: None,
                gap_max_mm: Some(gap.radius_mm),
                spacing_needed_mm: spacing_mm,
                points_needed: spacing_mm.map(|mm| needed(area_mm2, mm)),
                at_mm: gap.at_mm,
                approach: gap.approach,
                polygons: Vec::new(),
                simplified_mm: 0.0,
            }
        });
        let open: Vec<NextFigures> = open.collect();
        open.into_iter().chain(self.coarse(facets, covered, allowed)).collect()
    }

    /// Pieces of facets beyond the limits, one a region whose facets share corners.
    fn coarse(&self, facets: &[Facet], covered: &[bool], allowed: &Allowed) -> Vec<NextFigures> {
        let mut sets = Sets::new(self.meshed.points_mm.len());
        let coarse: Vec<usize> = (0..facets.len()).filter(|&at| !covered[at]).collect();
        for &at in &coarse {
            let [a, b, c] = self.meshed.facets[at].map(|corner| corner as usize);
            sets.join(a, b);
            sets.join(b, c);
        }
        let mut regions: std::collections::BTreeMap<usize, Vec<usize>> = Default::default();
        for at in coarse {
            regions.entry(sets.root(self.meshed.facets[at][0] as usize)).or_default().push(at);
        }
        let region = |members: &Vec<usize>| {
            let area_mm2: f64 = members.iter().map(|&at| facets[at].area_mm2).sum();
            let worst = members.iter().map(|&at| &facets[at]);
            let worst = worst.reduce(|a, b| if b.gap_mm > a.gap_mm { b } else { a });
            let lfs_mm = worst.and_then(|worst| worst.lfs_mm);
            let spacing_mm = allowed.spacing_mm(&self.wanted, lfs_mm);
            let out = members.iter().fold([0.0; 3], |sum: Vector, &at| {
                let normal = self.meshed.double_area(self.meshed.facets[at]);
                [0, 1, 2].map(|axis| sum[axis] + normal[axis])
            });
            let has_sides = self.meshed.proof.is_oriented;
            NextFigures {
                area_mm2,
                undersampled_mm2: area_mm2,
                uncovered_mm2: 0.0,
                adds_coverage: allowed.adds(area_mm2),
                epsilon_max: worst.and_then(Facet::epsilon),
                gap_max_mm: worst.map(|worst| worst.gap_mm),
                spacing_needed_mm: spacing_mm,
                points_needed: spacing_mm.map(|mm| needed(area_mm2, mm)),
                at_mm: worst.map_or([0.0; 3], |worst| worst.at_mm),
                approach: unit(out).filter(|_| has_sides),
                polygons: Vec::new(),
                simplified_mm: 0.0,
            }
        };
        regions.values().map(region).collect()
    }
}

/// The limits of gaps, and the area of all that is to be covered.
struct Allowed {
    gap_limit_mm: f64,
    reach_mm: Option<f64>,
    whole_mm2: f64,
}

impl Allowed {
    /// The pitch of a raster that meets the limits; `None` where they say nothing.
    fn spacing_mm(&self, wanted: &Wanted, lfs_mm: Option<f64>) -> Option<f64> {
        let of = |share: Option<f64>, mm: Option<f64>| {
            share.zip(mm).map_or(f64::INFINITY, |(share, mm)| share * mm)
        };
        let gap_mm =
            self.gap_limit_mm.min(of(wanted.epsilon, lfs_mm)).min(of(wanted.rho, self.reach_mm));
        Some(std::f64::consts::SQRT_2 * gap_mm).filter(|mm| mm.is_normal())
    }

    fn adds(&self, area_mm2: f64) -> Option<f64> {
        (self.whole_mm2 > 0.0).then(|| (area_mm2 / self.whole_mm2).min(1.0))
    }
}

fn needed(area_mm2: f64, pitch_mm: f64) -> u64 {
    (area_mm2 / (pitch_mm * pitch_mm)).ceil().max(1.0) as u64
}

/// The largest of a value of facets.
fn largest(facets: &[Facet], of: impl Fn(&Facet) -> Option<f64>) -> Option<f64> {
    facets.iter().filter_map(of).reduce(f64::max)
}

/// The value that 99 % of the area have at most.
fn ninety_nine(facets: &[Facet], of: impl Fn(&Facet) -> Option<f64>) -> Option<f64> {
    let entries = facets.iter().filter_map(|facet| Some((of(facet)?, facet.area_mm2)));
    weighted_quantile(&mut entries.collect::<Vec<_>>(), 0.99)
}

/// The solid angle of a triangle as seen from the origin, positive where its corners turn counter-clockwise seen from outside
/// (A. van Oosterom, J. Strackee, IEEE Trans. Biomed. Eng. 30 (1983) 125-126).
pub(super) fn solid_angle([a, b, c]: [Vector; 3]) -> f64 {
    let [la, lb, lc] = [a, b, c].map(length);
    let triple = dot(a, cross(b, c));
    let below = la * lb * lc + dot(a, b) * lc + dot(b, c) * la + dot(c, a) * lb;
    2.0 * triple.atan2(below)
}

const NO_AREA: &str =
    "the points make no facet: fewer than three, all on a line, or none that agree";
/// The largest gap allowed where nothing is said, in average distances of points.
pub(super) const GAP: f64 = 4.0;
/// Regions that are listed.
const MOST_REGIONS: usize = 64;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn eight_octants_are_the_whole_sphere() {
        let (x, y, z) = ([3.0, 0.0, 0.0], [0.0, 5.0, 0.0], [0.0, 0.0, 0.1]);
        let quarter = std::f64::consts::FRAC_PI_2;
        assert!((solid_angle([x, y, z]) - quarter).abs() < 1e-15);
        assert!((solid_angle([y, x, z]) + quarter).abs() < 1e-15);
    }
}
