//! Bad input gets an error that names place, expected, found and the cure; the exit codes are the documented
//! ones.

use std::process::Output;

use asphera_tests::run;

fn words(output: &Output) -> String {
    String::from_utf8_lossy(&output.stderr).into_owned()
}

#[test]
fn every_mistake_of_a_configuration_is_named_at_once() {
    let dir = tempfile::tempdir().unwrap();
    let reference = asphera_tests::root().join("config/asphera.toml");
    let text = std::fs::read_to_string(&reference).unwrap();
    let good = run(["check", "--config", reference.to_str().unwrap()]);
    assert_eq!(good.status.code(), Some(0), "{}", words(&good));

    let bad = dir.path().join("bad.toml");
    let text = text
        .replace("baud_bd = 921600", "baud_bd = \"fast\"")
        .replace("node_id = 5", "node_id = 0");
    let line = 1 + text.lines().position(|line| line.starts_with("baud_bd = \"fast\"")).unwrap();
    let at_line = format!("bad.toml:{line}: link.probe.baud_bd");
    std::fs::write(&bad, text).unwrap();
    for command in ["check", "run"] {
        let output = run([command, "--config", bad.to_str().unwrap()]);
        assert_eq!(output.status.code(), Some(1), "{command}");
        assert!(output.stdout.is_empty());
        let words = words(&output);
        for place in
            [at_line.as_str(), "device.stage.settings.node_id", "found the string \"fast\""]
        {
            assert!(words.contains(place), "{command}: no {place:?} in {words}");
        }
    }
}

/// Both are TOML, and both have a `check`.
#[test]
fn a_nominal_in_the_place_of_a_station_is_named_as_one() {
    let nominal = asphera_tests::root().join("config/examples/flat.toml");
    let output = run(["run", "--config", nominal.to_str().unwrap()]);
    let words = words(&output);
    assert_eq!(output.status.code(), Some(1), "{words}");
    assert!(words.contains("flat.toml is a nominal file") && words.lines().count() == 1, "{words}");
}

#[test]
fn a_malformed_file_is_named_with_its_place() {
    let dir = tempfile::tempdir().unwrap();
    let nominal = dir.path().join("n.toml");
    std::fs::write(&nominal, "[surface]\nkind = \"plane\"\n").unwrap();
    let file = dir.path().join("p.xyz");
    std::fs::write(&file, "0 0 0\n1 0 zero\n").unwrap();
    let measure =
        |file: &str, nominal: &str| run(["measure", file, "--nominal", nominal, "--json"]);
    let output = measure(file.to_str().unwrap(), nominal.to_str().unwrap());
    assert_eq!(output.status.code(), Some(1));
    assert!(output.stdout.is_empty());
    let text = words(&output);
    assert!(text.contains("p.xyz") && text.contains("line 2") && text.contains("zero"), "{text}");

    let missing = measure("/nowhere/p.xyz", nominal.to_str().unwrap());
    assert_eq!(missing.status.code(), Some(1));
    assert!(words(&missing).contains("/nowhere/p.xyz"));

    std::fs::write(&nominal, "[surface]\nkind = \"asphere\"\nradius_mm = 0\n").unwrap();
    let output = measure(file.to_str().unwrap(), nominal.to_str().unwrap());
    assert_eq!(output.status.code(), Some(1));
    assert!(words(&output).contains("n.toml:"), "{}", words(&output));
}

#[test]
fn a_wrong_command_line_ends_with_two_and_no_verdict_with_three() {
    assert_eq!(run(["measure"]).status.code(), Some(2));
    assert_eq!(run(["demo", "--speed", "warp"]).status.code(), Some(2));
    assert_eq!(run(["frobnicate"]).status.code(), Some(2));
    let help = run(["--help"]);
    assert_eq!(help.status.code(), Some(0));
    assert!(String::from_utf8_lossy(&help.stdout).contains("Exit codes"));

    let dir = tempfile::tempdir().unwrap();
    let (nominal, file) = (dir.path().join("n.toml"), dir.path().join("p.xyz"));
    std::fs::write(&nominal, "[surface]\nkind = \"plane\"\n[tolerance]\npv_nm = 1\n").unwrap();
    std::fs::write(&file, "0 0 0\n").unwrap();
    let output =
        run(["measure", file.to_str().unwrap(), "--nominal", nominal.to_str().unwrap(), "--json"]);
    assert_eq!(output.status.code(), Some(11), "{}", words(&output));
}

/// Whatever the limit is of: PV and RMS are not the only ones a verdict can be asked for.
#[test]
fn a_limit_that_cannot_be_held_ends_with_eleven() {
    let dir = tempfile::tempdir().unwrap();
    let (nominal, file) = (dir.path().join("n.toml"), dir.path().join("p.xyz"));
    let points =
        (0..900).map(|index| format!("{} {} 0\n", 0.1 * f64::from(index % 30), index / 30));
    std::fs::write(&file, points.collect::<String>()).unwrap();
    let limits = [
        ("a_nm = 50", 11),
        ("minimum_zone_nm = 50", 11),
        ("[[tolerance.zone]]\nouter_mm = 1\nrms_nm = 5", 11),
        ("slope_rms_urad = 5\nslope_over_mm = 99\nslope_step_mm = 1", 11),
        ("", 0),
    ];
    for (limit, code) in limits {
        let sparse = "[sampling]\ngap_limit_mm = 0.001\ncoverage_min = 1.0\n";
        let text = format!("[surface]\nkind = \"plane\"\n[tolerance]\n{limit}\n{sparse}");
        std::fs::write(&nominal, text).unwrap();
        let page = dir.path().join("page.html");
        let [file, nominal, page] = [&file, &nominal, &page].map(|path| path.to_str().unwrap());
        let measured = run(["measure", file, "--nominal", nominal, "--json"]);
        assert_eq!(measured.status.code(), Some(code), "{limit}: {}", words(&measured));
        let reported = run(["report", file, "--nominal", nominal, "-o", page, "--force"]);
        assert_eq!(reported.status.code(), Some(code), "{limit}: {}", words(&reported));
    }
}

/// The results of another measurement may be the only ones there are.
#[test]
fn results_that_are_there_are_not_overwritten_unasked() {
    let dir = tempfile::tempdir().unwrap();
    let path = |name: &str| dir.path().join(name).to_str().unwrap().to_owned();
    let [file, nominal, out, page, csv] =
        ["p.xyz", "n.toml", "out", "page.html", "section.csv"].map(path);
    std::fs::write(&nominal, "[surface]\nkind = \"plane\"\n").unwrap();
    let points =
        (0..900).map(|index| format!("{} {} 0\n", 0.1 * f64::from(index % 30), index / 30));
    std::fs::write(&file, points.collect::<String>()).unwrap();
    let commands = [
        (vec!["measure", &file, "--nominal", &nominal, "--out", &out], "report.json"),
        (vec!["report", &file, "--nominal", &nominal, "-o", &page], "page.html"),
        (vec!["section", &file, "--line", "0,5,2,5", "-o", &csv], "section.csv"),
    ];
    for (mut command, written) in commands {
        let first = run(&command);
        assert_eq!(first.status.code(), Some(0), "{}", words(&first));
        let again = run(&command);
        assert_eq!(again.status.code(), Some(1), "{}", words(&again));
        assert!(
            words(&again).contains(&format!("{written} is there already; --force")),
            "{}",
            words(&again)
        );
        command.push("--force");
        assert_eq!(run(&command).status.code(), Some(0));
    }
}

#[test]
fn without_limits_the_verdict_is_none() {
    let dir = tempfile::tempdir().unwrap();
    let (nominal, file) = (dir.path().join("n.toml"), dir.path().join("p.xyz"));
    std::fs::write(&nominal, "[surface]\nkind = \"plane\"\n").unwrap();
    let points =
        (0..900).map(|index| format!("{} {} 0\n", 0.1 * f64::from(index % 30), index / 30));
    std::fs::write(&file, points.collect::<String>()).unwrap();
    let arguments = ["measure", file.to_str().unwrap(), "--nominal", nominal.to_str().unwrap()];
    let output = run(arguments);
    let text = String::from_utf8_lossy(&output.stdout).into_owned();
    assert!(text.contains("verdict    NO LIMITS\n  no limits are given"), "{text}");
    // Too few points for a fit: that no limits are given is no excuse.
    std::fs::write(&file, "0 0 0\n").unwrap();
    let output = run(arguments);
    assert_eq!(output.status.code(), Some(11));
    assert!(String::from_utf8_lossy(&output.stdout).contains("UNDECIDED"));
}

#[test]
fn no_recording_is_an_error_with_its_path() {
    let dir = tempfile::tempdir().unwrap();
    let output = run(["replay", dir.path().to_str().unwrap()]);
    assert_eq!(output.status.code(), Some(1));
    assert!(words(&output).contains(dir.path().to_str().unwrap()), "{}", words(&output));
}

#[test]
fn ports_are_listed_or_said_to_be_absent() {
    let output = run(["ports"]);
    assert_eq!(output.status.code(), Some(0));
    let text = String::from_utf8_lossy(&output.stdout).into_owned();
    assert!(text.contains("serial") && text.to_lowercase().contains("can"), "{text}");
}
