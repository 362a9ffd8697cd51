use proptest::prelude::*;

use super::*;
use crate::test_data::hold_against_damage;
use crate::xyz::{By, TextOptions, Unit};
use crate::{Format, ReadError, Topography};

fn points(bytes: &[u8]) -> Vec<[f64; 3]> {
    let topography = crate::read("a", bytes).unwrap();
    assert_eq!(topography.source().format, Format::Ply);
    topography.points().collect()
}

fn with_units(bytes: &[u8], units: &[Unit]) -> Result<Topography, ReadError> {
    read(bytes, &TextOptions { units: units.to_vec(), ..TextOptions::default() })
}

fn message(bytes: &[u8]) -> String {
    with_units(bytes, &[]).unwrap_err().to_string()
}

/// A file of one element vertex with the given lines of properties and content.
fn ascii(head: &str, body: &str) -> Vec<u8> {
    format!("ply\nformat ascii 1.0\n{head}\nend_header\n{body}").into_bytes()
}

const XYZ: &str = "property float x\nproperty float y\nproperty float z";

#[test]
fn files_of_other_programs_are_read_in_every_encoding() {
    let expected = [[0.0, 0.5, 1.25], [-2.0, 3.0, 0.1], [4.0, 5.0, -6.0]];
    for file in [ASCII, LITTLE, BIG] {
        assert_eq!(points(file), expected);
    }
    let taken = crate::read("a", BIG).unwrap().source().taken.clone().unwrap();
    assert_eq!((taken.units_by, taken.columns[0].number), (By::Default, 2));
    let expected = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.5], [0.0, 1.0, 0.25], [1.0, 1.0, -2.0]];
    assert_eq!(points(TRIMESH), expected);
}

#[test]
fn what_is_written_here_is_read_back_in_mm() {
    let points_mm = [[0.1, 0.2, 1.0 / 3.0], [1e-300, -0.0, 5.0], [7.0, 8.0, 9.0]];
    let scalar = [1.0, f64::NAN, 3.0];
    let mut file = Vec::new();
    let comments =
        ["coordinates in mm, measured frame", "deviation in nm, nan where there is none"];
    write_mesh(
        &mut file,
        &points_mm,
        &[[0, 1, 2]],
        Some(("scalar_deviation_nm", &scalar)),
        &comments,
    )
    .unwrap();
    let topography = with_units(&file, &[]).unwrap();
    assert_eq!(topography.points().collect::<Vec<_>>(), points_mm);
    assert_eq!(topography.source().taken.as_ref().unwrap().units_by, By::Head);
    assert!(with_units(&file, &[Unit::Mm]).is_ok());
    let error = with_units(&file, &[Unit::Um]).unwrap_err().to_string();
    assert!(error.contains("lengths are in mm, and `--unit` says um: leave"), "{error}");
}

#[test]
fn units_come_from_options_or_comments() {
    let file = ascii(&format!("element vertex 1\n{XYZ}"), "1 2 3\n");
    let topography = with_units(&file, &[Unit::Mm, Unit::Mm, Unit::Um]).unwrap();
    assert_eq!(topography.points().next(), Some([1.0, 2.0, 0.003]));
    let stated = ascii(&format!("comment units: m\nelement vertex 1\n{XYZ}"), "1 2 3\n");
    assert_eq!(points(&stated), [[1e3, 2e3, 3e3]]);
    let twice = ascii(
        &format!("comment units: m\ncomment x y z in um\nelement vertex 1\n{XYZ}"),
        "1 2 3\n",
    );
    assert!(
        message(&twice).contains("line 4: expected one unit of lengths"),
        "{}",
        message(&twice)
    );
}

#[test]
fn gaps_are_counted_and_all_line_endings_are_read() {
    let text = format!("element vertex 3\n{XYZ}");
    let file = ascii(&text, "0 0 nan\n 1 2\t3 \n\n4 NaN 6\n");
    let topography = with_units(&file, &[]).unwrap();
    assert_eq!((topography.points().count(), topography.missing()), (1, 2));
    for ending in ["\r", "\r\n"] {
        let file = String::from_utf8(file.clone()).unwrap().replace('\n', ending);
        assert_eq!(points(file.as_bytes()), [[1.0, 2.0, 3.0]]);
    }
    let infinite = ascii(&format!("element vertex 1\n{XYZ}"), "0 0 inf\n");
    assert!(
        message(&infinite).contains("line 8: expected finite coordinates"),
        "{}",
        message(&infinite)
    );
}

#[test]
fn faults_are_named_with_their_place() {
    let cases = [
        (ascii("element face 0", ""), "line 4: expected an element vertex, found none"),
        (ascii("element vertex 1\nproperty float x\nproperty float y", "0 0\n"), "one property z"),
        (ascii(&format!("element vertex 1\n{XYZ}\nproperty int x"), "0 0 0 0\n"), "one property x"),
        (
            ascii(&format!("element vertex 2\n{XYZ}"), "0 0 0\n1 1"),
            "expected 2 of element vertex, found the end of the file in number 2",
        ),
        (
            ascii(&format!("element vertex 1\n{XYZ}"), "0 0 1"),
            "expected a line end after the last number",
        ),
        (
            ascii(&format!("element vertex 1\n{XYZ}"), "0 0 zwei\n"),
            "line 8: expected a number, found \"zwei\"",
        ),
        (ascii(&format!("element vertex 0\n{XYZ}"), ""), "expected at least one point"),
        (
            ascii(&format!("element vertex 200000000\n{XYZ}"), ""),
            "expected at most 100000000 points",
        ),
        (ascii(&format!("element vertex -1\n{XYZ}"), ""), "line 3: expected element NAME COUNT"),
        (ascii("property float x", ""), "line 3: expected property TYPE NAME"),
        (ascii("element vertex 1\nproperty half x", ""), "line 4: expected property TYPE NAME"),
        (b"ply\nelement vertex 0\nend_header\n".to_vec(), "expected format ascii 1.0"),
        (b"ply\nformat ascii 2.0\n".to_vec(), "line 2: expected format ascii 1.0"),
        (b"ply\nformat ascii 1.0\n".to_vec(), "line 3: expected a line end_header"),
    ];
    for (file, expected) in cases {
        assert!(message(&file).contains(expected), "{}", message(&file));
    }
    let end = message(&LITTLE[..LITTLE.len() - 60]);
    assert!(end.contains("byte") && end.contains("expected 3 of element vertex"), "{end}");
}

/// As points and as a mesh.
fn both(bytes: &[u8]) -> [Option<String>; 2] {
    let mesh = read_triangles(bytes, &TextOptions::default());
    [with_units(bytes, &[]).map(|_| ()), mesh.map(|_| ())]
        .map(|found| found.err().map(|error| error.to_string()))
}

#[test]
fn a_wrong_count_or_property_of_text_is_named_with_its_line() {
    let faces = "property list uchar int vertex_indices";
    let rows = "0 0 0\n1 0 0\n1 1 0\n\n0 1 0\n3 0 1 2\n3 2 3 0\n";
    let file = |vertices: usize, count: usize, more: &str| {
        ascii(
            &format!("element vertex {vertices}\n{XYZ}{more}\nelement face {count}\n{faces}"),
            rows,
        )
    };
    assert_eq!(both(&file(4, 2, "")), [None, None]);
    let said = |bytes: &[u8], expected: &str| {
        for said in both(bytes) {
            let said = said.expect(expected);
            assert!(said.contains(expected), "{expected}: {said}");
        }
    };
    said(
        &file(5, 2, ""),
        "PLY file, line 15: expected 3 numbers in row 5 of 5 of element vertex, found 4: a count or a property in the header may be wrong",
    );
    said(&file(3, 2, ""), "line 14: expected 1 numbers in row 1 of 2 of element face, found 3");
    said(
        &file(4, 1, ""),
        "line 16: expected the end of the file after 1 of element face, found \"3 2 3 0\": a count",
    );
    said(&file(4, 3, ""), "expected 3 of element face, found the end of the file in number 3");
    said(
        &file(4, 2, "\nproperty float q"),
        "line 11: expected 4 numbers in row 1 of 4 of element vertex, found 3",
    );
    let points = ascii(&format!("element vertex 2\n{XYZ}"), "0 0 0\n1 0 0\n1 1 0\n");
    let expected =
        "line 10: expected the end of the file after 2 of element vertex, found \"1 1 0\"";
    assert!(message(&points).contains(expected), "{}", message(&points));
}

#[test]
fn bytes_behind_the_last_element_are_refused() {
    for file in [LITTLE, BIG, TRIMESH] {
        assert_eq!(both(file), [None, None]);
        let longer = [file, &b"abc"[..]].concat();
        for said in both(&longer) {
            let said = said.unwrap();
            let place =
                format!("PLY file, byte {}: expected the end of the file after", file.len());
            assert!(said.starts_with(&place) && said.contains("found 3 more bytes"), "{said}");
        }
        let [points, mesh] = both(&file[..file.len() - 1]);
        assert!(points.is_some() && points == mesh, "{points:?}");
    }
}

#[test]
fn claimed_sizes_cost_nothing() {
    let many =
        "element empty 18446744073709551615\nelement wide 18446744073709551615\nproperty double a";
    for encoding in ["ascii", "binary_big_endian"] {
        let file = format!(
            "ply\nformat {encoding} 1.0\n{many}\nelement vertex 1\n{XYZ}\nend_header\n1 2 3\n"
        );
        assert!(
            message(file.as_bytes()).contains("of element wide"),
            "{}",
            message(file.as_bytes())
        );
    }
    let list = "ply\nformat binary_little_endian 1.0\nelement a 1\nproperty list uint double l\nelement vertex 1\n";
    let mut file = format!("{list}{XYZ}\nend_header\n").into_bytes();
    file.extend([0xFF; 16]);
    assert!(message(&file).contains("expected 1 of element a"), "{}", message(&file));
}

#[test]
fn damaged_files_are_refused_or_read_without_a_panic() {
    for file in [ASCII, LITTLE, BIG, TRIMESH] {
        hold_against_damage(file, |bytes| with_units(bytes, &[]));
    }
}

proptest! {
    #[test]
    fn points_come_back_bit_for_bit(
        written in prop::collection::vec(prop::array::uniform3(prop::num::f64::NORMAL), 1..40),
    ) {
        let lines: String = written.iter().map(|[x, y, z]| format!("{x:e} {y:e} {z:e}\n")).collect();
        let properties = XYZ.replace("float", "double");
        let file = ascii(&format!("element vertex {}\n{properties}", written.len()), &lines);
        prop_assert_eq!(&points(&file), &written);
        let mut file = Vec::new();
        write_mesh(&mut file, &written, &[], None, &[]).unwrap();
        prop_assert_eq!(&points(&file), &written);
    }

    #[test]
    fn random_bytes_after_a_header_never_panic(
        kinds in prop::collection::vec(prop::sample::select(vec!["char", "ushort", "int", "float", "double", "list uchar int", "list int double"]), 0..5),
        encoding in prop::sample::select(vec!["ascii", "binary_little_endian", "binary_big_endian"]),
        body in prop::collection::vec(any::<u8>(), 0..200),
    ) {
        let more: String = kinds.iter().map(|kind| format!("property {kind} p\n")).collect();
        let head = format!("ply\nformat {encoding} 1.0\nelement a 2\n{more}element vertex 3\n{more}{XYZ}\nend_header\n");
        let _ = with_units(&[head.as_bytes(), &body].concat(), &[]);
    }
}

/// Written by plyfile 1.1.5: lists and a number before the vertices, other properties among theirs, faces after.
const ASCII: &[u8] = b"ply\n\
      format ascii 1.0\n\
      comment made by plyfile\n\
      element camera 1\n\
      property list uchar ushort l\n\
      property float g\n\
      element vertex 3\n\
      property uchar q\n\
      property double x\n\
      property float y\n\
      property double z\n\
      property uchar red\n\
      element face 1\n\
      property list uchar int vertex_indices\n\
      property short k\n\
      end_header\n\
      2 1 2 3\n\
      1 0 0.5 1.25 200\n\
      1 -2 3 0.100000000000000006 200\n\
      1 4 5 -6 200\n\
      3 0 1 2 7\n";

/// Written by plyfile 1.1.5: lists and a number before the vertices, other properties among theirs, faces after.
const LITTLE: &[u8] = b"ply\n\
      format binary_little_endian 1.0\n\
      comment made by plyfile\n\
      element camera 1\n\
      property list uchar ushort l\n\
      property float g\n\
      element vertex 3\n\
      property uchar q\n\
      property double x\n\
      property float y\n\
      property double z\n\
      property uchar red\n\
      element face 1\n\
      property list uchar int vertex_indices\n\
      property short k\n\
      end_header\n\
      \x02\x01\0\x02\0\0\0@@\x01\0\0\0\0\0\0\0\0\0\0\0?\0\0\0\0\0\0\xF4?\xC8\x01\0\0\0\0\0\0\0\xC0\
      \0\0@@\x9A\x99\x99\x99\x99\x99\xB9?\xC8\x01\0\0\0\0\0\0\x10@\0\0\xA0@\0\0\0\0\0\0\x18\xC0\
      \xC8\x03\0\0\0\0\x01\0\0\0\x02\0\0\0\x07\0";

/// Written by plyfile 1.1.5: lists and a number before the vertices, other properties among theirs, faces after.
const BIG: &[u8] = b"ply\n\
      format binary_big_endian 1.0\n\
      comment made by plyfile\n\
      element camera 1\n\
      property list uchar ushort l\n\
      property float g\n\
      element vertex 3\n\
      property uchar q\n\
      property double x\n\
      property float y\n\
      property double z\n\
      property uchar red\n\
      element face 1\n\
      property list uchar int vertex_indices\n\
      property short k\n\
      end_header\n\
      \x02\0\x01\0\x02\0\0@@\x01\0\0\0\0\0\0\0\0?\0\0\0?\xF4\0\0\0\0\0\0\xC8\x01\xC0\0\0\0\0\0\0\0\
      @@\0\0?\xB9\x99\x99\x99\x99\x99\x9A\xC8\x01@\x10\0\0\0\0\0\0@\xA0\0\0\xC0\x18\0\0\0\0\0\0\
      \xC8\x03\0\0\0\0\0\0\0\x01\0\0\0\x02\x07\0";

/// Written by trimesh 5.2.0: two triangles that share an edge.
const TRIMESH: &[u8] = b"ply\n\
      format binary_little_endian 1.0\n\
      comment https://github.com/mikedh/trimesh\n\
      element vertex 4\n\
      property float x\n\
      property float y\n\
      property float z\n\
      element face 2\n\
      property list uchar int vertex_indices\n\
      end_header\n\
      \0\0\0\0\0\0\0\0\0\0\0\0\0\0\x80?\0\0\0\0\0\0\0?\0\0\0\0\0\0\x80?\0\0\x80>\0\0\x80?\0\0\x80?\
      \0\0\0\xC0\x03\0\0\0\0\x01\0\0\0\x02\0\0\0\x03\x01\0\0\0\x03\0\0\0\x02\0\0\0";
