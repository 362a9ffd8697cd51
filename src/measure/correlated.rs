//! What u of pose and parameters is made of, and whether it counts that deviations are correlated.

use asphera_form::{Covariance, Parameter, Pose};
use asphera_geometry::PointMm;
use asphera_report::{CautionFigures, CorrelationFigures, FitDetails, FormFigures};
use asphera_uncertainty::{TypeA, UncertaintyError, glance, type_a};

use super::errors;
use super::fit_details;
use super::fitting::Fitted;
use super::uncertainties::{Assessed, COVERAGE};
use crate::{CorrelationFrom, Part};

/// Writes into the fit what its uncertainties are made of: those of the deviations as the nominal file asks, else what
/// they would be where these are plainly correlated and nothing counts it. `points` and `deviations_mm` are those of the
/// fit; `assessed` what a budget made of it.
pub(super) fn tell(
    form: &mut FormFigures,
    part: &Part,
    fitted: &Fitted,
    (points, deviations_mm): (&[PointMm], &[f64]),
    assessed: Option<&Assessed>,
) {
    let by_residuals = FitDetails::BY_RESIDUALS.to_owned();
    form.fit.details.u_model = Some(by_residuals);
    if fitted.reference.is_some() {
        // Its parameters are those of the base alone, about which most of the form remains.
        return;
    }
    let fit = &fitted.fit;
    if let Some(assessed) = assessed {
        form.fit.details.u_model = Some(errors::model(part).to_owned());
        form.fit.details.covariance = Some(fit_details::covariance(assessed.covariance(), fit));
    }
    let weights = fitted.uncertainties_mm.as_deref();
    match part.judging.correlated {
        CorrelationFrom::Nothing => {}
        CorrelationFrom::Deviations => match type_a(points, fit, &part.aperture, weights) {
            Ok(found) => count(form, part, fitted, &found, assessed),
            Err(error) => form.unknown.push(unknown(&error)),
        },
        CorrelationFrom::Budget if errors::has_correlated(part) => {}
        // Of the pose alone nothing is claimed but where a budget gives it an interval.
        CorrelationFrom::Budget
            if assessed.is_none() && !fit.estimates.iter().any(|of| is_of_shape(of.parameter)) => {}
        CorrelationFrom::Budget => {
            match glance(points, deviations_mm, fit, &part.aperture, weights) {
                Ok(Some(seen)) => compare(form, part, &seen),
                // Too few points to see by.
                Ok(None) => {}
                Err(error) => form.unknown.push(unknown(&error)),
            }
        }
    }
}

fn unknown(error: &UncertaintyError) -> String {
    format!("uncertainties by the deviations: {error}")
}

/// Takes the uncertainties of the parameters from the deviations, and beside them the effects of the machine.
fn count(
    form: &mut FormFigures,
    part: &Part,
    fitted: &Fitted,
    found: &TypeA,
    assessed: Option<&Assessed>,
) {
    let fit = &fitted.fit;
    let effects = assessed.map(Assessed::correlated);
    let ratio = largest_ratio(found, |parameter| {
        fit.estimates.iter().find(|estimate| estimate.parameter == parameter)?.u
    });
    for (index, of) in found.parameters.iter().enumerate() {
        let u = effects.and_then(|effects| effects.entry(index, index)).unwrap_or(0.0).sqrt();
        if let Some(figures) = form.fit.parameters.get_mut(&of.parameter.name(&part.nominal)) {
            figures.u = Some(of.u.hypot(u)).filter(|u| u.is_finite());
            // The squares of half widths add up as those of standard deviations, nearly.
            let half = of.expanded(COVERAGE).expanded.hypot(NORMAL * u);
            figures.expanded_95 = Some(half).filter(|half| half.is_finite());
        }
    }
    let mut covariance = fit_details::covariance(&found.covariance, fit);
    if let Some(effects) = effects {
        fit_details::add(&mut covariance, effects);
    }
    let details = &mut form.fit.details;
    details.covariance = Some(covariance);
    let beside = effects.is_some_and(varies);
    let model =
        if beside { FitDetails::BY_DEVIATIONS_AND_MACHINE } else { FitDetails::BY_DEVIATIONS };
    details.u_model = Some(model.to_owned());
    details.expanded_covers = Some(FitDetails::COVERS_MAKE.to_owned());
    details.correlation = Some(figures(found, part, ratio, true));
}

/// Where the deviations are plainly correlated, tells what form like this does to the parameters, and warns where u as told
/// proves one of the shape off its design and these do not.
///
/// Of the pose there is no warning: it has no design, and says where this very part lay.
fn compare(form: &mut FormFigures, part: &Part, seen: &TypeA) {
    if seen.independence.is_none_or(|found| found.p > PLAIN) {
        return;
    }
    let told = |parameter: Parameter| form.fit.parameters.get(&parameter.name(&part.nominal));
    // Where the shape is free, it is what the deviations are about.
    let shape_is_free = seen.parameters.iter().any(|of| is_of_shape(of.parameter));
    let counts = |parameter: Parameter| is_of_shape(parameter) || !shape_is_free;
    let of_those = |parameter| told(parameter).filter(|_| counts(parameter))?.u;
    let Some((parameter, ratio)) = largest_ratio(seen, of_those) else { return };
    if ratio < LEAST_RATIO {
        return;
    }
    let of_shape = seen.parameters.iter().filter(|of| is_of_shape(of.parameter));
    let unproven = of_shape.filter_map(|of| {
        let told = told(of.parameter)?;
        let design = of.parameter.value(&Pose::default(), &part.nominal)?;
        let (off, half) = ((told.value - design).abs(), of.expanded(COVERAGE).expanded);
        let half_told = told.expanded_95.or(told.u.map(|u| NORMAL * u))?;
        let unit = if told.unit == "1" { String::new() } else { format!(" {}", told.unit) };
        (half_told < off && off <= half).then(|| {
            let name = of.parameter.name(&part.nominal);
            let [off, half_told, half] = [off, half_told, half].map(two_digits);
            format!(
                "{name} is {off}{unit} off its design, more than the {half_told} that u allows, but not than the {half} \
                 that form error like this part's makes"
            )
        })
    });
    let unproven: Vec<String> = unproven.collect();
    let details = &mut form.fit.details;
    if !unproven.is_empty() {
        details.cautions.push(CautionFigures {
            kind: "correlated".to_owned(),
            text: format!(
                "it is not proven that the design is missed: {} (at 95 %). Deviations are correlated over about {} mm, which \
                 u does not count; correlation = \"deviations\" in the table uncertainty does",
                unproven.join("; "),
                two_digits(seen.correlation.length_mm),
            ),
            forbids_verdict: false,
        });
    }
    details.correlation = Some(figures(seen, part, Some((parameter, ratio)), false));
    for of in &seen.parameters {
        if let Some(figures) = form.fit.parameters.get_mut(&of.parameter.name(&part.nominal)) {
            figures.u_by_form = Some(of.u).filter(|u| u.is_finite());
        }
    }
}

/// The parameter whose uncertainty by the deviations is the most times that told, and how many.
fn largest_ratio(
    found: &TypeA,
    told: impl Fn(Parameter) -> Option<f64>,
) -> Option<(Parameter, f64)> {
    ratios(found, told).reduce(|most, one| if one.1 > most.1 { one } else { most })
}

/// How many times that told the uncertainty of each parameter is by the deviations.
fn ratios(
    found: &TypeA,
    told: impl Fn(Parameter) -> Option<f64>,
) -> impl Iterator<Item = (Parameter, f64)> {
    found.parameters.iter().filter_map(move |of| {
        let ratio = of.u / told(of.parameter)?;
        ratio.is_finite().then_some((of.parameter, ratio))
    })
}

fn figures(
    found: &TypeA,
    part: &Part,
    ratio: Option<(Parameter, f64)>,
    counted: bool,
) -> CorrelationFigures {
    let correlation = &found.correlation;
    CorrelationFigures {
        counted,
        kernel: correlation.kernel.name().to_owned(),
        length_mm: correlation.length_mm,
        sigma_nm: 1e6 * correlation.sigma_mm,
        rest_nm: 1e6 * correlation.rest_mm,
        kernels: found.kernels.iter().map(|(kernel, p)| (kernel.name().to_owned(), *p)).collect(),
        patches: found.patches as u64,
        patch_ratio: found.independence.map(|found| found.ratio),
        independent_p: found.independence.map(|found| found.p),
        largest_ratio: ratio.map(|(_, ratio)| ratio),
        largest_ratio_of: ratio.map(|(parameter, _)| parameter.name(&part.nominal)),
    }
}

fn varies(covariance: &Covariance) -> bool {
    (0..covariance.size()).any(|i| covariance.entry(i, i).is_some_and(|variance| variance > 0.0))
}

/// Whether a parameter is one of the part, and not of where it lies.
fn is_of_shape(parameter: Parameter) -> bool {
    !Parameter::POSE.contains(&parameter)
}

/// A number above 0 to two digits, and no less than its integral part.
fn two_digits(value: f64) -> String {
    if value < 1e-3 {
        return format!("{value:.1e}");
    }
    let places = (1.0 - value.log10().floor()).clamp(0.0, 9.0) as usize;
    format!("{value:.places$}")
}

/// Deviations are plainly correlated where independent ones would look so by a chance smaller than this.
const PLAIN: f64 = 1e-3;
/// By so many times an uncertainty must be larger by the deviations to be worth a word.
const LEAST_RATIO: f64 = 2.0;
/// Half the width of an interval of 95 % in standard deviations.
const NORMAL: f64 = 1.959_963_984_540_054;

#[cfg(test)]
mod tests {
    use crate::nominal::parse;
    use asphera_report::{Report, UncertaintyFigures};

    use super::super::Pipeline;
    use super::*;

    const PLANE: &str = "[surface]\nkind = \"plane\"\n";
    const SPHERE: &str = "[surface]\nkind = \"sphere\"\nradius_mm = 1000\n\
        [fit]\nfree = [\"tz\", \"rx\", \"ry\", \"radius\"]\n";

    /// A part with a wave of 20 nm over 30 mm, or without, and noise of some 10 nm: `bend_per_mm` of a sphere.
    fn part(nominal: &str, bend_per_mm: f64, wave_nm: f64) -> Report {
        let mut pipeline = Pipeline::new(parse("p.toml", nominal).unwrap());
        let mut state = 7_u64;
        let mut uniform = || {
            state = state
                .wrapping_mul(6_364_136_223_846_793_005)
                .wrapping_add(1_442_695_040_888_963_407);
            (state >> 33) as f64 / f64::from(1_u32 << 31) - 0.5
        };
        for index in 0..3600_u32 {
            let (x, y) = (f64::from(index % 60), f64::from(index / 60));
            let wave = wave_nm * (0.2 * x + 0.08 * y).sin() * (0.12 * y - 0.04 * x).cos();
            let noise = 10.0 * 3.0_f64.sqrt() * (0..4).map(|_| uniform()).sum::<f64>();
            let square = (x - 29.5).powi(2) + (y - 29.5).powi(2);
            let sag =
                bend_per_mm * square / (1.0 + (1.0 - bend_per_mm * bend_per_mm * square).sqrt());
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
        assert_eq!(
            form.fit.details.u_model.as_deref(),
            Some(UncertaintyFigures::NOISE_BESIDE_FORM)
        );
    }

    #[test]
    fn two_digits_are_enough() {
        let found = [4.56e-7, 0.0123, 3.1618, 14.9, 1234.0].map(two_digits);
        assert_eq!(found, ["4.6e-7", "0.012", "3.2", "15", "1234"]);
    }
}
