//! The state machine: refusals, silence, formats that change or are missing, reconnects.

use asphera_chrocodile::wire::packet::{Argument, CommandFlags, HEADER_LEN, Message, Name};
use asphera_chrocodile::{PacketChrocodile, PacketSettings, Trigger};
use asphera_link::{Command, Driver as _, Event, FaultKind, Input, Nanos, Output};

use crate::device::{answer, bytes_of, converse, data, events, format, outcome, streaming};

const SIGNALS: [u16; 2] = [75, 256];

fn settings() -> PacketSettings {
    PacketSettings { signals: SIGNALS.to_vec(), ..PacketSettings::default() }
}

fn value(sample: u32, id: u16, _: u16) -> f64 {
    if id == 75 { f64::from(sample) } else { 1000.0 + f64::from(sample) }
}

fn name(output: Option<Output>) -> String {
    let Some(Output::Bytes(sent)) = output else { return "nothing".into() };
    Message::decode(&sent[HEADER_LEN..]).unwrap().name.to_string()
}

fn message(name: &str, ticket: u16, flags: CommandFlags, arguments: Vec<Argument>) -> Vec<u8> {
    let mut bytes = Vec::new();
    Message { flags, ..Message::command(Name::new(name), ticket, arguments) }.encode(&mut bytes);
    bytes
}

fn counts(driver: &mut PacketChrocodile) -> Vec<u32> {
    outcome(driver).0.iter().map(|reading| reading.count.unwrap().raw).collect()
}

/// Time of a sample in a packet: 5 s, and a period of 1 ms each.
#[test]
fn samples_of_a_free_device_have_the_time_of_their_packet_and_their_row() {
    let format = format(&SIGNALS, 1, 1);
    let mut driver = streaming(PacketSettings { trigger: Trigger::Free, ..settings() }, &format);
    driver.receive(Nanos::ZERO, Input::Bytes(&data(&format, 0..3, value)));
    let times: Vec<_> =
        outcome(&mut driver).0.iter().map(|reading| reading.device_time_ns.unwrap()).collect();
    assert_eq!(times, [5_000_000_000, 5_001_000_000, 5_002_000_000]);
    // Silent for more than its answer may take.
    let due = driver.poll_timeout().unwrap();
    assert_eq!(due, Nanos::from_millis(1000));
    driver.timeout(due);
    let found = events(&mut driver);
    let [Event::Reopen(fault)] = &found[..] else { panic!("{found:?}") };
    assert_eq!(fault.detail, "no data for 1000 ms though free-running: check cable and power");
}

#[test]
fn data_of_an_unknown_format_are_counted_and_the_format_is_asked_for() {
    let (old, new) = (format(&SIGNALS, 1, 1), format(&[256, 75], 2, 1));
    let mut driver = streaming(settings(), &old);
    let lost = data(&new, 0..2, value);
    driver.receive(Nanos::ZERO, Input::Bytes(&lost));
    driver.receive(Nanos::ZERO, Input::Bytes(&lost));
    let found = events(&mut driver);
    let [Event::Fault(fault), Event::Discarded { bytes: a }, Event::Discarded { bytes: b }] =
        &found[..]
    else {
        panic!("{found:?}")
    };
    assert_eq!(fault.detail, "data of the format 2: it did not come, and is asked for");
    assert_eq!((fault.kind, a + b), (FaultKind::Protocol, 2 * lost.len() as u64));
    let sent = driver.poll_transmit();
    assert_eq!((name(sent.clone()), driver.poll_transmit()), ("SODX".into(), None));
    let Some(Output::Bytes(sent)) = sent else { panic!("nothing is sent") };
    driver.receive(Nanos::ZERO, Input::Bytes(&answer(&sent, &new)));
    driver.receive(Nanos::ZERO, Input::Bytes(&data(&new, 2..4, value)));
    // Data of the first format may still come.
    driver.receive(Nanos::ZERO, Input::Bytes(&data(&old, 4..5, value)));
    assert_eq!(counts(&mut driver), [2, 3, 4]);
}

#[test]
fn a_format_that_comes_by_itself_is_followed() {
    let (old, new) = (format(&SIGNALS, 1, 1), format(&[256, 75], 2, 1));
    let mut driver = streaming(settings(), &old);
    let bytes = [data(&old, 0..1, value), bytes_of(&new), data(&new, 1..3, value)].concat();
    driver.receive(Nanos::ZERO, Input::Bytes(&bytes));
    assert_eq!((counts(&mut driver), driver.poll_transmit()), (vec![0, 1, 2], None));
}

#[test]
fn a_device_that_sends_what_nobody_asked_for_is_reopened() {
    let good = format(&SIGNALS, 1, 1);
    let mut driver = streaming(settings(), &good);
    let bad = format(&[75, 257], 2, 1);
    driver.receive(Nanos::ZERO, Input::Bytes(&bytes_of(&bad)));
    let mut reopened = None;
    for _ in 0..2000 {
        driver.receive(Nanos::ZERO, Input::Bytes(&data(&bad, 0..1, value)));
        converse(&mut driver, Nanos::ZERO, &bad);
        for event in events(&mut driver) {
            match event {
                Event::Reading(reading) => panic!("{reading:?}"),
                Event::Reopen(fault) => reopened = Some(fault.detail),
                _ => {}
            }
        }
    }
    let reopened = reopened.unwrap();
    assert!(reopened.contains(" bytes without a sample as set up: check"), "{reopened}");
}

#[test]
fn a_signal_that_the_device_does_not_send_is_named() {
    let mut driver = PacketChrocodile::new(settings()).unwrap();
    driver.connected(Nanos::ZERO);
    let without = format(&[75, 257], 1, 1);
    for attempt in 0..2 {
        converse(&mut driver, Nanos::ZERO, &without);
        let due = driver.poll_timeout().unwrap();
        assert_eq!(due, Nanos::from_millis(1000 * (attempt + 1)));
        driver.timeout(due);
    }
    let found = events(&mut driver);
    let [Event::Online, Event::Fault(fault)] = &found[..] else { panic!("{found:?}") };
    assert_eq!(fault.kind, FaultKind::Refused);
    assert!(
        fault
            .detail
            .starts_with("SODX: the format that came gives no readings: it has no signal 256")
    );
    // A start tries again.
    driver.command(Nanos::from_millis(9), Command::Start);
    converse(&mut driver, Nanos::from_millis(9), &format(&SIGNALS, 2, 1));
    assert_eq!(events(&mut driver), [Event::Ready]);
}

#[test]
fn a_refused_command_is_a_fault_with_the_words_of_the_device() {
    let mut driver = PacketChrocodile::new(settings()).unwrap();
    driver.connected(Nanos::ZERO);
    let ok = message("STO", 1, CommandFlags::empty(), Vec::new());
    driver.receive(Nanos::ZERO, Input::Bytes(&ok));
    let text = Argument::Text(b"not valid\x1B".to_vec());
    let no = message("SHZ", 2, CommandFlags::ERROR, vec![Argument::Int(-7), text]);
    driver.receive(Nanos::ZERO, Input::Bytes(&no));
    let found = events(&mut driver);
    let [Event::Online, Event::Fault(fault)] = &found[..] else { panic!("{found:?}") };
    assert_eq!(
        fault.detail,
        "SHZ: refused, the answer was -7 \"not valid\\u{1b}\"; see the command reference"
    );
    assert_eq!(driver.poll_timeout(), None);
}

#[test]
fn answers_of_others_and_late_ones_are_passed_over() {
    let mut driver = PacketChrocodile::new(settings()).unwrap();
    driver.connected(Nanos::ZERO);
    assert_eq!(name(driver.poll_transmit()), "STO");
    for (name, ticket) in [("STO", 2), ("STA", 1), ("STO", 0)] {
        let other = message(name, ticket, CommandFlags::empty(), Vec::new());
        driver.receive(Nanos::ZERO, Input::Bytes(&other));
    }
    assert_eq!((events(&mut driver), driver.poll_transmit()), (Vec::new(), None));
    driver.timeout(Nanos::from_millis(1000));
    assert_eq!(name(driver.poll_transmit()), "STO");
    driver.timeout(Nanos::from_millis(2000));
    let found = events(&mut driver);
    let [Event::Reopen(fault)] = &found[..] else { panic!("{found:?}") };
    assert!(fault.detail.starts_with("no answer to STO within 1000 ms, asked 2 times: check"));
}

#[test]
fn a_warning_is_reported_and_a_new_probe_followed() {
    let format = format(&[75, 16640], 1, 1);
    let settings = PacketSettings { signals: vec![75, 16640], ..settings() };
    let mut driver = PacketChrocodile::new(settings).unwrap();
    driver.connected(Nanos::ZERO);
    let warning = message("STO", 1, CommandFlags::WARNING, vec![Argument::Int(5)]);
    driver.receive(Nanos::ZERO, Input::Bytes(&warning));
    driver.command(Nanos::ZERO, Command::Start);
    // The first command is answered already.
    assert_eq!(name(driver.poll_transmit()), "STO");
    converse(&mut driver, Nanos::ZERO, &format);
    let found = events(&mut driver);
    let [Event::Online, Event::Fault(fault), Event::Ready] = &found[..] else {
        panic!("{found:?}")
    };
    assert_eq!(
        (fault.kind, &*fault.detail),
        (FaultKind::Device, "STO: done with a warning, 5; see the command reference")
    );
    let half = |_: u32, id: u16, _: u16| if id == 75 { 1.0 } else { 16_384.0 };
    let update = message("SCA", 0, CommandFlags::UPDATE, vec![Argument::Float(600.0)]);
    let bytes = [data(&format, 0..1, half), update, data(&format, 0..1, half)].concat();
    driver.receive(Nanos::ZERO, Input::Bytes(&bytes));
    let values: Vec<_> =
        outcome(&mut driver).0.iter().map(|reading| reading.values.get(0).unwrap()).collect();
    assert_eq!(values, [1.0, 0.3]);
}

#[test]
fn data_stop_with_the_answer_to_the_stop() {
    let format = format(&SIGNALS, 1, 1);
    let mut driver = streaming(settings(), &format);
    driver.command(Nanos::ZERO, Command::Stop);
    let Some(Output::Bytes(sent)) = driver.poll_transmit() else { panic!("nothing is sent") };
    let bytes =
        [data(&format, 0..1, value), answer(&sent, &format), data(&format, 1..2, value)].concat();
    driver.receive(Nanos::ZERO, Input::Bytes(&bytes));
    let (readings, discarded) = outcome(&mut driver);
    assert_eq!((readings.len(), discarded), (1, data(&format, 1..2, value).len() as u64));
    assert_eq!(driver.poll_timeout(), None);
    // Wanted again while the stop is on its way.
    driver.command(Nanos::ZERO, Command::Start);
    converse(&mut driver, Nanos::ZERO, &format);
    driver.command(Nanos::ZERO, Command::Stop);
    driver.command(Nanos::ZERO, Command::Start);
    converse(&mut driver, Nanos::ZERO, &format);
    assert_eq!(events(&mut driver), [Event::Ready, Event::Ready]);
}

#[test]
fn a_line_gives_profiles() {
    let signals = [65, 256, 257];
    let format = format(&signals, 1, 40);
    let settings = PacketSettings {
        signals: signals.to_vec(),
        pitch_um: Some(5.0),
        ..PacketSettings::default()
    };
    let mut driver = streaming(settings, &format);
    let value = |sample: u32, id: u16, point: u16| match id {
        65 => f64::from(sample),
        256 if point % 10 == 3 => 0.0,
        256 => 500.0 + f64::from(point) + 100.0 * f64::from(sample),
        _ => 50.0,
    };
    driver.receive(Nanos::ZERO, Input::Bytes(&data(&format, 0..4, value)));
    let (readings, _) = outcome(&mut driver);
    assert_eq!(readings.len(), 4);
    for (sample, reading) in (0_u32..).zip(&readings) {
        let profile = reading.values.profile().unwrap();
        assert_eq!(
            reading.values.iter().collect::<Vec<_>>(),
            [Some(f64::from(sample)), Some(36.0)]
        );
        for (point, place) in (0_u16..).zip(profile.points_mm()) {
            let expected = (point % 10 != 3)
                .then(|| [f64::from(point) * 0.005, value(sample, 256, point) / 1000.0]);
            let close = match (place, expected) {
                (Some([x, z]), Some([u, v])) => (x - u).abs() < 1e-12 && (z - v).abs() < 1e-12,
                (None, None) => true,
                _ => false,
            };
            assert!(close, "{point}: {place:?}, expected {expected:?}");
        }
    }
}

#[test]
fn nothing_from_before_a_reconnect_is_decoded_after_it() {
    let format = format(&SIGNALS, 1, 1);
    let mut driver = streaming(settings(), &format);
    let mut other = format.clone();
    other.counter = 5;
    driver.receive(Nanos::ZERO, Input::Bytes(&bytes_of(&other)));
    driver.receive(Nanos::ZERO, Input::Bytes(&data(&other, 0..1, value)));
    assert_eq!(counts(&mut driver), [0]);
    let packet = data(&format, 0..2, value);
    driver.receive(Nanos::ZERO, Input::Bytes(&packet[..30]));
    driver.disconnected(Nanos::ZERO);
    assert_eq!(outcome(&mut driver), (Vec::new(), 30));
    assert_eq!((driver.poll_timeout(), driver.poll_transmit()), (None, None));
    driver.connected(Nanos::ZERO);
    driver.receive(Nanos::ZERO, Input::Bytes(&packet[30..]));
    converse(&mut driver, Nanos::ZERO, &format);
    // The rest of the old packet does not hide the answers behind it.
    let (readings, discarded) = outcome(&mut driver);
    assert_eq!((readings.len(), discarded), (0, packet.len() as u64 - 30));
    // The old format is unknown to the new connection, and the new one is not.
    driver.receive(Nanos::ZERO, Input::Bytes(&data(&other, 0..1, value)));
    assert!(outcome(&mut driver).0.is_empty());
    driver.receive(Nanos::ZERO, Input::Bytes(&packet));
    assert_eq!(counts(&mut driver), [0, 1]);
}
