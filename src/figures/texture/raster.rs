//! A mesh evaluated at the nodes of a regular grid.

use super::cells::box_of;
use super::{Grid, Mesh};
use crate::Lattice;

impl Mesh {
    /// The surface on a grid. Where its vertices lie on a raster, at the nodes of that, as they are; the grid is then turned
    /// as the raster is. Else interpolated linearly on its measured triangles, at nodes as far apart as its vertices are on
    /// the average, or farther where that takes more than 4,000,000; nodes elsewhere are gaps. `None` without a
    /// measured triangle. Takes time in proportion to vertices, triangles and nodes.
    pub fn to_grid(&self) -> Option<Grid> {
        self.to_turned_grid().map(|(grid, _)| grid)
    }

    /// As [`Mesh::to_grid`], with the angle in rad from +x towards +y of its rows.
    pub(super) fn to_turned_grid(&self) -> Option<(Grid, f64)> {
        let Some(lattice) = Lattice::find(self.places_mm(), self.triangles()) else {
            return self.interpolated().map(|grid| (grid, 0.0));
        };
        self.whole_triangles().next()?;
        let at = |place: Option<usize>| place.and_then(|place| self.at(place)).unwrap_or(f64::NAN);
        let heights_nm: Vec<f64> = lattice.places().map(at).collect();
        let (rows, columns) = (lattice.rows(), lattice.columns());
        let grid = Grid::new(&heights_nm, rows, columns, lattice.spacing_mm())
            .expect("a lattice has rows times columns nodes at positive distances");
        Some((grid, lattice.turn_rad()))
    }

    fn interpolated(&self) -> Option<Grid> {
        let corners = self.whole_triangles().flatten().map(|(place, _)| place);
        let [low_mm, high_mm] = box_of(corners)?;
        let mut spacing_mm = self.mean_spacing_mm()?;
        let nodes = |spacing_mm: f64| {
            [0, 1].map(|axis| ((high_mm[axis] - low_mm[axis]) / spacing_mm).floor() + 1.0)
        };
        while nodes(spacing_mm).iter().product::<f64>() > MOST_NODES {
            spacing_mm *= 1.2;
        }
        let [columns, rows] = nodes(spacing_mm).map(|nodes| nodes as usize);
        let mut heights_nm = vec![f64::NAN; rows * columns];
        for triangle in self.whole_triangles() {
            let [(a, _), (b, _), (c, _)] = triangle;
            let doubled = cross(b, c, a);
            if doubled == 0.0 {
                continue;
            }
            let ends = |axis: usize, nodes: usize| {
                let [low, high] = [a, b, c]
                    .map(|corner| (corner[axis] - low_mm[axis]) / spacing_mm)
                    .iter()
                    .fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], &at| {
                        [low.min(at), high.max(at)]
                    });
                (low - EDGE).ceil().max(0.0) as usize
                    ..=((high + EDGE).floor() as usize).min(nodes - 1)
            };
            for row in ends(1, rows) {
                for column in ends(0, columns) {
                    let at = [
                        low_mm[0] + column as f64 * spacing_mm,
                        low_mm[1] + row as f64 * spacing_mm,
                    ];
                    let shares = [cross(b, c, at), cross(c, a, at), cross(a, b, at)];
                    let shares = shares.map(|share| share / doubled);
                    // A node on an edge belongs to both triangles, which agree about it.
                    if shares.iter().all(|share| *share >= -EDGE) {
                        let heights = triangle.iter().zip(shares);
                        heights_nm[row * columns + column] =
                            heights.map(|((_, height_nm), share)| share * height_nm).sum();
                    }
                }
            }
        }
        Some(
            Grid::new(&heights_nm, rows, columns, [spacing_mm; 2])
                .expect("rows times columns heights at a positive distance"),
        )
    }

    /// Root of the area a vertex stands for on the average; `None` without an area.
    pub(super) fn mean_spacing_mm(&self) -> Option<f64> {
        let points = self.areas_mm2().iter().filter(|area| **area > 0.0).count();
        let spacing_mm = (self.areas_mm2().iter().sum::<f64>() / points as f64).sqrt();
        (spacing_mm.is_finite() && spacing_mm > 0.0).then_some(spacing_mm)
    }
}

/// Twice the area of a, b and a place, positive where that lies to the left of the way from a to b.
fn cross(a: [f64; 2], b: [f64; 2], at: [f64; 2]) -> f64 {
    (b[0] - a[0]) * (at[1] - a[1]) - (b[1] - a[1]) * (at[0] - a[0])
}

/// So much beyond an edge, in shares of the triangle and in nodes, counts as on it.
const EDGE: f64 = 1e-9;
const MOST_NODES: f64 = 4e6;
