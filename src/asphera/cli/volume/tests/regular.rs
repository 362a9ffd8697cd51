//! r by a mesh of the part.

use clap::Parser as _;

use super::super::run;
use super::{ball, figures_at, figures_of};
use crate::cli::{Cli, Command};

/// A ball of radius 0.9 mm as OFF: an octahedron whose facets are cut in four `cuts` times.
fn off(cuts: u32) -> String {
    let mut facets: Vec<[[f64; 3]; 3]> = (0..8)
        .map(|octant| {
            let sign = [0, 1, 2].map(|axis| if octant >> axis & 1 == 1 { -1.0 } else { 1.0 });
            let [a, b, c] = [[sign[0], 0.0, 0.0], [0.0, sign[1], 0.0], [0.0, 0.0, sign[2]]];
            if sign.iter().product::<f64>() > 0.0 { [a, b, c] } else { [a, c, b] }
        })
        .collect();
    for _ in 0..cuts {
        let middle = |a: [f64; 3], b: [f64; 3]| {
            let sum: [f64; 3] = std::array::from_fn(|axis| a[axis] + b[axis]);
            let length = sum.iter().map(|x| x * x).sum::<f64>().sqrt();
            sum.map(|x| x / length)
        };
        facets = facets
            .iter()
            .flat_map(|&[a, b, c]| {
                let [ab, bc, ca] = [middle(a, b), middle(b, c), middle(c, a)];
                [[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]]
            })
            .collect();
    }
    let mut text = format!("OFF\n{} {} 0\n", 3 * facets.len(), facets.len());
    for [x, y, z] in facets.iter().flatten() {
        text.push_str(&format!("{} {} {}\n", 0.9 * x, 0.9 * y, 0.9 * z));
    }
    for facet in 0..facets.len() {
        text.push_str(&format!("3 {} {} {}\n", 3 * facet, 3 * facet + 1, 3 * facet + 2));
    }
    text
}

/// A fine mesh proves the grid and gives certain bounds; a sharp one, and one that is open, prove nothing and say where.
#[test]
fn a_mesh_proves_r_unless_it_is_sharp_or_open() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("ball.vol");
    std::fs::write(&file, ball()).unwrap();
    let of = |text: &str| {
        let mesh = folder.path().join("part.off");
        std::fs::write(&mesh, text).unwrap();
        figures_at(
            &file,
            &["--spacing", "0.1", "--regular", mesh.to_str().unwrap(), "--unit", "mm"],
        )
        .unwrap()
    };
    let found = of(&off(4));
    let grid = &found["grid"];
    assert_eq!(grid["verdict"], "proved", "{grid}");
    let [r, reach] = ["proved_mm", "reach_mm"].map(|key| grid["mesh"][key].as_f64().unwrap());
    assert!(r <= 0.9005 && r > 0.5 && (reach - 0.9).abs() < 0.03, "{grid}");
    assert_eq!(grid["regular_mm"], grid["mesh"]["proved_mm"]);
    let truth = 4.0 / 3.0 * std::f64::consts::PI * 0.729;
    let bound = |key: &str| found["measures"]["volume_mm3"][key].as_f64().unwrap();
    assert!(bound("low") < truth && truth < bound("high"), "{found}");
    let sharp = of(&off(0))["grid"].clone();
    assert_eq!(
        (&sharp["verdict"], &sharp["regular_mm"]),
        (&"unknown".into(), &serde_json::Value::Null)
    );
    assert!(sharp["why"].as_str().unwrap().contains("an edge of 70.5°"), "{sharp}");
    let mut open = off(2);
    open.truncate(open.trim_end().rfind('\n').unwrap() + 1);
    let open = of(&open.replacen(" 128 0", " 127 0", 1))["grid"].clone();
    assert!(open["why"].as_str().unwrap().contains("bounds no body"), "{open}");
}

#[test]
fn a_mesh_that_cannot_be_read_is_said() {
    let said = |word: &str| {
        figures_of(&ball(), "vol", &["--spacing", "0.1", "--regular", word]).unwrap_err()
    };
    assert!(said("nowhere.stl").contains("nowhere.stl"));
    assert!(said("wide").contains("expected a length in mm above 0, found `wide`, and no name"));
}

#[test]
fn the_mesh_of_the_part_is_not_overwritten() {
    let folder = tempfile::tempdir().unwrap();
    let [volume, mesh] = ["v.nrrd", "part.stl"].map(|name| folder.path().join(name));
    std::fs::write(&volume, "").unwrap();
    std::fs::write(&mesh, off(0)).unwrap();
    let [volume, name] = [&volume, &mesh].map(|path| path.to_str().unwrap());
    let words = ["asphera", "volume", volume, "--regular", name, "--mesh", name, "--force"];
    let Command::Volume(args) = Cli::try_parse_from(words).unwrap().command else {
        panic!("another command")
    };
    let error = run(&args).unwrap_err().to_string();
    assert!(error.ends_with("part.stl is the file that is read; expected another"), "{error}");
    assert_eq!(std::fs::read_to_string(&mesh).unwrap(), off(0));
}

#[test]
fn a_unit_without_a_mesh_is_refused() {
    let Command::Volume(args) =
        Cli::try_parse_from(["asphera", "volume", "v.nrrd", "--unit", "um"]).unwrap().command
    else {
        panic!("another command")
    };
    let error = run(&args).unwrap_err().to_string();
    assert!(error.starts_with("--unit is that of a mesh in --regular"), "{error}");
}
