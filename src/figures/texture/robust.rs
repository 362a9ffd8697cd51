//! Weights that leave outliers out.

use super::TextureError;
use super::regression::FittedNode;

/// When the iteration of a robust filter ends.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Robust {
    tolerance: f64,
    most_iterations: usize,
}

impl Robust {
    /// Ends once the limit of outliers changes by less than the share `tolerance`, or after
    /// `most_iterations`. Fails unless the share lies between 0 and 1 and there is an iteration.
    pub fn new(tolerance: f64, most_iterations: usize) -> Result<Robust, TextureError> {
        if !(tolerance > 0.0 && tolerance < 1.0) {
            return Err(TextureError::Tolerance { value: tolerance });
        }
        if most_iterations == 0 {
            return Err(TextureError::Iterations);
        }
        Ok(Robust { tolerance, most_iterations })
    }
}

impl Default for Robust {
    /// A change below 1e-3, at most 100 iterations.
    fn default() -> Robust {
        Robust { tolerance: 1e-3, most_iterations: 100 }
    }
}

/// How a robust iteration went.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RobustReport {
    /// Fits after the first, linear one.
    pub iterations: usize,
    /// Whether the limit changed by less than the tolerance in the last.
    pub converged: bool,
    /// The last limit c_B = 4.4478·median|r| in nm: nodes farther from the long waves have no weight.
    pub limit_nm: f64,
    /// Measured nodes without weight in the last fit.
    pub outliers: usize,
}

/// The robust regression of ISO 16610-71:2014 (-31 for profiles): fits with the weights of the areas times
/// Tukey's biweight (1 − (r/c_B)²)², 0 beyond c_B, of the residuals r of the fit before, until
/// c_B = 4.4478·median|r| (three times the standard deviation if r is normal) stays the same.
///
/// The median is that of the area. If it is 0, more than half the area lies on the long waves exactly: then
/// what does not lie there has no weight, and the iteration ends.
pub(super) fn iterate(
    settings: Robust,
    heights_nm: &[Option<f64>],
    areas: &[f64],
    fit: impl Fn(&[f64]) -> Vec<FittedNode>,
) -> (Vec<FittedNode>, RobustReport) {
    let mut fitted = fit(areas);
    let mut report =
        RobustReport { iterations: 0, converged: false, limit_nm: f64::INFINITY, outliers: 0 };
    while report.iterations < settings.most_iterations && !report.converged {
        let residuals: Vec<Option<f64>> = heights_nm
            .iter()
            .zip(&fitted)
            .map(|(height, node)| {
                height.filter(|_| node.terms > 0).map(|z| (z - node.value_nm).abs())
            })
            .collect();
        let Some(median_nm) = median(&residuals, areas) else {
            report.converged = true;
            break;
        };
        let limit_nm = BIWEIGHT * median_nm;
        report.outliers = 0;
        let mut weights = vec![0.0; areas.len()];
        for (weight, (residual, area)) in weights.iter_mut().zip(residuals.iter().zip(areas)) {
            let Some(residual) = *residual else { continue };
            if residual == 0.0 {
                *weight = *area;
            } else if residual < limit_nm {
                let share = residual / limit_nm;
                *weight = area * (1.0 - share * share) * (1.0 - share * share);
            } else {
                report.outliers += 1;
            }
        }
        fitted = fit(&weights);
        report.iterations += 1;
        report.converged =
            limit_nm == 0.0 || (report.limit_nm - limit_nm).abs() < settings.tolerance * limit_nm;
        report.limit_nm = limit_nm;
    }
    (fitted, report)
}

/// The residual below which half the area lies, halfway between the two if one ends there; `None` if there
/// is none.
fn median(residuals: &[Option<f64>], areas: &[f64]) -> Option<f64> {
    let pairs = residuals.iter().zip(areas);
    let mut sorted: Vec<(f64, f64)> = pairs
        .filter_map(|(residual, &area)| Some((residual.filter(|_| area > 0.0)?, area)))
        .collect();
    sorted.sort_by(|a, b| a.0.total_cmp(&b.0));
    let total: f64 = sorted.iter().map(|(_, area)| area).sum();
    let mut below = 0.0;
    for (index, &(residual, area)) in sorted.iter().enumerate() {
        below += area;
        if 2.0 * below > total || index + 1 == sorted.len() {
            return Some(residual);
        }
        if 2.0 * below == total {
            return Some(0.5 * (residual + sorted[index + 1].0));
        }
    }
    None
}

/// Three times the factor 1.4826 between the median of |r| and the standard deviation of a normal r.
const BIWEIGHT: f64 = 4.4478;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_median_is_of_the_area() {
        let some = |values: &[f64]| values.iter().copied().map(Some).collect::<Vec<_>>();
        assert_eq!(median(&some(&[3.0, 1.0, 2.0]), &[1.0; 3]), Some(2.0));
        assert_eq!(median(&some(&[4.0, 1.0, 2.0, 3.0]), &[1.0; 4]), Some(2.5));
        assert_eq!(median(&some(&[1.0, 2.0, 9.0]), &[1.0, 1.0, 3.0]), Some(9.0));
        assert_eq!(median(&[None, Some(5.0)], &[1.0, 1.0]), Some(5.0));
        assert_eq!(median(&[None, Some(5.0)], &[1.0, 0.0]), None);
    }
}
