//! The reduction of a surface in space: few points, near enough to every place of it.
//!
//! The surface is the mesh of all points. A place of a facet lies within the facet's gap of a corner. So every place has a kept point
//! within the limit of its facet, where each corner has one within the limit less the gap ([`Cover`] chooses these).
//!
//! The kept points are meshed again and held against the limit and the topology of the surface. Where they fall short, more are
//! kept: the limit is tightened in steps. If no step will do, there is no result.

use asphera_geometry::vector::{length, minus};
use asphera_geometry::{PointMm, Triangle, WeightedTree};
use rayon::prelude::*;

use super::assessment::Footing;
use super::cover::{Cover, Joined};
use super::feature_size::FeatureSize;
use super::meshed::Meshed;
use crate::Part;

/// How near a kept point is to be to every place of a surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ReductionLimits {
    /// As a share of the local feature size there.
    pub epsilon: Option<f64>,
    /// As a share of the reach.
    pub rho: Option<f64>,
}

/// A surface in space with fewer points.
#[derive(Clone, Debug, PartialEq)]
pub struct ReducedInSpace {
    /// The points that are kept, by their coordinates.
    pub kept_mm: Vec<PointMm>,
    /// Points of the surface before.
    pub vertices: u64,
    /// Points at the place of another.
    pub duplicates: u64,
    /// Points that are not finite or out of range.
    pub rejected: u64,
    /// Points that no facet uses: they are dropped.
    pub left_out: u64,
    /// `nominal` or `measured`.
    pub lfs_source: &'static str,
    /// Smallest and largest local feature size, mm; that of a plane is infinite.
    pub lfs_mm: [f64; 2],
    /// Standard deviation of the noise along the normal, mm, where it is known.
    pub sigma_mm: Option<f64>,
    /// The share of the limit that was taken, so that topology and limit hold: 1 unless points had to be added.
    pub share: f64,
    /// The largest distance from a vertex to the nearest kept point, mm.
    pub away_max_mm: f64,
    /// All points.
    pub before: ReductionState,
    /// The kept points, meshed again.
    pub after: ReductionState,
}

/// A mesh in space beside the limits.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ReductionState {
    /// Facets.
    pub facets: u64,
    /// Their area.
    pub area_mm2: f64,
    /// Pieces that do not touch.
    pub components: u64,
    /// Handles, where it is known.
    pub genus: Option<i64>,
    /// Loops of the border.
    pub border_loops: u64,
    /// Edges of three facets, singular vertices and crossings.
    pub flaws: u64,
    /// The largest gap.
    pub gap_max_mm: f64,
    /// The largest gap as a share of the local feature size.
    pub epsilon_max: f64,
    /// The largest gap as a share of the reach.
    pub rho_max: f64,
}

/// Reduces points that are meshed in space. The design of a part gives the local feature size where it is a sphere, a circular
/// cylinder or a plane; else medial balls of the points do. `sigma_mm` is the noise where it is known.
///
/// The result depends on the places of the points alone.
///
/// # Errors
///
/// In words, with a place: the points make no surface, are sparser than the limit, or no reduction keeps limit and topology.
pub fn reduce_in_space(
    points_mm: &[PointMm],
    part: Option<&Part>,
    limits: ReductionLimits,
    sigma_mm: Option<f64>,
) -> Result<ReducedInSpace, String> {
    let footing = Footing::of(points_mm, part, sigma_mm)?;
    let Footing { meshed, size, .. } = &footing;
    if meshed.facets.is_empty() {
        return Err("expected points that make a surface, found no facet".to_owned());
    }
    let size = size.as_ref().map_err(|why| format!("{why}; give the surface with --nominal"))?;
    let allowed = Allowed::of(meshed, size, limits)?;
    allowed.refuse_sparse(meshed)?;
    let corners = |at: &[u32; 3]| [[at[0], at[1]], [at[1], at[2]], [at[2], at[0]]];
    let joined = Joined::by(meshed.points_mm.len(), meshed.facets.iter().flat_map(corners));
    let border = Joined::by(meshed.points_mm.len(), border_edges(meshed).into_iter());
    let before = allowed.state(meshed, |vertex| vertex);
    let mut failure = String::new();
    for share in SHARES {
        let kept = allowed.choose(meshed, share, &joined, &border);
        let kept_mm: Vec<PointMm> =
            kept.iter().map(|&vertex| meshed.points_mm[vertex as usize]).collect();
        // They are in the order of their coordinates, as the vertices are.
        let again = Meshed::of(&kept_mm)?;
        let after = allowed.state(&again, |at| kept[at as usize]);
        if let Err(why) = allowed.hold((meshed, &before), (&again, &after), &kept) {
            failure = why;
            continue;
        }
        return Ok(ReducedInSpace {
            away_max_mm: allowed.away_max_mm(meshed, &kept_mm)?,
            vertices: meshed.used().iter().filter(|used| **used).count() as u64,
            duplicates: meshed.duplicates,
            rejected: meshed.rejected,
            left_out: meshed.used().iter().filter(|used| !**used).count() as u64,
            lfs_source: size.source(),
            lfs_mm: allowed.lfs_range_mm,
            sigma_mm: footing.sigma_mm,
            share,
            before,
            after,
            kept_mm,
        });
    }
    Err(failure)
}

/// What is allowed where.
struct Allowed {
    limits: ReductionLimits,
    /// The local feature size at every vertex, where it is known.
    lfs_mm: Vec<Option<f64>>,
    lfs_range_mm: [f64; 2],
    reach_mm: f64,
    /// No limit is wider, whatever the local feature size is: what is kept still spans the surface.
    widest_mm: f64,
}

impl Allowed {
    fn of(meshed: &Meshed, size: &FeatureSize, limits: ReductionLimits) -> Result<Allowed, String> {
        let lfs_mm: Vec<Option<f64>> =
            meshed.points_mm.par_iter().map(|&place| size.at_mm(place)).collect();
        let corners = meshed.facets.as_flattened().iter();
        let known = || corners.clone().filter_map(|&corner| lfs_mm[corner as usize]);
        let reach_mm = known().fold(f64::INFINITY, f64::min);
        let lfs_range_mm = [reach_mm, known().fold(0.0, f64::max)];
        let widest_mm = WIDEST * meshed.proof.area_mm2.sqrt();
        let allowed = Allowed { limits, lfs_mm, lfs_range_mm, reach_mm, widest_mm };
        let unknown =
            meshed.facets.iter().find(|corners| allowed.facet_lfs_mm(**corners).is_none());
        match unknown.filter(|_| limits.epsilon.is_some()) {
            Some(corners) => Err(format!(
                "the local feature size is not known about {}: measure more densely there, or give the surface with --nominal",
                place(meshed.points_mm[corners[0] as usize])
            )),
            None => Ok(allowed),
        }
    }

    fn facet_lfs_mm(&self, corners: [u32; 3]) -> Option<f64> {
        corners.iter().filter_map(|&corner| self.lfs_mm[corner as usize]).reduce(f64::min)
    }

    /// The largest gap of a facet with these corners.
    fn limit_mm(&self, corners: [u32; 3]) -> f64 {
        let by_epsilon_mm = match (self.limits.epsilon, self.facet_lfs_mm(corners)) {
            (Some(epsilon), Some(lfs_mm)) => epsilon * lfs_mm,
            _ => f64::INFINITY,
        };
        let by_rho_mm = self.limits.rho.map_or(f64::INFINITY, |rho| rho * self.reach_mm);
        by_epsilon_mm.min(by_rho_mm).min(self.widest_mm)
    }

    /// Fails where the points themselves are farther apart than the limit.
    fn refuse_sparse(&self, meshed: &Meshed) -> Result<(), String> {
        let mut wide = 0_u64;
        let mut worst = (1.0, [0.0; 3], [0.0; 2]);
        for &corners in &meshed.facets {
            let gap = Triangle::new(&meshed.points_mm, corners).gap();
            let limit_mm = self.limit_mm(corners);
            if gap.mm > limit_mm {
                wide += 1;
                if gap.mm / limit_mm > worst.0 {
                    worst = (gap.mm / limit_mm, gap.at_mm, [gap.mm, limit_mm]);
                }
            }
        }
        let (times, at_mm, [gap_mm, limit_mm]) = worst;
        match wide {
            0 => Ok(()),
            _ => Err(format!(
                "{wide} of {} facets of the points themselves have larger gaps than the limit, the worst {gap_mm:.4} mm about {}, where {limit_mm:.4} mm are allowed: measure more densely there, or allow {}",
                meshed.facets.len(),
                place(at_mm),
                self.wider(times)
            )),
        }
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
    fn choose(&self, meshed: &Meshed, share: f64, joined: &Joined, border: &Joined) -> Vec<u32> {
        let count = meshed.points_mm.len();
        let (mut reach_mm, mut worth) = (vec![f64::INFINITY; count], vec![0.0; count]);
        for &corners in &meshed.facets {
            let gap_mm = Triangle::new(&meshed.points_mm, corners).gap().mm;
            let left_mm = (share * self.limit_mm(corners) - gap_mm).max(0.0);
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
    fn state(&self, meshed: &Meshed, vertex_of: impl Fn(u32) -> u32) -> ReductionState {
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

    /// Holds the mesh of kept points against the surface and the limits.
    fn hold(
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
            let limit_mm = self.limit_mm(corners.map(|at| kept[at as usize]));
            (gap.mm > limit_mm).then_some((gap, limit_mm))
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
            (away_mm / self.limit_mm([kept[corner as usize]; 3]), at_mm)
        });
        let Some((times, at_mm)) = moved.max_by(|a, b| a.0.total_cmp(&b.0)) else { return Ok(()) };
        if times > 1.0 || length_mm(again) > LONGEST * length_mm(surface) {
            return Err(format!(
                "the border of {} kept points is not that of the surface about {}: {CURE}",
                kept.len(),
                place(at_mm)
            ));
        }
        Ok(())
    }

    /// The largest distance from a vertex of the surface to the nearest kept point, found anew among all of them.
    fn away_max_mm(&self, meshed: &Meshed, kept_mm: &[PointMm]) -> Result<f64, String> {
        let tree = WeightedTree::of_points(kept_mm);
        let away_mm = |&at_mm: &PointMm| tree.least(at_mm).unwrap_or(f64::INFINITY);
        let away_mm: Vec<f64> = meshed.points_mm.par_iter().map(away_mm).collect();
        let mut most_mm: f64 = 0.0;
        for &corners in &meshed.facets {
            let triangle = Triangle::new(&meshed.points_mm, corners);
            let away_mm =
                corners.iter().map(|&corner| away_mm[corner as usize]).fold(0.0, f64::max);
            most_mm = most_mm.max(away_mm);
            // One rounding of each side.
            if away_mm + triangle.gap().mm > (1.0 + 1e-12) * self.limit_mm(corners) {
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

fn place([x, y, z]: PointMm) -> String {
    format!("({x:.4}, {y:.4}, {z:.4}) mm")
}

/// Edges of one facet alone.
fn border_edges(meshed: &Meshed) -> Vec<[u32; 2]> {
    let mut edges: Vec<[u32; 2]> = meshed
        .facets
        .iter()
        .flat_map(|&[a, b, c]| [[a, b], [b, c], [c, a]])
        .map(|[a, b]| [a.min(b), a.max(b)])
        .collect();
    edges.sort_unstable();
    edges.chunk_by(|a, b| a == b).filter(|same| same.len() == 1).map(|same| same[0]).collect()
}

/// Shares of the limit that are tried.
const SHARES: [f64; 7] = [1.0, 0.9, 0.8, 0.7, 0.6, 0.5, 0.35];
/// Of the border before. Chords of a border are shorter than it is; those of a rough one may run otherwise.
const LONGEST: f64 = 1.25;
/// Of the root of the area.
const WIDEST: f64 = 0.2;
const CURE: &str = "allow less, or measure more densely";
