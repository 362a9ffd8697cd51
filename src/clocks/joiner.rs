//! Joins readings of several devices by time: companions are interpolated at the times of the primary's readings.

use std::collections::VecDeque;
use std::time::Duration;

use asphera_link::{Flags, MAX_CHANNELS, Nanos, Reading};

use crate::clock::{ClockState, Placed};
use crate::keeper::{Keeper, Moment, Timekeeping};
use crate::track::{Between, Question, Track};

/// How readings are joined by time.
#[derive(Clone, Debug, PartialEq)]
pub struct TimeSettings {
    /// How long a reading waits for those of its companions that come after it.
    pub wait: Duration,
    /// How many readings of each device may wait; beyond that the oldest are given up.
    pub capacity: usize,
    /// Longest time between two readings of a companion that is interpolated.
    pub gap: Duration,
    /// Times of each device, the primary first.
    pub devices: Vec<Timekeeping>,
    /// Channels that give coordinates.
    pub coordinates: Vec<Coordinate>,
}

/// A channel that gives a coordinate.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Coordinate {
    /// Which device.
    pub stream: usize,
    /// Which channel of it.
    pub channel: usize,
    /// Values of a full turn, of one that turns: it may begin again after any number of turns. 0 of any other.
    pub turn: f64,
}

/// A reading of the primary with those of its companions at the same time.
#[derive(Clone, Debug, PartialEq)]
pub struct Joined {
    /// Readings of the primary before it.
    pub number: u64,
    /// When it arrived.
    pub host: Nanos,
    /// One reading a device, the primary first; companions interpolated, or none of them.
    pub readings: Vec<Option<Reading>>,
    /// Uncertainties of the interpolated coordinates.
    pub spreads: Vec<Spread>,
}

/// Standard uncertainty of a coordinate that was interpolated.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Spread {
    /// Which device.
    pub stream: usize,
    /// Which channel of it.
    pub channel: usize,
    /// In the unit of the channel; infinite where nothing bounds it.
    pub u: f64,
}

impl Joined {
    /// Whether every companion has a reading.
    pub fn is_complete(&self) -> bool {
        self.readings.iter().all(Option::is_some)
    }
}

/// Fate of the readings of one device.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Fate {
    /// Of the primary, readings without a place; of a companion, readings of the primary that it could not place.
    pub unjoined: u64,
    /// Readings whose time could not be told.
    pub untimed: u64,
}

/// Joins devices by the times of their readings.
///
/// Device 0 is the primary: each reading of it is given once, in order, complete or not. It waits until its companions
/// have readings on both sides of its time, or the wait is over. Nothing is extrapolated, and no gap is bridged that is
/// longer than [`TimeSettings::gap`].
#[derive(Debug)]
pub struct TimeJoiner {
    settings: TimeSettings,
    streams: Vec<Stream>,
    waiting: VecDeque<Waiting>,
    number: u64,
    now: Nanos,
    patient_until: Nanos,
}

#[derive(Debug)]
struct Stream {
    keeper: Keeper,
    track: Track,
    turns: [f64; MAX_CHANNELS],
    fate: Fate,
}

#[derive(Debug)]
struct Waiting {
    moment: Option<Moment>,
    reading: Reading,
}

impl TimeJoiner {
    /// For the devices of the settings.
    pub fn new(settings: TimeSettings) -> TimeJoiner {
        let stream = |(stream, timekeeping): (usize, &Timekeeping)| {
            let mut turns = [0.0; MAX_CHANNELS];
            let of_stream = settings.coordinates.iter().filter(|of| of.stream == stream);
            of_stream.for_each(|of| turns[of.channel] = of.turn);
            let keeper = Keeper::new(*timekeeping);
            Stream { keeper, track: Track::default(), turns, fate: Fate::default() }
        };
        TimeJoiner {
            streams: settings.devices.iter().enumerate().map(stream).collect(),
            settings,
            waiting: VecDeque::new(),
            number: 0,
            now: Nanos::ZERO,
            patient_until: Nanos::ZERO,
        }
    }

    /// Takes a reading of a device; what is complete or given up by it goes to `out`.
    pub fn take(&mut self, stream: usize, reading: Reading, out: &mut Vec<Joined>) {
        self.now = self.now.max(reading.host);
        // What was read before this instant has no other reading of its own to come.
        self.release(false, out);
        // Bytes that may be damaged say nothing of the time, nor of the way.
        let is_usable = !reading.flags.contains(Flags::SUSPECT);
        let of = &mut self.streams[stream];
        let moment = if is_usable { of.keeper.moment(&reading) } else { None };
        if stream == 0 {
            let same = |last: &&mut Waiting| {
                matches!(last.moment, Some(Moment::Arrival(_))) && last.moment == moment
            };
            if let Some(last) = self.waiting.back_mut().filter(same) {
                // Several by one read of the port: the last alone is as new as its arrival.
                last.moment = None;
                of.fate.untimed += 1;
            }
            of.fate.untimed += u64::from(moment.is_none());
            self.waiting.push_back(Waiting { moment, reading });
        } else if let Some(moment) = moment {
            of.track.push(moment, reading, self.settings.capacity);
            if self.waiting.is_empty() {
                let old = self.settings.wait + self.settings.gap + LATEST;
                of.track.forget_before(self.now - old);
            }
        } else {
            of.fate.untimed += 1;
        }
        self.release(false, out);
    }

    /// The link of a device was lost.
    pub fn interrupted(&mut self, stream: usize) {
        self.streams[stream].keeper.interrupted();
        self.streams[stream].track.interrupted();
    }

    /// The host was held up: no reading has waited too long before `until`, and times of arrival up to then say nothing.
    pub fn held_up(&mut self, until: Nanos) {
        self.patient_until = until;
        self.streams.iter_mut().for_each(|stream| stream.keeper.held_up(until));
    }

    /// When [`TimeJoiner::timeout`] is to be called.
    pub fn poll_timeout(&self) -> Option<Nanos> {
        self.waiting.front().map(|waiting| waiting.reading.host + self.settings.wait)
    }

    /// Gives up what has waited too long.
    pub fn timeout(&mut self, now: Nanos, out: &mut Vec<Joined>) {
        self.now = self.now.max(now);
        self.release(false, out);
    }

    /// Gives up everything that still waits: no more readings will come.
    pub fn flush(&mut self, out: &mut Vec<Joined>) {
        self.now = self.now + Duration::from_nanos(1);
        self.release(true, out);
    }

    /// Readings of the primary that wait.
    pub fn pending(&self) -> usize {
        self.waiting.len()
    }

    /// Fate of the readings of each device.
    pub fn fates(&self) -> impl Iterator<Item = Fate> + '_ {
        self.streams.iter().map(|stream| {
            let untimed = stream.fate.untimed + stream.track.untimed;
            Fate { untimed, ..stream.fate }
        })
    }

    /// State of each device's clock; `None` of one without.
    pub fn clocks(&self) -> impl Iterator<Item = Option<ClockState>> + '_ {
        self.streams.iter().map(|stream| stream.keeper.clock())
    }

    /// Hands on what is complete, and what no reading will complete; `all`: everything.
    fn release(&mut self, all: bool, out: &mut Vec<Joined>) {
        while let Some(waiting) = self.waiting.front() {
            let since = waiting.reading.host;
            let waited =
                self.now >= self.patient_until && self.now.since(since) >= self.settings.wait;
            let ends = all || waited || self.waiting.len() > self.settings.capacity;
            let moment = waiting.moment;
            let (companions, waits) = self.companions(moment);
            if waits && !ends {
                break;
            }
            let Some(Waiting { reading, .. }) = self.waiting.pop_front() else { break };
            self.emit(reading, companions, out);
        }
    }

    /// Readings of all companions at a moment of the primary, and whether one that lacks may still come.
    fn companions(&mut self, moment: Option<Moment>) -> (Vec<Found>, bool) {
        let Some((primary, others)) = self.streams.split_first_mut() else {
            return (vec![], false);
        };
        let placed = moment.map_or(Placed::Never, |moment| primary.keeper.placed(moment, self.now));
        let Placed::At { ns, u_ns } = placed else {
            let waits = placed == Placed::NotYet && !others.is_empty();
            return (others.iter().map(|_| None).collect(), waits);
        };
        let mut waits = false;
        let gap_ns = self.settings.gap.as_nanos() as f64;
        let found = others.iter_mut().map(|Stream { keeper, track, turns, .. }| {
            let question = Question { keeper, at_ns: ns, u_ns, gap_ns, turns, now: self.now };
            match track.at(&question) {
                Between::Found(found) => Some((found.reading, found.u)),
                Between::NotYet => {
                    waits = true;
                    None
                }
                Between::Never => None,
            }
        });
        (found.collect(), waits)
    }

    fn emit(&mut self, primary: Reading, companions: Vec<Found>, out: &mut Vec<Joined>) {
        let is_complete = companions.iter().all(Option::is_some);
        self.streams[0].fate.unjoined += u64::from(!is_complete);
        let mut spreads = Vec::new();
        let host = primary.host;
        let mut readings = vec![Some(primary)];
        for (stream, found) in (1..).zip(companions) {
            self.streams[stream].fate.unjoined += u64::from(found.is_none());
            let Some((reading, u)) = found else {
                readings.push(None);
                continue;
            };
            let of_stream = self.settings.coordinates.iter().filter(|of| of.stream == stream);
            spreads.extend(of_stream.map(|of| Spread {
                stream,
                channel: of.channel,
                u: u[of.channel],
            }));
            readings.push(Some(reading));
        }
        out.push(Joined { number: self.number, host, readings, spreads });
        self.number += 1;
    }
}

/// A companion's reading at a time, and the standard uncertainty of each channel.
type Found = Option<(Reading, [f64; MAX_CHANNELS])>;

/// How late a reading of the primary may be that still finds those of its companions.
const LATEST: Duration = Duration::from_secs(1);
