//! Small integer lattices against exhaustive integer arithmetic: every degenerate case there is.

use asphera_geometry::{PointMm, VertexId};
use asphera_mesh::{Mesh, Outcome, check};
use proptest::prelude::*;

type Node = [i64; 2];

fn cross(a: Node, b: Node, c: Node) -> i64 {
    (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
}

/// Positive if `d` is inside the circle through the counter-clockwise `a`, `b`, `c`.
fn in_circle([a, b, c]: [Node; 3], d: Node) -> i64 {
    let [a, b, c] = [a, b, c].map(|p| [p[0] - d[0], p[1] - d[1]]);
    let lift = |p: Node| p[0] * p[0] + p[1] * p[1];
    let minor = |p: Node, q: Node| p[0] * q[1] - p[1] * q[0];
    lift(a) * minor(b, c) + lift(b) * minor(c, a) + lift(c) * minor(a, b)
}

/// Whether no node lies strictly to the right of the line from `a` to `b`.
fn on_hull(nodes: &[Node], a: Node, b: Node) -> bool {
    nodes.iter().all(|&node| cross(a, b, node) >= 0)
}

/// Nodes on the boundary of the convex hull and twice its area, by trying every pair.
fn hull(nodes: &[Node]) -> (usize, i64) {
    let mut on_boundary = vec![false; nodes.len()];
    let mut twice_area = 0;
    for (i, &a) in nodes.iter().enumerate() {
        for (j, &b) in nodes.iter().enumerate().filter(|&(j, _)| j != i) {
            if on_hull(nodes, a, b) {
                on_boundary[i] = true;
                on_boundary[j] = true;
                // Only the shortest step along a straight side counts for the shoelace sum.
                let between = |node: &Node| {
                    let dot = |p: Node, q: Node| {
                        (p[0] - node[0]) * (q[0] - node[0]) + (p[1] - node[1]) * (q[1] - node[1])
                    };
                    cross(a, b, *node) == 0 && dot(a, b) < 0
                };
                if !nodes.iter().any(between) {
                    twice_area += a[0] * b[1] - a[1] * b[0];
                }
            }
        }
    }
    (on_boundary.into_iter().filter(|&on| on).count(), twice_area)
}

/// Meshes the nodes, flushing after those marked, and checks the result by integers alone.
fn assert_delaunay(pushed: &[(Node, bool)]) {
    let mut mesh = Mesh::new();
    let mut distinct: Vec<Node> = Vec::new();
    for &(node, flush) in pushed {
        mesh.push([node[0] as f64, node[1] as f64, 0.0]);
        if flush {
            mesh.flush();
        }
        if !distinct.contains(&node) {
            distinct.push(node);
        }
    }
    mesh.flush();

    // Vertices are the different nodes in order of arrival; all others are duplicates of those.
    let vertices: Vec<PointMm> = distinct.iter().map(|n| [n[0] as f64, n[1] as f64, 0.0]).collect();
    assert_eq!(mesh.points(), vertices);
    for (index, (node, _)) in pushed.iter().enumerate() {
        let first = pushed.iter().position(|(other, _)| other == node).expect("it is one of them");
        let of = distinct.iter().position(|other| other == node).expect("it was added") as VertexId;
        let expected = if first == index { Outcome::Vertex(of) } else { Outcome::Duplicate { of } };
        assert_eq!(mesh.outcome(index), Some(expected));
    }

    let triangles: Vec<[Node; 3]> = mesh
        .triangles()
        .into_iter()
        .map(|corners| corners.map(|corner| distinct[corner as usize]))
        .collect();
    let mut twice_area = 0;
    for &triangle in &triangles {
        let [a, b, c] = triangle;
        assert!(cross(a, b, c) > 0, "{triangle:?} is not counter-clockwise");
        twice_area += cross(a, b, c);
        for &node in &distinct {
            assert!(in_circle(triangle, node) <= 0, "{node:?} inside the circle of {triangle:?}");
        }
    }
    let (boundary, twice_hull_area) = hull(&distinct);
    assert_eq!(twice_area, twice_hull_area, "the triangles do not fill the hull");
    let counts = mesh.counts();
    if triangles.is_empty() {
        assert_eq!(counts.edges, distinct.len().saturating_sub(1) as u64);
        assert_eq!(counts.hull, distinct.len() as u64);
    } else {
        assert_eq!(counts.hull, boundary as u64);
        assert_eq!(counts.vertices + counts.triangles, counts.edges + 1);
    }
    assert_eq!(counts.triangles, triangles.len() as u64);
    assert_eq!(check::delaunay(mesh.points(), mesh.triangles()), Ok(()));
}

proptest! {
    #[test]
    fn any_nodes_in_any_order_with_any_flushes(
        pushed in prop::collection::vec((prop::array::uniform2(0_i64..8), prop::bool::weighted(0.2)), 0..80),
    ) {
        assert_delaunay(&pushed);
    }

    #[test]
    fn nodes_of_a_few_lines(
        pushed in prop::collection::vec(((0_i64..40, 0_i64..2), prop::bool::weighted(0.2)), 0..60),
        slope in -2_i64..=2,
    ) {
        let pushed: Vec<(Node, bool)> = pushed
            .into_iter()
            .map(|((along, off), flush)| ([along, slope * along + off / 2], flush))
            .collect();
        assert_delaunay(&pushed);
    }
}

#[test]
fn a_line_that_leaves_its_line_late() {
    let line = (0..30).map(|i| [3 * ((i * 7) % 30), 2 * ((i * 7) % 30)]);
    let rest = [[1, 1], [0, 5], [45, 30], [-3, -2], [44, 29]];
    let pushed: Vec<(Node, bool)> = line.chain(rest).map(|node| (node, true)).collect();
    for end in 0..=pushed.len() {
        assert_delaunay(&pushed[..end]);
    }
}

#[test]
fn a_full_lattice() {
    let pushed: Vec<(Node, bool)> = (0..81).map(|i| ([i % 9, i / 9], i == 40)).collect();
    assert_delaunay(&pushed);
}
