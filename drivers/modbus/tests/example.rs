//! The map of Baumer's OX200 in config/examples/ox200-line.toml, against the tables of its manual.
//!
//! No manual of ours prints an answer. The registers here are filled by the tables (OX100, pages 20 and 21; OX200,
//! page 27), the numbers in two registers as the OM20 manual writes them (page 23: 7C37h, 428Bh is 69.743 mm).

use asphera_link::{Driver, Event, Flags, Input, Nanos, Output, Reading};
use asphera_modbus::FAMILY;
use asphera_settings::File;

/// Input registers 200 to 223: synchronised and valid; good; output 1; value 1; six values that are not set; 500 Hz;
/// 12 s, 345678 µs; reserved.
const REGISTERS: [u16; 24] = [
    0x0006, 0x0000, 0x0001, 0x7C37, 0x428B, 0, 0x7FC0, 0, 0x7FC0, 0, 0x7FC0, 0, 0x7FC0, 0, 0x7FC0,
    0, 0x7FC0, 0, 0x43FA, 0x000C, 0, 0x464E, 0x0005, 0,
];

fn driver() -> Box<dyn Driver> {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../../config/examples/ox200-line.toml");
    let text = std::fs::read_to_string(path).expect("the example is there");
    let file = File::parse("ox200-line.toml", &text).expect("the example is TOML");
    let root = file.root();
    let table = root.section("device").section("table").section("settings");
    let settings = FAMILY.read(&table).expect("the example has all settings");
    settings.driver().expect("the example can be used")
}

/// The reading of an answer with these registers.
fn reading(registers: [u16; 24]) -> Reading {
    let mut driver = driver();
    driver.connected(Nanos::ZERO);
    let Some(Output::Bytes(request)) = driver.poll_transmit() else { panic!("nothing is asked") };
    // Transaction 0, unit 1, function 4: 24 registers from 200.
    assert_eq!(request, [0, 0, 0, 0, 0, 6, 1, 4, 0, 200, 0, 24]);
    let mut answer = vec![0, 0, 0, 0, 0, 51, 1, 4, 48];
    answer.extend(registers.iter().flat_map(|word| word.to_be_bytes()));
    driver.receive(Nanos::from_millis(1), Input::Bytes(&answer));
    let reading = std::iter::from_fn(|| driver.poll_event()).find_map(|event| match event {
        Event::Reading(reading) => Some(reading),
        _ => None,
    });
    reading.expect("an answer is a reading")
}

#[test]
fn values_stand_where_the_manual_says() {
    let good = reading(REGISTERS);
    assert!((good.values.get(0).expect("a height") - 69.7426).abs() < 5e-5);
    assert_eq!(good.values.get(1), Some(500.0));
    assert_eq!(good.device_time_ns, Some(12_345_678_000));
    assert_eq!(good.flags, Flags::empty());
}

#[test]
fn states_flag_the_reading() {
    let with = |index: usize, word: u16| {
        let mut registers = REGISTERS;
        registers[index] = word;
        let reading = reading(registers);
        (reading.values.get(0).is_some(), reading.flags)
    };
    assert_eq!(with(0, 0x0002), (false, Flags::NO_SIGNAL), "values are not valid");
    assert_eq!(with(0, 0x000E), (true, Flags::DEVICE_ERROR), "alarm");
    assert_eq!(with(1, 1), (true, Flags::WEAK));
    assert_eq!(with(1, 2), (false, Flags::NO_SIGNAL));
    assert_eq!(with(4, 0x7FC0), (false, Flags::NOT_FINITE), "a value that is not set");
}
