//! Running references made from the points against references made anew from the same points.

use std::f64::consts::TAU;

use asphera_form::{
    Aperture, Base, Figures, Grid, Knots, LiveError, LiveEstimate, LiveReference, PointMm,
    Reference, ReferenceError, ReferenceSettings, Smoothing, deviations, reference,
};
use proptest::prelude::*;

use crate::common::{Noise, spiral};

const GRID: Grid =
    Grid { x_min_mm: -9.0, x_max_mm: 9.0, y_min_mm: -9.0, y_max_mm: 9.0, nx: 96, ny: 96 };
const SIGMA_MM: f64 = 2e-5;

fn settings() -> ReferenceSettings {
    ReferenceSettings {
        aperture: Aperture::Circle { radius_mm: 8.5 },
        centre_mm: Some([0.0; 2]),
        ..ReferenceSettings::default()
    }
}

/// A sphere of 30 mm with a wave of 300 nm and 6 mm across it, 20 nm of noise, and a dent of 400 nm the knots pass over.
fn surface(places: &[[f64; 2]], seed: u64) -> Vec<PointMm> {
    waving(places, 6.0, SIGMA_MM, seed)
}

/// The same with waves of another length, and other noise.
fn waving(places: &[[f64; 2]], length_mm: f64, sigma_mm: f64, seed: u64) -> Vec<PointMm> {
    let mut noise = Noise::new(seed);
    let point = |&[x, y]: &[f64; 2]| {
        let rr = x * x + y * y;
        let sphere = rr / (30.0 + (900.0 - rr).sqrt());
        let wave = 3e-4 * (TAU * (x + 0.4 * y) / length_mm).cos();
        let dent = -4e-4 * (-((x - 3.0).powi(2) + (y + 2.0).powi(2)) / 0.01).exp();
        [x, y, sphere + wave + dent + sigma_mm * 3_f64.sqrt() * noise.next()]
    };
    places.iter().map(point).collect()
}

/// Lines there and back over the disc, from the smallest y upwards.
fn raster(count: usize, radius_mm: f64) -> Vec<[f64; 2]> {
    let pitch = (std::f64::consts::PI * radius_mm * radius_mm / count as f64).sqrt();
    let lines = (2.0 * radius_mm / pitch) as usize;
    let at = |k: usize| -radius_mm + (k as f64 + 0.5) * pitch;
    let place = |i: usize| {
        let (line, column) = (i / lines, i % lines);
        [at(if line % 2 == 0 { column } else { lines - 1 - column }), at(line)]
    };
    (0..lines * lines).map(place).filter(|p| p[0].hypot(p[1]) <= radius_mm).collect()
}

fn over(points: &[PointMm]) -> LiveReference {
    let mut live = LiveReference::new(settings(), GRID).unwrap();
    points.iter().for_each(|&point| live.push(point));
    live
}

/// How far an estimate lies from a reference: RMS and PV as shares, and the root mean square difference of the mean
/// deviations of the cells of the map in nm.
fn off(found: &LiveEstimate, full: &Reference, points: &[PointMm]) -> [f64; 3] {
    let all = deviations(points, &full.fit.nominal, &full.fit.pose);
    let aperture = settings().aperture;
    let figures = Figures::new(points, &all, &full.fit.pose, &aperture).unwrap();
    assert_eq!((found.count, figures.count), (full.fit.used, full.fit.used));
    let mut means = vec![(0.0, 0.0); 96 * 96];
    for (point, deviation_mm) in points.iter().zip(&all).filter(|(_, mm)| mm.is_finite()) {
        let [x, y, _] = full.fit.pose.to_part(*point);
        let [i, j] = [x, y].map(|place| ((place + 9.0) / 18.0 * 96.0) as usize);
        means[j * 96 + i].0 += 1.0;
        means[j * 96 + i].1 += 1e6 * deviation_mm;
    }
    let both = found.map.mean_nm.iter().zip(&means).filter(|(nm, (n, _))| !nm.is_nan() && *n > 0.0);
    let (count, square) = both.fold((0.0, 0.0), |(count, square), (nm, (n, sum))| {
        (count + 1.0, square + (nm - sum / n).powi(2))
    });
    assert!(count > 10.0);
    let rms = found.figures.rms_nm / figures.rms_nm - 1.0;
    [rms.abs(), (found.figures.pv_nm / figures.pv_nm - 1.0).abs(), (square / count).sqrt()]
}

/// Places in the order in which a machine may come to them.
#[derive(Clone, Copy, Debug)]
enum Scan {
    /// From the middle.
    Outward,
    /// From the rim.
    Inward,
    Lines,
    NoOrder,
}

const SCANS: [Scan; 4] = [Scan::Outward, Scan::Inward, Scan::Lines, Scan::NoOrder];

impl Scan {
    fn places(self, count: usize) -> Vec<[f64; 2]> {
        let mut places = match self {
            Scan::Lines => return raster(count, 8.0),
            Scan::Outward | Scan::Inward | Scan::NoOrder => spiral(count, 8.0),
        };
        match self {
            Scan::Inward => places.reverse(),
            Scan::NoOrder => {
                let mut noise = Noise::new(count as u64);
                for last in (1..count).rev() {
                    let other = ((noise.next() + 1.0) / 2.0 * (last + 1) as f64) as usize;
                    places.swap(last, other.min(last));
                }
            }
            Scan::Outward | Scan::Lines => {}
        }
        places
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(10))]

    #[test]
    fn at_any_moment_it_is_near_a_reference_made_anew(
        moment in 100..12_000_usize,
        seed in 0..1_000_u64,
        scan in 0..4_usize,
    ) {
        let scan = SCANS[scan];
        let places = scan.places(12_000);
        let points = &surface(&places, seed)[..moment.min(places.len())];
        let mut live = over(points);
        let found = live.estimate().unwrap();
        let full = reference(points, &settings()).unwrap();
        let [rms, pv, map_nm] = off(&found, &full, points);
        eprintln!(
            "{scan:?} at {moment}, made at {}: RMS {:.3} %, PV {:.3} %, map {map_nm:.3} nm",
            found.reference_count, 100.0 * rms, 100.0 * pv
        );
        prop_assert!(rms < 0.02 && pv < 0.05, "{rms} {pv}");
        prop_assert!(map_nm < 0.3 * 1e6 * SIGMA_MM, "{map_nm}");
        live.settle();
        let found = live.estimate().unwrap();
        let [rms, pv, map_nm] = off(&found, &full, points);
        prop_assert!(rms < 1e-5 && pv < 1e-6 && map_nm < 1e-3, "{rms} {pv} {map_nm}");
        prop_assert_eq!((found.pose, found.reference_count), (full.fit.pose, points.len()));
        prop_assert_eq!((live.spline(), live.base()), (Some(&full.spline), Some((full.base, &full.base_fit))));
    }
}

/// How far RMS and PV are off at worst, by surface, scan and number of points: with much noise and with hardly any, of
/// waves the knots follow and of waves they follow only when points lie densely.
#[test]
fn what_holds_at_all_moments() {
    eprintln!("| waves mm | noise nm | scan | points | RMS % | PV % | map nm | references |");
    for ((length_mm, sigma_mm), scan) in
        SURFACES.into_iter().flat_map(|surface| SCANS.map(|scan| (surface, scan)))
    {
        let points = waving(&scan.places(12_000), length_mm, sigma_mm, 7);
        let mut live = over(&[]);
        let (mut from, mut made) = (0, Vec::new());
        for to in [1_000, 2_000, 4_000, points.len()] {
            let mut worst = [0.0_f64; 3];
            for moment in (from..to).step_by((to - from) / LOOKS).skip(1).chain([to]) {
                points[live.taken()..moment].iter().for_each(|&point| live.push(point));
                let Some(found) = live.estimate() else { continue };
                made.push(found.reference_count);
                let so_far = &points[..moment];
                let Ok(full) = reference(so_far, &settings()) else { continue };
                let here = off(&found, &full, so_far);
                worst = [0, 1, 2].map(|k| worst[k].max(here[k]));
            }
            made.dedup();
            let [rms, pv, map_nm] = worst;
            eprintln!(
                "| {length_mm} | {} | {scan:?} | to {to} | {:.2} | {:.2} | {map_nm:.2} | {} |",
                1e6 * sigma_mm,
                100.0 * rms,
                100.0 * pv,
                made.len()
            );
            assert!(rms < 0.02 && pv < 0.05, "{scan:?} to {to}: {rms} {pv}");
            from = to;
        }
    }
}

/// Lengths of waves and noise.
const SURFACES: [(f64, f64); 4] = [(6.0, SIGMA_MM), (6.0, 1e-6), (2.0, SIGMA_MM), (2.0, 1e-6)];
/// In each range of points.
const LOOKS: usize = 3;

/// A deviation that is no noise, narrower than the knots, is found where it is, on the way as at the end.
#[test]
fn a_dent_the_knots_pass_over_is_the_extreme() {
    let points = surface(&spiral(11_000, 8.0), 1);
    let found = over(&points).estimate().unwrap();
    let [x, y, _] = found.figures.at_min_mm;
    assert!((x - 3.0).hypot(y + 2.0) < 0.1 && found.figures.min_nm < -200.0, "{:?}", found.figures);
    assert!(found.figures.max_nm < 100.0, "{:?}", found.figures);
    // The mean of the cells of the map is that of the dent, too.
    let cell = ((y + 9.0) / 18.0 * 96.0) as usize * 96 + ((x + 9.0) / 18.0 * 96.0) as usize;
    assert!(found.map.mean_nm[cell] < -50.0, "{}", found.map.mean_nm[cell]);
    let counted = found.mean_squares_nm2.iter().zip(&found.map.counts).filter(|(_, n)| **n > 0);
    let square: f64 = counted.map(|(square, count)| square * *count as f64).sum();
    assert!(((square / found.count as f64).sqrt() / found.figures.rms_nm - 1.0).abs() < 1e-3);
}

/// The same part elsewhere, and eight times as large with all its heights: the same deviations, and eight times as large.
#[test]
fn places_shift_and_sizes_scale() {
    let points = surface(&spiral(5_000, 8.0), 2);
    let here = over(&points).estimate().unwrap();
    let shift = [700.0, -300.0, 5.0];
    let moved: Vec<PointMm> =
        points.iter().map(|point| [0, 1, 2].map(|axis| point[axis] + shift[axis])).collect();
    let there = ReferenceSettings { centre_mm: Some([700.0, -300.0]), ..settings() };
    let mut live = LiveReference::new(there, GRID).unwrap();
    moved.iter().for_each(|&point| live.push(point));
    let there = live.estimate().unwrap();
    assert!((there.figures.rms_nm - here.figures.rms_nm).abs() < 1e-3);
    assert!((there.figures.pv_nm - here.figures.pv_nm).abs() < 1e-2);
    assert!((there.pose.tz_mm - here.pose.tz_mm - 5.0).abs() < 1e-9);
    let large = ReferenceSettings { aperture: Aperture::Circle { radius_mm: 68.0 }, ..settings() };
    let grid = Grid { x_min_mm: -72.0, x_max_mm: 72.0, y_min_mm: -72.0, y_max_mm: 72.0, ..GRID };
    let mut live = LiveReference::new(large, grid).unwrap();
    points.iter().for_each(|point| live.push(point.map(|coordinate| 8.0 * coordinate)));
    let eightfold = live.estimate().unwrap();
    assert!((eightfold.figures.rms_nm / here.figures.rms_nm - 8.0).abs() < 1e-4);
    assert!((eightfold.figures.pv_nm / here.figures.pv_nm - 8.0).abs() < 1e-4);
}

/// Merged in any order they settle on one reference; the points before decide only the order of the sums.
#[test]
fn merged_parts_settle_on_the_reference_of_all() {
    let points = surface(&raster(6_000, 8.0), 3);
    let full = reference(&points, &settings()).unwrap();
    let parts = [&points[..40], &points[40..2_500], &points[2_500..2_900], &points[2_900..]];
    for order in [[0, 1, 2, 3], [3, 1, 0, 2]] {
        let mut merged = over(&[]);
        order.iter().for_each(|&part| merged.merge(over(parts[part])).unwrap());
        assert_eq!(merged.taken(), points.len());
        let on_the_way = merged.estimate().unwrap();
        let [rms, ..] = off(&on_the_way, &full, &points);
        assert!(rms < 0.02, "{order:?}: {rms}");
        merged.settle();
        let [rms, pv, map_nm] = off(&merged.estimate().unwrap(), &full, &points);
        assert!(rms < 1e-3 && pv < 1e-3 && map_nm < 0.05, "{order:?}: {rms} {pv} {map_nm}");
    }
    let other = LiveReference::new(ReferenceSettings::default(), GRID).unwrap();
    assert_eq!(over(&points[..100]).merge(other), Err(LiveError::Different { what: "settings" }));
}

/// A scan that grows over its net makes a wider one at once, and all points count.
#[test]
fn a_scan_that_outgrows_its_net_is_followed() {
    let points = surface(&raster(9_000, 8.0), 4);
    let mut live = over(&points[..4_100]);
    let mut references = Vec::new();
    for points in points[4_100..8_000].chunks(60) {
        points.iter().for_each(|&point| live.push(point));
        let found = live.estimate().unwrap();
        assert_eq!(found.count, live.taken());
        references.push(found.reference_count);
    }
    references.dedup();
    // Neither of these is a doubling of 4,096.
    assert!(references.len() > 2 && references.len() < 9, "{references:?}");
}

#[test]
fn nothing_is_said_before_points_make_a_surface() {
    let mut live = over(&[]);
    assert!(live.estimate().is_none() && live.method().is_none() && live.failure().is_none());
    (0..63).for_each(|i| live.push([0.1 * f64::from(i), 0.0, 0.0]));
    assert!(live.estimate().is_none() && live.failure().is_none());
    live.push([f64::NAN; 3]);
    assert!(matches!(live.failure(), Some(ReferenceError::Line { used: 63, .. })));
    // The next attempt is at twice the points, with a lattice and far outliers among them.
    for i in 0..64 {
        live.push([f64::from(i % 8), f64::from(i / 8), if i == 20 { 1e-3 } else { 0.0 }]);
    }
    let found = live.estimate().unwrap();
    assert_eq!((found.count, found.excluded.not_finite, live.failure()), (122, 1, None));
    live.push([1e9, 0.0, 0.0]);
    live.push([-3.0, 1.0, f64::INFINITY]);
    let found = live.estimate().unwrap();
    assert_eq!(
        (found.count, found.excluded.outside_aperture, found.excluded.not_finite),
        (122, 6, 2)
    );
    assert!(found.figures.rms_nm.is_finite());
    // Places measured many times over are no surface.
    let mut live = over(&[]);
    (0..300).for_each(|i| live.push([f64::from(i % 2), 1.0, 0.0]));
    assert!(live.estimate().is_none() && live.failure().is_some());
    let grid = Grid { nx: 0, ..GRID };
    assert!(matches!(LiveReference::new(settings(), grid), Err(LiveError::Grid(_))));
}

/// Knots finer than an estimate can solve, or than the points allow so far, are not used on the way.
#[test]
fn knots_are_bounded_on_the_way() {
    let points = surface(&spiral(12_000, 8.0), 5);
    for (knots, sides) in
        [(Knots::Across(100), 31..=34), (Knots::Spacing(0.3), 30..=34), (Knots::Across(7), 7..=9)]
    {
        let settings = ReferenceSettings {
            knots,
            smoothing: Smoothing::Relative { lambda: 0.01 },
            base: Some(Base::Sphere),
            ..settings()
        };
        let mut live = LiveReference::new(settings, GRID).unwrap();
        points[..9_000].iter().for_each(|&point| live.push(point));
        let cells = live.spline().unwrap().surface.cells();
        assert!(sides.contains(&cells.nx.max(cells.ny)), "{knots:?}: {cells:?}");
        assert!(live.estimate().unwrap().figures.rms_nm > 10.0);
        assert_eq!(live.base().unwrap().0, Base::Sphere);
        assert!(live.method().unwrap().contains("sphere"));
    }
}
