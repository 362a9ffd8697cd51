//! The figures of the parts of a scene as JSON writes them: `asphera.parts/1`.

use asphera_graph::compare::Size;
use asphera_graph::library::{Candidate, Facing, Outcome, Recognition};
use asphera_report::Verdict;
use serde::Serialize;

use super::super::graph::figures::PartFigures;
use super::super::summary::short;
use super::library::Library;

/// The parts of a scene. Lengths are mm of the file's frame.
#[derive(Debug, Serialize)]
pub(super) struct PartsReport {
    pub(super) format: &'static str,
    pub(super) file: String,
    pub(super) points: u64,
    pub(super) spacing_mm: f64,
    pub(super) tau_mm: f64,
    /// Entries of the library; absent without one.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) entries: Option<usize>,
    pub(super) parts: Vec<PartReport>,
    /// Pieces of too few points to be parts, and the points in them.
    pub(super) islands: usize,
    pub(super) island_points: u64,
    /// Points left over where touching parts were taken apart.
    #[serde(skip_serializing_if = "is_0")]
    pub(super) crumbs: u64,
}

fn is_0(count: &u64) -> bool {
    *count == 0
}

/// A part, which entry of the library it is, and its form.
#[derive(Debug, Serialize)]
pub(super) struct PartReport {
    #[serde(flatten)]
    pub(super) figures: PartFigures,
    #[serde(rename = "match", skip_serializing_if = "Option::is_none")]
    pub(super) found: Option<MatchFigures>,
    /// The form against the nominal of the entry, where it was measured.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) form: Option<PartForm>,
}

/// Whether a part is an entry.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub(super) enum Answer {
    /// It fits, and clearly better than any other.
    Match,
    /// The fit of its nominal says so, too.
    Confirmed,
    /// There is no answer; the reason says why.
    Unknown,
}

/// Which entry of the library a part is.
#[derive(Clone, Debug, Serialize)]
pub(super) struct MatchFigures {
    pub(super) verdict: Answer,
    /// The entry; absent if it is unknown.
    pub(super) name: Option<String>,
    /// Why it is unknown, in words.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) reason: Option<String>,
    /// 1 without any difference, 0 at the limit and beyond.
    pub(super) score: f64,
    /// How much nearer the nearest entry is than the second: 0 of equal ones, 1 without a second.
    pub(super) margin: f64,
    /// The largest difference that fits.
    pub(super) limit_mm: f64,
    /// The entry that differs least, and how it would lie.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) nearest: Option<CandidateFigures>,
    /// The next one.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) second: Option<CandidateFigures>,
    /// Size of the part over that of the entry, of parts recognised whatever their size.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) scale: Option<f64>,
    /// How the part lies; absent if it is unknown.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) pose: Option<MatchPose>,
}

/// An entry laid onto a part.
#[derive(Clone, Debug, Serialize)]
pub(super) struct CandidateFigures {
    pub(super) name: String,
    /// How far both differ: the root mean square over surfaces and outlines.
    pub(super) difference_mm: f64,
}

/// How a part lies in the scene.
#[derive(Clone, Debug, Serialize)]
pub(super) struct MatchPose {
    /// Where the origin of the entry lies.
    pub(super) place_mm: [f64; 3],
    /// Where its z axis points: up, down, side, or either where it looks alike on both sides.
    pub(super) face: &'static str,
    /// The angle between its z axis and that of the scene, whatever their sense.
    pub(super) tilt_deg: f64,
    /// The turn about z; absent of what looks alike after any turn.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) turn_deg: Option<f64>,
    /// R of p = R·y + t, rows; t is the place. With a scale s it is p = R·(s·y) + t.
    pub(super) rotation: [[f64; 3]; 3],
}

/// The form of a part against its nominal, as `measure` finds it.
#[derive(Clone, Debug, Serialize)]
pub(super) struct PartForm {
    pub(super) pv_nm: f64,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) u_pv_nm: Option<f64>,
    pub(super) rms_nm: f64,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) u_rms_nm: Option<f64>,
    /// The RMS with the mean square of the noise taken off.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) rms_without_noise_nm: Option<f64>,
    /// Points that the fit used.
    pub(super) used: u64,
    /// Where the fit put the origin of the nominal in the scene, and the angle of its z axis to that of the scene.
    pub(super) place_mm: [f64; 3],
    pub(super) tilt_deg: f64,
    /// Whether the part holds the limits of its nominal.
    pub(super) verdict: Verdict,
}

impl MatchFigures {
    pub(super) fn new(found: &Recognition, library: &Library, size: Size) -> MatchFigures {
        let candidate = |at: usize| {
            let candidate: &Candidate = found.candidates.get(at)?;
            let name = library.name(candidate.entry).to_owned();
            Some(CandidateFigures { name, difference_mm: candidate.difference_mm })
        };
        let (nearest, second) = (candidate(0), candidate(1));
        let limit_mm = short(found.limit_mm);
        let reason = match (found.outcome, &nearest, &second) {
            (Outcome::Match, ..) => None,
            (Outcome::TooSmall, ..) => {
                Some("fewer than twelve places, or all of them on a line".to_owned())
            }
            (Outcome::Ambiguous, Some(first), Some(second)) => Some(format!(
                "{} and {} fit equally, by {} and {} mm",
                first.name,
                second.name,
                short(first.difference_mm),
                short(second.difference_mm)
            )),
            (_, Some(first), _) => Some(format!(
                "nearest is {}, by {} mm; up to {limit_mm} mm fits",
                first.name,
                short(first.difference_mm)
            )),
            (_, None, _) => Some("no entry has about its size".to_owned()),
        };
        let first = found.candidates.first().filter(|_| reason.is_none());
        MatchFigures {
            verdict: if reason.is_none() { Answer::Match } else { Answer::Unknown },
            name: first.map(|first| library.name(first.entry).to_owned()),
            reason,
            score: found.score(),
            margin: found.margin(),
            limit_mm: found.limit_mm,
            nearest,
            second,
            scale: first.filter(|_| size == Size::Free).map(|first| first.scale),
            pose: first.map(MatchPose::new),
        }
    }

    /// The same after a fit that confirms the match, or does not for a reason.
    pub(super) fn judged(self, reason: Option<String>) -> MatchFigures {
        match reason {
            None => MatchFigures { verdict: Answer::Confirmed, ..self },
            Some(reason) => MatchFigures {
                verdict: Answer::Unknown,
                name: None,
                scale: None,
                pose: None,
                reason: Some(reason),
                ..self
            },
        }
    }
}

impl MatchPose {
    fn new(candidate: &Candidate) -> MatchPose {
        let pose = &candidate.pose;
        let face = match (candidate.is_side_known, pose.facing()) {
            (false, _) => "either",
            (true, Facing::Up) => "up",
            (true, Facing::Down) => "down",
            (true, Facing::Side) => "side",
        };
        MatchPose {
            place_mm: pose.shift_mm,
            face,
            tilt_deg: pose.tilt_rad().to_degrees(),
            turn_deg: candidate.is_turn_known.then(|| pose.turn_rad().to_degrees()),
            rotation: pose.rotation,
        }
    }
}
