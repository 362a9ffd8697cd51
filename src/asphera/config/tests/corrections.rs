//! What is taken out of readings and points: errors of the axes.

use super::*;

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
    let errors = config.kinematics.axes()[1].errors.clone().unwrap();
    assert!((errors.corrected(0.0).unwrap() + 2e-3).abs() < 1e-15);
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
