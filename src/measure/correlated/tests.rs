//! Tests of the sources of u.

use crate::nominal::parse;
use crate::random::Random;
use asphera_report::{FormFigures, Report, UncertaintyFigures};

use super::super::Pipeline;
use super::*;

const PLANE: &str = "[surface]\nkind = \"plane\"\n";
const SPHERE: &str = "[surface]\nkind = \"sphere\"\nradius_mm = 1000\n\
    [fit]\nfree = [\"tz\", \"rx\", \"ry\", \"radius\"]\n";

/// A part with a wave of 20 nm over 30 mm, or without, and noise of some 10 nm: `bend_per_mm` of a sphere.
fn part(nominal: &str, bend_per_mm: f64, wave_nm: f64) -> Report {
    let mut pipeline = Pipeline::new(parse("p.toml", nominal).unwrap());
    let mut random = Random(7);
    let mut uniform = || random.centred();
    for index in 0..3600_u32 {
        let (x, y) = (f64::from(index % 60), f64::from(index / 60));
        let wave = wave_nm * (0.2 * x + 0.08 * y).sin() * (0.12 * y - 0.04 * x).cos();
        let noise = 10.0 * 3.0_f64.sqrt() * (0..4).map(|_| uniform()).sum::<f64>();
        let square = (x - 29.5).powi(2) + (y - 29.5).powi(2);
        let sag = bend_per_mm * square / (1.0 + (1.0 - bend_per_mm * bend_per_mm * square).sqrt());
        pipeline.take_position([x - 29.5, y - 29.5, sag + 1e-6 * (wave + noise)]);
    }
    pipeline.finish().report
}

fn measured(wave_nm: f64, rest: &str) -> Report {
    part(&format!("{PLANE}{rest}"), 0.0, wave_nm)
}

fn sphere(radius_mm: f64, wave_nm: f64, rest: &str) -> FormFigures {
    part(&format!("{SPHERE}{rest}"), radius_mm.recip(), wave_nm).form.unwrap()
}

/// The radius at which the fit finds one that is off the design by twice what u allows.
fn doubtful_mm() -> f64 {
    let found = sphere(1000.0, 20.0, "").fit.parameters["radius"].clone();
    2000.0 + 2.0 * NORMAL * found.u.unwrap() - found.value
}

fn kinds(form: &FormFigures) -> Vec<&str> {
    let all = form.fit.details.cautions.iter().map(|caution| &caution.kind[..]);
    // That the shape is free is said of every such fit.
    all.filter(|kind| *kind != "free_shape").collect()
}

/// What form does to the pose is told where u has an interval of it, but there is no design it could miss.
#[test]
fn where_a_part_lies_needs_no_caution() {
    let plain = measured(20.0, "").form.unwrap();
    assert_eq!((kinds(&plain), &plain.fit.details.correlation), (Vec::new(), &None));
    assert_eq!(plain.fit.details.u_model.as_deref(), Some(FitDetails::BY_RESIDUALS));
    assert!(plain.fit.parameters.values().all(|figures| figures.u_by_form.is_none()));
    let told = measured(20.0, "[uncertainty]\nnoise_nm = 10\n").form.unwrap();
    assert_eq!(kinds(&told), Vec::<&str>::new());
    for (name, of) in &told.fit.parameters {
        assert!(of.u_by_form.unwrap() > 1.5 * of.u.unwrap(), "{name} {of:?}");
    }
    let covers = told.fit.details.expanded_covers.as_deref().unwrap();
    assert!(covers.contains("places") && covers.contains("u_by_form"), "{covers}");
}

/// A radius is cautioned of where u alone would prove it wrong, and else what form does to it is told, and no more.
#[test]
fn a_caution_stands_where_form_takes_back_what_u_proves() {
    let radius = |form: &FormFigures| form.fit.parameters["radius"].clone();
    let right = sphere(doubtful_mm(), 20.0, "");
    let found = radius(&right);
    let (off, by_form) = ((found.value - 1000.0).abs(), found.u_by_form.unwrap());
    assert!(off > NORMAL * found.u.unwrap() && off < 2.0 * by_form, "{found:?}");
    assert_eq!(kinds(&right), ["correlated"]);
    let cautions = &right.fit.details.cautions;
    let text = &cautions.iter().find(|one| one.kind == "correlated").unwrap().text;
    assert!(text.contains("not proven") && text.contains("radius is"), "{text}");
    let seen = right.fit.details.correlation.as_ref().unwrap();
    assert_eq!((seen.counted, seen.largest_ratio_of.as_deref()), (false, Some("radius")));
    assert!((seen.largest_ratio.unwrap() / (by_form / found.u.unwrap()) - 1.0).abs() < 1e-9);
    assert!(seen.independent_p.unwrap() < 1e-9 && seen.patches >= 56, "{seen:?}");
    assert!(right.fit.parameters["tz"].u_by_form.is_some());

    // Off by more than form explains: what u proves stands.
    let wrong = sphere(1000.0 + 20.0 * by_form, 20.0, "");
    assert_eq!(kinds(&wrong), Vec::<&str>::new());
    assert!((radius(&wrong).u_by_form.unwrap() / by_form - 1.0).abs() < 0.1);
    assert!(wrong.fit.details.correlation.is_some());

    let counted = sphere(doubtful_mm(), 20.0, "[uncertainty]\ncorrelation = \"deviations\"\n");
    assert_eq!(kinds(&counted), Vec::<&str>::new());
    let of = radius(&counted);
    assert!((0.5..2.0).contains(&(of.u.unwrap() / by_form)), "{of:?} {by_form}");
    assert_eq!(of.u_by_form, None);
}

#[test]
fn correlated_deviations_are_counted_where_asked() {
    let plain = measured(20.0, "").form.unwrap();
    let counted = measured(20.0, "[uncertainty]\ncorrelation = \"deviations\"\n").form.unwrap();
    let details = &counted.fit.details;
    assert_eq!(details.u_model.as_deref(), Some(FitDetails::BY_DEVIATIONS));
    let seen = details.correlation.as_ref().unwrap();
    assert!(seen.counted && seen.largest_ratio.unwrap() > 2.0, "{seen:?}");
    let by = |form: &FormFigures, name: &str| form.fit.parameters[name].clone();
    let most = seen.largest_ratio_of.as_deref().unwrap();
    let ratio = by(&counted, most).u.unwrap() / by(&plain, most).u.unwrap();
    assert!((ratio / seen.largest_ratio.unwrap() - 1.0).abs() < 1e-9, "{ratio} {seen:?}");
    let of = by(&counted, most);
    assert!(of.expanded_95.unwrap() > 1.2 * of.u.unwrap(), "{of:?}");
    let covariance = details.covariance.as_ref().unwrap();
    let at = covariance.parameters.iter().position(|name| name == most).unwrap();
    assert!((covariance.covariance[at][at].sqrt() / of.u.unwrap() - 1.0).abs() < 1e-12);
    let of_figures = counted.deviation.uncertainty.unwrap();
    assert_eq!(of_figures.model, UncertaintyFigures::NOISE_BESIDE_FORM);
}

#[test]
fn noise_and_what_is_stated_need_no_caution() {
    let noise = sphere(1000.0, 0.0, "");
    assert_eq!((kinds(&noise), &noise.fit.details.correlation), (Vec::new(), &None));
    for rest in [
        "[uncertainty]\ncorrelation = \"none\"\n",
        "[uncertainty]\nlong_wave_nm = 10\nlong_wave_mm = 8\nlong_wave_kernel = \"matern\"\n",
    ] {
        let form = sphere(1000.0, 20.0, rest);
        assert_eq!(kinds(&form), Vec::<&str>::new());
        assert_eq!(form.fit.details.correlation, None);
    }
    let form = sphere(doubtful_mm(), 20.0, "[uncertainty]\nnoise_nm = 8\n");
    assert_eq!(kinds(&form), ["correlated"]);
    assert_eq!(form.fit.details.u_model.as_deref(), Some(UncertaintyFigures::NOISE_ONLY));
}

#[test]
fn the_machine_counts_beside_the_deviations() {
    let rest = "[uncertainty]\ncorrelation = \"deviations\"\n";
    let alone = measured(20.0, rest).form.unwrap();
    let both = measured(20.0, &format!("{rest}square_xz_arcsec = 2\n")).form.unwrap();
    let machine = measured(20.0, "[uncertainty]\nsquare_xz_arcsec = 2\nnoise_nm = 0\n");
    let machine = machine.form.unwrap();
    // Beside the machine a budget counts the places; form error drawn anew does not.
    let places = measured(20.0, "[uncertainty]\nnoise_nm = 1e-6\n").form.unwrap();
    for (name, of) in &both.fit.parameters {
        let [a, b, c] =
            [&alone, &machine, &places].map(|form| form.fit.parameters[name].u.unwrap());
        let square = a * a + b * b - c * c;
        assert!((of.u.unwrap() / square.sqrt() - 1.0).abs() < 1e-5, "{name}");
    }
    let model = both.fit.details.u_model.as_deref();
    assert_eq!(model, Some(FitDetails::BY_DEVIATIONS_AND_MACHINE));
    assert_eq!(both.deviation.uncertainty.unwrap().model, UncertaintyFigures::BUDGET);
}

#[test]
fn too_few_points_are_said() {
    let text = format!("{PLANE}[uncertainty]\ncorrelation = \"deviations\"\nnoise_nm = 1\n");
    let mut pipeline = Pipeline::new(parse("p.toml", &text).unwrap());
    for index in 0..9_u32 {
        let (x, y) = (f64::from(index % 3), f64::from(index / 3));
        pipeline.take_position([x, y, 1e-6 * f64::from(index * index % 5)]);
    }
    let form = pipeline.finish().report.form.unwrap();
    let why = form.unknown.iter().find(|why| why.starts_with("uncertainties by the"));
    assert!(why.is_some_and(|why| why.contains("9 points are too few")), "{:?}", form.unknown);
    assert_eq!(form.fit.details.u_model.as_deref(), Some(UncertaintyFigures::NOISE_BESIDE_FORM));
}

#[test]
fn two_digits_are_enough() {
    let found = [4.56e-7, 0.0123, 3.1618, 14.9, 1234.0].map(two_digits);
    assert_eq!(found, ["4.6e-7", "0.012", "3.2", "15", "1234"]);
}
