//! A CAN bus behind an slcan adapter at a TCP port: transducers after CiA 406, and described devices.

use asphera_cia406::wire::object;
use asphera_cia406::{Kind, PositionObject, Settings, Transmission};
use asphera_sim_cia406::{Bus, NodeConfig, Simulator};
use tokio::net::TcpListener;

use std::sync::Arc;

use crate::gauges::Gauges;
use crate::port::next_host;
use crate::showing::Showing;

/// Why a node by these settings is not simulated; `None` where it is.
pub(crate) fn refusal(settings: &Settings) -> Option<&'static str> {
    if settings.listen_only {
        return Some("another master sets it up, and there is none here: remove listen_only");
    }
    match (settings.transmission, settings.kind) {
        (Transmission::EventTimer { .. }, _) => {
            Some("it sends by a timer of its own, without SYNC")
        }
        (Transmission::Sync { every: 2.. }, _) => Some("it answers some of the SYNCs only"),
        (_, Kind::Rotary { .. }) => Some("it turns: with kind = \"counts\" it is simulated"),
        (Transmission::Sync { .. }, Kind::Linear { .. } | Kind::Counts) => None,
    }
}

/// Length of a count in the unit of the channel.
fn step(settings: &Settings) -> f64 {
    match settings.kind {
        Kind::Linear { .. } => f64::from(step_nm(settings)) / NM_PER_MM,
        Kind::Counts | Kind::Rotary { .. } => 1.0,
    }
}

/// Step that the node says it has, nm.
fn step_nm(settings: &Settings) -> u32 {
    match settings.kind {
        Kind::Linear { step_nm: Some(step_nm) } if step_nm >= 1.0 => step_nm.round() as u32,
        _ => NodeConfig::default().position_step_nm,
    }
}

/// The value that is read where this one is sent.
pub(crate) fn shown(settings: &Settings, value: f64) -> f64 {
    f64::from(counts(settings, value)) * step(settings)
}

fn counts(settings: &Settings, value: f64) -> i32 {
    (value / step(settings)).round() as i32
}

/// A bus: transducers with their numbers among the devices, and the other devices on it.
pub(crate) struct Transducers {
    simulator: Simulator,
    nodes: Vec<(usize, Settings)>,
    gauges: Arc<Gauges>,
}

impl Transducers {
    /// Puts the devices on a bus; `None` where two nodes have one number.
    pub(crate) fn new(nodes: Vec<(usize, Settings)>, gauges: Gauges) -> Option<Transducers> {
        let gauges = Arc::new(gauges);
        let config = |(_, settings): &(usize, Settings)| NodeConfig {
            node_id: settings.node_id,
            vendor_id: settings.vendor_id.unwrap_or(NodeConfig::default().vendor_id),
            position: match settings.position {
                PositionObject::MultiSensor => object::POSITION_1,
                PositionObject::Single | PositionObject::SingleUnsigned => object::POSITION,
            },
            position_step_nm: step_nm(settings),
            ..NodeConfig::default()
        };
        let bus = Bus::new(nodes.iter().map(config).collect()).ok()?;
        let simulator = Simulator::with_participant(bus, gauges.clone());
        Some(Transducers { simulator, nodes, gauges })
    }

    /// Whether something on the bus sends by itself.
    pub(crate) fn is_triggered(&self) -> bool {
        !self.nodes.is_empty() || self.gauges.is_any_triggered()
    }

    pub(crate) fn is_armed(&self) -> bool {
        self.simulator.is_open() && self.simulator.armed() && self.gauges.are_armed()
    }

    /// One SYNC with the positions of all nodes after it, where there are nodes; then the frames of the other devices. What nobody hears
    /// is lost, as on a real bus.
    pub(crate) async fn trigger(&self, trigger: u64, showing: &Showing) {
        if !self.nodes.is_empty() {
            self.sync(trigger, showing).await;
        }
        let frames = self.gauges.frames(trigger);
        if !frames.is_empty() {
            let _delivery = self.simulator.transmit(&frames).await;
        }
    }

    async fn sync(&self, trigger: u64, showing: &Showing) {
        let position = |(device, settings): &(usize, Settings)| {
            counts(settings, showing.at(*device, trigger).first().copied().unwrap_or(0.0))
        };
        let positions: Vec<i32> = self.nodes.iter().map(position).collect();
        let overflow = self.nodes.iter().find_map(|(_, settings)| settings.sync_counter_overflow);
        let counter = overflow.map(|overflow| (trigger % u64::from(overflow)) as u8 + 1);
        let _delivery = self.simulator.sync(counter, &positions).await;
    }

    /// Serves one host after the other.
    pub(crate) async fn serve(self: Arc<Self>, port: TcpListener) {
        while let Some(stream) = next_host(&port).await {
            // A host that goes away in the middle of a frame is no trouble of the bus.
            drop(self.simulator.serve(stream).await);
        }
    }
}

const NM_PER_MM: f64 = 1e6;
