//! Tests of the MetroPro reader.

use proptest::prelude::*;

use super::*;
use crate::test_data::{shared, sq_about_polynomial_mm};

/// A 3 × 2 map of header format 1 with one intensity image of 2 × 1, field by field at the offsets
/// that SurfaceTopography's `MetroPro.py` gives.
fn small() -> Vec<u8> {
    let mut bytes = vec![0; 834];
    let mut put = |offset: usize, field: &[u8]| {
        bytes[offset..offset + field.len()].copy_from_slice(field);
    };
    put(0, b"\x88\x1B\x03\x6F");
    put(4, b"\x00\x01"); // header format 1
    put(6, b"\x00\x00\x03\x42"); // header of 834 bytes
    put(52, b"\x00\x02\x00\x01\x00\x01"); // intensity 2 × 1, one image
    put(68, b"\x00\x03\x00\x02"); // phase 3 × 2
    put(72, b"\x00\x00\x00\x18"); // 24 bytes of phase
    put(76, b"\x3A\xDE\x68\xB1"); // 987654321 s after 1970
    put(80, b"flat\0rest of an older comment");
    put(164, b"\x3F\x00\x00\x00"); // scale factor 0.5
    put(168, b"\x35\x80\x00\x00"); // wavelength 2^-20 m
    put(176, b"\x40\x00\x00\x00"); // obliquity 2
    put(184, b"\x3A\x80\x00\x00"); // lateral resolution 2^-10 m
    put(238, b"\x00\x05"); // NewView
    put(242, b"\x01\x02"); // serial number 258
    bytes.extend(b"\xFF\xFF\xFF\xFF"); // intensity
    for phase in [4096_i32, -4096, 2_147_483_640, 0, 8192, 2_147_483_647] {
        bytes.extend(phase.to_be_bytes());
    }
    bytes
}

fn map(bytes: &[u8]) -> HeightMap {
    match read(bytes) {
        Ok(Topography::Map(map, _)) => map,
        other => panic!("no map but {other:?}"),
    }
}

fn with(offset: usize, field: &[u8]) -> Vec<u8> {
    let mut bytes = small();
    bytes[offset..offset + field.len()].copy_from_slice(field);
    bytes
}

#[test]
fn small_map_is_scaled_and_turned_over() {
    let read_map = map(&small());
    // 4096 counts are S·W·O = 2^-20 m.
    let unit_mm = 2.0_f64.powi(-20) * 1e3;
    let expected = [0.0, 2.0 * unit_mm, f64::NAN, unit_mm, -unit_mm, f64::NAN];
    assert_eq!(format!("{:?}", read_map.z_mm), format!("{expected:?}"));
    assert_eq!((read_map.nx, read_map.ny), (3, 2));
    assert_eq!((read_map.dx_mm, read_map.dy_mm), (0.9765625, 0.9765625));
    assert_eq!(read_map.missing(), 2);

    let topography = read(&small()).unwrap();
    let source = topography.source();
    assert_eq!(source.instrument.as_deref(), Some("Zygo NewView 258"));
    assert_eq!(source.date.as_deref(), Some("2001-04-19T04:25:21"));
    assert_eq!(source.comment.as_deref(), Some("flat"));
}

#[test]
fn phase_resolution_and_sign_scale_the_heights() {
    let reference = map(&small()).z_mm[1];
    assert_eq!(map(&with(218, b"\x00\x01")).z_mm[1], reference / 8.0);
    assert_eq!(map(&with(218, b"\x00\x02")).z_mm[1], reference / 32.0);
    assert_eq!(map(&with(232, b"\x00\x01")).z_mm[1], -reference);
}

#[test]
fn contradictions_are_errors_at_their_byte() {
    let message = |offset, field: &[u8]| read(&with(offset, field)).unwrap_err().to_string();
    for (offset, field, expected) in [
        (0, &b"GIF8"[..], "byte 0: expected a magic number"),
        (4, b"\x00\x02", "byte 4: expected header format 1 after this magic number, found 2"),
        (6, b"\x00\x00\x00\x10", "byte 6: expected a header of at least 570 bytes, found 16"),
        (68, b"\x00\x00", "byte 68: expected at least one column and one row, found 0 × 2"),
        (68, b"\x00\x04", "byte 72: expected 32 bytes of phase for 4 × 2 samples, found 24"),
        (56, b"\x00\x02", "expected a file of 866 bytes"),
        (164, b"\x00\x00\x00\x00", "byte 164: expected an interferometric scale factor above zero"),
        (
            168,
            b"\x7F\xC0\x00\x00",
            "byte 168: expected a wavelength in metres above zero, found NaN",
        ),
        (176, b"\xBF\x80\x00\x00", "byte 176: expected an obliquity factor above zero, found -1"),
        (184, b"\x00\x00\x00\x00", "byte 184: expected a lateral resolution in metres above zero"),
        (218, b"\x00\x03", "byte 218: expected a phase resolution of 0, 1 or 2, found 3"),
    ] {
        let message = message(offset, field);
        assert!(message.contains(expected), "{message}");
    }
}

#[test]
fn every_truncation_is_an_error() {
    let bytes = small();
    assert!((0..bytes.len()).all(|len| read(&bytes[..len]).is_err()));
    assert!(read(&[&bytes[..], b"\0"].concat()).is_err());
}

#[test]
fn dates_follow_the_calendar() {
    // `date -u -d @SECONDS +%FT%T`.
    for (seconds, date) in [
        (0, "1970-01-01T00:00:00"),
        (951_782_399, "2000-02-28T23:59:59"),
        (951_868_800, "2000-03-01T00:00:00"),
        (1_709_164_800, "2024-02-29T00:00:00"),
        (u32::MAX, "2106-02-07T06:28:15"),
    ] {
        assert_eq!(iso_date(seconds), date);
    }
}

/// Size, raw Sq and Sq about the second-order polynomial as the authors of SurfaceTopography assert
/// them (`test_metropro.py`, `detrend('curvature')`); Sq about the plane as numpy's `lstsq` gives it.
#[test]
fn measured_map_has_the_published_size_and_roughness() {
    let Some(bytes) = shared("topography/metropro-1.dat") else { return };
    let map = map(&bytes);
    assert_eq!((map.nx, map.ny, map.missing()), (640, 480, 0));
    let near = |found: f64, expected: f64| (found / expected - 1.0).abs() < 1e-6;
    assert!(near(640.0 * map.dx_mm, 0.7028813), "{}", 640.0 * map.dx_mm);
    assert!(near(480.0 * map.dy_mm, 0.5271610), "{}", 480.0 * map.dy_mm);
    for (degree, expected_m) in
        [(0, 7.528822204734589e-8), (1, 1.3334981370330653e-8), (2, 3.911386124282179e-9)]
    {
        let found_m = sq_about_polynomial_mm(&map, degree) * 1e-3;
        assert!(near(found_m, expected_m), "degree {degree}: {found_m:e}");
    }
}

proptest! {
    #[test]
    fn mutated_files_never_panic(
        changes in prop::collection::vec((0..862_usize, any::<u8>()), 0..6),
        len in 0..900_usize,
    ) {
        let mut bytes = small();
        for (offset, value) in changes {
            bytes[offset] = value;
        }
        bytes.truncate(len);
        let _ = read(&bytes);
    }

    #[test]
    fn random_bytes_after_the_magic_never_panic(tail in prop::collection::vec(any::<u8>(), 0..2000)) {
        let _ = read(&[&b"\x88\x1B\x03\x71\x00\x03"[..], &tail].concat());
    }
}
