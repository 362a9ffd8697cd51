//! Geometric convection (R. Chaine 2003): the convex hull shrinks along the flow towards the points.
//!
//! A facet of the moving surface lets it pass where the smallest ball about it holds the point behind. What the surface has not
//! reached stays; its border is the result. Where it closes upon itself both sides vanish. Pockets that no open facet leads to stay filled.

use asphera_geometry::PointMm;
use asphera_geometry::predicates::in_facet_ball;

use crate::delaunay::{Delaunay, NoDelaunay};
use crate::surface::{LeftOut, Reconstruction, of_vertices};

/// Reconstructs a closed surface by geometric convection. There is no theorem about it.
///
/// # Errors
///
/// Points that do not span space.
pub fn convection(points_mm: &[PointMm]) -> Result<Reconstruction, NoDelaunay> {
    let delaunay = Delaunay::new(points_mm)?;
    let cells = delaunay.corners.len() as u32;
    let mut is_passed = vec![false; cells as usize];
    let mut front: Vec<u32> = (delaunay.tetrahedra as u32..cells).collect();
    for &cell in &front {
        is_passed[cell as usize] = true;
    }
    while let Some(cell) = front.pop() {
        for slot in 0..4 {
            let next = delaunay.neighbours[cell as usize][slot];
            if is_passed[next as usize] {
                continue;
            }
            let back = delaunay.slot_toward(next, cell);
            let facet = delaunay.facet(next, back).map(|corner| delaunay.place(corner));
            let behind = delaunay.place(delaunay.corners[next as usize][back]);
            if in_facet_ball(facet, behind).is_gt() {
                is_passed[next as usize] = true;
                front.push(next);
            }
        }
    }
    let border = delaunay.facets().filter(|&(cell, slot)| {
        let other = delaunay.neighbours[cell as usize][slot];
        is_passed[cell as usize] != is_passed[other as usize]
    });
    let facets = border.map(|(cell, slot)| delaunay.facet(cell, slot)).collect();
    Ok(of_vertices(points_mm, &delaunay, facets, LeftOut::NoFacet))
}
