//! One device's clock against the host's: offset, drift, jitter, jumps and wraps.

use std::time::Duration;

use asphera_link::{DeviceClock, Nanos};

use crate::envelope::{Envelope, Line};

/// Follows the clock of one device.
///
/// A device time is *placed* on the host's clock by the line below all pairs (see `envelope.rs`): the host time at which the
/// reading would have arrived without delay, but for the least delay there is. That one cannot be told from offsets, so
/// the configuration states it.
///
/// Before [`SETTLED_PAIRS`] pairs over [`SETTLED_SPAN`] nothing is placed. A reading that arrives earlier than possible proves
/// that the clock jumped; then all begins anew. One that arrives very late proves nothing: either it waited in a buffer,
/// and one in time follows, or the clock went back. Until that is known no such reading is placed. A jump smaller than
/// 1 ms and five times the jitter stays unseen.
#[derive(Clone, Debug)]
pub struct Clock {
    facts: DeviceClock,
    run: Option<Run>,
    former: Option<Former>,
    runs: u32,
    wraps: u64,
    jumps: u64,
    repeated: u64,
}

/// A device time as it was taken, to be placed later, when the clock is known better.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stamp {
    /// Which run of the clock, from one jump to the next.
    run: u32,
    /// Device time since the first of the run, ns.
    x_ns: f64,
}

/// A time on the host's monotonic clock.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Placed {
    /// It is known.
    At {
        /// Since the start of the session, ns.
        ns: f64,
        /// Its standard uncertainty, ns.
        u_ns: f64,
    },
    /// It may be known later.
    NotYet,
    /// It will not be known.
    Never,
}

/// State of a device's clock against the host's.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ClockState {
    /// Host time less device time at the newest reading, s; `None` before it is known.
    pub offset_s: Option<f64>,
    /// How much the device's clock gains, in millionths.
    pub drift_ppm: Option<f64>,
    /// Standard uncertainty of the drift.
    pub u_drift_ppm: Option<f64>,
    /// Standard uncertainty of a device time on the host's clock, s.
    pub u_s: Option<f64>,
    /// Standard deviation of the delays with which readings arrive, s.
    pub jitter_s: Option<f64>,
    /// Times the counter of the clock began again at its zero.
    pub wraps: u64,
    /// Times the clock jumped.
    pub jumps: u64,
    /// Readings that had the time of the reading before.
    pub repeated: u64,
}

/// The time from one jump to the next.
#[derive(Clone, Debug)]
struct Run {
    number: u32,
    /// The first pair.
    first_device_ns: u64,
    first_host: Nanos,
    /// The newest pair: device time as sent, and unwrapped since the first.
    last_device_ns: u64,
    last_x_ns: f64,
    last_host: Nanos,
    envelope: Envelope,
    pairs: u64,
    delays: Delays,
    /// Newest device time that is believed.
    believed_x_ns: f64,
    doubt: Option<Doubt>,
}

/// Readings that arrive late, one after the other.
#[derive(Clone, Copy, Debug)]
struct Doubt {
    since: Nanos,
    readings: u32,
}

/// A run that is over.
#[derive(Clone, Copy, Debug)]
struct Former {
    number: u32,
    first_host: Nanos,
    line: Line,
    believed_x_ns: f64,
}

/// Delays beyond the least, their number, mean and squares.
#[derive(Clone, Copy, Debug, Default)]
struct Delays {
    count: f64,
    mean_ns: f64,
    squares: f64,
}

impl Clock {
    /// A clock of which nothing was read yet.
    pub fn new(facts: DeviceClock) -> Clock {
        Clock { facts, run: None, former: None, runs: 0, wraps: 0, jumps: 0, repeated: 0 }
    }

    /// Takes the time of a reading that arrived at `host`; `None` where it has the time of the reading before.
    pub fn take(&mut self, device_ns: u64, host: Nanos) -> Option<Stamp> {
        let Some(run) = &mut self.run else { return Some(self.begin(device_ns, host)) };
        if device_ns == run.last_device_ns && host.since(run.last_host) < STANDS_STILL {
            self.repeated += 1;
            return None;
        }
        let Some(elapsed_ns) = run.elapsed_ns(device_ns, host, self.facts.wraps_ns) else {
            return Some(self.jump(device_ns, host));
        };
        let x_ns = run.last_x_ns + elapsed_ns;
        let y_ns = nanos_between(host, run.first_host) - x_ns;
        if let Some(late_ns) = run.line().map(|line| y_ns - line.at_ns(x_ns)) {
            let limits = run.limits();
            if late_ns < -limits.early_ns {
                return Some(self.jump(device_ns, host));
            }
            if late_ns > limits.late_ns {
                let doubt = run.doubt.get_or_insert(Doubt { since: host, readings: 0 });
                doubt.readings += 1;
                if doubt.readings >= DOUBTED && host.since(doubt.since) >= PATIENCE {
                    return Some(self.jump(device_ns, host));
                }
                self.wraps += u64::from(device_ns < run.last_device_ns);
                run.go_on(device_ns, x_ns, host);
                return Some(Stamp { run: run.number, x_ns });
            }
            run.delays.take(late_ns.max(0.0));
        }
        self.wraps += u64::from(device_ns < run.last_device_ns);
        run.go_on(device_ns, x_ns, host);
        run.doubt = None;
        run.believed_x_ns = x_ns;
        run.pairs += 1;
        run.envelope.take(x_ns, y_ns);
        Some(Stamp { run: run.number, x_ns })
    }

    /// The link was lost: the device may have started anew.
    pub fn interrupted(&mut self) {
        self.end_run();
    }

    /// Where a stamp lies on the host's clock, as far as that is known now.
    pub fn placed(&self, stamp: Stamp) -> Placed {
        let known = match (&self.run, &self.former) {
            (Some(run), _) if run.number == stamp.run => {
                let waits = run.doubt.is_some() && stamp.x_ns > run.believed_x_ns;
                run.line()
                    .filter(|_| !waits)
                    .map(|line| (line, run.first_host))
                    .ok_or(Placed::NotYet)
            }
            (_, Some(former)) if former.number == stamp.run => {
                let is_believed = stamp.x_ns <= former.believed_x_ns;
                is_believed.then_some((former.line, former.first_host)).ok_or(Placed::Never)
            }
            _ => Err(Placed::Never),
        };
        let (line, first_host) = match known {
            Ok(known) => known,
            Err(placed) => return placed,
        };
        // A time that was cut to whole ticks is half a tick old on average.
        let tick_ns = self.facts.tick_ns as f64;
        let ns = first_host.as_nanos() as f64 + stamp.x_ns + line.at_ns(stamp.x_ns) + tick_ns / 2.0;
        Placed::At { ns, u_ns: line.u_ns.hypot(tick_ns / 12_f64.sqrt()) }
    }

    /// State of the clock at the newest reading.
    pub fn state(&self) -> ClockState {
        let line = self.run.as_ref().and_then(|run| Some((run, run.line()?)));
        let of_line =
            |value: &dyn Fn(&Run, &Line) -> f64| line.map(|(run, line)| value(run, &line));
        ClockState {
            offset_s: of_line(&|run, line| {
                let ahead = run.first_host.as_nanos() as f64 - run.first_device_ns as f64;
                (ahead + line.at_ns(run.last_x_ns)) * 1e-9
            }),
            drift_ppm: of_line(&|_, line| (1.0 / (1.0 + line.slope()) - 1.0) * 1e6),
            u_drift_ppm: of_line(&|_, line| line.u_slope / (1.0 + line.slope()).powi(2) * 1e6),
            u_s: of_line(&|_, line| {
                line.u_ns.hypot(self.facts.tick_ns as f64 / 12_f64.sqrt()) * 1e-9
            }),
            jitter_s: of_line(&|run, _| run.delays.deviation_ns() * 1e-9),
            wraps: self.wraps,
            jumps: self.jumps,
            repeated: self.repeated,
        }
    }

    /// Which run of the clock a stamp belongs to: between two of different runs nothing is known.
    pub(crate) fn run_of(stamp: Stamp) -> u32 {
        stamp.run
    }

    fn jump(&mut self, device_ns: u64, host: Nanos) -> Stamp {
        self.jumps += 1;
        self.end_run();
        self.begin(device_ns, host)
    }

    fn end_run(&mut self) {
        let Some(run) = self.run.take() else { return };
        self.former = run.line().map(|line| Former {
            number: run.number,
            first_host: run.first_host,
            line,
            believed_x_ns: run.believed_x_ns,
        });
    }

    fn begin(&mut self, device_ns: u64, host: Nanos) -> Stamp {
        self.runs += 1;
        let mut envelope = Envelope::new();
        envelope.take(0.0, 0.0);
        self.run = Some(Run {
            number: self.runs,
            first_device_ns: device_ns,
            first_host: host,
            last_device_ns: device_ns,
            last_x_ns: 0.0,
            last_host: host,
            envelope,
            pairs: 1,
            delays: Delays::default(),
            believed_x_ns: 0.0,
            doubt: None,
        });
        Stamp { run: self.runs, x_ns: 0.0 }
    }
}

/// How far from the line a pair may lie, ns.
struct Limits {
    early_ns: f64,
    late_ns: f64,
}

impl Run {
    /// The line, once there is enough behind it.
    fn line(&self) -> Option<Line> {
        let span_ns = SETTLED_SPAN.as_nanos() as f64;
        let is_settled = self.pairs >= SETTLED_PAIRS && self.believed_x_ns >= span_ns;
        self.envelope.line().filter(|_| is_settled)
    }

    fn limits(&self) -> Limits {
        let u_ns = self.envelope.line().map_or(0.0, |line| line.u_ns);
        Limits {
            early_ns: LEAST_JUMP_NS + 10.0 * u_ns,
            late_ns: LEAST_JUMP_NS + 10.0 * u_ns + 5.0 * self.delays.deviation_ns(),
        }
    }

    /// Device time since the newest pair; `None` where the clock went back, and no wrap explains that, or leapt.
    fn elapsed_ns(&self, device_ns: u64, host: Nanos, wraps_ns: Option<u64>) -> Option<f64> {
        let host_ns = nanos_between(host, self.last_host);
        let Some(wraps_ns) = wraps_ns.filter(|wraps_ns| (1..=u64::MAX / 2).contains(wraps_ns))
        else {
            let elapsed_ns = device_ns.checked_sub(self.last_device_ns)? as f64;
            return (elapsed_ns - host_ns <= MOST_LEAP.as_nanos() as f64).then_some(elapsed_ns);
        };
        let ahead_ns =
            (device_ns % wraps_ns + wraps_ns - self.last_device_ns % wraps_ns) % wraps_ns;
        let (ahead_ns, turn_ns) = (ahead_ns as f64, wraps_ns as f64);
        let turns = ((host_ns - ahead_ns) / turn_ns).round().max(0.0);
        let elapsed_ns = ahead_ns + turns * turn_ns;
        let doubt_ns = (turn_ns / 4.0).min(MOST_DELAY.as_nanos() as f64);
        ((elapsed_ns - host_ns).abs() <= doubt_ns).then_some(elapsed_ns)
    }

    fn go_on(&mut self, device_ns: u64, x_ns: f64, host: Nanos) {
        (self.last_device_ns, self.last_x_ns, self.last_host) = (device_ns, x_ns, host);
    }
}

impl Delays {
    fn take(&mut self, delay_ns: f64) {
        self.count += 1.0;
        let off = delay_ns - self.mean_ns;
        self.mean_ns += off / self.count;
        self.squares += off * (delay_ns - self.mean_ns);
    }

    fn deviation_ns(&self) -> f64 {
        (self.squares / self.count.max(1.0)).sqrt()
    }
}

/// Host time from one instant to a later one, or less than 0, in ns.
fn nanos_between(later: Nanos, earlier: Nanos) -> f64 {
    later.since(earlier).as_nanos() as f64 - earlier.since(later).as_nanos() as f64
}

/// Pairs before a device time is placed …
pub const SETTLED_PAIRS: u64 = 16;
/// … and the time they must span.
pub const SETTLED_SPAN: Duration = Duration::from_millis(500);
/// A clock that shows one time for longer stands still, or came round.
const STANDS_STILL: Duration = Duration::from_secs(1);
/// How long readings may all be late before their clock is taken to have gone back …
const PATIENCE: Duration = Duration::from_secs(1);
/// … and how many they must be.
const DOUBTED: u32 = 8;
/// How long a link or a host may hold readings back.
const MOST_DELAY: Duration = Duration::from_secs(10);
/// A clock that goes so much further than the host's from one reading to the next is another clock.
const MOST_LEAP: Duration = Duration::from_secs(3600);
/// A jump below this is not told from delays.
const LEAST_JUMP_NS: f64 = 1e6;
