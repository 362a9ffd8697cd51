//! A device of the configuration, as far as it can be played.

use std::any::Any;
use std::net::SocketAddr;

use asphera_chrocodile as chrocodile;
use asphera_cia402 as cia402;
use asphera_cia406 as cia406;
use asphera_described as described;
use asphera_ippdme as ippdme;
use asphera_keyence as keyence;
use asphera_link::{Channel, DeviceSettings, Unit};
use asphera_modbus as modbus;
use asphera_optoncdt as optoncdt;
use asphera_rf627 as rf627;
use asphera_riftek as riftek;
use asphera_scpi as scpi;
use asphera_zaber as zaber;
use thiserror::Error;

use crate::frame::Frames;
use crate::probe::{self, Protocol};
use crate::row::Row;
use crate::sight::Sight;
use crate::signals::Signals;
use crate::touch::Touch;
use crate::{axes, opto, profiler, registers, rf60x, scanner, transducers};

/// A device that can be simulated.
#[derive(Clone, Debug)]
pub struct Instrument {
    pub(crate) name: String,
    pub(crate) link: usize,
    pub(crate) channels: Vec<Channel>,
    pub(crate) kind: Kind,
}

/// What simulates it.
#[derive(Clone, Debug)]
pub(crate) enum Kind {
    /// Lines, records and questions.
    Voice(Box<Frames>),
    /// A stage that obeys where the station moves it, and else answers as a voice does.
    Stage(zaber::Settings, Box<Frames>),
    /// A drive of a CAN bus.
    Drive(cia402::Settings),
    /// A coordinate measuring machine that runs the program of the station.
    Machine,
    /// A node of a CAN bus.
    Transducer(cia406::Settings),
    /// A device on a CAN bus that no profile describes.
    Gauge(Box<Signals>),
    /// A laser sensor that sends blocks.
    Blocks(optoncdt::Settings),
    /// A laser sensor with a stream, or answers.
    Results(riftek::Settings),
    /// A laser profiler with two ports.
    Profiler(keyence::Settings),
    /// A chromatic probe.
    Probe(Protocol),
    /// Modbus.
    Registers(modbus::Settings),
    /// A laser line scanner.
    Scanner(rf627::Settings),
}

/// Why a device cannot be simulated.
#[derive(Clone, Debug, Error, PartialEq, Eq)]
#[error("device {device}: expected one that can be simulated here, found one that cannot: {why}")]
pub struct UnplayableError {
    /// Name of its table.
    pub device: String,
    /// Why, and what would do.
    pub why: String,
}

/// An instrument and what it shows at each trigger.
#[derive(Clone, Debug)]
pub struct Played {
    /// The instrument.
    pub instrument: Instrument,
    /// Of each channel its values in the channel's unit, one for each trigger; `None`: it stands still.
    pub courses: Vec<Option<Vec<f64>>>,
    /// What it sees, where it is a line scanner.
    pub sight: Option<Sight>,
    /// What it touches, where it is a measuring machine.
    pub touch: Option<Touch>,
    /// Where the station listens for it, on a UDP link.
    pub listen: Option<SocketAddr>,
}

impl Played {
    /// An instrument whose channels all stand still.
    pub fn still(instrument: Instrument) -> Played {
        let courses = vec![None; instrument.channels.len()];
        Played { instrument, courses, sight: None, touch: None, listen: None }
    }
}

impl Instrument {
    /// A device of a configuration: its name, the number of its link, and its settings, which have no problems.
    ///
    /// # Errors
    ///
    /// Where nothing plays such a device, or not with these settings.
    pub fn new(
        name: &str,
        link: usize,
        settings: &dyn DeviceSettings,
    ) -> Result<Instrument, UnplayableError> {
        let unplayable = |why: String| UnplayableError { device: name.to_owned(), why };
        let kind = kind(settings).map_err(unplayable)?;
        Ok(Instrument { name: name.to_owned(), link, channels: settings.channels(), kind })
    }

    /// The value that a station reads where the device is to show this one. Its steps and digits are finite.
    pub fn shown(&self, channel: usize, value: f64) -> f64 {
        match &self.kind {
            Kind::Voice(frames) | Kind::Stage(_, frames) => frames.shown(channel, value),
            Kind::Drive(settings) => axes::shown(settings, value),
            Kind::Machine => value,
            Kind::Transducer(settings) => transducers::shown(settings, value),
            Kind::Probe(_) => self.channels.get(channel).map_or(value, |c| probe::shown(c, value)),
            Kind::Registers(settings) => registers::shown(settings, channel, value),
            Kind::Gauge(signals) => signals.shown(channel, value),
            Kind::Blocks(settings) => opto::shown(settings, channel, value),
            Kind::Results(settings) => rf60x::shown(settings, value),
            Kind::Scanner(_) | Kind::Profiler(_) => value.round(),
        }
    }

    /// Distance of the points of its line, mm; `None` where it measures points.
    pub fn pitch_mm(&self) -> Option<f64> {
        match &self.kind {
            Kind::Voice(frames) => frames.row().map(Row::pitch_mm),
            Kind::Probe(protocol) => protocol.pitch_mm(),
            Kind::Scanner(_) => Some(scanner::pitch_mm()),
            Kind::Profiler(_) => Some(profiler::pitch_mm()),
            _ => None,
        }
    }

    /// How many points its line has; `None` where that is left to the simulation.
    pub fn line_points(&self) -> Option<usize> {
        match &self.kind {
            Kind::Voice(frames) => frames.row().map(Row::points),
            _ => None,
        }
    }

    /// Smallest and largest height of the points of its line, mm; `None` where it measures points.
    pub fn line_range_mm(&self) -> Option<(f64, f64)> {
        match &self.kind {
            Kind::Voice(frames) => frames.row().map(Row::range_mm),
            Kind::Probe(protocol) => protocol.pitch_mm().map(|_| protocol.range_mm()),
            Kind::Scanner(_) => Some(scanner::range_mm()),
            Kind::Profiler(_) => Some(profiler::range_mm()),
            _ => None,
        }
    }

    /// Smallest and largest value that a channel can show, in its unit; `None` where the settings say none.
    pub fn range(&self, channel: usize) -> Option<(f64, f64)> {
        match &self.kind {
            Kind::Voice(frames) | Kind::Stage(_, frames) => frames.range(channel),
            Kind::Transducer(_) | Kind::Scanner(_) | Kind::Profiler(_) => None,
            Kind::Drive(_) | Kind::Machine => None,
            Kind::Gauge(signals) => signals.range(channel),
            Kind::Blocks(settings) => opto::range(settings, channel),
            Kind::Results(settings) => Some(rf60x::range(settings)),
            Kind::Probe(protocol) => protocol.range(self.channels.get(channel)?),
            Kind::Registers(settings) => registers::range(settings, channel),
        }
    }

    /// Readings a second of a device that runs by its own clock and measures on after the scan; `None` of any other.
    pub fn free_rate_hz(&self) -> Option<f64> {
        match &self.kind {
            Kind::Probe(protocol) => protocol.free_rate_hz(),
            _ => None,
        }
    }

    /// Whether it sends CAN FD frames.
    pub(crate) fn sends_fd(&self) -> bool {
        matches!(&self.kind, Kind::Gauge(signals) if signals.settings().fd)
    }

    /// The value of a channel that nothing moves, in its unit: a room at 20 °C, the middle of a range, else 0.
    pub(crate) fn still(&self, channel: usize) -> f64 {
        let (low, high) = self.range(channel).unwrap_or((f64::NEG_INFINITY, f64::INFINITY));
        let likely = match self.channels.get(channel).map(|channel| channel.unit) {
            Some(Unit::DegreeCelsius) => ROOM_DEGC,
            _ => 0.0,
        };
        if (low..=high).contains(&likely) { likely } else { 0.5 * (low + high) }
    }
}

fn kind(settings: &dyn DeviceSettings) -> Result<Kind, String> {
    let any: &dyn Any = settings;
    let voice = |settings| Frames::new(settings).map(|frames| Kind::Voice(Box::new(frames)));
    if let Some(settings) = any.downcast_ref::<described::Settings>() {
        return voice(settings.clone());
    }
    if let Some(settings) = any.downcast_ref::<zaber::Settings>() {
        let description = settings.description().map_err(|error| error.to_string())?;
        return Ok(Kind::Stage(settings.clone(), Box::new(Frames::new(description)?)));
    }
    if let Some(settings) = any.downcast_ref::<cia402::Settings>() {
        return match axes::refusal(settings) {
            None => Ok(Kind::Drive(settings.clone())),
            Some(why) => Err(why),
        };
    }
    if any.is::<ippdme::Settings>() {
        return Ok(Kind::Machine);
    }
    if let Some(settings) = any.downcast_ref::<scpi::Settings>() {
        return voice(settings.description().map_err(|error| error.to_string())?);
    }
    if let Some(settings) = any.downcast_ref::<cia406::Settings>() {
        return match transducers::refusal(settings) {
            None => Ok(Kind::Transducer(settings.clone())),
            Some(why) => Err(why.to_owned()),
        };
    }
    if let Some(settings) = any.downcast_ref::<modbus::Settings>() {
        return Ok(Kind::Registers(settings.clone()));
    }
    if let Some(settings) = any.downcast_ref::<rf627::Settings>() {
        return Ok(Kind::Scanner(settings.clone()));
    }
    if let Some(settings) = any.downcast_ref::<described::CanSettings>() {
        return Ok(Kind::Gauge(Box::new(Signals::new(settings.clone()))));
    }
    if let Some(settings) = any.downcast_ref::<optoncdt::Settings>() {
        return Ok(Kind::Blocks(settings.clone()));
    }
    if let Some(settings) = any.downcast_ref::<riftek::Settings>() {
        return Ok(Kind::Results(settings.clone()));
    }
    if let Some(settings) = any.downcast_ref::<keyence::Settings>() {
        return Ok(Kind::Profiler(settings.clone()));
    }
    let dollar = any.downcast_ref::<chrocodile::Settings>().cloned().map(Protocol::Dollar);
    let packets =
        || any.downcast_ref::<chrocodile::PacketSettings>().cloned().map(Protocol::Packets);
    match dollar.or_else(packets) {
        Some(protocol) => match protocol.refusal() {
            None => Ok(Kind::Probe(protocol)),
            Some(why) => Err(why.to_owned()),
        },
        None => Err("no simulator here plays its driver: record a session with the device, and play it by asphera simulate --session".to_owned()),
    }
}

const ROOM_DEGC: f64 = 20.0;
