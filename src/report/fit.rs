//! How the nominal was laid into the points.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use crate::{FitDetails, LossFigures, PoseFigures, WeightFigures};

/// How the nominal was laid into the points.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct FitFigures {
    /// The criterion: `orthogonal least squares`.
    pub method: String,
    /// Why the iteration ended.
    pub termination: String,
    /// How many steps it took.
    pub iterations: u32,
    /// Names of the parameters that were free.
    pub free: Vec<String>,
    /// Every free parameter: value, unit and standard uncertainty (k = 1). Shifts and turns are those against
    /// the plane of projection, which along z is the measured frame.
    pub parameters: BTreeMap<String, ParameterFigures>,
    /// Free parameters the points do not determine, and motions of several of them in words; they stayed at their start.
    pub indeterminate: Vec<String>,
    /// Pose of the part in the measured frame.
    pub pose: PoseFigures,
    /// How many points of equal weight count as much, (Σw)²/Σw²; absent where all count alike.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub effective_points: Option<f64>,
    /// How much a deviation counts, where that is not by its square; final only.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub loss: Option<LossFigures>,
    /// Weights of points, where they do not count alike; final only.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub weights: Option<WeightFigures>,
    /// How it ended, what it lacks, how its figures must be read.
    #[serde(flatten)]
    pub details: FitDetails,
}

/// One fitted parameter.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ParameterFigures {
    /// Its value.
    pub value: f64,
    /// Its unit.
    pub unit: String,
    /// Its standard uncertainty (k = 1) in the same unit, by what `u_model` of the fit names; absent where there is none.
    pub u: Option<f64>,
    /// Half width of the interval about the value that holds with 95 % what `expanded_covers` of the fit names, from the budget
    /// or the deviations; absent without.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub expanded_95: Option<f64>,
    /// Its standard uncertainty in the same unit if form error like that of this part counts, as of another part of the same
    /// make; roughly, for it is from a glance. Of the pose it is by how much form error moves the best fit from where the part
    /// would lie without; absent of a pose without `expanded_95` or a free shape. Absent where `u` counts it, and where
    /// deviations are not plainly correlated.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub u_by_form: Option<f64>,
}
