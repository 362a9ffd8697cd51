//! CAN interfaces of the Linux kernel.

use std::io;

use asphera_link::{CanFrame, CanId};
use socketcan::tokio::CanSocket;
use socketcan::{EmbeddedFrame as _, ExtendedId, Id, SocketOptions as _, StandardId};

use crate::OpenError;

/// An open CAN socket.
pub(crate) struct CanPort {
    socket: CanSocket,
}

/// What a CAN socket gives.
pub(crate) enum Received {
    /// A data or remote frame.
    Frame(CanFrame),
    /// The controller reports trouble on the bus.
    BusError(String),
}

impl CanPort {
    pub(crate) fn open(interface: &str) -> Result<CanPort, OpenError> {
        let failed = |source| OpenError::SocketCan { interface: interface.to_owned(), source };
        let socket = CanSocket::open(interface).map_err(failed)?;
        // Bus-off and the like must be seen, not guessed from silence.
        socket.set_error_filter_accept_all().map_err(failed)?;
        Ok(CanPort { socket })
    }

    pub(crate) async fn receive(&self) -> io::Result<Received> {
        let frame = self.socket.read_frame().await?;
        let (remote, len) = match &frame {
            socketcan::CanFrame::Data(frame) => (false, frame.dlc()),
            socketcan::CanFrame::Remote(frame) => (true, frame.dlc()),
            socketcan::CanFrame::Error(error) => {
                return Ok(Received::BusError(format!("{:?}", error.into_error())));
            }
        };
        let id = match frame.id() {
            Id::Standard(id) => CanId::Standard(id.as_raw()),
            Id::Extended(id) => CanId::Extended(id.as_raw()),
        };
        let frame = if remote {
            CanFrame::remote_frame(id, len)
        } else {
            CanFrame::data_frame(id, frame.data())
        };
        frame.map(Received::Frame).map_err(io::Error::other)
    }

    pub(crate) async fn send(&self, frame: &CanFrame) -> io::Result<()> {
        let invalid =
            || io::Error::new(io::ErrorKind::InvalidInput, format!("no CAN frame: {frame:?}"));
        let id: Id = match frame.id() {
            CanId::Standard(id) => StandardId::new(id).ok_or_else(invalid)?.into(),
            CanId::Extended(id) => ExtendedId::new(id).ok_or_else(invalid)?.into(),
        };
        let frame = if frame.is_remote() {
            socketcan::CanFrame::new_remote(id, frame.dlc())
        } else {
            socketcan::CanFrame::new(id, frame.data())
        };
        self.socket.write_frame(frame.ok_or_else(invalid)?).await
    }
}
