//! The mesh of a scan that is larger than memory.
//!
//! Vertices are numbered in the order of arrival, and so nearly are triangles. A scan grows at its
//! border: what lies behind it is not looked at for long, often never again. So points and triangles are
//! kept in chunks in that order, and chunks that nobody looked at lately are put on a shelf,
//! a file for instance, and read back when somebody looks at them again. That a region is finished
//! is inferred and can be taken back, where M. Isenburg, Y. Liu, J. Shewchuk and J. Snoeyink, Streaming
//! computation of Delaunay triangulations, ACM Trans. Graph. 25 (2006) 1049-1056,
//! doi:10.1145/1141911.1141992, must be told so with the points, and for good.

mod desk;
mod pages;
mod shelf;
mod stores;

use std::panic::{AssertUnwindSafe, catch_unwind, resume_unwind};
use std::sync::{Arc, Mutex, PoisonError};

use asphera_geometry::{PointMm, VertexId, admit};

use self::desk::Desk;
use self::pages::Pages;
pub use self::shelf::{Part, Shelf, ShelfError, ShelfFailure};
use self::stores::{PagedCells, PagedPoints};
use crate::delaunay::Delaunay;
use crate::outcome::edges_and_hull;
use crate::{Counts, Mesh};

/// The triangulation of more points than memory holds; it grows by batches of any size.
///
/// Vertices and triangles are those of a [`crate::Mesh`] of the same points. Left out is what would
/// grow with the scan outside the chunks: what became of each point
/// ([`crate::Mesh::outcome`]) and repeated measurements ([`crate::Mesh::repeats`]); they are
/// counted.
///
/// Memory is bounded but for a first profile: as long as all points lie on one line, a tree of them
/// is kept in memory besides. Scans whose points arrive in no order are meshed rightly, but each
/// point waits for chunks to be read.
///
/// `BITS` says how many records a chunk has: 2 to that power; 65,536 unless said otherwise.
///
/// ```
/// use std::collections::BTreeMap;
///
/// use asphera_mesh::{PagedMesh, Shelf, ShelfFailure};
///
/// #[derive(Default)]
/// struct Drawer(BTreeMap<u32, Vec<u8>>);
///
/// impl Shelf for Drawer {
///     fn put(&mut self, chunk: u32, bytes: &[u8]) -> Result<(), ShelfFailure> {
///         self.0.insert(chunk, bytes.to_vec());
///         Ok(())
///     }
///
///     fn get(&mut self, chunk: u32, bytes: &mut [u8]) -> Result<(), ShelfFailure> {
///         bytes.copy_from_slice(self.0.get(&chunk).ok_or("no such chunk")?);
///         Ok(())
///     }
/// }
///
/// let mut mesh: PagedMesh<Drawer> = PagedMesh::new(Drawer::default(), 64 << 20);
/// mesh.insert(&[[0.0, 0.0, 0.1], [1.0, 0.0, 0.2], [0.0, 1.0, 0.3]])?;
/// assert_eq!(mesh.counts().triangles, 1);
/// # Ok::<(), asphera_mesh::ShelfError>(())
/// ```
pub struct PagedMesh<S: Shelf, const BITS: u32 = 16> {
    desk: Arc<Mutex<Desk<S>>>,
    delaunay: Delaunay<PagedCells<S, BITS>>,
    points: PagedPoints<S, BITS>,
    /// Whether a change was given up in the middle.
    lost: bool,
    budget_bytes: usize,
    counts: Counts,
}

/// Traffic between a [`PagedMesh`] and its shelf.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Paging {
    /// Bytes of memory the mesh takes now.
    pub resident_bytes: usize,
    /// Bytes of it that chunks may take, rounded to whole chunks.
    pub budget_bytes: usize,
    /// Bytes put on the shelf so far.
    pub written_bytes: u64,
    /// Bytes read back so far.
    pub read_bytes: u64,
    /// How often the shelf failed to keep a chunk, which therefore stayed in memory.
    pub failed_puts: u64,
    /// Error that it gave last.
    pub last_failure: Option<String>,
}

impl<S: Shelf, const BITS: u32> PagedMesh<S, BITS> {
    /// Bytes of every chunk.
    pub const CHUNK_BYTES: usize = Pages::<f64, S, 3, BITS>::CHUNK_BYTES;

    /// An empty mesh whose chunks take `memory_bytes` at most, but no less than three: two of
    /// triangles and one of points.
    ///
    /// Besides there are the bytes of one chunk on its way (of another while all are read one by
    /// one), 48 bytes for each chunk there is, a byte for some 15 points, and some 100 bytes for
    /// each point of a batch, but not of more than 65,536 at once.
    pub fn new(shelf: S, memory_bytes: usize) -> PagedMesh<S, BITS> {
        let chunks = memory_bytes / Self::CHUNK_BYTES;
        let of_points = (chunks / 3).max(1);
        let of_cells = chunks.saturating_sub(of_points).max(2);
        let desk = Arc::new(Mutex::new(Desk::new(shelf, Self::CHUNK_BYTES)));
        PagedMesh {
            delaunay: Delaunay::kept_in(PagedCells::new(Arc::clone(&desk), of_cells)),
            points: PagedPoints::new(Arc::clone(&desk), of_points),
            desk,
            lost: false,
            budget_bytes: (of_cells + of_points) * Self::CHUNK_BYTES,
            counts: Counts::default(),
        }
    }

    /// Takes the next points; the mesh holds them when this returns.
    ///
    /// They are admitted, and their duplicates found, as by [`crate::Mesh::insert`], with its default
    /// conflict tolerance. Points that follow one another along lines need few chunks.
    ///
    /// # Errors
    ///
    /// When a chunk cannot be read back. The change cannot be finished then: the mesh is lost, and
    /// every later call returns [`ShelfError::Lost`]. It needs unwinding; in a program built to
    /// abort on panic it aborts instead.
    ///
    /// # Panics
    ///
    /// At 2²⁹ vertices.
    pub fn insert(&mut self, points: &[PointMm]) -> Result<(), ShelfError> {
        for batch in points.chunks(MOST_AT_ONCE) {
            self.change(|mesh| mesh.take(batch))?;
        }
        Ok(())
    }

    /// Makes a change, which unwinds with a [`ShelfError`] if a chunk cannot be read back.
    fn change<T>(&mut self, change: impl FnOnce(&mut Self) -> T) -> Result<T, ShelfError> {
        if self.lost {
            return Err(ShelfError::Lost);
        }
        // Nobody sees what was half changed: the mesh is lost, also to a caller who catches a panic.
        self.lost = true;
        let done = unless_unread(|| change(self))?;
        self.lost = false;
        Ok(done)
    }

    fn take(&mut self, batch: &[PointMm]) {
        let first = self.points.pages.len() as VertexId;
        let mut counts = self.counts;
        let admitted: Vec<PointMm> = batch.iter().filter_map(|&point| admit(point).ok()).collect();
        self.points.extend(&admitted);
        let end = first + admitted.len() as VertexId;
        if self.delaunay.insert(&self.points, first..end) {
            for duplicate in self.delaunay.close_gaps(&mut self.points, first) {
                let [_, _, z_mm] = admitted[(duplicate.point - first) as usize];
                let height_mm = z_mm - self.points.point(duplicate.of)[2];
                if height_mm.abs() <= Mesh::CONFLICT_TOLERANCE_MM {
                    counts.duplicates += 1;
                } else {
                    counts.conflicts += 1;
                }
            }
        }
        counts.pushed += batch.len() as u64;
        counts.rejected += (batch.len() - admitted.len()) as u64;
        counts.vertices = self.points.pages.len() as u64;
        counts.triangles = self.delaunay.triangle_count() as u64;
        (counts.edges, counts.hull) = edges_and_hull(counts.vertices, counts.triangles);
        self.counts = counts;
        self.delaunay.cells_mut().pages.trim();
        self.points.pages.trim();
    }

    /// How many there are of everything. Constant time; of a lost mesh, what was counted before.
    pub fn counts(&self) -> Counts {
        self.counts
    }

    /// Calls `take` with each triangle: its corners counter-clockwise seen from +z. Their order is
    /// nearly that of arrival and means nothing. Linear time; chunks on the shelf are read once.
    ///
    /// # Errors
    ///
    /// When a chunk cannot be read back, after the triangles of those before; the mesh stays what it is.
    /// When the mesh is lost.
    pub fn for_each_triangle(&self, mut take: impl FnMut([VertexId; 3])) -> Result<(), ShelfError> {
        self.check_whole()?;
        self.delaunay.cells().pages.for_each_chunk(|words| {
            PagedCells::<S, BITS>::corners_of(words).for_each(&mut take);
        })
    }

    /// Calls `take` with the points of the vertices, chunk by chunk in order of arrival, and
    /// the number of the first of each chunk. Linear time; chunks on the shelf are read once.
    ///
    /// # Errors
    ///
    /// As [`PagedMesh::for_each_triangle`].
    pub fn for_each_points(
        &self,
        mut take: impl FnMut(VertexId, &[PointMm]),
    ) -> Result<(), ShelfError> {
        self.check_whole()?;
        let mut first = 0;
        self.points.pages.for_each_chunk(|words| {
            let points = words.as_chunks::<3>().0;
            take(first, points);
            first += points.len() as VertexId;
        })
    }

    /// The point of a vertex, `None` if there is none with that number. Brings its chunk back into
    /// memory.
    ///
    /// # Errors
    ///
    /// As [`PagedMesh::for_each_triangle`].
    pub fn point(&self, vertex: VertexId) -> Result<Option<PointMm>, ShelfError> {
        self.check_whole()?;
        if vertex as usize >= self.points.pages.len() {
            return Ok(None);
        }
        unless_unread(|| Some(self.points.point(vertex)))
    }

    fn check_whole(&self) -> Result<(), ShelfError> {
        if self.lost { Err(ShelfError::Lost) } else { Ok(()) }
    }

    /// Bytes of memory the mesh takes now.
    pub fn resident_bytes(&self) -> usize {
        self.delaunay.cells().memory_bytes()
            + self.points.pages.memory_bytes()
            + self.delaunay.other_bytes()
            + Self::CHUNK_BYTES
    }

    /// Traffic between the mesh and its shelf.
    pub fn paging(&self) -> Paging {
        let desk = self.desk.lock().unwrap_or_else(PoisonError::into_inner);
        let bytes = |chunks: u64| chunks * Self::CHUNK_BYTES as u64;
        Paging {
            resident_bytes: self.resident_bytes(),
            budget_bytes: self.budget_bytes,
            written_bytes: bytes(desk.written_chunks),
            read_bytes: bytes(desk.read_chunks),
            failed_puts: desk.failed_puts,
            last_failure: desk.last_failure.as_ref().map(ToString::to_string),
        }
    }
}

/// Does something that unwinds with a [`ShelfError`] if a chunk cannot be read back; other panics pass.
fn unless_unread<T>(work: impl FnOnce() -> T) -> Result<T, ShelfError> {
    catch_unwind(AssertUnwindSafe(work)).map_err(|payload| match payload.downcast() {
        Ok(error) => *error,
        Err(panic) => resume_unwind(panic),
    })
}

/// Points of a batch that are inserted at once.
const MOST_AT_ONCE: usize = 1 << 16;
