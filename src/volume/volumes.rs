//! The volume of the part: by every method, and bounds that hold for certain.
//!
//! Source: Stelldinger, Latecki, Siqueira, IEEE PAMI 29 (2007), section IX: all reconstructions, and the part itself, agree outside
//! the balls of radius r′ = √3/2 about the centres of the mixed cells. The source bounds their volume by that of all balls added
//! up; here it is the volume of their union, which is exact.

use rayon::prelude::*;

use crate::cells::{mixed_codes, mixed_words};
use crate::fractions::{Fractions, ball_fractions, cube_fractions};
use crate::reconstruct::LEAST_BALL_RADIUS;
use crate::scan::{Gaps, Scan};
use crate::{Histogram, Samples};

impl Histogram {
    /// The volume of a reconstruction, in cubes of the spacing: the sum over the cells of what the table says.
    pub fn volume(&self, fractions: &Fractions) -> f64 {
        self.sum(|code| fractions[usize::from(code)])
    }
}

/// What the volume of the part is certain to lie between, in cubes of the spacing. It holds for r-regular parts sampled at
/// h < r / √3.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct VolumeBounds {
    /// What is inside whatever the part does between the samples.
    pub low: f64,
    /// What is not outside.
    pub high: f64,
}

impl VolumeBounds {
    /// The bounds of a volume. `regular` is the part's r in spacings, where it is stated.
    ///
    /// Without it, all that lies within r′ of the centre of a mixed cell is uncertain. With it, so is only what lies within
    /// t of a mixed cell, along each axis: the boundary enters a cell without mixed corners by at most
    ///
    /// ```text
    /// t = r − √(r² − ½)
    /// ```
    ///
    /// for it touches a ball of radius r, and the chord between the samples of a face is √2 at most. The narrower bounds are given.
    pub fn new(samples: &Samples, regular: Option<f64>) -> VolumeBounds {
        VolumeBounds::with_missing(samples, None, regular)
    }

    /// The same where the foreground of `missing` was not measured: every cell with a corner on such a sample counts as mixed. So the
    /// bounds hold whatever lies there.
    ///
    /// # Panics
    ///
    /// Where the sizes differ.
    pub fn with_missing(
        samples: &Samples,
        missing: Option<&Samples>,
        regular: Option<f64>,
    ) -> VolumeBounds {
        let counts = Corners::of(Scan::new(samples, Gaps { missing, at_border: false }));
        let by_balls = counts.bounds(&ball_fractions(LEAST_BALL_RADIUS));
        let depth = regular.filter(|r| *r * *r > 0.5).map(|r| r - (r * r - 0.5).sqrt());
        let by_slabs = depth
            .filter(|depth| *depth < 0.5)
            .map(|depth| counts.bounds(&cube_fractions(0.5 + depth)));
        match by_slabs {
            Some(slabs) if slabs.high - slabs.low < by_balls.high - by_balls.low => slabs,
            _ => by_balls,
        }
    }

    /// The width over the middle.
    pub fn relative_width(&self) -> f64 {
        (self.high - self.low) / f64::midpoint(self.high, self.low)
    }
}

/// Standard uncertainty of a volume by counting samples, from the place of the grid alone, in cubes of the spacing. `area` is that
/// of the part, in squares of the spacing.
///
/// Matheron's transitive theory: near 0 the covariogram of a body of area A falls as A·|x| / 4, in the mean over its directions. Its
/// Fourier transform and the Epstein zeta function ζ(4) = Σ |n|⁻⁴ = 16.5323 of the cubic grid give
///
/// ```text
/// u² = A / 4 · ζ(4) / (2π³) = 0.06665 A
/// ```
pub fn counting_uncertainty(area: f64) -> f64 {
    0.258_17 * area.max(0.0).sqrt()
}

/// How many voxels, of background and foreground, have which mixed cells at their corners.
struct Corners {
    counts: [[u64; 256]; 2],
}

impl Corners {
    fn of(scan: Scan<'_>) -> Corners {
        let samples = scan.samples;
        let Some(mixed) = uncertain_cells(scan) else {
            return Corners { counts: [[0; 256]; 2] };
        };
        let zero = || [[0_u64; 256]; 2];
        let mut counts = (0..=mixed.size()[2])
            .into_par_iter()
            .fold(zero, |mut counts, z| {
                mixed_words(&mixed, z, |y, word, corners, bits| {
                    mixed_codes(word, corners, bits, |x, code| {
                        let inside = samples.padded_bit(x, y, z);
                        counts[usize::from(inside)][usize::from(code)] += 1;
                    });
                });
                // Voxels all of whose corners are mixed are not listed with the others.
                for y in 0..=mixed.size()[1] {
                    for x in 0..=mixed.size()[0] {
                        if mixed.padded_bit(x, y, z) && mixed.code([x, y, z]) == 255 {
                            counts[usize::from(samples.padded_bit(x, y, z))][255] += 1;
                        }
                    }
                }
                counts
            })
            .reduce(zero, |mut a, b| {
                a.as_flattened_mut().iter_mut().zip(b.as_flattened()).for_each(|(a, b)| *a += b);
                a
            });
        counts[1][0] = samples.foreground() - counts[1][1..].iter().sum::<u64>();
        Corners { counts }
    }

    /// Lower bound: what of the foreground's voxels is certain. Upper bound: that, and all that is uncertain.
    fn bounds(&self, uncertain: &Fractions) -> VolumeBounds {
        let mut low = 0.0;
        let mut open = 0.0;
        for (code, &share) in uncertain.iter().enumerate() {
            let [background, foreground] = self.counts.map(|counts| counts[code] as f64);
            low += foreground * (1.0 - share);
            open += (foreground + background) * share;
        }
        VolumeBounds { low, high: low + open }
    }
}

/// The mixed cells of a volume as a volume: cell (x, y, z), by its lowest corner in the padded volume, is sample (x, y, z).
///
/// `None` where the volume is so large that one with a row more is not possible.
pub(crate) fn mixed_cells(samples: &Samples) -> Option<Samples> {
    let mut mixed = Samples::background(samples.size().map(|side| side + 1)).ok()?;
    for z in 0..=samples.size()[2] {
        mixed_words(samples, z, |y, word, _, bits| add_cells(&mut mixed, [word, y, z], bits));
    }
    Some(mixed)
}

/// Adds the cells of a word to such a volume.
fn add_cells(cells: &mut Samples, [word, y, z]: [usize; 3], bits: u64) {
    let row = cells.row_mut(y + 1, z + 1);
    row[word] |= bits << 1;
    if bits >> 63 != 0 {
        row[word + 1] |= 1;
    }
}

/// The cells that are mixed or near missing samples, as [`mixed_cells`] gives them.
fn uncertain_cells(scan: Scan<'_>) -> Option<Samples> {
    let mut cells = mixed_cells(scan.samples)?;
    for z in 0..=scan.samples.size()[2] {
        scan.near_missing(z, |y, word, bits| add_cells(&mut cells, [word, y, z], bits));
    }
    Some(cells)
}
