//! Power spectral density of a map with gaps.

use nalgebra::Complex;

use super::fourier::{transform_map, transposed};
use super::unknown::positive;
use super::{Band, Interpolation, SettingError, Unknown, Window};

/// Heights on a regular grid.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HeightGrid<'a> {
    heights_nm: &'a [f64],
    rows: usize,
    columns: usize,
    spacing_mm: [f64; 2],
}

impl HeightGrid<'_> {
    /// Heights in nm, row after row; NaN is a gap. `spacing_mm` is the distance of columns and of rows.
    /// Fails unless there are rows times columns heights and the distances are positive.
    pub fn new(
        heights_nm: &[f64],
        rows: usize,
        columns: usize,
        spacing_mm: [f64; 2],
    ) -> Result<HeightGrid<'_>, SettingError> {
        if rows.checked_mul(columns) != Some(heights_nm.len()) {
            return Err(SettingError::Grid { rows, columns, heights: heights_nm.len() });
        }
        positive("distance of columns", spacing_mm[0])?;
        positive("distance of rows", spacing_mm[1])?;
        Ok(HeightGrid { heights_nm, rows, columns, spacing_mm })
    }
}

/// Two-sided power spectral density of a map.
#[derive(Clone, Debug, PartialEq)]
pub struct MapPsd {
    /// Rows of the density, as many as the map has.
    pub rows: usize,
    /// Columns of the density.
    pub columns: usize,
    /// Distance in cycles per mm of the frequencies along x (columns) and along y (rows).
    pub step_per_mm: [f64; 2],
    /// Density in nm²·mm², row after row, frequency 0 first and the negative ones after the positive.
    pub density_nm2_mm2: Vec<f64>,
    /// Share of the grid that was measured.
    pub measured: f64,
    /// Window along rows and columns.
    pub window: Window,
    /// Highest frequency in cycles per mm, whatever its direction, up to which the density is of the surface; infinite
    /// where it is so to the end.
    pub up_to_per_mm: f64,
}

/// Mean density of a ring of frequencies.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FrequencyRing {
    /// Its middle in cycles per mm.
    pub frequency_per_mm: f64,
    /// Mean density in nm²·mm².
    pub density_nm2_mm2: f64,
    /// Entries averaged.
    pub count: usize,
}

impl MapPsd {
    /// RMS in nm of the frequencies in a band, whatever their direction: each entry counts whole, by its
    /// own frequency, as the density times the cell of the frequencies. Over all frequencies this is the
    /// RMS of the measured heights about their mean, under the window. Nothing beyond [`MapPsd::up_to_per_mm`] counts.
    pub fn band_rms_nm(&self, band: &Band) -> f64 {
        let counts = |frequency: f64| band.contains(frequency) && frequency <= self.up_to_per_mm;
        let rows = (0..self.rows).map(|row| {
            let entries = (0..self.columns).filter(|&column| counts(self.frequency(row, column)));
            entries.map(|column| self.density_nm2_mm2[row * self.columns + column]).sum::<f64>()
        });
        (rows.sum::<f64>() * self.step_per_mm[0] * self.step_per_mm[1]).sqrt()
    }

    /// Means over rings as wide as the coarser distance of the frequencies, the middle of the first at one
    /// width, up to the lower of the two half sampling frequencies and [`MapPsd::up_to_per_mm`]: beyond that rings are
    /// not whole.
    pub fn rings(&self) -> Vec<FrequencyRing> {
        let width = self.step_per_mm[0].max(self.step_per_mm[1]);
        let half_x = 0.5 * self.columns as f64 * self.step_per_mm[0];
        let half_y = 0.5 * self.rows as f64 * self.step_per_mm[1];
        let last =
            (half_x.min(half_y).min(self.up_to_per_mm) / width - 0.5).floor().max(0.0) as usize;
        let mut sums = vec![(0.0, 0_usize); last + 1];
        for row in 0..self.rows {
            for column in 0..self.columns {
                let ring = (self.frequency(row, column) / width).round() as usize;
                if let Some((sum, count)) = sums.get_mut(ring) {
                    *sum += self.density_nm2_mm2[row * self.columns + column];
                    *count += 1;
                }
            }
        }
        let rings = sums.into_iter().enumerate().skip(1).filter(|(_, (_, count))| *count > 0);
        let rings = rings.map(|(i, (sum, count))| FrequencyRing {
            frequency_per_mm: i as f64 * width,
            density_nm2_mm2: sum / count as f64,
            count,
        });
        rings.collect()
    }

    /// Frequency of an entry in cycles per mm, whatever its direction.
    pub fn frequency(&self, row: usize, column: usize) -> f64 {
        let [x, y] = self.frequencies(row, column);
        x.hypot(y)
    }

    /// Of heights that were interpolated between places on no raster: the density over the share of the power that the
    /// interpolation leaves, up to where that is half.
    pub fn without(mut self, interpolation: &Interpolation) -> MapPsd {
        for row in 0..self.rows {
            for column in 0..self.columns {
                let power = interpolation.power(self.frequencies(row, column));
                self.density_nm2_mm2[row * self.columns + column] /= power.max(LEAST_POWER);
            }
        }
        self.up_to_per_mm = self.up_to_per_mm.min(interpolation.half_power_per_mm());
        self
    }

    /// Frequency of an entry along x and y in cycles per mm, negative ones after the positive.
    fn frequencies(&self, row: usize, column: usize) -> [f64; 2] {
        let signed = |index: usize, count: usize| {
            if 2 * index > count { index as f64 - count as f64 } else { index as f64 }
        };
        [
            signed(column, self.columns) * self.step_per_mm[0],
            signed(row, self.rows) * self.step_per_mm[1],
        ]
    }
}

/// The power spectral density of a map.
///
/// The mean of the measured heights is subtracted and gaps are set to 0: what is not measured adds no
/// power, and the density |Σ w·m·z·exp(−2πi·f·x)|²·dx·dy/Σ (w·m)², with the window w and m = 1 where
/// measured, is of the measured area. Gaps act as a window does: each frequency is smeared by the
/// transform of the measured area, so near the frequency of one cycle over the widest gap or the aperture
/// the density is not to be relied on. Remove tilt and power before; they smear most. `O(n log n)`.
///
/// Unknown with fewer than 64 measured heights.
pub fn map_psd(grid: &HeightGrid<'_>, window: Window) -> Result<MapPsd, Unknown> {
    let (rows, columns) = (grid.rows, grid.columns);
    let finite = || grid.heights_nm.iter().copied().filter(|height| height.is_finite());
    let used = finite().count();
    if used < LEAST_HEIGHTS {
        return Err(Unknown::TooFewPoints { used, needed: LEAST_HEIGHTS });
    }
    let mean = finite().sum::<f64>() / used as f64;
    let at = |index: usize| window.at(index / columns, rows) * window.at(index % columns, columns);
    let mut power = 0.0;
    let values = grid.heights_nm.iter().enumerate().map(|(index, height)| {
        if !height.is_finite() {
            return Complex::new(0.0, 0.0);
        }
        let weight = at(index);
        power += weight * weight;
        Complex::new((height - mean) * weight, 0.0)
    });
    let values = transform_map(values.collect(), rows, columns);
    let values = transposed(&values, columns, rows);
    let [dx, dy] = grid.spacing_mm;
    let scale = dx * dy / power;
    Ok(MapPsd {
        rows,
        columns,
        step_per_mm: [1.0 / (columns as f64 * dx), 1.0 / (rows as f64 * dy)],
        density_nm2_mm2: values.iter().map(|value| value.norm_sqr() * scale).collect(),
        measured: used as f64 / (rows * columns) as f64,
        window,
        up_to_per_mm: f64::INFINITY,
    })
}

/// Entries of which an interpolation leaves less lie beyond the last that is given.
const LEAST_POWER: f64 = 1e-3;
/// An eight by eight map; fewer heights have hardly a spectrum.
const LEAST_HEIGHTS: usize = 64;
