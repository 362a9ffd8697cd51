//! Poles: for each point the farthest corner of its Voronoi cell, and the farthest on the other side (N. Amenta, M. Bern 1999).
//!
//! On a dense sample the way to a pole is nearly the normal, and the poles lie near the medial axis: the distance from a point to
//! the nearest pole of all estimates its local feature size.

use asphera_geometry::{PointMm, WeightedTree};
use rayon::prelude::*;

use crate::delaunay::{Delaunay, INFINITE};
use crate::geometry::{dot, double_area, minus, scaled, unit};

/// The poles of all vertices.
pub(crate) struct Poles {
    /// Unit vectors to the first pole; `None` where there is no direction.
    pub(crate) normals: Vec<Option<PointMm>>,
    /// The first pole; `None` of a vertex of the hull, whose cell is infinite.
    pub(crate) first: Vec<Option<PointMm>>,
    /// The pole on the other side.
    pub(crate) second: Vec<Option<PointMm>>,
    /// The tetrahedra whose centres they are, the first and the second; [`INFINITE`] where there is none.
    pub(crate) cells: Vec<[u32; 2]>,
}

impl Poles {
    pub(crate) fn of(delaunay: &Delaunay, centres: &[PointMm]) -> Poles {
        let outward = outward(delaunay);
        let mut farthest: Vec<(f64, u32)> = vec![(-1.0, 0); delaunay.points_mm.len()];
        let square = |cell: usize, corner: u32| {
            let way = minus(centres[cell], delaunay.place(corner));
            dot(way, way)
        };
        for (cell, corners) in delaunay.corners[..delaunay.tetrahedra].iter().enumerate() {
            for &corner in corners {
                let far = square(cell, corner);
                // Of equal distances the first by coordinates, so that the order of cells does not matter.
                let best = &mut farthest[corner as usize];
                if far > best.0 || (far == best.0 && centres[cell] < centres[best.1 as usize]) {
                    *best = (far, cell as u32);
                }
            }
        }
        let (normals, first): (Vec<_>, Vec<Option<PointMm>>) =
            (farthest.par_iter().zip(&outward).enumerate())
                .map(|(vertex, (&(far, cell), outward))| {
                    if *outward != [0.0; 3] {
                        return (unit(*outward), None);
                    }
                    let pole = (far >= 0.0).then(|| centres[cell as usize]);
                    (pole.and_then(|pole| unit(minus(pole, delaunay.points_mm[vertex]))), pole)
                })
                .unzip();
        let mut opposite: Vec<(f64, u32)> = vec![(-1.0, 0); delaunay.points_mm.len()];
        for (cell, corners) in delaunay.corners[..delaunay.tetrahedra].iter().enumerate() {
            for &corner in corners {
                let Some(normal) = normals[corner as usize] else { continue };
                let way = minus(centres[cell], delaunay.place(corner));
                let far = dot(way, way);
                let best = &mut opposite[corner as usize];
                let is_farther =
                    far > best.0 || (far == best.0 && centres[cell] < centres[best.1 as usize]);
                if is_farther && dot(way, normal) < 0.0 {
                    *best = (far, cell as u32);
                }
            }
        }
        let second = opposite
            .iter()
            .map(|&(far, cell)| (far >= 0.0).then(|| centres[cell as usize]))
            .collect();
        let numbered = |(far, cell): (f64, u32), is_there: bool| {
            if far >= 0.0 && is_there { cell } else { INFINITE }
        };
        let cells = (farthest.iter().zip(opposite).zip(&first))
            .map(|((&one, other), first)| [numbered(one, first.is_some()), numbered(other, true)])
            .collect();
        Poles { normals, first, second, cells }
    }

    /// The distance from each place to the nearest pole, mm.
    pub(crate) fn feature_sizes_mm(&self, places: &[PointMm]) -> Vec<f64> {
        let poles: Vec<PointMm> =
            self.first.iter().chain(&self.second).flatten().copied().collect();
        let tree = WeightedTree::of_points(&poles);
        let of = |&place: &PointMm| tree.least(place).unwrap_or(f64::INFINITY);
        places.par_iter().map(of).collect()
    }
}

/// Sums of the unit normals of the hull facets at each vertex; zero inside.
fn outward(delaunay: &Delaunay) -> Vec<PointMm> {
    let mut sums = vec![[0.0; 3]; delaunay.points_mm.len()];
    for cell in delaunay.tetrahedra as u32..delaunay.corners.len() as u32 {
        let normal = outward_normal(delaunay, cell);
        for &corner in &delaunay.corners[cell as usize][..3] {
            let sum = &mut sums[corner as usize];
            *sum = [0, 1, 2].map(|axis| sum[axis] + normal[axis]);
        }
    }
    sums
}

/// The unit normal of the hull facet of a cell at infinity.
pub(crate) fn outward_normal(delaunay: &Delaunay, cell: u32) -> PointMm {
    let [a, b, c, _] = delaunay.corners[cell as usize];
    let [a, b, c] = [a, b, c].map(|corner| delaunay.place(corner));
    // Seen from outside they turn clockwise.
    unit(scaled(double_area([a, b, c]), -1.0)).unwrap_or([0.0; 3])
}
