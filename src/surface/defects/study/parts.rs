//! Simulated parts of the study: a disc of 9 mm radius with the form and the noise of a kind.

use std::f64::consts::TAU;

use asphera_geometry::{PointMm, VertexId};
use asphera_mesh::Mesh;

use crate::curvature::Adjacency;
use crate::curvature::truth::Random;
use crate::defects::{DefectSearch, DefectSettings, DeviatingSurface, search_defects};
use crate::noise::{Noise, NoiseSettings, estimate_noise};

pub(super) const RADIUS_MM: f64 = 9.0;
/// Noise of a single reading where the kind has no other.
pub(super) const SIGMA_MM: f64 = 5e-6;

/// Form and noise of a clean part.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Kind {
    /// White noise on low orders.
    White,
    /// One to three rings of Gaussian section, as zonal polishing leaves them.
    Rings,
    /// Waves of 1.5 to 6 mm over the part or a part of it, straight or about the axis.
    Waves,
    /// An edge that is turned down over the last 0.3 to 1.5 mm.
    Edges,
    /// Noise of 5 nm in the middle and 20 nm at the rim.
    RimNoise,
    /// Noise of 5 nm with Laplace's distribution.
    Laplace,
    /// Scan lines, each with an offset of its own of 1 to 5 nm.
    Lines,
    /// Points in no order and with no pitch, on low orders of up to ten times the height.
    Scattered,
}

pub(super) const KINDS: [Kind; 8] = [
    Kind::White,
    Kind::Rings,
    Kind::Waves,
    Kind::Edges,
    Kind::RimNoise,
    Kind::Laplace,
    Kind::Lines,
    Kind::Scattered,
];

/// A meshed part and its deviations.
pub(super) struct Part {
    pub(super) points: Vec<PointMm>,
    pub(super) triangles: Vec<[VertexId; 3]>,
    pub(super) deviations_mm: Vec<f64>,
    pub(super) spacing_mm: f64,
}

impl Part {
    /// A clean part of about that many points, on the turns of a spiral or on lines.
    pub(super) fn clean(kind: Kind, count: usize, seed: u64) -> Part {
        let mut random = Random::new(977 * seed + kind as u64);
        let spacing_mm = RADIUS_MM * (std::f64::consts::PI / count as f64).sqrt();
        let spiral = kind != Kind::Lines && seed.is_multiple_of(2);
        let places = if kind == Kind::Scattered {
            scattered_places(count, &mut random)
        } else if spiral {
            spiral_places(count, &mut random)
        } else {
            line_places(spacing_mm, &mut random)
        };
        let form = form(kind, &mut random);
        let offset_mm = 1e-6 * (1.0 + 4.0 * random.unit());
        let (mut line, mut level_mm) = (usize::MAX, 0.0);
        let deviations_mm = places
            .iter()
            .map(|&(of, [x, y])| {
                if of != line {
                    line = of;
                    level_mm = if kind == Kind::Lines { offset_mm * random.normal() } else { 0.0 };
                }
                let share = x.hypot(y) / RADIUS_MM;
                let noise = match kind {
                    Kind::RimNoise => SIGMA_MM * (1.0 + 3.0 * share * share) * random.normal(),
                    Kind::Laplace => {
                        let unit = random.unit() - 0.5;
                        let size = -(1.0 - 2.0 * unit.abs()).ln() / 2.0_f64.sqrt();
                        SIGMA_MM * size.copysign(unit)
                    }
                    _ => SIGMA_MM * random.normal(),
                };
                form(x, y) + level_mm + noise
            })
            .collect();
        let places = places.into_iter().map(|(_, place)| place).collect();
        let spacing_mm = if kind == Kind::Scattered { 1.23 * spacing_mm } else { spacing_mm };
        Part::meshed(places, deviations_mm, spacing_mm)
    }

    /// The part of the demo: a ring of 40 nm at 5.58 mm whose height falls to 1/e over 0.54 mm. Its points lie 1.08 times as
    /// far apart on the steep surface as in the plane.
    pub(super) fn of_demo(count: usize, seed: u64) -> Part {
        let mut part = Part::clean(Kind::White, count, 2 * seed);
        part.add(|x, y| 4e-5 * (-((x.hypot(y) - 5.58) / 0.54).powi(2)).exp());
        part.spacing_mm *= 1.08;
        part
    }

    fn meshed(places: Vec<[f64; 2]>, deviations_mm: Vec<f64>, spacing_mm: f64) -> Part {
        let points = places.iter().zip(&deviations_mm);
        let points: Vec<PointMm> =
            points.map(|(&[x, y], d)| [x, y, (x * x + y * y) / 100.0 + d]).collect();
        let mut mesh = Mesh::new();
        mesh.insert(&points);
        assert!(mesh.points() == points, "a point is no vertex of its own");
        let triangles = mesh.triangles();
        Part { points, triangles, deviations_mm, spacing_mm }
    }

    /// Adds a height that depends on the place.
    pub(super) fn add(&mut self, height_mm: impl Fn(f64, f64) -> f64) {
        for (point, deviation) in self.points.iter_mut().zip(&mut self.deviations_mm) {
            let more = height_mm(point[0], point[1]);
            *deviation += more;
            point[2] += more;
        }
    }

    /// The search of a report: noise from the neighbourhoods of the points, widths up to twenty spacings.
    pub(super) fn search(&self) -> DefectSearch {
        let reach_mm = 6.0 * self.spacing_mm;
        let adjacency = Adjacency::new(&self.points, &self.triangles, Some(reach_mm)).unwrap();
        let noise: Noise =
            estimate_noise(&self.points, &adjacency, &NoiseSettings::default()).unwrap().noise;
        let places_mm: Vec<[f64; 2]> = self.points.iter().map(|&[x, y, _]| [x, y]).collect();
        let surface = DeviatingSurface {
            places_mm: Some(&places_mm),
            points: &self.points,
            triangles: &self.triangles,
            deviations_mm: &self.deviations_mm,
            spacing_mm: self.spacing_mm,
            reach_mm,
        };
        search_defects(&surface, &settings().with_noise(noise)).unwrap()
    }
}

/// The usual settings, or with as many false ones as the environment asks for.
fn settings() -> DefectSettings {
    let usual = DefectSettings::default();
    match std::env::var("ASPHERA_DEFECT_FALSE") {
        Ok(text) => usual.with_false_expected(text.parse().unwrap()).unwrap(),
        Err(_) => usual,
    }
}

/// Points of about equal area on a spiral outwards, by the number of the turn.
fn spiral_places(count: usize, random: &mut Random) -> Vec<(usize, [f64; 2])> {
    let turns = (count as f64 / std::f64::consts::PI).sqrt();
    let phase = random.unit();
    (0..count)
        .map(|index| {
            let share = ((index as f64 + 0.5) / count as f64).sqrt();
            let (sin, cos) = (TAU * (turns * share + phase)).sin_cos();
            ((turns * share) as usize, [RADIUS_MM * share * cos, RADIUS_MM * share * sin])
        })
        .collect()
}

/// Points of a disc, each drawn for itself.
fn scattered_places(count: usize, random: &mut Random) -> Vec<(usize, [f64; 2])> {
    (0..count)
        .map(|index| {
            let away = RADIUS_MM * random.unit().sqrt();
            let (sin, cos) = (TAU * random.unit()).sin_cos();
            (index, [away * cos, away * sin])
        })
        .collect()
}

/// Lines over a disc with 5 % jitter along them, turned by some angle.
fn line_places(spacing_mm: f64, random: &mut Random) -> Vec<(usize, [f64; 2])> {
    let half = (RADIUS_MM / spacing_mm).ceil() as i64;
    let (sin, cos) = (TAU * random.unit()).sin_cos();
    let mut places = Vec::new();
    for row in -half..=half {
        for column in -half..=half {
            let jitter = 0.1 * (random.unit() - 0.5);
            let [x, y] = [spacing_mm * (column as f64 + jitter), spacing_mm * row as f64];
            if x.hypot(y) < RADIUS_MM {
                places.push(((row + half) as usize, [cos * x - sin * y, sin * x + cos * y]));
            }
        }
    }
    places
}

type Form = Box<dyn Fn(f64, f64) -> f64>;

/// Low orders, and what the kind adds to them.
fn form(kind: Kind, random: &mut Random) -> Form {
    let mut between = |low: f64, high: f64| low + (high - low) * random.unit();
    let orders: [f64; 4] = std::array::from_fn(|_| between(-5e-5, 5e-5));
    let low = move |x: f64, y: f64| {
        let [x, y] = [x / RADIUS_MM, y / RADIUS_MM];
        let squared = x * x + y * y;
        orders[0] * (x * x - y * y)
            + orders[1] * x * (3.0 * squared - 2.0)
            + orders[2] * (6.0 * squared * squared - 6.0 * squared + 1.0)
            + orders[3] * (x * x * x - 3.0 * x * y * y)
    };
    match kind {
        Kind::Rings => {
            let count = between(1.0, 4.0) as usize;
            let rings: Vec<[f64; 3]> = (0..count)
                .map(|_| [between(2.0, 7.5), between(0.5, 1.0), between(1.5e-5, 6e-5)])
                .collect();
            Box::new(move |x, y| {
                let r = x.hypot(y);
                let of =
                    |&[at, width, height]: &[f64; 3]| height * (-((r - at) / width).powi(2)).exp();
                low(x, y) + rings.iter().map(of).sum::<f64>()
            })
        }
        Kind::Waves => {
            let (about, local) = (between(0.0, 1.0) < 0.5, between(0.0, 1.0) < 0.5);
            let (length, height) = (between(1.5, 6.0), between(1e-5, 4e-5));
            let (turn, at) = (between(0.0, TAU), between(-4.0, 4.0));
            Box::new(move |x, y| {
                let along = x * turn.cos() + y * turn.sin();
                let way = if about { x.hypot(y) } else { along };
                // A crest on the axis: a slope there would be the tip of a cone.
                let phase = if about { 0.25 } else { 0.0 };
                let share =
                    if local && !about { (-((along - at) / 2.5).powi(2)).exp() } else { 1.0 };
                low(x, y) + share * height * (TAU * (way / length + phase)).sin()
            })
        }
        Kind::Edges => {
            let (wide, height) = (between(0.3, 1.5), between(5e-5, 4e-4));
            let power = between(2.0, 4.0);
            Box::new(move |x, y| {
                let inside = (x.hypot(y) - RADIUS_MM) / wide + 1.0;
                low(x, y) - height * inside.max(0.0).powf(power)
            })
        }
        Kind::Scattered => {
            let high = 10.0_f64.powf(between(0.0, 1.0));
            Box::new(move |x, y| high * low(x, y))
        }
        _ => Box::new(low),
    }
}
