//! Stations with line scanners and laser profilers: the examples, their links and their kinematics.

use super::*;
use crate::station::{Carriage, ProfileDirection};

/// Every commented key of the example exists; profiles are used by one kind of kinematics, of the primary device, over UDP.
#[test]
fn a_line_scanner_needs_its_own_kinematics_and_a_udp_link() {
    let text = read(&project("examples/line-scanner.toml")).unwrap();
    let nominal = "[nominal.surface]\nkind = \"plane\"\n";
    let text = text.replace("[nominal]\nfile = \"flat.toml\"\n", nominal);
    let plain = Config::parse("line-scanner.toml", &text).unwrap();
    assert!(!plain.kinematics.is_point_by_point());
    assert_eq!((plain.end.points, plain.expected_points()), (Some(400), None));
    let mut shown = text.clone();
    for key in ["peer", "silence_ms", "reorder_ms"] {
        assert!(shown.contains(&format!("# {key} = ")), "{key}");
        shown = shown.replace(&format!("# {key} = "), &format!("{key} = "));
    }
    Config::parse("line-scanner.toml", &shown).unwrap();

    let across = "across = { device = \"scanner\", offset_mm = 0, scale = 1, reverse = false, skew_deg = 0 }";
    let height = "height = { offset_mm = 5, scale = 1, reverse = true }";
    let udp = "kind = \"udp\"\n# The port to which the scanner sends its profiles, as it was set up; 50001 by default.\nlisten = \"0.0.0.0:50001\"";
    let along = "channel = \"step\", mm_per_count = 0.025";
    let points = "kind = \"cartesian\"\nx = { constant_mm = 0 }\ny = { constant_mm = 0 }\nz = { constant_mm = 0 }\n";
    for (from, to, keys) in [
        (
            across,
            "across = { device = \"stage\", skew_deg = 70 }",
            &["kinematics.across.skew_deg", "kinematics.across.device"][..],
        ),
        (across, "", &["kinematics.across.device"]),
        (height, "height = { scale = 0 }", &["kinematics.height.scale"]),
        (along, "channel = \"steps\"", &["kinematics.along.channel"]),
        (along, "channel = \"exposure\"", &["kinematics.along.channel"]),
        (udp, "kind = \"tcp\"\naddress = \"192.168.1.30:50001\"", &["device.scanner.link"]),
        (
            "kind = \"line\"",
            points,
            &["kinematics.kind", "kinematics.across", "kinematics.along", "kinematics.height"],
        ),
    ] {
        assert!(text.contains(from), "{from}");
        let problems = Config::parse("line-scanner.toml", &text.replace(from, to)).unwrap_err();
        let found: Vec<_> = problems.0.iter().map(|problem| problem.key.as_str()).collect();
        assert_eq!(found, keys, "{to}: {problems}");
    }
}

/// A part that turns has `rotary` and `profile` in place of `along`, and what only one of them has is refused of the other.
#[test]
fn a_line_scanner_has_one_axis_linear_or_rotary() {
    let text = read(&project("examples/shaft-scanner.toml")).unwrap();
    let plain = Config::parse("shaft.toml", &text).unwrap();
    let Kinematics::Line(profiler) = &plain.kinematics else { panic!("{:?}", plain.kinematics) };
    let Carriage::Turning { rotary, profile, tangential_mm } = &profiler.carriage else {
        panic!("{profiler:?}")
    };
    assert_eq!((*profile, *tangential_mm), (ProfileDirection::Axial, 0.0));
    assert_eq!(rotary.scale, std::f64::consts::TAU / 36_000.0);
    let rotary =
        "rotary = { device = \"profiler\", channel = \"encoder\", counts_per_turn = 36000 }";
    let along = "along = { device = \"profiler\", channel = \"encoder\", mm_per_count = 0.001 }";
    let both = format!("{rotary}\n{along}");
    for (from, to, keys) in [
        ("profile = \"axial\"", "", &["kinematics.profile"][..]),
        ("profile = \"axial\"", "profile = \"along\"", &["kinematics.profile"]),
        ("tangential_mm = 0", "tangential_mm = 1e5", &["kinematics.across.tangential_mm"]),
        (rotary, &both, &["kinematics.along"]),
        (rotary, along, &["kinematics.across.tangential_mm", "kinematics.profile"]),
        (
            rotary,
            "",
            &["kinematics.along", "kinematics.across.tangential_mm", "kinematics.profile"],
        ),
        (", counts_per_turn = 36000", "", &["kinematics.rotary.counts_per_turn"]),
    ] {
        assert!(text.contains(from), "{from}");
        let problems = Config::parse("shaft.toml", &text.replace(from, to)).unwrap_err();
        let mut found: Vec<_> = problems.0.iter().map(|problem| problem.key.as_str()).collect();
        let mut keys = keys.to_vec();
        found.sort_unstable();
        keys.sort_unstable();
        assert_eq!(found, keys, "{to}: {problems}");
    }
}

/// Every commented key of the example exists; two ports suit the drivers that need both, and no others.
#[test]
fn a_link_of_two_connections_is_for_devices_that_have_two() {
    let text = read(&project("examples/laser-profiler.toml")).unwrap();
    let plain = Config::parse("laser-profiler.toml", &text).unwrap();
    let address = "127.0.0.1:24691".to_owned();
    assert_eq!(plain.links[0].endpoint, Endpoint::TcpPair { address, second_port: 24692 });
    let mut shown = text.clone();
    for key in ["serial", "batch", "answer_ms", "watch_ms", "silence_ms"] {
        assert!(shown.contains(&format!("# {key} = ")), "{key}");
        shown = shown.replace(&format!("# {key} = "), &format!("{key} = "));
    }
    Config::parse("laser-profiler.toml", &shown).unwrap();

    let pair = "kind = \"tcp-pair\"\naddress = \"127.0.0.1:24691\"\nsecond_port = 24692";
    let of_pair =
        |address: &str, port: &str| format!("kind = \"tcp-pair\"\naddress = {address}\n{port}");
    for (to, key, expected) in [
        (
            "kind = \"tcp\"\naddress = \"127.0.0.1:24691\"".to_owned(),
            "device.profiler.link",
            "a tcp-pair link",
        ),
        (of_pair("\"127.0.0.1:24691\"", ""), "link.profiler.second_port", "second_port"),
        (
            of_pair("\"127.0.0.1:24691\"", "second_port = 70000"),
            "link.profiler.second_port",
            "70000",
        ),
        (of_pair("\"127.0.0.1\"", "second_port = 1"), "link.profiler.address", "host:port"),
    ] {
        assert!(text.contains(pair));
        let problems = Config::parse("laser-profiler.toml", &text.replace(pair, &to)).unwrap_err();
        let keys: Vec<&str> = problems.0.iter().map(|problem| problem.key.as_str()).collect();
        assert_eq!(keys, [key], "{problems}");
        assert!(problems.to_string().contains(expected), "{problems}");
    }
    let described = "driver = \"rf627\"";
    let text = text.replace("driver = \"keyence-lj\"", described);
    let text = text.replace("series = \"lj-x8000\"\n", "");
    let problems = Config::parse("laser-profiler.toml", &text).unwrap_err().to_string();
    assert!(
        problems.contains("expected a udp link, found profiler of kind tcp-pair"),
        "{problems}"
    );
}
