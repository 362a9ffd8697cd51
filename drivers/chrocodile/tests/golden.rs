//! Literal bytes, written by hand from the manuals' rules, through the whole driver.
//!
//! CR: Precitec "CHRocodile 2 Command Reference", 2025-07-23, by section (its pages were not at hand
//! when these were written). C: "CHRocodile C Operation Manual" 1.0, 2016-09-20. CLS: "CHRocodile CLS
//! 0.2" operation manual. C and CLS are cited by printed page.

#![expect(clippy::unwrap_used, reason = "a panic here is a failed test")]

use asphera_chrocodile::{Chrocodile, Settings, Trigger};
use asphera_link::{
    Command, Count, Driver, Event, FaultKind, Flags, Input, Nanos, Output, Reading,
};

/// What the device answers to a setting: the echo, CR, `ready` CR LF (C p. 55, `$SHZ 1000`).
fn setting(echo: &str) -> Vec<u8> {
    format!("{echo}\rready\r\n").into_bytes()
}

/// Takes everything the driver wants sent.
fn sent(driver: &mut Chrocodile) -> Vec<u8> {
    let mut all = Vec::new();
    while let Some(output) = driver.poll_transmit() {
        match output {
            Output::Bytes(bytes) => all.extend(bytes),
            Output::Frame(frame) => panic!("a CAN frame: {frame:?}"),
        }
    }
    all
}

fn events(driver: &mut Chrocodile) -> Vec<Event> {
    std::iter::from_fn(|| driver.poll_event()).collect()
}

fn readings(driver: &mut Chrocodile) -> Vec<Reading> {
    events(driver)
        .into_iter()
        .filter_map(|event| match event {
            Event::Reading(reading) => Some(reading),
            _ => None,
        })
        .collect()
}

fn ms(ms: u64) -> Nanos {
    Nanos::from_millis(ms)
}

fn receive(driver: &mut Chrocodile, at_ms: u64, bytes: &[u8]) {
    driver.receive(ms(at_ms), Input::Bytes(bytes));
}

/// A driver that streams, after the dialogue of set-up in which every setting is accepted.
fn streaming(settings: Settings) -> Chrocodile {
    let mut driver = Chrocodile::new(settings).unwrap();
    driver.command(ms(0), Command::Start);
    driver.connected(ms(0));
    loop {
        let command = sent(&mut driver);
        let Some(echo) = command.strip_suffix(b"\r") else { break };
        let echo = std::str::from_utf8(echo).unwrap();
        let answer = match echo {
            // CLS p. 47: the answer to the question has no CR before `ready`.
            "$SCA ?" => b"$SCA ? 3320ready\r\n".to_vec(),
            _ => setting(echo),
        };
        receive(&mut driver, 0, &answer);
    }
    let events = events(&mut driver);
    assert_eq!(events, [Event::Online, Event::Ready]);
    driver
}

/// Delivers one telegram and the silence after it.
fn one(driver: &mut Chrocodile, telegram: &[u8]) -> Reading {
    receive(driver, 1, telegram);
    assert_eq!(readings(driver), [], "nothing confirms it yet");
    let due = driver.poll_timeout().unwrap();
    driver.timeout(due);
    let readings = readings(driver);
    assert_eq!(readings.len(), 1);
    readings[0].clone()
}

#[test]
fn set_up_is_this_dialogue() {
    let settings = Settings { sample_rate_hz: 2000.0, averaging: 4, ..Settings::default() };
    let mut driver = Chrocodile::new(settings).unwrap();
    driver.connected(ms(0));
    let dialogue: [(&[u8], &[u8]); 7] = [
        (b"$STO\r", b"$STO\rready\r\n"), // C p. 61, literal
        (b"$BIN\r", b"$BIN\rready\r\n"), // CR, BIN
        (b"$SODX 75 76 65 256 257\r", b"$SODX 75 76 65 256 257\rready\r\n"), // CLS p. 49, 50
        (b"$SHZ 2000\r", b"$SHZ 2000\rready\r\n"), // C p. 55, CLS p. 48
        (b"$AVD 4\r", b"$AVD 4\rready\r\n"), // CR, AVD
        (b"$TRE\r", b"$TRE\rready\r\n"), // C p. 62
        (b"$SCA ?\r", b"$SCA ? 3320ready\r\n"), // CLS p. 47, literal
    ];
    for (command, answer) in dialogue {
        assert_eq!(sent(&mut driver), command);
        receive(&mut driver, 1, answer);
    }
    assert_eq!(events(&mut driver), [Event::Online], "set up, but no start was commanded");
    driver.command(ms(2), Command::Start);
    assert_eq!(sent(&mut driver), b"$STA\r"); // C p. 60
    receive(&mut driver, 3, b"$STA\rready\r\n");
    assert_eq!(events(&mut driver), [Event::Ready]);
    assert_eq!(driver.poll_timeout(), None, "a triggered device may wait for ever");
}

#[test]
fn default_telegram() {
    let mut driver = streaming(Settings::default());
    let reading = one(
        &mut driver,
        &[
            0xFF, 0xFF, // sync (CR, binary mode)
            0x12, 0x34, // 75 exposure count, 16 bits: most significant byte first: 4660
            0x00, 0x05, // 76 exposure flags: bit 0 saturation, bit 2 delayed (CR)
            0xF0, 0xD8, 0xFF, 0xFF, // 65 encoder X, 32 bits: least significant first: -10000
            0x00, 0x80, 0x9C, 0x44, // 256 distance 1 in µm, float 0x449C8000 = 1252
            0x00, 0x00, 0x48, 0x42, // 257 intensity 1, float 0x42480000 = 50
        ],
    );
    assert_eq!(reading.host, ms(1));
    assert_eq!(reading.count, Some(Count { raw: 4660, first: 0, modulus: 65536 }));
    assert_eq!(reading.flags, Flags::SATURATED | Flags::DELAYED);
    assert_eq!(
        reading.values.iter().collect::<Vec<_>>(),
        [Some(-10000.0), Some(1.252), Some(50.0)]
    );
    assert_eq!(reading.device_time_ns, None);
}

#[test]
fn every_encoding_of_a_distance() {
    // 256 float µm, 264 peak 2; the encodings of bits 15 and 14 (CR, SODX) cannot be mixed for one
    // peak, so each has a peak of its own.
    let distance = |encoding: u16, peak: u16| encoding << 14 | 1 << 8 | peak << 3;
    let signals = vec![distance(1, 0), distance(2, 1), distance(3, 2), distance(0, 3), 93, 64, 76];
    assert_eq!(signals[..4], [16640, 33032, 49424, 280]);
    let mut driver = streaming(Settings { signals, ..Settings::default() });
    let reading = one(
        &mut driver,
        &[
            0xFF, 0xFF, // sync
            0x40, 0x00, // peak 1, 16 bits: 16384 / 32768 of 3320 µm = 1660 µm (CLS p. 47)
            0x15, 0xCD, 0x5B, 0x07, // peak 2, 32 bits in nm: 123456789 nm (CR)
            0x00, 0x00, 0x00, 0x20, // peak 3, 32 bits: 2^29 / 2^31 of 3320 µm = 830 µm (CR)
            0x00, 0x00, 0x20, 0x41, // peak 4, float: 10 µm
            0x09, 0xC4, // 93 temperature, 16 bits: 2500 hundredths = 25 °C (CR)
            0x00, 0xCA, 0x9A, 0x3B, // 64 start time, 32 bits: 1000000000 ns (CR, CLS p. 50)
            0x00, 0x02, // 76 exposure flags: bit 1, a trigger was lost (CR)
        ],
    );
    assert_eq!(
        reading.values.iter().collect::<Vec<_>>(),
        [Some(1.66), Some(123.456789), Some(0.83), Some(0.01), Some(25.0)]
    );
    assert_eq!(reading.flags, Flags::TRIGGER_LOST);
    assert_eq!(reading.device_time_ns, Some(1_000_000_000));
}

#[test]
fn no_peak_is_no_distance() {
    // C p. 61, THR: without a peak over the threshold, 0 is sent for distance and intensity.
    let mut driver = streaming(Settings { signals: vec![256, 257], ..Settings::default() });
    let reading = one(&mut driver, &[0xFF, 0xFF, 0, 0, 0, 0, 0, 0, 0, 0]);
    assert_eq!(reading.flags, Flags::NO_SIGNAL);
    assert_eq!(reading.values.iter().collect::<Vec<_>>(), [None, None]);
}

#[test]
fn a_command_between_telegrams_loses_none() {
    let settings =
        Settings { signals: vec![75, 16640], scale_um: Some(3276.8), ..Settings::default() };
    let mut driver = streaming(settings);
    // 75 exposure count 1 and 2, 16640 distance 10 and 20 steps of 0.1 µm.
    receive(&mut driver, 1, &[0xFF, 0xFF, 0x00, 0x01, 0x00, 0x0A]);
    driver.command(ms(1), Command::Stop);
    assert_eq!(sent(&mut driver), b"$STO\r");
    receive(&mut driver, 2, &[0xFF, 0xFF, 0x00, 0x02, 0x00, 0x14]);
    receive(&mut driver, 2, b"$STO\rrea");
    receive(&mut driver, 2, b"dy\r\n");
    let readings = readings(&mut driver);
    let distances: Vec<_> = readings.iter().map(|reading| reading.values.get(0)).collect();
    assert_eq!(distances, [Some(0.001), Some(0.002)]);
    assert!(readings.iter().all(|reading| reading.flags.is_empty()));
    assert_eq!(driver.poll_timeout(), None);
}

#[test]
fn data_before_the_echo_are_never_decoded() {
    let mut driver = Chrocodile::new(Settings::default()).unwrap();
    driver.connected(ms(0));
    // The device streams from an earlier session, in the very layout this driver is going to choose.
    let telegram = [0xFF, 0xFF, 0, 1, 0, 0, 0, 0, 0, 0, 0, 0, 0x80, 0x3F, 0, 0, 0x80, 0x3F];
    receive(&mut driver, 0, &telegram.repeat(10));
    receive(&mut driver, 0, b"$STO\rready\r\n");
    let events = events(&mut driver);
    let passed: u64 = events
        .iter()
        .map(|event| match event {
            Event::Discarded { bytes } => *bytes,
            Event::Online => 0,
            other => panic!("{other:?}"),
        })
        .sum();
    assert_eq!(passed, 180);
    assert_eq!(events.last(), Some(&Event::Online));
}

#[test]
fn a_refused_value_is_a_fault_that_names_it() {
    let mut driver = Chrocodile::new(Settings::default()).unwrap();
    driver.command(ms(0), Command::Start);
    driver.connected(ms(0));
    for _ in 0..3 {
        let command = String::from_utf8(sent(&mut driver)).unwrap();
        receive(&mut driver, 0, &setting(command.trim_end()));
    }
    for _ in 0..2 {
        assert_eq!(sent(&mut driver), b"$SHZ 1000\r");
        // CLS p. 48: a value that is not accepted is answered with "not valid".
        receive(&mut driver, 0, b"$SHZ 1000\rnot valid\r\nready\r\n");
    }
    let events = events(&mut driver);
    let [Event::Online, Event::Fault(fault)] = &events[..] else { panic!("{events:?}") };
    assert_eq!(fault.kind, FaultKind::Refused);
    let words = "$SHZ 1000: the value is not accepted, the answer was \"not valid\"; see the command reference";
    assert!(fault.detail.starts_with(words), "{}", fault.detail);
    assert_eq!(driver.poll_timeout(), None);
    driver.command(ms(1), Command::Start);
    assert_eq!(sent(&mut driver), b"$STO\r", "a start tries again");
}

#[test]
fn no_answer_is_asked_twice_and_then_given_up() {
    let mut driver = Chrocodile::new(Settings::default()).unwrap();
    driver.connected(ms(0));
    assert_eq!(sent(&mut driver), b"$STO\r");
    assert_eq!(driver.poll_timeout(), Some(ms(1000)));
    driver.timeout(ms(1000));
    assert_eq!(sent(&mut driver), b"$STO\r");
    driver.timeout(ms(2000));
    let events = events(&mut driver);
    let [Event::Reopen(fault)] = &events[..] else { panic!("{events:?}") };
    assert_eq!(fault.kind, FaultKind::Timeout);
    assert!(fault.detail.starts_with("no echo to $STO within 1000 ms, asked 2 times: check cable"));
    assert_eq!(driver.poll_timeout(), None);
}

#[test]
fn a_late_answer_is_not_taken_for_that_of_the_next_command() {
    let mut driver = Chrocodile::new(Settings::default()).unwrap();
    driver.connected(ms(0));
    sent(&mut driver);
    driver.timeout(ms(1000));
    assert_eq!(sent(&mut driver), b"$STO\r");
    receive(&mut driver, 1001, b"$STO\rready\r\n"); // the answer to the first
    assert_eq!(sent(&mut driver), b"$BIN\r");
    receive(&mut driver, 1002, b"$STO\rready\r\n"); // the answer to the second
    assert_eq!(sent(&mut driver), b"");
    receive(&mut driver, 1003, b"$BIN\rready\r\n");
    assert_eq!(sent(&mut driver), b"$SODX 75 76 65 256 257\r");
}

#[test]
fn a_free_running_device_that_falls_silent_is_reopened() {
    let mut driver = streaming(Settings { trigger: Trigger::Free, ..Settings::default() });
    let due = driver.poll_timeout().unwrap();
    assert_eq!(due, ms(1000));
    driver.timeout(due);
    let events = events(&mut driver);
    let [Event::Reopen(fault)] = &events[..] else { panic!("{events:?}") };
    assert_eq!(fault.detail, "no data for 1000 ms though free-running: check cable and power");
}

#[test]
fn nothing_from_before_a_reconnect_is_decoded_after_it() {
    let mut driver = streaming(Settings { signals: vec![75, 16640], ..Settings::default() });
    receive(&mut driver, 1, &[0xFF, 0xFF, 0x00, 0x01, 0x00, 0x0A]);
    driver.disconnected(ms(2));
    assert_eq!(driver.poll_timeout(), None);
    driver.connected(ms(3));
    receive(&mut driver, 3, &[0xFF, 0xFF, 0x00, 0x02, 0x00, 0x0A]);
    driver.timeout(ms(500));
    assert_eq!(readings(&mut driver), []);
}
