//! Settings of the driver, and the description they stand for.

use std::f64::consts::PI;

use asphera_described::{End, Settings as Description};
use asphera_described::{Field, Framing, Hello, Layout, PatternError, Place, Poll, Refusal, Role};
use asphera_link::{Channel, Problem, Unit, check_range};

use crate::{reply, warning};

/// A stage, or a controller with several axes.
#[derive(Clone, Debug, PartialEq)]
pub struct Settings {
    /// Address of the device on its line, 1 to 99.
    pub address: u8,
    /// Number of the axis, 1 to 9; 0: the whole device, whose replies hold a position of each axis.
    pub axis: u8,
    /// The axes whose positions a reply holds, in their order: one, unless `axis` is 0.
    pub axes: Vec<Axis>,
    /// Whether commands and replies have a checksum (the setting `comm.checksum` of the device).
    pub checksum: bool,
    /// Time from one question to the next, 1 to 3 600 000 ms.
    pub interval_ms: u32,
    /// Time an answer may take, 1 to 60 000 ms.
    pub timeout_ms: u32,
    /// Silence after which no late answer is expected any more, `timeout_ms` to 600 000 ms.
    pub late_limit_ms: u32,
}

/// An axis.
#[derive(Clone, Debug, PartialEq)]
pub struct Axis {
    /// Name of its channel.
    pub name: String,
    /// Worth of a microstep.
    pub microstep: Microstep,
}

/// Worth of a microstep, or of a count of the encoder: larger than 0.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Microstep {
    /// Of a linear axis, in µm.
    Micrometres(f64),
    /// Of a rotary axis, in degrees.
    Degrees(f64),
}

impl Microstep {
    /// Unit of the channel, and a microstep in it.
    pub(crate) fn in_channel(self) -> (Unit, f64) {
        match self {
            Microstep::Micrometres(um) => (Unit::Millimetre, um * 1e-3),
            Microstep::Degrees(deg) => (Unit::Radian, deg * PI / 180.0),
        }
    }
}

impl Settings {
    /// Everything that cannot be used. Empty means that [`Settings::description`] makes a driver.
    pub fn problems(&self) -> Vec<Problem> {
        let mut problems = Vec::new();
        check_range(&mut problems, "address", self.address, 1, 99);
        check_range(&mut problems, "number", self.axis, 0, 9);
        if self.axis != 0 && self.axes.len() > 1 {
            let expected = "one table [[axis]], or number = 0 for the whole device";
            problems.push(Problem::new("axis", expected, self.axes.len()));
        }
        if self.axes.len() > 9 {
            problems.push(Problem::new("axis", "at most 9 axes", self.axes.len()));
        }
        for (index, axis) in self.axes.iter().enumerate() {
            let (Microstep::Micrometres(step) | Microstep::Degrees(step)) = axis.microstep;
            if !(step > 0.0 && step.is_finite()) {
                let word = match axis.microstep {
                    Microstep::Micrometres(_) => "microstep_um",
                    Microstep::Degrees(_) => "microstep_deg",
                };
                let key = format!("axis[{index}].{word}");
                problems.push(Problem::new(key, "a number above 0", step));
            }
        }
        let own = problems.is_empty();
        let described = self.description().ok().filter(|_| own);
        let described = described.map(|described| described.problems()).unwrap_or_default();
        problems.extend(described.into_iter().filter_map(own_key));
        problems
    }

    /// Channels of the readings: a position of each axis, in mm or rad.
    pub fn channels(&self) -> Vec<Channel> {
        let channel = |axis: &Axis| Channel::new(axis.name.clone(), axis.microstep.in_channel().0);
        self.axes.iter().map(channel).collect()
    }

    /// Description of the stage for the state machine of described devices.
    ///
    /// # Errors
    ///
    /// None in practice: the patterns of Zaber's replies are sound.
    pub fn description(&self) -> Result<Description, PatternError> {
        let (address, axis) = (self.address, self.axis);
        let ask = |words: &str| reply::command(address, axis, words, self.checksum);
        let rejected = Refusal {
            pattern: reply::rejection(address, axis)?,
            means: "the stage rejects the question for its position; check number and axes in the settings".to_owned(),
        };
        Ok(Description {
            framing: Framing::Lines { begin: Vec::new(), end: End::Any, longest: LONGEST },
            checksum: self.checksum.then_some(reply::CHECKSUM),
            layout: Layout::Pattern(reply::positions(address, axis, self.axes.len())?),
            fields: self.fields(),
            poll: Some(Poll {
                ask: ask("get pos"),
                interval_ms: self.interval_ms,
                timeout_ms: self.timeout_ms,
                late_limit_ms: self.late_limit_ms,
            }),
            hello: Some(Hello {
                ask: ask("get pos"),
                answer: reply::acceptance(address)?,
                timeout_ms: self.timeout_ms,
            }),
            refusals: vec![rejected],
            ignore: reply::others(address)?.to_vec(),
            ..Description::default()
        })
    }

    fn fields(&self) -> Vec<Field> {
        let position = |(index, axis): (usize, &Axis)| {
            let (unit, scale) = axis.microstep.in_channel();
            let group = Place::Group(format!("p{}", index + 1));
            Field { scale, ..Field::channel(&axis.name, group, unit) }
        };
        let mut good = warning::fine();
        good.push("--".to_owned());
        let warning = Field {
            role: Role::Status { good },
            flagged: warning::bad(),
            ..Field::channel(WARNING, Place::Group(WARNING.to_owned()), Unit::One)
        };
        self.axes.iter().enumerate().map(position).chain([warning]).collect()
    }
}

/// A problem of the description under the key of this driver.
fn own_key(problem: Problem) -> Option<Problem> {
    // What follows from the time-out is said of the time-out.
    if problem.key.starts_with("hello") {
        return None;
    }
    let key = problem.key.strip_prefix("poll.").unwrap_or(&problem.key);
    Some(Problem { key: key.replace("field", "axis"), ..problem })
}

/// Group of the pattern, and name of the field, that holds the warning flag.
const WARNING: &str = "warning";

/// Most bytes of a reply.
const LONGEST: usize = 256;
