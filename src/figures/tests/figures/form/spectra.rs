//! Power spectral densities.

use std::f64::consts::TAU;
use std::num::NonZeroU16;

use asphera_figures::{
    Band, HeightGrid, HeightLine, SettingError, Unknown, Window, azimuthal_profile, line_psd,
    map_psd,
};

use super::disc;
use crate::common::Noise;

fn wave(count: usize, periods: f64) -> Vec<f64> {
    (0..count).map(|i| 7.0 + 20.0 * (TAU * periods * i as f64 / count as f64 + 0.3).cos()).collect()
}

fn everything() -> Band {
    Band::of_frequencies(None, None).unwrap()
}

#[test]
fn a_wave_has_half_its_square_at_its_frequency() {
    // 100 samples at 0.05 mm, 8 periods: 1.6 cycles per mm at entry 8, step 0.2.
    let heights = wave(100, 8.0);
    let found = line_psd(&HeightLine::new(&heights, 0.05).unwrap(), Window::None).unwrap();
    assert!((found.step_per_mm - 0.2).abs() < 1e-15);
    assert_eq!((found.first, found.used, found.density_nm2_mm.len()), (0, 100, 51));
    for (i, density) in found.density_nm2_mm.iter().enumerate() {
        let expected = if i == 8 { 200.0 / 0.2 } else { 0.0 };
        assert!((density - expected).abs() < 1e-9, "{i}: {density}");
    }
    let rms = |band: Result<Band, SettingError>| found.band_rms_nm(&band.unwrap());
    let whole = 200.0_f64.sqrt();
    assert!((rms(Band::of_frequencies(None, None)) - whole).abs() < 1e-9);
    // One limit is one limit: 1.6 cycles per mm is a period of 0.625 mm.
    assert!((rms(Band::of_frequencies(Some(1.5), None)) - whole).abs() < 1e-9);
    assert!(rms(Band::of_frequencies(None, Some(1.5))) < 1e-6);
    assert!((rms(Band::of_periods(None, Some(0.7))) - whole).abs() < 1e-9);
    assert!(rms(Band::of_periods(None, Some(0.6))) < 1e-6);
    assert!((rms(Band::of_periods(Some(0.6), None)) - whole).abs() < 1e-9);
    assert!(rms(Band::of_periods(Some(0.7), None)) < 1e-6);
    assert!((rms(Band::of_periods(Some(0.6), Some(0.7))) - whole).abs() < 1e-9);
}

#[test]
fn squares_add_up_and_bands_share_nothing() {
    let mut noise = Noise::new(3);
    for count in [8, 9, 64, 100, 257, 1000] {
        let heights: Vec<f64> = (0..count).map(|_| 50.0 + 10.0 * noise.next()).collect();
        let line = HeightLine::new(&heights, 0.02).unwrap();
        let found = line_psd(&line, Window::None).unwrap();
        let mean = heights.iter().sum::<f64>() / count as f64;
        let square = heights.iter().map(|z| (z - mean).powi(2)).sum::<f64>() / count as f64;
        let all = found.band_rms_nm(&everything());
        assert!((all - square.sqrt()).abs() < 1e-10, "{count}");
        let edge = 3.0 * found.step_per_mm;
        let low = found.band_rms_nm(&Band::of_frequencies(None, Some(edge)).unwrap());
        let high = found.band_rms_nm(&Band::of_frequencies(Some(edge), None).unwrap());
        assert!((low.hypot(high) - all).abs() < 1e-10, "{count}");
        // Hann changes the weights, not the level of noise.
        let hann = line_psd(&line, Window::Hann).unwrap().band_rms_nm(&everything());
        assert!(count < 256 || (hann / all - 1.0).abs() < 0.1, "{count}: {hann} {all}");
    }
}

#[test]
fn the_longest_run_is_used_and_named() {
    let mut heights = wave(100, 10.0);
    heights[15] = f64::NAN;
    heights[96] = f64::NAN;
    let found = line_psd(&HeightLine::new(&heights, 0.1).unwrap(), Window::None).unwrap();
    assert_eq!((found.first, found.used, found.given), (16, 80, 100));
    let density = found.density_nm2_mm;
    assert!((density[8] * found.step_per_mm - 200.0).abs() < 1e-9);
    for i in (0..100).step_by(8) {
        heights[i] = f64::NAN;
    }
    let found = line_psd(&HeightLine::new(&heights, 0.1).unwrap(), Window::None);
    assert_eq!(found, Err(Unknown::ShortRun { longest: 7, needed: 8 }));
    let found = line_psd(&HeightLine::new(&[], 0.1).unwrap(), Window::None);
    assert_eq!(found, Err(Unknown::ShortRun { longest: 0, needed: 8 }));
}

#[test]
fn spectrum_of_an_azimuthal_profile_counts_the_undulations() {
    let sample = disc(100_000, |x, y| 10.0 * (5.0 * y.atan2(x)).cos());
    let sectors =
        azimuthal_profile(&sample, NonZeroU16::new(360).unwrap(), Some([3.0, 5.0])).unwrap();
    let heights: Vec<f64> =
        sectors.iter().map(|s| s.heights.map_or(f64::NAN, |heights| heights.mean_nm)).collect();
    let found =
        line_psd(&HeightLine::new(&heights, TAU * 4.0 / 360.0).unwrap(), Window::None).unwrap();
    // Means over a sector keep sin(5π/360)/(5π/360) of the wave.
    let half = 5.0 * std::f64::consts::PI / 360.0;
    let expected = 50.0 * (half.sin() / half).powi(2);
    let power = found.density_nm2_mm[5] * found.step_per_mm;
    assert!((power / expected - 1.0).abs() < 1e-3, "{power} {expected}");
    let rest = found.band_rms_nm(&everything()).powi(2) - power;
    assert!(rest < 0.05, "{rest}");
}

#[test]
fn a_wave_over_a_map_lies_at_its_frequency() {
    // 60 columns at 0.1 mm, 48 rows at 0.125 mm: 6 mm either way, 3 and 4 periods: 5/6 cycles per mm.
    let (rows, columns) = (48, 60);
    let heights: Vec<f64> = (0..rows * columns)
        .map(|i| {
            let (row, column) = ((i / columns) as f64, (i % columns) as f64);
            5.0 + 8.0 * (TAU * (3.0 * column / 60.0 + 4.0 * row / 48.0)).sin()
        })
        .collect();
    let grid = HeightGrid::new(&heights, rows, columns, [0.1, 0.125]).unwrap();
    let found = map_psd(&grid, Window::None).unwrap();
    assert_eq!(found.measured, 1.0);
    let cell = found.step_per_mm[0] * found.step_per_mm[1];
    for (i, density) in found.density_nm2_mm2.iter().enumerate() {
        let hit = [4 * columns + 3, (rows - 4) * columns + columns - 3].contains(&i);
        let expected = if hit { 16.0 / cell } else { 0.0 };
        assert!((density - expected).abs() < 1e-9 * 16.0 / cell, "{i}: {density}");
    }
    assert!((found.band_rms_nm(&everything()) - 32.0_f64.sqrt()).abs() < 1e-9);
    let band = Band::of_periods(Some(1.1), Some(1.3)).unwrap();
    assert!((found.band_rms_nm(&band) - 32.0_f64.sqrt()).abs() < 1e-9);
    let rings = found.rings();
    let most = rings.iter().max_by(|a, b| a.density_nm2_mm2.total_cmp(&b.density_nm2_mm2)).unwrap();
    assert!((most.frequency_per_mm - 5.0 / 6.0).abs() < 1e-12, "{most:?}");
    assert!((most.density_nm2_mm2 * most.count as f64 * cell - 32.0).abs() < 1e-9);
}

#[test]
fn gaps_of_a_map_neither_add_nor_take_power() {
    let mut noise = Noise::new(11);
    let (rows, columns) = (100, 90);
    let mut heights: Vec<f64> = (0..rows * columns).map(|_| 1e5 + 30.0 * noise.next()).collect();
    let spacing = [0.05, 0.05];
    let full = |heights: &[f64], window| {
        map_psd(&HeightGrid::new(heights, rows, columns, spacing).unwrap(), window).unwrap()
    };
    let whole = full(&heights, Window::None);
    for (i, height) in heights.iter_mut().enumerate() {
        let (row, column) = (i / columns, i % columns);
        if (row as f64 - 50.0).hypot(column as f64 - 45.0) > 44.0 || row == 30 {
            *height = f64::NAN;
        }
    }
    let holed = full(&heights, Window::None);
    assert!(holed.measured > 0.6 && holed.measured < 0.7, "{}", holed.measured);
    let kept = || heights.iter().copied().filter(|height| height.is_finite());
    let mean = kept().sum::<f64>() / kept().count() as f64;
    let rms = (kept().map(|z| (z - mean).powi(2)).sum::<f64>() / kept().count() as f64).sqrt();
    assert!((holed.band_rms_nm(&everything()) - rms).abs() < 1e-9);
    // White noise of variance σ² has the density σ²·dx·dy everywhere: 300 nm² · 0.0025 mm².
    for (map, tolerance) in [(whole, 0.05), (holed, 0.08), (full(&heights, Window::Hann), 0.15)] {
        let rings = map.rings();
        let outer = &rings[rings.len() / 3..];
        let sum: f64 = outer.iter().map(|ring| ring.density_nm2_mm2 * ring.count as f64).sum();
        let level = sum / outer.iter().map(|ring| ring.count).sum::<usize>() as f64;
        assert!((level / 0.75 - 1.0).abs() < tolerance, "{level}");
    }
}

#[test]
fn settings_that_make_no_sense_are_refused() {
    assert!(matches!(Band::of_frequencies(Some(2.0), Some(2.0)), Err(SettingError::Band { .. })));
    assert!(Band::of_frequencies(Some(-1.0), None).is_err());
    assert!(Band::of_frequencies(Some(f64::NAN), None).is_err());
    assert!(Band::of_periods(Some(0.0), None).is_err());
    assert!(Band::of_periods(Some(2.0), Some(1.0)).is_err());
    assert!(HeightLine::new(&[1.0], -0.1).is_err());
    let error = HeightGrid::new(&[1.0; 5], 2, 3, [1.0; 2]).unwrap_err();
    assert_eq!(error.to_string(), "a grid of 2 rows and 3 columns, but 5 heights");
    assert!(HeightGrid::new(&[1.0; 6], 2, 3, [1.0, f64::NAN]).is_err());
    let few = HeightGrid::new(&[1.0; 6], 2, 3, [1.0; 2]).unwrap();
    let found = map_psd(&few, Window::None);
    assert_eq!(found, Err(Unknown::TooFewPoints { used: 6, needed: 64 }));
    let empty = HeightGrid::new(&[], 0, 7, [1.0; 2]).unwrap();
    assert!(map_psd(&empty, Window::None).is_err());
}
