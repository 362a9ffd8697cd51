//! Literal packets, written by hand from the layout in the Command Reference (packet protocol); its text has no dump of
//! bytes. The codes of commands are also in `chr_cmd_id.py` of the maker's library, version 5.1.

use asphera_chrocodile::wire::packet::{
    Argument, CommandFlags, Data, Format, FormatSignal, HEADER_LEN, Header, Kind, Message, Name,
    NumberType,
};
use asphera_chrocodile::{PacketChrocodile, PacketSettings};
use asphera_link::{Command, Count, Driver as _, Event, Flags, Input, Nanos, Output};

use crate::device::events;

/// `SODX 65 256`, ticket 6.
const SODX: [u8; 56] = [
    0x55, 0xAA, 0x55, 0xAA, 56, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, // magic, length, zeros
    b'C', b'M', b'D', 0, // kind
    b'S', b'O', b'D', b'X', 0, 0, 0, 0, 0, 0, 0, 0, // command, destination, source
    0, 0, 0, 0, 6, 0, 2, 0, // flags, zero, ticket 6, 2 arguments
    0, 0, 0, 0, 65, 0, 0, 0, // integer 65
    0, 0, 0, 0, 0, 1, 0, 0, // integer 256
];

/// Format 7 at 1000 Hz: encoder X as 32 bits, distance 1 as float.
const DFT: [u8; 52] = [
    0x55, 0xAA, 0x55, 0xAA, 52, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, // magic, length, zeros
    b'D', b'F', b'T', 0, // kind
    1, 0, 0, 0, 7, 0, 0, 0, 0, 0, 0x7A, 0x44, 2, 0, 0,
    0, // stream, counter, 1000.0, 2 signals
    5, 0, 1, 0, 0, 0, 65, 0, // s32, reserved, 1 point from 0, signal 65
    6, 0, 1, 0, 0, 0, 0, 1, // float, reserved, 1 point from 0, signal 256
];

/// Two samples of it at 2.5 s: encoder −2 with 1500 µm, encoder 70000 without a peak.
const DAT: [u8; 56] = [
    0x55, 0xAA, 0x55, 0xAA, 56, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, // magic, length, zeros
    b'D', b'A', b'T', 0, // kind
    1, 0, 0, 0, 7, 0, 0, 0, // stream, counter
    0, 0, 0, 0x80, 2, 0, 0, 0, // 2 s and 2³¹ / 2³² s
    2, 0, 0, 0, // samples
    0xFE, 0xFF, 0xFF, 0xFF, 0, 0x80, 0xBB, 0x44, // −2, 1500.0
    0x70, 0x11, 1, 0, 0, 0, 0, 0, // 70000, 0.0
];

/// `SHZ` refused: −2147483647, "not valid", ticket 2.
const REFUSAL: [u8; 68] = [
    0x55, 0xAA, 0x55, 0xAA, 68, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, // magic, length, zeros
    b'C', b'M', b'D', 0, // kind
    b'S', b'H', b'Z', 0, 0, 0, 0, 0, 0, 0, 0, 0, // command, destination, source
    0, 0x80, 0, 0, 2, 0, 2, 0, // error, zero, ticket 2, 2 arguments
    0, 0, 0, 0, 1, 0, 0, 0x80, // integer
    2, 0, 0, 0, 9, 0, 0, 0, // text of 9 bytes
    b'n', b'o', b't', b' ', b'v', b'a', b'l', b'i', b'd', 0, 0, 0,
];

fn body(packet: &[u8]) -> &[u8] {
    let header = Header::decode(packet).unwrap().unwrap();
    assert_eq!(header.len, packet.len());
    &packet[HEADER_LEN..]
}

#[test]
fn a_command_is_read_and_written() {
    let arguments = vec![Argument::Int(65), Argument::Int(256)];
    let message = Message::command(Name::new("SODX"), 6, arguments);
    assert_eq!(Message::decode(body(&SODX)), Some(message.clone()));
    let mut written = Vec::new();
    message.encode(&mut written);
    assert_eq!(written, SODX);
}

#[test]
fn a_format_is_read_and_written() {
    let signal = |number, id| FormatSignal { number, points: 1, first_point: 0, id };
    let format = Format {
        stream: 1,
        counter: 7,
        sample_rate_hz: 1000.0,
        signals: vec![signal(NumberType::S32, 65), signal(NumberType::F32, 256)],
    };
    assert_eq!(Header::decode(&DFT).unwrap().unwrap().kind, Kind::Format);
    assert_eq!(Format::decode(body(&DFT)), Ok(format.clone()));
    let mut written = Vec::new();
    format.encode(&mut written);
    assert_eq!(written, DFT);
}

#[test]
fn data_are_read_and_written() {
    let data = Data::decode(body(&DAT)).unwrap();
    assert_eq!((data.stream, data.counter, data.time_ns()), (1, 7, 2_500_000_000));
    let samples: Vec<&[u8]> = data.split(8).unwrap().collect();
    assert_eq!(samples, [&DAT[40..48], &DAT[48..56]]);
    let mut written = Vec::new();
    Data { stream: 1, counter: 7, time: 5 << 31, rows: 2, samples: &DAT[40..] }
        .encode(&mut written);
    assert_eq!(written, DAT);
}

#[test]
fn a_refusal_is_read() {
    let message = Message::decode(body(&REFUSAL)).unwrap();
    assert_eq!((message.flags, message.ticket), (CommandFlags::ERROR, 2));
    let text = Argument::Text(b"not valid".to_vec());
    assert_eq!(message.arguments, [Argument::Int(-2_147_483_647), text]);
}

/// What the driver sends next, and that it is nothing more.
fn sent(driver: &mut PacketChrocodile) -> Vec<u8> {
    let Some(Output::Bytes(sent)) = driver.poll_transmit() else { panic!("nothing is sent") };
    assert_eq!(driver.poll_transmit(), None);
    sent
}

/// A command of the host with at most one argument, all bytes literal but its length.
fn command(name: &[u8; 4], query: bool, ticket: u8, argument: &[u8]) -> Vec<u8> {
    let len = (40 + argument.len()) as u8;
    let mut bytes = vec![0x55, 0xAA, 0x55, 0xAA, len, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0];
    bytes.extend(b"CMD\0");
    bytes.extend(name);
    bytes.extend([0, 0, 0, 0, 0, 0, 0, 0]);
    bytes.extend([u8::from(query), 0, 0, 0, ticket, 0, u8::from(!argument.is_empty()), 0]);
    bytes.extend(argument);
    bytes
}

/// The whole dialogue, byte by byte: stop, rate, averaging, trigger, full scale, signals with their format, start, data.
#[test]
fn the_dialogue_ends_in_readings() {
    let settings = PacketSettings { signals: vec![65, 256], ..PacketSettings::default() };
    let mut driver = PacketChrocodile::new(settings).unwrap();
    driver.connected(Nanos::ZERO);
    driver.command(Nanos::ZERO, Command::Start);
    let rate = [1, 0, 0, 0, 0, 0, 0x7A, 0x44];
    let one = [0, 0, 0, 0, 1, 0, 0, 0];
    for (expected, answer) in [
        (command(b"STO\0", false, 1, &[]), command(b"STO\0", false, 1, &[])),
        (command(b"SHZ\0", false, 2, &rate), command(b"SHZ\0", false, 2, &rate)),
        (command(b"AVD\0", false, 3, &one), command(b"AVD\0", false, 3, &one)),
        (command(b"TRE\0", false, 4, &[]), command(b"TRE\0", false, 4, &[])),
        // 2000 µm, as an integer.
        (
            command(b"SCA\0", true, 5, &[]),
            command(b"SCA\0", true, 5, &[0, 0, 0, 0, 0xD0, 0x07, 0, 0]),
        ),
        (SODX.to_vec(), [&SODX[..], &DFT[..]].concat()),
        (command(b"STA\0", false, 7, &[]), command(b"STA\0", false, 7, &[])),
    ] {
        assert_eq!(sent(&mut driver), expected);
        driver.receive(Nanos::ZERO, Input::Bytes(&answer));
    }
    assert_eq!(driver.poll_transmit(), None);
    assert_eq!(events(&mut driver), [Event::Online, Event::Ready]);
    driver.receive(Nanos::from_millis(3), Input::Bytes(&DAT));
    let found = events(&mut driver);
    let [Event::Reading(first), Event::Reading(second)] = &found[..] else { panic!("{found:?}") };
    assert_eq!(first.values.iter().collect::<Vec<_>>(), [Some(-2.0), Some(1.5)]);
    assert_eq!(
        (first.host, first.flags, first.count),
        (Nanos::from_millis(3), Flags::empty(), None)
    );
    assert_eq!(second.values.iter().collect::<Vec<_>>(), [Some(70_000.0), None]);
    assert_eq!((second.flags, second.device_time_ns), (Flags::NO_SIGNAL, None));
}

/// Exposure count, flags (saturated, a trigger lost), start time, and a distance of 16 bits: 16384 / 2¹⁵ · 2000 µm.
#[test]
fn counts_flags_and_times_have_their_places() {
    let signals = vec![64, 75, 76, 16640];
    let settings = PacketSettings { signals, scale_um: Some(2000.0), ..PacketSettings::default() };
    let signal = |number, id| FormatSignal { number, points: 1, first_point: 0, id };
    let format = Format {
        stream: 1,
        counter: 1,
        sample_rate_hz: 1000.0,
        signals: vec![
            signal(NumberType::U16, 75),
            signal(NumberType::U16, 76),
            signal(NumberType::U32, 64),
            signal(NumberType::S16, 16640),
        ],
    };
    let mut driver = crate::device::streaming(settings, &format);
    let sample = [0xFF, 0xFF, 3, 0, 0x40, 0x42, 0x0F, 0, 0, 0x40];
    let mut bytes = Vec::new();
    Data { stream: 1, counter: 1, time: 0, rows: 1, samples: &sample }.encode(&mut bytes);
    assert_eq!(bytes.len(), 52, "padded from 50");
    driver.receive(Nanos::ZERO, Input::Bytes(&bytes));
    let found = events(&mut driver);
    let [Event::Reading(reading)] = &found[..] else { panic!("{found:?}") };
    assert_eq!(reading.count, Some(Count { raw: 65_535, first: 0, modulus: 65_536 }));
    assert_eq!(reading.flags, Flags::SATURATED | Flags::TRIGGER_LOST);
    assert_eq!(reading.device_time_ns, Some(1_000_000));
    assert_eq!(reading.values.iter().collect::<Vec<_>>(), [Some(1.0)]);
}
