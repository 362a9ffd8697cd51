//! When a reading was taken, on the host's clock.

use std::time::Duration;

use asphera_link::{DeviceClock, Flags, Nanos, Reading};

use crate::clock::{Clock, ClockState, Placed, Stamp};

/// How times of a device are found.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Timekeeping {
    /// The clock its readings carry; `None` to go by the times at which they arrive.
    pub clock: Option<DeviceClock>,
    /// How long after it was taken the fastest reading arrives.
    pub delay: Duration,
    /// Standard uncertainty of times so found, beside that of the clock's line. By arrival it holds all delays.
    pub u: Duration,
}

/// Finds when the readings of one device were taken.
#[derive(Clone, Debug)]
pub struct Keeper {
    timekeeping: Timekeeping,
    clock: Option<Clock>,
    /// What arrives up to then may have waited for the host.
    held_up_until: Nanos,
}

/// Time of a reading as it was taken, to be placed later.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Moment {
    /// By the device's clock.
    Device(Stamp),
    /// By its arrival.
    Arrival(Nanos),
}

impl Keeper {
    /// For a device of which nothing was read yet.
    pub fn new(timekeeping: Timekeeping) -> Keeper {
        let clock = timekeeping.clock.map(Clock::new);
        Keeper { timekeeping, clock, held_up_until: Nanos::ZERO }
    }

    /// Notes the time of a reading, for its clock's figures alone.
    pub fn note(&mut self, reading: &Reading) {
        // A reading without a time says nothing of the clock, nor does one that may be damaged.
        if !reading.flags.contains(Flags::SUSPECT) {
            let _ = self.moment(reading);
        }
    }

    /// The time of a reading as taken; `None` where it has none: the device sent none, or the one of the reading
    /// before, or the host had been held up when it came.
    pub(crate) fn moment(&mut self, reading: &Reading) -> Option<Moment> {
        match &mut self.clock {
            Some(clock) => clock.take(reading.device_time_ns?, reading.host).map(Moment::Device),
            None => (reading.host > self.held_up_until).then_some(Moment::Arrival(reading.host)),
        }
    }

    /// Where it lies on the host's clock. `now` is the newest time: others may still arrive at the same instant.
    pub(crate) fn placed(&self, moment: Moment, now: Nanos) -> Placed {
        let placed = match (moment, &self.clock) {
            (Moment::Device(stamp), Some(clock)) => clock.placed(stamp),
            (Moment::Arrival(at), _) if at < now => {
                Placed::At { ns: at.as_nanos() as f64, u_ns: 0.0 }
            }
            (Moment::Arrival(_), _) => Placed::NotYet,
            (Moment::Device(_), None) => Placed::Never,
        };
        let Placed::At { ns, u_ns } = placed else { return placed };
        let Timekeeping { delay, u, .. } = self.timekeeping;
        let u_ns = u_ns.hypot(u.as_nanos() as f64);
        Placed::At { ns: ns - delay.as_nanos() as f64, u_ns }
    }

    /// The link was lost.
    pub fn interrupted(&mut self) {
        if let Some(clock) = &mut self.clock {
            clock.interrupted();
        }
    }

    /// The host was held up: the times of arrival up to `until` say nothing.
    pub fn held_up(&mut self, until: Nanos) {
        self.held_up_until = self.held_up_until.max(until);
    }

    /// State of the device's clock; `None` where it has none.
    pub fn clock(&self) -> Option<ClockState> {
        self.clock.as_ref().map(Clock::state)
    }
}
