//! A descriptor of a cloud: how far its points lie apart, and how it vibrates.

use crate::cloud::Cloud;
use crate::functions::{FunctionError, eigenfunctions};

/// Whether sizes count.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Size {
    /// In mm: a part of twice the size is another part.
    #[default]
    Counts,
    /// Shapes alone.
    Free,
}

/// Figures of a cloud that are compared.
#[derive(Clone, Debug, PartialEq)]
pub struct ShapeDescriptor {
    /// Quantiles of the distances of pairs of places in mm, over their mean where sizes are free (D2 of R. Osada and others, ACM
    /// Transactions on Graphics 21 (2002) 807-832).
    quantiles: Vec<f64>,
    /// Logarithms of the eigenvalues of the Laplacian over the first one; none of a cloud in pieces.
    tones: Vec<f64>,
    size: Size,
}

/// The descriptor of a cloud. The distances are those of 100,000 pairs that the order of places fixes; the eigenvalues are those
/// of at most [`MOST_PLACES`] places. So it takes some seconds for any number of points.
///
/// # Errors
///
/// Fewer than eight places.
pub fn shape_descriptor<const D: usize>(
    cloud: &Cloud<D>,
    size: Size,
) -> Result<ShapeDescriptor, FunctionError> {
    if cloud.len() < LEAST {
        return Err(FunctionError::NoPoints);
    }
    let mut distances_mm = pairs(cloud);
    distances_mm.sort_unstable_by(f64::total_cmp);
    let unit = match size {
        Size::Counts => 1.0,
        Size::Free => distances_mm.iter().sum::<f64>() / distances_mm.len() as f64,
    };
    let last = distances_mm.len() - 1;
    let quantile = |at: usize| distances_mm[at * last / QUANTILES] / unit;
    let quantiles = (1..=QUANTILES).map(quantile).collect();
    let tones = match tones(cloud) {
        Ok(tones) => tones,
        // Pieces vibrate for themselves: the distances alone tell then.
        Err(FunctionError::Pieces { .. } | FunctionError::Unsolved { .. }) => Vec::new(),
        Err(error) => return Err(error),
    };
    Ok(ShapeDescriptor { quantiles, tones, size })
}

impl ShapeDescriptor {
    /// How far two descriptors lie apart: the mean difference of quantiles as a share of their mean, and half the mean difference
    /// of the logarithms of tones. 0 of equal ones; symmetric. Where one has no tones, the other's do not count.
    pub fn distance(&self, other: &ShapeDescriptor) -> f64 {
        let mean = |values: &[f64]| values.iter().sum::<f64>() / values.len() as f64;
        let apart: Vec<f64> =
            self.quantiles.iter().zip(&other.quantiles).map(|(a, b)| (a - b).abs()).collect();
        let scale = f64::midpoint(mean(&self.quantiles), mean(&other.quantiles));
        let of_distances = if scale > 0.0 { mean(&apart) / scale } else { 0.0 };
        let tones: Vec<f64> =
            self.tones.iter().zip(&other.tones).map(|(a, b)| (a - b).abs()).collect();
        let of_tones = if tones.is_empty() { 0.0 } else { mean(&tones) };
        of_distances + WEIGHT_OF_TONES * of_tones
    }

    /// Whether sizes count.
    pub fn size(&self) -> Size {
        self.size
    }
}

/// Distances of pairs. Steps by the golden ratio and by √2 lead from place to place.
fn pairs<const D: usize>(cloud: &Cloud<D>) -> Vec<f64> {
    let places = cloud.places();
    let count = places.len() as f64;
    let at = |pair: usize, step: f64| &places[((pair as f64 * step).fract() * count) as usize];
    let distance = |pair: usize| {
        let (a, b) = (at(pair, GOLDEN), at(pair, std::f64::consts::SQRT_2));
        crate::tree::squared_distance(a, b).sqrt()
    };
    (1..=PAIRS).map(distance).collect()
}

fn tones<const D: usize>(cloud: &Cloud<D>) -> Result<Vec<f64>, FunctionError> {
    let step = cloud.len().div_ceil(MOST_PLACES);
    let some: Vec<[f64; D]> = cloud.places().iter().copied().step_by(step).collect();
    let some = Cloud::new(&some)?;
    let count = TONES.min(some.len() / 4);
    let found = eigenfunctions(&some, &some.nearest(NEIGHBOURS)?, count)?;
    let first = found.eigenvalues[0];
    Ok(found.eigenvalues[1..].iter().map(|value| (value / first).ln()).collect())
}

/// Places whose vibrations are worked out, at most.
pub const MOST_PLACES: usize = 5_000;
/// Places of a shape, at least.
const LEAST: usize = 8;
const PAIRS: usize = 100_000;
const QUANTILES: usize = 64;
const TONES: usize = 12;
const NEIGHBOURS: usize = 12;
const WEIGHT_OF_TONES: f64 = 0.5;
const GOLDEN: f64 = 0.618_033_988_749_894_9;
