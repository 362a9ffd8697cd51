//! A reduction held against the surface that it is of: topology, border, gaps and distances.

use asphera_geometry::vector::{length, minus};
use asphera_geometry::{PointMm, Triangle, WeightedTree};
use rayon::prelude::*;

use super::allowed::Allowed;
use super::{ReductionState, border_edges, place};
use crate::space::meshed::Meshed;

impl Allowed {
    /// Holds the mesh of kept points against the surface and the limits.
    pub(super) fn hold(
        &self,
        (surface, before): (&Meshed, &ReductionState),
        (again, after): (&Meshed, &ReductionState),
        kept: &[u32],
    ) -> Result<(), String> {
        let count = kept.len();
        let genus = |state: &ReductionState| {
            state.genus.map_or_else(|| "unknown".to_owned(), |genus| genus.to_string())
        };
        let changed = [
            ("components", before.components.to_string(), after.components.to_string()),
            ("genus", genus(before), genus(after)),
            ("border loops", before.border_loops.to_string(), after.border_loops.to_string()),
        ];
        if let Some((what, expected, found)) = changed.iter().find(|(_, a, b)| a != b) {
            return Err(format!(
                "no {count} points keep the topology: expected {what} {expected}, found {found} about {}: {CURE}",
                place(odd_place(surface, again))
            ));
        }
        if after.flaws > before.flaws {
            return Err(format!(
                "the mesh of {count} kept points is no surface about {}: {CURE}",
                place(odd_place(surface, again))
            ));
        }
        self.hold_border(surface, again, kept)?;
        if let Some(at) = again.used().iter().position(|used| !used) {
            let at_mm = again.points_mm[at];
            return Err(format!("a kept point is in no facet, at {}: {CURE}", place(at_mm)));
        }
        let wide = again.facets.iter().find_map(|&corners| {
            let gap = Triangle::new(&again.points_mm, corners).gap();
            let corners = corners.map(|at| kept[at as usize]);
            let limit_mm = self.limit_mm(corners).unwrap_or(0.0);
            let is_wide = gap.mm > limit_mm && !self.are_sparse(corners);
            is_wide.then_some((gap, limit_mm))
        });
        match wide {
            Some((gap, limit_mm)) => Err(format!(
                "{count} kept points leave a gap of {:.4} mm about {}, where {limit_mm:.4} mm are allowed: {CURE}",
                gap.mm,
                place(gap.at_mm)
            )),
            None => Ok(()),
        }
    }

    /// Holds the border of the kept points against that of the surface: no longer, and nowhere else.
    fn hold_border(&self, surface: &Meshed, again: &Meshed, kept: &[u32]) -> Result<(), String> {
        let length_mm = |meshed: &Meshed| {
            meshed.proof.border_loops.iter().map(|border| border.length_mm).fold(0.0, |a, b| a + b)
        };
        let corners = |meshed: &Meshed| -> Vec<PointMm> {
            let edges = border_edges(meshed);
            edges.as_flattened().iter().map(|&corner| meshed.points_mm[corner as usize]).collect()
        };
        let tree = WeightedTree::of_points(&corners(surface));
        let moved = border_edges(again).into_iter().flatten().map(|corner| {
            let at_mm = again.points_mm[corner as usize];
            let away_mm = tree.least(at_mm).unwrap_or(f64::INFINITY);
            let limit_mm = self.limit_mm([kept[corner as usize]; 3]).unwrap_or(0.0);
            let is_there = away_mm <= limit_mm;
            (if is_there { 0.0 } else { away_mm }, at_mm)
        });
        let Some((moved_mm, at_mm)) = moved.max_by(|a, b| a.0.total_cmp(&b.0)) else {
            return Ok(());
        };
        if moved_mm > 0.0 || length_mm(again) > LONGEST * length_mm(surface) {
            return Err(format!(
                "the border of {} kept points is not that of the surface about {}: {CURE}",
                kept.len(),
                place(at_mm)
            ));
        }
        Ok(())
    }

    /// The largest distance from a vertex of the surface to the nearest kept point, found anew among all of them.
    pub(super) fn away_max_mm(&self, meshed: &Meshed, kept_mm: &[PointMm]) -> Result<f64, String> {
        let tree = WeightedTree::of_points(kept_mm);
        let away_mm = |&at_mm: &PointMm| tree.least(at_mm).unwrap_or(f64::INFINITY);
        let away_mm: Vec<f64> = meshed.points_mm.par_iter().map(away_mm).collect();
        let mut most_mm: f64 = 0.0;
        for (facet, &corners) in meshed.facets.iter().enumerate() {
            if self.is_sparse(facet) {
                continue;
            }
            let triangle = Triangle::new(&meshed.points_mm, corners);
            let away_mm =
                corners.iter().map(|&corner| away_mm[corner as usize]).fold(0.0, f64::max);
            most_mm = most_mm.max(away_mm);
            // One rounding of each side.
            let limit_mm = self.limit_mm(corners).unwrap_or(0.0);
            if away_mm + triangle.gap().mm > (1.0 + 1e-12) * limit_mm {
                return Err(format!(
                    "a place about {} is {away_mm:.4} mm from the nearest kept point, more than the limit: {CURE}",
                    place(triangle.gap().at_mm)
                ));
            }
        }
        Ok(most_mm)
    }
}

/// A place where two meshes differ: of the border loop that is farthest from those of the other, else of the widest facet.
fn odd_place(surface: &Meshed, again: &Meshed) -> PointMm {
    let loops = |meshed: &Meshed| -> Vec<PointMm> {
        let of = |border: &asphera_reconstruct::prove::BorderLoop| border.vertex as usize;
        meshed.proof.border_loops.iter().map(|border| meshed.points_mm[of(border)]).collect()
    };
    let away_mm = |at: PointMm, others: &[PointMm]| {
        others.iter().map(|other| length(minus(at, *other))).fold(f64::INFINITY, f64::min)
    };
    let (old, new) = (loops(surface), loops(again));
    let odd = |from: &[PointMm], others: &[PointMm]| {
        let ways = from.iter().map(|&at| (away_mm(at, others), at));
        ways.max_by(|a, b| a.0.total_cmp(&b.0))
    };
    let odd = [odd(&old, &new), odd(&new, &old)].into_iter().flatten();
    if let Some((_, at_mm)) = odd.max_by(|a, b| a.0.total_cmp(&b.0)) {
        return at_mm;
    }
    let gaps = again.facets.iter().map(|&corners| Triangle::new(&again.points_mm, corners).gap());
    let widest = gaps.max_by(|a, b| a.mm.total_cmp(&b.mm)).map(|gap| gap.at_mm);
    widest.or(surface.points_mm.first().copied()).unwrap_or_default()
}

/// Of the border before. Chords of a border are shorter than it is; those of a rough one may run otherwise.
const LONGEST: f64 = 1.25;
const CURE: &str = "allow less, or measure more densely";
