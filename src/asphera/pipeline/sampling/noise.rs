//! The noise of the heights of a mesh, from patches of it.
//!
//! Noise is found from what neighbourhoods leave of their own polynomials (`asphera_surface::noise`), and a few
//! thousand of a million are enough. So their neighbours are looked up in patches only: the vertices within
//! [`RINGS`] rings of [`SEEDS`] of them, spread evenly over the order in which points arrived.

use std::collections::BTreeSet;

use asphera_surface::curvature::Adjacency;
use asphera_surface::noise::{Along, NoiseEstimate, NoiseSettings, estimate_noise};
use asphera_surface::{Mesh, PointMm, VertexId};
use rayon::prelude::*;

/// The noise of the part of a mesh that counts, along z of its frame. `reach_mm` is the length from which an
/// edge bridges a gap.
///
/// # Errors
///
/// Why it is not known, in words.
pub(super) fn noise(
    mesh: &Mesh,
    reach_mm: f64,
    counts: impl Fn(PointMm) -> bool + Sync,
) -> Result<NoiseEstimate, String> {
    let points = mesh.points();
    let wanted = points.len().min(SEEDS);
    let seeds = (0..wanted).map(|seed| (seed * points.len() / wanted) as VertexId);
    let seeds: Vec<VertexId> = seeds.filter(|&seed| counts(points[seed as usize])).collect();
    let patches: Vec<(Vec<VertexId>, Vec<[VertexId; 3]>)> =
        seeds.par_iter().map(|&seed| patch(mesh, seed)).collect();
    let mut vertices: BTreeSet<VertexId> = BTreeSet::new();
    let mut triangles: BTreeSet<[VertexId; 3]> = BTreeSet::new();
    for (near, facets) in patches {
        vertices.extend(near);
        triangles.extend(facets);
    }
    // Numbered anew, so that what is made of the patches is as small as they are.
    let vertices: Vec<VertexId> = vertices.into_iter().collect();
    let number = |vertex: VertexId| vertices.binary_search(&vertex).ok().map(|at| at as VertexId);
    let triangles: Vec<[VertexId; 3]> = triangles
        .into_iter()
        .filter_map(|[a, b, c]| Some([number(a)?, number(b)?, number(c)?]))
        .collect();
    let points: Vec<PointMm> = vertices.iter().map(|&vertex| points[vertex as usize]).collect();
    let settings =
        NoiseSettings::new(NEIGHBOURHOODS, Along::Z).map_err(|error| error.to_string())?;
    let adjacency =
        Adjacency::new(&points, &triangles, Some(reach_mm)).map_err(|error| error.to_string())?;
    estimate_noise(&points, &adjacency, &settings).map_err(|error| error.to_string())
}

/// The vertices about a seed, and the triangles about the inner ones.
fn patch(mesh: &Mesh, seed: VertexId) -> (Vec<VertexId>, Vec<[VertexId; 3]>) {
    let mut vertices = mesh.within(seed, RINGS).unwrap_or_default();
    vertices.push(seed);
    let inner = mesh.within(seed, RINGS - 1).unwrap_or_default();
    let facets = inner.into_iter().chain([seed]).filter_map(|vertex| mesh.star(vertex)).flatten();
    (vertices, facets.map(from_smallest).collect())
}

/// A triangle from its smallest corner on, so that it is the same from whichever vertex it was found.
fn from_smallest([a, b, c]: [VertexId; 3]) -> [VertexId; 3] {
    if a < b && a < c {
        [a, b, c]
    } else if b < c {
        [b, c, a]
    } else {
        [c, a, b]
    }
}

/// Neighbourhoods that are looked at: enough for 1 %.
const NEIGHBOURHOODS: usize = 2048;
/// Patches, of some 90 vertices each: three quarters of them have two rings in the patch.
const SEEDS: usize = 64;
const RINGS: usize = 5;
