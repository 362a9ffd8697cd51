//! Input that makes no basis, no scale, or no expansion.

use asphera_form::basis::{
    Counting, ExpandError, Normalisation, Product, ProductError, Q2d, Q2dError, Scale, Zernike,
    ZernikeError, expand, zernike_value,
};

fn basis() -> Zernike {
    Zernike::first(Counting::Fringe, 4, Normalisation::UnitHeight).unwrap()
}

#[test]
fn no_points_and_fewer_points_than_terms() {
    let scale = Scale::round(5.0).unwrap();
    let error = expand(&basis(), &scale, &[], &[], None).unwrap_err();
    assert_eq!(
        error.to_string(),
        "0 usable points for 4 terms of the Fringe Zernike series (0 more lie outside its domain, \
         0 are not finite): give more points or fewer terms"
    );
    let places = [[0.0, 0.0], [1.0, 0.0], [f64::NAN, 0.0], [0.0, 6.0], [1.0, 1.0]];
    let error = expand(&basis(), &scale, &places, &[1.0; 5], None).unwrap_err();
    assert!(matches!(error, ExpandError::TooFew { used: 3, outside: 1, not_finite: 1, .. }));
}

#[test]
fn all_points_outside_names_the_cure() {
    let scale = Scale::round(5.0).unwrap();
    let places = [[7.0, 0.0], [0.0, -6.0], [5.5, 0.0], [0.0, 6.5]];
    let error = expand(&basis(), &scale, &places, &[1.0; 4], None).unwrap_err();
    assert_eq!(
        error.to_string(),
        "none of 4 points lies where the Fringe Zernike series is defined, half width 5 mm by 5 mm. \
         The points are 5.5 to 7 mm from the axis: centre them, or normalise by 7 mm or more"
    );
}

#[test]
fn lists_weights_and_sums_that_cannot_be() {
    let scale = Scale::round(5.0).unwrap();
    let places = [[0.0, 0.0]; 5];
    let error = expand(&basis(), &scale, &places, &[1.0; 4], None).unwrap_err();
    assert_eq!(error, ExpandError::Lengths { places: 5, values: 4, weights: 5 });
    let weights = [1.0, 0.0, -1.0, 1.0, 1.0];
    let error = expand(&basis(), &scale, &places, &[1.0; 5], Some(&weights)).unwrap_err();
    assert_eq!(error, ExpandError::Weight { index: 2, weight: -1.0 });
    let error = expand(&basis(), &scale, &places, &[1e200; 5], None).unwrap_err();
    assert_eq!(error, ExpandError::Overflow);
}

#[test]
fn one_place_many_times_determines_the_piston_only() {
    let scale = Scale::round(5.0).unwrap();
    let found = expand(&basis(), &scale, &[[1.0, 2.0]; 9], &[4.0; 9], None).unwrap();
    assert_eq!(found.indeterminate, ["Z2", "Z3", "Z4"]);
    assert!((found.coefficients[0].unwrap() - 4.0).abs() < 1e-14);
    assert_eq!(found.condition, 1.0);
}

#[test]
fn weights_of_zero_and_not_numbers() {
    let scale = Scale::round(5.0).unwrap();
    let places: Vec<[f64; 2]> =
        (0..20).map(|i| [f64::from(i % 5) - 2.0, f64::from(i / 5) - 1.5]).collect();
    let mut values: Vec<f64> = places.iter().map(|place| place[0] / 5.0).collect();
    values[3] = 1e6;
    let mut weights = [1.0; 20];
    weights[3] = 0.0;
    let found = expand(&basis(), &scale, &places, &values, Some(&weights)).unwrap();
    assert!((found.coefficients[1].unwrap() - 1.0).abs() < 1e-12);
    assert!(found.residual_rms < 1e-12);
    weights[3] = f64::NAN;
    let found = expand(&basis(), &scale, &places, &values, Some(&weights)).unwrap();
    assert_eq!((found.used, found.not_finite), (19, 1));
    // With every weight 0 nothing is determined, and nothing is made up.
    let found = expand(&basis(), &scale, &places, &values, Some(&[0.0; 20])).unwrap();
    assert_eq!(found.coefficients, [None; 4]);
}

/// As many points as terms: a solution, but nothing to estimate noise from.
#[test]
fn no_degrees_of_freedom() {
    let scale = Scale::round(1.0).unwrap();
    let places = [[0.0, 0.0], [0.5, 0.0], [0.0, 0.5], [-0.9, 0.1]];
    let found = expand(&basis(), &scale, &places, &[1.0, 2.0, 3.0, 4.0], None).unwrap();
    assert!(found.residual_rms < 1e-12 && found.u(0).is_none());
}

#[test]
fn bases_that_cannot_be() {
    let height = Normalisation::UnitHeight;
    assert_eq!(Zernike::of_orders(&[], height), Err(ZernikeError::Empty));
    assert_eq!(Zernike::first(Counting::Noll, 0, height), Err(ZernikeError::Empty));
    let error = Zernike::of_orders(&[(3, 2)], height);
    assert_eq!(error, Err(ZernikeError::NoSuchTerm { n: 3, m: 2 }));
    let error = Zernike::of_orders(&[(3, i32::MIN)], height);
    assert_eq!(error, Err(ZernikeError::NoSuchTerm { n: 3, m: i32::MIN }));
    assert!(matches!(
        Zernike::first(Counting::Ansi, u32::MAX, height),
        Err(ZernikeError::NoSuchTerm { n: 201, m: -201 })
    ));
    let error = Zernike::of_orders(&[(2, 0), (2, 0)], height);
    assert_eq!(error, Err(ZernikeError::Twice { n: 2, m: 0 }));
    assert_eq!(zernike_value(2, 1, height, 0.0, 0.0), None);
    assert_eq!(zernike_value(4_000_000_000, 0, height, 0.0, 0.0), None);
    assert_eq!(Q2d::new(&[], 0.0), Err(Q2dError::Empty));
    assert_eq!(Q2d::new(&[(41, 0)], 0.0), Err(Q2dError::Order { order: 41 }));
    assert_eq!(Q2d::new(&[(1, 1), (1, 1)], 0.0), Err(Q2dError::Twice { n: 1, m: 1 }));
    assert_eq!(Q2d::new(&[(1, 1)], -1.0), Err(Q2dError::Base { bend: -1.0 }));
    assert!(Q2d::new(&[(1, 1)], f64::NAN).is_err());
    assert_eq!(Product::powers(&[]), Err(ProductError::Empty));
    assert_eq!(Product::powers(&[(64, 0)]), Err(ProductError::Order { order: 64 }));
    assert_eq!(Product::legendre(&[(1, 2), (1, 2)]), Err(ProductError::Twice { i: 1, j: 2 }));
}

#[test]
fn scales_that_cannot_be() {
    let error = Scale::round(0.0).unwrap_err();
    assert_eq!(error.to_string(), "normalisation radius is 0 mm, expected a positive number");
    assert!(Scale::round(f64::INFINITY).is_err() && Scale::round(f64::NAN).is_err());
    let error = Scale::rectangle(1.0, -2.0).unwrap_err();
    assert_eq!(error.name, "half width along y");
}
