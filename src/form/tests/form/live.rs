//! The running estimator against the full fit.

use crate::common::{Noise, al1815, misaligned, pose_difference, raster, spiral};
use crate::shapes::biconic;
use asphera_form::artefact::Artefact;
use asphera_form::form_error::FormError;
use asphera_form::{
    Accumulator, Aperture, Figures, FitError, FitSettings, Grid, Live, LiveError, LiveEstimate,
    LiveSettings, Nominal, Parameter, PointMm, Pose, ZoneSettings, deviations, fit, minimum_zone,
};

const GRID: Grid =
    Grid { x_min_mm: -9.0, x_max_mm: 9.0, y_min_mm: -9.0, y_max_mm: 9.0, nx: 96, ny: 96 };

pub(crate) fn settings(fit: FitSettings) -> LiveSettings {
    LiveSettings::new(fit, GRID)
}

/// A lens with 200 nm of form error and 2 nm of noise, scanned along `sample`.
pub(crate) fn lens(sample: &[[f64; 2]]) -> Vec<PointMm> {
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

pub(crate) fn compare(
    points: &[PointMm],
    live: &LiveEstimate,
    name: &str,
    pose: f64,
    rms: f64,
    pv: f64,
) {
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

#[test]
fn every_estimate_on_the_way_is_near_the_full_fit_of_the_same_points() {
    let sample = raster(6_000, 9.0);
    let points = lens(&sample);
    let mut live = Live::new(al1815(), settings(FitSettings::default())).unwrap();
    for (index, &point) in points.iter().enumerate() {
        live.push(point);
        // Not the first lines: on a narrow strip tilt and shift cannot be told apart.
        if index > 3_000 && index % 1_000 == 0 {
            compare(&points[..=index], &live.estimate().unwrap(), "raster", 1e-7, 0.01, 1.0);
        }
    }
}

#[test]
fn map_holds_the_mean_deviation_and_gaps() {
    let grid = Grid { x_min_mm: 0.0, x_max_mm: 4.0, y_min_mm: 0.0, y_max_mm: 3.0, nx: 4, ny: 3 };
    let fit = FitSettings { free: vec![Parameter::Tz], ..FitSettings::default() };
    let mut live = Live::new(Nominal::Plane, LiveSettings::new(fit, grid)).unwrap();
    // Two points in each cell, 1 nm and 3 nm above a level of 1 mm, but none in the cell (2, 1); the far
    // point outside the grid is 10 nm below.
    for i in 0..24 {
        let (column, row) = (f64::from(i % 4), f64::from(i / 4 % 3));
        if (column, row) != (2.0, 1.0) {
            let height = if i < 12 { 1e-6 } else { 3e-6 };
            live.push([column + 0.5, row + 0.5, 1.0 + height]);
        }
    }
    live.push([10.0, 0.0, 1.0 - 1e-5]);
    let estimate = live.estimate().unwrap();
    let mean = (11.0 + 33.0 - 10.0) / 23.0;
    assert!((estimate.pose.tz_mm - 1.0 - mean * 1e-6).abs() < 1e-14);
    assert_eq!((estimate.count, estimate.map.mean_nm.len()), (23, 12));
    for (cell, value) in estimate.map.mean_nm.iter().enumerate() {
        if cell == 6 {
            assert!(value.is_nan());
        } else {
            assert!((value - (2.0 - mean)).abs() < 1e-8, "{cell}: {value}");
        }
        let centroid_mm = estimate.map.centroids_mm[cell];
        if cell == 6 {
            assert_eq!(estimate.map.counts[cell], 0);
            assert!(centroid_mm[0].is_nan() && centroid_mm[1].is_nan());
        } else {
            assert_eq!(estimate.map.counts[cell], 2);
            assert_eq!(centroid_mm, [(cell % 4) as f64 + 0.5, (cell / 4) as f64 + 0.5]);
        }
    }
    assert!((estimate.figures.pv_nm - 13.0).abs() < 1e-8);
    assert_eq!(estimate.figures.at_min_mm[..2], [10.0, 0.0]);
    assert_eq!(estimate.figures.at_max_mm[..2], [0.5, 0.5]);
}

#[test]
fn nothing_is_said_before_a_fit_is_possible() {
    let mut live = Live::new(Nominal::Plane, settings(FitSettings::default())).unwrap();
    assert_eq!((live.estimate(), live.failure(), live.taken()), (None, None, 0));
    (0..20).for_each(|_| live.push([f64::NAN; 3]));
    assert_eq!(live.estimate(), None);
    assert_eq!(live.failure(), Some(&FitError::NoPoints { given: 16 }));
    for i in 0..20 {
        live.push([f64::from(i % 5), f64::from(i / 5), 1.0]);
    }
    let estimate = live.estimate().unwrap();
    assert_eq!((live.failure(), live.taken()), (None, 40));
    assert_eq!((estimate.count, estimate.excluded.not_finite), (20, 20));
    assert_eq!(estimate.indeterminate, [Parameter::Tx, Parameter::Ty]);
    assert!((estimate.pose.tz_mm - 1.0).abs() < 1e-14);
}

#[test]
fn impossible_grids_are_refused() {
    let bad = [
        Grid { nx: 0, ..GRID },
        Grid { ny: 1025, ..GRID },
        Grid { x_max_mm: -9.0, ..GRID },
        Grid { y_min_mm: f64::NAN, ..GRID },
    ];
    for grid in bad {
        let settings = LiveSettings::new(FitSettings::default(), grid);
        assert!(matches!(Live::new(Nominal::Plane, settings), Err(LiveError::Grid(_))));
    }
}

/// From the first millimetre of a spiral tilt and shift cannot be told apart.
#[test]
fn a_small_patch_makes_no_wild_pose() {
    let points = lens(&spiral(100_000, 9.0));
    let mut live = Live::new(al1815(), settings(FitSettings::default())).unwrap();
    for (index, &point) in points[..10_000].iter().enumerate() {
        live.push(point);
        if index > 16 && index % 97 == 0 {
            let estimate = live.estimate().unwrap();
            let off = pose_difference(&estimate.pose, &misaligned());
            assert!(off < 0.05, "{index}: {:?}", estimate.pose);
            assert!(estimate.figures.pv_nm < 200.0 && estimate.figures.rms_nm < 40.0);
            assert_eq!(estimate.count, index + 1);
        }
    }
    // With every tilt admitted the figures still hold, because no step may make the sum larger.
    let reckless = LiveSettings { rank_tolerance: 0.0, ..settings(FitSettings::default()) };
    let mut live = Live::new(al1815(), reckless).unwrap();
    for (index, &point) in points[..2_000].iter().enumerate() {
        live.push(point);
        if index > 16 && index % 97 == 0 {
            let figures = live.estimate().unwrap().figures;
            assert!(figures.rms_nm < 400.0, "{index}: {figures:?}");
        }
    }
}

/// A lens and a freeform, all parameters of the latter free, in parts of any size: the figures are those of one
/// accumulator.
#[test]
fn merged_parts_are_the_whole() {
    let every = biconic().parameters().into_iter().map(|(parameter, _)| parameter).collect();
    let turned = Pose { rz_rad: 0.1, ..misaligned() };
    for (nominal, free, pose) in
        [(al1815(), Parameter::RIGID.to_vec(), misaligned()), (biconic(), every, turned)]
    {
        let sample = spiral(6_000, 8.5);
        let error_mm = |x: f64, y: f64| 2e-4 * (0.7 * x).sin() * (0.4 * y).cos();
        let artefact = Artefact::new(nominal.clone(), pose, &[], &sample, error_mm).unwrap();
        let points: Vec<PointMm> =
            sample.iter().map(|&[x, y]| artefact.point_mm(x, y).unwrap()).collect();
        let settings = settings(FitSettings { free, ..FitSettings::default() });
        // A reference from the first points, so that the estimate has a way to go.
        let reference = fit(&points[..1_500], &nominal, &settings.fit).unwrap();
        let empty = Accumulator::new(reference, settings.clone()).unwrap();
        let over = |points: &[PointMm]| {
            let mut accumulator = empty.clone();
            points.iter().for_each(|&point| accumulator.push(point));
            accumulator
        };
        let whole = over(&points).estimate().unwrap();
        for part in [7, 1_300, 3_000, 6_000] {
            let mut merged = empty.clone();
            points.chunks(part).for_each(|points| merged.merge(over(points)).unwrap());
            let merged = merged.estimate().unwrap();
            assert_eq!((merged.count, merged.excluded), (whole.count, whole.excluded));
            let pose_off = pose_difference(&merged.pose, &whole.pose);
            let rms_off_nm = (merged.figures.rms_nm - whole.figures.rms_nm).abs();
            let pv_off_nm = (merged.figures.pv_nm - whole.figures.pv_nm).abs();
            eprintln!(
                "{} in parts of {part}: pose off by {pose_off:.1e}, rms by {rms_off_nm:.1e} nm, pv by {pv_off_nm:.1e} nm",
                nominal.kind()
            );
            assert!(pose_off < 1e-12 && rms_off_nm < 1e-8 && pv_off_nm < 1e-8);
            for (merged, whole) in merged.map.mean_nm.iter().zip(&whole.map.mean_nm) {
                assert!((merged - whole).abs() < 1e-8 || (merged.is_nan() && whole.is_nan()));
            }
            for (merged, whole) in merged.estimates.iter().zip(&whole.estimates) {
                let off = (merged.value - whole.value).abs();
                assert!(off < 1e-4 * whole.u.unwrap(), "{merged:?} {whole:?}");
            }
        }
    }
}

#[test]
fn merged_estimators_settle_on_the_fit_of_all_points() {
    let points = lens(&spiral(5_000, 9.0));
    let over = |points: &[PointMm]| {
        let mut live = Live::new(al1815(), settings(FitSettings::default())).unwrap();
        points.iter().for_each(|&point| live.push(point));
        live
    };
    let (mut some, mut all) = (over(&points[..3_000]), over(&points));
    some.merge(over(&points[3_000..4_000])).unwrap();
    // Neither of these makes a new reference: the first 3,000 points made one at 2,048.
    let on_the_way = some.estimate().unwrap();
    assert_eq!((on_the_way.count, on_the_way.reference_count), (4_000, 2_048));
    let pushed = over(&points[..4_000]).estimate().unwrap();
    assert!(pose_difference(&on_the_way.pose, &pushed.pose) < 1e-13);
    // The number of points has doubled: a new reference.
    some.merge(over(&points[4_000..])).unwrap();
    assert_eq!((some.taken(), some.estimate().unwrap().reference_count), (5_000, 5_000));
    some.settle();
    all.settle();
    let (some, all) = (some.estimate().unwrap(), all.estimate().unwrap());
    assert_eq!(some.pose, all.pose);
    assert!((some.figures.rms_nm - all.figures.rms_nm).abs() < 1e-9);

    let mut empty = over(&[]);
    empty.merge(over(&points[..40])).unwrap();
    assert_eq!(empty.estimate().unwrap().count, 40);
}

#[test]
fn what_differs_is_not_merged() {
    let points = lens(&spiral(300, 9.0));
    let of = |nominal: Nominal, fit| Live::new(nominal, settings(fit)).unwrap();
    let mut live = of(al1815(), FitSettings::default());
    let other = of(Nominal::Plane, FitSettings::default());
    assert_eq!(live.merge(other), Err(LiveError::Different { what: "nominal" }));
    let other = of(al1815(), FitSettings { search: false, ..FitSettings::default() });
    assert_eq!(live.merge(other), Err(LiveError::Different { what: "settings" }));
    let accumulator = |count: usize, fitting: FitSettings| {
        let reference = fit(&points[..count], &al1815(), &fitting).unwrap();
        Accumulator::new(reference, settings(fitting)).unwrap()
    };
    let mut one = accumulator(200, FitSettings::default());
    let other = accumulator(300, FitSettings::default());
    assert_eq!(one.merge(other), Err(LiveError::Different { what: "reference" }));
    let other = accumulator(200, FitSettings { max_iterations: 9, ..FitSettings::default() });
    assert_eq!(one.merge(other), Err(LiveError::Different { what: "settings" }));
    assert_eq!(one.estimate(), None);
}

/// What the cells tell of the size of the deviation is what the whole has, and the extremes of their blocks hold a zone
/// no wider than all.
#[test]
fn mean_squares_and_extremes_of_cells_are_those_of_the_points() {
    let points = lens(&raster(20_000, 8.9));
    let mut live = Live::new(al1815(), settings(FitSettings::default())).unwrap();
    points[..15_000].iter().for_each(|&point| live.push(point));
    let found = live.estimate().unwrap();
    assert!(found.is_complete(), "{:?}", found.undetermined);
    let cells =
        found.mean_squares_nm2.iter().zip(&found.map.counts).filter(|(_, count)| **count > 0);
    let square: f64 = cells.map(|(square, count)| square * *count as f64).sum();
    let rms_nm = (square / found.count as f64).sqrt();
    assert!((rms_nm / found.figures.rms_nm - 1.0).abs() < 1e-3, "{rms_nm} {:?}", found.figures);
    let extremes = live.extremes(8);
    assert!((100..=288).contains(&extremes.len()), "{}", extremes.len());
    let zone = ZoneSettings {
        fit: FitSettings { start: found.pose, search: false, ..FitSettings::default() },
        tolerance: 1e-4,
        ..ZoneSettings::default()
    };
    let zone_nm = 1e6 * minimum_zone(&extremes, &al1815(), &zone).unwrap().certificate.lower_mm;
    assert!(zone_nm <= found.figures.pv_nm, "{zone_nm} {:?}", found.figures);
    assert!(zone_nm > 0.7 * found.figures.pv_nm, "{zone_nm} {:?}", found.figures);
}
