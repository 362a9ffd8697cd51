use proptest::prelude::*;

use super::*;
use crate::test_data::hold_against_damage;
use crate::xyz::{Column, Unit};

fn plain(bytes: &[u8]) -> Result<Topography, ReadError> {
    read(bytes, &TextOptions::default())
}

fn points(bytes: &[u8]) -> Vec<[f64; 3]> {
    plain(bytes).unwrap().points().collect()
}

fn message(bytes: &[u8], options: &TextOptions) -> String {
    read(bytes, options).unwrap_err().to_string()
}

fn units(units: &[Unit]) -> TextOptions {
    TextOptions { units: units.to_vec(), ..TextOptions::default() }
}

/// A file of version 1.0.
fn file(descr: &str, shape: &str, data: &[u8]) -> Vec<u8> {
    let text = format!("{{'descr': {descr}, 'fortran_order': False, 'shape': {shape}, }}\n");
    let head = [MAGIC, &[1, 0], &(text.len() as u16).to_le_bytes()].concat();
    [&head, text.as_bytes(), data].concat()
}

/// A file of numbers as `<f8`.
fn doubles(shape: &str, numbers: &[f64]) -> Vec<u8> {
    let data: Vec<u8> = numbers.iter().flat_map(|number| number.to_le_bytes()).collect();
    file("'<f8'", shape, &data)
}

#[test]
fn arrays_of_numpy_are_points_in_both_orders() {
    let topography = crate::read("a", POINTS).unwrap();
    let expected = [[0.0, 0.5, 1.25], [-2.0, 3.0, 0.1], [4.0, 5.0, -6.0]];
    assert_eq!(topography.points().collect::<Vec<_>>(), expected);
    let source = topography.source();
    assert_eq!(
        (source.format, source.taken.as_ref().unwrap().units_by),
        (Format::Npy, By::Default)
    );
    let expected = expected.map(|point| point.map(|value| f64::from(value as f32)));
    assert_eq!(points(FORTRAN), expected);
    let found = read(WHOLE, &units(&[Unit::Um])).unwrap();
    assert_eq!(found.points().collect::<Vec<_>>(), [[0.001, 0.002, 0.003], [-0.005, 0.006, 0.007]]);
    assert_eq!(found.uncertainties_mm(), [0.004, 0.008]);
}

#[test]
fn records_are_read_by_the_names_of_their_fields() {
    let error = message(RECORDS, &TextOptions::default());
    assert!(error.contains("the unit of x is not stated, while that of others is"), "{error}");
    let found = read(RECORDS, &units(&[Unit::Mm])).unwrap();
    assert_eq!(found.points().collect::<Vec<_>>(), [[1.0, 0.5, -1.0], [2.0, 0.25, 2.0]]);
    assert_eq!(found.uncertainties_mm(), [1e-5, 2e-5]);
    let data: Vec<u8> =
        [3.0_f64, 1.0, 2.0].iter().flat_map(|number| number.to_le_bytes()).collect();
    let swapped = file("[('z', '<f8'), ('x', '<f8'), ('y', '<f8')]", "(1,)", &data);
    assert_eq!(points(&swapped), [[1.0, 2.0, 3.0]]);
    let nameless = file("[('a', '<f8'), ('b', '<f8'), ('c', '<f8')]", "(1,)", &data);
    let error = message(&nameless, &TextOptions::default());
    assert!(
        error.starts_with("NumPy file, row 1: the columns a, b, c are neither x, y, z"),
        "{error}"
    );
}

#[test]
fn two_columns_are_a_profile_of_heights_or_slopes() {
    let profile = doubles("(3, 2)", &[0.0, 1.0, 1.0, 2.0, 3.0, 4.0]);
    assert!(message(&profile, &TextOptions::default()).contains("two columns without names"));
    let heights = read(&profile, &units(&[Unit::Mm])).unwrap();
    assert_eq!(heights.points().nth(1), Some([1.0, 0.0, 2.0]));
    let slopes = read(&profile, &units(&[Unit::Mm, Unit::Mrad])).unwrap();
    assert_eq!(slopes.slopes(), [0.001, 0.002, 0.004]);
    assert_eq!(slopes.points().nth(1), Some([1.0, 0.0, 0.0015]));
}

#[test]
fn a_pitch_makes_a_matrix_of_heights() {
    let array = doubles("(2, 3)", &[1.0, 2.0, f64::NAN, 4.0, 5.0, 6.0]);
    let options = TextOptions { pitch_mm: Some([0.5, 2.0]), ..units(&[Unit::Um]) };
    let Topography::Map(map, source) = read(&array, &options).unwrap() else { panic!("no map") };
    assert_eq!((map.nx, map.ny, map.dx_mm, map.dy_mm), (3, 2, 0.5, 2.0));
    assert_eq!(map.z_mm[..5], [0.004, 0.005, 0.006, 0.001, 0.002]);
    assert!(map.z_mm[5].is_nan() && source.format == Format::Npy);
    let error =
        message(&array, &TextOptions { pitch_mm: Some([1.0; 2]), ..TextOptions::default() });
    assert!(error.contains("add `--unit` with that of the heights"), "{error}");
    let infinite = doubles("(1, 2)", &[1.0, f64::INFINITY]);
    assert!(
        message(&infinite, &options).contains("row 1, column 2: expected a height in um, or NaN")
    );
    assert!(message(RECORDS, &options).contains("leave out `--pitch`"));
}

#[test]
fn columns_are_named_where_the_shape_does_not() {
    let wide = doubles("(1, 6)", &[9.0, 9.0, 1.0, 2.0, 3.0, 9.0]);
    let error = message(&wide, &TextOptions::default());
    assert!(error.contains("6 columns without names"), "{error}");
    let columns = [3, 4, 5].map(Column::Number).to_vec();
    let found = read(&wide, &TextOptions { columns, ..TextOptions::default() }).unwrap();
    assert_eq!(found.points().collect::<Vec<_>>(), [[1.0, 2.0, 3.0]]);
}

#[test]
fn gaps_are_counted_and_infinities_refused() {
    let gaps =
        doubles("(3, 3)", &[0.0, 0.0, f64::NAN, f64::NAN, f64::NAN, f64::NAN, 5.0, 5.0, 5.0]);
    let found = plain(&gaps).unwrap();
    assert_eq!((found.points().count(), found.missing()), (1, 2));
    let infinite = doubles("(1, 3)", &[0.0, 0.0, f64::NEG_INFINITY]);
    let error = message(&infinite, &TextOptions::default());
    assert!(error.starts_with("NumPy file, row 1, column 3: expected z in mm"), "{error}");
}

#[test]
fn every_type_of_number_is_read() {
    let cases: [(&str, &[u8], f64); 9] = [
        ("'|i1'", &[0xFE], -2.0),
        ("'|u1'", &[0xFE], 254.0),
        ("'>i2'", &[0xFF, 0x00], -256.0),
        ("'<u2'", &[0x01, 0xFF], 65281.0),
        ("'>i4'", &[0x80, 0, 0, 1], -2_147_483_647.0),
        ("'<u4'", &[0, 0, 0, 0x80], 2_147_483_648.0),
        ("'<i8'", &[0xFF; 8], -1.0),
        ("'>u8'", &[0, 0, 0, 0, 0, 0, 1, 0], 256.0),
        ("'>f4'", &[0xC0, 0x20, 0, 0], -2.5),
    ];
    for (descr, bytes, expected) in cases {
        assert_eq!(points(&file(descr, "(1, 3)", &bytes.repeat(3))), [[expected; 3]], "{descr}");
    }
}

#[test]
fn faults_are_named() {
    let plain = TextOptions::default();
    let cases = [
        (file("'<c16'", "(1, 3)", &[0; 48]), "an array of type <c16 is not supported"),
        (file("'|O'", "(1, 3)", &[]), "an array of Python objects is not supported"),
        (
            doubles("(3,)", &[0.0; 3]),
            "expected an array of two dimensions, as n × 3 for x, y, z, found (3)",
        ),
        (doubles("(1, 1, 3)", &[0.0; 3]), "found (1, 1, 3)"),
        (
            doubles("(2, 3)", &[0.0; 5]),
            "expected 48 bytes of numbers for the shape (2, 3), found 40, which is 5 whole items",
        ),
        (doubles("(1, 3)", &[0.0; 4]), "expected 24 bytes"),
        (doubles("(0, 3)", &[]), "expected at least one point, found (0, 3)"),
        (doubles("(4000000000, 3)", &[]), "expected at most 100000000 points, found 4000000000"),
        (doubles("(3, 18446744073709551615)", &[]), "expected more than 2⁶⁴ bytes"),
        (file("'<f8'", "3", &[]), "expected a dictionary of descr, fortran_order and shape"),
        (b"\x93NUMPY\x04\x00\x00\x00".to_vec(), "byte 6: expected version 1.0, 2.0 or 3.0"),
        (
            b"\x93NUMPY\x02\x00\xFF\xFF\xFF\xFF".to_vec(),
            "byte 12: expected a header of 4294967295 bytes, found 0 bytes",
        ),
        (file("[('x', '|V0')]", "(100000000,)", &[]), "expected"),
    ];
    for (file, expected) in cases {
        assert!(
            message(&file, &plain).contains(expected),
            "{expected}: {}",
            message(&file, &plain)
        );
    }
}

#[test]
fn damaged_files_are_refused_or_read_without_a_panic() {
    let options = units(&[Unit::Mm]);
    for file in [POINTS, FORTRAN, WHOLE, RECORDS] {
        hold_against_damage(file, |bytes| read(bytes, &options));
    }
    let options = TextOptions { pitch_mm: Some([1.0; 2]), ..options };
    hold_against_damage(WHOLE, |bytes| read(bytes, &options));
}

proptest! {
    #[test]
    fn points_come_back_bit_for_bit(
        written in prop::collection::vec(prop::array::uniform3(prop::num::f64::NORMAL), 1..40),
    ) {
        let bytes = doubles(&format!("({}, 3)", written.len()), &written.concat());
        prop_assert_eq!(points(&bytes), written);
    }

    #[test]
    fn random_headers_never_panic(text in "[\\[\\](){}',:a-zA-Z0-9<>| ]{0,80}", data in prop::collection::vec(any::<u8>(), 0..40)) {
        let _ = plain(&file(&text, "(2, 3)", &data));
        let _ = plain(&file("'<f8'", &text, &data));
    }
}

/// Written by NumPy 2.4.6: 3 × 3 as `<f8`, in the order of C.
const POINTS: &[u8] =
    b"\x93NUMPY\x01\0v\0{'descr': '<f8', 'fortran_order': False, 'shape': (3, 3), }               \
      \x20                                          \n\
      \0\0\0\0\0\0\0\0\0\0\0\0\0\0\xE0?\0\0\0\0\0\0\xF4?\0\0\0\0\0\0\0\xC0\0\0\0\0\0\0\x08@\x9A\
      \x99\x99\x99\x99\x99\xB9?\0\0\0\0\0\0\x10@\0\0\0\0\0\0\x14@\0\0\0\0\0\0\x18\xC0";

/// Written by NumPy 2.4.6: the same as `>f4`, in the order of Fortran.
const FORTRAN: &[u8] =
    b"\x93NUMPY\x01\0v\0{'descr': '>f4', 'fortran_order': True, 'shape': (3, 3), }                \
      \x20                                          \n\
      \0\0\0\0\xC0\0\0\0@\x80\0\0?\0\0\0@@\0\0@\xA0\0\0?\xA0\0\0=\xCC\xCC\xCD\xC0\xC0\0\0";

/// Written by NumPy 2.4.6: 2 × 4 as `<i2`.
const WHOLE: &[u8] =
    b"\x93NUMPY\x01\0v\0{'descr': '<i2', 'fortran_order': False, 'shape': (2, 4), }               \
      \x20                                          \n\
      \x01\0\x02\0\x03\0\x04\0\xFB\xFF\x06\0\x07\0\x08\0";

/// Written by NumPy 2.4.6: two records with fields `id`, `x`, `y`, `z_um`, `u_z`, aligned.
const RECORDS: &[u8] =
    b"\x93NUMPY\x01\0\xB6\0{'descr': [('id', '|u1'), ('', '|V7'), ('x', '<f8'), ('y', '<f4'), ('z_\
      um', '<i4'), ('u_z', '<f8')], 'fortran_order': False, 'shape': (2,), }                      \
      \x20                 \n\
      \x09\0\0\0\0\0\0\0\0\0\0\0\0\0\xF0?\0\0\0?\x18\xFC\xFF\xFF\xF1h\xE3\x88\xB5\xF8\xE4>\x09\0\0\
      \0\0\0\0\0\0\0\0\0\0\0\0@\0\0\x80>\xD0\x07\0\0\xF1h\xE3\x88\xB5\xF8\xF4>";
