//! The files of the project are read as a user's would be; mistakes are named all at once.

use std::fs;

use super::*;

mod can_links;
mod contours;
mod corrections;
mod file_links;
mod line_scanners;
mod scan;
mod tilting_probes;
mod tip;
mod tls_links;

fn project(path: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../config").join(path)
}

#[test]
fn the_reference_is_valid() {
    let config = Config::load(&project("asphera.toml")).unwrap();
    assert_eq!((config.links.len(), config.devices.len()), (3, 3));
    assert_eq!(config.sync.devices, [0, 1]);
    assert_eq!(config.part.limits()[0].name(), "pv_nm");
    assert_eq!(config.part.limits()[0].value, 300.0);
}

/// A key that is shown commented out must exist, and mean what it says: its default.
#[test]
fn commented_keys_of_the_reference_are_known() {
    let text = read(&project("asphera.toml")).unwrap();
    let shown: String = text
        .lines()
        .map(|line| match line.strip_prefix("# ") {
            // `key = value` at the beginning of a comment is a setting that was commented out.
            Some(setting)
                if setting.split_once(" = ").is_some_and(|(key, _)| {
                    key.chars().all(|letter| letter.is_ascii_lowercase() || letter == '_')
                }) && !ALTERNATIVES.contains(&setting) =>
            {
                format!("{setting}\n")
            }
            _ => format!("{line}\n"),
        })
        .collect();
    let plain = Config::parse("asphera.toml", &text).unwrap();
    let shown = Config::parse("asphera.toml", &shown).unwrap();
    // Of this one its absence is the default.
    assert_eq!(shown.end, EndSettings { open: Some(Duration::from_secs(10)), ..plain.end });
    assert_eq!(shown.output.command, ["/usr/local/bin/to-the-line", "--gate", "3"]);
    assert_eq!(plain.output.command_timeout, shown.output.command_timeout);
    assert_eq!(plain.sync, shown.sync);
    assert_eq!(plain.part, shown.part);
    assert_eq!(plain.along, shown.along);
    assert_eq!(plain.recordings, shown.recordings);
    assert_eq!(plain.recording, shown.recording);
    assert_eq!(plain.output.files, shown.output.files);
    assert_eq!((plain.listen, plain.autostart), (shown.listen, shown.autostart));
    for (plain, shown) in plain.links.iter().zip(&shown.links) {
        assert_eq!(plain.endpoint, shown.endpoint);
        assert_eq!(plain.stale_after, shown.stale_after);
    }
}

/// The tables of limits and uncertainty are shown as examples, which hold together but are not defaults.
#[test]
fn commented_limits_and_uncertainties_of_the_reference_are_known() {
    let text = read(&project("asphera.toml")).unwrap();
    let from = text.find("[nominal.tolerance]").unwrap();
    let to = text.find("[nominal.sampling]").unwrap();
    let shown: String = text[from..to]
        .lines()
        .map(|line| match line.strip_prefix("# ") {
            Some("guard_factor = 2") => String::new(),
            Some(setting) if setting.starts_with('[') || ALTERNATIVES.contains(&setting) => {
                format!("{setting}\n")
            }
            _ => format!("{line}\n"),
        })
        .collect();
    let config =
        Config::parse("asphera.toml", &format!("{}{shown}{}", &text[..from], &text[to..])).unwrap();
    let judging = config.part.judging;
    assert_eq!((judging.limits.len(), judging.guard.is_some()), (9, true));
    assert_eq!((judging.standards.len(), judging.standards[0].1), (4, 280.0));
    let texture = config.part.figures.texture.unwrap();
    assert_eq!((texture.scale.s_mm(), texture.scale.l_mm()), (Some(0.08), Some(2.5)));
    let (budget, draws) = judging.uncertainty.unwrap();
    assert_eq!((budget.long_waves.len(), budget.effects.len()), (1, 7));
    assert_eq!((draws.count, draws.seed), (200, 0));
}

/// Settings shown as alternatives to others, or as examples that are not defaults.
const ALTERNATIVES: &[&str] = &[
    "radius_mm = 0.5",
    "u_radius_mm = 0",
    "reads = \"lowest\"",
    "kind = \"udp\"",
    "path = \"raster\"",
    "spacing_mm = 0.5",
    "from_epsilon = 0.05",
    "one_way = false",
    "inward = false",
    "margin_mm = 0",
    "centre_mm = [0, 0]",
    "scan_speed_mm_s = 5",
    "dwell_ms = 50",
    "point_spacing_mm = 0.05",
    "watchdog_ms = 500",
    "home = false",
    "home_within_s = 60",
    "time_limit_s = 600",
    "points_max = 100000",
    "adaptive = true",
    "coverage = 0.99",
    "u_max_nm = 20",
    "finest_mm = 0.03",
    "batch_places = 2000",
    "x = { travel_mm = [-25, 25], speed_mm_s = 20, acceleration_mm_s2 = 200, tolerance_mm = 0.05 }",
    "y = { travel_mm = [-25, 25], speed_mm_s = 20, acceleration_mm_s2 = 200, tolerance_mm = 0.05 }",
    "r = { travel_mm = [0, 25], speed_mm_s = 20, acceleration_mm_s2 = 200, tolerance_mm = 0.05 }",
    "c = { speed_deg_s = 360, acceleration_deg_s2 = 3600, tolerance_deg = 0.1 }",
    "listen = \"0.0.0.0:50001\"",
    "peer = \"192.168.10.21:50011\"",
    "rho_limit = 0.05",
    "kind = \"socketcan\"",
    "interface = \"can0\"",
    "kind = \"socketcand\"",
    "address = \"192.168.10.31:29536\"",
    "bus = \"can0\"",
    "data_bit_rate_bps = 2000000",
    "kind = \"candump\"",
    "file = \"bus.log\"",
    "speed = 1.0",
    "tls = { ca = \"plant.pem\", server_name = \"oven.plant\", certificate = \"station.pem\", key = \"station.key\" }",
    "kind = \"file\"",
    "path = \"profiles.fifo\"",
    "follow = false",
    "from = \"end\"",
    "scale_um = 10000",
    "step_nm = 100",
    "velocity_step_mm_s = 0.01",
    "counts_per_turn = 3600000",
    "event_timer_ms = 1",
    "sync_window_us = 200",
    "vendor_id = 0x40",
    "map = \"baumer-om20\"",
    "late_limit_ms = 800",
    "file = \"al1815.toml\"",
    "file = \"calibration.toml\"",
    "function = \"input\"",
    "address = 200",
    "length = 13",
    "points = 1000",
    "largest_mm = 0.5",
    "pvr_nm = 250",
    "indication = \"3/0.5(0.1/0.05); RMSi<0.02; λ=546.07 nm\"",
    "minimum_zone_nm = 280",
    "sa_nm = 2",
    "sq_nm = 2.5",
    "sz_nm = 40",
    "terms = [\"piston\", \"tilt\", \"power\"]",
    "rms_nm = 20",
    "slope_length_mm = 1",
    "slope_step_mm = 0.5",
    "remove = \"plane\"",
    "s_mm = 0.08",
    "l_mm = 2.5",
    "order = 2",
    "robust = false",
    "guard_probability = 0.95",
    "guard_factor = 2",
    "hints = \"1.5,2=hole;8,2=plate\"",
    "inner_mm = 0",
    "outer_mm = 4.5",
    "rms_nm = 30",
    "noise_nm = 5",
    "long_wave_nm = 10",
    "long_wave_mm = 8",
    "long_wave_kernel = \"gaussian\"",
    "scale_x_ppm = 1",
    "scale_y_ppm = 1",
    "scale_z_ppm = 1",
    "square_xy_arcsec = 0.5",
    "square_xz_arcsec = 0.5",
    "square_yz_arcsec = 0.5",
    "expansion_ppm_per_k = 7.1",
    "temperature_k = 0.1",
    "correlation = \"budget\"",
    "draws = 200",
    "seed = 0",
    "method = \"auto\"",
    "tolerance_mm = 0",
    "airfoil = false",
    "gap_mm = 0.5",
    "plane = [0, 0, 1, 5]",
    "within_mm = 0.05",
    "outline = \"blade.svg\"",
    "alpha_mm = 0.8",
    "deviation_mm = 0.02",
    "roundness_mm = 0.01",
    // Keys of readings that are joined by time.
    "gap_limit_ms = 100",
    "u_limit_um = 100",
    "noise_nm = 20",
    "from = \"device\"",
    "delay_ms = 0",
    "u_ms = 0.05",
    "axis = \"y\"",
    "tau_mm = 1.5",
    "strip_mm = 3",
    "min_points = 20",
    "library = \"library\"",
    // Keys of the table of thermal expansion.
    "stale_s = 60",
    "range_degc = [10, 40]",
    THERMAL_PART,
    THERMAL_SCALES,
];

const THERMAL_PART: &str = "part = { device = \"thermal\", channel = \"part\", expansion_um_per_m_k = 7.1, u_expansion_um_per_m_k = 0.3, u_k = 0.1 }";
const THERMAL_SCALES: &str = "scales = { constant_degc = 20.5, expansion_um_per_m_k = 8, u_expansion_um_per_m_k = 0.5, u_k = 0.2 }";

#[test]
fn every_example_is_valid_and_keeps_its_nominal_in_the_effective_text() {
    let mut stations = 0;
    for entry in fs::read_dir(project("examples")).unwrap() {
        let path = entry.unwrap().path();
        let text = read(&path).unwrap();
        if text.contains("[station]") {
            let config = Config::load(&path).unwrap();
            let again = Config::parse("effective", &config.text).unwrap();
            assert_eq!(again.part, config.part, "{}", path.display());
            assert_eq!(again.kinematics, config.kinematics);
            crate::station::assemble(&config).unwrap();
            stations += 1;
        } else {
            asphera_nominal::parse("part", &text).unwrap();
        }
    }
    assert!(stations > 0);
}

#[test]
fn all_mistakes_of_a_station_come_at_once() {
    let text = read(&project("asphera.toml"))
        .unwrap()
        .replace("baud_bd = 921600", "baud = 921600")
        .replace("node_id = 5", "node_id = 200")
        .replace("[75, 76, 65, 256, 257]", "[75, 76, 65, 256, 9999]")
        .replace("bit_rate_bps = 1000000", "bit_rate_bps = 750000")
        .replace("link = \"thermal\"", "link = \"termal\"")
        .replace("conic = -1.1", "conic = \"hyperbolic\"")
        .replace("[scan]\n", "[scna]\n");
    let problems = Config::parse("asphera.toml", &text).unwrap_err();
    let keys: Vec<_> = problems.0.iter().map(|problem| problem.key.as_str()).collect();
    assert_eq!(
        keys,
        [
            "link.probe.baud",
            "link.stage.bit_rate_bps",
            "device.probe.settings.signals[4]",
            "device.probe.settings.intensity_min",
            "device.stage.settings.node_id",
            "device.thermal.link",
            "nominal.surface.conic",
            "scna",
        ],
        "{problems}"
    );
}

/// Without the address of the device datagrams come in, and none can go out.
#[test]
fn a_udp_link_without_a_peer_leads_to_no_device_that_is_asked() {
    let tcp = "kind = \"tcp\"\naddress = \"192.168.1.7:8500\"";
    let text = read(&project("examples/described.toml")).unwrap();
    assert!(text.contains(tcp));
    let udp = |text: &str, peer: &str| {
        let link = format!("kind = \"udp\"\nlisten = \"0.0.0.0:8500\"\n{peer}");
        let nominal = "[nominal.surface]\nkind = \"plane\"\n";
        let text = text.replace(tcp, &link).replace("[nominal]\nfile = \"flat.toml\"\n", nominal);
        Config::parse("described.toml", &text)
    };
    let problems = udp(&text, "").unwrap_err();
    let keys: Vec<_> = problems.0.iter().map(|problem| problem.key.as_str()).collect();
    assert_eq!(keys, ["device.arm.link"], "{problems}");
    assert!(problems.to_string().contains("set link.arm.peer to the address"), "{problems}");
    udp(&text, "peer = \"192.168.1.7:8500\"").unwrap();
    // A device that sends by itself needs none.
    let (from, to) = (text.find("[device.arm.settings.hello]"), text.find("# Lines by which"));
    let quiet = text[..from.unwrap()].to_owned() + &text[to.unwrap()..];
    let quiet = quiet.replace("['GO\\r\\n']", "[]").replace("['STOP\\r\\n']", "[]");
    udp(&quiet, "").unwrap();
}

/// What else is wrong is told, what merely follows is not.
#[test]
fn a_setting_that_cannot_be_used_is_one_mistake() {
    let text = read(&project("asphera.toml")).unwrap();
    let text = text.replace("sample_rate_hz = 4000", "sample_rate_hz = 0");
    let problems = Config::parse("asphera.toml", &text).unwrap_err();
    let keys: Vec<_> = problems.0.iter().map(|problem| problem.key.as_str()).collect();
    assert_eq!(keys, ["device.probe.settings.sample_rate_hz"]);
    let text = text
        .replace("# wait_ms = 2000", "wait_ms = 50")
        .replace("node_id = 5", "node_id = 5\nnod_id = 6");
    let problems = Config::parse("asphera.toml", &text).unwrap_err();
    let keys: Vec<_> = problems.0.iter().map(|problem| problem.key.as_str()).collect();
    let expected =
        ["device.probe.settings.sample_rate_hz", "device.stage.settings.nod_id", "sync.wait_ms"];
    assert_eq!(keys, expected);
}

#[test]
fn devices_must_suit_their_link() {
    let text = read(&project("asphera.toml")).unwrap();
    let crossed = text
        .replace("driver = \"cia406\"\nlink = \"stage\"", "driver = \"cia406\"\nlink = \"probe\"");
    let problems = Config::parse("asphera.toml", &crossed).unwrap_err().to_string();
    assert!(problems.contains("expected a CAN link"), "{problems}");
}

#[test]
fn axes_must_name_channels_that_are_there() {
    let text = read(&project("asphera.toml")).unwrap();
    let wrong = text
        .replace("channel = \"encoder_x\"", "channel = \"encoder_y\"")
        .replace("counts_per_turn = 3600000, offset_rad", "offset_rad");
    let problems = Config::parse("asphera.toml", &wrong).unwrap_err().to_string();
    assert!(problems.contains("kinematics.rotary.channel"), "{problems}");
    assert!(problems.contains("encoder_x, distance1, intensity1"), "{problems}");
}

/// What would be accepted and then measure wrongly.
#[test]
fn benches_that_cannot_measure_are_refused() {
    let text = read(&project("asphera.toml")).unwrap();
    for (from, to, words) in [
        (
            "devices = [\"probe\", \"stage\"]",
            "devices = [\"stage\", \"probe\"]",
            "longest counter first",
        ),
        ("signals = [75, 76, 65, 256, 257]", "signals = [76, 65, 256, 257]", "signal 75"),
        ("# averaging = 1", "averaging = 4", "averages"),
        ("# trigger = \"each\"", "trigger = \"free\"", "runs free"),
        ("# every_sync = 1", "every_sync = 2", "does not answer every SYNC"),
        ("# sync_counter_overflow = 240", "sync_counter_overflow = 0", "no counter"),
        ("# wait_ms = 2000", "wait_ms = 50", "hold a reading back"),
        ("# paced = true", "paced = \"no\"", "true or false"),
        (
            "channel = \"position\", offset_mm",
            "channel = \"velocity\", offset_mm",
            "one of the channels",
        ),
        ("address = \"192.168.10.21:502\"", "address = \"192.168.10.21\"", "host:port"),
    ] {
        let changed = text.replace(from, to);
        assert_ne!(changed, text, "{from}");
        let problems = Config::parse("asphera.toml", &changed).unwrap_err().to_string();
        assert!(problems.contains(words), "{to}: {problems}");
    }
    let twice = text.replace(
        "path = \"/dev/serial/by-id/usb-CANable-if00\"",
        "path = \"/dev/serial/by-id/usb-FTDI_FT232R_USB_UART_A10KZP45-if00-port0\"",
    );
    let problems = Config::parse("asphera.toml", &twice).unwrap_err().to_string();
    assert!(problems.contains("where link probe leads"), "{problems}");
}

#[test]
fn a_missing_nominal_file_does_not_hide_other_mistakes() {
    let dir = tempfile::tempdir().unwrap();
    let text = read(&project("examples/om30-line.toml")).unwrap().replace("idle_s = 5", "idle = 5");
    fs::write(dir.path().join("station.toml"), text).unwrap();
    let error = Config::load(&dir.path().join("station.toml")).unwrap_err().to_string();
    assert!(error.contains("nominal.file") && error.contains("scan.idle"), "{error}");
}

#[test]
fn a_nominal_in_a_file_of_its_own_reports_its_own_lines() {
    let dir = tempfile::tempdir().unwrap();
    let text = read(&project("examples/om30-line.toml")).unwrap().replace("idle_s = 5", "idle = 5");
    fs::write(dir.path().join("station.toml"), text).unwrap();
    fs::write(dir.path().join("flat.toml"), "[surface]\nkind = \"plan\"\n").unwrap();
    let error = Config::load(&dir.path().join("station.toml")).unwrap_err().to_string();
    assert!(error.contains("flat.toml:2: surface.kind"), "{error}");
    assert!(error.contains("station.toml:") && error.contains("scan.idle"), "{error}");
}

#[test]
fn the_direction_of_projection_is_a_word_or_a_vector() {
    let text = read(&project("asphera.toml")).unwrap();
    let along = |table: &str| {
        let text = text.replace("[projection]\n", &format!("[projection]\n{table}\n"));
        Config::parse("a.toml", &text).map(|config| config.along)
    };
    assert_eq!(along(""), Ok(Along::Z));
    assert_eq!(along("along = \"z\""), Ok(Along::Z));
    assert_eq!(along("along = \"none\""), Ok(Along::NONE));
    assert_eq!(along("along = \"auto\""), Ok(Along::AUTO));
    assert_eq!(along("along = [0, 0, 2.5]"), Ok(Along::Z));
    assert_eq!(along("along = [0, 1, -1.5]"), Ok(Along::direction([0.0, 1.0, -1.5]).unwrap()));
    assert_eq!(along("along = \"fitted\""), Ok(Along::fitted(1000).unwrap()));
    assert_eq!(along("along = \"fitted\"\npoints = 40"), Ok(Along::fitted(40).unwrap()));
    let line = 2 + text.lines().position(|line| line == "[projection]").unwrap();
    for (table, problem) in [
        (
            "along = \"x\"",
            "projection.along: expected \"z\", \"fitted\", \"none\", \"auto\" or a direction [nx, ny, nz], found \"x\"",
        ),
        (
            "along = 1",
            "projection.along: expected \"z\", \"fitted\", \"none\", \"auto\" or a direction [nx, ny, nz], found 1",
        ),
        (
            "along = [0, 1]",
            "projection.along: expected three numbers [nx, ny, nz], found 2 numbers",
        ),
        (
            "along = [0, 0.0, -0.0]",
            "projection.along: expected a direction of finite length above 0, such as [0, 0.5, 0.866], found [0.0, 0.0, -0.0]",
        ),
        (
            "along = [nan, 0, 1]",
            "projection.along: expected a direction of finite length above 0, such as [0, 0.5, 0.866], found [NaN, 0.0, 1.0]",
        ),
        (
            "points = 5",
            "projection.points: expected no such key, or along = \"fitted\", found `points`",
        ),
        ("points = 2\nalong = \"fitted\"", "projection.points: expected 3 to 1000000, found 2"),
        (
            "along = \"fitted\"\npoints = -2",
            ": projection.points: expected a whole number, not negative, found -2",
        ),
        (
            "normal = [0, 0, 1]",
            "projection.normal: expected one of the keys along, points, found `normal`",
        ),
    ] {
        let problems = along(table).unwrap_err();
        let [found] = &problems.0[..] else { panic!("{table}: {problems}") };
        assert!(found.to_string().ends_with(problem), "{table}: {found}");
        let named = 1 + table
            .lines()
            .position(|key| found.key.ends_with(key.split(' ').next().unwrap()))
            .unwrap();
        assert_eq!(found.line, line + named - 1, "{table}: {found}");
    }
}

/// 0.01·(x + 4)² over 8 × 8 mm about the origin, as `sags.x3p`.
fn write_sags(folder: &Path) {
    let map = asphera_formats::HeightMap {
        nx: 9,
        ny: 9,
        dx_mm: 1.0,
        dy_mm: 1.0,
        x0_mm: -4.0,
        y0_mm: -4.0,
        z_mm: (0..81).map(|node| 0.01 * f64::from((node % 9) * (node % 9))).collect(),
    };
    let metadata = asphera_formats::x3p::Metadata {
        date: "2026-01-31T12:00:00.0Z",
        calibration_date: "2026-01-01T00:00:00.0Z",
        creator: None,
        manufacturer: "asphera",
        model: "station",
        serial: "1",
        version: "0.1.0",
        probing: asphera_formats::x3p::Probing::NonContacting,
        probe: "chromatic sensor",
        comment: None,
    };
    let mut bytes = Vec::new();
    asphera_formats::x3p::write_map(&mut bytes, &map, &metadata).unwrap();
    fs::write(folder.join("sags.x3p"), bytes).unwrap();
}

/// A recording keeps the text of its configuration, and is replayed from any folder.
#[test]
fn the_effective_text_of_a_station_names_its_heights_by_their_whole_path() {
    let folder = tempfile::tempdir().unwrap();
    write_sags(folder.path());
    fs::write(folder.path().join("part.toml"), "[surface]\nkind = \"grid\"\nfile = \"sags.x3p\"\n")
        .unwrap();
    let reference =
        fs::read_to_string(concat!(env!("CARGO_MANIFEST_DIR"), "/../../config/asphera.toml"))
            .unwrap();
    let (before, rest) = reference.split_once("[nominal.surface]").unwrap();
    let after = rest.split_once("[scan]").unwrap().1;
    for nominal in [
        "[nominal]\nfile = \"part.toml\"\n",
        "[nominal.surface]\nkind = \"grid\"\nfile = \"sags.x3p\"\n",
    ] {
        let path = folder.path().join("station.toml");
        fs::write(&path, format!("{before}{nominal}[scan]{after}")).unwrap();
        let config = Config::load(&path).unwrap();
        assert!(config.part.nominal.freeform().is_some());
        let again = Config::parse("elsewhere/recording", &config.text).unwrap();
        assert_eq!(again.part, config.part);
    }
}

/// A probe of single points has no profiles.
#[test]
fn kinematics_of_a_line_scanner_need_one() {
    let text = read(&project("asphera.toml")).unwrap();
    let from = text.find("kind = \"polar\"").unwrap();
    let to = text.find("# -----").map(|_| text[from..].find("\n# ----").unwrap() + from).unwrap();
    let line = "kind = \"line\"\nacross = { device = \"probe\" }\nheight = {}\nalong = { constant_mm = 0 }\n";
    let text = format!("{}{line}{}", &text[..from], &text[to..]);
    let problems = Config::parse("asphera.toml", &text).unwrap_err().to_string();
    assert!(
        problems.contains("expected a line scanner, whose readings have profiles"),
        "{problems}"
    );
}

#[test]
fn a_port_without_a_name_is_no_port() {
    let text = read(&project("asphera.toml")).unwrap();
    let line = text.lines().find(|line| line.starts_with("path = ")).unwrap();
    let problems = Config::parse("a.toml", &text.replace(line, "path = \"\"")).unwrap_err();
    let problems = problems.to_string();
    assert!(problems.contains(".path: expected a port, as /dev/serial/by-id/…, found an empty"));
}

/// Two devices without a shared count.
fn by_time(keys: &str, clocks: &str) -> Result<Config, Problems> {
    let text = read(&project("asphera.toml")).unwrap();
    let devices = "devices = [\"probe\", \"stage\"]\n";
    let keys = format!("{devices}by = \"time\"\n{keys}\n{clocks}\n");
    let text = text.replace(devices, "").replace("\n[sync]\n", &format!("\n[sync]\n{keys}\n"));
    let text = text.replace("signals = [75, 76, 65, 256, 257]", "signals = [64, 65, 256, 257]");
    Config::parse("asphera.toml", &text)
}

#[test]
fn devices_without_a_shared_count_are_joined_by_time() {
    let clocks = "clock = { probe = { u_ms = 0.01 }, stage = { u_ms = 0.5, delay_ms = 1.5 } }";
    let config = by_time("gap_limit_ms = 20\nu_limit_um = 3", clocks).unwrap();
    let time = config.sync.time.unwrap();
    assert_eq!((time.gap, time.u_limit_mm), (Duration::from_millis(20), 0.003));
    let [probe, stage] = time.devices[..] else { panic!("{:?}", time.devices) };
    assert!(probe.clock.is_some() && stage.clock.is_none());
    assert_eq!((stage.u, stage.delay), (Duration::from_micros(500), Duration::from_micros(1500)));
}

#[test]
fn mistakes_of_joining_by_time_are_named() {
    let told = |keys: &str, clocks: &str| by_time(keys, clocks).unwrap_err().to_string();
    let clocks = "clock = { probe = { u_ms = 0.01 }, stage = { u_ms = 0.5 } }";
    assert!(told("", "clock = { probe = { u_ms = 0.01 } }").contains("sync.clock.stage.u_ms"));
    assert!(told("paced = false", clocks).contains("times tell nothing"));
    assert!(told("gap_limit_ms = 3000", clocks).contains("sync.wait_ms"));
    let of_host = "clock = { probe = { u_ms = 0.01 }, stage = { u_ms = 0.5, from = \"device\" } }";
    assert!(told("", of_host).contains("readings carry a time"));
    let other = "clock = { probe = { u_ms = 1 }, stage = { u_ms = 1 }, thermal = { u_ms = 1 } }";
    assert!(told("", other).contains("synchronized devices probe, stage"));
    let text = read(&project("asphera.toml")).unwrap();
    let text = text.replace("# gap_limit_ms = 100", "gap_limit_ms = 100");
    let problems = Config::parse("asphera.toml", &text).unwrap_err().to_string();
    assert!(problems.contains("by = \"time\""), "{problems}");
}
