//! A flat disc of known form: the figures that the nominal file asks for, and their limits.

use std::f64::consts::TAU;

use asphera_report::{FormFigures, StandardFigures, Status};

use crate::nominal::parse;
use crate::{Along, Measurement, Pipeline};

const FLAT: &str = "[surface]\nkind = \"plane\"\n[aperture]\nshape = \"circle\"\nradius_mm = 3.0\n\
     [fit]\nfree = [\"tz\", \"rx\", \"ry\"]\n[sampling]\ngap_limit_mm = 0.2\n";

/// 20 nm of astigmatism at the rim with waves of 5 nm every 0.5 mm on it, and a tilt.
fn measured(rest: &str) -> Measurement {
    let part = parse("flat.toml", &format!("{FLAT}{rest}")).unwrap();
    let mut pipeline = Pipeline::along(part, Along::default());
    for i in -60..=60 {
        for j in -60..=60 {
            let (x, y) = (f64::from(i) * 0.05, f64::from(j) * 0.05);
            // Off the edge of the aperture, which the tilt would move points across.
            if x.hypot(y) <= 2.98 {
                let nm = 20.0 / 9.0 * (x * x - y * y) + 5.0 * (TAU * (x + 0.01) / 0.5).sin();
                pipeline.take_position([x, y, 1e-3 * x + nm * 1e-6]);
            }
        }
    }
    pipeline.finish()
}

fn form(measurement: &Measurement) -> &FormFigures {
    measurement.report.form.as_ref().unwrap()
}

fn reads_itself(form: &FormFigures) {
    let text = serde_json::to_string(form).unwrap();
    assert!(!text.contains("NaN"), "{text}");
    let again = serde_json::from_str::<FormFigures>(&text).unwrap().standards;
    let of = &form.standards;
    // All but the last bits of numbers comes back.
    assert_eq!(again.indication, of.indication);
    assert_eq!(again.psd.is_some(), of.psd.is_some());
    assert_eq!(again.q_spectrum.is_some(), of.q_spectrum.is_some());
    let names = |of: &StandardFigures| {
        let texture = of.texture.iter().flat_map(|texture| texture.figures.clone());
        texture.map(|figure| figure.name).collect::<Vec<_>>()
    };
    assert_eq!(names(&again), names(of));
    assert_eq!(
        again.minimum_zone.map(|zone| zone.settled),
        of.minimum_zone.as_ref().map(|zone| zone.settled)
    );
}

#[test]
fn what_costs_little_is_there_unasked() {
    let measurement = measured("");
    let form = form(&measurement);
    let of = &form.standards;
    assert!(of.minimum_zone.is_none() && of.texture.is_none());
    assert!(of.indication.as_ref().unwrap().found.starts_with("3/"));
    let psd = of.psd.as_ref().unwrap();
    let pairs = psd.frequency_per_mm.iter().zip(&psd.density_nm2_mm2);
    let (frequency, _) =
        pairs.filter(|(f, _)| **f > 1.0).max_by(|a, b| a.1.total_cmp(b.1)).unwrap();
    assert!((frequency - 2.0).abs() < 0.1, "{frequency}");
    let q = of.q_spectrum.as_ref().unwrap();
    assert!(q.asked == 24 && q.coefficients_nm.len() == q.u_nm.len(), "{q:?}");
    assert_eq!(form.unknown, Vec::<String>::new());
    reads_itself(form);
}

#[test]
fn all_that_is_asked_is_there_with_what_it_rests_on() {
    let measurement = measured(
        "[figures]\nminimum_zone = true\npsd = false\nq_terms = 0\nzernike_terms = 37\nslope_length_mm = 0.4\n\
         [figures.texture]\nl_mm = 1.5\n",
    );
    let form = form(&measurement);
    let of = &form.standards;
    assert!(of.psd.is_none() && of.q_spectrum.is_none());
    let zone = of.minimum_zone.as_ref().unwrap();
    assert!(zone.settled && zone.lower_nm <= zone.width.value, "{zone:?}");
    assert!(zone.width.value <= zone.least_squares_pv_nm * (1.0 + 1e-12));
    assert!((zone.least_squares_pv_nm - form.deviation.pv_nm).abs() < 1e-9);
    assert!((zone.contacts.iter().map(|contact| contact.share).sum::<f64>() - 1.0).abs() < 1e-4);
    // Saddle and waves lie symmetrically: 40 nm and what the waves add near the rim.
    assert!((40.0..50.0).contains(&zone.width.value), "{}", zone.width.value);
    let texture = of.texture.as_ref().unwrap();
    let value =
        |name: &str| texture.figures.iter().find(|figure| figure.name == name).unwrap().value;
    // The long saddle is gone, the waves stay: 5 nm over √2.
    assert!((value("Sq") - 5.0 / 2f64.sqrt()).abs() < 0.15, "{}", value("Sq"));
    assert!((value("Sa") - 10.0 / std::f64::consts::PI).abs() < 0.15, "{}", value("Sa"));
    assert!((9.0..12.0).contains(&value("Sz")), "{}", value("Sz"));
    assert_eq!((texture.surface.as_str(), texture.l_mm), ("S-L", Some(1.5)));
    assert_eq!(texture.filters.len(), 1);
    let zernike = form.zernike.as_ref().unwrap();
    let last = zernike.terms.last().unwrap();
    assert_eq!((last.index, last.n, last.m), (37, 12, 0));
    assert!(form.figures.iter().any(|figure| figure.variant == "over 0.4 mm"));
    reads_itself(form);
}

#[test]
fn limits_of_zone_and_texture_decide() {
    let verdict = |limits: &str| {
        let rest = format!("[tolerance]\n{limits}\n[figures.texture]\nl_mm = 1.5\n");
        measured(&rest).report.verdict
    };
    let pass = verdict("minimum_zone_nm = 60\nsq_nm = 4\nsz_nm = 20");
    assert_eq!((pass.status, &pass.reasons[..]), (Status::Pass, &[][..]), "{pass:?}");
    let names: Vec<&str> = pass.checks.iter().map(|check| check.figure.name.as_str()).collect();
    assert_eq!(names, ["minimum_zone_nm", "sq_nm", "sz_nm"]);
    let fail = verdict("pv_nm = 60\nminimum_zone_nm = 30");
    assert_eq!(fail.status, Status::Fail);
    assert!(fail.checks[0].ok && !fail.checks[1].ok, "{fail:?}");
}

/// Sq is 3.54 nm and the noise of a point tells it to hundredths of a nm, the zone 45 nm or so and known to some nm.
#[test]
fn limits_of_zone_and_texture_regard_their_uncertainty() {
    let found = |limits: &str| {
        let rest = format!(
            "[tolerance]\n{limits}\nguard_factor = 2\n[figures]\nminimum_zone = true\n\
             [figures.texture]\nl_mm = 1.5\n[uncertainty]\nnoise_nm = 0.5\n"
        );
        measured(&rest)
    };
    let good = found("minimum_zone_nm = 60\nsq_nm = 4\nsz_nm = 20");
    let verdict = &good.report.verdict;
    assert_eq!(verdict.status, Status::Pass, "{verdict:?}");
    for check in &verdict.checks {
        let (u, band) = (check.u.unwrap(), check.guard_band.unwrap());
        assert!(u > 0.0 && (band - 2.0 * u).abs() < 1e-12 && check.rule.is_some(), "{check:?}");
    }
    let near = form(&good);
    let zone = &near.standards.minimum_zone.as_ref().unwrap().width;
    let simulated = zone.simulated.as_ref().unwrap();
    assert_eq!((simulated.model.as_str(), simulated.draws), ("noise only", 200));
    assert!(simulated.low < zone.value && simulated.bias > 0.0, "{simulated:?}");
    let texture = near.standards.texture.as_ref().unwrap();
    let with_u = texture.figures.iter().filter(|figure| figure.u.is_some());
    let names: Vec<&str> = with_u.map(|figure| figure.name.as_str()).collect();
    assert_eq!(names, ["Sa", "Sq", "Sp", "Sv", "Sz"]);
    reads_itself(near);
    assert_eq!(found("minimum_zone_nm = 30").report.verdict.status, Status::Fail);
    let within = format!("minimum_zone_nm = {}", zone.value + zone.u.unwrap());
    let verdict = found(&within).report.verdict;
    assert_eq!(verdict.status, Status::Undecided);
    let why = "minimum zone: the figure is nearer to its limit than its guard band";
    assert!(verdict.reasons.iter().any(|reason| reason == why), "{verdict:?}");
}

#[test]
fn limits_of_a_drawing_and_of_what_terms_leave_decide() {
    let verdict = |limits: &str| {
        let draws = "[uncertainty]\nnoise_nm = 0.1\ndraws = 20\n";
        measured(&format!("{limits}\n{draws}")).report.verdict
    };
    let drawing = verdict("[tolerance]\nindication = \"3/0.1(0.1/-); RMSi<0.05; λ=546.07\"\n");
    assert_eq!(drawing.status, Status::Fail, "{drawing:?}");
    let held: Vec<(&str, bool)> =
        drawing.checks.iter().map(|check| (check.figure.name.as_str(), check.ok)).collect();
    // A is next to nothing, B about 45 nm and RMSi about 10 nm, where 27.3, 27.3 and 13.7 nm are allowed.
    assert_eq!(held, [("a_nm", true), ("b_nm", false), ("rmsi_nm", true)]);
    let measurement = measured("[tolerance]\nrmsi_nm = 20\n[uncertainty]\nnoise_nm = 0.1\n");
    let rms_i = form(&measurement).figures.iter().find(|figure| figure.name == "RMSi");
    assert!(rms_i.unwrap().u.is_some_and(|u| u > 0.0), "{rms_i:?}");
    let less = verdict("[[tolerance.less]]\nterms = [\"astigmatism\"]\nrms_nm = 6\n");
    assert_eq!(less.status, Status::Pass, "{less:?}");
    assert_eq!(less.checks[0].figure.name, "rms_nm less astigmatism");
    assert!((less.checks[0].value - 5.0 / 2f64.sqrt()).abs() < 0.1);
    assert!(less.checks[0].u.is_some_and(|u| u > 0.0));
}

/// A limit alone costs no simulated measurements. What it is held against is the same.
#[test]
fn values_do_not_hang_on_whether_their_uncertainty_is_asked_for() {
    let limits = "[tolerance]\npv_nm = 90\nrms_nm = 40\npvr_nm = 90\nslope_rms_urad = 90\nslope_over_mm = 0.4\n\
                  slope_step_mm = 0.2\nindication = \"3/0.5(0.2/0.1); RMSi<0.05; λ=546.07\"\n\
                  [[tolerance.zone]]\nouter_mm = 2\npv_nm = 70\nrms_nm = 40\npvr_nm = 90\n\
                  [[tolerance.less]]\nterms = [\"astigmatism\"]\nrms_nm = 9\npvr_nm = 40\n";
    let plain = measured(limits);
    let asked = measured(&format!("{limits}[uncertainty]\nnoise_nm = 0.1\ndraws = 20\n"));
    let held = |measurement: &Measurement| -> Vec<(String, f64, bool)> {
        let checks = measurement.report.verdict.checks.iter();
        checks.map(|check| (check.figure.name.clone(), check.value, check.ok)).collect()
    };
    assert_eq!(held(&plain), held(&asked));
    assert_eq!(held(&plain).len(), 13, "{:?}", plain.report.verdict);
    // Those of PV and RMS of the whole are known without draws.
    let with_u = plain.report.verdict.checks.iter().filter(|check| check.u.is_some());
    let names: Vec<&str> = with_u.map(|check| check.figure.name.as_str()).collect();
    assert_eq!(names, ["pv_nm", "rms_nm"]);
    assert!(asked.report.verdict.checks.iter().all(|check| check.u.is_some()));
    let zones = |measurement: &Measurement| {
        let figures = form(measurement).figures.iter();
        figures.filter(|figure| figure.variant == "from 0 to 2 mm").count()
    };
    assert_eq!((zones(&plain), zones(&asked)), (3, 3));
}

/// Each check of a verdict is a figure of the report, with one value. Slopes of limits were formed over another length than those of
/// the report, and RMS with terms removed stood in the report by area alone.
#[test]
fn what_a_limit_holds_is_a_figure_of_the_report() {
    let limits = "[tolerance]\npv_nm = 90\nrms_nm = 40\nslope_max_urad = 90\nslope_rms_urad = 90\ngradient_max_urad = 90\n\
                  gradient_rms_urad = 90\nslope_over_mm = 0.4\nslope_step_mm = 0.2\nrmsi_nm = 40\n\
                  [[tolerance.zone]]\nouter_mm = 2\nrms_nm = 40\nslope_max_urad = 90\n\
                  [[tolerance.less]]\nterms = [\"astigmatism\"]\nrms_nm = 9\npvr_nm = 40\n\
                  [[tolerance.less]]\nterms = [\"piston\", \"tilt\"]\npv_nm = 90\nrms_nm = 40\n";
    let meridional = |measurement: &Measurement| -> Vec<String> {
        let figures = form(measurement).figures.iter().filter(|figure| figure.id == "slope_max");
        figures.map(|figure| figure.variant.clone()).collect()
    };
    for (figures, lengths) in [
        ("", vec!["over 0.4 mm", "over 0.4 mm, from 0 to 2 mm"]),
        (
            "[figures]\nslope_length_mm = 1\n",
            vec!["over 1 mm", "over 0.4 mm", "over 0.4 mm, from 0 to 2 mm"],
        ),
    ] {
        let measurement = measured(&format!("{limits}{figures}"));
        let checks = &measurement.report.verdict.checks;
        assert_eq!(checks.len(), 13, "{checks:?}");
        for check in checks {
            let of_report = form(&measurement).figures.iter();
            let same = of_report.filter(|figure| {
                figure.id == check.figure.id && (figure.value / check.value - 1.0).abs() < 1e-12
            });
            assert!(same.count() > 0, "{check:?}: {:#?}", form(&measurement).figures);
            let is_slope = check.figure.unit == "µrad";
            let says_over = check.figure.words().contains("over 0.4 mm");
            assert_eq!(is_slope, says_over, "{}", check.figure.words());
        }
        assert_eq!(meridional(&measurement), lengths);
        // No figure stands twice in the report.
        let of_report = &form(&measurement).figures;
        let mut keys: Vec<(&str, &str)> =
            of_report.iter().map(|figure| (&figure.id[..], &figure.variant[..])).collect();
        keys.sort_unstable();
        keys.dedup();
        assert_eq!(keys.len(), of_report.len());
    }
}
