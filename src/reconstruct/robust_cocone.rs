//! Robust Cocone (T. K. Dey, S. Goswami 2006, "Provable surface reconstruction from noisy samples",
//! doi:10.1016/j.comgeo.2005.10.006): a closed surface through the points that touch big balls outside.
//!
//! Points within a band of noise touch no big outer ball and are left out. Over the other points sides are told anew ([`crate::sides`]),
//! and the surface is the border between them. Where no big ball is inside there is no body, and no surface is given.
//! We deviate twice. The paper hands the points that are left to Tight Cocone. And facets wider than their corners' reach are lids, which
//! are left out, so that an open surface stays open ([`crate::reach`]).

use asphera_geometry::PointMm;

use crate::centres;
use crate::cocone::COCONE_BOUND;
use crate::delaunay::{Delaunay, NoDelaunay};
use crate::poles::Poles;
use crate::reach::Reach;
use crate::sampling::SamplingCondition;
use crate::sides::Sides;
use crate::surface::{LeftOut, Reconstruction, of_vertices};

/// A closed surface between balls inside and balls outside.
#[derive(Clone, Debug, PartialEq)]
pub struct RobustCocone {
    /// The surface; without facets where there is no inside.
    pub surface: Reconstruction,
    /// Points that touch no big outer ball.
    pub noise: usize,
    /// Big balls inside.
    pub inner: usize,
    /// Facets left out as lids.
    pub lids: usize,
    /// The sampling condition, for the points that are left.
    pub sampling: SamplingCondition,
}

/// Reconstructs a closed surface from points that may be off it.
///
/// # Errors
///
/// Points that do not span space.
pub fn robust_cocone(points_mm: &[PointMm]) -> Result<RobustCocone, NoDelaunay> {
    let whole = Delaunay::new(points_mm)?;
    let is_outermost = outermost(&whole);
    let mut noise: Vec<(u32, LeftOut)> = Vec::new();
    let mut places = Vec::with_capacity(whole.vertices());
    let mut ids = Vec::with_capacity(whole.vertices());
    // In the order of the points as they came, so that of equal places the same number counts.
    let mut by_id: Vec<u32> = (0..whole.vertices() as u32).collect();
    by_id.sort_unstable_by_key(|&vertex| whole.ids[vertex as usize]);
    for vertex in by_id {
        let id = whole.ids[vertex as usize];
        if is_outermost[vertex as usize] {
            places.push(whole.place(vertex));
            ids.push(id);
        } else {
            noise.push((id, LeftOut::Noise));
        }
    }
    let left_out = whole.left_out.clone();
    drop(whole);
    let mut delaunay = Delaunay::new(&places)?;
    for id in &mut delaunay.ids {
        *id = ids[*id as usize];
    }
    delaunay.left_out = left_out;
    let centres = centres::of(&delaunay);
    let poles = Poles::of(&delaunay, &centres);
    let sides = Sides::of(&delaunay, &centres, &poles, BIG);
    let inner = sides.inner();
    let mut facets = Vec::new();
    let mut lids = 0;
    if inner > 0 {
        let reach = Reach::of(&delaunay);
        for (cell, slot) in sides.border(&delaunay) {
            let facet = delaunay.facet(cell, slot);
            if reach.is_lid(&delaunay, facet) {
                lids += 1;
            } else {
                facets.push(facet);
            }
        }
    }
    let sampling = SamplingCondition::of(&delaunay.points_mm, &poles, &facets, COCONE_BOUND);
    let mut surface = of_vertices(points_mm, &delaunay, facets, LeftOut::NoFacet);
    let count = noise.len();
    surface.left_out.extend(noise);
    surface.left_out.sort_unstable();
    Ok(RobustCocone { surface, noise: count, inner, lids, sampling })
}

/// Vertices on big balls outside, those of the hull among them.
fn outermost(delaunay: &Delaunay) -> Vec<bool> {
    let centres = centres::of(delaunay);
    let sides = Sides::of(delaunay, &centres, &Poles::of(delaunay, &centres), BIG);
    let mut is_outermost = vec![false; delaunay.vertices()];
    for (cell, corners) in delaunay.corners.iter().enumerate() {
        if sides.is_big[cell] && sides.is_outside[cell] {
            for &corner in corners {
                if let Some(is_outermost) = is_outermost.get_mut(corner as usize) {
                    *is_outermost = true;
                }
            }
        }
    }
    is_outermost
}

/// The radius of a big ball, in distances of the 8th neighbour.
const BIG: f64 = 1.0;
