//! CAN frames in the bytes of a link: adapters, logs and servers.

use asphera_cantext::candump::{Item as LogItem, Reader};
use asphera_cantext::socketcand::{self, Client, Event as ServerEvent, HANDSHAKE_TIME};
use asphera_link::{CanFrame, Nanos};
use asphera_slcan::{Command, Decoder, Item, Timestamps};

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

/// A serial adapter.
pub(super) struct Adapter {
    decoder: Decoder,
    /// Commands and frames that it refused.
    refusals: u64,
    /// Whether a device of the bus reads CAN FD.
    reads_fd: bool,
}

/// Content of received bytes.
#[derive(Debug, PartialEq)]
pub(super) enum Piece {
    /// A frame for the devices.
    Frame(CanFrame),
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
            Framing::CanRecords => Bus::Records { reads_fd },
            Framing::Candump { interface } => {
                Bus::Log(Reader::new(interface.clone()).with_fd(reads_fd))
            }
            Framing::Socketcand { bus } => {
                Bus::Server { client: Client::new(bus), until: now + HANDSHAKE_TIME }
            }
            Framing::Slcan { bit_rate, data_bit_rate, listen_only } => {
                // An adapter that was left open takes no bit rate; the empty line ends what it may have half read.
                first.push(asphera_slcan::CR);
                let commands = [Command::Close, Command::BitRate(*bit_rate)].into_iter();
                let commands = commands.chain(data_bit_rate.map(Command::DataBitRate)).chain([
                    Command::Timestamps(false),
                    if *listen_only { Command::Listen } else { Command::Open },
                ]);
                commands.for_each(|command| command.encode(&mut first));
                // Time stamps are off, so a line that has one is damaged.
                let decoder = Decoder::expecting(Timestamps::Never);
                Bus::Slcan(Adapter { decoder, refusals: 0, reads_fd })
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
            Bus::Slcan(adapter) => adapter.decoder.pending(),
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

    /// Takes bytes off the front of `input` up to the next piece, or all of them if none ends in them.
    #[must_use]
    pub(super) fn receive(&mut self, input: &mut &[u8]) -> Option<Piece> {
        loop {
            if input.is_empty() {
                return None;
            }
            let piece = match self {
                Bus::Absent => {
                    let bytes = std::mem::take(input).len() as u64;
                    Some(Piece::Discarded { bytes, why: None })
                }
                Bus::Records { reads_fd } => Some(record(input, *reads_fd)),
                Bus::Slcan(adapter) => adapter.receive(input)?,
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
        Ok(frame) => Piece::Frame(frame),
        Err(_) => Piece::Discarded { bytes, why: None },
    }
}

/// A CAN FD frame where no device reads one.
fn unread(source: &str, bytes: u64) -> Piece {
    let why = format!(
        "{source} gave a CAN FD frame: drivers read classic frames alone, of up to 8 bytes, but for described with fd = true"
    );
    Piece::Discarded { bytes, why: Some(why) }
}

impl Adapter {
    /// Content of the next line; outer `None` where no line ends in the input, inner where it says nothing.
    #[expect(clippy::option_option, reason = "outer: no whole line; inner: one that says nothing")]
    fn receive(&mut self, input: &mut &[u8]) -> Option<Option<Piece>> {
        let before = self.decoder.pending() + input.len() as u64;
        let item = self.decoder.decode(input)?;
        // Nothing is pending behind a line.
        let bytes = before - input.len() as u64;
        Some(match item {
            Item::Frame(frame, _) if frame.fd().is_some() && !self.reads_fd => {
                Some(unread("the adapter", bytes))
            }
            Item::Frame(frame, _) => Some(Piece::Frame(frame)),
            Item::Malformed { bytes } => Some(Piece::Discarded { bytes, why: None }),
            Item::Error => {
                self.refusals += 1;
                let words = "the adapter refused a command or a frame";
                (self.refusals > EXPECTED_REFUSALS).then(|| Piece::Trouble(words.to_owned()))
            }
            Item::Status(status) if !status.is_empty() => {
                Some(Piece::Trouble(format!("the adapter reports {status:?}")))
            }
            Item::Status(_)
            | Item::Ok
            | Item::TransmitAck { .. }
            | Item::Version { .. }
            | Item::SerialNumber(_)
            | Item::Command(_) => None,
        })
    }
}

fn logged(item: LogItem) -> Piece {
    match item {
        LogItem::Frame(frame) => Piece::Frame(frame),
        LogItem::BusError(error) => Piece::Trouble(format!("trouble on the bus: {error}")),
        LogItem::LeftOut { bytes, why } => Piece::Discarded { bytes, why: Some(why) },
    }
}

fn served(event: ServerEvent) -> Piece {
    match event {
        ServerEvent::Send(bytes) => Piece::Send(bytes),
        ServerEvent::Open => Piece::Open,
        ServerEvent::Frame(frame) => Piece::Frame(frame),
        ServerEvent::BusError(error) => Piece::Trouble(format!("trouble on the bus: {error}")),
        ServerEvent::Refused(words) => Piece::Trouble(words),
        ServerEvent::Failed(words) => Piece::Failed(words),
        ServerEvent::Discarded { bytes } => Piece::Discarded { bytes, why: None },
    }
}

/// An adapter that is closed already refuses to be closed, and some refuse the empty line before.
const EXPECTED_REFUSALS: u64 = 2;
