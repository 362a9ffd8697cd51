//! Laws every surface obeys.

use asphera_figures::texture::{
    Datum, Gaussian, Grid, Order, Robust, Threshold, core_parameters, height_parameters,
    hybrid_parameters, spatial_parameters,
};
use proptest::prelude::*;

use super::{grid, mesh, weyl};
use crate::common::Noise;

const ROWS: usize = 40;
const COLUMNS: usize = 52;
const SPACING_MM: [f64; 2] = [0.01, 0.015];

/// Waves and noise with gaps.
fn heights(seed: u64) -> Vec<f64> {
    let mut noise = Noise::new(seed);
    let one = |noise: &mut Noise, i: usize| {
        let (x, y) = ((i % COLUMNS) as f64, (i / COLUMNS) as f64);
        let waves = (1..=20).map(|k| {
            let (fx, fy) = (1.4 * weyl(k, 0.819) - 0.7, 1.4 * weyl(k, 0.671) - 0.7);
            9.0 * (fx * x + fy * y + f64::from(k * k)).sin()
        });
        let height = waves.sum::<f64>() + 5.0 * noise.next();
        if noise.next() > 0.6 { f64::NAN } else { height }
    };
    (0..ROWS * COLUMNS).map(|i| one(&mut noise, i)).collect()
}

fn made(heights: &[f64]) -> Grid {
    Grid::new(heights, ROWS, COLUMNS, SPACING_MM).unwrap()
}

/// Sizes in nm, µrad and µm, then numbers without unit, of a grid about its mean plane.
fn figures(grid: &Grid) -> ([f64; 8], [f64; 4]) {
    let flat = grid.levelled(Datum::MeanPlane);
    let heights = height_parameters((&flat).into()).unwrap();
    let core = core_parameters((&flat).into()).unwrap();
    let spatial = spatial_parameters((&flat).into(), Threshold::DEFAULT).unwrap();
    let slope = hybrid_parameters((&flat).into()).unwrap().sdq_urad;
    (
        [
            heights.sa_nm,
            heights.sq_nm,
            heights.sz_nm,
            core.sk_nm,
            core.spk_nm,
            core.svk_nm,
            slope,
            spatial.sal_um(),
        ],
        [
            heights.ssk.unwrap(),
            heights.sku.unwrap(),
            core.smrk1_percent,
            spatial.str_ratio().unwrap(),
        ],
    )
}

fn close(a: f64, b: f64, share: f64) -> bool {
    (a - b).abs() <= share * a.abs().max(b.abs()).max(1e-6)
}

/// The same bits whatever the threads.
#[test]
fn threads_do_not_matter() {
    let grid = made(&heights(3));
    let meshed = mesh(30, 30, |i, j| [f64::from(j), f64::from(i)], |x, y| (x * y).sin());
    let all = || {
        let filters = [Order::Zero, Order::Two].map(|order| {
            let filter = Gaussian::new(0.08, order).unwrap().robust(Robust::default());
            let on_mesh = Gaussian::new(3.0, order).unwrap().robust(Robust::default());
            (filter.of_grid(&grid), on_mesh.of_mesh(&meshed))
        });
        (filters, figures(&grid))
    };
    let with = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(all)
    };
    assert_eq!(with(1), with(4));
}

/// A mesh on the nodes of a grid has its figures, but for the weight of the border.
#[test]
fn a_mesh_of_a_lattice_agrees_with_its_grid() {
    let height = |x: f64, y: f64| {
        20.0 * (9.0 * x).sin() * (7.0 * y).cos() + 3.0 * (40.0 * x + 31.0 * y).sin()
    };
    let gridded = grid(150, 200, [0.01, 0.01], height);
    let meshed = mesh(150, 200, |i, j| [f64::from(j) * 0.01, f64::from(i) * 0.01], height);
    let filter = Gaussian::new(0.08, Order::Two).unwrap();
    let (smooth, smooth_mesh) = (filter.of_grid(&gridded).surface, filter.of_mesh(&meshed).surface);
    // Inside, weights and places are the same; the windows are a square and a disc.
    for (i, (a, b)) in smooth.heights_nm().zip(smooth_mesh.heights_nm()).enumerate() {
        let (row, column) = (i / 200, i % 200);
        if (14..136).contains(&row) && (14..186).contains(&column) {
            assert!((a.unwrap() - b.unwrap()).abs() < 1e-3, "{row} {column}");
        }
    }
    let [a, b] = [(&gridded).into(), (&meshed).into()].map(|surface| {
        let heights = height_parameters(surface).unwrap();
        let core = core_parameters(surface).unwrap();
        let hybrid = hybrid_parameters(surface).unwrap();
        [heights.sa_nm, heights.sq_nm, core.sk_nm, core.spk_nm, hybrid.sdq_urad, hybrid.sdr_percent]
    });
    for (a, b) in a.iter().zip(&b) {
        assert!(close(*a, *b, 0.02), "{a} {b}");
    }
    assert!(close(a[4], b[4], 1e-12));
}

/// Core parameters of the surface upside down change places.
#[test]
fn upside_down_peaks_are_dales() {
    let values = heights(9);
    let turned: Vec<f64> = values.iter().map(|z| -z).collect();
    let of = |values: &[f64]| core_parameters((&made(values)).into()).unwrap();
    let (up, down) = (of(&values), of(&turned));
    assert!(close(up.sk_nm, down.sk_nm, 1e-9));
    assert!(close(up.spk_nm, down.svk_nm, 1e-9) && close(up.svk_nm, down.spk_nm, 1e-9));
    assert!(close(up.smrk1_percent, 100.0 - down.smrk2_percent, 1e-9));
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(12))]

    #[test]
    fn figures_scale_with_the_heights(seed in 0..1000_u64, factor in 1e-3..1e3_f64) {
        let values = heights(seed);
        let scaled: Vec<f64> = values.iter().map(|z| 1e4 + factor * z).collect();
        let (sizes, shape) = figures(&made(&values));
        let (found, found_shape) = figures(&made(&scaled));
        for (i, (size, found)) in sizes.iter().zip(&found).enumerate() {
            let factor = if i == 7 { 1.0 } else { factor };
            prop_assert!(close(size * factor, *found, 1e-6), "{i} {size} {found}");
        }
        for (a, b) in shape.iter().zip(&found_shape) {
            prop_assert!(close(*a, *b, 1e-6), "{a} {b}");
        }
    }

    #[test]
    fn a_mirrored_or_turned_surface_has_the_same_figures(seed in 0..1000_u64) {
        let values = heights(seed);
        let mirrored: Vec<f64> = values.chunks(COLUMNS).flat_map(|row| row.iter().rev().copied()).collect();
        let turned: Vec<f64> =
            (0..values.len()).map(|i| values[i % ROWS * COLUMNS + i / ROWS]).collect();
        let turned = Grid::new(&turned, COLUMNS, ROWS, [SPACING_MM[1], SPACING_MM[0]]).unwrap();
        let (sizes, shape) = figures(&made(&values));
        for other in [made(&mirrored), turned] {
            let (found, found_shape) = figures(&other);
            for (a, b) in sizes.iter().chain(&shape).zip(found.iter().chain(&found_shape)) {
                prop_assert!(close(*a, *b, 1e-6), "{a} {b}");
            }
        }
    }

    #[test]
    fn linear_filters_are_linear_and_keep_a_plane(seed in 0..1000_u64, slope in -500.0..500.0_f64) {
        let (first, second) = (heights(seed), heights(seed));
        let plane = |i: usize| 50.0 + slope * (i % COLUMNS) as f64 * SPACING_MM[0];
        let sum: Vec<f64> = first.iter().zip(&second).enumerate()
            .map(|(i, (a, b))| a - 3.0 * b + plane(i)).collect();
        let filter = Gaussian::new(0.07, Order::Two).unwrap();
        let of = |values: &[f64]| filter.of_grid(&made(values)).surface;
        let (first, second, sum) = (of(&first), of(&second), of(&sum));
        for (i, ((a, b), sum)) in first.heights_nm().zip(second.heights_nm()).zip(sum.heights_nm()).enumerate() {
            match (a, b, sum) {
                (Some(a), Some(b), Some(sum)) => prop_assert!((a - 3.0 * b + plane(i) - sum).abs() < 1e-7),
                gap => prop_assert_eq!(gap, (None, None, None)),
            }
        }
    }
}
