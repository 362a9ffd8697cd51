//! How soft a step is: over which way its level rises.

use super::super::line::side;
use super::{BAND, WIDE, jump_of};

/// Profile of a step across its line.
pub(super) struct Flank {
    /// As in [`Line`](super::super::line::Line); 0 where it jumps as far as can be told.
    pub(super) soft_mm: f64,
    /// Standard uncertainty that this gives the height.
    pub(super) uncertainty_mm: f64,
}

/// A softness, with the height and the squares that it leaves.
type Tried = [f64; 3];

impl Flank {
    /// The softness that leaves the least squares of the samples (way, offset, height) by segments, with a cubic across the
    /// line. Each segment is moved so that its jump is at offset 0.
    pub(super) fn of(segments: &[Vec<[f64; 3]>], side_mm: f64, spacing_mm: f64) -> Flank {
        let sharp = Flank { soft_mm: 0.0, uncertainty_mm: 0.0 };
        let mut profile: Vec<[f64; 2]> = Vec::new();
        for samples in segments {
            let inner = samples.iter().filter(|sample| sample[1].abs() <= BAND * side_mm);
            let mut inner: Vec<[f64; 3]> = inner.copied().collect();
            // A soft one has its middle where a sharp one fits best.
            let Some(jump) = jump_of(&mut inner, [side_mm, spacing_mm, 0.0]) else { continue };
            profile.extend(samples.iter().map(|sample| [sample[1] - jump.offset_mm, sample[2]]));
        }
        let half_mm = WIDE * side_mm;
        let of = |spacings: f64| tried(&profile, half_mm, spacings * spacing_mm);
        let Some(jumps) = of(0.0) else { return sharp };
        let soft: Vec<Tried> = SOFT.into_iter().filter_map(of).collect();
        let best = soft.iter().min_by(|p, q| p[2].total_cmp(&q[2]));
        let Some(&[soft_mm, height_mm, squares]) = best else { return sharp };
        let single_mm2 = squares / profile.len() as f64;
        if jumps[2] - squares < CLEAR * CLEAR * single_mm2 {
            return sharp;
        }
        // Each is as likely as what it leaves makes it.
        let likely = |of: &Tried| (0.5 * (squares - of[2]) / single_mm2).exp();
        let total: f64 = soft.iter().map(likely).sum();
        let spread = soft.iter().map(|of| likely(of) / total * (of[1] - height_mm).powi(2));
        Flank { soft_mm, uncertainty_mm: spread.sum::<f64>().sqrt() }
    }
}

/// A softness at a profile of offsets and heights.
fn tried(profile: &[[f64; 2]], half_mm: f64, soft_mm: f64) -> Option<Tried> {
    let mut normal = nalgebra::SMatrix::<f64, 6, 6>::zeros();
    let mut right = nalgebra::SVector::<f64, 6>::zeros();
    let mut squares = 0.0;
    for &[offset_mm, height_mm] in profile {
        let x = offset_mm / half_mm;
        let rise = side(offset_mm, soft_mm);
        // How it changes if it is moved; a jump is where it is.
        let moved = if soft_mm > 0.0 { 0.25 - rise * rise } else { 0.0 };
        let terms = nalgebra::SVector::from([1.0, x, x * x, x * x * x, rise, moved]);
        normal += terms * terms.transpose();
        right += terms * height_mm;
        squares += height_mm * height_mm;
    }
    if soft_mm == 0.0 {
        normal[(5, 5)] = 1.0;
    }
    let solved = normal.cholesky()?.solve(&right);
    Some([soft_mm, solved[4], squares - solved.dot(&right)])
}

/// Softnesses that are tried, in spacings.
const SOFT: [f64; 14] = [1.0, 1.2, 1.4, 1.7, 2.0, 2.4, 2.8, 3.4, 4.0, 4.8, 5.6, 6.8, 8.0, 9.6];
/// Standard deviations from which on a step is taken for soft.
const CLEAR: f64 = 4.0;
