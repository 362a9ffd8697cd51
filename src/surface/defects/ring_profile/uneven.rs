//! Rings that are not the same all round: their middle lies beside the axis, for a part is turned about one place and cut out
//! about another; or they are higher on some sides, for a polishing head tilts.
//!
//! Rings f about a place c near the axis leave f(|p − c|) − f(|p|) ≈ −f′ c·û of what is alike about the axis, up in half of
//! the sectors and down in the others. Rings whose height changes round leave f (a₁ cos θ + b₁ sin θ + …) up to waves three times
//! round, as of a chuck with three jaws.
//! By least squares over all means that gives c, a and b, and better about each that was found. What a defect adds to some
//! means is far from that: it is cut down to what noise may add.

use nalgebra::{SMatrix, SVector};

use super::sectors::{SECTORS, Sectors};
use crate::defects::tail;

/// By how much the rings differ from what was assumed.
pub(super) struct Change {
    /// The rings, by nodes outwards, in mm.
    pub(super) rings_mm: Vec<f64>,
    /// Of their middle, in nodes.
    pub(super) centre: [f64; 2],
    /// Of the terms of their height.
    pub(super) terms: [f64; WAVES],
}

impl Change {
    /// How far the middle moves in nodes, and by what share of them the rings swell.
    pub(super) fn sizes(&self) -> [f64; 2] {
        let swell = self.terms.iter().map(|term| term * term).sum::<f64>().sqrt();
        [self.centre[0].hypot(self.centre[1]), swell]
    }
}

/// Rings whose height changes round, less what is alike.
#[derive(Clone, Default)]
pub(super) struct Uneven {
    /// By nodes outwards; none without rings.
    pub(super) rings_mm: Vec<f64>,
    pub(super) terms: [f64; WAVES],
}

impl Uneven {
    /// Height at a place from the middle of the rings, in nodes.
    pub(super) fn height_mm(&self, [x, y]: [f64; 2]) -> f64 {
        let radius = x.hypot(y);
        let known = radius > 0.0 && radius + 1.0 < self.rings_mm.len() as f64;
        if !known {
            return 0.0;
        }
        let below = radius as usize;
        let [low, high] = [below, below + 1].map(|node| self.rings_mm[node]);
        let share: f64 =
            waves([x / radius, y / radius]).iter().zip(self.terms).map(|(p, q)| p * q).sum();
        share * (low + (radius - below as f64) * (high - low))
    }

    /// How much the rings change, by what a profile leaves of the sectors; `None` where no ring tells. Nodes before `first` do
    /// not count.
    pub(super) fn change(
        profile_mm: &[f64],
        rings_mm: Vec<f64>,
        left: &Sectors,
        first: usize,
    ) -> Option<Change> {
        let mut lines = Vec::new();
        for (sector, means) in left.means.iter().enumerate() {
            let (y, x) = Sectors::middle_of(sector).sin_cos();
            let waves = waves([x, y]);
            for node in first..(profile_mm.len() - 1).min(means.len()) {
                let root = means[node].weight.sqrt();
                let steepness = 0.5 * (profile_mm[node + 1] - profile_mm[node - 1]);
                let mut lift = SVector::<f64, UNKNOWNS>::zeros();
                (lift[0], lift[1]) = (-root * steepness * x, -root * steepness * y);
                for (term, wave) in waves.iter().enumerate() {
                    lift[2 + term] = root * rings_mm[node] * wave * KEPT[term / 2];
                }
                lines.push(Line { lift, height: root * means[node].height_mm });
            }
        }
        let found = solved(&lines)?;
        let centre = [found[0], found[1]];
        Some(Change { rings_mm, centre, terms: std::array::from_fn(|term| found[2 + term]) })
    }
}

/// Waves once, twice and three times round in a direction: cosine and sine of each.
fn waves([u, v]: [f64; 2]) -> [f64; WAVES] {
    let twice = [u * u - v * v, 2.0 * u * v];
    let thrice = [u * twice[0] - v * twice[1], u * twice[1] + v * twice[0]];
    [u, v, twice[0], twice[1], thrice[0], thrice[1]]
}

/// A mean over its standard deviation, but for a factor that all have.
struct Line {
    /// What one of each unknown adds.
    lift: SVector<f64, UNKNOWNS>,
    height: f64,
}

/// The unknowns by least squares; `None` where they are not determined.
fn solved(lines: &[Line]) -> Option<SVector<f64, UNKNOWNS>> {
    let normal: SMatrix<f64, UNKNOWNS, UNKNOWNS> =
        lines.iter().map(|line| line.lift * line.lift.transpose()).sum();
    let factor = normal.cholesky()?;
    let (mut found, mut most) = (SVector::zeros(), f64::INFINITY);
    for _ in 0..ROUNDS {
        let off = |line: &Line| line.height - line.lift.dot(&found);
        let step = |line: &Line| line.lift * off(line).clamp(-most, most);
        let more = factor.solve(&lines.iter().map(step).sum::<SVector<f64, UNKNOWNS>>());
        let mut sizes: Vec<f64> = lines.iter().map(|line| off(line).abs()).collect();
        most = CALM * tail::scale(&mut sizes)?;
        found += more;
    }
    found.iter().all(|term| term.is_finite()).then_some(found)
}

/// Terms of the height.
pub(super) const WAVES: usize = 6;
const UNKNOWNS: usize = 2 + WAVES;
/// Share of waves once, twice and three times round that the mean over a sector has.
const KEPT: [f64; 3] = [0.988_616, 0.954_930, 0.900_316];
const _: () = assert!(SECTORS == 12);
/// Rounds in which what is far off is cut down.
const ROUNDS: usize = 5;
/// Standard deviations to which it is.
const CALM: f64 = 3.0;
