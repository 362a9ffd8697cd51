//! Tests of profiles: figures put in come out, whichever way the line runs.

use asphera_report::{Report, Status};

use crate::Pipeline;
use crate::nominal::parse;

const SPHERE: &str = "[surface]\nkind = \"sphere\"\nradius_mm = 50\n[aperture]\nshape = \"circle\"\nradius_mm = 10\n\
                      [fit]\nfree = [\"tx\", \"ty\", \"tz\", \"rx\", \"ry\"]\n";

/// A cut through a sphere of 50 mm from `from` to `to` mm, with a wave of 100 nm along the normal, in a direction.
fn cut(text: &str, turn_rad: f64, from: i32, to: i32) -> Report {
    let mut pipeline = Pipeline::new(parse("p.toml", text).unwrap());
    let [cos, sin] = [turn_rad.cos(), turn_rad.sin()];
    let points = (from * 10..=to * 10).map(|step| {
        let s = 0.1 * f64::from(step);
        let off_mm = 1e-4 * (std::f64::consts::TAU * s / 4.0).cos();
        let [n_s, n_z] = [-s / 50.0, (1.0 - (s / 50.0).powi(2)).sqrt()];
        let [s, z] = [s + off_mm * n_s, 50.0 - 50.0 * n_z + off_mm * n_z];
        [s * cos, s * sin, z]
    });
    pipeline.take_positions(points);
    pipeline.finish().report
}

#[test]
fn a_profile_is_fitted_and_judged_whichever_way_it_runs() {
    let text = format!("{SPHERE}[tolerance]\npv_nm = 210\nrms_nm = 75\n");
    let along_x = cut(&text, 0.0, -10, 10);
    assert_eq!(along_x.verdict.status, Status::Pass, "{:?}", along_x.verdict);
    let form = along_x.form.as_ref().unwrap();
    // Five waves over 201 points: the fit takes their mean of 1/2 nm off, and little else.
    assert!((form.deviation.pv_nm - 200.0).abs() < 0.01, "{}", form.deviation.pv_nm);
    assert!(
        (form.deviation.rms_nm - 100.0 / 2.0_f64.sqrt()).abs() < 0.5,
        "{}",
        form.deviation.rms_nm
    );
    let profile = along_x.profile.as_ref().unwrap();
    assert_eq!(profile.held, ["ty", "rx"]);
    assert!((profile.length_mm.unwrap() - 20.0).abs() < 1e-3);
    assert!((along_x.sampling.coverage.unwrap() - 1.0).abs() < 1e-3);
    // A wave of 100 nm and 4 mm has slopes of 100·2π/4/√2 nm/mm, by differences over 0.1 mm a thousandth less.
    let slope = 100.0 * std::f64::consts::TAU / 4.0 / 2.0_f64.sqrt();
    assert!((profile.slope_rms_urad.unwrap() / slope - 1.0).abs() < 0.005, "{profile:?}");
    for turn in [std::f64::consts::FRAC_PI_2, 0.7, -1.1, 2.4] {
        let turned = cut(&text, turn, -10, 10);
        assert_eq!(turned.verdict.status, Status::Pass, "{turn}: {:?}", turned.verdict);
        let other = turned.form.as_ref().unwrap();
        for (a, b) in [
            (form.deviation.pv_nm, other.deviation.pv_nm),
            (form.deviation.rms_nm, other.deviation.rms_nm),
            (form.fit.pose.tz_mm * 1e6, other.fit.pose.tz_mm * 1e6),
            (profile.slope_rms_urad.unwrap(), turned.profile.unwrap().slope_rms_urad.unwrap()),
        ] {
            assert!((a - b).abs() < 1e-3, "{turn}: {a} {b}");
        }
    }
}

#[test]
fn what_is_missing_of_the_line_leaves_it_undecided() {
    let text = format!("{SPHERE}[tolerance]\npv_nm = 210\n");
    let half = cut(&text, 0.3, -10, 0);
    assert!((half.sampling.coverage.unwrap() - 0.5).abs() < 0.01, "{:?}", half.sampling);
    assert_eq!(half.verdict.status, Status::Undecided);
    // What is measured breaks the limit already.
    let broken = cut(&format!("{SPHERE}[tolerance]\npv_nm = 150\n"), 0.3, -10, 0);
    assert_eq!(broken.verdict.status, Status::Fail);
}

#[test]
fn limits_of_surfaces_are_refused_and_those_of_slopes_held() {
    let slopes =
        "slope_over_mm = 0.4\nslope_step_mm = 0.1\nslope_max_urad = 200\nslope_rms_urad = 120\n";
    let held = cut(&format!("{SPHERE}[tolerance]\n{slopes}"), 0.0, -10, 10);
    assert_eq!(held.verdict.status, Status::Pass, "{:?}", held.verdict);
    // 100·2π/4 µrad, by best lines over a tenth of a wave 1 % less.
    let most =
        held.verdict.checks.iter().find(|check| check.figure.name == "slope_max_urad").unwrap();
    assert!((most.value / 157.08 - 0.985).abs() < 0.01, "{most:?}");
    let fails =
        cut(&format!("{SPHERE}[tolerance]\n{}", slopes.replace("200", "150")), 0.0, -10, 10);
    assert_eq!(fails.verdict.status, Status::Fail);
    let refused = cut(&format!("{SPHERE}[tolerance]\npv_nm = 210\nb_nm = 100\n"), 0.0, -10, 10);
    assert_eq!(refused.verdict.status, Status::Undecided);
    assert!(
        refused.verdict.reasons.iter().any(|why| why.contains("not formed of a profile")),
        "{:?}",
        refused.verdict
    );
}

#[test]
fn a_freeform_has_profiles_along_its_axes_only() {
    let cylinder = "[surface]\nkind = \"cylinder\"\nstraight_along = \"y\"\nradius_mm = 50\n[fit]\nfree = [\"tz\", \"ry\"]\n[tolerance]\npv_nm = 300\n";
    let oblique = cut(cylinder, 0.7, -10, 10);
    assert!(oblique.form.is_none());
    assert!(
        oblique.verdict.reasons.iter().any(|why| why.contains("oblique line")),
        "{:?}",
        oblique.verdict
    );
}

/// A line of readings that come in steps: neighbours share their errors, so their slopes tell little.
#[test]
fn heights_in_steps_have_the_noise_of_their_rounding() {
    let text = "[surface]\nkind = \"plane\"\n[fit]\nfree = [\"tz\"]\n";
    let of = |height_mm: fn(f64) -> f64| {
        let mut pipeline = Pipeline::new(parse("p.toml", text).unwrap());
        pipeline.take_positions((0..2000).map(|step| {
            let x_mm = 0.001 * f64::from(step);
            [x_mm, 0.0, height_mm(x_mm)]
        }));
        let report = pipeline.finish().report;
        let profile = report.profile.unwrap();
        (profile.noise_sigma_nm, profile.slope_noise_urad, report.sampling.unknown.join("; "))
    };
    // 100 nm over √12, twice in a step of 1 µm.
    let (noise_nm, slope_urad, said) = of(|x_mm| 1e-4 * (3.0 * (3.0 * x_mm).sin()).round());
    assert!((noise_nm.unwrap() - 28.87).abs() < 0.01, "{noise_nm:?}");
    assert!((slope_urad.unwrap() - 2.0_f64.sqrt() * 28_867.5).abs() < 10.0, "{slope_urad:?}");
    assert!(said.contains("the heights come in steps of 100"), "{said}");
    let (noise_nm, slope_urad, said) = of(|_| 0.25);
    assert_eq!([noise_nm, slope_urad], [None; 2]);
    assert!(said.contains("most neighbours have the very same height"), "{said}");
    let (noise_nm, _, said) = of(|x_mm| 1e-4 * (3.0 * x_mm).sin());
    assert!(noise_nm.unwrap() < 1e-3 && !said.contains("steps"), "{noise_nm:?} {said}");
}
