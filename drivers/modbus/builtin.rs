//! Maps of known devices.

use asphera_link::Unit;

use crate::map::{Block, Field, Function, Kind, Map, Role, WordOrder};

/// Names of the maps that come with the driver.
pub const BUILT_IN: [&str; 1] = ["baumer-om20"];

impl Map {
    /// The map of a known device, by its name in [`BUILT_IN`].
    pub fn built_in(name: &str) -> Option<Map> {
        match name {
            "baumer-om20" => Some(baumer_om20()),
            _ => None,
        }
    }
}

/// Baumer OM20 and OM30 laser distance sensors with RS-485.
///
/// Operating manual OM20, section Modbus, pages 13, 14, 22, 23 and 45: the measurement is the block
/// of input registers 200 to 212, which cannot be read in parts; of a value in two registers the less
/// significant one is at the lower address. Distance is in mm, measuring rate in Hz, response delay
/// in µs. Factory setting of the line: slave 1, 57600 Bd, 8 data bits, even parity, 1 stop bit.
fn baumer_om20() -> Map {
    let input = Function::ReadInput;
    let field = |name: &str, address: u16, kind: Kind, unit: Unit, role: Role| Field {
        word_order: WordOrder::Cdab,
        role,
        ..Field::channel(name, input, address, kind, unit)
    };
    let channel = |name: &str, address: u16, kind: Kind, unit: Unit| {
        field(name, address, kind, unit, Role::Channel)
    };
    let quality = Role::Quality {
        good: vec![0],
        weak: vec![1],
        bad: vec![2],
        judges: vec!["distance".to_owned()],
    };
    Map {
        name: "Baumer OM20/OM30".to_owned(),
        fields: vec![
            channel("distance", 202, Kind::F32, Unit::Millimetre),
            channel("rate", 204, Kind::F32, Unit::Hertz),
            channel("exposure_reserve", 206, Kind::U16, Unit::One),
            Field { scale: 1e-6, ..channel("response_delay", 207, Kind::U32, Unit::Second) },
            channel("switch_output", 201, Kind::Bit(0), Unit::One),
            field("quality", 200, Kind::U16, Unit::One, quality),
            field("alarm", 201, Kind::Bit(1), Unit::One, Role::Alarm),
            field("time_s", 209, Kind::U32, Unit::Second, Role::DeviceTimeSeconds),
            Field {
                scale: 1e-6,
                ..field("time_us", 211, Kind::U32, Unit::Second, Role::DeviceTimeMicros)
            },
        ],
        blocks: vec![Block { function: input, address: 200, len: 13 }],
    }
}
