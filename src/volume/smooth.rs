//! Trilinear pieces blended into a smooth surface: section VIII of the source.

use crate::Samples;
use crate::implicit::trilinear;
use crate::refine::Implicit;

/// How the pieces are blended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Blend {
    /// h(x) = x: the surface has kinks where the blended zones end. (The source calls it C¹.)
    Linear,
    /// h(x) = 3x² − 2x³: tangents are continuous. (Printed as 2x³ − 3x² + 1 in the source, which falls.)
    Cubic,
    /// h(x) = exp(−1/x): derivatives of every order are continuous.
    Infinite,
}

/// Half the width of the blended zones: the value for which the source proves the topology (lemma 26).
pub(crate) const BLEND_HALF_WIDTH: f64 = 0.2;

/// f = Σ over cells of φ(p − centre) · trilinear polynomial of the cell.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Smooth {
    pub(crate) blend: Blend,
}

impl Smooth {
    fn h(self, x: f64) -> f64 {
        match self.blend {
            Blend::Linear => x,
            Blend::Cubic => x * x * (3.0 - 2.0 * x),
            Blend::Infinite if x <= 0.0 => 0.0,
            Blend::Infinite => (-1.0 / x).exp(),
        }
    }

    /// The weight of a cell whose centre is `t` away along one axis. The weights of two neighbours add up to 1.
    fn weight(self, t: f64) -> f64 {
        let inner = 0.5 - BLEND_HALF_WIDTH;
        let share = (t.abs() - inner) / (2.0 * BLEND_HALF_WIDTH);
        if share <= 0.0 {
            1.0
        } else if share >= 1.0 {
            0.0
        } else {
            self.h(1.0 - share) / (self.h(1.0 - share) + self.h(share))
        }
    }
}

impl Implicit for Smooth {
    fn value(&self, samples: &Samples, cell: [usize; 3], code: u8, local: [f64; 3]) -> f64 {
        // Along each axis the cell itself, and the neighbour on the nearer side where its zone reaches here.
        let own: [f64; 3] = local.map(|place| self.weight(place - 0.5));
        let side: [i64; 3] = local.map(|place| if place < 0.5 { -1 } else { 1 });
        let mut sum = 0.0;
        for neighbour in 0..8_usize {
            let is_off = |axis: usize| neighbour >> axis & 1 == 1;
            let weight: f64 =
                (0..3).map(|axis| if is_off(axis) { 1.0 - own[axis] } else { own[axis] }).product();
            if weight <= 0.0 {
                continue;
            }
            let shift: [i64; 3] =
                std::array::from_fn(|axis| if is_off(axis) { side[axis] } else { 0 });
            let of_neighbour = if neighbour == 0 { code } else { code_at(samples, cell, shift) };
            let place = std::array::from_fn(|axis| local[axis] - shift[axis] as f64);
            sum += weight * trilinear(of_neighbour, place);
        }
        sum
    }

    fn is_local(&self) -> bool {
        false
    }
}

/// The code of a neighbouring cell; beyond the padded volume all is background.
fn code_at(samples: &Samples, cell: [usize; 3], shift: [i64; 3]) -> u8 {
    let size = samples.size();
    let place: [i64; 3] = std::array::from_fn(|axis| cell[axis] as i64 + shift[axis]);
    if (0..3).any(|axis| place[axis] < 0 || place[axis] > size[axis] as i64) {
        return 0;
    }
    samples.code(place.map(|coordinate| coordinate as usize))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn weights_of_neighbours_add_up_to_one() {
        for blend in [Blend::Linear, Blend::Cubic, Blend::Infinite] {
            let smooth = Smooth { blend };
            for step in 0..=100 {
                let t = f64::from(step) / 100.0;
                let sum = smooth.weight(t) + smooth.weight(1.0 - t);
                assert!((sum - 1.0).abs() < 1e-12, "{blend:?} {t} {sum}");
            }
        }
    }
}
