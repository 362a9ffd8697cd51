//! Natural neighbours (J.-D. Boissonnat, F. Cazals 2002, "Smooth surface reconstruction via natural neighbour interpolation of
//! distance functions", doi:10.1016/S0925-7721(01)00048-7).
//!
//! A signed function interpolates the heights over the tangent planes of the points ([`function`]). A facet is of the surface where the
//! Voronoi edge across it has ends of different signs. Normals are the ways to poles; which of them points outwards follows from
//! the sides of tetrahedra ([`crate::sides`]). We deviate once: facets wider than their corners' reach are lids and are left out
//! ([`crate::reach`]), so that an open surface stays open.

mod function;

use asphera_geometry::PointMm;
use rayon::prelude::*;

use self::function::{Function, Room, Sign};
use crate::centres;
use crate::delaunay::{Delaunay, INFINITE, NoDelaunay};
use crate::geometry::{dot, minus, scaled};
use crate::poles::Poles;
use crate::reach::Reach;
use crate::sampling::SamplingCondition;
use crate::sides::Sides;
use crate::surface::{LeftOut, Reconstruction, of_vertices};

/// A surface where a signed function changes its sign.
#[derive(Clone, Debug, PartialEq)]
pub struct Natural {
    /// The surface.
    pub surface: Reconstruction,
    /// Tetrahedra at whose centres tangent planes disagree about the side.
    pub mixed: usize,
    /// Tetrahedra for which the function is not known, so that the sides of their neighbours decide.
    pub by_side: usize,
    /// Points whose two poles are on one side: there is no inside and outside there.
    pub one_sided: usize,
    /// Facets left out as lids.
    pub lids: usize,
    /// The sampling condition of the theorem.
    pub sampling: SamplingCondition,
}

/// The largest sampling ratio ε for which the theorem holds, as seed 002 states it.
pub const NATURAL_BOUND: f64 = 0.25;

/// Reconstructs the surface of a body by natural neighbours.
///
/// # Errors
///
/// Points that do not span space.
pub fn natural(points_mm: &[PointMm]) -> Result<Natural, NoDelaunay> {
    let delaunay = Delaunay::new(points_mm)?;
    let centres = centres::of(&delaunay);
    let poles = Poles::of(&delaunay, &centres);
    let sides = Sides::of(&delaunay, &centres, &poles, 0.0);
    let (outward, one_sided) = outward(&poles, &sides);
    let spheres: Vec<(PointMm, f64)> = (centres.iter().zip(&delaunay.corners))
        .map(|(&centre, corners)| {
            let way = minus(centre, delaunay.place(corners[0]));
            (centre, dot(way, way))
        })
        .collect();
    let function = Function { delaunay: &delaunay, spheres: &spheres, outward: &outward };
    let signs: Vec<Sign> = (0..delaunay.tetrahedra as u32)
        .into_par_iter()
        .map_init(Room::default, |room, cell| function.sign(cell, room))
        .collect();
    let is_outside = |cell: u32| match signs.get(cell as usize) {
        Some(Sign::Inside(_)) => false,
        Some(Sign::Open) => sides.is_outside[cell as usize],
        _ => true,
    };
    let reach = Reach::of(&delaunay);
    let mut lids = 0;
    let mut facets = Vec::new();
    for (cell, slot) in delaunay.facets() {
        if is_outside(cell) == is_outside(delaunay.neighbours[cell as usize][slot]) {
            continue;
        }
        let facet = delaunay.facet(cell, slot);
        if reach.is_lid(&delaunay, facet) {
            lids += 1;
        } else {
            facets.push(facet);
        }
    }
    let mixed = |sign: &&Sign| matches!(sign, Sign::Inside(true) | Sign::Outside(true));
    Ok(Natural {
        mixed: signs.iter().filter(mixed).count(),
        by_side: signs.iter().filter(|sign| **sign == Sign::Open).count(),
        one_sided,
        lids,
        sampling: SamplingCondition::of(&delaunay.points_mm, &poles, &facets, NATURAL_BOUND),
        surface: of_vertices(points_mm, &delaunay, facets, LeftOut::NoFacet),
    })
}

/// Outward normals of vertices, and how many have both poles on one side.
fn outward(poles: &Poles, sides: &Sides) -> (Vec<Option<PointMm>>, usize) {
    let is_outside = |cell: u32| cell == INFINITE || sides.is_outside[cell as usize];
    let one_sided = (poles.cells.iter().zip(&poles.second))
        .filter(|&(&[one, other], second)| second.is_some() && is_outside(one) == is_outside(other))
        .count();
    let outward = (poles.normals.iter().zip(&poles.cells)).map(|(normal, &[first, _])| {
        normal.map(|normal| if is_outside(first) { normal } else { scaled(normal, -1.0) })
    });
    (outward.collect(), one_sided)
}
