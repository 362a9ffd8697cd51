//! Meshes too dense for their filters vertex by vertex, and meshes laid on a grid.

use std::cell::RefCell;
use std::f64::consts::TAU;

use asphera_figures::texture::{
    Datum, Gaussian, Grid, Mesh, Order, Robust, Threshold, Unknown, autocorrelation,
    height_parameters, spatial_parameters,
};

use super::mesh;
use crate::common::Noise;

/// 100 × 100 vertices some 0.01 mm apart, none of them in line.
fn shaken(height_nm: impl Fn(f64, f64) -> f64) -> Mesh {
    shaken_of(100, height_nm)
}

/// The same of another number of rows and columns.
fn shaken_of(count: u32, height_nm: impl Fn(f64, f64) -> f64) -> Mesh {
    let noise = |i: u32, j: u32, salt: u32| {
        let hash = (i.wrapping_mul(2_654_435_761) ^ j.wrapping_mul(40_503) ^ salt)
            .wrapping_mul(2_246_822_519);
        f64::from(hash >> 16) / 65_536.0 - 0.5
    };
    let place = move |i: u32, j: u32| {
        [
            0.01 * (f64::from(j) + 0.6 * noise(i, j, 1)),
            0.01 * (f64::from(i) + 0.6 * noise(i, j, 77)),
        ]
    };
    mesh(count, count, place, height_nm)
}

/// Largest and RMS difference of the measured heights of two meshes of the same vertices.
fn apart(a: &Mesh, b: &Mesh) -> (f64, f64) {
    let pairs = a.heights_nm().zip(b.heights_nm()).map(|(a, b)| (a.unwrap() - b.unwrap()).abs());
    let all: Vec<f64> = pairs.collect();
    let square = all.iter().map(|d| d * d).sum::<f64>() / all.len() as f64;
    (all.iter().copied().fold(0.0, f64::max), square.sqrt())
}

#[test]
fn a_grid_of_nodes_filters_as_the_vertices_do() {
    let height = |x: f64, y: f64| {
        1e6 + 40.0 * (TAU * x / 0.5).sin()
            + 20.0 * (TAU * y / 1.1).cos()
            + 5.0 * (TAU * (x + y) / 0.03).sin()
    };
    let dense = shaken(height);
    for order in [Order::Zero, Order::Two] {
        let filter = Gaussian::new(0.35, order).unwrap();
        let (exact, by_grid) = (filter.of_mesh(&dense), filter.of_dense_mesh(&dense));
        assert_eq!((exact.nodes_mm, by_grid.undetermined), (None, 0));
        // Only about 19 of the mean distance of the vertices lie in a window of order 2, 12 of order 0.
        if by_grid.nodes_mm.is_none() {
            assert_eq!((order, exact.surface), (Order::Zero, by_grid.surface));
            continue;
        }
        let (largest, rms) = apart(&exact.surface, &by_grid.surface);
        assert!(largest < 0.6 && rms < 0.15, "{order:?}: {largest} {rms}");
    }
    let coarse = Gaussian::new(0.55, Order::Zero).unwrap();
    let (exact, by_grid) = (coarse.of_mesh(&dense), coarse.of_dense_mesh(&dense));
    assert!(by_grid.nodes_mm.is_some_and(|nodes_mm| (nodes_mm - 0.55 / 32.0).abs() < 1e-12));
    let (largest, rms) = apart(&exact.surface, &by_grid.surface);
    assert!(largest < 0.5 && rms < 0.1, "{largest} {rms}");
}

#[test]
fn a_robust_filter_keeps_out_of_pits_on_a_grid_of_nodes_too() {
    let pit = |x: f64, y: f64| (x - 0.5).hypot(y - 0.5) < 0.05;
    let noise = RefCell::new(Noise::new(3));
    let smooth = |x: f64, y: f64| 30.0 * (x * x + y);
    let dense = shaken(|x, y| {
        smooth(x, y) + noise.borrow_mut().next() - if pit(x, y) { 900.0 } else { 0.0 }
    });
    let filter = Gaussian::new(0.5, Order::Two).unwrap().robust(Robust::default());
    let found = filter.of_dense_mesh(&dense);
    let report = found.robust.unwrap();
    assert!(found.nodes_mm.is_some() && report.converged, "{report:?}");
    let (largest, rms) = apart(&found.surface, &shaken(smooth));
    assert!(largest < 1.0 && rms < 0.1, "{largest} {rms} {report:?}");
}

#[test]
fn a_mesh_on_a_grid_is_its_linear_interpolation() {
    let plane = |x: f64, y: f64| 7.0 + 300.0 * x - 200.0 * y;
    let tilted = shaken(plane);
    let grid = tilted.to_grid().unwrap();
    let known = grid.heights_nm().flatten().count();
    assert!(known > 9000 && grid.spacing_mm()[0] == grid.spacing_mm()[1]);
    // The heights of a plane are those of a plane: what levelling leaves is rounding.
    let left = height_parameters((&grid.levelled(Datum::MeanPlane)).into()).unwrap();
    assert!(left.sz_nm < 1e-9, "{}", left.sz_nm);
    assert_eq!(Mesh::new(&[], &[]).unwrap().to_grid(), None);
}

#[test]
fn sal_and_str_of_a_mesh_are_those_of_its_surface() {
    // Grooves along y of 0.2 mm: the autocorrelation is a cosine, which falls to 0.2 at acos(0.2)/2π.
    let grooves = shaken_of(140, |x, _| 50.0 * (TAU * x / 0.2).sin()).levelled(Datum::Mean);
    let found = spatial_parameters((&grooves).into(), Threshold::DEFAULT).unwrap();
    let expected_um = 200.0 * 0.2f64.acos() / TAU;
    assert!((found.sal_um() - expected_um).abs() < 0.02 * expected_um, "{}", found.sal_um());
    assert!(matches!(found.slowest, Err(Unknown::StaysInOneDirection { .. })));
    assert!(found.support.points > 19_000);
    let noise = RefCell::new(Noise::new(5));
    let rough = shaken_of(140, |_, _| noise.borrow_mut().next());
    let smooth = Gaussian::new(0.08, Order::Zero).unwrap().of_mesh(&rough).surface;
    let by_mesh = spatial_parameters((&smooth).into(), Threshold::DEFAULT).unwrap();
    let grid = smooth.to_grid().unwrap();
    let by_grid = spatial_parameters((&grid).into(), Threshold::DEFAULT).unwrap();
    assert_eq!(by_mesh.sal_um(), by_grid.sal_um());
    // Noise through a Gaussian exp(−π(r/αc)²) has the autocorrelation exp(−π(r/αc)²/2), about 0.2 at 1.012·αc.
    let expected_um = 1e3 * 1.012 * 0.469_7 * 0.08;
    assert!((by_mesh.sal_um() - expected_um).abs() < 0.12 * expected_um, "{}", by_mesh.sal_um());
    assert!(by_mesh.str_ratio().unwrap() > 0.7 && autocorrelation(&grid).is_ok());
}

/// White heights on a turned raster with gaps: interpolated they would come out smooth, and Sal as long as a step.
#[test]
fn a_mesh_on_a_raster_is_that_raster() {
    let (columns, rows, step_mm, turn_rad) = (60_usize, 50_usize, 0.1, 0.4_f64);
    let mut noise = Noise::new(11);
    let heights_nm: Vec<f64> = (0..columns * rows)
        .map(|node| if node % 97 == 5 { f64::NAN } else { 30.0 * noise.next() })
        .collect();
    let (sin, cos) = turn_rad.sin_cos();
    let point = |node: usize| {
        let (u, v) = (step_mm * (node % columns) as f64, step_mm * (node / columns) as f64);
        [2.0 + cos * u - sin * v, sin * u + cos * v - 7.0, heights_nm[node] * 1e-6]
    };
    let points: Vec<[f64; 3]> = (0..columns * rows).map(point).collect();
    let cell = |node: usize| {
        let [a, b, c, d] = [node, node + 1, node + columns, node + columns + 1].map(|n| n as u32);
        [[a, b, d], [a, d, c]]
    };
    let inner = (0..columns * (rows - 1)).filter(|node| (node + 1) % columns != 0);
    let triangles: Vec<[u32; 3]> = inner.flat_map(cell).collect();
    let mesh = Mesh::new(&points, &triangles).unwrap().levelled(Datum::Mean);
    let of_mesh = mesh.to_grid().unwrap();
    let grid = Grid::new(&heights_nm, rows, columns, [step_mm; 2]).unwrap();
    for (found, expected) in of_mesh.heights_nm().zip(mesh.heights_nm()) {
        assert_eq!(found, expected);
    }
    let by_mesh = spatial_parameters((&mesh).into(), Threshold::DEFAULT).unwrap();
    let by_grid =
        spatial_parameters((&grid.levelled(Datum::Mean)).into(), Threshold::DEFAULT).unwrap();
    assert!((by_mesh.sal_um() / by_grid.sal_um() - 1.0).abs() < 0.01, "{by_mesh:?} {by_grid:?}");
    assert!(by_mesh.sal_um() < 100.0, "{}", by_mesh.sal_um());
    let turn = by_mesh.fastest.direction_rad - by_grid.fastest.direction_rad;
    let off = ((turn - turn_rad) / std::f64::consts::PI).rem_euclid(1.0);
    assert!(!(0.01..0.99).contains(&off), "{off}");
}
