//! The engine on problems whose minimax is known in closed form, and laws of the linear problem.

use std::ops::Range;

use proptest::prelude::*;

use super::directions::Directions;
use super::exchange::Rows;
use super::residuals::Residuals;
use super::search::{End, Found, Limits, search};
use crate::fit::freedoms::Freedoms;

/// y(x) less a polynomial with free coefficients.
struct Polynomial {
    x: Vec<f64>,
    y: Vec<f64>,
    coefficients: usize,
}

impl Residuals for Polynomial {
    type Place = Vec<f64>;

    fn len(&self) -> usize {
        self.x.len()
    }

    fn parameters(&self) -> usize {
        self.coefficients
    }

    fn moved(&self, from: &Vec<f64>, step: &[f64]) -> Option<Vec<f64>> {
        Some(from.iter().zip(step).map(|(value, change)| value + change).collect())
    }

    fn distances(&self, at: &Vec<f64>, range: Range<usize>, out: &mut Vec<f64>) {
        let polynomial = |x: f64| at.iter().rev().fold(0.0, |sum, c| sum * x + c);
        out.extend(range.map(|index| self.y[index] - polynomial(self.x[index])));
    }

    fn rows(
        &self,
        at: &Vec<f64>,
        indices: impl Iterator<Item = usize>,
        out: &mut Vec<f64>,
    ) -> Option<()> {
        for index in indices {
            out.extend((0..self.coefficients).map(|k| -self.x[index].powi(k as i32)));
            self.distances(at, index..index + 1, out);
        }
        Some(())
    }
}

/// The best polynomial with so many coefficients for y over a grid that holds the wanted places.
fn approximate(
    y: impl Fn(f64) -> f64,
    coefficients: usize,
    wanted: &[f64],
    grid: usize,
    offset: bool,
) -> Found<Vec<f64>> {
    let regular = (0..grid).map(|i| 2.0 * i as f64 / (grid - 1) as f64 - 1.0);
    let x: Vec<f64> = regular.chain(wanted.iter().copied()).collect();
    let problem = Polynomial { y: x.iter().map(|&x| y(x)).collect(), x, coefficients };
    let start = vec![0.0; coefficients];
    let order: Vec<Vec<usize>> = (0..coefficients).map(|index| vec![index]).collect();
    let directions =
        Directions::new(&problem, &start, (&Freedoms::each(coefficients), &order), offset, 1e-10)
            .unwrap();
    let limits = Limits { tolerance: 1e-12, rounding_mm: 1e-15, scans: 50, by_range: offset };
    search(&problem, &directions, start, limits).unwrap()
}

/// Chebyshev: no polynomial of lower degree comes nearer to xⁿ over [−1, 1] than 2^(1−n), and where it is
/// that near the differences at cos(jπ/n) alternate.
#[test]
fn powers_are_approximated_as_chebyshev_says() {
    for n in 1..=9_usize {
        let wanted: Vec<f64> =
            (0..=n).map(|j| (std::f64::consts::PI * j as f64 / n as f64).cos()).collect();
        for grid in [200, 20_000] {
            let found = approximate(|x| x.powi(n as i32), n, &wanted, grid, false);
            let expected = 2.0_f64.powi(1 - n as i32);
            assert_eq!(found.end, End::Settled);
            let width = found.span.half_mm(false);
            assert!((width / expected - 1.0).abs() < 1e-12, "n {n}: {width:e} {expected:e}");
            assert!(found.lower_mm <= width * (1.0 + 1e-12) && found.pull < 1e-9);
            let all: f64 = found.contacts.iter().map(|contact| contact.multiplier).sum();
            assert!((all - 1.0).abs() < 1e-12);
        }
    }
}

/// de la Vallée-Poussin: for |x| the best quadratic over [−1, 1] is x² + 1/8, off by 1/8.
#[test]
fn the_modulus_is_approximated_by_a_parabola() {
    let found = approximate(f64::abs, 3, &[0.5, -0.5, 0.0], 4001, false);
    assert!((found.span.half_mm(false) - 0.125).abs() < 1e-14);
    for (coefficient, expected) in found.place.iter().zip([0.125, 0.0, 1.0]) {
        assert!((coefficient - expected).abs() < 1e-12, "{:?}", found.place);
    }
}

/// Best line for eˣ over [−1, 1]: parallel to the chord, slope sinh 1, and half way to the tangent at
/// x = ln sinh 1.
#[test]
fn the_exponential_is_approximated_by_a_line() {
    let slope = 1.0_f64.sinh();
    let touching = slope.ln();
    let half = 0.5 * (1.0_f64.exp() - slope - (slope - slope * touching));
    for (coefficients, offset) in [(2, false), (2, true)] {
        let found = approximate(f64::exp, coefficients, &[touching], 3001, offset);
        assert!((found.span.half_mm(offset) / half - 1.0).abs() < 1e-12);
        assert!((found.place[1] - slope).abs() < 1e-12);
        // The constant makes up for an offset, which therefore stays 0.
        assert!(found.span.centre_mm(true).abs() < 1e-14);
    }
}

#[test]
fn without_parameters_the_offset_floats_alone() {
    let x: Vec<f64> = (0..=100).map(|i| f64::from(i) / 50.0 - 1.0).collect();
    let problem = Polynomial { y: x.iter().map(|x| x * x + 7.0).collect(), x, coefficients: 0 };
    let directions =
        Directions::new(&problem, &Vec::new(), (&Freedoms::each(0), &[]), true, 1e-10).unwrap();
    assert!(directions.floating && directions.count() == 1);
    let limits = Limits { tolerance: 1e-12, rounding_mm: 1e-15, scans: 9, by_range: true };
    let found = search(&problem, &directions, Vec::new(), limits).unwrap();
    assert_eq!((found.span.high_mm, found.span.low_mm), (8.0, 7.0));
    assert!((found.lower_mm - 0.5).abs() < 1e-13);
    assert_eq!(found.end, End::Settled);
}

/// One high point over a bent valley (Rosenbrock, Comput. J. 3 (1960) 175) and two low ones that only say what
/// the parameters are: at the answer one point holds two parameters.
struct Valley;

impl Residuals for Valley {
    type Place = [f64; 2];

    fn len(&self) -> usize {
        3
    }

    fn parameters(&self) -> usize {
        2
    }

    fn moved(&self, from: &[f64; 2], step: &[f64]) -> Option<[f64; 2]> {
        Some([from[0] + step[0], from[1] + step[1]])
    }

    fn distances(&self, &[x, y]: &[f64; 2], range: Range<usize>, out: &mut Vec<f64>) {
        let valley = 1.0 + 0.01 * ((1.0 - x) * (1.0 - x) + 10.0 * (y - x * x) * (y - x * x));
        out.extend_from_slice(&[valley, 0.1 * x, 0.1 * y][range]);
    }

    fn rows(
        &self,
        at: &[f64; 2],
        indices: impl Iterator<Item = usize>,
        out: &mut Vec<f64>,
    ) -> Option<()> {
        let [x, y] = *at;
        for index in indices {
            let slopes = match index {
                0 => [0.01 * (2.0 * (x - 1.0) - 40.0 * x * (y - x * x)), 0.2 * (y - x * x)],
                1 => [0.1, 0.0],
                _ => [0.0, 0.1],
            };
            out.extend_from_slice(&slopes);
            self.distances(at, index..index + 1, out);
        }
        Some(())
    }
}

#[test]
fn the_bottom_of_a_bent_valley_is_found() {
    let start = [-1.2, 1.0];
    let within = (&Freedoms::each(2), &[vec![0], vec![1]][..]);
    let directions = Directions::new(&Valley, &start, within, false, 1e-10).unwrap();
    let limits = Limits { tolerance: 1e-8, rounding_mm: 1e-15, scans: 9, by_range: false };
    let found = search(&Valley, &directions, start, limits).unwrap();
    assert_eq!(found.end, End::Settled, "{found:?}");
    assert!((found.span.high_mm - 1.0).abs() < 1e-12, "{found:?}");
    // The bottom is flat: its place is known to the root of rounding only, and so is the bound.
    assert!((found.place[0] - 1.0).abs() < 1e-6 && (found.place[1] - 1.0).abs() < 1e-6);
    let largest = found.contacts.iter().map(|contact| contact.multiplier).fold(0.0, f64::max);
    assert!(largest > 1.0 - 1e-6, "{found:?}");
}

/// Strong duality proves the answer: it is in the box, and multipliers give a bound of equal value.
fn check(rows: &Rows, reach: f64) -> Result<(), TestCaseError> {
    let optimum = rows.minimax(reach);
    let size = rows.entries.iter().fold(1.0_f64, |size, entry| size.max(entry.abs()));
    let eps = 1e-9 * size;
    prop_assert!(optimum.y.iter().all(|y| y.abs() <= reach));
    let all: f64 = optimum.held.iter().map(|held| held.multiplier).sum();
    prop_assert!((all - 1.0).abs() < 1e-9, "{optimum:?}");
    let width = rows.columns + 1;
    // Σ λ·s·(b + J·y) over the rows held, less what the box could still gain, bounds every y in the box.
    let mut sum = 0.0;
    let mut pull = vec![0.0; rows.columns];
    for held in &optimum.held {
        let row = &rows.entries[held.row * width..][..width];
        let side = if held.high { held.multiplier } else { -held.multiplier };
        sum += side * row[rows.columns];
        pull.iter_mut().zip(row).for_each(|(pull, slope)| *pull += side * slope);
    }
    let lower = sum - reach * pull.iter().map(|pull| pull.abs()).sum::<f64>();
    prop_assert!((lower - optimum.reached).abs() <= eps, "{lower} {optimum:?}");
    Ok(())
}

proptest! {
    #[test]
    fn linear_minimax_is_proved_by_its_multipliers(
        entries in prop::collection::vec(-1.0..1.0f64, 4..240), columns in 0..6usize,
    ) {
        let whole = entries.len() / (columns + 1) * (columns + 1);
        prop_assume!(whole > 0);
        check(&Rows { columns, entries: entries[..whole].to_vec() }, 4.0)?;
    }

    /// Ties, repeated and dependent rows everywhere.
    #[test]
    fn small_whole_numbers_do_not_cycle(
        entries in prop::collection::vec(-2..3i32, 4..240), columns in 0..6usize,
    ) {
        let whole = entries.len() / (columns + 1) * (columns + 1);
        prop_assume!(whole > 0);
        let entries = entries[..whole].iter().copied().map(f64::from).collect();
        check(&Rows { columns, entries }, 4.0)?;
    }
}
