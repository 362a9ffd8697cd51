//! A CHRocodile on its packet protocol over TCP: a probe on a polar machine, and a line sensor on a stage.

use std::net::SocketAddr;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::time::Duration;

use asphera_rig::{Plan, Rig, Scene, StationOptions};
use asphera_sim_chrocodile::{Exposure, Fault, PacketDevice, Sample, Simulator, tcp};
use asphera_tests::{Running, asphera, count, json, json_file, number, recording, run, wait_for};
use serde_json::Value;

/// The built-in asphere with its probe on packets, without a thermometer.
fn scene_text(points: u64, faults: &str) -> String {
    let text = Scene::built_in_toml("asphere").unwrap();
    let text = text.replace("# protocol = \"packets\"", "protocol = \"packets\"");
    let text = text.replace("points = 100_000 ", &format!("points = {points} "));
    let (before, after) = text.split_once("[thermal]").unwrap();
    let rest_of_file = after.split_once("# What goes wrong").unwrap().1;
    format!("{before}\n# What goes wrong{rest_of_file}\n{faults}")
}

/// The configuration of a station for the bench; it links the probe and the stage.
fn polar(folder: &Path, probe: &str, stage: &str) -> PathBuf {
    let text = format!(
        "[station]\nname = \"packets\"\n[link.probe]\nkind = \"tcp\"\naddress = \"{probe}\"\n\
         [link.stage]\nkind = \"slcan-serial\"\npath = \"{stage}\"\nbit_rate_bps = 1000000\n\
         [device.probe]\ndriver = \"chrocodile2\"\nlink = \"probe\"\n\
         [device.probe.settings]\nprotocol = \"packets\"\nsample_rate_hz = 4000\n\
         [device.stage]\ndriver = \"cia406\"\nlink = \"stage\"\n\
         [device.stage.settings]\nnode_id = 5\nkind = \"linear\"\nstep_nm = 1\nsync_counter_overflow = 240\n\
         [sync]\ndevices = [\"probe\", \"stage\"]\n[kinematics]\nkind = \"polar\"\n\
         rotary = {{ device = \"probe\", channel = \"encoder_x\", counts_per_turn = 3600000 }}\n\
         radial = {{ device = \"stage\", channel = \"position\" }}\n\
         probe = {{ device = \"probe\", channel = \"distance1\", offset_mm = -1 }}\n\
         [nominal.surface]\nkind = \"asphere\"\nradius_mm = 11.65\nconic = -1.1\n\
         A4 = 3.69067205091e-5\nA6 = -1.285461192617e-8\nA8 = -1.400167659754e-10\n\
         [nominal.aperture]\nshape = \"circle\"\nradius_mm = 9\n\
         [nominal.fit]\nfree = [\"tx\", \"ty\", \"tz\", \"rx\", \"ry\"]\n\
         [nominal.tolerance]\npv_nm = 500\nrms_nm = 150\n\
         [scan]\npoints = 12000\nidle_s = 5\n[session]\ndir = {:?}\n\
         [publish]\nlisten = \"127.0.0.1:0\"\n[output]\nfiles = [\"report.json\"]\n",
        folder.join("recordings").display().to_string()
    );
    let path = folder.join("station.toml");
    std::fs::write(&path, text).unwrap();
    path
}

/// Exit code, report and recording of one session of a configuration.
fn measured(folder: &Path, config: &Path) -> (i32, Value, PathBuf) {
    let running =
        Running::start(Command::new(asphera()).args(["run", "--once", "--config"]).arg(config));
    let output = running.wait(Duration::from_secs(120));
    let words = String::from_utf8_lossy(&output.stderr).into_owned();
    let session = recording(&folder.join("recordings"));
    let report = session.join("report.json");
    assert!(report.exists(), "{words}");
    (output.status.code().unwrap_or(-1), json_file(&report), session)
}

/// The address that `asphera simulate` printed for a link.
fn address(listing: &Path, link: &str) -> String {
    wait_for(&format!("address of {link}"), Duration::from_secs(60), || {
        let text = std::fs::read_to_string(listing).unwrap();
        let line = text.lines().find(|line| line.starts_with(link));
        let address = line.and_then(|line| line.split_whitespace().next_back());
        address.map(str::to_owned).ok_or(text)
    })
}

/// `asphera simulate` in one process, `asphera run` in another.
#[test]
fn a_scan_over_packets_passes_with_the_figures_of_the_scene() {
    let folder = tempfile::tempdir().unwrap();
    let (scene, listing) = (folder.path().join("scene.toml"), folder.path().join("listing"));
    let text = scene_text(12_000, "");
    std::fs::write(&scene, &text).unwrap();
    let _bench = Running::start(
        Command::new(asphera())
            .arg("simulate")
            .arg(&scene)
            .arg("--ports")
            .arg(folder.path().join("ports"))
            .stdout(Stdio::from(std::fs::File::create(&listing).unwrap())),
    );
    let (probe, stage) = (address(&listing, "probe"), address(&listing, "stage"));
    let config = polar(folder.path(), &probe, &stage);
    let (code, report, session) = measured(folder.path(), &config);
    assert_eq!(code, 0, "{report:#}");
    assert_eq!(report["verdict"]["status"], "pass");
    assert_eq!(count(&report, "/points/used"), 12_000);
    assert_eq!(count(&report, "/points/lost"), 0);
    let plan = Plan::new(&Scene::parse("scene", &text).unwrap()).unwrap();
    let truth = serde_json::to_value(plan.truth()).unwrap();
    for place in ["/form/deviation/pv_nm", "/form/deviation/rms_nm"] {
        let (found, expected) = (number(&report, place), number(&truth, place));
        // The fit over the noisy points moves the PV by a fraction of the noise of 5 nm.
        assert!((found - expected).abs() < 1.0, "{place}: {found}, expected {expected}");
    }
    let replayed = json(&run(["replay".as_ref(), session.as_os_str(), "--json".as_ref()]));
    assert_eq!((&replayed["form"], &replayed["links"]), (&report["form"], &report["links"]));
}

/// The probe is unplugged, its line is noisy and it loses its supply: what was lost is counted, and nothing is wrong.
#[tokio::test(flavor = "multi_thread")]
async fn faults_of_the_probe_cost_points_and_move_no_figure() {
    let faults = "[[fault]]\nlink = \"probe\"\nat_point = 3000\nkind = \"unplug\"\nduration_s = 0.3\n\
                  [[fault]]\nlink = \"probe\"\nat_point = 14000\nkind = \"noise\"\nbytes = 3000\n\
                  [[fault]]\nlink = \"probe\"\nat_point = 15000\nkind = \"drop\"\n\
                  [[fault]]\nlink = \"probe\"\nat_point = 18000\nkind = \"restart\"\n";
    let folder = tempfile::tempdir().unwrap();
    let scene = Scene::parse("faults", &scene_text(24_000, faults)).unwrap();
    let rig = Rig::start(scene, &folder.path().join("ports")).await.unwrap();
    let options = StationOptions {
        recordings: folder.path().join("recordings"),
        listen: ([127, 0, 0, 1], 0).into(),
    };
    let config = folder.path().join("station.toml");
    let text = rig.station_toml(&options) + "\n[output]\nfiles = [\"report.json\"]\n";
    std::fs::write(&config, text).unwrap();
    let truth = serde_json::to_value(rig.truth()).unwrap();
    let place = folder.path().to_owned();
    let (_, report, session) =
        tokio::task::spawn_blocking(move || measured(&place, &config)).await.unwrap();
    let probe = &report["links"][0];
    assert_eq!(count(probe, "/opened"), 3, "{probe:#}");
    assert!(count(probe, "/discarded_bytes") >= 3000, "{probe:#}");
    let unused = 24_000 - count(&report, "/points/used");
    // 300 ms at 4 kHz, and what passed until the daemon had connected and set up again.
    assert!((1200..18_000).contains(&unused), "{unused} points unused: {:#}", report["points"]);
    let pv_nm = number(&report, "/form/deviation/pv_nm");
    let had_nm = number(&truth, "/form/deviation/pv_nm");
    assert!(
        pv_nm < had_nm + 5.0 && pv_nm > 0.5 * had_nm,
        "PV {pv_nm} nm, the part has {had_nm} nm"
    );
    assert!(!report["verdict"]["reasons"].as_array().unwrap().is_empty(), "{report:#}");
    let replayed = json(&run(["replay".as_ref(), session.as_os_str(), "--json".as_ref()]));
    assert_eq!((&replayed["form"], &replayed["links"]), (&report["form"], &report["links"]));
}

/// Points of a line, their distance, and profiles; lengths in mm.
const LINE: u16 = 150;
const PITCH_MM: f64 = 0.04;
const PROFILES: u64 = 150;
/// Distance from the sensor to the vertex of the part, mm.
const STANDOFF_MM: f64 = 1.0;

/// Height of the part: a sphere of 30 mm with waves of 2 µm; nothing beyond 2.9 mm.
fn height_mm(x_mm: f64, y_mm: f64) -> Option<f64> {
    let r2 = x_mm * x_mm + y_mm * y_mm;
    let wave_mm = 2e-3 * (2.0 * x_mm).sin() * (2.0 * y_mm).cos();
    (r2 < 2.9 * 2.9).then(|| r2 / (30.0 + (900.0 - r2).sqrt()) + wave_mm)
}

fn x_mm(point: u16) -> f64 {
    f64::from(point) * PITCH_MM - 2.98
}

fn y_mm(profile: u64) -> f64 {
    profile as f64 * 0.04 - 2.98
}

/// Distances of a profile in single precision, as they are sent; µm.
fn line_um(profile: u64) -> Vec<Option<f64>> {
    let distance_um = |point| {
        let height_mm = height_mm(x_mm(point), y_mm(profile))?;
        Some(f64::from((1000.0 * (STANDOFF_MM + height_mm)) as f32))
    };
    (0..LINE).map(distance_um).collect()
}

async fn scan(simulator: Simulator) {
    simulator.wait_armed(true).await;
    for profile in 0..PROFILES {
        if profile == 70 {
            simulator.fault(Fault::LoseFormat);
        }
        let sample = Sample {
            exposure_count: profile,
            encoder: [2 * profile as i32 - 10; 5],
            ..Sample::default()
        };
        let exposure = Exposure { sample, line_um: Some(line_um(profile).into()) };
        simulator.expose(exposure).await.unwrap();
        tokio::time::sleep(Duration::from_millis(4)).await;
    }
}

fn line_station(folder: &Path, sensor: SocketAddr) -> PathBuf {
    let text = format!(
        "[station]\nname = \"line sensor\"\n[link.sensor]\nkind = \"tcp\"\naddress = \"{sensor}\"\n\
         [device.sensor]\ndriver = \"chrocodile2\"\nlink = \"sensor\"\n\
         [device.sensor.settings]\nprotocol = \"packets\"\nsignals = [75, 76, 65, 256, 257]\npitch_um = 40\n\
         [sync]\ndevices = [\"sensor\"]\n[kinematics]\nkind = \"line\"\n\
         across = {{ device = \"sensor\", offset_mm = -2.98 }}\nheight = {{ offset_mm = -1 }}\n\
         along = {{ device = \"sensor\", channel = \"encoder_x\", mm_per_count = 0.02, offset_mm = -2.78 }}\n\
         [nominal]\nfile = \"sphere.toml\"\n[scan]\nidle_s = 2\n[session]\ndir = {:?}\n\
         [publish]\nlisten = \"127.0.0.1:0\"\n[output]\nfiles = [\"report.json\"]\n",
        folder.join("recordings").display().to_string()
    );
    let path = folder.join("station.toml");
    std::fs::write(&path, text).unwrap();
    std::fs::write(
        folder.join("sphere.toml"),
        "[surface]\nkind = \"sphere\"\nradius_mm = 30\n[fit]\nfree = [\"tx\", \"ty\", \"tz\"]\n\
         [tolerance]\npv_nm = 6000\nrms_nm = 2000\n",
    )
    .unwrap();
    path
}

/// A line sensor gives the figures of a file with the same points. Its format is lost on the way: profiles up to the answer
/// are lost and counted.
#[tokio::test(flavor = "multi_thread")]
async fn profiles_of_a_line_sensor_become_a_measured_part() {
    let folder = tempfile::tempdir().unwrap();
    let simulator = Simulator::new(PacketDevice::new(3000.0, LINE), 16);
    let (sensor, serving) = tcp(simulator.clone(), ([127, 0, 0, 1], 0).into()).await.unwrap();
    let tasks = [tokio::spawn(async move { drop(serving.await) }), tokio::spawn(scan(simulator))];
    let place = folder.path().to_owned();
    let (_, report, session) = tokio::task::spawn_blocking(move || {
        let config = line_station(&place, sensor);
        measured(&place, &config)
    })
    .await
    .unwrap();
    tasks.iter().for_each(tokio::task::JoinHandle::abort);
    let readings = count(&report, "/links/0/devices/0/readings");
    let lost = count(&report, "/points/lost");
    // A packet holds two profiles at most, so that few come before the answer.
    assert!((1..20).contains(&lost) && readings + lost == PROFILES, "{readings} and {lost}");
    assert_eq!(count(&report, "/links/0/devices/0/faults/protocol"), 1);
    let mut points = String::from("x_mm,y_mm,z_mm\n");
    for profile in (0..PROFILES).filter(|profile| !(70..70 + lost).contains(profile)) {
        for (point, distance_um) in (0_u16..).zip(line_um(profile)) {
            if let Some(distance_um) = distance_um {
                let (x_mm, y_mm) = (x_mm(point), y_mm(profile));
                points += &format!("{x_mm:?},{y_mm:?},{:?}\n", distance_um / 1000.0 - STANDOFF_MM);
            }
        }
    }
    let (file, nominal) = (folder.path().join("points.csv"), folder.path().join("sphere.toml"));
    std::fs::write(&file, points).unwrap();
    let of_file = json(&run([
        "measure".as_ref(),
        file.as_os_str(),
        "--nominal".as_ref(),
        nominal.as_os_str(),
        "--json".as_ref(),
    ]));
    assert_eq!(count(&report, "/points/used"), count(&of_file, "/points/used"));
    for place in ["/form/deviation/pv_nm", "/form/deviation/rms_nm"] {
        let (found, expected) = (number(&report, place), number(&of_file, place));
        assert!((found - expected).abs() < 1e-3, "{place}: {found}, expected {expected}");
    }
    // The waves' rms is half their amplitude.
    let rms_nm = number(&report, "/form/deviation/rms_nm");
    assert!((rms_nm - 1000.0).abs() < 150.0, "{rms_nm}");
    let replayed = json(&run(["replay".as_ref(), session.as_os_str(), "--json".as_ref()]));
    assert_eq!(replayed["form"], report["form"], "a replay gives the same figures");
}
