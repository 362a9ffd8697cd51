//! The figures of a section as a person reads them.

use std::fmt::Write as _;

use asphera_report::SectionReport;

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
    writeln!(text, "section    {:.6} mm in {pieces}", report.length_mm)?;
    if let Some(height) = &report.height {
        writeln!(
            text,
            "height     PV {:.6} mm, mean {:.6} mm, RMS about it {:.6} mm",
            height.pv_mm, height.mean_mm, height.rms_about_mean_mm
        )?;
        if let Some(line) = &height.line {
            write!(text, "line       slope {:.9}", line.slope)?;
            if let Some(u) = line.u_slope {
                write!(text, " (u {u:.1e})")?;
            }
            writeln!(text, ", left PV {:.1} nm, RMS {:.2} nm", line.pv_nm, line.rms_nm)?;
        }
        if let Some(circle) = &height.circle {
            match circle.radius_mm.zip(circle.u_radius_mm) {
                Some((radius, u)) => write!(text, "circle     radius {radius:.6} mm (u {u:.1e})")?,
                None => write!(text, "circle     none: the curvature is not significant")?,
            }
            writeln!(text, ", left PV {:.1} nm, RMS {:.2} nm", circle.pv_nm, circle.rms_nm)?;
        }
    }
    if let Some(deviation) = &report.deviation {
        writeln!(
            text,
            "deviation  PV {:.1} nm, RMS {:.2} nm, mean {:.2} nm over {:.6} mm",
            deviation.pv_nm, deviation.rms_nm, deviation.mean_nm, deviation.length_mm
        )?;
    }
    report.reasons.iter().try_for_each(|reason| writeln!(text, "  {reason}"))
}
