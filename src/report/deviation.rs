//! The form deviation in short, and what is known of its errors.

use serde::{Deserialize, Serialize};

use crate::{SystematicFigures, UnmeasuredFigures};

/// Form deviation: measured minus nominal along the nominal's normal, after alignment.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct DeviationFigures {
    /// Range.
    pub pv_nm: f64,
    /// Root mean square over the points.
    pub rms_nm: f64,
    /// Largest, positive where material stands above the nominal (+z side).
    pub max_nm: f64,
    /// Smallest.
    pub min_nm: f64,
    /// Where the largest is, part frame, mm.
    pub at_max_mm: [f64; 3],
    /// Where the smallest is, part frame, mm.
    pub at_min_mm: [f64; 3],
    /// Errors of these figures; absent where the noise is not known, `unknown` says why.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub uncertainty: Option<UncertaintyFigures>,
    /// Errors that all points have together, source by source, as `uncertainty` and the u of limits, pose and shape count them;
    /// final only. Empty where no source is known.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub systematic: Vec<SystematicFigures>,
    /// Allowance for the part of the aperture that was not measured; final only.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub unmeasured: Option<UnmeasuredFigures>,
}

/// Uncertainties of PV and RMS, by the budget of the nominal file or, without one, by the noise of the points alone.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct UncertaintyFigures {
    /// Sources of the errors: [`UncertaintyFigures::BUDGET`], [`UncertaintyFigures::NOISE_ONLY`] or
    /// [`UncertaintyFigures::NOISE_BESIDE_FORM`].
    #[serde(default = "UncertaintyFigures::budget")]
    pub model: String,
    /// Standard uncertainty (k = 1) of the PV, by simulated measurements.
    pub u_pv_nm: f64,
    /// Whether that and `pv_bias_nm` are upper bounds: where nothing was simulated.
    #[serde(default)]
    pub pv_at_most: bool,
    /// Rise of the PV by noise, the most with a probability of one half, as far as the draws tell.
    pub pv_bias_nm: f64,
    /// Interval that holds with 95 % the PV at the places measured, by what `pv_covers` names.
    pub pv_95_nm: [f64; 2],
    /// Scope of `u_pv_nm` and `pv_95_nm`, in words.
    #[serde(default)]
    pub pv_covers: String,
    /// Standard uncertainty (k = 1) of the RMS without noise.
    pub u_rms_nm: f64,
    /// RMS with the mean square of the noise taken off: final figures over the area about its own best fit, where every point
    /// counts by what it stands for; running ones over the points.
    pub rms_without_noise_nm: f64,
    /// Interval that holds that with 95 %, by what `rms_covers` names.
    pub rms_95_nm: [f64; 2],
    /// Scope of `u_rms_nm` and `rms_95_nm`, in words.
    #[serde(default)]
    pub rms_covers: String,
    /// Standard deviation of the independent noise of a point.
    pub noise_nm: f64,
    /// Whether the noise was measured from the points.
    pub noise_measured: bool,
    /// Measurements simulated; absent where none were.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub draws: Option<u32>,
    /// Seed of the simulation.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub seed: Option<u64>,
}

impl UncertaintyFigures {
    /// By the table `[uncertainty]` of the nominal file, correlated errors included.
    pub const BUDGET: &str = "error budget of the nominal file";
    /// By the noise of the points, and nothing that is correlated from point to point.
    pub const NOISE_ONLY: &str = "noise only";
    /// The same where the nominal file says so: what is correlated in the deviations is form of the part, which PV and RMS
    /// tell of, and no error of theirs.
    pub const NOISE_BESIDE_FORM: &str = "noise only, what is correlated being form";

    /// Scope of an uncertainty by a model, of a figure of single points, or of what is formed at the places measured.
    pub fn covers_places(model: &str) -> String {
        format!("{}, at the measured places; without what lies between them", errors_of(model))
    }

    /// Scope of an uncertainty by a model, of an average. `counted`: whether the places are in it.
    pub fn covers_area(model: &str, counted: bool) -> String {
        let errors = errors_of(model);
        if counted {
            format!(
                "{errors}, and the choice of places (as of scattered points: for a spiral that is denser in the middle the true share is \
                 smaller); without form finer than some four point distances"
            )
        } else {
            format!("{errors}; without the choice of places")
        }
    }

    /// Scope of an uncertainty by a model, of a figure of points that is held against that of the area.
    pub fn covers_difference(model: &str, counted: bool) -> String {
        if !counted {
            return UncertaintyFigures::covers_area(model, false);
        }
        format!(
            "{}; of the choice of places only the difference between points and area",
            errors_of(model)
        )
    }

    fn budget() -> String {
        UncertaintyFigures::BUDGET.to_owned()
    }
}

/// The errors that a model has, in words.
fn errors_of(model: &str) -> &'static str {
    match model {
        UncertaintyFigures::BUDGET => "the error budget of the nominal file",
        _ => "the noise of the points, without correlated errors",
    }
}
