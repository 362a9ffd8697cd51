//! Sections against brute force over all edges and triangles, and against the laws they obey.

use std::collections::BTreeSet;
use std::f64::consts::TAU;

use asphera_geometry::{PointMm, RANGE_MM, Rejection, VertexId};
use asphera_mesh::{Location, Mesh};
use asphera_surface::sections::{
    CuttingPlane, Limit, Section, SectionError, SectionPath, SectionPoint, Source, cut, section,
    section_where,
};
use proptest::prelude::*;

use crate::patterns::{PITCH_MM, jittered_raster, raster, scattered};
use crate::random::Random;

type Node = [i64; 2];

fn meshed(points: &[PointMm]) -> Mesh {
    let mut mesh = Mesh::new();
    mesh.insert(points);
    mesh
}

/// Nodes with heights that no plane has.
fn lifted(nodes: &[Node]) -> Mesh {
    let height = |[x, y]: Node| ((x * 7 + y * 13 + x * y).rem_euclid(11)) as f64 / 8.0;
    meshed(
        &nodes
            .iter()
            .map(|&node| [node[0] as f64, node[1] as f64, height(node)])
            .collect::<Vec<_>>(),
    )
}

fn cross(a: Node, b: Node, c: Node) -> i64 {
    (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
}

fn dot(at: Node, p: Node, q: Node) -> i64 {
    (p[0] - at[0]) * (q[0] - at[0]) + (p[1] - at[1]) * (q[1] - at[1])
}

fn edges(mesh: &Mesh) -> BTreeSet<[VertexId; 2]> {
    let sides = mesh.triangles().into_iter().flat_map(|[a, b, c]| [[a, b], [b, c], [c, a]]);
    sides.map(|[a, b]| [a.min(b), a.max(b)]).collect()
}

/// A source without its weights: the vertices it lies between.
fn between(source: &Source) -> Vec<VertexId> {
    match *source {
        Source::Vertex { vertex } => vec![vertex],
        Source::Edge { edge, .. } => edge.to_vec(),
        Source::Triangle { corners, .. } => {
            let mut corners = corners.to_vec();
            corners.sort_unstable();
            corners
        }
    }
}

fn segment(from_mm: [f64; 2], to_mm: [f64; 2]) -> SectionPath {
    SectionPath::Segment { from_mm, to_mm }
}

fn circle(centre_mm: [f64; 2], radius_mm: f64, start_rad: f64) -> SectionPath {
    SectionPath::Circle { centre_mm, radius_mm, start_rad }
}

/// What must hold of any section along a path.
fn assert_sound(mesh: &Mesh, found: &Section) {
    let mut last_mm = f64::NEG_INFINITY;
    for piece in &found.pieces {
        assert!(piece.points.len() >= 2, "{piece:?}");
        for point in &piece.points {
            assert!(point.s_mm >= last_mm, "{point:?} before {last_mm}");
            last_mm = point.s_mm;
            let weights: Vec<(VertexId, f64)> = point.source.weights().collect();
            assert!(weights.iter().all(|&(_, weight)| (0.0..=1.0).contains(&weight)), "{point:?}");
            let axis = |axis: usize| point.interpolate(|v| mesh.points()[v as usize][axis]);
            for (axis, found) in [axis(0), axis(1), axis(2)].into_iter().zip(point.at_mm) {
                assert!((axis - found).abs() <= 1e-12 * (1.0 + found.abs()), "{point:?}");
            }
        }
        for pair in piece.points.windows(2) {
            let same =
                pair[0].source == pair[1].source && matches!(pair[0].source, Source::Vertex { .. });
            assert!(!same, "{pair:?} twice");
        }
    }
}

/// The sources that a segment between nodes must have, by brute force over vertices and edges, with
/// the distance from the start as a fraction of its length. Ends that are no vertices and on no edge
/// are left out.
fn segment_nodes(mesh: &Mesh, nodes: &[Node], p: Node, q: Node) -> Vec<Vec<VertexId>> {
    let at = |vertex: VertexId| nodes[vertex as usize];
    let within = |numerator: i64, denominator: i64| (0..=denominator).contains(&numerator);
    let length = dot(p, q, q);
    let mut found: Vec<(f64, Vec<VertexId>)> = Vec::new();
    for vertex in mesh.vertices().filter(|&vertex| cross(p, q, at(vertex)) == 0) {
        let along = dot(p, q, at(vertex));
        if within(along, length) {
            found.push((along as f64 / length as f64, vec![vertex]));
        }
    }
    for [a, b] in edges(mesh) {
        let (from, to) = (cross(p, q, at(a)), cross(p, q, at(b)));
        // Along an edge only its ends count, and a start or an end between them.
        if from == 0 && to == 0 {
            for (s, end) in [(0.0, p), (1.0, q)] {
                if dot(end, at(a), at(b)) < 0 {
                    found.push((s, vec![a, b]));
                }
            }
        } else if from.signum() * to.signum() < 0 {
            let (start, end) = (cross(at(a), at(b), p), cross(at(a), at(b), q));
            // The share along the way of the place where the start's side turns into the end's.
            let (numerator, denominator) = (start, start - end);
            let sign = denominator.signum();
            if within(numerator * sign, denominator * sign) {
                found.push((numerator as f64 / denominator as f64, vec![a, b]));
            }
        }
    }
    found.sort_by(|left, right| left.0.total_cmp(&right.0));
    found.into_iter().map(|(_, between)| between).collect()
}

fn assert_segment(mesh: &Mesh, nodes: &[Node], p: Node, q: Node) {
    let [from, to] = [p, q].map(|node| node.map(|x| x as f64));
    let found = section(mesh, &segment(from, to), None).expect("it has a length");
    assert_sound(mesh, &found);
    let expected = segment_nodes(mesh, nodes, p, q);
    let seen: Vec<Vec<VertexId>> = found
        .points()
        .map(|point| between(&point.source))
        .filter(|between| between.len() < 3)
        .collect();
    let mut ends = [p, q].map(|end| {
        let [x, y] = end.map(|x| x as f64);
        !matches!(mesh.locate(x, y), Location::Outside { .. } | Location::OffLine)
    });
    if found.pieces.is_empty() {
        // At most it touches a corner.
        assert!(expected.len() <= 1, "{p:?} {q:?}: {expected:?}");
        assert!(!(ends[0] && ends[1]));
        return;
    }
    assert_eq!(found.pieces.len(), 1);
    assert_eq!(seen, expected, "{p:?} {q:?}");
    let piece = &found.pieces[0];
    for (limit, inside) in [piece.begins, piece.ends].into_iter().zip(&mut ends) {
        if limit == Limit::Path {
            assert!(*inside);
        } else {
            assert_eq!(limit, Limit::Hull);
        }
    }
}

fn lattice(width: i64, height: i64) -> Vec<Node> {
    (0..height).flat_map(|y| (0..width).map(move |x| [2 * x, 2 * y])).collect()
}

#[test]
fn on_a_lattice_every_segment_meets_what_brute_force_finds() {
    let nodes = lattice(5, 4);
    let mesh = lifted(&nodes);
    let places = || (-1..=9).flat_map(|x| (-1..=7).map(move |y| [x, y]));
    for p in places() {
        for q in places().filter(|&q| q != p) {
            assert_segment(&mesh, &nodes, p, q);
        }
    }
}

proptest! {
    #[test]
    fn on_scattered_nodes_every_segment_meets_what_brute_force_finds(
        nodes in prop::collection::btree_set(prop::array::uniform2(-6_i64..=6), 4..30),
        ends in prop::array::uniform2(prop::array::uniform2(-8_i64..=8)),
    ) {
        let nodes: Vec<Node> = nodes.into_iter().collect();
        let mesh = lifted(&nodes);
        prop_assume!(mesh.counts().triangles > 0 && ends[0] != ends[1]);
        assert_segment(&mesh, &nodes, ends[0], ends[1]);
    }

    #[test]
    fn turning_round_turns_the_section_round(
        nodes in prop::collection::btree_set(prop::array::uniform2(-6_i64..=6), 4..30),
        ends in prop::array::uniform2(prop::array::uniform2(-8_i64..=8)),
        kept in any::<u64>(),
    ) {
        let nodes: Vec<Node> = nodes.into_iter().collect();
        let mesh = lifted(&nodes);
        prop_assume!(ends[0] != ends[1]);
        let [p, q] = ends.map(|node| node.map(|x| x as f64));
        let keep = |[a, b, c]: [VertexId; 3]| kept >> ((a + 5 * b + 11 * c) % 64) & 1 == 0;
        let there = section_where(&mesh, &segment(p, q), keep).unwrap();
        let back = section_where(&mesh, &segment(q, p), keep).unwrap();
        prop_assert_eq!(there.pieces.len(), back.pieces.len());
        for (there, back) in there.pieces.iter().zip(back.pieces.iter().rev()) {
            prop_assert_eq!((there.begins, there.ends), (back.ends, back.begins));
            prop_assert_eq!(there.points.len(), back.points.len());
            for (there, back) in there.points.iter().zip(back.points.iter().rev()) {
                prop_assert_eq!(between(&there.source), between(&back.source));
                for axis in 0..3 {
                    prop_assert!((there.at_mm[axis] - back.at_mm[axis]).abs() < 1e-12);
                }
            }
        }
    }
}

/// Compares with the state of many places along the path, each located on its own.
fn assert_covers(
    mesh: &Mesh,
    found: &Section,
    keep: impl Fn([VertexId; 3]) -> bool,
    places: impl Iterator<Item = (f64, [f64; 2])>,
    bend_mm: f64,
) {
    let margin_mm = 1e-9;
    for (s_mm, [x, y]) in places {
        let kept = match mesh.locate(x, y) {
            Location::Inside { triangle } => keep(triangle),
            Location::Outside { .. } | Location::OffLine => false,
            // On an edge it depends on both sides.
            _ => continue,
        };
        let near = found.points().any(|point| (point.s_mm - s_mm).abs() < margin_mm);
        let piece = found.pieces.iter().find(|piece| {
            let ends = [piece.points[0], piece.points[piece.points.len() - 1]];
            (ends[0].s_mm..=ends[1].s_mm).contains(&s_mm)
        });
        if near {
            continue;
        }
        assert_eq!(piece.is_some(), kept, "at {s_mm} of {:?}", found.pieces.len());
        let Some(piece) = piece else { continue };
        let after = piece.points.partition_point(|point| point.s_mm <= s_mm);
        let [left, right]: [SectionPoint; 2] = [piece.points[after - 1], piece.points[after]];
        let share = (s_mm - left.s_mm) / (right.s_mm - left.s_mm);
        let z_mm = left.at_mm[2] + share * (right.at_mm[2] - left.at_mm[2]);
        let expected_mm = mesh.interpolate_linear(x, y).expect("the place is inside");
        assert!((z_mm - expected_mm).abs() < bend_mm, "{z_mm} for {expected_mm} at {s_mm}");
    }
}

fn along(p: [f64; 2], q: [f64; 2], count: usize) -> impl Iterator<Item = (f64, [f64; 2])> {
    let length_mm = (q[0] - p[0]).hypot(q[1] - p[1]);
    (0..count).map(move |i| {
        let share = (i as f64 + 0.37) / count as f64;
        (share * length_mm, [p[0] + share * (q[0] - p[0]), p[1] + share * (q[1] - p[1])])
    })
}

fn around(
    centre: [f64; 2],
    radius: f64,
    start: f64,
    count: usize,
) -> impl Iterator<Item = (f64, [f64; 2])> {
    (0..count).map(move |i| {
        let angle = TAU * (i as f64 + 0.37) / count as f64;
        let (sin, cos) = (start + angle).sin_cos();
        (radius * angle, [centre[0] + radius * cos, centre[1] + radius * sin])
    })
}

#[test]
fn pieces_are_where_the_triangles_are_kept() {
    let mut random = Random::new(7);
    for (seed, points) in
        [jittered_raster(40, 0.3, 1), scattered(1500, 0.2, 2), raster(40)].into_iter().enumerate()
    {
        let mesh = meshed(&points);
        let keep = |[a, b, c]: [VertexId; 3]| (a * 7 + b * 3 + c) % 5 > 0;
        for _ in 0..60 {
            let [p, q] = [0, 1].map(|_| [0, 1].map(|_| 0.3 * random.unit() - 0.05));
            let found = section_where(&mesh, &segment(p, q), keep).unwrap();
            assert_sound(&mesh, &found);
            assert_covers(&mesh, &found, keep, along(p, q, 700), 1e-12);
            let radius = 0.3 * random.unit().powi(3) + 1e-5;
            let start = 20.0 * random.unit() - 10.0;
            let found = section_where(&mesh, &circle(p, radius, start), keep).unwrap();
            assert_sound(&mesh, &found);
            // Over a degree of arc the sagitta is 4e-5 of the radius, and slopes are below 1.
            assert_covers(
                &mesh,
                &found,
                keep,
                around(p, radius, start, 900),
                4e-5 * radius + 1e-12,
            );
        }
        assert_eq!(mesh.counts().vertices, points.len() as u64, "{seed}");
    }
}

/// What a circle about a node must cross, with the radius squared a whole number: vertices on it,
/// and each edge as often as it is crossed between its ends.
fn circle_nodes(mesh: &Mesh, nodes: &[Node], centre: Node, squared: i64) -> Vec<Vec<VertexId>> {
    let at = |vertex: VertexId| nodes[vertex as usize];
    let side = |vertex: VertexId| (dot(centre, at(vertex), at(vertex)) - squared).signum();
    let mut found: Vec<Vec<VertexId>> =
        mesh.vertices().filter(|&vertex| side(vertex) == 0).map(|vertex| vec![vertex]).collect();
    for [a, b] in edges(mesh) {
        let heads_in = |from: VertexId, to: VertexId| dot(at(from), at(to), centre) > 0;
        let times = match (side(a), side(b)) {
            (-1, 1) | (1, -1) => 1,
            (0, 1) => usize::from(heads_in(a, b)),
            (1, 0) => usize::from(heads_in(b, a)),
            (1, 1) => {
                let length = dot(at(a), at(b), at(b));
                let near = cross(at(a), at(b), centre).pow(2) < squared * length;
                2 * usize::from(near && heads_in(a, b) && heads_in(b, a))
            }
            _ => 0,
        };
        found.extend(std::iter::repeat_n(vec![a, b], times));
    }
    found.sort();
    found
}

fn assert_circle(mesh: &Mesh, nodes: &[Node], centre: Node, squared: i64, start_rad: f64) {
    let radius = (squared as f64).sqrt();
    let path = circle(centre.map(|x| x as f64), radius, start_rad);
    let found = section(mesh, &path, None).expect("it is a circle");
    assert_sound(mesh, &found);
    let [piece] = &found.pieces[..] else { panic!("{centre:?} {squared}: {found:?}") };
    assert!(piece.is_closed());
    assert_eq!(piece.points[0].at_mm, piece.points[piece.points.len() - 1].at_mm);
    assert!((piece.length_mm() - TAU * radius).abs() < 1e-12 * radius);
    // A point set in between may happen to lie where the circle touches an edge.
    let touched = |between: &[VertexId]| {
        let [a, b] = between[..] else { return false };
        let [a, b] = [a, b].map(|end| nodes[end as usize]);
        cross(a, b, centre).pow(2) == squared * dot(a, b, b)
    };
    let mut seen: Vec<Vec<VertexId>> = piece.points[1..]
        .iter()
        .map(|point| between(&point.source))
        .filter(|between| between.len() < 3 && !touched(between))
        .collect();
    seen.sort();
    assert_eq!(seen, circle_nodes(mesh, nodes, centre, squared), "{centre:?} {squared}");
    for point in &piece.points {
        let [x, y, _] = point.at_mm;
        let away = (x - centre[0] as f64).hypot(y - centre[1] as f64);
        assert!((away - radius).abs() < 1e-14 * (radius + 20.0), "{point:?}");
    }
    for pair in piece.points.windows(2) {
        assert!(pair[1].s_mm - pair[0].s_mm <= radius * TAU / 360.0 * (1.0 + 1e-9), "{pair:?}");
    }
}

#[test]
fn on_a_lattice_every_circle_meets_what_brute_force_finds() {
    let nodes: Vec<Node> = (-9..=9).flat_map(|y| (-9..=9).map(move |x| [2 * x, 2 * y])).collect();
    let mesh = lifted(&nodes);
    // Whole radii only, for a root is not exact.
    for radius in 1..=16 {
        for centre in [[0, 0], [1, 0], [1, 1], [-1, 2]] {
            // The start lies on no edge, where it would be one more point.
            assert_circle(&mesh, &nodes, centre, radius * radius, 0.1234567);
        }
    }
}

proptest! {
    #[test]
    fn on_scattered_nodes_every_circle_meets_what_brute_force_finds(
        nodes in prop::collection::btree_set(prop::array::uniform2(-10_i64..=10), 0..60),
        centre in prop::array::uniform2(-6_i64..=6),
        radius in 1_i64..=10,
    ) {
        let frame = [[-40, -40], [40, -40], [40, 40], [-40, 40]];
        let nodes: Vec<Node> = frame.into_iter().chain(nodes).collect();
        let mesh = lifted(&nodes);
        assert_circle(&mesh, &nodes, centre, radius * radius, 0.1234567);
    }

    #[test]
    fn circles_that_leave_the_mesh_are_where_it_is(
        nodes in prop::collection::btree_set(prop::array::uniform2(-6_i64..=6), 3..20),
        centre in prop::array::uniform2(-8_i64..=8),
        radius in 1_i64..=12,
        start in -3_i32..=3,
        offset in 0.0..0.3_f64,
    ) {
        let nodes: Vec<Node> = nodes.into_iter().collect();
        let mesh = lifted(&nodes);
        let (centre, radius) = (centre.map(|x| x as f64), radius as f64 + offset.max(0.05) - 0.05);
        let start = f64::from(start) * TAU / 4.0;
        let found = section(&mesh, &circle(centre, radius, start), None).unwrap();
        assert_sound(&mesh, &found);
        // Heights differ by up to 1.25 from node to node, slopes of slivers are steeper.
        assert_covers(&mesh, &found, |_| true, around(centre, radius, start, 500), f64::INFINITY);
    }
}

#[test]
fn a_circle_through_every_corner_of_a_raster_starts_and_ends_at_one() {
    let nodes = lattice(9, 9);
    let mesh = lifted(&nodes);
    let found = section(&mesh, &circle([8.0, 8.0], 4.0, 0.0), None).unwrap();
    let [piece] = &found.pieces[..] else { panic!("{found:?}") };
    let start = nodes.iter().position(|&node| node == [12, 8]).unwrap() as VertexId;
    assert_eq!(piece.points[0].source, Source::Vertex { vertex: start });
    assert_eq!(piece.points.last().unwrap().source, Source::Vertex { vertex: start });
    assert!(piece.is_closed());
}

#[test]
fn a_circle_inside_one_triangle() {
    let mesh = meshed(&[[0.0, 0.0, 1.0], [9.0, 0.0, 10.0], [0.0, 9.0, 19.0]]);
    let found = section(&mesh, &circle([2.0, 3.0], 1.0, 0.5), None).unwrap();
    let [piece] = &found.pieces[..] else { panic!("{found:?}") };
    assert!(piece.is_closed() && piece.points.len() == 361);
    for point in &piece.points {
        let [x, y, z] = point.at_mm;
        assert!((z - (1.0 + x + 2.0 * y)).abs() < 1e-14, "{point:?}");
        assert!(((x - 2.0).hypot(y - 3.0) - 1.0).abs() < 1e-15);
    }
    let none = section_where(&mesh, &circle([2.0, 3.0], 1.0, 0.5), |_| false).unwrap();
    assert!(none.pieces.is_empty());
}

#[test]
fn planes_are_reproduced_and_spheres_lie_above_their_chords() {
    let [a, b, c] = [0.3, -0.7, 2.0];
    let plane: Vec<PointMm> = jittered_raster(60, 0.4, 5)
        .into_iter()
        .map(|[x, y, _]| [x, y, a * x + b * y + c])
        .collect();
    let mesh = meshed(&plane);
    let sphere = meshed(&jittered_raster(60, 0.4, 5));
    let middle = 29.5 * PITCH_MM;
    let paths = [
        segment([0.011, 0.02], [0.27, 0.21]),
        circle([middle, middle], 0.1, 0.3),
        SectionPath::Radius { centre_mm: [middle, middle], angle_rad: 4.0 },
    ];
    for path in paths {
        let found = section(&mesh, &path, None).unwrap();
        assert!(found.points().count() > 50);
        for point in found.points() {
            let [x, y, z] = point.at_mm;
            assert!((z - (a * x + b * y + c)).abs() < 1e-15, "{point:?}");
        }
        // Within a gap g of a corner the chords lie at most g² / 2R above; without the thin
        // triangles along the hull.
        let gap_mm = 1.5 * PITCH_MM;
        let found = section(&sphere, &path, Some(gap_mm)).unwrap();
        assert!(found.points().count() > 50);
        for point in found.points() {
            let [x, y, z] = point.at_mm;
            let above = z - crate::patterns::sag_mm(x, y);
            let bound = 1.001 * gap_mm.powi(2) / (2.0 * 50.0);
            assert!((-1e-16..=bound).contains(&above), "{above} at {point:?}");
        }
    }
}

#[test]
fn a_radius_runs_to_the_hull_and_is_exact_along_the_axes() {
    let mesh = lifted(&lattice(9, 7));
    for (quarter, length, passed) in [(0, 8.0, 5), (1, 6.0, 4), (2, 8.0, 5), (3, 6.0, 4)] {
        let path = SectionPath::Radius {
            centre_mm: [8.0, 6.0],
            angle_rad: f64::from(quarter) * TAU / 4.0,
        };
        let found = section(&mesh, &path, None).unwrap();
        let [piece] = &found.pieces[..] else { panic!("{found:?}") };
        assert_eq!((piece.begins, piece.ends), (Limit::Path, Limit::Hull));
        assert_eq!(piece.length_mm(), length);
        assert_eq!(piece.points.len(), passed);
        assert!(piece.points.iter().all(|point| matches!(point.source, Source::Vertex { .. })));
    }
    let outside = SectionPath::Radius { centre_mm: [-3.0, 5.5], angle_rad: 0.0 };
    let found = section(&mesh, &outside, None).unwrap();
    assert_eq!((found.pieces[0].begins, found.pieces[0].points[0].s_mm), (Limit::Hull, 3.0));
    let away = SectionPath::Radius { centre_mm: [-3.0, 5.5], angle_rad: 3.0 };
    assert!(section(&mesh, &away, None).unwrap().pieces.is_empty());
}

#[test]
fn a_gap_is_not_bridged() {
    // A hole of radius 4 in a raster of 1.
    let points: Vec<PointMm> = (0..900)
        .map(|i| [f64::from(i % 30), f64::from(i / 30), 0.0])
        .filter(|[x, y, _]| (x - 15.0).hypot(y - 15.0) > 4.0)
        .collect();
    let mesh = meshed(&points);
    let path = segment([-5.0, 15.25], [50.0, 15.25]);
    let found = section(&mesh, &path, Some(1.0)).unwrap();
    let limits: Vec<_> = found.pieces.iter().map(|piece| (piece.begins, piece.ends)).collect();
    assert_eq!(limits, [(Limit::Hull, Limit::Gap), (Limit::Gap, Limit::Hull)]);
    let [left, right] = [&found.pieces[0], &found.pieces[1]];
    assert!(left.points.last().unwrap().at_mm[0] <= 12.0);
    assert!(right.points[0].at_mm[0] >= 18.0);
    let whole = section(&mesh, &path, None).unwrap();
    assert_eq!((whole.pieces.len(), whole.length_mm()), (1, 29.0));
    // Along the border between kept and not, the section is kept, whichever side that is.
    let border = segment([0.0, 10.0], [29.0, 10.0]);
    for above in [true, false] {
        let keep = |corners: [VertexId; 3]| {
            let y = corners.map(|corner| mesh.points()[corner as usize][1]).iter().sum::<f64>();
            (y > 30.0) == above
        };
        let found = section_where(&mesh, &border, keep).unwrap();
        assert_eq!((found.pieces.len(), found.length_mm()), (1, 29.0));
    }
}

#[test]
fn moving_mesh_and_path_moves_the_section() {
    let nodes: Vec<Node> = lattice(8, 8);
    let moved: Vec<PointMm> =
        lifted(&nodes).points().iter().map(|[x, y, z]| [x + 4096.0, y - 512.0, *z]).collect();
    let (mesh, moved) = (lifted(&nodes), meshed(&moved));
    let paths = |dx: f64, dy: f64| {
        [
            segment([1.0 + dx, 0.5 + dy], [13.0 + dx, 12.25 + dy]),
            circle([7.0 + dx, 7.0 + dy], 5.0, 1.0),
        ]
    };
    for (here, there) in paths(0.0, 0.0).iter().zip(paths(4096.0, -512.0)) {
        let [here, there] =
            [section(&mesh, here, None).unwrap(), section(&moved, &there, None).unwrap()];
        let pairs = here.points().zip(there.points());
        assert_eq!(here.points().count(), there.points().count());
        for (here, there) in pairs {
            assert_eq!(between(&here.source), between(&there.source));
            assert!((here.s_mm - there.s_mm).abs() < 1e-11, "{here:?} {there:?}");
            assert!((here.at_mm[2] - there.at_mm[2]).abs() < 1e-11);
        }
    }
}

#[test]
fn meshes_without_triangles_have_no_section() {
    for count in 0..4 {
        let points: Vec<PointMm> = (0..count).map(|i| [f64::from(i), 0.0, 1.0]).collect();
        let mesh = meshed(&points);
        for path in [
            segment([0.0, 0.0], [2.0, 0.0]),
            segment([0.5, -1.0], [0.5, 1.0]),
            circle([0.0, 0.0], 1.0, 0.0),
            SectionPath::Radius { centre_mm: [0.0, 0.0], angle_rad: 0.0 },
        ] {
            assert_eq!(section(&mesh, &path, None), Ok(Section::default()));
        }
        let plane = CuttingPlane::new([0.0, 0.0, 1.0], 1.0).unwrap();
        assert_eq!(cut(&mesh, &plane, None), Ok(Section::default()));
    }
}

#[test]
fn nonsense_is_named() {
    let mesh = lifted(&lattice(3, 3));
    let error = |path: SectionPath| section(&mesh, &path, None).unwrap_err().to_string();
    assert_eq!(
        error(segment([1.0, 2.0], [1.0, 2.0])),
        "the section starts and ends at (1, 2) mm: it has no length"
    );
    assert_eq!(
        error(segment([0.0, f64::NAN], [1.0, 2.0])),
        "start of the section (0, NaN) mm: a coordinate is not finite"
    );
    for radius_mm in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        let found = section(&mesh, &circle([0.0, 0.0], radius_mm, 0.0), None);
        assert!(matches!(found, Err(SectionError::Radius { .. })), "{radius_mm}");
    }
    let far = SectionPath::Radius { centre_mm: [2.0 * RANGE_MM, 0.0], angle_rad: 0.0 };
    let found = section(&mesh, &far, None).unwrap_err();
    assert!(matches!(found, SectionError::Place { rejection: Rejection::OutOfRange, .. }));
    let turned = SectionPath::Radius { centre_mm: [0.0, 0.0], angle_rad: f64::INFINITY };
    assert_eq!(error(turned), "angle inf rad: expected a number from -1000 to 1000");
    let path = segment([0.0, 0.0], [1.0, 1.0]);
    for limit in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        let found = section(&mesh, &path, Some(limit));
        assert!(matches!(found, Err(SectionError::GapLimit { .. })), "{limit}");
    }
    for (normal, offset) in
        [([0.0; 3], 1.0), ([f64::NAN, 0.0, 1.0], 0.0), ([0.0, 0.0, 1.0], f64::INFINITY)]
    {
        assert!(matches!(CuttingPlane::new(normal, offset), Err(SectionError::Plane { .. })));
    }
}
