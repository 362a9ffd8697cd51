//! Numbers at the border: absurd but valid ones in files, nominals and configurations end in a clear error or in
//! figures that are numbers, within 30 s of the processor and 6 GB of addresses.

use std::fmt::Write as _;
use std::fs::File;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::time::Duration;

use asphera_tests::{asphera, now};
use serde_json::Value;

/// What a command left.
struct Ended {
    code: Option<i32>,
    stdout: String,
    stderr: String,
}

/// A folder of files, and the commands that are run on them.
struct Bench {
    folder: tempfile::TempDir,
}

impl Bench {
    fn new() -> Bench {
        Bench { folder: tempfile::tempdir().unwrap() }
    }

    fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    fn file(&self, name: &str, content: impl AsRef<[u8]>) -> String {
        std::fs::write(self.path(name), content).unwrap();
        self.path(name).to_str().unwrap().to_owned()
    }

    /// Runs a command of the daemon with bounded time and memory. The time is that of the processor, so that what else a
    /// machine does is not counted.
    fn run(&self, arguments: &[&str]) -> Ended {
        let [out, err] = ["stdout", "stderr"].map(|name| self.path(name));
        let mut child = Command::new("sh")
            .args([
                "-c",
                &format!("ulimit -v {MEMORY_KIB} && ulimit -t {PROCESSOR_S} && exec \"$0\" \"$@\""),
            ])
            .arg(asphera())
            .args(arguments)
            .stdin(Stdio::null())
            .stdout(File::create(&out).unwrap())
            .stderr(File::create(&err).unwrap())
            .spawn()
            .unwrap();
        let by = now() + PATIENCE;
        let status = loop {
            if let Some(status) = child.try_wait().unwrap() {
                break status;
            }
            if now() > by {
                child.kill().unwrap();
                child.wait().unwrap();
                panic!("{arguments:?} still ran after {PATIENCE:?}");
            }
            std::thread::park_timeout(Duration::from_millis(5));
        };
        let text =
            |path: &Path| String::from_utf8_lossy(&std::fs::read(path).unwrap()).into_owned();
        Ended { code: status.code(), stdout: text(&out), stderr: text(&err) }
    }

    /// Runs a command and holds it to an end that a person can use.
    fn hold(&self, arguments: &[&str]) -> Ended {
        let ended = self.run(arguments);
        let Ended { code, stdout, stderr } = &ended;
        assert!(
            matches!(code, Some(0 | 1 | 2 | 10 | 11)),
            "{arguments:?} ended with {code:?}: {stderr}"
        );
        assert!(!stderr.contains("panicked"), "{arguments:?}: {stderr}");
        assert!(stderr.len() < 20_000, "{arguments:?} complained in {} bytes", stderr.len());
        let moves = |sign: char| sign.is_control() && sign != '\n';
        assert!(!stderr.contains(moves), "{arguments:?}: {stderr:?}");
        if matches!(code, Some(1 | 2)) {
            assert!(stderr.contains("error: "), "{arguments:?}: {stderr}");
        } else if arguments.contains(&"--json") {
            let report: Value = serde_json::from_str(stdout).unwrap();
            is_sound(&report, &format!("{arguments:?}"));
        }
        ended
    }

    /// The same of a command that must be refused; gives the words.
    fn refused(&self, arguments: &[&str]) -> String {
        let Ended { code, stderr, .. } = self.hold(arguments);
        assert_eq!(code, Some(1), "{arguments:?}: {stderr}");
        stderr
    }
}

/// No text of a report holds a number that is none, and a form has all its figures.
fn is_sound(report: &Value, what: &str) {
    let mut left = vec![report];
    while let Some(value) = left.pop() {
        match value {
            Value::Object(entries) => left.extend(entries.values()),
            Value::Array(entries) => left.extend(entries),
            Value::String(text) => {
                let mut words = text.split(|sign: char| !sign.is_alphanumeric());
                assert!(words.all(|word| word != "NaN" && word != "inf"), "{what}: {text}");
            }
            _ => {}
        }
    }
    if let Some(form) = report.get("form").filter(|form| !form.is_null()) {
        for figure in ["pv_nm", "rms_nm"] {
            assert!(form["deviation"][figure].is_f64(), "{what}: {figure} {}", form["deviation"]);
        }
    }
}

/// A paraboloid of 30 × 30 points, each coordinate made from the plain one.
fn points(made: impl Fn([f64; 3]) -> [f64; 3]) -> String {
    (0..900).fold(String::new(), |mut text, index| {
        let [x, y] = [index % 30, index / 30].map(|count| (f64::from(count) - 14.5) / 3.0);
        let [x, y, z] = made([x, y, 0.01 * (x * x + y * y)]);
        writeln!(text, "{x:e} {y:e} {z:e}").unwrap();
        text
    })
}

#[test]
fn coordinates_of_any_size_end_in_figures_or_words() {
    let bench = Bench::new();
    let nominal = bench.file("plane.toml", "[surface]\nkind = \"plane\"\n[tolerance]\npv_nm = 1\n");
    let sphere = bench.file("sphere.toml", "[surface]\nkind = \"sphere\"\nradius_mm = 50\n");
    for size in [1e308, 1e150, 1e15, 1e-40, 1e-308, 5e-324] {
        let clouds = [
            points(|[x, y, z]| [x * size / 5.0, y, z]),
            points(|[x, y, z]| [x, y, z * size]),
            points(|[x, y, z]| [x * size / 5.0, y * size / 5.0, z * size]),
            points(|[x, y, z]| [x + size, y - size, z + size]),
            points(|point| point) + &format!("0.1 0.1 {size:e}\n"),
        ];
        for cloud in clouds {
            let file = bench.file("points.xyz", cloud);
            bench.hold(&["measure", &file, "--nominal", &nominal, "--json"]);
            bench.hold(&["sampling", &file, "--json"]);
            bench.hold(&["section", &file, "--line=-1,0,3,1", "--json"]);
        }
        let file = bench.file("points.xyz", points(|point| point.map(|mm| mm * size / 5.0)));
        bench.hold(&["measure", &file, "--nominal", &sphere, "--json"]);
    }
    let far = bench.file("far.xyz", points(|[x, y, z]| [1e15 + x, y, z]));
    let words = bench.refused(&["section", &far, "--line", "0,0,1,1"]);
    assert!(words.contains("900 of 900 lie farther than 1e12 mm from the origin"), "{words}");
    let told = bench.hold(&["measure", &far, "--nominal", &nominal]).stdout;
    assert!(told.contains("there is no point to fit") && told.contains("Check the unit"), "{told}");
}

#[test]
fn a_million_points_in_one_place_or_on_a_line_end_soon() {
    let bench = Bench::new();
    let nominal = bench.file("plane.toml", "[surface]\nkind = \"plane\"\n");
    let place = bench.file("place.xyz", "1.5 2.5 3.5\n".repeat(1_000_000));
    let line = (0..1_000_000).map(|index| {
        let x = f64::from(index) * 1e-3;
        format!("{x} {} 0\n", 2.0 * x)
    });
    let line = bench.file("line.xyz", line.collect::<String>());
    for file in [&place, &line] {
        bench.hold(&["measure", file, "--nominal", &nominal, "--json"]);
        bench.hold(&["sampling", file, "--json"]);
    }
}

#[test]
fn nominals_of_any_size_end_in_figures_or_words() {
    let bench = Bench::new();
    let file = bench.file("points.xyz", points(|point| point));
    let mut surfaces: Vec<String> = Vec::new();
    for radius in ["1e308", "1e-300", "-0.0", "1e-5", "5e-324"] {
        surfaces.push(format!("kind = \"sphere\"\nradius_mm = {radius}\n"));
        surfaces
            .push(format!("kind = \"cylinder\"\nstraight_along = \"y\"\nradius_mm = {radius}\n"));
    }
    surfaces
        .push("kind = \"biconic\"\nradius_x_mm = 1e-5\nradius_y_mm = 50\nconic_x = 2\n".to_owned());
    for conic in ["1e308", "-1e308", "1e15"] {
        surfaces.push(format!("kind = \"conic\"\nradius_mm = 50\nconic = {conic}\n"));
        surfaces.push(format!(
            "kind = \"biconic\"\nradius_x_mm = 50\nradius_y_mm = 50\nconic_x = {conic}\n"
        ));
    }
    for surface in surfaces {
        let nominal = bench.file("nominal.toml", format!("[surface]\n{surface}"));
        bench.hold(&["nominal", &nominal]);
        bench.hold(&["measure", &file, "--nominal", &nominal, "--json"]);
    }
}

#[test]
fn grids_and_paths_of_any_size_end_in_figures_or_words() {
    let bench = Bench::new();
    let nominal = bench.file("plane.toml", "[surface]\nkind = \"plane\"\n");
    let matrix: String = (0..30).map(|row| format!("{row} 1 2 3 5 8 13 21\n")).collect();
    let matrix = bench.file("matrix.txt", matrix);
    for pitch in ["1e-20", "1e300", "5e-324", "1e-20,1e20"] {
        let pitch = format!("--pitch={pitch}");
        bench.hold(&["measure", &matrix, &pitch, "--nominal", &nominal, "--json"]);
        bench.hold(&["sampling", &matrix, &pitch, "--json"]);
    }
    let file = bench.file("points.xyz", points(|point| point));
    for path in
        ["--line=-1e308,0,1e308,0", "--circle=0,0,1e308", "--circle=0,0,1e-300", "--radius=1e308"]
    {
        bench.hold(&["section", &file, path, "--json"]);
    }
    for wish in ["--spacing=1e-300", "--spacing=1e308", "--epsilon=1e-300", "--rho=1e-300"] {
        let places = bench.path("places.csv");
        let places = places.to_str().unwrap();
        bench.hold(&["sampling", &file, wish, "--waypoints", places, "--force", "--json"]);
    }
}

/// Of the size that a head claims no memory is taken before the points are there.
#[test]
fn heads_that_claim_more_points_than_there_are_get_an_error() {
    let bench = Bench::new();
    let nominal = bench.file("plane.toml", "[surface]\nkind = \"plane\"\n");
    let array = |shape: &str| {
        let head = format!("{{'descr': '<f8', 'fortran_order': False, 'shape': {shape}, }}");
        let head = format!("{head:<117}\n");
        [&b"\x93NUMPY\x01\0\x76\0"[..], head.as_bytes(), &[0; 24]].concat()
    };
    let vertices = |format: &str, count: &str| {
        let axes = "property float x\nproperty float y\nproperty float z\nend_header\n0 0 0\n";
        format!("ply\nformat {format} 1.0\nelement vertex {count}\n{axes}").into_bytes()
    };
    let triangles = [&[0; 80][..], &[255; 4], &[0; 50]].concat();
    let profile = "aISO-1.0\nManufacID = A\nNumPoints = 1000000000\nNumProfiles = 1000000000\nXscale = 1e-6\n\
                   Yscale = 1e-6\nZscale = 1\nZresolution = 1\nCompression = 0\nDataType = 7\nCheckType = 0\n*\n1 2 3\n*\n";
    let mut scan = vec![0; 227];
    scan[..4].copy_from_slice(b"LASF");
    (scan[24], scan[25]) = (1, 2);
    scan[94..100].copy_from_slice(&[227, 0, 227, 0, 0, 0]);
    scan[105..111].copy_from_slice(&[20, 0, 255, 255, 255, 255]);
    let files: [(&str, Vec<u8>); 9] = [
        ("a.npy", array("(1000000000, 3)")),
        ("b.npy", array("(9223372036854775808, 3)")),
        ("c.npy", array("(18446744073709551615, 18446744073709551615)")),
        ("a.ply", vertices("ascii", "18446744073709551615")),
        ("b.ply", vertices("binary_little_endian", "1000000000")),
        ("a.stl", triangles),
        ("a.sdf", profile.into()),
        ("a.las", scan),
        ("a.grd", b"1000000000 1000000000 1 1 0 0 0\n0 0 0 0\n".into()),
    ];
    for (name, content) in files {
        let file = bench.file(name, content);
        let words = bench.refused(&["measure", &file, "--nominal", &nominal, "--json"]);
        assert!(words.contains(name), "{words}");
    }
}

/// 9²⁵⁴ mm high where the points end, and no aperture that could be held against it: feet were looked for over minutes.
#[test]
fn a_nominal_that_is_no_surface_where_the_points_end_is_refused() {
    let bench = Bench::new();
    let rows = (0..900).map(|at| [at % 30, at / 30].map(|side| f64::from(side) * 0.6 - 9.0));
    let points: String =
        rows.map(|[x, y]| format!("{x} {y} {}\n", (x * x + y * y) / 23.3)).collect();
    let points = bench.file("cap.xyz", points);
    for power in ["A254 = 1", "A20 = 1"] {
        let text = format!("[surface]\nkind = \"asphere\"\nradius_mm = 11.65\n{power}\n");
        let nominal = bench.file("high.toml", text);
        let words = bench.hold(&["measure", &points, "--nominal", &nominal]).stdout;
        assert!(words.contains("mm high 8.700000 mm from its axis"), "{words}");
    }
}

#[test]
fn texts_of_any_shape_are_refused_in_few_words() {
    let bench = Bench::new();
    let reference =
        std::fs::read_to_string(asphera_tests::root().join("config/asphera.toml")).unwrap();
    let keys: String = (0..50_000).map(|index| format!("key_{index} = 1\n")).collect();
    let devices = (0..50_000)
        .map(|index| format!("[device.d{index}]\nlink = \"probe\"\ndriver = \"chrocodile\"\n"));
    let deep =
        |open: &str, close: &str| format!("a = {}1{}\n", open.repeat(10_000), close.repeat(10_000));
    let texts = [
        format!("{keys}{reference}"),
        reference.replacen("[station]\n", &format!("[station]\n{keys}"), 1),
        format!("{reference}\n{}", devices.collect::<String>()),
        deep("[", "]"),
        deep("{a = ", "}"),
        format!("[{}a]\n", "a.".repeat(10_000)),
        format!("{} = 1\n{reference}", "k".repeat(1_000_000)),
        format!("[station]\nname = {}\n", "9".repeat(1_000_000)),
        format!("[station]\nmane = \"{}\"\n", "s".repeat(10_000_000)),
        "[surface]\nkind = \"plane\"\n\"\\u001b[2J\" = 1\n".to_owned(),
    ];
    for text in texts {
        let file = bench.file("file.toml", text);
        bench.refused(&["check", "--config", &file]);
        bench.refused(&["nominal", &file]);
    }
    let endless = bench.file("grid.toml", "[surface]\nkind = \"grid\"\nfile = \"/dev/zero\"\n");
    let words = bench.refused(&["nominal", &endless]);
    assert!(words.contains("/dev/zero"), "{words}");
    let words =
        bench.refused(&["export", "/dev/zero", "-o", bench.path("o.xyz").to_str().unwrap()]);
    assert!(words.contains("/dev/zero"), "{words}");
}

/// Time of the processor a command may take: far more than any of these needs in a debug build.
const PROCESSOR_S: u32 = 30;
/// For a command that waits without working, however busy the machine is.
const PATIENCE: Duration = Duration::from_secs(300);
/// Addresses a command may take: 6 GB, of which those of threads that are never touched are no memory.
const MEMORY_KIB: u64 = 6 << 20;
