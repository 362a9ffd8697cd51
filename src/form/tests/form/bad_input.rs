//! What a fit says of input that cannot give what is wanted.

use std::sync::Arc;

use asphera_form::{
    Aperture, Asphere, Caution, FitError, FitSettings, Nominal, Parameter, PointMm, Pose, Units,
    fit, fit_weighted,
};

use crate::common::{Noise, al1815, misaligned, spiral};
use crate::shapes::{Revolved, saddle};

fn rough(nominal: &Nominal, places: &[[f64; 2]], factor: f64) -> Vec<PointMm> {
    let mut noise = Noise::new(4);
    let point = |&[x, y]: &[f64; 2]| {
        let z = nominal.height_mm(x, y).unwrap() + 2e-5 * noise.next();
        misaligned().to_measured([x, y, z]).map(|coordinate| coordinate * factor)
    };
    places.iter().map(point).collect()
}

/// Profilers write places in mm and heights in µm or nm.
#[test]
fn heights_alone_in_another_unit_are_told() {
    let sphere = Nominal::Sphere { radius_mm: 20.0 };
    for nominal in [sphere, al1815(), saddle()] {
        for (heights_are, factor, unit) in [(1e3, 1e-3, "in µm,"), (1e6, 1e-6, "in nm,")] {
            let points = rough(&nominal, &spiral(2_000, 8.0), 1.0);
            let points: Vec<PointMm> =
                points.into_iter().map(|[x, y, z]| [x, y, z * heights_are]).collect();
            let told = match fit(&points, &nominal, &FitSettings::default()) {
                Err(FitError::Units(units)) => Some(units),
                Ok(fitted) => fitted.cautions.into_iter().find_map(|caution| match caution {
                    Caution::Units(units) => Some(units),
                    _ => None,
                }),
                Err(_) => None,
            };
            let units = told.expect("a word on the units");
            assert!(units.heights_only && units.factor == factor, "{nominal}: {units}");
            assert!(units.to_string().contains(unit), "{units}");
        }
    }
}

/// A curved line lies in a plane: that its height over it is rounding says nothing of units.
#[test]
fn a_line_of_points_is_not_in_another_unit() {
    let sphere = Nominal::Sphere { radius_mm: 30.0 };
    let points: Vec<PointMm> = (-250..=250)
        .map(|step| f64::from(step) * 0.036)
        .map(|x| [x, 0.0, sphere.sag_mm(x.abs())])
        .collect();
    let fitted = fit(&points, &sphere, &FitSettings::default()).unwrap();
    assert_eq!(fitted.cautions, []);
}

#[test]
fn points_in_micrometres_or_metres_are_told() {
    let sphere = Nominal::Sphere { radius_mm: 20.0 };
    for nominal in
        [sphere.clone(), al1815(), saddle(), Nominal::Freeform(Arc::new(Revolved(sphere)))]
    {
        for (points_are, factor) in [(1e3, 1e-3), (1e-3, 1e3)] {
            let points = rough(&nominal, &spiral(2_000, 8.0), points_are);
            let told = match fit(&points, &nominal, &FitSettings::default()) {
                Err(FitError::Units(units)) => Some(units),
                Ok(fitted) => fitted.cautions.into_iter().find_map(|caution| match caution {
                    Caution::Units(units) => Some(units),
                    _ => None,
                }),
                Err(_) => None,
            };
            let Units { factor: found, then, .. } = told.expect("a word on the units");
            assert_eq!(found, factor, "{nominal}");
            assert!(then < 1e-3, "{nominal}: {then:e}");
            let [unit, cure] = match factor < 1.0 {
                true => ["in µm", "divided by 1000 they fit"],
                false => ["in m,", "multiplied by 1000 they fit"],
            };
            let words = told.unwrap().to_string();
            assert!(words.contains(unit) && words.contains(cure), "{words}");
        }
        let points = rough(&nominal, &spiral(2_000, 8.0), 1.0);
        let fitted = fit(&points, &nominal, &FitSettings::default()).unwrap();
        assert_eq!(fitted.cautions, [], "{nominal}");
    }
}

#[test]
fn points_on_something_else_are_not_taken_for_another_unit() {
    let bumps: Vec<PointMm> = spiral(2_000, 8.0)
        .into_iter()
        .map(|[x, y]| [x, y, 0.3 * (2.0 * x).sin() * (1.5 * y).cos()])
        .collect();
    let fitted = fit(&bumps, &al1815(), &FitSettings::default()).unwrap();
    assert!(!fitted.cautions.iter().any(|caution| matches!(caution, Caution::Units(_))));
    let flat: Vec<PointMm> = spiral(500, 8.0).into_iter().map(|[x, y]| [x, y, 1.0]).collect();
    let fitted = fit(&flat, &al1815(), &FitSettings::default()).unwrap();
    assert!(!fitted.cautions.iter().any(|caution| matches!(caution, Caution::Units(_))));
}

#[test]
fn the_end_of_the_domain_is_told_with_the_points_beyond() {
    let small = Nominal::Sphere { radius_mm: 5.0 };
    let mut points: Vec<PointMm> =
        spiral(2_000, 4.5).into_iter().map(|[x, y]| [x, y, small.sag_mm(x.hypot(y))]).collect();
    points.extend([[7.0, 0.0, 6.0], [0.0, 9.5, 7.0]]);
    let fitted =
        fit(&points, &small, &FitSettings { search: false, ..FitSettings::default() }).unwrap();
    let [Caution::BeyondDomain { domain_mm, beyond, farthest_mm }] = fitted.cautions[..] else {
        unreachable!("{:?}", fitted.cautions)
    };
    assert_eq!((domain_mm, beyond), (5.0, 2));
    assert!((farthest_mm - 9.5).abs() < 1e-9);
    let text = fitted.cautions[0].to_string();
    assert!(
        text.starts_with("2 points in the aperture lie beyond the nominal, which ends 5.0"),
        "{text}"
    );
}

#[test]
fn every_coefficient_over_half_a_lens_is_ill_conditioned_and_says_where() {
    let half: Vec<[f64; 2]> = spiral(4_000, 9.0).into_iter().filter(|[x, _]| *x > 0.5).collect();
    let points = rough(&al1815(), &half, 1.0);
    let powers = (4..=16).step_by(2).map(Parameter::A);
    let shape = [Parameter::Radius, Parameter::Conic].into_iter().chain(powers);
    let free: Vec<Parameter> = Parameter::RIGID.into_iter().chain(shape).collect();
    let settings = FitSettings { free, ..FitSettings::default() };
    let fitted = fit(&points, &al1815(), &settings).unwrap();
    let weakest = fitted.weakest.as_ref().unwrap();
    eprintln!("condition {:e}: {weakest}", fitted.condition);
    assert!(fitted.condition > 1e6);
    assert!((weakest.ratio * fitted.condition - 1.0).abs() < 1e-9);
    let square: f64 = weakest.terms.iter().map(|(_, share)| share * share).sum();
    assert!((0.9..=1.0 + 1e-12).contains(&square) && weakest.terms.len() >= 2);
    assert!(fitted.cautions.iter().any(|caution| matches!(
        caution,
        Caution::IllConditioned { condition, combination }
            if *condition == fitted.condition && combination == weakest
    )));
    // What is left of the parameters is told with its covariance.
    let covariance = fitted.covariance.as_ref().unwrap();
    assert_eq!(covariance.size(), fitted.estimates.len());
    for (index, estimate) in fitted.estimates.iter().enumerate() {
        let u = covariance.entry(index, index).unwrap().sqrt();
        assert!((u / estimate.u.unwrap() - 1.0).abs() < 1e-9);
    }
    let (_, _, worst) = covariance.worst_pair().unwrap();
    assert!(worst.abs() > 0.999 && worst.abs() <= 1.0);
}

/// An uncertainty without its decimals, or in m beside mm, lets one point take all the weight.
#[test]
fn a_point_that_counts_for_all_is_told() {
    let points = rough(&al1815(), &spiral(2_000, 8.0), 1.0);
    let told = |least_mm: f64| {
        let mut u_mm = vec![1e-5; points.len()];
        u_mm[700] = least_mm;
        let fitted = fit_weighted(&points, Some(&u_mm), &al1815(), &FitSettings::default());
        fitted.unwrap().cautions
    };
    let [Caution::FewCount { effective, used: 2_000, estimated: 5 }] = told(1e-9)[..] else {
        panic!("{:?}", told(1e-9))
    };
    assert!((effective - 1.0).abs() < 1e-3, "{effective}");
    assert!(told(1e-6).is_empty(), "{:?}", told(1e-6));
}

#[test]
fn a_valley_that_bends_is_followed_to_its_end() {
    // Over half of a lens radius, conic and coefficients can hardly be told apart, and the sum of squares
    // has a long valley that bends.
    let half: Vec<[f64; 2]> = spiral(20_000, 9.0).into_iter().filter(|[x, _]| *x > 0.0).collect();
    let coefficients = [(4, 3.69e-5), (6, -1.285e-8), (8, -1.4e-10)];
    let lens = Nominal::Asphere(Asphere::new(11.65, -1.1, &coefficients).unwrap());
    let mut noise = Noise::new(4);
    let point = |&[x, y]: &[f64; 2]| {
        let wave = 3e-5 * x.cos() * (y / 2.0).sin();
        [x, y, lens.height_mm(x, y).unwrap() + wave + 5e-6 * noise.next()]
    };
    let points: Vec<PointMm> = half.iter().map(point).collect();
    let shape = [Parameter::Radius, Parameter::Conic].into_iter();
    let powers = [4, 6, 8].map(Parameter::A);
    let free = Parameter::RIGID.into_iter().chain(shape).chain(powers).collect();
    let fitted = fit(&points, &lens, &FitSettings { free, ..FitSettings::default() }).unwrap();
    assert!(fitted.termination.is_converged(), "{:?}", fitted.termination);
    assert!(fitted.condition > 1e5, "{:e}", fitted.condition);
}

#[test]
fn residual_figures_are_those_of_the_distances() {
    let points = rough(&al1815(), &spiral(3_000, 9.0), 1.0);
    let fitted = fit(&points, &al1815(), &FitSettings::default()).unwrap();
    let found = asphera_form::deviations(&points, &fitted.nominal, &fitted.pose);
    let (low, high) =
        found.iter().fold((0.0, 0.0), |(low, high): (f64, f64), d| (low.min(*d), high.max(*d)));
    let rms = (found.iter().map(|d| d * d).sum::<f64>() / found.len() as f64).sqrt();
    let told = fitted.residuals;
    assert!((told.rms_mm - rms).abs() < 1e-14 && (told.low_mm - low).abs() < 1e-13);
    assert!((told.high_mm - high).abs() < 1e-13);
    assert!(fitted.evaluations > fitted.iterations && fitted.robust.is_none());
}

#[test]
fn an_empty_aperture_in_another_unit_is_told() {
    let points = rough(&al1815(), &spiral(2_000, 8.0), 1e3);
    let ring = Aperture::Annulus { inner_mm: 0.5, outer_mm: 8.5 };
    let start = Pose { tz_mm: 400.0, ..Pose::default() };
    let settings = FitSettings { aperture: ring, start, ..FitSettings::default() };
    let told = match fit(&points, &al1815(), &settings) {
        Err(FitError::Units(units)) => units.factor,
        Ok(fitted) => fitted
            .cautions
            .iter()
            .find_map(|caution| match caution {
                Caution::Units(units) => Some(units.factor),
                _ => None,
            })
            .expect("a word on the units"),
        Err(other) => unreachable!("{other}"),
    };
    assert_eq!(told, 1e-3);
}
