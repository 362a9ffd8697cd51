//! The curve between Voronoi vertices inside and outside.

use std::cmp::Ordering;
use std::collections::BinaryHeap;

use asphera_geometry::BoundsMm;
use asphera_geometry::predicates::{by_x_then_y, orientation};

use crate::triangulation::TriangleId;
use crate::{Graph, PlaceMm, SampleId, Triangulation};

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
    let hull = Hull::new(triangulation);
    for triangle in 0..centres.len() as TriangleId {
        if hull.is_beyond(centres[triangle as usize]) {
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

/// The sides of the hull below and above its samples, each from left to right.
///
/// Samples are numbered by x, then y, and edges by their ends: so both ways are in order, and a place lies beyond one side of each at most.
struct Hull<'a> {
    triangulation: &'a Triangulation,
    bounds: BoundsMm,
    below: Vec<[SampleId; 2]>,
    above: Vec<[SampleId; 2]>,
}

impl<'a> Hull<'a> {
    fn new(triangulation: &'a Triangulation) -> Hull<'a> {
        let (mut below, mut above) = (Vec::new(), Vec::new());
        for edge in triangulation.edges() {
            match edge.triangles() {
                [Some(_), None] => below.push(edge.ends),
                [None, Some(_)] => above.push(edge.ends),
                _ => {}
            }
        }
        let bounds = BoundsMm::about(triangulation.samples().places().iter().copied());
        Hull { triangulation, bounds, below, above }
    }

    /// Whether a place lies beyond the hull; one that is no number does.
    fn is_beyond(&self, place: PlaceMm) -> bool {
        // Voronoi vertices may lie so far off that products overflow.
        let BoundsMm { low, high } = self.bounds;
        if !(0..2).all(|axis| (low[axis]..=high[axis]).contains(&place[axis])) {
            return true;
        }
        let turn = |sides: &[[SampleId; 2]]| {
            let at = |sample: SampleId| self.triangulation.place(sample);
            let follows = |side: &[SampleId; 2]| by_x_then_y(at(side[0]), place).is_le();
            let [p, q] = sides[sides.partition_point(follows).checked_sub(1)?].map(at);
            by_x_then_y(place, q).is_le().then(|| orientation(p, q, place))
        };
        match [turn(&self.below), turn(&self.above)] {
            [Some(below), Some(above)] => below.is_lt() || above.is_gt(),
            _ => true,
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Samples;

    #[test]
    fn beyond_the_hull_is_right_of_one_of_its_sides() {
        let spread = |index: u32| index.wrapping_mul(0x9E37_79B9) >> 26;
        let lattice = (0..40).map(|index| [spread(index), spread(7 * index + 3)].map(f64::from));
        let square = [[0.0, 0.0], [0.0, 2.0], [0.0, 4.0], [4.0, 4.0], [4.0, 0.0], [2.0, 0.0]];
        for places in [lattice.collect::<Vec<PlaceMm>>(), square.to_vec()] {
            let triangulation = Triangulation::new(Samples::new(&places).expect("finite places"));
            let hull = Hull::new(&triangulation);
            let at = |sample: SampleId| triangulation.place(sample);
            for index in 0..70 * 70 {
                let place = [index % 70 - 3, index / 70 - 3].map(f64::from);
                let is_right = triangulation.edges().iter().any(|edge| {
                    let turn = orientation(at(edge.ends[0]), at(edge.ends[1]), place);
                    match edge.triangles() {
                        [Some(_), None] => turn.is_lt(),
                        [None, Some(_)] => turn.is_gt(),
                        _ => false,
                    }
                });
                assert_eq!(hull.is_beyond(place), is_right, "{place:?}");
            }
            assert!(hull.is_beyond([f64::NAN, 1.0]) && hull.is_beyond([1.0, f64::INFINITY]));
        }
    }
}
