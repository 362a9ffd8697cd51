//! CAN frames in the bytes of a link: adapters, logs and servers.

use asphera_cantext::candump::{Item as LogItem, Reader};
use asphera_cantext::socketcand::{self, Client, Event as ServerEvent, HANDSHAKE_TIME};
use asphera_link::{CanFrame, Nanos};
use asphera_slcan::Command;

use super::adapter::{self, Adapter};
use super::framing::Framing;

/// State of the bus on one connection.
pub(super) enum Bus {
    /// The link carries no frames.
    Absent,
    /// A serial adapter.
    Slcan(Adapter),
    /// An interface of the kernel.
    Records {
        /// Whether a device of the bus reads CAN FD.
        reads_fd: bool,
    },
    /// A log.
    Log(Reader),
    /// A server, and until when it has to open the bus.
    Server { client: Client, until: Nanos },
}

/// Content of received bytes.
#[derive(Debug, PartialEq)]
pub(super) enum Piece {
    /// A frame for the devices, with its time where its source tells one, at most that of the read.
    Frame(CanFrame, Option<Nanos>),
    /// Bytes that give no frame, and why where that is worth a word.
    Discarded { bytes: u64, why: Option<String> },
    /// Trouble that ends nothing.
    Trouble(String),
    /// Bytes to send.
    Send(Vec<u8>),
    /// The bus is open: devices can be talked to.
    Open,
    /// The connection cannot be used.
    Failed(String),
}

impl Bus {
    /// The bus on a connection that has just opened, and the bytes that are sent first. CAN FD frames are given where
    /// `reads_fd` says so, and else counted as discarded.
    pub(super) fn opened(framing: &Framing, reads_fd: bool, now: Nanos) -> (Bus, Vec<u8>) {
        let mut first = Vec::new();
        let bus = match framing {
            Framing::Raw | Framing::Datagrams | Framing::TwoStreams | Framing::File => Bus::Absent,
            Framing::CanRecords { .. } => Bus::Records { reads_fd },
            Framing::Candump { interface } => {
                Bus::Log(Reader::new(interface.clone()).with_fd(reads_fd))
            }
            Framing::Socketcand { bus } => {
                Bus::Server { client: Client::new(bus), until: now + HANDSHAKE_TIME }
            }
            Framing::Slcan { bit_rate, data_bit_rate, listen_only, timestamps } => {
                let commands = adapter::commands(*bit_rate, *data_bit_rate, *timestamps);
                first.extend(commands);
                let open = if *listen_only { Command::Listen } else { Command::Open };
                open.encode(&mut first);
                Bus::Slcan(Adapter::new(reads_fd, *timestamps))
            }
        };
        (bus, first)
    }

    /// Whether devices can be talked to.
    pub(super) fn is_open(&self) -> bool {
        match self {
            Bus::Server { client, .. } => client.is_open(),
            Bus::Absent | Bus::Slcan(_) | Bus::Records { .. } | Bus::Log(_) => true,
        }
    }

    /// Bytes that wait for the end of their frame.
    pub(super) fn pending(&self) -> u64 {
        match self {
            Bus::Slcan(adapter) => adapter.pending(),
            Bus::Log(reader) => reader.pending(),
            Bus::Server { client, .. } => client.pending(),
            Bus::Absent | Bus::Records { .. } => 0,
        }
    }

    /// Words on what the connection gave, where its end needs them.
    pub(super) fn summary(&self) -> Option<String> {
        match self {
            Bus::Log(reader) => Some(reader.summary()),
            _ => None,
        }
    }

    /// Whether the source of the frames stamps them; `None` where that is not known yet.
    pub(super) fn is_stamped(&self) -> Option<bool> {
        match self {
            Bus::Slcan(adapter) => adapter.is_stamped(),
            Bus::Absent | Bus::Records { .. } | Bus::Log(_) | Bus::Server { .. } => None,
        }
    }

    /// When a server must have opened the bus.
    pub(super) fn poll_timeout(&self) -> Option<Nanos> {
        match self {
            Bus::Server { client, until } if client.is_waiting() => Some(*until),
            _ => None,
        }
    }

    /// The time has come: why the connection cannot be used, if it cannot.
    pub(super) fn timeout(&mut self, now: Nanos) -> Option<String> {
        match self {
            Bus::Server { client, until } if client.is_waiting() && *until <= now => {
                Some(client.expire())
            }
            _ => None,
        }
    }

    /// Appends the bytes of a frame to send.
    pub(super) fn encode(&self, frame: &CanFrame, out: &mut Vec<u8>) {
        match self {
            Bus::Slcan(_) => asphera_slcan::encode(frame, out),
            Bus::Records { .. } => out.extend(frame.to_record()),
            Bus::Server { .. } => socketcand::encode(frame, out),
            // The configuration refuses devices that send on a log, and frames on a link that carries none.
            Bus::Log(_) | Bus::Absent => {}
        }
    }

    /// Takes bytes, read now, off the front of `input` up to the next piece, or all of them if none ends in them.
    #[must_use]
    pub(super) fn receive(&mut self, now: Nanos, input: &mut &[u8]) -> Option<Piece> {
        loop {
            if let Bus::Slcan(adapter) = self
                && let Some(words) = adapter.take_words()
            {
                return Some(Piece::Trouble(words.to_owned()));
            }
            if input.is_empty() {
                return None;
            }
            let piece = match self {
                Bus::Absent => {
                    let bytes = std::mem::take(input).len() as u64;
                    Some(Piece::Discarded { bytes, why: None })
                }
                Bus::Records { reads_fd } => Some(record(input, *reads_fd)),
                Bus::Slcan(adapter) => adapter.receive(now, input)?,
                Bus::Log(reader) => Some(logged(reader.read(input)?)),
                Bus::Server { client, .. } => Some(served(client.receive(input)?)),
            };
            if piece.is_some() {
                return piece;
            }
        }
    }
}

fn record(input: &mut &[u8], reads_fd: bool) -> Piece {
    let (record, after) = CanFrame::split_record(input);
    *input = after;
    let bytes = record.len() as u64;
    match CanFrame::from_record(record) {
        Ok(frame) if frame.fd().is_some() && !reads_fd => unread("the bus", bytes),
        Ok(frame) => Piece::Frame(frame, None),
        Err(_) => Piece::Discarded { bytes, why: None },
    }
}

/// A CAN FD frame where no device reads one.
pub(super) fn unread(source: &str, bytes: u64) -> Piece {
    let why = format!(
        "{source} gave a CAN FD frame: drivers read classic frames alone, of up to 8 bytes, but for described with fd = true"
    );
    Piece::Discarded { bytes, why: Some(why) }
}

fn logged(item: LogItem) -> Piece {
    match item {
        LogItem::Frame(frame) => Piece::Frame(frame, None),
        LogItem::BusError(error) => Piece::Trouble(format!("trouble on the bus: {error}")),
        LogItem::LeftOut { bytes, why } => Piece::Discarded { bytes, why: Some(why) },
    }
}

fn served(event: ServerEvent) -> Piece {
    match event {
        ServerEvent::Send(bytes) => Piece::Send(bytes),
        ServerEvent::Open => Piece::Open,
        ServerEvent::Frame(frame) => Piece::Frame(frame, None),
        ServerEvent::BusError(error) => Piece::Trouble(format!("trouble on the bus: {error}")),
        ServerEvent::Refused(words) => Piece::Trouble(words),
        ServerEvent::Failed(words) => Piece::Failed(words),
        ServerEvent::Discarded { bytes } => Piece::Discarded { bytes, why: None },
    }
}
