//! Files written by the rules of the manual, and what breaks them.

use super::*;

/// z = 100 + the number of the height, in a file of 5 by 6.
fn file(first: &str) -> String {
    (0..30).fold(format!("{first}\n"), |text, index| text + &format!("{} 0 0 0 0\n", 100 + index))
}

fn map(bytes: &[u8]) -> HeightMap {
    match read(bytes).unwrap() {
        Topography::Map(map, _) => map,
        Topography::Cloud(..) => unreachable!("a grid is no cloud"),
    }
}

fn message(text: &str) -> String {
    read(text.as_bytes()).unwrap_err().to_string()
}

/// "The first data line in the file corresponds to the upper left corner of the surface, that is, the corner defined by -x and +y
/// limits. Each point that follows is read across the face of the surface from left to right" (ZEMAX manual, Grid Sag).
#[test]
fn the_first_height_is_at_minus_x_and_plus_y_and_x_runs_first() {
    let topography = read(file("5 6 2 -0.5 0 0.25 -3").as_bytes()).unwrap();
    let points: Vec<[f64; 3]> = topography.points().collect();
    assert_eq!(points.len(), 30);
    for (index, [x_mm, y_mm]) in
        [(0, [-3.75, -1.75]), (1, [-1.75, -1.75]), (5, [-3.75, -2.25]), (29, [4.25, -4.25])]
    {
        let z_mm = 100.0 + f64::from(index);
        assert!(points.contains(&[x_mm, y_mm, z_mm]), "{index}");
    }
    assert_eq!(points[0], [-3.75, -4.25, 125.0]);
}

#[test]
fn every_length_is_in_the_unit_of_the_file() {
    let in_mm = map(file("5 6 2 0.5 0 1 -3").as_bytes());
    for (flag, unit_mm) in [(1, 10.0), (2, 25.4), (3, 1000.0)] {
        let found = map(file(&format!("5 6 2 0.5 {flag} 1 -3")).as_bytes());
        let expected = HeightMap {
            dx_mm: in_mm.dx_mm * unit_mm,
            dy_mm: in_mm.dy_mm * unit_mm,
            x0_mm: unit_mm - 0.5 * 4.0 * 2.0 * unit_mm,
            y0_mm: -3.0 * unit_mm - 0.5 * 5.0 * 0.5 * unit_mm,
            z_mm: in_mm.z_mm.iter().map(|z_mm| z_mm * unit_mm).collect(),
            ..in_mm
        };
        assert_eq!(found, expected);
    }
}

#[test]
fn what_has_no_height_is_a_gap() {
    let text = file("5 6 1 1 0 0 0")
        .replace("100 0 0 0 0", "100 1e-3 0 0 1")
        .replace("101 0 0 0 0", "NaN 0 0 0 0")
        .replace("102 0 0 0 0", "102")
        .replace("103 0 0 0 0", "103 0 0 0");
    let topography = read(text.as_bytes()).unwrap();
    assert_eq!(topography.missing(), 2);
    let heights: Vec<f64> = topography.points().map(|point| point[2]).collect();
    assert!([102.0, 103.0].iter().all(|height| heights.contains(height)));
    assert!(![100.0, 101.0].iter().any(|height| heights.contains(height)));
}

#[test]
fn comments_line_ends_and_encodings_change_nothing() {
    let plain = file("5 6 1 1 0 0 0");
    let expected = map(plain.as_bytes());
    let told = format!("! made by hand\r\n\r\n{}\r\n! end\r\n", plain.replace('\n', "\r\n"));
    let wide = [0xFF, 0xFE].into_iter().chain(told.encode_utf16().flat_map(u16::to_le_bytes));
    let wide: Vec<u8> = wide.collect();
    for bytes in [told.as_bytes(), &wide] {
        assert_eq!(map(bytes), expected);
        assert!(is_grid_sag(bytes));
    }
}

#[test]
fn other_columns_are_no_grid() {
    for text in [
        "",
        "1 2 3\n4 5 6\n",
        "5 5 1 1 0 0 0\n5 5 1 1 0 0 0\n",
        "5 5 1 1 0 0 0\n",
        "4 5 1 1 0 0 0\n1\n",
    ] {
        assert!(!is_grid_sag(text.as_bytes()), "{text}");
    }
}

#[test]
fn mistakes_are_told_with_their_place() {
    let first = |first: &str| message(&file(first));
    for (found, said) in [
        (
            message(""),
            "line 1: expected seven numbers: nx ny delx dely unitflag xdec ydec, found \"\"",
        ),
        (first("5 6 1 1 0 0"), "line 1: expected seven numbers"),
        (
            first("4 6 1 1 0 0 0"),
            "line 1, column 1: expected a whole number of at least 5, found \"4\"",
        ),
        (
            first("5 6.5 1 1 0 0 0"),
            "line 1, column 2: expected a whole number of at least 5, found \"6.5\"",
        ),
        (
            first("5 6 0 1 0 0 0"),
            "line 1, column 3: expected a distance that is not 0, found \"0\"",
        ),
        (first("5 6 1 1 4 0 0"), "line 1, column 5: expected a unit: 0 for mm"),
        (first("5 6 1 1 3 0 1e307"), "line 1, column 7: expected a number, found \"1e307\""),
        (first("6 6 1 1 0 0 0"), "line 31: expected 36 heights, as nx times ny, found 30"),
        (
            first("5 5 1 1 0 0 0"),
            "line 27: expected no more than nx times ny heights, found \"125 0 0 0 0\"",
        ),
        (
            message(&file("5 6 1 1 0 0 0").replace("103 0", "103 x")),
            "line 5, column 2: expected a number, found \"x\"",
        ),
        (
            message(&file("5 6 1 1 0 0 0").replace("103 0", "103 0 0")),
            "line 5: expected at most z dz/dx",
        ),
        (
            message("50000 50000 1 1 0 0 0\n0\n"),
            "line 1, column 1: expected at most 100000000 points, found 2500000000",
        ),
    ] {
        assert!(found.contains(said), "{found}");
        assert!(found.starts_with("Zemax grid sag file, "), "{found}");
    }
}

proptest::proptest! {
    #[test]
    fn no_bytes_make_it_panic(bytes: Vec<u8>) {
        let _ = read(&bytes);
        let _ = read(&[b"5 5 1 1 0 0 0\n", bytes.as_slice()].concat());
        let _ = is_grid_sag(&bytes);
    }
}
