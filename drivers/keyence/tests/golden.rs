//! Literal bytes, put together by hand from the layouts of the maker's and of the ROS code. Sources: README.md.

#![expect(clippy::unwrap_used, reason = "a test ends where something is not as it must be")]

use asphera_keyence::wire::{
    Answer, AnswerError, ErrorCodes, Layout, LayoutError, NoHeight, Notice, Profile, ProfileError,
    Request, RequestError, Series, Unit, heights, is_notice, pack_heights,
};

/// Preparation of the stream, as `LJX8IF_PreStartHighSpeedDataCommunication` and `myAnyCommand` of LJX8_IF_Linux.cpp send it.
const PREPARE: [u8; 24] = [
    0x14, 0x00, 0x00, 0x00, // 20 bytes follow: 16 + 8 - 4
    0x03, 0x00, 0xF0, 0x00, // LJ-X8000
    0x00, 0x00, 0x00, 0x00, // zero
    0x08, 0x00, 0x00, 0x00, // body of 8 bytes
    0x47, 0x00, 0x00, 0x00, // command
    0x02, 0x00, 0x00, 0x00, // from the next profile on
];

/// Start of the stream with the code 12345678h.
const START: [u8; 28] = [
    0x18, 0x00, 0x00, 0x00, // 24 bytes follow
    0x03, 0x00, 0xF0, 0x00, // LJ-X8000
    0x00, 0x00, 0x00, 0x00, // zero
    0x0C, 0x00, 0x00, 0x00, // body of 12 bytes
    0xA0, 0x00, 0x00, 0x00, // command
    0x47, 0x00, 0x00, 0x00, // of a stream that 47h prepared
    0x78, 0x56, 0x34, 0x12, // start code
];

/// Answer to the preparation: places 32, 40, 44, 46, 48 and 52 as `LJX8IF_PreStartHighSpeedDataCommunication` reads them.
const PREPARED: [u8; 56] = [
    0x34, 0x00, 0x00, 0x00, // 52 bytes follow
    0x03, 0x00, 0xF0, 0x00, // 4
    0x00, 0x00, 0x00, 0x00, // 8
    0x28, 0x00, 0x00, 0x00, // 12 length of the body
    0x47, 0x00, 0x00, 0x00, // 16 command, 17 error
    0x00, 0x00, 0x00, 0x00, // 20
    0x03, 0x00, 0x00, 0x00, // 24 active program 3
    0x00, 0x00, 0x00, 0x00, // 28
    0x78, 0x56, 0x34, 0x12, // 32 start code
    0x00, 0x00, 0x00, 0x00, // 36
    0x01, 0x00, 0x00, 0x00, // 40 kind: one profile, no luminances
    0x09, 0x00, // 44 nine points
    0x08, 0x00, // 46 unit 80 nm
    0x18, 0xFC, 0xFF, 0xFF, // 48 x of the first point -1000: -0.01 mm
    0xF4, 0x01, 0x00, 0x00, // 52 points 500 apart: 0.005 mm
];

/// Profile of nine points with trigger 7 and encoder -2; heights 1, -1, 524287, -524284, no peak, masked, dead zone, not
/// processed, 74565. Each five hexadecimal digits of a line are a point, the last one first.
const PROFILE: [u8; 52] = [
    0x00, 0x00, 0x00, 0x00, // reserved
    0x07, 0x00, 0x00, 0x00, // trigger count
    0xFE, 0xFF, 0xFF, 0xFF, // encoder count
    0x00, 0x00, 0x00, 0x00, // reserved
    0x00, 0x00, 0x00, 0x00, // reserved
    0x00, 0x00, 0x00, 0x00, // reserved
    0x01, 0x00, 0xF0, 0xFF, 0xFF, // FFFFF 00001
    0xFF, 0xFF, 0x47, 0x00, 0x80, // 80004 7FFFF
    0x00, 0x00, 0x18, 0x00, 0x80, // 80001 80000
    0x02, 0x00, 0x38, 0x00, 0x80, // 80003 80002
    0x45, 0x23, 0x01, 0x00, // 12345, filled up to a u32
    0x62, 0xDB, 0x71, 0xCA, // sum of the twelve numbers before it: CA71DB62
];

fn layout() -> Layout {
    let (answer, _) = Answer::decode(&PREPARED).unwrap().unwrap();
    Layout::decode(answer.content).unwrap()
}

#[test]
fn requests_are_those_of_the_makers_code() {
    let start = Request::Start { code: 0x1234_5678 };
    assert_eq!(Request::Prepare.encode(Series::LjX8000), PREPARE);
    assert_eq!(start.encode(Series::LjX8000), START);
    // `sendSingleCommand`: four bytes of body.
    for (request, command) in [
        (Request::Units, 0x06),
        (Request::Errors, 0x04),
        (Request::StartMeasure, 0x22),
        (Request::StopMeasure, 0x23),
        (Request::Stop, 0x48),
    ] {
        let single = [16, 0, 0, 0, 3, 0, 0xF0, 0, 0, 0, 0, 0, 4, 0, 0, 0, command, 0, 0, 0];
        assert_eq!(request.encode(Series::LjX8000), single);
    }
    // `GetCurrentProfileUnitForFallback`: the current profile, one, not erased.
    let profile = [
        32, 0, 0, 0, 3, 0, 0xF0, 0, 0, 0, 0, 0, 20, 0, 0, 0, 0x42, 0, 0, 0, // command
        0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 1, 0, 0, 0,
    ];
    assert_eq!(Request::Profile.encode(Series::LjX8000), profile);
    for (bytes, request) in [(&PREPARE[..], Request::Prepare), (&START, start)] {
        assert_eq!(Request::decode(bytes), Ok(Some((Series::LjX8000, request, bytes.len()))));
        assert_eq!(Request::decode(&bytes[..bytes.len() - 1]), Ok(None));
    }
}

/// `encodeRequestHeader` of the ROS code, keyence_message.h: 00F00001h, and the size of the arguments + 16.
#[test]
fn the_lj_v7000_has_a_number_of_its_own() {
    let mut prepare = PREPARE;
    prepare[4] = 0x01;
    assert_eq!(Request::Prepare.encode(Series::LjV7000), prepare);
    let decoded = Request::decode(&prepare);
    assert_eq!(decoded, Ok(Some((Series::LjV7000, Request::Prepare, 24))));
}

#[test]
fn bytes_that_are_no_request_are_refused() {
    let with = |at: usize, byte: u8| {
        let mut bytes = PREPARE;
        bytes[at] = byte;
        Request::decode(&bytes)
    };
    assert_eq!(with(6, 0xF1), Err(RequestError::Series([3, 0, 0xF1, 0])));
    assert_eq!(with(12, 9), Err(RequestError::Length { length: 20, body: 9 }));
    assert_eq!(with(16, 0x02), Err(RequestError::Command(0x02, 4)), "no reboot");
}

#[test]
fn an_answer_tells_the_layout() {
    let (answer, len) = Answer::decode(&PREPARED).unwrap().unwrap();
    assert_eq!((answer.command, answer.error, len), (0x47, 0, 56));
    let layout = Layout::decode(answer.content).unwrap();
    let expected = Layout {
        start_code: 0x1234_5678,
        kind: 1,
        points: 9,
        unit_10nm: 8,
        x_start_10nm: -1000,
        x_pitch_10nm: 500,
    };
    assert_eq!(layout, expected);
    assert_eq!(layout.encode(), answer.content);
    assert_eq!(Answer::decode(&PREPARED[..55]), Ok(None));
    assert_eq!(Layout::decode(&answer.content[..27]), Err(LayoutError::Short(27)));
    let without_points = Layout { points: 0, ..layout }.encode();
    assert_eq!(Layout::decode(&without_points), Err(LayoutError::Points(0)));
    let too_many = Layout { points: 3201, ..layout }.encode();
    assert_eq!(Layout::decode(&too_many), Err(LayoutError::Points(3201)));
    let at_one_place = Layout { x_pitch_10nm: 0, ..layout }.encode();
    assert_eq!(Layout::decode(&at_one_place), Err(LayoutError::Pitch));
}

/// 17 is the place of the error. An answer may end behind it.
#[test]
fn a_refusal_has_its_error() {
    let refusal = [14, 0, 0, 0, 3, 0, 0xF0, 0, 0, 0, 0, 0, 2, 0, 0, 0, 0xA0, 0x33];
    let (answer, len) = Answer::decode(&refusal).unwrap().unwrap();
    assert_eq!((answer, len), (Answer { command: 0xA0, error: 0x33, content: &[] }, 18));
    assert_eq!(Answer::decode(&[13, 0, 0, 0]), Err(AnswerError::Length(13)));
    assert_eq!(Answer::decode(&[0, 0, 0, 1]), Err(AnswerError::Length(1 << 24)));
}

/// Serial number of the controller at 44 + 32, model of the head at 44 + 52, its serial number at 44 + 32 + 52
/// (`LJX8IF_GetSerialNumber`, `LJX8IF_GetHeadModel`); count of errors at 28, codes from 32 on (`LJX8IF_GetError`).
#[test]
fn units_and_errors_stand_where_the_makers_code_reads_them() {
    let mut answer = [0; 148];
    answer[28] = 2;
    answer[44..52].copy_from_slice(b"LJ-X8000");
    answer[76..84].copy_from_slice(b"1A230004");
    answer[96..104].copy_from_slice(b"LJ-X8080");
    answer[128..136].copy_from_slice(b"9C870001");
    let unit = |model: &str, serial: &str| Unit { model: model.into(), serial: serial.into() };
    let units = [unit("LJ-X8000", "1A230004"), unit("LJ-X8080", "9C870001")];
    assert_eq!(Unit::decode_all(&answer[28..]), units);
    assert_eq!(Unit::encode_all(&units), &answer[28..]);
    assert_eq!(Unit::decode_all(&[]), []);
    let errors = [2, 0, 0, 0, 0x21, 0x00, 0x34, 0x12];
    assert_eq!(ErrorCodes::decode(&errors), ErrorCodes(vec![0x21, 0x1234]));
    assert_eq!(ErrorCodes(vec![0x21, 0x1234]).encode(), errors);
    assert_eq!(ErrorCodes::decode(&[9, 0, 0, 0, 1, 0, 2]), ErrorCodes(vec![1]));
}

#[test]
fn a_profile_has_its_heights_and_their_absence() {
    let layout = layout();
    assert_eq!(Profile::len(&layout), 52);
    let profile = Profile::decode(&PROFILE, &layout).unwrap().unwrap();
    assert_eq!((profile.trigger_count, profile.encoder_count), (7, -2));
    let expected = [
        Ok(1),
        Ok(-1),
        Ok(524_287),
        Ok(-524_284),
        Err(NoHeight::NoPeak),
        Err(NoHeight::Masked),
        Err(NoHeight::DeadZone),
        Err(NoHeight::Unprocessed),
        Ok(74_565),
    ];
    assert_eq!(profile.heights().collect::<Vec<_>>(), expected);
    assert_eq!(Profile::encode(&layout, 7, -2, expected), PROFILE);
    assert_eq!(Profile::decode(&PROFILE[..51], &layout), None);
    // The sum, added up here without the code that is tested: 13 numbers of 4 bytes, without the last.
    let words =
        PROFILE.chunks(4).map(|four| u64::from(u32::from_le_bytes(four.try_into().unwrap())));
    let sum = words.take(12).sum::<u64>() % (1 << 32);
    assert_eq!(sum.to_le_bytes()[..4], PROFILE[48..]);
    for at in 0..52 {
        let mut damaged = PROFILE;
        damaged[at] ^= 0x10;
        let error = Profile::decode(&damaged, &layout).unwrap().unwrap_err();
        assert!(matches!(error, ProfileError::Sum { .. }), "byte {at}");
    }
}

/// `SetThreadParamFast`: 20 bits and 10 bits a point are filled up to a u32 each.
#[test]
fn luminances_follow_the_heights() {
    let with = Layout { kind: 0x41, ..layout() };
    assert_eq!((with.height_bytes(), with.luminance_bytes()), (24, 12));
    assert_eq!(Profile::len(&with), 24 + 24 + 12 + 4);
    let whole = Layout { points: 3200, kind: 0x40, ..with };
    assert_eq!(Profile::len(&whole), 24 + 8000 + 4000 + 4);
    let mut bytes = PROFILE[..48].to_vec();
    bytes.extend([0x55, 0x55, 0x55, 0x15, 0, 0, 0, 0, 0, 0, 0, 0]);
    let sum = bytes.chunks(4).map(|it| u32::from_le_bytes(it.try_into().unwrap()));
    let sum = sum.fold(0_u32, u32::wrapping_add);
    bytes.extend(sum.to_le_bytes());
    let profile = Profile::decode(&bytes, &with).unwrap().unwrap();
    let plain = Profile::decode(&PROFILE, &layout()).unwrap().unwrap();
    assert!(profile.heights().eq(plain.heights()));
}

/// `ReceiveDataCheck` and `receiveThread`: FFFFFFFFh; then bits 0 to 15 for a stop, bit 16 for the end of a batch.
#[test]
fn notices_say_what_ended() {
    let stop = [0xFF, 0xFF, 0xFF, 0xFF, 0x02, 0x00, 0x00, 0x00];
    let notice = Notice::decode(&stop).unwrap();
    assert_eq!((notice.stopped(), notice.ends_batch(), notice.encode()), (Some(2), false, stop));
    let batch = [0xFF, 0xFF, 0xFF, 0xFF, 0x00, 0x00, 0x01, 0x00];
    let notice = Notice::decode(&batch).unwrap();
    assert_eq!((notice.stopped(), notice.ends_batch(), notice.encode()), (None, true, batch));
    assert_eq!(Notice::decode(&stop[..7]), None);
    assert!(is_notice(&stop) && !is_notice(&PROFILE));
}

/// Bit by bit: bit b of point n is bit 20 n + b of the bytes, from the least significant one on. The ROS code
/// (`ljv7_unpack_profile_data`) takes eight points from five u32 with masks; both say the same of these bytes.
fn by_bits(bytes: &[u8], point: usize) -> i32 {
    let bit = |at: usize| i32::from(bytes[at / 8] >> (at % 8) & 1);
    let bits = (0..20).map(|b| bit(20 * point + b) << b).sum::<i32>();
    if bits >= 1 << 19 { bits - (1 << 20) } else { bits }
}

/// Masks and shifts by hand, from the table of five u32 for eight points.
fn by_words(bytes: &[u8]) -> Vec<i32> {
    let words: Vec<u32> =
        bytes.chunks(4).map(|four| u32::from_le_bytes(four.try_into().unwrap())).collect();
    let mut points = Vec::new();
    for row in words.chunks(5) {
        let [a, b, c, d, e] = row.try_into().unwrap();
        points.extend([
            a % 0x10_0000,
            a >> 20 | (b % 0x100) << 12,
            b >> 8 & 0xF_FFFF,
            b >> 28 | (c % 0x1_0000) << 4,
            c >> 16 | (d % 0x10) << 16,
            d >> 4 & 0xF_FFFF,
            d >> 24 | (e % 0x1000) << 8,
            e >> 12,
        ]);
    }
    points.into_iter().map(|bits| ((bits ^ 0x8_0000) as i32) - 0x8_0000).collect()
}

#[test]
fn three_ways_to_unpack_agree() {
    let mut state = 1_u32;
    let bytes: Vec<u8> = std::iter::repeat_with(|| {
        state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        (state >> 24) as u8
    })
    .take(20 * 100)
    .collect();
    let numbers: Vec<i32> = heights(&bytes, 800)
        .map(|height| match height {
            Ok(value) => value,
            Err(NoHeight::NoPeak) => -524_288,
            Err(NoHeight::Masked) => -524_287,
            Err(NoHeight::DeadZone) => -524_286,
            Err(NoHeight::Unprocessed) => -524_285,
        })
        .collect();
    assert_eq!(numbers, by_words(&bytes));
    assert_eq!(numbers, (0..800).map(|point| by_bits(&bytes, point)).collect::<Vec<_>>());
    let mut packed = Vec::new();
    pack_heights(heights(&bytes, 800), &mut packed);
    assert_eq!(packed, bytes);
    // An odd number of points, and too few bytes.
    assert_eq!(heights(&bytes[..20], 7).count(), 7);
    assert_eq!(heights(&bytes[..7], 7).count(), 2);
}
