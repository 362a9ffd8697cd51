//! Area from the volume near the surface: the semi-local estimator of the source, and bounds.
//!
//! Source: Stelldinger, Latecki, Siqueira, IEEE PAMI 29 (2007), section IX. C are the centres of the mixed cells; N(s) counts the
//! samples nearer than s to C. Weyl's tube formula (H. Weyl, On the volume of tubes, Am. J. Math. 61, 1939) is exact for s < r:
//!
//! ```text
//! V(∂A ⊕ B_s) = 2sA + (4π/3) χ s³        χ: Euler number of ∂A
//! ```

use std::collections::VecDeque;

use crate::Samples;
use crate::volumes::mixed_cells;

/// N(s) for several s: how many samples of the endless grid lie nearer than s to the centre of a mixed cell.
///
/// Memory grows with the slices within the largest s, time with the samples times that. `None` where the volume is too large
/// to be given a margin.
pub fn tube_counts(samples: &Samples, radii: &[f64]) -> Option<Vec<u64>> {
    let mixed = mixed_cells(samples)?;
    let largest = radii.iter().copied().fold(0.0, f64::max);
    let margin = largest.ceil() as usize;
    let plane = Plane::new(&mixed, margin);
    let mut counts = vec![0; radii.len()];
    // Squares in quarters of the spacing's square: centres of cells lie halfway between samples.
    let limits: Vec<u32> = radii.iter().map(|s| quarter_limit(*s)).collect();
    let layers = mixed.size()[2];
    let mut near: VecDeque<(usize, Vec<u32>)> = VecDeque::new();
    let mut next = 0;
    let mut least = vec![0; plane.places()];
    // Sample slice z, counted with the margin; cell layer k lies half a spacing below sample slice k + margin.
    for z in 0..layers + 2 * margin {
        while next < layers && next <= z {
            near.push_back((next, plane.squares(next)));
            next += 1;
        }
        while near.front().is_some_and(|(layer, _)| layer + 2 * margin < z) {
            near.pop_front();
        }
        least.fill(FAR);
        for (layer, squares) in &near {
            let twice = 2 * (z as i64 - margin as i64) - 2 * *layer as i64 + 1;
            let height = (twice * twice) as u32;
            if height < FAR {
                for (least, square) in least.iter_mut().zip(squares) {
                    *least = (*least).min(square + height);
                }
            }
        }
        for (count, &limit) in counts.iter_mut().zip(&limits) {
            *count += least.iter().filter(|&&square| square < limit).count() as u64;
        }
    }
    Some(counts)
}

const FAR: u32 = u32::MAX / 4;

/// The smallest whole number of quarter squares that is not nearer than s.
fn quarter_limit(s: f64) -> u32 {
    (4.0 * s * s).ceil().min(f64::from(FAR)) as u32
}

/// Squared distances within the layers of cells.
struct Plane<'a> {
    mixed: &'a Samples,
    margin: usize,
    /// Columns and rows of samples with the margin.
    size: [usize; 2],
}

impl Plane<'_> {
    fn new(mixed: &Samples, margin: usize) -> Plane<'_> {
        let size = [mixed.size()[0] + 2 * margin, mixed.size()[1] + 2 * margin];
        Plane { mixed, margin, size }
    }

    fn places(&self) -> usize {
        self.size[0] * self.size[1]
    }

    /// For every sample of a slice half a spacing from layer `z`, the square of the distance within the plane to the nearest mixed
    /// cell, in quarters; [`FAR`] beyond the margin.
    fn squares(&self, z: usize) -> Vec<u32> {
        let [columns, rows] = self.size;
        let mut found = vec![FAR; self.places()];
        for y in 0..self.mixed.size()[1] {
            let row = self.row_squares(y, z);
            if row.iter().all(|&square| square >= FAR) {
                continue;
            }
            // Row y of cells lies half a spacing below sample row y + margin.
            let first = (y + 1).saturating_sub(1);
            for target in first..(y + 2 * self.margin).min(rows) {
                let twice = 2 * (target as i64 - self.margin as i64) - 2 * y as i64 + 1;
                let height = (twice * twice) as u32;
                let line = &mut found[target * columns..(target + 1) * columns];
                for (least, square) in line.iter_mut().zip(&row) {
                    *least = (*least).min(square + height);
                }
            }
        }
        found
    }

    /// The same within a row of cells.
    fn row_squares(&self, y: usize, z: usize) -> Vec<u32> {
        let columns = self.size[0];
        let mut squares = vec![FAR; columns];
        let is_mixed = |x: usize| self.mixed.padded_bit(x + 1, y + 1, z + 1);
        let mut lower: Option<usize> = None;
        for x in 0..columns {
            // Cell c lies half a spacing below sample column c + margin.
            let cell = x as i64 - self.margin as i64;
            let own = usize::try_from(cell).ok().filter(|&c| c < self.mixed.size()[0]);
            if let Some(own) = own.filter(|&own| is_mixed(own)) {
                lower = Some(own);
                let back = x.saturating_sub(2 * self.margin);
                for target in (back..x).rev() {
                    let twice = 2 * (own as i64 + self.margin as i64 - target as i64) - 1;
                    let square = (twice * twice) as u32;
                    if square >= squares[target] {
                        break;
                    }
                    squares[target] = square;
                }
            }
            if let Some(lower) = lower {
                let twice = 2 * (x as i64 - self.margin as i64 - lower as i64) + 1;
                squares[x] = squares[x].min((twice * twice).min(i64::from(FAR)) as u32);
            }
        }
        squares
    }
}

/// The area by the source: N(s) over 2s. It is too large by about 0.75 / s of itself, for C ⊕ B_s is thicker than ∂A ⊕ B_s.
pub fn semi_local_area(count: u64, s: f64) -> f64 {
    count as f64 / (2.0 * s)
}

/// The area by a difference quotient, in which the thickness of C falls out: N(s) − N(s/2), less Weyl's term, over s.
///
/// `surface_euler` is the Euler number of the surface, twice that of the solid. Its δ = 0.65 is the half thickness of C, found by
/// experiment. s / 2 should be 7 or more, and s below r.
pub fn difference_area(count_at_s: u64, count_at_half: u64, s: f64, surface_euler: i64) -> f64 {
    let weyl = |s: f64| weyl_term(surface_euler, s + HALF_THICKNESS);
    (count_at_s as f64 - count_at_half as f64 - (weyl(s) - weyl(s / 2.0))) / s
}

/// Half the thickness of the mixed cells' centres about a surface, found by experiment.
const HALF_THICKNESS: f64 = 0.65;

/// (4π/3) χ s³.
fn weyl_term(surface_euler: i64, s: f64) -> f64 {
    4.0 * std::f64::consts::PI / 3.0 * surface_euler as f64 * s * s * s
}

/// Bounds of the area of an r-regular part, in squares of the spacing.
///
/// ```text
/// ∂A ⊕ B(s − 2r′)  ⊂  voxels counted  ⊂  ∂A ⊕ B(s + 2r′)        r′ = √3/2
/// ```
///
/// `None` where 2r′ < s and s + 2r′ < r do not hold.
pub fn area_bounds(count: u64, s: f64, surface_euler: i64, regular: f64) -> Option<[f64; 2]> {
    let reach = 3_f64.sqrt();
    if !(s > reach && s + reach < regular) {
        return None;
    }
    let bound = |s: f64| (count as f64 - weyl_term(surface_euler, s)) / (2.0 * s);
    Some([bound(s + reach), bound(s - reach)])
}
