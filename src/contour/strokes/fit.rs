//! Cubic Bézier curves along a line.

use super::StrokeLine;
use crate::PlaceMm;
use crate::bezier::at;
use crate::triangulation::distance_mm;

/// Cubic Bézier curves that follow a line: no place of it is farther off than a tolerance, as far as places are compared at equal shares of length.
///
/// Places are fitted by least squares with the directions of both ends held, at parameters by length, which are improved four times. Where that is not near enough the
/// line is cut at the worst place, and both halves have the direction from its place before to its place after. P. J. Schneider, Graphics Gems (1990) 612-626.
pub fn beziers_of(line: &StrokeLine, tolerance_mm: f64) -> Vec<[PlaceMm; 4]> {
    let mut places = line.places_mm.clone();
    places.dedup();
    if line.closed && places.len() > 2 {
        places.push(places[0]);
    }
    if places.len() < 2 {
        return Vec::new();
    }
    let last = places.len() - 1;
    let ends = match line.closed && last > 2 {
        true => {
            let along = unit(places[last - 1], places[1]);
            [along, along.map(|value| -value)]
        }
        false => [unit(places[0], places[1]), unit(places[last], places[last - 1])],
    };
    let mut curves = Vec::new();
    fit(&places, ends, tolerance_mm, &mut curves);
    curves
}

/// Fits places, `ends` the directions from both ends inwards.
fn fit(places: &[PlaceMm], ends: [[f64; 2]; 2], tolerance_mm: f64, curves: &mut Vec<[PlaceMm; 4]>) {
    let last = places.len() - 1;
    if last == 1 {
        curves.push(curve(places, ends, [distance_mm(places[0], places[1]) / 3.0; 2]));
        return;
    }
    let mut shares = by_length(places);
    let mut worst = (f64::INFINITY, last / 2);
    for _ in 0..ROUNDS {
        let found = curve(places, ends, handles_mm(places, ends, &shares));
        let off = |index: usize| distance_mm(places[index], at(&found, shares[index]));
        worst = (1..last)
            .map(|index| (off(index), index))
            .fold((0.0, last / 2), |worst, it| if it.0 > worst.0 { it } else { worst });
        if worst.0 <= tolerance_mm {
            curves.push(found);
            return;
        }
        improve(&found, places, &mut shares);
    }
    let middle = worst.1;
    let along = unit(places[middle + 1], places[middle - 1]);
    fit(&places[..=middle], [ends[0], along], tolerance_mm, curves);
    fit(&places[middle..], [along.map(|value| -value), ends[1]], tolerance_mm, curves);
}

fn curve(places: &[PlaceMm], ends: [[f64; 2]; 2], handles_mm: [f64; 2]) -> [PlaceMm; 4] {
    let [first, last] = [places[0], places[places.len() - 1]];
    let inner = |from: PlaceMm, along: [f64; 2], by_mm: f64| {
        [from[0] + by_mm * along[0], from[1] + by_mm * along[1]]
    };
    [first, inner(first, ends[0], handles_mm[0]), inner(last, ends[1], handles_mm[1]), last]
}

/// The lengths of both handles by least squares; a third of the chord where these are none.
fn handles_mm(places: &[PlaceMm], ends: [[f64; 2]; 2], shares: &[f64]) -> [f64; 2] {
    let [first, last] = [places[0], places[places.len() - 1]];
    let (mut matrix, mut right) = ([[0.0; 2]; 2], [0.0; 2]);
    for (place, &t) in places.iter().zip(shares) {
        let s = 1.0 - t;
        let weights = [3.0 * s * s * t, 3.0 * s * t * t];
        let [from, to] = [s * s * s + weights[0], t * t * t + weights[1]];
        for axis in 0..2 {
            let terms = [weights[0] * ends[0][axis], weights[1] * ends[1][axis]];
            let missing = place[axis] - from * first[axis] - to * last[axis];
            for row in 0..2 {
                right[row] += terms[row] * missing;
                for column in 0..2 {
                    matrix[row][column] += terms[row] * terms[column];
                }
            }
        }
    }
    let determinant = matrix[0][0] * matrix[1][1] - matrix[0][1] * matrix[1][0];
    let chord_mm = distance_mm(first, last);
    let found = [
        (right[0] * matrix[1][1] - right[1] * matrix[0][1]) / determinant,
        (matrix[0][0] * right[1] - matrix[1][0] * right[0]) / determinant,
    ];
    match found.iter().all(|&handle_mm| handle_mm.is_finite() && handle_mm > 1e-6 * chord_mm) {
        true => found,
        false => [chord_mm / 3.0; 2],
    }
}

/// One step of Newton's method towards the nearest parameter of each place.
fn improve(curve: &[PlaceMm; 4], places: &[PlaceMm], shares: &mut [f64]) {
    for (place, share) in places.iter().zip(shares) {
        let [x, y] = at(curve, *share);
        let off = [x - place[0], y - place[1]];
        let [dx, dy] = crate::bezier::slope(curve, *share);
        let [ddx, ddy] = crate::bezier::bend(curve, *share);
        let step = (off[0] * dx + off[1] * dy) / (dx * dx + dy * dy + off[0] * ddx + off[1] * ddy);
        if step.is_finite() {
            *share = (*share - step).clamp(0.0, 1.0);
        }
    }
}

/// The share of the length up to each place.
fn by_length(places: &[PlaceMm]) -> Vec<f64> {
    let mut lengths = vec![0.0];
    let mut length_mm = 0.0;
    for pair in places.windows(2) {
        length_mm += distance_mm(pair[0], pair[1]);
        lengths.push(length_mm);
    }
    lengths.iter().map(|length| length / length_mm).collect()
}

fn unit(from: PlaceMm, to: PlaceMm) -> [f64; 2] {
    let length_mm = distance_mm(from, to);
    if length_mm == 0.0 {
        [1.0, 0.0]
    } else {
        [(to[0] - from[0]) / length_mm, (to[1] - from[1]) / length_mm]
    }
}

/// How often parameters are improved.
const ROUNDS: usize = 5;
