//! Smooth closed curves with their local feature size, and samples that meet a condition.

use asphera_contour::PlaceMm;

use crate::places::{Random, distance};

/// A closed curve as places close together, with its local feature size.
pub(crate) struct Curve {
    pub(crate) places: Vec<PlaceMm>,
    pub(crate) lfs: Vec<f64>,
}

/// A sampling condition.
#[derive(Clone, Copy)]
pub(crate) enum Condition {
    Epsilon(f64),
    Rho(f64),
}

impl Curve {
    /// r(θ) = 1 + Σ aₖ·cos(kθ + φₖ), k from 2 to 6, with amplitudes at random.
    ///
    /// The medial axis is found from `count` places: the ball that touches at p and at q has the radius
    /// |pq|² / (2·n·(q - p)), and the least over all q is the medial ball of p on that side.
    pub(crate) fn random(random: &mut Random, count: usize) -> Curve {
        let waves: Vec<[f64; 3]> = (2..=6)
            .map(|k| {
                [f64::from(k), random.between(-0.5, 0.5) / f64::from(k), random.between(0.0, 6.3)]
            })
            .collect();
        let step = std::f64::consts::TAU / count as f64;
        let mut places = Vec::new();
        let mut normals = Vec::new();
        for index in 0..count {
            let angle = index as f64 * step;
            let (mut radius, mut slope) = (1.0, 0.0);
            for [k, amplitude, phase] in &waves {
                radius += amplitude * (k * angle + phase).cos();
                slope -= amplitude * k * (k * angle + phase).sin();
            }
            let (sin, cos) = angle.sin_cos();
            let tangent = [slope * cos - radius * sin, slope * sin + radius * cos];
            let length = tangent[0].hypot(tangent[1]);
            places.push([radius * cos, radius * sin]);
            normals.push([-tangent[1] / length, tangent[0] / length]);
        }
        let centres = centres(&places, &normals);
        let lfs = |&place: &PlaceMm| {
            centres.iter().map(|&centre| distance(place, centre)).fold(f64::INFINITY, f64::min)
        };
        let lfs = places.iter().map(lfs).collect();
        Curve { places, lfs }
    }

    /// Samples of the curve in order, of random spacing as wide as the condition lets it be; none if it does not hold
    /// where the curve closes.
    pub(crate) fn samples(
        &self,
        condition: Condition,
        random: &mut Random,
    ) -> Option<Vec<PlaceMm>> {
        let count = self.places.len();
        let mut chosen = vec![0];
        loop {
            let from = chosen[chosen.len() - 1];
            let mut to = from + 1;
            while to < count && self.holds(condition, from, to + 1) {
                to += 1;
            }
            if to == count {
                break;
            }
            let reach = to - from;
            chosen.push(from + ((reach as f64 * random.between(0.6, 1.0)) as usize).max(1));
        }
        let closes = self.holds(condition, chosen[chosen.len() - 1], count);
        (closes && chosen.len() > 3)
            .then(|| chosen.into_iter().map(|index| self.places[index]).collect())
    }

    /// Whether the places between two samples meet the condition.
    fn holds(&self, condition: Condition, from: usize, to: usize) -> bool {
        let count = self.places.len();
        let ends = [from, to].map(|index| self.places[index % count]);
        let reach = (from..=to).map(|index| self.lfs[index % count]).fold(f64::INFINITY, f64::min);
        (from..to).all(|index| {
            let place = self.places[index];
            let nearest = distance(place, ends[0]).min(distance(place, ends[1]));
            match condition {
                Condition::Epsilon(epsilon) => nearest < epsilon * self.lfs[index],
                Condition::Rho(rho) => nearest < rho * reach,
            }
        })
    }
}

/// The centres of the medial balls on both sides.
fn centres(places: &[PlaceMm], normals: &[PlaceMm]) -> Vec<PlaceMm> {
    let mut centres = Vec::new();
    for (p, n) in places.iter().zip(normals) {
        for side in [1.0, -1.0] {
            let mut least = f64::INFINITY;
            for q in places {
                let [x, y] = [q[0] - p[0], q[1] - p[1]];
                let along = side * (n[0] * x + n[1] * y);
                if along > 0.0 {
                    least = least.min((x * x + y * y) / (2.0 * along));
                }
            }
            if least < 1e6 {
                centres.push([p[0] + side * least * n[0], p[1] + side * least * n[1]]);
            }
        }
    }
    centres
}
