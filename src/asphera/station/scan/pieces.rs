//! The runs of the piece that is measured now.

use std::collections::VecDeque;
use std::time::Duration;

use asphera_plan::{AxisRun, Limits, Piece, PlanError, RunKind, Spacing, axis_runs};

/// Runs of a piece.
#[derive(Debug, Default)]
pub(super) struct Runs {
    runs: VecDeque<AxisRun>,
}

impl Runs {
    /// The runs of a piece, from where the axes stand.
    pub(super) fn begin(
        &mut self,
        piece: Piece,
        spacing: Spacing,
        limits: &Limits,
        axes: [f64; 2],
    ) -> Result<(), PlanError> {
        self.runs = axis_runs(&[(piece, spacing)], limits, axes)?.into();
        Ok(())
    }

    pub(super) fn current(&self) -> Option<&AxisRun> {
        self.runs.front()
    }

    /// The current run is behind.
    pub(super) fn done(&mut self) {
        self.runs.pop_front();
    }

    pub(super) fn measures_on_the_way(run: &AxisRun) -> bool {
        run.kind == RunKind::Line
    }

    pub(super) fn measures_at_its_end(run: &AxisRun) -> bool {
        run.kind == RunKind::Stop
    }

    pub(super) fn text(&self) -> String {
        let words = match self.current().map(|run| run.kind) {
            Some(RunKind::Line) => "measures along a line",
            Some(RunKind::Stop) => "goes to a place to measure",
            Some(RunKind::Transit) | None => "goes to the next line",
        };
        words.to_owned()
    }
}

/// Time after which a run has gone wrong.
pub(super) fn patience(run: &AxisRun) -> Duration {
    Duration::from_secs_f64((2.0 * run.duration_s).min(86_400.0)) + BEYOND
}

/// Time for commands and answers, beside that of the run.
const BEYOND: Duration = Duration::from_secs(2);
