//! The reduction of a surface in space: few points, near enough to every place of it.
//!
//! The surface is the mesh of all points. A place of a facet lies within the facet's gap of a corner. So every place has a kept point
//! within the limit of its facet, where each corner has one within the limit less the gap ([`Cover`] chooses these).
//!
//! Where the points themselves are farther apart than the limit, all of them are kept.
//!
//! The kept points are meshed again and held against the limit and the topology of the surface. Where they fall short, more are
//! kept: the limit is tightened in steps. If no step will do, there is no result.

mod allowed;
mod verification;

use asphera_geometry::PointMm;

use self::allowed::Allowed;
use super::assessment::Footing;
use super::cover::Joined;
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
    pub retained_mm: Vec<PointMm>,
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
    /// Facets of the points themselves that are wider than the limit.
    pub sparse: SparseInSpace,
    /// The share of the limit that was taken, so that topology and limit hold: 1 unless points had to be added.
    pub share: f64,
    /// The largest distance from a vertex to the nearest kept point, mm.
    pub away_max_mm: f64,
    /// All points.
    pub before: ReductionState,
    /// The kept points, meshed again.
    pub after: ReductionState,
}

/// Facets of all points whose gap is wider than the limit, or of unknown local feature size. No reduction mends those: their corners
/// are all kept.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SparseInSpace {
    /// How many.
    pub facets: u64,
    /// Their area.
    pub area_mm2: f64,
    /// Where the widest is, beside its limit.
    pub widest_at_mm: Option<PointMm>,
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
/// In words, with a place: the points make no surface, all are sparser than the limit, or no reduction keeps limit and topology.
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
    let allowed = Allowed::of(meshed, size, limits);
    let sparse = allowed.sparse(meshed)?;
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
            sparse,
            share,
            before,
            after,
            retained_mm: kept_mm,
        });
    }
    Err(failure)
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
