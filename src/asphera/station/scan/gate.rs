//! Points of a plan: those measured on its lines and at its stops, each some way from the last one.

use std::collections::VecDeque;

use asphera_link::{Flags, Nanos};

use crate::station::kinematics::Point;

/// Tells points of the plan from others.
#[derive(Debug)]
pub(super) struct Gate {
    /// No point is nearer to the last one, mm.
    spacing_mm: f64,
    /// When points count: begins, and ends where they have come.
    spans: VecDeque<(Nanos, Option<Nanos>)>,
    last_mm: Option<[f64; 2]>,
    taken: u64,
}

impl Gate {
    pub(super) fn new(spacing_mm: f64) -> Gate {
        Gate { spacing_mm, spans: VecDeque::new(), last_mm: None, taken: 0 }
    }

    /// Points count from now on.
    pub(super) fn begin(&mut self, now: Nanos) {
        self.end(now);
        if self.spans.len() >= SPANS {
            self.spans.pop_front();
        }
        self.spans.push_back((now, None));
    }

    /// Points do not count any more.
    pub(super) fn end(&mut self, now: Nanos) {
        if let Some((_, end @ None)) = self.spans.back_mut() {
            *end = Some(now);
        }
    }

    /// Flags a point that does not count. Points come some time after they were measured.
    pub(super) fn judge(&mut self, point: &mut Point) {
        let is_within = |(begin, end): &(Nanos, Option<Nanos>)| {
            *begin <= point.host && end.is_none_or(|end| point.host <= end)
        };
        if !self.spans.iter().any(is_within) {
            point.flags |= Flags::OFF_PLAN;
            return;
        }
        if !point.is_good() {
            return;
        }
        let [x, y, _] = point.position_mm;
        let is_near = |[x0, y0]: [f64; 2]| (x - x0).hypot(y - y0) < self.spacing_mm;
        if self.last_mm.is_some_and(is_near) {
            point.flags |= Flags::OFF_PLAN;
            return;
        }
        self.last_mm = Some([x, y]);
        self.taken += 1;
    }

    /// Points of the plan so far.
    pub(super) fn taken(&self) -> u64 {
        self.taken
    }
}

/// Spans that late points may belong to.
const SPANS: usize = 256;
