//! Surfaces with gaps, down to nothing: figures near those of the whole surface or a reason, never NaN.

use std::f64::consts::TAU;

use asphera_figures::texture::{
    Datum, Gaussian, Grid, Mesh, Order, Robust, Scale, Surface, TextureError, Threshold, Unknown,
    autocorrelation, core_parameters, height_parameters, hybrid_parameters, spatial_parameters,
};
use proptest::prelude::*;

use super::{lattice, mesh};
use crate::common::Noise;

/// All figures of a surface; none may be anything but a finite number.
fn numbers(surface: Surface<'_>) -> usize {
    let mut figures = Vec::new();
    figures.extend(height_parameters(surface).map(|found| found.figures()).unwrap_or_default());
    figures.extend(hybrid_parameters(surface).map(|found| found.figures()).unwrap_or_default());
    figures.extend(core_parameters(surface).map(|found| found.figures()).unwrap_or_default());
    if let Surface::Grid(grid) = surface {
        let found = spatial_parameters(grid.into(), Threshold::DEFAULT);
        figures.extend(found.map(|found| found.figures()).unwrap_or_default());
    }
    assert!(figures.iter().all(|figure| figure.value.is_finite()), "{figures:?}");
    figures.len()
}

fn filters() -> [Gaussian; 4] {
    let linear = [Order::Zero, Order::Two].map(|order| Gaussian::new(0.05, order).unwrap());
    [linear[0], linear[1], linear[0].robust(Robust::default()), linear[1].robust(Robust::default())]
}

/// Figures of a grid as it is and after each filter.
fn all_numbers(grid: &Grid) {
    for datum in [Datum::AsGiven, Datum::Mean, Datum::MeanPlane] {
        numbers((&grid.levelled(datum)).into());
    }
    for filter in filters() {
        let scale = Scale::new(None, Some(filter)).unwrap();
        let left = scale.of_grid(grid, Datum::MeanPlane);
        let long = &left.l.as_ref().unwrap().surface;
        assert!(long.heights_nm().chain(left.surface.heights_nm()).flatten().all(f64::is_finite));
        numbers((&left.surface).into());
    }
}

const SIZE: usize = 300;

/// A rough surface of correlation length 20 µm on waves of 0.7 mm.
fn rough() -> Vec<f64> {
    let mut noise = Noise::new(25178);
    let heights: Vec<f64> = (0..SIZE * SIZE).map(|_| 100.0 * noise.next()).collect();
    let white = Grid::new(&heights, SIZE, SIZE, [0.005; 2]).unwrap();
    let smooth = Gaussian::new(0.06, Order::Zero).unwrap().of_grid(&white).surface;
    let wave = |i: usize| 30.0 * (TAU * (i % SIZE) as f64 * 0.005 / 0.7).sin();
    smooth.heights_nm().enumerate().map(|(i, z)| z.unwrap() + wave(i)).collect()
}

/// The S-L surface without waves above 0.25 mm.
fn limited(heights: &[f64]) -> Grid {
    let grid = Grid::new(heights, SIZE, SIZE, [0.005; 2]).unwrap();
    let filter = Gaussian::new(0.25, Order::Two).unwrap();
    let scale = Scale::new(None, Some(filter)).unwrap();
    scale.of_grid(&grid, Datum::MeanPlane).surface
}

#[test]
fn scattered_gaps_change_figures_by_no_more_than_sampling() {
    let heights = rough();
    let whole = limited(&heights);
    let of = |grid: &Grid| {
        let heights = height_parameters(grid.into()).unwrap();
        let core = core_parameters(grid.into()).unwrap();
        let spatial = spatial_parameters(grid.into(), Threshold::DEFAULT).unwrap();
        let hybrid = hybrid_parameters(grid.into()).unwrap();
        let shape = [heights.ssk.unwrap(), heights.sku.unwrap()];
        let sizes =
            [heights.sa_nm, heights.sq_nm, core.sk_nm, core.spk_nm, core.svk_nm, hybrid.sdq_urad];
        (sizes, shape, spatial.sal_um(), heights.support.measured)
    };
    let (sizes, shape, sal, all) = of(&whole);
    assert_eq!(all, 1.0);
    for (gaps, share) in [(0.25, 0.02), (0.89, 0.06)] {
        let mut random = Noise::new(16610);
        let holed: Vec<f64> = heights
            .iter()
            .map(|&z| if random.next() < 2.0 * gaps - 1.0 { f64::NAN } else { z })
            .collect();
        let (found, found_shape, found_sal, measured) = of(&limited(&holed));
        eprintln!("{gaps}: {found:?} {found_shape:?} {found_sal}; whole {sizes:?} {shape:?} {sal}");
        assert!((measured - (1.0 - gaps)).abs() < 5e-3);
        for (found, whole) in found.iter().zip(&sizes) {
            assert!((found / whole - 1.0).abs() < share, "{gaps}: {found} {whole}");
        }
        for (found, whole) in found_shape.iter().zip(&shape) {
            assert!((found - whole).abs() < 3.0 * share, "{gaps}: {found} {whole}");
        }
        // The shortest of all directions: what noise there is shortens it.
        assert!((found_sal / sal - 1.0).abs() < 2.0 * share, "{gaps}: {found_sal} {sal}");
    }
}

/// A filter sees what is on the far side of a hole as without it, and its border as a border.
#[test]
fn a_hole_in_the_middle_leaves_the_rest_as_it_is() {
    let heights = rough();
    let hole = |i: usize| {
        let (x, y) = ((i % SIZE) as f64 - 150.0, (i / SIZE) as f64 - 150.0);
        x.hypot(y) < 60.0
    };
    let holed: Vec<f64> =
        heights.iter().enumerate().map(|(i, &z)| if hole(i) { f64::NAN } else { z }).collect();
    let (whole, found) = (limited(&heights), limited(&holed));
    let mut far = 0;
    for (i, (whole, found)) in whole.heights_nm().zip(found.heights_nm()).enumerate() {
        assert_eq!(found.is_none(), hole(i));
        let (x, y) = ((i % SIZE) as f64 - 150.0, (i / SIZE) as f64 - 150.0);
        // Beyond the window of 78 nodes, but for the mean plane, which the filter of order two passes.
        if (x.abs() - 60.0).max(y.abs() - 60.0) > 78.0 {
            assert!((whole.unwrap() - found.unwrap()).abs() < 1e-9);
            far += 1;
        }
    }
    assert!(far > 1000);
}

#[test]
fn nothing_one_point_and_one_row_have_what_they_have() {
    let spacing = [0.01, 0.01];
    for (heights, rows, columns) in
        [(vec![], 0, 0), (vec![], 0, 7), (vec![f64::NAN; 12], 3, 4), (vec![f64::INFINITY; 4], 1, 4)]
    {
        let nothing = Grid::new(&heights, rows, columns, spacing).unwrap();
        all_numbers(&nothing);
        assert_eq!(numbers((&nothing).into()), 0);
        let given = heights.len();
        assert_eq!(height_parameters((&nothing).into()), Err(Unknown::NoPoints { given }));
    }
    let mut one = vec![f64::NAN; 100];
    one[37] = -5.0;
    let one = Grid::new(&one, 10, 10, spacing).unwrap();
    all_numbers(&one);
    let found = height_parameters((&one).into()).unwrap();
    assert_eq!((found.sa_nm, found.sp_nm, found.sv_nm, found.sz_nm), (5.0, -5.0, 5.0, 0.0));
    assert_eq!((found.support.points, found.support.measured), (1, 0.01));
    let levelled = height_parameters((&one.levelled(Datum::MeanPlane)).into()).unwrap();
    assert_eq!((levelled.sq_nm, levelled.ssk, levelled.sku), (0.0, None, None));
    assert_eq!(hybrid_parameters((&one).into()), Err(Unknown::NoTriangle));
    assert_eq!(core_parameters((&one).into()), Err(Unknown::TooFewPoints { used: 1, needed: 5 }));
    let two = Gaussian::new(0.05, Order::Two).unwrap().of_grid(&one);
    assert_eq!((two.lowered, two.undetermined, two.surface.height_nm(3, 7)), (1, 0, Some(-5.0)));

    let row: Vec<f64> = (0..200).map(|i| (f64::from(i) * 0.3).sin() * 9.0).collect();
    let row = Grid::profile(&row, 0.01).unwrap();
    all_numbers(&row);
    let two = Gaussian::new(0.05, Order::Two).unwrap().of_grid(&row);
    assert_eq!((two.lowered, two.undetermined), (0, 0));
    let narrow = Unknown::TooNarrow { rows: 1, columns: 200, needed: 8 };
    assert_eq!(spatial_parameters((&row).into(), Threshold::DEFAULT), Err(narrow));
    assert_eq!(hybrid_parameters((&row).into()), Err(Unknown::NoTriangle));
}

#[test]
fn a_flat_surface_has_heights_of_zero_and_no_shape() {
    let flat = Grid::new(&[0.0; 400], 20, 20, [0.01; 2]).unwrap();
    all_numbers(&flat);
    let found = height_parameters((&flat).into()).unwrap();
    assert_eq!((found.sq_nm, found.sz_nm, found.ssk, found.sku), (0.0, 0.0, None, None));
    assert_eq!(autocorrelation(&flat), Err(Unknown::Flat));
    let core = core_parameters((&flat).into()).unwrap();
    assert_eq!((core.sk_nm, core.spk_nm, core.svk_nm), (0.0, 0.0, 0.0));
    // An offset never ceases to correlate.
    let offset = Grid::new(&[3.0; 400], 20, 20, [0.01; 2]).unwrap();
    let found = spatial_parameters((&offset).into(), Threshold::DEFAULT);
    assert!(matches!(found, Err(Unknown::NeverFalls { .. })), "{found:?}");
}

#[test]
fn meshes_without_area_or_places_have_reasons() {
    let place = |i: u32, j: u32| [f64::from(j) * 0.01, f64::from(i) * 0.01];
    let nothing = Mesh::new(&[], &[]).unwrap();
    let loose = Mesh::new(&[[0.0, 0.0, 1e-6], [1.0, 0.0, 2e-6]], &[]).unwrap();
    let line = [[0.0, 0.0, 1e-6], [1.0, 1.0, 2e-6], [2.0, 2.0, 5e-6]];
    let line = Mesh::new(&line, &[[0, 1, 2], [1, 1, 2]]).unwrap();
    let gaps = mesh(9, 9, place, |_, _| f64::NAN);
    for bare in [&nothing, &loose, &line, &gaps] {
        assert_eq!(numbers(bare.into()), 0);
        let unknown = Unknown::NoPoints { given: bare.len() };
        assert_eq!(height_parameters(bare.into()), Err(unknown));
        for filter in filters() {
            let filtered = filter.of_mesh(bare);
            let measured = bare.heights_nm().flatten().count();
            assert_eq!(filtered.undetermined, measured);
            assert_eq!(filtered.surface.heights_nm().flatten().count(), 0);
        }
    }
    let mut points: Vec<[f64; 3]> =
        (0..81).map(|i| place(i / 9, i % 9)).map(|[x, y]| [x, y, x * y]).collect();
    points[40] = [f64::NAN, 0.0, 1.0];
    points[10][2] = f64::INFINITY;
    let holed = Mesh::new(&points, &lattice(9, 9)).unwrap();
    assert_eq!(numbers((&holed).into()), 14);
    // The node without a place takes its six triangles along, the one without a height is a gap.
    let measured = height_parameters((&holed).into()).unwrap().support.measured;
    assert!((measured - 116.0 / 122.0).abs() < 1e-12, "{measured}");
}

#[test]
fn what_makes_no_sense_is_refused() {
    let size = TextureError::Grid { rows: 2, columns: 2, heights: 3 };
    assert_eq!(Grid::new(&[0.0; 3], 2, 2, [1.0; 2]), Err(size));
    assert!(Grid::new(&[], usize::MAX, 2, [1.0; 2]).is_err());
    for bad in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        assert!(matches!(Grid::new(&[], 0, 0, [1.0, bad]), Err(TextureError::Length { .. })));
        assert!(matches!(Gaussian::new(bad, Order::Two), Err(TextureError::Length { .. })));
        assert!(matches!(Robust::new(bad, 5), Err(TextureError::Tolerance { .. })));
        assert!(matches!(Threshold::new(bad), Err(TextureError::Threshold { .. })));
    }
    assert_eq!(Robust::new(0.1, 0), Err(TextureError::Iterations));
    let corner = TextureError::Corner { triangle: 0, corner: 1, points: 1 };
    assert_eq!(Mesh::new(&[[0.0; 3]], &[[0, 1, 0]]), Err(corner));
    let filter = |cutoff| Some(Gaussian::new(cutoff, Order::Zero).unwrap());
    let error = Scale::new(filter(0.5), filter(0.5)).unwrap_err();
    assert_eq!(
        error.to_string(),
        "the S-filter's cut-off of 0.5 mm is not below the L-filter's of 0.5 mm"
    );
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(60))]

    #[test]
    fn any_grid_gives_finite_numbers(
        columns in 1..24_usize,
        heights in prop::collection::vec(
            prop::option::of(prop::sample::select(vec![-2.0, 0.0, 1.0, 3.5, 1e-30, 1e30])), 0..400,
        ),
        spacing in prop::sample::select(vec![1e-9, 0.004, 0.02, 1.0, 1e12]),
    ) {
        let rows = heights.len() / columns;
        let heights: Vec<f64> =
            heights[..rows * columns].iter().map(|z| z.unwrap_or(f64::NAN)).collect();
        all_numbers(&Grid::new(&heights, rows, columns, [spacing, 0.01]).unwrap());
    }

    #[test]
    fn any_mesh_gives_finite_numbers(
        points in prop::collection::vec((-4..=4_i32, -4..=4_i32, prop::option::of(-3..=3_i32)), 3..60),
        corners in prop::collection::vec((0..60_u32, 0..60_u32, 0..60_u32), 0..80),
        scale in prop::sample::select(vec![1e-6, 0.02, 1e3]),
    ) {
        let count = points.len() as u32;
        let points: Vec<[f64; 3]> = points
            .iter()
            .map(|&(x, y, z)| [f64::from(x) * scale, f64::from(y) * scale, z.map_or(f64::NAN, f64::from)])
            .collect();
        let triangles: Vec<[u32; 3]> =
            corners.iter().map(|&(a, b, c)| [a % count, b % count, c % count]).collect();
        let mesh = Mesh::new(&points, &triangles).unwrap();
        numbers((&mesh).into());
        for filter in filters() {
            let scale = Scale::new(None, Some(filter)).unwrap();
            numbers((&scale.of_mesh(&mesh, Datum::MeanPlane).surface).into());
        }
    }
}
