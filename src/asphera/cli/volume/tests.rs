//! The command from its arguments to its figures.

use std::path::Path;

use asphera_rig::CtScene;
use clap::Parser as _;
use serde_json::Value;

use super::{figures, form, meshed, opened};

mod border;
mod missing;
mod regular;
use crate::cli::demo::ct::lay_out;
use crate::cli::files::part;
use crate::cli::progress::Progress;
use crate::cli::{Cli, Command};

/// The figures of a volume file with more arguments.
fn figures_of(bytes: &[u8], extension: &str, more: &[&str]) -> Result<Value, String> {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join(format!("part.{extension}"));
    std::fs::write(&file, bytes).unwrap();
    figures_at(&file, more)
}

/// The same of what lies at a path.
fn figures_at(path: &Path, more: &[&str]) -> Result<Value, String> {
    let mut words = vec!["asphera", "volume", path.to_str().unwrap()];
    words.extend(more);
    let cli = Cli::try_parse_from(words).map_err(|error| error.to_string())?;
    let Command::Volume(args) = cli.command else { panic!("another command") };
    // All at once, and slice by slice where the file and the method can.
    let figures = |whole: u64, mesh: &str| {
        let opened = opened::open(&args, whole)?;
        let folder = tempfile::tempdir().unwrap();
        let files = [folder.path().join(format!("{mesh}.ply")), folder.path().join("mesh.stl")];
        let surface = meshed::of(&args, &opened, &files)?;
        let given = args.nominal.as_deref().map(part).transpose()?;
        let report = figures::of(&args, &opened, &surface, given.as_ref())?;
        let written = files.map(|file| std::fs::read(file).unwrap());
        Ok((serde_json::to_value(&report).unwrap(), written))
    };
    let text = |error: crate::cli::output::Failure| error.to_string();
    let whole = figures(u64::MAX, "whole");
    let sliced = figures(0, "sliced");
    match (whole, sliced) {
        (Ok((whole, [ply, stl])), Ok((sliced, [sliced_ply, sliced_stl]))) => {
            assert_near("", &whole, &sliced);
            assert!(stl == sliced_stl, "STL of slices differs");
            let ends = [&ply, &sliced_ply].map(|file| {
                let head = b"end_header\n";
                let at = file.windows(head.len()).position(|part| part == head).unwrap();
                file[at..].to_vec()
            });
            assert!(ends[0] == ends[1], "PLY of slices differs");
            Ok(whole)
        }
        (Err(whole), Err(sliced)) => {
            let whole = text(whole);
            let sliced = text(sliced);
            let short = |text: &str| text.contains("bytes of samples") && text.contains("expected");
            assert!(whole == sliced || (short(&whole) && short(&sliced)), "{whole}\n{sliced}");
            Err(whole)
        }
        (Ok(_), Err(error)) => panic!("slice by slice: {}", text(error)),
        (Err(error), Ok(_)) => panic!("all at once: {}", text(error)),
    }
}

/// Holds figures to others: sums in another order differ by rounding.
fn assert_near(key: &str, one: &Value, other: &Value) {
    match (one, other) {
        (Value::Object(one), Value::Object(other)) => {
            assert!(one.keys().eq(other.keys()), "{key}");
            one.iter().for_each(|(key, value)| assert_near(key, value, &other[key]));
        }
        (Value::Array(one), Value::Array(other)) => {
            assert_eq!(one.len(), other.len(), "{key}");
            one.iter().zip(other).for_each(|(one, other)| assert_near(key, one, other));
        }
        (Value::Number(one), Value::Number(other)) if one.is_f64() => {
            let [one, other] = [one, other].map(|number| number.as_f64().unwrap());
            assert!((one - other).abs() <= 1e-9 * one.abs().max(1e-6), "{key}: {one} {other}");
        }
        _ => assert_eq!(one, other, "{key}"),
    }
}

/// A ball of radius 9 spacings, one byte a sample.
fn ball() -> Vec<u8> {
    let mut file = b"X: 24\nY: 24\nZ: 24\nVersion: 2\n.\n".to_vec();
    for index in 0..24 * 24 * 24 {
        let at = [index % 24, index / 24 % 24, index / 576].map(|place| f64::from(place) - 11.3);
        let square: f64 = at.iter().map(|place| place * place).sum();
        file.push(if square < 81.0 { 255 } else { 0 });
    }
    file
}

#[test]
fn a_ball_has_its_volume_area_and_topology() {
    let found = figures_of(&ball(), "vol", &["--spacing", "0.1", "--regular", "0.9"]).unwrap();
    assert_eq!(found["format"], "asphera.volume/1");
    assert_eq!(found["grid"]["verdict"], "proved");
    assert_eq!(found["topology"]["euler_6"], 1);
    assert_eq!(found["mesh"]["euler"], 2);
    assert_eq!(found["mesh"]["closed"], true);
    let near = |value: &Value, truth: f64, share: f64| {
        let value = value.as_f64().unwrap();
        assert!((value / truth - 1.0).abs() < share, "{value} {truth}");
    };
    let volume = 4.0 / 3.0 * std::f64::consts::PI * 0.729;
    let area = 4.0 * std::f64::consts::PI * 0.81;
    let measures = &found["measures"];
    near(&measures["volume_mm3"]["value"], volume, 0.01);
    near(&measures["area_mm2"]["value"], area, 0.01);
    for (figure, truth) in [("volume_mm3", volume), ("area_mm2", area)] {
        let [low, high] = ["low", "high"].map(|bound| measures[figure][bound].as_f64().unwrap());
        assert!(low < truth && truth < high, "{figure} {low} {high}");
    }
}

#[test]
fn methods_share_the_topology() {
    for method in ["mmc", "mi", "cmi", "balls", "trilinear", "smooth", "voxels"] {
        let found = figures_of(&ball(), "vol", &["--spacing", "0.1", "--method", method]).unwrap();
        assert_eq!(found["mesh"]["method"], method);
        assert_eq!(found["topology"]["surfaces"][0]["genus"], 0);
        assert_eq!(found["grid"]["verdict"], "unknown");
    }
}

#[test]
fn a_coarse_grid_is_contradicted() {
    // Two samples on a space diagonal: C2.
    let file = b"X: 2\nY: 2\nZ: 2\nVersion: 2\n.\n\x01\0\0\0\0\0\0\x01";
    let found = figures_of(file, "vol", &["--spacing", "1", "--regular", "5"]).unwrap();
    assert_eq!(found["grid"]["verdict"], "contradicted");
    assert_eq!(found["grid"]["forbidden"], 1);
    assert_eq!(found["grid"]["places"][0]["centre_mm"], serde_json::json!([0.5, 0.5, 0.5]));
    assert_eq!(found["volume"]["parts"], 2);
    let found = figures_of(file, "vol", &["--spacing", "1", "--part", "2"]).unwrap();
    assert_eq!(found["volume"]["foreground"], 1);
    let found = figures_of(&ball(), "vol", &["--spacing", "0.1", "--regular", "0.17"]).unwrap();
    assert_eq!(found["grid"]["verdict"], "contradicted");
}

#[test]
fn what_cannot_be_measured_is_said() {
    let message = |bytes: &[u8], more: &[&str]| figures_of(bytes, "vol", more).unwrap_err();
    assert!(message(&ball(), &[]).contains("give --spacing MM"));
    let flat = b"X: 2\nY: 1\nZ: 1\nVersion: 2\n.\n\x07\x07";
    assert!(message(flat, &["--spacing", "1"]).contains("found one value all over"));
    let missing = format!(
        "NRRD0004\ntype: float\ndimension: 3\nsizes: 2 2 2\nencoding: ascii\nspacings: 1 1 1\n\n{}\n",
        "nan ".repeat(8)
    );
    let said = figures_of(missing.as_bytes(), "nrrd", &[]).unwrap_err();
    assert!(said.contains("found no value that is finite"), "{said}");
    let above = message(&ball(), &["--spacing", "1", "--threshold", "300"]);
    assert!(above.contains("up to the largest 255, found 300"), "{above}");
    assert!(message(&ball(), &["--spacing", "1", "--part", "2"]).contains("--part 2"));
    assert!(message(b"1 2 3", &["--spacing", "1"]).contains("expected a volume"));
    for more in [["--spacing", "0"], ["--refine", "9"], ["--part", "0"]] {
        assert!(figures_of(&ball(), "vol", &more).is_err(), "{more:?}");
    }
    for more in [["--refine", "4"], ["--blend", "cubic"]] {
        let said = message(&ball(), &["--spacing", "1", more[0], more[1]]);
        assert!(said.starts_with(&format!("{}: expected --method", more[0])), "{said}");
    }
    for more in [["--regular", "-1"], ["--spacing", "-0.1"]] {
        let said = message(&ball(), &more);
        assert!(said.contains("expected a length in mm above 0, found `-"), "{said}");
    }
}

/// Slices as files give the figures of the same samples with a TOML file beside them.
#[test]
fn folders_of_slices_and_raw_samples_are_measured() {
    let folder = tempfile::tempdir().unwrap();
    let write = |name: &str, bytes: &[u8]| std::fs::write(folder.path().join(name), bytes).unwrap();
    let header = b"X: 24\nY: 24\nZ: 24\nVersion: 2\n.\n".len();
    let samples = &ball()[header..];
    write("ball.raw", samples);
    write("ball.toml", b"size = [24, 24, 24]\ntype = \"u8\"\nspacing_mm = 0.1\n");
    std::fs::create_dir(folder.path().join("slices")).unwrap();
    for (number, slice) in samples.chunks(576).enumerate() {
        let entries: [(u16, u32); 9] = [
            (256, 24),
            (257, 24),
            (258, 8),
            (259, 1),
            (262, 1),
            (273, 122),
            (277, 1),
            (278, 24),
            (279, 576),
        ];
        // TIFF 6.0: each entry is tag, type LONG, a count of 1 and the value.
        let mut file = b"II\x2A\0\x08\0\0\0\x09\0".to_vec();
        for (tag, value) in entries {
            file.extend(tag.to_le_bytes());
            file.extend([4, 0, 1, 0, 0, 0]);
            file.extend(value.to_le_bytes());
        }
        file.extend([0; 4]);
        file.extend(slice);
        write(&format!("slices/{number}.tif"), &file);
    }
    write("slices/notes.txt", b"not a slice");
    let expected = figures_of(&ball(), "vol", &["--spacing", "0.1"]).unwrap();
    for path in ["ball.raw", "ball.toml", "slices"] {
        let path = folder.path().join(path);
        let found = figures_at(&path, &["--spacing", "0.1"]).unwrap();
        for figure in ["volume", "topology", "measures", "mesh"] {
            assert_eq!(found[figure], expected[figure], "{}", path.display());
        }
    }
    let unspaced = figures_at(&folder.path().join("slices"), &[]).unwrap_err();
    assert!(unspaced.contains("give --spacing MM"), "{unspaced}");
    std::fs::remove_file(folder.path().join("slices/7.tif")).unwrap();
    let lacking = figures_at(&folder.path().join("slices"), &[]).unwrap_err();
    assert!(lacking.contains("slice 8.tif: expected the slice with number 7"), "{lacking}");
}

#[test]
fn grey_values_unequal_spacing_and_missing_samples_are_told() {
    let mut file =
        b"NRRD0004\ntype: float\ndimension: 3\nsizes: 12 12 12\nencoding: raw\nendian: little\n\
        spacings: 0.1 0.1 0.2\n\n"
            .to_vec();
    for index in 0..1728 {
        let at = [index % 12, index / 12 % 12, index / 144].map(|place| place as f32 - 5.5);
        let distance = at.iter().map(|place| place * place).sum::<f32>().sqrt();
        let value = if index == 0 { f32::NAN } else { 4.2 - distance };
        file.extend(value.to_le_bytes());
    }
    let found = figures_of(&file, "nrrd", &["--threshold", "0", "--regular", "1"]).unwrap();
    assert_eq!(found["grid"]["verdict"], "unknown");
    assert_eq!(found["volume"]["missing"], 1);
    assert_eq!(found["measures"]["area_mm2"]["estimator"], "mesh");
    let [low, high] = [0, 1]
        .map(|at| found["measures"]["volume_mm3"]["at_threshold_moved"][at].as_f64().unwrap());
    assert!(low >= high);
    // Flat triangles cut the ball a little.
    let truth = 4.0 / 3.0 * std::f64::consts::PI * 4.2_f64.powi(3) * 0.002;
    let mesh = found["measures"]["volume_mm3"]["by"]["mesh"].as_f64().unwrap();
    assert!((mesh / truth - 1.0).abs() < 0.05, "{mesh} {truth}");
    assert!(found["reasons"].to_string().contains("mm is assumed"));
}

/// A missing sample is background, infinite too; the cells of the surface beside it are counted, and contradict nothing.
#[test]
fn cells_beside_missing_samples_are_counted() {
    for lacking in [f32::NAN, f32::INFINITY] {
        let mut file =
            b"NRRD0004\ntype: float\ndimension: 3\nsizes: 12 12 12\nencoding: raw\nendian: little\n\
            spacings: 0.1 0.1 0.1\n\n"
                .to_vec();
        for index in 0..1728 {
            let at = [index % 12, index / 12 % 12, index / 144].map(|place| place as f32 - 5.5);
            let distance = at.iter().map(|place| place * place).sum::<f32>().sqrt();
            // One amid the material, and two diagonal neighbours of one slice: C1.
            let is_lacking = [786, 799].contains(&index);
            let value = if is_lacking { lacking } else { 4.2 - distance };
            file.extend(value.to_le_bytes());
        }
        let found = figures_of(&file, "nrrd", &["--threshold", "0", "--regular", "0.4"]).unwrap();
        assert_eq!(found["volume"]["missing"], 2);
        // Eight cells about each; the two share two of them.
        assert_eq!(found["volume"]["missing_cells"], 14);
        assert!(found["grid"]["doubtful"].as_u64().unwrap() > 0);
        assert_eq!(found["grid"]["verdict"], "unknown", "{}", found["grid"]);
        assert!(
            found["reasons"]
                .to_string()
                .contains("14 cells that would have surface lie beside one")
        );
    }
}

/// Noise on voxels that are no cubes, or whose axes are slanted, contradicts nothing: no theorem says anything of them.
#[test]
fn no_theorem_speaks_of_slanted_or_unequal_axes() {
    for (axes, verdict) in [
        ("(1,0,0) (0,1,0) (0,0,1)", "contradicted"),
        ("(1,0,0) (0,1,0) (0,0,3)", "unknown"),
        ("(1,0,0) (0.6,0.8,0) (0,0,1)", "unknown"),
    ] {
        let mut file = format!(
            "NRRD0004\ntype: uint8\ndimension: 3\nspace: left-posterior-superior\nsizes: 4 4 4\nspace directions: {axes}\n\
             encoding: raw\n\n"
        )
        .into_bytes();
        file.extend((0..64).map(|index| u8::from([21, 42].contains(&index))));
        let found = figures_of(&file, "nrrd", &["--regular", "9"]).unwrap();
        assert_eq!(found["grid"]["verdict"], verdict, "{axes}");
    }
}

/// Two corners of a cell on its space diagonal, which trilinear interpolation of the values joins and that of their signs does not.
#[test]
fn trilinear_knows_grey_values() {
    let of = |other: f32| {
        let mut file =
            b"NRRD0004\ntype: float\ndimension: 3\nsizes: 2 2 2\nencoding: raw\nendian: little\n\
            spacings: 1 1 1\n\n"
                .to_vec();
        for value in [1.0, other, other, other, other, other, 2.0 * other, 1.0] {
            file.extend(f32::to_le_bytes(value));
        }
        let found =
            figures_of(&file, "nrrd", &["--threshold", "0", "--method", "trilinear", "--pad"])
                .unwrap();
        assert_eq!(found["mesh"]["closed"], true);
        found["topology"]["surfaces"].as_array().unwrap().len()
    };
    assert_eq!(of(-0.01), 1);
    assert_eq!(of(-1.0), 2);
}

/// The reach of a sphere is its radius: r / √3 is asked of the spacing. Of the part beside the face nothing is proved.
#[test]
fn a_nominal_asks_for_a_spacing() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("cap.toml");
    let of = |radius: &str, aperture: &str| {
        let text = format!(
            "[surface]\nkind = \"sphere\"\nradius_mm = {radius}\n[aperture]\nshape = \"circle\"\nradius_mm = {aperture}\n"
        );
        std::fs::write(&path, text).unwrap();
        let more = ["--spacing", "0.1", "--nominal", path.to_str().unwrap()];
        figures_of(&ball(), "vol", &more).unwrap()["grid"].clone()
    };
    let found = of("-0.9", "0.5");
    assert_eq!(
        (&found["verdict"], &found["nominal"]["verdict"]),
        (&"unknown".into(), &"proved".into())
    );
    let number = |name: &str| found["nominal"][name].as_f64().unwrap();
    assert!((number("reach_mm") - 0.9).abs() < 0.01, "{found}");
    assert!((number("needed_spacing_mm") - 0.9 / 3.0_f64.sqrt()).abs() < 0.01, "{found}");
    assert!((number("margin") - 9.0 / 3.0_f64.sqrt()).abs() < 0.1, "{found}");
    // Too sharp for a spacing of 0.1 mm.
    assert_eq!(of("-0.15", "0.1")["nominal"]["verdict"], "contradicted");
    std::fs::write(&path, "[surface]\nkind = \"sphere\"\nradius_mm = 5\n").unwrap();
    let more = ["--spacing", "0.1", "--nominal", path.to_str().unwrap()];
    let said = figures_of(&ball(), "vol", &more).unwrap_err();
    assert!(said.contains("expected an [aperture]"), "{said}");
}

/// With a nominal the report has the form of its face, the same as that of `asphera measure`; of a volume without that face it says why
/// not.
#[test]
fn a_nominal_gives_the_form_of_its_face() {
    let dir = tempfile::tempdir().unwrap();
    let laid = lay_out(dir.path(), &CtScene::lens(0.25)).unwrap();
    let progress = Progress::start("test");
    let measured = laid.measured(&progress).unwrap().first.report.form.unwrap();
    let mut words =
        vec!["asphera".into(), "volume".into(), laid.volume.clone(), "--nominal".into()];
    words.push(laid.nominals[0].clone());
    let cli = Cli::try_parse_from(words).unwrap();
    let Command::Volume(args) = cli.command else { panic!("another command") };
    let opened = opened::open(&args, u64::MAX).unwrap();
    let surface = meshed::of(&args, &opened, &[]).unwrap();
    let face = part(&laid.nominals[0]).unwrap();
    let mut report = figures::of(&args, &opened, &surface, Some(&face)).unwrap();
    let mut without = figures::of(&args, &opened, &surface, None).unwrap();
    let volume = opened.into_volume().unwrap();
    form::add(&mut report, &args, (&face, Some(volume.clone())), &progress);
    assert_eq!(report.form.as_ref(), Some(&measured), "{:?}", report.reasons);
    let notes = report.reasons.join("\n");
    assert!(notes.contains("face: its threshold is 18000"), "{notes}");
    assert!(notes.contains("face: form in waves shorter than"), "{notes}");
    // There is no ring as far out.
    let far = dir.path().join("far.toml");
    let ring = "[surface]\nkind = \"plane\"\n[aperture]\nshape = \"annulus\"\ninner_radius_mm = 50\nouter_radius_mm = 60\n";
    std::fs::write(&far, ring).unwrap();
    form::add(&mut without, &args, (&part(&far).unwrap(), Some(volume)), &progress);
    let why = without.reasons.last().unwrap();
    assert!(without.form.is_none() && why.starts_with("no form of the face: "), "{why}");
}
