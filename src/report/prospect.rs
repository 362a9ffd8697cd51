//! What can already be said of limits while points arrive: never in a report.

use serde::{Deserialize, Serialize};

use crate::FigureName;

/// State of the outlook for one limit, or for all.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum ProspectState {
    /// The limit will be broken, whatever is measured yet. Not taken back while the figures themselves are not in doubt.
    FailCertain,
    /// The limit will hold with the probability given, if the rest is like what is measured. What may stand out between
    /// the points is counted.
    PassCertain,
    /// It will, once the coverage is as large as said.
    PassFrom,
    /// The figure is worked out from all points, at the end; until then nothing is said of its limit.
    AtEnd,
    /// Neither can be said.
    #[default]
    Open,
}

/// Outlook for one limit.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ProspectFigures {
    /// Which figure, of what, as in the checks of the verdict.
    #[serde(flatten)]
    pub figure: FigureName,
    /// The largest value allowed.
    pub limit: f64,
    /// The value so far, over zones and with terms removed as of [`SamplingFigures::as_of_points`](crate::SamplingFigures::as_of_points);
    /// absent for figures that are only worked out at the end.
    pub value: Option<f64>,
    /// State of the outlook.
    pub state: ProspectState,
    /// The final value will be at least this; absent where that cannot be said.
    pub at_least: Option<f64>,
    /// The coverage, 0 to 1, from which on a pass is certain; absent where that cannot be said.
    pub pass_from_coverage: Option<f64>,
    /// The coverage of the aperture it is held against, also where the limit is for a zone.
    pub coverage: Option<f64>,
    /// The probability of a pass, where one is told.
    pub p: f64,
    /// Outlook in a sentence, and why it is open where it is.
    pub text: String,
}

/// Outlook for the part.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Outlook {
    /// A fail where one limit fails, a pass where each of them passes, and at the end where all others pass and one is
    /// only known then.
    pub state: ProspectState,
    /// In a sentence.
    pub text: String,
    /// Every limit.
    pub limits: Vec<ProspectFigures>,
}
