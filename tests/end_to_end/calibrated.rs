//! A machine with an error: found with a ball, taken out of the points that follow, and not for ever.

use std::fs;
use std::path::Path;
use std::sync::Arc;

use asphera::config::Config;
use asphera::live::{Finished, Station};
use asphera::replay::replay;
use asphera_link::Command;
use asphera_report::Report;
use asphera_rig::{Rig, Scene, StationOptions};
use asphera_tests::{json, number, run};

/// A ball of 20 mm without form error under an XY stage.
const BALL: &str = r#"
title = "Ball R 20 mm"
seed = 3
[part]
semi_diameter_mm = 9.0
[part.surface]
kind = "sphere"
radius_mm = 20.0
[part.pose]
tx_mm = 0.02
ty_mm = 0.01
tz_mm = -0.004
[fit]
free = ["tx", "ty", "tz"]
[tolerance]
rms_nm = 10.0
[scan]
kind = "raster"
points = 6400
rate_hz = 4000.0
half_width_mm = 6.0
[probe]
noise_nm = 5.0
standoff_mm = 1.0
full_scale_um = 6000.0
intensity = 100.0
[stage]
node_ids = [5, 6]
step_nm = 1
"#;

/// Measures the ball with a station whose axis y counts 0.1 mm too much a metre, and with these lines in its configuration.
/// The configuration lies in `folder`.
async fn measured(folder: &Path, lines: &str) -> Result<Arc<Finished>, String> {
    measured_of(folder, BALL, "1.0001", lines).await
}

/// The same of any scene under an XY stage, whose axis y has this scale.
async fn measured_of(
    folder: &Path,
    scene: &str,
    scale: &str,
    lines: &str,
) -> Result<Arc<Finished>, String> {
    let scene = Scene::parse("ball", scene).unwrap().with_speed(asphera_rig::Speed::Max);
    let rig = Rig::start(scene, &folder.join("ports")).await.unwrap();
    let options =
        StationOptions { recordings: folder.to_owned(), listen: ([127, 0, 0, 1], 0).into() };
    let text = rig.station_toml(&options);
    let y = text.lines().find(|line| line.starts_with("y = ")).unwrap();
    let wrong = y.replace(" }", &format!(", scale = {scale} }}"));
    assert_ne!(y, wrong);
    let text = format!("{}\n{lines}\n", text.replace(y, &wrong));
    let path = folder.join("station.toml");
    fs::write(&path, text).unwrap();
    let config = Config::load(&path).map_err(|error| error.to_string())?;
    let mut station = Station::start(config).unwrap();
    let started = station.handle().session(Command::Start).await;
    started.map_err(|error| error.to_string())?;
    Ok(station.closed().await.unwrap().finished)
}

/// Systematic errors that the u of a report counts, and those that it does not, by source.
fn systematic(report: &Report) -> [Vec<&str>; 2] {
    let all = &report.form.as_ref().unwrap().deviation.systematic;
    [true, false].map(|counted| {
        let some = all.iter().filter(|one| one.u_rms_nm.is_some() == counted);
        some.map(|one| one.source.as_str()).collect()
    })
}

fn rms_nm(finished: &Finished) -> f64 {
    finished.measurement.report.form.as_ref().unwrap().deviation.rms_nm
}

#[tokio::test(flavor = "multi_thread")]
async fn a_ball_tells_the_error_of_an_axis_and_later_parts_are_without_it() {
    let folder = tempfile::tempdir().unwrap();
    let before = measured(folder.path(), "").await.unwrap();
    assert!(rms_nm(&before) > 20.0, "{} nm", rms_nm(&before));
    let calibration = folder.path().join("calibration.toml");
    let recording = before.recording.clone().unwrap();
    let calibrate = |recording: &Path, out: &Path| {
        let names = "scale_x,scale_y,squareness,tilt_x,tilt_y";
        let [recording, out] = [recording, out].map(|path| path.to_str().unwrap().to_owned());
        json(&run([
            "calibrate",
            &recording,
            "--sphere",
            "20",
            "--parameters",
            names,
            "-o",
            &out,
            "--json",
        ]))
    };
    let found = calibrate(&recording, &calibration);
    // What was counted too much is taken off again: 1 / 1.0001 − 1.
    let truths = [0.0, -99.99, 0.0, 0.0, 0.0];
    for (index, truth) in truths.into_iter().enumerate() {
        let value = number(&found, &format!("/parameters/{index}/value"));
        let u = number(&found, &format!("/parameters/{index}/u"));
        assert!((value - truth).abs() < 4.0 * u, "{found:#}");
        assert!(u < 3.0, "{found:#}");
    }

    let after =
        measured(folder.path(), "[calibration]\nfile = \"calibration.toml\"").await.unwrap();
    assert!(rms_nm(&after) < 6.0, "{} nm", rms_nm(&after));
    let report = &after.measurement.report;
    let session = report.session.as_ref().unwrap();
    let made = &session.calibration.as_ref().unwrap().date;
    assert!(fs::read_to_string(&calibration).unwrap().contains(made.as_str()), "{made}");
    let sources = "calibration: scale_x, scale_y, squareness, tilt_x, tilt_y";
    assert_eq!(systematic(report), [vec![sources], vec!["calibration: scale_z"]]);
    // The recording holds the calibration: it is replayed without the file.
    let kept = folder.path().join("kept.toml");
    fs::rename(&calibration, &kept).unwrap();
    let recording = after.recording.clone().unwrap();
    let mut replayed = replay(&recording, |_| {}).unwrap().report;
    replayed.timing = report.timing.clone();
    assert_eq!(&replayed, report);
    // Its bare readings still show the error.
    let again = calibrate(&recording, &calibration);
    let scale = number(&again, "/parameters/1/value");
    assert!((scale + 99.99).abs() < 5.0, "{again:#}");

    // Past its validity no session starts, and it says why.
    let old = fs::read_to_string(&kept).unwrap().replace(made.as_str(), "2020-01-01T00:00:00Z");
    fs::write(&calibration, old).unwrap();
    let refused = measured(folder.path(), "[calibration]\nfile = \"calibration.toml\"").await;
    let message = refused.err().unwrap();
    assert!(message.contains("was valid for 90 days, until 2020-03-31T00:00:00Z"), "{message}");
}

/// Axis y counts 0.1 mm too much a metre. A table says so, and the ball is round again, live and replayed without the file.
#[tokio::test(flavor = "multi_thread")]
async fn an_error_table_of_an_axis_is_taken_out_and_recorded() {
    let folder = tempfile::tempdir().unwrap();
    let table = folder.path().join("y.csv");
    // Indicated ±10 mm stands for ±10 mm / 1.0001.
    let error_nm = 10e6 - 10e6 / 1.0001;
    fs::write(&table, format!("position[mm],error[nm]\n-10,-{error_nm}\n10,{error_nm}\n")).unwrap();
    let scale = "1.0001, error_table = \"y.csv\"";
    let finished = measured_of(folder.path(), BALL, scale, "").await.unwrap();
    assert!(rms_nm(&finished) < 6.0, "{} nm", rms_nm(&finished));
    let report = &finished.measurement.report;
    assert_eq!(report.session.as_ref().unwrap().error_tables, ["y.csv"]);
    assert_eq!(systematic(report), [vec![], vec!["error table y.csv"]]);
    fs::remove_file(&table).unwrap();
    let mut replayed = replay(finished.recording.as_ref().unwrap(), |_| {}).unwrap().report;
    replayed.timing = report.timing.clone();
    assert_eq!(&replayed, report);
}

/// The thermometer of the bench says 30 °C, so a ball of 20 mm is one of 20 mm / 1.001 at 20 °C. Held against 20 mm the machine then
/// measures 1000 µm too little a metre, along every axis.
#[tokio::test(flavor = "multi_thread")]
async fn a_warm_part_is_measured_as_it_is_at_20_degc_and_so_is_the_ball_of_a_calibration() {
    let folder = tempfile::tempdir().unwrap();
    let scene = format!(
        "{BALL}\n[thermal]\nunit_id = 1\nmean_degc = 30.0\namplitude_degc = 0.0\nperiod_s = 600.0\n"
    );
    let lines = "[thermal]\npart = { device = \"thermal\", channel = \"part\", expansion_um_per_m_k = 100, \
                 u_expansion_um_per_m_k = 0.5, u_k = 0.02 }";
    let warm = measured_of(folder.path(), &scene, "1.0", lines).await.unwrap();
    let report = &warm.measurement.report;
    // The primary waited for the thermometer.
    assert_eq!((report.points.received, report.points.used), (6400, 6400));
    let thermal = report.session.as_ref().unwrap().thermal.clone().unwrap();
    assert_eq!((thermal.part_degc, thermal.scales_degc), (Some([30.0, 30.0]), None));
    let [least, most] = thermal.lengths_um_per_m;
    assert!((least + 1e6 / 1001.0).abs() < 1e-6 && least == most, "{thermal:?}");
    assert!((thermal.u_um_per_m - 5.0_f64.hypot(2.0)).abs() < 1e-9, "{thermal:?}");
    assert_eq!(systematic(report), [vec!["thermal expansion"], vec![]]);
    let contribution = &report.form.as_ref().unwrap().deviation.systematic[0];
    // 20 mm · 5.4 µm/m are 108 nm of radius, of whose sag over the field some nanometres are left.
    assert!(contribution.u_pv_nm.unwrap() > 1.0 && contribution.u_pv_nm.unwrap() < 108.0);
    let recording = warm.recording.clone().unwrap();
    let mut replayed = replay(&recording, |_| {}).unwrap().report;
    replayed.timing = report.timing.clone();
    assert_eq!(&replayed, report);
    let recording = recording.to_str().unwrap();
    let parameters = "scale_x,scale_y,scale_z";
    let found = json(&run([
        "calibrate",
        recording,
        "--sphere",
        "20",
        "--parameters",
        parameters,
        "--json",
    ]));
    for index in 0..3 {
        let value = number(&found, &format!("/parameters/{index}/value"));
        let u = number(&found, &format!("/parameters/{index}/u"));
        assert!((value - 1000.0).abs() < 5.0 * u + 1.0 && u < 60.0, "{found:#}");
    }
}
