//! The same surface in every kind of file: whole reports are compared.
//!
//! Heights are whole multiples of 2⁻³² m and places of 2⁻¹² m, which every format holds to the last bit. Files whose origin is
//! the corner then have the same report but for `reading` and `timing`, with no figure left out. Points of a
//! session carry flags and links that no file has; that a replay gives the report of its session is tested elsewhere.

use std::fmt::Write as _;
use std::path::{Path, PathBuf};

use asphera_formats::{HeightMap, x3p};
use asphera_tests::{json, run};
use serde_json::Value;

const NX: usize = 33;
const NY: usize = 25;
/// Distance of columns and rows, 2⁻¹² m.
const PITCH_MM: f64 = 1000.0 / 4096.0;
/// One step of the heights, 2⁻³² m.
const STEP_M: f64 = 1.0 / 4_294_967_296.0;

/// The number of steps of a height; `None` where nothing was measured. A sphere of 60 mm about the middle, with astigmatism,
/// a wave and roughness.
fn steps(column: usize, row: usize) -> Option<i32> {
    if (column, row) == (20, 7) {
        return None;
    }
    let [x, y] =
        [(column, NX), (row, NY)].map(|(at, of)| (at as f64 - 0.5 * (of - 1) as f64) * PITCH_MM);
    let sphere_mm = 60.0 - (3600.0 - x * x - y * y).sqrt();
    let rough = ((column * 7919 + row * 104_729) % 101) as f64 / 50.0 - 1.0;
    let nm = 4.0 * (x * x - 0.7 * y * y) + 9.0 * (2.0 * x + y).sin() + 3.0 * rough;
    Some(((sphere_mm * 1e-3 + nm * 1e-9) / STEP_M).round() as i32)
}

fn z_mm(column: usize, row: usize) -> f64 {
    steps(column, row).map_or(f64::NAN, |steps| f64::from(steps) * STEP_M * 1000.0)
}

/// Columns and rows in the order in which maps list their points.
fn places() -> impl Iterator<Item = (usize, usize)> {
    (0..NY).flat_map(|row| (0..NX).map(move |column| (column, row)))
}

/// Lines of x, y, z.
fn lines(separator: &str, number: impl Fn(f64) -> String) -> String {
    places().fold(String::new(), |mut text, (column, row)| {
        let [x, y] = [column, row].map(|at| number(at as f64 * PITCH_MM));
        let z = z_mm(column, row);
        let z = if z.is_nan() { "NaN".to_owned() } else { number(z) };
        writeln!(text, "{x}{separator}{y}{separator}{z}").unwrap();
        text
    })
}

fn sdf(binary: bool) -> Vec<u8> {
    let stored = |(column, row)| steps(column, row).unwrap_or(i32::MIN);
    if !binary {
        let mut text = format!(
            "aISO-1.0\nManufacID = TEST\nNumPoints = {NX}\nNumProfiles = {NY}\nXscale = {0:e}\nYscale = {0:e}\nZscale = {STEP_M:e}\n\
             Zresolution = 1e-9\nCompression = 0\nDataType = 6\nCheckType = 0\n*\n",
            PITCH_MM / 1000.0
        );
        for place in places() {
            match steps(place.0, place.1) {
                Some(steps) => writeln!(text, "{steps}").unwrap(),
                None => text.push_str("BAD\n"),
            }
        }
        return format!("{text}*\n").into_bytes();
    }
    let mut bytes = b"bISO-1.0TEST\0\0\0\0\0\x00040120100853050320101353".to_vec();
    bytes.extend((NX as u16).to_le_bytes());
    bytes.extend((NY as u16).to_le_bytes());
    for scale_m in [PITCH_MM / 1000.0, PITCH_MM / 1000.0, STEP_M, 1e-9] {
        bytes.extend(scale_m.to_le_bytes());
    }
    bytes.extend(b"\0\x06\0");
    bytes.extend(places().flat_map(|place| stored(place).to_le_bytes()));
    bytes
}

/// Header format 1; S 0.5, O 2, W 2⁻²⁰ m, R 4096.
fn metropro() -> Vec<u8> {
    let mut bytes = vec![0; 834];
    let mut put = |offset: usize, field: &[u8]| {
        bytes[offset..offset + field.len()].copy_from_slice(field);
    };
    put(0, b"\x88\x1B\x03\x6F\x00\x01\x00\x00\x03\x42");
    put(68, &(NX as u16).to_be_bytes());
    put(70, &(NY as u16).to_be_bytes());
    put(72, &(4 * (NX * NY) as u32).to_be_bytes());
    for (offset, value) in
        [(164, 0.5_f32), (168, 2.0_f32.powi(-20)), (176, 2.0), (184, 2.0_f32.powi(-12))]
    {
        put(offset, &value.to_be_bytes());
    }
    for row in (0..NY).rev() {
        for column in 0..NX {
            bytes.extend(steps(column, row).unwrap_or(i32::MAX).to_be_bytes());
        }
    }
    bytes
}

fn x3p_file() -> Vec<u8> {
    let z_mm = places().map(|(column, row)| z_mm(column, row)).collect();
    let map = HeightMap {
        nx: NX,
        ny: NY,
        dx_mm: PITCH_MM,
        dy_mm: PITCH_MM,
        x0_mm: 0.0,
        y0_mm: 0.0,
        z_mm,
    };
    let metadata = x3p::Metadata {
        date: "2026-01-31T12:00:00.0Z",
        calibration_date: "2026-01-01T00:00:00.0Z",
        creator: None,
        manufacturer: "asphera",
        model: "test",
        serial: "1",
        version: "1",
        probing: x3p::Probing::Software,
        probe: "none",
        comment: None,
    };
    let mut bytes = Vec::new();
    x3p::write_map(&mut bytes, &map, &metadata).unwrap();
    bytes
}

/// Vertices alone, those without a height too.
fn ply(binary: bool) -> Vec<u8> {
    let format = if binary { "binary_little_endian" } else { "ascii" };
    let head = format!(
        "ply\nformat {format} 1.0\ncomment coordinates in mm\nelement vertex {}\nproperty double x\nproperty double y\n\
         property double z\nend_header\n",
        NX * NY
    );
    let mut bytes = head.into_bytes();
    if binary {
        for (column, row) in places() {
            let [x, y] = [column, row].map(|at| at as f64 * PITCH_MM);
            bytes.extend([x, y, z_mm(column, row)].iter().flat_map(|number| number.to_le_bytes()));
        }
    } else {
        bytes.extend(lines(" ", |number| number.to_string()).into_bytes());
    }
    bytes
}

fn matrix() -> String {
    (0..NY).rev().fold(String::new(), |mut text, row| {
        let row: Vec<String> = (0..NX).map(|column| z_mm(column, row).to_string()).collect();
        writeln!(text, "{}", row.join(" ")).unwrap();
        text
    })
}

/// The origin of a grid sag is its middle.
fn grid_sag() -> String {
    let mut text = format!("{NX} {NY} {PITCH_MM} {PITCH_MM} 0 0 0\n");
    for row in (0..NY).rev() {
        for column in 0..NX {
            let z = z_mm(column, row);
            match z.is_nan() {
                true => text.push_str("NaN 0 0 0 0\n"),
                false => writeln!(text, "{z} 0 0 0 0").unwrap(),
            }
        }
    }
    text
}

fn utf16(text: &str) -> Vec<u8> {
    std::iter::once(0xFEFF).chain(text.encode_utf16()).flat_map(u16::to_le_bytes).collect()
}

/// A report without what may differ: how text was read, and how long it took.
fn report(folder: &Path, name: &str, bytes: &[u8], nominal: &Path, more: &[&str]) -> Value {
    let file: PathBuf = folder.join(name);
    std::fs::write(&file, bytes).unwrap();
    let mut arguments =
        vec!["measure", file.to_str().unwrap(), "--nominal", nominal.to_str().unwrap(), "--json"];
    arguments.extend(more);
    let output = run(&arguments);
    assert!(!output.stdout.is_empty(), "{name}: {}", String::from_utf8_lossy(&output.stderr));
    let mut report = json(&output);
    let report_map = report.as_object_mut().unwrap();
    report_map.remove("reading");
    report_map.remove("timing");
    report
}

/// Where two reports differ by more than rounding.
fn differences(place: &str, a: &Value, b: &Value, found: &mut Vec<String>) {
    match (a, b) {
        (Value::Object(a), Value::Object(b)) if a.keys().eq(b.keys()) => {
            for (key, value) in a {
                differences(&format!("{place}/{key}"), value, &b[key], found);
            }
        }
        (Value::Array(a), Value::Array(b)) if a.len() == b.len() => {
            for (index, (a, b)) in a.iter().zip(b).enumerate() {
                differences(&format!("{place}/{index}"), a, b, found);
            }
        }
        _ if a == b => {}
        _ => found.push(format!("{place}: {a} and {b}")),
    }
}

const FIGURES: &str = "[figures]\nminimum_zone = true\npsd = true\n[figures.texture]\nl_mm = 2\n";

fn nominals() -> [(&'static str, String); 2] {
    let sphere = format!(
        "[surface]\nkind = \"sphere\"\nradius_mm = 60\n[fit]\nfree = [\"tx\", \"ty\", \"tz\", \"radius\"]\n{FIGURES}\
         [tolerance]\npv_nm = 200\nrms_nm = 100\n[uncertainty]\nnoise_nm = 2\n"
    );
    let plane =
        format!("[surface]\nkind = \"plane\"\n[fit]\nfree = [\"tz\", \"rx\", \"ry\"]\n{FIGURES}");
    [("sphere", sphere), ("plane", plane)]
}

#[test]
fn whole_reports_are_the_same_to_the_last_bit() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let plain = lines(" ", |number| number.to_string());
    for (kind, nominal) in nominals() {
        let path = folder.join(format!("{kind}.toml"));
        std::fs::write(&path, nominal).unwrap();
        let first = report(folder, "plain.xyz", plain.as_bytes(), &path, &[]);
        assert!(first["form"]["figures"].as_array().unwrap().len() > 10, "{:#}", first["verdict"]);
        let comma = lines("\t", |number| number.to_string().replace('.', ","));
        let pitch = format!("{PITCH_MM}");
        let files: [(&str, Vec<u8>, Vec<&str>); 10] = [
            (
                "head.csv",
                format!("x_mm,y_mm,z_mm\n{}", plain.replace(' ', ",")).into_bytes(),
                vec![],
            ),
            ("comma.txt", comma.into_bytes(), vec!["--unit", "mm"]),
            ("wide.xyz", utf16(&plain.replace('\n', "\r\n")), vec![]),
            ("matrix.txt", matrix().into_bytes(), vec!["--pitch", &pitch, "--unit", "mm"]),
            ("text.sdf", sdf(false), vec![]),
            ("binary.sdf", sdf(true), vec![]),
            ("zygo.dat", metropro(), vec![]),
            ("map.x3p", x3p_file(), vec![]),
            ("text.ply", ply(false), vec![]),
            ("binary.ply", ply(true), vec![]),
        ];
        for (name, bytes, more) in files {
            let other = report(folder, name, &bytes, &path, &more);
            let mut found = Vec::new();
            differences("", &first, &other, &mut found);
            assert!(found.is_empty(), "{kind}, {name}:\n{}", found.join("\n"));
        }
    }
}

/// Numbers in µm are divided by 1000, and the origin of a grid sag is its middle: what differs is rounding, below a millionth,
/// in the whole report. With the origin move places in the measured frame, and estimates of uncertainty a little.
#[test]
fn reports_do_not_depend_on_unit_and_origin() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let [(_, sphere), _] = nominals();
    let path = folder.join("sphere.toml");
    std::fs::write(&path, sphere).unwrap();
    let plain = lines(" ", |number| number.to_string());
    let plain = report(folder, "plain.xyz", plain.as_bytes(), &path, &[]);
    let um = lines(" ", |number| (number * 1e3).to_string());
    let um = report(folder, "um.xyz", format!("# x y z in um\n{um}").as_bytes(), &path, &[]);
    let sag = report(folder, "sag.dat", grid_sag().as_bytes(), &path, &[]);
    for (name, other, moved) in [("um", um, &[][..]), ("grid sag", sag, &MOVED[..])] {
        let mut far = Vec::new();
        apart("", &plain, &other, &mut far);
        far.retain(|line| !moved.iter().any(|place| line.starts_with(place)));
        if !moved.is_empty() {
            far.retain(|line| !ESTIMATED.iter().any(|of| line.contains(of)));
        }
        assert!(far.is_empty(), "{name}:\n{}", far.join("\n"));
    }
}

/// Places of the measured frame along x and y.
const MOVED: [&str; 8] = [
    "/form/fit/parameters/tx/value:",
    "/form/fit/parameters/ty/value:",
    "/form/fit/pose/tx_mm:",
    "/form/fit/pose/ty_mm:",
    "/form/origin/at_mm/0:",
    "/form/origin/at_mm/1:",
    "/sampling/at_max_mm/0:",
    "/sampling/at_max_mm/1:",
];

/// Estimates of uncertainty of patches and draws. On an exact raster, rounding decides to which of two patches a point between
/// them belongs; a file whose origin is elsewhere rounds otherwise.
const ESTIMATED: [&str; 10] = [
    "/simulated/",
    "/deviation/uncertainty/",
    "/fit/correlation/",
    "/fit/covariance/",
    "/fit/cautions/",
    "/u:",
    "/u_by_form:",
    "/expanded_95:",
    "/guard_band:",
    "/interval_95/",
];

/// As [`differences`], of numbers by more than a millionth and 1e-6 of their unit.
fn apart(place: &str, a: &Value, b: &Value, found: &mut Vec<String>) {
    match (a, b) {
        (Value::Object(a), Value::Object(b)) if a.keys().eq(b.keys()) => {
            for (key, value) in a {
                apart(&format!("{place}/{key}"), value, &b[key], found);
            }
        }
        (Value::Array(a), Value::Array(b)) if a.len() == b.len() => {
            for (index, (a, b)) in a.iter().zip(b).enumerate() {
                apart(&format!("{place}/{index}"), a, b, found);
            }
        }
        (Value::Number(x), Value::Number(y)) => {
            let (x, y) = (x.as_f64().unwrap(), y.as_f64().unwrap());
            if (x - y).abs() > 1e-6 * x.abs().max(1.0) {
                found.push(format!("{place}: {x} and {y}"));
            }
        }
        _ if a == b => {}
        _ => found.push(format!("{place}: {a} and {b}")),
    }
}
