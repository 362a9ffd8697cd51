//! Cuts of facets in space: bodies whose sections are known by formula, and every segment by brute force.

use std::f64::consts::{PI, TAU};

use asphera_geometry::PointMm;
use asphera_surface::sections::{CuttingPlane, Limit, Section, SectionError, Source, cut_facets};
use proptest::prelude::*;

/// Points, and facets between them.
type Body = (Vec<PointMm>, Vec<[u32; 3]>);

/// A grid of places, each with its neighbour to the right and above; wrapped along the axes that say so.
fn grid([wide, high]: [u32; 2], wrapped: [bool; 2], at: impl Fn(f64, f64) -> PointMm) -> Body {
    let number = |i: u32, j: u32| (j % high) * wide + i % wide;
    let all = (0..high).flat_map(|j| (0..wide).map(move |i| (i, j)));
    let points = all.clone().map(|(i, j)| at(f64::from(i), f64::from(j))).collect();
    let inside = |(i, j): &(u32, u32)| (wrapped[0] || i + 1 < wide) && (wrapped[1] || j + 1 < high);
    let facets = all.filter(inside).flat_map(|(i, j)| {
        let [a, b, c, d] = [(i, j), (i + 1, j), (i + 1, j + 1), (i, j + 1)];
        let [a, b, c, d] = [a, b, c, d].map(|(i, j)| number(i, j));
        [[a, b, c], [a, c, d]]
    });
    (points, facets.collect())
}

fn tube(radius_mm: f64, length_mm: f64, [round, along]: [u32; 2]) -> Body {
    grid([round, along], [true, false], |i, j| {
        let (sin, cos) = (TAU * i / f64::from(round)).sin_cos();
        [radius_mm * cos, radius_mm * sin, length_mm * j / f64::from(along - 1)]
    })
}

fn torus(ring_mm: f64, tube_mm: f64, [round, about]: [u32; 2]) -> Body {
    grid([round, about], [true, true], |i, j| {
        let (sin_u, cos_u) = (TAU * i / f64::from(round)).sin_cos();
        let (sin_t, cos_t) = (TAU * j / f64::from(about)).sin_cos();
        let from_axis = ring_mm + tube_mm * cos_t;
        [from_axis * cos_u, from_axis * sin_u, tube_mm * sin_t]
    })
}

/// A ball with a fan at either pole.
fn ball(radius_mm: f64, [round, rings]: [u32; 2]) -> Body {
    let (mut points, mut facets) = grid([round, rings], [true, false], |i, j| {
        let (sin_t, cos_t) = (PI * (j + 1.0) / f64::from(rings + 1)).sin_cos();
        let (sin_u, cos_u) = (TAU * i / f64::from(round)).sin_cos();
        [radius_mm * sin_t * cos_u, radius_mm * sin_t * sin_u, radius_mm * cos_t]
    });
    for (z, first) in [(radius_mm, 0), (-radius_mm, (rings - 1) * round)] {
        let pole = points.len() as u32;
        points.push([0.0, 0.0, z]);
        facets.extend((0..round).map(|i| [pole, first + i, first + (i + 1) % round]));
    }
    (points, facets)
}

fn section((points, facets): &Body, normal: PointMm, offset_mm: f64) -> Section {
    let plane = CuttingPlane::new(normal, offset_mm).expect("its normal has a direction");
    cut_facets(points, facets, &plane, None).expect("there is no limit")
}

#[test]
fn a_ball_is_cut_in_a_circle() {
    let ball = ball(10.0, [400, 199]);
    for (normal, offset_mm) in [
        // Skew; through the poles, vertices and edges; along a ring of vertices.
        ([0.3, -0.5, 0.8], 4.0),
        ([0.0, 1.0, 0.0], 0.0),
        ([0.0, 0.0, 1.0], 0.0),
        ([1.0, 0.0, 0.0], -9.0),
    ] {
        let found = section(&ball, normal, offset_mm);
        let [piece] = &found.pieces[..] else { panic!("{normal:?}: {}", found.pieces.len()) };
        assert!(piece.is_closed(), "{normal:?}");
        let length = normal.iter().map(|n: &f64| n * n).sum::<f64>().sqrt();
        let offset_mm: f64 = offset_mm / length;
        let radius_mm = (100.0 - offset_mm * offset_mm).sqrt();
        let expected_mm = TAU * radius_mm;
        let error = piece.length_mm() / expected_mm - 1.0;
        assert!(error < 1e-12 && error > -1e-3, "{normal:?}: {error}");
        for point in &piece.points {
            let above: f64 = normal.iter().zip(point.at_mm).map(|(n, x)| n * x).sum();
            assert!((above / length - offset_mm).abs() < 1e-13, "{normal:?} {above}");
            let off = point.at_mm.iter().map(|x| x * x).sum::<f64>().sqrt();
            assert!((off - 10.0).abs() < 2e-3, "{off}");
        }
    }
    // Outside, and touching at a pole.
    assert!(section(&ball, [0.0, 0.0, 1.0], 10.5).pieces.is_empty());
    assert!(section(&ball, [0.0, 0.0, 1.0], 10.0).pieces.is_empty());
}

#[test]
fn a_torus_is_cut_in_two_circles_beside_and_within_each_other() {
    let torus = torus(20.0, 5.0, [600, 200]);
    let found = section(&torus, [0.0, 1.0, 0.0], 0.0);
    assert_eq!(found.pieces.len(), 2);
    for piece in &found.pieces {
        assert!(piece.is_closed());
        assert!((piece.length_mm() / (TAU * 5.0) - 1.0).abs() < 1e-3, "{}", piece.length_mm());
    }
    let found = section(&torus, [0.0, 0.0, 1.0], 3.0);
    let mut lengths: Vec<f64> = found.pieces.iter().map(|piece| piece.length_mm() / TAU).collect();
    lengths.sort_by(f64::total_cmp);
    let [inner, outer] = lengths[..] else { panic!("{lengths:?}") };
    assert!((inner - 16.0).abs() < 1e-2 && (outer - 24.0).abs() < 1e-2, "{inner} {outer}");
    // Oblique at the slope where it touches on both sides: two circles of the ring's radius (Y. Villarceau, 1848) that cross.
    let slope = (5.0_f64 / 20.0).asin();
    let found = section(&torus, [0.0, -slope.sin(), slope.cos()], 0.0);
    assert!((found.length_mm() / (2.0 * TAU * 20.0) - 1.0).abs() < 1e-3, "{}", found.length_mm());
}

#[test]
fn an_open_tube_is_cut_in_open_lines_that_end_at_its_border() {
    // 90 round: no vertex lies on the plane x = 3; 4 round: vertices and edges lie on x = 0.
    for (round, x_mm) in [(90, 3.0), (90, 0.0), (4, 0.0)] {
        let found = section(&tube(7.0, 12.0, [round, 5]), [1.0, 0.0, 0.0], x_mm);
        assert_eq!(found.pieces.len(), 2, "{round} {x_mm}");
        for piece in &found.pieces {
            assert_eq!((piece.begins, piece.ends), (Limit::Border, Limit::Border));
            assert!((piece.length_mm() - 12.0).abs() < 1e-12, "{}", piece.length_mm());
        }
    }
    // Across: a circle; along its border: once, closed.
    for z_mm in [0.0, 3.0, 5.0, 12.0] {
        let found = section(&tube(7.0, 12.0, [360, 5]), [0.0, 0.0, 1.0], z_mm);
        let [piece] = &found.pieces[..] else { panic!("{z_mm}: {found:?}") };
        assert!(piece.is_closed());
        assert!((piece.length_mm() / (TAU * 7.0) - 1.0).abs() < 1e-4);
    }
}

#[test]
fn a_plane_through_vertices_and_edges_takes_each_line_once() {
    // An octahedron: its equator lies on four edges.
    let points: Vec<PointMm> = (0..6)
        .map(|at| {
            let mut place = [0.0; 3];
            place[at / 2] = if at % 2 == 0 { 1.0 } else { -1.0 };
            place
        })
        .collect();
    let facets: Vec<[u32; 3]> =
        (0..8).map(|at| [at & 1, 2 + (at >> 1 & 1), 4 + (at >> 2 & 1)]).collect();
    let octahedron = (points.clone(), facets);
    let found = section(&octahedron, [0.0, 0.0, 1.0], 0.0);
    let [piece] = &found.pieces[..] else { panic!("{found:?}") };
    assert!(piece.is_closed() && piece.points.len() == 5);
    assert!((piece.length_mm() - 4.0 * 2.0_f64.sqrt()).abs() < 1e-15);
    assert!(piece.points.iter().all(|point| matches!(point.source, Source::Vertex { .. })));
    // Three leaves at one edge: a plane across it meets all three there.
    let leaves = (
        vec![
            [0.0, 0.0, -1.0],
            [0.0, 0.0, 1.0],
            [1.0, 0.0, 0.0],
            [0.0, 1.0, 0.0],
            [-1.0, -1.0, 0.0],
        ],
        vec![[0, 1, 2], [0, 1, 3], [0, 1, 4]],
    );
    let found = section(&leaves, [0.0, 0.0, 1.0], 0.25);
    let limits: Vec<_> = found.pieces.iter().map(|piece| (piece.begins, piece.ends)).collect();
    assert_eq!(limits, [(Limit::Junction, Limit::Border); 3]);
    let found = section(&leaves, [0.0, 1.0, 0.0], 0.0);
    // The leaf in the plane is not cut; the edge that it shares with the others is, once.
    let [piece] = &found.pieces[..] else { panic!("{found:?}") };
    assert_eq!(piece.length_mm(), 2.0);
    let limit =
        cut_facets(&points, &[], &CuttingPlane::new([1.0, 0.0, 0.0], 0.0).unwrap(), Some(0.0));
    assert_eq!(limit, Err(SectionError::GapLimit { limit_mm: 0.0 }));
}

#[test]
fn a_wide_facet_breaks_the_section() {
    let (points, mut facets) = tube(7.0, 12.0, [360, 13]);
    let plane = CuttingPlane::new([0.0, 0.0, 1.0], 6.5).unwrap();
    // 1 mm long and 0.12 mm wide: gaps of 0.5 mm.
    let whole = cut_facets(&points, &facets, &plane, Some(0.6)).unwrap();
    assert!(whole.pieces[0].is_closed());
    assert!(cut_facets(&points, &facets, &plane, Some(0.4)).unwrap().pieces.is_empty());
    // A hole: it ends at a border on either side.
    let at = facets.iter().position(|facet| facet.iter().all(|&corner| corner / 360 >= 6)).unwrap();
    facets.remove(at);
    let open = cut_facets(&points, &facets, &plane, Some(0.6)).unwrap();
    assert_eq!((open.pieces[0].begins, open.pieces[0].ends), (Limit::Border, Limit::Border));
}

proptest! {
    /// Of points on a small lattice nearly everything lies on the plane: each segment is there once, whatever facets there are.
    #[test]
    fn every_segment_is_there_once(
        places in prop::collection::vec(prop::array::uniform3(-1_i8..=1), 12),
        facets in prop::collection::vec(prop::array::uniform3(0_u32..12), 1..30),
    ) {
        let points: Vec<PointMm> = places.iter().map(|place| place.map(f64::from)).collect();
        let mut facets: Vec<[u32; 3]> = facets
            .into_iter()
            .filter(|[a, b, c]| a != b && b != c && c != a)
            .collect();
        facets.sort_unstable();
        facets.dedup();
        let found = section(&(points.clone(), facets.clone()), [0.0, 0.0, 1.0], 0.0);
        // By the numbers of vertices: a place on an edge is its pair, one at a vertex that vertex twice.
        let mut expected: Vec<[[u32; 2]; 2]> = Vec::new();
        for corners in facets {
            let mut nodes = Vec::new();
            for i in 0..3 {
                let (p, q) = (corners[i], corners[(i + 1) % 3]);
                let [from, to] = [p, q].map(|vertex| points[vertex as usize][2]);
                if from == 0.0 {
                    nodes.push([p, p]);
                } else if from * to < 0.0 {
                    nodes.push([p.min(q), p.max(q)]);
                }
            }
            if let [p, q] = nodes[..] {
                expected.push([p.min(q), p.max(q)]);
            }
        }
        expected.sort_unstable();
        expected.dedup();
        let node = |source: Source| match source {
            Source::Vertex { vertex } => [vertex; 2],
            Source::Edge { edge, .. } => edge,
            Source::Triangle { .. } => unreachable!("planes cut at edges"),
        };
        let pairs = found.pieces.iter().flat_map(|piece| piece.points.windows(2));
        let mut segments: Vec<[[u32; 2]; 2]> = pairs
            .map(|pair| {
                let [p, q] = [pair[0], pair[1]].map(|point| node(point.source));
                [p.min(q), p.max(q)]
            })
            .collect();
        segments.sort_unstable();
        prop_assert_eq!(segments, expected);
    }
}
