//! What the cells of the running map tell of the form: its cost depends on the cells, not on the points.

use asphera_figures::{FringeCount, Sample, SampleError, fringe_fit};
use asphera_form::{Aperture, Grid, Map, middle_mm};
use asphera_report::{HistogramFigures, Source, ZernikeFigures};

use super::details::{histogram_of, zernike};
use crate::Part;

/// Figures of a running report about the form beside fit, PV and RMS.
#[derive(Default)]
pub(super) struct CellDetails {
    /// Where these count from, beside the origin of the map.
    pub(super) origin_mm: [f64; 2],
    pub(super) zernike: Option<ZernikeFigures>,
    /// Why there are none; among [`unknown`](Self::unknown), too.
    pub(super) zernike_unknown: Option<String>,
    pub(super) histogram: Option<HistogramFigures>,
    /// Unknown figures, and why.
    pub(super) unknown: Vec<String>,
}

/// The running details of a map of this part.
pub(super) fn details(map: &Map, part: &Part) -> CellDetails {
    let origin_mm = origin_mm(map, part);
    let mut details = CellDetails { origin_mm, ..CellDetails::default() };
    let sample_of = |map: &Map| sample(map, &part.aperture, origin_mm);
    let samples = sample_of(map).and_then(|sample| Ok((sample, sample_of(&blocks(map))?)));
    let (sample, coarse) = match samples {
        Ok(samples) => samples,
        Err(error) => {
            details.unknown.push(format!("figures of the form: {error}"));
            return details;
        }
    };
    match fringe_fit(&coarse, FringeCount::ThirtySix) {
        Ok(fit) if fit.condition <= MOST_CONDITION => {
            details.zernike = Some(zernike(&fit, Source::Cells));
        }
        Ok(fit) => {
            details.zernike_unknown = Some(format!(
                "the places measured so far cannot separate them yet (condition {:.0}, at most {MOST_CONDITION} is allowed)",
                fit.condition
            ));
        }
        Err(why) => details.zernike_unknown = Some(why.to_string()),
    }
    let why = details.zernike_unknown.iter();
    details.unknown.extend(why.map(|why| format!("Zernike terms: {why}")));
    let counts = sample.indices().iter().map(|&cell| map.counts[cell] as u64);
    details.histogram = histogram_of(sample.values_nm(), counts, Source::Cells);
    details
}

/// The place of the map from which figures count: its origin, but where nothing else than the points says where their middle
/// is, that of those there are.
pub(super) fn origin_mm(map: &Map, part: &Part) -> [f64; 2] {
    let slides = if part.reference.is_some() { [true; 2] } else { part.nominal.slides() };
    let middle_mm = match part.aperture {
        Aperture::None if slides != [false; 2] => middle_mm(&map.centroids_mm).unwrap_or_default(),
        _ => [0.0; 2],
    };
    [0, 1].map(|axis| if slides[axis] { middle_mm[axis] } else { 0.0 })
}

/// The cells that hold points, at the mean place of these about the origin of figures, with as much weight as there are points.
pub(super) fn sample(
    map: &Map,
    aperture: &Aperture,
    [x_mm, y_mm]: [f64; 2],
) -> Result<Sample, SampleError> {
    let weights: Vec<f64> = map.counts.iter().map(|count| *count as f64).collect();
    // Points around a hole have their mean in it.
    let filled = aperture.filled();
    let about = |[x, y]: [f64; 2]| into(&filled, [x - x_mm, y - y_mm]);
    let places_mm: Vec<[f64; 2]> = map.centroids_mm.iter().copied().map(about).collect();
    let deviations_mm: Vec<f64> = map.mean_nm.iter().map(|nm| nm * 1e-6).collect();
    // What was drawn onto an outline lies on it to rounding.
    let is_outline = matches!(filled, Aperture::Outline { .. });
    let slack_mm = if is_outline { ROUNDING * filled.half_width_mm() } else { 0.0 };
    Sample::new(&places_mm, &deviations_mm, Some(&weights), &filled.widened(slack_mm))
}

/// A map of blocks of two by two cells.
///
/// 36 terms take four times as long from all cells, and gain little: blocks a 48th of the aperture wide lower the
/// finest of these terms by less than 3 %, and power by less than a thousandth.
fn blocks(map: &Map) -> Map {
    let (nx, ny) = (map.grid.nx.div_ceil(2), map.grid.ny.div_ceil(2));
    let mut coarse = Map {
        grid: Grid { nx, ny, ..map.grid },
        mean_nm: vec![0.0; nx * ny],
        counts: vec![0; nx * ny],
        centroids_mm: vec![[0.0; 2]; nx * ny],
    };
    for (cell, &count) in map.counts.iter().enumerate().filter(|(_, count)| **count > 0) {
        let block = cell / map.grid.nx / 2 * nx + cell % map.grid.nx / 2;
        let weight = count as f64;
        coarse.counts[block] += count;
        coarse.mean_nm[block] += weight * map.mean_nm[cell];
        for axis in 0..2 {
            coarse.centroids_mm[block][axis] += weight * map.centroids_mm[cell][axis];
        }
    }
    for (block, &count) in coarse.counts.iter().enumerate() {
        // Nothing over nothing is no number, as in the map itself.
        coarse.mean_nm[block] /= count as f64;
        coarse.centroids_mm[block] = coarse.centroids_mm[block].map(|sum| sum / count as f64);
    }
    coarse
}

/// The place itself, or the nearest on the outer border: points near it are in or out as an earlier pose had
/// it, some micrometres off.
fn into(aperture: &Aperture, [x, y]: [f64; 2]) -> [f64; 2] {
    match *aperture {
        Aperture::None => [x, y],
        Aperture::Circle { radius_mm } | Aperture::Annulus { outer_mm: radius_mm, .. } => {
            let out = x.hypot(y) / radius_mm;
            // The quotient may be rounded to just outside.
            if out > 1.0 { [x, y].map(|c| c / out * (1.0 - f64::EPSILON)) } else { [x, y] }
        }
        Aperture::Rectangle { width_mm, height_mm } => {
            [x.clamp(-0.5 * width_mm, 0.5 * width_mm), y.clamp(-0.5 * height_mm, 0.5 * height_mm)]
        }
        Aperture::Outline { ref outline, .. } if outline.contains([x, y]) => [x, y],
        Aperture::Outline { ref outline, .. } => outline.nearest_mm([x, y]),
    }
}

/// Share of its width by which a place drawn onto an outline may lie beside it.
const ROUNDING: f64 = 1e-12;
/// The noise of a coefficient is that of the cells, times this over the root of their number at worst: with some
/// thousand cells it does not exceed that of one cell.
const MOST_CONDITION: f64 = 100.0;
