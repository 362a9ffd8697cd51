//! What is taken out of readings and points: errors of the axes, thermal expansion.

use super::*;
use crate::station::Temperature;

const RADIAL: &str = "channel = \"position\", offset_mm = -120.0";

/// The reference with a change, in a folder with a file.
fn station(from: &str, to: &str, (name, content): (&str, &str)) -> Result<Config, String> {
    let text = read(&project("asphera.toml")).unwrap();
    assert!(text.contains(from), "{from}");
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join(name), content).unwrap();
    let path = folder.path().join("station.toml");
    fs::write(&path, text.replace(from, to)).unwrap();
    Config::load(&path).map_err(|error| error.to_string())
}

fn with_table(content: &str) -> Result<Config, String> {
    let to = format!("{RADIAL}, error_table = \"r.csv\"");
    station(RADIAL, &to, ("r.csv", content))
}

/// The folder is gone when the recording of the text is read.
#[test]
fn a_recording_has_the_error_tables_of_its_axes() {
    let config = with_table("position[mm],error[nm]\n-200,0\n200,4000\n").unwrap();
    let table = config.kinematics.axes()[1].errors.clone().unwrap();
    assert_eq!(table.file, "r.csv");
    assert!((table.errors.corrected(0.0).unwrap() + 2e-3).abs() < 1e-15);
    let again = Config::parse("recorded", &config.text).unwrap();
    assert_eq!(again.kinematics, config.kinematics);
    let plain = Config::load(&project("asphera.toml")).unwrap();
    assert!(plain.kinematics.axes().iter().all(|axis| axis.errors.is_none()));
}

#[test]
fn mistakes_in_an_error_table_are_named_with_file_and_line() {
    for (content, expected) in [
        (
            "position[mm],error[nm]\n0,0\n0,1\n",
            "kinematics.radial.error_table: expected in line 3 of r.csv a position above that of the row before",
        ),
        (
            "position[rad],error[urad]\n0,0\n1,1\n",
            "in line 1 of r.csv the head position[mm],error[nm]",
        ),
        (
            "position[mm],error[nm]\n0,0\n1,NaN\n",
            "in line 3 of r.csv finite numbers, found \"1,NaN\"",
        ),
        (
            "position[mm],error[nm]\n0,0\n",
            "two rows of position and error or more below it, found one row",
        ),
    ] {
        let problems = with_table(content).unwrap_err();
        assert!(problems.contains(expected), "{content:?}: {problems}");
        assert!(problems.contains("station.toml:"), "{problems}");
    }
    let to = format!("{RADIAL}, error_table = \"q.csv\"");
    let problems = station(RADIAL, &to, ("r.csv", "")).unwrap_err();
    assert!(problems.contains("expected a file that can be read, found q.csv"), "{problems}");
    let radial = "radial = { device = \"stage\", channel = \"position\", offset_mm = -120.0 }";
    let still = "radial = { constant_mm = 3, error_table = \"r.csv\" }";
    let content = "position[mm],error[nm]\n0,0\n10,1\n";
    let problems = station(radial, still, ("r.csv", content)).unwrap_err();
    assert!(problems.contains("expected no such key, or an axis that moves"), "{problems}");
}

/// The reference with its table of thermal expansion, a line of it replaced.
fn with_thermal(from: &str, to: &str) -> Result<Config, Problems> {
    let text = read(&project("asphera.toml")).unwrap();
    let at = text.find("# [thermal]").unwrap();
    let end = at + text[at..].find("\n\n").unwrap();
    let shown: String = text[at..end]
        .lines()
        .map(|line| match line.strip_prefix("# ") {
            Some(setting) if setting == "[thermal]" || ALTERNATIVES.contains(&setting) => {
                format!("{setting}\n")
            }
            _ => format!("{line}\n"),
        })
        .collect();
    assert!(shown.contains(from), "{from}");
    let shown = shown.replace(from, to);
    Config::parse("asphera.toml", &format!("{}{shown}{}", &text[..at], &text[end..]))
}

#[test]
fn the_thermal_expansion_of_the_reference_is_known() {
    let thermal = with_thermal("[thermal]", "[thermal]").unwrap().thermal.unwrap();
    let part = thermal.part.unwrap();
    assert_eq!(part.temperature, Temperature::Channel { device: 2, channel: 0 });
    assert_eq!((part.per_k, part.u_per_k, part.u_k), (7.1 * 1e-6, 0.3 * 1e-6, 0.1));
    assert_eq!(thermal.scales.unwrap().temperature, Temperature::Constant(20.5));
    assert_eq!((thermal.stale, thermal.range_degc), (Duration::from_secs(60), (10.0, 40.0)));
    let one = with_thermal(THERMAL_SCALES, "").unwrap().thermal.unwrap();
    assert_eq!((one.part, one.scales), (Some(part), None));
    assert!(Config::load(&project("asphera.toml")).unwrap().thermal.is_none());
}

#[test]
fn mistakes_in_the_thermal_expansion_are_named() {
    for (from, to, key, expected) in [
        (
            "device = \"thermal\"",
            "device = \"probe\"",
            "part.channel",
            "a device with a channel in degC, which probe has not",
        ),
        (
            "device = \"thermal\"",
            "device = \"air\"",
            "part.device",
            "one of the devices probe, stage, thermal, or constant_degc",
        ),
        (
            "channel = \"part\"",
            "channel = \"air\"",
            "part.channel",
            "one of the channels in degC part of thermal",
        ),
        ("= 7.1", "= 7100", "part.expansion_um_per_m_k", "-50 to 1000"),
        (", u_k = 0.1", "", "part.u_k", "a finite number"),
        ("constant_degc = 20.5", "constant_degc = 293.15", "scales.constant_degc", "10 to 40"),
        ("stale_s = 60", "stale_s = 0", "stale_s", "0.1 to 86400"),
        ("range_degc = [10, 40]", "range_degc = [40, 10]", "range_degc", "[lowest, highest]"),
        ("u_expansion_um_per_m_k = 0.5", "u_expansion = 0.5", "scales.u_expansion", "did you mean"),
    ] {
        let problems = with_thermal(from, to).unwrap_err();
        let key = format!("thermal.{key}");
        let named = problems.0.iter().find(|problem| problem.key == key);
        assert!(named.is_some_and(|named| named.expected.contains(expected)), "{to}: {problems}");
    }
    let text = read(&project("asphera.toml"))
        .unwrap()
        .replace("[projection]\n", "[thermal]\n[projection]\n");
    let problems = Config::parse("asphera.toml", &text).unwrap_err().to_string();
    assert!(problems.contains("thermal.part: expected a table part or scales"), "{problems}");
}

const CALIBRATION: &str = "format = \"asphera.calibration/1\"\nmade = \"2026-11-01T00:00:00Z\"\nmachine = \"polar\"\n\
                           [parameters.offset_radial]\nvalue_um = 2\nu_um = 1\n";

/// Errors of height lie along z: they say nothing of a probe that looks along the radius, or tilts.
#[test]
fn a_map_of_heights_is_refused_where_the_probe_measures_elsewhere_than_along_z() {
    let map = format!(
        "{CALIBRATION}[map]\nradius_mm = 10\n[[map.term]]\nn = 2\nm = 0\nvalue_nm = 3\nu_nm = 1\n"
    );
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("plain.toml"), CALIBRATION).unwrap();
    fs::write(folder.path().join("map.toml"), map).unwrap();
    let radial = ("profile = \"axial\"", "profile = \"radial\"");
    for (example, (from, to), has_map_along_z) in [
        ("shaft-scanner.toml", ("", ""), false),
        ("shaft-scanner.toml", radial, true),
        ("tilting-probe.toml", ("", ""), false),
    ] {
        let text = read(&project("examples").join(example)).unwrap().replacen(from, to, 1);
        let load = |calibration: &str| {
            let path = folder.path().join("station.toml");
            let table = format!("[calibration]\nfile = \"{calibration}\"\n");
            fs::write(&path, format!("{text}\n{table}")).unwrap();
            Config::load(&path).map_err(|error| error.to_string())
        };
        assert!(load("plain.toml").unwrap().calibration.is_some());
        match load("map.toml") {
            Ok(config) => assert!(has_map_along_z && config.calibration.is_some()),
            Err(problems) => {
                assert!(!has_map_along_z, "{problems}");
                assert!(
                    problems.contains("calibration.file: expected a calibration without a map"),
                    "{problems}"
                );
            }
        }
    }
}
