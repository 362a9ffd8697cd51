//! Where a simulated machine measures: places over the aperture, each beside the one before.

use std::f64::consts::{PI, TAU};

use asphera_measure::Part;

/// A place, (x, y) in mm in the part frame.
pub(super) type PlaceMm = [f64; 2];

/// Distance of places so that about so many lie in the aperture, mm; `None` where it has no area.
pub(super) fn spacing_mm(part: &Part, points: u64) -> Option<f64> {
    let spacing_mm = (part.aperture.area_mm2() / points as f64).sqrt();
    (spacing_mm.is_finite() && spacing_mm > 0.0).then_some(spacing_mm)
}

/// Lines along x, to and fro, from −y to +y; those of their places that lie in the aperture.
pub(super) fn raster(part: &Part, points: u64) -> Vec<PlaceMm> {
    let extents = part.aperture.half_extents_mm().zip(spacing_mm(part, points));
    let Some(([half_x_mm, half_y_mm], spacing_mm)) = extents else { return Vec::new() };
    let [columns, rows] = [half_x_mm, half_y_mm].map(|half_mm| count(half_mm, spacing_mm));
    let row = |row: usize| {
        let to_and_fro =
            move |along: usize| if row.is_multiple_of(2) { along } else { columns - 1 - along };
        (0..columns)
            .map(to_and_fro)
            .map(move |column| [along(half_x_mm, column, columns), along(half_y_mm, row, rows)])
    };
    inside(part, (0..rows).flat_map(row))
}

/// One line through the middle of the aperture, along x (0) or y (1), where the other axis stands still at `at_mm`.
pub(super) fn line(part: &Part, points: u64, axis: usize, at_mm: f64) -> Vec<PlaceMm> {
    let Some(half_mm) = part.aperture.half_extents_mm() else { return Vec::new() };
    let count = usize::try_from(points).unwrap_or(usize::MAX);
    let place = |index: usize| {
        let mut place = [at_mm - part.centre_mm[1 - axis]; 2];
        place[axis] = along(half_mm[axis], index, count);
        place
    };
    inside(part, (0..count).map(place))
}

/// A spiral from the axis outwards whose places stand for about equal areas, as radius in mm and angle in rad.
///
/// ρ_k = R·√((k+½)/N), θ = 2πρ/p with p = √(π·R²/N): the turns are about as far apart as the places along them.
pub(super) fn spiral(part: &Part, points: u64) -> Vec<[f64; 2]> {
    let Some(reach_mm) = part.aperture.reach_mm() else { return Vec::new() };
    let [x_mm, y_mm] = part.centre_mm;
    let reach_mm = reach_mm + x_mm.hypot(y_mm);
    let disc_mm2 = PI * reach_mm * reach_mm;
    let whole = points as f64 * disc_mm2 / part.aperture.area_mm2();
    let pitch_mm = (disc_mm2 / whole).sqrt();
    let turn = |k: u64| {
        let radius_mm = reach_mm * ((k as f64 + 0.5) / whole).sqrt();
        [radius_mm, TAU * radius_mm / pitch_mm]
    };
    let is_inside = |&[radius_mm, angle_rad]: &[f64; 2]| {
        let (sin, cos) = angle_rad.sin_cos();
        part.aperture.contains(radius_mm * cos - x_mm, radius_mm * sin - y_mm)
    };
    (0..whole as u64).map(turn).filter(is_inside).collect()
}

/// Places about the middle of the aperture that lie in it, in the part frame.
fn inside(part: &Part, places: impl Iterator<Item = PlaceMm>) -> Vec<PlaceMm> {
    let [x_mm, y_mm] = part.centre_mm;
    let places = places.filter(|[x, y]| part.aperture.contains(*x, *y));
    places.map(|[x, y]| [x + x_mm, y + y_mm]).collect()
}

fn count(half_mm: f64, spacing_mm: f64) -> usize {
    ((2.0 * half_mm / spacing_mm).round() as usize).max(1)
}

/// Middle of one of `count` equal pieces of a line, mm.
fn along(half_mm: f64, index: usize, count: usize) -> f64 {
    half_mm * ((2 * index + 1) as f64 / count as f64 - 1.0)
}

#[cfg(test)]
mod tests {
    use asphera_form::{Aperture, Nominal};

    use super::*;

    fn part(aperture: Aperture) -> Part {
        Part { aperture, centre_mm: [3.0, -1.0], ..Part::new(Nominal::Plane) }
    }

    #[test]
    fn each_place_lies_beside_the_one_before() {
        let square = part(Aperture::Rectangle { width_mm: 4.0, height_mm: 2.0 });
        let places = raster(&square, 800);
        assert_eq!(places.len(), 800);
        assert_eq!(places[0], [3.0 - 1.95, -1.0 - 0.95]);
        let steps = places.windows(2).map(|p| (p[1][0] - p[0][0]).hypot(p[1][1] - p[0][1]));
        assert!(steps.into_iter().all(|step| (step - 0.1).abs() < 1e-12));
    }

    #[test]
    fn a_spiral_stands_for_equal_areas() {
        let disc = Part { centre_mm: [0.0; 2], ..part(Aperture::Circle { radius_mm: 5.0 }) };
        let places = spiral(&disc, 1000);
        assert_eq!(places.len(), 1000);
        let within = places.iter().filter(|place| place[0] < 5.0 / 2_f64.sqrt()).count();
        assert_eq!(within, 500);
        let ring = part(Aperture::Annulus { inner_mm: 2.0, outer_mm: 5.0 });
        let places = spiral(&ring, 1000);
        assert!((950..1050).contains(&places.len()), "{}", places.len());
    }

    #[test]
    fn a_line_goes_through_the_middle() {
        let square = part(Aperture::Rectangle { width_mm: 4.0, height_mm: 2.0 });
        let places = line(&square, 4, 0, -1.0);
        assert_eq!(places, [[1.5, -1.0], [2.5, -1.0], [3.5, -1.0], [4.5, -1.0]]);
        assert!(line(&part(Aperture::None), 4, 0, 0.0).is_empty());
    }
}
