//! What can go wrong on a bench.

use std::fmt;
use std::time::Duration;

use serde::Serialize;

/// A link of the bench.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Link {
    /// The probe's serial line.
    Probe,
    /// The serial line of the stage's slcan adapter.
    Stage,
    /// The thermometer's TCP port.
    Thermal,
}

impl Link {
    /// Its name in scenes, listings and the station's configuration.
    pub const fn name(self) -> &'static str {
        match self {
            Link::Probe => "probe",
            Link::Stage => "stage",
            Link::Thermal => "thermal",
        }
    }
}

impl fmt::Display for Link {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

/// Something that goes wrong. The scan goes on; data of an outage are lost.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Fault {
    /// The plug is pulled and put back. A serial port vanishes with its name and comes back as
    /// another device under the same name; a TCP port closes its connections and refuses new ones.
    ///
    /// The device has its own supply and keeps its settings, unless `restart`.
    Unplug {
        /// How long it is out.
        duration: Duration,
        /// Whether the device has forgotten its settings when it comes back.
        restart: bool,
    },
    /// Nothing gets through, and the port stays.
    Silent {
        /// How long.
        duration: Duration,
    },
    /// Random bytes among those to the host, the same for the same scene and trigger. On the probe's
    /// line they may stand some telegrams before the trigger: those that wait are not sent yet.
    Noise {
        /// How many.
        bytes: usize,
    },
    /// A CANopen emergency of the first node of the stage.
    Emergency {
        /// Error code, object 603Fh; 0 is "no error any more".
        code: u16,
        /// Error register, object 1001h.
        register: u8,
    },
    /// The next telegram, TPDO of the first node, or answer is lost.
    Drop,
    /// The device loses its supply for a moment and forgets its settings. Not for the
    /// thermometer, which has none.
    Restart,
}

impl Fault {
    /// The word a scene has for it.
    pub const fn kind(&self) -> &'static str {
        match self {
            Fault::Unplug { .. } => "unplug",
            Fault::Silent { .. } => "silent",
            Fault::Noise { .. } => "noise",
            Fault::Emergency { .. } => "emergency",
            Fault::Drop => "drop",
            Fault::Restart => "restart",
        }
    }

    /// Whether it can happen to a link.
    pub const fn suits(&self, link: Link) -> bool {
        match self {
            Fault::Emergency { .. } => matches!(link, Link::Stage),
            Fault::Restart | Fault::Unplug { restart: true, .. } => !matches!(link, Link::Thermal),
            _ => true,
        }
    }

    /// How long no data come.
    pub(crate) fn outage(&self) -> Duration {
        match *self {
            Fault::Unplug { duration, .. } | Fault::Silent { duration } => duration,
            _ => Duration::ZERO,
        }
    }
}

/// A fault with its place in a scan.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Scheduled {
    /// The trigger before which it happens.
    pub(crate) at_point: u64,
    /// To which link.
    pub(crate) link: Link,
    /// What happens.
    pub(crate) fault: Fault,
}
