//! Joins the readings of several devices that were triggered together.

use std::collections::BTreeMap;
use std::time::Duration;

use asphera_link::{Flags, Nanos, Reading};

use super::gate::{Gate, Pass};
use super::unwrap::{Progress, Unwrapped, Unwrapper, tells_cycle};

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
        // Bytes that may be damaged say nothing about the trigger.
        let count = reading.count.filter(|_| !reading.flags.contains(Flags::SUSPECT));
        let other = self.progress_beside(stream);
        let from_start = self.was_ready_at_the_start(stream);
        let known = count.map(|count| {
            self.streams[stream].modulus = Some(count.modulus);
            self.streams[stream].unwrapper.take(count, reading.host, from_start, other)
        });
        let alone = self.streams.len() == 1;
        let counts = &mut self.streams[stream].counts;
        match known {
            Some(Unwrapped::Known { count, skipped }) => {
                counts.lost += skipped;
                if stream == 0 {
                    self.first_primary.get_or_insert((count, reading.host));
                    self.rate.take(count, reading.host);
                    self.place(stream, count, reading);
                } else {
                    self.admit(stream, count, reading);
                }
            }
            Some(Unwrapped::Repeated) => {
                counts.repeated += 1;
                self.orphan(stream, reading, Flags::AMBIGUOUS_COUNT, out);
            }
            Some(Unwrapped::Ambiguous) => {
                counts.ambiguous += 1;
                self.orphan(stream, reading, Flags::AMBIGUOUS_COUNT, out);
            }
            // One device alone needs no count.
            None if alone => out.push(Record {
                count: None,
                host: reading.host,
                readings: vec![Some(reading)],
                flags: Flags::empty(),
            }),
            None => {
                counts.ambiguous += 1;
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
    fn admit(&mut self, stream: usize, count: u64, reading: Reading) {
        let modulus = reading.count.map_or(2, |count| count.modulus);
        // Above the rate at which host times tell cycles, only the order of the bytes is left to trust.
        let pass = if tells_cycle(self.rate.hz, modulus) {
            let backlogged = self.streams[0].backlogged || self.streams[stream].backlogged;
            let far = self.streams[0]
                .unwrapper
                .latest()
                .filter(|(_, host)| !backlogged && reading.host.since(*host) < PRIMARY_SILENT)
                .map(|(primary, _)| is_far(primary, count, modulus));
            self.streams[stream].gate.judge(far, reading.host)
        } else {
            Pass::Release
        };
        let companion = &mut self.streams[stream];
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
        let companion = &mut self.streams[stream];
        let Some((modulus, (count, _))) = companion.modulus.zip(companion.unwrapper.latest())
        else {
            return;
        };
        if primary.is_some_and(|(primary, _)| is_far(primary, count, modulus)) {
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

    /// Whether a device saw the first trigger: the primary always defines it; a companion must have been
    /// ready before the primary's first reading, and the scan must have begun with that.
    fn was_ready_at_the_start(&self, stream: usize) -> bool {
        let Some((first, at)) = self.first_primary else { return true };
        let ready = self.streams[stream].ready.is_some_and(|ready| ready <= at);
        stream == 0 || (ready && first < START_COUNTS)
    }

    /// Progress of the trigger as seen by the others: by the primary, and for the primary by the companion
    /// that is furthest.
    fn progress_beside(&self, stream: usize) -> Option<Progress> {
        let others = if stream == 0 { 1..self.streams.len() } else { 0..1 };
        others
            .filter_map(|other| self.streams[other].unwrapper.latest())
            .max()
            .map(|(count, host)| Progress { count, host, rate_hz: self.rate.hz })
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
        self.unwrapper.interrupted();
        self.gate.interrupted();
    }
}

/// Half a cycle apart or more.
fn is_far(primary: u64, companion: u64, modulus: u32) -> bool {
    primary.abs_diff(companion) >= u64::from(modulus / 2)
}

/// A primary whose first count is below this saw the beginning of the scan, but for a few losses.
const START_COUNTS: u64 = 60;
/// After this the primary's count says nothing about now.
const PRIMARY_SILENT: Duration = Duration::from_millis(20);

/// Triggers a second, from the primary's counts, over windows of at least 50 ms.
#[derive(Debug, Default)]
struct Rate {
    window: Option<(u64, Nanos)>,
    hz: f64,
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
