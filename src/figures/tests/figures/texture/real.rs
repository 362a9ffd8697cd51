//! Measured topographies with figures asserted by their publishers.

use std::path::PathBuf;

use asphera_figures::texture::{
    Datum, Gaussian, Grid, Order, Robust, Scale, height_parameters, hybrid_parameters,
};
use asphera_formats::Topography;

/// The heights of a file, or `None` where the shared data are absent.
fn map(name: &str) -> Option<Grid> {
    let data = std::env::var_os("ASPHERA_DATA").map_or_else(
        || PathBuf::from(concat!(env!("CARGO_MANIFEST_DIR"), "/../../../shared/data")),
        PathBuf::from,
    );
    let path = data.join("topography").join(name);
    let Ok(bytes) = std::fs::read(&path) else {
        eprintln!("skipped: {} not found", path.display());
        return None;
    };
    let Topography::Map(map, _) = asphera_formats::read(name, &bytes).unwrap() else {
        panic!("{name} holds no map");
    };
    let heights: Vec<f64> = map.z_mm.iter().map(|z| z * 1e6).collect();
    Some(Grid::new(&heights, map.ny, map.nx, [map.dx_mm, map.dy_mm]).unwrap())
}

fn near(found: f64, expected: f64, share: f64) {
    eprintln!("{found}, expected {expected}");
    assert!((found / expected - 1.0).abs() < share, "{found} {expected}");
}

/// SurfaceTopography 1.27.1, test/IO/test_metropro.py.
#[test]
fn sq_of_an_interferogram() {
    let Some(grid) = map("metropro-1.dat") else { return };
    let found = height_parameters((&grid.levelled(Datum::Mean)).into()).unwrap();
    near(found.sq_nm, 75.288_222_047_345_89, 1e-9);
}

/// SurfaceTopography 1.27.1, test/IO/test_x3p.py. Its gradient is of one triangle a cell.
#[test]
fn sq_and_gradient_of_an_x3p_file() {
    let Some(grid) = map("x3p-2.x3p") else { return };
    let found = height_parameters((&grid.levelled(Datum::Mean)).into()).unwrap();
    near(found.sq_nm, 77.280_332_735_978_76, 1e-9);
    let hybrid = hybrid_parameters((&grid).into()).unwrap();
    near(hybrid.sdq_urad, 62_070.073_998_443_28, 2e-4);
}

#[test]
fn roughness_of_an_interferogram_by_either_filter() {
    let Some(grid) = map("metropro-1.dat") else { return };
    let cut_off = Gaussian::new(0.08, Order::Two).unwrap();
    let rough = |filter| {
        let scale = Scale::new(None, Some(filter)).unwrap();
        let limited = scale.of_grid(&grid, Datum::MeanPlane);
        let report = limited.l.as_ref().unwrap().robust;
        (height_parameters((&limited.surface).into()).unwrap(), report)
    };
    let (linear, _) = rough(cut_off);
    let (robust, report) = rough(cut_off.robust(Robust::default()));
    eprintln!("{linear:?} {robust:?} {report:?}");
    assert!(report.unwrap().converged);
    assert!(linear.sq_nm > 0.0 && linear.sq_nm < 4.0 && robust.sq_nm >= linear.sq_nm);
}
