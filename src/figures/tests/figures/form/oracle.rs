//! Figures against NumPy and prysm: `tests/figures.py` makes `tests/figures.txt`.

use std::num::{NonZeroU8, NonZeroU16};
use std::process::Command;

use asphera_figures::{
    Approximation, FringeCount, HeightGrid, Reference, Sample, Share, SlopeSettings, Term, Window,
    decompose, fringe_fit, map_psd, peak_to_valley, pvr, q_spectrum, remove, rms,
    robust_peak_to_valley, slopes,
};
use asphera_form::Aperture;

const TABLE: &str = include_str!("../../figures.txt");
const RADIUS_MM: f64 = 2.0;

/// The numbers of the line that begins with `name`.
fn expected(name: &str) -> Vec<f64> {
    let line = TABLE.lines().find(|line| line.split(' ').next() == Some(name)).unwrap();
    line.split(' ').skip(1).map(|number| number.parse().unwrap()).collect()
}

fn compare(name: &str, found: &[f64]) {
    let expected = expected(name);
    assert_eq!(found.len(), expected.len(), "{name}");
    let size = expected.iter().fold(0.0, |size: f64, value| size.max(value.abs()));
    let off = found.iter().zip(&expected).map(|(found, expected)| (found - expected).abs());
    let off = off.fold(0.0, f64::max) / size;
    eprintln!("{name}: off by {off:.1e} of the largest of {}", expected.len());
    assert!(off < 1e-11, "{name}: {found:?} {expected:?}");
}

/// `height` of figures.py.
fn height_nm(x: f64, y: f64) -> f64 {
    let square = x * x + y * y;
    80.0 * (1.3 * x + 0.5 * y).sin() + 40.0 * x * y * (-0.3 * square).exp() + 30.0 * square
}

/// `sample` of figures.py.
fn sample(weighted: bool) -> Sample {
    let weyl = |i: u32, f: f64| (f64::from(i) * f).fract();
    let (mut places, mut deviations, mut areas) = (Vec::new(), Vec::new(), Vec::new());
    for i in 1..=3000 {
        let r = RADIUS_MM * weyl(i, 0.8191725133961645).sqrt();
        let phi = 2.0 * std::f64::consts::PI * weyl(i, 0.6710436067037893);
        let w = 2.0 * weyl(i, 0.5497004779019703) - 1.0;
        let (x, y) = (r * phi.cos(), r * phi.sin());
        places.push([x, y]);
        deviations.push((height_nm(x, y) + 5.0 * w) * 1e-6);
        areas.push(1.0 + weyl(i, 0.324_717_957_244_746));
    }
    let areas = weighted.then_some(&areas[..]);
    let disc = Aperture::Circle { radius_mm: RADIUS_MM };
    Sample::new(&places, &deviations, areas, &disc).unwrap()
}

#[test]
fn amplitudes_agree_with_numpy() {
    let sample = sample(true);
    let about = |reference| rms(&sample, reference).unwrap().value;
    compare("rms", &[about(Reference::Zero), about(Reference::Mean)]);
    compare("robust", &[robust_peak_to_valley(&sample, Share::NINETY_NINE).unwrap().value]);
}

#[test]
fn fringe_fit_and_pvr_agree_with_prysm() {
    let fit = fringe_fit(&sample(true), FringeCount::ThirtySeven).unwrap();
    let found: Vec<f64> = fit.coefficients_nm.iter().map(|value| value.unwrap()).collect();
    compare("fringe", &found);
    let equal = sample(false);
    compare("pvr36", &[pvr(&equal, FringeCount::ThirtySix).unwrap().value]);
    compare("pvr37", &[pvr(&equal, FringeCount::ThirtySeven).unwrap().value]);
}

#[test]
fn removal_and_decomposition_agree_with_numpy() {
    let sample = sample(true);
    let removed = remove(&sample, &[Term::Piston, Term::Tilt, Term::Coma]).unwrap().sample;
    let left = [peak_to_valley(&removed), rms(&removed, Reference::Zero)];
    compare("removed", &left.map(|figure| figure.unwrap().value));
    let sphere = Approximation::sphere(3.0).unwrap();
    for (name, approximation) in [("quadratic", Approximation::Quadratic), ("sphere", sphere)] {
        let found = decompose(&sample, approximation, NonZeroU16::new(10)).unwrap();
        compare(name, &found.figures().map(|figure| figure.value));
    }
    let found = q_spectrum(&sample, NonZeroU8::new(6).unwrap(), None).unwrap();
    compare("qbfs", &[&[found.power_nm], &found.coefficients_nm[..]].concat());
}

#[test]
fn slopes_agree_with_planes_by_brute_force() {
    let found = slopes(&sample(true), SlopeSettings::new(0.5, 0.25).unwrap()).unwrap();
    let counts = [found.stations as f64, found.unmeasured as f64];
    let figures = found.figures().map(|figure| figure.value);
    compare("slopes", &[&figures[..], &counts].concat());
}

#[test]
fn density_of_a_map_agrees_with_prysm() {
    let heights: Vec<f64> =
        (0..90).map(|i| height_nm(0.25 * f64::from(i % 10), 0.25 * f64::from(i / 10))).collect();
    let grid = HeightGrid::new(&heights, 9, 10, [0.25; 2]).unwrap();
    compare("psd", &map_psd(&grid, Window::None).unwrap().density_nm2_mm2);
    compare("psd_hann", &map_psd(&grid, Window::Hann).unwrap().density_nm2_mm2);
}

/// The table is what the script prints today.
#[test]
fn table_is_made_by_the_script() {
    let script = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/figures.py");
    let Some(python) = std::env::var_os("ASPHERA_PYTHON") else {
        eprintln!("skipped: ASPHERA_PYTHON not set");
        return;
    };
    let has = Command::new(&python).args(["-c", "import prysm, scipy"]).output();
    if !has.is_ok_and(|output| output.status.success()) {
        eprintln!("skipped: python packages prysm and scipy not found");
        return;
    }
    let output = Command::new(&python).arg(script).output().unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let printed = String::from_utf8(output.stdout).unwrap();
    assert_eq!(printed.lines().count(), TABLE.lines().count());
    for line in printed.lines() {
        let (name, numbers) = line.split_once(' ').unwrap();
        let numbers: Vec<f64> = numbers.split(' ').map(|number| number.parse().unwrap()).collect();
        compare(name, &numbers);
    }
}
