//! A finer grid within the cells of a volume, and surfaces found on it.

use rayon::prelude::*;

use crate::marching::{Crossings, marching_cubes};
use crate::table::Ambiguity;
use crate::{Samples, SizeError, Surface};

/// Most pieces a side of a cell is cut into.
pub const MAX_REFINE: usize = 8;

/// A solid described in every cell by a function, above 0 inside.
pub(crate) trait Implicit: Sync {
    /// The function at a place of a cell, each coordinate from 0 to 1. `cell` is the place of its lowest corner in the padded volume.
    fn value(&self, samples: &Samples, cell: [usize; 3], code: u8, local: [f64; 3]) -> f64;

    /// Whether the code alone decides the function.
    fn is_local(&self) -> bool;

    /// Whether a cell without foreground corners is outside and a full one inside, everywhere: so for all methods of the source.
    /// Only mixed cells are then asked.
    fn bits(&self, samples: &Samples, cell: [usize; 3], code: u8, refine: usize) -> CellBits {
        let mut bits = [[0_u8; MAX_REFINE]; MAX_REFINE];
        for (z, slice) in bits.iter_mut().enumerate().take(refine) {
            for (y, row) in slice.iter_mut().enumerate().take(refine) {
                for x in 0..refine {
                    let local = [x, y, z].map(|at| at as f64 / refine as f64);
                    *row |= u8::from(self.value(samples, cell, code, local) >= 0.0) << x;
                }
            }
        }
        bits
    }
}

/// Samples of the finer grid in one cell: bit x of row y of slice z.
pub(crate) type CellBits = [[u8; MAX_REFINE]; MAX_REFINE];

/// The surface of an implicit solid by marching cubes on a grid `refine` times finer.
///
/// Every sample of the finer grid belongs to one cell, so that neighbours agree and nothing cracks. Vertices lie on the surface.
pub(crate) fn implicit_surface(
    samples: &Samples,
    solid: &impl Implicit,
    refine: usize,
) -> Result<Surface, SizeError> {
    let refine = refine.clamp(1, MAX_REFINE);
    let fine = refined(
        samples,
        refine,
        |cell, code| solid.bits(samples, cell, code, refine),
        solid.is_local(),
    )?;
    let crossings = Roots { samples, solid, refine };
    let surface = marching_cubes(&fine, Ambiguity::Apart, &crossings);
    let scale = refine as f64;
    Ok(surface.moved(|vertex| vertex.map(|place| place / scale - 1.0), false))
}

/// The finer volume: sample i of it lies at i / refine of the padded volume.
pub(crate) fn refined(
    samples: &Samples,
    refine: usize,
    bits: impl Fn([usize; 3], u8) -> CellBits + Sync,
    is_local: bool,
) -> Result<Samples, SizeError> {
    let size = samples.size().map(|side| (side + 1) * refine + 1);
    let mut fine = Samples::background(size)?;
    let full = [[(1_u16 << refine).wrapping_sub(1) as u8; MAX_REFINE]; MAX_REFINE];
    let table: Vec<CellBits> = if is_local {
        (0..=255_u8)
            .map(|code| match code {
                0 => [[0; MAX_REFINE]; MAX_REFINE],
                255 => full,
                _ => bits([0; 3], code),
            })
            .collect()
    } else {
        Vec::new()
    };
    let words_per_row = fine.words_per_row();
    let slice_words = words_per_row * (size[1] + 2);
    let [nx, ny, _] = samples.size();
    // Slice 0 of the words is the layer around the volume.
    fine.words_mut()[slice_words..].par_chunks_mut(slice_words * refine).enumerate().for_each(
        |(z, slices)| {
            if z > samples.size()[2] {
                return;
            }
            for y in 0..=ny {
                for x in 0..=nx {
                    let code = samples.code([x, y, z]);
                    if code == 0 {
                        continue;
                    }
                    let own = match table.get(usize::from(code)) {
                        Some(own) => *own,
                        None if code == 255 => full,
                        None => bits([x, y, z], code),
                    };
                    let bit = x * refine + 1;
                    for (dz, slice) in own.iter().enumerate().take(refine) {
                        for (dy, &row) in slice.iter().enumerate().take(refine) {
                            let start = dz * slice_words + (y * refine + dy + 1) * words_per_row;
                            let wide = u128::from(row) << (bit % 64);
                            slices[start + bit / 64] |= wide as u64;
                            if wide >> 64 != 0 {
                                slices[start + bit / 64 + 1] |= (wide >> 64) as u64;
                            }
                        }
                    }
                }
            }
        },
    );
    Ok(fine)
}

/// Where an implicit solid begins on the edges of the finer grid.
struct Roots<'a, S> {
    samples: &'a Samples,
    solid: &'a S,
    refine: usize,
}

impl<S: Implicit> Crossings for Roots<'_, S> {
    fn share(&self, from: [i64; 3], axis: usize) -> f64 {
        let refine = self.refine as i64;
        // The finer grid begins where the padded volume does, so no crossing edge starts before it.
        let from = from.map(|place| place.max(0));
        let [nx, ny, nz] = self.samples.size();
        let cell = [(from[0], nx), (from[1], ny), (from[2], nz)]
            .map(|(place, side)| ((place / refine) as usize).min(side));
        let code = self.samples.code(cell);
        let start: [f64; 3] =
            std::array::from_fn(|at| (from[at] - cell[at] as i64 * refine) as f64 / refine as f64);
        let value = |share: f64| {
            let mut local = start;
            local[axis] += share / refine as f64;
            self.solid.value(self.samples, cell, code, local)
        };
        root_between(value)
    }
}

/// The root of a function between 0 and 1: false position, the kept end halved (Illinois), to 1e-14. Linear functions need one step.
fn root_between(value: impl Fn(f64) -> f64) -> f64 {
    let (mut a, mut b) = (0.0, 1.0);
    let (mut at_a, mut at_b) = (value(a), value(b));
    if at_a == 0.0 {
        return a;
    }
    if at_b == 0.0 {
        return b;
    }
    if (at_a > 0.0) == (at_b > 0.0) {
        // The finer samples beside a cell that is asked no more: the surface passes between them.
        return 0.5;
    }
    for _ in 0..200 {
        let mut middle = (a * at_b - b * at_a) / (at_b - at_a);
        if !(middle > a && middle < b) {
            middle = f64::midpoint(a, b);
        }
        let found = value(middle);
        if found.abs() < 1e-15 || b - a < 1e-15 {
            return middle;
        }
        if (found > 0.0) == (at_a > 0.0) {
            (a, at_a) = (middle, found);
            at_b /= 2.0;
        } else {
            (b, at_b) = (middle, found);
            at_a /= 2.0;
        }
    }
    f64::midpoint(a, b)
}
