//! The area within points of a closed curve of any form.

use super::course::{Course, Noise, area_mm2};
use super::profile::Estimate;
use crate::PlaceMm;
use crate::triangulation::distance_mm;

/// The area within the points of a closed course, counter-clockwise.
///
/// That of the polygon, and κ·h³/12 for each of its sides h, κ the curvature there by three points a stride apart: what lies between side and
/// curve. Noise σ across the curve moves the area by σ times half of what lies between the neighbours. So u² = Σ (σ·h)². Of each corner
/// between two points what the polygon cuts off is lost: less than h²/4.
pub(super) fn enclosed_mm2(course: &Course, noise: &Noise) -> Estimate {
    let places_mm = course.places_mm();
    let count = places_mm.len();
    let at = |index: usize, steps: isize| {
        places_mm
            [(index as isize + steps * noise.stride as isize).rem_euclid(count as isize) as usize]
    };
    let curvatures: Vec<f64> =
        (0..count).map(|index| curvature([at(index, -1), at(index, 0), at(index, 1)])).collect();
    let (mut between, mut variance) = (0.0, 0.0);
    for index in 0..count {
        let next = (index + 1) % count;
        let side_mm = distance_mm(places_mm[index], places_mm[next]);
        let bend = 0.5 * (curvatures[index] + curvatures[next]);
        between += bend * side_mm.powi(3) / 12.0;
        let step_mm = distance_mm(at(index, -1), at(index, 1)) / (2 * noise.stride) as f64;
        variance += (noise.sigma_mm * step_mm).powi(2);
    }
    Estimate { value: area_mm2(places_mm) + between, u: variance.sqrt() }
}

/// Curvature of the circle through three places, left turns above 0; 0 where they turn too much for one curve.
fn curvature([p, q, r]: [PlaceMm; 3]) -> f64 {
    let crossed = (q[0] - p[0]) * (r[1] - q[1]) - (q[1] - p[1]) * (r[0] - q[0]);
    let along = (q[0] - p[0]) * (r[0] - q[0]) + (q[1] - p[1]) * (r[1] - q[1]);
    let product = distance_mm(p, q) * distance_mm(q, r) * distance_mm(p, r);
    let is_curve = crossed.atan2(along).abs() <= MOST_TURN && product > 0.0;
    if is_curve { 2.0 * crossed / product } else { 0.0 }
}

/// Largest turn from side to side that is not a corner, radians.
const MOST_TURN: f64 = 0.5;
