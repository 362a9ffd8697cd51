//! Tests of effects of the machine.

use super::*;
use crate::nominal::parse;
use crate::random::Random;
use crate::{Along, Pipeline};

#[test]
fn effects_turn_with_the_plane() {
    let plane = Plane::new([1.0, 2.0, 3.0], [1.0, 0.5, -0.2]).unwrap();
    let effect = Effect { about_mm: [4.0, 0.0, -1.0], ..Effect::squareness(0, 2, 1e-3) };
    let turned = in_plane(&effect, &plane);
    // Displacing in the plane's frame is displacing in the measured one.
    let displaced = |effect: &Effect, at: PointMm| -> PointMm {
        let from: PointMm = std::array::from_fn(|i| at[i] - effect.about_mm[i]);
        let row = |row: [f64; 3]| (0..3).map(|j| row[j] * from[j]).sum::<f64>();
        let moved = effect.displacement.map(row);
        std::array::from_fn(|i| at[i] + moved[i])
    };
    for point in [[5.0, -7.0, 11.0], [0.0; 3]] {
        let truth = plane.to_plane(displaced(&effect, point));
        let found = displaced(&turned, plane.to_plane(point));
        for axis in 0..3 {
            assert!((found[axis] - truth[axis]).abs() < 1e-13);
        }
    }
}

/// A perfect flat with noise of 5 nm on one side and 15 nm on the other. One noise in the middle left 7 nm of form.
#[test]
fn noise_that_differs_over_the_part_is_no_form() {
    let text = "[surface]\nkind = \"plane\"\n[aperture]\nshape = \"rectangle\"\nwidth_mm = 10\nheight_mm = 10\n";
    let report = |loud_nm: f64| {
        let mut pipeline = Pipeline::along(parse("flat.toml", text).unwrap(), Along::Z);
        let mut random = Random(7);
        for place in 0..10_000 {
            let [x, y] = [place % 100, place / 100].map(|k| 0.1 * f64::from(k) - 4.95);
            let sigma_nm = if x < 0.0 { 5.0 } else { loud_nm };
            let normal = 3.0_f64.sqrt() * (0..4).map(|_| random.centred()).sum::<f64>();
            pipeline.take_position([x, y, 1e-6 * sigma_nm * normal]);
        }
        pipeline.finish().report
    };
    let uneven = report(15.0);
    let [least, most] = uneven.sampling.noise_range_nm.unwrap();
    assert!((4.0..6.0).contains(&least) && (13.0..17.0).contains(&most), "{least} {most}");
    let rms_nm = uneven.sampling.noise_rms_nm.unwrap();
    assert!((rms_nm / 125.0_f64.sqrt() - 1.0).abs() < 0.05, "{rms_nm}");
    let said = &uneven.sampling.unknown;
    assert!(said.iter().any(|why| why.contains("the noise differs over the part")), "{said:?}");
    let uncertainty = uneven.form.unwrap().deviation.uncertainty.unwrap();
    assert_eq!(uncertainty.noise_nm, rms_nm);
    assert!(uncertainty.rms_without_noise_nm < 4.0, "{uncertainty:?}");
    let even = report(5.0).sampling;
    assert_eq!((even.noise_range_nm, even.noise_rms_nm), (None, None));
    assert!(!even.unknown.iter().any(|why| why.contains("differs")));
}

/// A flat under a device with steps of 600 nm, which sees 2 µm of power in four levels. Without a word the noise would be 0,
/// and so would be every u. By the steps it is 600/√12 nm, whoever states the budget.
#[test]
fn heights_in_steps_have_the_noise_of_their_rounding() {
    for table in ["", "[uncertainty]\n"] {
        let text = format!(
            "[surface]\nkind = \"plane\"\n[aperture]\nshape = \"rectangle\"\nwidth_mm = 8\nheight_mm = 8\n\
             [fit]\nfree = [\"tz\"]\n[tolerance]\nrms_nm = 2000\n{table}"
        );
        let mut pipeline = Pipeline::along(parse("flat.toml", &text).unwrap(), Along::Z);
        for place in 0..6400 {
            let [x, y] = [place % 80, place / 80].map(|k| 0.1 * f64::from(k) - 3.95);
            let steps = (2e-3 * (x * x + y * y) / 32.0 / 6e-4).round();
            pipeline.take_position([x, y, 5.0 - 6e-4 * steps]);
        }
        let report = pipeline.finish().report;
        let rounding_nm = 600.0 / 12_f64.sqrt();
        let noise_nm = report.sampling.noise_sigma_nm.unwrap();
        assert!((noise_nm - rounding_nm).abs() < 1e-3, "{table}: {noise_nm}");
        assert!((report.sampling.height_step_nm.unwrap() - 600.0).abs() < 1e-3, "{table}");
        let said = &report.sampling.unknown;
        assert!(said.iter().any(|why| why.contains("steps of 600.0 nm")), "{table}: {said:?}");
        let uncertainty = report.form.unwrap().deviation.uncertainty.unwrap();
        assert!(uncertainty.u_pv_nm > rounding_nm, "{table}: {uncertainty:?}");
    }
}
