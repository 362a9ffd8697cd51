//! Described devices on a CAN bus: what they answer, and what they send at a trigger.

use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use asphera_link::CanFrame;

use crate::frame::Moment;
use crate::showing::Showing;
use crate::signals::Signals;

/// Devices of one bus that no profile describes.
pub(crate) struct Gauges {
    showing: Arc<Showing>,
    gauges: Vec<Gauge>,
}

/// A device with its number among all.
struct Gauge {
    device: usize,
    signals: Signals,
    host: Mutex<Host>,
}

/// What the host said to one.
#[derive(Clone, Copy, Debug, Default)]
struct Host {
    has_started: bool,
    has_asked: bool,
}

impl Gauges {
    /// Devices with their numbers.
    pub(crate) fn new(devices: Vec<(usize, Signals)>, showing: Arc<Showing>) -> Gauges {
        let gauge = |(device, signals)| Gauge { device, signals, host: Mutex::default() };
        Gauges { showing, gauges: devices.into_iter().map(gauge).collect() }
    }

    /// Whether one of them sends by itself.
    pub(crate) fn is_any_triggered(&self) -> bool {
        self.gauges.iter().any(Gauge::is_triggered)
    }

    /// Whether a host waits for the readings of all.
    pub(crate) fn are_armed(&self) -> bool {
        self.gauges.iter().all(|gauge| {
            let host = *gauge.host();
            let is_started = host.has_started || gauge.signals.settings().on_start.is_empty();
            is_started && (gauge.is_triggered() || host.has_asked)
        })
    }

    /// Frames of those that send by themselves and were started.
    pub(crate) fn frames(&self, trigger: u64) -> Vec<CanFrame> {
        let sends = |gauge: &&Gauge| {
            let on_start = &gauge.signals.settings().on_start;
            gauge.is_triggered() && (gauge.host().has_started || on_start.is_empty())
        };
        let frame = |gauge: &Gauge| {
            let values = self.showing.at(gauge.device, trigger);
            self.frame(gauge, trigger, &values)
        };
        self.gauges.iter().filter(sends).filter_map(frame).collect()
    }

    fn frame(&self, gauge: &Gauge, trigger: u64, values: &[f64]) -> Option<CanFrame> {
        let clock_s = self.showing.clock_s();
        gauge.signals.frame(&Moment { trigger, clock_s, values, sight: None })
    }
}

impl Gauges {
    /// A host begins.
    pub(crate) fn opened(&self) {
        self.gauges.iter().for_each(|gauge| *gauge.host() = Host::default());
    }

    /// Takes a frame that the host sent, and gives the answers.
    pub(crate) fn receive(&self, frame: &CanFrame) -> Vec<CanFrame> {
        let answer = |gauge: &Gauge| {
            let settings = gauge.signals.settings();
            let mut host = gauge.host();
            if settings.on_start.last() == Some(frame) {
                host.has_started = true;
            } else if settings.on_stop.last() == Some(frame) {
                host.has_started = false;
            }
            settings.poll.filter(|poll| poll.ask == *frame)?;
            host.has_asked = true;
            let values = self.showing.now(gauge.device);
            self.frame(gauge, self.showing.trigger(), &values)
        };
        self.gauges.iter().filter_map(answer).collect()
    }
}

impl Gauge {
    fn is_triggered(&self) -> bool {
        self.signals.settings().poll.is_none()
    }

    fn host(&self) -> MutexGuard<'_, Host> {
        // Whoever panicked left whole values.
        self.host.lock().unwrap_or_else(PoisonError::into_inner)
    }
}
