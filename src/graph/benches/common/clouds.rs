//! Clouds whose geodesic distances are known.

use std::f64::consts::TAU;

use crate::bodies::{Place, Random, norm};

/// Points with the distances from the first one along their surface.
pub(crate) struct Known {
    pub(crate) name: &'static str,
    pub(crate) points: Vec<Place>,
    pub(crate) truth: Vec<f64>,
}

/// A closed mesh.
pub(crate) struct Mesh {
    pub(crate) points: Vec<Place>,
    pub(crate) triangles: Vec<[u32; 3]>,
}

/// Radius of the tube of the torus; that of its ring is 1.
const TUBE: f64 = 0.4;

/// A torus of any number of points. They lie along one line that winds round the tube, shaken by a third of their distance at
/// most; each is joined with the next one and with those of the next turn.
pub(crate) fn torus(count: usize, random: &mut Random) -> Mesh {
    let turns = (count as f64 / TUBE).sqrt() as usize;
    let next = count / turns;
    let point = |at: usize| {
        let mut shaken = || random.between(-0.3, 0.3);
        let u = TAU * (at as f64 / count as f64 + shaken() / turns as f64);
        let along = (at * turns % count) as f64 / count as f64;
        let v = TAU * (along + shaken() * turns as f64 / count as f64);
        let out = 1.0 + TUBE * v.cos();
        [out * u.cos(), out * u.sin(), TUBE * v.sin()]
    };
    let points = (0..count).map(point).collect();
    let corner = |at: usize| (at % count) as u32;
    let triangles = (0..count).flat_map(|at| {
        let [own, after, beyond] = [at, at + 1, at + next].map(corner);
        let opposite = corner(at + next + 1);
        [[own, after, opposite], [own, opposite, beyond]]
    });
    Mesh { points, triangles: triangles.collect() }
}

pub(crate) fn plane(count: usize, random: &mut Random) -> Known {
    let points: Vec<Place> = (0..count).map(|_| [random.unit(), random.unit(), 0.0]).collect();
    known("plane", points, chord)
}

pub(crate) fn sphere(count: usize, random: &mut Random) -> Known {
    let points = (0..count).map(|_| random.direction()).collect();
    known("sphere", points, |p, q| 2.0 * (chord(p, q) / 2.0).min(1.0).asin())
}

/// A cone of a half angle of 30°: unrolled it is half a disc.
pub(crate) fn cone(count: usize, random: &mut Random) -> Known {
    let point = |_| {
        let (radius, angle) = (random.unit().sqrt(), TAU * random.unit());
        [0.5 * radius * angle.cos(), 0.5 * radius * angle.sin(), 0.75_f64.sqrt() * radius]
    };
    known("cone", (0..count).map(point).collect(), |p, q| {
        let mut turn = (p[1].atan2(p[0]) - q[1].atan2(q[0])).abs();
        turn = turn.min(TAU - turn) / 2.0;
        let (a, b) = (norm(p), norm(q));
        (a * a + b * b - 2.0 * a * b * turn.cos()).max(0.0).sqrt()
    })
}

fn known(name: &'static str, points: Vec<Place>, truth: impl Fn(Place, Place) -> f64) -> Known {
    let truth = points.iter().map(|point| truth(points[0], *point)).collect();
    Known { name, points, truth }
}

fn chord(p: Place, q: Place) -> f64 {
    norm(std::array::from_fn(|axis| p[axis] - q[axis]))
}
