//! Orthogonality by quadrature.

use std::f64::consts::{PI, TAU};

use asphera_form::basis::{Basis, Counting, Normalisation, Product, Q2d, Zernike};

/// Nodes and weights of the Gauss rule on (0, 1), by Newton's method on Legendre's polynomial.
fn gauss(count: usize) -> Vec<(f64, f64)> {
    let n = count as f64;
    let node = |i: usize| {
        let mut x = (PI * (i as f64 + 0.75) / (n + 0.5)).cos();
        let mut slope = 1.0;
        for _ in 0..20 {
            let (mut now, mut before) = (1.0, 0.0);
            for k in 0..count {
                let k = k as f64;
                (now, before) = (((2.0 * k + 1.0) * x * now - k * before) / (k + 1.0), now);
            }
            slope = n * (x * now - before) / (x * x - 1.0);
            x -= now / slope;
        }
        (0.5 * (1.0 + x), 1.0 / ((1.0 - x * x) * slope * slope))
    };
    (0..count).map(node).collect()
}

fn values(basis: &dyn Basis, u: f64, v: f64) -> Vec<f64> {
    let mut values = vec![f64::NAN; basis.terms()];
    basis.each_value(u, v, &mut |term, value| values[term] = value);
    values
}

/// Adds weight · w·wᵀ.
fn accumulate(gram: &mut [f64], w: &[f64], weight: f64) {
    for (i, a) in w.iter().enumerate() {
        for (j, b) in w.iter().enumerate() {
            gram[i * w.len() + j] += weight * a * b;
        }
    }
}

fn is_identity(gram: &[f64], size: usize, tolerance: f64) {
    for (index, entry) in gram.iter().enumerate() {
        let expected = f64::from(index / size == index % size);
        assert!((entry - expected).abs() < tolerance, "{index}: {entry}");
    }
}

#[test]
fn unit_rms_zernike_terms_are_orthonormal_over_the_disc() {
    let basis = Zernike::first(Counting::Noll, 231, Normalisation::UnitRms).unwrap();
    assert_eq!(basis.orders()[230].0, 20);
    let size = basis.terms();
    let mut gram = vec![0.0; size * size];
    for (s, weight) in gauss(22) {
        for k in 0..44 {
            let (sin, cos) = (TAU * f64::from(k) / 44.0).sin_cos();
            let row = values(&basis, s.sqrt() * cos, s.sqrt() * sin);
            accumulate(&mut gram, &row, weight / 44.0);
        }
    }
    is_identity(&gram, size, 1e-11);
}

#[test]
fn unit_height_terms_reach_one_at_the_rim() {
    let basis = Zernike::first(Counting::Fringe, 100, Normalisation::UnitHeight).unwrap();
    for (term, &(_, m)) in basis.orders().iter().enumerate() {
        let phi = if m >= 0 { 0.0 } else { PI / 2.0 / f64::from(-m) };
        let value = values(&basis, phi.cos(), phi.sin())[term];
        assert!((value - 1.0).abs() < 1e-12, "term {term}: {value}");
    }
}

#[test]
fn legendre_terms_have_their_mean_squares() {
    let basis = Product::legendre(&Product::tensor_orders(9, 6)).unwrap();
    let size = basis.terms();
    let norms = basis.orders().iter().map(|&(i, j)| f64::from((2 * i + 1) * (2 * j + 1)).sqrt());
    let norms: Vec<f64> = norms.collect();
    let mut gram = vec![0.0; size * size];
    for (x, along) in gauss(12) {
        for (y, across) in gauss(12) {
            let mut row = values(&basis, 2.0 * x - 1.0, 2.0 * y - 1.0);
            row.iter_mut().zip(&norms).for_each(|(value, norm)| *value *= norm);
            accumulate(&mut gram, &row, along * across);
        }
    }
    is_identity(&gram, size, 1e-12);
}

/// The property 2-D-Q polynomials are made for (Forbes 2012, section 2): with weight 1/√(1 − ρ²) in ρ, the mean
/// square gradient of a sum is the sum of the squares of its coefficients. The Gauss-Chebyshev rule is exact.
#[test]
fn q2d_gradients_are_orthonormal() {
    let orders: Vec<(u32, i32)> = (-6..=6)
        .flat_map(|m| (0..=12).map(move |n| (n, m)))
        .chain([(3, 20), (30, 9), (40, 0)])
        .collect();
    let basis = Q2d::new(&orders, 0.0).unwrap();
    let size = basis.terms();
    let (radii, angles) = (100, 48);
    let mut gram = vec![0.0; size * size];
    for i in 0..radii {
        let rho = (PI * (f64::from(i) + 0.5) / f64::from(2 * radii)).cos();
        for k in 0..angles {
            let (sin, cos) = (TAU * (f64::from(k) + 0.3) / f64::from(angles)).sin_cos();
            let mut slopes = [vec![f64::NAN; size], vec![f64::NAN; size]];
            basis.each_jet(rho * cos, rho * sin, &mut |term, jet| {
                slopes[0][term] = jet.gradient[0];
                slopes[1][term] = jet.gradient[1];
            });
            let weight = 1.0 / f64::from(radii * angles);
            slopes.iter().for_each(|row| accumulate(&mut gram, row, weight));
        }
    }
    is_identity(&gram, size, 1e-9);
}
