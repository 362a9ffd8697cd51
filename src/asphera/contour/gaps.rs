//! Gaps of a curve, closed where they are asked for.

use asphera_contour::gaps::{GapCurve, GapError, MOST_ENDS, gaps_of};
use asphera_contour::{FoundCurve, Kind, Method, Samples};
use asphera_report::contour::{ContourReport, GapFigures};

use super::report::line_mm;

/// Enters the gaps of a curve up to so many mm, and says of which ends nothing is known. Nothing where it is not asked for; a
/// region and a graph have none.
pub(super) fn close_gaps(
    report: &mut ContourReport,
    samples: &Samples,
    method: Method,
    curve: &FoundCurve,
    widest_mm: Option<f64>,
) {
    let Some(widest_mm) = widest_mm else { return };
    let of = match method.kind() {
        Kind::Region => Some("a region"),
        Kind::Graph => Some("a graph"),
        Kind::Curve => None,
    };
    if let Some(of) = of {
        let name = method.name();
        let why = format!("gaps: expected a method of curves, found {name}, which makes {of}");
        report.unknown.push(why);
        return;
    }
    let places_mm = curve.places_mm.as_deref().unwrap_or(samples.places());
    let sigma_mm = curve.sigma_mm.unwrap_or(0.0);
    let Some(gaps) = gaps_of(&curve.graph, places_mm, widest_mm, sigma_mm) else {
        let ends = report.ends.len();
        report.unknown.push(format!(
            "gaps: expected {MOST_ENDS} ends at most, found {ends}; choose a method that leaves fewer"
        ));
        return;
    };
    for gap in gaps {
        match across(&gap.curve, gap.ends.map(|end| places_mm[end as usize])) {
            Ok((kind, points_mm)) => report.gaps.push(GapFigures {
                ends: gap.ends.map(|end| samples.row_of(end)),
                width_mm: gap.width_mm,
                kind: kind.to_owned(),
                length_mm: line_mm(&points_mm, false),
                points_mm,
            }),
            Err(why) => report.unknown.push(why.to_string()),
        }
    }
}

type Line = (&'static str, Vec<[f64; 2]>);

fn across(curve: &Result<GapCurve, GapError>, ends_mm: [[f64; 2]; 2]) -> Result<Line, &GapError> {
    Ok(match curve.as_ref()? {
        GapCurve::Corner { at_mm } => ("corner", vec![ends_mm[0], *at_mm, ends_mm[1]]),
        GapCurve::Smooth { places_mm, .. } => ("smooth", places_mm.clone()),
    })
}
