//! The driver as a configuration knows it: its keys, and what a station asks of its settings.

use std::fmt::Display;
use std::str::FromStr;

use asphera_link::{Carries, Channel, DeviceClock, DeviceSettings, Driver, Family, Problem, Unit};
use asphera_settings::Section;

use crate::{Block, Field, Kind, Map, MapSource, Modbus, Role, Settings, Transport};

/// Devices described by a register map: `driver = "modbus"`, on a serial line or TCP.
pub const FAMILY: Family = Family {
    name: "modbus",
    carries: Carries::Bytes,
    settings: |table| read(table).map(|settings| Box::new(settings) as _),
    propose: None,
};

fn read(table: &Section<'_>) -> Option<Settings> {
    let default = Settings::default();
    let transports = [("tcp", Transport::Tcp), ("rtu", Transport::Rtu)];
    let transport = table.required_word("framing", &transports);
    let map = map(table);
    let settings = Settings {
        transport: transport.unwrap_or(default.transport),
        unit_id: table.or("unit_id", default.unit_id),
        map: map.clone().unwrap_or(default.map),
        poll_interval_ms: table.or("poll_interval_ms", default.poll_interval_ms),
        timeout_ms: table.or("timeout_ms", default.timeout_ms),
        late_limit_ms: table.get("late_limit_ms"),
        max_gap_words: table.or("max_gap_words", default.max_gap_words),
        max_words: table.or("max_words", default.max_words),
        pause_between_requests_ms: table
            .or("pause_between_requests_ms", default.pause_between_requests_ms),
        skip_repeated: table.or("skip_repeated", default.skip_repeated),
    };
    map.map(|_| settings)
}

/// The name of a built-in map, or the map that the tables `field` and `block` make.
fn map(table: &Section<'_>) -> Option<MapSource> {
    let fields = table.array("field");
    if fields.is_empty() {
        return table.required("map").map(MapSource::BuiltIn);
    }
    if table.has("map") {
        table.problem("map", "either a built-in map or fields", "both");
    }
    let fields: Vec<Option<Field>> = fields.iter().map(field).collect();
    let fields: Option<Vec<Field>> = fields.into_iter().collect();
    let blocks: Vec<Option<Block>> = table.array("block").iter().map(block).collect();
    let blocks: Option<Vec<Block>> = blocks.into_iter().collect();
    let (fields, blocks) = fields.zip(blocks)?;
    Some(MapSource::Own(Map { name: "fields".to_owned(), fields, blocks }))
}

fn field(table: &Section<'_>) -> Option<Field> {
    let name = table.required("name");
    let function = parsed(table, "function");
    let address = table.required("address");
    let kind = parsed(table, "kind");
    let word_order = if table.has("word_order") {
        parsed(table, "word_order")
    } else {
        Some(Default::default())
    };
    let units: Vec<(&str, Unit)> = Unit::ALL.iter().map(|unit| (unit.symbol(), *unit)).collect();
    let unit = table.word("unit", Unit::One, &units);
    let role = role(table);
    let valid_range = table.range("valid_range");
    let (scale, offset) = (table.or("scale", 1.0), table.or("offset", 0.0));
    table.finish();
    Some(Field {
        name: name?,
        function: function?,
        address: address?,
        kind: kind?,
        word_order: word_order?,
        scale,
        offset,
        unit,
        role: role?,
        valid_range,
    })
}

/// Registers the device wants read whole.
fn block(table: &Section<'_>) -> Option<Block> {
    let function = parsed(table, "function");
    let (address, len) = (table.required("address"), table.required("length"));
    table.finish();
    Some(Block { function: function?, address: address?, len: len? })
}

fn role(table: &Section<'_>) -> Option<Role> {
    let words = ["channel", "quality", "alarm", "device-time-s", "device-time-us", "count"]
        .map(|word| (word, word));
    Some(match table.word("role", "channel", &words) {
        "quality" => Role::Quality {
            good: table.or("good", vec![0]),
            weak: table.or("weak", Vec::new()),
            bad: table.or("bad", Vec::new()),
            judges: table.or("judges", Vec::new()),
        },
        "alarm" => Role::Alarm,
        "device-time-s" => Role::DeviceTimeSeconds,
        "device-time-us" => Role::DeviceTimeMicros,
        "count" => Role::Count { first: table.or("first", 0), modulus: table.required("modulus")? },
        _ => Role::Channel,
    })
}

/// A word of the register map.
fn parsed<T: FromStr>(table: &Section<'_>, key: &str) -> Option<T>
where
    T::Err: Display,
{
    let word: String = table.required(key)?;
    word.parse().inspect_err(|error| table.problem(key, "a word of the register map", error)).ok()
}

impl DeviceSettings for Settings {
    fn problems(&self) -> Vec<Problem> {
        Settings::problems(self)
    }

    fn channels(&self) -> Vec<Channel> {
        self.map.resolve().map_or_else(Vec::new, |map| map.channels())
    }

    fn count_cycle(&self) -> Result<u32, &'static str> {
        let map = self.map.resolve();
        let mut fields = map.iter().flat_map(|map| &map.fields);
        let cycle = fields.find_map(|field| match field.role {
            Role::Count { modulus, .. } => Some(modulus),
            _ => None,
        });
        cycle.ok_or("its map has no field with the role count")
    }

    fn clock(&self) -> Option<DeviceClock> {
        let map = self.map.resolve()?;
        let field = |role: &Role| map.fields.iter().find(|field| field.role == *role);
        match (field(&Role::DeviceTimeSeconds), field(&Role::DeviceTimeMicros)) {
            (Some(_), Some(_)) => Some(DeviceClock { wraps_ns: None, tick_ns: 1000 }),
            (Some(_), None) => Some(DeviceClock { wraps_ns: None, tick_ns: 1_000_000_000 }),
            (None, Some(field)) => {
                let bits = if field.kind == Kind::U16 { 16 } else { 32 };
                Some(DeviceClock { wraps_ns: Some(1000 << bits), tick_ns: 1000 })
            }
            (None, None) => None,
        }
    }

    fn driver(&self) -> Result<Box<dyn Driver>, Vec<Problem>> {
        Ok(Box::new(Modbus::new(self.clone())?))
    }
}

#[cfg(test)]
mod tests {
    use asphera_settings::Problems;

    use super::*;

    fn settings(text: &str) -> Result<Box<dyn DeviceSettings>, Problems> {
        FAMILY.parse("thermal", text)
    }

    #[test]
    fn a_built_in_map_or_fields_give_a_driver() {
        let built_in = settings("framing = \"tcp\"\nmap = \"baumer-om20\"").unwrap();
        assert_eq!(built_in.driver().unwrap().channels(), built_in.channels());
        assert!(built_in.count_cycle().unwrap_err().contains("role count"));
        let text = "framing = \"rtu\"\n[[field]]\nname = \"t\"\nfunction = \"input\"\naddress = 0\n\
                    kind = \"i16\"\nunit = \"degC\"\n[[field]]\nname = \"n\"\nfunction = \"input\"\n\
                    address = 1\nkind = \"u16\"\nrole = \"count\"\nmodulus = 1000";
        assert_eq!(built_in.clock(), Some(DeviceClock { wraps_ns: None, tick_ns: 1000 }));
        let own = settings(text).unwrap();
        assert_eq!(own.channels(), [Channel::new("t", Unit::DegreeCelsius)]);
        assert_eq!(own.count_cycle(), Ok(1000));
        assert_eq!(own.driver().unwrap().channels(), own.channels());
    }

    #[test]
    fn every_mistake_is_told_under_the_key_of_the_table() {
        let problems = settings("unit_id = 250\nmap = \"om70\"\npause_ms = 3").unwrap_err();
        let told: Vec<_> =
            problems.0.iter().map(|found| (found.line, found.key.as_str())).collect();
        assert_eq!(told, [(1, "framing"), (1, "unit_id"), (2, "map"), (3, "pause_ms")]);
        let text = "framing = \"tcp\"\n[[field]]\nname = \"t\"\nfunction = \"input\"\naddress = 0\n\
                    kind = \"f32\"\nscale = 0\n[[block]]\nfunction = \"input\"\naddress = 1\nlength = 1";
        let problems = settings(text).unwrap_err();
        let told: Vec<_> = problems.0.iter().map(|found| found.key.as_str()).collect();
        assert_eq!(told, ["field[0].scale", "block[0].address", "block[0].length"]);
    }
}
