//! Real measured surfaces from files.

use std::path::Path;

use asphera_tests::{count, data, json, number, root, run};
use serde_json::Value;

fn measure(file: &Path, nominal: &str, more: &[&str]) -> Value {
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("nominal.toml");
    std::fs::write(&path, nominal).unwrap();
    let mut arguments =
        vec!["measure", file.to_str().unwrap(), "--nominal", path.to_str().unwrap(), "--json"];
    arguments.extend(more);
    let output = run(&arguments);
    assert_eq!(output.status.code(), Some(0), "{}", String::from_utf8_lossy(&output.stderr));
    let report = json(&output);
    assert!(number(&report, "/form/deviation/rms_nm").is_finite());
    assert!(number(&report, "/mesh/area_mm2") > 0.0);
    report
}

const PLANE: &str = "[surface]\nkind = \"plane\"\n[fit]\nfree = [\"tz\", \"rx\", \"ry\"]\n";
const LEVEL: &str = "[surface]\nkind = \"plane\"\n[fit]\nfree = [\"tz\"]\n";

fn assert_rms(report: &Value, rms_nm: f64, relative: f64) {
    let found = number(report, "/form/deviation/rms_nm");
    assert!((found / rms_nm - 1.0).abs() < relative, "RMS {found} nm, published {rms_nm} nm");
}

/// Sq 7.528822204734589e-8 m about the mean height is published with the file (SurfaceTopography's tests).
/// The figure published as "tilt removed", 3.911386e-9 m, is what remains after a general second-order
/// surface; after the plane it is 1.3334981370330653e-8 m, by NumPy's lstsq and by SurfaceTopography itself.
#[test]
fn metropro_map() {
    let Some(file) = data("topography/metropro-1.dat") else { return };
    let level = measure(&file, LEVEL, &[]);
    assert_rms(&level, 75.28822204734589, 1e-6);
    let limits = "[tolerance]\na_nm = 100\nrmst_nm = 20\nb_nm = 2000\nrmsi_nm = 10\n[uncertainty]\ndraws = 20\n";
    let report = measure(&file, &format!("{PLANE}{limits}"), &[]);
    assert_rms(&report, 13.334981370330653, 1e-6);
    about_the_middle(&report);
    assert_eq!(count(&report, "/points/used"), 640 * 480);
    let dx_mm = 0.702_881_3 / 640.0;
    let area = number(&report, "/mesh/area_mm2");
    // The surface is a little larger than its projection.
    let excess = area / (639.0 * 479.0 * dx_mm * dx_mm) - 1.0;
    assert!((0.0..1e-4).contains(&excess), "{area} mm²");
}

/// A, B, RMSt and RMSi about the middle of the map, by NumPy's lstsq over the heights SurfaceTopography reads: piston, tilt
/// and r² fitted together, each node weighted by the area of its cell (half at the border). About the corner from which the file
/// counts, A is 208.95 nm and RMSt 46.25 nm.
fn about_the_middle(report: &Value) {
    let truth = [
        ("A", "a_nm", 52.237914408279586),
        ("B", "b_nm", 1363.5662177581398),
        ("RMSt", "rmst_nm", 13.286031190963456),
        ("RMSi", "rmsi_nm", 6.7596583071044805),
    ];
    let named = |list: &str, name: &str| {
        let all = report.pointer(list).unwrap().as_array().unwrap();
        all.iter().find(|one| one["name"] == name).unwrap()["value"].as_f64().unwrap()
    };
    for (name, limit, nm) in truth {
        let [figure, check] = [named("/form/figures", name), named("/verdict/checks", limit)];
        assert!((figure / nm - 1.0).abs() < 1e-5, "{name} {figure} nm, not {nm} nm");
        assert!((check / figure - 1.0).abs() < 1e-9, "{name}: {figure} nm, but {check} nm judged");
    }
    assert_eq!(report["form"]["origin"]["place"], "middle of the points");
    // The middle of 640 by 480 nodes.
    let step_mm = 0.702_881_3 / 640.0;
    for (axis, middle_mm) in [(0, 319.5 * step_mm), (1, 239.5 * step_mm)] {
        let found = number(report, &format!("/form/origin/at_mm/{axis}"));
        assert!((found - middle_mm).abs() < 1e-6, "{found} mm, not {middle_mm} mm");
    }
    for term in report["form"]["zernike"]["terms"].as_array().unwrap() {
        assert!(term["value_nm"].as_f64().unwrap().abs() < 400.0, "{term}");
    }
}

/// Sq 7.728033273597876e-8 m about the mean height is published with the file.
#[test]
fn x3p_map() {
    let Some(file) = data("topography/x3p-2.x3p") else { return };
    assert_rms(&measure(&file, LEVEL, &[]), 77.28033273597876, 1e-6);
    let report = measure(&file, PLANE, &[]);
    assert_eq!(count(&report, "/mesh/vertices"), 650 * 650);
    assert_eq!(count(&report, "/mesh/triangles"), 2 * 649 * 649);
}

#[test]
fn sdf_map() {
    let Some(file) = data("topography/sdf-1.sdf") else { return };
    let report = measure(&file, PLANE, &[]);
    assert_eq!(count(&report, "/points/used"), 28);
}

/// The mirror's plane and sphere, and the same figures in another order and on another number of threads.
#[test]
fn mirror_as_points() {
    let Some(file) = data("mirrors/xmf_02_hyperbolic_cylinder.xyz") else { return };
    let report = measure(&file, PLANE, &["--threads", "1"]);
    assert_eq!(count(&report, "/points/used"), 106_048);
    let mut threaded = measure(&file, PLANE, &["--threads", "3"]);
    threaded["timing"] = report["timing"].clone();
    assert_eq!(threaded, report, "the thread count changed the result");
    let shuffled = measure(&file, PLANE, &["--shuffle", "11"]);
    for place in ["/form/deviation/rms_nm", "/form/deviation/pv_nm", "/mesh/area_mm2"] {
        let (found, had) = (number(&shuffled, place), number(&report, place));
        assert!((found / had - 1.0).abs() < 1e-9, "{place}: {found} shuffled, {had} in order");
    }
    assert_eq!(shuffled["mesh"]["triangles"], report["mesh"]["triangles"]);
    let sphere = "[surface]\nkind = \"sphere\"\nradius_mm = 80000\n[fit]\nfree = [\"tx\", \"ty\", \"tz\", \"radius\"]\n";
    let sphere = measure(&file, sphere, &[]);
    assert!(number(&sphere, "/form/deviation/rms_nm") < number(&report, "/form/deviation/rms_nm"));
}

/// A part made by formula, through a text file: the figures are those put in, and gaps stay gaps.
#[test]
fn asphere_with_gaps_from_text() {
    let dir = tempfile::tempdir().unwrap();
    let (radius, conic) = (11.65, -1.1);
    let mut text = String::from("# x y z in mm\n");
    let mut gaps = 0;
    for i in -60..=60 {
        for j in -60..=60 {
            let (x, y) = (f64::from(i) * 0.1, f64::from(j) * 0.1);
            let r2 = x * x + y * y;
            if r2 > 36.0 {
                continue;
            }
            if (i, j) == (5, 5) {
                text.push_str(&format!("{x},{y},nan\n"));
                gaps += 1;
                continue;
            }
            let c = 1.0 / radius;
            let z = c * r2 / (1.0 + (1.0 - (1.0 + conic) * c * c * r2).sqrt());
            // 10 nm up or down along z; along the normal it is less where the surface is steep.
            let z = z + if (i + j) % 2 == 0 { 1e-5 } else { -1e-5 };
            text.push_str(&format!("{x:.4},{y:.4},{z:.12}\n"));
        }
    }
    let file = dir.path().join("asphere.xyz");
    std::fs::write(&file, text).unwrap();
    // Up to 1.1 nm may stand out between the points.
    let nominal = format!(
        "[surface]\nkind = \"asphere\"\nradius_mm = {radius}\nconic = {conic}\n\
         [aperture]\nshape = \"circle\"\nradius_mm = 6.1\n[tolerance]\npv_nm = 25\nrms_nm = 12\n"
    );
    let out = dir.path().join("out");
    let report = measure(&file, &nominal, &["--out", out.to_str().unwrap()]);
    assert_eq!(count(&report, "/points/flagged/missing"), gaps);
    let rms = number(&report, "/form/deviation/rms_nm");
    assert!(rms > 8.0 && rms < 10.0, "{rms}");
    assert_eq!(report["verdict"]["status"], "pass");
    let map =
        asphera_formats::read("deviation.x3p", &std::fs::read(out.join("deviation.x3p")).unwrap())
            .unwrap();
    let largest = map.points().map(|[.., z]| z.abs()).fold(0.0, f64::max);
    assert!((8e-6..1.1e-5).contains(&largest), "{largest} mm in the X3P file");
    let again = measure(&out.join("deviation.x3p"), PLANE, &[]);
    assert!(count(&again, "/points/flagged/missing") > 100);
}

#[test]
fn the_nominals_of_the_examples_can_be_measured_against() {
    let dir = tempfile::tempdir().unwrap();
    let file = dir.path().join("flat.xyz");
    let rows = (0..400).map(|index| format!("{} {} 0\n", index % 20, index / 20));
    std::fs::write(&file, rows.collect::<String>()).unwrap();
    let nominal = root().join("config/examples/flat.toml");
    let output =
        run(["measure", file.to_str().unwrap(), "--nominal", nominal.to_str().unwrap(), "--json"]);
    // Points 1 mm apart are too far apart for this nominal: no pass, and the reason says so.
    assert_eq!(output.status.code(), Some(11));
    let report = json(&output);
    assert!(
        report["verdict"]["reasons"].to_string().contains("sampled densely enough"),
        "{report:#}"
    );
}

/// A cap of a sphere of 50 mm, or a plane, in µm.
fn in_micrometres(curved: bool) -> String {
    let places = (-20..=20).flat_map(|i| (-20..=20).map(move |j| (f64::from(i), f64::from(j))));
    let lines = places.map(|(i, j)| {
        let (x, y) = (0.5 * i, 0.5 * j);
        let z = if curved { 50.0 - (2500.0 - x * x - y * y).sqrt() } else { 1e-5 * (i - j).sin() };
        format!("{} {} {}\n", 1e3 * x, 1e3 * y, 1e3 * z)
    });
    lines.collect()
}

#[test]
fn points_in_micrometres_are_not_taken_for_millimetres_without_a_word() {
    let dir = tempfile::tempdir().unwrap();
    let [file, nominal] = ["points.xyz", "nominal.toml"].map(|name| dir.path().join(name));
    for (surface, curved) in
        [("kind = \"sphere\"\nradius_mm = 50", true), ("kind = \"plane\"", false)]
    {
        std::fs::write(&file, in_micrometres(curved)).unwrap();
        let text = format!(
            "[surface]\n{surface}\n[aperture]\nshape = \"circle\"\nradius_mm = 10\n[tolerance]\npv_nm = 100000\n"
        );
        std::fs::write(&nominal, text).unwrap();
        let measure = |more: &[&str]| {
            let mut all =
                vec!["measure", file.to_str().unwrap(), "--nominal", nominal.to_str().unwrap()];
            all.extend(more);
            run(&all)
        };
        let assumed = measure(&[]);
        let told = String::from_utf8_lossy(&assumed.stdout).into_owned();
        assert_eq!(assumed.status.code(), Some(11), "{told}");
        assert!(told.contains("The points seem to be in µm, not mm"), "{told}");
        assert!(told.contains("Add `--unit um`.") && told.contains("mm is assumed"), "{told}");
        let wrong = measure(&["--unit", "m"]);
        let told = String::from_utf8_lossy(&wrong.stdout).into_owned();
        assert_eq!(wrong.status.code(), Some(11), "{told}");
        assert!(told.contains("were read in m, as `--unit` says"), "{told}");
        assert!(told.contains("Give `--unit um` instead.") && !told.contains("Add `"), "{told}");
        let stated = measure(&["--unit", "um"]);
        let told = String::from_utf8_lossy(&stated.stdout).into_owned();
        assert_eq!(stated.status.code(), Some(0), "{told}");
        assert!(
            told.contains("x in column 1 in um, y in column 2 in um, z in column 3 in um\n"),
            "{told}"
        );
    }
}

/// Every command that reads points takes columns and units, and refuses what cannot be told.
#[test]
fn columns_and_units_are_for_every_command() {
    let dir = tempfile::tempdir().unwrap();
    let [file, nominal, out, html] =
        ["points.csv", "nominal.toml", "out.xyz", "out.html"].map(|name| dir.path().join(name));
    let numbered: String = in_micrometres(true)
        .lines()
        .enumerate()
        .map(|(index, line)| format!("{index},{}\n", line.replace(' ', ",")))
        .collect();
    std::fs::write(&file, numbered).unwrap();
    std::fs::write(&nominal, "[surface]\nkind = \"sphere\"\nradius_mm = 50\n").unwrap();
    let words = |path: &Path| path.to_str().unwrap().to_owned();
    let [file, nominal, out, html] = [&file, &nominal, &out, &html].map(|path| words(path));
    let commands: [Vec<&str>; 5] = [
        vec!["measure", &file, "--nominal", &nominal],
        vec!["sampling", &file],
        vec!["section", &file, "--line", "-5,0,5,0"],
        vec!["reduce", &file, "--epsilon", "0.1", "-o", &out, "--noise", "0"],
        vec!["report", &file, "--nominal", &nominal, "-o", &html],
    ];
    for command in commands {
        let refused = run(&command);
        let told = String::from_utf8_lossy(&refused.stderr).into_owned();
        assert_eq!(refused.status.code(), Some(1), "{command:?}: {told}");
        assert!(told.contains("4 columns without names") && told.contains("`--columns`"), "{told}");
        let mut told = command.clone();
        told.extend(["--columns", "2,3,4", "--unit", "um"]);
        let read = run(&told);
        let all = [read.stdout, read.stderr].concat();
        let all = String::from_utf8_lossy(&all).into_owned();
        assert!([Some(0), Some(11)].contains(&read.status.code()), "{told:?}: {all}");
        assert!(all.contains("x in column 2 in um"), "{told:?}: {all}");
    }
}
