//! Circle and deviation from a nominal outline, as the command writes them.

use std::fmt::Write as _;
use std::path::Path;

use asphera_contour::PlaceMm;
use asphera_contour::features::{Circle, NominalOutline, minimum_zone};
use asphera_contour::sampler::BezierLine;
use asphera_formats::drawing::{DrawnLine, read_dxf, read_svg};
use serde::{Deserialize, Serialize};

use super::places;
use super::report::ContourReport;
use crate::cli::files::read;
use crate::cli::output::Failure;
use crate::cli::progress::Progress;
use crate::cli::summary::short;
use crate::cli::text::TextArgs;

/// The circle of the points of one curve. Lengths are mm; `u_` are standard uncertainties by the scatter of the points.
#[derive(Debug, Deserialize, PartialEq, Serialize)]
pub(in crate::cli) struct CircleFigures {
    /// How many points it is fitted to.
    pub(in crate::cli) points: usize,
    /// Least-squares circle.
    pub(in crate::cli) centre_mm: PlaceMm,
    pub(in crate::cli) u_centre_mm: [f64; 2],
    pub(in crate::cli) diameter_mm: f64,
    pub(in crate::cli) u_diameter_mm: f64,
    /// Roundness deviation about it, unfiltered: noise makes it too large, by 2·u at most in 95 of 100 cases.
    pub(in crate::cli) roundness_mm: f64,
    pub(in crate::cli) u_roundness_mm: f64,
    /// The same about the centre of the minimum zone; its uncertainty is not known.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(in crate::cli) roundness_zone_mm: Option<f64>,
    /// Noise of the points, from neighbours.
    pub(in crate::cli) noise_sigma_mm: f64,
    /// Angle that the points span.
    pub(in crate::cli) span_deg: f64,
}

/// Deviations from the nominal outline as it lies: outside, and in its holes, above 0. Lengths are mm.
#[derive(Debug, Deserialize, PartialEq, Serialize)]
pub(in crate::cli) struct DeviationFigures {
    /// The file of the outline.
    pub(in crate::cli) outline: String,
    /// How many points were held against it.
    pub(in crate::cli) points: usize,
    pub(in crate::cli) largest_mm: f64,
    pub(in crate::cli) largest_at_mm: PlaceMm,
    pub(in crate::cli) least_mm: f64,
    pub(in crate::cli) least_at_mm: PlaceMm,
    pub(in crate::cli) mean_mm: f64,
    pub(in crate::cli) rms_mm: f64,
    /// Standard uncertainty of the deviation of a point: its noise. Absent where noise was not estimated.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(in crate::cli) u_mm: Option<f64>,
    /// x, y and deviation of every point, by x, then y.
    pub(in crate::cli) deviations_mm: Vec<[f64; 3]>,
}

/// A circle is told where its roundness is at most this share of its diameter.
const ROUND: f64 = 0.05;

impl CircleFigures {
    /// The circle of points; none where they are far from one.
    pub(super) fn of(points_mm: &[PlaceMm]) -> Option<CircleFigures> {
        let circle = Circle::fit(points_mm)?;
        (circle.roundness_mm <= ROUND * circle.diameter_mm).then(|| CircleFigures {
            points: points_mm.len(),
            centre_mm: circle.centre_mm,
            u_centre_mm: circle.u_centre_mm,
            diameter_mm: circle.diameter_mm,
            u_diameter_mm: circle.u_diameter_mm,
            roundness_mm: circle.roundness_mm,
            u_roundness_mm: circle.u_roundness_mm,
            roundness_zone_mm: minimum_zone(points_mm, circle.centre_mm, 0.5 * circle.diameter_mm)
                .map(|zone| zone.width_mm),
            noise_sigma_mm: circle.noise_sigma_mm,
            span_deg: circle.span_deg,
        })
    }

    /// The lines of the summary.
    pub(super) fn write_summary(&self, text: &mut String) -> std::fmt::Result {
        let [x, y] = self.centre_mm.map(short);
        writeln!(
            text,
            "circle     diameter {:.6} mm, u {} mm, centre {x}, {y} mm, over {:.0}°",
            self.diameter_mm,
            short(self.u_diameter_mm),
            self.span_deg
        )?;
        write!(
            text,
            "roundness  {} mm (least squares), u {} mm",
            short(self.roundness_mm),
            short(self.u_roundness_mm)
        )?;
        if let Some(zone_mm) = self.roundness_zone_mm {
            write!(text, ", {} mm (minimum zone)", short(zone_mm))?;
        }
        writeln!(text)
    }
}

impl DeviationFigures {
    /// The deviations of points from the outline of a file.
    pub(super) fn of(
        path: &Path,
        points_mm: &[PlaceMm],
        u_mm: Option<f64>,
    ) -> Result<DeviationFigures, Failure> {
        let name = path.display().to_string();
        let outline = NominalOutline::new(&nominal(path)?)
            .ok_or_else(|| format!("{name}: expected an outline, found no line"))?;
        let found = outline.deviations(points_mm);
        let Some([largest_mm, least_mm, rms_mm]) = found.extremes_mm() else {
            return Err(format!("{name}: no point lies on a curve to be held against it").into());
        };
        let at = |wanted: f64| {
            let index = found.deviations_mm.iter().position(|deviation| *deviation == wanted);
            points_mm[index.unwrap_or(0)]
        };
        let points = points_mm.len();
        Ok(DeviationFigures {
            outline: name,
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

    /// The line of the summary.
    pub(super) fn write_summary(&self, text: &mut String) -> std::fmt::Result {
        let at = |[x, y]: PlaceMm| format!("{}, {} mm", short(x), short(y));
        writeln!(
            text,
            "deviation  {} mm at {} to {} mm at {}, RMS {} mm, from {}",
            short(self.least_mm),
            at(self.least_at_mm),
            short(self.largest_mm),
            at(self.largest_at_mm),
            short(self.rms_mm),
            self.outline
        )
    }
}

/// The lines of a nominal outline: a drawing, what `contour --json` wrote, or the corners of a polygon in order.
fn nominal(path: &Path) -> Result<Vec<BezierLine>, Failure> {
    let name = path.display();
    let ending = path.extension().map(|ending| ending.to_string_lossy().to_lowercase());
    let drawn = |lines: Vec<DrawnLine>| -> Vec<BezierLine> {
        let line = |DrawnLine { pieces, closed }| BezierLine { pieces, closed };
        lines.into_iter().map(line).collect()
    };
    let named =
        |error: asphera_formats::ReadError| -> Failure { format!("{name}: {error}").into() };
    Ok(match ending.as_deref() {
        Some("svg") => drawn(read_svg(&read(path)?).map_err(named)?),
        Some("dxf") => drawn(read_dxf(&read(path)?).map_err(named)?),
        Some("json") => {
            let report: ContourReport = serde_json::from_slice(&read(path)?)
                .map_err(|error| format!("{name}: expected what contour --json writes: {error}"))?;
            let lines = report.chains.iter();
            lines.map(|chain| BezierLine::through(&chain.points_mm, chain.closed)).collect()
        }
        _ => {
            let corners = places(path, &TextArgs::default(), &Progress::start("outline"))?;
            vec![BezierLine::through(&corners, true)]
        }
    })
}
