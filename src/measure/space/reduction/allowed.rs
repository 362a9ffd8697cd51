//! The limits of a reduction at every facet, and the vertices that meet them.

use asphera_geometry::vector::length;
use asphera_geometry::{PointMm, Triangle, WeightedTree};
use rayon::prelude::*;

use super::{ReductionLimits, ReductionState, SparseInSpace, place};
use crate::space::cover::{Cover, Joined};
use crate::space::feature_size::FeatureSize;
use crate::space::meshed::Meshed;

/// What is allowed where.
pub(super) struct Allowed {
    limits: ReductionLimits,
    /// The local feature size at every vertex, where it is known.
    lfs_mm: Vec<Option<f64>>,
    pub(super) lfs_range_mm: [f64; 2],
    reach_mm: f64,
    /// No limit is wider, whatever the local feature size is: what is kept still spans the surface.
    widest_mm: f64,
    /// For each facet whether it is wider than the limit, or of unknown local feature size.
    is_sparse: Vec<bool>,
    /// Their corners: all of these are kept.
    at_sparse: Vec<bool>,
}

impl Allowed {
    pub(super) fn of(meshed: &Meshed, size: &FeatureSize, limits: ReductionLimits) -> Allowed {
        let lfs_mm = lfs_mm(meshed, size);
        let corners = meshed.facets.as_flattened().iter();
        let known = || corners.clone().filter_map(|&corner| lfs_mm[corner as usize]);
        let reach_mm = known().fold(f64::INFINITY, f64::min);
        let mut allowed = Allowed {
            limits,
            lfs_range_mm: [reach_mm, known().fold(0.0, f64::max)],
            reach_mm,
            widest_mm: WIDEST * meshed.proof.area_mm2.sqrt(),
            is_sparse: Vec::new(),
            at_sparse: vec![false; meshed.points_mm.len()],
            lfs_mm,
        };
        for &corners in &meshed.facets {
            let gap_mm = Triangle::new(&meshed.points_mm, corners).gap().mm;
            let is_sparse = allowed.limit_mm(corners).is_none_or(|limit_mm| gap_mm > limit_mm);
            allowed.is_sparse.push(is_sparse);
            if is_sparse {
                corners.iter().for_each(|&corner| allowed.at_sparse[corner as usize] = true);
            }
        }
        allowed
    }

    fn facet_lfs_mm(&self, corners: [u32; 3]) -> Option<f64> {
        corners.iter().filter_map(|&corner| self.lfs_mm[corner as usize]).reduce(f64::min)
    }

    /// The largest gap of a facet with these corners; `None` where the local feature size is needed and not known.
    pub(super) fn limit_mm(&self, corners: [u32; 3]) -> Option<f64> {
        let by_epsilon_mm = match self.limits.epsilon {
            Some(epsilon) => epsilon * self.facet_lfs_mm(corners)?,
            None => f64::INFINITY,
        };
        let by_rho_mm = self.limits.rho.map_or(f64::INFINITY, |rho| rho * self.reach_mm);
        Some(by_epsilon_mm.min(by_rho_mm).min(self.widest_mm))
    }

    /// Whether a facet of the surface is wider than the limit.
    pub(super) fn is_sparse(&self, facet: usize) -> bool {
        self.is_sparse[facet]
    }

    /// Whether all corners are those of such facets.
    pub(super) fn are_sparse(&self, corners: [u32; 3]) -> bool {
        corners.iter().all(|&corner| self.at_sparse[corner as usize])
    }

    /// The facets of the points themselves that no reduction brings within the limit.
    ///
    /// # Errors
    ///
    /// If that is all of them.
    pub(super) fn sparse(&self, meshed: &Meshed) -> Result<SparseInSpace, String> {
        let mut found = SparseInSpace { facets: 0, area_mm2: 0.0, widest_at_mm: None };
        let (mut times, mut widths_mm) = (0.0, [0.0; 2]);
        for (&corners, _) in meshed.facets.iter().zip(&self.is_sparse).filter(|(_, is)| **is) {
            found.facets += 1;
            let triangle = Triangle::new(&meshed.points_mm, corners);
            found.area_mm2 += triangle.area_mm2();
            let gap = triangle.gap();
            let limit_mm = self.limit_mm(corners).unwrap_or(f64::INFINITY);
            if gap.mm / limit_mm > times || found.widest_at_mm.is_none() {
                (times, widths_mm) = (gap.mm / limit_mm, [gap.mm, limit_mm]);
                found.widest_at_mm = Some(gap.at_mm);
            }
        }
        let Some(at_mm) = found.widest_at_mm.filter(|_| self.is_sparse.iter().all(|is| *is)) else {
            return Ok(found);
        };
        let [gap_mm, limit_mm] = widths_mm;
        Err(if limit_mm.is_finite() {
            format!(
                "all {} facets of the points have larger gaps than the limit, the worst {gap_mm:.4} mm about {}, where {limit_mm:.4} mm are allowed: no point can be dropped; measure more densely, or allow {}",
                found.facets,
                place(at_mm),
                self.wider(times)
            )
        } else {
            "the local feature size is known nowhere; give the surface with --nominal".to_owned()
        })
    }

    /// Both limits, so many times as wide.
    fn wider(&self, times: f64) -> String {
        let wider = |name: &str, share: Option<f64>| {
            share.map(|share| format!("--{name} {:.4}", 1.001 * times * share))
        };
        let both = [wider("epsilon", self.limits.epsilon), wider("rho", self.limits.rho)];
        both.into_iter().flatten().collect::<Vec<_>>().join(" and ")
    }

    /// The vertices to keep at a share of the limit, ascending: those of the border first, so that it stays where it is.
    pub(super) fn choose(
        &self,
        meshed: &Meshed,
        share: f64,
        joined: &Joined,
        border: &Joined,
    ) -> Vec<u32> {
        let count = meshed.points_mm.len();
        let (mut reach_mm, mut worth) = (vec![f64::INFINITY; count], vec![0.0; count]);
        for &corners in &meshed.facets {
            let gap_mm = Triangle::new(&meshed.points_mm, corners).gap().mm;
            let limit_mm = self.limit_mm(corners).unwrap_or(0.0);
            let left_mm = (share * limit_mm - gap_mm).max(0.0);
            let area = length(meshed.double_area(corners));
            for corner in corners.map(|corner| corner as usize) {
                reach_mm[corner] = left_mm.min(reach_mm[corner]);
                worth[corner] += area;
            }
        }
        let wanted = |joined: &Joined| -> Vec<u32> {
            (0..count as u32).filter(|&vertex| !joined.of(vertex).is_empty()).collect()
        };
        let mut cover = Cover::new(&meshed.points_mm, &reach_mm, &worth);
        let mut kept = cover.choose(border, wanted(border).into_iter());
        let mut cover = Cover::new(&meshed.points_mm, &reach_mm, &worth);
        cover.add(&kept, joined);
        kept.extend(cover.choose(joined, wanted(joined).into_iter()));
        kept.sort_unstable();
        kept
    }

    /// A mesh beside the limits; `vertex_of` tells which of all vertices each of its is.
    pub(super) fn state(&self, meshed: &Meshed, vertex_of: impl Fn(u32) -> u32) -> ReductionState {
        let (mut gap_max_mm, mut epsilon_max): (f64, f64) = (0.0, 0.0);
        for &corners in &meshed.facets {
            let gap_mm = Triangle::new(&meshed.points_mm, corners).gap().mm;
            gap_max_mm = gap_max_mm.max(gap_mm);
            let lfs_mm = self.facet_lfs_mm(corners.map(&vertex_of));
            epsilon_max = epsilon_max.max(lfs_mm.map_or(0.0, |lfs_mm| gap_mm / lfs_mm));
        }
        let proof = &meshed.proof;
        let flaws = proof.nonmanifold_edges.count
            + proof.singular_vertices.count
            + proof.self_intersections.count;
        ReductionState {
            facets: proof.facets as u64,
            area_mm2: proof.area_mm2,
            components: proof.components as u64,
            genus: proof.genus,
            border_loops: proof.border_loops.len() as u64,
            flaws: flaws as u64,
            gap_max_mm,
            epsilon_max,
            rho_max: gap_max_mm / self.reach_mm,
        }
    }
}

/// The local feature size at every vertex, where it is known: no larger than that of any other vertex and the way there. It
/// changes by no more than the way gone, and estimates do not.
fn lfs_mm(meshed: &Meshed, size: &FeatureSize) -> Vec<Option<f64>> {
    let found_mm: Vec<Option<f64>> =
        meshed.points_mm.par_iter().map(|&at_mm| size.at_mm(at_mm)).collect();
    let known = meshed.points_mm.iter().zip(&found_mm);
    let known = known.filter_map(|(&at_mm, mm)| Some((at_mm, mm.filter(|mm| mm.is_finite())?)));
    let tree = WeightedTree::new(known);
    let least = |(&at_mm, mm): (&PointMm, &Option<f64>)| {
        mm.map(|mm| tree.least(at_mm).map_or(mm, |least_mm| least_mm.min(mm)))
    };
    meshed.points_mm.par_iter().zip(&found_mm).map(least).collect()
}

/// Of the root of the area.
const WIDEST: f64 = 0.2;
