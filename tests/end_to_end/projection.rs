//! Parts that face elsewhere than z, through the daemon, its recording and its command line.

use std::path::Path;

use asphera::config::Config;
use asphera::live::Station;
use asphera::replay::replay;
use asphera_link::Command;
use asphera_report::{ProjectionFigures, Report, SectionRequest};
use asphera_rig::{Rig, Scene, Speed, StationOptions};
use asphera_tests::{count, json, json_file, number, run};

/// Measures a simulated sphere with these settings, live and from the recording.
async fn measured_twice(projection: &str) -> [Report; 2] {
    let folder = tempfile::tempdir().unwrap();
    let scene = Scene::built_in("sphere").unwrap().with_points(6000).with_speed(Speed::Max);
    let rig = Rig::start(scene, &folder.path().join("ports")).await.unwrap();
    let options =
        StationOptions { recordings: folder.path().to_owned(), listen: ([127, 0, 0, 1], 0).into() };
    let text = format!("{}\n[projection]\n{projection}\n", rig.station_toml(&options));
    let mut station = Station::start(Config::parse("station.toml", &text).unwrap()).unwrap();
    station.handle().session(Command::Start).await.unwrap();
    let finished = station.closed().await.unwrap().finished;
    let live = finished.measurement.report.clone();
    let recording = finished.recording.clone().unwrap();
    let mut replayed = replay(&recording, |_| {}).unwrap().report;
    replayed.timing = live.timing.clone();
    // A section of the recording is cut from the same mesh, in the same frame.
    let surface = &finished.measurement.surface;
    let request = SectionRequest::Line { from_mm: [-80.0, -29.5], to_mm: [80.0, 30.5] };
    let cut = surface.section(&request).unwrap().unwrap();
    let pv_nm = cut.deviation.unwrap().pv_nm;
    let source = recording.to_str().unwrap();
    let again = json(&run(["section", source, "--line", "-80,-29.5,80,30.5", "--json"]));
    assert_eq!(number(&again, "/length_mm"), cut.length_mm);
    assert_eq!(number(&again, "/deviation/pv_nm"), pv_nm);
    // So it is by the plane 3u − 8v = −4, said in the measured frame.
    let [u, v, _] = surface.plane().axes();
    let normal: [f64; 3] = std::array::from_fn(|axis| 3.0 * u[axis] - 8.0 * v[axis]);
    let offset: f64 = (0..3).map(|axis| normal[axis] * surface.plane().origin_mm()[axis]).sum();
    let [a, b, c] = normal;
    let plane = format!("{a},{b},{c},{}", offset - 4.0);
    let upright = json(&run(["section", source, "--plane", &plane, "--json"]));
    let upright_nm = number(&upright, "/deviation/pv_nm");
    assert!((upright_nm - pv_nm).abs() < 0.1, "{upright_nm} nm, {pv_nm} nm");
    [live, replayed]
}

#[tokio::test(flavor = "multi_thread")]
async fn a_replay_fits_the_plane_the_session_fitted() {
    let [live, replayed] = measured_twice("along = \"fitted\"\npoints = 2000").await;
    assert_eq!(live, replayed);
    let found = &live.mesh.projection;
    let Some(ProjectionFigures::Fitted { plane, points: 2000 }) = found else {
        panic!("{found:?}")
    };
    // The first rows of the sphere lie askew.
    assert!(plane.normal[2] > 0.7 && plane.normal[2] < 0.9999, "{plane:?}");
    assert_eq!(live.mesh.relief.folds, []);
    assert!(live.form.is_some());
}

#[tokio::test(flavor = "multi_thread")]
async fn a_replay_projects_along_the_direction_the_session_was_given() {
    let [live, replayed] = measured_twice("along = [0.05, -0.1, 1]").await;
    assert_eq!(live, replayed);
    assert!(matches!(live.mesh.projection, Some(ProjectionFigures::Given { .. })));
}

/// A waffled plane that stands upright: nothing can be meshed along z.
#[test]
fn a_file_of_an_upright_part_is_measured_along_its_normal() {
    let folder = tempfile::tempdir().unwrap();
    let text: String = (0..60 * 60)
        .map(|index| {
            let (i, j) = (index / 60, index % 60);
            let step_mm = if (i + j) % 2 == 0 { 5e-5 } else { -5e-5 };
            format!("{:.6} {i} {j}\n", 7.0 + step_mm)
        })
        .collect();
    let [file, nominal, out] =
        ["part.xyz", "plane.toml", "out"].map(|name| folder.path().join(name));
    std::fs::write(&file, text).unwrap();
    std::fs::write(&nominal, "[surface]\nkind = \"plane\"\n[tolerance]\nrms_nm = 60\n").unwrap();
    let path = |path: &Path| path.to_str().unwrap().to_owned();
    let measure = |along: &str| {
        run([
            "measure",
            &path(&file),
            "--nominal",
            &path(&nominal),
            "--json",
            "--force",
            "--out",
            &path(&out),
            "--along",
            along,
        ])
    };

    for (along, how) in [("fitted", "fitted"), ("-1,0,0", "given"), ("1,0,0", "given")] {
        let output = measure(along);
        assert_eq!(output.status.code(), Some(0), "{}", String::from_utf8_lossy(&output.stderr));
        let report = json(&output);
        assert_eq!(report["mesh"]["projection"]["how"], how);
        let normal = number(&report, "/mesh/projection/plane/normal/0");
        assert!((normal.abs() - 1.0).abs() < 1e-9, "{normal}");
        assert_eq!(count(&report, "/mesh/vertices"), 3600);
        assert!((number(&report, "/form/deviation/rms_nm") - 50.0).abs() < 1e-3);
        assert!((number(&report, "/sampling/coverage") - 1.0).abs() < 1e-9);
        assert_eq!(report["verdict"]["status"], "pass");
        assert_eq!(json_file(&out.join("report.json")), report);
        let map = std::fs::metadata(out.join("deviation.x3p")).unwrap();
        assert!(map.len() > 1000);
    }
    let output = measure("z");
    assert_eq!(output.status.code(), Some(11));
    let report = json(&output);
    assert!(report["mesh"].get("projection").is_none());

    for (along, words) in [
        ("0,0,0", "expected a direction of finite length above 0"),
        ("sideways", "expected z, fitted, none, auto or three numbers nx,ny,nz, found `sideways`"),
    ] {
        let output = measure(along);
        assert_eq!(output.status.code(), Some(2));
        let said = String::from_utf8_lossy(&output.stderr).into_owned();
        assert!(said.contains(words), "{said}");
    }
}
