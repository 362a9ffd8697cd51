//! Joins readings of several devices: by the count of their trigger, or by time.

use asphera_clocks::{ClockState, Joined, Keeper, TimeJoiner, TimeSettings, Timekeeping};
use asphera_link::{DeviceClock, Flags, Nanos, Reading};

use super::synchronizer::{Record, StreamCounts, SyncSettings, Synchronizer};

/// How readings of several devices are joined.
#[derive(Clone, Debug, PartialEq)]
pub enum JoinSettings {
    /// By the count of the trigger they share.
    Count {
        /// How counts are compared.
        settings: SyncSettings,
        /// The clock of each device, of which figures are given.
        clocks: Vec<Option<DeviceClock>>,
    },
    /// By the times of their readings.
    Time {
        /// How times are found and companions interpolated.
        settings: TimeSettings,
        /// Largest standard uncertainty of a good point along an axis by the joining, mm.
        u_limit_mm: f64,
    },
}

/// Joins readings either way.
#[derive(Debug)]
pub(super) enum Joiner {
    Count { synchronizer: Synchronizer, keepers: Vec<Keeper> },
    Time { joiner: TimeJoiner, joined: Vec<Joined> },
}

impl Joiner {
    pub(super) fn new(streams: usize, settings: JoinSettings) -> Joiner {
        match settings {
            JoinSettings::Count { settings, clocks } => {
                let timekeeping = |clock| Timekeeping { clock, ..Timekeeping::default() };
                Joiner::Count {
                    synchronizer: Synchronizer::new(streams, settings),
                    keepers: clocks.into_iter().map(|of| Keeper::new(timekeeping(of))).collect(),
                }
            }
            JoinSettings::Time { settings, .. } => {
                Joiner::Time { joiner: TimeJoiner::new(settings), joined: Vec::new() }
            }
        }
    }

    /// Takes a reading; what is complete or given up by it goes to `out`.
    pub(super) fn take(&mut self, stream: usize, reading: Reading, out: &mut Vec<Record>) {
        match self {
            Joiner::Count { synchronizer, keepers } => {
                if let Some(keeper) = keepers.get_mut(stream) {
                    keeper.note(&reading);
                }
                synchronizer.take(stream, reading, out);
            }
            Joiner::Time { joiner, joined } => {
                joiner.take(stream, reading, joined);
                out.extend(joined.drain(..).map(record));
            }
        }
    }

    pub(super) fn timeout(&mut self, now: Nanos, out: &mut Vec<Record>) {
        match self {
            Joiner::Count { synchronizer, .. } => synchronizer.timeout(now, out),
            Joiner::Time { joiner, joined } => {
                joiner.timeout(now, joined);
                out.extend(joined.drain(..).map(record));
            }
        }
    }

    /// After `now` no more readings will come.
    pub(super) fn flush(&mut self, now: Nanos, out: &mut Vec<Record>) {
        match self {
            Joiner::Count { synchronizer, .. } => synchronizer.flush(now, out),
            Joiner::Time { joiner, joined } => {
                joiner.flush(joined);
                out.extend(joined.drain(..).map(record));
            }
        }
    }

    pub(super) fn poll_timeout(&self) -> Option<Nanos> {
        match self {
            Joiner::Count { synchronizer, .. } => synchronizer.poll_timeout(),
            Joiner::Time { joiner, .. } => joiner.poll_timeout(),
        }
    }

    /// The host was held up: no reading has waited too long before `until`.
    pub(super) fn held_up(&mut self, until: Nanos) {
        match self {
            Joiner::Count { synchronizer, .. } => synchronizer.put_off(until),
            Joiner::Time { joiner, .. } => joiner.held_up(until),
        }
    }

    /// Whether what is now read of `stream` had piled up before. By time that matters not: a device's clock tells when, and
    /// of several readings by one arrival one is taken.
    pub(super) fn backlogged(&mut self, stream: usize, backlogged: bool) {
        match self {
            Joiner::Count { synchronizer, .. } => synchronizer.backlogged(stream, backlogged),
            Joiner::Time { .. } => {}
        }
    }

    pub(super) fn ready(&mut self, stream: usize, now: Nanos) {
        match self {
            Joiner::Count { synchronizer, .. } => synchronizer.ready(stream, now),
            Joiner::Time { .. } => {}
        }
    }

    /// The link of `stream` was lost.
    pub(super) fn interrupted(&mut self, stream: usize) {
        match self {
            Joiner::Count { synchronizer, keepers } => {
                if let Some(keeper) = keepers.get_mut(stream) {
                    keeper.interrupted();
                }
                synchronizer.interrupted(stream);
            }
            Joiner::Time { joiner, .. } => joiner.interrupted(stream),
        }
    }

    /// Fate of the readings of each stream.
    pub(super) fn counts(&self) -> Vec<StreamCounts> {
        match self {
            Joiner::Count { synchronizer, .. } => synchronizer.counts().collect(),
            Joiner::Time { joiner, .. } => {
                let fates = joiner.fates();
                let counts = fates.map(|fate| StreamCounts {
                    unjoined: fate.unjoined,
                    ambiguous: fate.untimed,
                    ..StreamCounts::default()
                });
                counts.collect()
            }
        }
    }

    /// Clock of each stream; `None` of one that sends no time.
    pub(super) fn clocks(&self) -> Vec<Option<ClockState>> {
        match self {
            Joiner::Count { keepers, .. } => keepers.iter().map(Keeper::clock).collect(),
            Joiner::Time { joiner, .. } => joiner.clocks().collect(),
        }
    }

    /// Triggers that the primary skipped: only a count tells them.
    pub(super) fn lost(&self) -> u64 {
        match self {
            Joiner::Count { synchronizer, .. } => {
                synchronizer.counts().next().map_or(0, |counts| counts.lost)
            }
            Joiner::Time { .. } => 0,
        }
    }

    /// Triggers whose readings still wait for others.
    pub(super) fn pending(&self) -> usize {
        match self {
            Joiner::Count { synchronizer, .. } => synchronizer.pending(),
            Joiner::Time { joiner, .. } => joiner.pending(),
        }
    }

    /// The primary's first count, if the counters had not been reset before the scan.
    pub(super) fn unreset(&self) -> Option<u64> {
        match self {
            Joiner::Count { synchronizer, .. } => synchronizer.unreset(),
            Joiner::Time { .. } => None,
        }
    }
}

fn record(joined: Joined) -> Record {
    let flags = if joined.is_complete() { Flags::empty() } else { Flags::UNJOINED };
    let Joined { number, host, readings, spreads } = joined;
    Record { count: Some(number), host, readings, flags, spreads }
}
