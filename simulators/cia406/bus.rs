//! A bus of simulated nodes, without a clock or a port.

use asphera_cia406::WireError;
use asphera_cia406::wire::{Cob, NmtRequest, NodeId, sync_frame};
use asphera_link::{CanFrame, Nanos};
use thiserror::Error;

use crate::NodeConfig;
use crate::node::Node;

/// Simulated nodes on one bus.
///
/// Frames in, frames out, time as an argument: the same calls give the same frames. Nodes are named
/// by their place in the list given to [`Bus::new`].
#[derive(Clone, Debug)]
pub struct Bus {
    nodes: Vec<Node>,
}

/// Why a list of nodes is no bus.
#[derive(Clone, Copy, Debug, Error, PartialEq, Eq)]
pub enum BusError {
    /// A number that is none.
    #[error("a node cannot be on the bus")]
    Node(#[from] WireError),
    /// Two nodes with one number.
    #[error("node {0} is there twice")]
    Twice(NodeId),
}

impl Bus {
    /// A bus with these nodes, all just powered on and pre-operational.
    pub fn new(configs: Vec<NodeConfig>) -> Result<Bus, BusError> {
        let mut nodes: Vec<Node> = Vec::with_capacity(configs.len());
        for config in configs {
            let id = NodeId::new(config.node_id)?;
            if nodes.iter().any(|node| node.id() == id) {
                return Err(BusError::Twice(id));
            }
            nodes.push(Node::new(id, config));
        }
        Ok(Bus { nodes })
    }

    /// How many nodes there are.
    pub fn len(&self) -> usize {
        self.nodes.len()
    }

    /// Whether there is no node.
    pub fn is_empty(&self) -> bool {
        self.nodes.is_empty()
    }

    /// Whether every node is operational with its TPDO on: a SYNC would be answered by all.
    pub fn armed(&self) -> bool {
        self.nodes.iter().all(Node::is_armed)
    }

    /// Takes a frame somebody sent, and gives what the nodes send in turn.
    pub fn receive(&mut self, now: Nanos, frame: &CanFrame) -> Vec<CanFrame> {
        match Cob::from_frame(frame) {
            Some(Cob::Nmt) => {
                let Ok(request) = NmtRequest::decode(frame.data()) else { return Vec::new() };
                let named = |node: &&mut Node| request.node.is_none_or(|id| id == node.id());
                self.nodes
                    .iter_mut()
                    .filter(named)
                    .filter_map(|node| node.command(now, request.command))
                    .collect()
            }
            Some(Cob::Sync) => {
                self.nodes.iter_mut().filter_map(|node| node.sync(frame.data())).collect()
            }
            Some(Cob::SdoRequest(id)) => {
                let node = self.nodes.iter_mut().find(|node| node.id() == id);
                node.and_then(|node| node.request(now, frame.data())).into_iter().collect()
            }
            _ => Vec::new(),
        }
    }

    /// Moves each node to its position, in counts, and sends a SYNC: the SYNC, then what the nodes
    /// send. Nodes without a position in the list stay where they are.
    pub fn sync(&mut self, counter: Option<u8>, positions: &[i32]) -> Vec<CanFrame> {
        self.place(positions);
        let sync = sync_frame(counter);
        let mut frames = vec![sync];
        frames.extend(self.nodes.iter_mut().filter_map(|node| node.sync(sync.data())));
        frames
    }

    /// Sets where a node is, in counts, and how fast it moves, in velocity steps.
    ///
    /// # Panics
    ///
    /// Here and below, if there is no such node.
    pub fn set_motion(&mut self, node: usize, position: i32, velocity: i16) {
        self.nodes[node].set_motion(position, velocity);
    }

    /// When [`Bus::timeout`] is to be called.
    pub fn poll_timeout(&self) -> Option<Nanos> {
        self.nodes.iter().filter_map(Node::poll_timeout).min()
    }

    /// What the nodes send by themselves at this time: heartbeats and positions by event timer.
    pub fn timeout(&mut self, now: Nanos) -> Vec<CanFrame> {
        let mut frames = Vec::new();
        self.nodes.iter_mut().for_each(|node| node.timeout(now, &mut frames));
        frames
    }

    /// The same with the nodes at these places, in counts. Nodes without one in the list stay where they are.
    pub(crate) fn timeout_at(&mut self, now: Nanos, positions: &[i32]) -> Vec<CanFrame> {
        self.place(positions);
        self.timeout(now)
    }

    fn place(&mut self, positions: &[i32]) {
        for (node, &position) in self.nodes.iter_mut().zip(positions) {
            node.set_position(position);
        }
    }

    /// Powers a node off and on: its boot-up frame.
    pub fn reboot(&mut self, node: usize) -> CanFrame {
        self.nodes[node].boot()
    }

    /// Gives a node an error, or none with code and register 0: its emergency frame.
    pub fn emergency(&mut self, node: usize, code: u16, register: u8) -> CanFrame {
        self.nodes[node].emergency(code, register)
    }

    /// The next TPDO of a node gets lost.
    pub fn drop_next_tpdo(&mut self, node: usize) {
        self.nodes[node].drop_next_tpdo();
    }
}
