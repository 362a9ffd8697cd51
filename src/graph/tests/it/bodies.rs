//! Bodies of a known genus, sampled at random on their surfaces.

use rand_core::{Rng as _, SeedableRng as _};
use rand_pcg::Pcg64;

pub(crate) type Place = [f64; 3];

/// Numbers at random.
#[derive(Clone)]
pub(crate) struct Random(Pcg64);

impl Random {
    pub(crate) fn new(seed: u64) -> Random {
        Random(Pcg64::seed_from_u64(seed))
    }

    /// Between 0 and 1.
    pub(crate) fn unit(&mut self) -> f64 {
        (self.0.next_u64() >> 11) as f64 / (1_u64 << 53) as f64
    }

    pub(crate) fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.unit()
    }

    pub(crate) fn below(&mut self, count: usize) -> usize {
        (self.unit() * count as f64) as usize
    }

    /// A normal deviate (Box and Muller).
    pub(crate) fn normal(&mut self) -> f64 {
        let radius = (-2.0 * (1.0 - self.unit()).ln()).sqrt();
        radius * (std::f64::consts::TAU * self.unit()).cos()
    }

    pub(crate) fn direction(&mut self) -> Place {
        let draw = [self.normal(), self.normal(), self.normal()];
        let length = norm(draw);
        draw.map(|value| value / length)
    }

    /// Fisher and Yates's shuffle.
    pub(crate) fn shuffle<T>(&mut self, things: &mut [T]) {
        for last in (1..things.len()).rev() {
            let other = self.below(last + 1);
            things.swap(last, other);
        }
    }
}

pub(crate) fn norm(p: Place) -> f64 {
    p.iter().map(|value| value * value).sum::<f64>().sqrt()
}

/// A body: its signed distance (or a bound of that sign with a slope near 1 at the surface), the box about it, its genus.
pub(crate) struct Body {
    pub(crate) name: String,
    pub(crate) genus: usize,
    half: Place,
    distance: Box<dyn Fn(Place) -> f64 + Sync>,
}

impl Body {
    pub(crate) fn sphere() -> Body {
        Body::of("sphere", 0, [1.0; 3], |p| norm(p) - 1.0)
    }

    pub(crate) fn torus() -> Body {
        Body::of("torus", 1, [1.4, 1.4, 0.4], |p| torus(p, 0.0))
    }

    /// Tori in a row, each joined to the next.
    pub(crate) fn row(genus: usize) -> Body {
        let length = 2.0 * (genus as f64 - 1.0) / 2.0;
        Body::of(&format!("row of {genus}"), genus, [1.4 + length, 1.4, 0.4], move |p| {
            let rings = (0..genus).map(|ring| torus(p, 2.0 * ring as f64 - length));
            rings.fold(f64::INFINITY, f64::min)
        })
    }

    /// A plate of 8 by 8 and a thickness, with 3 by 3 bores of radius 0.8.
    pub(crate) fn plate(thickness: f64) -> Body {
        let half = [4.0, 4.0, thickness / 2.0];
        Body::of(&format!("plate of {thickness}"), 9, half, move |p| {
            let sides: Place = std::array::from_fn(|axis| p[axis].abs() - half[axis]);
            let outside = norm(sides.map(|side| side.max(0.0)));
            let plate = outside + sides.into_iter().fold(f64::NEG_INFINITY, f64::max).min(0.0);
            let bores = (0..9).map(|bore| {
                let at = [bore % 3, bore / 3].map(|step| 2.5 * (f64::from(step) - 1.0));
                (p[0] - at[0]).hypot(p[1] - at[1]) - 0.8
            });
            plate.max(-bores.fold(f64::INFINITY, f64::min))
        })
    }

    pub(crate) fn of(
        name: &str,
        genus: usize,
        half: Place,
        distance: impl Fn(Place) -> f64 + Sync + 'static,
    ) -> Body {
        Body { name: name.to_owned(), genus, half, distance: Box::new(distance) }
    }

    /// Points at random, evenly on the surface: those of a thin shell, moved onto it.
    pub(crate) fn sample(&self, count: usize, random: &mut Random) -> Vec<Place> {
        let shell = 0.02;
        let mut points = Vec::with_capacity(count);
        while points.len() < count {
            let mut p: Place = self.half.map(|half| random.between(-half - shell, half + shell));
            if (self.distance)(p).abs() > shell {
                continue;
            }
            for _ in 0..3 {
                let value = (self.distance)(p);
                let slope: Place = std::array::from_fn(|axis| {
                    let [mut low, mut high] = [p; 2];
                    (low[axis], high[axis]) = (p[axis] - 1e-6, p[axis] + 1e-6);
                    ((self.distance)(high) - (self.distance)(low)) / 2e-6
                });
                let square = slope.iter().map(|value| value * value).sum::<f64>().max(0.1);
                (0..3).for_each(|axis| p[axis] -= value * slope[axis] / square);
            }
            points.push(p);
        }
        points
    }
}

fn torus(p: Place, x: f64) -> f64 {
    ((p[0] - x).hypot(p[1]) - 1.0).hypot(p[2]) - 0.4
}
