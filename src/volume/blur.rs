//! Area from a blurred volume: its total variation, extrapolated to no blur.
//!
//! With b the volume of 0 and 1 and G a Gaussian of standard deviation σ, on a smooth surface with curvatures κ₁ and κ₂
//!
//! ```text
//! TV(σ) = ∫ |∇(G ∗ b)| = A − (σ²/2) ∫ (κ₁² + κ₂²) dA + …
//! ```
//!
//! and on edges the loss grows as σ. Which of the two it is shows in three σ.

mod convolution;
mod drawn;
mod rims;
mod scale;

use rayon::prelude::*;

use crate::Samples;
use convolution::{Field, Kernel, Mirrors, block};
use drawn::Drawn;
use rims::{creases, rims};
use scale::{BASE, STEPS_DOUBT, Scale, Variations, by_creases};

/// The area, and how it was found.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BlurredArea {
    /// In squares of the spacing.
    pub area: f64,
    /// Its standard uncertainty: from the place of the grid, the extrapolation, the angles of the surface at the border of the volume and,
    /// where only some places were blurred, the scatter between them.
    pub u: f64,
    /// The order with which the total variation falls as σ grows: 2 for smooth bodies, 1 where edges prevail; `None` where it does not
    /// fall.
    pub order: Option<f64>,
    /// Whether edges prevail, so that the extrapolation is that of edges.
    pub has_edges: bool,
    /// Whether detail is as fine as the blur. It is taken for smooth; where it has edges, the area may be a tenth too small.
    pub is_fine: bool,
}

/// The area of a volume by blurring it, in the caller's pool. The result does not depend on threads.
///
/// σ is 1.5, 1.5·√2 and 3 spacings. The order p comes from the three; where it is nearer to 1 than to 2, edges prevail (of finer σ below an
/// order that falls with what they take, as that of small smooth bodies does), and the area is a polynomial in σ at 0, else one in σ². Where these σ take much, 1, √2 and 2 decide, and serve smooth bodies. Where they take little,
/// steps of the grid would stand out, so σ grows as the root of the radius of curvature, on a grid as much coarser.
///
/// Where material touches the border of the volume, flat faces close it half a spacing beyond: each of their samples is a square, and walls
/// of half a spacing join them to the area up to the outermost samples.
///
/// Blurring is slow. Of more than 4,000 blocks of 32³ samples with surface in them, 250 drawn by strata are blurred. The area
/// of the others follows from that of their marching cubes, as a ratio, whose scatter between the blocks `u` counts too.
pub fn blurred_area(samples: &Samples) -> BlurredArea {
    let found = area_to_border(samples);
    if !samples.touches_border() {
        return found;
    }
    let walls = rims(samples) / 2.0;
    let area = found.area + faces(samples) as f64 + walls;
    BlurredArea { area, u: found.u.hypot(WALL_DOUBT * walls), ..found }
}

/// The same up to the outermost samples, beyond which nothing is known: no faces close the volume there.
///
/// The volume goes on as its mirror image. Walls that do not meet the border at right angles have creases there: what blur takes off
/// these is given back, by how far the walls lean.
pub(crate) fn area_to_border(samples: &Samples) -> BlurredArea {
    let mirrors = samples.touched_faces();
    if let Some(drawn) = Drawn::new(samples, mirrors) {
        return drawn.area();
    }
    let is_mirrored = mirrors != Mirrors::default();
    let creases = creases(samples);
    let measured = |scale: Scale| {
        let field = Field { samples, level: scale.level, mirrors };
        let sums = scale.sigmas().map(|sigma| variation(field, sigma));
        Variations { scale, sums }.with_creases(creases)
    };
    let base = measured(BASE);
    let mut best = base;
    if let Some(finer) = base.finer() {
        best = measured(finer);
    } else {
        while let Some(coarser) = best.coarser(base.loss()) {
            // Creases are known to a few percent, and blur takes the more off them the coarser it is.
            let [_, doubt] = by_creases(coarser, false, creases);
            if doubt > STEPS_DOUBT * base.area(false) {
                break;
            }
            let next = measured(coarser);
            if !next.is_trusted() {
                break;
            }
            best = next;
        }
    }
    // Steps of the grid stand out most where edges are found, as σ counts more there.
    if best.scale == BASE && best.order().1 && !is_mirrored {
        let next = measured(BASE.next());
        if next.are_edges_trusted() {
            best = next;
        }
    }
    let (order, has_edges) = best.order();
    // Steps of the grid would disturb the finer σ where edges prevail.
    let used = if has_edges && best.scale.is_finer() { base } else { best };
    // What is left of creases looks like edges.
    let [of_smooth, _] = by_creases(used.scale, false, creases);
    let has_edges = has_edges && (used.area(true) - used.area(false)).abs() >= of_smooth;
    let [_, doubt] = by_creases(used.scale, has_edges, creases);
    BlurredArea {
        area: used.area(has_edges),
        u: used.uncertainty(has_edges).hypot(doubt),
        order,
        has_edges,
        is_fine: best.is_fine(),
    }
}

/// Standard uncertainty of the area of walls between the outermost samples and the faces that close a volume, as a share of it: they may
/// lean.
const WALL_DOUBT: f64 = 1.0 / 3.0;

/// Foreground samples of the six slices at the border; one at an edge of the volume counts for each.
fn faces(samples: &Samples) -> u64 {
    let [nx, ny, nz] = samples.size();
    let row = |y: usize, z: usize| -> u64 {
        samples.row(y, z).iter().map(|word| u64::from(word.count_ones())).sum()
    };
    let mut count = 0;
    for z in 1..=nz {
        count += row(1, z) + row(ny, z);
        for y in 1..=ny {
            count += [1, nx].iter().filter(|&&x| samples.padded_bit(x, y, z)).count() as u64;
        }
    }
    count + (1..=ny).map(|y| row(y, 1) + row(y, nz)).sum::<u64>()
}

/// Side of the blocks that are blurred one at a time.
const BLOCK: usize = 32;

/// ∫ |∇(G ∗ b)| over the endless grid, in squares of the spacing; σ in spacings.
pub fn total_variation(samples: &Samples, sigma: f64) -> f64 {
    variation(Field { samples, level: 0, mirrors: Mirrors::default() }, sigma)
}

/// The same of a field; σ in spacings of its grid, the variation in squares of the finest one.
fn variation(field: Field<'_>, sigma: f64) -> f64 {
    let level = field.level;
    // A mean of n samples at a distance of 1/n has a variance of (1 − 1/n²)/12.
    let of_mean = (1.0 - (-2.0 * f64::from(level)).exp2()) / 12.0;
    let kernel = Kernel::new((sigma * sigma - of_mean).sqrt());
    let reach = kernel.reach();
    let sides = field.samples.size().map(|side| (side + 2).div_ceil(1 << level));
    let blocks = sides.map(|side| (side + 2 * reach).div_ceil(BLOCK));
    let sums: Vec<f64> = (0..blocks.iter().product::<usize>())
        .into_par_iter()
        .map(|index| {
            let place =
                [index % blocks[0], index / blocks[0] % blocks[1], index / blocks[0] / blocks[1]];
            // Blocks begin as far before the volume as the kernel reaches.
            let from = place.map(|at| (at * BLOCK) as i64 - reach as i64);
            block(field, &kernel, from)
        })
        .collect();
    sums.iter().sum::<f64>() * (2.0 * f64::from(level)).exp2()
}
