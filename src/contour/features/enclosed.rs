//! The area within points of a closed curve of any form.

use super::course::{Course, Noise, area_mm2};
use super::cut_corner::{CutCorner, MOST_TURN, turn};
use super::profile::Estimate;
use crate::PlaceMm;
use crate::triangulation::distance_mm;

/// The area within the points of a closed course, counter-clockwise.
///
/// That of the polygon, and κ·h³/12 for each of its sides h, κ the curvature there by three points a stride apart: what lies between side and
/// curve. A side across a corner has the triangle that it cuts off instead ([`CutCorner`]). Where points do not show what it cuts off, half
/// of the most is added. Then
///
/// u² = Σ (σ·h)² + Σ v + (Σ m)²/12
///
/// σ is the noise across the curve, which moves the area by half of what lies between the neighbours; v the variance of a sharp corner; m the
/// most that a side may cut off, anything up to it as likely, and alike at all of them.
pub(super) fn enclosed_mm2(course: &Course, noise: &Noise) -> Estimate {
    let places_mm = course.places_mm();
    let count = places_mm.len();
    let at = |index: usize, steps: isize| {
        places_mm
            [(index as isize + steps * noise.stride as isize).rem_euclid(count as isize) as usize]
    };
    let mut curvatures: Vec<f64> =
        (0..count).map(|index| curvature([at(index, -1), at(index, 0), at(index, 1)])).collect();
    let corners = cut_corners(places_mm, noise);
    let is_sharp = |index: usize| matches!(corners[index % count], CutCorner::Sharp(..));
    for index in (0..count).filter(|&index| is_sharp(index)) {
        (curvatures[index], curvatures[(index + 1) % count]) = (0.0, 0.0);
    }
    let (mut between, mut variance, mut blurred_mm2) = (0.0, 0.0, 0.0);
    for index in 0..count {
        let next = (index + 1) % count;
        let side_mm = distance_mm(places_mm[index], places_mm[next]);
        let bend = 0.5 * (curvatures[index] + curvatures[next]);
        match corners[index] {
            CutCorner::Sharp(area_mm2, variance_mm4) => {
                between += area_mm2;
                variance += variance_mm4;
            }
            // Beside a sharp corner the way turns at the corner alone.
            CutCorner::Blurred(most_mm2) if !is_sharp(index + count - 1) && !is_sharp(next) => {
                between += 0.5 * most_mm2;
                blurred_mm2 += most_mm2.abs();
            }
            CutCorner::Blurred(_) | CutCorner::None => between += bend * side_mm.powi(3) / 12.0,
        }
        let step_mm = distance_mm(at(index, -1), at(index, 1)) / (2 * noise.stride) as f64;
        variance += (noise.sigma_mm * step_mm).powi(2);
    }
    variance += blurred_mm2 * blurred_mm2 / 12.0;
    Estimate { value: area_mm2(places_mm) + between, u: variance.sqrt() }
}

/// What every side cuts off; nothing where noise is so wide that points more than a step apart show the curve.
fn cut_corners(places_mm: &[PlaceMm], noise: &Noise) -> Vec<CutCorner> {
    let count = places_mm.len();
    let six =
        |index: usize| [0, 1, 2, 3, 4, 5].map(|step| places_mm[(index + count + step - 2) % count]);
    let between = |index: usize| match noise.stride {
        1 => CutCorner::between(six(index), noise.sigma_mm),
        _ => CutCorner::None,
    };
    (0..count).map(between).collect()
}

/// Curvature of the circle through three places, left turns above 0; 0 where they turn too much for one curve.
fn curvature([p, q, r]: [PlaceMm; 3]) -> f64 {
    let crossed = (q[0] - p[0]) * (r[1] - q[1]) - (q[1] - p[1]) * (r[0] - q[0]);
    let product = distance_mm(p, q) * distance_mm(q, r) * distance_mm(p, r);
    let is_curve = turn([p, q, r]).abs() <= MOST_TURN && product > 0.0;
    if is_curve { 2.0 * crossed / product } else { 0.0 }
}
