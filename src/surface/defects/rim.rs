//! Windows along a border that the lattice of windows does not follow.

use super::cells::Cells;
use super::fit::Work;
use super::reference::{Blend, Patch, Told, patch};

/// Windows of their own for the cells whose height no window of the lattice tells.
pub(super) struct Rim {
    windows: Vec<Patch>,
    /// By cell, which of them.
    of: Vec<Option<usize>>,
}

impl Rim {
    /// Cell after cell that no window tells well gets one, moved inwards until the cell lies at its rim; it counts for all
    /// other cells it tells better.
    pub(super) fn new(blend: &Blend<'_>, cells: &Cells) -> Rim {
        let mut rim = Rim { windows: Vec::new(), of: vec![None; cells.len()] };
        let known: Vec<Option<Told>> =
            (0..cells.len()).map(|cell| blend.told(cells.centre_mm(cell))).collect();
        let poor = |&cell: &usize| known[cell].is_none_or(|told| told.loss > POOR);
        let mut left: Vec<usize> = (0..cells.len()).filter(poor).collect();
        let most = blend.patches.len() + SPARE;
        let mut work = Work::default();
        while let Some(&first) = left.first()
            && rim.windows.len() < most
        {
            left.remove(0);
            let centre_mm = inwards_mm(cells, blend.lattice.half_mm, first);
            let (samples, lattice) = (blend.samples, blend.lattice);
            let Some(window) = patch(samples, cells, lattice, blend.steps, centre_mm, &mut work)
            else {
                continue;
            };
            let tells = |cell: usize| {
                let place_mm = cells.centre_mm(cell);
                let within = |axis: usize| {
                    (place_mm[axis] - centre_mm[axis]).abs() <= 1.01 * lattice.half_mm
                };
                let variance = blend.variance(&window, place_mm);
                let better = known[cell].is_none_or(|told| variance < BETTER * told.variance);
                within(0) && within(1) && window.sees(variance) && better
            };
            let index = rim.windows.len();
            if tells(first) {
                rim.of[first] = Some(index);
            }
            left.retain(|&cell| {
                let told = tells(cell);
                if told {
                    rim.of[cell] = Some(index);
                }
                !told
            });
            rim.windows.push(window);
        }
        rim
    }

    /// The window of a cell, if it has one of its own.
    pub(super) fn of(&self, cell: usize) -> Option<&Patch> {
        self.of[cell].map(|index| &self.windows[index])
    }
}

/// The centre of a window at whose rim a cell lies, over as many samples as can be: as far beyond the middle of what lies
/// about the cell as the cell is before it.
fn inwards_mm(cells: &Cells, half_mm: f64, cell: usize) -> [f64; 2] {
    let reach = (half_mm / cells.side_mm).floor() as i64;
    let place = cells.places[cell].map(i64::from);
    let (mut sums, mut count) = ([0_i64; 2], 0_i64);
    for row in place[1] - reach..=place[1] + reach {
        for column in place[0] - reach..=place[0] + reach {
            if cells.at(column, row).is_some() {
                sums[0] += column - place[0];
                sums[1] += row - place[1];
                count += 1;
            }
        }
    }
    let from = cells.centre_mm(cell);
    [0, 1].map(|axis| {
        let away_mm = 2.0 * sums[axis] as f64 / count as f64 * cells.side_mm;
        from[axis] + away_mm.clamp(-half_mm, half_mm)
    })
}

/// Variance over that of a mean of all samples from which on a window of its own may tell a cell better: at the middle of the
/// side of a square it is 37.5.
const POOR: f64 = 50.0;
/// How much smaller its variance must then be.
const BETTER: f64 = 0.7;
/// So many windows there may be where the lattice has next to none.
const SPARE: usize = 64;
