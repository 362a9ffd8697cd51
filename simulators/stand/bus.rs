//! A CAN bus behind an slcan adapter at a TCP port: transducers after CiA 406, drives after CiA 402, and described devices.

use std::sync::Arc;

use asphera_cia406::Settings;
use asphera_link::{CanFrame, Nanos};
use asphera_sim_cia406::{Bus as Nodes, Participant, Simulator};
use tokio::net::TcpListener;
use tokio::time::Instant;

use crate::axes::DriveAxes;
use crate::gauges::Gauges;
use crate::port::next_host;
use crate::showing::Showing;
use crate::transducers;

/// A bus: transducers with their numbers among the devices, and the other devices on it.
pub(crate) struct Bus {
    simulator: Simulator,
    others: Arc<Others>,
}

/// What of the bus sends at other times than a SYNC.
struct Others {
    nodes: Vec<(usize, Settings)>,
    gauges: Gauges,
    drives: Option<Arc<DriveAxes>>,
    showing: Arc<Showing>,
}

impl Bus {
    /// Puts the devices of a bus on it; `None` where two nodes have one number.
    pub(crate) fn new(
        nodes: Vec<(usize, Settings)>,
        gauges: Gauges,
        drives: Option<Arc<DriveAxes>>,
        showing: Arc<Showing>,
    ) -> Option<Bus> {
        let configs = nodes.iter().map(|(_, settings)| transducers::node(settings));
        let mut bus = Nodes::new(configs.collect()).ok()?;
        for (_, settings) in &nodes {
            for frame in transducers::other_master(settings) {
                // Its answers were heard before the station came.
                drop(bus.receive(Nanos::ZERO, &frame));
            }
        }
        let others = Arc::new(Others { nodes, gauges, drives, showing });
        let simulator = Simulator::with_participant(bus, others.clone());
        Some(Bus { simulator, others })
    }

    /// Whether something on the bus sends at the trigger.
    pub(crate) fn is_triggered(&self) -> bool {
        self.has_sync() || self.others.gauges.is_any_triggered()
    }

    fn has_sync(&self) -> bool {
        self.others.nodes.iter().any(|(_, settings)| transducers::is_synchronous(settings))
    }

    pub(crate) fn is_armed(&self) -> bool {
        let drives = self.others.drives.as_ref();
        self.simulator.is_open()
            && self.simulator.armed()
            && self.others.gauges.are_armed()
            && drives.is_none_or(|axes| axes.drives().are_sending())
    }

    /// One SYNC with the positions of all nodes after it, where there are such nodes; then the frames of described devices. What nobody
    /// hears is lost, as on a real bus.
    pub(crate) async fn trigger(&self, trigger: u64, showing: &Showing) {
        if self.has_sync() {
            self.sync(trigger, showing).await;
        }
        let frames = self.others.gauges.frames(trigger);
        if !frames.is_empty() {
            let _delivery = self.simulator.transmit(&frames).await;
        }
    }

    async fn sync(&self, trigger: u64, showing: &Showing) {
        let nodes = &self.others.nodes;
        let positions = positions(nodes, |device| showing.at(device, trigger));
        let overflow = nodes.iter().find_map(|(_, settings)| settings.sync_counter_overflow);
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

/// Places of the nodes in counts.
fn positions(nodes: &[(usize, Settings)], values: impl Fn(usize) -> Vec<f64>) -> Vec<i32> {
    let position = |(device, settings): &(usize, Settings)| {
        transducers::counts(settings, values(*device).first().copied().unwrap_or(0.0))
    };
    nodes.iter().map(position).collect()
}

impl Participant for Others {
    fn opened(&self) {
        self.gauges.opened();
    }

    fn receive(&self, frame: &CanFrame) -> Vec<CanFrame> {
        let mut answers = self.gauges.receive(frame);
        if let Some(axes) = &self.drives {
            answers.extend(axes.drives().receive(frame));
        }
        answers
    }

    fn due(&self) -> Option<Instant> {
        self.drives.as_ref()?.drives().due()
    }

    fn timeout(&self) -> Vec<CanFrame> {
        let Some(axes) = &self.drives else { return Vec::new() };
        if !self.showing.is_moved() {
            axes.push(|device| self.showing.now(device).first().copied().unwrap_or(0.0));
        }
        axes.drives().timeout()
    }

    fn positions(&self) -> Vec<i32> {
        positions(&self.nodes, |device| self.showing.now(device))
    }
}
