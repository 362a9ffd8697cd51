use proptest::prelude::*;

use super::*;
use crate::test_data::hold_against_damage;
use crate::xyz::{By, Unit};

fn points(bytes: &[u8]) -> Vec<[f64; 3]> {
    let topography = crate::read("a", bytes).unwrap();
    assert_eq!(topography.source().format, Format::Stl);
    topography.points().collect()
}

fn plain(bytes: &[u8]) -> Result<Topography, ReadError> {
    read(bytes, &TextOptions::default())
}

fn message(bytes: &[u8]) -> String {
    plain(bytes).unwrap_err().to_string()
}

#[test]
fn files_of_another_program_give_each_corner_once() {
    let expected = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.5], [0.0, 1.0, 0.25], [1.0, 1.0, -2.0]];
    for file in [BINARY, ASCII] {
        assert_eq!(points(file), expected);
    }
    // Some programs write text into the head of binary files.
    let mut file = BINARY.to_vec();
    file[..11].copy_from_slice(b"solid facet");
    assert_eq!(points(&file), expected);
    let topography = plain(BINARY).unwrap();
    assert_eq!(topography.source().taken.as_ref().unwrap().units_by, By::Default);
    let options = TextOptions { units: vec![Unit::In], ..TextOptions::default() };
    assert_eq!(read(ASCII, &options).unwrap().points().nth(1), Some([25.4, 0.0, 12.7]));
}

#[test]
fn equal_places_are_one_and_gaps_are_counted() {
    let solid = |corners: &str| {
        format!(
            "solid a b\nfacet normal 0 0 1\n outer loop\n{corners} endloop\nendfacet\nendsolid a b\n"
        )
    };
    let file = solid("vertex 0 0 1\nvertex -0 0 1\nvertex 0 nan 1\n");
    let topography = plain(file.as_bytes()).unwrap();
    assert_eq!((topography.points().count(), topography.missing()), (1, 1));
    let two = file.to_uppercase() + &solid("vertex 1 0 1\r\nvertex 2 0 1\rvertex 1 0 1\n");
    assert_eq!(points(two.as_bytes()), [[0.0, 0.0, 1.0], [1.0, 0.0, 1.0], [2.0, 0.0, 1.0]]);
    let infinite = solid("vertex 0 0 1\nvertex 0 0 1e999\nvertex 0 0 3\n");
    assert!(message(infinite.as_bytes()).contains("line 5: expected finite coordinates"));
}

#[test]
fn faults_are_named_with_their_place() {
    let cases: [(&[u8], &str); 7] = [
        (
            b"solid\nfacet normal 0 0 1\nvertex 0 0 1\n",
            "line 3: expected outer loop, found \"vertex 0 0 1\"",
        ),
        (b"solid\nfacet\nouter loop\nvertex 0 0\n", "line 4: expected vertex with three numbers"),
        (b"solid\nfacet\nouter loop\nvertex 0 0 1\nendloop\n", "line 5: expected vertex"),
        (b"solid\nendsolid\n", "line 2: expected at least one point, found none"),
        (b"solid\nfacet\n", "line 2: expected outer loop, found the end of the file"),
        (&BINARY[..130], "byte 80: expected 184 bytes for 2 triangles, found 130, with room for 0"),
        (
            &BINARY[..50],
            "byte 50: expected solid, or 80 bytes and the number of triangles, found 50 bytes",
        ),
    ];
    for (file, expected) in cases {
        assert!(message(file).contains(expected), "{}", message(file));
    }
    let mut solid = BINARY.to_vec();
    solid[..6].copy_from_slice(b"solid ");
    assert!(message(&solid[..183]).contains("expected 184 bytes for 2 triangles, found 183"));
    let mut many = BINARY.to_vec();
    many[80..84].copy_from_slice(&[0xFF; 4]);
    assert!(message(&many).contains("expected 214748364834 bytes"), "{}", message(&many));
    assert!(message(&[0; 84]).contains("expected at least one point"));
}

#[test]
fn damaged_files_are_refused_or_read_without_a_panic() {
    hold_against_damage(BINARY, plain);
    hold_against_damage(ASCII, plain);
}

proptest! {
    #[test]
    fn corners_come_back_bit_for_bit(
        corners in prop::collection::vec(prop::array::uniform3(prop::num::f32::NORMAL), 1..30),
    ) {
        let mut file = vec![b' '; 80];
        file.extend((corners.len() as u32).to_le_bytes());
        for corner in &corners {
            let numbers = [[0.0; 3], *corner, *corner, *corner].concat();
            file.extend(numbers.iter().flat_map(|number: &f32| number.to_le_bytes()));
            file.extend([0; 2]);
        }
        let mut expected: Vec<[f64; 3]> = Vec::new();
        for corner in corners.iter().map(|corner| corner.map(f64::from)) {
            if !expected.contains(&corner) {
                expected.push(corner);
            }
        }
        prop_assert_eq!(points(&file), expected);
    }

    #[test]
    fn random_lines_never_panic(text in "(solid|facet|outer|vertex [0-9e. -]{0,9}|endloop|endfacet|endsolid|\n){0,40}") {
        let _ = plain(text.as_bytes());
    }
}

/// Written by trimesh 5.2.0: two triangles that share an edge.
const BINARY: &[u8] =
    b"\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\
      \0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\x02\0\0\0\x83t\xDF\xBE\
      \x83t_\xBE\x83t_?\0\0\0\0\0\0\0\0\0\0\0\0\0\0\x80?\0\0\0\0\0\0\0?\0\0\0\0\0\0\x80?\0\0\x80>\
      \0\08'$?wd6?\xF9\xE9\x91>\0\0\x80?\0\0\0\0\0\0\0?\0\0\x80?\0\0\x80?\0\0\0\xC0\0\0\0\0\0\0\
      \x80?\0\0\x80>\0\0";

/// Written by trimesh 5.2.0: two triangles that share an edge.
const ASCII: &[u8] = b"solid \n\
      facet normal -0.4364357804719848 -0.2182178902359924 0.8728715609439696\n\
      outer loop\n\
      vertex 0.0 0.0 0.0\n\
      vertex 1.0 0.0 0.5\n\
      vertex 0.0 1.0 0.25\n\
      endloop\n\
      endfacet\n\
      facet normal 0.6412234498911868 0.7124704998790965 0.2849881999516386\n\
      outer loop\n\
      vertex 1.0 0.0 0.5\n\
      vertex 1.0 1.0 -2.0\n\
      vertex 0.0 1.0 0.25\n\
      endloop\n\
      endfacet\n\
      \n\
      endsolid\n";
