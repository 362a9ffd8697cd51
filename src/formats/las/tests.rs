use proptest::prelude::*;

use super::*;
use crate::test_data::hold_against_damage;
use crate::xyz::Unit;

fn in_metres(bytes: &[u8]) -> Result<Topography, ReadError> {
    read(bytes, &TextOptions { units: vec![Unit::M], ..TextOptions::default() })
}

fn message(bytes: &[u8]) -> String {
    in_metres(bytes).unwrap_err().to_string()
}

/// A file with some bytes changed.
fn changed(file: &[u8], at: usize, bytes: &[u8]) -> Vec<u8> {
    let mut file = file.to_vec();
    file[at..at + bytes.len()].copy_from_slice(bytes);
    file
}

#[test]
fn files_of_another_program_are_read_with_scale_and_offset() {
    for file in [LAS_0, LAS_6] {
        let topography = in_metres(file).unwrap();
        assert_eq!((topography.missing(), topography.source().format), (1, Format::Las));
        let found: Vec<_> = topography.points().collect();
        let expected = [[500.0, 0.0, -1000.0], [520.0, 20.0, -998.0]];
        for (found, expected) in found.iter().flatten().zip(expected.iter().flatten()) {
            assert!((found - expected).abs() < 1e-9, "{found} {expected}");
        }
        assert_eq!(found.len(), 2);
    }
}

#[test]
fn packed_points_are_the_same() {
    for (packed, plain) in [(LAZ_0, LAS_0), (LAZ_6, LAS_6)] {
        assert_eq!(in_metres(packed), in_metres(plain));
    }
}

#[test]
fn faults_of_packed_files_are_named() {
    let table = LAZ_0.len() as u64 - 8;
    let cases = [
        (changed(LAZ_0, 107, &[4]), "expected 4 packed points in the chunks from here on, found"),
        (changed(LAZ_0, 107, &[2]), "expected no bytes after 2 packed points"),
        (changed(LAZ_0, 107, &[0, 0, 0, 1]), "expected room for 16777216 points"),
        (
            changed(LAZ_0, 229, b"X"),
            "expected a record \"laszip encoded\" before compressed points, found none",
        ),
        (changed(LAZ_0, 227 + 54, &[9]), "is not supported, expected points packed by LASzip 2"),
        (
            changed(LAZ_0, 227 + 54 + 38, &[1]),
            "an old or unknown version of LASzip is not supported",
        ),
        (changed(LAZ_0, 227 + 54 + 34, &[7]), "is not supported"),
        (LAZ_0[..table as usize].to_vec(), "expected a table of chunks within"),
        // The first layer claims 4 GB.
        (changed(LAZ_6, layers_of(LAZ_6), &[0xFF; 4]), "expected a chunk of packed points"),
    ];
    for (file, expected) in cases {
        assert!(message(&file).contains(expected), "{expected}: {}", message(&file));
    }
}

/// Where the sizes of the layers begin in a file of format 6: after the place of the table, a point and the number of points.
fn layers_of(file: &[u8]) -> usize {
    let start = u32::from_le_bytes(*file[96..].first_chunk().unwrap());
    start as usize + 8 + 30 + 4
}

#[test]
fn without_a_unit_nothing_is_assumed() {
    let error = read(LAS_0, &TextOptions::default()).unwrap_err().to_string();
    assert!(error.contains("may be metres, feet or anything else"), "{error}");
    assert!(error.contains("add `--unit` with"), "{error}");
}

#[test]
fn faults_are_named_with_their_byte() {
    let cases = [
        (changed(LAS_0, 0, b"LASX"), "byte 0: expected LASF"),
        (changed(LAS_0, 24, &[2, 0]), "byte 24: version 2.0 is not supported"),
        (
            changed(LAS_0, 24, &[1, 4]),
            "byte 94: expected a header of at least 375 bytes, found 227",
        ),
        (changed(LAS_0, 96, &[9, 0, 0, 0]), "byte 96: expected points that begin after"),
        (changed(LAS_0, 104, &[11]), "byte 104: expected a format of points from 0 to 10"),
        (
            changed(LAS_0, 105, &[19, 0]),
            "byte 105: expected points of at least 20 bytes, of format 0",
        ),
        (changed(LAS_0, 107, &[4]), "byte 227: expected 4 points of 20 bytes, found 3"),
        (changed(LAS_0, 107, &[0]), "expected at least one point, found none"),
        (changed(LAS_0, 107, &[0xFF; 4]), "byte 107: expected at most 100000000 points"),
        (changed(LAS_6, 247, &[0xFF; 8]), "byte 247: expected at most 100000000 points"),
        (changed(LAS_0, 139, &[0; 8]), "byte 131: expected scales other than 0"),
        (changed(LAS_0, 155, &f64::NAN.to_le_bytes()), "byte 155: expected three finite numbers"),
        (changed(LAS_0, 131, &f64::MAX.to_le_bytes()), "byte 267: expected finite coordinates"),
        (LAS_0[..286].to_vec(), "byte 227: expected 3 points of 20 bytes, found 2"),
        (LAS_0[..200].to_vec(), "byte 227: expected 3 points of 20 bytes, found 0"),
    ];
    for (file, expected) in cases {
        assert!(message(&file).contains(expected), "{expected}: {}", message(&file));
    }
}

#[test]
fn the_mark_of_withheld_points_came_with_1_1() {
    let old = changed(LAS_0, 25, &[0]);
    assert_eq!(in_metres(&old).unwrap().missing(), 0);
    // The long count of 1.4 may be 0 in files of old formats; then the short one counts.
    let short = changed(&changed(LAS_6, 247, &[0]), 107, &[3]);
    assert_eq!(in_metres(&short).unwrap().points().count(), 2);
}

#[test]
fn damaged_files_are_refused_or_read_without_a_panic() {
    hold_against_damage(LAS_0, in_metres);
    hold_against_damage(LAS_6, in_metres);
    hold_against_damage(LAZ_0, in_metres);
    hold_against_damage(LAZ_6, in_metres);
}

proptest! {
    #[test]
    fn coordinates_are_number_times_scale_plus_offset(
        numbers in prop::collection::vec(prop::array::uniform3(any::<i32>()), 1..20),
        scales in prop::array::uniform3(1e-9..1.0_f64),
        offsets in prop::array::uniform3(-1e6..1e6_f64),
    ) {
        let mut file = LAS_0[..227].to_vec();
        file[107..111].copy_from_slice(&(numbers.len() as u32).to_le_bytes());
        for (index, value) in [scales, offsets].concat().iter().enumerate() {
            file[131 + 8 * index..][..8].copy_from_slice(&value.to_le_bytes());
        }
        for point in &numbers {
            file.extend(point.iter().flat_map(|number| number.to_le_bytes()));
            file.extend([0; 8]);
        }
        let options = TextOptions { units: vec![Unit::Mm], ..TextOptions::default() };
        let found: Vec<_> = read(&file, &options).unwrap().points().collect();
        let expected: Vec<[f64; 3]> = numbers
            .iter()
            .map(|point| [0, 1, 2].map(|axis| f64::from(point[axis]) * scales[axis] + offsets[axis]))
            .collect();
        prop_assert_eq!(found, expected);
    }
}

/// Written by laspy 2.7.0: version 1.2, points of format 0, the second one withheld.
const LAS_0: &[u8] =
    b"LASF\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\x01\x02OTHER\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\
      \0\0\0\0\0\0\0\0\0\0laspy 2.7.0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0G\x01\xEA\x07\xE3\0\
      \xE3\0\0\0\0\0\0\0\0\x14\0\x03\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\x8D\xED\xB5\xA0\
      \xF7\xC6\xB0>\x8D\xED\xB5\xA0\xF7\xC6\xB0>\x8D\xED\xB5\xA0\xF7\xC6\xB0>\0\0\0\0\0\0\xE0?\0\0\
      \0\0\0\0\0\0\0\0\0\0\0\0\xF0\xBF\xA4p=\n\
      \xD7\xA3\xE0?\0\0\0\0\0\0\xE0?{\x14\xAEG\xE1z\x94?\0\0\0\0\0\0\0\0V\x0E-\xB2\x9D\xEF\xEF\xBF\
      \0\0\0\0\0\0\xF0\xBF\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\x10'\0\0\x10'\0\0\xE8\x03\0\0\0\
      \0\0\x80\0\0\0\0 N\0\0 N\0\0\xD0\x07\0\0\0\0\0\0\0\0\0\0";

/// Written by laspy 2.7.0: version 1.4, points of format 6, the second one withheld.
const LAS_6: &[u8] =
    b"LASF\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\x01\x04OTHER\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\
      \0\0\0\0\0\0\0\0\0\0laspy 2.7.0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0G\x01\xEA\x07w\x01w\
      \x01\0\0\0\0\0\0\x06\x1E\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\x8D\xED\xB5\xA0\
      \xF7\xC6\xB0>\x8D\xED\xB5\xA0\xF7\xC6\xB0>\x8D\xED\xB5\xA0\xF7\xC6\xB0>\0\0\0\0\0\0\xE0?\0\0\
      \0\0\0\0\0\0\0\0\0\0\0\0\xF0\xBF\xA4p=\n\
      \xD7\xA3\xE0?\0\0\0\0\0\0\xE0?{\x14\xAEG\xE1z\x94?\0\0\0\0\0\0\0\0V\x0E-\xB2\x9D\xEF\xEF\xBF\
      \0\0\0\0\0\0\xF0\xBF\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\x03\0\0\0\0\0\0\0\0\0\0\0\0\0\0\
      \0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\
      \0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\
      \0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\
      \0\0\0\0\0\x10'\0\0\x10'\0\0\xE8\x03\0\0\0\0\0\x04\0\0\0\0\0\0\0\0\0\0\0\0\0\0 N\0\0 N\0\0\
      \xD0\x07\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0";

/// Written by laspy 2.7.0 with lazrs 0.8.2: the same, compressed.
const LAZ_0: &[u8] =
    b"LASF\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\x01\x02OTHER\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\
      \0\0\0\0\0\0\0\0\0\0laspy 2.7.0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0G\x01\xEA\x07\xE3\0\
      A\x01\0\0\x01\0\0\0\x80\x14\0\x03\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\x8D\xED\xB5\
      \xA0\xF7\xC6\xB0>\x8D\xED\xB5\xA0\xF7\xC6\xB0>\x8D\xED\xB5\xA0\xF7\xC6\xB0>\0\0\0\0\0\0\xE0?\
      \0\0\0\0\0\0\0\0\0\0\0\0\0\0\xF0\xBF\xA4p=\n\
      \xD7\xA3\xE0?\0\0\0\0\0\0\xE0?{\x14\xAEG\xE1z\x94?\0\0\0\0\0\0\0\0V\x0E-\xB2\x9D\xEF\xEF\xBF\
      \0\0\0\0\0\0\xF0\xBF\0\0laszip encoded\0\0\xBCV(\0http://laszip.org\0\0\0\0\0\0\0\0\0\0\0\0\
      \0\0\0\x02\0\0\0\x02\x02\0\0\0\0\0\0P\xC3\0\0\xFF\xFF\xFF\xFF\xFF\xFF\xFF\xFF\xFF\xFF\xFF\
      \xFF\xFF\xFF\xFF\xFF\x01\0\x06\0\x14\0\x02\0q\x01\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\
      \0\0\0\0\0\"\x01u\x1F\x9E\xDC\x80\x17\xC1f\x13\x9F\xFE\x17\xC2Z(\0\0\0\0\0\0\0\x01\0\0\x003D\0\
      \0\0";

/// Written by laspy 2.7.0 with lazrs 0.8.2: the same, compressed.
const LAZ_6: &[u8] =
    b"LASF\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\x01\x04OTHER\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\
      \0\0\0\0\0\0\0\0\0\0laspy 2.7.0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0G\x01\xEA\x07w\x01\
      \xD5\x01\0\0\x01\0\0\0\x86\x1E\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\x8D\xED\xB5\
      \xA0\xF7\xC6\xB0>\x8D\xED\xB5\xA0\xF7\xC6\xB0>\x8D\xED\xB5\xA0\xF7\xC6\xB0>\0\0\0\0\0\0\xE0?\
      \0\0\0\0\0\0\0\0\0\0\0\0\0\0\xF0\xBF\xA4p=\n\
      \xD7\xA3\xE0?\0\0\0\0\0\0\xE0?{\x14\xAEG\xE1z\x94?\0\0\0\0\0\0\0\0V\x0E-\xB2\x9D\xEF\xEF\xBF\
      \0\0\0\0\0\0\xF0\xBF\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\x03\0\0\0\0\0\0\0\0\0\0\0\0\0\0\
      \0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\
      \0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\
      \0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0laszip encoded\0\0\xBCV(\0http://laszip.org\0\
      \0\0\0\0\0\0\0\0\0\0\0\0\0\0\x03\0\0\0\x02\x02\0\0\0\0\0\0P\xC3\0\0\xFF\xFF\xFF\xFF\xFF\xFF\
      \xFF\xFF\xFF\xFF\xFF\xFF\xFF\xFF\xFF\xFF\x01\0\n\
      \0\x1E\0\x03\0>\x02\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\
      \x03\0\0\0\x0F\0\0\0\x07\0\0\0\0\0\0\0\x05\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\
      \xE2spr\x8A\xA4\xA5\xD0\xAFa\xCA\0\0\0U#\x84\xCC\0\0\0\x10\0\0\0\0\0\0\0\0\x01\0\0\0<\x1E\0\
      \0\0";
