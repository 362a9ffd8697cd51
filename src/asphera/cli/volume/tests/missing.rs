//! Missing samples open the surface, and every figure says so.

use std::f64::consts::PI;

use serde_json::Value;

use super::figures_of;

const SIDE: usize = 32;
const RADIUS: f64 = 12.3;
const CENTRE: [f64; 3] = [15.7, 16.1, 16.0];

/// A ball by the distance from its surface, with values missing where a rule says so. Samples are 0.1 mm apart.
fn ball(is_missing: impl Fn([f64; 3]) -> bool) -> Vec<u8> {
    let mut file = format!(
        "NRRD0004\ntype: float\ndimension: 3\nsizes: {SIDE} {SIDE} {SIDE}\nencoding: raw\nendian: little\n\
         space: left-posterior-superior\nspace directions: (0.1,0,0) (0,0.1,0) (0,0,0.1)\n\
         space units: \"mm\" \"mm\" \"mm\"\n\n"
    )
    .into_bytes();
    for index in 0..SIDE.pow(3) {
        let place = [index % SIDE, index / SIDE % SIDE, index / SIDE / SIDE];
        let at: [f64; 3] = std::array::from_fn(|axis| place[axis] as f64 - CENTRE[axis]);
        let height = RADIUS - at.iter().map(|x| x * x).sum::<f64>().sqrt();
        let value = if is_missing(at) { f64::NAN } else { height };
        file.extend((value as f32).to_le_bytes());
    }
    file
}

fn number(found: &Value, path: &str) -> f64 {
    found.pointer(path).and_then(Value::as_f64).unwrap_or_else(|| panic!("{path}: {found}"))
}

/// Two slices through the ball: two caps by Archimedes, no volume of a mesh, bounds that hold what was hidden.
#[test]
fn a_surface_is_open_where_samples_are_missing() {
    let file = ball(|[_, _, z]| z == 3.0 || z == 4.0);
    for method in ["mmc", "trilinear", "voxels"] {
        let more = ["--threshold", "0", "--regular", "1.2", "--method", method];
        let found = figures_of(&file, "nrrd", &more).unwrap();
        let mesh = &found["mesh"];
        assert_eq!(
            (&mesh["closed"], &mesh["oriented"], &mesh["borders"], &mesh["euler"]),
            (&false.into(), &true.into(), &2.into(), &2.into()),
            "{method}"
        );
        for surface in found["topology"]["surfaces"].as_array().unwrap() {
            assert_eq!((&surface["genus"], &surface["volume_mm3"]), (&Value::Null, &Value::Null));
        }
        assert_eq!(found["measures"]["volume_mm3"]["by"]["mesh"], Value::Null);
        assert_eq!(found["measures"]["volume_mm3"]["u"], Value::Null);
        assert_eq!(found["grid"]["verdict"], "unknown");
        // Two parts without the missing samples, one with them.
        assert_eq!(found["topology"]["components"], 2);
        assert_eq!(found["topology"]["with_missing"]["components"], 1);
        let truth = 4.0 / 3.0 * PI * (0.1 * RADIUS).powi(3);
        let volume = |of: &str| number(&found, &format!("/measures/volume_mm3/{of}"));
        assert!(volume("low") < truth && truth < volume("high"), "{found}");
        assert!(volume("value") < truth && truth < volume("with_missing"), "{found}");
        let area = |of: &str| number(&found, &format!("/measures/area_mm2/{of}"));
        let truth = 2.0 * PI * RADIUS * (2.0 * RADIUS - 3.0) * 0.01;
        assert!((area("value") - truth).abs() < 2.0 * area("u"), "{truth} {found}");
        assert!((area("value") / truth - 1.0).abs() < 0.01, "{truth} {found}");
    }
}

/// The area moves with the threshold as that of a ball whose radius is that much smaller or larger, the volume with it.
#[test]
fn the_area_has_a_sensitivity_to_the_threshold() {
    for gap in [f64::NAN, 3.0] {
        let file = ball(|[_, _, z]| z == gap);
        let found = figures_of(&file, "nrrd", &["--threshold", "0"]).unwrap();
        let of = |measure: &str| -> [f64; 2] {
            [0, 1].map(|at| number(&found, &format!("/measures/{measure}/at_threshold_moved/{at}")))
        };
        let area = number(&found, "/measures/area_mm2/value");
        let [less, more] = of("area_mm2");
        assert!(less > area && area > more, "{found}");
        // One percent of the contrast moves the radius by as many spacings, for the values are distances.
        let [larger, smaller] = of("volume_mm3").map(|volume| volume * 1000.0);
        let step = (larger - smaller) / (2.0 * 4.0 * PI * RADIUS * RADIUS);
        let expected = [1.0, -1.0].map(|sign| 2.0 * sign * step / RADIUS);
        for (moved, expected) in [less, more].into_iter().zip(expected) {
            let found = moved / area - 1.0;
            assert!((found / expected - 1.0).abs() < 0.25, "{found} {expected}");
        }
    }
}
