//! Devices on a CAN bus: bits against cantools and published frames, settings, and the machine in virtual time.

use asphera_described::{BitOrder, FAMILY, Signal, SignalForm};
use asphera_link::{
    CanFrame, CanId, Carries, Command, DeviceClock, Driver, Event, FaultKind, FdFlags, Flags,
    Input, Nanos, Output, Reading,
};
use proptest::prelude::*;
use proptest::test_runner::FileFailurePersistence;

fn hex(text: &str) -> Vec<u8> {
    let byte = |at| u8::from_str_radix(&text[at..at + 2], 16).expect("two digits");
    (0..text.len()).step_by(2).map(byte).collect()
}

/// 400 signals that cantools read, of every order and sign, in frames of 1 to 64 bytes.
#[test]
fn numbers_are_those_of_cantools() {
    let mut count = 0;
    for line in include_str!("can_signals.txt").lines() {
        let [place, data, value] = line.split(' ').collect::<Vec<_>>()[..] else {
            panic!("{line}")
        };
        let (start_bit, rest) = place.split_once('|').unwrap();
        let (bits, kind) = rest.split_once('@').unwrap();
        let (order, form) = match kind {
            "1+" => (BitOrder::Little, SignalForm::Unsigned),
            "1-" => (BitOrder::Little, SignalForm::Signed),
            "0+" => (BitOrder::Big, SignalForm::Unsigned),
            _ => (BitOrder::Big, SignalForm::Signed),
        };
        let (start_bit, bits) = (start_bit.parse().unwrap(), bits.parse().unwrap());
        let signal = Signal { start_bit, bits, order, form };
        // Beyond 2⁵³ both are rounded to the nearest.
        let exact: i128 = value.parse().unwrap();
        assert_eq!(signal.read(&hex(data)), Some(exact as f64), "{line}");
        if exact.unsigned_abs() < 1 << 53 {
            let (mut own, sent) = (hex(data), hex(data));
            signal.write(u64::MAX, &mut own);
            signal.write(signal.raw_of(exact as f64), &mut own);
            assert_eq!(own, sent, "{line}");
        }
        count += 1;
    }
    assert_eq!(count, 400);
}

/// A number that the bits cannot say is the nearest that they can.
#[test]
fn numbers_are_limited_to_their_bits() {
    let signal = |bits, form| Signal { start_bit: 0, bits, order: BitOrder::Little, form };
    let raw = |bits, form, number| signal(bits, form).raw_of(number) & (u64::MAX >> (64 - bits));
    let unsigned = [-1.0, 2.4, 2.5, 1e9].map(|number| raw(8, SignalForm::Unsigned, number));
    assert_eq!(unsigned, [0, 2, 3, 255]);
    let signed = [-1e9, -1.0, 127.0, 1e9].map(|number| raw(8, SignalForm::Signed, number));
    assert_eq!(signed, [0x80, 0xFF, 0x7F, 0x7F]);
    assert_eq!(raw(64, SignalForm::Signed, -1e30), 1 << 63);
    assert_eq!(raw(64, SignalForm::Unsigned, 1e30), u64::MAX);
    // IEEE 754: 1.5 is 3FC00000h and 3FF8000000000000h.
    assert_eq!(raw(32, SignalForm::Single, 1.5), 0x3FC0_0000);
    assert_eq!(raw(64, SignalForm::Double, 1.5), 0x3FF8_0000_0000_0000);
}

fn driver(text: &str) -> Box<dyn Driver> {
    let settings = FAMILY.parse("gauge", text).expect("settings of a test are sound");
    settings.driver().expect("settings of a test are sound")
}

fn events(driver: &mut dyn Driver) -> Vec<Event> {
    std::iter::from_fn(|| driver.poll_event()).collect()
}

fn readings(events: &[Event]) -> Vec<&Reading> {
    let readings = events.iter().filter_map(|event| match event {
        Event::Reading(reading) => Some(reading),
        _ => None,
    });
    readings.collect()
}

fn values(events: &[Event]) -> Vec<Vec<Option<f64>>> {
    readings(events).iter().map(|reading| reading.values.iter().collect()).collect()
}

fn give(driver: &mut dyn Driver, at_ms: u64, frame: CanFrame) -> Vec<Event> {
    driver.receive(Nanos::from_millis(at_ms), Input::Frame(&frame));
    events(driver)
}

fn classic(id: u16, data: &[u8]) -> CanFrame {
    CanFrame::data_frame(CanId::Standard(id), data).expect("eight bytes at most")
}

/// The example of cantools' README: message 496 of motohawk.dbc, with the line `1F0 [8] 80 4A 0F 00 00 00 00 00`: enabled, radius
/// 0.0 m, temperature 255.92 degK. Motorola order, a number over a byte's end.
#[test]
fn frame_of_the_readme_of_cantools() {
    let mut gauge = driver(
        "frame = 'can'\nid = 0x1F0\nlength = 8\nfield = [\n\
         { name = 'temperature', start_bit = 0, bits = 12, order = 'big', form = 'signed', scale = 0.01, offset = 250 },\n\
         { name = 'radius', start_bit = 6, bits = 6, order = 'big', scale = 0.1 },\n\
         { name = 'enable', start_bit = 7, bits = 1, order = 'big', role = 'status', good = ['1'] }]",
    );
    gauge.connected(Nanos::ZERO);
    let found = give(&mut *gauge, 1, classic(0x1F0, &[0x80, 0x4A, 0x0F, 0, 0, 0, 0, 0]));
    assert!(found.contains(&Event::Online) && found.contains(&Event::Ready));
    let reading = readings(&found)[0];
    assert!((reading.values.get(0).unwrap() - 255.92).abs() < 1e-9, "{reading:?}");
    assert_eq!((reading.values.get(1), reading.flags), (Some(0.0), Flags::empty()));
    let off = give(&mut *gauge, 2, classic(0x1F0, &[0, 0x4A, 0x0F, 0, 0, 0, 0, 0]));
    assert_eq!(readings(&off)[0].flags, Flags::SUSPECT);
}

/// J1939 EEC1 as introductions of the protocol print it: 0CF00401h, FF FF FF 68 13 FF FF FF is an engine speed of 621 rpm (SPN 190:
/// bytes 4 and 5, 0.125 rpm a bit). The mask leaves priority and source address out.
#[test]
fn engine_speed_of_j1939() {
    let mut gauge = driver(
        "frame = 'can'\nid = 0x00F00400\nextended = true\nmask = 0x03FFFF00\n\
         field = [{ name = 'speed', start_bit = 24, bits = 16, order = 'little', scale = 0.125 }]",
    );
    gauge.connected(Nanos::ZERO);
    let data = hex("FFFFFF6813FFFFFF");
    let frame = |id| CanFrame::data_frame(CanId::Extended(id), &data).unwrap();
    assert_eq!(values(&give(&mut *gauge, 1, frame(0x0CF0_0401))), [[Some(621.0)]]);
    assert_eq!(values(&give(&mut *gauge, 2, frame(0x18F0_0427))), [[Some(621.0)]]);
    assert!(give(&mut *gauge, 3, frame(0x0CF0_0501)).is_empty(), "another group");
    assert!(give(&mut *gauge, 3, classic(0x400, &data)).is_empty(), "another kind of identifier");
}

const SENDER: &str = "frame = 'can'\nid = 0x185\ngap_ms = 500\nlength = 7\nfield = [\n\
    { name = 'z', start_bit = 0, bits = 32, order = 'little', form = 'signed', scale = 1e-4, unit = 'mm', no_value = -2147483648, valid_range = [-10, 10] },\n\
    { name = 'n', start_bit = 32, bits = 8, order = 'little', role = 'count', modulus = 256 },\n\
    { name = 't', start_bit = 40, bits = 8, order = 'little', role = 'device-time', scale = 1e-3, unit = 's' },\n\
    { name = 'state', start_bit = 48, bits = 8, order = 'little', role = 'bits', weak = ['0'], saturated = ['1'], device_error = ['7'] }]";

fn sample(z: i32, n: u8, t: u8, state: u8) -> CanFrame {
    classic(0x185, &[&z.to_le_bytes()[..], &[n, t, state]].concat())
}

#[test]
fn counters_clocks_and_error_bits() {
    let settings = FAMILY.parse("gauge", SENDER).unwrap();
    assert_eq!((settings.carries(), settings.needs_fd()), (Some(Carries::CanFrames), false));
    assert_eq!(settings.count_cycle(), Ok(256));
    let clock = DeviceClock { wraps_ns: Some(256_000_000), tick_ns: 1_000_000 };
    assert_eq!(settings.clock(), Some(clock));
    let mut gauge = settings.driver().unwrap();
    gauge.connected(Nanos::ZERO);
    let found = give(&mut *gauge, 1, sample(-12_345, 7, 9, 0));
    let reading = readings(&found)[0];
    assert_eq!(reading.values.get(0), Some(-12_345.0 * 1e-4));
    assert_eq!(reading.count.unwrap().raw, 7);
    assert_eq!((reading.device_time_ns, reading.host), (Some(9_000_000), Nanos::from_millis(1)));
    let found = give(&mut *gauge, 2, sample(1, 8, 10, 0b11));
    assert_eq!(readings(&found)[0].flags, Flags::WEAK | Flags::SATURATED);
    let found = give(&mut *gauge, 3, sample(i32::MIN, 9, 11, 0));
    assert_eq!(readings(&found)[0].flags, Flags::NO_SIGNAL);
    let found = give(&mut *gauge, 4, sample(200_000, 9, 11, 0));
    assert_eq!(
        (readings(&found)[0].flags, values(&found)),
        (Flags::OUT_OF_RANGE, vec![vec![None]])
    );
    let found = give(&mut *gauge, 5, sample(1, 9, 11, 0x80));
    let Event::Fault(fault) = &found[0] else { panic!("{found:?}") };
    assert!(fault.detail.contains("the device reports state `bit 7`"), "{}", fault.detail);
    assert_eq!(give(&mut *gauge, 6, sample(1, 9, 11, 0x80)).len(), 1, "said once");
}

#[test]
fn frames_of_another_length_are_counted_and_said_once() {
    let mut gauge = driver(SENDER);
    gauge.connected(Nanos::ZERO);
    let found = give(&mut *gauge, 1, classic(0x185, &[1, 2]));
    let [Event::Discarded { bytes: 2 }, Event::Fault(fault)] = &found[..] else {
        panic!("{found:?}")
    };
    assert_eq!(fault.kind, FaultKind::Protocol);
    assert_eq!(fault.detail, "185#0102 has 2 bytes, expected 7: check identifier and length");
    assert_eq!(give(&mut *gauge, 2, classic(0x185, &[1])), [Event::Discarded { bytes: 1 }]);
    assert_eq!(gauge.poll_timeout(), None, "nothing proved yet that it is there");
    give(&mut *gauge, 3, sample(1, 1, 1, 0));
    assert_eq!(gauge.poll_timeout(), Some(Nanos::from_millis(503)));
    gauge.timeout(Nanos::from_millis(503));
    let [Event::Reopen(fault)] = &events(&mut *gauge)[..] else { panic!("no reopening") };
    assert!(fault.detail.contains("no frame for 500 ms"), "{}", fault.detail);
    assert_eq!(give(&mut *gauge, 504, sample(1, 1, 1, 0)), [Event::Discarded { bytes: 7 }]);
}

const ASKED: &str = "frame = 'can'\nid = 0x585\non_start = [{ id = 0, data = '\\x01\\x05' }]\n\
    poll = { id = 0x605, data = '\\x40\\x00', interval_ms = 50, timeout_ms = 100, late_limit_ms = 200 }\n\
    field = [{ name = 'z', start_bit = 7, bits = 16, order = 'big', unit = 'mm', scale = 1e-3 }]";

#[test]
fn answers_belong_to_their_questions() {
    let mut gauge = driver(ASKED);
    let sent =
        |gauge: &mut dyn Driver| std::iter::from_fn(|| gauge.poll_transmit()).collect::<Vec<_>>();
    let ask = Output::Frame(classic(0x605, &[0x40, 0]));
    gauge.command(Nanos::ZERO, Command::Start);
    gauge.connected(Nanos::ZERO);
    assert_eq!(sent(&mut *gauge), [Output::Frame(classic(0, &[1, 5])), ask.clone()]);
    // It may answer a question of the connection before.
    assert_eq!(give(&mut *gauge, 5, classic(0x585, &[0, 9])), [Event::Online]);
    assert_eq!(gauge.poll_timeout(), Some(Nanos::from_millis(205)));
    gauge.timeout(Nanos::from_millis(205));
    assert_eq!(sent(&mut *gauge), std::slice::from_ref(&ask));
    assert_eq!(values(&give(&mut *gauge, 210, classic(0x585, &[0, 10]))), [[Some(0.01)]]);
    assert_eq!(gauge.poll_timeout(), Some(Nanos::from_millis(255)));
    gauge.timeout(Nanos::from_millis(255));
    assert_eq!(sent(&mut *gauge), std::slice::from_ref(&ask));
    // No answer in time; a late one is none, and defers the next question.
    gauge.timeout(Nanos::from_millis(355));
    let [Event::Fault(fault)] = &events(&mut *gauge)[..] else { panic!("no fault") };
    assert!(fault.detail.starts_with("no answer to 605#4000 within 100 ms"), "{}", fault.detail);
    assert_eq!(give(&mut *gauge, 400, classic(0x585, &[0, 11])), [Event::Discarded { bytes: 2 }]);
    assert_eq!(gauge.poll_timeout(), Some(Nanos::from_millis(600)));
    gauge.timeout(Nanos::from_millis(600));
    assert_eq!(sent(&mut *gauge), [ask]);
    gauge.disconnected(Nanos::from_millis(610));
    assert_eq!(gauge.poll_timeout(), None);
}

#[test]
fn fd_frames_hold_more_numbers() {
    let settings = FAMILY.parse(
        "gauge",
        "frame = 'can'\nid = 0x123\nfd = true\n\
         field = [{ name = 'z', start_bit = 480, bits = 32, order = 'little', form = 'f32', unit = 'mm' }]",
    );
    let settings = settings.unwrap();
    assert!(settings.needs_fd());
    let mut gauge = settings.driver().unwrap();
    assert!(gauge.reads_fd());
    gauge.connected(Nanos::ZERO);
    let mut data = [0; 64];
    data[60..].copy_from_slice(&1.5_f32.to_le_bytes());
    let frame = CanFrame::fd_frame(CanId::Standard(0x123), &data, FdFlags::default()).unwrap();
    assert_eq!(values(&give(&mut *gauge, 1, frame)), [[Some(1.5)]]);
    let found = give(&mut *gauge, 2, classic(0x123, &[1]));
    let Event::Fault(fault) = &found[1] else { panic!("{found:?}") };
    assert!(fault.detail.contains("is a classic frame: set fd = false"), "{}", fault.detail);
}

fn wrong(text: &str) -> Vec<(usize, String)> {
    let problems = FAMILY.parse("gauge", text).expect_err("a mistake");
    problems.0.into_iter().map(|problem| (problem.line, problem.key)).collect()
}

#[test]
fn every_mistake_is_named_with_its_line() {
    let text = "frame = 'can'\nid = 0x800\nmasc = 1\n[poll]\nid = 0x20000000\nextended = true\n\
        [[field]]\nname = 'z'\nstart_bit = 0\nbits = 16\norder = 'intel'\nbegin = 1\n\
        [[on_start]]\nid = 1\ndata = '123456789'\n";
    let lines = [
        (2, "id"),
        (3, "masc"),
        (5, "poll.id"),
        (11, "field[0].order"),
        (12, "field[0].begin"),
        (15, "on_start[0].data"),
    ];
    let mut found = wrong(text);
    found.sort();
    assert_eq!(found, lines.map(|(line, key)| (line, key.to_owned())));
    let keys = |text: &str| wrong(text).into_iter().map(|(_, key)| key).collect::<Vec<_>>();
    assert_eq!(keys("frame = 'can'\nid = 1"), ["field"]);
    assert_eq!(keys("frame = 'cam'\nid = 1")[0], "frame");
    let with = |head: &str, field: &str| {
        let field = format!("field = [{{ name = 'z', order = 'little', {field} }}]");
        keys(&format!("frame = 'can'\nid = 1\n{head}\n{field}"))
    };
    assert_eq!(with("", "start_bit = 60, bits = 8"), ["field[0].start_bit"]);
    assert_eq!(with("length = 2", "start_bit = 8, bits = 16"), ["field[0].start_bit"]);
    assert_eq!(with("length = 12", "start_bit = 8, bits = 16"), ["length"]);
    assert_eq!(with("length = 9\nfd = true", "start_bit = 8, bits = 16"), ["length"]);
    assert_eq!(with("", "start_bit = 0, bits = 65"), ["field[0].bits"]);
    assert_eq!(with("", "start_bit = 0, bits = 16, form = 'f32'"), ["field[0].bits"]);
    assert_eq!(with("mask = 0x800", "start_bit = 0, bits = 1"), ["mask"]);
    assert_eq!(with("gap_ms = 5", "start_bit = 0, bits = 1"), ["gap_ms"]);
    assert_eq!(
        with("poll = { id = 2, interval_ms = 0 }", "start_bit = 0, bits = 1"),
        ["poll.interval_ms"]
    );
    assert_eq!(
        with("poll = { id = 2, bit_rate_switch = true }", "start_bit = 0, bits = 1"),
        ["poll.bit_rate_switch"]
    );
    assert_eq!(with("", "start_bit = 0, bits = 8, scale = 0"), ["field[0].scale"]);
    assert_eq!(
        with("", "start_bit = 0, bits = 8, role = 'bits', weak = ['x']"),
        ["field", "field[0].role"]
    );
}

proptest! {
    #![proptest_config(ProptestConfig {
        failure_persistence: Some(Box::new(FileFailurePersistence::WithSource("regressions"))),
        ..ProptestConfig::default()
    })]

    /// Bits that are written are read, and no others are touched.
    #[test]
    fn bits_survive_a_frame(
        start_bit in 0_u16..512, bits in 1_u8..=64, is_big: bool, raw: u64, data in prop::collection::vec(any::<u8>(), 64)
    ) {
        let order = if is_big { BitOrder::Big } else { BitOrder::Little };
        let signal = Signal { start_bit, bits, order, form: SignalForm::Unsigned };
        prop_assume!(signal.end_byte() <= 64);
        let raw = raw & (u64::MAX >> (64 - bits));
        let mut written = data.clone();
        signal.write(raw, &mut written);
        prop_assert_eq!(signal.raw(&written), Some(raw));
        signal.write(signal.raw(&data).unwrap(), &mut written);
        prop_assert_eq!(&written, &data);
        prop_assert_eq!(signal.raw(&data[..signal.end_byte() - 1]), None);
    }

    /// Frames of others, and frames of any content, never harm; a reading comes of the device's own frames alone.
    #[test]
    fn any_frames_are_readings_of_their_own_or_counted(
        frames in prop::collection::vec((prop::sample::select(vec![0x185_u16, 0x186, 0]), prop::collection::vec(any::<u8>(), 0..=8)), 0..50)
    ) {
        let mut gauge = driver(SENDER);
        gauge.connected(Nanos::ZERO);
        for (at, (id, data)) in frames.iter().enumerate() {
            let found = give(&mut *gauge, at as u64, classic(*id, data));
            let is_reading = *id == 0x185 && data.len() == 7;
            prop_assert_eq!(readings(&found).len(), usize::from(is_reading));
            let counted: u64 = found.iter().map(|event| match event {
                Event::Discarded { bytes } => *bytes,
                _ => 0,
            }).sum();
            let expected = if *id == 0x185 && !is_reading { data.len() as u64 } else { 0 };
            prop_assert_eq!(counted, expected);
        }
    }
}
