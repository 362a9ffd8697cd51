//! The report of strokes: labelled regions, closed gaps, and the lines between regions.

use asphera_contour::strokes::{Strokes, beziers_of, closing_gap_mm};
use asphera_contour::{Method, Parameters, Triangulation};
use asphera_report::contour::{ChainFigures, ContourReport, GapFigures};

use super::report::{line_mm, region_report};

/// The report of what a method made of strokes; Bézier curves follow its lines within a tolerance, 0 for half a spacing.
pub(super) fn strokes_report(
    triangulation: &Triangulation,
    method: Method,
    parameters: &Parameters,
    strokes: &Strokes,
    tolerance_mm: f64,
) -> ContourReport {
    let samples = triangulation.samples();
    let half_spacing_mm = closing_gap_mm(triangulation).unwrap_or(0.0) / 6.0;
    let tolerance_mm = if tolerance_mm > 0.0 { tolerance_mm } else { half_spacing_mm };
    let mut report = region_report(triangulation, method, parameters, &strokes.region);
    for (figures, part) in report.regions.iter_mut().flatten().zip(strokes.region.parts()) {
        figures.label = strokes.labels.get(part.label as usize - 1).cloned();
    }
    report.gaps = strokes
        .gaps
        .iter()
        .map(|&ends| {
            let points_mm = ends.map(|end| triangulation.place(end)).to_vec();
            let length_mm = line_mm(&points_mm, false);
            GapFigures {
                ends: ends.map(|end| samples.row_of(end)),
                width_mm: length_mm,
                kind: "straight".to_owned(),
                length_mm,
                points_mm,
            }
        })
        .collect();
    report.chains = strokes
        .lines
        .iter()
        .map(|line| ChainFigures {
            closed: line.closed,
            length_mm: line_mm(&line.places_mm, line.closed),
            points_mm: line.places_mm.clone(),
        })
        .collect();
    report.beziers_mm = strokes.lines.iter().map(|line| beziers_of(line, tolerance_mm)).collect();
    report.unknown.retain(|why| !why.starts_with("kind: "));
    report.unknown.push("kind: points are taken for samples of lines between regions".to_owned());
    report
}
