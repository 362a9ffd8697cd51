//! The order of datagrams: a network may lose them, repeat them, and deliver one before another.

use std::collections::VecDeque;
use std::time::Duration;

use asphera_link::Nanos;

/// What tells one profile of a scanner from all others.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Stamp {
    /// Number of the datagram.
    pub(crate) packet: u32,
    /// Number of the measurement.
    pub(crate) measure: u32,
    /// The scanner's clock.
    pub(crate) time_ns: u64,
}

/// A profile in its place.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Placed<T> {
    pub(crate) stamp: Stamp,
    pub(crate) item: T,
    /// Measurements missing before it.
    pub(crate) missing: u32,
    /// Datagrams missing before it.
    pub(crate) missing_packets: u32,
}

/// How a profile came.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Arrival {
    /// After those before it, or waiting for them.
    Ahead,
    /// Before others that came earlier, and in time to be put in its place.
    Overtaken,
    /// After it was given up.
    Late,
    /// A second time.
    Repeated,
    /// With the number of a measurement before, and other content.
    Doubled,
    /// With smaller numbers than before: the scanner started over.
    StartedOver,
}

/// Puts profiles in the order of their measurements.
///
/// Numbers wrap, so of two of them the one less than half of all ahead is the later one. A profile with a gap before it
/// waits: at most so long, and at most [`MOST_WAITING`] of them do. No gap is one that the scanner left itself, with
/// datagrams numbered without a gap.
#[derive(Debug)]
pub(crate) struct Order<T> {
    wait: Duration,
    latest: Option<Stamp>,
    /// Sorted by measurement, each with its arrival.
    waiting: Vec<(Stamp, Nanos, T)>,
    /// Profiles of late, in the order of their arrival.
    recent: VecDeque<Stamp>,
}

impl<T> Order<T> {
    pub(crate) fn new(wait: Duration) -> Order<T> {
        Order { wait, latest: None, waiting: Vec::new(), recent: VecDeque::new() }
    }

    /// Takes a profile; what is in its place now goes to `out`. One that came late, twice or with a used number is given
    /// back with the word for it.
    pub(crate) fn take(
        &mut self,
        now: Nanos,
        stamp: Stamp,
        item: T,
        out: &mut Vec<Placed<T>>,
    ) -> (Arrival, Option<T>) {
        if self.recent.contains(&stamp) {
            return (Arrival::Repeated, Some(item));
        }
        let Some(latest) = self.latest else {
            self.note(stamp);
            self.place(stamp, item, out);
            return (Arrival::Ahead, None);
        };
        if distance(latest.measure, stamp.measure) == 0 {
            self.note(stamp);
            return (Arrival::Doubled, Some(item));
        }
        if !is_ahead(latest.measure, stamp.measure) {
            if self.fits(stamp) {
                self.note(stamp);
                return (Arrival::Late, Some(item));
            }
            self.flush(out);
            self.recent.clear();
            self.note(stamp);
            self.latest = None;
            self.place(stamp, item, out);
            return (Arrival::StartedOver, None);
        }
        self.note(stamp);
        let before = |(waiting, ..): &(Stamp, Nanos, T)| {
            distance(latest.measure, waiting.measure) < distance(latest.measure, stamp.measure)
        };
        let at = self.waiting.partition_point(before);
        if self.waiting.get(at).is_some_and(|(next, ..)| next.measure == stamp.measure) {
            return (Arrival::Doubled, Some(item));
        }
        let arrival = if at < self.waiting.len() { Arrival::Overtaken } else { Arrival::Ahead };
        self.waiting.insert(at, (stamp, now, item));
        self.place_followers(out);
        while self.waiting.len() > MOST_WAITING {
            self.place_first(out);
        }
        self.expire(now, out);
        (arrival, None)
    }

    /// When the first gap is given up.
    pub(crate) fn due(&self) -> Option<Nanos> {
        self.waiting.iter().map(|(_, at, _)| *at + self.wait).min()
    }

    /// Gives up the gaps that were waited for long enough.
    pub(crate) fn expire(&mut self, now: Nanos, out: &mut Vec<Placed<T>>) {
        while self.due().is_some_and(|due| due <= now) {
            self.place_first(out);
        }
    }

    /// Gives up all gaps.
    pub(crate) fn flush(&mut self, out: &mut Vec<Placed<T>>) {
        while !self.waiting.is_empty() {
            self.place_first(out);
        }
    }

    /// Whether a number that was passed belongs to the same run of the scanner: its time lies between its neighbours'.
    fn fits(&self, stamp: Stamp) -> bool {
        let nearest = |is_before: bool| {
            let others = self.recent.iter().filter(move |other| {
                other.measure != stamp.measure
                    && is_ahead(other.measure, stamp.measure) == is_before
            });
            others.min_by_key(move |other| {
                let (from, to) = if is_before {
                    (other.measure, stamp.measure)
                } else {
                    (stamp.measure, other.measure)
                };
                distance(from, to)
            })
        };
        let is_taken = self.recent.iter().any(|other| other.measure == stamp.measure);
        match (nearest(true), nearest(false)) {
            (Some(before), Some(after)) => {
                !is_taken && before.time_ns < stamp.time_ns && stamp.time_ns < after.time_ns
            }
            // The first ones of a connection changed places.
            (None, Some(after)) => {
                !is_taken
                    && distance(stamp.measure, after.measure) < MOST_WAITING as u32
                    && stamp.time_ns < after.time_ns
                    && after.time_ns - stamp.time_ns < START_NS
            }
            (_, None) => false,
        }
    }

    fn note(&mut self, stamp: Stamp) {
        if self.recent.len() == MEMORY {
            self.recent.pop_front();
        }
        self.recent.push_back(stamp);
    }

    fn place_first(&mut self, out: &mut Vec<Placed<T>>) {
        if !self.waiting.is_empty() {
            let (stamp, _, item) = self.waiting.remove(0);
            self.place(stamp, item, out);
            self.place_followers(out);
        }
    }

    fn place_followers(&mut self, out: &mut Vec<Placed<T>>) {
        while let Some((latest, (next, ..))) = self.latest.zip(self.waiting.first()) {
            let follows = distance(latest.measure, next.measure) == 1
                || distance(latest.packet, next.packet) == 1;
            if !follows {
                return;
            }
            let (stamp, _, item) = self.waiting.remove(0);
            self.place(stamp, item, out);
        }
    }

    fn place(&mut self, stamp: Stamp, item: T, out: &mut Vec<Placed<T>>) {
        let missing = |number: fn(Stamp) -> u32| {
            self.latest
                .map_or(0, |latest| distance(number(latest), number(stamp)).saturating_sub(1))
        };
        let (missing, missing_packets) = (missing(|it| it.measure), missing(|it| it.packet));
        self.latest = Some(stamp);
        out.push(Placed { stamp, item, missing, missing_packets });
    }
}

/// How far a wrapping number went.
fn distance(from: u32, to: u32) -> u32 {
    to.wrapping_sub(from)
}

fn is_ahead(from: u32, to: u32) -> bool {
    (1..1 << 31).contains(&distance(from, to))
}

/// Most profiles that wait for others.
pub(crate) const MOST_WAITING: usize = 30;

/// Profiles that are remembered, to know a copy of them and to tell a late one from a restart.
const MEMORY: usize = 256;

/// Time within which the first profiles of a connection may change places, ns of the scanner.
const START_NS: u64 = 1_000_000_000;

#[cfg(test)]
mod tests {
    use super::*;

    fn stamp(measure: u32) -> Stamp {
        Stamp { packet: measure.wrapping_add(7), measure, time_ns: 1000 + 2 * u64::from(measure) }
    }

    struct Run {
        order: Order<u32>,
        placed: Vec<Placed<u32>>,
        arrivals: Vec<Arrival>,
    }

    impl Run {
        fn new(wait_ms: u64) -> Run {
            let order = Order::new(Duration::from_millis(wait_ms));
            Run { order, placed: Vec::new(), arrivals: Vec::new() }
        }

        fn take(&mut self, ms: u64, stamp: Stamp) {
            let now = Nanos::from_millis(ms);
            let (arrival, _) = self.order.take(now, stamp, stamp.measure, &mut self.placed);
            self.arrivals.push(arrival);
        }

        fn places(&self) -> Vec<(u32, u32)> {
            self.placed.iter().map(|placed| (placed.item, placed.missing)).collect()
        }
    }

    #[test]
    fn profiles_that_overtake_wait_for_the_others() {
        let mut run = Run::new(10);
        for (ms, measure) in [(0, 5), (1, 7), (2, 8), (3, 6), (4, 9)] {
            run.take(ms, stamp(measure));
        }
        assert_eq!(run.places(), [(5, 0), (6, 0), (7, 0), (8, 0), (9, 0)]);
        assert_eq!(run.arrivals[3], Arrival::Overtaken);
        assert_eq!(run.order.due(), None);
    }

    #[test]
    fn a_gap_is_given_up_in_time_and_a_late_profile_known() {
        let mut run = Run::new(10);
        run.take(0, stamp(5));
        run.take(1, stamp(8));
        assert_eq!(run.order.due(), Some(Nanos::from_millis(11)));
        run.order.expire(Nanos::from_millis(11), &mut run.placed);
        assert_eq!(run.places(), [(5, 0), (8, 2)]);
        run.take(12, stamp(6));
        run.take(13, stamp(6));
        assert_eq!(
            run.arrivals,
            [Arrival::Ahead, Arrival::Ahead, Arrival::Late, Arrival::Repeated]
        );
        assert_eq!(run.placed.len(), 2);
    }

    #[test]
    fn numbers_that_the_scanner_left_out_are_not_waited_for() {
        let mut run = Run::new(10);
        run.take(0, stamp(5));
        run.take(1, Stamp { packet: 13, ..stamp(9) });
        assert_eq!(run.places(), [(5, 0), (9, 3)]);
        assert_eq!(run.placed[1].missing_packets, 0);
    }

    #[test]
    fn a_scanner_that_started_over_is_no_late_profile() {
        let mut run = Run::new(10);
        for measure in 0..20 {
            run.take(0, stamp(measure));
        }
        run.take(1, Stamp { packet: 3, measure: 3, time_ns: 5 });
        assert_eq!(run.arrivals.last(), Some(&Arrival::StartedOver));
        assert_eq!(run.places().last(), Some(&(3, 0)));
        run.take(2, Stamp { packet: 4, measure: 4, time_ns: 7 });
        assert_eq!(run.places().last(), Some(&(4, 0)));
    }

    #[test]
    fn the_first_profiles_may_change_places() {
        let mut run = Run::new(10);
        for measure in [1, 0, 2] {
            run.take(0, stamp(measure));
        }
        assert_eq!(run.arrivals, [Arrival::Ahead, Arrival::Late, Arrival::Ahead]);
    }

    #[test]
    fn numbers_wrap() {
        let mut run = Run::new(10);
        for measure in [u32::MAX - 1, u32::MAX, 0, 2] {
            run.take(0, Stamp { time_ns: u64::from(measure.wrapping_add(2)), ..stamp(measure) });
        }
        run.order.flush(&mut run.placed);
        assert_eq!(run.places(), [(u32::MAX - 1, 0), (u32::MAX, 0), (0, 0), (2, 1)]);
    }

    #[test]
    fn not_more_wait_than_there_is_room_for() {
        let mut run = Run::new(1000);
        run.take(0, stamp(0));
        for measure in 1..200 {
            run.take(0, stamp(2 * measure));
        }
        assert_eq!(run.placed.len(), 200 - MOST_WAITING);
        assert!(run.placed[1..].iter().all(|placed| placed.missing == 1));
    }
}
