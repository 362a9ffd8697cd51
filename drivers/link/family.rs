//! What a station's configuration asks of a driver.

use std::any::Any;
use std::fmt::Debug;
use std::time::Duration;

use asphera_settings::{File, Problems, Section};

use crate::{Channel, Driver, Problem};

/// A family of devices that one driver reads.
///
/// A driver's crate has one constant of this type, `FAMILY`. It is all that a configuration names of a driver.
#[derive(Clone, Copy, Debug)]
pub struct Family {
    /// Word of the key `driver` in the table of a device: `chrocodile2`.
    pub name: &'static str,
    /// What a link to such a device carries.
    pub carries: Carries,
    /// Makes settings from the table `settings` of a device.
    ///
    /// It reports values of the wrong kind and absent keys to the table; what is out of range is found by
    /// [`DeviceSettings::problems`]. `None`: too little is there to go on.
    pub settings: fn(&Section<'_>) -> Option<Box<dyn DeviceSettings>>,
    /// Proposes a table `settings` for a device that was listened to, where the driver can.
    pub propose: Option<fn(&Capture) -> Proposal>,
}

/// All that was heard from a device that nobody has described yet.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Capture {
    /// Bytes it sent.
    pub received: Vec<u8>,
    /// Question it was asked again and again, and the time from one to the next in ms.
    pub asked: Option<(Vec<u8>, u32)>,
}

/// Settings proposed for a device that nobody has described yet.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Proposal {
    /// Keys and values as TOML, comments among them, or `None` where nothing can be proposed. Tables are named as
    /// below `settings`: `[[field]]`.
    pub settings: Option<String>,
    /// Remarks for a person: what was seen, what could not be told.
    pub remarks: Vec<String>,
}

/// What a link carries.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Carries {
    /// Bytes of one device: a serial line, a TCP connection, or datagrams.
    Bytes,
    /// Datagrams of one device, each given whole by one [`crate::Input::Bytes`]: a UDP link.
    Datagrams,
    /// Bytes of one device on two connections at once: answers by [`crate::Input::Bytes`], a stream by
    /// [`crate::Input::Second`]. Both open and end together.
    TwoStreams,
    /// CAN frames, of as many devices as the bus has.
    CanFrames,
}

/// Settings of one device, as its driver understands them.
///
/// Settings that cannot be used answer too, so that a configuration with several mistakes is checked whole.
///
/// The type behind it can be asked for by [`Any`]: a simulator of the device needs it.
pub trait DeviceSettings: Any + Debug + Send + Sync {
    /// All that cannot be used. Keys are those of the table; empty when [`DeviceSettings::driver`] succeeds.
    fn problems(&self) -> Vec<Problem>;

    /// Channels of its readings, in order.
    fn channels(&self) -> Vec<Channel>;

    /// Whether each reading has a [`crate::Profile`]: the device is a line scanner.
    fn measures_profiles(&self) -> bool {
        false
    }

    /// Whether the driver moves the axes that its channels show: see [`Driver::motion`].
    fn moves_axes(&self) -> bool {
        false
    }

    /// Whether the driver finds home with its axes: see [`crate::Motion::Home`].
    fn homes(&self) -> bool {
        false
    }

    /// Whether the driver runs a program that moves and measures, once the scan is armed: see [`crate::Motion::Run`].
    fn runs_program(&self) -> bool {
        false
    }

    /// How many numbers the trigger count of its readings has, at least 2.
    ///
    /// # Errors
    ///
    /// Why a reading cannot be joined with those of other devices by its count, after the device's name and a colon.
    fn count_cycle(&self) -> Result<u32, &'static str> {
        Err("its readings carry no count")
    }

    /// The clock whose time each reading carries; `None` where the device sends none.
    fn clock(&self) -> Option<DeviceClock> {
        None
    }

    /// The number that tells it from other devices on a bus.
    fn bus_number(&self) -> Option<BusNumber> {
        None
    }

    /// What the link must carry, where that depends on the settings; `None`: what [`Family::carries`] says.
    fn carries(&self) -> Option<Carries> {
        None
    }

    /// Whether the device sends or takes CAN FD frames: its link must carry them.
    fn needs_fd(&self) -> bool {
        false
    }

    /// Longest time for which the driver holds a reading back to be sure of it.
    fn holds_back(&self) -> Duration {
        Duration::ZERO
    }

    /// Makes the driver.
    ///
    /// # Errors
    ///
    /// [`DeviceSettings::problems`], when there are any.
    fn driver(&self) -> Result<Box<dyn Driver>, Vec<Problem>>;
}

/// Clock of a device, as its manual describes it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct DeviceClock {
    /// Time after which it begins again at 0, ns; `None` where that does not happen in a session, or is not known.
    pub wraps_ns: Option<u64>,
    /// Time of one step, ns; 0 where that is not known or does not matter.
    pub tick_ns: u64,
}

impl DeviceClock {
    /// The clock of a whole number of `bits` bits whose steps are `step_s` long.
    pub fn counter(step_s: f64, bits: i32) -> DeviceClock {
        let tick_ns = step_s * 1e9;
        let wraps_ns = tick_ns * 2_f64.powi(bits);
        let is_whole = (1.0..1e19).contains(&wraps_ns);
        DeviceClock {
            wraps_ns: is_whole.then(|| wraps_ns.round() as u64),
            tick_ns: tick_ns.abs().round() as u64,
        }
    }
}

/// Number of a device on a bus.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct BusNumber {
    /// Key of the settings that holds it: `node_id`.
    pub key: &'static str,
    /// The number.
    pub number: u8,
}

impl Family {
    /// Reads the table `settings` of a device and reports all that is wrong with it, unknown keys among it.
    /// `None`: too little is there to go on, and the table says so.
    pub fn read(&self, table: &Section<'_>) -> Option<Box<dyn DeviceSettings>> {
        let settings = (self.settings)(table);
        table.finish();
        for Problem { key, expected, found } in settings.iter().flat_map(|known| known.problems()) {
            table.problem(&key, expected, found);
        }
        settings
    }

    /// Settings of a text of their own, with keys and tables as they stand below `settings`; `name` stands in the problems.
    ///
    /// # Errors
    ///
    /// All that is wrong, each with its line.
    pub fn parse(&self, name: &str, text: &str) -> Result<Box<dyn DeviceSettings>, Problems> {
        let file = File::parse(name, text)?;
        let root = file.root();
        let settings = self.read(&root);
        drop(root);
        file.conclude(settings)
    }
}
