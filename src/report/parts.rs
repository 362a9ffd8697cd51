//! Parts of a scene: which ones lie there, what they are, and their form. Lengths are mm of the measured frame.

use serde::{Deserialize, Serialize};

use crate::Verdict;

/// Points, place and holes of a part.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize)]
pub struct PartFigures {
    /// Its points.
    pub points: u64,
    /// The box along the axes: least and largest coordinates.
    pub box_mm: [[f64; 3]; 2],
    /// The mean of its places.
    pub centre_mm: [f64; 3],
    /// Its holes.
    pub loops: usize,
}

/// A part, which entry of the library it is, and its form.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize)]
pub struct PartReport {
    /// Its points, place and holes.
    #[serde(flatten)]
    pub figures: PartFigures,
    /// Which entry of the library it is, where there is a library.
    #[serde(default, rename = "match", skip_serializing_if = "Option::is_none")]
    pub found: Option<MatchFigures>,
    /// The form against the nominal of the entry, where it was measured.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub form: Option<PartForm>,
}

/// Whether a part is an entry.
#[derive(Clone, Copy, Debug, Deserialize, Eq, PartialEq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Answer {
    /// It fits, and clearly better than any other.
    Match,
    /// The fit of its nominal says so, too.
    Confirmed,
    /// There is no answer; the reason says why.
    Unknown,
}

/// Which entry of the library a part is.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize)]
pub struct MatchFigures {
    /// The answer.
    pub verdict: Answer,
    /// The entry; absent if it is unknown.
    pub name: Option<String>,
    /// Why it is unknown, in words.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub reason: Option<String>,
    /// 1 without any difference, 0 at the limit and beyond.
    pub score: f64,
    /// How much nearer the nearest entry is than the second: 0 of equal ones, 1 without a second.
    pub margin: f64,
    /// The largest difference that fits.
    pub limit_mm: f64,
    /// The entry that differs least, and how it would lie.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub nearest: Option<CandidateFigures>,
    /// The next one.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub second: Option<CandidateFigures>,
    /// Size of the part over that of the entry, of parts recognised whatever their size.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub scale: Option<f64>,
    /// How the part lies; absent if it is unknown.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub pose: Option<MatchPose>,
}

/// An entry laid onto a part.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize)]
pub struct CandidateFigures {
    /// Its name.
    pub name: String,
    /// How far both differ: the root mean square over surfaces and outlines.
    pub difference_mm: f64,
}

/// How a part lies in the scene.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize)]
pub struct MatchPose {
    /// Where the origin of the entry lies.
    pub place_mm: [f64; 3],
    /// Where its z axis points: up, down, side, or either where it looks alike on both sides.
    pub face: String,
    /// The angle between its z axis and that of the scene, whatever their sense.
    pub tilt_deg: f64,
    /// The turn about z; absent of what looks alike after any turn.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub turn_deg: Option<f64>,
    /// R of p = R·y + t, rows; t is the place. With a scale s it is p = R·(s·y) + t.
    pub rotation: [[f64; 3]; 3],
}

/// The form of a part against its nominal, as `measure` finds it.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize)]
pub struct PartForm {
    /// Range of the deviation.
    pub pv_nm: f64,
    /// Its standard uncertainty.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub u_pv_nm: Option<f64>,
    /// Root mean square of the deviation.
    pub rms_nm: f64,
    /// Its standard uncertainty.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub u_rms_nm: Option<f64>,
    /// The RMS with the mean square of the noise taken off.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub rms_without_noise_nm: Option<f64>,
    /// Points that the fit used.
    pub used: u64,
    /// Where the fit put the origin of the nominal in the scene, and the angle of its z axis to that of the scene.
    pub place_mm: [f64; 3],
    /// See [`PartForm::place_mm`].
    pub tilt_deg: f64,
    /// Whether the part holds the limits of its nominal.
    pub verdict: Verdict,
}

/// The parts of a session: those that ended up to now, in a report all of them.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize)]
pub struct SessionParts {
    /// Points that were looked at.
    pub as_of_points: u64,
    /// The way of the scan: `x`, `y` or `z`, with `-` towards lower coordinates.
    pub axis: String,
    /// Points nearer than this belong to one part, mm.
    pub tau_mm: f64,
    /// Width of the strips that close behind the scan, mm.
    pub strip_mm: f64,
    /// Entries of the library; absent without one.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub entries: Option<usize>,
    /// Parts that ended, in the order of their ends.
    pub parts: Vec<SessionPart>,
    /// Parts that the scan has begun and not ended.
    pub open: usize,
    /// Parts that ended and are not measured yet.
    pub waiting: usize,
    /// Pieces of too few points to be parts, and the points in them.
    pub islands: usize,
    /// See [`SessionParts::islands`].
    pub island_points: u64,
    /// Points left over where touching parts were taken apart.
    pub crumbs: u64,
    /// Points that came when the scan had left their place. They are in no part.
    pub late: u64,
    /// Points too far away to be placed. They are in no part.
    pub outside: u64,
    /// The last events, in their order; at most [`MOST_EVENTS`].
    pub events: Vec<PartEvent>,
    /// Events before these.
    pub earlier_events: u64,
}

/// Events that are listed.
pub const MOST_EVENTS: usize = 200;

/// A part of a session.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize)]
pub struct SessionPart {
    /// Its number in the scan, as the events have it. Parts that touched share one.
    pub scanned: u32,
    /// Whether the scan ended in it, so that it may have been cut off.
    pub is_open: bool,
    /// What it is.
    #[serde(flatten)]
    pub part: PartReport,
}

/// An event of the scan.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize)]
pub struct PartEvent {
    /// The part in the scan, from 0.
    pub part: u32,
    /// `begun`, `split`, `joined`, `merged` or `ended`.
    pub event: String,
    /// Where, mm.
    pub at_mm: [f64; 3],
    /// Branches that it was split into or joined of.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub branches: Option<usize>,
    /// Parts that turned out to be this one.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub merged: Vec<u32>,
}

/// What a snapshot says of the parts.
#[derive(Clone, Copy, Debug, Deserialize, Eq, PartialEq, Serialize)]
pub struct PartsState {
    /// Points that were looked at: when it changes, there is something new to ask for.
    pub as_of_points: u64,
    /// Parts that ended.
    pub ended: usize,
    /// Parts begun and not ended.
    pub open: usize,
    /// Parts that ended and are not measured yet.
    pub waiting: usize,
}

impl SessionParts {
    /// In short.
    pub fn state(&self) -> PartsState {
        PartsState {
            as_of_points: self.as_of_points,
            ended: self.parts.len(),
            open: self.open,
            waiting: self.waiting,
        }
    }
}
