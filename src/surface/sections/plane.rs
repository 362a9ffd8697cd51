//! The cut of a mesh by any plane.
//!
//! The plane splits the vertices into those above, below and on it, once for all, so that all
//! triangles agree. A triangle with corners on both sides is cut along a chord between two of its
//! sides, or between a corner on the plane and the side opposite; of one with two corners on the
//! plane and the third not, that edge is the chord, which the triangle beyond may have as well. So
//! chords, each taken once, meet in *nodes*: edges crossed, of at most two triangles and two chords,
//! and vertices on the plane, where any number may meet. Pieces are made of what lies between nodes
//! that have not just two chords.
//!
//! Of a part of the mesh that lies in the plane only the border is cut, where it rises or falls.
//!
//! Facets in space are cut by the same rule: it asks for no projection, and three facets may share an edge.

use std::cmp::Ordering;
use std::collections::{BTreeMap, BTreeSet};

use asphera_geometry::{PointMm, RANGE_MM, VertexId};
use asphera_mesh::Mesh;

use super::pieces::{Limit, Piece, Section, SectionPoint, Source};
use super::{SectionError, within_gap};

/// A plane in space: the places p with n·p = d.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CuttingPlane {
    /// Its unit normal.
    normal: [f64; 3],
    offset_mm: f64,
}

impl CuttingPlane {
    /// The plane n·p = d for a normal n of any length, and d in mm times that length.
    ///
    /// # Errors
    ///
    /// If the normal has no direction, or a number is not finite or out of range.
    pub fn new(normal: [f64; 3], offset_mm: f64) -> Result<CuttingPlane, SectionError> {
        let largest = normal.iter().fold(0.0_f64, |largest, n| largest.max(n.abs()));
        let length =
            largest * normal.map(|n| n / largest).iter().map(|n| n * n).sum::<f64>().sqrt();
        let offset = offset_mm / length;
        if (1e-100..=1e100).contains(&length) && offset.abs() <= RANGE_MM {
            // An axis stays one to the bit.
            Ok(CuttingPlane { normal: normal.map(|n| n / length), offset_mm: offset })
        } else {
            Err(SectionError::Plane { normal, offset_mm })
        }
    }

    /// Its unit normal.
    pub fn normal(&self) -> [f64; 3] {
        self.normal
    }

    /// Its distance from the origin along the normal in mm.
    pub fn offset_mm(&self) -> f64 {
        self.offset_mm
    }

    /// The height of a place above the plane in mm, as good as if computed with twice the digits
    /// and then rounded: a compensated scalar product (T. Ogita, S. M. Rump, S. Oishi, SIAM J. Sci.
    /// Comput. 26 (2005) 1955-1988, doi:10.1137/030601818, algorithm 5.3).
    fn above_mm(&self, at_mm: PointMm) -> f64 {
        let (mut sum, mut lost) = (-self.offset_mm, 0.0);
        for (n, x) in self.normal.into_iter().zip(at_mm) {
            let product = n * x;
            let rest = n.mul_add(x, -product);
            let total = sum + product;
            let taken = total - sum;
            lost += (sum - (total - taken)) + (product - taken) + rest;
            sum = total;
        }
        sum + lost
    }
}

/// The lines in which a plane cuts the lifted mesh, in triangles whose gap is within
/// `gap_limit_mm`, as in [`super::section()`].
///
/// Pieces are listed by the smallest node they have; a piece that is not closed begins at the
/// smaller of its ends, a closed one at its smallest node. Nodes are ordered by their vertices. The
/// arc position starts from 0 in each piece and is the length in space.
///
/// Takes time in proportion to all triangles, and some memory.
///
/// # Errors
///
/// If the limit is not a finite number above 0.
pub fn cut(
    mesh: &Mesh,
    plane: &CuttingPlane,
    gap_limit_mm: Option<f64>,
) -> Result<Section, SectionError> {
    let keep = within_gap(mesh.points(), gap_limit_mm)?;
    let on_hull = |vertex| mesh.neighbours(vertex).is_none_or(|about| about.on_hull);
    Ok(Lines::new(mesh.points(), plane).through(mesh.triangles(), keep, (Limit::Hull, on_hull)))
}

/// The same of facets in space; a piece that is not closed ends at the border of the surface.
///
/// Takes time in proportion to all facets, and some memory.
///
/// # Errors
///
/// If the limit is not a finite number above 0.
///
/// # Panics
///
/// If a facet names a point that is not there.
pub fn cut_facets(
    points: &[PointMm],
    facets: &[[VertexId; 3]],
    plane: &CuttingPlane,
    gap_limit_mm: Option<f64>,
) -> Result<Section, SectionError> {
    let keep = within_gap(points, gap_limit_mm)?;
    let lines = Lines::new(points, plane);
    let border = lines.border_on_plane(facets);
    let ends_at = |vertex| border.contains(&vertex);
    Ok(lines.through(facets.iter().copied(), keep, (Limit::Border, ends_at)))
}

/// Points, and their heights above the plane that cuts the facets between them.
struct Lines<'a> {
    points: &'a [PointMm],
    above_mm: Vec<f64>,
}

impl Lines<'_> {
    fn new<'a>(points: &'a [PointMm], plane: &CuttingPlane) -> Lines<'a> {
        let above_mm = points.iter().map(|&at_mm| plane.above_mm(at_mm)).collect();
        Lines { points, above_mm }
    }

    /// The section of the facets that are kept. Where the surface ends, at these vertices and at edges of one facet, `outside`
    /// is the limit.
    fn through(
        &self,
        facets: impl IntoIterator<Item = [VertexId; 3]>,
        keep: impl Fn([VertexId; 3]) -> bool,
        (outside, ends_at): (Limit, impl Fn(VertexId) -> bool),
    ) -> Section {
        let mut chords = Chords::default();
        for corners in facets {
            if let Some(ends) = chord(corners, &self.above_mm) {
                let kept = keep(corners);
                chords.add(ends, kept);
            }
        }
        let source = |[a, b]: Node| {
            if a == b {
                return Source::Vertex { vertex: a };
            }
            let [from, to] = [a, b].map(|end| self.above_mm[end as usize]);
            // The ends have different signs: no more than one rounding, and no division by zero.
            Source::Edge { edge: [a, b], share: from / (from - to) }
        };
        Section { pieces: chords.pieces(source, (outside, ends_at), self.points) }
    }

    /// The vertices on the plane that have an edge of one facet alone.
    fn border_on_plane(&self, facets: &[[VertexId; 3]]) -> BTreeSet<VertexId> {
        let is_on = |vertex: VertexId| self.above_mm[vertex as usize] == 0.0;
        let mut facets_of: BTreeMap<Node, u32> = BTreeMap::new();
        for corners in facets {
            for (from, to) in [(0, 1), (1, 2), (2, 0)].map(|(i, j)| (corners[i], corners[j])) {
                if is_on(from) || is_on(to) {
                    *facets_of.entry([from.min(to), from.max(to)]).or_default() += 1;
                }
            }
        }
        let of_border = facets_of.into_iter().filter(|(_, count)| *count == 1);
        of_border.flat_map(|(ends, _)| ends).filter(|&vertex| is_on(vertex)).collect()
    }
}

/// An edge that is cut, the smaller end first, or twice a vertex on the plane.
type Node = [VertexId; 2];

/// The chord of a triangle.
fn chord(corners: [VertexId; 3], above_mm: &[f64]) -> Option<[Node; 2]> {
    let sides = corners.map(|corner| match above_mm[corner as usize] {
        above_mm if above_mm > 0.0 => Ordering::Greater,
        above_mm if above_mm < 0.0 => Ordering::Less,
        _ => Ordering::Equal,
    });
    if sides.iter().all(|side| side.is_eq()) {
        return None;
    }
    let vertices = (0..3).filter(|&i| sides[i].is_eq()).map(|i| [corners[i]; 2]);
    let edges = (0..3).map(|i| (i, (i + 1) % 3)).filter_map(|(i, j)| {
        let crossed = !sides[i].is_eq() && sides[i] == sides[j].reverse();
        crossed.then(|| [corners[i].min(corners[j]), corners[i].max(corners[j])])
    });
    let mut nodes = vertices.chain(edges);
    let (first, second) = (nodes.next()?, nodes.next()?);
    Some([first.min(second), first.max(second)])
}

/// The chords at each node.
#[derive(Default)]
struct Chords {
    at: BTreeMap<Node, Meeting>,
}

#[derive(Default)]
struct Meeting {
    /// The other ends of the chords that are kept.
    ends: Vec<Node>,
    /// Whether a chord that is not kept ends there.
    broken: bool,
}

impl Chords {
    fn add(&mut self, [p, q]: [Node; 2], kept: bool) {
        for (at, end) in [(p, q), (q, p)] {
            let meeting = self.at.entry(at).or_default();
            if !kept {
                meeting.broken = true;
            } else if !meeting.ends.contains(&end) {
                meeting.ends.push(end);
            }
        }
    }

    /// All pieces; takes the chords away one by one.
    fn pieces(
        mut self,
        source: impl Fn(Node) -> Source,
        (outside, ends_at): (Limit, impl Fn(VertexId) -> bool),
        points: &[PointMm],
    ) -> Vec<Piece> {
        for meeting in self.at.values_mut() {
            meeting.ends.sort_unstable();
        }
        let counts: BTreeMap<Node, usize> =
            self.at.iter().map(|(&node, meeting)| (node, meeting.ends.len())).collect();
        let mut found: Vec<(Node, Piece)> = Vec::new();
        // First those between nodes where pieces end, then those that go round.
        let ending = counts.iter().filter(|&(_, &count)| count != 2);
        for (&start, _) in ending.chain(&counts) {
            while let Some(nodes) = self.follow(start, &counts) {
                let limit = |node: Node| match counts[&node] {
                    2 => Limit::Closed,
                    1 if self.at[&node].broken => Limit::Gap,
                    // An edge with one chord has one triangle.
                    1 if node[0] != node[1] || ends_at(node[0]) => outside,
                    _ => Limit::Junction,
                };
                let (first, last) = (nodes[0], nodes[nodes.len() - 1]);
                let smallest = nodes.iter().copied().min().unwrap_or(first);
                let piece = Piece {
                    begins: limit(first),
                    ends: limit(last),
                    points: polyline(&nodes, &source, points),
                };
                found.push((smallest, piece));
            }
        }
        found.sort_by_key(|&(smallest, _)| smallest);
        found.into_iter().map(|(_, piece)| piece).collect()
    }

    /// The nodes from one on to one where a piece ends, or to the first again.
    fn follow(&mut self, start: Node, counts: &BTreeMap<Node, usize>) -> Option<Vec<Node>> {
        let mut nodes = vec![start];
        let mut at = start;
        loop {
            let next = self.take(at, None)?;
            self.take(next, Some(at));
            nodes.push(next);
            if next == start || counts[&next] != 2 {
                return Some(nodes);
            }
            at = next;
        }
    }

    /// Takes away the chord from a node to another one, or the first there is.
    fn take(&mut self, from: Node, to: Option<Node>) -> Option<Node> {
        let ends = &mut self.at.get_mut(&from)?.ends;
        let index = match to {
            Some(to) => ends.iter().position(|&end| end == to)?,
            None => 0,
        };
        (index < ends.len()).then(|| ends.remove(index))
    }
}

fn polyline(
    nodes: &[Node],
    source: impl Fn(Node) -> Source,
    points: &[PointMm],
) -> Vec<SectionPoint> {
    let mut found: Vec<SectionPoint> = Vec::with_capacity(nodes.len());
    for &node in nodes {
        let source = source(node);
        let at_mm = source.at_mm(points);
        let s_mm = found.last().map_or(0.0, |last| {
            let [x, y, z] = [0, 1, 2].map(|axis| at_mm[axis] - last.at_mm[axis]);
            last.s_mm + x.hypot(y).hypot(z)
        });
        found.push(SectionPoint { s_mm, at_mm, source });
    }
    found
}
