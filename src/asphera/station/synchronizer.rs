//! Joins the readings of several devices that were triggered together.

use std::collections::BTreeMap;
use std::time::Duration;

use asphera_link::{Flags, Nanos, Reading};

use super::gate::{Gate, Pass};
use super::unwrap::{Context, Progress, Unwrapped, Unwrapper, tells_cycle};

/// How readings are joined.
#[derive(Clone, Debug, PartialEq)]
pub struct SyncSettings {
    /// How long a reading waits for its companions.
    pub wait: Duration,
    /// How many triggers may wait at once; beyond that the oldest are given up.
    pub capacity: usize,
}

/// What was read at one trigger.
#[derive(Clone, Debug, PartialEq)]
pub struct Record {
    /// Which trigger, from 0; `None` where it could not be told.
    pub count: Option<u64>,
    /// When its first reading arrived.
    pub host: Nanos,
    /// One reading a stream, the primary first. All are there unless [`Record::flags`] says why not.
    pub readings: Vec<Option<Reading>>,
    /// [`Flags::UNJOINED`] or [`Flags::AMBIGUOUS_COUNT`] when a position cannot be given.
    pub flags: Flags,
}

/// What became of the readings of one stream.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct StreamCounts {
    /// Triggers skipped: readings lost before they reached the host.
    pub lost: u64,
    /// Readings without companions.
    pub unjoined: u64,
    /// Readings whose count repeated the one before.
    pub repeated: u64,
    /// Readings whose count was ambiguous or missing.
    pub ambiguous: u64,
    /// Times a whole cycle of the count was found missing.
    pub slips: u64,
}

/// Joins streams on their shared trigger count.
///
/// Stream 0 is the primary: every reading of it becomes a [`Record`], joined or flagged. A reading of
/// another stream (a companion) that finds no primary is counted. Counts of few numbers are watched for
/// lost cycles; see `gate.rs`. Records come in the order of their counts. The wait
/// is bounded in time and number, and everything follows from the readings and their host times, so a
/// recording gives the same records again.
#[derive(Debug)]
pub struct Synchronizer {
    settings: SyncSettings,
    streams: Vec<Stream>,
    pending: BTreeMap<u64, Slot>,
    rate: Rate,
    /// Count and time of the primary's first reading.
    first_primary: Option<(u64, Nanos)>,
}

#[derive(Debug, Default)]
struct Stream {
    unwrapper: Unwrapper,
    gate: Gate,
    held: Vec<(u64, Reading)>,
    /// When its device was first ready.
    ready: Option<Nanos>,
    backlogged: bool,
    /// A loss at a rate at which a lost cycle cannot be told: only the end of the scan settles it.
    unsettled: bool,
    /// Readings without a known count since the last known one: their triggers are not lost.
    orphans: u64,
    modulus: Option<u32>,
    counts: StreamCounts,
}

#[derive(Debug)]
struct Slot {
    since: Nanos,
    readings: Vec<Option<Reading>>,
}

impl Synchronizer {
    /// For `streams` devices, at least one.
    pub fn new(streams: usize, settings: SyncSettings) -> Synchronizer {
        Synchronizer {
            settings,
            streams: (0..streams.max(1)).map(|_| Stream::default()).collect(),
            pending: BTreeMap::new(),
            rate: Rate::default(),
            first_primary: None,
        }
    }

    /// What became of the readings of each stream.
    pub fn counts(&self) -> impl Iterator<Item = StreamCounts> + '_ {
        self.streams.iter().map(|stream| stream.counts)
    }

    /// Triggers waiting for a reading.
    pub fn pending(&self) -> usize {
        self.pending.len()
    }

    /// Whether what is now read of `stream` had piled up before: then its distance from another stream
    /// says nothing.
    pub fn backlogged(&mut self, stream: usize, backlogged: bool) {
        self.streams[stream].backlogged = backlogged;
    }

    /// The device of `stream` is set up and would answer a trigger.
    pub fn ready(&mut self, stream: usize, now: Nanos) {
        self.streams[stream].ready.get_or_insert(now);
    }

    /// The link of `stream` was lost.
    pub fn interrupted(&mut self, stream: usize) {
        let stream = &mut self.streams[stream];
        stream.unwrapper.interrupted();
        stream.gate.interrupted();
    }

    /// Takes a reading of `stream`; what is complete or given up by it goes to `out`.
    pub fn take(&mut self, stream: usize, reading: Reading, out: &mut Vec<Record>) {
        // Bytes that may be damaged say nothing about the trigger, nor do counters without a common zero.
        let usable =
            !reading.flags.contains(Flags::SUSPECT) && (stream == 0 || self.unreset().is_none());
        let context = self.context(stream);
        let known = reading.count.filter(|_| usable).map(|count| {
            self.streams[stream].modulus = Some(count.modulus);
            self.streams[stream].unwrapper.take(count, reading.host, context)
        });
        let alone = self.streams.len() == 1;
        match known {
            Some(Unwrapped::Known { count, skipped }) => {
                let first = stream == 0 && self.first_primary.is_none();
                if first {
                    self.first_primary = Some((count, reading.host));
                }
                let orphans = std::mem::take(&mut self.streams[stream].orphans);
                // What a counter that was not reset counted before the scan is no loss.
                let skipped = if first && count >= START_COUNTS {
                    0
                } else {
                    skipped.saturating_sub(orphans)
                };
                self.streams[stream].counts.lost += skipped;
                if stream == 0 {
                    self.rate.take(count, reading.host);
                    self.place(stream, count, reading);
                } else {
                    self.admit(stream, count, skipped, reading);
                }
            }
            Some(Unwrapped::Repeated) => {
                self.streams[stream].counts.repeated += 1;
                self.orphan(stream, reading, Flags::AMBIGUOUS_COUNT, out);
            }
            Some(Unwrapped::Ambiguous) => {
                self.streams[stream].counts.ambiguous += 1;
                self.orphan(stream, reading, Flags::AMBIGUOUS_COUNT, out);
            }
            // One device alone needs no count.
            None if alone => {
                self.streams[0].orphans += 1;
                out.push(Record {
                    count: None,
                    host: reading.host,
                    readings: vec![Some(reading)],
                    flags: Flags::empty(),
                });
            }
            None => {
                self.streams[stream].counts.ambiguous += 1;
                self.orphan(stream, reading, Flags::UNJOINED, out);
            }
        }
        self.release(reading.host, out);
    }

    /// When [`Synchronizer::timeout`] is to be called.
    pub fn poll_timeout(&self) -> Option<Nanos> {
        Some(self.pending.first_key_value()?.1.since + self.settings.wait)
    }

    /// Gives up what has waited too long.
    pub fn timeout(&mut self, now: Nanos, out: &mut Vec<Record>) {
        self.release(now, out);
    }

    /// Gives up everything that still waits: no more readings will come.
    pub fn flush(&mut self, out: &mut Vec<Record>) {
        for stream in 1..self.streams.len() {
            self.settle(stream);
        }
        while let Some((count, slot)) = self.pending.pop_first() {
            self.emit(count, slot, out);
        }
    }

    /// Joins a companion's reading once its cycle is believed.
    fn admit(&mut self, stream: usize, count: u64, skipped: u64, reading: Reading) {
        let modulus = self.cycle(stream);
        let rate_hz = self.rate.hz;
        let primary = self.streams[0].unwrapper.latest();
        let backlogged = self.streams[0].backlogged || self.streams[stream].backlogged;
        let companion = &mut self.streams[stream];
        let pass = if rate_hz == 0.0 {
            Pass::Release
        } else if tells_cycle(rate_hz, modulus) {
            let far = primary
                .filter(|(_, host)| {
                    let silent = reading.host.since(*host).as_secs_f64();
                    !backlogged && silent * rate_hz <= f64::from(modulus) / 4.0
                })
                .map(|(primary, _)| is_far(primary, count, modulus, rate_hz));
            companion.gate.judge(far, reading.host)
        } else {
            // Above the rate at which host times tell cycles only the order of the bytes is left to trust,
            // and after a loss not even that, until the end shows whether both saw the same last trigger.
            companion.unsettled |= skipped > 0 || matches!(companion.gate, Gate::Proving { .. });
            if companion.unsettled { Pass::Hold } else { Pass::Release }
        };
        companion.held.push((count, reading));
        if companion.held.len() > self.settings.capacity || pass == Pass::Slip {
            companion.slip();
        } else if pass == Pass::Release {
            for (count, reading) in std::mem::take(&mut companion.held) {
                self.place(stream, count, reading);
            }
        }
    }

    /// The scan is over: both devices saw the same last trigger, or a cycle is missing.
    fn settle(&mut self, stream: usize) {
        let primary = self.streams[0].unwrapper.latest();
        let modulus = self.cycle(stream);
        let companion = &mut self.streams[stream];
        let last = companion.unwrapper.latest();
        if let (Some((primary, _)), Some((count, _))) = (primary, last)
            && primary.abs_diff(count) >= u64::from(modulus / 2)
        {
            companion.slip();
        }
        for (count, reading) in std::mem::take(&mut companion.held) {
            self.place(stream, count, reading);
        }
    }

    fn place(&mut self, stream: usize, count: u64, reading: Reading) {
        let streams = self.streams.len();
        let slot = self
            .pending
            .entry(count)
            .or_insert_with(|| Slot { since: reading.host, readings: vec![None; streams] });
        slot.readings[stream] = Some(reading);
    }

    /// A reading that cannot be joined: the primary's still becomes a record, so that it is seen.
    fn orphan(&mut self, stream: usize, reading: Reading, flags: Flags, out: &mut Vec<Record>) {
        self.streams[stream].counts.unjoined += 1;
        self.streams[stream].orphans += 1;
        if stream == 0 {
            let mut readings = vec![None; self.streams.len()];
            readings[0] = Some(reading);
            out.push(Record { count: None, host: reading.host, readings, flags });
        }
    }

    fn release(&mut self, now: Nanos, out: &mut Vec<Record>) {
        // Streams come in order: what all of them have passed will never be completed.
        let passed = self.streams.iter().map(Stream::settled).min().unwrap_or(0);
        while let Some(entry) = self.pending.first_entry() {
            let slot = entry.get();
            let complete = slot.readings.iter().all(Option::is_some);
            let waited = now.since(slot.since) >= self.settings.wait;
            if !complete && *entry.key() >= passed && !waited && !self.is_full() {
                break;
            }
            if let Some((count, slot)) = self.pending.pop_first() {
                self.emit(count, slot, out);
            }
        }
    }

    fn is_full(&self) -> bool {
        self.pending.len() > self.settings.capacity
    }

    fn emit(&mut self, count: u64, slot: Slot, out: &mut Vec<Record>) {
        let complete = slot.readings.iter().all(Option::is_some);
        if !complete {
            for (stream, _) in slot.readings.iter().enumerate().filter(|(_, got)| got.is_some()) {
                self.streams[stream].counts.unjoined += 1;
            }
        }
        if slot.readings[0].is_some() {
            out.push(Record {
                count: Some(count),
                host: slot.since,
                readings: slot.readings,
                flags: if complete { Flags::empty() } else { Flags::UNJOINED },
            });
        }
    }

    /// A companion's cycle: a loss of that many is not seen in its counts. The configuration sees to it that
    /// the primary's is not shorter.
    fn cycle(&self, stream: usize) -> u32 {
        self.streams[stream].modulus.unwrap_or(2)
    }

    /// The primary's first count, if there are companions and it is so large that the counters cannot have
    /// been reset before the scan: then nothing says which of their counts belong together.
    pub fn unreset(&self) -> Option<u64> {
        let (first, _) = self.first_primary?;
        (self.streams.len() > 1 && first >= START_COUNTS).then_some(first)
    }

    fn context(&self, stream: usize) -> Context {
        let ready = self.streams[stream].ready;
        let others = if stream == 0 { 1..self.streams.len() } else { 0..1 };
        Context {
            // The primary defines the start; a companion must have been ready before it.
            from_start: stream == 0
                || self.first_primary.is_none_or(|(_, at)| ready.is_some_and(|ready| ready <= at)),
            alone: self.streams.len() == 1,
            other: others
                .filter_map(|other| self.streams[other].unwrapper.latest())
                .max()
                .map(|(count, host)| Progress { count, host, rate_hz: self.rate.hz }),
            peak_hz: self.rate.peak_hz,
        }
    }
}

impl Stream {
    /// Every reading of a smaller count has been placed or will never come.
    fn settled(&self) -> u64 {
        let held = self.held.first().map(|(count, _)| *count);
        held.or(self.unwrapper.latest().map(|(count, _)| count)).unwrap_or(0)
    }

    /// A cycle is missing: what is held cannot be placed, and the next reading is placed anew.
    fn slip(&mut self) {
        let held = std::mem::take(&mut self.held).len() as u64;
        self.counts.slips += 1;
        self.counts.ambiguous += held;
        self.counts.unjoined += held;
        self.unwrapper.slipped();
        self.gate.interrupted();
    }
}

/// Half a cycle apart, or further than the links' delays explain.
fn is_far(primary: u64, companion: u64, modulus: u32, rate_hz: f64) -> bool {
    let delays = 8 + (rate_hz * LINK_DELAY_S) as u64;
    primary.abs_diff(companion) >= u64::from(modulus / 2).min(delays)
}

/// A primary whose first count is below this saw the beginning of the scan, but for a few losses.
const START_COUNTS: u64 = 60;
/// How much one link may be slower than another: USB adapters collect bytes for 16 ms.
const LINK_DELAY_S: f64 = 0.05;

/// Triggers a second, from the primary's counts, over windows of at least 50 ms.
#[derive(Debug, Default)]
struct Rate {
    window: Option<(u64, Nanos)>,
    hz: f64,
    /// The highest there was.
    peak_hz: f64,
}

impl Rate {
    fn take(&mut self, count: u64, host: Nanos) {
        let Some((from, since)) = self.window else {
            self.window = Some((count, host));
            return;
        };
        let span = host.since(since);
        if span >= Duration::from_millis(50) {
            self.hz = count.saturating_sub(from) as f64 / span.as_secs_f64();
            self.peak_hz = self.peak_hz.max(self.hz);
            self.window = Some((count, host));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use asphera_link::{Count, Values};
    use proptest::prelude::*;

    fn reading(stream: usize, trigger: u64, host: Nanos) -> Reading {
        let (first, modulus) = if stream == 0 { (0, 65_536) } else { (1, 240) };
        Reading {
            host,
            device_time_ns: None,
            count: Some(Count {
                raw: first + (trigger % u64::from(modulus)) as u32,
                first,
                modulus,
            }),
            values: [Some(trigger as f64 + 0.5 * stream as f64)].into_iter().collect::<Values>(),
            flags: Flags::empty(),
        }
    }

    fn settings() -> SyncSettings {
        SyncSettings { wait: Duration::from_millis(500), capacity: 10_000 }
    }

    /// Two devices that are ready before the scan.
    fn armed(settings: SyncSettings) -> Synchronizer {
        let mut sync = Synchronizer::new(2, settings);
        sync.ready(0, Nanos::ZERO);
        sync.ready(1, Nanos::ZERO);
        sync
    }

    fn at(trigger: u64) -> Nanos {
        Nanos::from_nanos(trigger * 250_000)
    }

    fn assert_joined(record: &Record) {
        let count = record.count.unwrap() as f64;
        assert_eq!(record.readings[0].unwrap().values.get(0), Some(count));
        assert_eq!(record.readings[1].unwrap().values.get(0), Some(count + 0.5));
    }

    #[test]
    fn hundred_thousand_triggers_join_through_every_wrap() {
        let mut sync = armed(settings());
        let mut out = Vec::new();
        for trigger in 0..100_000 {
            sync.take(0, reading(0, trigger, at(trigger)), &mut out);
            sync.take(1, reading(1, trigger, at(trigger)), &mut out);
        }
        assert_eq!(out.len(), 100_000);
        out.iter().for_each(assert_joined);
        assert!(sync.counts().all(|counts| counts == StreamCounts::default()));
    }

    #[test]
    fn companion_that_was_gone_for_three_seconds_joins_again_at_the_right_place() {
        let mut sync = armed(settings());
        let mut out = Vec::new();
        for trigger in 0..40_000 {
            let gone = (8_000..20_000).contains(&trigger);
            if trigger == 8_000 {
                sync.interrupted(1);
            }
            while let Some(due) = sync.poll_timeout().filter(|due| *due <= at(trigger)) {
                sync.timeout(due, &mut out);
            }
            sync.take(0, reading(0, trigger, at(trigger)), &mut out);
            if !gone {
                sync.take(1, reading(1, trigger, at(trigger)), &mut out);
            }
        }
        assert_eq!(out.len(), 40_000);
        let (joined, lonely): (Vec<_>, Vec<_>) =
            out.iter().partition(|record| record.flags.is_empty());
        joined.iter().for_each(|record| assert_joined(record));
        assert_eq!((joined.len(), lonely.len()), (28_000, 12_000));
        let counts: Vec<_> = sync.counts().collect();
        assert_eq!((counts[0].unjoined, counts[1].lost), (12_000, 12_000));
    }

    #[test]
    fn cycles_lost_on_an_open_link_are_found_and_never_joined_wrongly() {
        let mut sync = armed(SyncSettings { wait: Duration::from_secs(2), ..settings() });
        let mut out = Vec::new();
        for trigger in 0..20_000 {
            while let Some(due) = sync.poll_timeout().filter(|due| *due <= at(trigger)) {
                sync.timeout(due, &mut out);
            }
            sync.take(0, reading(0, trigger, at(trigger)), &mut out);
            // 700 triggers, nearly three cycles, are gone without a trace on the link.
            if !(8_000..8_700).contains(&trigger) {
                sync.take(1, reading(1, trigger, at(trigger)), &mut out);
            }
        }
        sync.flush(&mut out);
        assert_eq!(out.len(), 20_000);
        let joined: Vec<_> = out.iter().filter(|record| record.flags.is_empty()).collect();
        joined.iter().for_each(|record| assert_joined(record));
        assert!(joined.len() > 16_000, "{}", joined.len());
        assert_eq!(sync.counts().nth(1).unwrap().slips, 1);
    }

    #[test]
    fn a_host_that_was_held_up_joins_everything() {
        for primary_first in [true, false] {
            let mut sync = armed(settings());
            let mut out = Vec::new();
            let mut backlog = Vec::new();
            for trigger in 0..10_000 {
                // 200 ms in which nothing is read, then one link's backlog after the other's.
                if (4_000..4_800).contains(&trigger) {
                    backlog.push(trigger);
                    continue;
                }
                let streams = if primary_first { [0, 1] } else { [1, 0] };
                for stream in streams {
                    for late in &backlog {
                        sync.take(stream, reading(stream, *late, at(trigger)), &mut out);
                    }
                }
                backlog.clear();
                for stream in streams {
                    sync.take(stream, reading(stream, trigger, at(trigger)), &mut out);
                }
            }
            sync.flush(&mut out);
            assert_eq!(out.len(), 10_000);
            out.iter().for_each(|record| assert!(record.flags.is_empty()));
            out.iter().for_each(assert_joined);
        }
    }

    #[test]
    fn a_cycle_lost_beyond_all_rates_shows_at_the_end() {
        let mut sync = armed(settings());
        let mut out = Vec::new();
        for trigger in 0..2_000 {
            sync.take(0, reading(0, trigger, Nanos::ZERO), &mut out);
            if !(500..1_000).contains(&trigger) {
                sync.take(1, reading(1, trigger, Nanos::ZERO), &mut out);
            }
        }
        sync.flush(&mut out);
        assert_eq!(sync.counts().nth(1).unwrap().slips, 1);
    }

    /// Beyond all rates nothing tells the cycle of a device that came late: nothing of it is joined.
    #[test]
    fn a_device_that_comes_late_to_a_fast_scan_is_not_joined_on_a_guess() {
        let mut sync = Synchronizer::new(2, settings());
        sync.ready(0, Nanos::ZERO);
        let fast = |trigger: u64| Nanos::from_nanos(1_000_000 + trigger * 5_000);
        let mut out = Vec::new();
        for trigger in 0..50_000 {
            sync.take(0, reading(0, trigger, fast(trigger)), &mut out);
            if trigger == 20_000 {
                sync.ready(1, fast(trigger));
            }
            if trigger >= 20_000 {
                sync.take(1, reading(1, trigger, fast(trigger)), &mut out);
            }
        }
        sync.flush(&mut out);
        assert_eq!(out.len(), 50_000);
        assert!(out.iter().all(|record| record.flags == Flags::UNJOINED));
        assert_eq!(sync.counts().nth(1).unwrap().ambiguous, 30_000);
    }

    #[test]
    fn counters_that_were_not_reset_are_not_joined_and_cost_nothing_that_was_not_lost() {
        let mut sync = armed(settings());
        let mut out = Vec::new();
        for trigger in 0..20_000 {
            sync.take(0, reading(0, 5_000 + trigger, at(trigger)), &mut out);
            sync.take(1, reading(1, 56 + trigger, at(trigger)), &mut out);
        }
        sync.flush(&mut out);
        assert_eq!(sync.unreset(), Some(5_000));
        assert!(out.iter().all(|record| record.flags == Flags::UNJOINED));
        assert_eq!(sync.counts().next().unwrap().lost, 0);
    }

    /// Beyond all rates a loss leaves the cycle open until both are seen to have had the same last trigger.
    #[test]
    fn a_loss_beyond_all_rates_is_never_joined_on_a_guess() {
        for (lost, end_joins) in [(3, true), (700, false)] {
            let mut sync = armed(SyncSettings { wait: Duration::from_secs(100), ..settings() });
            let fast = |trigger: u64| Nanos::from_nanos(trigger * 20_000);
            let mut out = Vec::new();
            for trigger in 0..10_000 {
                sync.take(0, reading(0, trigger, fast(trigger)), &mut out);
                if !(5_000..5_000 + lost).contains(&trigger) {
                    sync.take(1, reading(1, trigger, fast(trigger)), &mut out);
                }
            }
            sync.flush(&mut out);
            let joined = out.iter().filter(|record| record.flags.is_empty());
            assert_eq!(
                joined.clone().inspect(|record| assert_joined(record)).count() > 6_000,
                end_joins
            );
            assert_eq!(sync.counts().nth(1).unwrap().slips, u64::from(!end_joins));
        }
    }

    #[test]
    fn suspect_readings_are_not_counted_twice() {
        let mut sync = Synchronizer::new(1, settings());
        let mut out = Vec::new();
        for trigger in 0..100 {
            let flags = if trigger % 10 == 5 { Flags::SUSPECT } else { Flags::empty() };
            sync.take(0, Reading { flags, ..reading(0, trigger, at(trigger)) }, &mut out);
        }
        sync.flush(&mut out);
        assert_eq!(out.len(), 100);
        assert_eq!(sync.counts().next().unwrap().lost, 0);
    }

    #[test]
    fn wait_is_bounded_in_number_too() {
        let mut sync = armed(SyncSettings { capacity: 10, ..settings() });
        let mut out = Vec::new();
        (0..100).for_each(|trigger| sync.take(0, reading(0, trigger, at(0)), &mut out));
        assert!(sync.pending() <= 10);
        sync.flush(&mut out);
        assert_eq!(out.len(), 100);
        assert!(out.iter().all(|record| record.flags == Flags::UNJOINED));
    }

    #[test]
    fn suspect_readings_do_not_move_the_count() {
        let mut sync = armed(settings());
        let mut out = Vec::new();
        sync.take(0, reading(0, 0, at(0)), &mut out);
        sync.take(0, Reading { flags: Flags::SUSPECT, ..reading(0, 40_000, at(0)) }, &mut out);
        sync.take(0, reading(0, 1, at(0)), &mut out);
        assert_eq!(sync.counts().next().unwrap().lost, 0);
        assert_eq!(out.len(), 1);
    }

    proptest! {
        /// Whatever is lost on either side and however the two interleave, no reading is joined to a
        /// stranger and every primary reading becomes one record.
        #[test]
        fn nothing_is_joined_wrongly(
            losses in prop::collection::vec((0u8..10, 0u8..10), 1..600),
            lag in 0usize..40,
        ) {
            let mut sync = armed(settings());
            let mut out = Vec::new();
            let mut late = std::collections::VecDeque::new();
            let mut primaries = 0;
            for (trigger, (a, b)) in losses.iter().enumerate() {
                if *a > 0 {
                    primaries += 1;
                    sync.take(0, reading(0, trigger as u64, at(trigger as u64)), &mut out);
                }
                if *b > 0 {
                    late.push_back(trigger as u64);
                }
                if late.len() > lag {
                    let companion = late.pop_front().unwrap();
                    sync.take(1, reading(1, companion, at(trigger as u64)), &mut out);
                }
            }
            sync.flush(&mut out);
            prop_assert_eq!(out.len(), primaries);
            out.iter().filter(|record| record.flags.is_empty()).for_each(assert_joined);
        }
    }
}
