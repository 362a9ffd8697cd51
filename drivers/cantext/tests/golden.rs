//! Lines of the documents of can-utils and socketcand, and the laws of the codecs.

use asphera_cantext::candump::{self, Content, Line, MAX_LINE, Reader};
use asphera_cantext::socketcand::{self, Client, Decoder, Event, MAX_ELEMENT};
use asphera_cantext::{BusError, candump::Item as LogItem, socketcand::Item};
use asphera_link::{CanFrame, CanId, FD_LENGTHS, FdFlags};
use proptest::prelude::*;
use proptest::test_runner::FileFailurePersistence;

fn standard(id: u16, data: &[u8]) -> CanFrame {
    CanFrame::data_frame(CanId::Standard(id), data).expect("a good frame")
}

fn extended(id: u32, data: &[u8]) -> CanFrame {
    CanFrame::data_frame(CanId::Extended(id), data).expect("a good frame")
}

fn flexible(id: CanId, data: &[u8], bit_rate_switch: bool, error_passive: bool) -> CanFrame {
    CanFrame::fd_frame(id, data, FdFlags { bit_rate_switch, error_passive }).expect("a good frame")
}

fn remote(id: CanId, len: usize) -> CanFrame {
    CanFrame::remote_frame(id, len).expect("a good frame")
}

fn content(frame: &str) -> Option<Content> {
    let line = format!("(1436509052.249713) can0 {frame}");
    Line::parse(line.as_bytes()).ok().map(|line| line.content)
}

/// The examples of can-utils' `lib.h`, and of its log format.
#[test]
fn frames_of_can_utils() {
    let bytes = [0x11, 0x22, 0x33, 0x44, 0x55, 0x66, 0x77, 0x88];
    let cases = [
        ("123#", standard(0x123, &[])),
        ("12345678#", extended(0x1234_5678, &[])),
        ("123#R", remote(CanId::Standard(0x123), 0)),
        ("123#R0", remote(CanId::Standard(0x123), 0)),
        ("123#R7", remote(CanId::Standard(0x123), 7)),
        ("7A1#r", remote(CanId::Standard(0x7A1), 0)),
        ("12345678#R5", remote(CanId::Extended(0x1234_5678), 5)),
        ("123#00", standard(0x123, &[0])),
        ("123#1122334455667788", standard(0x123, &bytes)),
        ("123#11.22.33.44.55.66.77.88", standard(0x123, &bytes)),
        ("123#11.2233.44556677.88", standard(0x123, &bytes)),
        // Eight bytes with a raw length code of 14, as newer versions write it.
        ("123#1122334455667788_E", standard(0x123, &bytes)),
        ("123#R8_9", remote(CanId::Standard(0x123), 8)),
        // 29 bits below 2^11 stay extended.
        ("00000123#11", extended(0x123, &[0x11])),
    ];
    for (text, frame) in cases {
        assert_eq!(content(text), Some(Content::Frame(frame)), "{text}");
    }
    // `##`, then a digit of flags: CANFD_BRS 1, CANFD_ESI 2, and CANFD_FDF 4, which newer kernels add.
    let short = CanId::Standard(0x123);
    let bytes = [0x11, 0x22, 0x33];
    for (text, frame) in [
        ("123##0112233", flexible(short, &bytes, false, false)),
        ("123##1112233", flexible(short, &bytes, true, false)),
        ("123##2112233", flexible(short, &bytes, false, true)),
        ("123##5112233", flexible(short, &bytes, true, false)),
        ("123##3", flexible(short, &[], true, true)),
        ("12345678##111", flexible(CanId::Extended(0x1234_5678), &[0x11], true, false)),
    ] {
        assert_eq!(content(text), Some(Content::Frame(frame)), "{text}");
    }
    // No CAN FD frame has nine bytes.
    assert_eq!(content("123##0112233445566778899"), None);
    assert_eq!(content("45123#81:00:12345678#11223344.556677"), Some(Content::ExtraLong));
    assert_eq!(content("20000040#0000000000000000"), Some(Content::BusError(BusError(0x40))));
    // "error frame with CAN_ERR_FLAG set", whatever the bits of the class.
    assert_eq!(content("32345678#112233"), Some(Content::BusError(BusError(0x1234_5678))));
}

/// A whole line of the manual page of candump, and what the parts around the frame may be.
#[test]
fn times_interfaces_and_directions() {
    let line = Line::parse(b"(1436509052.249713) vcan0 044#2A366C2BBA").unwrap();
    assert_eq!((line.time_ns, line.interface), (1_436_509_052_249_713_000, "vcan0"));
    for (text, ns) in [
        ("(0000000000.000000) can1 123#", 0),
        ("(0.0) can1 123# R", 0),
        ("(000.100000) can1 123#11 T", 100_000_000),
        ("(1.123456789) can1 123#R4 R", 1_123_456_789),
    ] {
        assert_eq!(Line::parse(text.as_bytes()).unwrap().time_ns, ns, "{text}");
        assert_eq!(candump::time_of(text.as_bytes()), Some(ns), "{text}");
    }
}

#[test]
fn lines_that_are_none_say_what_is_wrong() {
    let wrong = |line: &str| Line::parse(line.as_bytes()).unwrap_err().to_string();
    assert!(wrong("can0  123   [2]  11 22").starts_with("expected (seconds.fraction)"));
    assert!(wrong("(2026-01-02 10:00:00.5) can0 123#").starts_with("expected (seconds"));
    assert!(wrong("(1.5) 123#11").contains("name of an interface"));
    assert!(wrong("(1.5) can0").ends_with("found "));
    for frame in [
        "12#11",
        "1234#11",
        "800#11",
        "123#1",
        "123#112233445566778899",
        "123#11..22",
        "123#GG",
        "123#R9",
        "123##",
        "123##G",
        "123#11_9",
        "123#1122334455667788_8",
        "FFFFFFFF#",
        "40000000#11",
        "45123#81:00#11",
        "123",
        "#11",
    ] {
        let error = wrong(&format!("(1.5) can0 {frame}"));
        assert_eq!(error, format!("expected a frame, as 123#1122 or 12345678#R4, found {frame}"));
    }
    assert!(wrong("(1.5) can0 123#11 X").ends_with("found X"));
    assert!(wrong("(99999999999999999999.0) can0 123#").contains("(seconds"));
    assert_eq!(candump::time_of(b"no time"), None);
}

fn items(reader: &mut Reader, mut bytes: &[u8]) -> Vec<LogItem> {
    let mut items = Vec::new();
    while !bytes.is_empty() {
        items.extend(reader.read(&mut bytes));
    }
    items
}

const LOG: &str = "(1.0) can0 123#11\n\
    (1.1) can1 124#22\n\
    \n\
    # a remark\n\
    (1.2) can0 123##311\r\n\
    (1.3) can0 20000040#00\n\
    (1.4) can0 123##322\n\
    (1.5) can0 125#33\n";

#[test]
fn a_log_is_read_by_interface_and_every_line_left_out_has_its_number() {
    let mut reader = Reader::new(Some("can0".to_owned()));
    let found = items(&mut reader, LOG.as_bytes());
    assert_eq!(found[0], LogItem::Frame(standard(0x123, &[0x11])));
    let LogItem::LeftOut { bytes: 11, why } = &found[1] else { panic!("{:?}", found[1]) };
    assert!(why.starts_with("line 4 of the log is no line of candump: expected ("), "{why}");
    let LogItem::LeftOut { bytes: 21, why } = &found[2] else { panic!("{:?}", found[2]) };
    assert!(why.starts_with("line 5 of the log is a CAN FD frame: drivers read"), "{why}");
    assert_eq!(found[3], LogItem::BusError(BusError(0x40)));
    assert_eq!(found[5], LogItem::Frame(standard(0x125, &[0x33])));
    assert_eq!(
        reader.summary(),
        "2 frames in 8 lines; 1 times no line of candump, first in line 4; 2 times a CAN FD frame, first in line 5"
    );
    let with_fd = items(&mut Reader::new(None).with_fd(true), LOG.as_bytes());
    assert!(with_fd.contains(&LogItem::Frame(flexible(
        CanId::Standard(0x123),
        &[0x11],
        true,
        true
    ))));
    assert_eq!(with_fd.iter().filter(|item| matches!(item, LogItem::Frame(_))).count(), 5);
    let all = items(&mut Reader::new(None), LOG.as_bytes());
    assert_eq!(all.iter().filter(|item| matches!(item, LogItem::Frame(_))).count(), 3);
}

#[test]
fn a_line_without_end_stays_small() {
    let mut reader = Reader::new(None);
    assert_eq!(items(&mut reader, &vec![b'x'; 100_000]), []);
    assert_eq!(reader.pending(), 100_000);
    let found = items(&mut reader, b"\n(1.0) can0 123#\n");
    let LogItem::LeftOut { bytes: 100_001, why } = &found[0] else { panic!("{:?}", found[0]) };
    assert!(why.contains(&MAX_LINE.to_string()), "{why}");
    assert_eq!(found[1], LogItem::Frame(standard(0x123, &[])));
}

fn elements(decoder: &mut Decoder, mut bytes: &[u8]) -> Vec<Item> {
    let mut items = Vec::new();
    while !bytes.is_empty() {
        items.extend(decoder.decode(&mut bytes));
    }
    items
}

/// The commands as `doc/protocol.md` of socketcand prints them, sign for sign.
#[test]
fn commands_of_the_protocol_document() {
    let text = |frame| {
        let mut out = Vec::new();
        socketcand::encode(&frame, &mut out);
        String::from_utf8(out).expect("ASCII")
    };
    assert_eq!(text(standard(0x123, &[])), "< send 123 0 >");
    assert_eq!(text(extended(0x1AAA_AAAA, &[0x01, 0xF1])), "< send 1AAAAAAA 2 1 F1 >");
    assert_eq!(text(remote(CanId::Standard(0x123), 0)), "< sendrtr 123 0 >");
    assert_eq!(text(remote(CanId::Extended(0x1AAA_AAAA), 2)), "< sendrtr 1AAAAAAA 2 >");
    // The identifier has three digits, or the server takes none of eight for an extended one.
    assert_eq!(text(standard(0x5, &[0x1A, 0x22, 0x03, 0x44])), "< send 005 4 1A 22 3 44 >");
    assert_eq!(text(extended(0x5, &[])), "< send 00000005 0 >");
}

/// Elements of `doc/protocol.md`, and the same as `state_raw.c` prints them.
#[test]
fn elements_of_the_protocol_document() {
    let data = [0x11, 0x22, 0x33, 0x44];
    let cases = [
        ("< hi >", Item::Greeting),
        ("< ok >", Item::Done),
        ("< frame 123 23.424242 11 22 33 44 >", Item::Frame(standard(0x123, &data))),
        ("< frame 123 23.424242 11223344 >", Item::Frame(standard(0x123, &data))),
        ("< frame 1AAAAAAA 23.424242 01F1 >", Item::Frame(extended(0x1AAA_AAAA, &[1, 0xF1]))),
        ("< frame 00000123 23.424242  >", Item::Frame(extended(0x123, &[]))),
        ("< rtr 123 23.424242 4 >", Item::Frame(remote(CanId::Standard(0x123), 4))),
        ("< error 040 23.424242 >", Item::BusError(BusError(0x40))),
        ("< error 40 >", Item::BusError(BusError(0x40))),
        ("< error could not open bus >", Item::Refused("could not open bus".to_owned())),
        ("< echo >", Item::Other("echo".to_owned())),
    ];
    for (text, item) in cases {
        assert_eq!(elements(&mut Decoder::new(), text.as_bytes()), [item], "{text}");
    }
    for text in [
        "< frame 123 23.424242 1 >x", // one digit is a byte; what follows is none
        "< frame 800 23.4 11 >",
        "< frame 123 23 11 >",
        "< frame 123 23.4 112 >",
        "< frame 123 23.4 112233445566778899 >",
        "< rtr 123 23.4 9 >",
        "< frame >",
    ] {
        let found = elements(&mut Decoder::new(), text.as_bytes());
        let bytes = text.len() as u64;
        match text.strip_suffix('x') {
            Some(_) => assert_eq!(found, [Item::Frame(standard(0x123, &[1]))]),
            None => assert_eq!(found, [Item::Malformed { bytes }], "{text}"),
        }
    }
}

fn events(client: &mut Client, mut bytes: &[u8]) -> Vec<Event> {
    let mut events = Vec::new();
    while !bytes.is_empty() {
        events.extend(client.receive(&mut bytes));
    }
    events
}

#[test]
fn a_connection_opens_step_by_step() {
    let mut client = Client::new("can0");
    assert_eq!(events(&mut client, b"< hi >"), [Event::Send(b"< open can0 >".to_vec())]);
    assert_eq!(events(&mut client, b"< ok"), []);
    assert_eq!(client.pending(), 4);
    assert_eq!(events(&mut client, b" >"), [Event::Send(b"< rawmode >".to_vec())]);
    assert!(client.is_waiting() && !client.is_open());
    let frame = Event::Frame(standard(0x123, &[0x11]));
    assert_eq!(events(&mut client, b"< ok >< frame 123 1.0 11 >"), [Event::Open, frame]);
    assert!(client.is_open());
    let refused = events(&mut client, b"< error unknown command >");
    assert_eq!(refused, [Event::Refused("socketcand refused a command: unknown command".into())]);
    assert!(client.is_open(), "a refusal ends nothing");
}

#[test]
fn a_connection_that_cannot_be_used_says_why() {
    let failed = |script: &[u8]| {
        let mut client = Client::new("can7");
        let last = events(&mut client, script).pop().unwrap();
        assert!(!client.is_open() && !client.is_waiting());
        assert_eq!(events(&mut client, b"< ok >< ok >"), [], "nothing more counts");
        match last {
            Event::Failed(words) => words,
            other => panic!("{other:?}"),
        }
    };
    let words = failed(b"< hi >< error could not open bus >");
    assert!(words.contains("can7 (< error could not open bus >): set bus"), "{words}");
    assert!(failed(b"< hi >< ok >< error unknown command >").contains("raw mode"));
    assert!(failed(b"< ok >").contains("expected the greeting"));
    assert!(failed(b"<html>").contains("found < html >: check the address"));
    let mut client = Client::new("can0");
    assert!(client.expire().contains("greeting"));
}

proptest! {
    #![proptest_config(ProptestConfig {
        failure_persistence: Some(Box::new(FileFailurePersistence::WithSource("regressions"))),
        ..ProptestConfig::default()
    })]

    #[test]
    fn every_frame_survives_a_log(id in 0_u32..0x2000_0000, short: bool, len in 0_usize..=8, data: [u8; 8], is_remote: bool) {
        let id = if short { CanId::Standard((id & 0x7FF) as u16) } else { CanId::Extended(id) };
        let frame = if is_remote { remote(id, len) } else { CanFrame::data_frame(id, &data[..len]).unwrap() };
        let mut log = String::new();
        candump::encode(1_436_509_052_249_713, "can0", &frame, &mut log);
        let line = Line::parse(log.trim_end().as_bytes()).unwrap();
        prop_assert_eq!(line.content, Content::Frame(frame));
        prop_assert_eq!(line.time_ns, 1_436_509_052_249_713_000);
    }

    #[test]
    fn every_fd_frame_survives_a_log(
        id in 0_u32..0x2000_0000, short: bool, len in prop::sample::select(FD_LENGTHS.to_vec()),
        data in prop::collection::vec(any::<u8>(), 64), switch: bool, passive: bool,
    ) {
        let id = if short { CanId::Standard((id & 0x7FF) as u16) } else { CanId::Extended(id) };
        let frame = flexible(id, &data[..len], switch, passive);
        let mut log = String::new();
        candump::encode(5, "can0", &frame, &mut log);
        prop_assert_eq!(Line::parse(log.trim_end().as_bytes()).unwrap().content, Content::Frame(frame));
        let mut out = Vec::new();
        socketcand::encode(&frame, &mut out);
        prop_assert!(out.is_empty(), "the protocol has no command for it");
    }

    #[test]
    fn any_bytes_are_counted_however_they_are_cut(text in "[<> a-f0-9.#()\n\\x00-\\xFF]{0,600}", at in 0_usize..600) {
        let bytes = text.as_bytes();
        let (head, tail) = bytes.split_at(at.min(bytes.len()));
        let mut whole = Decoder::new();
        let expected = elements(&mut whole, bytes);
        let mut cut = Decoder::new();
        let mut found = elements(&mut cut, head);
        found.extend(elements(&mut cut, tail));
        prop_assert_eq!(&found, &expected);
        prop_assert!(cut.pending() <= MAX_ELEMENT as u64);
        let (mut one, mut two) = (Reader::new(None), Reader::new(None));
        let expected = items(&mut one, bytes);
        let mut found = items(&mut two, head);
        found.extend(items(&mut two, tail));
        prop_assert_eq!(found, expected);
    }
}
