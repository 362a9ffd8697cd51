//! The form deviation with Zernike terms taken out, for those who look at it.
//!
//! Nothing here reaches the verdict: that is of the deviation as fitted.

use asphera_figures::{
    Reference, Removed, Sample, SampleError, Unknown, peak_to_valley, remove, rms,
};
use asphera_form::{Aperture, Grid, Map as CellMap};
use asphera_report::{FORM_VIEW_FORMAT, FormView, Map, RemovedTerm, Source, Term};
use thiserror::Error;

use super::cells;
use super::details::histogram_of;
use super::figures::map_of;

/// Why terms cannot be taken out.
#[derive(Clone, Debug, Error, PartialEq)]
pub(super) enum RemovalError {
    /// The deviation makes no sample.
    #[error(transparent)]
    Sample(#[from] SampleError),
    /// The places do not tell.
    #[error(transparent)]
    Unknown(#[from] Unknown),
}

/// The deviation of the running map without `terms`, which count from a place of it; `used` points are in the fit.
pub(super) fn of_cells(
    (map, origin_mm): (&CellMap, [f64; 2]),
    aperture: &Aperture,
    used: u64,
    terms: &[Term],
) -> Result<FormView, RemovalError> {
    let removed = remove(&cells::sample(map, aperture, origin_mm)?, &kernels(terms))?;
    let sample = &removed.sample;
    let mut left_nm = vec![f64::NAN; map.mean_nm.len()];
    for (&cell, &nm) in sample.indices().iter().zip(sample.values_nm()) {
        left_nm[cell] = nm;
    }
    let counts = sample.indices().iter().map(|&cell| map.counts[cell] as u64);
    view(&removed, &map.grid, &left_nm, counts, Source::Cells, used)
}

/// The final deviation of a sample of points without `terms`, mapped over the cells of `grid`. `O(n)`.
pub(super) fn of_points(
    sample: &Sample,
    grid: &Grid,
    terms: &[Term],
) -> Result<FormView, RemovalError> {
    let removed = remove(sample, &kernels(terms))?;
    let sample = &removed.sample;
    let left_nm = means(grid, sample);
    let counts = sample.values_nm().iter().map(|_| 1);
    view(&removed, grid, &left_nm, counts, Source::Points, sample.len() as u64)
}

/// The terms as the kernel names them.
fn kernels(terms: &[Term]) -> Vec<asphera_figures::Term> {
    let kernel = |term: &Term| match term {
        Term::Piston => asphera_figures::Term::Piston,
        Term::Tilt => asphera_figures::Term::Tilt,
        Term::Power => asphera_figures::Term::Power,
        Term::Astigmatism => asphera_figures::Term::Astigmatism,
        Term::Coma => asphera_figures::Term::Coma,
        Term::Spherical => asphera_figures::Term::Spherical,
    };
    terms.iter().map(kernel).collect()
}

fn view(
    removed: &Removed,
    grid: &Grid,
    left_nm: &[f64],
    counts: impl Iterator<Item = u64>,
    source: Source,
    as_of_points: u64,
) -> Result<FormView, RemovalError> {
    let sample = &removed.sample;
    let term =
        |&(index, value_nm): &(u8, Option<f64>)| RemovedTerm { index: index.into(), value_nm };
    Ok(FormView {
        format: FORM_VIEW_FORMAT,
        source,
        as_of_points,
        provisional: source == Source::Cells,
        removed: removed.terms.iter().map(ToString::to_string).collect(),
        terms: removed.coefficients_nm.iter().map(term).collect(),
        pv_nm: peak_to_valley(sample)?.value,
        rms_nm: rms(sample, Reference::Zero)?.value,
        map: map_of(grid, left_nm),
        histogram: histogram_of(sample.values_nm(), counts, source).ok_or(Unknown::NoPoints)?,
    })
}

/// The final deviation of a sample of points over the cells of `grid`: their means. `O(n)`.
pub(super) fn cells_of(sample: &Sample, grid: &Grid) -> Map {
    map_of(grid, &means(grid, sample))
}

/// Mean over the points of each cell; NaN without one.
fn means(grid: &Grid, sample: &Sample) -> Vec<f64> {
    let mut sums = vec![(0.0, 0_u64); grid.nx * grid.ny];
    for (&[x, y], nm) in sample.places_mm().iter().zip(sample.values_nm()) {
        let column = share(x, grid.x_min_mm, grid.x_max_mm).map(|u| (u * grid.nx as f64) as usize);
        let row = share(y, grid.y_min_mm, grid.y_max_mm).map(|v| (v * grid.ny as f64) as usize);
        if let Some((column, row)) = column.zip(row) {
            let (sum, count) = &mut sums[row.min(grid.ny - 1) * grid.nx + column.min(grid.nx - 1)];
            *sum += nm;
            *count += 1;
        }
    }
    sums.into_iter().map(|(sum, count)| sum / count as f64).collect()
}

fn share(value: f64, low: f64, high: f64) -> Option<f64> {
    let share = (value - low) / (high - low);
    (0.0..=1.0).contains(&share).then_some(share)
}

#[cfg(test)]
mod tests;
