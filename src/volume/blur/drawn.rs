//! Blocks drawn from a large volume, and what they tell of all.

use rayon::prelude::*;

use super::convolution::{Field, Kernel, Mirrors, block};
use super::rims::creases_of_blocks;
use super::scale::{BASE, Scale, Variations, by_creases};
use super::{BLOCK, BlurredArea};
use crate::Samples;
use crate::cells::mixed_codes;
use crate::fractions::marching_areas;
use crate::scan::{Gaps, Scan};

/// Blocks with surface, up to which all are blurred.
const ALL: usize = 4000;

/// Blocks that are blurred of more.
const DRAWN: usize = 250;

/// Samples before the volume at which blocks begin: as far as the widest kernel reaches.
const REACH: usize = 12;

/// Blocks drawn by strata of their order, with the area that marching cubes have in them.
pub(super) struct Drawn<'a> {
    field: Field<'a>,
    blocks: Vec<Block>,
    /// Area of marching cubes of the whole volume, and the number of blocks that it lies in.
    total: f64,
    with_surface: usize,
}

/// A block drawn.
#[derive(Clone, Copy)]
struct Block {
    /// Its lowest sample.
    from: [i64; 3],
    /// Area of marching cubes in it.
    area: f64,
    /// What blur takes off its creases at the border of the volume, over σ.
    creases: f64,
}

impl Drawn<'_> {
    /// Draws from the blocks of a volume; `None` where it has so few that all may be blurred.
    pub(super) fn new(samples: &Samples, mirrors: Mirrors) -> Option<Drawn<'_>> {
        let counts = samples.size().map(|side| (side + 2 * REACH).div_ceil(BLOCK));
        if counts.iter().product::<usize>() <= ALL {
            return None;
        }
        let is_mirrored = mirrors != Mirrors::default();
        let scan = Scan::new(samples, Gaps { missing: None, at_border: is_mirrored });
        let areas: Vec<f64> = (0..counts[2])
            .into_par_iter()
            .flat_map_iter(|layer| areas(scan, [counts[0], counts[1]], layer))
            .collect();
        let with_surface: Vec<usize> = (0..areas.len()).filter(|&at| areas[at] > 0.0).collect();
        if with_surface.len() <= ALL {
            return None;
        }
        let place = |at: usize| {
            [at % counts[0], at / counts[0] % counts[1], at / counts[0] / counts[1]]
                .map(|at| (at * BLOCK) as i64 - REACH as i64)
        };
        let block_of = |sample: [usize; 3]| {
            let [x, y, z] = sample.map(|at| (at + REACH) / BLOCK);
            (z * counts[1] + y) * counts[0] + x
        };
        let creases = creases_of_blocks(samples, areas.len(), block_of);
        let blocks = (0..DRAWN).map(|stratum| {
            let [from, to] = [stratum, stratum + 1].map(|at| at * with_surface.len() / DRAWN);
            let at = with_surface[from + (scattered(stratum as u64) % (to - from) as u64) as usize];
            Block { from: place(at), area: areas[at], creases: creases[at] }
        });
        let blocks = blocks.collect();
        let total = areas.iter().sum();
        let field = Field { samples, level: 0, mirrors };
        Some(Drawn { field, blocks, total, with_surface: with_surface.len() })
    }

    pub(super) fn area(&self) -> BlurredArea {
        let base = self.with(BASE);
        let sum = Variations::sum(&base);
        let mut blocks = base;
        let mut total = sum;
        if let Some(finer) = sum.finer() {
            let found = self.with(finer);
            total = Variations::sum(&found);
            if !total.order().1 {
                blocks = found;
            }
        }
        let (order, has_edges) = total.order();
        let own: Vec<f64> = blocks.iter().map(|of| of.area(has_edges)).collect();
        let known: f64 = self.blocks.iter().map(|block| block.area).sum();
        let ratio = own.iter().sum::<f64>() / known;
        // Of a ratio: the scatter of what each block has beside it (Cochran, Sampling Techniques, 3rd edition, 6.4).
        let count = own.len() as f64;
        let square = |(own, block): (&f64, &Block)| (own - ratio * block.area).powi(2);
        let squares: f64 = own.iter().zip(&self.blocks).map(square).sum();
        let left = 1.0 - count / self.with_surface as f64;
        let scatter = (count * left * squares / (count - 1.0)).sqrt();
        let used = Variations::sum(&blocks);
        let creases: f64 = self.blocks.iter().map(|block| block.creases).sum();
        let [_, doubt] = by_creases(used.scale, has_edges, creases);
        let u = self.total / known * scatter.hypot(used.uncertainty(has_edges)).hypot(doubt);
        BlurredArea { area: ratio * self.total, u, order, has_edges, is_fine: total.is_fine() }
    }

    /// The total variations of each block.
    fn with(&self, scale: Scale) -> Vec<Variations> {
        let kernels = scale.sigmas().map(Kernel::new);
        let sums = |from: [i64; 3]| {
            // The layer around the volume comes before its first sample.
            let from = from.map(|at| at + 1);
            kernels.each_ref().map(|kernel| block(self.field, kernel, from))
        };
        let of_block = |block: &Block| {
            Variations { scale, sums: sums(block.from) }.with_creases(block.creases)
        };
        self.blocks.par_iter().map(of_block).collect()
    }
}

/// The area of marching cubes in each block of a layer of blocks, by their lowest corners.
fn areas(scan: Scan<'_>, counts: [usize; 2], layer: usize) -> Vec<f64> {
    let of_code = marching_areas();
    let mut areas = vec![0.0; counts[0] * counts[1]];
    // Cell z of the padded volume has its lowest corner at sample z - 1.
    let start = layer * BLOCK + 1;
    let end = (start + BLOCK).saturating_sub(REACH).min(scan.samples.size()[2] + 1);
    for z in start.saturating_sub(REACH)..end {
        scan.mixed_words(z, |y, word, corners, mixed| {
            let row = (y + REACH - 1) / BLOCK * counts[0];
            mixed_codes(word, corners, mixed, |x, code| {
                areas[row + (x + REACH - 1) / BLOCK] += of_code[usize::from(code)];
            });
        });
    }
    areas
}

/// A number without a pattern for each whole number (Steele, Lea, Flood, Fast splittable pseudorandom number generators, OOPSLA 2014).
fn scattered(number: u64) -> u64 {
    let mut value = number.wrapping_add(1).wrapping_mul(0x9E37_79B9_7F4A_7C15);
    value = (value ^ value >> 30).wrapping_mul(0xBF58_476D_1CE4_E5B9);
    value = (value ^ value >> 27).wrapping_mul(0x94D0_49BB_1331_11EB);
    value ^ value >> 31
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A gyroid of 8 periods: the blocks drawn tell its area within what they say.
    #[test]
    fn the_area_of_blocks_drawn_is_that_of_all() {
        let side = 560;
        let wave = 16.0 * std::f32::consts::PI / side as f32;
        let table: Vec<[f32; 2]> =
            (0..side).map(|at| (at as f32 * wave).sin_cos().into()).collect();
        let samples = Samples::from_fn([side; 3], |x, y, z| {
            let [[sx, cx], [sy, cy], [sz, cz]] = [x, y, z].map(|at| table[at]);
            sx * cy + sy * cz + sz * cx > 0.9
        })
        .unwrap();
        let mirrors = samples.touched_faces();
        let drawn = Drawn::new(&samples, mirrors).unwrap();
        let found = drawn.area();
        let u = found.u;
        assert!(u < 0.004 * found.area, "{found:?}");
        // A period of 1 has an area of 2.5567 by marching cubes of scikit-image 0.26.0 on 200³ values of the function. One slice of 560 lies
        // beyond the outermost samples, half on each side.
        let truth = 8.0 * 2.5567 * (side as f64 - 1.0).powi(3) / side as f64;
        eprintln!("{found:?} {truth} {}", found.area / truth - 1.0);
        assert!((found.area - truth).abs() < 2.0 * u, "{found:?} {truth}");
        // The same with all blocks, of one σ only, which is what takes the time.
        let one: f64 = drawn.with(BASE).iter().map(|of| of.sums[0]).sum();
        let known: f64 = drawn.blocks.iter().map(|block| block.area).sum();
        let by_drawn = one / known * drawn.total;
        let field = Field { samples: &samples, level: 0, mirrors };
        let blurred = super::super::variation(field, BASE.sigmas()[0]);
        let whole = Variations { scale: BASE, sums: [blurred, 0.0, 0.0] };
        let all = whole.with_creases(super::super::rims::creases(&samples)).sums[0];
        assert!((by_drawn - all).abs() < 3.0 * u, "{by_drawn} {all} {u}");
        let mesh = crate::marching_cubes(&samples, crate::Ambiguity::Paired, &crate::Middles);
        let gaps = Gaps { missing: None, at_border: true };
        let open = mesh.without_gaps(samples.size(), gaps);
        assert!((drawn.total / open.area() - 1.0).abs() < 1e-9);
    }

    #[test]
    fn small_volumes_are_blurred_whole() {
        let samples = Samples::from_fn([40; 3], |x, y, z| x + y + z < 60).unwrap();
        assert!(Drawn::new(&samples, Mirrors::default()).is_none());
        // Many blocks, of which few have surface.
        let samples = Samples::from_fn([520, 520, 520], |x, y, z| x < 9 && y < 9 && z < 9).unwrap();
        assert!(Drawn::new(&samples, Mirrors::default()).is_none());
    }
}
