//! Files exchanged with independent software: x3pio, SurfaceTopography and plyfile.
//!
//! `ASPHERA_PYTHON` names the interpreter, by default `python3`. Where it or a package is missing,
//! the test says so and ends.

#![expect(clippy::print_stderr, reason = "a test that cannot run here says so")]

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

use asphera_formats::{HeightMap, ReadError, Topography, ply, read, x3p};

const SCRIPT: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/readback.py");

fn python(arguments: &[&Path]) -> Option<Output> {
    let interpreter = std::env::var_os("ASPHERA_PYTHON").unwrap_or_else(|| "python3".into());
    Command::new(interpreter).args(arguments).output().ok()
}

/// Whether the interpreter can import a package.
fn has(package: &str) -> bool {
    let import = format!("import {package}");
    let has = python(&["-c".as_ref(), import.as_ref()]).is_some_and(|out| out.status.success());
    if !has {
        eprintln!("skipped: python package {package} not found");
    }
    has
}

/// Runs the script and returns what it prints.
fn run(arguments: &[&Path]) -> String {
    let output =
        python(&[&[Path::new(SCRIPT)], arguments].concat()).expect("the interpreter ran before");
    let error = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(output.status.success(), "{error}");
    String::from_utf8_lossy(&output.stdout).into_owned()
}

fn save_f64(path: &Path, values: impl IntoIterator<Item = f64>) {
    let bytes: Vec<u8> = values.into_iter().flat_map(f64::to_le_bytes).collect();
    fs::write(path, bytes).expect("the temporary folder can be written");
}

fn load_f64(path: &Path) -> Vec<f64> {
    let bytes = fs::read(path).expect("the script wrote this file");
    bytes.as_chunks::<8>().0.iter().map(|&bytes| f64::from_le_bytes(bytes)).collect()
}

/// Numbers that use every bit of the mantissa, the same every time (Knuth's MMIX generator).
fn noise() -> impl FnMut() -> f64 {
    let mut state = 20_260_131_u64;
    move || {
        state =
            state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 11) as f64 / (1_u64 << 53) as f64 - 0.5
    }
}

const METADATA: x3p::Metadata<'_> = x3p::Metadata {
    date: "2026-01-31T12:00:00.0+01:00",
    calibration_date: "2026-01-01T00:00:00.0Z",
    creator: Some("A & B"),
    manufacturer: "asphera",
    model: "µ-station",
    serial: "7",
    version: "0.1.0",
    probing: x3p::Probing::NonContacting,
    probe: "lens <3>",
    comment: Some("\"quoted\""),
};

#[test]
fn other_software_reads_what_is_written_bit_for_bit() {
    if !has("x3pio") {
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name);
    let mut noise = noise();

    let mut z_mm: Vec<f64> = (0..37 * 23).map(|_| noise()).collect();
    z_mm[100..140].fill(f64::NAN);
    let map = HeightMap { nx: 37, ny: 23, dx_mm: 0.1, dy_mm: 0.3, x0_mm: -1.7, y0_mm: 1e-3, z_mm };
    let mut file = Vec::new();
    x3p::write_map(&mut file, &map, &METADATA).unwrap();
    fs::write(path("map.x3p"), file).unwrap();
    let sizes = [map.nx as f64, map.ny as f64];
    let lengths_mm = [map.dx_mm, map.dy_mm, map.x0_mm, map.y0_mm];
    let in_metres = lengths_mm.iter().chain(&map.z_mm).map(|mm| mm / 1e3);
    save_f64(&path("map.f64"), sizes.into_iter().chain(in_metres));

    let points: Vec<[f64; 3]> = (0..50).map(|_| [noise(), noise(), noise()]).collect();
    let mut file = Vec::new();
    x3p::write_cloud(&mut file, &points, &METADATA).unwrap();
    fs::write(path("cloud.x3p"), file).unwrap();
    save_f64(&path("cloud.f64"), points.iter().flatten().map(|mm| mm / 1e3));

    let triangles: Vec<[u32; 3]> = (0..48).map(|first| [first, first + 1, first + 2]).collect();
    let mut deviation_mm: Vec<f64> = points.iter().map(|_| noise()).collect();
    deviation_mm[7] = f64::NAN;
    let mut file = Vec::new();
    let scalar = Some(("deviation_mm", &deviation_mm[..]));
    ply::write_mesh(&mut file, &points, &triangles, scalar, &["lengths in mm"]).unwrap();
    fs::write(path("mesh.ply"), file).unwrap();
    let rows = points.iter().zip(&deviation_mm).flat_map(|([x, y, z], d)| [*x, *y, *z, *d]);
    save_f64(&path("mesh.f64"), rows);
    let corners = triangles.iter().flatten().flat_map(|corner| corner.to_le_bytes());
    fs::write(path("mesh.i32"), corners.collect::<Vec<u8>>()).unwrap();

    let report = run(&["written".as_ref(), folder.path()]);
    eprint!("{report}");
    assert!(report.contains("same: x3pio, map, 851 values"));
    assert!(report.contains("same: x3pio, cloud, 150 values"));
}

#[test]
fn files_of_x3pio_give_the_points_it_gives() {
    if !has("x3pio") {
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    run(&["make".as_ref(), folder.path()]);
    let mut compared = 0;
    for name in [
        "shifted",
        "placed",
        "irregular",
        "irregular_placed",
        "cloud_placed",
        "map_int16",
        "map_int32",
        "map_float32",
        "cloud_int16",
        "cloud_int32",
        "cloud_float32",
    ] {
        for storage in ["binary", "xml"] {
            let path = folder.path().join(format!("{name}_{storage}.x3p"));
            let topography = read(&path.to_string_lossy(), &fs::read(&path).unwrap()).unwrap();
            let is_map = matches!(topography, Topography::Map(..));
            assert_eq!(is_map, name == "shifted" || name.starts_with("map"), "{name}");
            let missing = fs::read_to_string(path.with_extension("txt")).unwrap();
            assert_eq!(topography.missing().to_string(), missing, "{name}");
            let found: Vec<f64> = topography.points().flatten().collect();
            let expected = load_f64(&path.with_extension("f64"));
            assert_eq!(found.len(), expected.len(), "{name}");
            for (found, expected) in found.iter().zip(&expected) {
                // A few roundings of the largest term, 500 mm where there is an offset.
                let scale = if name.contains("placed") || name == "shifted" { 500.0 } else { 0.02 };
                assert!(
                    (found - expected).abs() <= 4.0 * f64::EPSILON * scale,
                    "{name} {found} {expected}"
                );
                compared += 1;
            }
        }
    }
    assert_eq!(compared, 11 * 2 * 74 * 3);
    for (name, place) in [("layers", "SizeZ"), ("profile", "FeatureType")] {
        let path = folder.path().join(format!("{name}.x3p"));
        let error = read(name, &fs::read(path).unwrap()).unwrap_err();
        assert!(matches!(error, ReadError::Unsupported { .. }), "{error}");
        assert!(error.to_string().contains(place), "{error}");
    }
}

/// Every height of the shared measurements, against SurfaceTopography.
#[test]
fn measured_maps_have_the_heights_surface_topography_gives() {
    if !has("SurfaceTopography") {
        return;
    }
    let data = std::env::var_os("ASPHERA_DATA").map_or_else(
        || PathBuf::from(concat!(env!("CARGO_MANIFEST_DIR"), "/../../../shared/data")),
        PathBuf::from,
    );
    let folder = tempfile::tempdir().unwrap();
    for (name, rows_go_down) in [
        ("topography/metropro-1.dat", true),
        ("topography/x3p-2.x3p", false),
        ("topography/sdf-1.sdf", false),
    ] {
        let path = data.join(name);
        let Ok(bytes) = fs::read(&path) else {
            eprintln!("skipped: {} not found", path.display());
            continue;
        };
        let Ok(Topography::Map(map, _)) = read(name, &bytes) else { panic!("{name} is no map") };
        let output = folder.path().join("heights.f64");
        run(&["heights".as_ref(), &path, &output]);
        let expected_m = load_f64(&output);
        assert_eq!(map.z_mm.len(), expected_m.len());
        for (index, z_mm) in map.z_mm.iter().enumerate() {
            let (column, row) = (index % map.nx, index / map.nx);
            let row = if rows_go_down { map.ny - 1 - row } else { row };
            let expected_mm = expected_m[row * map.nx + column] * 1e3;
            let near = (z_mm - expected_mm).abs() <= 4.0 * f64::EPSILON * expected_mm.abs();
            assert!(near, "{name}, column {column}, row {row}: {z_mm} {expected_mm}");
        }
    }
}
