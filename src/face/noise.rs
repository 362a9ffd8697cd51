//! Noise of grey values beside a face, and what it does to a crossing.

use rayon::prelude::*;

use crate::body::{Body, Skin};
use asphera_geometry::vector::{Vector, dot, plus};

/// Noise of the samples beside a face.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Noise {
    /// Standard deviation of one sample about the level of its patch.
    pub(crate) sigma: f64,
    /// Length ℓ of its correlation exp(−h²/(2ℓ²)), mm.
    pub(crate) length_mm: f64,
    /// Standard deviation of a value between samples over that of a sample, as the crossings are interpolated.
    pub(crate) between: f64,
}

/// From the samples next to places `beyond_mm` inside and outside of vertices, about the levels there, and their neighbours.
pub(crate) fn noise(
    body: &Body,
    skin: &Skin,
    vertices: &[(u32, [f64; 2])],
    beyond_mm: f64,
) -> Noise {
    let grey = body.grey(skin.threshold);
    let per_mm = body.scan.lattice.per_mm();
    // Squares of samples, and products with the neighbour along each axis: sums and counts.
    let of_one = |&(vertex, levels): &(u32, [f64; 2])| -> [f64; 5] {
        let normal = skin.normals[vertex as usize];
        let from = skin.surface.vertices[vertex as usize];
        let mut sums = [0.0; 5];
        for (side, level) in [(-1.0, levels[0]), (1.0, levels[1])] {
            let away: Vector = per_mm.map(|row| dot(row, normal) * side * beyond_mm);
            let node = plus(from, 1.0, away).map(f64::round);
            let off = |place: Vector| grey.at(place).map(|value| value - level);
            let beside = [0, 1, 2].map(|axis| {
                let mut place = node;
                // Away from the face.
                place[axis] += if away[axis] < 0.0 { -1.0 } else { 1.0 };
                off(place)
            });
            if let (Some(own), [Some(a), Some(b), Some(c)]) = (off(node), beside) {
                let seen = [own * own, own * a, own * b, own * c, 1.0];
                sums.iter_mut().zip(seen).for_each(|(sum, more)| *sum += more);
            }
        }
        sums
    };
    // Summed in the order of the vertices, whatever the threads.
    let each: Vec<[f64; 5]> = vertices.par_iter().map(of_one).collect();
    let sums = each.iter().fold([0.0; 5], |sums, one| std::array::from_fn(|i| sums[i] + one[i]));
    let spacing_mm = body.scan.lattice.spacing_mm();
    let share = |axis: usize| {
        let share = if sums[0] > 0.0 { sums[1 + axis] / sums[0] } else { 0.0 };
        share.clamp(LEAST_SHARE, MOST_SHARE)
    };
    let lengths_mm = [0, 1, 2].map(|axis| spacing_mm[axis] / (-2.0 * share(axis).ln()).sqrt());
    let mean_share = (0..3).map(share).sum::<f64>() / 3.0;
    Noise {
        sigma: (sums[0] / sums[4].max(1.0)).sqrt(),
        length_mm: lengths_mm.iter().sum::<f64>() / 3.0,
        between: between(mean_share),
    }
}

/// The mean, over all places between two samples, of the standard deviation of a value of the polynomial through six, if neighbours are
/// correlated by `share`.
fn between(share: f64) -> f64 {
    let correlation = |a: usize, b: usize| share.powi((a.abs_diff(b) * a.abs_diff(b)) as i32);
    let variance: f64 = (0..PLACES)
        .map(|place| {
            let weights = weights((f64::from(place) + 0.5) / f64::from(PLACES));
            let rows = (0..6)
                .map(|a| (0..6).map(|b| weights[a] * weights[b] * correlation(a, b)).sum::<f64>());
            rows.sum::<f64>()
        })
        .sum();
    (variance / f64::from(PLACES)).sqrt()
}

/// Lagrange's weights of the samples −2 to 3 at a place between 0 and 1.
fn weights(at: f64) -> [f64; 6] {
    std::array::from_fn(|own| {
        let node = own as f64 - 2.0;
        (0..6)
            .filter(|&other| other != own)
            .map(|other| other as f64 - 2.0)
            .map(|other| (at - other) / (node - other))
            .product()
    })
}

/// Correlations of neighbours that are told apart from none and from all.
const LEAST_SHARE: f64 = 0.02;
const MOST_SHARE: f64 = 0.995;
const PLACES: u32 = 64;

#[cfg(test)]
mod tests {
    use super::*;

    /// A value in the middle of six independent ones has the weights 150, −25 and 3 over 256; values that are all alike are one.
    #[test]
    fn weights_are_those_of_a_polynomial() {
        let found = weights(0.5).map(|weight| (weight * 256.0).round());
        assert_eq!(found, [3.0, -25.0, 150.0, 150.0, -25.0, 3.0]);
        assert_eq!(weights(0.0), [0.0, 0.0, 1.0, 0.0, 0.0, 0.0]);
        assert!((between(0.999_999) - 1.0).abs() < 1e-4);
        let white = between(0.0);
        assert!(white > 0.8 && white < 0.95, "{white}");
    }
}
