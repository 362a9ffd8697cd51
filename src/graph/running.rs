//! The Point Cloud Graph along the axis of a scan, kept up while points arrive.
//!
//! A strip is closed when the scan has left it and the next one behind. Its pieces become nodes then, and its points are given
//! away or dropped. So a scan without end takes the memory of some strips and of the parts that have not ended.

mod open;
mod strip;

use std::collections::BTreeMap;

use asphera_geometry::PointMm;
use thiserror::Error;

use crate::cloud::{MOST_POINTS, RANGE_MM};
use crate::graph::GraphError;
use crate::slab::Grid;
use open::OpenParts;
pub use open::{Change, PartId, RunningEvent, RunningPart};
pub use strip::{ClosedStrip, RunningNode};
use strip::{Strip, StripPoints};

/// How a scan is parted.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RunningSettings {
    /// The axis along which the scan goes: 0, 1, 2 of x, y, z.
    pub axis: usize,
    /// Whether it goes towards lower coordinates.
    pub is_reversed: bool,
    /// Points nearer than this belong together, mm.
    pub tau_mm: f64,
    /// Width of a strip, mm: τ or more. Strips begin at multiples of it.
    pub strip_mm: f64,
    /// Whether parts keep their points until they end.
    pub keeps_points: bool,
}

/// The graph of the points up to now, and the parts they make.
///
/// Nodes, arcs and parts are those of [`PointGraph`](crate::PointGraph) of all points with the same strips, whatever the batches
/// and the order within a strip.
/// A point behind the closed strips comes too late: it is counted and in no part.
#[derive(Clone, Debug)]
pub struct RunningGraph {
    settings: RunningSettings,
    grid: Grid<3>,
    /// Points farther from 0 have no cell.
    reach_mm: f64,
    /// Points of the strips that are not closed.
    pending: BTreeMap<i64, StripPoints>,
    received: u64,
    late: u64,
    outside: u64,
    /// The strip that was closed last.
    last: Option<Strip>,
    next_node: u64,
    open: OpenParts,
    closed: Vec<ClosedStrip>,
}

impl RunningGraph {
    /// A graph without points.
    ///
    /// # Errors
    ///
    /// τ that is no length above 0; strips narrower than τ, or so narrow that they cannot be numbered; no such axis.
    pub fn new(settings: RunningSettings) -> Result<RunningGraph, RunningError> {
        let RunningSettings { axis, tau_mm, strip_mm, .. } = settings;
        if axis > 2 {
            return Err(RunningError::Axis { axis });
        }
        if tau_mm.is_nan() || tau_mm <= 0.0 || tau_mm.is_infinite() {
            return Err(GraphError::Tau { tau_mm }.into());
        }
        if strip_mm.is_nan() || strip_mm < tau_mm || strip_mm < LEAST_STRIP_MM {
            return Err(RunningError::Strip { strip_mm, tau_mm });
        }
        let grid = Grid::about([0.0; 3], tau_mm).ok_or(GraphError::Tau { tau_mm })?;
        Ok(RunningGraph {
            settings,
            grid,
            reach_mm: (CELLS * tau_mm).min(RANGE_MM),
            pending: BTreeMap::new(),
            received: 0,
            late: 0,
            outside: 0,
            last: None,
            next_node: 0,
            open: OpenParts::default(),
            closed: Vec::new(),
        })
    }

    /// Takes points, and closes the strips that the scan has left behind. Rows count from 0 over all batches.
    ///
    /// # Errors
    ///
    /// More than [`MOST_POINTS`] in a strip.
    pub fn take(&mut self, points: &[PointMm]) -> Result<(), RunningError> {
        let mut left = points;
        while let Some(first) = left.first() {
            let Some(strip) = self.strip_of(first) else {
                self.outside += 1;
                self.received += 1;
                left = &left[1..];
                continue;
            };
            // Points that follow one another are mostly of the same strip.
            let count = left.iter().take_while(|at_mm| self.is_in(at_mm, strip)).count().max(1);
            let (own, others) = left.split_at(count);
            self.put(strip, own)?;
            left = others;
        }
        Ok(())
    }

    /// Puts points into their strip, in the order in which they came.
    fn put(&mut self, strip: i64, points: &[PointMm]) -> Result<(), RunningError> {
        let rows = self.received..self.received + points.len() as u64;
        self.received = rows.end;
        if self.last.as_ref().is_some_and(|last| strip <= last.closed.strip) {
            self.late += points.len() as u64;
            return Ok(());
        }
        let into = self.pending.entry(strip).or_default();
        if into.rows.len() + points.len() > MOST_POINTS {
            return Err(RunningError::Full { strip_mm: self.settings.strip_mm });
        }
        into.rows.extend(rows);
        into.at_mm.extend_from_slice(points);
        // The front moves seldom: it is looked for where there are strips behind the newest two.
        if self.pending.len() > SLACK {
            self.close_behind();
        }
        Ok(())
    }

    /// Closes all strips: nothing more will come. Parts that reach the last strip may have been cut off.
    pub fn finish(&mut self) {
        while let Some((number, points)) = self.pending.pop_first() {
            self.close(number, points);
        }
        self.open.end_all(true);
        self.last = None;
    }

    /// Strips closed since the last call, ascending.
    pub fn take_closed(&mut self) -> Vec<ClosedStrip> {
        std::mem::take(&mut self.closed)
    }

    /// Events since the last call, in the order of the scan.
    pub fn take_events(&mut self) -> Vec<RunningEvent> {
        self.open.take_events()
    }

    /// Parts that ended since the last call, in the order of their ends, then of their numbers.
    pub fn take_ended(&mut self) -> Vec<RunningPart> {
        self.open.take_ended()
    }

    /// Parts that have begun and not ended.
    pub fn open_parts(&self) -> usize {
        self.open.len()
    }

    /// Points taken.
    pub fn received(&self) -> u64 {
        self.received
    }

    /// Points that came when their strip was closed: 0 where the graph is whole.
    pub fn late(&self) -> u64 {
        self.late
    }

    /// Points without a place: no number, or farther from 0 than 6·10⁸ τ or [`RANGE_MM`]. They are in no part.
    pub fn outside(&self) -> u64 {
        self.outside
    }

    /// Points that lie in strips that are not closed.
    pub fn waiting(&self) -> usize {
        self.pending.values().map(|points| points.rows.len()).sum()
    }

    /// How far a place lies along the scan, mm.
    fn along_mm(&self, at_mm: &PointMm) -> f64 {
        let RunningSettings { axis, is_reversed, .. } = self.settings;
        if is_reversed { -at_mm[axis] } else { at_mm[axis] }
    }

    /// Whether a place lies within reach, and in a strip.
    fn is_in(&self, at_mm: &PointMm, strip: i64) -> bool {
        let (along_mm, first, width_mm) =
            (self.along_mm(at_mm), strip as f64, self.settings.strip_mm);
        along_mm >= first * width_mm
            && along_mm < (first + 1.0) * width_mm
            && at_mm.iter().all(|value| value.abs() <= self.reach_mm)
    }

    /// The strip of a place; `None` of one beyond reach.
    fn strip_of(&self, at_mm: &PointMm) -> Option<i64> {
        if !at_mm.iter().all(|value| value.abs() <= self.reach_mm) {
            return None;
        }
        let (along_mm, width_mm) = (self.along_mm(at_mm), self.settings.strip_mm);
        let guess = (along_mm / width_mm).floor();
        let strip = match guess {
            _ if along_mm < guess * width_mm => guess - 1.0,
            _ if along_mm >= (guess + 1.0) * width_mm => guess + 1.0,
            _ => guess,
        };
        Some(strip as i64)
    }

    /// Closes the strips that lie more than one behind the front. A few points ahead of all others, as spikes are, make no front.
    fn close_behind(&mut self) {
        let mut ahead = 0;
        let front = self.pending.iter().rev().find_map(|(&strip, points)| {
            ahead += points.rows.len();
            (ahead >= CONFIRMED).then_some(strip)
        });
        let Some(front) = front else { return };
        while let Some(entry) = self.pending.first_entry() {
            if *entry.key() + (SLACK as i64) > front {
                break;
            }
            let (number, points) = entry.remove_entry();
            self.close(number, points);
        }
    }

    fn close(&mut self, number: i64, points: StripPoints) {
        let below = self.last.take().filter(|last| last.closed.strip + 1 == number);
        if below.is_none() {
            self.open.end_all(false);
        }
        let strip = Strip::new(number, points, below.as_ref(), self.next_node, &self.grid);
        self.next_node += strip.closed.nodes.len() as u64;
        let keeps = self.settings.keeps_points;
        self.open.advance(&strip, below.as_ref().map(|below| below.closed.first_node), keeps);
        self.closed.push(strip.closed.clone());
        self.last = Some(strip);
    }
}

/// Reason why there is no running graph.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum RunningError {
    /// No such axis.
    #[error("axis {axis}: expected 0, 1 or 2 of x, y, z")]
    Axis {
        /// The axis.
        axis: usize,
    },
    /// Strips are too narrow.
    #[error(
        "strips of {strip_mm} mm: expected tau ({tau_mm} mm) or more, and 1e-6 mm at least; take wider strips"
    )]
    Strip {
        /// Their width in mm.
        strip_mm: f64,
        /// τ in mm.
        tau_mm: f64,
    },
    /// τ that is no length, or that does not fit the points.
    #[error(transparent)]
    Graph(#[from] GraphError),
    /// More points in a strip than it takes.
    #[error("more than 40000000 points in a strip of {strip_mm} mm: take narrower strips")]
    Full {
        /// Its width in mm.
        strip_mm: f64,
    },
}

/// Strips between the front and the next one to be closed, that one included.
const SLACK: usize = 2;

/// Points that make a front.
const CONFIRMED: usize = 3;

/// Cells over τ that have numbers: 2³⁰ of the root of a third.
const CELLS: f64 = 6e8;

/// Coordinates of [`RANGE_MM`] have whole numbers of such strips.
const LEAST_STRIP_MM: f64 = 1e-6;
