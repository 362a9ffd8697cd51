//! Which SYNC a position belongs to.

use std::time::Duration;

use asphera_link::{Count, Event, Fault, FaultKind, Flags, Nanos};

use crate::wire::NodeId;

/// Follows the SYNCs of a bus and the positions of one node.
///
/// A SYNC opens a cycle, the first position after it answers it. Everything else is told: a cycle
/// that should have been answered and was not, a position that no SYNC asked for, a counter that
/// jumps or is no counter.
#[derive(Clone, Debug)]
pub(super) struct Cycle {
    node: NodeId,
    /// Highest counter, or `None` where SYNC is not counted.
    overflow: Option<u8>,
    /// The node answers every n-th SYNC.
    every: u8,
    /// How long after a SYNC a position may still be its answer.
    window: Option<Duration>,
    open: Open,
    last_counter: Option<u8>,
    bad_sync: bool,
    /// Whether the node is known to be operational, so that silence means something.
    counting: bool,
    /// SYNCs since the last one answered.
    silent: u64,
    /// Positions missing since the last one that came.
    missing: u64,
}

#[derive(Clone, Copy, Debug)]
enum Open {
    /// No SYNC yet.
    Nothing,
    /// The last SYNC, with its count and its time, waits for a position.
    Asked(Option<Count>, Nanos),
    /// The last SYNC has its position.
    Answered,
}

impl Cycle {
    pub(super) fn new(
        node: NodeId,
        overflow: Option<u8>,
        every: u8,
        window: Option<Duration>,
    ) -> Cycle {
        Cycle {
            node,
            overflow,
            every: every.max(1),
            window,
            open: Open::Nothing,
            last_counter: None,
            bad_sync: false,
            counting: false,
            silent: 0,
            missing: 0,
        }
    }

    /// The node is operational: from the next SYNC on it owes positions.
    pub(super) fn begin(&mut self) {
        self.counting = true;
        self.silent = 0;
        self.missing = 0;
    }

    /// Takes the data of a SYNC.
    pub(super) fn sync(&mut self, now: Nanos, data: &[u8], told: &mut impl Extend<Event>) {
        if let Open::Asked(count, _) = self.open
            && self.counting
            && self.silent > 0
            && self.silent.is_multiple_of(self.every.into())
        {
            self.missing += 1;
            if self.missing == 1 {
                let number = count.map(|count| format!(" {}", count.raw)).unwrap_or_default();
                let detail = format!(
                    "node {} sent no position for SYNC{number}: check the load of the bus",
                    self.node
                );
                told.extend([fault(FaultKind::Timeout, detail)]);
            }
        }
        let (count, passed) = self.count(data, told);
        self.open = Open::Asked(count, now);
        self.silent += passed;
    }

    /// Takes a position: the count it belongs to, and what is wrong with that.
    pub(super) fn position(
        &mut self,
        now: Nanos,
        told: &mut impl Extend<Event>,
    ) -> (Option<Count>, Flags) {
        let (count, asked) = match self.open {
            Open::Asked(count, asked) => (count, asked),
            Open::Nothing => {
                return self.unasked(told, "before any SYNC: check that SYNC is sent");
            }
            Open::Answered => {
                return self.unasked(told, "twice after one SYNC, one is late or a SYNC was lost: check the load of the bus");
            }
        };
        if self.window.is_some_and(|window| now.since(asked) > window) {
            return self.unasked(told, "too long after the last SYNC: check the load of the bus, or increase sync_window_us");
        }
        let flags = if self.missing > 0 { Flags::TRIGGER_LOST } else { Flags::empty() };
        self.close_gap(told);
        self.open = Open::Answered;
        self.silent = 0;
        (count, flags)
    }

    /// The node no longer owes positions. Tells how many are missing.
    pub(super) fn end(&mut self, told: &mut impl Extend<Event>) {
        self.close_gap(told);
        self.counting = false;
    }

    fn unasked(&self, told: &mut impl Extend<Event>, why: &str) -> (Option<Count>, Flags) {
        let detail = format!("node {} sent a position {why}", self.node);
        told.extend([fault(FaultKind::Protocol, detail)]);
        (None, Flags::DELAYED)
    }

    fn close_gap(&mut self, told: &mut impl Extend<Event>) {
        // The first missing position was told when it was found missing; here the whole gap is.
        if self.missing > 1 {
            let detail = format!(
                "node {}: {} positions missing in a row: check the load of the bus",
                self.node, self.missing
            );
            told.extend([fault(FaultKind::Timeout, detail)]);
        }
        self.missing = 0;
    }

    /// The count of a SYNC, and how many SYNCs have passed since the one before, with it.
    fn count(&mut self, data: &[u8], told: &mut impl Extend<Event>) -> (Option<Count>, u64) {
        let Some(overflow) = self.overflow else { return (None, 1) };
        let counter = match *data {
            [counter] if (1..=overflow).contains(&counter) => counter,
            _ => {
                // Once per change: a producer that does not count would tell it at every SYNC.
                if !self.bad_sync {
                    let detail = format!(
                        "SYNC carries {data:02X?}, expected a counter of 1 to {overflow}: set sync_counter_overflow as its producer has it"
                    );
                    told.extend([fault(FaultKind::Protocol, detail)]);
                }
                self.bad_sync = true;
                self.last_counter = None;
                return (None, 1);
            }
        };
        self.bad_sync = false;
        let count = Count { raw: counter.into(), first: 1, modulus: overflow.into() };
        let mut passed = 1;
        if let Some(last) = self.last_counter.replace(counter) {
            let step =
                (u16::from(counter) + u16::from(overflow) - u16::from(last)) % u16::from(overflow);
            // A producer that starts anew begins with 1: no jump.
            if step != 1 && counter != 1 {
                let detail =
                    format!("SYNC {counter} follows SYNC {last}: check the load of the bus");
                told.extend([fault(FaultKind::Protocol, detail)]);
                passed = u64::from(step).max(1);
            }
        }
        (Some(count), passed)
    }
}

fn fault(kind: FaultKind, detail: String) -> Event {
    Event::Fault(Fault { kind, detail })
}

#[cfg(test)]
mod tests {
    use super::*;

    const WINDOW: Duration = Duration::from_millis(5);
    const NOW: Nanos = Nanos::from_millis(100);

    fn cycle(every: u8) -> Cycle {
        let mut cycle = Cycle::new(NodeId::new(5).unwrap(), Some(10), every, Some(WINDOW));
        cycle.begin();
        cycle
    }

    fn details(told: &[Event]) -> Vec<&str> {
        told.iter()
            .map(|event| match event {
                Event::Fault(fault) => fault.detail.as_str(),
                other => panic!("{other:?}"),
            })
            .collect()
    }

    #[test]
    fn a_position_belongs_to_the_sync_before_it() {
        let mut cycle = cycle(1);
        let mut told = Vec::new();
        for round in 0..25_u32 {
            let counter = 1 + (round % 10) as u8;
            cycle.sync(NOW, &[counter], &mut told);
            let count = Count { raw: counter.into(), first: 1, modulus: 10 };
            assert_eq!(cycle.position(NOW, &mut told), (Some(count), Flags::empty()));
        }
        cycle.end(&mut told);
        assert_eq!(told, []);
    }

    #[test]
    fn every_missing_position_is_counted() {
        let mut cycle = cycle(1);
        let mut told = Vec::new();
        (1..=4).for_each(|counter| cycle.sync(NOW, &[counter], &mut told));
        let (count, flags) = cycle.position(NOW, &mut told);
        assert_eq!((count.unwrap().raw, flags), (4, Flags::TRIGGER_LOST));
        assert_eq!(
            details(&told),
            [
                "node 5 sent no position for SYNC 1: check the load of the bus",
                "node 5: 3 positions missing in a row: check the load of the bus"
            ]
        );
        told.clear();
        cycle.sync(NOW, &[5], &mut told);
        assert_eq!(cycle.position(NOW, &mut told).1, Flags::empty());
        assert_eq!(told, []);
    }

    #[test]
    fn every_third_sync_is_owed_a_position() {
        let mut cycle = cycle(3);
        let mut told = Vec::new();
        for counter in 1..=9_u8 {
            cycle.sync(NOW, &[counter], &mut told);
            if counter == 3 {
                assert_eq!(cycle.position(NOW, &mut told).1, Flags::empty());
            }
        }
        assert_eq!(
            details(&told),
            ["node 5 sent no position for SYNC 6: check the load of the bus"]
        );
        cycle.sync(NOW, &[10], &mut told);
        cycle.end(&mut told);
        assert_eq!(
            details(&told)[1..],
            ["node 5: 2 positions missing in a row: check the load of the bus"]
        );
    }

    #[test]
    fn positions_nobody_asked_for_have_no_count() {
        let mut cycle = cycle(1);
        let mut told = Vec::new();
        assert_eq!(cycle.position(NOW, &mut told), (None, Flags::DELAYED));
        cycle.sync(NOW, &[1], &mut told);
        cycle.position(NOW, &mut told);
        assert_eq!(cycle.position(NOW, &mut told), (None, Flags::DELAYED));
        assert!(details(&told)[0].starts_with("node 5 sent a position before any SYNC: check"));
        assert!(details(&told)[1].contains("twice after one SYNC"));
    }

    #[test]
    fn a_counter_that_jumps_is_told_and_one_that_starts_anew_is_not() {
        let mut cycle = cycle(1);
        let mut told = Vec::new();
        for counter in [1, 2, 5, 6, 1, 2] {
            cycle.sync(NOW, &[counter], &mut told);
            cycle.position(NOW, &mut told);
        }
        assert_eq!(details(&told), ["SYNC 5 follows SYNC 2: check the load of the bus"]);
    }

    #[test]
    fn a_sync_without_its_counter_is_told_once() {
        let mut cycle = cycle(1);
        let mut told = Vec::new();
        for data in [&[][..], &[], &[11], &[0], &[1, 2]] {
            cycle.sync(NOW, data, &mut told);
            assert_eq!(cycle.position(NOW, &mut told), (None, Flags::empty()));
        }
        assert_eq!(details(&told).len(), 1);
        assert!(
            details(&told)[0].starts_with("SYNC carries [], expected a counter of 1 to 10: set")
        );
    }

    /// A position lost and the next SYNC lost with it: without the window the next position would be
    /// given the count of the first SYNC.
    #[test]
    fn a_position_after_the_window_is_not_the_answer() {
        let mut cycle = cycle(1);
        let mut told = Vec::new();
        cycle.sync(NOW, &[1], &mut told);
        assert_eq!(cycle.position(NOW + 2 * WINDOW, &mut told), (None, Flags::DELAYED));
        cycle.sync(NOW + 3 * WINDOW, &[3], &mut told);
        let (count, flags) = cycle.position(NOW + 4 * WINDOW, &mut told);
        assert_eq!((count.unwrap().raw, flags), (3, Flags::TRIGGER_LOST));
        assert_eq!(
            details(&told),
            [
                "node 5 sent a position too long after the last SYNC: check the load of the bus, or increase sync_window_us",
                "node 5 sent no position for SYNC 1: check the load of the bus",
                "SYNC 3 follows SYNC 1: check the load of the bus"
            ]
        );
    }
}
