//! Maps, spectra and slopes of points on rasters and on none, against what they were made with.

use std::f64::consts::TAU;

use asphera_geometry::PointMm;
use asphera_report::standards::PsdFigures;
use asphera_report::{FormFigures, Status};

use crate::nominal::parse;
use crate::random::Random;
use crate::{Along, MapSource, Measurement, Pipeline};

const FLAT: &str = "[surface]\nkind = \"plane\"\n[fit]\nfree = [\"tz\", \"rx\", \"ry\"]\n";
const PITCH_MM: f64 = 0.1;
const SIDE: usize = 72;

fn measured(part: &str, points: impl IntoIterator<Item = PointMm>) -> Measurement {
    let mut pipeline = Pipeline::along(parse("flat.toml", part).unwrap(), Along::default());
    points.into_iter().for_each(|point| pipeline.take_position(point));
    pipeline.finish()
}

/// A raster turned by an angle; heights in nm by its own coordinates, from −1 to 1 half a side apart from the middle.
fn raster(turn_rad: f64, mut nm: impl FnMut(f64, f64) -> f64) -> Vec<PointMm> {
    let (sin, cos) = turn_rad.sin_cos();
    let mut points = Vec::new();
    for row in 0..SIDE {
        for column in 0..SIDE {
            let [u, v] =
                [column, row].map(|node| PITCH_MM * (node as f64 - 0.5 * (SIDE - 1) as f64));
            points.push([5.0 + cos * u - sin * v, sin * u + cos * v - 3.0, nm(u, v) * 1e-6]);
        }
    }
    points
}

fn form(measurement: &Measurement) -> &FormFigures {
    measurement.report.form.as_ref().unwrap()
}

fn psd(measurement: &Measurement) -> &PsdFigures {
    form(measurement).standards.psd.as_ref().unwrap()
}

fn rms(values: impl Iterator<Item = f64> + Clone) -> f64 {
    (values.clone().map(|value| value * value).sum::<f64>() / values.count() as f64).sqrt()
}

/// By Parseval the density of white noise adds up to σ², and that of a wave to half the square of its height. Interpolated
/// to other nodes, the noise gave 6.5 nm for 10, and the wave of half the highest frequency 52 nm for 70.7.
#[test]
fn a_raster_keeps_its_power_to_the_last_frequency() {
    for turn_rad in [0.0, 0.3] {
        let mut random = Random(5);
        let white = measured(FLAT, raster(turn_rad, |_, _| 10.0 * random.normal()));
        let found = psd(&white);
        let truth = form(&white).deviation.rms_nm;
        // Under the window fewer heights count.
        assert!((found.rms_nm / truth - 1.0).abs() < 0.05, "{} for {truth}", found.rms_nm);
        assert!((found.up_to_per_mm - 5.0).abs() < 1e-9 && found.source.contains("as measured"));
        let ends = found.frequency_per_mm.iter().zip(&found.density_nm2_mm2);
        let high: Vec<f64> = ends.filter(|(f, _)| **f > 3.5).map(|(_, density)| *density).collect();
        let mean = high.iter().sum::<f64>() / high.len() as f64;
        // σ²·dx·dy.
        assert!((mean - 1.0).abs() < 0.12, "{mean} nm²·mm²");
        assert!((found.noise_nm2_mm2.unwrap() - 1.0).abs() < 0.15, "{:?}", found.noise_nm2_mm2);
        for share in [0.5, 0.9] {
            let wave = |u: f64, _: f64| 100.0 * (TAU * share * 5.0 * u + 0.7).sin();
            let found = measured(FLAT, raster(turn_rad, wave));
            let rms_nm = psd(&found).rms_nm;
            assert!((rms_nm / (100.0 / 2f64.sqrt()) - 1.0).abs() < 0.01, "{share}: {rms_nm} nm");
        }
    }
}

#[test]
fn the_map_of_a_raster_holds_what_was_measured() {
    for turn_rad in [0.0, 0.3] {
        let mut random = Random(7);
        let mut points = raster(turn_rad, |_, _| 30.0 * random.normal());
        // Some points are lost, and with them nothing else.
        let mut index = 0;
        points.retain(|_| {
            index += 1;
            index % 101 != 17
        });
        let measurement = measured(FLAT, points.clone());
        let map = measurement.map.as_ref().unwrap();
        let MapSource::Raster { bridged_nm, .. } = &map.source else { panic!("{:?}", map.source) };
        assert!((40..=52).contains(&bridged_nm.len()), "{}", bridged_nm.len());
        assert_eq!((map.grid.nx, map.grid.ny), (SIDE, SIDE));
        let known = map.values_nm.iter().copied().filter(|nm| nm.is_finite());
        assert_eq!(known.clone().count(), points.len());
        let of_points = rms(measurement.deviations_nm.iter().copied());
        assert!((rms(known) / of_points - 1.0).abs() < 1e-12);
    }
}

/// One point between the nodes once turned a raster into scattered points, whose spectrum ends early.
#[test]
fn strays_and_missing_rows_leave_a_raster_its_spectrum() {
    let mut random = Random(5);
    let mut points = raster(0.0, |_, _| 10.0 * random.normal());
    let truth = form(&measured(FLAT, points.clone())).deviation.rms_nm;
    let row = 30 * SIDE..31 * SIDE;
    points.drain(row);
    points.extend([[5.03, -3.04, 0.0], [6.03, -1.77, 1e-6]]);
    points[500][0] += 0.04;
    let measurement = measured(FLAT, points);
    let found = psd(&measurement);
    assert!((found.up_to_per_mm - 5.0).abs() < 0.01, "{}", found.up_to_per_mm);
    assert!((found.rms_nm / truth - 1.0).abs() < 0.05, "{} for {truth}", found.rms_nm);
    assert!(found.source.ends_with("which are left out: 3"), "{}", found.source);
    let source = measurement.map.as_ref().unwrap().source.to_string();
    assert!(source.ends_with("; 3 points beside its nodes are left out"), "{source}");
}

/// Waves and noise at places without order: what linear interpolation takes from them is put back.
#[test]
fn scattered_points_have_a_spectrum_up_to_where_it_is_known() {
    let mut random = Random(3);
    let count = SIDE * SIDE;
    let side_mm = PITCH_MM * SIDE as f64;
    let places: Vec<[f64; 2]> =
        (0..count).map(|_| [side_mm * random.next(), side_mm * random.next()]).collect();
    let of = |nm: &mut dyn FnMut(f64, f64) -> f64| {
        measured(FLAT, places.iter().map(|&[x, y]| [x, y, nm(x, y) * 1e-6]).collect::<Vec<_>>())
    };
    let white = of(&mut |_, _| 10.0 * random.normal());
    let found = psd(&white);
    assert!(found.source.contains("interpolated"), "{}", found.source);
    // Half of the power is left at 0.47 of the highest frequency: SciPy's Delaunay of as many places gives 0.475.
    assert!((found.up_to_per_mm / 5.0 - 0.475).abs() < 0.03, "{}", found.up_to_per_mm);
    assert!(*found.frequency_per_mm.last().unwrap() <= found.up_to_per_mm);
    let pairs =
        found.frequency_per_mm.iter().zip(&found.density_nm2_mm2).filter(|(f, _)| **f > 1.0);
    let densities: Vec<f64> = pairs.map(|(_, density)| *density).collect();
    let mean = densities.iter().sum::<f64>() / densities.len() as f64;
    let noise = found.noise_nm2_mm2.unwrap();
    assert!((mean / noise - 1.0).abs() < 0.2, "{mean} and {noise} nm²·mm²");
    for share in [0.1, 0.25, 0.4] {
        let wave = of(&mut |x, y| 100.0 * (TAU * share * 5.0 * (0.8 * x + 0.6 * y)).sin());
        let rms_nm = psd(&wave).rms_nm;
        assert!((rms_nm / (100.0 / 2f64.sqrt()) - 1.0).abs() < 0.04, "{share}: {rms_nm} nm");
    }
    let map = white.map.as_ref().unwrap();
    assert!(map.source.to_string().contains("scattered"), "{}", map.source);
}

/// A disc masked short of its aperture, with 5 nm of noise that the points tell of themselves: 24 terms of it were off by
/// thousands of nm.
#[test]
fn a_noisy_disc_tells_few_terms_with_their_uncertainty() {
    let part = format!("{FLAT}[aperture]\nshape = \"circle\"\nradius_mm = 5.0\n");
    let mut random = Random(11);
    let points: Vec<PointMm> = (0..12_000)
        .map(|i| (4.9 * ((f64::from(i) + 0.5) / 12_000.0).sqrt(), 2.399_963 * f64::from(i)))
        .map(|(r, phi)| {
            let x = (r / 5.0).powi(2);
            // Q₀ = 1 and Q₁ = (13 − 16u²)/√19: prysm's Qbfs.
            let nm = x * (1.0 - x) * (-400.0 + 60.0 * (13.0 - 16.0 * x) / 19f64.sqrt());
            [r * phi.cos(), r * phi.sin(), (nm + 5.0 * random.normal()) * 1e-6]
        })
        .collect();
    let measurement = measured(&part, points);
    let q = form(&measurement).standards.q_spectrum.as_ref().unwrap();
    assert!((q.noise_nm - 5.0).abs() < 0.4 && !q.noise_of_residuals, "{q:?}");
    assert!((2..=4).contains(&q.coefficients_nm.len()) && q.asked == 24, "{q:?}");
    assert!(q.note.as_ref().unwrap().contains("do not stand out of noise"), "{q:?}");
    for (m, truth) in [(0, -400.0), (1, 60.0)] {
        let off = q.coefficients_nm[m].unwrap() - truth;
        assert!(off.abs() < 4.0 * q.u_nm[m] && q.u_nm[m] < 8.0, "a{m}: {off} {q:?}");
    }
    let [low, high] = q.slope_95_urad.unwrap();
    let truth = 400f64.hypot(60.0) / 5.0;
    assert!(low - 1.0 < truth && truth < high + 1.0 && q.ends, "{q:?}");
}

/// Short integration lengths make much slope of noise: it is told, and fails no part.
#[test]
fn noise_in_slopes_is_told_and_breaks_no_limit() {
    let verdict_of = |limit: f64| {
        let part = format!(
            "{FLAT}[tolerance]\ngradient_rms_urad = {limit}\nslope_over_mm = 0.4\nslope_step_mm = 0.4\n\
             [figures]\nslope_length_mm = 0.4\n[uncertainty]\ndraws = 40\n"
        );
        let mut random = Random(2);
        let wave = |u: f64| 10.0 * (TAU * u / 7.2).cos();
        measured(&part, raster(0.0, |u, _| wave(u) + 2.0 * random.normal()))
    };
    // 10 nm·2π/7.2 mm/√2 = 6.17 µrad, some of which the discs take.
    let measurement = verdict_of(8.0);
    let figure = form(&measurement).figures.iter().find(|figure| figure.name == "gradient, RMS");
    let figure = figure.unwrap();
    let without = figure.without_noise.unwrap();
    assert!(figure.value > 9.0, "{figure:?}");
    assert!((without - 6.15).abs() < 0.4, "{figure:?}");
    assert!((figure.value - without - figure.noise_adds.unwrap()).abs() < 1e-12);
    let verdict = &measurement.report.verdict;
    assert_eq!(verdict.status, Status::Undecided, "{verdict:?}");
    assert_eq!(verdict_of(4.0).report.verdict.status, Status::Fail);
    assert_eq!(verdict_of(14.0).report.verdict.status, Status::Pass);
}

/// A concave cap of 10 mm up to 70° with 100 nm of astigmatism along the normal: 100/√6 nm of RMS by area. Across the axis its
/// slope is 200 nm·ρ over the radius, with an RMS of 15.05 µrad.
#[test]
fn steep_parts_have_their_deviation_and_slopes_that_say_where_they_are_not() {
    let (sphere_mm, flat) = (10.0, 70f64.to_radians().cos());
    let reach_mm = sphere_mm * (1.0 - flat * flat).sqrt();
    let points: Vec<PointMm> = (0..8000)
        .map(|i| {
            let cos = 1.0 - (1.0 - flat) * (f64::from(i) + 0.5) / 8000.0;
            let (phi, sin) = (2.399_963 * f64::from(i), (1.0 - cos * cos).sqrt());
            let mm = 1e-4 * (sin * sphere_mm / reach_mm).powi(2) * (2.0 * phi).cos();
            let r = (sphere_mm - mm) * sin;
            [r * phi.cos(), r * phi.sin(), sphere_mm - (sphere_mm - mm) * cos]
        })
        .collect();
    let of = |length_mm: f64| {
        let part = format!(
            "[surface]\nkind = \"sphere\"\nradius_mm = {sphere_mm}\n[aperture]\nshape = \"circle\"\n\
             radius_mm = {reach_mm:?}\n[fit]\nfree = [\"tx\", \"ty\", \"tz\"]\n\
             [figures]\nslope_length_mm = {length_mm:?}\n[tolerance]\ngradient_rms_urad = 40.0\n\
             slope_over_mm = {length_mm:?}\nslope_step_mm = {length_mm:?}\n"
        );
        measured(&part, points.clone())
    };
    let value = |measurement: &Measurement, name: &str| {
        form(measurement).figures.iter().find(|figure| figure.name == name).unwrap().value
    };
    let lacks = |measurement: &Measurement| {
        let notes = &form(measurement).unknown;
        notes.iter().filter(|why| why.starts_with("slopes at")).count()
    };
    let long = of(1.5);
    assert!((value(&long, "RMS by area") - 100.0 / 6f64.sqrt()).abs() < 0.2);
    assert!((form(&long).deviation.pv_nm - 200.0).abs() < 0.6);
    assert!((value(&long, "gradient, RMS") / 15.05 - 1.0).abs() < 0.05);
    assert_eq!(lacks(&long), 0);
    // In the middle points are too far apart across the axis: what is left is steeper.
    let short = of(0.5);
    assert!(value(&short, "gradient, RMS") > 17.0);
    assert_eq!(lacks(&short), 1);
    // What is not known everywhere is not passed.
    let verdict = |measurement: &Measurement| {
        let verdict = &measurement.report.verdict;
        let of_stations = |reason: &&String| reason.contains("no slopes at");
        (verdict.status, verdict.reasons.iter().filter(of_stations).count())
    };
    assert_eq!(verdict(&long), (Status::Pass, 0));
    assert_eq!(verdict(&short), (Status::Undecided, 1));
}
