//! What a window is fitted to: means of cells, or the samples themselves where it is only a few cells wide.

use asphera_geometry::VertexId;

use super::Samples;
use super::cells::{Cells, QUARTIC, height_mm, quartic};
use super::fit::{Row, TERMS};

/// Adds the mean of each cell whose centre lies in a window.
pub(super) fn rows_of_cells(
    cells: &Cells,
    (centre_mm, half_mm): ([f64; 2], f64),
    jumps: impl Fn(&[VertexId], &mut [f64; TERMS]),
    rows: &mut Vec<Row>,
) {
    let [along, across] = places(cells, (centre_mm, half_mm), 0.0);
    for row in across.clone() {
        for column in along.clone() {
            let Some(cell) = cells.at(column, row) else { continue };
            let moments = &cells.moments[cell];
            let at = cells.centre_mm(cell);
            let [x, y] = [0, 1].map(|axis| (at[axis] - centre_mm[axis]) / half_mm);
            let mut terms = [0.0; TERMS];
            terms[..QUARTIC].copy_from_slice(&moments.terms(x, y, cells.side_mm / half_mm));
            jumps(cells.members(cell), &mut terms);
            rows.push(Row {
                terms,
                height_mm: moments.height_mm,
                count: moments.count,
                place: [(column - along.start) as usize, (row - across.start) as usize],
            });
        }
    }
}

/// Adds each sample in a window, which is too narrow for means.
pub(super) fn rows_of_samples(
    (samples, cells): (&Samples<'_>, &Cells),
    (centre_mm, half_mm): ([f64; 2], f64),
    jumps: impl Fn(&[VertexId], &mut [f64; TERMS]),
    rows: &mut Vec<Row>,
) {
    let [along, across] = places(cells, (centre_mm, half_mm), 0.5);
    let all = across.flat_map(|row| along.clone().map(move |column| (column, row)));
    for cell in all.filter_map(|(column, row)| cells.at(column, row)) {
        for vertex in cells.members(cell) {
            let point = samples.points[*vertex as usize];
            let [x, y] = [0, 1].map(|axis| (point[axis] - centre_mm[axis]) / half_mm);
            if x.abs() > 1.0 || y.abs() > 1.0 {
                continue;
            }
            let mut terms = [0.0; TERMS];
            terms[..QUARTIC].copy_from_slice(&quartic(x, y));
            jumps(std::slice::from_ref(vertex), &mut terms);
            let height_mm = height_mm(samples, *vertex);
            let place = [x, y].map(|at| ((at + 1.0) * 0.5 * SQUARES) as usize);
            rows.push(Row { terms, height_mm, count: 1.0, place });
        }
    }
}

/// Columns and rows of the cells whose centres lie in a window, or so many sides beyond it.
fn places(
    cells: &Cells,
    (centre_mm, half_mm): ([f64; 2], f64),
    beyond: f64,
) -> [std::ops::Range<i64>; 2] {
    [0, 1].map(|axis| {
        let place = |at: f64| (at - cells.low_mm[axis]) / cells.side_mm - 0.5;
        let first = (place(centre_mm[axis] - half_mm) - beyond).ceil().max(0.0) as i64;
        let end = (place(centre_mm[axis] + half_mm) + beyond).ceil();
        first..end.min(cells.size[axis] as f64) as i64
    })
}

/// Squares along a window of samples, by which neighbours of what stands off are told.
const SQUARES: f64 = 8.0;
