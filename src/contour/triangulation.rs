//! The exact Delaunay triangulation as a graph: edges with their triangles, neighbours, the order of lengths.

mod edges;
mod fan;
mod lengths;
mod nearby;

use std::cmp::Ordering;
use std::sync::OnceLock;

use asphera_geometry::predicates::compare_distances;
use asphera_geometry::{WeightedTree, from_smallest};
use asphera_mesh::Mesh;
use rayon::prelude::*;

pub(crate) use self::fan::Fan;
use self::lengths::Lengths;
use crate::cells::in_cells;
use crate::samples::{PlaceMm, SampleId, Samples};

/// Number of an edge of a triangulation: its index in [`Triangulation::edges`].
pub type EdgeId = u32;

/// Number of a triangle of a triangulation.
pub type TriangleId = u32;

/// An edge of the triangulation.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Edge {
    /// Its ends, the smaller number first.
    pub ends: [SampleId; 2],
    /// As [`Edge::triangles`], with [`BEYOND`] for none: half as large as options, and there are three edges a sample.
    triangles: [TriangleId; 2],
}

/// No triangle has this number: there are fewer.
const BEYOND: TriangleId = TriangleId::MAX;

impl Edge {
    /// The triangle on the left of the way from the first end to the second, and that on the right; none beyond the hull.
    #[inline]
    pub fn triangles(&self) -> [Option<TriangleId>; 2] {
        self.triangles.map(|triangle| (triangle != BEYOND).then_some(triangle))
    }
}

/// The Delaunay triangulation of samples, with what its edges and vertices meet.
///
/// It is that of the surface kernel: exact, and unique through its rule for ties. While all samples lie on one line it has no
/// triangle, and an edge between each two that follow each other.
pub struct Triangulation {
    samples: Samples,
    triangles: Vec<[SampleId; 3]>,
    /// The edge from corner i to corner i + 1 of each triangle.
    sides: Vec<[EdgeId; 3]>,
    edges: Vec<Edge>,
    /// The edges of sample i are `spokes[first_spoke[i]..first_spoke[i + 1]]`, by their other end.
    first_spoke: Vec<u32>,
    spokes: Vec<Spoke>,
    lengths: OnceLock<Lengths>,
    nearest: OnceLock<Vec<Option<Spoke>>>,
    tree: OnceLock<WeightedTree>,
    centres: OnceLock<Vec<PlaceMm>>,
}

/// An edge seen from one of its ends.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Spoke {
    /// The other end.
    pub to: SampleId,
    /// The edge.
    pub edge: EdgeId,
}

impl Triangulation {
    /// The triangulation of samples; n·log n time.
    pub fn new(samples: Samples) -> Triangulation {
        let triangles = triangles(&samples);
        let (edges, sides, room) = edges::edges(samples.len(), &triangles);
        let (first_spoke, spokes) = edges::spokes(samples.len(), &edges, room);
        Triangulation {
            samples,
            triangles,
            sides,
            edges,
            first_spoke,
            spokes,
            lengths: OnceLock::new(),
            nearest: OnceLock::new(),
            tree: OnceLock::new(),
            centres: OnceLock::new(),
        }
    }

    /// The samples.
    pub fn samples(&self) -> &Samples {
        &self.samples
    }

    /// How many samples there are.
    pub fn len(&self) -> usize {
        self.samples.len()
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.samples.is_empty()
    }

    /// The place of a sample in mm.
    #[inline]
    pub fn place(&self, sample: SampleId) -> PlaceMm {
        self.samples.places()[sample as usize]
    }

    /// The triangles, counter-clockwise, each from its smallest corner on, in lexicographic order.
    pub fn triangles(&self) -> &[[SampleId; 3]] {
        &self.triangles
    }

    /// The edges of a triangle, from each corner to the next.
    pub fn sides(&self, triangle: TriangleId) -> [EdgeId; 3] {
        self.sides[triangle as usize]
    }

    /// The edges, sorted by their ends.
    pub fn edges(&self) -> &[Edge] {
        &self.edges
    }

    /// The ends of an edge, the smaller number first.
    #[inline]
    pub fn ends(&self, edge: EdgeId) -> [SampleId; 2] {
        self.edges[edge as usize].ends
    }

    /// The places of the ends of an edge in mm.
    #[inline]
    pub fn ends_mm(&self, edge: EdgeId) -> [PlaceMm; 2] {
        self.ends(edge).map(|end| self.place(end))
    }

    /// The corners opposite an edge, on its left and on its right; none beyond the hull.
    pub fn opposite(&self, edge: EdgeId) -> [Option<SampleId>; 2] {
        let edge = self.edges[edge as usize];
        let ends = edge.ends;
        edge.triangles().map(|triangle| {
            let corners = self.triangles[triangle? as usize];
            corners.into_iter().find(|corner| !ends.contains(corner))
        })
    }

    /// The edges of a sample, by the number of their other end.
    #[inline]
    pub fn spokes(&self, sample: SampleId) -> &[Spoke] {
        let sample = sample as usize;
        &self.spokes[self.first_spoke[sample] as usize..self.first_spoke[sample + 1] as usize]
    }

    /// The edge between two samples, if there is one.
    pub fn edge_between(&self, p: SampleId, q: SampleId) -> Option<EdgeId> {
        let spokes = self.spokes(p);
        spokes.binary_search_by_key(&q, |spoke| spoke.to).ok().map(|index| spokes[index].edge)
    }

    /// Length of an edge in mm.
    pub fn length_mm(&self, edge: EdgeId) -> f64 {
        let [p, q] = self.ends_mm(edge);
        distance_mm(p, q)
    }

    /// All edges, shortest first, those of equal length by their ends.
    pub fn by_length(&self) -> &[EdgeId] {
        &self.lengths().sorted
    }

    /// Rank of an edge's length: edges of exactly the same length have the same.
    #[inline]
    pub fn length_class(&self, edge: EdgeId) -> u32 {
        self.lengths().classes()[edge as usize]
    }

    /// The order of the lengths of two edges, decided exactly. Of few edges it is sooner known than [`Triangulation::length_class`].
    pub(crate) fn compare_lengths(&self, a: EdgeId, b: EdgeId) -> Ordering {
        let ([p, q], [r, s]) = (self.ends_mm(a), self.ends_mm(b));
        compare_distances(p, q, r, s)
    }

    /// The way to the nearest other sample, of equally near ones to that of the smallest number; none from a sample alone.
    ///
    /// The nearest sample is always a neighbour: the disc about the edge as diameter, its rim included, holds no other.
    pub fn nearest(&self, sample: SampleId) -> Option<Spoke> {
        self.nearest.get_or_init(|| {
            // Compared here, not by their order of lengths: that takes longer than all else a method of nearest samples does.
            let nearest = |sample: SampleId| {
                let at = self.place(sample);
                let nearer = |a: &Spoke, b: &Spoke| {
                    let [to_a, to_b] = [a.to, b.to].map(|other| self.place(other));
                    compare_distances(at, to_a, at, to_b).then(a.to.cmp(&b.to))
                };
                self.spokes(sample).iter().copied().min_by(nearer)
            };
            (0..self.len() as SampleId).into_par_iter().map(nearest).collect()
        })[sample as usize]
    }

    /// The other samples, nearest first, equally near ones by their numbers.
    pub fn nearby(&self, sample: SampleId) -> impl Iterator<Item = SampleId> + '_ {
        nearby::Nearby::new(self, sample)
    }

    /// The nearest other sample that is wanted, of equally near ones that of the smallest number; none where no neighbour is wanted.
    ///
    /// The same as the first wanted one of [`Triangulation::nearby`], sooner found.
    pub fn nearest_of(
        &self,
        sample: SampleId,
        is_wanted: impl Fn(SampleId) -> bool,
    ) -> Option<SampleId> {
        nearby::nearest_of(self, sample, is_wanted)
    }

    /// A tree of the samples for questions about regions; the numbers it tells are those of the samples.
    pub fn tree(&self) -> &WeightedTree {
        self.tree.get_or_init(|| {
            WeightedTree::new(self.samples.places().iter().map(|&[x, y]| ([x, y, 0.0], 0.0)))
        })
    }

    /// The circumcentres of the triangles in mm: the Voronoi vertices. They are rounded.
    ///
    /// The centre is computed from the corner that lies first, in differences, so that places far from the origin lose
    /// nothing but what their own coordinates hold. Of a triangle that is nearly a line it may lie anywhere far off.
    pub fn centres_mm(&self) -> &[PlaceMm] {
        self.centres.get_or_init(|| {
            let centre =
                |corners: &[SampleId; 3]| circumcentre_mm(corners.map(|corner| self.place(corner)));
            self.triangles.par_iter().map(centre).collect()
        })
    }

    fn lengths(&self) -> &Lengths {
        // Numbers of edges are in the order of their ends.
        self.lengths.get_or_init(|| Lengths::new(self.edges.len(), |edge| self.ends_mm(edge)))
    }
}

/// The triangles of samples in the order of their coordinates.
fn triangles(samples: &Samples) -> Vec<[SampleId; 3]> {
    edges::in_order(samples.len(), unsorted_triangles(samples))
}

/// The triangles of samples in no order, each from its smallest corner on.
///
/// Samples are handed to the kernel along the curve through the cells of a quadtree: sorted along an axis they would alternate between
/// the branches of a curve, which its strips of scan lines are not made for. What lies near one another lies near in memory, too, and the
/// time does not depend on the order of arrival.
pub(crate) fn unsorted_triangles(samples: &Samples) -> Vec<[SampleId; 3]> {
    let order = in_cells(samples);
    let places = samples.places();
    let mut mesh = Mesh::new();
    let points: Vec<[f64; 3]> = order
        .iter()
        .map(|&sample| {
            let [x, y] = places[sample as usize];
            [x, y, 0.0]
        })
        .collect();
    mesh.insert(&points);
    let chunks = 0..mesh.written().len();
    let triangles = chunks.flat_map(|chunk| mesh.triangles_of(chunk));
    let numbered =
        triangles.map(|corners| from_smallest(corners.map(|vertex| order[vertex as usize])));
    // There are fewer than two a sample.
    let mut found = Vec::with_capacity(2 * samples.len());
    found.extend(numbered);
    found
}

/// Distance of two places in mm.
pub(crate) fn distance_mm(p: PlaceMm, q: PlaceMm) -> f64 {
    let [x, y] = [p[0] - q[0], p[1] - q[1]];
    (x * x + y * y).sqrt()
}

/// Centre of the circle through three places in mm.
pub(crate) fn circumcentre_mm([a, b, c]: [PlaceMm; 3]) -> PlaceMm {
    let [bx, by, cx, cy] = [b[0] - a[0], b[1] - a[1], c[0] - a[0], c[1] - a[1]];
    let twice = 2.0 * (bx * cy - by * cx);
    let [b2, c2] = [bx * bx + by * by, cx * cx + cy * cy];
    [a[0] + (cy * b2 - by * c2) / twice, a[1] + (bx * c2 - cx * b2) / twice]
}
