//! Samples of a solid on a grid: one bit each, 64 a word along x.

use rayon::prelude::*;
use thiserror::Error;

use crate::threshold::mask_of_bytes;

/// Most samples that a volume may have, 2³⁶: 8 GiB of bits.
pub const MAX_SAMPLES: u64 = 1 << 36;

/// Rows that are worth a thread of their own.
const ROWS: usize = 256;

/// A binary volume: which samples of a grid lie inside the solid.
///
/// Sample (x, y, z) lies at column x, row y and slice z; the distance of neighbours is 1. Around the volume lies one
/// layer of background samples, which [`Samples::get`] tells too. So every surface made from the samples is closed, also
/// where the solid touches the border.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Samples {
    size: [usize; 3],
    words_per_row: usize,
    words: Vec<u64>,
}

/// Why samples make no volume.
#[derive(Clone, Debug, Error, PartialEq, Eq)]
pub enum SizeError {
    /// A volume without samples, or with more than [`MAX_SAMPLES`].
    #[error("volume: expected 1 to {MAX_SAMPLES} samples, found {} × {} × {}", size[0], size[1], size[2])]
    Size {
        /// Columns, rows and slices.
        size: [usize; 3],
    },
    /// More or fewer samples than the size asks for.
    #[error("volume: expected {expected} samples, found {found}")]
    Length {
        /// Columns × rows × slices.
        expected: usize,
        /// The samples given.
        found: usize,
    },
}

impl Samples {
    /// A volume of background. `size` counts columns, rows and slices.
    ///
    /// # Errors
    ///
    /// [`SizeError::Size`] where a side is 0 or there are more than [`MAX_SAMPLES`].
    pub fn background(size: [usize; 3]) -> Result<Samples, SizeError> {
        let error = || SizeError::Size { size };
        // The layer around the volume counts: what is checked here cannot overflow below.
        let padded = size
            .iter()
            .try_fold(1_u64, |all, &side| all.checked_mul((side as u64).checked_add(2)?));
        if size.contains(&0) || padded.is_none_or(|padded| padded > MAX_SAMPLES) {
            return Err(error());
        }
        let words_per_row = (size[0] + 2).div_ceil(64);
        let words = vec![0; words_per_row * (size[1] + 2) * (size[2] + 2)];
        Ok(Samples { size, words_per_row, words })
    }

    /// A volume from a rule: `is_inside(x, y, z)` is asked once for every sample, x fastest.
    ///
    /// # Errors
    ///
    /// As [`Samples::background`].
    pub fn from_fn(
        size: [usize; 3],
        mut is_inside: impl FnMut(usize, usize, usize) -> bool,
    ) -> Result<Samples, SizeError> {
        let mut samples = Samples::background(size)?;
        for z in 0..size[2] {
            for y in 0..size[1] {
                let row = samples.row_mut(y + 1, z + 1);
                for x in 0..size[0] {
                    if is_inside(x, y, z) {
                        row[(x + 1) / 64] |= 1 << ((x + 1) % 64);
                    }
                }
            }
        }
        Ok(samples)
    }

    /// A volume from one truth value a sample, x fastest, then y, then z.
    ///
    /// # Errors
    ///
    /// As [`Samples::background`]; [`SizeError::Length`] where there are not as many values as samples.
    pub fn from_bools(size: [usize; 3], values: &[bool]) -> Result<Samples, SizeError> {
        let mut builder = SlabBuilder::new(size)?;
        builder.check(values.len())?;
        builder.push_with(values.len(), |index| values[index]);
        builder.finish()
    }

    /// A volume from bytes, x fastest, then y, then z: foreground is what is `threshold` or more.
    ///
    /// # Errors
    ///
    /// As [`Samples::from_bools`].
    pub fn from_bytes(
        size: [usize; 3],
        values: &[u8],
        threshold: u8,
    ) -> Result<Samples, SizeError> {
        let mut builder = SlabBuilder::new(size)?;
        builder.push_bytes(values, threshold)?;
        builder.finish()
    }

    /// Columns, rows and slices.
    pub fn size(&self) -> [usize; 3] {
        self.size
    }

    /// The number of samples.
    pub fn len(&self) -> u64 {
        self.size.iter().map(|&side| side as u64).product()
    }

    /// Whether nothing is inside.
    pub fn is_empty(&self) -> bool {
        self.words.iter().all(|&word| word == 0)
    }

    /// The number of samples inside the solid.
    pub fn foreground(&self) -> u64 {
        self.words.iter().map(|word| u64::from(word.count_ones())).sum()
    }

    /// Whether a sample is inside; what lies outside the volume is not.
    pub fn get(&self, [x, y, z]: [i64; 3]) -> bool {
        let within = |value: i64, side: usize| value >= 0 && (value as u64) < side as u64;
        within(x, self.size[0])
            && within(y, self.size[1])
            && within(z, self.size[2])
            && self.padded_bit(x as usize + 1, y as usize + 1, z as usize + 1)
    }

    /// Puts one sample inside or outside.
    ///
    /// # Panics
    ///
    /// Where the volume has no such sample.
    pub fn set(&mut self, [x, y, z]: [usize; 3], is_inside: bool) {
        assert!(x < self.size[0] && y < self.size[1] && z < self.size[2], "no such sample");
        let row = self.row_mut(y + 1, z + 1);
        let bit = 1 << ((x + 1) % 64);
        if is_inside {
            row[(x + 1) / 64] |= bit;
        } else {
            row[(x + 1) / 64] &= !bit;
        }
    }

    /// Whether the foreground touches the border of the volume: the part may go on beyond it.
    pub fn touches_border(&self) -> bool {
        self.touched_faces().as_flattened().contains(&true)
    }

    /// Which faces of the volume the foreground touches, by axis: that of the first samples and that of the last.
    pub(crate) fn touched_faces(&self) -> [[bool; 2]; 3] {
        let [nx, ny, nz] = self.size;
        let any = |y, z| self.row(y, z).iter().any(|&word| word != 0);
        let column = |x| (1..=nz).any(|z| (1..=ny).any(|y| self.padded_bit(x, y, z)));
        [
            [1, nx].map(column),
            [1, ny].map(|y| (1..=nz).any(|z| any(y, z))),
            [1, nz].map(|z| (1..=ny).any(|y| any(y, z))),
        ]
    }

    /// The volume with inside and outside exchanged; the layer around it stays background.
    pub fn complement(&self) -> Samples {
        let mut samples = self.clone();
        let [nx, ny, nz] = self.size;
        for z in 1..=nz {
            for y in 1..=ny {
                for (index, word) in samples.row_mut(y, z).iter_mut().enumerate() {
                    *word = !*word & within_row(index, nx);
                }
            }
        }
        samples
    }

    /// One row of words: rows and slices count from 0 for the layer around the volume, bit x + 1 is sample x.
    pub(crate) fn row(&self, y: usize, z: usize) -> &[u64] {
        let start = (z * (self.size[1] + 2) + y) * self.words_per_row;
        &self.words[start..start + self.words_per_row]
    }

    pub(crate) fn row_mut(&mut self, y: usize, z: usize) -> &mut [u64] {
        let start = (z * (self.size[1] + 2) + y) * self.words_per_row;
        &mut self.words[start..start + self.words_per_row]
    }

    /// All words: rows within slices, the layer around the volume included.
    pub(crate) fn words_mut(&mut self) -> &mut [u64] {
        &mut self.words
    }

    /// Words that a row of samples takes, the layer around the volume included.
    pub(crate) fn words_per_row(&self) -> usize {
        self.words_per_row
    }

    /// A sample by its place in the padded volume.
    pub(crate) fn padded_bit(&self, x: usize, y: usize, z: usize) -> bool {
        self.row(y, z)[x / 64] >> (x % 64) & 1 == 1
    }

    /// The code of the cell whose lowest corner is (x, y, z) of the padded volume.
    pub(crate) fn code(&self, [x, y, z]: [usize; 3]) -> u8 {
        (0..8).fold(0, |code, corner| {
            let bit =
                self.padded_bit(x + (corner & 1), y + (corner >> 1 & 1), z + (corner >> 2 & 1));
            code | u8::from(bit) << corner
        })
    }
}

/// The bits of word `index` that are samples of a row of `nx`, not the layer around them.
fn within_row(index: usize, nx: usize) -> u64 {
    let below = |bits: usize| if bits >= 64 { u64::MAX } else { (1 << bits) - 1 };
    let start = index * 64;
    let upper = below((nx + 1).saturating_sub(start));
    upper & !below(1_usize.saturating_sub(start))
}

/// A volume that comes slab by slab: any number of samples at a time, x fastest, then y, then z.
#[derive(Debug)]
pub struct SlabBuilder {
    samples: Samples,
    filled: usize,
}

impl SlabBuilder {
    /// A builder of a volume of `size` columns, rows and slices.
    ///
    /// # Errors
    ///
    /// As [`Samples::background`].
    pub fn new(size: [usize; 3]) -> Result<SlabBuilder, SizeError> {
        Ok(SlabBuilder { samples: Samples::background(size)?, filled: 0 })
    }

    /// Adds values: foreground is what is `threshold` or more. A value that is not finite is missing, and background.
    ///
    /// # Errors
    ///
    /// [`SizeError::Length`] where more come than the volume has; nothing is added then.
    pub fn push_values(&mut self, values: &[f32], threshold: f32) -> Result<(), SizeError> {
        self.check(values.len())?;
        let is_inside = |value: f32| value.is_finite() && value >= threshold;
        self.push_with(values.len(), |index| is_inside(values[index]));
        Ok(())
    }

    /// Adds values: foreground is what is missing, as it is not finite.
    ///
    /// # Errors
    ///
    /// As [`SlabBuilder::push_values`].
    pub fn push_missing(&mut self, values: &[f32]) -> Result<(), SizeError> {
        self.check(values.len())?;
        self.push_with(values.len(), |index| !values[index].is_finite());
        Ok(())
    }

    /// Adds bytes: foreground is what is `threshold` or more. Whole rows are shared by the threads of the caller's pool.
    ///
    /// # Errors
    ///
    /// As [`SlabBuilder::push_values`].
    pub fn push_bytes(&mut self, values: &[u8], threshold: u8) -> Result<(), SizeError> {
        self.check(values.len())?;
        let [nx, ny, _] = self.samples.size;
        if !self.filled.is_multiple_of(nx) || !values.len().is_multiple_of(nx) {
            self.push_with(values.len(), |index| values[index] >= threshold);
            return Ok(());
        }
        // Rows count without the layer around the volume, places with it.
        let (first, end) = (self.filled / nx, (self.filled + values.len()) / nx);
        let place = |row: usize| (row / ny + 1) * (ny + 2) + row % ny + 1;
        let words = self.samples.words_per_row;
        let of_rows = &mut self.samples.words[place(first) * words..place(end) * words];
        let rows = of_rows.par_chunks_mut(words).enumerate().with_min_len(ROWS);
        rows.for_each(|(index, words)| {
            let (z, y) = ((place(first) + index) / (ny + 2), (place(first) + index) % (ny + 2));
            if (1..=ny).contains(&y) {
                let row = (z - 1) * ny + y - 1 - first;
                mask_of_bytes(&values[row * nx..][..nx], threshold, words);
            }
        });
        self.filled += values.len();
        Ok(())
    }

    /// The volume.
    ///
    /// # Errors
    ///
    /// [`SizeError::Length`] where samples are missing.
    pub fn finish(self) -> Result<Samples, SizeError> {
        let expected = self.expected();
        if self.filled == expected {
            Ok(self.samples)
        } else {
            Err(SizeError::Length { expected, found: self.filled })
        }
    }

    fn expected(&self) -> usize {
        self.samples.size.iter().product()
    }

    fn check(&self, more: usize) -> Result<(), SizeError> {
        let (expected, found) = (self.expected(), self.filled.saturating_add(more));
        if found > expected { Err(SizeError::Length { expected, found }) } else { Ok(()) }
    }

    fn push_with(&mut self, count: usize, is_inside: impl Fn(usize) -> bool) {
        let [nx, ny, _] = self.samples.size;
        let mut index = 0;
        while index < count {
            let at = self.filled + index;
            let (x, row) = (at % nx, at / nx);
            let run = (nx - x).min(count - index);
            let words = self.samples.row_mut(row % ny + 1, row / ny + 1);
            for step in 0..run {
                let bit = x + step + 1;
                words[bit / 64] |= u64::from(is_inside(index + step)) << (bit % 64);
            }
            index += run;
        }
        self.filled += count;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn rule(x: usize, y: usize, z: usize) -> bool {
        (x * 7 + y * 13 + z * 29 + x * y * z) % 5 < 2
    }

    #[test]
    fn all_ways_into_a_volume_agree() {
        for size in [[1, 1, 1], [61, 3, 2], [62, 2, 3], [63, 1, 4], [64, 5, 1], [130, 4, 3]] {
            let [nx, ny, nz] = size;
            let places = || (0..nx * ny * nz).map(|i| [i % nx, i / nx % ny, i / nx / ny]);
            let by_rule = Samples::from_fn(size, rule).unwrap();
            let bools: Vec<bool> = places().map(|[x, y, z]| rule(x, y, z)).collect();
            let bytes: Vec<u8> = bools.iter().map(|&b| if b { 130 } else { 129 }).collect();
            let floats: Vec<f32> = bools.iter().map(|&b| if b { 0.5 } else { f32::NAN }).collect();
            assert_eq!(Samples::from_bools(size, &bools).unwrap(), by_rule);
            assert_eq!(Samples::from_bytes(size, &bytes, 130).unwrap(), by_rule);
            for slab in [1, 7, 64, 1000] {
                let mut builder = SlabBuilder::new(size).unwrap();
                let mut of_bytes = SlabBuilder::new(size).unwrap();
                for (part, bytes) in floats.chunks(slab).zip(bytes.chunks(slab)) {
                    builder.push_values(part, 0.5).unwrap();
                    of_bytes.push_bytes(bytes, 130).unwrap();
                }
                assert_eq!(builder.finish().unwrap(), by_rule);
                assert_eq!(of_bytes.finish().unwrap(), by_rule);
            }
            assert_eq!(by_rule.foreground(), bools.iter().filter(|&&b| b).count() as u64);
            let other = by_rule.complement();
            assert_eq!(other.foreground() + by_rule.foreground(), by_rule.len());
            assert_eq!(other.complement(), by_rule);
            for [x, y, z] in places() {
                assert_eq!(by_rule.get([x as i64, y as i64, z as i64]), rule(x, y, z));
                assert_eq!(other.get([x as i64, y as i64, z as i64]), !rule(x, y, z));
            }
        }
    }

    #[test]
    fn sizes_that_are_none_are_refused() {
        for size in [[0, 1, 1], [1, 0, 1], [1, 1, 0], [usize::MAX, 2, 2], [1 << 20, 1 << 20, 1]] {
            assert_eq!(Samples::background(size), Err(SizeError::Size { size }));
        }
        let found = Samples::from_bytes([2, 2, 2], &[0; 7], 1);
        assert_eq!(found, Err(SizeError::Length { expected: 8, found: 7 }));
        let mut builder = SlabBuilder::new([2, 2, 2]).unwrap();
        assert!(builder.push_values(&[0.0; 9], 1.0).is_err());
        builder.push_values(&[0.0; 7], 1.0).unwrap();
        assert!(builder.finish().is_err());
    }

    #[test]
    fn the_border_is_seen() {
        let mut samples = Samples::background([5, 5, 5]).unwrap();
        samples.set([2, 2, 2], true);
        assert!(!samples.touches_border());
        for place in [[0, 2, 2], [4, 2, 2], [2, 0, 2], [2, 4, 2], [2, 2, 0], [2, 2, 4]] {
            samples.set(place, true);
            assert!(samples.touches_border(), "{place:?}");
            samples.set(place, false);
        }
    }
}
