//! A CHRocodile 2 on either of its protocols: a point, or a line of them on packets.

use std::sync::Arc;

use asphera_chrocodile::{PacketSettings, Settings, Trigger};
use asphera_link::Channel;
use asphera_sim_chrocodile::{Device, Exposure, Instrument, PacketDevice, Sample, Simulator};
use tokio::net::TcpListener;

use crate::port::next_host;
use crate::showing::Showing;
use crate::sight::Sight;

/// Settings of either protocol.
#[derive(Clone, Debug)]
pub(crate) enum Protocol {
    Dollar(Settings),
    Packets(PacketSettings),
}

impl Protocol {
    /// Why a probe by these settings is not simulated; `None` where it is.
    pub(crate) fn refusal(&self) -> Option<&'static str> {
        match self {
            Protocol::Dollar(Settings { averaging: 2.., .. })
            | Protocol::Packets(PacketSettings { averaging: 2.., .. }) => {
                Some("it averages exposures: with averaging = 1 it is simulated")
            }
            Protocol::Dollar(_) | Protocol::Packets(_) => None,
        }
    }

    /// Exposures a second of a probe that runs by its own clock; `None` where it is triggered.
    pub(crate) fn free_rate_hz(&self) -> Option<f64> {
        let (trigger, rate_hz) = match self {
            Protocol::Dollar(settings) => (settings.trigger, settings.sample_rate_hz),
            Protocol::Packets(settings) => (settings.trigger, settings.sample_rate_hz),
        };
        (trigger == Trigger::Free).then_some(rate_hz)
    }

    /// Full scale of the probe, µm.
    fn full_scale_um(&self) -> f64 {
        let scale_um = match self {
            Protocol::Dollar(settings) => settings.scale_um,
            Protocol::Packets(settings) => settings.scale_um,
        };
        scale_um.unwrap_or(if self.pitch_mm().is_some() { LINE_SCALE_UM } else { FULL_SCALE_UM })
    }

    /// Distance of the points of a line, mm; `None` of a single point.
    pub(crate) fn pitch_mm(&self) -> Option<f64> {
        match self {
            Protocol::Dollar(_) => None,
            Protocol::Packets(settings) => settings.pitch_um.map(|pitch_um| pitch_um * MM_PER_UM),
        }
    }

    /// Smallest and largest distance, mm, with some room at both ends: 0 means that there is no signal.
    pub(crate) fn range_mm(&self) -> (f64, f64) {
        let scale_mm = self.full_scale_um() * MM_PER_UM;
        (ROOM * scale_mm, (1.0 - ROOM) * scale_mm)
    }

    /// What the channel can show, in its unit; `None`: anything.
    pub(crate) fn range(&self, channel: &Channel) -> Option<(f64, f64)> {
        (channel.name == DISTANCE).then(|| self.range_mm())
    }
}

/// The value that is read where this one is sent. Encoders are whole; the distance of a telegram has single precision, which counts as a
/// part of what is measured.
pub(crate) fn shown(channel: &Channel, value: f64) -> f64 {
    if channel.name == DISTANCE { value } else { value.round() }
}

/// The probe at work.
pub(crate) struct Probe {
    device: usize,
    channels: Vec<Channel>,
    /// Of a line, with the distance of its points in mm.
    line: Option<(Sight, f64)>,
    is_free: bool,
    simulator: Simulator,
}

impl Probe {
    /// A probe with its channels, and what it sees of a line.
    pub(crate) fn new(
        device: usize,
        protocol: &Protocol,
        channels: Vec<Channel>,
        sight: Option<Sight>,
    ) -> Probe {
        let scale_um = protocol.full_scale_um();
        let line = sight.zip(protocol.pitch_mm());
        let points = line.as_ref().map_or(1, |(sight, _)| sight.points());
        let points = u16::try_from(points).unwrap_or(u16::MAX);
        let instrument: Instrument = match protocol {
            Protocol::Dollar(_) => Device::new(scale_um).into(),
            Protocol::Packets(_) => PacketDevice::new(scale_um, points).into(),
        };
        let (is_free, simulator) =
            (protocol.free_rate_hz().is_some(), Simulator::new(instrument, QUEUE));
        Probe { device, channels, line, is_free, simulator }
    }

    /// Whether it measures on, whatever the trigger does.
    pub(crate) fn is_free(&self) -> bool {
        self.is_free
    }

    pub(crate) fn is_armed(&self) -> bool {
        self.simulator.armed()
    }

    /// One exposure. Waits while a host that is there does not read.
    pub(crate) async fn trigger(&self, trigger: u64, showing: &Showing) {
        let mut sample = Sample {
            exposure_count: trigger,
            start_ns: (showing.clock_s() * 1e9) as u64,
            ..Sample::default()
        };
        for (channel, value) in self.channels.iter().zip(showing.at(self.device, trigger)) {
            let encoder =
                channel.name.strip_prefix("encoder_").and_then(|axis| axis.chars().next());
            let axis = encoder.and_then(|axis| AXES.iter().position(|known| *known == axis));
            match axis {
                Some(axis) => sample.encoder[axis] = value.round() as i32,
                None if channel.name == DISTANCE => sample.distance_um = Some(value / MM_PER_UM),
                None => {}
            }
        }
        let line_um = self.line.as_ref().map(|(sight, pitch_mm)| {
            let distance_um = |point: usize| {
                let distance_mm = sight.height_mm(trigger, point, point as f64 * pitch_mm)?;
                Some(distance_mm / MM_PER_UM)
            };
            (0..sight.points()).map(distance_um).collect::<Arc<[_]>>()
        });
        if self.simulator.expose(Exposure { sample, line_um }).await.is_err() {
            tracing::debug!(trigger, "the probe runs no more");
        }
    }

    /// Serves one host after the other. Without one its exposures are lost.
    pub(crate) async fn serve(&self, port: TcpListener) {
        loop {
            let host = tokio::select! {
                host = next_host(&port) => host,
                () = self.simulator.lose_exposures() => continue,
            };
            let Some(stream) = host else { return };
            drop(self.simulator.serve(stream).await);
        }
    }
}

const DISTANCE: &str = "distance1";
const AXES: [char; 5] = ['x', 'y', 'z', 'u', 'v'];
/// Of a probe that the configuration leaves to be asked.
const FULL_SCALE_UM: f64 = 10_000.0;
/// Share of the range that is left free at either end.
const ROOM: f64 = 0.05;
/// Of one that measures lines: its distances have 16 bits.
const LINE_SCALE_UM: f64 = 1000.0;
const MM_PER_UM: f64 = 1e-3;
/// Exposures that may wait for a host that does not read.
const QUEUE: usize = 64;
