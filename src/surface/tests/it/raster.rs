//! Interpolation on a grid against fields that linear interpolation reproduces exactly.

use asphera_geometry::PointMm;
use asphera_mesh::Mesh;
use asphera_surface::{Criteria, Grid, RasterError, assess, rasterize};
use proptest::prelude::*;

use crate::patterns::scattered;

fn meshed(points: impl IntoIterator<Item = PointMm>) -> Mesh {
    let mut mesh = Mesh::new();
    mesh.extend(points);
    mesh.flush();
    mesh
}

fn square_grid(nodes: usize, step_mm: f64) -> Grid {
    Grid { x0_mm: 0.0, y0_mm: 0.0, dx_mm: step_mm, dy_mm: step_mm, nx: nodes, ny: nodes }
}

#[test]
fn a_linear_field_comes_back() {
    let mesh = meshed(scattered(2_000, 1.0, 21));
    let field = |x: f64, y: f64| 3.0 - 2.0 * x + 0.5 * y;
    let values: Vec<f64> = mesh.points().iter().map(|p| field(p[0], p[1])).collect();
    let grid = Grid { x0_mm: -0.2, y0_mm: 0.1, dx_mm: 0.0131, dy_mm: 0.017, nx: 110, ny: 50 };
    let raster = rasterize(mesh.points(), mesh.triangles(), &values, &grid).unwrap();
    assert_eq!(raster.len(), 110 * 50);
    let mut inside = 0;
    for (index, value) in raster.into_iter().enumerate() {
        let x = grid.x0_mm + (index % grid.nx) as f64 * grid.dx_mm;
        let y = grid.y0_mm + (index / grid.nx) as f64 * grid.dy_mm;
        if !value.is_nan() {
            inside += 1;
            assert!((value - field(x, y)).abs() < 1e-13, "{value} at ({x}, {y})");
        }
        // 2,000 points scattered over the unit square come within 0.03 of its outline everywhere.
        let margin = x.min(1.0 - x).min(y).min(1.0 - y);
        assert!(margin < 0.03 || !value.is_nan(), "hole at ({x}, {y})");
        assert!(margin >= 0.0 || value.is_nan(), "value outside at ({x}, {y})");
    }
    assert!(inside > 3_500, "{inside}");
}

#[test]
fn nodes_on_the_points_take_their_values() {
    let mesh = meshed((0..400).map(|i| [f64::from(i % 20), f64::from(i / 20), 0.0]));
    let values: Vec<f64> = (0..400).map(|i| f64::from(i * i % 37) / 3.0).collect();
    let raster =
        rasterize(mesh.points(), mesh.triangles(), &values, &square_grid(20, 1.0)).unwrap();
    assert_eq!(raster, values);
}

#[test]
fn a_constant_stays_constant() {
    let mesh = meshed(scattered(300, 1.0, 22));
    let values = vec![0.1; 300];
    let raster =
        rasterize(mesh.points(), mesh.triangles(), &values, &square_grid(50, 0.02)).unwrap();
    assert!(raster.iter().all(|&value| value.is_nan() || value == 0.1));
    assert!(raster.iter().filter(|value| !value.is_nan()).count() > 2_000);
}

#[test]
fn a_gap_stays_a_gap() {
    // Two plates of 11 × 11 nodes, 10 mm apart.
    let plate = |x0: f64| (0..121).map(move |i| [x0 + f64::from(i % 11), f64::from(i / 11), 1.0]);
    let mesh = meshed(plate(0.0).chain(plate(20.0)));
    let criteria = Criteria { gap_limit_mm: Some(1.0), ..Criteria::default() };
    let survey = assess(mesh.points(), mesh.triangles(), &criteria, |_, _| f64::INFINITY);
    let grid = Grid { x0_mm: -1.0, y0_mm: 0.25, dx_mm: 0.5, dy_mm: 9.5, nx: 65, ny: 2 };
    let raster = rasterize(mesh.points(), survey.good(), &[1.0; 242], &grid).unwrap();
    for (index, value) in raster.into_iter().enumerate() {
        let x = -1.0 + (index % 65) as f64 * 0.5;
        let on_a_plate = (0.0..=10.0).contains(&x) || (20.0..=30.0).contains(&x);
        assert_eq!(!value.is_nan(), on_a_plate, "{x}");
    }
}

#[test]
fn a_missing_value_spreads_no_farther_than_its_triangles() {
    let mesh = meshed((0..25).map(|i| [f64::from(i % 5), f64::from(i / 5), 0.0]));
    let mut values = vec![1.0; 25];
    values[12] = f64::NAN;
    let raster = rasterize(mesh.points(), mesh.triangles(), &values, &square_grid(9, 0.5)).unwrap();
    for (index, value) in raster.into_iter().enumerate() {
        let (x, y) = ((index % 9) as f64 * 0.5, (index / 9) as f64 * 0.5);
        let (dx, dy) = ((x - 2.0).abs(), (y - 2.0).abs());
        if (dx, dy) == (0.0, 0.0) || (dx, dy) == (0.5, 0.0) || (dx, dy) == (0.0, 0.5) {
            assert!(value.is_nan(), "({x}, {y})");
        } else if dx >= 1.0 || dy >= 1.0 {
            assert_eq!(value, 1.0, "({x}, {y})");
        }
    }
}

#[test]
fn what_cannot_be_rasterized() {
    let points = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
    let run = |values: &[f64], grid: Grid| rasterize(&points, [[0, 1, 2]], values, &grid);
    let good = square_grid(2, 0.5);
    assert_eq!(run(&[1.0; 3], good), Ok(vec![1.0; 4]));
    assert_eq!(run(&[1.0; 2], good), Err(RasterError::Values { values: 2, points: 3 }));
    for step in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        let found = run(&[1.0; 3], Grid { dx_mm: step, ..good });
        assert!(matches!(found, Err(RasterError::Grid { .. })), "{step}: {found:?}");
    }
    let found = run(&[1.0; 3], Grid { x0_mm: f64::NAN, ..good });
    assert!(matches!(found, Err(RasterError::Grid { .. })));
    let (nx, ny) = (usize::MAX, 2);
    assert_eq!(run(&[1.0; 3], Grid { nx, ..good }), Err(RasterError::Nodes { nx, ny }));
    assert_eq!(run(&[1.0; 3], Grid { nx: 0, ..good }), Ok(vec![]));
    // Far from everything, and a clockwise triangle.
    let away = run(&[1.0; 3], Grid { x0_mm: -1e30, ..good }).unwrap();
    assert!(away.iter().all(|value| value.is_nan()));
    let clockwise = rasterize(&points, [[0, 2, 1]], &[1.0; 3], &good).unwrap();
    assert!(clockwise[3].is_nan());
}

proptest! {
    /// Integer corners and nodes: which nodes a triangle covers is known exactly.
    #[test]
    fn covers_exactly_the_nodes_inside(
        corners in prop::array::uniform3(prop::array::uniform2(-20_i64..20)),
        values in prop::array::uniform3(-1.0..1.0_f64),
    ) {
        let [a, b, c] = corners;
        let cross = |p: [i64; 2], q: [i64; 2], r: [i64; 2]| {
            (q[0] - p[0]) * (r[1] - p[1]) - (q[1] - p[1]) * (r[0] - p[0])
        };
        prop_assume!(cross(a, b, c) > 0);
        let points = corners.map(|[x, y]| [x as f64, y as f64, 0.0]);
        let grid = Grid { x0_mm: -12.0, y0_mm: -25.0, dx_mm: 1.0, dy_mm: 1.0, nx: 25, ny: 50 };
        let raster = rasterize(&points, [[0, 1, 2]], &values, &grid).unwrap();
        let [low, high] = [f64::min, f64::max].map(|pick| values.into_iter().reduce(pick).unwrap());
        for (index, value) in raster.into_iter().enumerate() {
            let node = [index as i64 % 25 - 12, index as i64 / 25 - 25];
            let weights = [cross(b, c, node), cross(c, a, node), cross(a, b, node)];
            let inside = weights.iter().all(|&weight| weight >= 0);
            prop_assert_eq!(!value.is_nan(), inside, "{:?}", node);
            if inside {
                let sum: f64 = (0..3).map(|i| weights[i] as f64 * values[i]).sum();
                let expected = sum / cross(a, b, c) as f64;
                prop_assert!((value - expected).abs() < 1e-14 && low <= value && value <= high);
            }
        }
    }
}
