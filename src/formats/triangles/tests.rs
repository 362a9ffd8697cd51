//! Every file here is written by hand from the definition of its format.

use std::collections::HashSet;

use proptest::prelude::*;

use super::*;
use crate::test_data::hold_mesh_against_damage;
use crate::xyz::Unit;

fn mesh(name: &str, bytes: &[u8]) -> Triangles {
    read_triangles(name, bytes, &TextOptions::default()).unwrap().unwrap()
}

fn message(name: &str, bytes: &[u8]) -> String {
    read_triangles(name, bytes, &TextOptions::default()).unwrap_err().to_string()
}

/// A square with a roof: a quadrangle, and a triangle that stands on one of its sides.
const CORNERS: [[f64; 3]; 5] =
    [[0.0, 0.0, 0.0], [2.0, 0.0, 0.0], [2.0, 1.0, 0.0], [0.0, 1.0, 0.0], [1.0, 0.5, 1.5]];
const TRIANGLES: [[u32; 3]; 3] = [[0, 1, 2], [0, 2, 3], [0, 1, 4]];

const OFF: &[u8] = b"OFF # a roof\n5 3 0\n0 0 0\n2 0 0\n2 1 0\n0 1 0\n1 0.5 1.5\n4 0 1 2 3 0.5 0.5 0.5\n3 0 1 4\n2 0 4\n";

const OBJ: &[u8] = b"o roof\nv 0 0 0\nv 2 0 0\nv 2 1 0\nv 0 1 0\nvn 0 0 1\nf 1//1 2//1 3//1 4//1\nv 1 0.5 1.5 1.0\nf -5/1 2 \\\n  -1/2/3\nl 1 2\n";

const PLY: &[u8] = b"ply\nformat ascii 1.0\nelement vertex 5\nproperty float x\nproperty float y\nproperty float z\n\
    property uchar red\nelement face 2\nproperty uchar flags\nproperty list uchar float texcoord\n\
    property list uchar int vertex_indices\nend_header\n0 0 0 9\n2 0 0 9\n2 1 0 9\n0 1 0 9\n1 0.5 1.5 9\n\
    7 2 0.5 0.5 4 0 1 2 3\n7 0 3 0 1 4\n";

/// Faces before vertices, big-endian; an element behind both.
fn binary_ply() -> Vec<u8> {
    let mut file = b"ply\nformat binary_big_endian 1.0\nelement face 2\nproperty list ushort uint vertex_index\n\
        element vertex 5\nproperty short y\nproperty short x\nproperty double z\nelement edge 1\nproperty uchar a\nend_header\n"
        .to_vec();
    file.extend(b"\0\x04\0\0\0\0\0\0\0\x01\0\0\0\x02\0\0\0\x03\0\x03\0\0\0\0\0\0\0\x01\0\0\0\x04");
    // As IEEE 754 double precision 1.5 is 3FF8 and zeros.
    for (x, y, z) in
        [(0, 0, b"\0\0"), (2, 0, b"\0\0"), (2, 1, b"\0\0"), (0, 1, b"\0\0"), (1, 0, b"\x3F\xF8")]
    {
        file.extend([0, y, 0, x]);
        file.extend(z);
        file.extend([0; 6]);
    }
    file.push(1);
    file
}

const STL: &[u8] = b"solid roof\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 2 0 0\nvertex 2 1 0\nendloop\nendfacet\n\
    facet normal 0 0 1\nouter loop\nvertex 0 -0 0\nvertex 2 1 0\nvertex 0 1 0\nendloop\nendfacet\n\
    facet normal 0 0 0\nouter loop\nvertex 0 0 0\nvertex 2 0 0\nvertex 1 0.5 1.5\nendloop\nendfacet\nendsolid roof\n";

/// 1, 2, 0.5 and 1.5 as IEEE 754 single precision, written by hand.
fn binary_stl() -> Vec<u8> {
    let (one, two, half, more): (&[u8], &[u8], &[u8], &[u8]) =
        (b"\0\0\x80\x3F", b"\0\0\0\x40", b"\0\0\0\x3F", b"\0\0\xC0\x3F");
    let zero: &[u8] = &[0; 4];
    let mut file = vec![b' '; 80];
    file.extend(b"\x03\0\0\0");
    for corners in [
        [[zero, zero, zero], [two, zero, zero], [two, one, zero]],
        [[zero, zero, zero], [two, one, zero], [zero, one, zero]],
        [[zero, zero, zero], [two, zero, zero], [one, half, more]],
    ] {
        file.extend([0; 12]);
        corners.into_iter().flatten().for_each(|number| file.extend(number));
        file.extend([0; 2]);
    }
    file
}

#[test]
fn faces_are_read_of_every_format() {
    for (name, bytes) in
        [("a.off", OFF), ("a.obj", OBJ), ("a.ply", PLY), ("a.stl", STL), ("a.stl", &binary_stl())]
    {
        let found = mesh(name, bytes);
        assert_eq!(found.points_mm, CORNERS, "{name}");
        assert_eq!(found.triangles, TRIANGLES, "{name}");
        let points = crate::read(name, bytes).unwrap();
        assert_eq!(points.points().collect::<Vec<_>>(), CORNERS, "{name}");
    }
    let found = mesh("a.ply", &binary_ply());
    assert_eq!(found.points_mm[..4], CORNERS[..4]);
    assert_eq!((found.points_mm[4], &found.triangles[..]), ([1.0, 0.0, 1.5], &TRIANGLES[..]));
}

#[test]
fn units_scale_corners() {
    let options = TextOptions { units: vec![Unit::Um], ..TextOptions::default() };
    let found = read_triangles("a.stl", STL, &options).unwrap().unwrap();
    assert_eq!(found.points_mm[4], [1e-3, 0.5e-3, 1.5e-3]);
}

#[test]
fn files_of_points_have_no_triangles() {
    let points = b"ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nproperty float y\nproperty float z\n";
    let ply = |more: &str| [&points[..], more.as_bytes()].concat();
    for (name, bytes) in [
        ("a.xyz", b"0 0 1\n1 0 1\n".to_vec()),
        ("a.off", b"OFF\n1 0 0\n0 0 0\n".to_vec()),
        ("a.off", b"OFF\n2 1 0\n0 0 0\n1 0 0\n2 0 1\n".to_vec()),
        ("a.obj", b"v 0 0 1\n".to_vec()),
        ("a.ply", ply("end_header\n0 0 0\n")),
        (
            "a.ply",
            ply("element face 0\nproperty list uchar int vertex_indices\nend_header\n0 0 0\n"),
        ),
    ] {
        assert_eq!(read_triangles(name, &bytes, &TextOptions::default()), Ok(None), "{name}");
    }
}

#[test]
fn a_corner_that_there_is_not_is_named_with_its_place() {
    let off = |face: &str| format!("OFF\n3 1 0\n0 0 0\n1 0 0\nnan 1 0\n{face}\n").into_bytes();
    let obj = |face: &str| format!("v 0 0 0\nv 1 0 0\nv nan 1 0\n{face}\n").into_bytes();
    let ply = |face: &str| {
        format!(
            "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n\
             element face 1\nproperty list uchar int vertex_indices\nend_header\n0 0 0\n1 0 0\nnan 1 0\n{face}\n"
        )
        .into_bytes()
    };
    let behind = "expected a face with corners of the 3 there are, found";
    let gap = "expected a face with corners that have coordinates, found";
    let mut stl = binary_stl();
    stl[84 + 12..][..4].copy_from_slice(&[0, 0, 0xC0, 0x7F]);
    let mut far = binary_ply();
    let at = far.windows(12).position(|window| window == b"end_header\n\0").unwrap() + 11;
    far[at + 2] = 1;
    for (name, file, expected) in [
        ("a.off", off("3 0 1 3"), format!("line 6: {behind} corner 3")),
        ("a.off", off("3 0 1 -1"), format!("line 6: {behind} corner -1")),
        ("a.off", off("3 0 1 2"), format!("line 6: {gap} corner 2")),
        (
            "a.off",
            off("3 0 1"),
            "line 6: expected number and numbers of the corners of face 1".into(),
        ),
        ("a.off", off("3 0 1 x"), "line 6: expected number and numbers".into()),
        ("a.off", off("9999999999999 0 1 2"), "line 6: expected number and numbers".into()),
        ("a.off", off(""), "line 5: expected 1 faces, found the end of the file after 0".into()),
        ("a.obj", obj("f 1 2 4"), format!("line 4: {behind} corner 4, counted from 1")),
        ("a.obj", obj("f 0 1 2"), format!("line 4: {behind} corner 0, counted from 1")),
        ("a.obj", obj("f -4 1 2"), format!("line 4: {behind} corner 0, counted from 1")),
        ("a.obj", obj("f 1 2 3"), format!("line 4: {gap} corner 3, counted from 1")),
        ("a.obj", obj("f 1 2"), "line 4: expected f and the numbers of three vertices".into()),
        ("a.obj", obj("f 1 2 q"), "line 4: expected f and the numbers".into()),
        ("a.ply", ply("3 0 1 3"), format!("line 13: {behind} 3")),
        ("a.ply", ply("3 0 1 0.5"), format!("line 13: {behind} 0.5")),
        ("a.ply", ply("3 0 1 2"), format!("line 13: {gap} 2")),
        ("a.ply", ply("3 0 1"), "expected 1 of element face, found the end of the file".into()),
        ("a.ply", ply("x"), "line 13: expected the length of a list".into()),
        (
            "a.ply",
            far,
            format!("byte {at}: expected a face with corners of the 5 there are, found"),
        ),
        ("a.stl", stl, format!("byte {}: {gap} one that is NaN", 84 + 36)),
    ] {
        assert!(message(name, &file).contains(&expected), "{expected}: {}", message(name, &file));
    }
}

/// Meshes of others have the number of faces, or the Euler characteristic 2 − 2g of the genus, that their sources state.
#[test]
fn real_meshes_have_the_faces_and_the_genus_of_their_sources() {
    let read = |name: &str| crate::test_data::shared(name).map(|bytes| mesh(name, &bytes));
    if let Some(bunny) = read("solids/bunny.ply") {
        assert_eq!((bunny.points_mm.len(), bunny.triangles.len()), (35_947, 69_451));
    }
    for (name, genus) in
        [("solids/eight.off", 2), ("solids/anchor_dense.off", 4), ("solids/knot1.off", 1)]
    {
        let Some(found) = read(name) else { continue };
        let side = |[a, b]: [u32; 2]| [a.min(b), a.max(b)];
        let sides: HashSet<[u32; 2]> = found
            .triangles
            .iter()
            .flat_map(|&[a, b, c]| [[a, b], [b, c], [c, a]].map(side))
            .collect();
        let corners: HashSet<u32> = found.triangles.iter().flatten().copied().collect();
        let euler = corners.len() as i64 - sides.len() as i64 + found.triangles.len() as i64;
        assert_eq!(euler, 2 - 2 * genus, "{name}");
    }
}

#[test]
fn damaged_meshes_are_refused_or_read_without_a_panic() {
    hold_mesh_against_damage("a.ply", PLY);
    hold_mesh_against_damage("a.ply", &binary_ply());
    hold_mesh_against_damage("a.stl", &binary_stl());
    hold_mesh_against_damage("a.stl", STL);
    hold_mesh_against_damage("a.off", OFF);
    hold_mesh_against_damage("a.obj", OBJ);
}

#[test]
fn claimed_sizes_cost_nothing() {
    let head = "ply\nformat binary_little_endian 1.0\nelement vertex 1\nproperty float x\nproperty float y\nproperty float z\n";
    let mut file =
        format!("{head}element face 18446744073709551615\nproperty list uint int vertex_indices\nend_header\n")
            .into_bytes();
    file.extend([0; 12]);
    file.extend([0xFF; 16]);
    assert!(message("a.ply", &file).contains("of element face"), "{}", message("a.ply", &file));
    let file = b"OFF\n1 18446744073709551615 0\n0 0 0\n18446744073709551615 0\n";
    assert!(message("a.off", file).contains("line 4: expected number and numbers"));
}

/// The area of a polygon in the plane by its corners (Gauss, shoelace formula).
fn shoelace_mm2(corners: &[[f64; 3]]) -> f64 {
    let next = corners.iter().cycle().skip(1);
    0.5 * corners.iter().zip(next).map(|(a, b)| a[0] * b[1] - a[1] * b[0]).sum::<f64>()
}

proptest! {
    #[test]
    fn fans_of_convex_polygons_have_their_area(
        angles in prop::collection::btree_set(0_u32..3600, 3..20),
    ) {
        let corners: Vec<[f64; 3]> = angles
            .iter()
            .map(|&tenths| {
                let (sin, cos) = (f64::from(tenths) * std::f64::consts::TAU / 3600.0).sin_cos();
                [3.0 * cos, 2.0 * sin, 0.0]
            })
            .collect();
        let mut file = format!("OFF\n{} 1 0\n", corners.len());
        corners.iter().for_each(|[x, y, z]| file += &format!("{x} {y} {z}\n"));
        let numbers: Vec<String> = (0..corners.len()).map(|number| number.to_string()).collect();
        file += &format!("{} {}\n", corners.len(), numbers.join(" "));
        let found = mesh("a.off", file.as_bytes());
        prop_assert_eq!(found.triangles.len(), corners.len() - 2);
        let area_mm2: f64 = found
            .triangles
            .iter()
            .map(|corners| shoelace_mm2(&corners.map(|at| found.points_mm[at as usize])))
            .sum();
        prop_assert!((area_mm2 - shoelace_mm2(&corners)).abs() < 1e-12);
    }

    #[test]
    fn a_mesh_that_is_written_is_read_again(
        written in prop::collection::vec(prop::array::uniform3(-1e3..1e3), 3..30),
        picks in prop::collection::vec(prop::array::uniform3(any::<prop::sample::Index>()), 1..30),
    ) {
        let triangles: Vec<[u32; 3]> =
            picks.iter().map(|corners| corners.map(|pick| pick.index(written.len()) as u32)).collect();
        let mut file = Vec::new();
        ply::write_mesh(&mut file, &written, &triangles, None, &[]).unwrap();
        let found = mesh("a.ply", &file);
        prop_assert_eq!(&found.points_mm, &written);
        prop_assert_eq!(&found.triangles, &triangles);
    }
}
