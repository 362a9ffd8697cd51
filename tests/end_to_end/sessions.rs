//! A recorded session as a source of points: every command takes it, and other programs get its points.

use std::fs;
use std::path::{Path, PathBuf};
use std::sync::OnceLock;

use asphera_tests::{count, json, recording, run};
use serde_json::Value;
use tempfile::TempDir;

/// A session of a simulated asphere, recorded once for all tests.
fn session() -> &'static Path {
    static SESSION: OnceLock<(TempDir, PathBuf)> = OnceLock::new();
    let (_, path) = SESSION.get_or_init(|| {
        let folder = tempfile::tempdir().unwrap();
        let out = folder.path().to_str().unwrap();
        let demo = run(["demo", "--exit", "--points", "12000", "--speed", "max", "--out", out]);
        assert_eq!(demo.status.code(), Some(0), "{}", String::from_utf8_lossy(&demo.stderr));
        let path = recording(folder.path());
        (folder, path)
    });
    path
}

/// Places within the entries of a recording, the middle one first: MCAP's record 6 is a chunk of them. Its other records are
/// indices, of which a loss costs nothing.
fn chunks_from_the_middle(bytes: &[u8]) -> Vec<usize> {
    let (mut at, mut chunks) = (8, Vec::new());
    while at + 17 < bytes.len() {
        let length = u64::from_le_bytes(bytes[at + 1..at + 9].try_into().unwrap()) as usize;
        if bytes[at] == 6 {
            chunks.push(at + 9 + length / 2);
        }
        at += 9 + length;
    }
    let middle = chunks.len() / 2;
    let mut order: Vec<usize> = (0..chunks.len()).collect();
    order.sort_by_key(|index| index.abs_diff(middle));
    order.into_iter().map(|index| chunks[index]).collect()
}

/// The same session with 200 bytes about its middle turned, where that leaves readings without a partner. Which readings share
/// a chunk depends on the moment of the recording.
fn damaged() -> &'static Path {
    static DAMAGED: OnceLock<(TempDir, PathBuf)> = OnceLock::new();
    let (_, path) = DAMAGED.get_or_init(|| {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("session-damaged");
        fs::create_dir(&path).unwrap();
        for entry in fs::read_dir(session()).unwrap() {
            let entry = entry.unwrap().path();
            fs::copy(&entry, path.join(entry.file_name().unwrap())).unwrap();
        }
        let segment = path.join("0000.mcap");
        let bytes = fs::read(&segment).unwrap();
        let leaves_unjoined = |place: usize| {
            let mut turned = bytes.clone();
            turned[place..place + 200].iter_mut().for_each(|byte| *byte ^= 0x5A);
            fs::write(&segment, turned).unwrap();
            figures(&["measure", words(&path)])["points"]["flagged"]["unjoined"].as_u64() > Some(0)
        };
        let found = chunks_from_the_middle(&bytes).into_iter().any(leaves_unjoined);
        assert!(found, "no chunk whose loss leaves a reading without a partner");
        (folder, path)
    });
    path
}

fn words(path: &Path) -> &str {
    path.to_str().unwrap()
}

/// The report of a command that ends with a verdict, without its timing.
fn figures(arguments: &[&str]) -> Value {
    let output = run(arguments.iter().chain(&["--json"]));
    let code = output.status.code();
    assert!(
        matches!(code, Some(0 | 10 | 11)),
        "{arguments:?}: {}",
        String::from_utf8_lossy(&output.stderr)
    );
    let mut report = json(&output);
    report.as_object_mut().unwrap().remove("timing");
    report
}

/// What a command that fails says.
fn failure(arguments: &[&str]) -> String {
    ends_with(1, arguments)
}

/// What a command says that ends with an exit code.
fn ends_with(code: i32, arguments: &[&str]) -> String {
    let output = run(arguments);
    assert_eq!(output.status.code(), Some(code), "{arguments:?}");
    String::from_utf8_lossy(&output.stderr).into_owned()
}

/// A nominal that is not the recorded one.
fn sphere(folder: &Path) -> PathBuf {
    let path = folder.join("sphere.toml");
    fs::write(&path, "[surface]\nkind = \"sphere\"\nradius_mm = 11.65\n[tolerance]\npv_nm = 1\n")
        .unwrap();
    path
}

#[test]
fn a_session_measured_has_the_figures_of_its_replay() {
    let folder = tempfile::tempdir().unwrap();
    let nominal = sphere(folder.path());
    let segment = session().join("0000.mcap");
    for source in [session(), &segment, damaged()] {
        let own = figures(&["measure", words(source)]);
        assert_eq!(own, figures(&["replay", words(source)]));
        assert!(own["form"]["nominal"].to_string().contains("asphere"), "{own:#}");
        let other = figures(&["measure", words(source), "--nominal", words(&nominal)]);
        let replayed = figures(&["replay", words(source), "--nominal", words(&nominal)]);
        assert_eq!(other, replayed);
        assert_eq!(other["links"], own["links"]);
        assert!(other["form"]["nominal"].to_string().contains("sphere R 11.65"), "{other:#}");
        assert_ne!(other["form"], own["form"]);
        assert_eq!(other["verdict"]["checks"][0]["name"], "pv_nm");
    }
    // The order of the points moves the sums by roundings alone.
    let shuffled = figures(&["measure", words(session()), "--shuffle", "7"]);
    let own = figures(&["measure", words(session())]);
    assert_eq!(shuffled["mesh"]["triangles"], own["mesh"]["triangles"]);
    assert_eq!(shuffled["links"], own["links"]);
}

#[test]
fn the_loss_of_a_damaged_recording_is_said_by_every_command() {
    let folder = tempfile::tempdir().unwrap();
    let (source, said) = (words(damaged()), "the recording is damaged: at least");
    for command in ["measure", "replay"] {
        let report = figures(&[command, source]);
        assert_eq!(report["verdict"]["status"], "undecided");
        assert!(report["verdict"]["reasons"].to_string().contains(said), "{report:#}");
    }
    let sampling = json(&run(["sampling", source, "--json"]));
    assert!(sampling["unknown"].to_string().contains(said), "{sampling:#}");
    let section = json(&run(["section", source, "--radius", "30", "--json"]));
    assert!(section["reasons"].to_string().contains(said), "{section:#}");
    assert!(section["deviation"].is_object(), "{section:#}");
    let out = folder.path().join("reduced.xyz");
    let reduced = json(&run(["reduce", source, "--epsilon", "0.2", "-o", words(&out), "--json"]));
    assert!(reduced["losses"].to_string().contains(said), "{reduced:#}");
    assert!(fs::read_to_string(&out).unwrap().contains(said));
    let page = folder.path().join("report.html");
    let report = run(["report", source, "-o", words(&page)]);
    assert_eq!(report.status.code(), Some(11));
    assert!(fs::read_to_string(&page).unwrap().contains(said));
    for name in ["points.xyz", "points.csv", "points.ply"] {
        let out = folder.path().join(name);
        let export = run(["export", source, "-o", words(&out)]);
        assert!(String::from_utf8_lossy(&export.stderr).contains(said));
        assert!(String::from_utf8_lossy(&fs::read(&out).unwrap()).contains(said), "{name}");
    }
}

/// The numbers of a line of text.
fn numbers(line: &str, separator: char) -> Vec<f64> {
    line.split(separator).map_while(|word| word.parse().ok()).collect()
}

/// The lines of a file that hold points.
fn lines(text: &str) -> impl Iterator<Item = &str> {
    text.lines().filter(|line| !line.starts_with(['#', 'x']))
}

#[test]
fn what_is_exported_has_the_bits_of_the_session() {
    let folder = tempfile::tempdir().unwrap();
    let nominal = sphere(folder.path());
    for source in [session(), damaged()] {
        let whole = figures(&["measure", words(source), "--nominal", words(&nominal)]);
        let [xyz, csv, ply] = ["a.xyz", "a.csv", "a.ply"].map(|name| {
            let out = folder.path().join(name);
            let export = run(["export", words(source), "-o", words(&out), "--force"]);
            assert_eq!(export.status.code(), Some(0));
            out
        });
        for out in [&xyz, &csv] {
            let again = figures(&["measure", words(out), "--nominal", words(&nominal)]);
            for part in ["form", "mesh", "sampling", "defects", "partition"] {
                assert_eq!(again[part], whole[part], "{part} of {}", out.display());
            }
            let units = again["reading"]["columns"].to_string();
            assert_eq!(units.matches("\"unit\":\"mm\"").count(), 3, "{units}");
            assert_eq!(again["reading"]["units_by"], "the file");
        }
        // So have the vertices of the PLY file, and of the mesh in a folder of results.
        let results = folder.path().join("results");
        let written = ["--out", words(&results), "--force"];
        figures(
            &[&["measure", words(source), "--nominal", words(&nominal)], &written[..]].concat(),
        );
        for out in [&ply, &results] {
            let again = figures(&["measure", words(out), "--nominal", words(&nominal)]);
            assert_eq!(again["form"], whole["form"], "{}", out.display());
            assert_eq!(again["reading"]["units_by"], "the file");
        }
        let received = count(&whole, "/points/received");
        let text = fs::read_to_string(&csv).unwrap();
        assert!(text.contains("\nx[mm],y[mm],z[mm],time[s],trigger,flags\n"));
        assert_eq!(lines(&text).count() as u64, received);
        let marked = lines(&text).filter(|line| line.starts_with("NaN,NaN,NaN,")).count() as u64;
        let again = figures(&["measure", words(&csv), "--nominal", words(&nominal)]);
        let missing = again["points"]["flagged"]["missing"].as_u64().unwrap_or(0);
        assert_eq!((missing, count(&again, "/points/received")), (marked, received));
        if source == damaged() {
            // A point may have several flags.
            let flags = |line: &str| line.rsplit(',').next().unwrap().to_owned();
            let flags: Vec<String> =
                lines(&text).filter(|line| line.starts_with("NaN")).map(flags).collect();
            let is_unjoined = |flags: &String| flags.split('|').any(|flag| flag == "unjoined");
            assert!(flags.iter().any(is_unjoined), "{flags:?}");
        }
        // The vertices of the PLY file, bit for bit, and of both texts.
        let bytes = fs::read(&ply).unwrap();
        let end = bytes.windows(11).position(|at| at == b"end_header\n").unwrap() + 11;
        let (vertices, rest) = bytes[end..].as_chunks::<8>();
        assert!(rest.is_empty());
        let vertices: Vec<f64> = vertices.iter().map(|eight| f64::from_le_bytes(*eight)).collect();
        let spaced: Vec<f64> =
            lines(&fs::read_to_string(&xyz).unwrap()).flat_map(|line| numbers(line, ' ')).collect();
        let separated: Vec<f64> = lines(&text)
            .filter(|line| !line.starts_with("NaN"))
            .flat_map(|line| numbers(line, ',').into_iter().take(3).collect::<Vec<_>>())
            .collect();
        assert!(!vertices.is_empty() && vertices.len() as u64 == 3 * (received - marked));
        assert_eq!(vertices, spaced);
        assert_eq!(vertices, separated);
    }
}

/// Heights with their uncertainties, and slopes of a profile, are read back as they were.
#[test]
fn what_is_exported_of_a_file_has_its_columns() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("points.csv");
    let out = folder.path().join("out.xyz");
    for (head, line, names) in [
        ("x_um,y_um,z_nm,u_z_nm", "1500,-250,31.5,4", "x[mm] y[mm] z[mm] u_z[mm]"),
        ("x[mm],slope[urad]", "1.5,-250", "x[mm] slope[rad]"),
    ] {
        let next = line.replacen("1", "2", 1);
        fs::write(&file, format!("{head}\n{line}\n{next}\n")).unwrap();
        let export = run(["export", words(&file), "-o", words(&out), "--force"]);
        assert_eq!(export.status.code(), Some(0), "{}", String::from_utf8_lossy(&export.stderr));
        let text = fs::read_to_string(&out).unwrap();
        assert!(text.contains(&format!("\n{names}\n")), "{text}");
        let read = |path: &Path| asphera_formats::read("a.csv", &fs::read(path).unwrap()).unwrap();
        let (before, after) = (read(&file), read(&out));
        let points = |of: &asphera_formats::Topography| of.points().collect::<Vec<_>>();
        assert_eq!(points(&after), points(&before));
        assert_eq!(after.uncertainties_mm(), before.uncertainties_mm());
        assert_eq!(after.slopes(), before.slopes());
    }
}

#[test]
fn what_cannot_be_a_source_or_a_target_is_told_with_its_cure() {
    let folder = tempfile::tempdir().unwrap();
    let empty = folder.path().join("empty");
    fs::create_dir(&empty).unwrap();
    let said = failure(&["measure", words(&empty)]);
    assert!(
        said.contains("expected a folder session-…") && said.contains("found neither"),
        "{said}"
    );
    // A folder that holds one session is that session.
    let around = damaged().parent().unwrap();
    assert_eq!(figures(&["measure", words(around)]), figures(&["measure", words(damaged())]));
    let out = folder.path().join("points.stl");
    let said = ends_with(2, &["export", words(session()), "-o", words(&out)]);
    assert!(said.contains("expected a name ending in .xyz"), "{said}");
    let segment = session().join("0000.mcap");
    let page = ["report", words(session()), "-o", words(&segment), "--force"];
    assert!(failure(&page).contains("belongs to the recording"));
    let file = folder.path().join("points.xyz");
    fs::write(&file, "0 0 0\n1 0 0\n0 1 0\n").unwrap();
    assert!(ends_with(2, &["measure", words(&file)]).contains("--nominal FILE says what"));
    assert!(failure(&["export", words(&file), "-o", words(&file), "--force"]).contains("is read"));
    assert!(
        ends_with(2, &["measure", words(session()), "--unit", "um"])
            .contains("leave out `--columns`")
    );
    let weighted = folder.path().join("weighted.toml");
    let text = "[surface]\nkind = \"plane\"\n[fit]\nweights = \"uncertainty\"\n";
    fs::write(&weighted, text).unwrap();
    for command in ["measure", "replay"] {
        let said = failure(&[command, words(session()), "--nominal", words(&weighted)]);
        assert!(said.contains("carry no uncertainties"), "{said}");
    }
}

/// The points as another program reads them: MCAP and the message of ROS 1, neither decoded by us.
#[test]
fn points_of_a_recording_are_read_by_other_programs() {
    let Some(python) = asphera_tests::python("mcap_ros1") else { return };
    let script = "
import glob, struct, sys
from mcap.reader import SeekingReader
from mcap_ros1.decoder import DecoderFactory
for segment in sorted(glob.glob(sys.argv[1] + '/*.mcap')):
    reader = SeekingReader(open(segment, 'rb'), validate_crcs=True, decoder_factories=[DecoderFactory()])
    for schema, channel, message, cloud in reader.iter_decoded_messages(topics=['/points']):
        assert schema.name == 'sensor_msgs/PointCloud2' and channel.metadata['unit'] == 'mm'
        assert [f.name for f in cloud.fields] == ['x', 'y', 'z', 'time_s', 'count', 'flags']
        assert len(cloud.data) == cloud.row_step == cloud.width * cloud.point_step
        for at in range(0, len(cloud.data), cloud.point_step):
            x, y, z, time, count, flags = struct.unpack_from('<dddddI', cloud.data, at)
            print(x.hex(), y.hex(), z.hex(), int(count), flags)
";
    let output =
        std::process::Command::new(python).args(["-c", script]).arg(session()).output().unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let read = String::from_utf8(output.stdout).unwrap();
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("points.csv");
    let export = run(["export", session().to_str().unwrap(), "-o", file.to_str().unwrap()]);
    assert_eq!(export.status.code(), Some(0), "{}", String::from_utf8_lossy(&export.stderr));
    let text = fs::read_to_string(&file).unwrap();
    let mut rows = text.lines().filter(|line| !line.starts_with('#'));
    let head: Vec<&str> = rows.next().unwrap().split(',').collect();
    let column = |name: &str| {
        head.iter().position(|one| one.starts_with(name)).unwrap_or_else(|| panic!("{head:?}"))
    };
    let places = [column("x"), column("y"), column("z")];
    let mut lines = read.lines();
    let mut points = 0;
    for row in rows {
        let row: Vec<&str> = row.split(',').collect();
        let line: Vec<&str> = lines.next().expect("as many points").split(' ').collect();
        for (place, hex) in places.iter().zip(&line) {
            let exported: f64 = row[*place].parse().unwrap();
            assert_eq!(exported.to_bits(), from_hex(hex).to_bits(), "{row:?} {line:?}");
        }
        points += 1;
    }
    assert_eq!((lines.next(), points), (None, 12_000));
}

/// A number as Python's `float.hex` writes it.
fn from_hex(text: &str) -> f64 {
    let (sign, digits) = text.strip_prefix('-').map_or((1.0, text), |digits| (-1.0, digits));
    let (digits, power) = digits.trim_start_matches("0x").split_once('p').unwrap();
    let mantissa = u64::from_str_radix(&digits.replace('.', ""), 16).unwrap() as f64;
    let places = digits.split_once('.').map_or(0, |(_, tail)| tail.len() as i32);
    sign * mantissa * 2f64.powi(power.parse::<i32>().unwrap() - 4 * places)
}
