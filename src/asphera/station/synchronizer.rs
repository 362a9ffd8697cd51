//! Joins the readings of several devices that were triggered together.

use std::collections::BTreeMap;
use std::time::Duration;

use asphera_clocks::Spread;
use asphera_link::{Flags, Nanos, Reading};

use super::gate::{Gate, Pass};
use super::rate::Rate;
use super::unwrap::{Context, LATENCY, Progress, Unwrapped, Unwrapper, most_triggers, tells_cycle};

/// How readings are joined.
#[derive(Clone, Debug, PartialEq)]
pub struct SyncSettings {
    /// How long a reading waits for its companions.
    pub wait: Duration,
    /// How many triggers may wait at once; beyond that the oldest are given up.
    pub capacity: usize,
    /// Whether triggers come by a clock of their own, so that the time at which bytes arrive tells of the
    /// trigger. Where they do not, as of a machine that waits for its host, no cycle of a count is told from
    /// host times, and no link is suspected for being late: the order of its bytes is what is known, and
    /// after a loss not even that until the end.
    pub paced: bool,
}

/// Readings at one trigger.
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
    /// Uncertainties of values that are interpolated; none where all were measured at the trigger.
    pub spreads: Vec<Spread>,
}

/// Fate of the readings of one stream.
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
    /// When held readings are looked at again if nothing more arrives.
    recheck: Option<Nanos>,
    /// Before this no wait is over: the host was held up, and companions may lie unread.
    patient_until: Nanos,
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
            recheck: None,
            patient_until: Nanos::ZERO,
        }
    }

    /// Fate of the readings of each stream.
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

    /// The host was held up: no reading has waited too long before `until`.
    pub fn put_off(&mut self, until: Nanos) {
        self.patient_until = until;
    }

    /// The device of `stream` is set up and would answer a trigger.
    pub fn ready(&mut self, stream: usize, now: Nanos) {
        self.streams[stream].ready.get_or_insert(now);
    }

    /// The link of `stream` was lost.
    pub fn interrupted(&mut self, stream: usize) {
        let stream = &mut self.streams[stream];
        // What was held because its cycle was in doubt will not be proved any more.
        if stream.gate != Gate::Open {
            stream.give_up();
        }
        stream.unwrapper.interrupted();
        stream.gate.interrupted();
    }

    /// Takes a reading of `stream`; what is complete or given up by it goes to `out`.
    pub fn take(&mut self, stream: usize, reading: Reading, out: &mut Vec<Record>) {
        let host = reading.host;
        // Bytes that may be damaged say nothing about the trigger, nor do counters without a common zero.
        let usable =
            !reading.flags.contains(Flags::SUSPECT) && (stream == 0 || self.unreset().is_none());
        let context = self.context(stream);
        let before = self.streams[stream].unwrapper.latest();
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
                    for companion in 1..self.streams.len() {
                        self.rejudge(companion, host);
                    }
                } else {
                    // Whether a whole cycle may have passed since the reading before.
                    let silent = before.map(|(_, at)| reading.host.since(at));
                    let most = silent.and_then(|silent| most_triggers(silent, context.peak_hz));
                    let may_hide = skipped > 0
                        && most.is_none_or(|most| most >= u64::from(self.cycle(stream)));
                    self.admit(stream, count, may_hide, reading);
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
                    spreads: Vec::new(),
                });
            }
            None => {
                self.streams[stream].counts.ambiguous += 1;
                self.orphan(stream, reading, Flags::UNJOINED, out);
            }
        }
        let holding = self.streams.iter().any(|stream| !stream.held.is_empty());
        self.recheck = holding.then(|| host + DRAINED);
        self.release(host, out);
    }

    /// When [`Synchronizer::timeout`] is to be called.
    pub fn poll_timeout(&self) -> Option<Nanos> {
        let oldest =
            self.pending.first_key_value().map(|(_, slot)| slot.since + self.settings.wait);
        oldest.into_iter().chain(self.recheck).min()
    }

    /// Gives up what has waited too long. Where nothing has arrived for a while there is no backlog: what was
    /// held for one is judged by where the counts stand.
    pub fn timeout(&mut self, now: Nanos, out: &mut Vec<Record>) {
        if self.recheck.is_some_and(|due| due <= now) {
            self.recheck = None;
            self.streams.iter_mut().for_each(|stream| stream.backlogged = false);
            for stream in 1..self.streams.len() {
                self.rejudge(stream, now);
            }
        }
        self.release(now, out);
    }

    /// Gives up everything that still waits: after `now` no more readings will come.
    pub fn flush(&mut self, now: Nanos, out: &mut Vec<Record>) {
        for stream in 1..self.streams.len() {
            self.settle(stream, now);
        }
        while let Some((count, slot)) = self.pending.pop_first() {
            self.emit(count, slot, out);
        }
    }

    /// Joins a companion's reading once its cycle is believed.
    fn admit(&mut self, stream: usize, count: u64, may_hide: bool, reading: Reading) {
        let companion = &mut self.streams[stream];
        let host = reading.host;
        companion.held.push((count, reading));
        if may_hide && self.rate.hz > 0.0 && !self.tells_cycle(stream) {
            self.streams[stream].unsettled = true;
        }
        if self.streams[stream].held.len() > self.settings.capacity {
            self.streams[stream].slip();
        } else {
            self.judge(stream, host, self.rate.hz == 0.0);
        }
    }

    /// Looks again at a companion whose readings are held.
    fn rejudge(&mut self, stream: usize, now: Nanos) {
        if !self.streams[stream].held.is_empty() {
            self.judge(stream, now, false);
        }
    }

    /// Decides what becomes of the readings held for a companion.
    fn judge(&mut self, stream: usize, now: Nanos, at_once: bool) {
        let modulus = self.cycle(stream);
        let rate_hz = self.rate.hz;
        let tells_cycle = self.tells_cycle(stream);
        let primary = self.streams[0].unwrapper.latest();
        let backlogged = self.streams[0].backlogged || self.streams[stream].backlogged;
        let companion = &mut self.streams[stream];
        let pass = if at_once {
            Pass::Release
        } else if tells_cycle {
            let far = primary.zip(companion.unwrapper.latest()).and_then(|(primary, own)| {
                // Both must be as of now, or stand still together.
                let apart = primary.1.since(own.1).max(own.1.since(primary.1)).as_secs_f64();
                let known = !backlogged && apart * rate_hz <= f64::from(modulus) / 4.0;
                known.then(|| is_far(primary.0, own.0, modulus, rate_hz * (LINK_DELAY_S + apart)))
            });
            companion.gate.judge(far, now)
        } else {
            // Above the rate at which host times tell cycles only the order of the bytes is left to trust,
            // and after a loss not even that, until the end shows whether both saw the same last trigger.
            companion.unsettled |= matches!(companion.gate, Gate::Proving { .. });
            if companion.unsettled { Pass::Hold } else { Pass::Release }
        };
        match pass {
            Pass::Slip => companion.slip(),
            Pass::Hold => {}
            Pass::Release => {
                for (count, reading) in std::mem::take(&mut companion.held) {
                    self.place(stream, count, reading);
                }
            }
        }
    }

    /// The scan is over. Where nothing was on its way any more, both devices saw the same last trigger, or a cycle is
    /// missing.
    fn settle(&mut self, stream: usize, now: Nanos) {
        let primary = self.streams[0].unwrapper.latest();
        let modulus = self.cycle(stream);
        let slow = self.tells_cycle(stream);
        let paced = self.settings.paced;
        let drained = DRAINED.min(self.settings.wait);
        let companion = &mut self.streams[stream];
        let doubted = companion.unsettled || (slow && companion.gate != Gate::Open);
        let Some((primary, own)) = primary.zip(companion.unwrapper.latest()) else { return };
        let apart = primary.0.abs_diff(own.0) >= u64::from(modulus / 2);
        // The last counts can be compared where both were seen to the same end. Host times tell whether they
        // were; where those say nothing, only counts that are the same show it, and no others are believed.
        // A scan may be stopped while it runs: at a high rate more than half a cycle is on its way then.
        let still = now.since(primary.1.max(own.1)) >= drained;
        let together = if paced {
            let near = primary.1.since(own.1).max(own.1.since(primary.1)) <= LATENCY;
            near && (slow || still)
        } else {
            apart || primary.0 == own.0
        };
        if together && apart {
            companion.slip();
        } else if doubted && (slow || !together) {
            companion.give_up();
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
            let host = reading.host;
            let mut readings = vec![None; self.streams.len()];
            readings[0] = Some(reading);
            out.push(Record { count: None, host, readings, flags, spreads: Vec::new() });
        }
    }

    fn release(&mut self, now: Nanos, out: &mut Vec<Record>) {
        // Streams come in order: what all of them have passed will never be completed.
        let passed = self.streams.iter().map(Stream::settled).min().unwrap_or(0);
        while let Some(entry) = self.pending.first_entry() {
            let slot = entry.get();
            let complete = slot.readings.iter().all(Option::is_some);
            let waited = now >= self.patient_until && now.since(slot.since) >= self.settings.wait;
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
                spreads: Vec::new(),
            });
        }
    }

    /// Whether host times tell which cycle a companion's count is in.
    fn tells_cycle(&self, stream: usize) -> bool {
        self.settings.paced && tells_cycle(self.rate.hz, self.cycle(stream))
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
        let paced = self.settings.paced;
        Context {
            // The primary defines the start; a companion must have been ready before it.
            from_start: stream == 0
                || self.first_primary.is_none_or(|(_, at)| ready.is_some_and(|ready| ready <= at)),
            alone: self.streams.len() == 1,
            other: others
                .filter_map(|other| self.streams[other].unwrapper.latest())
                .max()
                .filter(|_| paced)
                .map(|(count, host)| Progress { count, host, rate_hz: self.rate.hz }),
            peak_hz: if paced { self.rate.peak_hz } else { 0.0 },
        }
    }
}

impl Stream {
    /// Every reading of a smaller count has been placed or will never come.
    fn settled(&self) -> u64 {
        let held = self.held.first().map(|(count, _)| *count);
        held.or(self.unwrapper.latest().map(|(count, _)| count)).unwrap_or(0)
    }

    /// What is held cannot be placed.
    fn give_up(&mut self) {
        let held = std::mem::take(&mut self.held).len() as u64;
        self.counts.ambiguous += held;
        self.counts.unjoined += held;
    }

    /// A cycle is missing: what is held cannot be placed, and the next reading is placed anew.
    fn slip(&mut self) {
        self.give_up();
        self.counts.slips += 1;
        self.unwrapper.slipped();
        self.gate.interrupted();
    }
}

/// Half a cycle apart, or further than `delay`, what the links' delays explain, in triggers.
fn is_far(primary: u64, companion: u64, modulus: u32, delay: f64) -> bool {
    primary.abs_diff(companion) >= u64::from(modulus / 2).min(8 + delay as u64)
}

/// A primary whose first count is below this saw the beginning of the scan, but for a few losses.
const START_COUNTS: u64 = 60;
/// After this long without a byte nothing is left in the buffers of ports and adapters.
const DRAINED: Duration = Duration::from_millis(100);
/// How much one link may be slower than another: USB adapters collect bytes for 16 ms.
const LINK_DELAY_S: f64 = 0.05;

#[cfg(test)]
mod tests;
