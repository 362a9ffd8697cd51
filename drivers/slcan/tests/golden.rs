//! Lines from manuals and from other people's programs, and the laws of the codec.

use asphera_link::{CanFrame, CanId, FD_LENGTHS, FdFlags};
use asphera_slcan::{
    AdapterStatus, BitRate, Command, DataBitRate, Decoder, Item, MAX_LINE, Timestamps, encode,
    encode_timestamped,
};
use proptest::prelude::*;
use proptest::test_runner::FileFailurePersistence;

fn items(decoder: &mut Decoder, mut bytes: &[u8]) -> Vec<Item> {
    let mut items = Vec::new();
    while !bytes.is_empty() {
        items.extend(decoder.decode(&mut bytes));
    }
    items
}

fn line(text: &str) -> Item {
    let items = items(&mut Decoder::new(), text.as_bytes());
    assert_eq!(items.len(), 1, "{text:?} gives {items:?}");
    items[0]
}

fn standard(id: u16, data: &[u8]) -> CanFrame {
    CanFrame::data_frame(CanId::Standard(id), data).expect("a good frame")
}

fn encoded(frame: &CanFrame) -> String {
    let mut out = Vec::new();
    encode(frame, &mut out);
    String::from_utf8(out).expect("slcan is ASCII")
}

/// The four examples of the comment in Linux `drivers/net/can/slcan.c`.
#[test]
fn lines_of_the_linux_driver() {
    let cases = [
        ("t1230\r", standard(0x123, &[])),
        ("t4563112233\r", standard(0x456, &[0x11, 0x22, 0x33])),
        (
            "T12ABCDEF2AA55\r",
            CanFrame::data_frame(CanId::Extended(0x12AB_CDEF), &[0xAA, 0x55]).unwrap(),
        ),
        ("r1230\r", CanFrame::remote_frame(CanId::Standard(0x123), 0).unwrap()),
    ];
    for (text, frame) in cases {
        assert_eq!(line(text), Item::Frame(frame, None));
        assert_eq!(encoded(&frame), text);
    }
}

/// ICP DAS I-7565 manual v1.3 p.34: identifier 03F, six bytes.
#[test]
fn line_of_the_icp_das_manual() {
    let frame = standard(0x03F, &[0x11, 0x22, 0x33, 0x44, 0x55, 0x66]);
    assert_eq!(line("t03F6112233445566\r"), Item::Frame(frame, None));
}

/// The longest classic line, with the last ms of the adapter's clock (EasySYNC ES_000005 p.20: times
/// run from 0x0000 to 0xEA5F).
#[test]
fn timestamp_of_the_easysync_manual() {
    let frame = CanFrame::data_frame(
        CanId::Extended(0x1111_2222),
        &[0x11, 0x22, 0x33, 0x44, 0x55, 0x66, 0x77, 0x88],
    )
    .unwrap();
    let text = "T1111222281122334455667788EA5F\r";
    assert_eq!(line(text), Item::Frame(frame, Some(59_999)));
    let mut out = Vec::new();
    encode_timestamped(&frame, 119_999, &mut out);
    assert_eq!(out, text.as_bytes());
    let too_late = "T1111222281122334455667788EA60\r";
    assert_eq!(line(too_late), Item::Malformed { bytes: 31 });
}

/// What `slcand` of can-utils writes when it opens an adapter at 500 kbit/s, and closes it.
#[test]
fn commands_of_slcand() {
    let sent = [
        Command::Close,
        Command::BitRate(BitRate::Kbps500),
        Command::Status,
        Command::Open,
        Command::Listen,
    ];
    let mut out = Vec::new();
    sent.iter().for_each(|command| command.encode(&mut out));
    assert_eq!(out, b"C\rS6\rF\rO\rL\r");
    let read = items(&mut Decoder::new(), &out);
    assert_eq!(read, sent.map(Item::Command));
}

#[test]
fn answers_of_an_adapter() {
    let read = items(&mut Decoder::new(), b"\r\x07z\rZ\rV0103\rNA123\rF89\r");
    let expected = [
        Item::Ok,
        Item::Error,
        Item::TransmitAck { extended: false },
        Item::TransmitAck { extended: true },
        Item::Version { hardware: *b"01", software: *b"03" },
        Item::SerialNumber(*b"A123"),
        Item::Status(
            AdapterStatus::RECEIVE_FULL | AdapterStatus::DATA_OVERRUN | AdapterStatus::BUS_ERROR,
        ),
    ];
    assert_eq!(read, expected);
}

#[test]
fn every_command_is_read_back() {
    let commands = [
        Command::Registers { value: 0x031C, count: 2 },
        Command::Registers { value: 0x01_021C, count: 3 },
        Command::PollOne,
        Command::PollAll,
        Command::AutoPoll(true),
        Command::Timestamps(false),
        Command::Version,
        Command::SerialNumber,
        Command::AcceptanceCode(0),
        Command::AcceptanceMask(u32::MAX),
        Command::Uart(1),
        Command::FilterMode(2),
    ];
    let rates = BitRate::ALL.map(Command::BitRate).into_iter();
    let rates = rates.chain(DataBitRate::ALL.map(Command::DataBitRate));
    for command in commands.into_iter().chain(rates) {
        let mut out = Vec::new();
        command.encode(&mut out);
        assert_eq!(items(&mut Decoder::new(), &out), [Item::Command(command)]);
    }
}

#[test]
fn lower_case_is_read() {
    assert_eq!(line("t1852abcd\r"), Item::Frame(standard(0x185, &[0xAB, 0xCD]), None));
}

fn flexible(id: CanId, data: &[u8], bit_rate_switch: bool) -> CanFrame {
    let flags = FdFlags { bit_rate_switch, error_passive: false };
    CanFrame::fd_frame(id, data, flags).expect("a good frame")
}

/// The forms and length codes of both READMEs of the CANable 2 firmware: `dIIILDD…`, `DIIIIIIIILDD…`, `bIIILDD…`, `BIIIIIIIILDD…`;
/// `9` is 12 bytes.
#[test]
fn can_fd_lines_are_frames() {
    let data: Vec<u8> = (0..12).collect();
    let cases = [
        ("d1239000102030405060708090A0B\r", flexible(CanId::Standard(0x123), &data, false)),
        ("b1239000102030405060708090A0B\r", flexible(CanId::Standard(0x123), &data, true)),
        ("D12ABCDEF2AA55\r", flexible(CanId::Extended(0x12AB_CDEF), &[0xAA, 0x55], false)),
        ("B12ABCDEF0\r", flexible(CanId::Extended(0x12AB_CDEF), &[], true)),
    ];
    for (text, frame) in cases {
        assert_eq!(line(text), Item::Frame(frame, None));
        assert_eq!(encoded(&frame), text);
    }
    let longest = format!("B12ABCDEFF{}EA5F\r", "5A".repeat(64));
    assert_eq!(longest.len(), MAX_LINE + 1);
    let frame = flexible(CanId::Extended(0x12AB_CDEF), &[0x5A; 64], true);
    assert_eq!(line(&longest), Item::Frame(frame, Some(59_999)));
    assert_eq!(line("d12390001\r"), Item::Malformed { bytes: 10 });
    for (code, len) in "0123456789ABCDEF".chars().zip(FD_LENGTHS) {
        let text = format!("d185{code}{}\r", "3C".repeat(len));
        assert_eq!(
            line(&text),
            Item::Frame(flexible(CanId::Standard(0x185), &vec![0x3C; len], false), None)
        );
    }
}

#[test]
fn what_is_almost_a_frame_is_none() {
    for text in [
        "t8000\r",             // Identifier above 0x7FF.
        "T200000000\r",        // Identifier above 0x1FFFFFFF.
        "t1239001122334455\r", // Nine bytes.
        "t12321\r",            // Too short.
        "t1232112\r",          // Half a byte.
        "t123111222\r",        // Two digits too many: neither time nor data.
        "t12G0\r",             // No digit.
        "t185440e2 100\r",     // A blank inside.
        "r12300\r",            // Remote with data.
        "t123\r",              // No length.
        "S9\r",                // No such bit rate.
        "Y3\r",                // No such data bit rate.
        "d12G0\r",             // No digit.
        "b1232112\r",          // Half a byte.
        "Z2\r",                // No such switch.
        "V\u{e9}03\r",         // No letters.
        "\n\r",                // LF is no part of the protocol.
        "q\r",                 // No such command.
    ] {
        assert_eq!(line(text), Item::Malformed { bytes: text.len() as u64 }, "{text:?}");
    }
}

#[test]
fn a_line_cut_by_noise_is_lost_and_the_next_is_read() {
    let read = items(&mut Decoder::new(), b"t185440\x00\xFFE20100\rt1854\x0740E20100\rt1230\r");
    let expected = [
        Item::Malformed { bytes: 16 },
        Item::Malformed { bytes: 5 },
        Item::Error,
        Item::Malformed { bytes: 9 },
        Item::Frame(standard(0x123, &[]), None),
    ];
    assert_eq!(read, expected);
}

#[test]
fn endless_noise_without_an_end_is_counted() {
    let mut decoder = Decoder::new();
    for _ in 0..100 {
        assert_eq!(decoder.decode(&mut &[b'5'; 1000][..]), None);
    }
    assert_eq!(decoder.pending(), 100_000);
    assert_eq!(
        items(&mut decoder, b"\rO\r"),
        [Item::Malformed { bytes: 100_001 }, Item::Command(Command::Open)]
    );
}

#[test]
fn a_length_off_by_two_is_seen_once_the_time_is_known_to_be_there() {
    // Six bytes and a time, the length digit damaged from 6 to 8.
    let damaged = b"t1858112233445566012C\r";
    let frame = standard(0x185, &[0x11, 0x22, 0x33, 0x44, 0x55, 0x66, 0x01, 0x2C]);
    assert_eq!(items(&mut Decoder::new(), damaged), [Item::Frame(frame, None)]);
    let mut strict = Decoder::expecting(Timestamps::Always);
    assert_eq!(items(&mut strict, damaged), [Item::Malformed { bytes: 22 }]);
    let mut never = Decoder::expecting(Timestamps::Never);
    assert_eq!(items(&mut never, b"t1230012C\r"), [Item::Malformed { bytes: 10 }]);
}

fn any_frame() -> impl Strategy<Value = CanFrame> {
    let id = prop_oneof![
        (0..=0x7FF_u16).prop_map(CanId::Standard),
        (0..=0x1FFF_FFFF_u32).prop_map(CanId::Extended)
    ];
    let classic = (id.clone(), prop::collection::vec(any::<u8>(), 0..=8), any::<bool>()).prop_map(
        |(id, data, remote)| {
            if remote {
                CanFrame::remote_frame(id, data.len()).expect("at most eight bytes")
            } else {
                CanFrame::data_frame(id, &data).expect("at most eight bytes")
            }
        },
    );
    let len = prop::sample::select(FD_LENGTHS.to_vec());
    let flexible = (id, len, prop::collection::vec(any::<u8>(), 64), any::<bool>())
        .prop_map(|(id, len, data, switch)| flexible(id, &data[..len], switch));
    prop_oneof![2 => classic, 1 => flexible]
}

/// Bytes as a bad line brings them: pieces of lines and noise.
fn line_noise() -> impl Strategy<Value = Vec<u8>> {
    let piece = prop_oneof![
        any_frame().prop_map(|frame| encoded(&frame).into_bytes()),
        prop::collection::vec(any::<u8>(), 0..6),
        prop::sample::select(b"tTrRdDzZFVNC0189aF\r\x07".to_vec()).prop_map(|byte| vec![byte]),
    ];
    prop::collection::vec(piece, 0..30).prop_map(|pieces| pieces.concat())
}

/// Where a failing case is kept. The default would be a folder beside the crate, and there the
/// workspace takes every folder for a member.
fn beside_this_file() -> ProptestConfig {
    let place = FileFailurePersistence::WithSource("regressions");
    ProptestConfig { failure_persistence: Some(Box::new(place)), ..ProptestConfig::default() }
}

proptest! {
    #![proptest_config(beside_this_file())]

    #[test]
    fn frames_survive_the_line(frame in any_frame(), time in prop::option::of(0..60_000_u16)) {
        let mut out = Vec::new();
        match time {
            Some(time) => encode_timestamped(&frame, time.into(), &mut out),
            None => encode(&frame, &mut out),
        }
        prop_assert_eq!(items(&mut Decoder::new(), &out), [Item::Frame(frame, time)]);
    }

    #[test]
    fn cuts_change_nothing(bytes in line_noise(), cuts in prop::collection::vec(1..9_usize, 1..20)) {
        let whole = items(&mut Decoder::new(), &bytes);
        let mut decoder = Decoder::new();
        let mut pieces = Vec::new();
        let mut rest = &bytes[..];
        for cut in cuts.iter().cycle() {
            let (head, tail) = rest.split_at((*cut).min(rest.len()));
            pieces.extend(items(&mut decoder, head));
            rest = tail;
            if rest.is_empty() { break }
        }
        prop_assert_eq!(whole, pieces);
    }

    #[test]
    fn every_byte_is_counted(bytes in line_noise()) {
        let mut decoder = Decoder::new();
        let mut rest = &bytes[..];
        let mut counted = 0;
        while !rest.is_empty() {
            let before = rest.len();
            let pending = decoder.pending();
            if let Some(item) = decoder.decode(&mut rest) {
                let taken = pending + (before - rest.len()) as u64;
                if let Item::Malformed { bytes } = item {
                    prop_assert_eq!(bytes, taken);
                }
                counted += taken;
            }
        }
        prop_assert_eq!(counted + decoder.pending(), bytes.len() as u64);
    }

    /// One byte put into a line, or taken out of it, is always seen.
    #[test]
    fn a_byte_more_or_less_is_always_seen(
        data in prop::collection::vec(any::<u8>(), 0..=8), noise in any::<u8>(), place in any::<prop::sample::Index>()
    ) {
        let frame = standard(0x185, &data);
        let good = encoded(&frame).into_bytes();
        let mut longer = good.clone();
        longer.insert(place.index(good.len()), noise);
        let mut shorter = good.clone();
        shorter.remove(place.index(good.len() - 1));
        for damaged in [longer, shorter] {
            for item in items(&mut Decoder::new(), &damaged) {
                let right = item == Item::Frame(frame, None);
                prop_assert!(right || !matches!(item, Item::Frame(..)), "{:?} gives {:?}", damaged, item);
            }
        }
    }
}
