//! All that is said of one measurement of one part.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use crate::contour::ContourReport;
use crate::parts::SessionParts;
use crate::{
    FaceFigures, FeatureFigures, FormFigures, Label, LinkFigures, MeshFigures, PlaceFigures,
    ProfileFigures, ReadingFigures, SamplingFigures, TipFigures, Verdict,
};

/// Version of the layout of [`Report`]. A reader refuses what it does not know.
pub const REPORT_FORMAT: &str = "asphera.report/1";

/// Everything asphera says about one measurement of one part.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Report {
    /// [`REPORT_FORMAT`].
    pub format: String,
    /// Columns and units of a file whose format leaves them open, such as text or PLY; absent for other files and sessions.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub reading: Option<ReadingFigures>,
    /// The face of a volume that was measured; absent for points.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub volume: Option<FaceFigures>,
    /// Counts of the points by their fate.
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
    /// Figures of points on a straight line, formed along it instead of by area.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub profile: Option<ProfileFigures>,
    /// The contour of the points of a session, where its configuration asks for it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub contour: Option<ContourReport>,
    /// The parts of a session, where its configuration asks for them.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub parts: Option<SessionParts>,
    /// Pass, fail or undecided.
    pub verdict: Verdict,
    /// Bytes and readings of each link and device, delivered and lost. Empty for points read from a file.
    pub links: Vec<LinkFigures>,
    /// How long it took. The only part that differs between a live run and its replay.
    pub timing: Timing,
    /// The recording this belongs to; absent for points read from a file.
    pub session: Option<SessionFigures>,
}

/// Counts of the points by their fate.
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
    /// Triggers of the scan that had not come when the session ended, where the scan says how many it has.
    #[serde(default)]
    pub missing: u64,
    /// Compensation of the radius of a ball tip; absent where there was none, and of running figures.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub tip: Option<Box<TipFigures>>,
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
    /// Longest time for which recorded points waited to be processed, in s; 0 where processing kept up, and absent then.
    #[serde(default, skip_serializing_if = "kept_up")]
    pub most_behind_s: f64,
}

/// Whether no points waited.
fn kept_up(most_behind_s: &f64) -> bool {
    *most_behind_s == 0.0
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
    /// Part and operator, as given at the start.
    #[serde(default, skip_serializing_if = "is_unlabelled")]
    pub label: Label,
    /// Calibration of the machine that its points were corrected by; absent where there was none.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub calibration: Option<CalibrationFigures>,
    /// Files of errors of its axes that were taken out of their readings; absent where there were none.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub error_tables: Vec<String>,
    /// How well places are known; absent where readings are joined by count.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub places: Option<PlaceFigures>,
    /// Thermal expansion that was taken out of its points; absent where there was none.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub thermal: Option<ThermalFigures>,
}

/// Thermal expansion that was taken out of the good points of a session.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct ThermalFigures {
    /// Lowest and highest temperature of the part, °C; absent where it was taken to be at 20 °C.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub part_degc: Option<[f64; 2]>,
    /// Lowest and highest temperature of the scales of the machine, °C; absent where they were taken to be at 20 °C.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub scales_degc: Option<[f64; 2]>,
    /// Smallest and largest relative change of lengths, µm/m; negative where they became shorter.
    pub lengths_um_per_m: [f64; 2],
    /// Largest relative standard uncertainty of lengths by it, µm/m. It is common to all points: `form.deviation.systematic` says
    /// what it adds to u of the figures.
    pub u_um_per_m: f64,
}

/// A calibration of a machine.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct CalibrationFigures {
    /// When it was made, RFC 3339, UTC.
    pub date: String,
    /// Until when it may be used, RFC 3339, UTC.
    pub valid_until: String,
    /// Kind of machine: `cartesian`, `polar`.
    pub machine: String,
}

fn is_unlabelled(label: &Label) -> bool {
    *label == Label::default()
}
