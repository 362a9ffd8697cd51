//! Settings of the driver.

use asphera_link::{Channel, Problem, Unit, check_range};

use crate::series::Series;
use crate::wire::Width;

/// A sensor as it was set up and saved.
#[derive(Clone, Debug, PartialEq)]
pub struct Settings {
    /// Series, which decides the formula.
    pub series: Series,
    /// Measuring range in mm, as on the type plate: 0.1 to 10 000. ILD1420-10 has 10.
    pub range_mm: f64,
    /// Further words of each block, in the order in which `GETOUTINFO_RS422` lists them.
    pub extras: Vec<Extra>,
    /// Whether each measurement answers one trigger, so that the counter counts triggers.
    pub triggered: bool,
    /// Silence after which the link is opened anew, 100 to 3 600 000 ms; 0: never, as between triggers.
    pub silence_ms: u32,
}

/// A further quantity of each block.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Extra {
    /// Exposure time; channel `exposure` in s.
    Shutter,
    /// Counter of measurements, 18 bits.
    Counter,
    /// The sensor's clock, two words, in steps of 10 µs.
    Timestamp,
    /// Intensity of the peak; channel `intensity` in percent.
    Intensity,
    /// State of the measurement.
    State,
    /// Distance before the sensor's own corrections; passed over.
    RawDistance,
}

impl Extra {
    /// Words of the configuration: those of the sensor's own command in lower case.
    pub const ALL: [(&'static str, Extra); 6] = [
        ("shutter", Extra::Shutter),
        ("counter", Extra::Counter),
        ("timestamp", Extra::Timestamp),
        ("intensity", Extra::Intensity),
        ("state", Extra::State),
        ("dist_raw", Extra::RawDistance),
    ];

    /// Words it takes.
    pub fn words(self) -> usize {
        if self == Extra::Timestamp { 2 } else { 1 }
    }

    fn channel(self) -> Option<Channel> {
        match self {
            Extra::Shutter => Some(Channel::new("exposure", Unit::Second)),
            Extra::Intensity => Some(Channel::new("intensity", Unit::One)),
            Extra::Counter | Extra::Timestamp | Extra::State | Extra::RawDistance => None,
        }
    }
}

impl Settings {
    /// Everything that cannot be used. Empty means that [`crate::Optoncdt::new`] takes the settings.
    pub fn problems(&self) -> Vec<Problem> {
        let mut problems = Vec::new();
        if !(0.1..=10_000.0).contains(&self.range_mm) {
            problems.push(Problem::new("range_mm", "0.1 to 10000", self.range_mm));
        }
        for (index, extra) in self.extras.iter().enumerate() {
            if self.extras[..index].contains(extra) {
                let word =
                    Extra::ALL.iter().find(|(_, known)| known == extra).map_or("", |(w, _)| w);
                problems.push(Problem::new("extras", "each once", format!("{word:?} twice")));
            }
        }
        if self.series.width() == Width::Two && !self.extras.is_empty() {
            problems.push(Problem::new("extras", "none: words of two bytes stand alone", "some"));
        }
        if self.triggered && !self.extras.contains(&Extra::Counter) {
            problems.push(Problem::new("triggered", "the counter among the extras", "none"));
        }
        if self.silence_ms != 0 {
            check_range(&mut problems, "silence_ms", self.silence_ms, 100, 3_600_000);
        }
        problems
    }

    /// Channels of the readings: `distance`, then those of the extras.
    pub fn channels(&self) -> Vec<Channel> {
        let distance = Channel::new("distance", Unit::Millimetre);
        std::iter::once(distance)
            .chain(self.extras.iter().filter_map(|extra| extra.channel()))
            .collect()
    }

    /// Words of a block.
    pub(crate) fn words(&self) -> usize {
        1 + self.extras.iter().map(|extra| extra.words()).sum::<usize>()
    }
}
