//! The command from its arguments to its files: trays whose truth is known, and libraries that are none.

use std::path::Path;

use asphera_rig::TrayScene;
use clap::Parser as _;
use serde_json::Value;
use tempfile::TempDir;

use super::run;
use crate::cli::demo::tray::lay_out;
use crate::cli::exit::Exit;
use crate::cli::{Cli, Command};

/// A folder with `tray.xyz`, `library` and `truth.json`.
fn tray(seed: u64) -> TempDir {
    let folder = tempfile::tempdir().unwrap();
    lay_out(folder.path(), &TrayScene::lenses(seed), false).unwrap();
    folder
}

/// Runs `asphera parts` on a file of a folder with its library.
fn done(folder: &Path, file: &str, more: &[&str]) -> Result<(Exit, Value), String> {
    let [file, library, out] =
        [file, "library", "out"].map(|name| folder.join(name).display().to_string());
    let mut words =
        vec!["asphera", "parts", &file, "--library", &library, "--out", &out, "--force", "--json"];
    words.extend(more);
    let cli = Cli::try_parse_from(words).map_err(|error| error.to_string())?;
    let Command::Parts(args) = cli.command else { panic!("another command") };
    let exit = run(&args).map_err(|error| error.to_string())?;
    let text = std::fs::read(folder.join("out/parts.json")).unwrap();
    Ok((exit, serde_json::from_slice(&text).unwrap()))
}

fn number(value: &Value) -> f64 {
    value.as_f64().unwrap_or_else(|| panic!("no number: {value}"))
}

fn place(value: &Value) -> [f64; 3] {
    [0, 1, 2].map(|axis| number(&value[axis]))
}

/// The part of a report that lies nearest to a place.
fn at(found: &Value, place_mm: [f64; 3]) -> &Value {
    let parts = found["parts"].as_array().unwrap();
    let from = |part: &&Value| {
        let [x, y, _] = place(&part["centre_mm"]);
        (x - place_mm[0]).hypot(y - place_mm[1])
    };
    parts.iter().min_by(|a, b| from(a).total_cmp(&from(b))).unwrap()
}

#[test]
fn the_parts_of_a_tray_are_recognised_and_measured() {
    let folder = tray(1);
    let (exit, found) = done(folder.path(), "tray.xyz", &["--measure"]).unwrap();
    let truth: Value =
        serde_json::from_slice(&std::fs::read(folder.path().join("truth.json")).unwrap()).unwrap();
    assert_eq!((exit, &found["format"]), (Exit::Done, &"asphera.parts/1".into()));
    assert_eq!(found["parts"].as_array().unwrap().len(), 8);
    assert_eq!(found["island_points"], truth["dust_points"]);
    for true_part in truth["parts"].as_array().unwrap() {
        let part = at(&found, place(&true_part["place_mm"]));
        let name = true_part["name"].as_str().unwrap();
        let (matched, form) = (&part["match"], &part["form"]);
        assert_eq!(matched["name"], format!("{name}.toml"), "{part}");
        assert_eq!(matched["verdict"], "confirmed", "{part}");
        // Where lenses touch some points may go to the other one.
        let touches = number(&true_part["place_mm"][1]) > 40.0 && name == "convex-asphere";
        let lost = number(&part["points"]) - number(&true_part["points"]);
        assert!(lost.abs() <= if touches { 15.0 } else { 0.0 }, "{lost} of {part}");
        assert_eq!((&part["loops"], &matched["pose"]["face"]), (&true_part["loops"], &"up".into()));
        assert!(number(&matched["score"]) > 0.8 && number(&matched["margin"]) > 0.5, "{matched}");
        // A coarse pose is some hundredths of a millimetre off.
        let [coarse, fine, right] =
            [&matched["pose"], form, true_part].map(|of| place(&of["place_mm"]));
        // Of a sphere or a plane the place moves with what its points do not feel.
        let number_of_part = found["parts"].as_array().unwrap().iter().position(|one| one == part);
        let file = format!("out/part-{}/report.json", number_of_part.unwrap() + 1);
        let report: Value =
            serde_json::from_slice(&std::fs::read(folder.path().join(file)).unwrap()).unwrap();
        let u_mm = number(&report["form"]["fit"]["parameters"]["tz"]["u"]).max(
            ["tx", "ty"]
                .iter()
                .filter_map(|name| report["form"]["fit"]["parameters"][name]["u"].as_f64())
                .fold(0.0, f64::max),
        );
        let is_fixed = name == "convex-asphere";
        for axis in 0..3 {
            assert!((coarse[axis] - right[axis]).abs() < 0.15, "{name} {coarse:?} {right:?}");
            let off_mm = (fine[axis] - right[axis]).abs();
            assert!(!is_fixed || off_mm < 5.0 * u_mm, "{name} {fine:?} {u_mm}");
        }
        assert!(!is_fixed || u_mm < 0.01, "{u_mm}");
        // A part alone has the figures that `measure` gives.
        assert_eq!(report["form"]["deviation"]["rms_nm"], form["rms_nm"]);
        let tilt_deg = number(&true_part["tilt_deg"]);
        assert!((number(&matched["pose"]["tilt_deg"]) - tilt_deg).abs() < 0.2, "{matched}");
        // Five times u, for forty figures are looked at.
        let rms_nm = number(&form["rms_without_noise_nm"]);
        let off_nm = (rms_nm - number(&true_part["rms_nm"])).abs();
        assert!(off_nm < 5.0 * number(&form["u_rms_nm"]), "{name} {form} {true_part}");
    }
    assert!(folder.path().join("out/part-8.ply").is_file());
    // The first point lies in the concave lens, the last is dust.
    let bytes = std::fs::read(folder.path().join("out/points.ply")).unwrap();
    let points = found["points"].as_u64().unwrap() as usize;
    let body = &bytes[bytes.len() - 28 * points..];
    assert!(bytes[..bytes.len() - 28 * points].ends_with(b"end_header\n"));
    let part = |row: usize| i32::from_le_bytes(body[28 * row + 24..][..4].try_into().unwrap());
    let concave = found["parts"].as_array().unwrap();
    let concave = concave.iter().position(|part| part["match"]["name"] == "concave-sphere.toml");
    assert_eq!((part(0), part(points - 1)), (concave.unwrap() as i32 + 1, 0));
}

#[test]
fn a_part_that_the_library_lacks_and_one_that_it_has_twice_are_unknown() {
    let folder = tray(2);
    let library = folder.path().join("library");
    std::fs::remove_file(library.join("ring.toml")).unwrap();
    std::fs::copy(library.join("flat.toml"), library.join("window.toml")).unwrap();
    let (exit, found) = done(folder.path(), "tray.xyz", &[]).unwrap();
    let parts = found["parts"].as_array().unwrap();
    let unknown: Vec<&Value> =
        parts.iter().filter(|part| part["match"]["verdict"] == "unknown").collect();
    assert_eq!((exit, unknown.len()), (Exit::Done, 2));
    // A part that is not measured has no verdict: who asks for one does not get a pass.
    let (exit, _) = done(folder.path(), "tray.xyz", &["--measure"]).unwrap();
    assert_eq!(exit, Exit::Undecided);
    let of = |loops: u64| unknown.iter().find(|part| part["loops"] == loops).unwrap();
    let (flat, ring) = (&of(0)["match"], &of(1)["match"]);
    assert_eq!((number(&flat["margin"]), &flat["name"]), (0.0, &Value::Null));
    let reason = flat["reason"].as_str().unwrap();
    assert!(reason.contains("flat.toml and window.toml fit equally"), "{reason}");
    assert!(ring["reason"].as_str().unwrap().contains("nearest is"), "{ring}");
    assert!(ring.get("pose").is_none() && number(&ring["score"]) == 0.0, "{ring}");
}

/// Glue on a lens is no outline: the coarse fit leaves the worst fiftieth out, the measurement does not.
#[test]
fn a_fit_that_leaves_too_much_takes_the_match_back() {
    let folder = tray(3);
    let text = std::fs::read_to_string(folder.path().join("tray.xyz")).unwrap();
    let truth: Value =
        serde_json::from_slice(&std::fs::read(folder.path().join("truth.json")).unwrap()).unwrap();
    let lens =
        truth["parts"].as_array().unwrap().iter().find(|part| part["name"] == "concave-sphere");
    let [x, y, _] = place(&lens.unwrap()["place_mm"]);
    let mut glued = String::new();
    for line in text.lines() {
        let numbers: Vec<f64> = line.split(' ').filter_map(|word| word.parse().ok()).collect();
        match numbers[..] {
            [a, b, c] if (a - x - 4.0).hypot(b - y) < 1.0 => {
                glued += &format!("{a} {b} {}\n", c + 0.6);
            }
            [a, b, _] if (a - x).hypot(b - y) > 12.0 => {}
            _ => glued += &format!("{line}\n"),
        }
    }
    std::fs::write(folder.path().join("glued.xyz"), glued).unwrap();
    let (exit, found) = done(folder.path(), "glued.xyz", &[]).unwrap();
    assert_eq!(
        (exit, &found["parts"][0]["match"]["name"]),
        (Exit::Done, &"concave-sphere.toml".into())
    );
    let (exit, found) = done(folder.path(), "glued.xyz", &["--measure"]).unwrap();
    let matched = &found["parts"][0]["match"];
    assert_eq!((exit, &matched["verdict"]), (Exit::Undecided, &"unknown".into()));
    let reason = matched["reason"].as_str().unwrap();
    assert!(reason.starts_with("the fit leaves 0.0"), "{reason}");
    assert!(number(&found["parts"][0]["form"]["pv_nm"]) > 5e5);
}

/// A ring that lies on its side face up or down: a body, closed, whose triangles are written as STL.
fn ring_stl() -> String {
    let (inner, outer, half, steps) = (5.0, 10.5, 1.5, 96);
    let corner = |step: u32, radius: f64, z: f64| {
        let angle = f64::from(step % steps) * std::f64::consts::TAU / f64::from(steps);
        format!("vertex {} {} {z}\n", radius * angle.cos(), radius * angle.sin())
    };
    let mut text = "solid ring\n".to_owned();
    for step in 0..steps {
        // Across the wall, counter-clockwise where the way along it comes from behind.
        let around = [(inner, half), (outer, half), (outer, -half), (inner, -half)];
        for (side, &(radius, z)) in around.iter().enumerate() {
            let (next_radius, next_z) = around[(side + 1) % 4];
            let quad = [
                corner(step, radius, z),
                corner(step, next_radius, next_z),
                corner(step + 1, next_radius, next_z),
                corner(step + 1, radius, z),
            ];
            for [a, b, c] in [[0, 1, 2], [0, 2, 3]] {
                text += "facet normal 0 0 0\nouter loop\n";
                [a, b, c].iter().for_each(|&at: &usize| text += &quad[at]);
                text += "endloop\nendfacet\n";
            }
        }
    }
    text + "endsolid ring\n"
}

#[test]
fn meshes_and_scans_are_entries() {
    let folder = tray(4);
    let library = folder.path().join("library");
    std::fs::write(library.join("ring.stl"), ring_stl()).unwrap();
    std::fs::remove_file(library.join("ring.toml")).unwrap();
    // A scan of the flat as an earlier one; another seed laid it otherwise.
    let other = tray(5);
    let (_, found) = done(other.path(), "tray.xyz", &[]).unwrap();
    let parts = found["parts"].as_array().unwrap();
    let flat = parts.iter().position(|part| part["match"]["name"] == "flat.toml").unwrap() + 1;
    let scan = other.path().join(format!("out/part-{flat}.ply"));
    std::fs::rename(scan, library.join("flat.ply")).unwrap();
    std::fs::remove_file(library.join("flat.toml")).unwrap();
    let (_, found) = done(folder.path(), "tray.xyz", &["--measure"]).unwrap();
    let parts = found["parts"].as_array().unwrap();
    let of = |name: &str| {
        parts
            .iter()
            .find(|part| part["match"]["name"] == name)
            .unwrap_or_else(|| panic!("{name}: {found}"))
    };
    let ring = &of("ring.stl")["match"];
    assert_eq!((&ring["pose"]["face"], &ring["verdict"]), (&"either".into(), &"match".into()));
    assert!(of("flat.ply").get("form").is_none());
    assert_eq!(of("concave-sphere.toml")["match"]["verdict"], "confirmed");
}

/// Surface 2 is the concave face; the others are planes, or have no size.
#[test]
fn curved_surfaces_of_a_lens_file_are_entries() {
    let folder = tray(8);
    let library = folder.path().join("library");
    std::fs::remove_file(library.join("concave-sphere.toml")).unwrap();
    let curvature = 1.0 / 60.0;
    let lens = format!(
        "UNIT MM\nSURF 0\nSURF 1\n  CURV 0.0\n  DIAM 11\nSURF 2\n  CURV {curvature}\n  DIAM 9.0\nSURF 3\n  CURV 0.02\n"
    );
    std::fs::write(library.join("lens.zmx"), lens).unwrap();
    let (_, found) = done(folder.path(), "tray.xyz", &[]).unwrap();
    assert_eq!(found["entries"], 5);
    let parts = found["parts"].as_array().unwrap();
    assert!(parts.iter().any(|part| part["match"]["name"] == "lens.zmx 2"), "{found}");
    std::fs::write(library.join("flat.zmx"), "UNIT MM\nSURF 0\nSURF 1\n  DIAM 11\n").unwrap();
    let said = done(folder.path(), "tray.xyz", &[]).unwrap_err();
    assert!(said.contains("flat.zmx: expected a lens with a curved surface"), "{said}");
}

/// What a newcomer types first; and then the same tray as a file.
#[test]
fn the_demo_leaves_a_tray_its_library_its_truth_and_what_was_found() {
    let folder = tempfile::tempdir().unwrap();
    let demo = |more: &[&str]| {
        let words = ["asphera", "demo", "--scene", "tray", "--points", "12000", "--speed", "max"];
        let mut words = words.to_vec();
        words.extend(["--exit", "--json", "--out", folder.path().to_str().unwrap()]);
        words.extend(more);
        let Command::Demo(args) = Cli::try_parse_from(words).unwrap().command else { panic!() };
        crate::cli::demo::run(args).map_err(|error| error.to_string())
    };
    demo(&[]).unwrap();
    for name in ["tray.xyz", "truth.json", "library/ring.toml", "report.json"] {
        assert!(folder.path().join(name).is_file(), "{name}");
    }
    let (_, found) = done(folder.path(), "tray.xyz", &["--measure"]).unwrap();
    assert_eq!(found["parts"].as_array().unwrap().len(), 8);
    assert!(demo(&[]).unwrap_err().contains("is there already; --force overwrites it"));
    demo(&["--force"]).unwrap();
}

#[test]
fn a_library_that_is_none_is_refused_with_the_cure() {
    let folder = tempfile::tempdir().unwrap();
    let library = folder.path().join("library");
    std::fs::write(folder.path().join("tray.xyz"), "0 0 0\n").unwrap();
    let said = || done(folder.path(), "tray.xyz", &[]).unwrap_err();
    assert!(said().contains("library: expected a folder as the library"), "{}", said());
    std::fs::create_dir(&library).unwrap();
    std::fs::write(library.join(".hidden"), "").unwrap();
    assert!(said().contains("expected a library with one file at least, found none"), "{}", said());
    std::fs::write(library.join("notes.pdf"), "%PDF-1.4").unwrap();
    std::fs::write(library.join("line.xyz"), "x y z\n0 0 0\n1 1 1\n2 2 2\n").unwrap();
    std::fs::write(library.join("a.toml"), "[surface]\nkind = \"plane\"\n").unwrap();
    std::fs::write(library.join("b.toml"), "[surface]\nkind = \"plain\"\n").unwrap();
    std::fs::write(library.join("c.toml"), "[surface]\nkind = \"unknown\"\n").unwrap();
    let inside_out = ring_stl().replacen("vertex", "VERTEX", 1);
    let (first, others) = inside_out.split_once("endfacet").unwrap();
    let lines: Vec<&str> = first.lines().collect();
    let swapped = [&lines[..3], &[lines[4], lines[3]], &lines[5..]].concat().join("\n");
    std::fs::write(library.join("d.stl"), format!("{swapped}\nendfacet{others}")).unwrap();
    let said = said();
    for expected in [
        "notes.pdf: expected a file of",
        "line.xyz: 3 points: expected 12 different ones",
        "a.toml: a nominal without an aperture",
        "b.toml:",
        "c.toml: a nominal without a design",
        "d.stl: a closed mesh whose triangles do not all turn the same way",
    ] {
        assert!(said.contains(expected), "{expected}: {said}");
    }
    assert!(said.contains("take it out of the library"), "{said}");
}

#[test]
fn points_are_drawn_of_triangles_where_that_is_asked_for() {
    let folder = tray(6);
    std::fs::write(folder.path().join("ring.stl"), ring_stl()).unwrap();
    let (_, corners) = done(folder.path(), "ring.stl", &["--tau", "3"]).unwrap();
    let (_, drawn) = done(folder.path(), "ring.stl", &["--tau", "3", "--sample", "5000"]).unwrap();
    let (_, again) = done(folder.path(), "ring.stl", &["--tau", "3", "--sample", "5000"]).unwrap();
    let (_, other) =
        done(folder.path(), "ring.stl", &["--tau", "3", "--sample", "5000", "--seed", "2"])
            .unwrap();
    assert_eq!([&corners["points"], &drawn["points"]], [4 * 96, 5000]);
    assert_eq!(drawn, again);
    assert_ne!(drawn, other);
    let said = done(folder.path(), "tray.xyz", &["--sample", "100"]).unwrap_err();
    assert!(
        said.contains("expected a mesh with faces") && said.contains("leave --sample out"),
        "{said}"
    );
}

#[test]
fn threads_change_no_answer() {
    let folder = tray(7);
    let (_, one) = done(folder.path(), "tray.xyz", &["--threads", "1"]).unwrap();
    let (_, two) = done(folder.path(), "tray.xyz", &["--threads", "2"]).unwrap();
    assert_eq!(one, two);
}

/// A tray of half the size is recognised where sizes are free, and unknown where they count.
#[test]
fn parts_of_half_the_size_are_recognised_where_sizes_are_free() {
    let folder = tray(4);
    let points = std::fs::read_to_string(folder.path().join("tray.xyz")).unwrap();
    let halved = |line: &str| -> String {
        let halved = |word: &str| {
            word.parse::<f64>().map_or_else(|_| word.to_owned(), |mm| (mm / 2.0).to_string())
        };
        line.split_whitespace().map(halved).collect::<Vec<_>>().join(" ")
    };
    let text: Vec<String> = points
        .lines()
        .map(|line| if line.starts_with('#') { line.to_owned() } else { halved(line) })
        .collect();
    std::fs::write(folder.path().join("half.xyz"), text.join("\n")).unwrap();
    let names = |found: &Value| -> Vec<Value> {
        let parts = found["parts"].as_array().unwrap().iter();
        parts.map(|part| part["match"]["name"].clone()).collect()
    };
    let (_, whole) = done(folder.path(), "tray.xyz", &[]).unwrap();
    let (_, free) = done(folder.path(), "half.xyz", &["--scale-free"]).unwrap();
    let (_, counts) = done(folder.path(), "half.xyz", &[]).unwrap();
    assert!(names(&counts).iter().all(Value::is_null), "{counts}");
    let named: Vec<&Value> = free["parts"]
        .as_array()
        .unwrap()
        .iter()
        .filter(|part| !part["match"]["name"].is_null())
        .collect();
    // The pair that touches is one part of no entry.
    assert_eq!(named.len(), 6, "{free}");
    for part in named {
        let matched = &part["match"];
        assert!((number(&matched["scale"]) - 0.5).abs() < 0.01, "{matched}");
        let twice = place(&part["centre_mm"]).map(|mm| 2.0 * mm);
        assert_eq!(matched["name"], at(&whole, twice)["match"]["name"]);
    }
    let both = done(folder.path(), "half.xyz", &["--scale-free", "--measure"]).unwrap_err();
    assert!(both.contains("cannot be used with"), "{both}");
}

#[test]
fn results_do_not_go_into_the_library() {
    let folder = tray(4);
    let [file, library] = ["tray.xyz", "library"].map(|name| folder.path().join(name));
    let [file, library] = [&file, &library].map(|path| path.to_str().unwrap());
    let words = ["asphera", "parts", file, "--library", library, "--out", library, "--force"];
    let Command::Parts(args) = Cli::try_parse_from(words).unwrap().command else {
        panic!("another command")
    };
    let error = run(&args).unwrap_err().to_string();
    assert!(error.starts_with("--out and --library are both "), "{error}");
}
