//! Errors of a server: `Error(3, 1008, "00010 GoTo(X(10000000))", "Target position out of machine volume")`.

use std::fmt;

use super::call::{Argument, Call};

/// Error that a server reports.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ServerError {
    /// Severity, F1.
    pub severity: Severity,
    /// Number of four digits, F2. From 8000 on it is the maker's.
    pub number: u16,
    /// Method that reported it, F3.
    pub cause: String,
    /// Sentence of the server.
    pub text: String,
}

/// Severity of an error.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Severity {
    /// 0: nothing is wrong.
    Info,
    /// 1: the command was done, with a change.
    Warning,
    /// 2: the command was not done. No other is done before `ClearAllErrors`.
    Error,
    /// 3: as 2, and a person has to look.
    Critical,
    /// 9: as 2, and the machine has to be mended.
    Fatal,
}

impl Severity {
    /// The severity of a digit. Digits without a meaning count as the next above.
    pub fn from_digit(digit: u8) -> Severity {
        match digit {
            0 => Severity::Info,
            1 => Severity::Warning,
            2 => Severity::Error,
            3 => Severity::Critical,
            _ => Severity::Fatal,
        }
    }

    /// Digit of the protocol.
    pub const fn digit(self) -> u8 {
        match self {
            Severity::Info => 0,
            Severity::Warning => 1,
            Severity::Error => 2,
            Severity::Critical => 3,
            Severity::Fatal => 9,
        }
    }
}

impl ServerError {
    /// The error in the text behind `!`.
    pub fn parse(text: &str) -> Option<ServerError> {
        let call = Call::parse(text).ok()?;
        let [
            Argument::Number(severity),
            Argument::Number(number),
            Argument::Text(cause),
            Argument::Text(text),
        ] = &call.arguments[..]
        else {
            return None;
        };
        let whole = |value: f64, most: f64| {
            (value >= 0.0 && value <= most && value.fract() == 0.0).then_some(value as u16)
        };
        (call.name == "Error").then_some(())?;
        Some(ServerError {
            severity: Severity::from_digit(u8::try_from(whole(*severity, 9.0)?).ok()?),
            number: whole(*number, 9999.0)?,
            cause: cause.clone(),
            text: text.clone(),
        })
    }

    /// Whether a program goes on after it, once the errors are cleared: a probe that touched nothing.
    pub fn is_missed_point(&self) -> bool {
        self.severity == Severity::Error && matches!(self.number, NO_TOUCH | SURFACE_NOT_FOUND)
    }

    /// Whether the command was aborted.
    pub fn is_abort(&self) -> bool {
        self.number == ABORTED
    }

    /// Cure in a few words, as it follows a colon.
    pub fn cure(&self) -> &'static str {
        match self.number {
            ABORTED => "someone aborted it; look at the machine",
            500 => "release the emergency stop and home the machine",
            501 | 507 => "the machine has no such command: correct `commands`",
            502 | 504..=506 | 509 | 510 | 1010 => "correct the command in `commands`",
            503 | 1002 | 1004 | 2503 => "call the maker's service",
            508 | 511 | 514 | 1000 => "look at the machine's own display",
            1001 | 2001 | 2504 => "take away what the probe ran into, then check the probe",
            NO_TOUCH | SURFACE_NOT_FOUND => {
                "check that the part is in its place, and the search long enough"
            }
            1005 => "free the axes, then home the machine",
            1007 | 1008 | 2500 | 2505 => "keep the program within the machine's volume",
            1009 => "check the air supply",
            1500 | 1501 => "seat the probe, then arm it",
            1502 | 1503 => "use the name of a tool that the machine knows",
            2000 => "calibrate the probe",
            2002 => "use a probe that can do this, as a scanning one",
            2501 | 2502 => "home the machine",
            2506 => "align the part first",
            _ => "see the machine's manual",
        }
    }
}

impl fmt::Display for ServerError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let ServerError { severity, number, cause, text } = self;
        write!(f, "Error({}, {number:04}, \"{cause}\", \"{text}\")", severity.digit())
    }
}

const ABORTED: u16 = 6;
const NO_TOUCH: u16 = 1003;
const SURFACE_NOT_FOUND: u16 = 1006;
