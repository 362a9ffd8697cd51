//! The instrument on either protocol, and what it sees.

use std::sync::Arc;

use crate::{Device, PacketDevice, Sample};

/// What the sensor sees in one exposure, at each of its points.
#[derive(Clone, Debug, PartialEq)]
pub struct Exposure {
    /// Values of the whole exposure; the distance is that of every point, where there is no line.
    pub sample: Sample,
    /// Distances of the points of a line in µm, `None` where there is no peak.
    pub line_um: Option<Arc<[Option<f64>]>>,
}

impl Exposure {
    /// Distance in µm at a point; `None` where there is no peak.
    pub fn distance_um(&self, point: usize) -> Option<f64> {
        match &self.line_um {
            Some(line_um) => line_um.get(point).copied().flatten(),
            None => self.sample.distance_um,
        }
    }
}

impl From<Sample> for Exposure {
    fn from(sample: Sample) -> Exposure {
        Exposure { sample, line_um: None }
    }
}

/// A simulated instrument on one of the protocols.
#[derive(Debug)]
pub enum Instrument {
    /// On the dollar protocol, with one point.
    Dollar(Device),
    /// On the packet protocol.
    Packets(PacketDevice),
}

impl From<Device> for Instrument {
    fn from(device: Device) -> Instrument {
        Instrument::Dollar(device)
    }
}

impl From<PacketDevice> for Instrument {
    fn from(device: PacketDevice) -> Instrument {
        Instrument::Packets(device)
    }
}

/// Calls the same method of either device.
macro_rules! either {
    ($instrument:expr, $device:ident => $call:expr) => {
        match $instrument {
            Instrument::Dollar($device) => $call,
            Instrument::Packets($device) => $call,
        }
    };
}

impl Instrument {
    pub(crate) fn restart(&mut self) {
        either!(self, device => device.restart());
    }

    pub(crate) fn receive(&mut self, bytes: &[u8]) {
        either!(self, device => device.receive(bytes));
    }

    pub(crate) fn transmit(&mut self) -> Vec<u8> {
        either!(self, device => device.transmit())
    }

    pub(crate) fn expose(&mut self, exposure: &Exposure) {
        match self {
            Instrument::Dollar(device) => device.trigger(exposure.sample),
            Instrument::Packets(device) => device.expose(exposure),
        }
    }

    pub(crate) fn lose_exposure(&mut self) {
        either!(self, device => device.lose_exposure());
    }

    pub(crate) fn armed(&self) -> bool {
        either!(self, device => device.armed())
    }

    pub(crate) fn sample_rate_hz(&self) -> f64 {
        either!(self, device => device.sample_rate_hz())
    }

    pub(crate) fn dropped(&self) -> u64 {
        either!(self, device => device.dropped())
    }

    pub(crate) fn drop_next(&mut self) {
        either!(self, device => device.drop_next());
    }

    pub(crate) fn corrupt_next(&mut self) {
        either!(self, device => device.corrupt_next());
    }

    pub(crate) fn inject(&mut self, len: usize, seed: u64) {
        either!(self, device => device.inject(len, seed));
    }

    /// Telegrams of the dollar protocol name no format: nothing happens there.
    pub(crate) fn lose_format(&mut self) {
        if let Instrument::Packets(device) = self {
            device.lose_format();
        }
    }

    /// Exposures that may be taken at once: packets gather them.
    pub(crate) const fn batch(&self) -> usize {
        match self {
            Instrument::Dollar(_) => 1,
            Instrument::Packets(_) => 32,
        }
    }
}
