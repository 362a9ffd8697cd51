//! Tests of the SDF readers.

use proptest::prelude::*;

use super::*;
use crate::test_data::shared;

const TEXT: &str = "aISO-1.0\nManufacID = TEST\nCreateDate = 040120100853\nNumPoints = 3\n\
    NumProfiles = 2\n; a comment\nXscale = 1.0E-6\nYscale\t2.0E-6\nZscale = 1.0E-3\n\
    Zresolution = 1.0E-9\nCompression = 0\nDataType = 7\nCheckType = 0\n*\n\
    1.5 BAD 3\n4\n5 6\n*\n< PartName > flat\n*\nnot read\n";

/// The same map as [`TEXT`] with heights in int16, field by field in the order of the standard.
fn binary() -> Vec<u8> {
    let mut bytes = b"bISO-1.0TEST\0\0\0\0\0\x00040120100853050320101353".to_vec();
    bytes.extend(b"\x03\0\x02\0");
    for scale_m in [1e-6_f64, 2e-6, 0.5e-3, 1e-9] {
        bytes.extend(scale_m.to_le_bytes());
    }
    bytes.extend(b"\0\x05\0");
    bytes.extend(b"\x03\0\x00\x80\x06\0\x08\0\x0A\0\x0C\0");
    bytes
}

fn map(bytes: &[u8]) -> HeightMap {
    match read(bytes) {
        Ok(Topography::Map(map, _)) => map,
        other => panic!("no map but {other:?}"),
    }
}

fn message(text: &str) -> String {
    read(text.as_bytes()).unwrap_err().to_string()
}

#[test]
fn text_and_binary_give_the_same_map() {
    let expected = HeightMap {
        nx: 3,
        ny: 2,
        dx_mm: 1e-6 * 1e3,
        dy_mm: 2e-6 * 1e3,
        x0_mm: 0.0,
        y0_mm: 0.0,
        z_mm: vec![1.5, f64::NAN, 3.0, 4.0, 5.0, 6.0],
    };
    for bytes in [TEXT.as_bytes(), &binary()] {
        let map = map(bytes);
        assert_eq!(format!("{map:?}"), format!("{expected:?}"));
        let topography = read(bytes).unwrap();
        assert_eq!(topography.source().instrument.as_deref(), Some("TEST"));
        assert_eq!(topography.source().date.as_deref(), Some("2010-01-04T08:53"));
    }
    let topography = read(TEXT.as_bytes()).unwrap();
    assert_eq!(topography.source().comment.as_deref(), Some("< PartName > flat"));
}

#[test]
fn a_scale_of_which_no_length_can_be_made_is_refused() {
    for scale in ["1.0E+306", "1.7E+308"] {
        let said = message(&TEXT.replace("Xscale = 1.0E-6", &format!("Xscale = {scale}")));
        assert!(said.contains("a scale that keeps all lengths finite in mm, found 1"), "{said}");
    }
}

#[test]
fn binary_data_types_have_their_sizes_and_gaps() {
    for (code, stored, expected) in [
        (0, &b"\x00\xFF"[..], [0.0, 255.0]),
        (1, b"\x01\x02\xFF\xFF", [513.0, f64::NAN]),
        (2, b"\x01\0\x02\0\xFF\xFF\xFF\xFF", [131_073.0, f64::NAN]),
        (3, b"\0\0\x80\x3F\0\0\xC0\x7F", [1.0, f64::NAN]),
        (4, b"\x80\x7F", [-128.0, 127.0]),
        (5, b"\xFF\xFF\0\x80", [-1.0, f64::NAN]),
        (6, b"\xFE\xFF\xFF\xFF\0\0\0\x80", [-2.0, f64::NAN]),
        (7, b"\0\0\0\0\0\0\xF0\xBF\0\0\0\0\0\0\xF0\x7F", [-1.0, f64::NAN]),
    ] {
        let mut bytes = binary();
        bytes.truncate(81);
        bytes[42] = 2;
        bytes[44] = 1;
        bytes[62..70].copy_from_slice(&1e-3_f64.to_le_bytes());
        bytes[79] = code;
        bytes.extend(stored);
        assert_eq!(format!("{:?}", map(&bytes).z_mm), format!("{expected:?}"), "type {code}");
        assert!(read(&bytes[..bytes.len() - 1]).is_err(), "type {code}");
    }
}

#[test]
fn errors_name_line_expected_and_found() {
    let with = |from: &str, to: &str| message(&TEXT.replacen(from, to, 1));
    for (from, to, expected) in [
        ("aISO-1.0", "aISO-2.0", "line 1: expected aISO-1.0 or aBCR-1.0, found \"aISO-2.0\""),
        ("= 3", "= -3", "line 4: expected a whole number for NumPoints, found \"-3\""),
        ("= 3", "= 0", "line 4: expected at least one column and one row, found 0 × 2"),
        ("= 3", "= 99999999999", "line 4: expected at most 100000000 points"),
        (
            "Xscale = 1.0E-6",
            "",
            "line 14: expected Xscale before the end of the header, found none",
        ),
        ("Xscale = 1.0E-6", "Xscale = 0", "line 7: expected a scale in metres above zero, found 0"),
        (
            "= 1.0E-3",
            "= 1,0E-3",
            "line 9: expected a number in metres for Zscale, found \"1,0E-3\"",
        ),
        ("Zresolution", "Zscale", "line 10: expected Zscale only once, found it again"),
        ("Compression = 0", "Compression = 1", "line 11: Compression 1 is not supported"),
        ("DataType = 7", "DataType = 8", "line 12: expected a DataType from 0 to 7, found 8"),
        ("DataType = 7", "DataType = 5", "line 15, column 1: expected a whole number or BAD"),
        ("5 6", "5,0 6", "line 17, column 1: expected a number or BAD, found \"5,0\""),
        ("5 6", "5", "line 18: expected 6 heights before here, found 5"),
        ("5 6", "5 6 7", "line 17, column 3: expected an asterisk after 6 heights, found \"7\""),
    ] {
        let message = with(from, to);
        assert!(message.contains(expected), "{from} → {to}: {message}");
    }
    let header_only = TEXT.split('*').next().unwrap();
    assert!(message(header_only).contains("expected an asterisk after the header"));
}

#[test]
fn binary_contradictions_are_errors_at_their_byte() {
    for (offset, value, expected) in [
        (0, b'x', "expected aISO-1.0"),
        (3, b'-', "byte 0: expected bISO-1.0 or bBCR-1.0"),
        (42, 0, "byte 42: expected at least one column and one row, found 0 × 2"),
        (42, 4, "byte 81: expected 16 bytes of heights, found 12"),
        (69, 0xFF, "byte 62: expected a scale in metres above zero"),
        (78, 1, "byte 78: Compression 1 is not supported, expected Compression 0"),
        (79, 9, "byte 79: expected a DataType from 0 to 7, found 9"),
        (80, 2, "byte 80: CheckType 2 is not supported, expected CheckType 0"),
    ] {
        let mut bytes = binary();
        bytes[offset] = value;
        let message = read(&bytes).unwrap_err().to_string();
        assert!(message.contains(expected), "{message}");
    }
    let bytes = binary();
    assert!((0..bytes.len()).all(|len| read(&bytes[..len]).is_err()));
}

/// "S2 Softgauges Example" of the standard; the file prints these 28 heights in µm.
#[test]
fn softgauge_of_the_standard_is_read_as_printed() {
    let Some(bytes) = shared("topography/sdf-1.sdf") else { return };
    let map = map(&bytes);
    #[rustfmt::skip]
    let printed_um = [
        1.00000, 0.99874, 0.99495, 0.98865, 0.97986, 0.96858, 1.00000,
        0.99874, 0.99748, 0.99369, 0.98740, 0.97862, 0.96736, 0.99874,
        0.99495, 0.99369, 0.98993, 0.98366, 0.97491, 0.96369, 0.99495,
        0.97986, 0.97862, 0.97491, 0.96874, 0.96012, 0.94907, 0.97986,
    ];
    assert_eq!((map.nx, map.ny, map.z_mm.len()), (7, 4, 28));
    for (z_mm, z_um) in map.z_mm.iter().zip(printed_um) {
        assert!((z_mm - z_um * 1e-3).abs() < 1e-18, "{z_mm} {z_um}");
    }
    assert!((map.dx_mm - 1e-3).abs() < 1e-18 && map.dx_mm == map.dy_mm);
}

proptest! {
    #[test]
    fn mutated_files_never_panic(
        text in any::<bool>(),
        changes in prop::collection::vec((any::<prop::sample::Index>(), any::<u8>()), 0..6),
        len in any::<prop::sample::Index>(),
    ) {
        let mut bytes = if text { TEXT.as_bytes().to_vec() } else { binary() };
        for (place, value) in changes {
            let place = place.index(bytes.len());
            bytes[place] = value;
        }
        let len = len.index(bytes.len() + 1);
        bytes.truncate(len);
        let _ = read(&bytes);
    }

    #[test]
    fn random_bytes_never_panic(bytes in prop::collection::vec(any::<u8>(), 0..300)) {
        let _ = read(&bytes);
        let _ = read(&[&b"bISO-1.0"[..], &bytes].concat());
    }
}
