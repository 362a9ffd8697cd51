//! Areas of outlines with sides too short for a fit, whose corners points cut off.

use asphera_contour::PlaceMm;
use asphera_contour::features::{Course, Profile};
use asphera_geometry::Numbers;
use asphera_geometry::outline::ring_area_mm2;

use crate::places::distance;

/// Points along a polygon at equal lengths, with normal noise across it.
fn along(corners: &[PlaceMm], count: usize, sigma: f64, draw: u32) -> Vec<PlaceMm> {
    let (noise, shift) = (Numbers::new(17, draw, 0), Numbers::new(17, draw, 1).uniform(0));
    let side = |index: usize| [corners[index], corners[(index + 1) % corners.len()]];
    let lengths: Vec<f64> = (0..corners.len()).map(side).map(|[p, q]| distance(p, q)).collect();
    let whole: f64 = lengths.iter().sum();
    let point = |index: usize| {
        let mut way = whole * (index as f64 + shift) / count as f64;
        let mut at = 0;
        while way > lengths[at] {
            way -= lengths[at];
            at += 1;
        }
        let [[x, y], [to_x, to_y]] = side(at);
        let [ux, uy] = [(to_x - x) / lengths[at], (to_y - y) / lengths[at]];
        let off = sigma * noise.normal(index);
        [x + way * ux + off * uy, y + way * uy - off * ux]
    };
    (0..count).map(point).collect()
}

#[test]
fn areas_hold_where_points_cut_corners_off() {
    let draws = if std::env::var_os("ASPHERA_LONG").is_some() { 2000 } else { 100 };
    let plate = [[0.0, 0.0], [10.0, 0.0], [10.0, 8.0], [6.0, 8.0]];
    let notch = [&plate[..], &[[6.0, 7.0], [5.0, 7.0], [5.0, 8.0], [0.0, 8.0]]].concat();
    let step = [&plate[..], &[[6.0, 7.3], [0.0, 7.3]]].concat();
    for (name, corners) in [("notch", notch), ("step", step)] {
        let truth = ring_area_mm2(&corners);
        let (mut held, mut sum) = (0, 0.0);
        for draw in 0..draws {
            let points = along(&corners, 150, 1e-3, draw);
            let profile = Profile::new(&Course::new(points, true), 0.0);
            assert!(profile.perimeter_mm.is_none(), "{name}: {profile:#?}");
            let area = profile.area_mm2.unwrap();
            held += u32::from((area.value - truth).abs() <= 1.96 * area.u);
            sum += (area.value - truth) / f64::from(draws);
        }
        let percent = 100.0 * f64::from(held) / f64::from(draws);
        println!("{name}: {percent:.2} % of {draws}, mean error {sum:.5} mm²");
        // Of few draws the share itself scatters: three standard deviations of it.
        let bar = if draws == 2000 { 2.0 } else { 300.0 * (0.95 * 0.05 / f64::from(draws)).sqrt() };
        assert!((percent - 95.0).abs() <= bar.max(2.0) && sum.abs() < 0.002, "{name}: {percent}");
    }
}
