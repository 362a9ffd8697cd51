//! The autocorrelation of a grid with gaps.

use nalgebra::Complex;

use super::{Grid, Support, Unknown};
use crate::fourier::transform_map;

/// The autocorrelation function of heights about their datum, by lag in columns and rows.
#[derive(Clone, Debug, PartialEq)]
pub struct Autocorrelation {
    /// Largest lag in columns and in rows.
    reach: [usize; 2],
    /// For lags of 0 to `reach[1]` rows, `−reach[0]` to `reach[0]` columns: the value and how many pairs it
    /// is the mean of.
    values: Vec<(f64, u64)>,
    /// Distance of columns and rows in mm.
    pub spacing_mm: [f64; 2],
    /// Samples that it rests on.
    pub support: Support,
}

impl Autocorrelation {
    /// Largest lag that is held, in columns and in rows.
    pub fn reach(&self) -> [usize; 2] {
        self.reach
    }

    /// Mean of the product of heights this many columns and rows apart, over the mean square of all
    /// heights, so that it is 1 at lag 0 and the same for the opposite lag; `None` for lags beyond the reach
    /// or with fewer than 50 pairs.
    pub fn at(&self, columns: isize, rows: isize) -> Option<f64> {
        self.entry(columns, rows).filter(|(_, pairs)| *pairs >= LEAST_PAIRS).map(|(value, _)| value)
    }

    /// Pairs of measured heights this far apart; 0 beyond the reach.
    pub fn pairs(&self, columns: isize, rows: isize) -> u64 {
        self.entry(columns, rows).map_or(0, |(_, pairs)| pairs)
    }

    fn entry(&self, columns: isize, rows: isize) -> Option<(f64, u64)> {
        let (columns, rows) = if rows < 0 { (-columns, -rows) } else { (columns, rows) };
        let reach = self.reach.map(|reach| reach as isize);
        if columns.abs() > reach[0] || rows > reach[1] {
            return None;
        }
        let index = rows * (2 * reach[0] + 1) + columns + reach[0];
        self.values.get(index as usize).copied()
    }
}

/// The autocorrelation of the heights of a grid about its datum, up to half its size in either direction.
///
/// Linear, by padding with zeros, and unbiased: each lag is divided by the number of its pairs of measured
/// heights, which is the correlation of the measured places with themselves. Both come from one complex
/// transform. Beyond half the size a lag sees less than half of each side. `O(n log n)`.
///
/// Unknown with fewer than 8 rows or columns, without a height, or if every height is 0.
pub fn autocorrelation(grid: &Grid) -> Result<Autocorrelation, Unknown> {
    let (rows, columns) = (grid.rows(), grid.columns());
    if rows < LEAST_SIZE || columns < LEAST_SIZE {
        return Err(Unknown::TooNarrow { rows, columns, needed: LEAST_SIZE });
    }
    let nodes = grid.nodes()?;
    let [low, high] = nodes.range_nm();
    let unit = high.abs().max(low.abs());
    if unit == 0.0 {
        return Err(Unknown::Flat);
    }
    let root = nodes.mean(|i| (nodes.heights_nm[i] / unit) * (nodes.heights_nm[i] / unit)).sqrt();
    // Two more than half, for the interpolation there.
    let reach = [columns / 2 + 2, rows / 2 + 2];
    let padded = [smooth_length(columns + reach[0]), smooth_length(rows + reach[1])];
    let mut values = vec![Complex::new(0.0, 0.0); padded[0] * padded[1]];
    for row in 0..rows {
        for column in 0..columns {
            if let Some(height_nm) = grid.at(row * columns + column) {
                values[row * padded[0] + column] = Complex::new(height_nm / unit / root, 1.0);
            }
        }
    }
    let spectrum = transform_map(values, padded[1], padded[0]);
    // Transposed: entry (column, row). The transform of the real part is the half sum with the conjugate
    // of the entry at the opposite frequency, that of the imaginary part their half difference over i.
    let opposite = |index: usize| {
        let (column, row) = (index / padded[1], index % padded[1]);
        (padded[0] - column) % padded[0] * padded[1] + (padded[1] - row) % padded[1]
    };
    let power = spectrum.iter().enumerate().map(|(index, value)| {
        let other = spectrum[opposite(index)].conj();
        Complex::new(0.25 * (value + other).norm_sqr(), 0.25 * (value - other).norm_sqr())
    });
    // Both powers are even, so forward and inverse transforms are the same, up to the factor.
    let lags = transform_map(power.collect(), padded[0], padded[1]);
    let scale = 1.0 / (padded[0] * padded[1]) as f64;
    let mut values = Vec::with_capacity((2 * reach[0] + 1) * (reach[1] + 1));
    for row in 0..=reach[1] {
        for column in -(reach[0] as isize)..=reach[0] as isize {
            let column = column.rem_euclid(padded[0] as isize) as usize;
            let lag = lags[row * padded[0] + column] * scale;
            let pairs = lag.im.round().max(0.0);
            values.push((if pairs > 0.0 { lag.re / pairs } else { 0.0 }, pairs as u64));
        }
    }
    Ok(Autocorrelation { reach, values, spacing_mm: grid.spacing_mm(), support: nodes.support })
}

/// The smallest length not below `least` without a prime factor above 5, which transforms fastest.
fn smooth_length(least: usize) -> usize {
    let is_smooth = |&length: &usize| {
        let mut rest = length;
        for factor in [2, 3, 5] {
            while rest % factor == 0 {
                rest /= factor;
            }
        }
        rest == 1
    };
    (least..).find(is_smooth).expect("a power of two follows every length")
}

/// A mean of fewer products is hardly known: its standard deviation is above 1/7.
const LEAST_PAIRS: u64 = 50;
/// Narrower grids have no lags to speak of.
const LEAST_SIZE: usize = 8;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_lag_is_the_mean_of_its_pairs() {
        let (rows, columns) = (12, 15);
        let heights: Vec<f64> = (0..rows * columns)
            .map(|i| if i * 7 % 10 < 3 { f64::NAN } else { (i as f64 * 1.7).sin() * 30.0 + 4.0 })
            .collect();
        let grid = Grid::new(&heights, rows, columns, [0.1, 0.2]).unwrap();
        let found = autocorrelation(&grid).unwrap();
        let squares: Vec<f64> = grid.heights_nm().flatten().map(|z| z * z).collect();
        let square = squares.iter().sum::<f64>() / squares.len() as f64;
        let mut compared = 0;
        for lag_y in -7_isize..=7 {
            for lag_x in -9_isize..=9 {
                let mut products = Vec::new();
                for row in 0..rows as isize {
                    for column in 0..columns as isize {
                        let (r, c) = (row + lag_y, column + lag_x);
                        if r < 0 || c < 0 {
                            continue;
                        }
                        let own = grid.height_nm(row as usize, column as usize);
                        let other = grid.height_nm(r as usize, c as usize);
                        products.extend(own.zip(other).map(|(a, b)| a * b));
                    }
                }
                assert_eq!(found.pairs(lag_x, lag_y), products.len() as u64, "{lag_x} {lag_y}");
                if let Some(value) = found.at(lag_x, lag_y) {
                    let mean = products.iter().sum::<f64>() / products.len() as f64 / square;
                    assert!((value - mean).abs() < 1e-12, "{value} {mean}");
                    compared += 1;
                }
            }
        }
        assert!(compared > 20, "{compared}");
        assert_eq!((found.pairs(10, 0), found.at(0, 9), found.reach()), (0, None, [9, 8]));
    }

    #[test]
    fn lengths_have_small_factors() {
        for (least, expected) in [(1, 1), (7, 8), (11, 12), (31, 32), (97, 100), (1023, 1024)] {
            assert_eq!(smooth_length(least), expected);
        }
    }
}
