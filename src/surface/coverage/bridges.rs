//! Which triangles that are not covered bridge what nobody scanned.

use asphera_geometry::{Gap, PointMm, Triangle, VertexId};
use rayon::prelude::*;

use super::gauge::{Gauged, Standing};

/// Tells which open triangles are bridges: for each vertex the smallest gap of a triangle there tells how far
/// apart samples are about it. A bridge has a large gap, but of the triangles at a sample on the rim of a
/// hole some are surface.
///
/// One look at each triangle, and more only at those beside open ones.
pub(super) fn find_bridges(
    points: &[PointMm],
    triangles: &[[VertexId; 3]],
    refined: &[(usize, Gap)],
    open: &mut [Gauged],
) {
    if open.iter().all(|gauged| gauged.standing == Standing::Bridge) {
        return;
    }
    let mut is_asked = vec![false; points.len()];
    for corner in open.iter().flat_map(|gauged| triangles[gauged.index]) {
        is_asked[corner as usize] = true;
    }
    let beside: Vec<usize> = triangles
        .par_iter()
        .with_min_len(CHUNK)
        .enumerate()
        .filter(|(_, corners)| corners.iter().any(|&corner| is_asked[corner as usize]))
        .map(|(index, _)| index)
        .collect();
    let mut about_mm = vec![f64::INFINITY; points.len()];
    let mut note = |index: usize, gap_mm: f64| {
        for corner in triangles[index] {
            let about_mm = &mut about_mm[corner as usize];
            *about_mm = about_mm.min(gap_mm);
        }
    };
    for &index in &beside {
        note(index, Triangle::new(points, triangles[index]).gap().mm);
    }
    // These are smaller than the corners alone tell.
    refined.iter().for_each(|(index, gap)| note(*index, gap.mm));
    for gauged in open {
        let corners = triangles[gauged.index].iter();
        let about_mm = corners.map(|&corner| about_mm[corner as usize]).fold(0.0, f64::max);
        if gauged.gap.mm > BRIDGE * about_mm {
            gauged.standing = Standing::Bridge;
        }
    }
}

/// Triangles of which one thread takes care.
const CHUNK: usize = 1 << 14;

/// A triangle bridges if its gap is more than so many times the smallest gap at each of its corners.
/// On a raster that is a hole of about five spacings across; scattered samples rarely have it.
const BRIDGE: f64 = 3.0;
