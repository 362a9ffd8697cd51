//! Surface texture: analytic truths, laws, gaps and degenerate input, and figures by other software.

mod dense;
mod gaps;
mod known;
mod laws;
mod oracle;
mod real;

use asphera_figures::texture::{Grid, Mesh};
use asphera_form::PointMm;

/// Heights in nm of a function of the place in mm.
pub(crate) fn grid(
    rows: usize,
    columns: usize,
    spacing_mm: [f64; 2],
    height_nm: impl Fn(f64, f64) -> f64,
) -> Grid {
    let heights: Vec<f64> = (0..rows * columns)
        .map(|i| {
            let (row, column) = (i / columns, i % columns);
            height_nm(column as f64 * spacing_mm[0], row as f64 * spacing_mm[1])
        })
        .collect();
    Grid::new(&heights, rows, columns, spacing_mm).unwrap()
}

/// Places of a grid of points, each cell divided into two triangles, with heights in nm.
pub(crate) fn mesh(
    rows: u32,
    columns: u32,
    place: impl Fn(u32, u32) -> [f64; 2],
    height_nm: impl Fn(f64, f64) -> f64,
) -> Mesh {
    let nodes = (0..rows).flat_map(|i| (0..columns).map(move |j| (i, j)));
    let points: Vec<PointMm> =
        nodes.map(|(i, j)| place(i, j)).map(|[x, y]| [x, y, height_nm(x, y) * 1e-6]).collect();
    Mesh::new(&points, &lattice(rows, columns)).unwrap()
}

/// Two triangles for each cell of a grid of points.
pub(crate) fn lattice(rows: u32, columns: u32) -> Vec<[u32; 3]> {
    let cells = (1..rows).flat_map(|i| (1..columns).map(move |j| (i - 1) * columns + j - 1));
    let divided =
        cells.flat_map(|c| [[c, c + 1, c + columns], [c + 1, c + columns + 1, c + columns]]);
    divided.collect()
}

/// The fraction of a multiple: evenly spread numbers from 0 to 1.
pub(crate) fn weyl(i: u32, factor: f64) -> f64 {
    (f64::from(i) * factor).fract()
}
