//! Euler numbers of the solid from the histogram.

use crate::Histogram;
use crate::cell::{EDGES, FACES};

/// Euler number of the union of closed voxels, where samples that share a corner of their voxels are connected (26).
///
/// ```text
/// χ = Σ over cells of [any] − ½ faces with any + ¼ edges with any − ⅛ foreground corners
/// ```
pub fn euler_26(histogram: &Histogram) -> i64 {
    let eighths = histogram.sum_whole(|code| {
        let any = |corners: &[usize]| corners.iter().any(|&corner| code >> corner & 1 == 1);
        let faces = FACES.iter().filter(|face| any(&face[..])).count() as i64;
        let edges = EDGES.iter().filter(|edge| any(&edge[..])).count() as i64;
        8 * i64::from(code != 0) - 4 * faces + 2 * edges - i64::from(code.count_ones())
    });
    eighths / 8
}

/// Euler number of the union of open voxels, where only samples that share a face of their voxels are connected (6).
///
/// ```text
/// χ = Σ over cells of ⅛ foreground corners − ¼ edges with both + ½ faces with all four − [all]
/// ```
pub fn euler_6(histogram: &Histogram) -> i64 {
    let eighths = histogram.sum_whole(|code| {
        let all = |corners: &[usize]| corners.iter().all(|&corner| code >> corner & 1 == 1);
        let faces = FACES.iter().filter(|face| all(&face[..])).count() as i64;
        let edges = EDGES.iter().filter(|edge| all(&edge[..])).count() as i64;
        i64::from(code.count_ones()) - 2 * edges + 4 * faces - 8 * i64::from(code == 255)
    });
    eighths / 8
}
