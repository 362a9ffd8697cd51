//! What a fit knows of its parameters together: covariances, correlations, weak combinations.

use std::fmt;

use crate::fit::freedoms::Held;
use crate::fit::motion::words;
use crate::fit::solve::System;
use crate::{Nominal, Parameter, Pose};

/// Covariances of the estimates of a fit, in their order.
#[derive(Clone, Debug, PartialEq)]
pub struct Covariance {
    size: usize,
    /// Column after column.
    entries: Vec<f64>,
}

impl Covariance {
    /// σ²·(JᵀJ)⁻¹ from the inverse Gram matrix, column after column, and σ in mm.
    pub fn new(size: usize, inverse_gram: &[f64], sigma_mm: f64) -> Covariance {
        let entries = inverse_gram.iter().map(|entry| sigma_mm * sigma_mm * entry).collect();
        Covariance { size, entries }
    }

    /// Number of parameters.
    pub fn size(&self) -> usize {
        self.size
    }

    /// Covariance of two estimates in the product of their units; `None` unless both exist.
    pub fn entry(&self, row: usize, column: usize) -> Option<f64> {
        let inside = row < self.size && column < self.size;
        inside.then(|| self.entries[column * self.size + row])
    }

    /// Correlation of two estimates, −1 to 1; `None` unless both exist and vary.
    pub fn correlation(&self, row: usize, column: usize) -> Option<f64> {
        let variances = self.entry(row, row)? * self.entry(column, column)?;
        let correlation = self.entry(row, column)? / variances.sqrt();
        correlation.is_finite().then(|| correlation.clamp(-1.0, 1.0))
    }

    /// The two estimates that are correlated most, with their correlation; `None` with fewer than two.
    pub fn worst_pair(&self) -> Option<(usize, usize, f64)> {
        let pairs = (0..self.size).flat_map(|b| (0..b).map(move |a| (a, b)));
        let known = pairs.filter_map(|(a, b)| Some((a, b, self.correlation(a, b)?)));
        known.reduce(|worst, pair| if pair.2.abs() > worst.2.abs() { pair } else { worst })
    }
}

/// A combination of parameters, as a direction: each in units of what moves the surface at the points by
/// the same root mean square.
///
/// Written as `0.71·tx + 0.70·ry`.
#[derive(Clone, Debug, PartialEq)]
pub struct Combination {
    /// Parameters with their share, the largest first; shares below a twentieth are left out. The squares
    /// of all add up to 1.
    pub terms: Vec<(Parameter, f64)>,
    /// Their names.
    pub names: Vec<String>,
    /// How far this combination moves the surface at the points, as a share of what the strongest
    /// combination of the same size does: the ratio of the singular values.
    pub ratio: f64,
}

impl Combination {
    pub(crate) fn new(
        parameters: impl IntoIterator<Item = Parameter>,
        shares: &[f64],
        ratio: f64,
        nominal: &Nominal,
    ) -> Combination {
        let mut terms: Vec<(Parameter, f64)> =
            parameters.into_iter().zip(shares.iter().copied()).collect();
        // Shares that differ by rounding alone must not change places.
        let size = |share: f64| (share.abs() / SAME_SHARE).round();
        terms.sort_by(|a, b| size(b.1).total_cmp(&size(a.1)).then(a.0.cmp(&b.0)));
        // The sign of a direction is free: the largest share is positive.
        let sign = terms.first().map_or(1.0, |(_, share)| share.signum());
        terms.iter_mut().for_each(|(_, share)| *share *= sign);
        terms.retain(|(_, share)| share.abs() >= LEAST_SHARE);
        let names = terms.iter().map(|(parameter, _)| parameter.name(nominal)).collect();
        Combination { terms, names, ratio }
    }
}

impl fmt::Display for Combination {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (index, ((_, share), name)) in self.terms.iter().zip(&self.names).enumerate() {
            let sign = match (index, *share < 0.0) {
                (0, _) => "",
                (_, true) => " - ",
                (_, false) => " + ",
            };
            write!(f, "{sign}{:.2}·{name}", share.abs())?;
        }
        Ok(())
    }
}

/// Something that points do not tell, and that stayed at its start: a free parameter, or a combination of motions.
#[derive(Clone, Debug, PartialEq)]
pub struct Undetermined {
    /// The parameter, or the one that leads the combination.
    pub parameter: Parameter,
    /// Whether no points on this nominal could determine it beside the others: a cylinder does not feel a
    /// turn about its axis. Otherwise points elsewhere could.
    pub by_shape: bool,
    /// Whether a combination was held, of which the other parameters have their parts: then all of them were estimated.
    pub is_combined: bool,
    /// The combination with the estimated parameters that the points do not feel.
    pub combination: Combination,
    /// What stayed at its start: the parameter's name, or of a combination the motion, "turn about the parent's axis".
    pub what: String,
    /// In a sentence: "the turn about the parent's axis cannot be found from these points: held at its start".
    pub text: String,
}

/// What the points do not feel, in words. `by_shape` says how many of each group of `order` no points on the nominal feel.
pub(crate) fn undetermined(
    system: &System,
    held: &[Held],
    free: &[Parameter],
    (nominal, pose): (&Nominal, &Pose),
    by_shape: &[usize],
) -> Vec<Undetermined> {
    let of_one = |held: &Held| {
        let (shares, ratio) = system.combination(&held.against, held.left);
        let parameters = held.against.iter().copied().chain([held.left]).map(|index| free[index]);
        let (what, text) = words(held, free, nominal, pose);
        Undetermined {
            parameter: free[held.leading],
            by_shape: held.number < by_shape[held.group],
            is_combined: held.is_combined,
            combination: Combination::new(parameters, &shares, ratio, nominal),
            what,
            text,
        }
    };
    held.iter().map(of_one).collect()
}

/// Shares of a combination that are not told.
const LEAST_SHARE: f64 = 0.05;
/// Shares nearer to each other count as the same.
const SAME_SHARE: f64 = 1e-6;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn correlations_and_the_worst_of_them() {
        let gram = [4.0, 1.0, -5.9, 1.0, 1.0, 0.0, -5.9, 0.0, 9.0];
        let covariance = Covariance::new(3, &gram, 0.1);
        assert!((covariance.entry(2, 2).unwrap() - 0.09).abs() < 1e-15);
        assert!((covariance.correlation(0, 1).unwrap() - 0.5).abs() < 1e-15);
        let (a, b, worst) = covariance.worst_pair().unwrap();
        assert!((a, b) == (0, 2) && (worst + 5.9 / 6.0).abs() < 1e-15);
        assert_eq!((covariance.entry(3, 0), covariance.correlation(0, 3)), (None, None));
        assert_eq!(Covariance::new(1, &[1.0], 1.0).worst_pair(), None);
        assert_eq!(Covariance::new(2, &[0.0; 4], 1.0).worst_pair(), None);
    }

    #[test]
    fn combinations_are_told_from_the_largest_share() {
        let parameters = [Parameter::Tx, Parameter::Tz, Parameter::Ry];
        let told = Combination::new(parameters, &[0.6, 0.01, -0.8], 1e-9, &Nominal::Plane);
        assert_eq!(told.to_string(), "0.80·ry - 0.60·tx");
        assert_eq!(told.terms, [(Parameter::Ry, 0.8), (Parameter::Tx, -0.6)]);
    }
}
