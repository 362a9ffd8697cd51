//! Power spectral density of a profile.

use nalgebra::Complex;

use super::fourier::Fourier;
use super::unknown::positive;
use super::{SettingError, Unknown};

/// A band of spatial frequencies: from the lower limit, included, to the upper, excluded, so that adjoining
/// bands share nothing.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Band {
    from_per_mm: f64,
    to_per_mm: f64,
}

impl Band {
    /// Limits in cycles per mm; no lower limit means 0, no upper one infinity. Fails unless the lower is
    /// not negative and below the upper.
    pub fn of_frequencies(
        from_per_mm: Option<f64>,
        to_per_mm: Option<f64>,
    ) -> Result<Band, SettingError> {
        let (from_per_mm, to_per_mm) =
            (from_per_mm.unwrap_or(0.0), to_per_mm.unwrap_or(f64::INFINITY));
        if from_per_mm >= 0.0 && from_per_mm < to_per_mm {
            Ok(Band { from_per_mm, to_per_mm })
        } else {
            Err(SettingError::Band { from_per_mm, to_per_mm })
        }
    }

    /// Limits as wavelengths in mm; no shortest one means no upper limit of the frequency, no longest one
    /// no lower limit. The longest belongs to the band. Fails unless given ones are positive and the
    /// shortest is below the longest.
    pub fn of_periods(
        shortest_mm: Option<f64>,
        longest_mm: Option<f64>,
    ) -> Result<Band, SettingError> {
        let frequency = |name, period_mm: Option<f64>| {
            period_mm.map(|period_mm| Ok(1.0 / positive(name, period_mm)?)).transpose()
        };
        Band::of_frequencies(
            frequency("longest period", longest_mm)?,
            frequency("shortest period", shortest_mm)?,
        )
    }

    /// Whether a frequency in cycles per mm belongs to it.
    pub fn contains(&self, frequency_per_mm: f64) -> bool {
        frequency_per_mm >= self.from_per_mm && frequency_per_mm < self.to_per_mm
    }
}

/// Window by which samples are multiplied before the transform.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Window {
    /// Nothing. For profiles around a full turn, and where ends meet.
    #[default]
    None,
    /// (1 − cos 2πx)/2 with x from 0 to 1, over samples at (i + ½)/n: against the step between the ends.
    Hann,
}

impl Window {
    pub(crate) fn at(self, index: usize, length: usize) -> f64 {
        match self {
            Window::None => 1.0,
            Window::Hann => {
                let sine = (std::f64::consts::PI * (index as f64 + 0.5) / length as f64).sin();
                sine * sine
            }
        }
    }
}

/// Evenly spaced heights along a line.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HeightLine<'a> {
    heights_nm: &'a [f64],
    spacing_mm: f64,
}

impl HeightLine<'_> {
    /// Heights in nm, NaN for a gap, at a positive finite distance from each other. Fails unless it is one.
    pub fn new(heights_nm: &[f64], spacing_mm: f64) -> Result<HeightLine<'_>, SettingError> {
        positive("spacing", spacing_mm)?;
        Ok(HeightLine { heights_nm, spacing_mm })
    }
}

/// One-sided power spectral density of a profile.
#[derive(Clone, Debug, PartialEq)]
pub struct LinePsd {
    /// Distance of the frequencies in cycles per mm; entry i is at i times this.
    pub step_per_mm: f64,
    /// Density in nm²·mm.
    pub density_nm2_mm: Vec<f64>,
    /// Index of the first sample of the run it is from.
    pub first: usize,
    /// Samples of that run.
    pub used: usize,
    /// Samples given, gaps included.
    pub given: usize,
    /// Window the run was multiplied with.
    pub window: Window,
}

impl LinePsd {
    /// RMS in nm of the frequencies in a band: each entry counts whole, by its own frequency, as the
    /// density times the distance of the frequencies. Over all frequencies this is the RMS of the run
    /// about its mean, under the window.
    pub fn band_rms_nm(&self, band: &Band) -> f64 {
        let entries = self.density_nm2_mm.iter().enumerate();
        let inside = entries.filter(|(i, _)| band.contains(*i as f64 * self.step_per_mm));
        (inside.map(|(_, density)| density).sum::<f64>() * self.step_per_mm).sqrt()
    }
}

/// The power spectral density of a profile.
///
/// Gaps are not bridged: the longest run without one is used, of equal ones the first, and the result says
/// which. Its mean is subtracted; other terms are the caller's to remove. Density is
/// 2·|Σ w·z·exp(−2πi·fx)|²·spacing/Σ w², without the factor 2 at frequency 0 and at half the sampling
/// frequency. `O(n log n)`. Unknown if the longest run has fewer than 8 samples.
pub fn line_psd(line: &HeightLine<'_>, window: Window) -> Result<LinePsd, Unknown> {
    let HeightLine { heights_nm, spacing_mm } = *line;
    let (first, used) = longest_run(heights_nm);
    if used < LEAST_RUN {
        return Err(Unknown::ShortRun { longest: used, needed: LEAST_RUN });
    }
    let run = &heights_nm[first..first + used];
    let mean = run.iter().sum::<f64>() / used as f64;
    let windowed = run.iter().enumerate().map(|(i, height)| (height - mean) * window.at(i, used));
    let mut spectrum: Vec<Complex<f64>> = windowed.map(|value| Complex::new(value, 0.0)).collect();
    Fourier::new(used).transform(&mut spectrum);
    let power: f64 = (0..used).map(|i| window.at(i, used) * window.at(i, used)).sum();
    let density = |(i, value): (usize, &Complex<f64>)| {
        let sides = if i == 0 || 2 * i == used { 1.0 } else { 2.0 };
        sides * value.norm_sqr() * spacing_mm / power
    };
    Ok(LinePsd {
        step_per_mm: 1.0 / (used as f64 * spacing_mm),
        density_nm2_mm: spectrum[..=used / 2].iter().enumerate().map(density).collect(),
        first,
        used,
        given: heights_nm.len(),
        window,
    })
}

/// Begin and length of the longest run of finite numbers; of equal ones the first.
fn longest_run(values: &[f64]) -> (usize, usize) {
    let (mut best, mut begin) = ((0, 0), 0);
    for (i, value) in values.iter().enumerate() {
        if !value.is_finite() {
            begin = i + 1;
        } else if i + 1 - begin > best.1 {
            best = (begin, i + 1 - begin);
        }
    }
    best
}

/// Fewer samples have hardly a spectrum.
const LEAST_RUN: usize = 8;
