//! An optoNCDT laser sensor: a block of its stream at every trigger.

use std::sync::atomic::{AtomicBool, Ordering};

use asphera_optoncdt::Settings;
use asphera_sim_optoncdt::{Measurement, Sensor};
use tokio::sync::mpsc;

use crate::connection::{QUEUE, Talker};
use crate::showing::Showing;

/// The value that is read where this one is measured: words are whole.
pub(crate) fn shown(settings: &Settings, channel: usize, value: f64) -> f64 {
    match channel {
        DISTANCE => Sensor::new(settings).shown_mm(value).unwrap_or(value),
        _ => value,
    }
}

/// Smallest and largest distance, mm.
pub(crate) fn range(settings: &Settings, channel: usize) -> Option<(f64, f64)> {
    // At the ends a rounded word would be of the reserve.
    let room_mm = ROOM * settings.range_mm;
    (channel == DISTANCE).then_some((room_mm, settings.range_mm - room_mm))
}

/// The sensor at work. It does as it was set up, whatever the host says.
pub(crate) struct Opto {
    device: usize,
    sensor: Sensor,
    /// To the connection. While the host does not read, the scan waits.
    sent: mpsc::Sender<Vec<u8>>,
    has_host: AtomicBool,
}

impl Opto {
    /// A sensor, and what it sends.
    pub(crate) fn new(device: usize, settings: &Settings) -> (Opto, mpsc::Receiver<Vec<u8>>) {
        let (sent, queue) = mpsc::channel(QUEUE);
        let sensor = Sensor::new(settings);
        (Opto { device, sensor, sent, has_host: AtomicBool::new(false) }, queue)
    }

    pub(crate) fn is_armed(&self) -> bool {
        self.has_host.load(Ordering::Relaxed)
    }

    /// Sends a block, where a host is there.
    pub(crate) async fn trigger(&self, trigger: u64, showing: &Showing) {
        if !self.is_armed() {
            return;
        }
        let block = self.sensor.block(Measurement {
            distance_mm: showing.at(self.device, trigger).get(DISTANCE).copied(),
            count: trigger,
            clock_ns: (showing.clock_s() * 1e9) as u64,
        });
        // The connection ends with the stand.
        drop(self.sent.send(block).await);
    }
}

impl Talker for Opto {
    fn connected(&self) {
        self.has_host.store(true, Ordering::Relaxed);
    }

    fn hear(&self, _: &[u8]) -> Vec<u8> {
        Vec::new()
    }

    fn disconnected(&self) {
        self.has_host.store(false, Ordering::Relaxed);
    }
}

/// Number of the channel `distance`.
const DISTANCE: usize = 0;
/// Share of the range that is left free at either end.
const ROOM: f64 = 0.01;
