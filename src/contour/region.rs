//! Regions: parts of the plane with outlines and holes, made of triangles of the mesh.

use std::collections::BTreeMap;

use asphera_geometry::predicates::left_of;
use asphera_geometry::{Sets, Sum};

use crate::inside::Inside;
use crate::samples::{PlaceMm, SampleId, Samples};
use crate::triangulation::{EdgeId, TriangleId, distance_mm};
use crate::{Graph, Triangulation};

/// An area of the plane: parts with holes, and its border.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Region {
    parts: Vec<Part>,
    border: Graph,
    left_out: Vec<SampleId>,
}

/// A part of a region: what one can walk through without crossing a single place.
///
/// Lines are closed, and no sample comes twice in one. The outline runs counter-clockwise and holes clockwise, so the part lies on
/// their left. Each begins at its smallest sample, which is not repeated.
#[derive(Clone, Debug, PartialEq)]
pub struct Part {
    /// The line round the part.
    pub outline: Vec<SampleId>,
    /// The lines round what the part lacks, sorted.
    pub holes: Vec<Vec<SampleId>>,
    /// How far its border lies outside these lines, in mm; above 0 of [`crate::regions::auto_shape`] alone.
    pub moved_mm: f64,
    /// The number of its label, from 1; 1 of a method without labels.
    pub label: u32,
}

impl Region {
    /// The region of triangles; n·log n time.
    pub(crate) fn of(triangulation: &Triangulation, inside: &Inside) -> Region {
        let border = Graph::of_edges(triangulation, |edge| inside.is_border(triangulation, edge));
        Region::new(triangulation, &inside.labels(), border)
    }

    /// The region of labelled triangles: 0 is none, and parts of different labels are parted where they meet.
    pub(crate) fn labelled(triangulation: &Triangulation, labels: &[u32]) -> Region {
        let label = |triangle: Option<TriangleId>| label_of(labels, triangle);
        let border = Graph::of_edges(triangulation, |edge| {
            let [left, right] = triangulation.edges()[edge as usize].triangles();
            label(left) != label(right)
        });
        Region::new(triangulation, labels, border)
    }

    /// The region that curves enclose, with those of them that enclose nothing as part of the border.
    ///
    /// A triangle belongs to it if the least number of edges on a way from it to beyond the hull is odd. The edges must be
    /// Delaunay edges.
    pub(crate) fn enclosed(triangulation: &Triangulation, curves: Graph) -> Region {
        let edges = triangulation.edges().iter();
        let walls: Vec<bool> = edges.map(|edge| curves.joins(edge.ends[0], edge.ends[1])).collect();
        Region::new(triangulation, &Inside::by_parity(triangulation, &walls).labels(), curves)
    }

    fn new(triangulation: &Triangulation, labels: &[u32], border: Graph) -> Region {
        let (part_of, count) = numbered(triangulation, labels);
        let mut outlines: Vec<Vec<Vec<SampleId>>> = vec![Vec::new(); count];
        let mut holes = outlines.clone();
        let mut label = vec![0; count];
        for (triangle, ring) in rings(triangulation, labels) {
            let Some(part) = part_of[triangle as usize] else { continue };
            label[part as usize] = labels[triangle as usize];
            for line in simple_lines(&ring) {
                let is_outline = is_counter_clockwise(&line, triangulation.samples());
                (if is_outline { &mut outlines } else { &mut holes })[part as usize].push(line);
            }
        }
        let parts = outlines.into_iter().zip(holes).zip(label);
        let parts = parts.filter_map(|((mut outlines, mut holes), label)| {
            holes.sort_unstable();
            Some(Part { outline: outlines.pop()?, holes, moved_mm: 0.0, label })
        });
        let mut parts: Vec<Part> = parts.collect();
        parts.sort_unstable_by(|a, b| a.outline.cmp(&b.outline));
        let mut is_covered = vec![false; triangulation.len()];
        for (corners, _) in
            triangulation.triangles().iter().zip(labels).filter(|(_, label)| **label > 0)
        {
            corners.iter().for_each(|&corner| is_covered[corner as usize] = true);
        }
        for &sample in border.edges().as_flattened() {
            is_covered[sample as usize] = true;
        }
        let left_out = (0..).zip(is_covered).filter(|(_, is_covered)| !is_covered);
        let left_out = left_out.map(|(sample, _)| sample).collect();
        Region { parts, border, left_out }
    }

    /// The region with the border of all parts moved out: outlines grow and holes shrink.
    pub(crate) fn moved(mut self, by_mm: f64) -> Region {
        self.parts.iter_mut().for_each(|part| part.moved_mm = by_mm);
        self
    }

    /// The parts, by their outlines.
    pub fn parts(&self) -> &[Part] {
        &self.parts
    }

    /// The border: all sides of outlines and holes, and lines that enclose nothing where the method makes such.
    pub fn border(&self) -> &Graph {
        &self.border
    }

    /// The samples that lie neither in a part nor on the border.
    pub fn left_out(&self) -> &[SampleId] {
        &self.left_out
    }

    /// The area of all parts, less their holes, in mm².
    pub fn area_mm2(&self, samples: &Samples) -> f64 {
        total(self.parts.iter().map(|part| part.area_mm2(samples)))
    }
}

impl Part {
    /// The lines of the part: its outline, then its holes.
    pub fn lines(&self) -> impl Iterator<Item = &[SampleId]> {
        std::iter::once(&self.outline).chain(&self.holes).map(Vec::as_slice)
    }

    /// The lines where the border lies, in mm: through the samples of [`Part::lines`] in their order, or beside them by `moved_mm`.
    ///
    /// A place is moved to where the sides beside it meet once they are moved, but by twice that length at most. A hole that is no wider
    /// than twice that length may turn over.
    pub fn lines_mm(&self, samples: &Samples) -> Vec<Vec<PlaceMm>> {
        let moved = |line: &[SampleId]| {
            let [x, y] = samples.places()[line[0] as usize];
            let places = self.relative_mm(line, samples).into_iter();
            places.map(|place| [x + place[0], y + place[1]]).collect()
        };
        let through = |line: &[SampleId]| {
            line.iter().map(|&sample| samples.places()[sample as usize]).collect()
        };
        match self.moved_mm == 0.0 {
            true => self.lines().map(through).collect(),
            false => self.lines().map(moved).collect(),
        }
    }

    /// Its area less that of its holes in mm².
    pub fn area_mm2(&self, samples: &Samples) -> f64 {
        let doubled = |line| doubled_area_mm2(&self.relative_mm(line, samples));
        0.5 * total(self.lines().map(doubled))
    }

    /// Length of its outline and of the lines round its holes in mm.
    pub fn perimeter_mm(&self, samples: &Samples) -> f64 {
        total(self.lines().flat_map(|line| {
            let places = self.relative_mm(line, samples);
            let next = places.iter().cycle().skip(1);
            places.iter().zip(next).map(|(&p, &q)| distance_mm(p, q)).collect::<Vec<f64>>()
        }))
    }

    /// The places of a line less that of its first sample, moved: so a place far from the origin costs nothing.
    fn relative_mm(&self, line: &[SampleId], samples: &Samples) -> Vec<PlaceMm> {
        let at = |sample: SampleId| samples.places()[sample as usize];
        let Some(&first) = line.first() else { return Vec::new() };
        let [x, y] = at(first);
        let places: Vec<PlaceMm> =
            line.iter().map(|&sample| [at(sample)[0] - x, at(sample)[1] - y]).collect();
        if self.moved_mm == 0.0 {
            return places;
        }
        let around = |index: usize| {
            let count = places.len();
            [places[(index + count - 1) % count], places[index], places[(index + 1) % count]]
        };
        (0..places.len()).map(|index| moved(around(index), self.moved_mm)).collect()
    }
}

/// A place of a line with what lies on its left, moved to the right of the sides before and after it.
fn moved([before, place, after]: [PlaceMm; 3], by_mm: f64) -> PlaceMm {
    let outwards = |p: PlaceMm, q: PlaceMm| {
        let [x, y] = [q[0] - p[0], q[1] - p[1]];
        // Squares of differences of 1e-160 mm are zero, and so may be differences of places far off.
        let length_mm = x.hypot(y);
        if length_mm > 0.0 { [y / length_mm, -x / length_mm] } else { [0.0; 2] }
    };
    let [a, b] = [outwards(before, place), outwards(place, after)];
    // Where the moved sides meet: (a + b) / (1 + a·b), which is 1 / cos² of half the turn long, squared. Above 4 it is cut.
    let squared = 2.0 / (1.0 + a[0] * b[0] + a[1] * b[1]).max(0.0);
    let sum = [a[0] + b[0], a[1] + b[1]];
    let length = sum[0].hypot(sum[1]);
    if length == 0.0 {
        return place;
    }
    let step_mm = by_mm * squared.sqrt().min(2.0) / length;
    [place[0] + step_mm * sum[0], place[1] + step_mm * sum[1]]
}

/// The label of a triangle; 0 beyond the hull.
fn label_of(labels: &[u32], triangle: Option<TriangleId>) -> u32 {
    triangle.map_or(0, |triangle| labels[triangle as usize])
}

/// The number of the part of each labelled triangle, and how many there are: triangles of one label that share a side belong together.
fn numbered(triangulation: &Triangulation, labels: &[u32]) -> (Vec<Option<u32>>, usize) {
    let mut sets = Sets::new(labels.len());
    // Edges in their order meet triangles near one another, which a walk from triangle to triangle would not.
    for edge in triangulation.edges() {
        if let [Some(left), Some(right)] = edge.triangles().map(|it| it.map(|it| it as usize))
            && labels[left] != 0
            && labels[left] == labels[right]
        {
            sets.join(left, right);
        }
    }
    let mut parts: Vec<Option<u32>> = vec![None; labels.len()];
    let mut count = 0;
    for (triangle, _) in labels.iter().enumerate().filter(|(_, label)| **label != 0) {
        // A set's root is its smallest member, so it comes first.
        let root = sets.root(triangle);
        if root == triangle {
            parts[triangle] = Some(count);
            count += 1;
        } else {
            parts[triangle] = parts[root];
        }
    }
    (parts, count as usize)
}

/// The closed lines round what has one label, which lies on their left, each with a triangle beside it.
///
/// At a sample a line goes on along the other side of the triangles that it comes along. So each line belongs to one part, and
/// may come through a sample more than once.
fn rings(triangulation: &Triangulation, labels: &[u32]) -> Vec<(TriangleId, Vec<SampleId>)> {
    let label = |triangle: Option<TriangleId>| label_of(labels, triangle);
    let mut is_done = vec![[false; 2]; triangulation.edges().len()];
    let mut rings = Vec::new();
    let sides = triangulation.edges().iter().enumerate();
    let borders =
        sides.filter(|(_, side)| label(side.triangles()[0]) != label(side.triangles()[1]));
    for (first, half) in borders.flat_map(|(edge, _)| [(edge, 0), (edge, 1)]) {
        let triangles = triangulation.edges()[first].triangles();
        let here = label(triangles[half]);
        let Some(beside) = triangles[half].filter(|_| here > 0) else { continue };
        if is_done[first][half] {
            continue;
        }
        let mut ring = Vec::new();
        let (mut triangle, mut edge) = (beside, first as EdgeId);
        loop {
            let is_right = triangulation.edges()[edge as usize].triangles()[1] == Some(triangle);
            is_done[edge as usize][usize::from(is_right)] = true;
            let sides = triangulation.sides(triangle);
            let mut next = (sides.iter().position(|&side| side == edge).unwrap_or(0) + 1) % 3;
            let corner = triangulation.triangles()[triangle as usize][next];
            ring.push(corner);
            while let beyond @ Some(other) = triangulation.across(triangle)[next]
                && label(beyond) == here
            {
                triangle = other;
                let corners = triangulation.triangles()[triangle as usize];
                next = corners.iter().position(|&other| other == corner).unwrap_or(0);
            }
            edge = triangulation.sides(triangle)[next];
            let is_right = triangulation.edges()[edge as usize].triangles()[1] == Some(triangle);
            if edge as usize == first && usize::from(is_right) == half {
                break;
            }
        }
        rings.push((beside, ring));
    }
    rings
}

/// A closed line cut where it comes through a sample again, each piece from its smallest sample on.
fn simple_lines(ring: &[SampleId]) -> Vec<Vec<SampleId>> {
    let mut lines = Vec::new();
    let mut open: Vec<SampleId> = Vec::new();
    let mut place_of: BTreeMap<SampleId, usize> = BTreeMap::new();
    for &sample in ring {
        let before = place_of.insert(sample, open.len());
        // What was cut off since may have left another sample in that place.
        if let Some(begin) = before.filter(|&begin| open.get(begin) == Some(&sample)) {
            lines.push(open.split_off(begin));
            place_of.insert(sample, begin);
        }
        open.push(sample);
    }
    lines.push(open);
    for line in &mut lines {
        let smallest = (0..line.len()).min_by_key(|&index| line[index]).unwrap_or(0);
        line.rotate_left(smallest);
    }
    lines
}

/// Whether a simple closed line from its smallest sample on runs counter-clockwise, decided exactly.
///
/// That sample lies farthest to the left, so the line turns there as it turns as a whole.
fn is_counter_clockwise(line: &[SampleId], samples: &Samples) -> bool {
    let [first, next, .., last] = line else { return false };
    let [last, first, next] = [last, first, next].map(|&sample| samples.places()[sample as usize]);
    left_of(last, first, next)
}

/// Twice the signed area within a closed line in mm², above 0 where it runs counter-clockwise.
fn doubled_area_mm2(line: &[PlaceMm]) -> f64 {
    let next = line.iter().cycle().skip(1);
    total(line.iter().zip(next).map(|(p, q)| p[0] * q[1] - p[1] * q[0]))
}

fn total(terms: impl Iterator<Item = f64>) -> f64 {
    let mut sum = Sum::default();
    terms.for_each(|term| sum.add(term));
    sum.total()
}
