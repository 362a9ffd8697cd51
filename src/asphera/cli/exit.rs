//! How the process ends.

use std::process::ExitCode;

use crate::report::{Report, Status};

/// Exit codes; the help text lists them. A wrong command line ends with 2, given by its parser.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Exit {
    /// Done; a verdict was given, or none was asked for.
    Done = 0,
    /// A file, a port or a configuration cannot be used.
    Failed = 1,
    /// The measurement ended, but a verdict could not be given.
    Undecided = 3,
}

impl Exit {
    /// Whether the verdict asked for could be given.
    pub(super) fn of(report: &Report, tolerance_given: bool) -> Exit {
        let undecided = report.verdict.status == Status::Undecided;
        if report.form.is_none() || (tolerance_given && undecided) {
            Exit::Undecided
        } else {
            Exit::Done
        }
    }
}

impl From<Exit> for ExitCode {
    fn from(exit: Exit) -> ExitCode {
        ExitCode::from(exit as u8)
    }
}
