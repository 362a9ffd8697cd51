//! Work that orders of arrival cost, counted, against that of the same points shuffled.

use std::f64::consts::{PI, TAU};

use asphera_geometry::PointMm;
use asphera_geometry::predicates::Place;
use rand_core::{Rng, SeedableRng};
use rand_pcg::Pcg64;

use crate::{Mesh, check};

/// Points of each order, and of a batch.
const COUNT: usize = 20_000;
const BATCH: usize = 1000;

/// Triangles torn down, sides flipped and steps of long walks a point, by batches of one thread.
fn effort(places: &[Place], batch: usize) -> f64 {
    let points: Vec<PointMm> = places.iter().map(|&[x, y]| [x, y, 0.0]).collect();
    let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build().expect("a thread starts");
    let mesh = pool.install(|| {
        let mut mesh = Mesh::new();
        points.chunks(batch).for_each(|batch| mesh.insert(batch));
        mesh
    });
    assert_eq!(check::delaunay(mesh.points(), mesh.triangles()), Ok(()));
    mesh.effort() as f64 / points.len() as f64
}

fn shuffled(places: &[Place]) -> Vec<Place> {
    let mut rng = Pcg64::seed_from_u64(42);
    let mut shuffled = places.to_vec();
    for last in (1..shuffled.len()).rev() {
        shuffled.swap(last, (rng.next_u64() % (last as u64 + 1)) as usize);
    }
    shuffled
}

fn polar(radius: f64, angle: f64) -> Place {
    [radius * angle.cos(), radius * angle.sin()]
}

fn along(at: impl Fn(f64) -> Place) -> Vec<Place> {
    (0..COUNT).map(|index| at(index as f64 / COUNT as f64)).collect()
}

fn spiral_inwards(turns: f64) -> Vec<Place> {
    along(|share| polar((1.0 - share).sqrt(), TAU * turns * (1.0 - share).sqrt()))
}

fn star(spikes: f64, inner: f64) -> Vec<Place> {
    let corner = |at: f64| polar(if at % 2.0 == 0.0 { 1.0 } else { inner }, PI * at / spikes);
    along(|share| {
        let side = 2.0 * spikes * share;
        let [from, to] = [side.floor(), side.floor() + 1.0].map(corner);
        [0, 1].map(|axis| from[axis] + side.fract() * (to[axis] - from[axis]))
    })
}

fn parabola() -> Vec<Place> {
    along(|share| [2.0 * share - 1.0, 33.0 * (2.0 * share - 1.0).powi(2)])
}

/// Two arcs that bulge towards each other, the points of each in turn or one arc after the other.
fn facing_arcs(by_turns: bool, bend: f64, apart: f64) -> Vec<Place> {
    let half = COUNT / 2;
    let at = |index: usize| {
        let (is_first, step) = if by_turns {
            (index.is_multiple_of(2), index / 2)
        } else {
            (index < half, index % half)
        };
        let x = 2.0 * step as f64 / half as f64 - 1.0;
        let y = apart + bend * x * x;
        if is_first { [x, y] } else { [0.7 * x, -y] }
    };
    (0..COUNT).map(at).collect()
}

fn circles_by_turns(many: usize, apart: f64) -> Vec<Place> {
    let at = |index: usize| {
        let [x, y] = polar(1.0, TAU * index as f64 / COUNT as f64);
        let [dx, dy] = polar(apart, TAU * (index % many) as f64 / many as f64);
        [x + dx, y + dy]
    };
    (0..COUNT).map(at).collect()
}

fn rings_inwards(points: usize) -> Vec<Place> {
    let at = |index: usize| {
        polar((1 + index / points) as f64, TAU * (index % points) as f64 / points as f64)
    };
    (0..COUNT).rev().map(at).collect()
}

/// Petals traced one after the other, through the middle each time.
fn rosette(petals: f64, turns: f64) -> Vec<Place> {
    along(|share| polar((petals * TAU * turns * share).sin(), TAU * turns * share))
}

/// Rows of 1899 points from the middle of a raster outwards, a point of either side by turns.
fn raster_to_both_ends() -> Vec<Place> {
    let at = |index: usize| {
        let place = if index.is_multiple_of(2) { index / 2 } else { COUNT - 1 - index / 2 };
        [(place % 1899) as f64 + 0.01 * (7.0 * place as f64).sin(), (place / 1899) as f64]
    };
    (0..COUNT).rev().map(at).collect()
}

/// Random points of a square by their distance from its middle: before the hull, at any angle.
fn random_from_inside() -> Vec<Place> {
    let mut rng = Pcg64::seed_from_u64(7);
    let mut unit = || (rng.next_u64() >> 11) as f64 / (1_u64 << 53) as f64 - 0.5;
    let mut places: Vec<Place> = (0..COUNT).map(|_| [unit(), unit()]).collect();
    places.sort_by(|p, q| p[0].hypot(p[1]).total_cmp(&q[0].hypot(q[1])));
    places
}

fn closed_curve() -> Vec<Place> {
    along(|share| {
        let t = TAU * share;
        polar(1.0 + 0.08 * (7.0 * t).cos() + 0.03 * (13.0 * t).sin(), t)
    })
}

/// Orders that took up to 2.9 times as long as shuffled ones before ends went in first, and more work before walks
/// about wide stars began where they face the place.
///
/// The bound is on times the work of the shuffled points. A triangle of many torn down at once costs less time than one of a
/// few, so spirals of many turns, rings and rosettes may have more. Along lines nothing is searched for ahead, either.
#[test]
fn no_order_of_arrival_costs_much_more_work_than_shuffled_points() {
    let orders = [
        ("spiral inwards, 2.3 turns", spiral_inwards(2.3), 2.6),
        ("spiral inwards, 9 turns", spiral_inwards(9.0), 3.3),
        ("spiral inwards, 57 turns", spiral_inwards(57.0), 1.9),
        ("star of 3 spikes", star(3.0, 0.5), 1.6),
        ("star of 6 spikes", star(6.0, 0.68), 1.0),
        ("parabola", parabola(), 0.57),
        ("arcs by turns", facing_arcs(true, 0.0004, 0.77), 0.69),
        ("arcs one after the other", facing_arcs(false, 0.0017, 6.2), 0.22),
        ("two circles by turns", circles_by_turns(2, 1698.0), 0.9),
        ("eight circles by turns", circles_by_turns(8, 132.0), 1.2),
        ("rings of 102 points inwards", rings_inwards(102), 1.5),
        ("rings of 1071 points inwards", rings_inwards(1071), 2.25),
        ("rosette of 8.454 petals", rosette(8.454, 4.9), 2.05),
        ("raster to both ends", raster_to_both_ends(), 1.0),
        ("random from inside", random_from_inside(), 1.15),
        ("closed curve", closed_curve(), 0.58),
    ];
    for (name, places, most) in orders {
        let [ours, of_shuffled] = [&places, &shuffled(&places)].map(|order| effort(order, BATCH));
        assert!(ours <= most * of_shuffled, "{name}: {ours:.1} against {of_shuffled:.1}");
    }
}

/// A line after the other of a cross takes strips that the lines before earned. One of 256 points took half a million flips,
/// as each saw all of the line beside it: 7.5 times the work of shuffled points.
#[test]
fn lines_of_a_cross_by_turns_cost_no_more_work_than_shuffled_points() {
    let at = |index: usize| {
        let (arm, step) = (index % 8, index / 8);
        let along = 16.0 * step as f64 / COUNT as f64 - 1.0;
        let outwards = if along < 0.0 { -1.0 - along } else { along };
        polar(outwards, PI * arm as f64 / 8.0 + 0.1)
    };
    let places: Vec<Place> = (0..COUNT).map(at).collect();
    let [ours, of_shuffled] = [&places, &shuffled(&places)].map(|order| effort(order, COUNT));
    assert!(ours <= 3.2 * of_shuffled, "{ours:.2} against {of_shuffled:.2}");
}

/// Strips before a long hull: one of 2,048 points took 6.0 million flips before 9,098 sides, one of 1,000 points 9.5 million
/// before 11,000, and one of 64 points 1.6 million before 25,637. Nor is a long strip before few sides: 1,024 points
/// took 1.3 million flips before 294.
#[test]
fn strips_before_a_hull_of_other_length_are_not_tried() {
    const MANY: usize = 100_000;
    let lines = (0..MANY).map(|index| {
        let [x, y] = [(index / 5) as f64 / (MANY / 5) as f64, 0.1883 * (index % 5) as f64];
        let (sine, cosine) = 5.17_f64.sin_cos();
        [cosine * x - sine * y, sine * x + cosine * y]
    });
    let star = |spikes: usize, inner: f64| {
        let corner = |at: usize| {
            polar(if at.is_multiple_of(2) { 1.0 } else { inner }, PI * at as f64 / spikes as f64)
        };
        let on_a_side = MANY / (2 * spikes);
        let place = |index: usize| {
            let share = (index % on_a_side) as f64 / on_a_side as f64;
            let [from, to] = [0, 1].map(|end| corner(index / on_a_side + end));
            [0, 1].map(|axis| from[axis] + share * (to[axis] - from[axis]))
        };
        (0..MANY).map(place).collect::<Vec<Place>>()
    };
    let cross = (0..MANY).map(|index| {
        let along = 4.0 * (index / 2) as f64 / MANY as f64 - 1.0;
        let outwards = if along < 0.0 { -1.0 - along } else { along };
        polar(outwards, PI * (index % 2) as f64 / 2.0 + 0.1)
    });
    for (name, places, batch, most) in [
        ("five lines by turns", lines.collect::<Vec<Place>>(), MANY, 1.45),
        ("star of 5 spikes", star(5, 0.091), BATCH, 0.6),
        ("star of 16 spikes", star(16, 0.358), MANY, 1.1),
        ("two lines of a cross by turns", cross.collect(), MANY, 1.65),
    ] {
        let [ours, of_shuffled] = [&places, &shuffled(&places)].map(|order| effort(order, batch));
        assert!(ours <= most * of_shuffled, "{name}: {ours:.2} against {of_shuffled:.2}");
    }
}
