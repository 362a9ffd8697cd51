//! Loops of closed surfaces: as many as their genus.

use asphera_graph::{Choices, Cloud, Growth, Pieces, extract, functions};

use crate::bodies::{Body, Random};

#[test]
fn loops_are_the_genus_and_hold_where_tau_and_strips_change() {
    let mut random = Random::new(1);
    let bodies =
        [Body::sphere(), Body::torus(), Body::row(2), Body::row(5), Body::row(9), Body::plate(0.5)];
    for body in bodies {
        let points = body.sample(60_000, &mut random);
        let cloud = Cloud::new(&points).unwrap();
        for direction in [[1.0, 0.3, 0.2], [1.0, 0.25, -0.3]] {
            let field = functions::height(&cloud, direction).unwrap();
            let choices = Choices::default();
            let found = extract(&cloud, &field, &choices).unwrap();
            assert_eq!(found.loops.len(), body.genus, "{} {direction:?}", body.name);
            assert_eq!(found.graph.components().1, 1);
            let stability = found.stability(&cloud, &field, &choices).unwrap();
            assert_eq!(stability.trials.len(), 4);
            assert_eq!((stability.most.loops, stability.most.along), (body.genus, None));
            if body.genus < 9 {
                assert!(stability.is_stable, "{} {stability:?}", body.name);
            }
        }
    }
}

#[test]
fn noise_of_a_tenth_of_the_hole_leaves_the_loops() {
    let mut random = Random::new(2);
    let points = Body::row(2).sample(60_000, &mut random);
    for share in [0.02, 0.05, 0.10] {
        // The smallest hole has the radius 0.6.
        let noisy: Vec<[f64; 3]> = points
            .iter()
            .map(|point| point.map(|value| value + 0.6 * share * random.normal()))
            .collect();
        let cloud = Cloud::new(&noisy).unwrap();
        // Aslant to the rings, where loops are as short as the layer is thick, too.
        for direction in [[1.0, 0.2, 0.1], [0.2, 0.6, 1.0], [0.2, 0.3, 1.0]] {
            let field = functions::height(&cloud, direction).unwrap();
            let found = extract(&cloud, &field, &Choices::default()).unwrap();
            assert_eq!(found.loops.len(), 2, "{share} {direction:?}");
            // The noise is 0.75 spacings and more.
            assert!(found.thinned_mm().is_some(), "{share}");
        }
    }
}

#[test]
fn density_that_varies_tenfold_leaves_the_loops() {
    let mut random = Random::new(3);
    let points = Body::row(2).sample(150_000, &mut random);
    let kept: Vec<[f64; 3]> =
        points.into_iter().filter(|[x, ..]| random.unit() < 0.1 + 0.9 * (x + 2.4) / 4.8).collect();
    let cloud = Cloud::new(&kept).unwrap();
    let field = functions::height(&cloud, [1.0, 0.2, 0.1]).unwrap();
    assert_eq!(extract(&cloud, &field, &Choices::default()).unwrap().loops.len(), 2);
}

#[test]
fn growth_among_few_neighbours_breaks_pieces_and_among_many_does_not() {
    let mut random = Random::new(4);
    let points = Body::row(2).sample(11_000, &mut random);
    let cloud = Cloud::new(&points).unwrap();
    let field = functions::height(&cloud, [1.0, 0.1, 0.1]).unwrap();
    let all = |k| {
        let pieces = Pieces::Grown(Growth { k, ..Growth::default() });
        let strips = asphera_graph::StripChoice::Uniform(30);
        let choices = Choices { pieces, strips, ..Choices::default() };
        let found = extract(&cloud, &field, &choices).unwrap();
        found.loops.len() + found.minor_loops.len()
    };
    assert!(all(5) > all(10) && all(10) >= all(30), "{} {} {}", all(5), all(10), all(30));
    assert_eq!(all(30), 2);
}

/// Functions that are no lengths are steep in places: strips are as wide there as τ needs.
#[test]
fn a_torus_has_one_loop_by_functions_of_any_slope() {
    let mut random = Random::new(12);
    let torus = Cloud::new(&Body::torus().sample(30_000, &mut random)).unwrap();
    let nearest = torus.nearest(12).unwrap();
    let eigen = functions::eigenfunctions(&torus, &nearest, 1).unwrap().fields.pop().unwrap();
    let fields = [
        ("first eigenfunction", eigen),
        ("harmonic", functions::harmonic_between_ends(&torus, &nearest).unwrap()),
        ("heat", functions::heat_kernel(&torus, &nearest, 0.1).unwrap()),
        ("square", functions::squared_norm(&torus)),
        ("saddle", functions::saddle(&torus)),
        ("log", functions::logarithm(&torus)),
    ];
    for (name, field) in fields {
        let found = extract(&torus, &field, &Choices::default()).unwrap();
        assert_eq!(found.loops.len(), 1, "{name}: {} strips", found.graph.strips().count());
    }
}

/// A bore seen so aslant that its loop is nearly closed: with thickness t, radius r and the angle θ to its axis the loop is open
/// over t·cos θ − 2r·sin θ.
#[test]
fn a_tilted_bore_counts_where_its_loop_is_open_over_two_tau() {
    let mut random = Random::new(5);
    let cloud = Cloud::new(&Body::plate(1.0).sample(100_000, &mut random)).unwrap();
    for (tilt, is_open) in [(0.0_f64, true), (0.37, true), (0.559, false), (0.8, true)] {
        let direction = [tilt.sin() * 0.8, tilt.sin() * 0.6, tilt.cos()];
        let field = functions::height(&cloud, direction).unwrap();
        let choices = Choices::default();
        let found = extract(&cloud, &field, &choices).unwrap();
        let open = (tilt.cos() - 1.6 * tilt.sin()).abs();
        assert_eq!(open > 2.0 * found.tau_mm, is_open, "{open} {}", found.tau_mm);
        assert_eq!(found.loops.len(), if is_open { 9 } else { 0 }, "{tilt} {open}");
        // Along other heights they are open over more.
        let most = found.stability(&cloud, &field, &choices).unwrap().most;
        assert_eq!((most.loops, most.is_stable), (9, true), "{tilt}");
        assert_eq!(most.along.is_none(), is_open, "{most:?}");
        for one in &found.loops {
            // Branches that are nearer than links reach count as one.
            let off = (open - one.extent()) / found.tau_mm;
            assert!(off > -0.5 && off < 2.0, "{tilt} {open} {}", one.extent());
        }
    }
}

/// A torus seen so that its two saddles lie nearly as high: with ring radius 1, tube radius 0.4 and the angle θ to its axis the loop is
/// open over 2·|sin θ − 0.4|. That is less than many gaps are, but the ends of the loop lie apart.
#[test]
fn a_loop_that_is_hardly_open_counts_where_its_ends_are_saddles() {
    let mut random = Random::new(6);
    let cloud = Cloud::new(&Body::torus().sample(60_000, &mut random)).unwrap();
    let tau_mm = asphera_graph::auto_tau_mm(&cloud).unwrap();
    for (open, loops) in [(-2.0_f64, 1), (-1.0, 1), (0.0, 0), (1.0, 1), (2.0, 1)] {
        let sin = 0.4 + 0.5 * open * tau_mm;
        let direction = [0.8 * sin, 0.6 * sin, (1.0 - sin * sin).sqrt()];
        let field = functions::height(&cloud, direction).unwrap();
        let found = extract(&cloud, &field, &Choices::default()).unwrap();
        assert_eq!(found.loops.len(), loops, "{open} {:?}", found.minor_loops);
        if open.abs() < 2.0 {
            assert!(found.loops.iter().all(|one| one.extent() < 1.2 * tau_mm), "{open}");
        }
    }
}

/// Points at random on a cylinder of radius 1 and height 2 without those in some discs: height and radius of each in τ.
fn pierced(discs: &[(f64, f64)], tau_mm: f64) -> Cloud<3> {
    let mut random = Random::new(7);
    let mut points = Vec::new();
    while points.len() < 20_000 {
        let (angle, z) = (std::f64::consts::TAU * random.unit(), 2.0 * random.unit() - 1.0);
        let is_cut = (0..).zip(discs).any(|(at, &(height, radius))| {
            let turn = std::f64::consts::TAU * f64::from(at) / discs.len() as f64;
            let across = 2.0 * ((angle - turn) / 2.0).sin();
            across.hypot(z - height * tau_mm) < radius * tau_mm
        });
        if !is_cut {
            points.push([angle.cos(), angle.sin(), z]);
        }
    }
    Cloud::new(&points).unwrap()
}

#[test]
fn gaps_are_minor_whether_one_or_two_on_a_level_and_holes_count() {
    let whole = pierced(&[], 0.0);
    let tau_mm = asphera_graph::auto_tau_mm(&whole).unwrap();
    let count = |discs: &[(f64, f64)]| {
        let cloud = pierced(discs, tau_mm);
        let field = functions::height(&cloud, [0.0, 0.0, 1.0]).unwrap();
        let choices = Choices::default();
        let found = extract(&cloud, &field, &choices).unwrap();
        if discs.iter().all(|(_, radius)| *radius < 1.0) {
            let most = found.stability(&cloud, &field, &choices).unwrap().most;
            // The axis of the tube lies in levels across it: its two rims make a loop there.
            assert!(most.loops <= 1, "{most:?}");
        }
        // Random points leave gaps of their own.
        (found.loops.len(), !found.minor_loops.is_empty())
    };
    // One alone opens the ring of a level, so that nothing parts: two on a level make one loop, which is open where both are.
    assert_eq!(count(&[(0.0, 0.6), (0.3, 0.6)]), (0, true));
    assert_eq!(count(&[(0.0, 0.7), (0.2, 0.7), (-0.1, 0.7)]), (0, true));
    assert_eq!(count(&[(0.0, 2.0), (0.2, 2.0)]).0, 1);
    assert_eq!(count(&[(0.0, 2.0), (0.2, 2.0), (-0.3, 2.0)]).0, 2);
}
