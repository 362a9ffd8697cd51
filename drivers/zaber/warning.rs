//! Warning flags of a reply: two letters, the worst that is the case.
//!
//! Names: class `WarningFlags` of Zaber's own library `zaber-motion`. `F` begins faults, `W` warnings, `N` notices.

use asphera_described::Flagged;
use asphera_link::{Flags, MotionFailure, MotionTrouble};

/// A warning flag of a reply.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Warning {
    /// Its two letters.
    pub letters: &'static str,
    /// Its name in Zaber's library.
    pub name: &'static str,
    /// Whether positions with it are not to be used: they are flagged as errors of the device.
    pub is_bad: bool,
}

const fn warning(letters: &'static str, name: &'static str, is_bad: bool) -> Warning {
    Warning { letters, name, is_bad }
}

const BAD: bool = true;
const FINE: bool = false;

/// All warning flags; `--` in a reply means that there is none.
///
/// Positions with a fault are bad. So are those of a stage that has no reference or was moved by force: they count
/// from anywhere.
pub const WARNINGS: [Warning; 34] = [
    warning("FF", "critical system error", BAD),
    warning("FN", "peripheral not supported", BAD),
    warning("FZ", "peripheral inactive", BAD),
    warning("FH", "hardware emergency stop", BAD),
    warning("FV", "overvoltage or undervoltage", BAD),
    warning("FO", "driver disabled, no fault", BAD),
    warning("FC", "current inrush error", BAD),
    warning("FM", "motor temperature error", BAD),
    warning("FD", "driver disabled", BAD),
    warning("FQ", "encoder error", BAD),
    warning("FI", "index error", BAD),
    warning("FA", "analog encoder sync error", BAD),
    warning("FR", "overdrive limit exceeded", BAD),
    warning("FS", "stalled and stopped", BAD),
    warning("FB", "stream bounds error", BAD),
    warning("FP", "interpolated path deviation", BAD),
    warning("FE", "limit error", BAD),
    warning("FT", "excessive twist", BAD),
    warning("WL", "unexpected limit trigger", BAD),
    warning("WV", "voltage out of range", FINE),
    warning("WT", "controller temperature high", FINE),
    warning("WS", "stalled with recovery", BAD),
    warning("WM", "displaced when stationary", BAD),
    warning("WP", "invalid calibration type", BAD),
    warning("WR", "no reference position", BAD),
    warning("WH", "device not homed", BAD),
    warning("NC", "manual control", FINE),
    warning("NI", "movement interrupted", FINE),
    warning("ND", "stream discontinuity", FINE),
    warning("NR", "value rounded", FINE),
    warning("NT", "value truncated", FINE),
    warning("NU", "setting update pending", FINE),
    warning("NJ", "joystick calibrating", FINE),
    warning("NB", "firmware update mode", FINE),
];

/// The warning of two letters; `None` for `--`, and for letters that are in no list.
pub(crate) fn find(letters: &str) -> Option<&'static Warning> {
    WARNINGS.iter().find(|warning| warning.letters == letters)
}

/// The failure of a move that is not begun, by the answer to `warnings`: their number, then each. `None`: a move may begin.
pub(crate) fn worst(answer: &str) -> Option<MotionFailure> {
    let bad = answer.split(' ').skip(1).filter_map(find).find(|warning| warning.is_bad)?;
    Some(bad.failure(bad.trouble()?))
}

/// Letters of the warnings that change nothing.
pub(crate) fn fine() -> Vec<String> {
    let fine = WARNINGS.iter().filter(|warning| !warning.is_bad);
    fine.map(|warning| warning.letters.to_owned()).collect()
}

/// Each bad warning, and its meaning.
pub(crate) fn bad() -> Vec<Flagged> {
    let flagged = |warning: &Warning| Flagged {
        flag: Flags::DEVICE_ERROR,
        texts: vec![warning.letters.to_owned()],
        means: warning.meaning(),
    };
    WARNINGS.iter().filter(|warning| warning.is_bad).map(flagged).collect()
}

impl Warning {
    fn meaning(&self) -> String {
        let trouble = self.trouble().unwrap_or(MotionTrouble::Device);
        format!("{}; {}", self.name, cure(trouble))
    }

    /// The end it puts to a move; `None` where moves go on.
    pub(crate) fn trouble(&self) -> Option<MotionTrouble> {
        match self.letters {
            "WR" | "WH" => Some(MotionTrouble::Unreferenced),
            "FS" | "WS" => Some(MotionTrouble::Stalled),
            "FE" | "WL" => Some(MotionTrouble::Limit),
            "NC" | "NI" | "NJ" | "WM" => Some(MotionTrouble::Interrupted),
            _ => self.is_bad.then_some(MotionTrouble::Device),
        }
    }

    /// Sentence of a move that it ended, or kept from being begun.
    pub(crate) fn failure(&self, trouble: MotionTrouble) -> MotionFailure {
        let (Warning { letters, name, .. }, cure) = (self, cure(trouble));
        MotionFailure::new(trouble, format!("the stage reports {letters}, {name}: {cure}"))
    }
}

const fn cure(trouble: MotionTrouble) -> &'static str {
    match trouble {
        MotionTrouble::Unreferenced => {
            "home the stage, with home = true in [scan.plan] or with Zaber Launcher"
        }
        MotionTrouble::Limit => {
            "move the stage away from its end, and compare the travel in [scan.plan] with the stage's limits"
        }
        MotionTrouble::Stalled => {
            "take away what blocks the stage, or plan less speed, then home it"
        }
        MotionTrouble::Interrupted => {
            "leave knob and other programs alone while asphera moves the stage"
        }
        _ => "see Zaber's manual, then home the stage",
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn letters_are_distinct_and_faults_are_bad() {
        for (index, warning) in WARNINGS.iter().enumerate() {
            assert!(WARNINGS[..index].iter().all(|other| other.letters != warning.letters));
            assert!(!warning.letters.starts_with('F') || warning.is_bad, "{warning:?}");
            assert!(!warning.letters.starts_with('N') || !warning.is_bad, "{warning:?}");
        }
    }
}
