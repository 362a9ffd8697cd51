use proptest::prelude::*;

use super::*;
use crate::test_data::hold_against_changes;
use crate::xyz::{By, Unit};

fn plain(bytes: &[u8]) -> Result<Topography, ReadError> {
    read(bytes, &TextOptions::default())
}

fn points(bytes: &[u8]) -> Vec<[f64; 3]> {
    plain(bytes).unwrap().points().collect()
}

fn message(bytes: &[u8]) -> String {
    plain(bytes).unwrap_err().to_string()
}

#[test]
fn a_file_of_another_program_is_read() {
    let expected = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.5], [0.0, 1.0, 0.25], [1.0, 1.0, -2.0]];
    let topography = crate::read("a", TRIMESH).unwrap();
    assert_eq!(topography.points().collect::<Vec<_>>(), expected);
    let source = topography.source();
    assert_eq!(
        (source.format, source.taken.as_ref().unwrap().units_by),
        (Format::Obj, By::Default)
    );
    let options = TextOptions { units: vec![Unit::Um], ..TextOptions::default() };
    assert_eq!(read(TRIMESH, &options).unwrap().points().nth(1), Some([1e-3, 0.0, 5e-4]));
}

#[test]
fn vertices_are_told_from_everything_else() {
    let file = b"\xEF\xBB\xBF# v 9 9 9\r\nmtllib a b.mtl\r\no v\r\n\r\nv 1 2 3 1.0 # w\r\nvt 0 0\r\nvn 0 0 1\r\nvp 1\r\n \
        v\t4 \\\r\n  5 6 0.5 0.5 0.5\r\nusemtl x\r\nf 1//1 2//1 1//1\r\nl 1 2\r\nv 7 nan 9";
    let topography = crate::read("a", file).unwrap();
    assert_eq!(topography.points().collect::<Vec<_>>(), [[1.0, 2.0, 3.0], [4.0, 5.0, 6.0]]);
    assert_eq!((topography.missing(), topography.source().format), (1, Format::Obj));
}

#[test]
fn faults_are_named_with_their_line() {
    assert_eq!(
        message(b"v 0 0 0\nv 1 2 # 3\n"),
        "OBJ file, line 2: expected v and three numbers, found \"v 1 2\""
    );
    assert!(message(b"v 0 0 0\nv 1 \\\n 2 x\nv 1 1 1\n").contains("line 2: expected v and three"));
    assert!(message(b"v 0 0 0\n\nv 1 2 inf\n").contains("line 3: expected finite coordinates"));
    assert!(message(b"vn 0 0 1\n").contains("line 2: expected at least one point, found none"));
    assert!(message(b"v 1 \\").contains("line 1: expected v and three"));
}

#[test]
fn cut_files_are_refused_or_give_the_vertices_before_the_cut() {
    let all = points(TRIMESH);
    for len in 0..TRIMESH.len() {
        if let Ok(found) = plain(&TRIMESH[..len]) {
            let found: Vec<_> = found.points().collect();
            // The last number may have lost digits.
            let whole = found.len() - 1;
            assert_eq!(found[..whole], all[..whole], "{len}");
        }
    }
    hold_against_changes(TRIMESH, plain);
}

/// Every line that goes on was once copied with all before it.
#[test]
fn a_line_that_goes_on_for_ever_is_read_in_one_pass() {
    let file = "v \\\n".repeat(300_000) + "1 2 3\n";
    assert!(message(file.as_bytes()).contains("line 1: expected v and three numbers"));
    let file = "v ".to_owned() + &"\\\n".repeat(300_000) + "1 2 3\n";
    assert_eq!(plain(file.as_bytes()).unwrap().points().next(), Some([1.0, 2.0, 3.0]));
}

proptest! {
    #[test]
    fn vertices_come_back_bit_for_bit(
        written in prop::collection::vec(prop::array::uniform3(prop::num::f64::NORMAL), 1..40),
    ) {
        let text: String = written.iter().map(|[x, y, z]| format!("v {x:e} {y:e} {z:e}\nvn 0 0 1\n")).collect();
        prop_assert_eq!(points(text.as_bytes()), written);
    }

    #[test]
    fn random_text_never_panics(text in "(v |vn |#|\\\\\n|[0-9. -]{0,9}|\n){0,40}") {
        let _ = plain(text.as_bytes());
        let _ = is_obj(text.as_bytes());
    }
}

/// Written by trimesh 5.2.0: two triangles that share an edge.
const TRIMESH: &[u8] = b"# https://github.com/mikedh/trimesh\n\
      v 0.00000000 0.00000000 0.00000000\n\
      v 1.00000000 0.00000000 0.50000000\n\
      v 0.00000000 1.00000000 0.25000000\n\
      v 1.00000000 1.00000000 -2.00000000\n\
      f 1 2 3\n\
      f 2 4 3\n\
      \n";
