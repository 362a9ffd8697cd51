//! The state machine every driver is.

use crate::{CanFrame, Channel, Motion, MotionEvent, MotionFailure, Nanos, Reading};

/// A device as a state machine, without ports, tasks or a clock.
///
/// # How it is driven
///
/// ```text
/// connected(now) ─▶ { receive(now, input) | timeout(now) | command(now, …) | motion(now, …) }* ─▶ disconnected(now)
///                    after each of them: poll_transmit() and poll_event() until they give None,
///                    then poll_timeout() once for the time of the next timeout(now)
/// ```
///
/// Times never go back. Everything a driver does follows from the calls and their times alone, so
/// that a recording of the calls gives the same readings again.
///
/// # Rules
///
/// - [`Driver::connected`] forgets everything received before: no byte from before a reconnect is
///   ever decoded after it.
/// - [`Event::Online`] comes once per connection, before the first reading, and only after a valid
///   frame of the device: an open port alone proves nothing.
/// - A reading that is damaged, weak or out of range is given with its flags, not dropped. Bytes
///   that are no reading at all are counted by [`Event::Discarded`].
pub trait Driver: Send {
    /// Channels of every reading, in order. They do not change during a driver's life; at most
    /// [`crate::MAX_CHANNELS`].
    fn channels(&self) -> &[Channel];

    /// The link is open. Drops all decoder state and queues what must be said first.
    fn connected(&mut self, now: Nanos);

    /// The link is closed. Until [`Driver::connected`] nothing else is called.
    fn disconnected(&mut self, now: Nanos);

    /// Takes what the link received. On a CAN bus every driver is shown every frame and takes its own; CAN FD frames go to
    /// those alone that [read them](Driver::reads_fd).
    fn receive(&mut self, now: Nanos, input: Input<'_>);

    /// Does what was due at the time given by [`Driver::poll_timeout`].
    fn timeout(&mut self, now: Nanos);

    /// When [`Driver::timeout`] is to be called, if at all.
    #[must_use]
    fn poll_timeout(&self) -> Option<Nanos>;

    /// The next thing to send.
    #[must_use]
    fn poll_transmit(&mut self) -> Option<Output>;

    /// The next event.
    #[must_use]
    fn poll_event(&mut self) -> Option<Event>;

    /// Whether CAN FD frames are given to the driver. Others never get one: eight bytes of a longer frame mean nothing to them.
    fn reads_fd(&self) -> bool {
        false
    }

    /// Starts or stops measuring. A command given while the link is closed takes effect when it opens.
    fn command(&mut self, now: Nanos, command: Command);

    /// Moves or halts axes. What becomes of it comes as [`Event::Motion`].
    ///
    /// # Errors
    ///
    /// When the order cannot be begun; then nothing is sent. A device without axes refuses every order.
    fn motion(&mut self, _now: Nanos, _motion: &Motion) -> Result<(), MotionFailure> {
        Err(MotionFailure::without_axes())
    }

    /// Bytes that halt every axis of the device in any state of the driver; `None` for a device without axes. The answer to
    /// them is no reading.
    fn halt_bytes(&self) -> Option<Vec<u8>> {
        None
    }

    /// The same for a device on a CAN bus, as frames; none for a device without axes.
    fn halt_frames(&self) -> Vec<CanFrame> {
        Vec::new()
    }
}

/// What a link received.
#[derive(Clone, Copy, Debug)]
pub enum Input<'a> {
    /// Bytes of a stream, cut anywhere; of a UDP link one whole datagram.
    Bytes(&'a [u8]),
    /// Bytes of the second connection of a link with two, cut anywhere.
    Second(&'a [u8]),
    /// One CAN frame.
    Frame(&'a CanFrame),
}

/// What a driver wants sent.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Output {
    /// Bytes of a stream; of a link with two connections for the first one.
    Bytes(Vec<u8>),
    /// One CAN frame.
    Frame(CanFrame),
}

/// What the station may ask of any device.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Command {
    /// Start measuring: from now on readings are wanted.
    Start,
    /// Stop measuring.
    Stop,
}

/// What a driver has to tell.
#[derive(Clone, Debug, PartialEq)]
pub enum Event {
    /// The device answered with a valid frame: it is there, and it is what it should be.
    Online,
    /// The device is set up and would answer a trigger: a scan may begin.
    Ready,
    /// A reading.
    Reading(Reading),
    /// The device refused or reported something. The link goes on.
    Fault(Fault),
    /// Bytes that belong to no valid frame were passed over.
    Discarded {
        /// How many bytes (for CAN: data bytes of the frames).
        bytes: u64,
    },
    /// What became of an order to the axes.
    Motion(MotionEvent),
    /// Nothing more can be trusted on this connection; it must be closed and opened anew.
    Reopen(Fault),
}

/// Something a person should know.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Fault {
    /// What kind of trouble.
    pub kind: FaultKind,
    /// One sentence with the values a technician needs, lower case, no full stop.
    pub detail: String,
}

/// Kinds of trouble, for counting.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum FaultKind {
    /// No answer within the time allowed.
    Timeout,
    /// The device answered that it will not.
    Refused,
    /// The device reported an error of its own (EMCY, alarm).
    Device,
    /// The answer does not fit the question.
    Protocol,
}

impl FaultKind {
    /// Name as reports write it.
    pub const fn name(self) -> &'static str {
        match self {
            FaultKind::Timeout => "timeout",
            FaultKind::Refused => "refused",
            FaultKind::Device => "device",
            FaultKind::Protocol => "protocol",
        }
    }
}
