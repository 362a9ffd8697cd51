//! CAN interfaces of the Linux kernel.

use std::io;
use std::time::Duration;

use asphera_link::{CanFrame, CanId};
use rustix::io::Errno;
use socketcan::{
    CanSocket, EmbeddedFrame as _, ExtendedId, Id, Socket as _, SocketOptions as _, StandardId,
};
use tokio::io::Interest;
use tokio::io::unix::AsyncFd;
use tokio::time::sleep;

use crate::OpenError;

/// An open CAN socket.
pub(crate) struct CanPort {
    socket: AsyncFd<CanSocket>,
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
        // An interface that is down can be bound all the same; that it is down stands in the socket's error.
        if let Some(down) = socket.as_raw_socket().take_error().map_err(failed)? {
            return Err(failed(down));
        }
        // Bus-off and the like must be seen, not guessed from silence.
        socket.set_error_filter_accept_all().map_err(failed)?;
        // CAN has no flow control: what does not fit here is lost.
        socket.as_raw_socket().set_recv_buffer_size(RECEIVE_BYTES).map_err(failed)?;
        socket.set_nonblocking(true).map_err(failed)?;
        #[expect(
            deprecated,
            reason = "its successor `register` is unsafe for descriptors that are closed or replaced behind it; nobody but `CanPort` has this one"
        )]
        let socket = AsyncFd::new(socket).map_err(failed)?;
        Ok(CanPort { socket })
    }

    pub(crate) async fn receive(&self) -> io::Result<Received> {
        // An interface that goes down is an error to the poll, and not readable.
        let interest = Interest::READABLE | Interest::ERROR;
        let frame = self.socket.async_io(interest, CanSocket::read_frame).await?;
        let (remote, len) = match &frame {
            socketcan::CanFrame::Data(frame) => (false, frame.dlc()),
            socketcan::CanFrame::Remote(frame) => (true, frame.dlc()),
            socketcan::CanFrame::Error(error) => {
                return Ok(Received::BusError(error.into_error().to_string()));
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

    /// Sends a frame; waits, without end, while the transmit queue is full.
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
        let frame = frame.ok_or_else(invalid)?;
        loop {
            match self.socket.async_io(Interest::WRITABLE, |to| to.write_frame(&frame)).await {
                // The queue of the interface is full, 10 frames as a rule. The kernel calls the socket
                // writable all the same, so there is nothing to wait for but time.
                Err(error) if error.raw_os_error() == Some(Errno::NOBUFS.raw_os_error()) => {
                    sleep(QUEUE_PAUSE).await;
                }
                sent => return sent,
            }
        }
    }
}

/// Asked of the kernel, which gives what `net.core.rmem_max` allows. One frame takes about 760 bytes.
const RECEIVE_BYTES: usize = 4 << 20;
/// About the time of four frames at 500 kbit/s.
const QUEUE_PAUSE: Duration = Duration::from_millis(1);
