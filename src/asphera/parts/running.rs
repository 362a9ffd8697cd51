//! The parts of a session while its points arrive.

use asphera_geometry::PointMm;
use asphera_graph::{Change, RunningEvent, RunningGraph, RunningPart};
use asphera_report::parts::{MOST_EVENTS, PartEvent, SessionParts};

use super::PartsPlan;
use super::plan::Judged;

/// The graph of a session with what became of its parts. Whoever drives it measures the parts that ended, in their order.
#[derive(Clone, Debug)]
pub(crate) struct RunningParts {
    graph: RunningGraph,
    found: SessionParts,
}

impl RunningParts {
    pub(crate) fn new(plan: &PartsPlan) -> RunningParts {
        RunningParts { graph: plan.graph(), found: plan.nothing() }
    }

    /// Takes good points, in the order of the scan, and gives the parts that ended.
    pub(crate) fn take(&mut self, points: &[PointMm]) -> Vec<RunningPart> {
        // A strip that is full takes no more: these points count as late ones.
        let before = self.graph.received();
        if self.graph.take(points).is_err() {
            let taken = self.graph.received() - before;
            self.found.late += points.len() as u64 - taken + 1;
        }
        self.noted()
    }

    /// Ends the scan, and gives the parts that ended with it.
    pub(crate) fn finish(&mut self) -> Vec<RunningPart> {
        self.graph.finish();
        self.noted()
    }

    /// Adds what became of a part that ended.
    pub(crate) fn add(&mut self, judged: Judged) {
        self.found.waiting = self.found.waiting.saturating_sub(1);
        self.found.parts.extend(judged.parts);
        self.found.crumbs += judged.crumbs;
        if let Some(points) = judged.island_points {
            self.found.islands += 1;
            self.found.island_points += points;
        }
    }

    /// What is known now.
    pub(crate) fn found(&self) -> SessionParts {
        SessionParts {
            as_of_points: self.graph.received(),
            open: self.graph.open_parts(),
            late: self.found.late + self.graph.late(),
            outside: self.graph.outside(),
            ..self.found.clone()
        }
    }

    fn noted(&mut self) -> Vec<RunningPart> {
        // The figures of single strips are asked for by nobody here.
        drop(self.graph.take_closed());
        self.found.events.extend(self.graph.take_events().into_iter().map(event));
        let more = self.found.events.len().saturating_sub(MOST_EVENTS);
        self.found.events.drain(..more);
        self.found.earlier_events += more as u64;
        let ended = self.graph.take_ended();
        self.found.waiting += ended.len();
        ended
    }
}

fn event(found: RunningEvent) -> PartEvent {
    let (word, branches, merged) = match found.change {
        Change::Begun => ("begun", None, Vec::new()),
        Change::Split { branches } => ("split", Some(branches), Vec::new()),
        Change::Joined { branches } => ("joined", Some(branches), Vec::new()),
        Change::Merged { absorbed } => ("merged", None, absorbed),
        Change::Ended => ("ended", None, Vec::new()),
    };
    let event = word.to_owned();
    PartEvent { part: found.part, event, at_mm: found.at_mm, branches, merged }
}
