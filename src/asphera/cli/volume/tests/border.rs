//! A part that goes on beyond the volume: its surface ends there, or is closed where that is asked for.

use std::f64::consts::PI;

use super::figures_of;

const SIDE: usize = 40;
const RADIUS: f64 = 14.3;
/// The ball lies across the last slices along z.
const CENTRE: [f64; 3] = [19.7, 20.1, 33.4];

/// A ball of bytes: 200 inside, 20 outside, so that vertices lie halfway. Samples are 0.1 mm apart.
fn ball(centre: [f64; 3]) -> Vec<u8> {
    let mut file = format!(
        "NRRD0004\ntype: uchar\ndimension: 3\nsizes: {SIDE} {SIDE} {SIDE}\nencoding: raw\n\
         space: left-posterior-superior\nspace directions: (0.1,0,0) (0,0.1,0) (0,0,0.1)\n\
         space units: \"mm\" \"mm\" \"mm\"\n\n"
    )
    .into_bytes();
    for index in 0..SIDE.pow(3) {
        let place = [index % SIDE, index / SIDE % SIDE, index / SIDE / SIDE];
        let square: f64 = (0..3).map(|axis| (place[axis] as f64 - centre[axis]).powi(2)).sum();
        file.push(if square < RADIUS * RADIUS { 200 } else { 20 });
    }
    file
}

#[test]
fn a_surface_ends_at_the_border_unless_it_is_padded() {
    let file = ball(CENTRE);
    let number = |found: &serde_json::Value, path: &str| found.pointer(path).unwrap().as_f64();
    for method in ["mmc", "mi", "cmi", "balls", "trilinear", "smooth", "voxels"] {
        let of = |more: &[&str]| {
            let all = [&["--regular", "1.4", "--method", method], more].concat();
            figures_of(&file, "nrrd", &all).unwrap()
        };
        let (open, padded) = (of(&[]), of(&["--pad"]));
        for (found, is_padded) in [(&open, false), (&padded, true)] {
            assert_eq!(found["volume"]["touches_border"], true);
            assert_eq!(found["volume"]["padded"], is_padded);
            assert_eq!(found["mesh"]["closed"], is_padded, "{method}");
            assert_eq!(found["mesh"]["oriented"], true, "{method}");
            assert_eq!(found["mesh"]["borders"], u64::from(!is_padded), "{method}");
            let surface = &found["topology"]["surfaces"][0];
            assert_eq!(surface["genus"].is_null(), !is_padded, "{method}");
            assert_eq!(found["measures"]["volume_mm3"]["by"]["mesh"].is_null(), !is_padded);
            // Nothing is proved of what was not scanned.
            assert_eq!(found["grid"]["verdict"], "unknown");
            assert_eq!(number(found, "/measures/volume_mm3/low"), None);
            let reasons = found["reasons"].to_string();
            assert!(
                reasons.contains("touches the border") && reasons.contains("--pad"),
                "{reasons}"
            );
        }
        assert_eq!(open["topology"]["euler_6"], padded["topology"]["euler_6"]);
        // Up to the last slice, by Archimedes; half a spacing more and a disc where it is padded.
        let height = (SIDE - 1) as f64 - CENTRE[2];
        let zone = |height: f64| 2.0 * PI * RADIUS * (RADIUS + height) * 0.01;
        let disc = PI * (RADIUS * RADIUS - (height + 0.5).powi(2)) * 0.01;
        for (found, truth) in [(&open, zone(height)), (&padded, zone(height + 0.5) + disc)] {
            let [area, u] = ["value", "u"]
                .map(|of| number(found, &format!("/measures/area_mm2/{of}")).unwrap());
            assert!((area - truth).abs() < 2.0 * u, "{method}: {area} {truth} {u}");
            assert!((area / truth - 1.0).abs() < 0.012, "{method}: {area} {truth}");
        }
    }
}

/// What does not touch the border has the same figures with and without a layer about it.
#[test]
fn padding_changes_nothing_of_a_part_within() {
    let file = ball([19.7, 20.1, 20.3]);
    let [plain, padded] =
        [&[][..], &["--pad"]].map(|more: &[&str]| figures_of(&file, "nrrd", more).unwrap());
    assert_eq!(plain["volume"]["padded"], false);
    for part in ["volume", "topology", "measures", "mesh", "reasons"] {
        assert_eq!(plain[part], padded[part], "{part}");
    }
}
