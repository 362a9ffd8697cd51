//! Errors that all points have together, and their share in the uncertainties.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

/// One error that all points have together, such as that of a calibration, and what it adds to uncertainties (k = 1).
///
/// Sources are independent of each other: squares of their contributions add up. A contribution is the change of a figure where
/// the points are moved by one standard uncertainty of the source and fitted anew. What the fit takes up is not in it.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct SystematicFigures {
    /// Source of the error, in words.
    pub source: String,
    /// Contribution to u of PV, nm; absent where it is not counted.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub u_pv_nm: Option<f64>,
    /// Contribution to u of RMS, nm; absent where it is not counted.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub u_rms_nm: Option<f64>,
    /// Contributions to u of figures that have a limit, by the name of the check and in its unit.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub limits: BTreeMap<String, f64>,
    /// Contributions to u of pose and shape, by the name of the parameter.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub parameters: BTreeMap<String, ContributionFigures>,
    /// Why nothing of it is counted; absent where it is.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub not_counted: Option<String>,
}

/// Contribution to the standard uncertainty of a parameter.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct ContributionFigures {
    /// Its size (k = 1).
    pub u: f64,
    /// Its unit.
    pub unit: String,
}

impl SystematicFigures {
    /// End of the scope of an uncertainty in which systematic errors are counted, in words.
    pub const COVERED: &str = "with the systematic errors listed";

    /// A source of which nothing is counted, and why.
    pub fn not_counted(source: &str, why: &str) -> SystematicFigures {
        SystematicFigures {
            source: source.to_owned(),
            not_counted: Some(why.to_owned()),
            ..SystematicFigures::default()
        }
    }
}
