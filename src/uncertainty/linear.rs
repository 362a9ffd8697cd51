//! A least-squares fit as a linear answer to errors of its points.
//!
//! With J the derivatives of the distances, W the weights and G = (JᵀWJ)⁻¹·JᵀW, errors v of the distances move
//! the parameters by −G·v and the residuals by v − J·G·v. A covariance U of the distances becomes G·U·Gᵀ for the
//! parameters, whatever U is (Forbes, Metrologia 43 (2006) S282, and JCGM 102:2011, 6.2).
//!
//! The answer of a robust fit is that of its last round: W has the weights ψ(e)/e of the loss in it, so what the
//! loss leaves out has no influence. Noise changes these weights, which smooth errors hardly do; by how much the
//! variance is larger for that, [`Linear::noise_factor`] says. Gross outliers are no noise: each pulls as hard as the loss
//! lets it, one way or the other (Huber & Ronchetti, Robust Statistics, 2nd ed., 7.6).

use super::budget::UncertaintyError;
use asphera_form::linear::{Model, Selection, System, Triangle, Weights};
use asphera_form::{Aperture, Fit, FitError, Parameter, PointMm};

/// The points of a fit with their derivatives.
#[derive(Clone, Debug)]
pub(super) struct Linear {
    pub(super) parameters: Vec<Parameter>,
    /// Indices of the points used among those given.
    pub(super) indices: Vec<usize>,
    /// Measured frame.
    pub(super) points: Vec<PointMm>,
    /// x and y in the part frame.
    pub(super) places_mm: Vec<[f64; 2]>,
    /// Normals at the feet, measured frame.
    pub(super) normals: Vec<[f64; 3]>,
    pub(super) distances_mm: Vec<f64>,
    /// Weight of each distance in the sum of squares, that of a robust loss included.
    pub(super) weights: Vec<f64>,
    /// What the variance of the parameters by independent noise is multiplied by: 1 for least squares.
    pub(super) noise_factor: f64,
    /// Places of the points a robust loss holds against the others as outliers.
    pub(super) outliers: Vec<usize>,
    /// What the square of their pull is multiplied by: see [`crate::Loss`].
    pull_factor: f64,
    /// Rows of J, one after the other.
    rows: Vec<f64>,
    /// Columns of G, one after the other.
    gains: Vec<f64>,
}

impl Linear {
    /// `uncertainties_mm` are those of [`asphera_form::fit_weighted`], if the fit had weights. `O(n·p²)`.
    pub(super) fn new(
        points: &[PointMm],
        fit: &Fit,
        aperture: &Aperture,
        uncertainties_mm: Option<&[f64]>,
    ) -> Result<Linear, UncertaintyError> {
        let weights = Linear::roots(uncertainties_mm, points.len())?;
        let roots = weights.as_ref().map(|weights| weights.roots.as_slice());
        let selection = Selection::new(points, roots, &fit.nominal, &fit.pose, aperture);
        let used = selection.points.len();
        if used != fit.used {
            return Err(UncertaintyError::OtherPoints { found: used, used: fit.used });
        }
        Linear::of(selection, fit)
    }

    /// The weights of a fit with uncertainties of the points.
    pub(super) fn roots(
        uncertainties_mm: Option<&[f64]>,
        points: usize,
    ) -> Result<Option<Weights>, UncertaintyError> {
        let weights = uncertainties_mm.map(|u_mm| Weights::new(u_mm, points)).transpose();
        weights.map_err(|error| match error {
            FitError::Uncertainty { found_mm: found, .. } => {
                let name = "standard uncertainty of a weight in mm";
                UncertaintyError::Number { name, found, expected: "a number above 0" }
            }
            _ => {
                let found = uncertainties_mm.map_or(0, <[f64]>::len);
                UncertaintyError::Lengths { points, found }
            }
        })
    }

    /// Of points that count, some of those of the fit or all. `O(n·p²)`.
    pub(super) fn of(selection: Selection, fit: &Fit) -> Result<Linear, UncertaintyError> {
        let parameters: Vec<Parameter> =
            fit.estimates.iter().map(|estimate| estimate.parameter).collect();
        let (p, used) = (parameters.len(), selection.points.len());
        let indices = selection.indices();
        let mut linear = Linear {
            indices,
            places_mm: Vec::with_capacity(used),
            normals: Vec::with_capacity(used),
            distances_mm: Vec::with_capacity(used),
            weights: Vec::with_capacity(used),
            noise_factor: fit.robust.map_or(1.0, |robust| robust.loss.noise_factor()),
            outliers: Vec::new(),
            pull_factor: fit.robust.map_or(1.0, |robust| robust.loss.pull_factor()),
            rows: Vec::with_capacity(used * p),
            gains: Vec::with_capacity(used * p),
            points: selection.points,
            parameters,
        };
        let model = Model::new(&fit.nominal, &fit.pose, &linear.parameters);
        let mut row = vec![0.0; p + 1];
        let mut triangle = Triangle::new(p + 1);
        for (place, &point) in linear.points.iter().enumerate() {
            let other = UncertaintyError::OtherPoints { found: place, used };
            let Some(normal) = model.row_and_normal(point, &mut row) else { return Err(other) };
            let [x, y, _] = model.to_part(point);
            linear.places_mm.push([x, y]);
            linear.normals.push(normal);
            linear.distances_mm.push(row[p]);
            linear.rows.extend_from_slice(&row[..p]);
            let root = selection.roots.as_ref().map_or(1.0, |roots| roots[place]);
            let of_loss = fit.robust.map_or(1.0, |robust| {
                let e = root * row[p] / robust.scale_mm;
                if e.abs() > OUTLIER {
                    linear.outliers.push(place);
                }
                robust.loss.weight(e)
            });
            let weight = root * root * of_loss;
            row.iter_mut().for_each(|entry| *entry *= weight.sqrt());
            triangle.push(&row);
            linear.weights.push(weight);
        }
        triangle.flush();
        let step = System::new(&triangle).solve_along(&fit.freedoms, 0.0);
        for place in 0..used {
            let weight = linear.weights[place];
            let gain = step.undo_gram(&linear.rows[place * p..][..p]);
            linear.gains.extend(gain.iter().map(|entry| entry * weight));
        }
        Ok(linear)
    }

    /// Points used.
    pub(super) fn len(&self) -> usize {
        self.points.len()
    }

    /// Derivatives of the distance of one point by the parameters.
    pub(super) fn row(&self, place: usize) -> &[f64] {
        let p = self.parameters.len();
        &self.rows[place * p..][..p]
    }

    /// Covariance of the parameters by the outliers, row after row: each pulls by itself, and as well the other way.
    pub(super) fn by_outliers(&self) -> Vec<f64> {
        let p = self.parameters.len();
        let mut covariance = vec![0.0; p * p];
        for &place in &self.outliers {
            let gain = self.gain(place);
            let square_mm2 = self.pull_factor * self.distances_mm[place].powi(2);
            for (i, row) in covariance.chunks_exact_mut(p.max(1)).enumerate() {
                row.iter_mut().zip(gain).for_each(|(sum, g)| *sum += square_mm2 * gain[i] * g);
            }
        }
        covariance
    }

    /// What an error of one distance by 1 mm takes off the parameters.
    pub(super) fn gain(&self, place: usize) -> &[f64] {
        let p = self.parameters.len();
        &self.gains[place * p..][..p]
    }
}

/// Deviations of more scales than this are no noise: of normal ones one in two million.
const OUTLIER: f64 = 5.0;

/// Σ a·b.
pub(super) fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}
