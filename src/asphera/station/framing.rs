//! How bytes of a link are framed.

use asphera_link::Carries;
use asphera_slcan::{BitRate, DataBitRate};

/// How bytes of a link are framed.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Framing {
    /// The one device on the link speaks its own protocol.
    Raw,
    /// The same in datagrams, each received whole.
    Datagrams,
    /// The same on two connections, in chunks that name theirs ([`asphera_link::Connection::chunk`]).
    TwoStreams,
    /// The same from a file or a pipe. Nothing can be sent.
    File,
    /// CAN frames as ASCII lines of a serial adapter.
    Slcan {
        /// Bit rate of the bus.
        bit_rate: BitRate,
        /// Bit rate of the data of CAN FD frames; `None`: an adapter for classic frames.
        data_bit_rate: Option<DataBitRate>,
        /// Whether the adapter neither acknowledges nor sends.
        listen_only: bool,
        /// Whether the adapter is to stamp the frames with its time.
        timestamps: bool,
    },
    /// CAN frames of the kernel, in records of 16 bytes, of CAN FD of 72.
    CanRecords {
        /// Whether they have the times of the controller's clock, not of the kernel.
        timestamps: bool,
    },
    /// CAN frames as lines of a log of candump. Nothing can be sent.
    Candump {
        /// Interface whose frames are taken; `None`: those of all.
        interface: Option<String>,
    },
    /// CAN frames as elements of socketcand.
    Socketcand {
        /// Bus that the server is to open.
        bus: String,
    },
}

impl Framing {
    /// Whether a driver for this kind of data can be on such a link.
    pub(crate) fn suits(&self, carries: Carries) -> bool {
        // A protocol of bytes may come in datagrams.
        self.carries() == carries || (*self == Framing::Datagrams && carries == Carries::Bytes)
    }

    /// Whether devices on such a link can be sent anything.
    pub(crate) fn can_send(&self) -> bool {
        !matches!(
            self,
            Framing::Candump { .. } | Framing::File | Framing::Slcan { listen_only: true, .. }
        )
    }

    /// Whether CAN FD frames can come and go on such a link.
    pub(crate) fn carries_fd(&self) -> bool {
        matches!(
            self,
            Framing::CanRecords { .. }
                | Framing::Candump { .. }
                | Framing::Slcan { data_bit_rate: Some(_), .. }
        )
    }

    /// Clock by which receipts are timed, where it is not that of the station as it reads them: `kernel`, `controller`, or `adapter` for one
    /// that is asked to stamp its frames. It may refuse.
    pub(crate) fn clock(&self) -> Option<&'static str> {
        match self {
            Framing::CanRecords { timestamps: false } => Some("kernel"),
            Framing::CanRecords { timestamps: true } => Some("controller"),
            Framing::Slcan { timestamps: true, .. } => Some("adapter"),
            _ => None,
        }
    }

    /// Name of the bus among several behind one address.
    pub(crate) fn bus(&self) -> Option<&str> {
        match self {
            Framing::Candump { interface } => interface.as_deref(),
            Framing::Socketcand { bus } => Some(bus),
            _ => None,
        }
    }

    fn carries(&self) -> Carries {
        match self {
            Framing::Raw | Framing::File => Carries::Bytes,
            Framing::Datagrams => Carries::Datagrams,
            Framing::TwoStreams => Carries::TwoStreams,
            Framing::Slcan { .. }
            | Framing::CanRecords { .. }
            | Framing::Candump { .. }
            | Framing::Socketcand { .. } => Carries::CanFrames,
        }
    }
}
