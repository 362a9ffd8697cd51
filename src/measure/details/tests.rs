//! Tests of the figures of a deviation.

use crate::nominal::parse;
use asphera_form::basis::{Normalisation, zernike_value};
use asphera_form::{Fit, FitSettings, fit};
use proptest::prelude::*;

use super::*;

const RADIUS_MM: f64 = 4.0;

fn fringe(index: u32, u: f64, v: f64) -> f64 {
    let (n, m) = Counting::Fringe.orders(index).unwrap();
    zernike_value(n, m, Normalisation::UnitHeight, u, v).unwrap()
}

fn flat() -> Part {
    let nominal = format!(
        "[surface]\nkind = \"plane\"\n[aperture]\nshape = \"circle\"\nradius_mm = {RADIUS_MM:?}\n\
         [fit]\nfree = [\"tz\"]\n"
    );
    parse("flat.toml", &nominal).unwrap()
}

/// Places on a square lattice over the disc, with a deviation each.
fn measured(nm: impl Fn(f64, f64) -> f64) -> (Vec<PointMm>, Vec<f64>) {
    let mut points = Vec::new();
    for i in -50..=50 {
        for j in -50..=50 {
            let (u, v) = (f64::from(i) * 0.0199, f64::from(j) * 0.0199);
            if u.hypot(v) <= 1.0 {
                points.push([RADIUS_MM * u, RADIUS_MM * v, nm(u, v) * 1e-6]);
            }
        }
    }
    let deviations_mm = points.iter().map(|point| point[2]).collect();
    (points, deviations_mm)
}

fn of(part: &Part, points: &[PointMm], deviations_mm: &[f64], areas_mm2: &[f64]) -> FormDetails {
    let settings = FitSettings { free: part.free.clone(), ..FitSettings::default() };
    let fit = fit(points, &part.nominal, &settings).unwrap();
    // The fit must not move the part, whose deviations are given.
    let fit = Fit { pose: Pose::default(), ..fit };
    let sample = sample(part, &fit.pose, points, deviations_mm, areas_mm2);
    let indicated = sample.as_ref().map_err(ToString::to_string).map(|sample| Indicated {
        sample,
        nominal: &fit.nominal,
        from_design: false,
    });
    let beside = Beside { rms_nm: 0.0, noise_nm: None, sure: &Sure::default() };
    details(part, &sample, indicated, areas_mm2, beside)
}

fn value(details: &FormDetails, name: &str, variant: &str) -> f64 {
    let found = |figure: &&FormFigure| figure.name == name && figure.variant == variant;
    let figure = details.figures.iter().find(found);
    figure.unwrap_or_else(|| panic!("no {name} {variant}: {:#?}", details.figures)).value
}

#[test]
fn terms_put_in_are_found_named_and_taken_out() {
    let put_in = [(1, 5.0), (2, -8.0), (4, 30.0), (5, 12.0), (8, -7.0), (9, 6.0), (11, 4.0)];
    let (points, deviations_mm) =
        measured(|u, v| put_in.iter().map(|&(index, nm)| nm * fringe(index, u, v)).sum());
    let found = of(&flat(), &points, &deviations_mm, &vec![1.0; points.len()]);
    // What is not rotational counts as noise of the Q spectrum, whose first terms it drowns.
    assert!(found.unknown.iter().all(|why| why.starts_with("Q spectrum")), "{:?}", found.unknown);
    let zernike = found.zernike.as_ref().unwrap();
    assert_eq!((zernike.terms.len(), zernike.radius_mm), (36, RADIUS_MM));
    for term in &zernike.terms {
        let had = put_in.iter().find(|(index, _)| *index == term.index);
        let had = had.map_or(0.0, |(_, nm)| *nm);
        assert!((term.value_nm - had).abs() < 1e-8, "{term:?}, not {had} nm");
    }
    let term = |index: usize| &zernike.terms[index - 1];
    assert_eq!((term(4).name.as_str(), term(4).n, term(4).m), ("defocus", 2, 0));
    assert_eq!((term(30).name.as_str(), term(30).n, term(30).m), ("tertiary trefoil x", 7, 3));
    // What is left in the end is the trefoil: ±4 nm at the rim.
    let all = "piston, tilt, power, astigmatism, coma, spherical removed";
    let left_nm = value(&found, "PV", all);
    assert!((7.6..8.0 + 1e-6).contains(&left_nm), "{left_nm}");
    assert!(value(&found, "PV", "piston, tilt removed") > value(&found, "PV", all));
    // The sphere of 30 nm of Fringe 4 and what 6 nm of Fringe 9 hold of it.
    assert!((value(&found, "A", "as fitted") - 60.0).abs() < 1.0);
}

#[test]
fn what_the_points_do_not_tell_is_said() {
    let points: Vec<PointMm> = (0..5).map(|i| [f64::from(i) * 0.5, 0.1, 1e-6]).collect();
    let found = of(&flat(), &points, &[1e-6; 5], &[0.0; 5]);
    assert_eq!(value(&found, "PV", "as fitted, every point counted alike"), 0.0);
    assert_eq!(found.zernike, None);
    for name in ["PVr", "Zernike terms", "slopes"] {
        assert!(found.unknown.iter().any(|why| why.starts_with(name)), "{:?}", found.unknown);
    }
    assert_eq!(found.histogram.unwrap().counts, [5]);
}

#[test]
fn a_triangle_stands_for_a_third_at_each_corner() {
    let points = [[0.0, 0.0, 9.0], [3.0, 0.0, 0.0], [0.0, 2.0, 0.0], [3.0, 2.0, 0.0]];
    let areas = areas_mm2(&points, [[0, 1, 2], [1, 3, 2]].into_iter());
    assert_eq!(areas, [1.0, 2.0, 2.0, 1.0]);
}

proptest! {
    #[test]
    fn a_histogram_counts_every_point_where_it_lies(
        values_nm in prop::collection::vec(-1e3..1e3f64, 1..200),
        scale in prop::sample::select(vec![1e-9, 1e-3, 1.0, 1e9]),
        offset_nm in prop::sample::select(vec![0.0, -1e3, 1e6]),
    ) {
        let values_nm: Vec<f64> =
            values_nm.iter().map(|nm| nm * scale + offset_nm).collect();
        let HistogramFigures { low_nm, width_nm, counts, .. } = histogram(&values_nm).unwrap();
        prop_assert_eq!(counts.iter().sum::<u64>(), values_nm.len() as u64);
        prop_assert!(counts[0] > 0 && counts[counts.len() - 1] > 0);
        prop_assert!(counts.len() <= 66, "{} bins", counts.len());
        let high_nm = low_nm + width_nm * counts.len() as f64;
        let rounding = 1e-12 * (low_nm.abs() + high_nm.abs());
        for nm in values_nm {
            prop_assert!(low_nm - rounding <= nm && nm <= high_nm + rounding);
        }
        let digit = width_nm / 10.0_f64.powi((width_nm * 1.000_001).log10().floor() as i32);
        prop_assert!([1.0, 2.0, 5.0].iter().any(|d| (digit - d).abs() < 1e-6), "{}", width_nm);
    }
}
