//! CAN interfaces of the Linux kernel.

use std::io::{self, IoSliceMut, Write as _};
use std::os::fd::AsRawFd as _;
use std::time::Duration;

use asphera_cantext::{ERROR_FLAG, ErrorFrame};
use asphera_link::{CanFrame, FD_RECORD_LEN, RECORD_LEN};
use nix::sys::socket::{
    ControlMessageOwned, MsgFlags, TimestampingFlag, Timestamps, recvmsg, setsockopt,
    sockopt::Timestamping,
};
use nix::sys::time::TimeSpec;
use nix::time::{ClockId, clock_gettime};
use rustix::io::Errno;
use socketcan::{CanFdSocket, Socket as _, SocketOptions as _};
use tokio::io::Interest;
use tokio::io::unix::AsyncFd;
use tokio::time::sleep;

use crate::OpenError;

/// An open CAN socket, for classic frames and those of CAN FD.
pub(crate) struct CanPort {
    interface: String,
    is_stamped: bool,
    socket: AsyncFd<CanFdSocket>,
}

/// What is known of when a frame came.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Came {
    /// How long ago the kernel took it.
    pub(crate) age: Duration,
    /// Time by the clock of the controller, ns since a zero of its own, where it stamps.
    pub(crate) controller_ns: Option<i64>,
}

/// What a CAN socket gives.
#[derive(Debug, PartialEq, Eq)]
pub(crate) enum Received {
    /// Record of a data or remote frame ([`CanFrame::to_record`]).
    Record(Vec<u8>),
    /// The controller reports trouble on the bus.
    BusError(ErrorFrame),
}

impl CanPort {
    pub(crate) fn open(interface: &str, is_stamped: bool) -> Result<CanPort, OpenError> {
        let failed = |source| OpenError::SocketCan { interface: interface.to_owned(), source };
        let socket = CanFdSocket::open(interface).map_err(failed)?;
        // An interface that is down can be bound all the same; that it is down stands in the socket's error.
        if let Some(down) = socket.as_raw_socket().take_error().map_err(failed)? {
            return Err(failed(down));
        }
        // Bus-off and the like must be seen, not guessed from silence.
        socket.set_error_filter_accept_all().map_err(failed)?;
        // CAN has no flow control: what does not fit here is lost.
        socket.as_raw_socket().set_recv_buffer_size(RECEIVE_BYTES).map_err(failed)?;
        socket.set_nonblocking(true).map_err(failed)?;
        // When the kernel, and a controller that can, took a frame is known, however late this task reads it.
        setsockopt(socket.as_raw_socket(), Timestamping, &STAMPS)
            .map_err(|error| failed(error.into()))?;
        #[expect(
            deprecated,
            reason = "its successor `register` is unsafe for descriptors that are closed or replaced behind it; nobody but `CanPort` has this one"
        )]
        let socket = AsyncFd::new(socket).map_err(failed)?;
        Ok(CanPort { interface: interface.to_owned(), is_stamped, socket })
    }

    /// Whether the times of frames are to be those of the controller.
    pub(crate) fn is_stamped(&self) -> bool {
        self.is_stamped
    }

    /// Why an interface whose controller gives no times is closed, and the cure.
    pub(crate) fn without_stamps(&self) -> String {
        let name = &self.interface;
        format!(
            "the controller of {name} stamps no frames (`ethtool -T {name}` shows what it can): set timestamps = false for the times of the kernel"
        )
    }

    /// The next frame, and when it came.
    pub(crate) async fn receive(&self) -> io::Result<(Received, Came)> {
        // An interface that goes down is an error to the poll, and not readable.
        let interest = Interest::READABLE | Interest::ERROR;
        let mut bytes = [0; FD_RECORD_LEN];
        let (count, came) = self.socket.async_io(interest, |from| read(from, &mut bytes)).await?;
        Ok((received(&bytes[..count])?, came))
    }

    /// Sends a frame; waits, without end, while the transmit queue is full.
    pub(crate) async fn send(&self, frame: &CanFrame) -> io::Result<()> {
        let bytes = native(frame);
        loop {
            let write = |to: &CanFdSocket| to.as_raw_socket().write(&bytes);
            match self.socket.async_io(Interest::WRITABLE, write).await {
                // The queue of the interface is full, 10 frames as a rule. The kernel calls the socket
                // writable all the same, so there is nothing to wait for but time.
                Err(error) if error.raw_os_error() == Some(Errno::NOBUFS.raw_os_error()) => {
                    sleep(QUEUE_PAUSE).await;
                }
                Err(error) if frame.fd().is_some() && is_invalid(&error) => {
                    return Err(io::Error::new(error.kind(), self.without_fd()));
                }
                Err(error) => return Err(error),
                Ok(_) => return Ok(()),
            }
        }
    }

    /// Why an interface refuses a CAN FD frame, and the cure.
    fn without_fd(&self) -> String {
        let name = &self.interface;
        format!(
            "{name} carries classic frames alone: `ip link set {name} type can bitrate … dbitrate … fd on` (of a vcan `mtu 72`)"
        )
    }
}

fn is_invalid(error: &io::Error) -> bool {
    error.raw_os_error() == Some(Errno::INVAL.raw_os_error())
}

/// Reads one frame of the kernel: how many bytes, and when it came.
fn read(socket: &CanFdSocket, bytes: &mut [u8]) -> io::Result<(usize, Came)> {
    let mut control = nix::cmsg_space!(Timestamps);
    let mut parts = [IoSliceMut::new(bytes)];
    let fd = socket.as_raw_socket().as_raw_fd();
    let message = recvmsg::<()>(fd, &mut parts, Some(&mut control), MsgFlags::empty())?;
    let stamps = message.cmsgs()?.find_map(|control| match control {
        ControlMessageOwned::ScmTimestampsns(stamps) => Some(stamps),
        _ => None,
    });
    let now = clock_gettime(ClockId::CLOCK_REALTIME)?;
    Ok((message.bytes, came(stamps, now)))
}

/// When a frame came, by its stamps (`struct scm_timestamping`: the second is no longer used, those that are not there are 0).
fn came(stamps: Option<Timestamps>, now: TimeSpec) -> Came {
    let of = |stamp: Option<TimeSpec>| stamp.map(Duration::from).filter(|stamp| !stamp.is_zero());
    let age = of(stamps.map(|stamps| stamps.system))
        .map_or(Duration::ZERO, |stamp| age(stamp, Duration::from(now)));
    let controller = of(stamps.map(|stamps| stamps.hw_raw));
    let controller_ns = controller.and_then(|stamp| i64::try_from(stamp.as_nanos()).ok());
    Came { age, controller_ns }
}

/// Time from a stamp of the wall clock until now. It counts from the read where the wall clock was set in between: then
/// the two times are of different clocks.
fn age(stamp: Duration, now: Duration) -> Duration {
    now.checked_sub(stamp).filter(|age| *age <= OLDEST).unwrap_or_default()
}

/// Content of a `struct can_frame` or `struct canfd_frame` of the kernel. Their sizes tell them apart.
fn received(bytes: &[u8]) -> io::Result<Received> {
    let mut record = bytes.to_vec();
    let is_fd = match record.len() {
        RECORD_LEN => false,
        FD_RECORD_LEN => true,
        len => return Err(io::Error::other(format!("the kernel gave a frame of {len} bytes"))),
    };
    let word = u32::from_ne_bytes([record[0], record[1], record[2], record[3]]);
    if word & ERROR_FLAG != 0 {
        let len = usize::from(record[4]).min(8);
        return Ok(Received::BusError(ErrorFrame::new(word & 0x1FFF_FFFF, &record[8..8 + len])));
    }
    record[..4].copy_from_slice(&word.to_le_bytes());
    // Older kernels leave FDF out; of a classic frame these three bytes are padding and the raw length code.
    record[5] = if is_fd { record[5] | FDF } else { 0 };
    record[6..8].fill(0);
    Ok(Received::Record(record))
}

/// The same structures, to be sent.
fn native(frame: &CanFrame) -> Vec<u8> {
    let mut record = frame.to_record();
    let word = u32::from_le_bytes([record[0], record[1], record[2], record[3]]);
    record[..4].copy_from_slice(&word.to_ne_bytes());
    record
}

/// Stamps of the kernel and of the controller, both of them as they are (Linux, Documentation/networking/timestamping.rst, 1.3).
const STAMPS: TimestampingFlag = TimestampingFlag::SOF_TIMESTAMPING_RX_SOFTWARE
    .union(TimestampingFlag::SOF_TIMESTAMPING_SOFTWARE)
    .union(TimestampingFlag::SOF_TIMESTAMPING_RX_HARDWARE)
    .union(TimestampingFlag::SOF_TIMESTAMPING_RAW_HARDWARE);

/// Frames wait longer only in a station that is stopped; then its receive buffer has overflowed.
const OLDEST: Duration = Duration::from_secs(1);

/// `CANFD_FDF` of `<linux/can.h>`.
const FDF: u8 = 4;
/// Asked of the kernel, which gives what `net.core.rmem_max` allows. One frame takes about 760 bytes.
const RECEIVE_BYTES: usize = 4 << 20;
/// About the time of four frames at 500 kbit/s.
const QUEUE_PAUSE: Duration = Duration::from_millis(1);

#[cfg(test)]
mod tests {
    use asphera_cantext::BusState;
    use asphera_link::{CanId, FdFlags};

    use super::*;

    /// `struct can_frame` of `<linux/can.h>`, with a raw length code of 14 in its last byte of padding.
    #[test]
    fn classic_frames_of_the_kernel() {
        let mut bytes = [0; RECORD_LEN];
        bytes[..4].copy_from_slice(&0x185_u32.to_ne_bytes());
        bytes[4..8].copy_from_slice(&[8, 0, 0, 14]);
        bytes[8..].copy_from_slice(&[1, 2, 3, 4, 5, 6, 7, 8]);
        let Received::Record(record) = received(&bytes).unwrap() else { panic!("no frame") };
        let frame =
            CanFrame::data_frame(CanId::Standard(0x185), &[1, 2, 3, 4, 5, 6, 7, 8]).unwrap();
        assert_eq!(CanFrame::from_record(&record), Ok(frame));
        assert_eq!(native(&frame)[..7], bytes[..7]);
    }

    /// `struct canfd_frame`, from a kernel that does not set CANFD_FDF.
    #[test]
    fn fd_frames_of_the_kernel() {
        let mut bytes = [0; FD_RECORD_LEN];
        bytes[..4].copy_from_slice(&(0x8000_0000_u32 | 0x1234_5678).to_ne_bytes());
        bytes[4..6].copy_from_slice(&[2, 1]);
        bytes[8..10].copy_from_slice(&[0xAA, 0x55]);
        let Received::Record(record) = received(&bytes).unwrap() else { panic!("no frame") };
        let flags = FdFlags { bit_rate_switch: true, error_passive: false };
        let id = CanId::Extended(0x1234_5678);
        let frame = CanFrame::fd_frame(id, &[0xAA, 0x55], flags).unwrap();
        assert_eq!(CanFrame::from_record(&record), Ok(frame));
        assert_eq!(native(&frame).len(), FD_RECORD_LEN);
    }

    /// `<linux/can/error.h>`: CAN_ERR_FLAG | CAN_ERR_BUSOFF; eight bytes of data always.
    #[test]
    fn error_frames_of_the_kernel() {
        let mut bytes = [0; RECORD_LEN];
        bytes[..4].copy_from_slice(&0x2000_0040_u32.to_ne_bytes());
        bytes[4] = 8;
        let Received::BusError(error) = received(&bytes).unwrap() else { panic!("a frame") };
        assert_eq!(error.state(), Some(BusState::Off));
        assert!(received(&bytes[..15]).is_err());
    }

    /// `struct scm_timestamping` of `<linux/errqueue.h>` with and without the stamp of a controller.
    #[test]
    fn stamps_that_are_not_there_are_zero() {
        let none = TimeSpec::new(0, 0);
        let [system, now] = [TimeSpec::new(1_436_509_052, 7), TimeSpec::new(1_436_509_052, 1_007)];
        let stamps = |hw_raw| Some(Timestamps { system, hw_trans: none, hw_raw });
        let age = Duration::from_micros(1);
        assert_eq!(came(stamps(none), now), Came { age, controller_ns: None });
        let controller_ns = Some(86_400_000_000_005);
        assert_eq!(came(stamps(TimeSpec::new(86_400, 5)), now), Came { age, controller_ns });
        assert_eq!(came(None, now), Came { age: Duration::ZERO, controller_ns: None });
    }

    #[test]
    fn a_wall_clock_that_was_set_makes_no_age() {
        let [stamp, ms] = [Duration::from_secs(1_436_509_052), Duration::from_millis(1)];
        assert_eq!(age(stamp, stamp + 3 * ms), 3 * ms);
        assert_eq!(age(stamp, stamp), Duration::ZERO);
        assert_eq!(age(stamp, stamp - ms), Duration::ZERO, "set back");
        assert_eq!(age(stamp, stamp + 3600 * 1000 * ms), Duration::ZERO, "set forward");
    }
}
