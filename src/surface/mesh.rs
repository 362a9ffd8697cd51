//! The mesh of a surface that grows while the surface is measured.

use crate::area::{Area, area};
use crate::delaunay::{Delaunay, Slot};
use crate::order::by_bisection;
use crate::point::{admit, place};
use crate::{Counts, Outcome, PointMm, VertexId};

/// How many points a batch has.
///
/// Points are inserted by batches, in an order that keeps scan lines from being the worst case (see
/// `order.rs`). Smaller batches would show points sooner, but a scan line cut into many batches
/// costs a fan over the rest of the last line for each of them.
pub const BATCH_POINTS: usize = 1024;

/// The triangulation of a surface's points, projected along z; it grows point by point.
///
/// The mesh is the Delaunay triangulation of the projected points, lifted to their heights. It fills
/// the convex hull of the projection: triangles that bridge a gap or a hollow of the outline belong
/// to it, and it is for [`crate::assess`] to tell them from the surface.
///
/// Points are buffered and inserted [`BATCH_POINTS`] at a time, counted from the first point or the
/// last [`Mesh::flush`]. The same points and flushes in the same order give the same mesh, bit by
/// bit. Where more than three points lie exactly on one circle with none inside, as on a raster, the
/// Delaunay triangulation is not unique and the choice depends on the order and the flushes;
/// elsewhere it depends on the points alone. Flush at the end of a measurement or at fixed counts,
/// then, but not by the clock, if a replay is to give the same mesh.
///
/// ```
/// use asphera_surface::{Mesh, Outcome};
///
/// let mut mesh = Mesh::new();
/// for point in [[0.0, 0.0, 0.1], [1.0, 0.0, 0.2], [0.0, 1.0, 0.3], [0.0, 0.0, 0.1]] {
///     mesh.push(point);
/// }
/// assert_eq!(mesh.outcome(3), Some(Outcome::Pending));
/// mesh.flush();
/// assert_eq!(mesh.outcome(3), Some(Outcome::Duplicate { of: 0 }));
/// assert_eq!(mesh.triangles().collect::<Vec<_>>().len(), 1);
/// ```
pub struct Mesh {
    conflict_tolerance_mm: f64,
    delaunay: Delaunay,
    /// The vertices, in order of arrival.
    points: Vec<PointMm>,
    /// The vertex in each slot of the triangulation. Slots follow insertion, vertices arrival.
    vertex_of_slot: Vec<VertexId>,
    /// One for each pushed point.
    outcomes: Vec<Outcome>,
    /// Admitted points that wait for their batch, as vertices would carry them.
    pending: Vec<Arrival>,
    duplicates: u64,
    conflicts: u64,
    rejected: u64,
}

/// A point in the buffer.
#[derive(Clone, Copy)]
struct Arrival {
    /// Which pushed point it is.
    index: usize,
    point: PointMm,
}

impl Mesh {
    /// Default of the conflict tolerance in mm: 100 nm, above the noise of an optical probe and
    /// below any step worth telling.
    pub const CONFLICT_TOLERANCE_MM: f64 = 1e-4;

    /// An empty mesh with the default conflict tolerance.
    pub fn new() -> Mesh {
        Mesh::with_conflict_tolerance(Mesh::CONFLICT_TOLERANCE_MM)
    }

    /// An empty mesh in which two points in one place are duplicates up to this height difference
    /// in mm, inclusive, and conflicts above. A tolerance that is negative or NaN is zero.
    pub fn with_conflict_tolerance(tolerance_mm: f64) -> Mesh {
        Mesh {
            conflict_tolerance_mm: tolerance_mm.max(0.0),
            delaunay: Delaunay::new(),
            points: Vec::new(),
            vertex_of_slot: Vec::new(),
            outcomes: Vec::new(),
            pending: Vec::with_capacity(BATCH_POINTS),
            duplicates: 0,
            conflicts: 0,
            rejected: 0,
        }
    }

    /// Takes the next point; the last of a batch inserts the batch.
    ///
    /// Coordinates below [`crate::TINY_MM`] are taken as zero. Points that are not finite or out of
    /// range are counted and take no part in the batch. Amortised cost: a few walk steps and edge
    /// flips where points arrive along a scan; the square root of the vertices where they arrive
    /// scattered at random.
    ///
    /// # Panics
    ///
    /// When the triangulation's 32-bit numbers run out, at some 700 million vertices.
    pub fn push(&mut self, point: PointMm) {
        match admit(point) {
            Ok(point) => {
                self.pending.push(Arrival { index: self.outcomes.len(), point });
                self.outcomes.push(Outcome::Pending);
                if self.pending.len() == BATCH_POINTS {
                    self.flush();
                }
            }
            Err(rejection) => {
                self.rejected += 1;
                self.outcomes.push(Outcome::Rejected(rejection));
            }
        }
    }

    /// Inserts the points that wait, as a batch of their own.
    pub fn flush(&mut self) {
        let batch = std::mem::take(&mut self.pending);
        let mut slots: Vec<Slot> = vec![0; batch.len()];
        for step in by_bisection(batch.len()) {
            let near = step.near.map(|near| slots[near]);
            slots[step.index] = self.delaunay.insert(place(batch[step.index].point), near);
        }
        // Of several points of the batch in one place the first to arrive is the vertex, whichever
        // was inserted first.
        self.vertex_of_slot.resize(self.delaunay.len(), VACANT);
        for (arrival, slot) in batch.iter().zip(slots) {
            self.outcomes[arrival.index] = self.settle(arrival.point, slot);
        }
        self.pending = batch;
        self.pending.clear();
    }

    /// Decides what a point in `slot` is; all that arrived before it are decided.
    fn settle(&mut self, point: PointMm, slot: Slot) -> Outcome {
        let vertex = &mut self.vertex_of_slot[slot as usize];
        if *vertex == VACANT {
            // There are no more vertices than slots, and slots are numbered with u32.
            *vertex = self.points.len() as VertexId;
            self.points.push(point);
            return Outcome::Vertex(*vertex);
        }
        let height_mm = point[2] - self.points[*vertex as usize][2];
        if height_mm.abs() <= self.conflict_tolerance_mm {
            self.duplicates += 1;
            Outcome::Duplicate { of: *vertex }
        } else {
            self.conflicts += 1;
            Outcome::Conflict { of: *vertex, height_mm }
        }
    }

    /// What became of the pushed point `index`, counted from 0; `None` if there is no such point.
    pub fn outcome(&self, index: usize) -> Option<Outcome> {
        self.outcomes.get(index).copied()
    }

    /// How many there are of everything. Constant time.
    pub fn counts(&self) -> Counts {
        let vertices = self.points.len() as u64;
        let triangles = self.delaunay.triangle_count() as u64;
        // Euler's relation, and each triangle has three edges, each inner edge two triangles.
        let edges = (vertices + triangles).saturating_sub(1);
        let hull = if triangles == 0 { vertices } else { 2 * edges - 3 * triangles };
        Counts {
            pushed: self.outcomes.len() as u64,
            vertices,
            triangles,
            edges,
            hull,
            duplicates: self.duplicates,
            conflicts: self.conflicts,
            rejected: self.rejected,
            pending: self.pending.len() as u64,
        }
    }

    /// Whether no two inserted points stand one above the other by more than the tolerance.
    ///
    /// This is all that points alone can tell: a mesh of a surface with an overhang whose points
    /// all differ in place is still a graph over the plane.
    pub fn projectable(&self) -> bool {
        self.conflicts == 0
    }

    /// The vertices in order of arrival; a [`VertexId`] is an index into them.
    pub fn points(&self) -> &[PointMm] {
        &self.points
    }

    /// The triangles, counter-clockwise seen from +z, in an order that depends on the pushed points
    /// and flushes alone.
    pub fn triangles(&self) -> impl Iterator<Item = [VertexId; 3]> + '_ {
        self.delaunay.triangles().map(|slots| slots.map(|slot| self.vertex_of_slot[slot as usize]))
    }

    /// Area of the whole mesh, hull-filling triangles included. Takes time in proportion to the
    /// triangles.
    pub fn area(&self) -> Area {
        area(&self.points, self.triangles())
    }
}

impl Default for Mesh {
    fn default() -> Mesh {
        Mesh::new()
    }
}

impl Extend<PointMm> for Mesh {
    fn extend<I: IntoIterator<Item = PointMm>>(&mut self, points: I) {
        points.into_iter().for_each(|point| self.push(point));
    }
}

/// Marks a slot whose vertex is not numbered yet.
const VACANT: VertexId = VertexId::MAX;
