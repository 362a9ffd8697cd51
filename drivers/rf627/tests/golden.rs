//! Bytes of a real scanner. Sources: README.md, "What was tested".

use std::path::{Path, PathBuf};

use asphera_rf627::wire::{
    ALL_DEVICES, Format, Header, Kind, Packet, PacketError, RawPoint, ServiceHeader, encode,
};

/// The fields before the points of the first capture of ten, one a line; then its point in the middle and one without a
/// value, with the byte count of both.
const HEAD: [u8; 72] = [
    0x11, // profile
    0x00, // no intensities
    0x73, 0x02, // RF627
    0x20, 0xBF, 0x02, 0x00, // serial 180000
    0xEC, 0xB0, 0x0E, 0x85, 0xFE, 0x3F, 0x04, 0x00, // 1,196,262.293418220 s
    0x01, 0x00, // protocol 1.0
    0x30, 0x40, // parameters at 48, points at 64
    0xD9, 0xC1, 0xFD, 0x68, // datagram 1,761,460,697
    0x00, 0x00, 0x00, 0x00, // measurement 0
    0xC8, 0x00, // z range 200
    0xA6, 0x00, // x range 166
    0x00, 0x40, // 16384 steps
    0, 0, 0, 0, 0, 0, 0, 0, 0, 0, // reserved
    0x3B, 0xE4, 0xF3, 0x7A, // licence hash
    0xC0, 0xA3, 0x01, 0x00, // exposure 107,456 ns
    0x2A, 0x00, 0x00, 0x00, // laser 42
    0x00, 0x00, 0x00, 0x00, // step 0
    0x00, // direction
    0x08, 0x00, // 8 bytes of points (2592 in the capture)
    0x04, // 4 bytes a point
    0xC8, 0x02, 0x4F, 0x17, // x 712, z 5967
    0x00, 0x00, 0x00, 0x00, // nothing
];

const HEADER: Header = Header {
    format: Format::Profile,
    serial: 180_000,
    time_ns: 1_196_262_293_418_220,
    version: (1, 0),
    packet_count: 1_761_460_697,
    measure_count: 0,
    z_range_mm: 200,
    x_range_mm: 166,
    range_steps: 16_384,
    licence_hash: 0x7AF3_E43B,
    exposure_ns: 107_456,
    laser: 42,
    step_count: 0,
    direction: 0,
};

/// A capture; `None`, said on stderr, where it is not there.
#[expect(clippy::print_stderr, reason = "what is skipped must be seen")]
fn capture(number: u32) -> Option<Vec<u8>> {
    let folder = std::env::var_os("ASPHERA_DATA").map_or_else(
        || Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../shared/data"),
        PathBuf::from,
    );
    let path = folder.join(format!("rf627/Profile_{number}.bin"));
    let bytes = std::fs::read(&path).ok();
    if bytes.is_none() {
        eprintln!(
            "skipped: no {}; ASPHERA_DATA names the folder of reference data",
            path.display()
        );
    }
    bytes
}

#[test]
fn the_fields_of_a_capture_are_read_and_written() {
    let packet = Packet::decode(&HEAD).unwrap();
    assert_eq!(packet.header, HEADER);
    let points: Vec<RawPoint> = packet.raw_points().collect();
    assert_eq!(points, [RawPoint { x: 712, z: 5967 }, RawPoint { x: 0, z: 0 }]);
    let places: Vec<Option<[f64; 2]>> = packet.points_mm().collect();
    let [x_mm, z_mm] = places[0].unwrap();
    assert!((x_mm - 7.2139).abs() < 5e-5 && (z_mm - 72.8394).abs() < 5e-5, "{x_mm}, {z_mm}");
    assert_eq!(places[1], None);
    let mut written = Vec::new();
    encode(&HEADER, &points, None, &mut written).unwrap();
    assert_eq!(written, HEAD);
}

/// Ten measurements one after the other, 2.06 ms apart, each with 648 points of which 520 or 521 have a value.
#[test]
fn ten_captures_are_ten_profiles_in_a_row() {
    for number in 0..10 {
        let Some(bytes) = capture(number) else { return };
        let packet = Packet::decode(&bytes).unwrap();
        assert_eq!((bytes.len(), packet.len(), packet.trailing()), (2656, 648, 0));
        let header = packet.header;
        assert_eq!((header.serial, header.measure_count), (180_000, number));
        assert_eq!(header.packet_count, HEADER.packet_count + number);
        let since_ns = header.time_ns - HEADER.time_ns;
        let expected_ns = u64::from(number) * 2_061_750;
        assert!(since_ns.abs_diff(expected_ns) < 300, "{since_ns} ns of {expected_ns}");
        let valid = packet.points_mm().flatten().count();
        assert_eq!(valid, if [4, 9].contains(&number) { 520 } else { 521 });
        assert!(
            packet.points_mm().flatten().all(|[x, z]| x.abs() < 39.0 && (0.0..91.0).contains(&z))
        );
        let raw: Vec<RawPoint> = packet.raw_points().collect();
        if number == 0 {
            assert_eq!(raw[324], RawPoint { x: 712, z: 5967 });
        }
        let mut written = Vec::new();
        encode(&header, &raw, None, &mut written).unwrap();
        assert_eq!(written, bytes, "the same datagram, reserved bytes among it");
    }
}

#[test]
fn data_that_are_no_points_in_mm_are_refused_by_name() {
    let with = |at: usize, byte: u8| {
        let mut bytes = HEAD.to_vec();
        bytes[at] = byte;
        Packet::decode(&bytes).unwrap_err().to_string()
    };
    assert!(with(0, 0x10).contains("0x10, columns of the detector, expected profiles in mm"));
    assert!(with(0, 0x12).contains("interpolated columns"));
    assert!(with(0, 0x20).contains("a profile by polynomials"));
    assert!(with(0, 0x99).contains("0x99, which we do not know"));
    assert!(with(2, 0x74).contains("device type 628, expected 627"));
    assert!(with(16, 2).contains("protocol 2.0, expected 1.0 to 1.2"));
    assert!(with(33, 0).contains("divided into 0 steps"));
    assert!(with(18, 60).contains("parameters at byte 60 and points at byte 64 of 72"));
    assert!(with(19, 73).contains("points at byte 73 of 72"));
    assert!(with(61, 9).contains("9 bytes of points with 4 bytes each"));
    assert!(with(61, 12).contains("12 bytes, and 8 are there"));
    let mut interpolated = HEAD.to_vec();
    interpolated[0] = 0x13;
    assert_eq!(Packet::decode(&interpolated).unwrap().header.format, Format::Interpolated);
}

#[test]
fn intensities_follow_the_points() {
    let points = [RawPoint { x: -5, z: 9 }, RawPoint { x: 7, z: 0 }];
    let mut bytes = Vec::new();
    encode(&HEADER, &points, Some(&[200, 3]), &mut bytes).unwrap();
    assert_eq!(bytes[1], 1);
    let packet = Packet::decode(&bytes).unwrap();
    assert_eq!(packet.intensities(), Some(&[200, 3][..]));
    assert_eq!(packet.points_mm().nth(1), Some(None), "z = 0 is no value");
    bytes.pop();
    assert_eq!(Packet::decode(&bytes), Err(PacketError::Cut { claimed: 10, found: 9 }));
    bytes.extend([3, 1, 2]);
    assert_eq!(Packet::decode(&bytes).map(|packet| packet.trailing()), Ok(2));
    assert!(encode(&HEADER, &points, Some(&[1]), &mut bytes).is_err());
    assert!(encode(&HEADER, &[points[0]; 16_384], None, &mut bytes).is_err());
}

/// The search for scanners: a command to all, the last one, 0x5E00, with the command big-endian.
#[test]
fn a_service_message_is_known_where_a_profile_should_be() {
    let search = [0x14, 0, 0, 0, 0xFF, 0xFF, 0xFF, 0xFF, 1, 0, 0x5E, 0x00, 0, 0];
    let header = ServiceHeader {
        kind: Kind::Command,
        wants_confirmation: false,
        is_last: true,
        checksum_bit: false,
        checksum: 0,
        serial: ALL_DEVICES,
        message: 1,
        command: 0x5E00,
        size: 0,
    };
    assert_eq!(ServiceHeader::decode(&search), Some(header));
    assert_eq!(header.encode(), search);
    let error = Packet::decode(&search).unwrap_err();
    assert_eq!(error, PacketError::Service(0x5E00));
    assert!(error.to_string().contains("the port is that of profiles, 50001, and not 50011"));
    assert_eq!(Packet::decode(b"hello, world"), Err(PacketError::Device(0x6C6C)));
    assert_eq!(Packet::decode(&HEAD[..63]), Err(PacketError::Short(63)));
}
