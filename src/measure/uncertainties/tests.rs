//! Tests of effects of the machine.

use super::*;

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
