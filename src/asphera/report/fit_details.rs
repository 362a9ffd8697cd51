//! What a fit says of itself beside its parameters: how it ended, what it lacks, how its figures must be read.

use serde::{Deserialize, Serialize};

/// Details of a fit. Running figures have what is known of them: which parameters are not determined.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct FitDetails {
    /// Whether the iteration reached its end; absent of running figures.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub converged: Option<bool>,
    /// How often distances and derivatives of all points were worked out.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub evaluations: Option<u64>,
    /// Largest over smallest singular value of the scaled Jacobian of the parameters found.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub condition: Option<f64>,
    /// Points used less parameters found.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub dof: Option<u64>,
    /// Standard deviation of the distances in nm: root of the sum of squares over `dof`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub sigma_nm: Option<f64>,
    /// What the figures must be read with; empty where there is nothing.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub cautions: Vec<CautionFigures>,
    /// The combination of the parameters found that is determined worst.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub weakest: Option<CombinationFigures>,
    /// Every free parameter the points do not determine, and which combination they do not feel.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub undetermined: Vec<UndeterminedFigures>,
    /// How the parameters found vary together, under the assumption that the residuals are independent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub covariance: Option<CovarianceFigures>,
}

/// Something that makes the figures doubtful or surprising.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct CautionFigures {
    /// `upside_down`, `mirrored`, `beyond_domain`, `units` or `ill_conditioned`; of a surface without a design `made_from_points`
    /// and `coarse_knots`; of running figures `provisional`.
    pub kind: String,
    /// In a sentence, with its numbers.
    pub text: String,
    /// Whether the verdict is undecided because of it.
    pub forbids_verdict: bool,
}

/// A combination of parameters, each in units of what moves the surface at the points by the same root mean square.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct CombinationFigures {
    /// `0.80·ry - 0.60·tx`.
    pub text: String,
    /// Parameters with their share, the largest first; the squares of all add up to 1, those below a twentieth
    /// are left out.
    pub shares: Vec<ShareFigures>,
    /// How far it moves the surface at the points, over what the strongest combination of that size does.
    pub ratio: f64,
}

/// A parameter's share in a combination.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ShareFigures {
    /// Its name.
    pub parameter: String,
    /// Its share, -1 to 1.
    pub share: f64,
}

/// A free parameter that stayed at its start.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct UndeterminedFigures {
    /// Its name.
    pub parameter: String,
    /// Whether no points on this nominal could determine it beside the others: a sphere does not feel a turn.
    /// Otherwise points elsewhere could.
    pub by_shape: bool,
    /// The combination with the parameters found that the points do not feel.
    pub combination: CombinationFigures,
}

/// Covariances and correlations: row and column by the order of `parameters`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct CovarianceFigures {
    /// Names of the parameters.
    pub parameters: Vec<String>,
    /// Their units; an entry of `covariance` has the product of two.
    pub units: Vec<String>,
    /// Covariances.
    pub covariance: Vec<Vec<f64>>,
    /// Correlations, -1 to 1; `None` (null) where one of the two does not vary.
    pub correlation: Vec<Vec<Option<f64>>>,
}
