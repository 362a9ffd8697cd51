//! The mesh of a surface that grows while the surface is measured.

mod changes;
mod edit;
mod interpolate;
mod locate;
mod neighbours;
mod order;

use std::collections::BTreeMap;
use std::sync::atomic::{AtomicBool, Ordering};

use asphera_geometry::{PointMm, VertexId, admit};
use rayon::prelude::*;

pub use self::changes::{ChangedPart, Changes, HEIGHTS_REMEMBERED, Revision};
pub use self::edit::EditError;
use self::edit::Edits;
pub use self::neighbours::Neighbours;
use self::order::in_order;
use crate::area::{Area, area};
use crate::delaunay::{Delaunay, Duplicate};
use crate::outcome::edges_and_hull;
use crate::room::make_room;
use crate::{Counts, Outcome, Repeats};

/// How many points [`Mesh::push`] gathers before it inserts them.
pub const BATCH_POINTS: usize = 1024;

/// How many such batches are inserted as one when points need not be current one by one.
const LARGE_BATCHES: usize = 64;

/// Fewer points are not worth a second thread for taking them over.
const FOR_TWO: usize = 16_384;

/// The triangulation of a surface's points, projected along z; it grows by batches of any size.
///
/// The mesh is the Delaunay triangulation of the projected points, lifted to their heights. It fills
/// the convex hull of the projection: triangles that bridge a gap or a hollow of the outline belong
/// to it, and those who look at the sampling tell them from the surface.
///
/// After [`Mesh::insert`] the mesh is that of all points so far, exactly. Where more than three
/// points lie on one circle with none inside, as on a raster, the Delaunay triangulation is not
/// unique; then of four such corners the diagonal that avoids the one with the largest x, and of
/// those the largest y, is taken. So the mesh depends on the points alone: not on the batches, and
/// but for the numbers of its vertices not on their order.
///
/// ```
/// use asphera_mesh::{Mesh, Outcome};
///
/// let mut mesh = Mesh::new();
/// mesh.insert(&[[0.0, 0.0, 0.1], [1.0, 0.0, 0.2], [0.0, 1.0, 0.3]]);
/// assert_eq!(mesh.triangles(), [[0, 1, 2]]);
/// mesh.insert(&[[0.0, 0.0, 0.1]]);
/// assert_eq!(mesh.outcome(3), Some(Outcome::Duplicate { of: 0 }));
/// ```
pub struct Mesh {
    conflict_tolerance_mm: f64,
    delaunay: Delaunay,
    /// The vertices, in order of arrival, withdrawn ones among them.
    points: Vec<PointMm>,
    /// Points pushed but not inserted yet.
    pending: Vec<PointMm>,
    /// Points taken so far, pending ones left out.
    taken: usize,
    /// Fate of those that are no vertices of their own, by index.
    others: Vec<(usize, Outcome)>,
    repeats: BTreeMap<VertexId, Repeats>,
    duplicates: u64,
    conflicts: u64,
    rejected: u64,
    edits: Edits,
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
            delaunay: Delaunay::default(),
            points: Vec::new(),
            pending: Vec::new(),
            taken: 0,
            others: Vec::new(),
            repeats: BTreeMap::new(),
            duplicates: 0,
            conflicts: 0,
            rejected: 0,
            edits: Edits::default(),
        }
    }

    /// As [`Mesh::new`], but two threads share every batch of so many points, however little that pays: what
    /// they do can be met with few points then.
    #[cfg(any(test, feature = "fuzzing"))]
    pub fn shared_from(points: usize) -> Mesh {
        let mut mesh = Mesh::new();
        mesh.delaunay.share_from(points);
        mesh
    }

    /// Takes the next points; the mesh holds them when this returns.
    ///
    /// Points that were pushed and wait are inserted first. Coordinates below [`asphera_geometry::TINY_MM`] are
    /// taken as zero; points that are not finite or out of range are counted and no vertices.
    ///
    /// Costs some walk steps and flips a point, wherever it lies, and for every batch the triangles
    /// by which the hull is closed beside an unfinished scan line: as many as the last line has
    /// points that the next has not reached. So batches much smaller than a scan line cost more.
    ///
    /// # Panics
    ///
    /// At 2²⁹ vertices.
    pub fn insert(&mut self, points: &[PointMm]) {
        self.flush();
        self.take(points);
    }

    /// Takes the next point; it waits until there are [`BATCH_POINTS`].
    ///
    /// # Panics
    ///
    /// As [`Mesh::insert`].
    pub fn push(&mut self, point: PointMm) {
        self.pending.push(point);
        if self.pending.len() == BATCH_POINTS {
            self.flush();
        }
    }

    /// Inserts the points that wait.
    pub fn flush(&mut self) {
        let mut batch = std::mem::take(&mut self.pending);
        self.take(&batch);
        batch.clear();
        self.pending = batch;
    }

    fn take(&mut self, batch: &[PointMm]) {
        let first = self.points.len() as VertexId;
        self.delaunay.cells_mut().advance();
        let mut rejected = Vec::new();
        make_room(&mut self.points, batch.len());
        if batch.len() < FOR_TWO || !self.store_all(batch) {
            for (index, &point) in batch.iter().enumerate() {
                match admit(point) {
                    Ok(point) => self.points.push(point),
                    Err(rejection) => rejected.push((index, Outcome::Rejected(rejection))),
                }
            }
        }
        let duplicated =
            self.delaunay.insert(&self.points[..], first..self.points.len() as VertexId);
        self.rejected += rejected.len() as u64;
        if duplicated || !rejected.is_empty() {
            self.settle(batch, first, rejected);
        }
        self.taken += batch.len();
    }

    /// Stores the points of a large batch if all are admitted, else none; by two threads where there are
    /// two, as much of the time goes into the system's handing out of the memory.
    fn store_all(&mut self, batch: &[PointMm]) -> bool {
        let before = self.points.len();
        let all = AtomicBool::new(true);
        self.points.par_extend(batch.par_iter().map(|&point| {
            admit(point).unwrap_or_else(|_| {
                all.store(false, Ordering::Relaxed);
                point
            })
        }));
        let all = all.into_inner();
        if !all {
            self.points.truncate(before);
        }
        all
    }

    /// Notes what became of the points of a batch that are no vertices.
    fn settle(&mut self, batch: &[PointMm], first: VertexId, rejected: Vec<(usize, Outcome)>) {
        // The heights of all admitted points, before the vertices close up.
        let heights_mm: Vec<f64> =
            self.points[first as usize..].iter().map(|point| point[2]).collect();
        let duplicates = self.delaunay.close_gaps(&mut self.points, first);
        let mut rejected = rejected.into_iter().peekable();
        let mut duplicates = duplicates.into_iter().peekable();
        let mut admitted = first;
        for index in 0..batch.len() {
            if let Some((_, outcome)) = rejected.next_if(|&(rejected, _)| rejected == index) {
                self.others.push((self.taken + index, outcome));
                continue;
            }
            if let Some(Duplicate { of, .. }) = duplicates.next_if(|other| other.point == admitted)
            {
                let outcome = self.repeat(of, heights_mm[(admitted - first) as usize]);
                self.others.push((self.taken + index, outcome));
            }
            admitted += 1;
        }
    }

    /// Takes another measurement in the place of a vertex.
    fn repeat(&mut self, of: VertexId, z_mm: f64) -> Outcome {
        let vertex_mm = self.points[of as usize][2];
        let height_mm = z_mm - vertex_mm;
        self.repeats.entry(of).or_insert_with(|| Repeats::first(vertex_mm)).add(z_mm);
        if height_mm.abs() <= self.conflict_tolerance_mm {
            self.duplicates += 1;
            Outcome::Duplicate { of }
        } else {
            self.conflicts += 1;
            Outcome::Conflict { of, height_mm }
        }
    }

    /// Fate of point `index`, counted from 0; `None` if there is no such point.
    pub fn outcome(&self, index: usize) -> Option<Outcome> {
        if index >= self.taken {
            return (index < self.taken + self.pending.len()).then_some(Outcome::Pending);
        }
        let before = self.others.partition_point(|&(other, _)| other < index);
        match self.others.get(before) {
            Some(&(other, outcome)) if other == index => Some(outcome),
            _ => {
                let vertex = (index - before) as VertexId;
                let there = self.is_vertex(vertex);
                Some(if there { Outcome::Vertex(vertex) } else { Outcome::Withdrawn(vertex) })
            }
        }
    }

    /// All measurements in the place of a vertex, if there is more than one.
    pub fn repeats(&self, vertex: VertexId) -> Option<&Repeats> {
        self.repeats.get(&vertex)
    }

    /// Counterparts of all such vertices, in order.
    pub fn all_repeats(&self) -> impl Iterator<Item = (VertexId, &Repeats)> {
        self.repeats.iter().map(|(&vertex, repeats)| (vertex, repeats))
    }

    /// How many there are of everything. Constant time.
    pub fn counts(&self) -> Counts {
        let withdrawn = self.withdrawn().len() as u64;
        let vertices = self.points.len() as u64 - withdrawn;
        let triangles = self.delaunay.triangle_count() as u64;
        let (edges, hull) = edges_and_hull(vertices, triangles);
        Counts {
            pushed: (self.taken + self.pending.len()) as u64,
            vertices,
            triangles,
            edges,
            hull,
            withdrawn,
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

    /// The number of the last change of each chunk of triangles, in order: a chunk whose number stays has not
    /// changed. The next call of [`Mesh::insert`] writes larger numbers than this one.
    pub fn written(&self) -> impl ExactSizeIterator<Item = u32> + '_ {
        self.delaunay.cells().written()
    }

    /// The number that changes of triangles get now; see [`Mesh::written`].
    pub fn now(&self) -> u32 {
        self.delaunay.cells().now()
    }

    /// The triangles of a chunk; see [`Mesh::written`].
    pub fn triangles_of(&self, chunk: usize) -> impl Iterator<Item = [VertexId; 3]> + '_ {
        self.delaunay.cells().triangles_of(chunk)
    }

    #[cfg(test)]
    pub(crate) fn effort(&self) -> usize {
        self.delaunay.effort()
    }

    #[cfg(test)]
    pub(crate) fn assert_sound(&self) {
        self.delaunay.assert_sound();
    }

    /// The vertices in order of arrival; a [`VertexId`] is an index into them. Those withdrawn keep
    /// their index: [`Mesh::vertices`] leaves them out.
    pub fn points(&self) -> &[PointMm] {
        &self.points
    }

    /// The triangles, counter-clockwise seen from +z, each from its smallest corner on, in
    /// lexicographic order of the corners: a list that depends on the points and their order alone.
    /// Linear time.
    pub fn triangles(&self) -> Vec<[VertexId; 3]> {
        in_order(self.points.len(), || self.delaunay.triangles())
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
    /// As [`Mesh::push`] for each: as many wait at the end. What is inserted is inserted by larger batches,
    /// which two threads can share.
    fn extend<I: IntoIterator<Item = PointMm>>(&mut self, points: I) {
        for point in points {
            self.pending.push(point);
            if self.pending.len() == LARGE_BATCHES * BATCH_POINTS {
                self.flush();
            }
        }
        let waiting = self.pending.split_off(self.pending.len() / BATCH_POINTS * BATCH_POINTS);
        self.flush();
        self.pending.extend(waiting);
    }
}
