//! The figures of a section as a person reads them.

use std::fmt::Write as _;

use asphera_report::SectionReport;
use asphera_report::words::with_u;

use crate::cli::summary::{plain, short};

/// The figures as a person reads them.
pub(super) fn summary(report: &SectionReport) -> String {
    let mut text = String::new();
    // Writing into a String cannot fail.
    let _ = write_summary(&mut text, report);
    text
}

fn write_summary(text: &mut String, report: &SectionReport) -> std::fmt::Result {
    let closed = report.pieces.iter().filter(|piece| piece.ends == "closed").count();
    let pieces = match (report.pieces.len(), closed) {
        (1, 0) => "one piece".to_owned(),
        (1, _) => "one closed piece".to_owned(),
        (count, 0) => format!("{count} pieces"),
        (count, closed) => format!("{count} pieces, {closed} of them closed"),
    };
    writeln!(text, "section    {} mm in {pieces}", short(report.length_mm))?;
    if let Some(height) = &report.height {
        writeln!(
            text,
            "height     PV {} mm, mean {} mm, RMS about it {} mm",
            short(height.pv_mm),
            short(height.mean_mm),
            short(height.rms_about_mean_mm)
        )?;
        if let Some(line) = &height.line {
            let slope = plain(&with_u(line.slope, line.u_slope));
            writeln!(text, "line       slope {slope}{}", left(line.pv_nm, line.rms_nm))?;
        }
        if let Some(circle) = &height.circle {
            let radius = match circle.radius_mm.zip(circle.u_radius_mm) {
                Some((radius, u)) => format!("radius {} mm", plain(&with_u(radius, Some(u)))),
                None => "none: the curvature is not significant".to_owned(),
            };
            writeln!(text, "circle     {radius}{}", left(circle.pv_nm, circle.rms_nm))?;
        }
    }
    if let Some(deviation) = &report.deviation {
        writeln!(
            text,
            "deviation  PV {} nm, RMS {} nm, mean {} nm over {} mm",
            short(deviation.pv_nm),
            short(deviation.rms_nm),
            short(deviation.mean_nm),
            short(deviation.length_mm)
        )?;
    }
    report.reasons.iter().try_for_each(|reason| writeln!(text, "  {reason}"))
}

/// Deviations from a fitted line or circle.
fn left(pv_nm: f64, rms_nm: f64) -> String {
    format!(", left PV {} nm, RMS {} nm", short(pv_nm), short(rms_nm))
}
