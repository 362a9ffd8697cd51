//! Tests of scenes: what is read, and what is refused.

use super::*;
use crate::{Fault, Link};

/// The commented scene with one line changed.
fn changed(from: &str, to: &str) -> Result<Scene, SceneError> {
    let text = Scene::built_in_toml("asphere").unwrap();
    assert_eq!(text.matches(from).count(), 1, "{from}");
    Scene::parse("changed", &text.replacen(from, to, 1))
}

/// Key, expected and found of the one thing that is wrong.
fn problem(result: Result<Scene, SceneError>) -> (String, String, String) {
    let error = result.unwrap_err();
    let SceneError::File { scene, problems } = &error else { panic!("{error:?}") };
    assert_eq!(scene, "changed");
    let [found] = &problems.0[..] else { panic!("{error}") };
    (found.key.clone(), found.expected.clone(), found.found.clone())
}

fn key(result: Result<Scene, SceneError>) -> String {
    problem(result).0
}

#[test]
fn every_built_in_scene_can_be_played() {
    let names: Vec<&str> = Scene::names().collect();
    assert_eq!(names, ["asphere", "asphere-unplugged", "asphere-noise", "sphere", "blade", "ball"]);
    for name in names {
        assert_eq!(Scene::built_in(name).unwrap().name(), name);
    }
    assert!(Scene::built_in("moon").is_none() && Scene::built_in_toml("moon").is_none());
}

/// The variants repeat the asphere key by key; only name, title and faults differ.
#[test]
fn the_variants_are_the_asphere_with_faults() {
    let asphere = Scene::built_in("asphere").unwrap();
    for name in ["asphere-unplugged", "asphere-noise"] {
        let variant = Scene::built_in(name).unwrap();
        assert!(!variant.faults.is_empty());
        let (name, title) = (asphere.name.clone(), asphere.title.clone());
        assert_eq!(Scene { name, title, faults: Vec::new(), ..variant }, asphere);
    }
}

#[test]
fn the_asphere_is_what_its_file_says() {
    let scene = Scene::built_in("asphere").unwrap();
    assert_eq!(scene.nominal.radius_mm(), Some(11.65));
    let asphere = scene.nominal.asphere().unwrap();
    assert_eq!((asphere.conic, asphere.coefficient(8)), (-1.1, Some(-1.400167659754e-10)));
    assert_eq!(scene.free, Parameter::RIGID);
    assert_eq!((scene.points, scene.rate_hz, scene.seed), (100_000, 4000.0, 1));
    let decentre_um = 1e3 * scene.pose.tx_mm.hypot(scene.pose.ty_mm);
    let tilt_mrad = 1e3 * scene.pose.rx_rad.hypot(scene.pose.ry_rad);
    assert!((decentre_um - 30.0).abs() < 1e-9 && (tilt_mrad - 0.5).abs() < 1e-9);
}

#[test]
fn mistakes_are_named_with_key_expected_and_found() {
    assert_eq!(
        problem(changed("radius_mm = 8.95", "radius_mm = 8.98")),
        (
            "scan.radius_mm".to_owned(),
            "points within part.semi_diameter_mm = 9 of the decentred part".to_owned(),
            "a reach of 9.01 mm".to_owned()
        )
    );
    assert_eq!(
        key(changed("semi_diameter_mm = 9.0", "semi_diameter_mm = -9.0")),
        "part.semi_diameter_mm"
    );
    assert_eq!(key(changed("rx_rad = 0.0003", "rx_rad = 0.3")), "part.pose.rx_rad");
    assert_eq!(key(changed("points = 100_000", "points = 0")), "scan.points");
    assert_eq!(key(changed("points = 100_000", "points = 2_000_000")), "scan.points");
    assert_eq!(key(changed("rate_hz = 4000.0", "rate_hz = nan")), "scan.rate_hz");
    assert_eq!(key(changed("node_ids = [5]", "node_ids = [5, 6]")), "stage.node_ids");
    assert_eq!(key(changed("node_ids = [5]", "node_ids = [128]")), "stage.node_ids[0]");
    assert_eq!(key(changed("step_nm = 1 ", "step_nm = 0 ")), "stage.step_nm");
    assert_eq!(key(changed("noise_nm = 5.0", "noise_nm = -5.0")), "probe.noise_nm");
    assert_eq!(key(changed("index = 5,", "index = 101,")), "part.form_error.fringe[0].index");
    assert_eq!(key(changed("A4 =", "A5 =")), "part.surface.coefficients.A5");
    assert_eq!(key(changed("radius_mm = 11.65", "radius_mm = 0")), "part.surface");
    assert_eq!(key(changed("\"tx\",", "\"roll\",")), "fit.free");
    assert_eq!(key(changed("\"tx\",", "\"ty\",")), "fit.free");
    assert_eq!(key(changed("pv_nm = 500.0", "pv_nm = 0.0")), "tolerance.pv_nm");
    assert_eq!(key(changed("period_s = 600.0", "period_s = 0.0")), "thermal.period_s");
    assert_eq!(key(changed("unit_id = 1\n", "unit_id = 250\n")), "thermal.unit_id");
}

#[test]
fn unknown_missing_and_mistyped_keys_are_named_with_their_line() {
    for (from, to, words) in [
        ("noise_nm = 5.0", "noise_um = 5.0", "changed:65: probe.noise_um: expected a known key"),
        ("seed = 1 ", "sed = 1 ", "changed:5: sed: expected a known key (did you mean `seed`?)"),
        (
            "intensity = 100.0",
            "",
            "changed:64: probe.intensity: expected a finite number, found nothing",
        ),
        (
            "standoff_mm = 1.0",
            "standoff_mm = \"1\"",
            "changed:66: probe.standoff_mm: expected a finite number",
        ),
        (
            "kind = \"spiral\"\n",
            "kind = \"random\"\n",
            "changed:57: scan.kind: expected \"spiral\" or \"raster\" or \"section\" or \"ball\", found \"random\"",
        ),
        ("title = \"", "title = =\"", "changed:4: expected TOML"),
    ] {
        let text = changed(from, to).unwrap_err().to_string();
        assert!(text.contains(words), "{text}");
        assert!(!text.contains("changed:58") && text.lines().count() <= 3, "{text}");
    }
}

#[test]
fn all_mistakes_come_at_once_where_they_are() {
    let text = Scene::built_in_toml("asphere").unwrap();
    let text = text
        .replace("height_nm = -27.0", "height_nm = 1e9")
        .replace("rx_rad = 0.0003", "rx_rad = 0.3")
        .replace("\"tx\",", "\"roll\",")
        .replace("node_ids = [5]", "node_ids = [200]")
        + "\n[[fault]]\nlink = \"stage\"\nat_point = 9\nkind = \"silent\"\nduration_s = 5000\nbytes = 1\n";
    let error = Scene::parse("changed", &text).unwrap_err();
    let SceneError::File { problems, .. } = &error else { panic!("{error:?}") };
    let told: Vec<_> = problems.0.iter().map(|found| (found.line, found.key.as_str())).collect();
    // The fault cannot be made, so ranges of the whole scene are not looked at yet.
    let last = text.lines().count();
    assert_eq!(
        told,
        [(47, "fit.free"), (last - 1, "fault[0].duration_s"), (last, "fault[0].bytes")]
    );
    let error =
        Scene::parse("changed", &text[..text.find("\n[[fault]]").unwrap()].replace("roll", "tx"));
    let SceneError::File { problems, .. } = error.unwrap_err() else { panic!("read") };
    let told: Vec<_> = problems.0.iter().map(|found| (found.line, found.key.as_str())).collect();
    let expected = [
        (23, "part.pose.rx_rad"),
        (35, "part.form_error.fringe[1].height_nm"),
        (74, "stage.node_ids[0]"),
    ];
    assert_eq!(told, expected);
}

fn fault(lines: &str) -> Result<Scene, SceneError> {
    let text = Scene::built_in_toml("asphere").unwrap();
    Scene::parse("changed", &format!("{text}\n[[fault]]\n{lines}\n"))
}

#[test]
fn faults_are_read_in_the_order_of_their_triggers() {
    let text = "link = \"stage\"\nat_point = 20\nkind = \"emergency\"\ncode = 0x5000\nregister = 1\n\
                [[fault]]\nlink = \"probe\"\nat_point = 10\nkind = \"unplug\"\nduration_s = 1.5\n\
                restart = true\n[[fault]]\nlink = \"thermal\"\nat_point = 20\nkind = \"drop\"";
    let faults = fault(text).unwrap().faults;
    let found: Vec<_> = faults.iter().map(|f| (f.at_point, f.link, f.fault)).collect();
    let duration = std::time::Duration::from_millis(1500);
    assert_eq!(
        found,
        [
            (10, Link::Probe, Fault::Unplug { duration, restart: true }),
            (20, Link::Stage, Fault::Emergency { code: 0x5000, register: 1 }),
            (20, Link::Thermal, Fault::Drop),
        ]
    );
}

#[test]
fn impossible_faults_are_refused() {
    for (lines, wrong) in [
        ("link = \"probe\"\nat_point = 1\nkind = \"explode\"", "kind"),
        ("link = \"probe\"\nat_point = 1\nkind = \"emergency\"\ncode = 1\nregister = 1", "kind"),
        ("link = \"thermal\"\nat_point = 1\nkind = \"restart\"", "kind"),
        ("link = \"stage\"\nat_point = 1\nkind = \"emergency\"\ncode = 1", "register"),
        ("link = \"stage\"\nat_point = 100_000\nkind = \"drop\"", "at_point"),
        ("link = \"stage\"\nat_point = 1\nkind = \"unplug\"", "duration_s"),
        ("link = \"stage\"\nat_point = 1\nkind = \"silent\"\nduration_s = -1.0", "duration_s"),
        ("link = \"stage\"\nat_point = 1\nkind = \"noise\"\nbytes = 0", "bytes"),
        ("link = \"stage\"\nat_point = 1\nkind = \"drop\"\nbytes = 5", "bytes"),
    ] {
        assert_eq!(key(fault(lines)), format!("fault[0].{wrong}"), "{lines}");
    }
}

#[test]
fn faults_keep_their_share_of_a_shorter_scan() {
    let scene = Scene::built_in("asphere-unplugged").unwrap().with_points(1_000);
    assert_eq!((scene.points(), scene.faults[0].at_point), (1_000, 400));
    assert!(scene.check().is_ok());
    assert!(scene.clone().with_points(0).check().is_err());
    assert!(scene.with_speed(Speed::Times(f64::NAN)).check().is_err());
}

#[test]
fn a_ball_is_a_sphere_and_has_a_place_and_a_radius_only() {
    let text = Scene::built_in_toml("ball").unwrap();
    let of = |from: &str, to: &str| {
        assert!(text.contains(from), "{from}");
        key(Scene::parse("changed", &text.replacen(from, to, 1)))
    };
    let asphere = "kind = \"asphere\"\nconic = 0.0\n";
    assert_eq!(of("kind = \"sphere\"\n", asphere), "part.surface");
    assert_eq!(of("\"tz\", \"radius\"", "\"tz\", \"rx\""), "fit.free");
    assert_eq!(of("node_ids = [5, 6]", "node_ids = [5]"), "stage.node_ids");
}
