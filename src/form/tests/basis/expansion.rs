//! Expansions of scattered values.

use asphera_form::basis::{
    Basis, Counting, Expansion, Normalisation, Product, Q2d, Scale, Zernike, expand, residuals,
};
use asphera_form::shape::{Series, Shape as _};
use nalgebra::{DMatrix, DVector};
use rand_core::{Rng as _, SeedableRng as _};
use rand_pcg::Pcg64Mcg;

const RADIUS_MM: f64 = 12.5;

struct Uniform(Pcg64Mcg);

impl Uniform {
    fn new() -> Uniform {
        Uniform(Pcg64Mcg::seed_from_u64(1976))
    }

    fn next(&mut self) -> f64 {
        (self.0.next_u64() >> 11) as f64 / (1_u64 << 53) as f64
    }
}

/// Uniform over the disc, or the part of it from x = `from` (as a share of the radius).
fn places(count: usize, from: f64) -> Vec<[f64; 2]> {
    let mut uniform = Uniform::new();
    let mut places = Vec::new();
    while places.len() < count {
        let (x, y) = (2.0 * uniform.next() - 1.0, 2.0 * uniform.next() - 1.0);
        if x >= from && x * x + y * y <= 1.0 {
            places.push([RADIUS_MM * x, RADIUS_MM * y]);
        }
    }
    places
}

fn coefficients(count: usize) -> Vec<f64> {
    (1..=count).map(|k| 100.0 * (k as f64 * 2.4).sin() / k as f64).collect()
}

fn matrix(basis: &dyn Basis, scale: &Scale, places: &[[f64; 2]]) -> DMatrix<f64> {
    let mut matrix = DMatrix::zeros(places.len(), basis.terms());
    for (row, &[x, y]) in places.iter().enumerate() {
        let [u, v] = scale.normalised(x, y);
        basis.each_value(u, v, &mut |term, value| matrix[(row, term)] = value);
    }
    matrix
}

fn values(basis: &dyn Basis, scale: &Scale, places: &[[f64; 2]], truth: &[f64]) -> Vec<f64> {
    let values = matrix(basis, scale, places) * DVector::from_column_slice(truth);
    values.iter().copied().collect()
}

fn largest_error(expansion: &Expansion, truth: &[f64]) -> f64 {
    let pairs = expansion.coefficients.iter().zip(truth);
    pairs.map(|(found, truth)| (found.unwrap() - truth).abs()).fold(0.0, f64::max)
}

#[test]
fn known_coefficients_come_back() {
    let round = Scale::round(RADIUS_MM).unwrap();
    let rectangle = Scale::rectangle(RADIUS_MM, 1.2 * RADIUS_MM).unwrap();
    let orders: Vec<(u32, i32)> = (-3..=3).flat_map(|m| (0..=4).map(move |n| (n, m))).collect();
    let cases: [(&dyn Basis, Scale, f64); 6] = [
        (&Zernike::fringe_37(Normalisation::UnitHeight), round, 1e-12),
        (&Zernike::first(Counting::Noll, 105, Normalisation::UnitRms).unwrap(), round, 1e-12),
        (&Q2d::new(&orders, 0.3).unwrap(), round, 1e-12),
        (&Product::chebyshev(&Product::tensor_orders(5, 5)).unwrap(), rectangle, 1e-12),
        (&Product::legendre(&Product::tensor_orders(5, 5)).unwrap(), rectangle, 1e-12),
        // Powers are nearly dependent: the condition says how many digits go.
        (&Product::powers(&Product::degree_orders(0, 6)).unwrap(), round, 1e-12),
    ];
    for (basis, scale, tolerance) in cases {
        let places = places(9000, -1.0);
        let truth = coefficients(basis.terms());
        let found =
            expand(basis, &scale, &places, &values(basis, &scale, &places, &truth), None).unwrap();
        let error = largest_error(&found, &truth) / 100.0;
        println!("{}: {error:e}, condition {}", basis.kind(), found.condition);
        assert!(error < tolerance, "{}: {error:e}", basis.kind());
        assert_eq!((found.used, found.outside, found.not_finite), (9000, 0, 0));
        assert!(found.residual_rms < 1e-12 && found.indeterminate.is_empty());
    }
}

/// Against a singular value decomposition of the whole matrix: condition, coefficients, uncertainties.
#[test]
fn part_of_the_disc_with_noise_against_a_dense_solution() {
    let basis = Zernike::first(Counting::Fringe, 25, Normalisation::UnitHeight).unwrap();
    let scale = Scale::round(RADIUS_MM).unwrap();
    for from in [-1.0, 0.0, 0.3] {
        let places = places(2500, from);
        let mut uniform = Uniform::new();
        let mut values = values(&basis, &scale, &places, &coefficients(25));
        values.iter_mut().for_each(|value| *value += uniform.next() - 0.5);
        let weights: Vec<f64> = places.iter().map(|place| 1.0 + place[0] / RADIUS_MM).collect();
        for weights in [None, Some(&weights[..])] {
            let found = expand(&basis, &scale, &places, &values, weights).unwrap();
            let root = |row: usize| weights.map_or(1.0, |weights| weights[row].sqrt());
            let mut matrix = matrix(&basis, &scale, &places);
            for (row, mut entries) in matrix.row_iter_mut().enumerate() {
                entries *= root(row);
            }
            let mut norms = Vec::new();
            for mut column in matrix.column_iter_mut() {
                norms.push(column.norm());
                column /= norms[norms.len() - 1];
            }
            let rhs = DVector::from_fn(values.len(), |row, _| values[row] * root(row));
            let qr = matrix.clone().qr();
            let r = qr.r();
            let solution = r.solve_upper_triangular(&qr.q().tr_mul(&rhs)).unwrap();
            let rest = (&rhs - &matrix * &solution).norm_squared();
            let total: f64 = (0..values.len()).map(|row| root(row) * root(row)).sum();
            assert!((found.residual_rms / (rest / total).sqrt() - 1.0).abs() < 1e-12);
            let singular = matrix.singular_values();
            let condition = singular.max() / singular.min();
            println!("from {from}: condition {condition}");
            assert!((found.condition / condition - 1.0).abs() < 1e-6, "{}", found.condition);
            let inverse = r.try_inverse().unwrap();
            let variance = rest / (values.len() - 25) as f64;
            for (term, norm) in norms.iter().enumerate() {
                let u = (inverse.row(term).norm_squared() * variance).sqrt() / norm;
                assert!((found.u(term).unwrap() / u - 1.0).abs() < 1e-8);
                let off = found.coefficients[term].unwrap() - solution[term] / norm;
                assert!(off.abs() < 1e-9 * u, "{term}: {off:e} of {u:e}");
            }
            let covariance = inverse.row(3).dot(&inverse.row(7)) * variance / norms[3] / norms[7];
            let size = found.u(3).unwrap() * found.u(7).unwrap();
            assert!((found.covariance(3, 7).unwrap() - covariance).abs() < 1e-8 * size);
        }
    }
}

#[test]
fn terms_the_places_do_not_determine_are_named() {
    let basis = Product::powers(&Product::degree_orders(0, 2)).unwrap();
    let scale = Scale::round(1.0).unwrap();
    // On the line y = 2x + 1 the powers of y follow from those of x.
    let places: Vec<[f64; 2]> =
        (0..50).map(|i| f64::from(i) / 50.0).map(|x| [x, 2.0 * x + 1.0]).collect();
    let values: Vec<f64> = places.iter().map(|place| 3.0 * place[0] * place[0] - 1.0).collect();
    let found = expand(&basis, &scale, &places, &values, None).unwrap();
    assert_eq!(found.indeterminate, ["X0Y1", "X1Y1", "X0Y2"]);
    let expected = [Some(-1.0), Some(0.0), None, Some(3.0), None, None];
    for (found, expected) in found.coefficients.iter().zip(expected) {
        assert_eq!(found.is_some(), expected.is_some());
        assert!((found.unwrap_or(0.0) - expected.unwrap_or(0.0)).abs() < 1e-12);
    }
    assert_eq!((found.covariance(0, 2), found.u(5)), (None, None));
    assert_eq!(found.filled().len(), 6);
}

#[test]
fn threads_do_not_change_a_bit() {
    let basis = Zernike::fringe_37(Normalisation::UnitRms);
    let scale = Scale::round(RADIUS_MM).unwrap();
    let places = places(30_000, -0.4);
    let mut uniform = Uniform::new();
    let values: Vec<f64> = places.iter().map(|_| uniform.next()).collect();
    let on = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| expand(&basis, &scale, &places, &values, None).unwrap())
    };
    let one = on(1);
    assert_eq!(one, on(2));
    assert_eq!(one, on(5));
}

#[test]
fn residuals_are_what_a_series_leaves() {
    let basis = Zernike::fringe_37(Normalisation::UnitHeight);
    let scale = Scale::round(RADIUS_MM).unwrap();
    let mut places = places(5000, -1.0);
    places[17] = [RADIUS_MM, RADIUS_MM];
    places[18][0] = f64::NAN;
    let truth = coefficients(37);
    let series = Series::new(basis.clone(), scale, &truth).unwrap();
    let values: Vec<f64> = (0..5000).map(|i| f64::from(i % 7)).collect();
    let all = residuals(&basis, &scale, &truth, &places, &values);
    for (index, (residual, place)) in all.iter().zip(&places).enumerate() {
        match series.sag_mm(place[0], place[1]) {
            Some(sag) => assert!((residual + sag - values[index]).abs() < 1e-12, "{index}"),
            None => assert!(residual.is_nan() && (17..19).contains(&index)),
        }
    }
    let mut outlier = vec![0.0; 5000];
    outlier[4321] = -7.0;
    let found = expand(&basis, &scale, &places, &outlier, None).unwrap();
    assert_eq!((found.used, found.outside, found.not_finite), (4998, 1, 1));
    assert_eq!(found.largest_residual.index, 4321);
    let all = residuals(&basis, &scale, &found.filled(), &places, &outlier);
    assert!((found.largest_residual.residual - all[4321]).abs() < 1e-12);
    let square: f64 = all.iter().filter(|residual| !residual.is_nan()).map(|r| r * r).sum();
    assert!((found.residual_rms / (square / 4998.0).sqrt() - 1.0).abs() < 1e-12);
}
