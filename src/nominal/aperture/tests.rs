//! Outlines as apertures, from numbers and from drawings.

use std::fs;

use asphera_form::Aperture;

use super::super::{flipped, parse};
use super::aperture_lines_mm;

const PLATE: &str = "[surface]\nkind = \"plane\"\n[aperture]\nshape = \"outline\"\n";

fn aperture(name: &str, keys: &str) -> Result<Aperture, String> {
    let part = parse(name, &format!("{PLATE}{keys}"));
    part.map(|part| part.aperture).map_err(|problems| problems.to_string())
}

#[test]
fn closed_lines_are_an_outline_and_its_holes() {
    // The hole stands first: the largest line is the outline.
    let keys = "lines_mm = [[1, 1, 2, 1, 2, 2, 1, 2], [0, 0, 4, 0, 4, 3, 0, 3, 0, 0]]\n";
    let keys = format!("{keys}centre_mm = [0, 0]\n");
    let found = aperture("nominal.toml", &keys).unwrap();
    assert_eq!(found.area_mm2(), 11.0);
    assert!(found.contains(3.0, 2.5) && found.contains(4.0, 3.0));
    assert!(!found.contains(1.5, 1.5) && !found.contains(-0.1, 1.0));
    let lines = aperture_lines_mm(&found).unwrap();
    let outer = vec![0.0, 0.0, 4.0, 0.0, 4.0, 3.0, 0.0, 3.0];
    assert_eq!((&lines[0], lines.len(), lines[1].len()), (&outer, 2, 8));
    assert_eq!(aperture_lines_mm(&Aperture::None), None);
}

#[test]
fn a_drawing_is_an_outline() {
    let folder = tempfile::tempdir().unwrap();
    // A disc of radius 5 about (1, 2), y upwards, drawn twice, with a square hole.
    let disc = "M 6 -2 A 5 5 0 0 0 -4 -2 A 5 5 0 0 0 6 -2 Z";
    let svg = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"20mm\" height=\"20mm\" viewBox=\"-10 -10 20 20\">\
         <path d=\"{disc}\"/><path d=\"{disc}\"/><path d=\"M 0 -1 L 2 -1 L 2 -3 L 0 -3 Z\"/></svg>"
    );
    fs::write(folder.path().join("disc.svg"), svg).unwrap();
    let name = folder.path().join("nominal.toml").display().to_string();
    let found = aperture(&name, "file = \"disc.svg\"\ncentre_mm = [0, 0]\n").unwrap();
    let expected = 25.0 * std::f64::consts::PI - 4.0;
    assert!((found.area_mm2() - expected).abs() < 2e-3, "{}", found.area_mm2());
    assert!(found.contains(5.99, 2.0) && !found.contains(6.01, 2.0) && !found.contains(1.0, 2.0));
}

#[test]
fn mistakes_are_named() {
    let folder = tempfile::tempdir().unwrap();
    let name = folder.path().join("nominal.toml").display().to_string();
    let open = "<svg xmlns=\"http://www.w3.org/2000/svg\"><path d=\"M 0 0 L 4 0 L 4 4\"/></svg>";
    fs::write(folder.path().join("open.svg"), open).unwrap();
    fs::write(folder.path().join("outline.txt"), "0 0\n1 0\n1 1\n").unwrap();
    let square = "[0, 0, 4, 0, 4, 4, 0, 4]";
    for (keys, words) in [
        (String::new(), "file"),
        ("file = \"none.svg\"\n".into(), "none.svg"),
        ("file = \"open.svg\"\n".into(), "closed lines"),
        ("file = \"outline.txt\"\n".into(), ".dxf"),
        ("lines_mm = []\n".into(), "no line"),
        ("lines_mm = [[0, 0, 1]]\n".into(), "an odd count of numbers"),
        ("lines_mm = [[0, 0, 1, 0]]\n".into(), "2 different places"),
        ("lines_mm = [[0, 0, 2, 2, 2, 0, 0, 2.5]]\n".into(), "meet near"),
        (format!("lines_mm = [{square}, [5, 5, 6, 5, 6, 6]]\n"), "hole 1 does not lie inside"),
        (format!("lines_mm = [{square}]\nfile = \"open.svg\"\n"), "both"),
    ] {
        let found = aperture(&name, &keys).unwrap_err();
        assert!(found.contains(words) && found.contains("aperture."), "{keys}: {found}");
    }
    // A sphere ends before the corner.
    let sphere = "[surface]\nkind = \"sphere\"\nradius_mm = 5\n[aperture]\nshape = \"outline\"\n";
    let beyond = parse(&name, &format!("{sphere}lines_mm = [{square}]\n")).unwrap_err().to_string();
    assert!(beyond.contains("an aperture within the surface"), "{beyond}");
}

#[test]
fn the_other_side_has_the_outline_mirrored() {
    let text = format!("{PLATE}lines_mm = [[0, 1, 4, 1, 4, 3]]\ncentre_mm = [0, 0]\n");
    let turned = parse("nominal.toml", &flipped(&text).unwrap()).unwrap().aperture;
    assert!(turned.contains(3.9, -2.0) && !turned.contains(3.9, 2.0));
    let error = flipped(&format!("{PLATE}file = \"disc.svg\"\n")).unwrap_err();
    assert!(error.to_string().contains("--along 0,0,-1"), "{error}");
}

#[test]
fn without_a_middle_an_outline_is_about_its_own() {
    let text = format!("{PLATE}lines_mm = [[2, 1, 6, 1, 6, 4, 2, 4]]\n");
    let part = parse("nominal.toml", &text).unwrap();
    assert_eq!(part.centre_mm, [4.0, 2.5]);
    assert!(part.aperture.contains(-2.0, 1.5) && !part.aperture.contains(2.1, 0.0));
    // A sphere has its vertex.
    let text = text.replace("kind = \"plane\"", "kind = \"sphere\"\nradius_mm = 20");
    let part = parse("nominal.toml", &text).unwrap();
    assert_eq!((part.centre_mm, part.aperture.contains(2.5, 3.5)), ([0.0; 2], true));
}
