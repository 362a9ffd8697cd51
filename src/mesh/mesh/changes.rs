//! What changed in the mesh since a moment of its growth, so that what shows it need not start
//! anew.
//!
//! Nothing is kept for insertions, and of removals only the order. A triangle that stands now was
//! not there at an earlier moment if, and only if, one of its corners was not, or a vertex that was
//! there and was withdrawn since lies inside its circumcircle. The first have a corner with a
//! number that had not been given; the others are those that would go if that vertex came back.

use std::collections::VecDeque;

use asphera_geometry::{BoundsMm, PointMm, VertexId, place};

use super::Mesh;
use crate::delaunay::Conflict;

/// How many changes of a height a mesh remembers.
pub const HEIGHTS_REMEMBERED: usize = 4096;

/// A moment in the growth of a mesh; see [`Mesh::changed_since`].
///
/// The default is before its first point.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub struct Revision {
    /// Numbers given to vertices.
    vertices: usize,
    /// Vertices withdrawn.
    withdrawn: usize,
    /// Heights changed.
    heights: u64,
}

/// Changes in a mesh since a revision of it.
#[derive(Clone, Debug, PartialEq)]
pub enum Changes {
    /// Everything may have changed: the revision is older than what the mesh remembers, or is none
    /// of this mesh.
    Everything,
    /// What is told here, and nothing else.
    Part(ChangedPart),
}

/// Changes in a mesh.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ChangedPart {
    /// The triangles that stand now and did not then, and those with a corner whose height was
    /// changed, as in [`Mesh::triangles`] and in its order, each once.
    pub triangles: Vec<[VertexId; 3]>,
    /// The numbers given to vertices since: all from the first on to below the second. Those that
    /// were withdrawn again are among them.
    pub inserted: std::ops::Range<VertexId>,
    /// The vertices withdrawn since, in the order they were.
    pub withdrawn: Vec<VertexId>,
    /// The vertices whose height was changed since, from the smallest number on, each once; of
    /// those withdrawn since, too.
    pub raised: Vec<VertexId>,
    /// A box with sides along x and y around all that changed: those triangles, and the places
    /// where the mesh no longer reaches. None if nothing changed.
    pub bounds_mm: Option<BoundsMm>,
}

impl Mesh {
    /// The present moment. Points that wait to be inserted take no part. Constant time.
    pub fn revision(&self) -> Revision {
        Revision {
            vertices: self.points.len(),
            withdrawn: self.edits.withdrawn.len(),
            heights: self.edits.heights.count,
        }
    }

    /// Changes since a revision of this mesh. A triangle that went and came back has not
    /// changed.
    ///
    /// The mesh remembers all insertions and removals, and the last [`HEIGHTS_REMEMBERED`] changes
    /// of a height. Takes time in proportion to the triangles that changed, with the logarithm for
    /// their order, and a short walk for every vertex inserted, withdrawn or raised since; never
    /// much more than [`Mesh::triangles`] for those inserted.
    ///
    /// ```
    /// use asphera_mesh::{Changes, Mesh};
    ///
    /// let mut mesh = Mesh::new();
    /// mesh.insert(&[[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]);
    /// let before = mesh.revision();
    /// mesh.insert(&[[1.0, 1.5, 0.0]]);
    /// let Changes::Part(part) = mesh.changed_since(before) else { panic!("it is remembered") };
    /// assert_eq!(part.triangles, [[1, 3, 2]]);
    /// ```
    pub fn changed_since(&self, revision: Revision) -> Changes {
        let now = self.revision();
        let known = revision.vertices <= now.vertices && revision.withdrawn <= now.withdrawn;
        let Some(raised) = self.edits.heights.since(revision.heights).filter(|_| known) else {
            return Changes::Everything;
        };
        let inserted = revision.vertices as VertexId..now.vertices as VertexId;
        let withdrawn = self.edits.withdrawn[revision.withdrawn..].to_vec();
        let mut changed = Gathered { points: &self.points, triangles: Vec::new(), bounds: None };
        self.gather_inserted(&mut changed, inserted.start);
        for &vertex in withdrawn.iter().filter(|&&vertex| vertex < inserted.start) {
            changed.surround(&[vertex]);
            let at = place(self.points[vertex as usize]);
            for conflict in self.delaunay.in_conflict(&self.points[..], at) {
                match conflict {
                    Conflict::Triangle(corners) => changed.add(corners),
                    Conflict::Beyond(side) => changed.surround(&side),
                }
            }
        }
        for &vertex in &raised {
            changed.surround(&[vertex]);
            if let Some(about) = self.about(vertex) {
                about.triangles(vertex).for_each(|corners| changed.add(corners));
                changed.surround(&about.vertices);
            }
        }
        let Gathered { mut triangles, bounds: bounds_mm, .. } = changed;
        triangles.sort_unstable();
        triangles.dedup();
        Changes::Part(ChangedPart { triangles, inserted, withdrawn, raised, bounds_mm })
    }

    /// Gathers all triangles that have a corner from `first` on, and the edges of a line.
    fn gather_inserted(&self, changed: &mut Gathered, first: VertexId) {
        let inserted = self.points.len() - first as usize;
        if inserted > first as usize && self.delaunay.triangle_count() > 0 {
            // To look at all triangles takes less time than to look for those.
            let all = self.triangles().into_iter();
            all.filter(|corners| corners.iter().any(|&corner| corner >= first))
                .for_each(|corners| changed.add(corners));
            return;
        }
        for vertex in first..self.points.len() as VertexId {
            let Some(about) = self.about(vertex) else { continue };
            changed.surround(&[vertex]);
            changed.surround(&about.vertices);
            about.triangles(vertex).for_each(|corners| changed.add(corners));
        }
    }
}

/// The last changes of a height.
#[derive(Default)]
pub(super) struct Heights {
    /// The vertices, the last one last.
    last: VecDeque<VertexId>,
    /// How many changes there were.
    count: u64,
}

impl Heights {
    pub(super) fn note(&mut self, vertex: VertexId) {
        if self.last.len() == HEIGHTS_REMEMBERED {
            self.last.pop_front();
        }
        self.last.push_back(vertex);
        self.count += 1;
    }

    /// The vertices that were raised after the first `count` changes, each once; none if that is
    /// not remembered or has not been yet.
    fn since(&self, count: u64) -> Option<Vec<VertexId>> {
        let fresh = usize::try_from(self.count.checked_sub(count)?).ok()?;
        let known = self.last.len().checked_sub(fresh)?;
        let mut raised: Vec<VertexId> = self.last.range(known..).copied().collect();
        raised.sort_unstable();
        raised.dedup();
        Some(raised)
    }
}

/// What is found changed.
struct Gathered<'a> {
    points: &'a [PointMm],
    triangles: Vec<[VertexId; 3]>,
    bounds: Option<BoundsMm>,
}

impl Gathered<'_> {
    fn add(&mut self, corners: [VertexId; 3]) {
        self.triangles.push(corners);
        self.surround(&corners);
    }

    fn surround(&mut self, vertices: &[VertexId]) {
        for &vertex in vertices {
            let at = place(self.points[vertex as usize]);
            self.bounds.get_or_insert(BoundsMm::EMPTY).add(at);
        }
    }
}
