//! The running estimator against the full fit.

use asphera_form::artefact::Artefact;
use asphera_form::zernike::FormError;
use asphera_form::{
    Aperture, Figures, FitSettings, Grid, Live, LiveEstimate, LiveSettings,
    PointMm, Pose, deviations, fit,
};
use crate::common::{Noise, al1815, misaligned, spiral};

const GRID: Grid =
    Grid { x_min_mm: -9.0, x_max_mm: 9.0, y_min_mm: -9.0, y_max_mm: 9.0, nx: 96, ny: 96 };

fn settings(fit: FitSettings) -> LiveSettings {
    LiveSettings { fit, grid: GRID }
}

/// A lens with 200 nm of form error and 2 nm of noise, scanned along `sample`.
fn lens(sample: &[[f64; 2]]) -> Vec<PointMm> {
    let error = FormError::typical(9.0);
    let error_mm = move |x: f64, y: f64| error.height_nm(x, y) * 1e-6;
    let artefact = Artefact::new(al1815(), misaligned(), &[], sample, error_mm).unwrap();
    let mut noise = Noise::new(11);
    sample
        .iter()
        .map(|&[x, y]| {
            let [x, y, z] = artefact.point_mm(x, y).unwrap();
            [x, y, z + 2e-6 * noise.next()]
        })
        .collect()
}

/// Boustrophedon lines over the disc.
fn raster(count: usize, radius: f64) -> Vec<[f64; 2]> {
    let pitch = (std::f64::consts::PI * radius * radius / count as f64).sqrt();
    let lines = (2.0 * radius / pitch) as i32;
    let mut places = Vec::new();
    for line in 0..lines {
        let y = -radius + (f64::from(line) + 0.5) * pitch;
        let row = (0..lines).map(|column| -radius + (f64::from(column) + 0.5) * pitch);
        let mut row: Vec<[f64; 2]> = row.map(|x| [x, y]).filter(|p| p[0].hypot(p[1]) <= radius).collect();
        if line % 2 == 1 {
            row.reverse();
        }
        places.append(&mut row);
    }
    places
}

fn pose_difference(a: &Pose, b: &Pose) -> f64 {
    let difference = [
        a.tx_mm - b.tx_mm,
        a.ty_mm - b.ty_mm,
        a.tz_mm - b.tz_mm,
        a.rx_rad - b.rx_rad,
        a.ry_rad - b.ry_rad,
    ];
    difference.iter().fold(0.0, |largest, value| largest.max(value.abs()))
}

fn compare(points: &[PointMm], live: &LiveEstimate, name: &str, pose: f64, rms: f64, pv: f64) {
    let full = fit(points, &al1815(), &FitSettings::default()).unwrap();
    let found = deviations(points, &full.nominal, &full.pose);
    let figures = Figures::new(points, &found, &full.pose, &Aperture::None).unwrap();
    let off = (
        pose_difference(&live.pose, &full.pose),
        (live.figures.rms_nm - figures.rms_nm).abs(),
        (live.figures.pv_nm - figures.pv_nm).abs(),
    );
    eprintln!(
        "{name}: reference at {}, pose off by {:e}, rms by {:e} nm, pv by {:e} nm of {}",
        live.reference_count, off.0, off.1, off.2, figures.pv_nm
    );
    assert!(off.0 <= pose && off.1 <= rms && off.2 <= pv, "{name}: {off:?}");
    assert_eq!(live.count, full.used);
    for (live, full) in live.estimates.iter().zip(&full.estimates) {
        assert_eq!(live.parameter, full.parameter);
        let (live, full) = (live.u.unwrap(), full.u.unwrap());
        assert!((live / full - 1.0).abs() < 1e-2, "{live} {full}");
    }
}

#[test]
fn after_100_000_points_of_a_lens_it_agrees_with_the_full_fit() {
    let mut outwards = spiral(100_000, 9.0);
    let inwards: Vec<[f64; 2]> = outwards.iter().rev().copied().collect();
    let scans = [("inwards", inwards), ("raster", raster(100_000, 9.0))];
    outwards.truncate(100_000);
    for (name, sample) in [("outwards", outwards)].into_iter().chain(scans) {
        let points = lens(&sample);
        let mut live = Live::new(al1815(), settings(FitSettings::default())).unwrap();
        points.iter().for_each(|&point| live.push(point));
        compare(&points, &live.estimate().unwrap(), name, 1e-9, 0.01, 1.0);
        live.settle();
        compare(&points, &live.estimate().unwrap(), name, 1e-11, 1e-6, 1e-5);
    }
}
