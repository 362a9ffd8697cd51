//! The middle of what lies between regions.

use std::collections::HashMap;

use super::StrokeLine;
use crate::polylines::middle;
use crate::triangulation::{EdgeId, TriangleId, distance_mm};
use crate::{Graph, PlaceMm, SampleId, Samples, Triangulation};

/// The lines between labelled triangles; sides up to `faint_mm` within a region are lines, too.
///
/// Samples within a stroke, all of whose triangles have no label, are left out first: what is Delaunay stays so. Then lines go from the middle of one side
/// within a stroke to the next (chordal axis; L. Prasad, CNLS Newsletter 139 (1997)), and along the sides between two labels.
pub(super) fn lines_of(
    triangulation: &Triangulation,
    labels: &[Option<u32>],
    faint_mm: f64,
) -> Vec<StrokeLine> {
    match outermost(triangulation, labels) {
        None => Axis { triangulation, labels, faint_mm }.lines(),
        Some((thinned, labels)) => {
            Axis { triangulation: &thinned, labels: &labels, faint_mm }.lines()
        }
    }
}

/// The triangulation without samples within strokes, with its labels; none if there are no such samples.
fn outermost(
    triangulation: &Triangulation,
    labels: &[Option<u32>],
) -> Option<(Triangulation, Vec<Option<u32>>)> {
    let mut is_outer = vec![false; triangulation.len()];
    for (corners, label) in triangulation.triangles().iter().zip(labels) {
        if label.is_some() {
            corners.iter().for_each(|&corner| is_outer[corner as usize] = true);
        }
    }
    for edge in triangulation.edges().iter().filter(|edge| edge.triangles().contains(&None)) {
        edge.ends.iter().for_each(|&end| is_outer[end as usize] = true);
    }
    if !is_outer.contains(&false) {
        return None;
    }
    let all = triangulation.samples().places();
    let places: Vec<PlaceMm> =
        all.iter().zip(&is_outer).filter(|(_, is)| **is).map(|(&place, _)| place).collect();
    // Numbers follow the coordinates in both.
    let before: Vec<SampleId> =
        (0..).zip(&is_outer).filter(|(_, is)| **is).map(|(it, _)| it).collect();
    // These places were admitted before.
    let thinned = Triangulation::new(Samples::new(&places).ok()?);
    let known: HashMap<[SampleId; 3], u32> = triangulation
        .triangles()
        .iter()
        .zip(labels)
        .filter_map(|(&corners, label)| Some((corners, (*label)?)))
        .collect();
    let labels = thinned
        .triangles()
        .iter()
        .map(|corners| known.get(&corners.map(|corner| before[corner as usize])).copied())
        .collect();
    Some((thinned, labels))
}

struct Axis<'a> {
    triangulation: &'a Triangulation,
    labels: &'a [Option<u32>],
    faint_mm: f64,
}

impl Axis<'_> {
    fn label(&self, triangle: Option<TriangleId>) -> Option<u32> {
        triangle.map_or(Some(0), |triangle| self.labels[triangle as usize])
    }

    /// The node in the middle of a side; samples are nodes by their own numbers.
    fn of_side(&self, side: EdgeId) -> u32 {
        self.triangulation.len() as u32 + side
    }

    /// The node in the middle of a triangle.
    fn of_triangle(&self, triangle: TriangleId) -> u32 {
        (self.triangulation.len() + self.triangulation.edges().len()) as u32 + triangle
    }

    fn place(&self, node: u32) -> PlaceMm {
        let [samples, sides] = [self.triangulation.len(), self.triangulation.edges().len()];
        let node = node as usize;
        if node < samples {
            self.triangulation.place(node as SampleId)
        } else if node < samples + sides {
            let [p, q] = self.triangulation.ends_mm((node - samples) as EdgeId);
            middle(p, q)
        } else {
            let corners = self.triangulation.triangles()[node - samples - sides];
            let [a, b, c] = corners.map(|corner| self.triangulation.place(corner));
            [(a[0] + b[0] + c[0]) / 3.0, (a[1] + b[1] + c[1]) / 3.0]
        }
    }

    fn lines(&self) -> Vec<StrokeLine> {
        let mut ways: Vec<[u32; 2]> = Vec::new();
        for (edge, side) in self.triangulation.edges().iter().zip(0..) {
            if self.is_line(side) {
                ways.push(edge.ends);
            }
        }
        let mut is_port = vec![false; self.triangulation.len()];
        for sample in 0..self.triangulation.len() as SampleId {
            is_port[sample as usize] = self.enter(sample, &mut ways);
        }
        for triangle in 0..self.triangulation.triangles().len() as TriangleId {
            if self.label(Some(triangle)).is_none() {
                self.cross(triangle, &is_port, &mut ways);
            }
        }
        let count = self.of_triangle(self.triangulation.triangles().len() as TriangleId);
        let mut nodes = vec![Node::default(); count as usize];
        ways.iter().for_each(|&way| change(&mut nodes, way, 1));
        while self.cut_spurs(&mut nodes, &mut ways) {}
        // Nodes that have a way, numbered without gaps.
        let mut numbers = vec![0; nodes.len()];
        let nodes: Vec<u32> =
            (0..).zip(&nodes).filter(|(_, it)| it.degree > 0).map(|(node, _)| node).collect();
        nodes.iter().zip(0_u32..).for_each(|(&node, number)| numbers[node as usize] = number);
        let graph = Graph::new(ways.iter().map(|way| way.map(|node| numbers[node as usize])));
        let chains = graph.chains(nodes.len()).into_iter();
        chains
            .map(|chain| StrokeLine {
                places_mm: chain.samples.iter().map(|&it| self.place(nodes[it as usize])).collect(),
                closed: chain.closed,
            })
            .collect()
    }

    /// Whether a side between two regions, or within one, is a line.
    fn is_line(&self, side: EdgeId) -> bool {
        match self.triangulation.edges()[side as usize].triangles().map(|it| self.label(it)) {
            [Some(left), Some(right)] => {
                left != right || self.triangulation.length_mm(side) <= self.faint_mm
            }
            _ => false,
        }
    }

    /// The ways through a triangle without a label.
    fn cross(&self, triangle: TriangleId, is_port: &[bool], ways: &mut Vec<[u32; 2]>) {
        let sides = self.triangulation.sides(triangle);
        let corners = self.triangulation.triangles()[triangle as usize];
        let faced = self.triangulation.across(triangle).map(|beyond| self.label(beyond));
        let inner: Vec<usize> = (0..3).filter(|&side| faced[side].is_none()).collect();
        match inner[..] {
            [a, b] => ways.push([self.of_side(sides[a]), self.of_side(sides[b])]),
            [a] => ways.push([self.of_side(sides[a]), corners[(a + 2) % 3]]),
            [] => {
                let ports: Vec<usize> =
                    (0..3).filter(|&corner| is_port[corners[corner] as usize]).collect();
                match ports[..] {
                    [p, q] => ways.push([corners[p], corners[q]]),
                    [_, _, _] => {
                        ways.extend(corners.map(|corner| [corner, self.of_triangle(triangle)]));
                    }
                    _ => {}
                }
            }
            _ => ways.extend(sides.map(|side| [self.of_side(side), self.of_triangle(triangle)])),
        }
    }

    /// Whether a sample joins several strokes or lines; if so, the ways from it into strokes of several triangles.
    fn enter(&self, sample: SampleId, ways: &mut Vec<[u32; 2]>) -> bool {
        let fan = self.triangulation.fan(sample);
        let is_stroke: Vec<bool> = fan.sectors.iter().map(|&it| self.label(it).is_none()).collect();
        let count = is_stroke.len();
        let Some(start) = is_stroke.iter().position(|is| !is) else { return false };
        let mut met = fan.edges.iter().filter(|&&edge| self.is_line(edge)).count();
        let mut nearest: Vec<EdgeId> = Vec::new();
        let mut inner: Vec<EdgeId> = Vec::new();
        for step in 1..=count {
            let at = (start + step) % count;
            match (is_stroke[at], is_stroke[(at + count - 1) % count]) {
                (true, false) => met += 1,
                (true, true) => inner.push(fan.edges[at]),
                (false, _) => {
                    let by_length = |&edge: &EdgeId| self.triangulation.length_class(edge);
                    nearest.extend(inner.drain(..).min_by_key(by_length));
                }
            }
        }
        if met > 1 {
            ways.extend(nearest.into_iter().map(|edge| [sample, self.of_side(edge)]));
        }
        met > 1
    }

    /// Takes ends off that begin at a junction and are no longer than twice the width of the stroke there; false if there are none.
    fn cut_spurs(&self, nodes: &mut [Node], ways: &mut Vec<[u32; 2]>) -> bool {
        let samples = self.triangulation.len() as u32;
        let width_mm = |node: u32| match node.checked_sub(samples) {
            Some(side) if (side as usize) < self.triangulation.edges().len() => {
                self.triangulation.length_mm(side)
            }
            _ => 0.0,
        };
        let mut gone: Vec<[u32; 2]> = Vec::new();
        for (leaf, node) in (0..).zip(&*nodes).filter(|(_, node)| node.degree == 1) {
            let (mut before, mut at) = (leaf, node.others);
            let mut branch = vec![[leaf.min(at), leaf.max(at)]];
            let mut length_mm = distance_mm(self.place(leaf), self.place(at));
            let mut widest_mm = width_mm(at);
            while nodes[at as usize].degree == 2 {
                let next = nodes[at as usize].others ^ before;
                if next == before {
                    break;
                }
                branch.push([at.min(next), at.max(next)]);
                length_mm += distance_mm(self.place(at), self.place(next));
                widest_mm = f64::max(widest_mm, width_mm(next));
                (before, at) = (at, next);
            }
            if nodes[at as usize].degree > 2 && length_mm <= 2.0 * widest_mm {
                gone.extend(branch);
            }
        }
        gone.sort_unstable();
        ways.retain(|&[p, q]| {
            let is_gone = gone.binary_search(&[p.min(q), p.max(q)]).is_ok();
            if is_gone {
                change(nodes, [p, q], -1);
            }
            !is_gone
        });
        !gone.is_empty()
    }
}

/// What the ways at a node lead to.
#[derive(Clone, Copy, Default)]
struct Node {
    degree: u32,
    /// The other ends of its ways, joined by exclusive or: the one end, or of two each from the other.
    others: u32,
}

/// Adds a way to the nodes at its ends, or takes it away.
fn change(nodes: &mut [Node], [p, q]: [u32; 2], by: i32) {
    for (at, to) in [(p, q), (q, p)] {
        let node = &mut nodes[at as usize];
        node.degree = node.degree.wrapping_add_signed(by);
        node.others ^= to;
    }
}
