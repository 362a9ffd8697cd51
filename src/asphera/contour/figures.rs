//! Circle and deviation from a nominal outline.

use asphera_contour::PlaceMm;
use asphera_contour::features::{Circle, minimum_zone};
use asphera_report::contour::{CircleFigures, DeviationFigures};

use super::{ContourError, Nominal};

/// Points are those of a circle where their roundness is at most this share of the height of the arc that they span: of its
/// diameter, if they lie all round. A flat curve is no small piece of a large circle.
const ROUND: f64 = 0.05;

/// Least points of a circle: the corners of a rectangle lie on one exactly, and say nothing of its uncertainty.
const LEAST_OF_CIRCLE: usize = 9;

/// The circle of the points of a curve, or why there is none though they lie on one; neither where they are far from a circle.
pub(super) fn circle_of(
    points_mm: &[PlaceMm],
    is_closed: bool,
) -> Option<Result<CircleFigures, String>> {
    let circle = Circle::fit(points_mm)?;
    let half_span_rad = 0.5 * circle.span_deg.to_radians();
    let height_mm = 0.5 * circle.diameter_mm * (1.0 - half_span_rad.cos());
    if circle.roundness_mm > ROUND * height_mm {
        return None;
    }
    let points = points_mm.len();
    if points < LEAST_OF_CIRCLE {
        return Some(Err(format!(
            "circle: {points} points lie near one, too few to tell their noise from their form; {LEAST_OF_CIRCLE} or more are needed"
        )));
    }
    Some(Ok(CircleFigures {
        points,
        centre_mm: circle.centre_mm,
        u_centre_mm: circle.u_centre_mm,
        diameter_mm: circle.diameter_mm,
        u_diameter_mm: circle.u_diameter_mm,
        roundness_mm: circle.roundness_mm,
        u_roundness_mm: circle.u_roundness_mm,
        roundness_zone_mm: minimum_zone(points_mm, circle.centre_mm, 0.5 * circle.diameter_mm)
            .map(|zone| zone.width_mm),
        noise_sigma_mm: circle.noise_sigma_mm,
        span_deg: if is_closed { 360.0 } else { circle.span_deg },
    }))
}

/// The deviations of points from a nominal outline, none where all lie beyond its ends; and what is not known of them.
pub(super) fn deviation_from(
    nominal: &Nominal,
    points_mm: &[PlaceMm],
    u_mm: Option<f64>,
) -> Result<(Option<DeviationFigures>, Option<String>), ContourError> {
    let outline = nominal.name();
    let nothing = || ContourError::NothingOnCurve { outline: outline.to_owned() };
    let found = nominal.outline().ok_or_else(nothing)?.deviations(points_mm);
    if points_mm.is_empty() {
        return Err(nothing());
    }
    let beyond = found.deviations_mm.iter().filter(|deviation| deviation.is_none()).count();
    let first = found.deviations_mm.iter().position(Option::is_none);
    let unknown = first.map(|first| {
        let [x, y] = points_mm[first];
        format!(
            "deviation: {beyond} of {} points lie beyond the ends of an open line of the outline, as at {x:.4}, {y:.4} mm, and have none",
            points_mm.len()
        )
    });
    let Some([largest_mm, least_mm, rms_mm]) = found.extremes_mm() else {
        return Ok((None, unknown));
    };
    let deviations_mm: Vec<[f64; 3]> = points_mm
        .iter()
        .zip(&found.deviations_mm)
        .filter_map(|(&[x, y], &deviation)| Some([x, y, deviation?]))
        .collect();
    let at = |wanted: f64| {
        let found = deviations_mm.iter().find(|[_, _, deviation]| *deviation == wanted);
        found.map_or(points_mm[0], |&[x, y, _]| [x, y])
    };
    let points = deviations_mm.len();
    let figures = DeviationFigures {
        outline: outline.to_owned(),
        points,
        beyond_ends: beyond,
        largest_mm,
        largest_at_mm: at(largest_mm),
        least_mm,
        least_at_mm: at(least_mm),
        mean_mm: deviations_mm.iter().map(|[_, _, deviation]| deviation).sum::<f64>()
            / points as f64,
        rms_mm,
        u_mm,
        deviations_mm,
    };
    Ok((Some(figures), unknown))
}
