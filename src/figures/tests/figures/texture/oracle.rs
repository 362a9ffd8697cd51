//! Texture against surfalize, SurfaceTopography and SciPy: `tests/texture.py` makes `tests/texture.txt`.

use std::f64::consts::TAU;

use asphera_figures::texture::{
    Datum, Gaussian, Grid, Mesh, Order, Robust, Threshold, core_parameters, height_parameters,
    hybrid_parameters, spatial_parameters,
};

use super::{lattice, weyl};

const TABLE: &str = include_str!("../../texture.txt");
const ROWS: u32 = 120;
const COLUMNS: u32 = 150;
const SPACING_MM: [f64; 2] = [0.0025, 0.002];
const CUTOFF_MM: f64 = 0.03;
const STEP: usize = 97;

/// The numbers of the line that begins with `name`.
fn expected(name: &str) -> Vec<f64> {
    let line = TABLE.lines().find(|line| line.split(' ').next() == Some(name)).unwrap();
    line.split(' ').skip(1).map(|number| number.parse().unwrap()).collect()
}

/// Each number within a share of the expected one, or of the largest of the line.
fn compare(name: &str, found: &[f64], share: f64, each: bool) {
    let expected = expected(name);
    assert_eq!(found.len(), expected.len(), "{name}");
    let size = expected.iter().fold(0.0, |size: f64, value| size.max(value.abs()));
    let off = found.iter().zip(&expected).map(|(found, expected)| {
        (found - expected).abs() / if each { expected.abs() } else { size }
    });
    let off = off.fold(0.0, f64::max);
    eprintln!("{name}: off by {off:.1e}");
    assert!(off < share, "{name}: {found:?} {expected:?}");
}

/// `height` of texture.py.
fn height_nm(x: f64, y: f64) -> f64 {
    let waves = (1..=40).map(|k| {
        let fx = 16.0 * weyl(k, 0.8191725133961645);
        let fy = 44.0 * weyl(k, 0.6710436067037893) - 22.0;
        12.0 * (TAU * (fx * x + fy * y + weyl(k * k, 0.5497004779019703))).cos()
    });
    let z: f64 = waves.sum();
    z - 0.003 * z * z
}

/// `grid` of texture.py; what `gap` says of a node, counted from 1, is not measured.
fn grid(outlier_nm: f64, gap: impl Fn(u32) -> bool) -> Grid {
    let heights: Vec<f64> = (0..ROWS * COLUMNS)
        .map(|n| {
            if gap(n + 1) {
                return f64::NAN;
            }
            let x = f64::from(n % COLUMNS) * SPACING_MM[0];
            let y = f64::from(n / COLUMNS) * SPACING_MM[1];
            let noise = 6.0 * weyl(n + 1, 0.324_717_957_244_746);
            let high = if weyl(n + 1, 0.4301597090019467) < 0.04 { outlier_nm } else { 0.0 };
            height_nm(x, y) + noise + high
        })
        .collect();
    Grid::new(&heights, ROWS as usize, COLUMNS as usize, SPACING_MM).unwrap()
}

fn quarter(n: u32) -> bool {
    weyl(n, 0.7548776662466927) < 0.25
}

fn sampled(grid: &Grid) -> Vec<f64> {
    grid.heights_nm().step_by(STEP).flatten().collect()
}

#[test]
fn heights_agree_with_surfalize_and_surfacetopography() {
    let flat = grid(0.0, |_| false).levelled(Datum::MeanPlane);
    let heights = height_parameters((&flat).into()).unwrap();
    let numbers = [heights.sa_nm, heights.sq_nm, heights.sp_nm, heights.sv_nm, heights.sz_nm];
    let shape = [heights.ssk.unwrap(), heights.sku.unwrap()];
    compare("heights", &[&numbers[..], &shape].concat(), 1e-12, true);
}

/// Sdq differs by stencil: surfalize averages each edge once, so that those of the border weigh twice;
/// SurfaceTopography takes one of the four triangles of a cell.
#[test]
fn slopes_agree_with_surfalize_and_surfacetopography() {
    let flat = grid(0.0, |_| false).levelled(Datum::MeanPlane);
    let sq_nm = height_parameters((&flat).into()).unwrap().sq_nm;
    let hybrid = hybrid_parameters((&flat).into()).unwrap();
    compare("sdq_cells", &[hybrid.sdq_urad], 1e-12, true);
    compare("sdq", &[hybrid.sdq_urad], 1e-3, true);
    compare("topography", &[sq_nm, hybrid.sdq_urad], 1e-3, true);
    assert_eq!((hybrid.triangles, hybrid.support.measured), (4 * 119 * 149, 1.0));
    let heights: Vec<f64> = flat.heights_nm().map(|z| z.unwrap() * 1e3).collect();
    let high = Grid::new(&heights, ROWS as usize, COLUMNS as usize, SPACING_MM).unwrap();
    compare("sdr", &[hybrid_parameters((&high).into()).unwrap().sdr_percent], 1e-12, true);
}

/// surfalize samples the curve at quantiles and takes ratios between nodes.
#[test]
fn core_agrees_with_surfalize() {
    let flat = grid(0.0, |_| false).levelled(Datum::MeanPlane);
    let core = core_parameters((&flat).into()).unwrap();
    let numbers = [core.sk_nm, core.spk_nm, core.svk_nm, core.smrk1_percent, core.smrk2_percent];
    compare("core", &numbers, 1e-3, true);
}

/// surfalize looks along rays to nodes only.
#[test]
fn autocorrelation_lengths_agree_with_surfalize() {
    let flat = grid(0.0, |_| false).levelled(Datum::MeanPlane);
    let found = spatial_parameters((&flat).into(), Threshold::DEFAULT).unwrap();
    compare("spatial", &[found.sal_um(), found.str_ratio().unwrap()], 1e-2, true);
}

#[test]
fn filters_agree_with_scipy() {
    let zero = Gaussian::new(CUTOFF_MM, Order::Zero).unwrap();
    compare("order0", &sampled(&zero.of_grid(&grid(0.0, |_| false)).surface), 1e-12, false);
    let holed = grid(0.0, quarter);
    compare("order0_gaps", &sampled(&zero.of_grid(&holed).surface), 1e-12, false);
    let two = Gaussian::new(CUTOFF_MM, Order::Two).unwrap().of_grid(&holed);
    assert_eq!((two.lowered, two.undetermined), (0, 0));
    compare("order2_gaps", &sampled(&two.surface), 1e-11, false);
    let robust = zero.robust(Robust::new(1e-9, 6).unwrap()).of_grid(&grid(900.0, quarter));
    let report = robust.robust.unwrap();
    assert!(report.iterations == 6 && !report.converged && report.outliers > 500);
    let numbers = [vec![report.limit_nm], sampled(&robust.surface)].concat();
    compare("robust", &numbers, 1e-11, false);
}

/// The mesh of texture.py.
fn moved_lattice() -> Mesh {
    let points: Vec<[f64; 3]> = (0..30 * 40)
        .map(|n| {
            let x = 0.01 * (f64::from(n % 40) + 0.6 * weyl(n + 1, 0.8191725133961645));
            let y = 0.01 * (f64::from(n / 40) + 0.6 * weyl(n + 1, 0.6710436067037893));
            [x, y, if n % 7 == 3 { f64::NAN } else { height_nm(x, y) * 1e-6 }]
        })
        .collect();
    Mesh::new(&points, &lattice(30, 40)).unwrap()
}

#[test]
fn a_mesh_with_gaps_agrees_with_numpy() {
    let mesh = moved_lattice();
    let heights = height_parameters((&mesh.levelled(Datum::Mean)).into()).unwrap();
    let numbers = [heights.sa_nm, heights.sq_nm, heights.support.measured];
    compare("mesh_heights", &numbers, 1e-10, true);
    let hybrid = hybrid_parameters((&mesh).into()).unwrap();
    compare("mesh_hybrid", &[hybrid.sdq_urad, hybrid.sdr_percent], 1e-9, true);
    let sampled = |mesh: &Mesh| mesh.heights_nm().step_by(11).flatten().collect::<Vec<f64>>();
    for (name, order) in [("mesh_order0", Order::Zero), ("mesh_order2", Order::Two)] {
        let filtered = Gaussian::new(0.05, order).unwrap().of_mesh(&mesh);
        assert_eq!((filtered.lowered, filtered.undetermined), (0, 0));
        compare(name, &sampled(&filtered.surface), 1e-10, false);
    }
}

/// The table is what the script prints today.
#[test]
fn table_is_made_by_the_script() {
    let script = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/texture.py");
    let Some(python) = std::env::var_os("ASPHERA_PYTHON") else {
        eprintln!("skipped: ASPHERA_PYTHON not set");
        return;
    };
    let packages = "import scipy, surfalize, SurfaceTopography";
    let has = std::process::Command::new(&python).args(["-c", packages]).output();
    if !has.is_ok_and(|output| output.status.success()) {
        eprintln!("skipped: python packages scipy, surfalize and SurfaceTopography not found");
        return;
    }
    let output = std::process::Command::new(&python).arg(script).output().unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let printed = String::from_utf8(output.stdout).unwrap();
    assert_eq!(printed.lines().count(), TABLE.lines().count());
    for line in printed.lines() {
        let (name, numbers) = line.split_once(' ').unwrap();
        let numbers: Vec<f64> = numbers.split(' ').map(|number| number.parse().unwrap()).collect();
        compare(name, &numbers, 1e-9, false);
    }
}
