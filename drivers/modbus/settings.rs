//! Settings of the driver.

use std::time::Duration;

use asphera_link::{Problem, check_range};

use crate::check;
use crate::map::{Block, Map};

/// How a Modbus device is reached and asked.
#[derive(Clone, Debug, PartialEq)]
pub struct Settings {
    /// Which framing the link carries.
    pub transport: Transport,
    /// Address of the device: 1 to 247; on Modbus TCP 0 and 255 too, which a device without a gateway
    /// takes for itself.
    pub unit_id: u8,
    /// What the device offers.
    pub map: MapSource,
    /// Time between two polls, 1 to 3 600 000 ms.
    pub poll_interval_ms: u32,
    /// How long the device may take to answer a request, 1 to 60 000 ms.
    pub timeout_ms: u32,
    /// RTU: how long after the time-out a late answer may still come, at least `timeout_ms`, at most
    /// 600 000 ms; `None`: four times `timeout_ms`. Until it came, or the line was silent for so long,
    /// nothing new is asked, because an RTU answer does not say which request it belongs to. The line
    /// must be silent for so long after the first answer of a connection, too.
    pub late_limit_ms: Option<u32>,
    /// How many registers (or bits) nobody asked for may be read to save a request, 0 to 124. Some
    /// devices refuse requests that touch an undefined register: 0 for these.
    pub max_gap_words: u16,
    /// Most registers of one request, 1 to 125 (bits: 16 times as many).
    pub max_words: u16,
    /// Silence between an answer and the next request, 0 to 10 000 ms; RTU at least 2 ms, which is
    /// the 3.5 characters of the specification from 19 200 Bd up (9600 Bd: 5 ms).
    pub pause_between_requests_ms: u32,
    /// Whether a poll that shows the device time of the reading before is passed over (and counted as
    /// repeated): the device has not measured since.
    pub skip_repeated: bool,
}

impl Default for Settings {
    /// RTU, unit 1, the map of the Baumer OM20, 10 polls a second.
    fn default() -> Settings {
        Settings {
            transport: Transport::Rtu,
            unit_id: 1,
            map: MapSource::BuiltIn("baumer-om20".to_owned()),
            poll_interval_ms: 100,
            timeout_ms: 200,
            late_limit_ms: None,
            max_gap_words: 8,
            max_words: 125,
            pause_between_requests_ms: 5,
            skip_repeated: true,
        }
    }
}

impl Settings {
    /// Everything that cannot be used. Empty means [`crate::Modbus::new`] takes the settings.
    pub fn problems(&self) -> Vec<Problem> {
        let mut problems = Vec::new();
        let rtu = self.transport == Transport::Rtu;
        if rtu {
            check_range(&mut problems, "unit_id", self.unit_id, 1, 247);
        } else if (248..=254).contains(&self.unit_id) {
            problems.push(Problem::new("unit_id", "0 to 247, or 255", self.unit_id));
        }
        check_range(&mut problems, "poll_interval_ms", self.poll_interval_ms, 1, 3_600_000);
        check_range(&mut problems, "timeout_ms", self.timeout_ms, 1, 60_000);
        if let Some(limit_ms) = self.late_limit_ms {
            check_range(&mut problems, "late_limit_ms", limit_ms, self.timeout_ms, 600_000);
        }
        check_range(&mut problems, "max_gap_words", self.max_gap_words, 0, 124);
        check_range(&mut problems, "max_words", self.max_words, 1, 125);
        let least_ms = if rtu { 2 } else { 0 };
        let pause_ms = self.pause_between_requests_ms;
        check_range(&mut problems, "pause_between_requests_ms", pause_ms, least_ms, 10_000);
        match self.map.resolve() {
            Some(map) => check::map(&mut problems, &map, self.max_words),
            None => {
                let expected = format!("a map, or one of {}", crate::BUILT_IN.join(", "));
                problems.push(Problem::new("map", expected, self.map.name()));
            }
        }
        problems
    }

    /// The requests of one poll, in order; empty when there is no such map.
    pub fn requests(&self) -> Vec<Block> {
        self.map.resolve().map_or_else(Vec::new, |map| {
            crate::plan::requests(&map, self.max_gap_words, self.max_words)
        })
    }

    pub(crate) fn late_limit(&self) -> Duration {
        let default_ms = self.timeout_ms.saturating_mul(4);
        Duration::from_millis(self.late_limit_ms.unwrap_or(default_ms).into())
    }
}

/// Framing of the link.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Transport {
    /// Modbus TCP: a header with a transaction id in front, no CRC.
    Tcp,
    /// Modbus RTU, on a serial line or tunnelled as it is: CRC at the end, no transaction id.
    Rtu,
}

impl std::str::FromStr for Transport {
    type Err = crate::WordError;

    fn from_str(word: &str) -> Result<Transport, crate::WordError> {
        match word {
            "tcp" => Ok(Transport::Tcp),
            "rtu" => Ok(Transport::Rtu),
            _ => Err(crate::WordError::new(word, "tcp or rtu")),
        }
    }
}

/// Where the register map comes from.
#[derive(Clone, Debug, PartialEq)]
pub enum MapSource {
    /// One that comes with the driver, by its name in [`crate::BUILT_IN`].
    BuiltIn(String),
    /// One's own.
    Own(Map),
}

impl MapSource {
    /// The map, if there is one of that name.
    pub fn resolve(&self) -> Option<Map> {
        match self {
            MapSource::BuiltIn(name) => Map::built_in(name),
            MapSource::Own(map) => Some(map.clone()),
        }
    }

    /// Its name.
    pub fn name(&self) -> &str {
        match self {
            MapSource::BuiltIn(name) => name,
            MapSource::Own(map) => &map.name,
        }
    }
}

impl From<Map> for MapSource {
    fn from(map: Map) -> MapSource {
        MapSource::Own(map)
    }
}

impl From<&str> for MapSource {
    fn from(name: &str) -> MapSource {
        MapSource::BuiltIn(name.to_owned())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::map::Function;

    fn keys(settings: &Settings) -> Vec<String> {
        settings.problems().into_iter().map(|problem| problem.key).collect()
    }

    #[test]
    fn defaults_have_no_problem() {
        assert_eq!(Settings::default().problems(), []);
        let block = Block { function: Function::ReadInput, address: 200, len: 13 };
        assert_eq!(Settings::default().requests(), [block]);
        assert_eq!(Settings::default().late_limit(), Duration::from_millis(800));
    }

    #[test]
    fn each_setting_out_of_range_is_named() {
        let settings = Settings {
            unit_id: 248,
            poll_interval_ms: 0,
            timeout_ms: 60_001,
            late_limit_ms: Some(5),
            max_gap_words: 125,
            max_words: 0,
            pause_between_requests_ms: 1,
            map: "om70".into(),
            ..Settings::default()
        };
        let expected = [
            "unit_id",
            "poll_interval_ms",
            "timeout_ms",
            "late_limit_ms",
            "max_gap_words",
            "max_words",
            "pause_between_requests_ms",
            "map",
        ];
        assert_eq!(keys(&settings), expected);
        let tcp = Settings {
            transport: Transport::Tcp,
            unit_id: 255,
            pause_between_requests_ms: 0,
            ..Settings::default()
        };
        assert_eq!(tcp.problems(), []);
    }

    #[test]
    fn no_block_of_the_map_may_be_longer_than_a_request() {
        let settings = Settings { max_words: 12, ..Settings::default() };
        assert_eq!(keys(&settings), ["block[0].length"]);
    }
}
