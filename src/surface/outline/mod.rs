//! Islands and holes of the part of a mesh that is well sampled.
//!
//! A mesh fills the convex hull of its points. Once the triangles that bridge gaps are left out, what
//! remains may be in several parts, and have holes. Triangles with a common side belong to one
//! island; those that touch at a corner only do not. Likewise two holes that touch at a corner are
//! two, and one that touches the outline at a corner is a hole.

mod count;
mod loops;

use std::cmp::Ordering;

use asphera_geometry::{PointMm, Sets, VertexId};

pub use self::count::IslandCounts;
pub(crate) use self::count::island_counts;
pub(crate) use self::loops::{Loop, loops};
use crate::relief::sides;

/// A part of the mesh in one piece, seen in the plane of projection.
#[derive(Clone, Debug, PartialEq)]
pub struct Island {
    /// How many triangles it has.
    pub triangles: u64,
    /// How many vertices its triangles have, those of its boundary included.
    pub vertices: u64,
    /// Its projected area in mm², without its holes.
    pub area_mm2: f64,
    /// Its outline, counter-clockwise.
    pub outline: Contour,
    /// Its holes, clockwise, the largest first. What lies in a hole, as other islands do, counts as
    /// part of the hole.
    pub holes: Vec<Contour>,
}

/// A closed line of sides, which passes no vertex twice.
#[derive(Clone, Debug, PartialEq)]
pub struct Contour {
    /// Its vertices in order, the island on the left, beginning with the one of the smallest x, of
    /// several with the smallest y.
    pub vertices: Vec<VertexId>,
    /// The area in mm² it encloses in the plane.
    pub area_mm2: f64,
    /// Its length in the plane in mm.
    pub perimeter_mm: f64,
    /// The smallest x and y of its vertices in mm.
    pub min_mm: [f64; 2],
    /// The largest x and y of its vertices in mm.
    pub max_mm: [f64; 2],
}

/// The islands that the triangles with a flag make up, the largest first.
///
/// `triangles` are those of a mesh of `points`, counter-clockwise; `keep` has a flag for each, such
/// as whether its [`crate::State`] is good. All figures are the same, to the bit, whatever the order
/// of the triangles, the corner each begins with or the numbering of the points. Areas are summed
/// with compensation from a vertex of the contour, so that neither their error nor that of the
/// coordinates grows with the distance from the origin.
///
/// Linear time but for sorting sides about each vertex and along the contours.
///
/// # Panics
///
/// When there is not one flag a triangle, or a corner is not the index of a point.
pub fn islands(points: &[PointMm], triangles: &[[VertexId; 3]], keep: &[bool]) -> Vec<Island> {
    assert_eq!(triangles.len(), keep.len(), "one flag a triangle");
    let kept: Vec<[VertexId; 3]> = triangles
        .iter()
        .zip(keep)
        .filter_map(|(&corners, &keep)| keep.then_some(corners))
        .collect();
    let starts = Starts::new(points.len(), &kept);
    let mut sets = Sets::new(kept.len());
    let mut open: Vec<(usize, [VertexId; 2])> = Vec::new();
    for (index, &corners) in kept.iter().enumerate() {
        for [p, q] in sides(corners) {
            match starts.triangle_left_of([q, p]) {
                Some(other) => {
                    sets.join(index, other);
                }
                None => open.push((index, [p, q])),
            }
        }
    }
    // Islands are numbered by their first triangle, which is the root of its set.
    let mut number_of_root = vec![0; kept.len()];
    let mut counts: Vec<u64> = Vec::new();
    let mut of_triangle = Vec::with_capacity(kept.len());
    for index in 0..kept.len() {
        let root = sets.root(index);
        if root == index {
            number_of_root[root] = counts.len();
            counts.push(0);
        }
        let island = number_of_root[root];
        counts[island] += 1;
        of_triangle.push(island);
    }
    let open = open.into_iter().map(|(index, side)| (of_triangle[index], side)).collect();
    let vertices = vertex_counts(&starts, &of_triangle, counts.len());

    let mut contours: Vec<Vec<Loop>> = vec![Vec::new(); counts.len()];
    for (island, contour) in loops(points, open) {
        contours[island].push(contour);
    }
    let mut found: Vec<Island> = contours
        .into_iter()
        .zip(counts.into_iter().zip(vertices))
        .map(|(contours, (triangles, vertices))| Island::new(contours, triangles, vertices))
        .collect();
    found.sort_by(|left, right| {
        right.area_mm2.total_cmp(&left.area_mm2).then_with(|| left.outline.order(&right.outline))
    });
    found
}

impl Island {
    fn new(mut contours: Vec<Loop>, triangles: u64, vertices: u64) -> Island {
        // All but the outline are clockwise. Comparing areas rather than signs holds for a sliver
        // whose area is rounded to nothing as well.
        contours.sort_by(|left, right| {
            right
                .signed_area_mm2
                .total_cmp(&left.signed_area_mm2)
                .then_with(|| left.contour.order(&right.contour))
        });
        let mut contours = contours.into_iter();
        let outline = contours.next().expect("an island has an outline").contour;
        let mut holes: Vec<Contour> = contours.map(|hole| hole.contour).collect();
        holes.sort_by(|left, right| {
            right.area_mm2.total_cmp(&left.area_mm2).then_with(|| left.order(right))
        });
        let area_mm2 = holes.iter().fold(outline.area_mm2, |area, hole| area - hole.area_mm2);
        Island { triangles, vertices, area_mm2, outline, holes }
    }
}

impl Contour {
    /// By place.
    fn order(&self, other: &Contour) -> Ordering {
        let corners = |contour: &Contour| [contour.min_mm, contour.max_mm].concat();
        let pairs = corners(self).into_iter().zip(corners(other));
        pairs
            .map(|(left, right)| left.total_cmp(&right))
            .find(|ordering| ordering.is_ne())
            .unwrap_or(Ordering::Equal)
    }
}

/// How many vertices the triangles of each island have.
fn vertex_counts(starts: &Starts, of_triangle: &[usize], islands: usize) -> Vec<u64> {
    let mut counts = vec![0; islands];
    let mut here: Vec<usize> = Vec::new();
    for slot in 0..starts.first.len() - 1 {
        here.clear();
        here.extend(starts.at(slot).iter().map(|&(_, triangle)| of_triangle[triangle]));
        here.sort_unstable();
        here.dedup();
        here.iter().for_each(|&island| counts[island] += 1);
    }
    counts
}

/// The directed sides of triangles by the vertex they start from.
pub(crate) struct Starts {
    /// The vertices with sides, ascending, where they are few; else every vertex has a slot, by its number.
    few: Option<Vec<VertexId>>,
    first: Vec<usize>,
    /// The ends of the sides from the vertex of slot i, ascending, with the triangle on their left, are
    /// `ends[first[i]..first[i + 1]]`.
    ends: Vec<(VertexId, usize)>,
}

impl Starts {
    /// Those of `triangles`, whose corners are below `points`. Costs time and memory in proportion to the
    /// points only where the triangles are many.
    pub(crate) fn new(points: usize, triangles: &[[VertexId; 3]]) -> Starts {
        let few = (FEW * triangles.len() < points).then(|| {
            let mut vertices = triangles.as_flattened().to_vec();
            vertices.sort_unstable();
            vertices.dedup();
            vertices
        });
        let slots = few.as_ref().map_or(points, Vec::len);
        let mut starts = Starts { few, first: vec![0; slots + 1], ends: Vec::new() };
        for &corner in triangles.as_flattened() {
            let slot = starts.slot(corner);
            starts.first[slot + 1] += 1;
        }
        for slot in 0..slots {
            starts.first[slot + 1] += starts.first[slot];
        }
        let mut ends = vec![(0, 0); 3 * triangles.len()];
        let mut next = starts.first.clone();
        for (index, &corners) in triangles.iter().enumerate() {
            for [p, q] in sides(corners) {
                let next = &mut next[starts.slot(p)];
                ends[*next] = (q, index);
                *next += 1;
            }
        }
        for bounds in starts.first.windows(2) {
            ends[bounds[0]..bounds[1]].sort_unstable();
        }
        starts.ends = ends;
        starts
    }

    /// The slot of a vertex with sides.
    fn slot(&self, vertex: VertexId) -> usize {
        match &self.few {
            Some(few) => few.partition_point(|&other| other < vertex),
            None => vertex as usize,
        }
    }

    fn at(&self, slot: usize) -> &[(VertexId, usize)] {
        &self.ends[self.first[slot]..self.first[slot + 1]]
    }

    /// The triangle on the left of the side, if there is one.
    pub(crate) fn triangle_left_of(&self, [p, q]: [VertexId; 2]) -> Option<usize> {
        let slot = self.slot(p);
        if self.few.as_ref().is_some_and(|few| few.get(slot) != Some(&p)) {
            return None;
        }
        let ends = self.at(slot);
        ends.binary_search_by_key(&q, |&(end, _)| end).ok().map(|at| ends[at].1)
    }
}

/// Triangles are few if so many times as many are fewer than the points.
const FEW: usize = 16;
