//! Network management, heartbeat and SYNC.

use std::fmt;

use asphera_link::CanFrame;

use crate::{Cob, NodeId, WireError, frame};

/// What a master tells a node (CiA 301, section 7.2.8.2.1; MTS p.27).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum NmtCommand {
    /// 01h: operational; PDOs flow.
    Start,
    /// 02h: stopped; only network management is heard.
    Stop,
    /// 80h: pre-operational; SDO but no PDO.
    EnterPreOperational,
    /// 81h: start as after power-on.
    ResetNode,
    /// 82h: communication objects (1000h to 1FFFh) as after power-on.
    ResetCommunication,
}

/// A command and whom it is for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct NmtRequest {
    /// The command.
    pub command: NmtCommand,
    /// The node, or all of them.
    pub node: Option<NodeId>,
}

/// State of a node as its heartbeat says it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum NmtState {
    /// 00h: the node has just started. Sent once.
    BootUp,
    /// 04h.
    Stopped,
    /// 05h.
    Operational,
    /// 7Fh.
    PreOperational,
}

impl NmtCommand {
    /// All of them.
    pub const ALL: [NmtCommand; 5] = [
        NmtCommand::Start,
        NmtCommand::Stop,
        NmtCommand::EnterPreOperational,
        NmtCommand::ResetNode,
        NmtCommand::ResetCommunication,
    ];

    /// The command specifier.
    pub const fn specifier(self) -> u8 {
        match self {
            NmtCommand::Start => 0x01,
            NmtCommand::Stop => 0x02,
            NmtCommand::EnterPreOperational => 0x80,
            NmtCommand::ResetNode => 0x81,
            NmtCommand::ResetCommunication => 0x82,
        }
    }
}

impl NmtRequest {
    /// A command for one node.
    pub const fn to(node: NodeId, command: NmtCommand) -> NmtRequest {
        NmtRequest { command, node: Some(node) }
    }

    /// The frame: specifier, node (0 for all).
    pub fn encode(self) -> CanFrame {
        frame(Cob::Nmt, &[self.command.specifier(), self.node.map_or(0, NodeId::get)])
    }

    /// Reads the data of an NMT frame.
    pub fn decode(data: &[u8]) -> Result<NmtRequest, WireError> {
        let &[specifier, node] = data else {
            return Err(WireError::Length { cob: Cob::Nmt, expected: 2, found: data.len() });
        };
        let command = NmtCommand::ALL
            .into_iter()
            .find(|command| command.specifier() == specifier)
            .ok_or(WireError::Value { cob: Cob::Nmt, found: specifier })?;
        let node = if node == 0 { None } else { Some(NodeId::new(node)?) };
        Ok(NmtRequest { command, node })
    }
}

impl NmtState {
    /// The byte of the heartbeat.
    pub const fn byte(self) -> u8 {
        match self {
            NmtState::BootUp => 0x00,
            NmtState::Stopped => 0x04,
            NmtState::Operational => 0x05,
            NmtState::PreOperational => 0x7F,
        }
    }

    /// Reads the data of the heartbeat of `node`.
    pub fn decode(node: NodeId, data: &[u8]) -> Result<NmtState, WireError> {
        let cob = Cob::Heartbeat(node);
        match *data {
            [0x00] => Ok(NmtState::BootUp),
            [0x04] => Ok(NmtState::Stopped),
            [0x05] => Ok(NmtState::Operational),
            [0x7F] => Ok(NmtState::PreOperational),
            [found] => Err(WireError::Value { cob, found }),
            _ => Err(WireError::Length { cob, expected: 1, found: data.len() }),
        }
    }
}

impl fmt::Display for NmtState {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            NmtState::BootUp => "booting",
            NmtState::Stopped => "stopped",
            NmtState::Operational => "operational",
            NmtState::PreOperational => "pre-operational",
        })
    }
}

/// The heartbeat, or boot-up, frame of a node.
pub fn heartbeat_frame(node: NodeId, state: NmtState) -> CanFrame {
    frame(Cob::Heartbeat(node), &[state.byte()])
}

/// A SYNC, with its counter where object 1019h of the producer is set (esd p.71): one byte, 1 to the
/// overflow value of 2 to 240, then 1 again. Without: no data.
pub fn sync_frame(counter: Option<u8>) -> CanFrame {
    match counter {
        Some(counter) => frame(Cob::Sync, &[counter]),
        None => frame(Cob::Sync, &[]),
    }
}
