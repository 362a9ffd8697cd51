//! Points put in the order of the sweep, though memory has no room for all of them.
//!
//! As many as memory holds are sorted at a time and put on the shelf as a run. The runs are then merged, a piece of each in memory.
//! Of points in one place the smallest number stays.

use std::cmp::Reverse;
use std::collections::BinaryHeap;

use asphera_geometry::{BoxMm, PointMm};
use rayon::prelude::*;

use super::shelf::{MOST_TILED_POINTS, Shelved, TileError, TileShelf, Word};
use crate::graph::landmarks::ascending_bits;
use crate::surface::{Numbered, as_place};

/// Points on their way into the order.
pub(super) struct Sorting {
    /// Points as they came, with their numbers.
    waiting: Vec<Numbered>,
    /// Pieces of each run.
    runs: Vec<Vec<u32>>,
    /// Points that are sorted at once.
    room: usize,
    received: u32,
    /// Points without place.
    pub(super) rejected: usize,
}

/// Points in order, cut into tiles of equal size.
pub(super) struct Sorted {
    pub(super) tiles: Vec<Tile>,
    pub(super) duplicates: usize,
}

/// A tile: consecutive points of the sweep.
pub(super) struct Tile {
    /// Its points on the shelf.
    pub(super) piece: u32,
    pub(super) len: usize,
    /// The box of its places.
    pub(super) bounds: BoxMm,
}

/// The order of the sweep, then that of the numbers.
type Key = ([u64; 3], u32);

fn key(&(point, number): &Numbered) -> Key {
    let [x, y, z] = place(point).map(ascending_bits);
    ([z, x, y], number)
}

/// The place of a point that has one.
pub(super) fn place(point: PointMm) -> PointMm {
    as_place(point).unwrap_or(point)
}

impl Sorting {
    pub(super) fn new(room: usize) -> Sorting {
        Sorting { waiting: Vec::new(), runs: Vec::new(), room, received: 0, rejected: 0 }
    }

    pub(super) fn take(
        &mut self,
        points_mm: &[PointMm],
        shelf: &mut Shelved<impl TileShelf>,
    ) -> Result<(), TileError> {
        for &point in points_mm {
            if self.received == MOST_TILED_POINTS {
                return Err(TileError::TooManyPoints);
            }
            match as_place(point) {
                Some(_) => self.waiting.push((point, self.received)),
                None => self.rejected += 1,
            }
            self.received += 1;
            if self.waiting.len() >= self.room {
                self.put_run(shelf)?;
            }
        }
        Ok(())
    }

    fn put_run(&mut self, shelf: &mut Shelved<impl TileShelf>) -> Result<(), TileError> {
        self.waiting.par_sort_unstable_by_key(key);
        let pieces = self.waiting.chunks(MERGED_AT_ONCE.min(self.room)).map(|part| shelf.put(part));
        self.runs.push(pieces.collect::<Result<_, _>>()?);
        self.waiting.clear();
        Ok(())
    }

    /// Cuts the points into tiles of `size` points each.
    pub(super) fn finish(
        mut self,
        size: usize,
        shelf: &mut Shelved<impl TileShelf>,
    ) -> Result<Sorted, TileError> {
        let mut cutting = Cutting { size, held: Vec::new(), last: None, tiles: Vec::new() };
        let mut duplicates = 0;
        if self.runs.is_empty() {
            self.waiting.par_sort_unstable_by_key(key);
            for &point in &self.waiting {
                duplicates += usize::from(!cutting.take(point, shelf)?);
            }
        } else {
            self.put_run(shelf)?;
            self.waiting = Vec::new();
            let mut merging = Merging::of(self.runs, shelf)?;
            while let Some(point) = merging.next(shelf)? {
                duplicates += usize::from(!cutting.take(point, shelf)?);
            }
        }
        cutting.cut(shelf)?;
        Ok(Sorted { tiles: cutting.tiles, duplicates })
    }
}

/// Points of all runs, the least first.
struct Merging {
    runs: Vec<Run>,
    heads: BinaryHeap<Reverse<(Key, usize)>>,
}

/// A run that is read piece by piece.
struct Run {
    pieces: std::vec::IntoIter<u32>,
    points: std::vec::IntoIter<Numbered>,
    head: Option<Numbered>,
}

impl Run {
    /// Goes on to the next point.
    fn advance(&mut self, shelf: &mut Shelved<impl TileShelf>) -> Result<(), TileError> {
        self.head = self.points.next();
        while self.head.is_none()
            && let Some(piece) = self.pieces.next()
        {
            self.points = shelf.take(piece)?.into_iter();
            self.head = self.points.next();
        }
        Ok(())
    }
}

impl Merging {
    fn of(runs: Vec<Vec<u32>>, shelf: &mut Shelved<impl TileShelf>) -> Result<Merging, TileError> {
        let mut merging = Merging { runs: Vec::new(), heads: BinaryHeap::new() };
        for (number, pieces) in runs.into_iter().enumerate() {
            let (pieces, points) = (pieces.into_iter(), Vec::new().into_iter());
            merging.runs.push(Run { pieces, points, head: None });
            merging.advance(number, shelf)?;
        }
        Ok(merging)
    }

    fn advance(
        &mut self,
        run: usize,
        shelf: &mut Shelved<impl TileShelf>,
    ) -> Result<(), TileError> {
        self.runs[run].advance(shelf)?;
        self.heads.extend(self.runs[run].head.map(|head| Reverse((key(&head), run))));
        Ok(())
    }

    fn next(&mut self, shelf: &mut Shelved<impl TileShelf>) -> Result<Option<Numbered>, TileError> {
        let Some(Reverse((_, run))) = self.heads.pop() else { return Ok(None) };
        let head = self.runs[run].head;
        self.advance(run, shelf)?;
        Ok(head)
    }
}

/// Points in order on their way into tiles.
struct Cutting {
    size: usize,
    held: Vec<Numbered>,
    last: Option<PointMm>,
    tiles: Vec<Tile>,
}

impl Cutting {
    /// Takes the next point; gives `false` of one at the place of the last.
    fn take(
        &mut self,
        point: Numbered,
        shelf: &mut Shelved<impl TileShelf>,
    ) -> Result<bool, TileError> {
        let own = place(point.0);
        if self.last == Some(own) {
            return Ok(false);
        }
        self.last = Some(own);
        self.held.push(point);
        if self.held.len() == self.size {
            self.cut(shelf)?;
        }
        Ok(true)
    }

    fn cut(&mut self, shelf: &mut Shelved<impl TileShelf>) -> Result<(), TileError> {
        if self.held.is_empty() {
            return Ok(());
        }
        let bounds = BoxMm::about(self.held.iter().map(|&(point, _)| place(point)));
        let piece = shelf.put(&self.held)?;
        self.tiles.push(Tile { piece, len: self.held.len(), bounds });
        self.held.clear();
        Ok(())
    }
}

impl Word for Numbered {
    const BYTES: usize = 28;

    fn write(&self, bytes: &mut Vec<u8>) {
        self.0.iter().for_each(|value| value.write(bytes));
        self.1.write(bytes);
    }

    fn read(bytes: &[u8]) -> Numbered {
        ([0, 8, 16].map(|at| f64::read(&bytes[at..])), u32::read(&bytes[24..]))
    }
}

/// Points of a run that are read at once.
const MERGED_AT_ONCE: usize = 1 << 12;
