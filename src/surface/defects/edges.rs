//! Form that is alike along the borders of a surface.
//!
//! An edge that is turned down bends the windows near it, each in its own way by how it lies to the border. Judged piece by
//! piece some of what they leave is form, and some is too weak or too steep to be told so. But such an edge is alike along
//! the border, while a pit or a scratch covers a small part of what lies as near to the border. So it is judged by bands
//! that follow the border.

use std::collections::BTreeSet;

use super::cells::Cells;

/// Stretches of the border, each with the rings of cells that are nearest to it.
pub(super) struct Edges {
    /// By stretch, from the border inwards.
    rings: Vec<Vec<Vec<usize>>>,
}

impl Edges {
    /// Rings of the cells that are no farther from a border than some way.
    pub(super) fn new(cells: &Cells, reach_mm: f64) -> Edges {
        let reach = (reach_mm / cells.side_mm).round() as usize;
        let counts = cells.size.map(|count| ((count as f64 / WAY) as usize).max(1));
        let square = |cell: usize| {
            let [column, row] = [0, 1]
                .map(|axis| cells.places[cell][axis] as usize * counts[axis] / cells.size[axis]);
            row * counts[0] + column
        };
        let mut rings = vec![vec![Vec::new(); reach]; counts[0] * counts[1]];
        let at_border =
            |cell: usize| STRAIGHT.iter().any(|&step| beside(cells, cell, step).is_none());
        // What was reached, by the way from the border, with the stretch it begins at.
        let mut open: BTreeSet<(usize, usize, usize)> = (0..cells.len())
            .filter(|&cell| at_border(cell))
            .map(|cell| (0, cell, square(cell)))
            .collect();
        let mut seen = vec![false; cells.len()];
        while let Some((way, cell, stretch)) = open.pop_first() {
            if seen[cell] || way / ACROSS >= reach {
                continue;
            }
            seen[cell] = true;
            rings[stretch][way / ACROSS].push(cell);
            for (steps, length) in [(STRAIGHT, ACROSS), (SLANTED, SLANT)] {
                for other in steps.into_iter().filter_map(|step| beside(cells, cell, step)) {
                    if !seen[other] {
                        open.insert((way + length, other, stretch));
                    }
                }
            }
        }
        Edges { rings }
    }

    /// The cells of the bands that are `form`: of each stretch of the border as far inwards as that goes on. It may begin
    /// within half of the way only, for windows that reach beyond an edge may be right at the border itself.
    pub(super) fn inwards(&self, form: impl Fn(&[Vec<usize>]) -> bool) -> Vec<Vec<usize>> {
        let mut all = Vec::new();
        for rings in &self.rings {
            let bands: Vec<&[Vec<usize>]> = rings.chunks(BAND).collect();
            let is_form: Vec<bool> = bands
                .iter()
                .map(|band| band.iter().map(Vec::len).sum::<usize>() >= LEAST && form(band))
                .collect();
            let Some(first) = is_form.iter().position(|&form| form) else { continue };
            if 2 * first < bands.len() {
                let on = is_form[first..].iter().take_while(|&&form| form).count();
                all.extend(bands[..first + on].iter().map(|band| band.concat()));
            }
        }
        all
    }
}

/// The cell at a step from another.
fn beside(cells: &Cells, cell: usize, step: [i64; 2]) -> Option<usize> {
    let [column, row] = cells.places[cell].map(i64::from);
    cells.at(column + step[0], row + step[1])
}

/// Steps to cells that share a side, and to those that share a corner, with their lengths in fifths of a side.
const STRAIGHT: [[i64; 2]; 4] = [[-1, 0], [1, 0], [0, -1], [0, 1]];
const SLANTED: [[i64; 2]; 4] = [[-1, -1], [1, -1], [-1, 1], [1, 1]];
const ACROSS: usize = 5;
const SLANT: usize = 7;
/// Cells along the side of a square that holds a stretch of the border: 120 spacings, or more. The largest pit moves windows
/// over less than half of that.
const WAY: f64 = 48.0;
/// Rings of a band: together as wide as half a wave of what a quartic over the widest windows misses.
const BAND: usize = 3;
/// Fewest cells of a band: those of a stretch that is as long as the square is wide.
const LEAST: usize = 144;
