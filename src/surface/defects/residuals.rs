//! Residuals along the normal, and what they tell of the noise: how large it is, where, and how far it goes.

use super::cells::{self, Cells};
use super::noise_field::{CellNoise, NoiseField};
use super::reference::Reference;
use super::tail::{self, Tail};
use crate::noise::Noise;

/// Residuals along the normal.
pub(super) struct Residuals {
    /// By vertex; NaN where not known.
    pub(super) normal_mm: Vec<f64>,
    /// By vertex the cell it lies in.
    pub(super) cell: Vec<u32>,
    /// Noise of half of the surface.
    pub(super) sigma_mm: f64,
    /// Noise by cell.
    pub(super) cell_mm: Vec<f64>,
}

impl Residuals {
    /// `points` is the number of vertices, or 0 where nothing but the noise is asked for.
    pub(super) fn new(
        cells: &Cells,
        reference: &Reference,
        points: usize,
        noise: Noise,
        field: &NoiseField,
    ) -> Residuals {
        let mut normal_mm = vec![f64::NAN; points];
        let mut cell_of = vec![cells::NONE; points];
        let mut sizes_mm = Vec::with_capacity(cells.all().len());
        let mut farthest_mm = 0.0_f64;
        let shapes: Vec<f64> =
            (0..cells.len()).map(|cell| field.at(cells.centre_mm(cell))).collect();
        for (cell, shape) in shapes.iter().enumerate() {
            let secant = reference.secants[cell];
            let residuals = &reference.residuals_mm[cells.range(cell)];
            for (&vertex, residual) in cells.members(cell).iter().zip(residuals) {
                let residual = residual / secant;
                if points > 0 {
                    normal_mm[vertex as usize] = residual;
                    cell_of[vertex as usize] = cell as u32;
                }
                if residual.is_finite() {
                    sizes_mm.push(residual.abs() / shape);
                }
            }
        }
        for cell in 0..cells.len() {
            farthest_mm = farthest_mm.max(cells.moments[cell].height_mm.abs());
        }
        let rounding_mm = ROUNDING * farthest_mm.max(f64::MIN_POSITIVE / f64::EPSILON);
        let spread_mm = tail::scale(&mut sizes_mm).unwrap_or(0.0);
        let sigma_mm = spread_mm.max(noise.sigma_mm());
        let cell_mm = shapes.iter().map(|shape| (shape * sigma_mm).max(rounding_mm)).collect();
        Residuals { normal_mm, cell: cell_of, sigma_mm: sigma_mm.max(rounding_mm), cell_mm }
    }
}

/// The residuals of the samples of a cell from their mean, in units of what they are expected to be of samples that
/// differ by 1.
fn within<'a>(
    cells: &Cells,
    reference: &'a Reference,
    cell: usize,
) -> Option<impl Iterator<Item = f64> + 'a> {
    let residuals = &reference.residuals_mm[cells.range(cell)];
    let count = residuals.len() as f64;
    let mean = residuals.iter().sum::<f64>() / count;
    let unit = reference.secants[cell] * (1.0 - count.recip()).sqrt();
    (count >= WITHIN && mean.is_finite())
        .then(|| residuals.iter().map(move |residual| (residual - mean) / unit))
}

/// How the noise differs by place.
pub(super) fn noise_field(cells: &Cells, reference: &Reference) -> NoiseField {
    let of = |cell: usize| {
        let (sum, count) = within(cells, reference, cell)?
            .fold((0.0, 0.0), |(sum, count), size| (sum + size * size, count + 1.0));
        Some(CellNoise { place_mm: cells.centre_mm(cell), variance: sum / count })
    };
    let all = (0..cells.len()).filter_map(of);
    NoiseField::of(all, cells.low_mm, cells.extent_mm, cells.side_mm)
}

/// How far the noise goes.
pub(super) fn tail_of(cells: &Cells, reference: &Reference, cell_mm: &[f64]) -> Tail {
    let mut pieces = tail::pieces();
    for (cell, noise_mm) in cell_mm.iter().enumerate() {
        if let Some(sizes) = within(cells, reference, cell) {
            let piece = tail::piece_of(cells.places[cell].map(|at| at as usize), cells.size);
            pieces[piece].extend(sizes.map(|size| size.abs() / noise_mm));
        }
    }
    Tail::of_cells(pieces)
}

/// Fewest samples of a cell that tell how they differ.
const WITHIN: f64 = 3.0;
/// What rounding makes of heights, over the largest of them.
const ROUNDING: f64 = 16.0 * f64::EPSILON;
