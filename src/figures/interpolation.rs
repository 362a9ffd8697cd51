//! How much of a wave linear interpolation between scattered places leaves.

use std::f64::consts::{PI, TAU};

use rayon::prelude::*;

/// The response of linear interpolation over triangles, by frequency and direction.
///
/// A wave exp(ik·x) that is known at the corners alone comes out of the interpolation as H·exp(ik·x), and as waves that are
/// others from triangle to triangle. H is the mean over the triangles, by area, of Σ w_c·exp(ik·(x_c − x)), with the
/// weights w_c of the corners at x. Of the power of a wave H² is left at its frequency.
#[derive(Clone, Debug, PartialEq)]
pub struct Interpolation {
    step_per_mm: f64,
    /// H² by direction, and in each by frequency, the first at 0.
    power: Vec<f64>,
}

impl Interpolation {
    /// Over the triangles, up to a frequency in cycles per mm. Some thousand triangles, evenly taken from the list, stand
    /// for all: H² is known to about 0.01.
    pub fn over(
        places_mm: &[[f64; 2]],
        triangles: &[[u32; 3]],
        up_to_per_mm: f64,
    ) -> Interpolation {
        let some = triangles.len().min(SOME_TRIANGLES);
        let corners: Vec<[[f64; 2]; 3]> = (0..some)
            .map(|index| triangles[index * triangles.len() / some])
            .map(|corners| corners.map(|corner| places_mm[corner as usize]))
            .collect();
        let step_per_mm = up_to_per_mm / STEPS as f64;
        let power = (0..DIRECTIONS * (STEPS + 1))
            .into_par_iter()
            .map(|entry| {
                let (direction, step) = (entry / (STEPS + 1), entry % (STEPS + 1));
                let (sin, cos) = (PI * direction as f64 / DIRECTIONS as f64).sin_cos();
                let k = TAU * step as f64 * step_per_mm;
                left(&corners, [k * cos, k * sin]).powi(2)
            })
            .collect();
        Interpolation { step_per_mm, power }
    }

    /// H² of a frequency in cycles per mm along x and y; beyond the last that of the last.
    pub fn power(&self, frequency_per_mm: [f64; 2]) -> f64 {
        let [x, y] = frequency_per_mm;
        let along = (x.hypot(y) / self.step_per_mm).min(STEPS as f64);
        // A wave has no sense: directions repeat after half a turn.
        let turn = (y.atan2(x) / PI).rem_euclid(1.0) * DIRECTIONS as f64;
        let (direction, step) = (turn as usize, (along as usize).min(STEPS - 1));
        let (beside, beyond) = (turn - direction as f64, along - step as f64);
        let at = |direction: usize| {
            let row = &self.power[direction % DIRECTIONS * (STEPS + 1)..][..=STEPS];
            row[step] + (row[step + 1] - row[step]) * beyond
        };
        at(direction) + (at(direction + 1) - at(direction)) * beside
    }

    /// Highest frequency in cycles per mm up to which half of the power of every wave is left.
    pub fn half_power_per_mm(&self) -> f64 {
        let least = |step: usize| {
            let all = (0..DIRECTIONS).map(|direction| self.power[direction * (STEPS + 1) + step]);
            all.fold(f64::INFINITY, f64::min)
        };
        for step in 1..=STEPS {
            let (before, here) = (least(step - 1), least(step));
            if here < HALF {
                let share = ((before - HALF) / (before - here)).clamp(0.0, 1.0);
                return ((step - 1) as f64 + share) * self.step_per_mm;
            }
        }
        STEPS as f64 * self.step_per_mm
    }
}

/// H of the wave vector in rad/mm.
fn left(triangles: &[[[f64; 2]; 3]], k: [f64; 2]) -> f64 {
    let (mut sum, mut total) = (0.0, 0.0);
    for [a, b, c] in triangles {
        let doubled = (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
        let area = doubled.abs();
        total += area;
        for &(weight, shares) in &NODES {
            let at =
                [0, 1].map(|axis| shares[0] * a[axis] + shares[1] * b[axis] + shares[2] * c[axis]);
            let wave =
                |corner: &[f64; 2]| (k[0] * (corner[0] - at[0]) + k[1] * (corner[1] - at[1])).cos();
            let waves = shares[0] * wave(a) + shares[1] * wave(b) + shares[2] * wave(c);
            sum += area * weight * waves;
        }
    }
    if total > 0.0 { sum / total } else { 1.0 }
}

/// Weights and barycentric coordinates of a rule of degree 4 over a triangle: D. A. Dunavant, Int. J. Numer. Methods Eng. 21
/// (1985) 1129.
const NODES: [(f64, [f64; 3]); 6] = {
    const P: (f64, f64, f64) =
        (0.223_381_589_678_011, 0.108_103_018_168_070, 0.445_948_490_915_965);
    const Q: (f64, f64, f64) =
        (0.109_951_743_655_322, 0.816_847_572_980_459, 0.091_576_213_509_771);
    [
        (P.0, [P.1, P.2, P.2]),
        (P.0, [P.2, P.1, P.2]),
        (P.0, [P.2, P.2, P.1]),
        (Q.0, [Q.1, Q.2, Q.2]),
        (Q.0, [Q.2, Q.1, Q.2]),
        (Q.0, [Q.2, Q.2, Q.1]),
    ]
};
/// Triangles that stand for all.
const SOME_TRIANGLES: usize = 3000;
/// Directions in half a turn, and steps of frequency.
const DIRECTIONS: usize = 8;
const STEPS: usize = 12;
/// Less of the power of a wave is hardly told from what others leave at its frequency.
const HALF: f64 = 0.5;
