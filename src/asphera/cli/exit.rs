//! How the process ends.

use std::process::ExitCode;

use asphera_report::{Report, Status};

/// Exit codes; the help text lists them.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Exit {
    /// Done; the part passed, or no limits are given.
    Done = 0,
    /// A file, a port or a configuration cannot be used.
    Failed = 1,
    /// The command line is wrong, as its parser says or as [`misused`](super::usage::misused) does.
    Misused = 2,
    /// The measurement ended and the part is outside a limit.
    OutOfTolerance = 10,
    /// The measurement ended, but a verdict could not be given.
    Undecided = 11,
}

impl Exit {
    /// The verdict as an exit code.
    pub(super) fn of(report: &Report) -> Exit {
        match report.verdict.status {
            Status::Fail => Exit::OutOfTolerance,
            Status::Undecided => Exit::Undecided,
            Status::Pass | Status::None => Exit::Done,
        }
    }

    /// The verdict of two: a fail before one that could not be given.
    pub(super) fn or(self, other: Exit) -> Exit {
        let rank = |exit: Exit| match exit {
            Exit::Done => 0,
            Exit::Undecided => 1,
            Exit::OutOfTolerance => 2,
            Exit::Failed | Exit::Misused => 3,
        };
        if rank(other) > rank(self) { other } else { self }
    }
}

impl From<Exit> for ExitCode {
    fn from(exit: Exit) -> ExitCode {
        ExitCode::from(exit as u8)
    }
}
