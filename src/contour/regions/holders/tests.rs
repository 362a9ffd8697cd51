//! The holders that are found together against walks from each triangle.

use std::f64::consts::TAU;

use asphera_geometry::Numbers;

use super::{End, Holders};
use crate::regions::gabriel::obtuse_corner;
use crate::{PlaceMm, Samples, Triangulation};

/// Samples of a flower, of a circle, points at random and a lattice, whose centres lie on sides.
fn sets() -> Vec<Vec<PlaceMm>> {
    let flower = |leaves: f64| {
        let place = |index: u32| {
            let angle = TAU * f64::from(index) / 900.0;
            let radius = 10.0 + 3.0 * (leaves * angle).cos();
            [radius * angle.cos(), radius * angle.sin()]
        };
        (0..900).map(place).collect()
    };
    let numbers = Numbers::new(7, 0, 0);
    let random = (0..900).map(|index| [2 * index, 2 * index + 1].map(|it| numbers.uniform(it)));
    let lattice = (0..400).map(|index: u32| [f64::from(index % 20), 2.0 * f64::from(index / 20)]);
    let sheared = (0..400).map(|index: u32| {
        let [x, y] = [index % 20, index / 20].map(f64::from);
        [4.0 * x + y, y]
    });
    let narrow = (0..60).map(|index: u32| {
        let x = f64::from(index);
        [x, if index.is_multiple_of(2) { 0.0 } else { 0.25 }]
    });
    vec![
        flower(5.0),
        flower(0.0),
        random.collect(),
        lattice.collect(),
        sheared.collect(),
        narrow.collect(),
    ]
}

#[test]
fn those_found_together_are_those_of_single_walks() {
    for points in sets() {
        let set = Triangulation::new(Samples::new(&points).expect("finite points"));
        let holders = Holders::new(&set);
        let found = holders.found();
        for (triangle, found) in (0..).zip(found) {
            let centre = holders.centre_mm(triangle);
            let walked = match (obtuse_corner(&set, triangle), centre) {
                (None, _) => Some(triangle),
                (Some(_), None) => None,
                (Some(_), Some(centre)) => match holders.walked(triangle, centre, usize::MAX) {
                    End::Within(at) => Some(at),
                    End::Beyond(_) | End::Open => None,
                },
            };
            assert_eq!(found, walked, "triangle {triangle} of {} points", points.len());
            assert_eq!(holders.holder(triangle), walked);
        }
    }
}
