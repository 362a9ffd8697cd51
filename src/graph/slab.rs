//! The places of a strip in cells so small that the places of one are within τ of each other.
//!
//! So a cell is one piece from the start, and only cells near each other remain to be looked at, most of which are
//! joined already (the grid of A. Gunawan's DBSCAN, Master's thesis, TU Eindhoven 2013). The outcome is exact: pieces
//! are those of all pairs nearer than τ.

use std::collections::HashMap;

use asphera_geometry::{BoundsMm, Sets, greater};

use crate::cloud::{Cloud, PlaceId};
use crate::tree::squared_distance;

/// The grid of cells of a cloud for one τ.
#[derive(Clone, Debug)]
pub(crate) struct Grid<const D: usize> {
    low: [f64; D],
    side: f64,
    /// Cells over mm.
    per_mm: f64,
    /// Square of τ in mm².
    pub(crate) square: f64,
    /// Steps to cells with places that may be nearer than τ: all but the last axis, and how far along the last one.
    rows: Vec<([i32; D], i32)>,
}

/// Least and largest coordinates.
type BoxMm<const D: usize> = [[f64; D]; 2];

/// Least and largest numbers of cells.
type Extent<const D: usize> = [[i32; 2]; D];

/// The places of a strip, sorted by cell.
#[derive(Clone, Debug)]
pub(crate) struct Slab<const D: usize> {
    pub(crate) places: Vec<PlaceId>,
    pub(crate) cells: Vec<[i32; D]>,
    /// Where the places of each cell begin, and the end.
    starts: Vec<u32>,
    /// The boxes of the places of each cell, mm.
    pub(crate) boxes_mm: Vec<BoxMm<D>>,
    /// The piece of each cell.
    pub(crate) pieces: Vec<u32>,
    pub(crate) piece_count: u32,
}

impl<const D: usize> Grid<D> {
    /// `None` where a cell would be less than 2⁻³⁰ of the cloud.
    pub(crate) fn new(cloud: &Cloud<D>, tau_mm: f64) -> Option<Grid<D>> {
        let [low, high] = cloud.bounds_mm()?;
        let grid = Grid::about(low, tau_mm)?;
        grid.holds(&high).then_some(grid)
    }

    /// A grid with a corner of cells at `low`; `None` where the sides of cells vanish.
    pub(crate) fn about(low: [f64; D], tau_mm: f64) -> Option<Grid<D>> {
        // The share that is left off covers what rounding does to the numbers of cells.
        let side = tau_mm / (D as f64).sqrt() * (1.0 - 2e-6);
        if side.is_nan() || side <= 0.0 || (1.0 / side).is_infinite() {
            return None;
        }
        let mut rows = vec![([0; D], 0)];
        for axis in 0..D - 1 {
            let wide: Vec<_> = rows
                .iter()
                .flat_map(|(offset, _)| {
                    (-REACH..=REACH).map(move |step| {
                        let mut offset = *offset;
                        offset[axis] = step;
                        (offset, 0)
                    })
                })
                .collect();
            rows = wide;
        }
        // Squares of gaps in sides; τ² is D of them.
        let gap = |step: i32| (step.abs() - 1).max(0).pow(2);
        for (offset, along) in &mut rows {
            let across: i32 = offset.iter().map(|&step| gap(step)).sum();
            *along = (0..=REACH).rev().find(|&step| across + gap(step) <= D as i32).unwrap_or(-1);
        }
        rows.retain(|(_, along)| *along >= 0);
        // The nearest first: what is joined early need not be looked at again.
        rows.sort_by_key(|(offset, _)| {
            (offset.iter().map(|step| step * step).sum::<i32>(), *offset)
        });
        Some(Grid { low, side, per_mm: 1.0 / side, square: tau_mm * tau_mm, rows })
    }

    /// Whether the cell of a place has a number: one below 2³⁰.
    pub(crate) fn holds(&self, place: &[f64; D]) -> bool {
        let far = |axis: usize| ((place[axis] - self.low[axis]) / self.side).abs();
        (0..D).all(|axis| far(axis) < f64::from(1 << 30))
    }

    fn cell(&self, place: &[f64; D]) -> [i32; D] {
        std::array::from_fn(|axis| {
            let sides = (place[axis] - self.low[axis]) * self.per_mm;
            // `floor` is a call where a processor need not have it.
            let cut = sides as i32;
            cut - i32::from(f64::from(cut) > sides)
        })
    }

    /// Where a place lies in its cell, in 2⁻³⁶ of its sides. Sums of whole numbers do not depend on their order.
    pub(crate) fn in_cell(&self, place: &[f64; D], cell: &[i32; D]) -> [i64; D] {
        std::array::from_fn(|axis| {
            let sides = (place[axis] - self.low[axis]) * self.per_mm - f64::from(cell[axis]);
            (sides * FINE) as i64
        })
    }

    /// The mean of `count` places of a cell, of which the sum is that of [`Grid::in_cell`].
    pub(crate) fn mean(&self, cell: &[i32; D], sum: &[i64; D], count: u64) -> [f64; D] {
        std::array::from_fn(|axis| {
            let sides = f64::from(cell[axis]) + sum[axis] as f64 / FINE / count as f64;
            self.low[axis] + sides * self.side
        })
    }
}

impl<const D: usize> Slab<D> {
    /// Sorts places into cells and joins the cells to pieces, numbered by the order of the cells.
    pub(crate) fn new(all: &[[f64; D]], grid: &Grid<D>, places: Vec<PlaceId>) -> Slab<D> {
        // Of a scan some points that follow one another share a cell, so such runs are sorted, not points.
        let mut runs: Vec<([i32; D], u32, u32)> = Vec::new();
        for (at, &place) in places.iter().enumerate() {
            let cell = grid.cell(&all[place as usize]);
            match runs.last_mut() {
                Some((last, _, end)) if *last == cell => *end += 1,
                _ => runs.push((cell, at as u32, at as u32 + 1)),
            }
        }
        runs.sort_unstable();
        let mut slab = Slab {
            places: Vec::with_capacity(places.len()),
            cells: Vec::new(),
            starts: Vec::new(),
            boxes_mm: Vec::new(),
            pieces: Vec::new(),
            piece_count: 0,
        };
        for (cell, start, end) in runs {
            if slab.cells.last() != Some(&cell) {
                slab.cells.push(cell);
                slab.starts.push(slab.places.len() as u32);
            }
            slab.places.extend(&places[start as usize..end as usize]);
        }
        slab.starts.push(slab.places.len() as u32);
        slab.boxes_mm =
            (0..slab.cells.len()).map(|cell| bounds(all, slab.places_of(cell))).collect();
        (slab.pieces, slab.piece_count) = slab.join(all, grid).numbered();
        slab
    }

    /// The places of a cell.
    pub(crate) fn places_of(&self, cell: usize) -> &[PlaceId] {
        &self.places[self.starts[cell] as usize..self.starts[cell + 1] as usize]
    }

    /// The places of a cell and their box.
    fn boxed(&self, cell: usize) -> Boxed<'_, D> {
        Boxed { places: self.places_of(cell), box_mm: &self.boxes_mm[cell] }
    }

    fn join(&self, all: &[[f64; D]], grid: &Grid<D>) -> Sets {
        let mut sets = Sets::new(self.cells.len());
        let ahead = |(offset, _): &&([i32; D], i32)| *offset >= [0; D];
        let rows: Vec<_> = grid.rows.iter().filter(ahead).collect();
        let mut cursors = vec![0; rows.len()];
        for (at, cell) in self.cells.iter().enumerate() {
            for ((offset, along), cursor) in rows.iter().zip(&mut cursors) {
                let (from, to) = span(cell, offset, *along);
                advance(&self.cells, cursor, &from);
                let mut other = (*cursor).max(at + 1);
                while other < self.cells.len() && self.cells[other] <= to {
                    if sets.root(at) != sets.root(other) {
                        let [a, b] = [at, other].map(|cell| self.boxed(cell));
                        if has_nearer(all, a, b, grid.square) {
                            sets.join(at, other);
                        }
                    }
                    other += 1;
                }
            }
        }
        sets
    }

    /// Numbers of cells along each axis; `None` without places.
    fn extent(&self) -> Option<Extent<D>> {
        (!self.cells.is_empty()).then(|| {
            std::array::from_fn(|axis| {
                let along = || self.cells.iter().map(|cell| cell[axis]);
                [along().min(), along().max()].map(Option::unwrap_or_default)
            })
        })
    }

    /// Least squared distances in mm², below τ², between pieces of this strip and of another one: (piece here, piece there,
    /// square), sorted. `own` are the places that the numbers of this strip mean, `others` those of the other.
    pub(crate) fn arcs_to(
        &self,
        next: &Slab<D>,
        [own, others]: [&[[f64; D]]; 2],
        grid: &Grid<D>,
    ) -> Vec<(u32, u32, f64)> {
        let mut found: HashMap<(u32, u32), f64> = HashMap::new();
        // The pair of pieces met last and its least square up to now: neighbours are mostly of the same two.
        let mut last = ((u32::MAX, u32::MAX), grid.square);
        let mut cursors = vec![0; grid.rows.len()];
        let Some(extent) = next.extent() else { return Vec::new() };
        for (at, cell) in self.cells.iter().enumerate() {
            for ((offset, along), cursor) in grid.rows.iter().zip(&mut cursors) {
                let (from, to) = span(cell, offset, *along);
                if !has_row(&extent, &from) {
                    continue;
                }
                advance(&next.cells, cursor, &from);
                let mut other = *cursor;
                while other < next.cells.len() && next.cells[other] <= to {
                    let pair = (self.pieces[at], next.pieces[other]);
                    if pair != last.0 {
                        last = (pair, found.get(&pair).copied().unwrap_or(grid.square));
                    }
                    let (a, b) = (self.boxed(at), next.boxed(other));
                    if squared_gap(a.box_mm, b.box_mm) < last.1
                        && let Some(square) = least_below((own, a), (others, b), last.1)
                    {
                        found.insert(pair, square);
                        last.1 = square;
                    }
                    other += 1;
                }
            }
        }
        let mut arcs: Vec<_> = found.into_iter().map(|((a, b), square)| (a, b, square)).collect();
        arcs.sort_unstable_by_key(|&(a, b, _)| (a, b));
        arcs
    }
}

/// Places of a cell and their box.
#[derive(Clone, Copy)]
struct Boxed<'a, const D: usize> {
    places: &'a [PlaceId],
    box_mm: &'a BoxMm<D>,
}

/// The first and the last cell of a row beside a cell.
fn span<const D: usize>(cell: &[i32; D], offset: &[i32; D], along: i32) -> ([i32; D], [i32; D]) {
    let mut from: [i32; D] = std::array::from_fn(|axis| cell[axis] + offset[axis]);
    let mut to = from;
    from[D - 1] -= along;
    to[D - 1] += along;
    (from, to)
}

/// Whether a row may have cells.
fn has_row<const D: usize>(extent: &Extent<D>, row: &[i32; D]) -> bool {
    (0..D - 1).all(|axis| (extent[axis][0]..=extent[axis][1]).contains(&row[axis]))
}

/// Moves a cursor over sorted cells to the first one not before `from`.
fn advance<const D: usize>(cells: &[[i32; D]], cursor: &mut usize, from: &[i32; D]) {
    let near = cells[*cursor..].iter().take(NEAR).position(|cell| cell >= from);
    *cursor += match near {
        Some(steps) => steps,
        None => cells[*cursor..].partition_point(|cell| cell < from),
    };
}

/// Whether some pair of places is nearer than the root of `square`.
fn has_nearer<const D: usize>(
    all: &[[f64; D]],
    a: Boxed<'_, D>,
    b: Boxed<'_, D>,
    square: f64,
) -> bool {
    squared_gap(a.box_mm, b.box_mm) < square
        && a.places.iter().map(|&p| &all[p as usize]).any(|p| {
            squared_gap(&[*p, *p], b.box_mm) < square
                && b.places.iter().any(|&q| squared_distance(p, &all[q as usize]) < square)
        })
}

/// The least squared distance of a pair, where it is below `least`.
fn least_below<const D: usize>(
    (own, a): (&[[f64; D]], Boxed<'_, D>),
    (others, b): (&[[f64; D]], Boxed<'_, D>),
    least: f64,
) -> Option<f64> {
    let mut best = least;
    for p in a.places.iter().map(|&p| &own[p as usize]) {
        if squared_gap(&[*p, *p], b.box_mm) < best {
            for &q in b.places {
                best = best.min(squared_distance(p, &others[q as usize]));
            }
        }
    }
    (best < least).then_some(best)
}

fn bounds<const D: usize>(all: &[[f64; D]], places: &[PlaceId]) -> BoxMm<D> {
    let BoundsMm { low, high } = BoundsMm::about(places.iter().map(|&place| all[place as usize]));
    [low, high]
}

/// Square of what two boxes are apart, mm². Rounded as distances of places are, so it is never above one of theirs.
fn squared_gap<const D: usize>(a: &BoxMm<D>, b: &BoxMm<D>) -> f64 {
    let mut sum = 0.0;
    for axis in 0..D {
        let gap = greater(greater(b[0][axis] - a[1][axis], a[0][axis] - b[1][axis]), 0.0);
        sum += gap * gap;
    }
    sum
}

/// Steps along an axis to cells that may hold a place nearer than τ: in four dimensions the gap of three steps is τ but for
/// rounding.
const REACH: i32 = 3;

/// Parts of the side of a cell. Sums over 40,000,000 places fit into 64 bits.
const FINE: f64 = (1_u64 << 36) as f64;

/// Cells that a cursor tries one by one.
const NEAR: usize = 8;
