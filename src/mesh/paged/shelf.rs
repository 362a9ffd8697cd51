//! Where chunks of a mesh go that memory has no room for, and what may go wrong there.

use std::error::Error;
use std::fmt;

/// Error of a shelf.
pub type ShelfFailure = Box<dyn Error + Send + Sync>;

/// A place outside memory, such as a file, for the chunks of a [`crate::PagedMesh`].
///
/// All chunks have the same length, [`crate::PagedMesh::CHUNK_BYTES`], and their numbers leave few
/// gaps: in a file, chunk number times length is a good place for each.
///
/// The mesh keeps a checksum of each chunk. Whatever the shelf gives back that was not put there
/// last under that number is an error, not a wrong mesh.
pub trait Shelf {
    /// Keeps `bytes` as chunk number `chunk`, in the stead of what was kept as such before.
    ///
    /// # Errors
    ///
    /// When they cannot be kept. The mesh then keeps the chunk in memory and says so in
    /// [`crate::Paging`]; what was kept under the number before is not asked for any more.
    fn put(&mut self, chunk: u32, bytes: &[u8]) -> Result<(), ShelfFailure>;

    /// Reads the chunk that was put last under the number into `bytes`, which has its length.
    ///
    /// # Errors
    ///
    /// When it cannot be read in full.
    fn get(&mut self, chunk: u32, bytes: &mut [u8]) -> Result<(), ShelfFailure>;
}

/// Why a chunk could not be read back.
#[derive(Debug, thiserror::Error)]
pub enum ShelfError {
    /// The shelf failed.
    #[error("chunk {chunk} ({part}) cannot be read back")]
    Read {
        /// Its number.
        chunk: u32,
        /// Content.
        part: Part,
        /// Error of the shelf.
        source: ShelfFailure,
    },
    /// The shelf gave bytes that were not put there last.
    #[error("chunk {chunk} ({part}) was damaged: checksum {found:016x}, not {expected:016x}")]
    Damaged {
        /// Its number.
        chunk: u32,
        /// Content.
        part: Part,
        /// Checksum of what was put.
        expected: u64,
        /// Checksum of what was read.
        found: u64,
    },
    /// An earlier call ended in the middle of a change as a chunk could not be read back.
    #[error("the mesh was lost when a chunk could not be read back")]
    Lost,
}

/// Content of a chunk.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Part {
    /// Points of vertices.
    Points,
    /// Triangles.
    Triangles,
}

impl fmt::Display for Part {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Part::Points => "points",
            Part::Triangles => "triangles",
        })
    }
}

impl Part {
    /// The number on the shelf of one of its chunks: there are two chunks of triangles to one of
    /// points.
    pub(super) fn number(self, chunk: usize) -> u32 {
        let number = match self {
            Part::Points => 3 * chunk + 2,
            Part::Triangles => 3 * (chunk / 2) + chunk % 2,
        };
        number as u32
    }
}
