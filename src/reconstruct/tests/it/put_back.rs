//! Points put back into surfaces of the graph method: the same topology, and a form much nearer to the truth.

use std::f64::consts::PI;

use asphera_geometry::PointMm;
use asphera_reconstruct::{
    FaceRule, GraphChoices, LandmarkOrder, LeftOut, PointGraph, Proof, Reconstruction, prove,
};

use crate::graph::random_torus;
use crate::real;
use crate::shapes::{ball, moebius, places, shuffle, torus};

/// A coarse surface and the one with its points put back, with their proofs.
struct Pair {
    coarse: Proof,
    fine: Proof,
    surface: Reconstruction,
}

fn put_back(points: &[PointMm], choices: &GraphChoices) -> Reconstruction {
    let graph = PointGraph::new(points, 15, &mut |_| {}).unwrap();
    graph.put_back(&graph.surface(choices, &mut |_| {}).unwrap(), &mut |_| {})
}

/// Both surfaces. They have the same topology, and every point is a vertex or listed.
fn pair(points: &[PointMm], choices: &GraphChoices) -> Pair {
    let graph = PointGraph::new(points, 15, &mut |_| {}).unwrap();
    let before = graph.surface(choices, &mut |_| {}).unwrap();
    let surface = graph.put_back(&before, &mut |_| {});
    let [coarse, fine] =
        [&before.reconstruction, &surface].map(|found| prove(points, &found.facets).unwrap());
    let topology = |proof: &Proof| {
        (
            [proof.components, proof.border_loops.len()],
            [proof.nonmanifold_edges.count, proof.singular_vertices.count],
            (proof.is_closed, proof.is_orientable, proof.euler),
            (proof.genus, proof.betti),
        )
    };
    assert_eq!(topology(&fine), topology(&coarse), "{choices:?}");
    assert_eq!(fine.vertices + surface.left_out.len(), points.len());
    assert!(fine.vertices > coarse.vertices);
    Pair { coarse, fine, surface }
}

fn choices() -> [GraphChoices; 3] {
    let usual = GraphChoices::default();
    [
        usual,
        GraphChoices { hops: 4, ..usual },
        GraphChoices { order: LandmarkOrder::Priority, ..usual },
    ]
}

/// Every point is a vertex, nothing crosses, and area and volume come so many times nearer to the truth.
fn assert_near(points: &[PointMm], [area_mm2, volume_mm3]: [f64; 2], times: f64) {
    for choices in choices() {
        let Pair { coarse, fine, surface } = pair(points, &choices);
        assert_eq!(surface.left_out, []);
        assert_eq!((fine.self_intersections.count, fine.degenerate_facets.count), (0, 0));
        let errors = |proof: &Proof| {
            [proof.area_mm2 / area_mm2, proof.volume_mm3.unwrap() / volume_mm3]
                .map(|share| (share - 1.0).abs())
        };
        let (before, after) = (errors(&coarse), errors(&fine));
        for (before, after) in before.into_iter().zip(after) {
            assert!(before > times * after, "{before} {after} {choices:?}");
        }
        assert!(after[0] < 5e-4 && after[1] < 2e-3, "{after:?}");
    }
}

#[test]
fn area_and_volume_of_balls_and_tori_come_much_nearer_to_the_truth() {
    let of_ball = [100.0 * PI, 500.0 / 3.0 * PI];
    let of_torus = [12.0 * PI * PI, 6.0 * PI * PI];
    assert_near(&ball(20_000, 0.0, 1), of_ball, 30.0);
    assert_near(&ball(20_000, 1e-3, 2), of_ball, 30.0);
    assert_near(&torus(300, 100).0, of_torus, 30.0);
    assert_near(&random_torus(20_000, 3), of_torus, 20.0);
}

#[test]
fn two_balls_stay_two() {
    let mut points = ball(8_000, 1e-3, 5);
    points.extend(ball(8_000, 1e-3, 6).into_iter().map(|[x, y, z]| [x + 20.0, y, z]));
    for choices in choices() {
        let Pair { fine, surface, .. } = pair(&points, &choices);
        assert_eq!((fine.components, fine.genus, fine.facets), (2, Some(0), 31_992));
        assert_eq!((surface.left_out.len(), fine.self_intersections.count), (0, 0));
    }
}

/// Noise of half the spacing: the topology stays, and what would fold the surface is listed.
#[test]
fn noise_changes_no_topology() {
    for (noise_mm, most) in [(0.02, 0), (0.06, 10)] {
        for choices in choices() {
            let Pair { fine, surface, .. } = pair(&ball(20_000, noise_mm, 2), &choices);
            assert_eq!((fine.is_closed, fine.genus), (true, Some(0)));
            assert_eq!(fine.self_intersections.count, 0);
            assert!(surface.left_out.len() <= most, "{:?}", surface.left_out);
            assert!(surface.left_out.iter().all(|left| left.1 == LeftOut::Folding));
        }
    }
}

/// The border goes outwards as a front. A few points in narrow notches of it stay out.
#[test]
fn an_open_bowl_has_one_border_and_no_crossings() {
    let whole = ball(20_000, 0.0, 3);
    let points: Vec<PointMm> = whole.into_iter().filter(|place| place[2] < 1.0).collect();
    for choices in choices() {
        let Pair { coarse, fine, surface } = pair(&points, &choices);
        assert_eq!((fine.border_loops.len(), fine.genus), (1, Some(0)));
        assert_eq!((fine.self_intersections.count, fine.is_manifold), (0, true));
        assert!(surface.left_out.len() < points.len() / 250, "{}", surface.left_out.len());
        assert!(surface.left_out.iter().all(|left| left.1 == LeftOut::Folding));
        let truth_mm2 = 60.0 * PI;
        assert!(fine.area_mm2 < truth_mm2 && truth_mm2 - fine.area_mm2 < 0.05 * truth_mm2);
        assert!(truth_mm2 - coarse.area_mm2 > 1.5 * (truth_mm2 - fine.area_mm2));
    }
}

#[test]
fn surfaces_with_one_side_or_with_defects_are_what_they_were() {
    let (points, _) = moebius(400, 40);
    let Pair { fine, .. } = pair(&points, &GraphChoices::default());
    assert_eq!((fine.is_orientable, fine.border_loops.len()), (false, 1));
    assert_eq!(fine.self_intersections.count, 0);
    for name in ["kitten.xyz", "knot1.off", "anchor_dense.off", "elk.off"] {
        let Some(points) = real::points(name) else { continue };
        for faces in [FaceRule::Any, FaceRule::Filled] {
            pair(&points, &GraphChoices { faces, hops: 4, ..GraphChoices::default() });
        }
    }
}

#[test]
fn the_bunny_keeps_its_topology_and_crosses_nothing() {
    let Some(points) = real::points("bunny.ply") else { return };
    for (faces, borders) in [(FaceRule::Any, 0), (FaceRule::Filled, 3)] {
        for hops in [4, 5] {
            let choices = GraphChoices { hops, faces, ..GraphChoices::default() };
            let Pair { fine, surface, .. } = pair(&points, &choices);
            assert_eq!((fine.genus, fine.border_loops.len()), (Some(0), borders));
            assert_eq!(fine.self_intersections.count, 0, "{choices:?}");
            let folding = surface.left_out.iter().filter(|left| left.1 == LeftOut::Folding);
            assert!(folding.count() < points.len() / 500, "{choices:?}");
        }
    }
}

#[test]
fn the_order_of_points_and_the_threads_change_nothing() {
    let whole = ball(6_000, 0.02, 4);
    let bowl: Vec<PointMm> = whole.into_iter().filter(|place| place[2] < 1.0).collect();
    for mut points in [torus(120, 40).0, bowl] {
        for order in [LandmarkOrder::Sweep, LandmarkOrder::Priority] {
            let choices = GraphChoices { hops: 3, order, ..GraphChoices::default() };
            let first = put_back(&points, &choices);
            let pool = rayon::ThreadPoolBuilder::new().num_threads(3).build().unwrap();
            assert_eq!(pool.install(|| put_back(&points, &choices)), first);
            let before = places(&points, &first.facets);
            shuffle(&mut points, 7);
            assert_eq!(places(&points, &put_back(&points, &choices).facets), before);
        }
    }
}

#[test]
fn quarter_turns_about_z_and_powers_of_two_change_nothing() {
    let points = random_torus(6_000, 8);
    let open: Vec<PointMm> = points.iter().copied().filter(|place| place[0] < 2.0).collect();
    for points in [points, open] {
        let turned: Vec<PointMm> = points.iter().map(|&[x, y, z]| [-y, x, z]).collect();
        let larger: Vec<PointMm> =
            points.iter().map(|point| point.map(|value| value * 64.0)).collect();
        let sweep = GraphChoices { hops: 3, ..GraphChoices::default() };
        assert_eq!(put_back(&points, &sweep), put_back(&turned, &sweep));
        let priority = GraphChoices { order: LandmarkOrder::Priority, ..sweep };
        for choices in [sweep, priority] {
            assert_eq!(put_back(&points, &choices), put_back(&larger, &choices));
        }
    }
}

#[test]
fn what_cannot_be_put_back_says_why() {
    let mut points = ball(4_000, 1e-3, 10);
    let choices = GraphChoices { hops: 3, ..GraphChoices::default() };
    let first = put_back(&points, &choices);
    assert_eq!(first.left_out, []);
    points.push(points[5]);
    points.push([0.0, f64::NAN, 0.0]);
    let second = put_back(&points, &choices);
    assert_eq!(first.facets, second.facets);
    assert_eq!(second.left_out, [(4_000, LeftOut::Duplicate), (4_001, LeftOut::NoPlace)]);
    // Without a surface all stays as it was.
    let line: Vec<PointMm> = (0..2_000).map(|at| [f64::from(at), 0.0, 0.0]).collect();
    let none = put_back(&line, &choices);
    assert_eq!((none.facets.len(), none.left_out.len()), (0, 2_000));
}
