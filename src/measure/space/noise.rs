//! The noise of points meshed in space, along the normal: by what neighbourhoods of some patches leave of their own polynomials.
//!
//! Each patch is laid flat about its middle. Its heights are the deviations where a shape was fitted, so that the bend of the part
//! is none of the noise; else the heights over the tangent plane. Flat patches that share no number go through the same estimate as
//! a mesh in the plane.

use asphera_geometry::vector::Vector;
use asphera_surface::curvature::Adjacency;
use asphera_surface::noise::{
    Along, NoiseEstimate, NoiseSettings, estimate_noise, estimate_noise_about,
};
use rayon::prelude::*;

use super::meshed::Meshed;
use super::patch::{AtVertex, Patch};
use super::shape::Laid;

/// The noise of a mesh.
///
/// # Errors
///
/// Why it is not known, in words.
pub(super) fn noise(
    meshed: &Meshed,
    normals: &[Option<Vector>],
    laid: Option<&Laid>,
) -> Result<NoiseEstimate, String> {
    let at_vertex = AtVertex::of(meshed);
    let vertices: Vec<u32> = (0..meshed.points_mm.len() as u32)
        .filter(|&vertex| normals[vertex as usize].is_some())
        .collect();
    // In the order of their coordinates, so that the same places are taken whatever came first.
    let seeds = vertices.len().min(SEEDS);
    let seeds: Vec<u32> = (0..seeds).map(|at| vertices[at * vertices.len() / seeds]).collect();
    let patches: Vec<Patch> = seeds
        .par_iter()
        .filter_map(|&seed| at_vertex.patch(meshed, (seed, normals[seed as usize]?), RINGS, laid))
        .collect();
    let (mut points, mut triangles, mut starts) = (Vec::new(), Vec::new(), Vec::new());
    for patch in patches {
        let first = points.len() as u32;
        starts.push(first);
        points.extend(patch.places_mm);
        triangles.extend(patch.facets.iter().map(|facet| facet.map(|corner| corner + first)));
    }
    let settings = NoiseSettings::new(NEIGHBOURHOODS, Along::Z).map_err(|why| why.to_string())?;
    let adjacency = Adjacency::new(&points, &triangles, None).map_err(|why| why.to_string())?;
    let found = estimate_noise(&points, &adjacency, &settings).map_err(|why| why.to_string())?;
    starts.push(points.len() as u32);
    let regions: Vec<NoiseEstimate> = (0..starts.len() - 1)
        .step_by(OF_REGION)
        .filter_map(|first| {
            let end = (first + OF_REGION).min(starts.len() - 1);
            let vertices: Vec<u32> = (starts[first]..starts[end]).collect();
            estimate_noise_about(&points, &adjacency, &vertices, &settings).ok()
        })
        .collect();
    Ok(found.over(&regions))
}

/// Neighbourhoods that are looked at: enough for 1 %.
const NEIGHBOURHOODS: usize = 2048;
const SEEDS: usize = 96;
const RINGS: usize = 4;
/// Patches of a region that may differ in noise from others: they follow one another along x.
const OF_REGION: usize = 6;
