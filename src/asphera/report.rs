//! The figures of a measurement, as every output writes them.
//!
//! One set of types serves the report file, the snapshots of the page and `--json`: what is shown
//! live and what is kept have the same names, units and meaning.

mod features;
mod fit;
mod fit_details;
mod form;
mod label;
mod mesh;
mod profile;
mod prospect;
mod reading;
mod sampling;
mod standards;
mod unmeasured;
mod verdict;

use std::collections::BTreeMap;

use asphera_form::Pose;
use serde::{Deserialize, Serialize};

pub use features::{DefectFigures, DefectSearchFigures, FeatureFigures, PartitionFigures};
pub use fit::{LossFigures, ReferenceFigures, WeightFigures};
pub use fit_details::{
    CautionFigures, CombinationFigures, CorrelationFigures, CovarianceFigures, FitDetails,
    ShareFigures, UndeterminedFigures,
};
pub use form::{
    ExpandedFigures, FormFigure, HistogramFigures, OriginFigures, RingFigures, SimulatedFigures,
    Source, ZernikeFigures, ZernikeTerm,
};
pub use label::Label;
pub use mesh::{
    MeshFigures, PlaneFigures, ProjectionFigures, RegionFigures, ReliefFigures, RepeatFigures,
};
pub use profile::ProfileFigures;
pub use prospect::{Outlook, ProspectFigures, ProspectState};
pub use reading::{ColumnFigures, ReadingFigures};
pub use sampling::{CurrentFigures, NextFigures, PolygonFigures, SamplingFigures};
pub use standards::{
    ContactFigures, IndicationFigures, MinimumZoneFigures, PsdFigures, QFigures, StandardFigures,
    TextureFigures,
};
pub use unmeasured::UnmeasuredFigures;
pub(crate) use verdict::words_of;
pub use verdict::{Check, Status, Verdict};

/// Version of the report's layout. A reader refuses what it does not know.
pub const FORMAT: &str = "asphera.report/1";

/// Everything asphera says about one measurement of one part.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Report {
    /// [`FORMAT`].
    pub format: String,
    /// Columns and units of a file whose format leaves them open, such as text or PLY; absent for other files and sessions.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub reading: Option<ReadingFigures>,
    /// What became of the points.
    pub points: Points,
    /// The mesh of the points used.
    pub mesh: MeshFigures,
    /// Whether the points lie densely enough.
    pub sampling: SamplingFigures,
    /// Defects, and which way the surface bends.
    #[serde(flatten)]
    pub features: FeatureFigures,
    /// Nominal, fit and deviation; absent where no fit could be made, then [`Verdict::reasons`] says why.
    pub form: Option<FormFigures>,
    /// Of points on a straight line: what is formed along it instead of by area.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub profile: Option<ProfileFigures>,
    /// Pass, fail or undecided.
    pub verdict: Verdict,
    /// What each link and device delivered and lost. Empty for points read from a file.
    pub links: Vec<LinkFigures>,
    /// How long it took. The only part that differs between a live run and its replay.
    pub timing: Timing,
    /// The recording this belongs to; absent for points read from a file.
    pub session: Option<SessionFigures>,
}

/// What became of the points.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Points {
    /// Records that were formed from what the devices sent, or rows of a file, gaps included.
    pub received: u64,
    /// Points in the mesh and inside the aperture: those of the fit and the figures.
    pub used: u64,
    /// Points not used, by reason. A point with several reasons counts once for each. A flag that does not
    /// forbid the use of a point stands in the figures of its device.
    pub flagged: BTreeMap<String, u64>,
    /// Points at the exact place and height of an earlier one.
    pub duplicates: u64,
    /// Triggers whose reading never arrived, as the gaps in the shared count tell.
    pub lost: u64,
}

/// Nominal, fit and deviation.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct FormFigures {
    /// The design surface in words: `asphere R 11.65 mm, conic -1.1, …`.
    pub nominal: String,
    /// The surface that was made from the points where no design is known; final only.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub reference: Option<ReferenceFigures>,
    /// How the nominal was laid into the points.
    pub fit: FitFigures,
    /// Where places of the part, rings, Zernike terms and slopes along the meridian count from.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub origin: Option<OriginFigures>,
    /// What remains.
    pub deviation: DeviationFigures,
    /// Whether these are running figures, to be replaced by a full fit at the end.
    pub provisional: bool,
    /// The figures of standards and optical shops, final only.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub figures: Vec<FormFigure>,
    /// The deviation in Zernike terms.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub zernike: Option<ZernikeFigures>,
    /// How many points have which deviation.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub histogram: Option<HistogramFigures>,
    /// Mean deviation by distance from the origin, the innermost ring first; final only.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub rings: Vec<RingFigures>,
    /// Minimum zone, spectra, texture and the indication of the drawing; final only.
    #[serde(flatten)]
    pub standards: StandardFigures,
    /// Why a figure is not known.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub unknown: Vec<String>,
}

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
    /// What points are weighted by, where they do not count alike; final only.
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

/// A rigid motion from the part frame into the measured frame: `p' = Rz·Ry·Rx·p + t`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct PoseFigures {
    /// Shift along x in mm.
    pub tx_mm: f64,
    /// Shift along y in mm.
    pub ty_mm: f64,
    /// Shift along z in mm.
    pub tz_mm: f64,
    /// Rotation about x in rad.
    pub rx_rad: f64,
    /// Rotation about y in rad.
    pub ry_rad: f64,
    /// Rotation about z in rad.
    pub rz_rad: f64,
}

impl PoseFigures {
    /// Takes a place of the part frame into the measured frame, both in mm.
    pub fn to_measured(&self, part_mm: [f64; 3]) -> [f64; 3] {
        let PoseFigures { tx_mm, ty_mm, tz_mm, rx_rad, ry_rad, rz_rad } = *self;
        Pose { tx_mm, ty_mm, tz_mm, rx_rad, ry_rad, rz_rad }.to_measured(part_mm)
    }
}

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
    /// What is known of the errors of these figures; absent where the noise is not known, `unknown` says why.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub uncertainty: Option<UncertaintyFigures>,
    /// What the part of the aperture that was not measured may hide; final only.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub unmeasured: Option<UnmeasuredFigures>,
}

/// Uncertainties of PV and RMS, by the budget of the nominal file or, without one, by the noise of the points alone.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct UncertaintyFigures {
    /// What they are made of: [`UncertaintyFigures::BUDGET`], [`UncertaintyFigures::NOISE_ONLY`] or
    /// [`UncertaintyFigures::NOISE_BESIDE_FORM`].
    #[serde(default = "UncertaintyFigures::budget")]
    pub model: String,
    /// Standard uncertainty (k = 1) of the PV, by simulated measurements.
    pub u_pv_nm: f64,
    /// Whether that and `pv_bias_nm` are upper bounds: where nothing was simulated.
    #[serde(default)]
    pub pv_at_most: bool,
    /// What noise adds to the PV, the most with a probability of one half, as far as the draws tell.
    pub pv_bias_nm: f64,
    /// Interval that holds with 95 % the PV at the places measured, by what `pv_covers` names.
    pub pv_95_nm: [f64; 2],
    /// What `u_pv_nm` and `pv_95_nm` cover, in words.
    #[serde(default)]
    pub pv_covers: String,
    /// Standard uncertainty (k = 1) of the RMS without noise.
    pub u_rms_nm: f64,
    /// RMS with the mean square of the noise taken off: final figures over the area about its own best fit, where every point
    /// counts by what it stands for; running ones over the points.
    pub rms_without_noise_nm: f64,
    /// Interval that holds that with 95 %, by what `rms_covers` names.
    pub rms_95_nm: [f64; 2],
    /// What `u_rms_nm` and `rms_95_nm` cover, in words.
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

    /// What an uncertainty by a model covers of a figure of single points, or of what is formed at the places measured.
    pub(crate) fn covers_places(model: &str) -> String {
        format!("{}, at the places measured; not what lies between them", errors_of(model))
    }

    /// What an uncertainty by a model covers of an average. `counted`: whether the places are in it.
    pub(crate) fn covers_area(model: &str, counted: bool) -> String {
        let errors = errors_of(model);
        if counted {
            format!("{errors}, and the places that were taken of the area")
        } else {
            format!("{errors}; not the places that were taken of the area")
        }
    }

    /// What an uncertainty by a model covers of a figure of points that is held against that of the area.
    pub(crate) fn covers_difference(model: &str, counted: bool) -> String {
        if !counted {
            return UncertaintyFigures::covers_area(model, false);
        }
        format!(
            "{}; of the places only how far the figure is from that of the area",
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
        _ => "the noise of the points, nothing correlated",
    }
}

/// What one link and its devices delivered and lost.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct LinkFigures {
    /// The link.
    pub name: String,
    /// Bytes received (CAN frames of the kernel: 16 bytes each).
    pub received_bytes: u64,
    /// Bytes that belong to no valid frame.
    pub discarded_bytes: u64,
    /// Times it was opened.
    pub opened: u64,
    /// Times it was lost.
    pub closed: u64,
    /// Its devices.
    pub devices: Vec<DeviceFigures>,
}

/// What one device delivered and lost.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct DeviceFigures {
    /// The device.
    pub name: String,
    /// Readings.
    pub readings: u64,
    /// Readings with a flag, by flag. A reading with several flags counts once for each.
    pub flagged: BTreeMap<String, u64>,
    /// Triggers skipped, as gaps in the shared count tell: readings lost before they reached the host.
    pub lost: u64,
    /// Readings that found no companion of the same count.
    pub unjoined: u64,
    /// Readings whose trigger could not be told.
    pub ambiguous: u64,
    /// Times a whole cycle of the shared count was found missing.
    pub slips: u64,
    /// Faults by kind.
    pub faults: BTreeMap<String, u64>,
    /// Every channel that makes no coordinate: smallest, mean and largest value.
    pub channels: BTreeMap<String, ChannelFigures>,
}

/// What a recorded channel did during the measurement.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ChannelFigures {
    /// Unit of the values.
    pub unit: String,
    /// Smallest value.
    pub min: f64,
    /// Mean value.
    pub mean: f64,
    /// Largest value.
    pub max: f64,
    /// How many values.
    pub count: u64,
}

/// How long it took. Never compared between runs.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Timing {
    /// From the start to the report, in s.
    pub total_s: f64,
    /// From the last point to the report, in s.
    pub after_last_point_s: f64,
    /// Points received over the whole time.
    pub points_per_s: f64,
}

/// The recording a report belongs to.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct SessionFigures {
    /// Name of the recording's folder.
    pub id: String,
    /// When it began, RFC 3339, UTC, by the host's clock.
    pub started: String,
    /// Name of the station.
    pub station: String,
    /// Version of asphera that recorded it.
    pub version: String,
    /// Why it ended: `complete`, `stopped`, `idle`, `interrupted`.
    pub ended: String,
    /// What was measured, and by whom, as it was told at the start.
    #[serde(default, skip_serializing_if = "is_unlabelled")]
    pub label: Label,
}

fn is_unlabelled(label: &Label) -> bool {
    *label == Label::default()
}
