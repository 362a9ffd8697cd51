//! Where a link leads.

use std::fmt;
use std::path::PathBuf;

use crate::TlsSettings;

/// Where a link leads.
#[derive(Clone, Debug, PartialEq)]
pub enum Endpoint {
    /// A serial port or anything that looks like one.
    Serial(SerialSettings),
    /// A TCP server, `host:port`.
    Tcp {
        /// Host and port.
        address: String,
    },
    /// A TCP server that speaks TLS.
    Tls {
        /// Host and port.
        address: String,
        /// How it is known.
        tls: TlsSettings,
    },
    /// A TCP server with two ports, connected to both or to none. Received chunks are
    /// [`asphera_link::Connection::chunk`]s; what is sent goes to the first.
    TcpPair {
        /// Host and first port.
        address: String,
        /// Second port of the same host.
        second_port: u16,
    },
    /// Datagrams of UDP. Each is one received chunk; what the kernel drops is lost without a word.
    Udp {
        /// Address and port to receive at, `0.0.0.0:50001`.
        listen: String,
        /// Host and port of the device: only its datagrams are taken, and to it goes what is sent. Without it
        /// everybody's are taken, and nothing can be sent.
        peer: Option<String>,
    },
    /// A CAN interface of the Linux kernel. Received chunks are records, one a frame
    /// ([`asphera_link::CanFrame::to_record`]).
    SocketCan {
        /// Name of the network interface: `can0`.
        interface: String,
        /// Whether frames have the times of its controller's clock. One that stamps no frames is refused.
        timestamps: bool,
    },
    /// A log of CAN frames as candump writes it. Received chunks are its lines, each at the time it has in the log. What
    /// is sent goes nowhere. At its end the link closes, and stays closed.
    CanLog {
        /// The file.
        path: PathBuf,
        /// How many times faster than the log it is played, above 0.
        speed: f64,
    },
    /// A file, a FIFO or the standard input. What is sent goes nowhere. A file that is not followed and a pipe without a name
    /// end the link, and it stays closed.
    File(FileSettings),
}

/// How a file or pipe is read.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct FileSettings {
    /// The file or FIFO; `-`: the standard input.
    pub path: PathBuf,
    /// Whether a file is read on at its end as it grows, and anew when it is truncated or replaced. Of no meaning for pipes.
    pub follow: bool,
    /// Whether a followed file that is there when the link first opens is read from its end on.
    pub from_end: bool,
}

/// How a serial port is opened. Always 8 data bits.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct SerialSettings {
    /// Path of the port. A name that survives unplugging is best: `/dev/serial/by-id/…`.
    pub path: String,
    /// Line rate in baud.
    pub baud_bd: u32,
    /// Parity bit.
    pub parity: Parity,
    /// Two stop bits instead of one.
    pub two_stop_bits: bool,
    /// Flow control.
    pub flow_control: FlowControl,
}

/// Parity of a serial line.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Parity {
    /// No parity bit.
    #[default]
    None,
    /// Even parity. Pseudo terminals refuse it.
    Even,
    /// Odd parity. Pseudo terminals refuse it.
    Odd,
}

/// Flow control of a serial line.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum FlowControl {
    /// None.
    #[default]
    None,
    /// RTS/CTS.
    Hardware,
}

impl Endpoint {
    /// A short word for the kind of link.
    pub const fn kind(&self) -> &'static str {
        match self {
            Endpoint::Serial(_) => "serial",
            Endpoint::Tcp { .. } | Endpoint::Tls { .. } => "tcp",
            Endpoint::TcpPair { .. } => "tcp-pair",
            Endpoint::Udp { .. } => "udp",
            Endpoint::SocketCan { .. } => "socketcan",
            Endpoint::CanLog { .. } => "candump",
            Endpoint::File(_) => "file",
        }
    }
}

/// The port or address alone.
impl fmt::Display for Endpoint {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Endpoint::Serial(serial) => f.write_str(&serial.path),
            Endpoint::Tcp { address }
            | Endpoint::Tls { address, .. }
            | Endpoint::TcpPair { address, .. } => f.write_str(address),
            Endpoint::Udp { peer: Some(peer), .. } => f.write_str(peer),
            Endpoint::Udp { listen, peer: None } => f.write_str(listen),
            Endpoint::SocketCan { interface, .. } => f.write_str(interface),
            Endpoint::CanLog { path, .. } => path.display().fmt(f),
            Endpoint::File(file) => file.fmt(f),
        }
    }
}

impl FileSettings {
    /// Whether it is the standard input.
    pub fn is_standard_input(&self) -> bool {
        self.path.as_os_str() == "-"
    }
}

/// The path, or words for the standard input.
impl fmt::Display for FileSettings {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.is_standard_input() {
            true => f.write_str("standard input"),
            false => self.path.display().fmt(f),
        }
    }
}
