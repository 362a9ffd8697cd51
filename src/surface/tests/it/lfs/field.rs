//! Bounds everywhere from a few places, and bounds from curvature.

use asphera_geometry::PointMm;
use asphera_surface::lfs::{Curvature, Lfs, LfsField, LfsNode, reach_floor_mm};
use proptest::prelude::*;

use super::bodies::{Sampled, ellipsoid, sheets, torus};

const EXACT: Sampled = Sampled { spacing_mm: 0.4, noise_mm: 0.0, tilt_rad: 0.0 };

fn known(mm: f64) -> Lfs {
    Lfs::Known { mm, lower_mm: mm, upper_mm: mm }
}

#[test]
fn a_thinned_set_bounds_all_places() {
    for sample in [torus(EXACT, 12.0, 5.0), ellipsoid(EXACT, 15.0, 8.0)] {
        let mut asked = 0;
        let truth = |at: PointMm| {
            let found = sample.points.iter().position(|&point| point == at).unwrap();
            known(sample.lfs_mm[found])
        };
        let field = LfsField::thinned(&sample.points, 0.4, 1e-3, |at| {
            asked += 1;
            truth(at)
        })
        .unwrap();
        assert!(field.nodes().len() <= asked && 2 * asked < sample.points.len(), "{asked}");
        for (&point, &lfs_mm) in sample.points.iter().zip(&sample.lfs_mm) {
            let bounds = field.at(point);
            let rounding_mm = 1e-12 * lfs_mm;
            assert!(bounds.lower_mm <= lfs_mm + rounding_mm, "{bounds:?}, but {lfs_mm}");
            assert!(bounds.upper_mm >= lfs_mm - rounding_mm, "{bounds:?}, but {lfs_mm}");
            assert!(bounds.error() <= 0.4 / 0.6, "{bounds:?}");
        }
    }
}

#[test]
fn where_nothing_is_known_all_cubes_have_a_node() {
    let points: Vec<PointMm> = (0..100).map(|i| [f64::from(i), 0.0, 0.0]).collect();
    let field = LfsField::thinned(&points, 0.5, 0.1, |_| Lfs::Hidden { upper_mm: 3.0 }).unwrap();
    assert_eq!(field.nodes().len(), 100);
    let bounds = field.at([4.5, 0.0, 0.0]);
    assert_eq!((bounds.lower_mm, bounds.upper_mm, bounds.error()), (0.0, 3.5, f64::INFINITY));
    let endless = |_| Lfs::Beyond { lower_mm: f64::INFINITY };
    let plane = LfsField::thinned(&points, 0.5, 0.1, endless).unwrap();
    assert_eq!(plane.nodes().len(), 1);
    let bounds = plane.at([50.0, 3.0, 0.0]);
    assert_eq!((bounds.lower_mm, bounds.error()), (f64::INFINITY, 0.0));
}

#[test]
fn bounds_that_contradict_each_other_give_the_upper_one() {
    let node = |x, lower_mm, upper_mm| LfsNode { at_mm: [x, 0.0, 0.0], lower_mm, upper_mm };
    let mut field = LfsField::new([node(0.0, 10.0, 11.0)]).unwrap();
    assert_eq!(field.at([1.0, 0.0, 0.0]).lower_mm, 9.0);
    field.extend([node(2.0, 1.0, 2.0)]).unwrap();
    let bounds = field.at([1.0, 0.0, 0.0]);
    assert_eq!((bounds.lower_mm, bounds.upper_mm), (3.0, 3.0));
    for refused in [node(0.0, 2.0, 1.0), node(0.0, -1.0, 1.0), node(0.0, f64::NAN, 1.0)] {
        assert!(field.extend([node(9.0, 0.0, 1.0), refused]).is_err());
        assert_eq!(field.nodes().len(), 2);
    }
    assert!(field.extend([node(f64::NAN, 0.0, 1.0)]).is_err());
    let nowhere = field.at([f64::NAN; 3]);
    assert_eq!((nowhere.lower_mm, nowhere.upper_mm), (0.0, f64::INFINITY));
    let empty = LfsField::default().at([0.0; 3]);
    assert_eq!((empty.lower_mm, empty.upper_mm), (0.0, f64::INFINITY));
}

#[test]
fn a_field_that_cannot_be_thinned() {
    let thinned = |fraction, smallest_mm, z| {
        LfsField::thinned(&[[0.0, 0.0, z]], fraction, smallest_mm, |_| known(1.0)).is_ok()
    };
    assert!(thinned(0.1, 1.0, 0.0));
    assert!(!thinned(0.0, 1.0, 0.0) && !thinned(1.0, 1.0, 0.0) && !thinned(f64::NAN, 1.0, 0.0));
    assert!(!thinned(0.1, 0.0, 0.0) && !thinned(0.1, 1.0, f64::INFINITY));
}

proptest! {
    #[test]
    fn both_bounds_change_by_no_more_than_the_way(
        nodes in prop::collection::vec(([-9.0..9.0, -9.0..9.0, -9.0..9.0_f64], 0.0..5.0_f64), 1..60),
        from in [-9.0..9.0, -9.0..9.0, -9.0..9.0_f64],
        to in [-9.0..9.0, -9.0..9.0, -9.0..9.0_f64],
    ) {
        let nodes = nodes.iter().map(|&(at_mm, mm)| LfsNode { at_mm, lower_mm: mm, upper_mm: mm });
        let field = LfsField::new(nodes.clone()).unwrap();
        let way = |a: PointMm, b: PointMm| (0..3).map(|i| (a[i] - b[i]).powi(2)).sum::<f64>().sqrt();
        let (a, b) = (field.at(from), field.at(to));
        prop_assert!((a.upper_mm - b.upper_mm).abs() <= way(from, to) + 1e-12);
        prop_assert!((a.lower_mm - b.lower_mm).abs() <= way(from, to) + 1e-12);
        let least = nodes.map(|node| node.upper_mm + way(from, node.at_mm)).fold(f64::INFINITY, f64::min);
        prop_assert_eq!(a.upper_mm, least);
    }
}

/// Curvature alone bounds lfs from above; with the neck, also from below.
#[test]
fn what_curvature_bounds() {
    let (ring_mm, tube_mm) = (12.0, 8.0);
    let sample = torus(EXACT, ring_mm, tube_mm);
    let curvatures = sample.points.iter().map(|[x, y, _]| {
        let around = (x.hypot(*y) - ring_mm) / tube_mm / x.hypot(*y);
        Curvature::new(around.abs().max(1.0 / tube_mm), 1e-3).unwrap()
    });
    let curvatures: Vec<Curvature> = curvatures.collect();
    let floor_mm = reach_floor_mm(curvatures.iter().copied(), ring_mm - tube_mm).unwrap().unwrap();
    for (curvature, &lfs_mm) in curvatures.iter().zip(&sample.lfs_mm) {
        assert!(curvature.ceiling_mm().unwrap() >= lfs_mm && floor_mm <= lfs_mm);
    }
    let flat = Curvature::new(0.0, 0.0).unwrap();
    let sheets = sheets(EXACT, 4.0, 3.0);
    // Sheets: no curvature, and yet a feature size.
    assert_eq!((flat.ceiling_mm(), flat.radius_floor_mm()), (None, f64::INFINITY));
    assert_eq!(reach_floor_mm([flat], 1.5).unwrap(), Some(sheets.lfs_mm[0]));
    assert_eq!(reach_floor_mm([], 1.5).unwrap(), None);
    assert!(reach_floor_mm([flat], 0.0).is_err() && reach_floor_mm([flat], f64::NAN).is_err());
    assert_eq!(Curvature::new(-0.5, 0.3).unwrap().ceiling_mm(), Some(5.0));
    assert_eq!(Curvature::new(0.1, 0.2).unwrap().ceiling_mm(), None);
    assert!(Curvature::new(f64::NAN, 0.0).is_err() && Curvature::new(1.0, -1.0).is_err());
}
