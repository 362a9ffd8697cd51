//! Circle and deviation from a nominal outline.

use asphera_contour::PlaceMm;
use asphera_contour::features::{Circle, OutlineDeviation, minimum_zone};
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

/// The deviations of points from a nominal outline.
pub(super) fn deviation_from(
    nominal: &Nominal,
    points_mm: &[PlaceMm],
    u_mm: Option<f64>,
) -> Result<DeviationFigures, ContourError> {
    let outline = nominal.name();
    let found = nominal.outline().map(|outline| outline.deviations(points_mm));
    let extremes_mm = found.as_ref().and_then(OutlineDeviation::extremes_mm);
    let Some((found, [largest_mm, least_mm, rms_mm])) = found.zip(extremes_mm) else {
        return Err(ContourError::NothingOnCurve { outline: outline.to_owned() });
    };
    let at = |wanted: f64| {
        let index = found.deviations_mm.iter().position(|deviation| *deviation == wanted);
        points_mm[index.unwrap_or(0)]
    };
    let points = points_mm.len();
    Ok(DeviationFigures {
        outline: outline.to_owned(),
        points,
        largest_mm,
        largest_at_mm: at(largest_mm),
        least_mm,
        least_at_mm: at(least_mm),
        mean_mm: found.deviations_mm.iter().sum::<f64>() / points as f64,
        rms_mm,
        u_mm,
        deviations_mm: points_mm
            .iter()
            .zip(&found.deviations_mm)
            .map(|(&[x, y], &deviation)| [x, y, deviation])
            .collect(),
    })
}
