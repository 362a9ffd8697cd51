//! A contour in the words of the command line.

use std::fmt::Write as _;

use asphera_contour::PlaceMm;
use asphera_report::contour::{
    CircleFigures, ContourReport, DeviationFigures, FeatureFigures, GapFigures, InputFigures,
    SampledFigures,
};

use crate::cli::summary::short;

/// The outcome as a person reads it.
pub(super) fn summary(report: &ContourReport) -> String {
    let mut text = String::new();
    // Writing into a String cannot fail.
    let _ = write_report(report, &mut text);
    text
}

/// The lines of all figures.
fn write_report(report: &ContourReport, text: &mut String) -> std::fmt::Result {
    let InputFigures { points, distinct, spacing_median_mm, .. } = &report.input;
    writeln!(
        text,
        "points     {points}, {distinct} places, spacing {} mm (median)",
        spacing_median_mm.map_or_else(|| "not known".to_owned(), short)
    )?;
    write!(text, "method     {}", report.method)?;
    for (name, value) in &report.parameters {
        write!(text, " {name}={value}")?;
    }
    writeln!(text, "; proven for: {}", report.guarantee)?;
    if let Some(reason) = &report.reason {
        writeln!(text, "chosen     {reason}")?;
    }
    if let Some(sigma_mm) = report.input.noise_sigma_mm {
        writeln!(text, "noise      {} mm (standard deviation), taken away", short(sigma_mm))?;
    }
    writeln!(text, "edges      {}", report.edges.len())?;
    if !report.chains.is_empty() {
        let closed = report.chains.iter().filter(|chain| chain.closed).count();
        let length_mm: f64 = report.chains.iter().map(|chain| chain.length_mm).sum();
        let open = report.chains.len() - closed;
        let length = short(length_mm);
        writeln!(text, "curves     {closed} closed, {open} open, {length} mm together")?;
    }
    if let (Some(area_mm2), Some(parts), Some(holes)) =
        (report.area_mm2, report.parts, report.holes)
    {
        writeln!(text, "area       {} mm², {parts} parts, {holes} holes", short(area_mm2))?;
    }
    for part in report.regions.iter().flatten() {
        if let Some(label) = &part.label {
            let [area, holes] = [short(part.area_mm2), part.holes_mm.len().to_string()];
            writeln!(text, "region     {label}: {area} mm², {holes} holes")?;
        }
    }
    writeln!(
        text,
        "unjoined   {} ends, {} junctions, {} points left out",
        report.ends.len(),
        report.junctions.len(),
        report.left_out.len()
    )?;
    for gap in &report.gaps {
        let GapFigures { kind, width_mm, length_mm, .. } = gap;
        let place = |at: Option<&PlaceMm>| {
            at.map_or_else(String::new, |[x, y]| format!("({}, {})", short(*x), short(*y)))
        };
        writeln!(
            text,
            "gap        {kind}, {} mm wide, {} mm long, from {} to {} mm",
            short(*width_mm),
            short(*length_mm),
            place(gap.points_mm.first()),
            place(gap.points_mm.last())
        )?;
    }
    if let Some(sampling) = &report.sampling {
        write_sampling(sampling, text)?;
    }
    if let Some(circle) = &report.circle {
        write_circle(circle, text)?;
    }
    let mut features = report.features.iter().take(MOST_LISTED);
    features.try_for_each(|feature| write_feature(feature, text))?;
    write_more("features", report.features.len(), text)?;
    if let Some(deviation) = &report.deviation {
        write_deviation(deviation, text)?;
    }
    let mut unknown = report.unknown.iter().take(MOST_LISTED);
    unknown.try_for_each(|unknown| writeln!(text, "unknown    {unknown}"))?;
    write_more("unknown", report.unknown.len(), text)
}

/// Says how many lines of a list are not shown.
fn write_more(name: &str, lines: usize, text: &mut String) -> std::fmt::Result {
    match lines.checked_sub(MOST_LISTED) {
        Some(more @ 1..) => writeln!(text, "{name:<10} {more} more; --json lists all"),
        _ => Ok(()),
    }
}

/// Features and what is unknown, each: of points that are no curve there are thousands, which push all other lines off the terminal.
const MOST_LISTED: usize = 100;

/// The line of the sampling.
fn write_sampling(sampling: &SampledFigures, text: &mut String) -> std::fmt::Result {
    let value = |value: Option<f64>| value.map_or("∞".to_owned(), short);
    let (epsilon, rho) = (value(sampling.epsilon), value(sampling.rho));
    write!(text, "sampling   ε {epsilon}, ρ {rho}")?;
    if let Some(uniformity) = sampling.uniformity {
        write!(text, ", u {}", short(uniformity))?;
    }
    let at =
        sampling.at_mm.map_or(String::new(), |[x, y]| format!(" at {}, {} mm", short(x), short(y)));
    match (&sampling.condition, sampling.holds) {
        (Some(condition), Some(true)) => writeln!(text, ": {condition} holds, closest{at}"),
        (Some(condition), Some(false)) if sampling.failing == 0 => {
            writeln!(
                text,
                ": {condition} holds, but it is proven for closed curves, and this one has ends"
            )
        }
        (Some(condition), Some(false)) => {
            writeln!(text, ": {condition} fails at {} places, most{at}", sampling.failing)
        }
        _ => writeln!(text, ", largest ρ{at}; no condition to check"),
    }
}

/// The lines of the circle.
fn write_circle(circle: &CircleFigures, text: &mut String) -> std::fmt::Result {
    let [x, y] = circle.centre_mm.map(short);
    writeln!(
        text,
        "circle     diameter {:.6} mm, u {} mm, centre {x}, {y} mm, over {:.0}°",
        circle.diameter_mm,
        short(circle.u_diameter_mm),
        circle.span_deg
    )?;
    write!(
        text,
        "roundness  {} mm (least squares), u {} mm",
        short(circle.roundness_mm),
        short(circle.u_roundness_mm)
    )?;
    if let Some(zone_mm) = circle.roundness_zone_mm {
        write!(text, ", {} mm (minimum zone)", short(zone_mm))?;
    }
    writeln!(text)
}

/// The line of the deviation.
fn write_deviation(deviation: &DeviationFigures, text: &mut String) -> std::fmt::Result {
    let at = |[x, y]: PlaceMm| format!("{}, {} mm", short(x), short(y));
    writeln!(
        text,
        "deviation  {} mm at {} to {} mm at {}, RMS {} mm, from {}",
        short(deviation.least_mm),
        at(deviation.least_at_mm),
        short(deviation.largest_mm),
        at(deviation.largest_at_mm),
        short(deviation.rms_mm),
        deviation.outline
    )
}

/// The line of a feature.
fn write_feature(feature: &FeatureFigures, text: &mut String) -> std::fmt::Result {
    let with = |value: f64, u: f64, unit: &str| format!("{value:.6} {unit}, u {} {unit}", short(u));
    let at = |[x, y]: PlaceMm| format!("{}, {} mm", short(x), short(y));
    match *feature {
        FeatureFigures::Line { ends_mm, angle_deg, u_angle_deg, points, .. } => writeln!(
            text,
            "line       {} to {}: {}, {points} points",
            at(ends_mm[0]),
            at(ends_mm[1]),
            with(angle_deg, u_angle_deg, "deg")
        ),
        FeatureFigures::Arc { centre_mm, radius_mm, u_radius_mm, sweep_deg, points, .. } => {
            writeln!(
                text,
                "arc        radius {}, about {}, over {:.1} deg, {points} points",
                with(radius_mm, u_radius_mm, "mm"),
                at(centre_mm),
                sweep_deg.abs()
            )
        }
        FeatureFigures::Free { ends_mm, points, .. } => writeln!(
            text,
            "free       {} to {}, {points} points: neither line nor arc",
            at(ends_mm[0]),
            at(ends_mm[1])
        ),
        FeatureFigures::Corner { at_mm, angle_deg, u_angle_deg, .. } => {
            writeln!(text, "corner     {}: {}", at(at_mm), with(angle_deg, u_angle_deg, "deg"))
        }
        FeatureFigures::Chamfer { at_mm, width_mm, u_width_mm, angles_deg, .. } => writeln!(
            text,
            "chamfer    {}: width {}, {} and {} deg to the lines beside it",
            at(at_mm),
            with(width_mm, u_width_mm, "mm"),
            short(angles_deg[0]),
            short(angles_deg[1])
        ),
        FeatureFigures::Edge { at_mm, radius_mm, u_radius_mm, angle_deg, .. } => writeln!(
            text,
            "edge       {}: radius {} between lines at {} deg",
            at(at_mm),
            with(radius_mm, u_radius_mm, "mm"),
            short(angle_deg)
        ),
        FeatureFigures::Enclosed { area_mm2, u_area_mm2, perimeter_mm, u_perimeter_mm, .. } => {
            write!(text, "enclosed   {}", with(area_mm2, u_area_mm2, "mm²"))?;
            if let Some((length_mm, u_mm)) = perimeter_mm.zip(u_perimeter_mm) {
                write!(text, "; perimeter {}", with(length_mm, u_mm, "mm"))?;
            }
            writeln!(text)
        }
        FeatureFigures::Airfoil { .. } => write_airfoil(feature, text),
    }
}

/// The lines of an airfoil.
fn write_airfoil(feature: &FeatureFigures, text: &mut String) -> std::fmt::Result {
    let FeatureFigures::Airfoil {
        chord_mm,
        u_chord_mm,
        thickness_mm,
        u_thickness_mm,
        leading_radius_mm,
        u_leading_radius_mm,
        trailing_radius_mm,
        u_trailing_radius_mm,
        ..
    } = *feature
    else {
        return Ok(());
    };
    let rows = [
        ("chord", Some(chord_mm), Some(u_chord_mm)),
        ("thickness", Some(thickness_mm), Some(u_thickness_mm)),
        ("leading", leading_radius_mm, u_leading_radius_mm),
        ("trailing", trailing_radius_mm, u_trailing_radius_mm),
    ];
    for (name, value, u) in rows {
        let Some((value, u)) = value.zip(u) else { continue };
        let radius = if name.ends_with("ing") { "radius " } else { "" };
        writeln!(text, "{name:<11}{radius}{value:.6} mm, u {} mm", short(u))?;
    }
    Ok(())
}
