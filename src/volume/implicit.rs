//! Solids that a cell's code decides: trilinear interpolation and unions of balls.

use crate::Samples;
use crate::refine::Implicit;

/// Trilinear interpolation of +1 at foreground and −1 at background samples.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Trilinear;

/// The trilinear polynomial of a cell at a place, which may lie beyond it.
pub(crate) fn trilinear(code: u8, [x, y, z]: [f64; 3]) -> f64 {
    let corner = |at: usize| if code >> at & 1 == 1 { 1.0 } else { -1.0 };
    let along = |a: f64, b: f64, share: f64| a + (b - a) * share;
    let row = |at: usize| along(corner(at), corner(at + 1), x);
    along(along(row(0), row(2), y), along(row(4), row(6), y), z)
}

impl Implicit for Trilinear {
    fn value(&self, _: &Samples, _: [usize; 3], code: u8, local: [f64; 3]) -> f64 {
        trilinear(code, local)
    }

    fn is_local(&self) -> bool {
        true
    }
}

/// Balls about all foreground samples.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Balls {
    pub(crate) radius: f64,
}

impl Implicit for Balls {
    fn value(&self, _: &Samples, _: [usize; 3], code: u8, local: [f64; 3]) -> f64 {
        let squares = (0..8_usize).filter(|at| code >> at & 1 == 1).map(|at| {
            (0..3).map(|axis| (local[axis] - (at >> axis & 1) as f64).powi(2)).sum::<f64>()
        });
        match squares.fold(f64::INFINITY, f64::min) {
            // No ball reaches a cell that has none at its corners.
            f64::INFINITY => -1.0,
            square => self.radius - square.sqrt(),
        }
    }

    fn is_local(&self) -> bool {
        true
    }
}
