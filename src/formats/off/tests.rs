use proptest::prelude::*;

use super::*;
use crate::test_data::hold_against_changes;
use crate::xyz::Unit;

fn points(bytes: &[u8]) -> Vec<[f64; 3]> {
    crate::read("a", bytes).unwrap().points().collect()
}

fn message(bytes: &[u8]) -> String {
    read(bytes, &TextOptions::default()).unwrap_err().to_string()
}

#[test]
fn the_cube_of_the_manual_is_read() {
    let found = points(CUBE);
    assert_eq!(found.len(), 8);
    assert_eq!((found[4], found[7]), ([1.0, 0.0, 0.0], [0.0, -1.0, 0.0]));
    assert_eq!(crate::read("a", CUBE).unwrap().source().format, Format::Off);
    let options = TextOptions { units: vec![Unit::Um], ..TextOptions::default() };
    assert_eq!(read(CUBE, &options).unwrap().points().nth(7), Some([0.0, -1e-3, 0.0]));
}

#[test]
fn the_numbers_may_follow_the_word_and_colours_the_vertices() {
    let expected = [[1.0, 2.0, 3.0], [4.0, 5.0, 6.0]];
    assert_eq!(points(b"OFF 2 0 0\n1 2 3\n4 5 6\n"), expected);
    assert_eq!(points(b"# by hand\nCOFF\r\n2 0\r\n1 2 3 255 0 0\r\n\r\n4 5 6 0 0 255"), expected);
    assert_eq!(points(b"STCNOFF\n2 1 0\n1 2 3 0 0 1\n4 5 6 0 0 1\n3 0 1 1\n"), expected);
}

#[test]
fn gaps_are_counted() {
    let found = crate::read("a.off", b"OFF\n2 0 0\n1 2 nan\n4 5 6\n").unwrap();
    assert_eq!((found.points().count(), found.missing()), (1, 1));
}

#[test]
fn faults_are_named_with_their_line() {
    assert_eq!(
        message(b"OFF\n2 0 0\n1 2 3\n4 5\n"),
        "OFF file, line 4: expected x y z of vertex 2 of 2, found \"4 5\""
    );
    assert!(
        message(b"OFF\n3 0 0\n1 2 3\n")
            .contains("expected 3 vertices, found the end of the file after 1")
    );
    assert!(message(b"OFF\n").contains("expected the numbers of vertices, faces and edges"));
    assert!(message(b"OFF\n1 2 3 4\n").contains("line 2: expected the numbers"));
    assert!(message(b"OFF\n0 0 0\n").contains("expected at least one point"));
    assert!(message(b"OFF\n1 0 0\n1 2 inf\n").contains("line 3: expected finite coordinates"));
    assert!(message(b"4OFF\n1 0 0\n1 2 3 1\n").contains("three coordinates a vertex"));
    assert!(message(b"OFF BINARY\n\0\0").contains("OFF as text"));
    assert!(message(b"OFF\n99999999999 0 0\n").contains("99999999999"));
    let named = crate::read("a.off", b"1 2 3\n").unwrap_err().to_string();
    assert!(named.contains("expected OFF, alone or with the numbers"), "{named}");
}

/// As points and as a mesh: a wrong number of vertices makes points of faces.
#[test]
fn files_that_go_on_or_end_early_are_refused() {
    let vertices = "0 0 0\n1 0 0\n1 1 0\n0 1 0\n";
    let file = |counts: &str| format!("OFF\n{counts} 0\n{vertices}3 0 1 2\n# more\n3 2 3 0\n");
    let both = |counts: &str| {
        let text = file(counts);
        let mesh = read_triangles(text.as_bytes(), &TextOptions::default()).map(|_| ());
        [message(text.as_bytes()), mesh.unwrap_err().to_string()]
    };
    assert_eq!(points(file("4 2").as_bytes()).len(), 4);
    let more = both("4 1");
    assert_eq!(more[0], more[1]);
    assert_eq!(
        more[0],
        "OFF file, line 9: expected the end of the file after 4 vertices and 1 faces, found \"3 2 3 0\": \
         the numbers in the header may be wrong"
    );
    assert!(both("5 2").iter().all(|said| said.contains("expected 2 faces, found the end of")));
    assert!(both("3 2").iter().all(|said| said.contains("line 9: expected the end of the file")));
}

#[test]
fn changed_files_never_panic() {
    hold_against_changes(CUBE, |bytes| read(bytes, &TextOptions::default()));
}

proptest! {
    #[test]
    fn what_is_written_is_read(
        written in prop::collection::vec(prop::array::uniform3(prop::num::f64::NORMAL), 1..40),
    ) {
        let vertices: String = written.iter().map(|[x, y, z]| format!("{x:e} {y:e} {z:e}\n")).collect();
        let text = format!("OFF\n{} 0 0\n{vertices}", written.len());
        prop_assert_eq!(points(text.as_bytes()), written);
    }

    #[test]
    fn random_text_never_panics(text in "(OFF|nOFF|[0-9. -]{0,9}|#|\n){0,40}") {
        let _ = read(text.as_bytes(), &TextOptions::default());
        let _ = is_off(text.as_bytes());
    }
}

/// The example of the format's description (a box with coloured faces).
const CUBE: &[u8] = b"OFF cube.off\n\
    # A cube\n\
    \x20\n\
    8 6 12\n\
     1.0  0.0 1.4142\n 0.0  1.0 1.4142\n-1.0  0.0 1.4142\n 0.0 -1.0 1.4142\n\
     1.0  0.0 0.0\n 0.0  1.0 0.0\n-1.0  0.0 0.0\n 0.0 -1.0 0.0\n\
    4  0 1 2 3  255 0 0 #red\n\
    4  7 4 0 3  0 255 0 #green\n\
    4  4 5 1 0  0 0 255 #blue\n\
    4  5 6 2 1  0 255 0\n\
    4  3 2 6 7  0 0 255\n\
    4  6 5 4 7  255 0 0\n";
