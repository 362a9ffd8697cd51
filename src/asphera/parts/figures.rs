//! What a part was recognised as, in figures.

use asphera_graph::compare::Size;
use asphera_graph::library::{Candidate, Facing, Outcome, Recognition};
use asphera_report::parts::{Answer, CandidateFigures, MatchFigures, MatchPose};
use asphera_report::words::short;

use super::Library;

/// The figures of a recognition.
pub(crate) fn matched(found: &Recognition, library: &Library, size: Size) -> MatchFigures {
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
        pose: first.map(pose),
    }
}

/// The same after a fit that confirms the match, or does not for a reason.
pub(crate) fn judged(found: MatchFigures, reason: Option<String>) -> MatchFigures {
    match reason {
        None => MatchFigures { verdict: Answer::Confirmed, ..found },
        Some(reason) => MatchFigures {
            verdict: Answer::Unknown,
            name: None,
            scale: None,
            pose: None,
            reason: Some(reason),
            ..found
        },
    }
}

fn pose(candidate: &Candidate) -> MatchPose {
    let pose = &candidate.pose;
    let face = match (candidate.is_side_known, pose.facing()) {
        (false, _) => "either",
        (true, Facing::Up) => "up",
        (true, Facing::Down) => "down",
        (true, Facing::Side) => "side",
    };
    MatchPose {
        place_mm: pose.shift_mm,
        face: face.to_owned(),
        tilt_deg: pose.tilt_rad().to_degrees(),
        turn_deg: candidate.is_turn_known.then(|| pose.turn_rad().to_degrees()),
        rotation: pose.rotation,
    }
}
