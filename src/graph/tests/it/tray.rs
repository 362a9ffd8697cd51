//! Simulated trays: parts at random places, turned and tilted, with noise; what lies where is the truth.

use crate::bodies::{Place, Random};
use asphera_graph::library::{Facing, LibraryEntry};

/// A kind of part on the tray.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Kind {
    Convex,
    Biconvex,
    Concave,
    Flat,
    Ring,
}

pub(crate) const KINDS: [Kind; 5] =
    [Kind::Convex, Kind::Biconvex, Kind::Concave, Kind::Flat, Kind::Ring];

/// A part of the tray: the truth.
#[derive(Clone, Debug)]
pub(crate) struct Truth {
    pub(crate) kind: Kind,
    pub(crate) facing: Facing,
    pub(crate) centre_mm: Place,
    pub(crate) holes: usize,
}

pub(crate) struct Tray {
    pub(crate) points: Vec<Place>,
    pub(crate) truth: Vec<Truth>,
}

impl Kind {
    /// Inner and outer radius in mm.
    pub(crate) fn radii_mm(self) -> [f64; 2] {
        match self {
            Kind::Convex => [0.0, 10.0],
            Kind::Biconvex => [0.0, 12.5],
            Kind::Concave => [0.0, 9.0],
            Kind::Flat => [0.0, 11.0],
            Kind::Ring => [5.0, 10.5],
        }
    }

    /// Height of the upper face in mm, of a part that lies face up or down, over its middle plane.
    fn height_mm(self, r_mm: f64, is_down: bool) -> f64 {
        let sphere = |radius: f64| r_mm * r_mm / (radius + (radius * radius - r_mm * r_mm).sqrt());
        match (self, is_down) {
            // An asphere, κ = −1.1 with a coefficient of the fourth order.
            (Kind::Convex, _) => {
                let square = r_mm * r_mm;
                let root = (1.0 + 0.1 * square / (22.0 * 22.0)).sqrt();
                3.0 - square / 22.0 / (1.0 + root) - 1e-5 * square * square
            }
            (Kind::Biconvex, false) => 3.5 - sphere(40.0),
            (Kind::Biconvex, true) => 3.5 - sphere(90.0),
            (Kind::Concave, _) => 2.0 + sphere(60.0),
            (Kind::Flat, _) => 3.0,
            (Kind::Ring, _) => 1.5,
        }
    }

    /// The entry of the library: a lens with two faces and the ring are bodies, the others are known from above alone.
    pub(crate) fn entry(self) -> LibraryEntry {
        let name = format!("{self:?}");
        let [inner, outer] = self.radii_mm();
        let (mut points, mut normals) = (Vec::new(), Vec::new());
        let step = outer / 35.0;
        for row in -36..=36 {
            for column in -36..=36 {
                let [x, y] = [f64::from(row) * step, f64::from(column) * step];
                let r = x.hypot(y);
                if !(inner..=outer).contains(&r) {
                    continue;
                }
                for is_down in [false, true] {
                    let slope = (self.height_mm(r + 1e-5, is_down)
                        - self.height_mm((r - 1e-5).abs(), is_down))
                        / 2e-5;
                    let length = slope.hypot(1.0);
                    let sign = if is_down { -1.0 } else { 1.0 };
                    let aside = if r > 0.0 { -slope / length / r } else { 0.0 };
                    points.push([x, y, sign * self.height_mm(r, is_down)]);
                    normals.push([aside * x, aside * y, sign / length]);
                }
            }
        }
        if matches!(self, Kind::Biconvex | Kind::Ring) {
            return LibraryEntry::body(&name, &points, &normals).unwrap();
        }
        let face: Vec<Place> = points.into_iter().step_by(2).collect();
        LibraryEntry::face(&name, &face).unwrap()
    }
}

/// A tray of eight parts: each kind once, one of the kinds twice and touching, and one more; with dust.
///
/// Points lie `spacing_mm` apart on average, with noise of 5 µm along z. The parts stand up to 2° aslant.
pub(crate) fn tray(seed: u64, spacing_mm: f64) -> Tray {
    let mut random = Random::new(seed);
    let mut kinds = KINDS.to_vec();
    kinds.push(KINDS[random.below(5)]);
    random.shuffle(&mut kinds);
    let pair = KINDS[random.below(5)];
    let mut tray = Tray { points: Vec::new(), truth: Vec::new() };
    // Cells of 40 mm; the pair lies in the last two.
    for (cell, kind) in kinds.into_iter().enumerate() {
        let x = 40.0 * (cell % 4) as f64 + random.between(-6.0, 6.0);
        let y = 40.0 * (cell / 4) as f64 + random.between(-6.0, 6.0);
        let is_down = kind == Kind::Biconvex && random.unit() < 0.5;
        let spot = Spot { middle_mm: [x, y], is_down, most_tilt_rad: 0.035 };
        lay(&mut tray, kind, spot, spacing_mm, &mut random);
    }
    let [_, radius] = pair.radii_mm();
    let turn = std::f64::consts::TAU * random.unit();
    for sign in [-1.0, 1.0] {
        let from = sign * (radius + 0.01);
        let place = [100.0 + from * turn.cos(), 40.0 + 15.0 + from * turn.sin()];
        let spot = Spot { middle_mm: place, is_down: false, most_tilt_rad: 0.0 };
        lay(&mut tray, pair, spot, spacing_mm, &mut random);
    }
    for _ in 0..6 {
        let [x, y] = [random.between(-18.0, 138.0), 20.0 + random.between(-1.0, 1.0)];
        for _ in 0..4 {
            let aside = [random.between(-0.1, 0.1), random.between(-0.1, 0.1)];
            tray.points.push([x + aside[0], y + aside[1], random.between(0.0, 0.1)]);
        }
    }
    random.shuffle(&mut tray.points);
    tray
}

/// How a part lies on a tray.
#[derive(Clone, Copy)]
pub(crate) struct Spot {
    pub(crate) middle_mm: [f64; 2],
    pub(crate) is_down: bool,
    /// The largest tilt about x and about y.
    pub(crate) most_tilt_rad: f64,
}

/// Lays a part of a kind on a spot.
pub(crate) fn lay(tray: &mut Tray, kind: Kind, spot: Spot, spacing_mm: f64, random: &mut Random) {
    let Spot { middle_mm: [x, y], is_down, most_tilt_rad: most } = spot;
    let [inner, outer] = kind.radii_mm();
    // The mean distance to the nearest of random points is half the root of the area of a point.
    let area = std::f64::consts::PI * (outer * outer - inner * inner);
    let count = (area / (4.0 * spacing_mm * spacing_mm)) as usize;
    let tilt = [random.between(-most, most), random.between(-most, most)];
    let mut placed = 0;
    while placed < count {
        let [a, b] = [random.between(-outer, outer), random.between(-outer, outer)];
        let r = a.hypot(b);
        if !(inner..=outer).contains(&r) {
            continue;
        }
        placed += 1;
        let z = kind.height_mm(r, is_down) + 0.005 * random.normal();
        let [a, z] = [a * tilt[0].cos() + z * tilt[0].sin(), z * tilt[0].cos() - a * tilt[0].sin()];
        let [b, z] = [b * tilt[1].cos() + z * tilt[1].sin(), z * tilt[1].cos() - b * tilt[1].sin()];
        tray.points.push([x + a, y + b, z + 3.0]);
    }
    let facing = if is_down { Facing::Down } else { Facing::Up };
    let holes = usize::from(inner > 0.0);
    tray.truth.push(Truth { kind, facing, centre_mm: [x, y, 3.0], holes });
}
