//! Tests of effects of the machine.

use super::*;
use crate::nominal::parse;
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
