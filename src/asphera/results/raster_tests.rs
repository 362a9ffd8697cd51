//! The file of the deviation map of a raster, against the points.

use asphera_formats::{Topography, x3p};
use asphera_measure::{Along, Pipeline};

const FLAT: &str = "[surface]\nkind = \"plane\"\n[fit]\nfree = [\"tz\", \"rx\", \"ry\"]\n";
const PITCH_MM: f64 = 0.1;
const SIDE: usize = 72;

/// A raster turned by an angle, with heights of some 30 nm and some nodes lost.
fn raster(turn_rad: f64) -> Vec<[f64; 3]> {
    let (sin, cos) = turn_rad.sin_cos();
    let middle = 0.5 * (SIDE - 1) as f64;
    let nodes = (0..SIDE * SIDE).filter(|node| node % 101 != 17);
    let point = |node: usize| {
        let [u, v] = [node % SIDE, node / SIDE].map(|at| PITCH_MM * (at as f64 - middle));
        // Multiples of the golden ratio scatter evenly.
        let height_nm = 100.0 * ((node as f64 * 0.618_033_988_75).fract() - 0.5);
        [5.0 + cos * u - sin * v, sin * u + cos * v - 3.0, height_nm * 1e-6]
    };
    nodes.map(point).collect()
}

#[test]
fn the_file_of_a_raster_holds_what_was_measured() {
    for turn_rad in [0.0, 0.3] {
        let part = asphera_nominal::parse("flat.toml", FLAT).unwrap();
        let mut pipeline = Pipeline::along(part, Along::default());
        pipeline.take_positions(raster(turn_rad));
        let measurement = pipeline.finish();
        let folder =
            std::env::temp_dir().join(format!("asphera-raster-{}-{turn_rad}", std::process::id()));
        super::write(&folder, &measurement).unwrap();
        let file = x3p::read(&std::fs::read(folder.join("deviation.x3p")).unwrap()).unwrap();
        std::fs::remove_dir_all(&folder).unwrap();
        assert_eq!(matches!(file, Topography::Map(..)), turn_rad == 0.0);
        assert!(file.source().comment.as_ref().unwrap().contains("as measured"));
        // The mesh has the points in an order of its own.
        let by_place = |points: &mut Vec<[f64; 3]>| {
            let key = |place: f64| (place * 1e6).round();
            points.sort_by(|a, b| {
                key(a[0]).total_cmp(&key(b[0])).then(key(a[1]).total_cmp(&key(b[1])))
            });
        };
        let mut read: Vec<[f64; 3]> = file.points().collect();
        let deviations = measurement.points_mm.iter().zip(&measurement.deviations_nm);
        let mut expected: Vec<[f64; 3]> =
            deviations.map(|([x, y, _], nm)| [*x, *y, nm * 1e-6]).collect();
        by_place(&mut read);
        by_place(&mut expected);
        assert_eq!(read.len(), expected.len());
        for (read, expected) in read.iter().zip(&expected) {
            let off = (0..3).map(|axis| (read[axis] - expected[axis]).abs());
            assert!(off.fold(0.0, f64::max) < 1e-9, "{read:?}, not {expected:?}");
        }
    }
}
