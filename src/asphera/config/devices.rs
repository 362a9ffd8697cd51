//! The tables `device.NAME`: which driver, on which link, with which settings.

use std::fmt::Display;
use std::str::FromStr;
use std::time::Duration;

use asphera_chrocodile::{Chrocodile, Trigger};
use asphera_cia406::{Cia406, Kind, PositionObject, Transmission};
use asphera_link::{Channel, Driver, Problem, Unit};
use asphera_modbus::{Block, Field, Map, MapSource, Modbus, Role, Transport};

use super::document::Section;

/// One device.
#[derive(Clone, Debug)]
pub struct DeviceConfig {
    /// Name of its table.
    pub name: String,
    /// Which link it is on.
    pub link: usize,
    /// Its driver's settings.
    pub driver: DriverConfig,
    /// What it measures.
    pub channels: Vec<Channel>,
}

/// Settings of a driver. A new driver is entered here and in [`DriverConfig::build`].
#[derive(Clone, Debug)]
pub enum DriverConfig {
    /// `chrocodile2`.
    Chrocodile(asphera_chrocodile::Settings),
    /// `cia406`.
    Cia406(asphera_cia406::Settings),
    /// `modbus`.
    Modbus(asphera_modbus::Settings),
}

#[derive(Clone, Copy)]
enum DriverKind {
    Chrocodile,
    Cia406,
    Modbus,
}

const DRIVERS: [(&str, DriverKind); 3] = [
    ("chrocodile2", DriverKind::Chrocodile),
    ("cia406", DriverKind::Cia406),
    ("modbus", DriverKind::Modbus),
];

impl DriverConfig {
    /// Makes the driver.
    ///
    /// # Errors
    ///
    /// What the driver says of settings it cannot use.
    pub fn build(&self) -> Result<Box<dyn Driver>, String> {
        match self {
            DriverConfig::Chrocodile(settings) => match Chrocodile::new(settings.clone()) {
                Ok(driver) => Ok(Box::new(driver)),
                Err(error) => Err(error.to_string()),
            },
            DriverConfig::Cia406(settings) => match Cia406::new(settings.clone()) {
                Ok(driver) => Ok(Box::new(driver)),
                Err(problems) => Err(words(&problems)),
            },
            DriverConfig::Modbus(settings) => match Modbus::new(settings.clone()) {
                Ok(driver) => Ok(Box::new(driver)),
                Err(problems) => Err(words(&problems)),
            },
        }
    }

    /// Whether it takes CAN frames, which several devices can share.
    pub fn is_can(&self) -> bool {
        matches!(self, DriverConfig::Cia406(_))
    }

    /// How many numbers the device's trigger count has, if it counts every trigger; otherwise what keeps it
    /// from that, in words.
    pub fn count_cycle(&self) -> Result<u32, &'static str> {
        match self {
            DriverConfig::Chrocodile(settings) => {
                if !settings.signals.contains(&EXPOSURE_COUNT) {
                    Err("signal 75, the exposure count, is not among its signals")
                } else if settings.averaging > 1 {
                    Err("it averages several exposures")
                } else if settings.trigger == Trigger::Free {
                    Err("it runs free of the trigger")
                } else {
                    Ok(1 << 16)
                }
            }
            DriverConfig::Cia406(settings) => {
                match (settings.transmission, settings.sync_counter_overflow) {
                    (Transmission::Sync { every: 1 }, Some(overflow)) => Ok(overflow.into()),
                    (Transmission::Sync { every: 1 }, None) => Err("its SYNC has no counter"),
                    _ => Err("it does not answer every SYNC"),
                }
            }
            DriverConfig::Modbus(settings) => {
                let map = settings.map.resolve();
                let fields = map.iter().flat_map(|map| &map.fields);
                let mut cycles = fields.filter_map(|field| match field.role {
                    Role::Count { modulus, .. } => Some(modulus),
                    _ => None,
                });
                cycles.next().ok_or("its map has no field with the role count")
            }
        }
    }

    /// Its number on a shared bus.
    pub fn bus_number(&self) -> Option<u8> {
        match self {
            DriverConfig::Cia406(settings) => Some(settings.node_id),
            DriverConfig::Chrocodile(_) | DriverConfig::Modbus(_) => None,
        }
    }

    /// How long the driver may hold a reading back, to be sure of it.
    pub fn holds_back(&self) -> Duration {
        match self {
            DriverConfig::Chrocodile(settings) => Duration::from_millis(settings.silence_ms.into()),
            DriverConfig::Cia406(_) | DriverConfig::Modbus(_) => Duration::ZERO,
        }
    }

    fn problems(&self) -> Vec<Problem> {
        match self {
            DriverConfig::Chrocodile(settings) => settings.problems(),
            DriverConfig::Cia406(settings) => settings.problems(),
            DriverConfig::Modbus(settings) => settings.problems(),
        }
    }
}

/// The key a person wrote for a setting of a driver.
fn key_of(setting: &str) -> String {
    match setting {
        "kind.step_nm" => "step_nm".to_owned(),
        "kind.counts_per_turn" => "counts_per_turn".to_owned(),
        "transmission.every" => "every_sync".to_owned(),
        "transmission.period_ms" => "event_timer_ms".to_owned(),
        other => other.replace("map.fields", "field").replace("map.blocks", "block"),
    }
}

/// CHRocodile's identifier of the exposure count.
const EXPOSURE_COUNT: u16 = 75;

fn words(problems: &[Problem]) -> String {
    let words = problems.iter().map(|Problem { key, expected, found }| {
        format!("{key}: expected {expected}, found {found}")
    });
    words.collect::<Vec<_>>().join("; ")
}

/// Names with commas between; of many the first, for every device may be told them.
fn listed(names: &[String]) -> String {
    let rest = if names.len() > LISTED { ", …" } else { "" };
    names[..names.len().min(LISTED)].join(", ") + rest
}

/// Most names that a problem lists.
const LISTED: usize = 20;

/// Reads one device; `links` are the names of the links there are.
pub(super) fn read(name: String, table: &Section<'_>, links: &[String]) -> Option<DeviceConfig> {
    let kind = table.required_word("driver", &DRIVERS);
    let link: Option<String> = table.required("link");
    let index = link.and_then(|link| {
        let index = links.iter().position(|known| *known == link);
        if index.is_none() {
            table.problem(
                "link",
                format!("one of the links {}", listed(links)),
                format!("{link:?}"),
            );
        }
        index
    });
    let settings = table.section("settings");
    let Some(kind) = kind else {
        table.finish();
        return None;
    };
    let driver = match kind {
        DriverKind::Chrocodile => DriverConfig::Chrocodile(chrocodile(&settings)),
        DriverKind::Cia406 => DriverConfig::Cia406(cia406(&settings)),
        DriverKind::Modbus => DriverConfig::Modbus(modbus(&settings)?),
    };
    settings.finish();
    table.finish();
    let problems = driver.problems();
    for problem in &problems {
        settings.problem(&key_of(&problem.key), &problem.expected, &problem.found);
    }
    // Without problems the driver can be made; what it measures is asked of itself.
    let channels =
        if problems.is_empty() { driver.build().ok()?.channels().to_vec() } else { Vec::new() };
    Some(DeviceConfig { name, link: index?, driver, channels })
}

fn chrocodile(table: &Section<'_>) -> asphera_chrocodile::Settings {
    let default = asphera_chrocodile::Settings::default();
    let triggers = [("each", Trigger::Each), ("free", Trigger::Free)];
    asphera_chrocodile::Settings {
        signals: table.or("signals", default.signals),
        sample_rate_hz: table.or("sample_rate_hz", default.sample_rate_hz),
        averaging: table.or("averaging", default.averaging),
        trigger: table.word("trigger", default.trigger, &triggers),
        scale_um: table.get("scale_um"),
        intensity_min: table.or("intensity_min", default.intensity_min),
        sync: default.sync,
        ready_timeout_ms: table.or("ready_timeout_ms", default.ready_timeout_ms),
        silence_ms: table.or("silence_ms", default.silence_ms),
    }
}

fn cia406(table: &Section<'_>) -> asphera_cia406::Settings {
    let default = asphera_cia406::Settings::default();
    let objects = [
        ("6020", PositionObject::MultiSensor),
        ("6004", PositionObject::Single),
        ("6004-unsigned", PositionObject::SingleUnsigned),
    ];
    let kind = match table.word(
        "kind",
        "linear",
        &[("linear", "linear"), ("rotary", "rotary"), ("counts", "counts")],
    ) {
        "rotary" => {
            Kind::Rotary { counts_per_turn: table.required("counts_per_turn").unwrap_or(1) }
        }
        "counts" => Kind::Counts,
        _ => Kind::Linear { step_nm: table.get("step_nm") },
    };
    let transmission = match table.get("event_timer_ms") {
        Some(period_ms) => Transmission::EventTimer { period_ms },
        None => Transmission::Sync { every: table.or("every_sync", 1) },
    };
    asphera_cia406::Settings {
        node_id: table.required("node_id").unwrap_or(default.node_id),
        vendor_id: table.get("vendor_id"),
        position: table.word("position_object", default.position, &objects),
        kind,
        map_velocity: table.or("map_velocity", default.map_velocity),
        map_status: table.or("map_status", default.map_status),
        transmission,
        sync_counter_overflow: match table.or("sync_counter_overflow", 240u8) {
            0 => None,
            overflow => Some(overflow),
        },
        sync_window_us: table.get("sync_window_us"),
        heartbeat_ms: table.or("heartbeat_ms", default.heartbeat_ms),
        sdo_timeout_ms: table.or("sdo_timeout_ms", default.sdo_timeout_ms),
    }
}

fn modbus(table: &Section<'_>) -> Option<asphera_modbus::Settings> {
    let default = asphera_modbus::Settings::default();
    let transports = [("tcp", Transport::Tcp), ("rtu", Transport::Rtu)];
    let transport = table.required_word("framing", &transports);
    let fields = table.array("field");
    let map = if fields.is_empty() {
        table.required("map").map(MapSource::BuiltIn)
    } else {
        if table.has("map") {
            table.problem("map", "either a built-in map or fields", "both");
        }
        let fields: Vec<Option<Field>> = fields.iter().map(field).collect();
        let fields: Option<Vec<Field>> = fields.into_iter().collect();
        let blocks: Vec<Option<Block>> = table.array("block").iter().map(block).collect();
        let blocks: Option<Vec<Block>> = blocks.into_iter().collect();
        fields.zip(blocks).map(|(fields, blocks)| {
            MapSource::Own(Map { name: "fields".to_owned(), fields, blocks })
        })
    };
    let settings = asphera_modbus::Settings {
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
    let valid_range = table.get::<Vec<f64>>("valid_range").and_then(|range| match range[..] {
        [low, high] if low < high => Some((low, high)),
        _ => {
            table.problem("valid_range", "[lowest, highest]", format!("{range:?}"));
            None
        }
    });
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

/// A word the driver reads itself.
fn parsed<T: FromStr>(table: &Section<'_>, key: &str) -> Option<T>
where
    T::Err: Display,
{
    let word: String = table.required(key)?;
    word.parse().inspect_err(|error| table.problem(key, "a word of the register map", error)).ok()
}
