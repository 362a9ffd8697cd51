//! How far the reference does not follow the form.
//!
//! What a quartic over a window of width w misses falls with the fifth power of w, so a reference of half the width shows
//! it: nearly all of what the two differ by is the wider one's, or noise. It is the largest along borders, where no other
//! window takes part. A defect may make them differ too, but only over a small share of what lies within a window of it,
//! while form that is not followed does so all about: the median tells it.

use super::cells::Cells;
use super::reference::Reference;
use super::tail;

/// What the first of two references misses about each cell, in mm along the normal; 0 where it does not stand out from the
/// noise of the two, and where there is none. `window_mm` is the width of its windows, the other's are half as wide.
pub(super) fn missed_mm(
    cells: &Cells,
    [reference, half]: [&Reference; 2],
    window_mm: f64,
) -> Vec<f64> {
    let rim = ((RIM * window_mm / cells.side_mm).round() as i64).max(1);
    let apart: Vec<Option<Apart>> =
        (0..cells.len()).map(|cell| Apart::of(cells, cell, [reference, half], rim)).collect();
    // Cells by the squares of a coarse grid, and by how near to a border they are.
    let side = ((SQUARE * window_mm / cells.side_mm).round() as u32).max(1);
    let size = cells.size.map(|count| count.div_ceil(side as usize) + 2);
    let none: [Vec<Apart>; ZONES] = Default::default();
    let mut squares = vec![none; size[0] * size[1]];
    let square = |cell: usize| {
        let [column, row] = cells.places[cell].map(|place| (place / side) as usize + 1);
        row * size[0] + column
    };
    for (cell, apart) in apart.iter().enumerate() {
        if let Some(apart) = apart {
            squares[square(cell)][apart.zone].push(*apart);
        }
    }
    let medians: Vec<[f64; ZONES]> = (0..squares.len())
        .map(|at| {
            let [column, row] = [at % size[0], at / size[0]];
            let mut inner = 0.0;
            std::array::from_fn(|zone| {
                let rows = row.saturating_sub(1)..(row + 2).min(size[1]);
                let about = rows.flat_map(|row| {
                    (column.saturating_sub(1)..(column + 2).min(size[0]))
                        .map(move |column| row * size[0] + column)
                });
                let found = missed(about.flat_map(|at| squares[at][zone].iter().copied()));
                // Too few cells so near to a border: as much at least as a little farther in.
                inner = found.unwrap_or(inner);
                inner
            })
        })
        .collect();
    let of = |(cell, apart): (usize, &Option<Apart>)| {
        apart.map_or(0.0, |apart| medians[square(cell)][apart.zone])
    };
    apart.iter().enumerate().map(of).collect()
}

/// What two references differ by in a cell.
#[derive(Clone, Copy)]
struct Apart {
    size_mm: f64,
    /// Standard deviation of that for samples of deviation 1.
    noise: f64,
    /// Mean residual and samples, by which the noise is told.
    scatter_mm: f64,
    /// How near to a border it is, by how well the wider reference is told there. It is told less well along a scratch, too.
    zone: usize,
}

/// Whether a cell within `reach` columns and rows is missing.
fn is_at_border(cells: &Cells, cell: usize, reach: i64) -> bool {
    let [column, row] = cells.places[cell].map(i64::from);
    let mut about = (-reach..=reach).flat_map(|i| (-reach..=reach).map(move |j| [i, j]));
    about.any(|[i, j]| cells.at(column + i, row + j).is_none())
}

impl Apart {
    fn of(cells: &Cells, cell: usize, [wide, half]: [&Reference; 2], rim: i64) -> Option<Apart> {
        let count = cells.range(cell).len() as f64;
        let sum = |of: fn(f64, f64) -> f64| -> f64 {
            let range = cells.range(cell);
            let pairs = wide.residuals_mm[range.clone()].iter().zip(&half.residuals_mm[range]);
            pairs.map(|(wide, half)| of(*wide, *half)).sum()
        };
        let size_mm = (sum(|wide, half| wide - half) / count).abs() / wide.secants[cell];
        let square_mm2 = sum(|_, half| half * half) / count / wide.secants[cell].powi(2);
        let noise = wide.uncertainties[cell].hypot(half.uncertainties[cell]);
        let zone = BORDERS.iter().filter(|&&share| wide.uncertainties[cell] > share * wide.typical);
        let zone = match zone.count() {
            0 => 0,
            zone if is_at_border(cells, cell, rim) => zone,
            _ => 0,
        };
        let scatter_mm = square_mm2.sqrt();
        let known = size_mm.is_finite() && noise.is_finite() && scatter_mm.is_finite();
        known.then_some(Apart { size_mm, noise, scatter_mm, zone })
    }
}

/// What is missed in the middle of cells, less the noise; `None` of too few.
fn missed(cells: impl Iterator<Item = Apart>) -> Option<f64> {
    let (mut sizes, mut noises, mut scatters) = (Vec::new(), Vec::new(), Vec::new());
    for apart in cells {
        sizes.push(apart.size_mm);
        noises.push(apart.noise);
        scatters.push(apart.scatter_mm);
    }
    if sizes.len() < LEAST {
        return None;
    }
    let [size, noise, scatter] = [sizes, noises, scatters].map(|mut all| {
        let middle = all.len() / 2;
        *all.select_nth_unstable_by(middle, f64::total_cmp).1
    });
    let by_noise = noise * scatter;
    let whole = tail::NORMAL * size;
    Some((whole * whole - by_noise * by_noise).max(0.0).sqrt())
}

/// Uncertainty of the reference from which on a zone nearer to a border begins, over the median of all: it is about 2 at a
/// straight border and 4 in a corner.
const BORDERS: [f64; 3] = [1.5, 2.0, 2.6];
const ZONES: usize = BORDERS.len() + 1;
/// Side of a square of the coarse grid in windows; three by three count for each.
const SQUARE: f64 = 0.5;
/// How near to a border its zones reach, in windows.
const RIM: f64 = 0.25;
/// Fewer cells have no median that a defect among them would not move.
const LEAST: usize = 24;
