//! Commands that wait for their turn.

use std::collections::VecDeque;

use crate::settings::Settings;

/// Command that waits for its turn.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Step {
    /// Method with its arguments.
    pub(super) text: String,
    pub(super) part: Part,
}

/// Part of the session that a command belongs to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Part {
    /// Before anything is measured.
    SetUp,
    /// The program, or the clearing of errors within it.
    Program,
    /// The end of the session.
    End,
}

impl Step {
    fn new(text: impl Into<String>, part: Part) -> Step {
        Step { text: text.into(), part }
    }

    /// Name of the method.
    pub(super) fn name(&self) -> &str {
        self.text.split(['(', ' ']).next().unwrap_or_default()
    }

    /// The command that clears errors, in a program.
    pub(super) fn clear() -> Step {
        Step::new(CLEAR, Part::Program)
    }
}

/// Commands that begin a session: none of them moves anything.
pub(super) fn set_up(settings: &Settings) -> VecDeque<Step> {
    let columns: Vec<String> = settings.columns().iter().map(|name| format!("{name}()")).collect();
    let columns = columns.join(", ");
    let reports = ["OnPtMeasReport", "OnScanReport"].map(|name| format!("{name}({columns})"));
    let begin = ["StartSession()".to_owned(), CLEAR.to_owned()];
    begin.into_iter().chain(reports).map(|text| Step::new(text, Part::SetUp)).collect()
}

/// Commands of the program.
pub(super) fn program(settings: &Settings) -> VecDeque<Step> {
    let commands = settings.commands.iter().map(|text| Step::new(text.trim(), Part::Program));
    std::iter::once(Step::clear()).chain(commands).collect()
}

/// Commands that end a session; an abort leaves an error to be cleared.
pub(super) fn end(was_aborted: bool) -> VecDeque<Step> {
    let clear = was_aborted.then_some(CLEAR);
    clear.into_iter().chain(["EndSession()"]).map(|text| Step::new(text, Part::End)).collect()
}

const CLEAR: &str = "ClearAllErrors()";
