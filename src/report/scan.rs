//! State of a scan that a station drives.

use serde::Serialize;

/// State of a scan that a station drives.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ScanFigures {
    /// `disarmed`, `armed`, `moving`, `deciding` or `ended`.
    pub state: String,
    /// State in a sentence: what it does, or why it was halted and the cure.
    pub text: String,
    /// Where the probe is, (x, y) in mm; absent before the axes answered.
    pub place_mm: Option<[f64; 2]>,
    /// Where it goes, (x, y) in mm; absent while it stands.
    pub next_mm: Option<[f64; 2]>,
    /// Number of the pass, from 1.
    pub pass: u32,
    /// Lines and stops of the pass.
    pub pieces: u64,
    /// Lines and stops of it that are behind.
    pub pieces_done: u64,
    /// Points of the plan so far.
    pub points: u64,
    /// Time since the first move in s.
    pub spent_s: f64,
    /// Time after which no line begins, in s; absent for any.
    pub time_limit_s: Option<f64>,
}
