//! Laws of the figures: turns, scale, order, duplicates, areas, threads.

use std::num::{NonZeroU8, NonZeroU16};

use asphera_figures::{
    Approximation, FringeCount, Reference, Sample, Share, SlopeSettings, Term, decompose,
    fringe_fit, peak_to_valley, pvr, q_spectrum, radial_profile, remove, rms,
    robust_peak_to_valley, slopes,
};
use proptest::prelude::*;

use super::{DISC, disc};
use crate::common::Noise;

/// A part with a wavy deviation in nm, 600 random places and areas, and a gap.
#[derive(Clone, Debug)]
struct Part {
    places_mm: Vec<[f64; 2]>,
    heights_nm: Vec<f64>,
    areas: Vec<f64>,
}

impl Part {
    fn new(seed: u64) -> Part {
        let mut noise = Noise::new(seed);
        let mut part = Part { places_mm: vec![], heights_nm: vec![], areas: vec![] };
        while part.places_mm.len() < 600 {
            let (x, y) = (4.9 * noise.next(), 4.9 * noise.next());
            if x.hypot(y) <= 4.9 && x + y < 4.0 {
                part.places_mm.push([x, y]);
                let wave = 40.0 * (x - 0.4 * y).sin() + 3.0 * x * y + 2.0 * x * x;
                part.heights_nm.push(wave + 5.0 * noise.next());
                part.areas.push(1.5 + noise.next());
            }
        }
        part
    }

    fn sample(&self) -> Sample {
        let deviations: Vec<f64> = self.heights_nm.iter().map(|nm| nm * 1e-6).collect();
        Sample::new(&self.places_mm, &deviations, Some(&self.areas), &DISC).unwrap()
    }
}

/// Every figure that is a number and does not depend on the directions of x and y.
fn invariants(sample: &Sample) -> Vec<f64> {
    let rings = NonZeroU16::new(7);
    let fit = fringe_fit(sample, FringeCount::ThirtySix).unwrap();
    let removed = remove(sample, &[Term::Tilt, Term::Power, Term::Astigmatism]).unwrap().sample;
    let parts = decompose(sample, Approximation::Quadratic, rings).unwrap();
    let q = q_spectrum(sample, NonZeroU8::new(4).unwrap(), None).unwrap();
    let mut found = vec![
        peak_to_valley(sample).unwrap().value,
        rms(sample, Reference::Zero).unwrap().value,
        rms(sample, Reference::Mean).unwrap().value,
        robust_peak_to_valley(sample, Share::new(0.9).unwrap()).unwrap().value,
        pvr(sample, FringeCount::ThirtySix).unwrap().value,
        peak_to_valley(&removed).unwrap().value,
        q.power_nm.abs(),
        q.slope.fitted_urad,
    ];
    found.extend(parts.figures().map(|figure| figure.value));
    found.extend(fit.spectrum().iter().map(|line| line.rms_nm));
    let profile = radial_profile(sample, rings).unwrap();
    found.extend(profile.iter().filter_map(|ring| ring.heights).map(|heights| heights.spread_nm));
    found
}

fn same(found: &[f64], expected: &[f64], factor: f64) -> Result<(), TestCaseError> {
    prop_assert_eq!(found.len(), expected.len());
    let size = expected.iter().fold(0.0, |size: f64, value| size.max(value.abs()));
    for (i, (found, expected)) in found.iter().zip(expected).enumerate() {
        let off = (found - factor * expected).abs() / (factor * size);
        prop_assert!(off < 1e-9, "{}: {} {}", i, found, factor * expected);
    }
    Ok(())
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(24))]

    #[test]
    fn a_turn_about_the_axis_changes_directions_only(seed: u64, turn in -3.0..3.0f64) {
        let part = Part::new(seed);
        let mut turned = part.clone();
        let (sin, cos) = turn.sin_cos();
        for [x, y] in &mut turned.places_mm {
            (*x, *y) = (*x * cos - *y * sin, *x * sin + *y * cos);
        }
        same(&invariants(&turned.sample()), &invariants(&part.sample()), 1.0)?;
        let axes = |part: &Part| {
            let fit = fringe_fit(&part.sample(), FringeCount::ThirtySix).unwrap();
            let found = fit.aberrations().unwrap();
            [(found.astigmatism, 2.0), (found.coma, 1.0), (found.trefoil, 3.0)]
        };
        for ((before, m), (after, _)) in axes(&part).into_iter().zip(axes(&turned)) {
            let angle = after.direction_rad.unwrap() - before.direction_rad.unwrap() - turn;
            // Angles of a term of order m repeat every 2π/m.
            let off = (0.5 * m * angle).sin().abs();
            prop_assert!(off * before.magnitude_nm < 1e-8, "{} {}", off, m);
            let period = std::f64::consts::TAU / m;
            prop_assert!((0.0..period).contains(&after.direction_rad.unwrap()));
        }
    }

    #[test]
    fn heights_scale_every_figure(seed: u64, factor in 1e-3..1e3f64) {
        let part = Part::new(seed);
        let mut scaled = part.clone();
        scaled.heights_nm.iter_mut().for_each(|nm| *nm *= factor);
        same(&invariants(&scaled.sample()), &invariants(&part.sample()), factor)?;
        // Turned upside down, ranges and roots stay.
        scaled.heights_nm.iter_mut().for_each(|nm| *nm *= -1.0 / factor);
        same(&invariants(&scaled.sample()), &invariants(&part.sample()), 1.0)?;
    }

    #[test]
    fn order_duplicates_and_the_unit_of_area_do_not_matter(seed: u64, unit in 1e-6..1e6f64) {
        let part = Part::new(seed);
        let expected = invariants(&part.sample());
        let mut changed = part.clone();
        changed.places_mm.reverse();
        changed.heights_nm.reverse();
        changed.areas.reverse();
        same(&invariants(&changed.sample()), &expected, 1.0)?;
        changed.places_mm.extend(part.places_mm);
        changed.heights_nm.extend(part.heights_nm);
        changed.areas.extend(part.areas);
        changed.areas.iter_mut().for_each(|area| *area *= unit);
        same(&invariants(&changed.sample()), &expected, 1.0)?;
    }

    #[test]
    fn a_double_area_is_two_points(seed: u64, which in 0_usize..600) {
        let part = Part::new(seed);
        let (mut heavy, mut twice) = (part.clone(), part);
        heavy.areas[which] *= 2.0;
        twice.places_mm.push(twice.places_mm[which]);
        twice.heights_nm.push(twice.heights_nm[which]);
        twice.areas.push(twice.areas[which]);
        same(&invariants(&heavy.sample()), &invariants(&twice.sample()), 1.0)?;
    }

    #[test]
    fn parts_are_never_larger_than_the_whole(seed: u64, rings in 1_u16..80) {
        let found =
            decompose(&Part::new(seed).sample(), Approximation::Quadratic, NonZeroU16::new(rings));
        let found = found.unwrap();
        let (total, i, a) =
            (found.rms_total_nm, found.rms_irregularity_nm, found.rms_variant_nm);
        prop_assert!(a <= i * (1.0 + 1e-12), "{} {}", a, i);
        prop_assert!(found.invariant_nm.iter().all(|nm| nm.is_finite()));
        prop_assert!(total > 0.0 && i <= total * 1.2);
    }
}

#[test]
fn the_number_of_threads_does_not_change_a_bit() {
    let sample = disc(30_000, |x, y| 20.0 * (3.0 * x).sin() * (2.0 * y).cos() + x * y);
    let settings = SlopeSettings::new(0.4, 0.2).unwrap();
    let all = || {
        let mut found = invariants(&sample);
        found.extend(slopes(&sample, settings).unwrap().figures().map(|figure| figure.value));
        found.into_iter().map(f64::to_bits).collect::<Vec<u64>>()
    };
    let with = |threads| rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
    assert_eq!(with(1).install(all), with(3).install(all));
}
