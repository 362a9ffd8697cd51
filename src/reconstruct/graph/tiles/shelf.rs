//! Where tiles wait that memory has no room for.

use std::error::Error;

use thiserror::Error;

use crate::graph::GraphError;

/// Error of a shelf.
pub type TileShelfFailure = Box<dyn Error + Send + Sync>;

/// A place outside memory, such as a file, for pieces of some megabytes.
pub trait TileShelf {
    /// Keeps bytes as piece number `piece`, in the stead of what was kept as such before. It may have another length.
    ///
    /// # Errors
    ///
    /// When they cannot be kept.
    fn put(&mut self, piece: u32, bytes: &[u8]) -> Result<(), TileShelfFailure>;

    /// Reads what was put last under a number in the stead of what `bytes` holds.
    ///
    /// # Errors
    ///
    /// When it cannot be read in full.
    fn get(&mut self, piece: u32, bytes: &mut Vec<u8>) -> Result<(), TileShelfFailure>;

    /// Forgets a piece, which is not asked for again.
    fn forget(&mut self, piece: u32);
}

/// Why there is no surface by tiles.
#[derive(Debug, Error)]
pub enum TileError {
    /// Numbers out of range.
    #[error(transparent)]
    Graph(#[from] GraphError),
    /// Landmarks by priority lie all over the points.
    #[error("tiles go along the sweep of landmarks: leave the order of priority out")]
    Order,
    /// More points than numbers.
    #[error("expected at most {MOST_TILED_POINTS} points by tiles")]
    TooManyPoints,
    /// What was put on the shelf does not come back.
    #[error("tiles that wait outside memory cannot be written or read back")]
    Shelf(#[source] TileShelfFailure),
}

/// The largest number of points by tiles.
pub const MOST_TILED_POINTS: u32 = u32::MAX - 1;

/// A shelf and the next free number on it.
pub(super) struct Shelved<S> {
    shelf: S,
    next: u32,
    bytes: Vec<u8>,
}

impl<S: TileShelf> Shelved<S> {
    pub(super) fn new(shelf: S) -> Shelved<S> {
        Shelved { shelf, next: 0, bytes: Vec::new() }
    }

    /// Puts numbers of a fixed length on the shelf; gives the number of the piece.
    pub(super) fn put<T: Word>(&mut self, words: &[T]) -> Result<u32, TileError> {
        let piece = self.next;
        self.next += 1;
        self.put_as(piece, words)?;
        Ok(piece)
    }

    /// Puts a piece in the stead of one that has the number already.
    pub(super) fn put_as<T: Word>(&mut self, piece: u32, words: &[T]) -> Result<(), TileError> {
        self.bytes.clear();
        words.iter().for_each(|word| word.write(&mut self.bytes));
        self.shelf.put(piece, &self.bytes).map_err(TileError::Shelf)
    }

    pub(super) fn get<T: Word>(&mut self, piece: u32) -> Result<Vec<T>, TileError> {
        self.shelf.get(piece, &mut self.bytes).map_err(TileError::Shelf)?;
        Ok(self.bytes.chunks_exact(T::BYTES).map(T::read).collect())
    }

    /// The same where the piece is asked for once.
    pub(super) fn take<T: Word>(&mut self, piece: u32) -> Result<Vec<T>, TileError> {
        let words = self.get(piece)?;
        self.shelf.forget(piece);
        Ok(words)
    }
}

/// What is kept as bytes.
pub(super) trait Word: Copy {
    const BYTES: usize;
    fn write(&self, bytes: &mut Vec<u8>);
    /// The word of so many bytes.
    fn read(bytes: &[u8]) -> Self;
}

impl Word for u8 {
    const BYTES: usize = 1;

    fn write(&self, bytes: &mut Vec<u8>) {
        bytes.push(*self);
    }

    fn read(bytes: &[u8]) -> u8 {
        bytes[0]
    }
}

impl Word for u32 {
    const BYTES: usize = 4;

    fn write(&self, bytes: &mut Vec<u8>) {
        bytes.extend(self.to_le_bytes());
    }

    fn read(bytes: &[u8]) -> u32 {
        bytes.first_chunk().map_or(0, |four| u32::from_le_bytes(*four))
    }
}

impl Word for f64 {
    const BYTES: usize = 8;

    fn write(&self, bytes: &mut Vec<u8>) {
        bytes.extend(self.to_le_bytes());
    }

    fn read(bytes: &[u8]) -> f64 {
        bytes.first_chunk().map_or(0.0, |eight| f64::from_le_bytes(*eight))
    }
}

impl<T: Word> Word for [T; 2] {
    const BYTES: usize = 2 * T::BYTES;

    fn write(&self, bytes: &mut Vec<u8>) {
        self.iter().for_each(|word| word.write(bytes));
    }

    fn read(bytes: &[u8]) -> [T; 2] {
        [T::read(bytes), T::read(&bytes[T::BYTES..])]
    }
}
