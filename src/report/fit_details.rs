//! What a fit says of itself beside its parameters: how it ended, what it lacks, how its figures must be read.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

/// Details of a fit. Running figures have what is known of them: which parameters are not determined.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct FitDetails {
    /// Whether the iteration reached its end; absent of running figures.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub converged: Option<bool>,
    /// How much further inside the edge of the aperture was taken, nm, because points lay on it and no choice of them settled.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub aperture_narrowed_nm: Option<f64>,
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
    /// Cautions to read the figures with; empty where there is nothing.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub cautions: Vec<CautionFigures>,
    /// The combination of the parameters found that is determined worst.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub weakest: Option<CombinationFigures>,
    /// Every free parameter the points do not determine, and which combination they do not feel.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub undetermined: Vec<UndeterminedFigures>,
    /// How the parameters found vary together, by what `u_model` names.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub covariance: Option<CovarianceFigures>,
    /// Sources of u of the parameters: [`FitDetails::BY_RESIDUALS`], [`FitDetails::BY_DEVIATIONS`],
    /// [`FitDetails::BY_DEVIATIONS_AND_MACHINE`] or a model of [`crate::UncertaintyFigures`]; absent of running
    /// figures, whose u is by the residuals.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub u_model: Option<String>,
    /// Scope of `expanded_95` of the parameters, in words; absent where there is none.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub expanded_covers: Option<String>,
    /// How the deviations are correlated, where u of the parameters counts it or tells less of the shape for not doing so.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub correlation: Option<CorrelationFigures>,
}

impl FitDetails {
    /// The residuals, each taken for an error of its own.
    pub const BY_RESIDUALS: &str = "residuals, taken as independent";
    /// The deviations with the correlation they have.
    pub const BY_DEVIATIONS: &str = "deviations, correlated as they are";
    /// The same with the effects of the machine of the nominal file beside them.
    pub const BY_DEVIATIONS_AND_MACHINE: &str =
        "deviations, correlated as they are, and effects of the machine";
    /// Scope of an expanded uncertainty by these.
    pub const COVERS_MAKE: &str = "parts of this make: form error like that of this one drawn anew; not waves longer than \
                                          the part, which look as a change of its parameters";

    /// Scope of an expanded uncertainty by a model of [`crate::UncertaintyFigures`] covers. `places`: whether the places
    /// that were taken are in it.
    pub fn covers_part(model: &str, places: bool) -> String {
        let errors = crate::UncertaintyFigures::covers_area(model, places);
        format!("the best fit to this very part: {errors}; what form error does to it is u_by_form")
    }
}

/// The correlation of the deviations, and what it does to u of the parameters.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct CorrelationFigures {
    /// Whether u of the parameters counts it. Where not, these figures are from a glance at few patches, and the parameters
    /// have `u_by_form`.
    pub counted: bool,
    /// The most likely correlation, by its name in the nominal file: `gaussian`, `matern` or `exponential`.
    pub kernel: String,
    /// Its length in mm.
    pub length_mm: f64,
    /// Standard deviation of the correlated part in nm.
    pub sigma_nm: f64,
    /// Standard deviation of the mean of a patch by what is independent from patch to patch, nm.
    pub rest_nm: f64,
    /// How likely each kernel is.
    pub kernels: BTreeMap<String, f64>,
    /// Patches of neighbouring points it was judged by.
    pub patches: u64,
    /// Variance of their means over that of independent deviations; absent where a patch is one point.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub patch_ratio: Option<f64>,
    /// The probability of so large a ratio if the deviations were independent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub independent_p: Option<f64>,
    /// How many times u by the deviations is that of independent ones, of the parameter where it is the most; where it is not
    /// counted, how many times that told, of those of the shape where any is free.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub largest_ratio: Option<f64>,
    /// Which parameter.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub largest_ratio_of: Option<String>,
}

/// Something that makes the figures doubtful or surprising.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct CautionFigures {
    /// `upside_down`, `mirrored`, `beyond_domain`, `units`, `ill_conditioned`, `held_combination`, `free_shape` or `correlated`; of a surface without a design `made_from_points`
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

/// A free parameter, or a combination of motions, that stayed at its start.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct UndeterminedFigures {
    /// Its name; of a combination that of the parameter with the largest part.
    pub parameter: String,
    /// In a sentence, as the motion it is.
    #[serde(default)]
    pub text: String,
    /// Whether it is a combination, in which other parameters have their parts.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub combined: bool,
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
