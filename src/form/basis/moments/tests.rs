//! Moments against the products of the terms.

use super::super::passes::Points;
use super::super::terms::Terms;
use super::super::{Basis, Counting, Normalisation, Q2d, Scale, Zernike};
use super::*;

/// Places of Fibonacci's spiral in a disc of radius `to`, without order: irregular and in one part of it denser.
fn places(count: usize, to: f64) -> Vec<[f64; 2]> {
    let place = |i: usize| {
        let r = to * ((i as f64 + 0.5) / count as f64).powf(0.4);
        let angle = 2.399_963_229_728_653 * i as f64 + 0.3 * (i as f64).sqrt().sin();
        [r * angle.cos(), r * angle.sin()]
    };
    (0..count).map(place).collect()
}

fn bases() -> Vec<Box<dyn Basis>> {
    let orders: Vec<(u32, i32)> = (-3..=3).flat_map(|m| (0..=4).map(move |n| (n, m))).collect();
    // Some azimuthal orders only, and of one of them the sine alone.
    let gaps: Vec<(u32, i32)> = (0..=10)
        .flat_map(|n| [0, 3, -3, 6, -6, -9].map(|m| (n, m)))
        .filter(|&(n, m): &(u32, i32)| {
            m.unsigned_abs() <= n && (n - m.unsigned_abs()).is_multiple_of(2)
        })
        .collect();
    vec![
        Box::new(Zernike::fringe_37(Normalisation::UnitHeight)),
        Box::new(Zernike::first(Counting::Noll, 66, Normalisation::UnitRms).unwrap()),
        Box::new(Q2d::new(&orders, 0.8).unwrap()),
        Box::new(Zernike::of_orders(&gaps, Normalisation::UnitHeight).unwrap()),
    ]
}

#[test]
fn equations_are_those_of_the_products_of_the_terms() {
    let places_mm = places(1000, 1.0);
    let values: Vec<f64> = places_mm.iter().map(|[x, y]| (3.0 * x).exp() - y).collect();
    let weights: Vec<f64> = places_mm.iter().map(|[x, _]| 1.5 + x).collect();
    let scale = Scale::round(1.0).unwrap();
    for basis in bases() {
        for weights in [None, Some(&weights[..])] {
            let basis = &*basis;
            let points =
                Points { basis, scale: &scale, places_mm: &places_mm, values: &values, weights };
            let terms = Terms { basis, weighted: weights.is_some() };
            let moments = Moments::new(basis.on_disc().unwrap()).unwrap();
            let direct = terms.equations(&points.sums(&terms).sums);
            let swift = moments.equations(&points.sums(&moments).sums);
            let off = (&swift.gram - &direct.gram).amax() / direct.gram.amax();
            assert!(off < 2e-13, "{}: {off:e}", basis.kind());
            let largest = direct.along.iter().fold(0.0, |most: f64, a| most.max(a.abs()));
            for (swift, direct) in swift.along.iter().zip(&direct.along) {
                assert!((swift - direct).abs() < 2e-13 * largest, "{}", basis.kind());
            }
            assert!((swift.square / direct.square - 1.0).abs() < 1e-14);
            // Far from the solution, so that the residuals are no rounding.
            let coefficients: Vec<f64> =
                (0..basis.terms()).map(|term| (term as f64).cos()).collect();
            let direct = points.rest(&terms, &coefficients);
            let swift = points.rest(&moments, &coefficients);
            assert_eq!(swift.largest.index, direct.largest.index);
            assert!((swift.square / direct.square - 1.0).abs() < 1e-13);
            assert_eq!(swift.weight, direct.weight);
            let (swift, direct) = (moments.along(&swift.sums), terms.along(&direct.sums));
            let largest = direct.iter().fold(0.0, |most: f64, a| most.max(a.abs()));
            for (swift, direct) in swift.iter().zip(&direct) {
                assert!((swift - direct).abs() < 2e-13 * largest, "{}", basis.kind());
            }
        }
    }
}

#[test]
fn a_small_part_of_the_disc_is_left_to_the_terms() {
    let basis = Zernike::fringe_37(Normalisation::UnitHeight);
    let scale = Scale::round(1.0).unwrap();
    let moments = Moments::new(basis.on_disc().unwrap()).unwrap();
    for (to, sure) in [(1.0, true), (0.95, true), (0.3, false), (0.01, false)] {
        let places_mm = places(2000, to);
        let values = vec![1.0; 2000];
        let (basis, scale, places_mm, values) = (&basis, &scale, &places_mm[..], &values[..]);
        let points = Points { basis, scale, places_mm, values, weights: None };
        let sums = points.sums(&moments).sums;
        let equations = moments.equations(&sums);
        let normal = Normal::new(&equations.gram);
        assert_eq!(moments.is_sure(&sums, &equations, &normal), sure, "{to}");
    }
}

#[test]
fn few_terms_and_those_of_high_order_have_none() {
    let none = |orders: &[(u32, i32)]| {
        let basis = Zernike::of_orders(orders, Normalisation::UnitHeight).unwrap();
        Moments::new(basis.on_disc().unwrap()).is_none()
    };
    assert!(none(&[(40, 40)]) && none(&[(3, 1), (8, -6)]));
    let all = Zernike::first(Counting::Ansi, 496, Normalisation::UnitHeight).unwrap();
    assert!(Moments::new(all.on_disc().unwrap()).is_none());
}
