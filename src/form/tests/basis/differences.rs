//! Derivatives of series against differences, and what a series says of itself.

use std::sync::Arc;

use asphera_form::basis::{Basis, Counting, LANES, Normalisation, Product, Q2d, Scale, Zernike};
use asphera_form::shape::{Series, Shape, ShapeError};
use proptest::prelude::*;

/// Derivative of `f` at 0 by Richardson's extrapolation of central differences.
fn slope(f: impl Fn(f64) -> f64, step: f64) -> f64 {
    let mut table: Vec<f64> = (0..5)
        .map(|k| {
            let h = step / f64::from(1 << k);
            (f(h) - f(-h)) / (2.0 * h)
        })
        .collect();
    for order in 1..5_u32 {
        let factor = f64::from(4_u32.pow(order));
        for k in (order as usize..5).rev() {
            table[k] = (factor * table[k] - table[k - 1]) / (factor - 1.0);
        }
    }
    table[4]
}

/// Gradient, Hessian and derivatives by parameters at a place; `size` is how large they may be.
pub(crate) fn check(shape: &dyn Shape, x: f64, y: f64, size: f64) {
    let step = 0.02;
    let jet = shape.jet(x, y).unwrap();
    assert!((jet.z_mm - shape.sag_mm(x, y).unwrap()).abs() <= 1e-14 * size);
    let sag = |x, y| shape.sag_mm(x, y).unwrap();
    let gradient = |x, y| shape.jet(x, y).unwrap().gradient;
    let close = |found: f64, expected: f64, what: &str| {
        assert!((found - expected).abs() <= 1e-9 * size, "{what} at {x}, {y}: {found} {expected}");
    };
    close(jet.gradient[0], slope(|h| sag(x + h, y), step), "∂z/∂x");
    close(jet.gradient[1], slope(|h| sag(x, y + h), step), "∂z/∂y");
    close(jet.hessian_per_mm[0], slope(|h| gradient(x + h, y)[0], step), "∂²z/∂x²");
    close(jet.hessian_per_mm[1], slope(|h| gradient(x, y + h)[0], step), "∂²z/∂x∂y");
    close(jet.hessian_per_mm[1], slope(|h| gradient(x + h, y)[1], step), "∂²z/∂y∂x");
    close(jet.hessian_per_mm[2], slope(|h| gradient(x, y + h)[1], step), "∂²z/∂y²");
    let parameters: Vec<f64> = shape.parameters().iter().map(|one| one.value).collect();
    let mut derivatives = vec![f64::NAN; parameters.len()];
    shape.by_parameters(x, y, &mut derivatives).unwrap();
    for (k, derivative) in derivatives.iter().enumerate() {
        let moved = |h: f64| {
            let mut values = parameters.clone();
            values[k] += h;
            shape.with_parameters(&values).unwrap().sag_mm(x, y).unwrap()
        };
        // The sag is linear in the coefficients.
        close(*derivative, 0.5 * (moved(1.0) - moved(-1.0)), &shape.parameters()[k].name);
    }
}

fn coefficients(count: usize, seed: u64) -> Vec<f64> {
    (1..=count).map(|k| (k as f64 * 0.7 + seed as f64).sin() / k as f64).collect()
}

fn shapes(seed: u64) -> Vec<Arc<dyn Shape>> {
    let round = Scale::round(5.0).unwrap();
    let rectangle = Scale::rectangle(5.0, 8.0).unwrap();
    let zernike = Zernike::first(Counting::Noll, 45, Normalisation::UnitRms).unwrap();
    let orders: Vec<(u32, i32)> = (-3..=4).flat_map(|m| (0..=4).map(move |n| (n, m))).collect();
    let flat = Q2d::new(&orders, 0.0).unwrap();
    let bent = Q2d::new(&orders, -0.7).unwrap();
    let tensor = Product::tensor_orders(4, 5);
    let chebyshev = Product::chebyshev(&tensor).unwrap();
    let legendre = Product::legendre(&tensor).unwrap();
    let powers = Product::powers(&Product::degree_orders(1, 6)).unwrap();
    fn series<B: Basis + 'static>(basis: B, scale: Scale, seed: u64) -> Arc<dyn Shape> {
        let values = coefficients(basis.terms(), seed);
        Arc::new(Series::new(basis, scale, &values).unwrap())
    }
    vec![
        series(zernike.clone(), round, seed),
        series(zernike, rectangle, seed),
        series(flat, round, seed),
        series(bent, round, seed),
        series(chebyshev, rectangle, seed),
        series(legendre, rectangle, seed),
        series(powers, rectangle, seed),
    ]
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(40))]
    #[test]
    fn derivatives_are_those_of_the_sag(
        seed in 0..1000_u64, radius in 0.0..0.9_f64, angle in 0.0..6.3_f64,
    ) {
        let (sin, cos) = angle.sin_cos();
        for shape in shapes(seed) {
            check(&*shape, 4.8 * radius * cos, 4.8 * radius * sin, 100.0);
        }
    }
}

#[test]
fn derivatives_at_the_centre_and_beside_it() {
    for shape in shapes(3) {
        check(&*shape, 0.0, 0.0, 100.0);
        check(&*shape, 1e-160, -1e-170, 100.0);
    }
}

#[test]
fn blocks_have_the_values_of_single_places() {
    let orders: Vec<(u32, i32)> = (-3..=4).flat_map(|m| (0..=5).map(move |n| (n, m))).collect();
    let bases: [&dyn Basis; 4] = [
        &Zernike::first(Counting::Fringe, 60, Normalisation::UnitRms).unwrap(),
        &Q2d::new(&orders, 0.6).unwrap(),
        &Product::chebyshev(&[(0, 9), (3, 3), (5, 0)]).unwrap(),
        &Product::powers(&Product::degree_orders(0, 5)).unwrap(),
    ];
    let u: [f64; LANES] = std::array::from_fn(|i| 0.7 * (i as f64).cos());
    let v: [f64; LANES] = std::array::from_fn(|i| 0.7 * (1.3 * i as f64).sin());
    for basis in bases {
        let mut rows = vec![[f64::NAN; LANES]; basis.terms()];
        basis.block(&u, &v, &mut rows);
        for i in 0..LANES {
            let mut seen = 0;
            basis.each_value(u[i], v[i], &mut |term, value| {
                seen += 1;
                assert!((rows[term][i] - value).abs() <= 1e-15 * (1.0 + value.abs()));
            });
            basis.each_jet(u[i], v[i], &mut |term, jet| {
                assert!((rows[term][i] - jet.value).abs() <= 2e-14 * (1.0 + jet.value.abs()));
            });
            assert_eq!(seen, basis.terms());
        }
    }
}

#[test]
fn a_series_ends_where_its_basis_does() {
    let all = shapes(1);
    assert_eq!(
        all.iter().map(|shape| shape.domain_mm()).collect::<Vec<_>>(),
        [5.0, 5.0, 5.0, 5.0, 5.0, 5.0, f64::INFINITY]
    );
    assert!(all[0].jet(3.0, 4.0).is_some() && all[0].jet(3.1, 4.0).is_none());
    assert!(all[1].jet(0.0, 7.9).is_some());
    assert!(all[4].jet(-5.0, 8.0).is_some() && all[4].sag_mm(0.0, 8.1).is_none());
    assert!(all[6].jet(50.0, 0.0).is_some());
    for shape in all {
        assert!(shape.jet(f64::NAN, 0.0).is_none() && shape.sag_mm(0.0, f64::NAN).is_none());
        assert!(shape.jet(f64::INFINITY, 0.0).is_none());
        let mut derivatives = vec![0.0; shape.parameters().len()];
        assert!(shape.by_parameters(0.0, f64::INFINITY, &mut derivatives).is_none());
    }
}

#[test]
fn coefficients_are_checked() {
    let basis = Zernike::fringe_37(Normalisation::UnitHeight);
    let scale = Scale::round(5.0).unwrap();
    let error = Series::new(basis.clone(), scale, &[0.0; 36]).unwrap_err();
    assert_eq!(error.to_string(), "36 values for the 37 parameters of the Fringe Zernike series");
    let mut values = [0.0; 37];
    values[8] = f64::NAN;
    let error = Series::new(basis, scale, &values).unwrap_err();
    assert!(matches!(&error, ShapeError::Value { parameter, .. } if parameter == "Z9"));
}
