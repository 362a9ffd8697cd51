//! What one asks of a mesh, against brute force over all its vertices and triangles.

use std::collections::{BTreeMap, BTreeSet};

use asphera_geometry::{PointMm, RANGE_MM, Rejection, VertexId};
use asphera_mesh::{Location, Mesh};
use proptest::prelude::*;
use rand_core::{Rng, SeedableRng};
use rand_pcg::Pcg64;

use crate::patterns::{PITCH_MM, jittered_raster, raster, scattered, spiral};

type Node = [i64; 2];

fn meshed(nodes: &[Node]) -> Mesh {
    let mut mesh = Mesh::new();
    mesh.insert(&nodes.iter().map(|&[x, y]| [x as f64, y as f64, 0.0]).collect::<Vec<_>>());
    mesh
}

fn minus(p: Node, q: Node) -> [i128; 2] {
    [i128::from(p[0] - q[0]), i128::from(p[1] - q[1])]
}

fn cross(a: Node, b: Node, c: Node) -> i128 {
    let (p, q) = (minus(b, a), minus(c, a));
    p[0] * q[1] - p[1] * q[0]
}

fn dot(at: Node, p: Node, q: Node) -> i128 {
    let (p, q) = (minus(p, at), minus(q, at));
    p[0] * q[0] + p[1] * q[1]
}

/// The sides that belong to one triangle only, each from its start to its end.
fn hull_of(mesh: &Mesh) -> BTreeMap<VertexId, VertexId> {
    let sides: BTreeSet<[VertexId; 2]> =
        mesh.triangles().into_iter().flat_map(|[a, b, c]| [[a, b], [b, c], [c, a]]).collect();
    sides.iter().filter(|&&[a, b]| !sides.contains(&[b, a])).map(|&[a, b]| (a, b)).collect()
}

/// The squared distance from a place to an edge, as a fraction.
fn squared_distance(a: Node, b: Node, place: Node) -> [i128; 2] {
    if dot(a, b, place) <= 0 {
        [dot(a, place, place), 1]
    } else if dot(b, a, place) <= 0 {
        [dot(b, place, place), 1]
    } else {
        [cross(a, b, place).pow(2), dot(a, b, b)]
    }
}

fn located(mesh: &Mesh, nodes: &[Node], place: Node) -> Location {
    let at = |vertex: VertexId| nodes[vertex as usize];
    let vertices: Vec<VertexId> = mesh.vertices().collect();
    if vertices.is_empty() {
        return Location::Empty;
    }
    if let Some(&vertex) = vertices.iter().find(|&&vertex| at(vertex) == place) {
        return Location::At { vertex };
    }
    let triangles = mesh.triangles();
    if triangles.is_empty() {
        let between = |a: VertexId, b: VertexId| {
            cross(at(a), at(b), place) == 0 && dot(place, at(a), at(b)) < 0
        };
        let ordered = |&a: &VertexId, &b: &VertexId| at(a).cmp(&at(b));
        let mut along = vertices;
        along.sort_unstable_by(ordered);
        let pair = along.windows(2).find(|pair| between(pair[0], pair[1]));
        return pair.map_or(Location::OffLine, |pair| Location::OnEdge {
            edge: [pair[0].min(pair[1]), pair[0].max(pair[1])],
        });
    }
    for &triangle in &triangles {
        let [a, b, c] = triangle;
        let turns = [(a, b), (b, c), (c, a)].map(|(p, q)| (cross(at(p), at(q), place), p, q));
        if turns.iter().all(|&(turn, ..)| turn > 0) {
            return Location::Inside { triangle };
        }
        if turns.iter().all(|&(turn, ..)| turn >= 0) {
            let (_, p, q) = turns.into_iter().find(|&(turn, ..)| turn == 0).expect("it is on one");
            return Location::OnEdge { edge: [p.min(q), p.max(q)] };
        }
    }
    let outer = hull_of(mesh).into_iter().filter(|&(p, q)| cross(at(p), at(q), place) < 0);
    let outer: Vec<_> = outer.map(|(p, q)| (squared_distance(at(p), at(q), place), p, q)).collect();
    let less = |p: [i128; 2], q: [i128; 2]| p[0] * q[1] < q[0] * p[1];
    let nearest: Vec<[VertexId; 2]> = outer
        .iter()
        .filter(|(distance, ..)| !outer.iter().any(|&(other, ..)| less(other, *distance)))
        .map(|&(_, p, q)| [p, q])
        .collect();
    // Of two with a common nearest corner, the one that ends there.
    let first = nearest.iter().find(|edge| nearest.iter().all(|other| other[1] != edge[0]));
    Location::Outside { edge: *first.expect("some side is nearest") }
}

fn nearest(mesh: &Mesh, nodes: &[Node], place: Node) -> Option<VertexId> {
    mesh.vertices().min_by_key(|&vertex| {
        let at = nodes[vertex as usize];
        (dot(place, at, at), at)
    })
}

/// Compares all answers with those found by brute force, at nodes in and around the mesh.
fn assert_answers(mesh: &Mesh, nodes: &[Node], places: impl IntoIterator<Item = Node>) {
    for place in places {
        let [x, y] = place.map(|coordinate| coordinate as f64);
        assert_eq!(mesh.locate(x, y), located(mesh, nodes, place), "{place:?}");
        assert_eq!(mesh.nearest(x, y), nearest(mesh, nodes, place), "{place:?}");
    }
    assert_neighbours(mesh);
}

/// Compares neighbours, stars and rings with what the list of triangles says.
fn assert_neighbours(mesh: &Mesh) {
    let triangles: BTreeSet<[VertexId; 3]> = mesh.triangles().into_iter().collect();
    if triangles.is_empty() {
        return;
    }
    let hull = hull_of(mesh);
    let mut edges: BTreeMap<VertexId, BTreeSet<VertexId>> = BTreeMap::new();
    for &[a, b, c] in &triangles {
        for [from, to] in [[a, b], [b, c], [c, a], [b, a], [c, b], [a, c]] {
            edges.entry(from).or_default().insert(to);
        }
    }
    for vertex in mesh.vertices() {
        let found = mesh.neighbours(vertex).expect("it is a vertex");
        let expected = &edges[&vertex];
        assert_eq!(found.vertices.len(), expected.len());
        assert_eq!(&found.vertices.iter().copied().collect::<BTreeSet<_>>(), expected);
        assert_eq!(found.on_hull, hull.contains_key(&vertex));
        let [first, .., last] = found.vertices[..] else { panic!("a single neighbour") };
        // Each with the next makes a triangle, counter-clockwise.
        let mut star = Vec::new();
        for pair in found.vertices.windows(2) {
            star.push(turned([vertex, pair[0], pair[1]]));
        }
        if found.on_hull {
            assert_eq!((hull[&vertex], hull[&last]), (first, vertex));
        } else {
            assert_eq!(Some(&first), expected.first());
            star.push(turned([vertex, last, first]));
        }
        assert!(star.iter().all(|corners| triangles.contains(corners)));
        assert_eq!(mesh.star(vertex), Some(star));

        let mut known = BTreeSet::from([vertex]);
        let mut within = Vec::new();
        let mut ring = vec![vertex];
        for rings in 0..4 {
            assert_eq!(mesh.within(vertex, rings).as_ref(), Some(&within));
            let next: BTreeSet<VertexId> =
                ring.iter().flat_map(|vertex| &edges[vertex]).copied().collect();
            ring = next.difference(&known).copied().collect();
            known.extend(&ring);
            within.extend(&ring);
        }
    }
}

fn turned([a, b, c]: [VertexId; 3]) -> [VertexId; 3] {
    [[a, b, c], [b, c, a], [c, a, b]].into_iter().min().expect("there are three")
}

fn window(reach: i64) -> impl Iterator<Item = Node> + Clone {
    (-reach..=reach).flat_map(move |y| (-reach..=reach).map(move |x| [x, y]))
}

#[test]
fn a_full_lattice() {
    let nodes: Vec<Node> = (0..49).map(|i| [4 * (i % 7) - 12, 4 * (i / 7) - 12]).collect();
    assert_answers(&meshed(&nodes), &nodes, window(20));
}

#[test]
fn a_sharp_corner_and_places_behind_it() {
    // Its two sides at the tip are never both before a place.
    let nodes = [[0, 0], [40, -1], [40, 1], [41, 0]];
    assert_answers(&meshed(&nodes), &nodes, window(30).map(|[x, y]| [x - 10, y]));
    // The perpendicular meets the hull exactly at a corner, and inside a straight side.
    let nodes = [[0, 0], [4, -4], [8, 0], [4, 4], [2, -2], [6, 2]];
    assert_answers(&meshed(&nodes), &nodes, window(20));
}

#[test]
fn none_one_and_a_line() {
    assert_answers(&meshed(&[]), &[], window(2));
    assert_answers(&meshed(&[[1, 1]]), &[[1, 1]], window(3));
    for step in [[2, 0], [0, 2], [2, 4], [-4, 2]] {
        let nodes: Vec<Node> =
            [3, 0, 4, 1].into_iter().map(|i| [step[0] * i - 3, step[1] * i - 3]).collect();
        let mesh = meshed(&nodes);
        assert_answers(&mesh, &nodes, window(20));
        let neighbours = |vertex| mesh.neighbours(vertex).unwrap();
        assert!(neighbours(0).on_hull);
        let mut inner = [3, 2];
        inner.sort_by_key(|&vertex| nodes[vertex as usize]);
        assert_eq!(neighbours(0).vertices, inner);
        assert_eq!(neighbours(1).vertices, [3]);
        assert_eq!(mesh.star(0), Some(vec![]));
        assert_eq!(mesh.within(2, 2), Some(vec![0, 3]));
    }
}

#[test]
fn no_such_vertex_and_no_such_place() {
    let mut mesh = meshed(&[[0, 0], [1, 0], [0, 1], [1, 1]]);
    assert_eq!(mesh.neighbours(4), None);
    mesh.remove(1).unwrap();
    assert_eq!((mesh.neighbours(1), mesh.star(1), mesh.within(1, 3)), (None, None, None));
    for (bad, rejection) in [
        (f64::NAN, Rejection::NotFinite),
        (f64::NEG_INFINITY, Rejection::NotFinite),
        (2.0 * RANGE_MM, Rejection::OutOfRange),
    ] {
        assert_eq!(mesh.locate(0.0, bad), Location::Rejected(rejection));
        assert_eq!(mesh.locate(bad, 0.0), Location::Rejected(rejection));
        assert_eq!(mesh.nearest(bad, 0.0), None);
        assert!(mesh.natural_coordinates(bad, 0.0).is_empty());
        assert_eq!(mesh.interpolate_linear(0.0, bad), None);
    }
    assert_eq!(mesh.locate(-1e-300, 0.0), Location::At { vertex: 0 });
    assert_eq!(mesh.nearest(RANGE_MM, -RANGE_MM), Some(0));
}

#[test]
fn scans_and_their_neighbours() {
    for points in [raster(30), jittered_raster(30, 0.2, 1), spiral(900), scattered(900, 1.0, 2)] {
        let mut mesh = Mesh::new();
        mesh.insert(&points);
        assert_neighbours(&mesh);
    }
}

/// Places in units of 1e-3 mm around 1e6 mm: coordinates are rounded, so `robust` decides.
#[test]
fn far_away() {
    let mut rng = Pcg64::seed_from_u64(5);
    let mut coordinate = |of: f64| of + f64::from(rng.next_u32() % 40) * 1e-3;
    let points: Vec<PointMm> = (0..300).map(|_| [coordinate(1e6), coordinate(-1e6), 0.0]).collect();
    let mut mesh = Mesh::new();
    mesh.insert(&points);
    let coord = |[x, y]: [f64; 2]| robust::Coord { x, y };
    let at = |vertex: VertexId| {
        let [x, y, _] = mesh.points()[vertex as usize];
        coord([x, y])
    };
    for _ in 0..3_000 {
        let place = [coordinate(1e6 - 2e-3) + 5e-4, coordinate(-1e6 - 2e-3)];
        let turn = |p, q| robust::orient2d(at(p), at(q), coord(place));
        match mesh.locate(place[0], place[1]) {
            Location::Inside { triangle: [a, b, c] } => {
                assert!([(a, b), (b, c), (c, a)].iter().all(|&(p, q)| turn(p, q) > 0.0));
            }
            Location::OnEdge { edge: [a, b] } => assert_eq!(turn(a, b), 0.0),
            Location::At { vertex } => assert_eq!(at(vertex), coord(place)),
            Location::Outside { edge: [a, b] } => assert!(turn(a, b) < 0.0),
            other => panic!("{other:?}"),
        }
        // Differences to the place are no larger than 2⁻⁴, and multiples of 2⁻³³: exact as
        // integers.
        let squared = |vertex: VertexId| {
            let [x, y] = [at(vertex).x - place[0], at(vertex).y - place[1]]
                .map(|difference| (difference * 2.0_f64.powi(33)) as i64);
            x * x + y * y
        };
        let by_place = |&p: &VertexId, &q: &VertexId| {
            let (p, q) = (at(p), at(q));
            p.x.total_cmp(&q.x).then(p.y.total_cmp(&q.y))
        };
        let expected = mesh
            .vertices()
            .min_by(|p, q| squared(*p).cmp(&squared(*q)).then_with(|| by_place(p, q)));
        assert_eq!(mesh.nearest(place[0], place[1]), expected);
    }
}

#[test]
fn answers_do_not_depend_on_how_the_mesh_grew() {
    let points = jittered_raster(40, 0.3, 3);
    let mut at_once = Mesh::new();
    at_once.insert(&points);
    let mut bit_by_bit = Mesh::new();
    for chunk in points.chunks(7) {
        bit_by_bit.insert(chunk);
    }
    for place in scattered(2_000, 50.0 * PITCH_MM, 4) {
        let [x, y] = [place[0] - 5.0 * PITCH_MM, place[1] - 5.0 * PITCH_MM];
        assert_eq!(at_once.locate(x, y), bit_by_bit.locate(x, y));
        assert_eq!(at_once.nearest(x, y), bit_by_bit.nearest(x, y));
        let bits = |mesh: &Mesh| -> Vec<(VertexId, u64)> {
            let weights = mesh.natural_coordinates(x, y);
            weights.into_iter().map(|(vertex, weight)| (vertex, weight.to_bits())).collect()
        };
        assert_eq!(bits(&at_once), bits(&bit_by_bit));
    }
}

proptest! {
    #[test]
    fn any_nodes(
        nodes in prop::collection::btree_set(prop::array::uniform2(-8_i64..=8), 0..40),
        spread in 1_i64..4,
        order in any::<u64>(),
        removed in 0_usize..10,
    ) {
        let mut nodes: Vec<Node> =
            nodes.into_iter().map(|node| node.map(|coordinate| coordinate * spread)).collect();
        nodes.sort_by_key(|&[x, y]| {
            (x as u64 ^ order).wrapping_mul(y as u64 ^ 0x9e37_79b9_7f4a_7c15).rotate_left(17)
        });
        let mut mesh = meshed(&nodes);
        for vertex in 0..removed.min(nodes.len()) as VertexId {
            mesh.remove(vertex).unwrap();
        }
        let between = |coordinate: i64| coordinate * spread - spread / 2;
        assert_answers(&mesh, &nodes, window(10).map(|place| place.map(between)));
    }
}
