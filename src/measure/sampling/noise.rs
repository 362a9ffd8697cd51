//! The noise of the heights of a mesh, from patches of it.
//!
//! Noise is found from what neighbourhoods leave of their own polynomials (`asphera_surface::noise`), and a few
//! thousand of a million are enough. So their neighbours are looked up in patches only: the vertices within
//! [`RINGS`] rings of some [`SEEDS`] of them, spread evenly over the plane. Patches are chosen by place: the order in
//! which points arrived does not change the noise.

use std::cmp::Ordering;
use std::collections::{BTreeMap, BTreeSet};

use asphera_geometry::{BoundsMm, PointMm, VertexId, from_smallest, place};
use asphera_mesh::Mesh;
use asphera_surface::curvature::Adjacency;
use asphera_surface::noise::{
    Along, HeightSteps, NoiseEstimate, NoiseSettings, edges_of, estimate_noise, height_steps,
    noise_map,
};
use rayon::prelude::*;

/// The noise of the part of a mesh that counts, along z of its frame. `reach_mm` is the length from which an
/// edge bridges a gap. `known_mm` is what is known of the height at a place: form that bends more than a cubic over two
/// rings would count as noise. Heights in steps have no noise below that of rounding ([`height_steps`]).
///
/// # Errors
///
/// Why it is not known, in words.
pub(super) fn noise(
    mesh: &Mesh,
    reach_mm: f64,
    counts: impl Fn(PointMm) -> bool + Sync,
    known_mm: impl Fn([f64; 2]) -> f64,
) -> Result<NoiseEstimate, String> {
    let points = mesh.points();
    let seeds: Vec<VertexId> =
        seeds(points).into_iter().filter(|&seed| counts(points[seed as usize])).collect();
    let patches: Vec<(Vec<VertexId>, Vec<[VertexId; 3]>)> =
        seeds.par_iter().map(|&seed| patch(mesh, seed)).collect();
    let mut vertices: BTreeSet<VertexId> = BTreeSet::new();
    let mut triangles: BTreeSet<[VertexId; 3]> = BTreeSet::new();
    for (near, facets) in patches {
        vertices.extend(near);
        triangles.extend(facets);
    }
    // Numbered anew, so that what is made of the patches is as small as they are.
    let mut vertices: Vec<VertexId> = vertices.into_iter().collect();
    vertices.sort_unstable_by(|&a, &b| by_place(points[a as usize], points[b as usize]));
    let numbers: BTreeMap<VertexId, VertexId> =
        vertices.iter().zip(0..).map(|(&vertex, number)| (vertex, number)).collect();
    let number = |vertex: VertexId| numbers.get(&vertex).copied();
    let mut triangles: Vec<[VertexId; 3]> = triangles
        .into_iter()
        .filter_map(|[a, b, c]| Some(from_smallest([number(a)?, number(b)?, number(c)?])))
        .collect();
    triangles.sort_unstable();
    let measured: Vec<PointMm> = vertices.iter().map(|&vertex| points[vertex as usize]).collect();
    let step_mm = match height_steps(&measured, &edges_of(&triangles)) {
        HeightSteps::Fine => None,
        HeightSteps::Of { step_mm } => Some(step_mm),
        HeightSteps::Hidden => return Err(HIDDEN.to_owned()),
    };
    let lowered = |&vertex: &VertexId| {
        let [x, y, z] = points[vertex as usize];
        [x, y, z - known_mm([x, y])]
    };
    let points: Vec<PointMm> = vertices.iter().map(lowered).collect();
    let settings =
        NoiseSettings::new(NEIGHBOURHOODS, Along::Z).map_err(|error| error.to_string())?;
    let adjacency =
        Adjacency::new(&points, &triangles, Some(reach_mm)).map_err(|error| error.to_string())?;
    let found =
        estimate_noise(&points, &adjacency, &settings).map_err(|error| error.to_string())?;
    let found = found.over(&noise_map(&points, &adjacency, &settings, REGIONS).known());
    Ok(step_mm.map_or(found, |step_mm| found.with_step(step_mm)))
}

/// What hides the noise of heights that come in steps of unknown size.
pub(crate) const HIDDEN: &str =
    "most neighbours have the very same height, as of readings in steps of unknown size";

/// The vertices nearest to the middles of the squares of a lattice over the points, one a square that has any.
fn seeds(points: &[PointMm]) -> Vec<VertexId> {
    let bounds = BoundsMm::about(points.iter().map(|&point| place(point)));
    let (low, extent) = (bounds.low, bounds.size_mm());
    let longer = extent[0].max(extent[1]);
    // Points on a line have one row of squares.
    let side = (extent[0] * extent[1] / SEEDS as f64).sqrt().max(longer / SEEDS as f64);
    if !(side > 0.0 && side.is_finite()) {
        return Vec::from_iter((!points.is_empty()).then_some(0));
    }
    let size = extent.map(|extent| (extent / side).ceil().max(1.0));
    // The lattice lies about the middle of the points, so that turning or mirroring them turns it, too.
    let corner = [0, 1].map(|axis| low[axis] + 0.5 * (extent[axis] - size[axis] * side));
    let mut nearest: Vec<Option<(f64, VertexId)>> = vec![None; (size[0] * size[1]) as usize];
    for (point, vertex) in points.iter().zip(0..) {
        let way = [0, 1].map(|axis| (point[axis] - corner[axis]) / side);
        let square = [0, 1].map(|axis| way[axis].floor().clamp(0.0, size[axis] - 1.0));
        let distance = (way[0] - square[0] - 0.5).hypot(way[1] - square[1] - 0.5);
        let found = &mut nearest[(square[1] * size[0] + square[0]) as usize];
        let nearer = found.is_none_or(|(least, had)| {
            distance < least
                || (distance == least && by_place(*point, points[had as usize]).is_lt())
        });
        if nearer {
            *found = Some((distance, vertex));
        }
    }
    nearest.into_iter().flatten().map(|(_, vertex)| vertex).collect()
}

fn by_place(a: PointMm, b: PointMm) -> Ordering {
    let axes = a.iter().zip(&b).map(|(a, b)| a.total_cmp(b));
    axes.fold(Ordering::Equal, Ordering::then)
}

/// The vertices about a seed, and the triangles about the inner ones.
fn patch(mesh: &Mesh, seed: VertexId) -> (Vec<VertexId>, Vec<[VertexId; 3]>) {
    let mut vertices = mesh.within(seed, RINGS).unwrap_or_default();
    vertices.push(seed);
    let inner = mesh.within(seed, RINGS - 1).unwrap_or_default();
    let facets = inner.into_iter().chain([seed]).filter_map(|vertex| mesh.star(vertex)).flatten();
    (vertices, facets.map(from_smallest).collect())
}

/// Neighbourhoods that are looked at: enough for 1 %.
const NEIGHBOURHOODS: usize = 2048;
/// Patches, of some 90 vertices each: three quarters of them have two rings in the patch.
const SEEDS: usize = 64;
const RINGS: usize = 5;
/// Columns and rows of regions that may differ in noise: four patches each.
const REGIONS: [usize; 2] = [4, 4];
