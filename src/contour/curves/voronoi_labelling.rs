//! The curve between Voronoi vertices inside and outside.

use std::cmp::Ordering;
use std::collections::BinaryHeap;

use asphera_geometry::predicates::orientation;

use crate::triangulation::TriangleId;
use crate::{Graph, PlaceMm, Triangulation};

/// Voronoi labelling: Voronoi vertices beyond the hull lie outside, and each vertex outside splits the cells that meet in it.
///
/// A cell is cut by the line through its sample at a right angle to the way to the vertex: the vertices of the cell on the near side lie
/// outside, too. The curve has the edges between vertices inside and outside, and the hull edges whose vertex lies inside. Cells are
/// split once, those without an end never. If all samples lie on the hull, it is the curve. Closed curves; the program's text speaks of
/// ε-samples whose concavities diverge, nothing is proven here.
///
/// A. D. Parakkat, S. Methirumangalath, R. Muthuganapathy, 2018, as a public program; text not at hand. Vertices are taken by falling
/// radius, so that no order matters; the program takes the last one it found, and splits one cell of three. Vertices are rounded; n·log n time
/// for samples of curves.
pub fn voronoi_labelling(triangulation: &Triangulation) -> Graph {
    let centres = triangulation.centres_mm();
    let mut labels = Labels {
        triangulation,
        centres,
        is_outside: vec![false; centres.len()],
        queue: BinaryHeap::new(),
    };
    for triangle in 0..centres.len() as TriangleId {
        if is_beyond_hull(triangulation, triangle, centres[triangle as usize]) {
            labels.put_outside(triangle);
        }
    }
    let mut is_split = vec![false; triangulation.len()];
    while let Some(Vertex { triangle, .. }) = labels.queue.pop() {
        for sample in triangulation.triangles()[triangle as usize] {
            if !std::mem::replace(&mut is_split[sample as usize], true) {
                labels.split(sample, triangle);
            }
        }
    }
    let is_outside = |triangle: Option<TriangleId>| {
        triangle.is_none_or(|triangle| labels.is_outside[triangle as usize])
    };
    // On one line there is nothing inside, and the samples that follow each other are joined.
    let is_line = centres.is_empty();
    Graph::of_edges(triangulation, |edge| {
        let [left, right] = triangulation.edges()[edge as usize].triangles().map(is_outside);
        is_line || left != right
    })
}

struct Labels<'a> {
    triangulation: &'a Triangulation,
    centres: &'a [PlaceMm],
    is_outside: Vec<bool>,
    /// Vertices outside whose cells were not looked at yet.
    queue: BinaryHeap<Vertex>,
}

impl Labels<'_> {
    fn put_outside(&mut self, triangle: TriangleId) {
        if !std::mem::replace(&mut self.is_outside[triangle as usize], true) {
            let corner = self.triangulation.triangles()[triangle as usize][0];
            let [x, y] = minus(self.centres[triangle as usize], self.triangulation.place(corner));
            self.queue.push(Vertex { radius_mm2: x * x + y * y, triangle });
        }
    }

    /// Puts the vertices of a sample's cell outside that lie on the side of one of them.
    fn split(&mut self, sample: u32, by: TriangleId) {
        let sectors = self.triangulation.fan(sample).sectors;
        let place = self.triangulation.place(sample);
        let way = minus(self.centres[by as usize], place);
        // A cell without an end has a sector beyond the hull.
        let cell: Option<Vec<TriangleId>> = sectors.into_iter().collect();
        for triangle in cell.unwrap_or_default() {
            let other = minus(self.centres[triangle as usize], place);
            if way[0] * other[0] + way[1] * other[1] > 0.0 {
                self.put_outside(triangle);
            }
        }
    }
}

/// Whether a Voronoi vertex lies beyond the hull: the way to it from its triangle leaves all triangles.
fn is_beyond_hull(triangulation: &Triangulation, triangle: TriangleId, centre: PlaceMm) -> bool {
    if !centre.iter().all(|value| value.is_finite()) {
        return true;
    }
    let (mut at, mut from) = (triangle, None);
    loop {
        let corners =
            triangulation.triangles()[at as usize].map(|corner| triangulation.place(corner));
        let across = triangulation.across(at);
        let next = (0..3).find(|&side| {
            (across[side] != from || from.is_none())
                && orientation(corners[side], corners[(side + 1) % 3], centre).is_lt()
        });
        match next.map(|side| across[side]) {
            None => return false,
            Some(None) => return true,
            Some(Some(other)) => (at, from) = (other, Some(at)),
        }
    }
}

fn minus(p: PlaceMm, q: PlaceMm) -> [f64; 2] {
    [p[0] - q[0], p[1] - q[1]]
}

/// A Voronoi vertex, the widest first, then that of the smallest number.
#[derive(PartialEq)]
struct Vertex {
    radius_mm2: f64,
    triangle: TriangleId,
}

impl Eq for Vertex {}

impl Ord for Vertex {
    fn cmp(&self, other: &Vertex) -> Ordering {
        self.radius_mm2.total_cmp(&other.radius_mm2).then(other.triangle.cmp(&self.triangle))
    }
}

impl PartialOrd for Vertex {
    fn partial_cmp(&self, other: &Vertex) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}
