//! The faults of the matrix.

/// A fault of a device, of its cable, or of the host.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Fault {
    /// The cable is pulled in the middle of a frame, and is back after 3 s.
    Unplugged,
    /// Nothing comes for 60 s.
    Silent,
    /// Bytes come one by one, frames late.
    Slow,
    /// The second half of a frame is lost.
    HalfFrame,
    /// Random bytes stand before each frame, then 10 MB of them come at once.
    Garbage,
    /// A frame comes twice.
    Repeated,
    /// A bit of a frame is wrong.
    BadChecksum,
    /// An answer comes after its time.
    LateAnswer,
    /// The device starts anew.
    Restart,
    /// Another device is on the line.
    WrongDevice,
    /// The part lies outside the measuring range.
    OutOfRange,
    /// The detector is saturated.
    Saturated,
    /// The host slept for an hour.
    ClockJump,
    /// The CAN controller went off the bus.
    BusOff,
    /// Frames come at ten times the rate.
    Burst,
    /// The stage does not follow its motor.
    Stall,
    /// The stage ran into a limit switch.
    Limit,
}

impl Fault {
    /// All of them, in the order of the table.
    pub const ALL: [Fault; 17] = [
        Fault::Unplugged,
        Fault::Silent,
        Fault::Slow,
        Fault::HalfFrame,
        Fault::Garbage,
        Fault::Repeated,
        Fault::BadChecksum,
        Fault::LateAnswer,
        Fault::Restart,
        Fault::WrongDevice,
        Fault::OutOfRange,
        Fault::Saturated,
        Fault::ClockJump,
        Fault::BusOff,
        Fault::Burst,
        Fault::Stall,
        Fault::Limit,
    ];

    /// Words of the table.
    pub const fn name(self) -> &'static str {
        match self {
            Fault::Unplugged => "unplugged and back",
            Fault::Silent => "silent",
            Fault::Slow => "slow",
            Fault::HalfFrame => "half a frame",
            Fault::Garbage => "garbage",
            Fault::Repeated => "repeated frame",
            Fault::BadChecksum => "bad checksum",
            Fault::LateAnswer => "late answer",
            Fault::Restart => "device restart",
            Fault::WrongDevice => "wrong device",
            Fault::OutOfRange => "out of range",
            Fault::Saturated => "saturated",
            Fault::ClockJump => "clock jump",
            Fault::BusOff => "bus-off",
            Fault::Burst => "burst, ten times the rate",
            Fault::Stall => "stage stalls",
            Fault::Limit => "limit switch",
        }
    }
}
