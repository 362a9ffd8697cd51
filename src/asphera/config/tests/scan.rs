//! Plans of scans that the station drives.

use super::*;

/// The example of a scan that the station drives, with some text replaced.
fn driven(changes: &[(&str, &str)]) -> Result<Config, Problems> {
    let mut text = read(&project("examples/closed-loop.toml")).unwrap();
    for (from, to) in changes {
        assert!(text.contains(from), "{from}");
        text = text.replacen(from, to, 1);
    }
    Config::parse("closed-loop.toml", &text)
}

#[test]
fn a_plan_of_a_scan_has_axes_from_the_kinematics_and_pieces_over_the_aperture() {
    let plan = driven(&[]).unwrap().scan.unwrap();
    assert_eq!(
        plan.axes.each_ref().map(|axis| (axis.name.as_str(), axis.stream, axis.channel)),
        [("x", 1, 0), ("y", 1, 1)]
    );
    assert_eq!((plan.axes[0].scale, plan.axes[0].offset), (1.0, -25.0));
    assert!(plan.pieces.len() >= 3 && plan.adaptive.is_some());
    // A raster that is not refined has its lines on both edges of 6 mm: four, 2 mm apart.
    let plain = driven(&[("adaptive = true", "adaptive = false")]).unwrap().scan.unwrap();
    assert_eq!((plain.pieces.len(), plain.adaptive), (4, None));
    assert_eq!((plain.point_spacing_mm, plain.watchdog.as_millis()), (0.2, 500));
    assert_eq!(driven(&[("[scan.plan]", "[scan.pland]")]).unwrap_err().0[0].key, "scan.pland");
}

/// Keys of the commented table of the reference, in a station whose axes move.
#[test]
fn the_plan_of_the_reference_is_known() {
    let text = read(&project("asphera.toml")).unwrap();
    let from = text.find("# [scan.plan]").unwrap();
    let to = from + text[from..].find("\n[session]").unwrap();
    let shown: Vec<&str> =
        text[from..to].lines().filter_map(|line| line.strip_prefix("# ")).collect();
    let keys: Vec<&str> = shown.into_iter().filter(|line| ALTERNATIVES.contains(line)).collect();
    let of_stages = keys.iter().filter(|line| !line.starts_with("r =") && !line.starts_with("c ="));
    // A plane needs no spacing by itself.
    let of_stages = of_stages
        .filter(|line| !line.starts_with("margin_mm"))
        .copied()
        .collect::<Vec<_>>()
        .join("\n");
    let example = read(&project("examples/closed-loop.toml")).unwrap();
    let bare = &example[..example.find("path = ").unwrap()];
    let config = Config::parse("reference", &format!("{bare}{of_stages}\n")).unwrap();
    let plan = config.scan.unwrap();
    assert_eq!((plan.points_max, plan.adaptive.unwrap().goal.u_max), (Some(100_000), Some(20.0)));
}

#[test]
fn mistakes_of_a_plan_are_named_with_their_cures() {
    let keys = |changes: &[(&str, &str)]| -> Vec<String> {
        driven(changes).unwrap_err().0.into_iter().map(|problem| problem.key).collect()
    };
    for (from, to, key) in [
        ("path = \"raster\"", "path = \"zigzag\"", "scan.plan.path"),
        ("path = \"raster\"", "", "scan.plan.path"),
        ("spacing_mm = 2", "", "scan.plan.spacing_mm"),
        ("spacing_mm = 2", "spacing_mm = 0", "scan.plan.spacing_mm"),
        ("spacing_mm = 2", "spacing_mm = 1e-5", "scan.plan.spacing_mm"),
        ("spacing_mm = 2", "spacing_mm = 2\nmargin_mm = 1", "scan.plan.margin_mm"),
        ("spacing_mm = 2", "spacing_mm = 2\nwatchdog_ms = 1", "scan.plan.watchdog_ms"),
        ("spacing_mm = 2", "spacing_mm = 2\ncentre_mm = [1]", "scan.plan.centre_mm"),
        ("spacing_mm = 2", "spacing_mm = 2\nspeed = 1", "scan.plan.speed"),
        ("adaptive = true", "coverage = 0.9", "scan.plan.coverage"),
        ("x = { travel_mm = [-25, 25]", "x = { travel_mm = [-3, 25]", "scan.plan.x.travel_mm"),
        ("y = { travel_mm = [-25, 25]", "y = { travel_mm = [25, -25]", "scan.plan.y.travel_mm"),
        (
            "x = { travel_mm = [-25, 25], speed_mm_s = 20",
            "x = { travel_mm = [-25, 25], speed_mm_s = 0",
            "scan.plan.x.speed_mm_s",
        ),
        ("idle_s = 10", "idle_s = 10\npoints = 5", "scan.points"),
        (
            "[nominal.aperture]\nshape = \"rectangle\"\nwidth_mm = 8\nheight_mm = 6",
            "",
            "scan.plan.path",
        ),
    ] {
        assert!(
            keys(&[(from, to)]).iter().any(|found| found == key),
            "{to}: {:?}",
            keys(&[(from, to)])
        );
    }
    // An axis whose device is only read, and one that does not move.
    let gauge =
        ("y = { device = \"stage\", channel = \"y\", offset_mm = -25 }", "y = { constant_mm = 0 }");
    assert_eq!(keys(&[gauge]), ["scan.plan.y"]);
    let read_only = driven(&[
        (
            "driver = \"zaber\"\nlink = \"stage\"\n\n[device.stage.settings]\ninterval_ms = 10",
            "driver = \"described\"\nlink = \"stage\"\n\n[device.stage.settings]",
        ),
        (
            "[[device.stage.settings.axis]]\nname = \"x\"\nmicrostep_um = 0.1",
            "[[device.stage.settings.field]]\nname = \"x\"\ncolumn = 1\nunit = \"mm\"",
        ),
        (
            "[[device.stage.settings.axis]]\nname = \"y\"\nmicrostep_um = 0.1",
            "[[device.stage.settings.field]]\nname = \"y\"\ncolumn = 2\nunit = \"mm\"",
        ),
    ]);
    let said = read_only.unwrap_err().to_string();
    assert!(
        said.contains("whose driver moves axes, as zaber")
            && said.contains("stage, which is only read"),
        "{said}"
    );
}

/// A turning table with a stage: r and c instead of x and y, c in degrees and without ends.
#[test]
fn a_turning_table_has_axes_r_and_c() {
    let table = [
        (
            "[[device.stage.settings.axis]]\nname = \"y\"\nmicrostep_um = 0.1",
            "[[device.stage.settings.axis]]\nname = \"y\"\nmicrostep_deg = 0.001",
        ),
        (
            "kind = \"cartesian\"\nx = { device = \"stage\", channel = \"x\", offset_mm = -25 }\n\
             y = { device = \"stage\", channel = \"y\", offset_mm = -25 }\nz = ",
            "kind = \"polar\"\nradial = { device = \"stage\", channel = \"x\", offset_mm = -25 }\n\
             rotary = { device = \"stage\", channel = \"y\" }\nprobe = ",
        ),
        ("shape = \"rectangle\"\nwidth_mm = 8\nheight_mm = 6", "shape = \"circle\"\nradius_mm = 4"),
        ("path = \"raster\"", "path = \"spiral\""),
        ("adaptive = true", "adaptive = false"),
        (
            "y = { travel_mm = [-25, 25], speed_mm_s = 20, acceleration_mm_s2 = 200 }",
            "c = { speed_deg_s = 180, acceleration_deg_s2 = 1800 }",
        ),
        ("x = { travel_mm = [-25, 25]", "r = { travel_mm = [0, 25]"),
    ];
    let plan = driven(&table).unwrap().scan.unwrap();
    assert_eq!(plan.axes.each_ref().map(|axis| axis.name.as_str()), ["x", "y"]);
    let asphera_plan::Machine::Polar { r, c } = plan.limits.machine else { panic!("a table") };
    assert_eq!((r.low, r.high, c.high), (0.0, 25.0, f64::INFINITY));
    assert!((c.speed - std::f64::consts::PI).abs() < 1e-12);
    assert_eq!(plan.pieces.len(), 2, "a spiral, and the turn at the edge");
    // Its lines miss the axis of the table.
    let mut raster = table;
    raster[3].1 = "path = \"raster\"";
    let plan = driven(&raster).unwrap().scan.unwrap();
    assert_eq!(plan.pieces.len(), 4);
}

/// A machine with a program is driven without a plan; both together are too many.
#[test]
fn a_device_with_a_program_needs_no_plan() {
    let text = read(&project("examples/cmm.toml")).unwrap();
    let config = Config::parse("cmm.toml", &text).unwrap();
    assert_eq!((config.program, config.scan.is_none()), (Some(0), true));
    assert_eq!(driven(&[]).unwrap().program, None);
    for (added, key) in [("points = 9\n", "scan.points"), ("[scan.plan]\n", "scan.plan")] {
        let problems = Config::parse("cmm.toml", &format!("{text}{added}")).unwrap_err();
        assert!(problems.0.iter().any(|problem| problem.key == key), "{problems}");
    }
}

#[test]
fn axes_find_home_where_their_devices_can() {
    let plan =
        driven(&[("path = \"raster\"", "home = true\nhome_within_s = 20\npath = \"raster\"")]);
    assert_eq!(plan.unwrap().scan.unwrap().home_within, Some(Duration::from_secs(20)));
    let example = read(&project("examples/drives.toml")).unwrap();
    let config = Config::parse("drives.toml", &example).unwrap();
    assert_eq!(config.scan.unwrap().home_within, Some(Duration::from_secs(60)));
    let homing = "homing = { method = 17, switch_mm_s = 20, zero_mm_s = 2 }\n";
    assert!(example.contains(homing));
    let problems = Config::parse("drives.toml", &example.replace(homing, "")).unwrap_err();
    let found: Vec<_> =
        problems.0.iter().map(|one| (one.key.as_str(), one.found.as_str())).collect();
    assert_eq!(found, [("scan.plan.home", "true, with x")]);
}
