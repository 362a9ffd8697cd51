//! Surfaces of numbers: sag grids, splines, and splines fitted to points.

use asphera_form::shape::{
    Cells, Jet, Nodes, SagGrid, SagGridError, Shape, SplineError, SplineSurface,
};
use asphera_form::{PointMm, Smoothing, SplineFitError, fit_spline};
use proptest::prelude::*;
use rand_core::SeedableRng as _;
use rand_pcg::Pcg64Mcg;

use crate::differences::check;

const NODES: Nodes =
    Nodes { x_min_mm: -3.0, y_min_mm: -2.0, step_x_mm: 0.5, step_y_mm: 0.4, nx: 13, ny: 11 };

fn grid(nodes: Nodes, sag: impl Fn(f64, f64) -> f64) -> SagGrid {
    let x = |i: usize| nodes.x_min_mm + i as f64 * nodes.step_x_mm;
    let y = |j: usize| nodes.y_min_mm + j as f64 * nodes.step_y_mm;
    let rows = (0..nodes.ny).flat_map(|j| (0..nodes.nx).map(move |i| (i, j)));
    let sags: Vec<f64> = rows.map(|(i, j)| sag(x(i), y(j))).collect();
    SagGrid::new(nodes, &sags).unwrap()
}

fn quartic(x: f64, y: f64) -> f64 {
    1.0 + x - 2.0 * y + 0.3 * x * y - 0.2 * x.powi(3) * y.powi(2) + 0.01 * x.powi(4) * y.powi(4)
}

fn jet_of_quartic(x: f64, y: f64) -> Jet {
    let (x2, x3, x4) = (x * x, x.powi(3), x.powi(4));
    let (y2, y3, y4) = (y * y, y.powi(3), y.powi(4));
    Jet {
        z_mm: quartic(x, y),
        gradient: [
            1.0 + 0.3 * y - 0.6 * x2 * y2 + 0.04 * x3 * y4,
            -2.0 + 0.3 * x - 0.4 * x3 * y + 0.04 * x4 * y3,
        ],
        hessian_per_mm: [
            -1.2 * x * y2 + 0.12 * x2 * y4,
            0.3 - 1.2 * x2 * y + 0.16 * x3 * y3,
            -0.4 * x3 + 0.12 * x4 * y2,
        ],
    }
}

proptest! {
    #[test]
    fn a_grid_is_exact_for_quartics(x in -3.0..3.0_f64, y in -2.0..2.0_f64) {
        let grid = grid(NODES, quartic);
        let (found, expected) = (grid.jet(x, y).unwrap(), jet_of_quartic(x, y));
        prop_assert!((found.z_mm - expected.z_mm).abs() < 1e-11);
        for k in 0..2 {
            prop_assert!((found.gradient[k] - expected.gradient[k]).abs() < 1e-10);
        }
        for k in 0..3 {
            prop_assert!((found.hessian_per_mm[k] - expected.hessian_per_mm[k]).abs() < 1e-9);
        }
    }
}

fn wave(x: f64, y: f64) -> f64 {
    (1.3 * x).sin() * (0.7 + y).cos()
}

#[test]
fn a_grid_passes_through_its_nodes_and_bends_smoothly() {
    let grid = grid(NODES, wave);
    for i in 0..NODES.nx {
        for j in 0..NODES.ny {
            let x = NODES.x_min_mm + i as f64 * NODES.step_x_mm;
            let y = NODES.y_min_mm + j as f64 * NODES.step_y_mm;
            assert!((grid.sag_mm(x, y).unwrap() - wave(x, y)).abs() < 1e-12);
        }
    }
    // Second derivatives agree on both sides of a border of cells.
    for i in 1..NODES.nx - 1 {
        let (x, y) = (NODES.x_min_mm + i as f64 * NODES.step_x_mm, 0.17);
        let (left, right) = (grid.jet(x - 1e-9, y).unwrap(), grid.jet(x + 1e-9, y).unwrap());
        for k in 0..3 {
            assert!((left.hessian_per_mm[k] - right.hessian_per_mm[k]).abs() < 1e-6);
        }
    }
    check(&grid, 0.26, 0.19, 10.0);
    check(&grid, -2.74, 1.81, 10.0);
}

/// Error of order 5 of the step.
#[test]
fn a_finer_grid_is_better_by_the_fifth_power() {
    let error = |halvings: usize| {
        let share = 1 << halvings;
        let fine = Nodes {
            step_x_mm: NODES.step_x_mm / share as f64,
            step_y_mm: NODES.step_y_mm / share as f64,
            nx: (NODES.nx - 1) * share + 1,
            ny: (NODES.ny - 1) * share + 1,
            ..NODES
        };
        let grid = grid(fine, wave);
        let places =
            (0..400).map(|k| (f64::from(k % 20) * 0.29 - 2.9, f64::from(k / 20) * 0.19 - 1.9));
        places.map(|(x, y)| (grid.sag_mm(x, y).unwrap() - wave(x, y)).abs()).fold(0.0, f64::max)
    };
    let (coarse, fine) = (error(0), error(2));
    assert!(coarse / fine > 500.0, "{coarse:e} {fine:e}");
}

#[test]
fn a_missing_node_is_never_bridged() {
    let mut sags = vec![1.0; 13 * 11];
    sags[5 * 13 + 6] = f64::NAN;
    let grid = SagGrid::new(NODES, &sags).unwrap();
    let defined = |x, y| grid.jet(x, y).is_some();
    // Node (6, 5) lies at (0, 0): cells that reach it, three on either side, are not defined.
    assert!(!defined(0.1, 0.1) && !defined(-0.1, 0.1) && !defined(1.4, -1.1));
    assert!(defined(1.6, 0.0) && defined(-1.6, 0.0) && defined(0.0, 1.3) && defined(2.9, 1.9));
    assert!(grid.by_parameters(0.1, 0.1, &mut []).is_none());
    assert_eq!(grid.domain_mm(), 0.0);
    // Beside an edge the formulas are one-sided: cells to the third depend on a node of the edge.
    let mut sags = vec![1.0; 13 * 11];
    sags[5 * 13] = f64::INFINITY;
    let grid = SagGrid::new(NODES, &sags).unwrap();
    assert!(grid.jet(-1.6, 0.0).is_none() && grid.jet(-1.4, 0.0).is_some());
    assert!((grid.domain_mm() - 1.5).abs() < 1e-12);
}

#[test]
fn grids_that_cannot_be() {
    let sags = [0.0; 143];
    let grid = SagGrid::new(NODES, &sags).unwrap();
    assert!(grid.jet(3.1, 0.0).is_none() && grid.jet(f64::NAN, 0.0).is_none());
    assert!(grid.jet(3.0, -2.0).is_some() && grid.parameters().is_empty());
    assert_eq!(grid.domain_mm(), 2.0);
    assert!(grid.with_parameters(&[1.0]).is_err());
    let error = SagGrid::new(Nodes { step_x_mm: 0.0, ..NODES }, &sags).unwrap_err();
    assert_eq!(error, SagGridError::Place { name: "step_x", value_mm: 0.0 });
    let error = SagGrid::new(Nodes { nx: 4, ..NODES }, &sags).unwrap_err();
    assert_eq!(error.to_string(), "4 by 11 nodes, expected at least 5 each way");
    let error = SagGrid::new(NODES, &sags[1..]).unwrap_err();
    assert_eq!(error, SagGridError::Count { found: 142, nx: 13, ny: 11 });
    let error = SagGrid::new(NODES, &[f64::NAN; 143]).unwrap_err();
    assert_eq!(error, SagGridError::Empty { missing: 143, nodes: 143 });
}

const CELLS: Cells =
    Cells { x_min_mm: -4.0, y_min_mm: -3.0, step_x_mm: 0.5, step_y_mm: 0.6, nx: 16, ny: 10 };

/// Splines whose coefficients are the mean of three values of a quadratic reproduce it: Marsden's identity.
#[test]
fn splines_have_their_derivatives() {
    let coefficients: Vec<f64> = (0..CELLS.splines()).map(|k| (k as f64 * 0.37).sin()).collect();
    let surface = SplineSurface::new(CELLS, &coefficients, &[true; 160]).unwrap();
    for (x, y) in [(0.26, 0.3), (-3.76, -2.7), (3.7, 2.75)] {
        check(&surface, x, y, 30.0);
    }
    // The coefficient of t² over a node k is k² − 1/3, with k − 1 the spline's own place.
    let columns = CELLS.nx + 3;
    let squares: Vec<f64> =
        (0..CELLS.splines()).map(|k| ((k % columns) as f64 - 1.0).powi(2) - 1.0 / 3.0).collect();
    let surface = SplineSurface::new(CELLS, &squares, &[true; 160]).unwrap();
    for x in [-4.0, -1.23, 0.0, 3.99, 4.0] {
        let t: f64 = (x + 4.0) / 0.5;
        let jet = surface.jet(x, 0.7).unwrap();
        assert!((jet.z_mm - t * t).abs() < 1e-11 && (jet.gradient[0] - 4.0 * t).abs() < 1e-11);
        assert!((jet.hessian_per_mm[0] - 8.0).abs() < 1e-10 && jet.gradient[1].abs() < 1e-11);
    }
}

#[test]
fn splines_that_cannot_be() {
    let zeros = vec![0.0; CELLS.splines()];
    let mut defined = [true; 160];
    defined[0] = false;
    let surface = SplineSurface::new(CELLS, &zeros, &defined).unwrap();
    assert!(surface.jet(-3.9, -2.9).is_none() && surface.jet(-3.4, -2.9).is_some());
    assert!(surface.jet(4.1, 0.0).is_none() && surface.jet(0.0, f64::NAN).is_none());
    assert!(surface.by_parameters(-3.9, -2.9, &mut []).is_none());
    assert_eq!(surface.domain_mm(), 3.0);
    let error = SplineSurface::new(CELLS, &zeros[1..], &defined).unwrap_err();
    assert!(matches!(
        error,
        SplineError::Count { what: "coefficients", found: 246, expected: 247 }
    ));
    let error = SplineSurface::new(Cells { nx: 0, ..CELLS }, &zeros, &defined).unwrap_err();
    assert_eq!(error, SplineError::Cells { nx: 0, ny: 10 });
    let error = SplineSurface::new(Cells { step_y_mm: f64::NAN, ..CELLS }, &zeros, &defined);
    assert!(matches!(error.unwrap_err(), SplineError::Place { name: "step_y", .. }));
}

/// Uniform over the rectangle but for a hole of 2 mm about (1, 1), with Gaussian noise.
fn points(count: usize, sigma_mm: f64, sag: impl Fn(f64, f64) -> f64) -> Vec<PointMm> {
    let mut random = Pcg64Mcg::seed_from_u64(1979);
    let mut uniform = || (random.next_u64() >> 11) as f64 / (1_u64 << 53) as f64;
    let mut points = Vec::new();
    while points.len() < count {
        let (x, y) = (8.0 * uniform() - 4.0, 6.0 * uniform() - 3.0);
        let normal = (0..12).map(|_| uniform()).sum::<f64>() - 6.0;
        if (x - 1.0).hypot(y - 1.0) > 1.0 {
            points.push([x, y, sag(x, y) + sigma_mm * normal]);
        }
    }
    points
}

fn freeform(x: f64, y: f64) -> f64 {
    0.02 * x * x - 0.01 * y * y + 1e-3 * (1.1 * x).sin() * (0.9 * y).cos()
}

/// Cross validation and the noise given both find the surface to much less than the noise, and the noise.
#[test]
fn noise_is_smoothed_away() {
    let sigma_mm = 1e-4;
    let points = points(6000, sigma_mm, freeform);
    for smoothing in [Smoothing::CrossValidation, Smoothing::Noise { sigma_mm }] {
        let fit = fit_spline(&points, &CELLS, smoothing).unwrap();
        assert!(!fit.at_limit && fit.used == 6000);
        assert!((fit.noise_mm.unwrap() / sigma_mm - 1.0).abs() < 0.05, "{smoothing:?} {fit:?}");
        let square: f64 = points
            .iter()
            .map(|p| (fit.surface.sag_mm(p[0], p[1]).unwrap() - freeform(p[0], p[1])).powi(2))
            .sum();
        let error = (square / 6000.0).sqrt();
        // √(effective parameters/n) of the noise, and something for what is smoothed away.
        let expected = sigma_mm * (fit.effective_parameters / 6000.0).sqrt();
        assert!(
            error < 1.5 * expected && error < 0.3 * sigma_mm,
            "{smoothing:?} {error:e} {expected:e}"
        );
        // The residuals' figure is that of the points.
        let square: f64 =
            points.iter().map(|p| (fit.surface.sag_mm(p[0], p[1]).unwrap() - p[2]).powi(2)).sum();
        assert!((fit.residual_rms_mm / (square / 6000.0).sqrt() - 1.0).abs() < 1e-9);
    }
}

#[test]
fn the_hole_stays_unknown() {
    let fit =
        fit_spline(&points(6000, 1e-5, freeform), &CELLS, Smoothing::CrossValidation).unwrap();
    assert!(fit.surface.jet(1.0, 1.0).is_none() && fit.surface.jet(1.0, 2.6).is_some());
    let undefined = fit.surface.defined().iter().filter(|defined| !**defined).count();
    assert!((2..=8).contains(&undefined), "{undefined}");
    assert!(fit.surface.domain_mm() > 0.5 && fit.surface.domain_mm() < 1.0);
}

/// Against the definition, solved densely: (BᵀB + λDᵀD)·c = Bᵀz and the trace of the hat matrix.
#[test]
fn a_fit_is_the_dense_solution() {
    use nalgebra::{DMatrix, DVector};
    let cells = Cells { nx: 4, ny: 5, step_x_mm: 2.0, step_y_mm: 1.2, ..CELLS };
    let points = points(60, 1e-3, freeform);
    let fit = fit_spline(&points, &cells, Smoothing::Relative { lambda: 0.3 }).unwrap();
    let (columns, rows) = (7, 8);
    let b = DMatrix::from_fn(points.len(), columns * rows, |i, k| {
        let mut unit = vec![0.0; columns * rows];
        unit[k] = 1.0;
        let spline = SplineSurface::new(cells, &unit, &[true; 20]).unwrap();
        spline.sag_mm(points[i][0], points[i][1]).unwrap()
    });
    let mut differences = Vec::new();
    for row in 0..rows {
        for column in 0..columns {
            for (stride, fits) in [(1, column + 2 < columns), (columns, row + 2 < rows)] {
                if fits {
                    let first = row * columns + column;
                    let mut difference = DVector::zeros(columns * rows);
                    difference[first] = 1.0;
                    difference[first + stride] = -2.0;
                    difference[first + 2 * stride] = 1.0;
                    differences.push(difference);
                }
            }
        }
    }
    let penalty: DMatrix<f64> = differences.iter().map(|d| d * d.transpose()).sum();
    let gram = b.tr_mul(&b);
    let lambda = 0.3 * gram.trace() / penalty.trace();
    let inverse = (&gram + penalty * lambda).try_inverse().unwrap();
    let z = DVector::from_iterator(points.len(), points.iter().map(|point| point[2]));
    let coefficients = &inverse * b.tr_mul(&z);
    for (found, expected) in fit.surface.coefficients_mm().iter().zip(coefficients.iter()) {
        assert!((found - expected).abs() < 1e-11, "{found} {expected}");
    }
    assert!((fit.effective_parameters - (inverse * gram).trace()).abs() < 1e-9);
    let rest = (z - b * coefficients).norm();
    assert!((fit.residual_rms_mm / (rest / 60_f64.sqrt()) - 1.0).abs() < 1e-9);
}

#[test]
fn a_plane_far_away_is_smoothest_and_exact() {
    let far = Cells { x_min_mm: 1e5 - 4.0, ..CELLS };
    let plane: Vec<PointMm> = points(900, 0.0, |x, y| 7.0 + 0.1 * x - 0.2 * y)
        .into_iter()
        .map(|[x, y, z]| [x + 1e5, y, z])
        .collect();
    let fit = fit_spline(&plane, &far, Smoothing::Noise { sigma_mm: 1e-6 }).unwrap();
    assert!(fit.at_limit && fit.residual_rms_mm < 1e-10, "{fit:?}");
    assert!((fit.effective_parameters - 4.0).abs() < 0.05, "{}", fit.effective_parameters);
}

#[test]
fn points_that_determine_nothing() {
    let smoothing = Smoothing::CrossValidation;
    let undetermined = |points: &[PointMm]| fit_spline(points, &CELLS, smoothing).unwrap_err();
    assert!(matches!(undetermined(&[]), SplineFitError::Undetermined { used: 0, .. }));
    let line: Vec<PointMm> = (0..70).map(|i| [f64::from(i) * 0.1 - 3.5, 0.0, 1.0]).collect();
    assert!(matches!(undetermined(&line), SplineFitError::Undetermined { used: 70, .. }));
    let mixed = [[9.0, 0.0, 0.0], [0.0, 0.0, f64::NAN], [0.0, 0.0, 0.0], [f64::NAN, 0.0, 0.0]];
    let expected = SplineFitError::Undetermined { used: 1, outside: 1, not_finite: 2 };
    assert_eq!(undetermined(&mixed), expected);
    let error = fit_spline(&line, &CELLS, Smoothing::Noise { sigma_mm: 0.0 }).unwrap_err();
    assert_eq!(error, SplineFitError::Smoothing { name: "sigma_mm", value: 0.0 });
    let error = fit_spline(&line, &Cells { nx: 129, ..CELLS }, smoothing).unwrap_err();
    assert!(matches!(error, SplineFitError::Cells(SplineError::Cells { nx: 129, ny: 10 })));
}
