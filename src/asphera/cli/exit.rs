//! How the process ends.

use std::process::ExitCode;

use crate::report::{Report, Status};

/// Exit codes; the help text lists them. A wrong command line ends with 2, given by its parser.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Exit {
    /// Done; the part passed, or no limit was given.
    Done = 0,
    /// A file, a port or a configuration cannot be used.
    Failed = 1,
    /// The measurement ended and the part is outside a limit.
    OutOfTolerance = 10,
    /// The measurement ended, but a verdict could not be given.
    Undecided = 11,
}

impl Exit {
    /// The verdict as an exit code. Without a limit that is [`Exit::Done`], if there is a fit.
    pub(super) fn of(report: &Report, tolerance_given: bool) -> Exit {
        match report.verdict.status {
            _ if report.form.is_none() => Exit::Undecided,
            Status::Fail => Exit::OutOfTolerance,
            Status::Undecided if tolerance_given => Exit::Undecided,
            Status::Pass | Status::Undecided => Exit::Done,
        }
    }
}

impl From<Exit> for ExitCode {
    fn from(exit: Exit) -> ExitCode {
        ExitCode::from(exit as u8)
    }
}
