//! The figures as a person reads them in a terminal.

use std::fmt::Write as _;

use crate::report::{RepeatFigures, Report, Status};

/// The report in a few lines.
pub(super) fn of(report: &Report) -> String {
    let mut text = String::new();
    // Writing into a String cannot fail.
    let _ = write(&mut text, report);
    text
}

fn write(text: &mut String, report: &Report) -> std::fmt::Result {
    let points = &report.points;
    write!(text, "points     {} received, {} used", points.received, points.used)?;
    for (reason, count) in &points.flagged {
        write!(text, ", {count} {}", reason.replace('_', " "))?;
    }
    for (count, what) in [(points.duplicates, "duplicate"), (points.lost, "lost")] {
        if count > 0 {
            write!(text, ", {count} {what}")?;
        }
    }
    let mesh = &report.mesh;
    writeln!(text, "\nmesh       {} triangles, {:.4} mm²", mesh.triangles, mesh.area_mm2)?;
    if let Some(projection) = &mesh.projection {
        writeln!(text, "plane      {projection}")?;
    }
    let relief = &mesh.relief;
    for (count, what) in
        [(relief.folds.len() as u64, "folds"), (relief.walls, "walls"), (relief.spikes, "spikes")]
    {
        if count > 0 {
            writeln!(text, "           {count} {what}")?;
        }
    }
    if let Some(spread_nm) = mesh.repeats.spread_nm {
        let RepeatFigures { places, measurements, .. } = mesh.repeats;
        writeln!(
            text,
            "           {places} places measured {measurements} times, spread {spread_nm:.1} nm"
        )?;
    }
    let sampling = &report.sampling;
    if let (Some(coverage), Some(gap), Some(epsilon)) =
        (sampling.coverage, sampling.gap_max_mm, sampling.epsilon_max)
    {
        writeln!(
            text,
            "sampling   {:.2} % covered, largest gap {gap:.4} mm, largest ε {epsilon:.4}",
            100.0 * coverage
        )?;
    }
    if let Some(form) = &report.form {
        writeln!(text, "nominal    {}", form.nominal)?;
        writeln!(
            text,
            "fit        {}, {} in {} steps",
            form.fit.method, form.fit.termination, form.fit.iterations
        )?;
        for (name, parameter) in &form.fit.parameters {
            write!(text, "  {name:<8} {:.9} {}", parameter.value, parameter.unit)?;
            match parameter.u {
                Some(u) => writeln!(text, "   (u {u:.1e})")?,
                None => writeln!(text)?,
            }
        }
        if !form.fit.indeterminate.is_empty() {
            writeln!(
                text,
                "  not determined by these points: {}",
                form.fit.indeterminate.join(", ")
            )?;
        }
        let deviation = &form.deviation;
        writeln!(
            text,
            "deviation  PV {:.1} nm, RMS {:.2} nm ({:+.1} nm at {}, {:+.1} nm at {})",
            deviation.pv_nm,
            deviation.rms_nm,
            deviation.max_nm,
            place(&deviation.at_max_mm),
            deviation.min_nm,
            place(&deviation.at_min_mm),
        )?;
    }
    for link in &report.links {
        for device in &link.devices {
            write!(text, "{:<10} {} readings on {}", device.name, device.readings, link.name)?;
            for (count, what) in [
                (device.lost, "lost"),
                (device.unjoined, "unjoined"),
                (device.ambiguous, "ambiguous"),
            ] {
                if count > 0 {
                    write!(text, ", {count} {what}")?;
                }
            }
            for (kind, count) in &device.faults {
                write!(text, ", {count} {kind} faults")?;
            }
            for (name, channel) in
                device.channels.iter().filter(|_| device.lost == 0 && device.unjoined == 0)
            {
                write!(text, ", {name} {:.3} {}", channel.mean, channel.unit)?;
            }
            writeln!(text)?;
        }
        if link.discarded_bytes > 0 || link.closed > 0 {
            writeln!(
                text,
                "  {}: {} bytes discarded, opened {} times, lost {} times",
                link.name, link.discarded_bytes, link.opened, link.closed
            )?;
        }
    }
    if let Some(session) = &report.session {
        writeln!(text, "session    {} ({})", session.id, session.ended)?;
    }
    let verdict = match report.verdict.status {
        Status::Pass => "PASS",
        Status::Fail => "FAIL",
        Status::Undecided => "UNDECIDED",
    };
    write!(text, "verdict    {verdict}")?;
    for check in &report.verdict.checks {
        let sign = if check.ok { "≤" } else { ">" };
        write!(text, "   {} {:.2} {sign} {:.2}", check.name, check.value, check.limit)?;
    }
    writeln!(text)?;
    report.verdict.reasons.iter().try_for_each(|reason| writeln!(text, "  {reason}"))
}

fn place([x, y, _]: &[f64; 3]) -> String {
    format!("x {x:.3} y {y:.3} mm")
}
