//! Terms of a known form, removed while it is measured and afterwards.

use asphera_report::Term;
use asphera_report::{FormFigures, FormView, FormViewAnswer, Source};

use crate::nominal::parse;
use crate::{Pipeline, RunningFigures};

const RADIUS_MM: f64 = 20.0;
const POWER_NM: f64 = 200.0;
const ASTIGMATISM_NM: f64 = 60.0;

/// Power and astigmatism on the unit disc.
fn two_terms_nm(u: f64, v: f64) -> f64 {
    POWER_NM * (2.0 * (u * u + v * v) - 1.0) + ASTIGMATISM_NM * (u * u - v * v)
}

/// A flat of 40 mm of this form, so tilted that the fit has something to do.
fn flat(form_nm: impl Fn(f64, f64) -> f64) -> impl Iterator<Item = [f64; 3]> {
    let line = |k: i32| f64::from(k) * 0.2;
    let raster = (-100..=100).flat_map(move |j| (-100..=100).map(move |i| [line(i), line(j)]));
    raster.filter(|[x, y]| x.hypot(*y) <= RADIUS_MM).map(move |[x, y]| {
        [x, y, 1e-4 * x - 3e-4 * y + form_nm(x / RADIUS_MM, y / RADIUS_MM) * 1e-6]
    })
}

const PART: &str = "[surface]\nkind = \"plane\"\n[aperture]\nshape = \"circle\"\nradius_mm = 20\n";

fn pipeline_of(points: impl Iterator<Item = [f64; 3]>) -> Pipeline {
    let mut pipeline = Pipeline::new(parse("part.toml", PART).unwrap());
    points.for_each(|point| pipeline.take_position(point));
    pipeline
}

fn pipeline() -> Pipeline {
    pipeline_of(flat(two_terms_nm))
}

fn good(answer: FormViewAnswer) -> FormView {
    answer.expect("there is a fit").expect("the terms can be removed")
}

fn term_nm(form: &FormFigures, index: u32) -> f64 {
    let terms = &form.zernike.as_ref().expect("the disc tells all terms apart").terms;
    terms.iter().find(|term| term.index == index).expect("the term is determined").value_nm
}

fn figure(form: &FormFigures, name: &str, variant: &str) -> f64 {
    let found = form.figures.iter().find(|it| it.name.starts_with(name) && it.variant == variant);
    found.unwrap_or_else(|| panic!("no {name} {variant}")).value
}

#[test]
fn the_cells_of_a_running_map_tell_the_terms_and_say_that_they_do() {
    let figures: RunningFigures = pipeline().figures();
    let form = figures.form.as_ref().unwrap();
    let zernike = form.zernike.as_ref().unwrap();
    assert_eq!((zernike.source, zernike.radius_mm), (Source::Cells, RADIUS_MM));
    // A cell of 0.42 mm smooths power by its 24th part of (0.42/20)²: far below 1 nm.
    assert!((term_nm(form, 4) - POWER_NM).abs() < 0.5, "{zernike:?}");
    assert!((term_nm(form, 5) - ASTIGMATISM_NM).abs() < 0.5, "{zernike:?}");
    assert!(zernike.residual_rms_nm < 1.0, "{zernike:?}");
    let histogram = form.histogram.as_ref().unwrap();
    assert_eq!(histogram.source, Source::Cells);
    assert_eq!(histogram.counts.iter().sum::<u64>(), figures.points.used, "no point is left out");
    let json = serde_json::to_value(form).unwrap();
    assert_eq!(json["zernike"]["source"], "map of cells");
    assert_eq!(json["histogram"]["source"], "map of cells");
}

/// R₁₀⁰, the finest of the 36 terms: blocks of cells take off what varies within them.
#[test]
fn the_finest_term_is_told_within_its_smoothing() {
    let finest = |u: f64, v: f64| {
        let q = u * u + v * v;
        100.0 * (-1.0 + q * (30.0 + q * (-210.0 + q * (560.0 + q * (-630.0 + q * 252.0)))))
    };
    let form = pipeline_of(flat(finest)).figures().form.unwrap();
    let found = term_nm(&form, 36);
    assert!((97.0..100.0).contains(&found), "{found}");
}

#[test]
fn removed_terms_are_gone_from_all_that_is_shown_and_nothing_else_is() {
    let running = pipeline().figures();
    let fitted = good(running.without(&[]));
    assert_eq!(Some(&fitted.map), running.map.as_ref(), "without a term the map is as it was");
    assert_eq!(Some(&fitted.histogram), running.form.unwrap().histogram.as_ref());
    let finished = pipeline().finish();
    for view in [
        good(pipeline().figures().without(&[Term::Power, Term::Piston])),
        good(finished.surface.without(&[Term::Power, Term::Piston])),
    ] {
        assert_eq!(view.removed, ["piston", "power"]);
        let removed: Vec<u32> = view.terms.iter().map(|term| term.index).collect();
        assert_eq!(removed, [1, 4]);
        assert!((view.terms[1].value_nm.unwrap() - POWER_NM).abs() < 1.0, "{:?}", view.terms);
        // Astigmatism is left: from -1 to 1 of its height, root mean square 1/√6.
        assert!((view.pv_nm - 2.0 * ASTIGMATISM_NM).abs() < 4.0, "{}", view.pv_nm);
        assert!((view.rms_nm - ASTIGMATISM_NM / 6.0_f64.sqrt()).abs() < 0.3, "{}", view.rms_nm);
        let cells = view.map.values_nm.iter().flatten();
        assert!(cells.clone().all(|nm| nm.abs() < 62.0) && cells.count() > 6000);
        assert!(view.histogram.low_nm > -70.0);
    }
}

#[test]
fn after_the_end_the_numbers_are_those_of_the_report() {
    let finished = pipeline().finish();
    let form = finished.report.form.as_ref().unwrap();
    let view = good(finished.surface.without(&[Term::Piston, Term::Tilt, Term::Power]));
    assert_eq!((view.source, view.provisional), (Source::Points, false));
    assert_eq!(view.as_of_points, finished.report.points.used);
    assert_eq!(view.pv_nm, figure(form, "PV", "piston, tilt, power removed"));
    assert_eq!(view.rms_nm, figure(form, "RMS", "piston, tilt, power removed"));
    let fitted = good(finished.surface.without(&[]));
    assert_eq!(fitted.pv_nm, figure(form, "PV", "as fitted"));
    assert_eq!(Some(&fitted.histogram), form.histogram.as_ref());
}

#[test]
fn what_the_places_do_not_tell_is_said() {
    let empty = pipeline_of(std::iter::empty()).figures();
    assert_eq!(empty.without(&[Term::Power]), None, "there is no fit yet");
    // The lowest fifth of the disc: 36 terms over the whole of it cannot be told from there.
    let strip = flat(two_terms_nm).filter(|[_, y, _]| *y < -12.0);
    let form = pipeline_of(strip).figures().form.unwrap();
    assert_eq!(form.zernike, None);
    assert!(form.unknown.iter().any(|why| why.contains("Zernike")), "{:?}", form.unknown);
    assert!(form.histogram.is_some(), "a histogram needs no terms");
}
