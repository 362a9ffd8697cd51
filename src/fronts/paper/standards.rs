//! Minimum zone, indication and texture in the HTML file.

use std::fmt::{Result, Write as _};

use asphera_report::{
    FormFigure, IndicationFigures, MinimumZoneFigures, PoseFigures, SimulatedFigures,
    TextureFigures,
};

use super::words::{count, minus, percent, place, short, text};

/// Indication of a drawing and the values found, in its own notation.
pub(super) fn indication(out: &mut String, indication: &IndicationFigures) -> Result {
    write!(out, "<p>By ISO 10110-5 found <b>{}</b>", text(&indication.found))?;
    match &indication.asked {
        Some(asked) => writeln!(out, "; asked <b>{}</b>.</p>", text(asked)),
        None => writeln!(out, ".</p>"),
    }
}

/// The zone, what it is beside the fit, and what shows that none near by is narrower.
pub(super) fn minimum_zone(
    out: &mut String,
    zone: &MinimumZoneFigures,
    pose: &PoseFigures,
) -> Result {
    writeln!(
        out,
        "<p>Every point lies within <b>{} nm</b> between two parallels of the nominal; at the least-squares fit the \
         same points span {} nm. The middle of the zone lies {} nm above the nominal.</p>",
        short(zone.width.value),
        short(zone.least_squares_pv_nm),
        short(zone.offset_nm)
    )?;
    if let (Some(u), Some(simulated)) = (zone.width.u, &zone.width.simulated) {
        writeln!(
            out,
            "<p>u = {} nm (k = 1); {} to {} nm, 95 % of {}; noise adds about {} nm.{}</p>",
            short(u),
            short(simulated.low),
            short(simulated.high),
            text(&simulated.covers),
            short(simulated.bias),
            draws(simulated)
        )?;
    }
    writeln!(
        out,
        "<p class=\"note\">{}, {}. Certificate: no zone near by is narrower than {} nm, which is {} nm less; all {} \
         points were held against it {} times, and these hold it:</p>",
        text(&zone.method),
        text(&zone.termination),
        short(zone.lower_nm),
        minus(format!("{:.0e}", zone.gap_nm)),
        count(zone.points),
        count(zone.passes)
    )?;
    out.push_str(
        "<table><thead><tr><th>border</th><th>at</th><th class=\"n\">share in holding it</th></tr></thead>\
         <tbody>\n",
    );
    for contact in &zone.contacts {
        writeln!(
            out,
            "<tr><th>{}</th><td>{}</td><td class=\"n\">{}</td></tr>",
            text(&contact.side),
            place(&pose.to_measured(contact.at_mm)),
            percent(contact.share)
        )?;
    }
    out.push_str("</tbody></table>\n");
    writeln!(
        out,
        "<p class=\"note\">{} <i>({})</i></p>",
        text(&zone.width.definition),
        text(&zone.width.source)
    )
}

/// The scale, then the parameters.
pub(super) fn texture(out: &mut String, texture: &TextureFigures) -> Result {
    let surface = match texture.surface.as_str() {
        kind @ ("S-F" | "S-L") => format!("{kind} surface"),
        kind => format!("Surface of {kind}"),
    };
    writeln!(
        out,
        "<p>{} of the deviation from the fitted nominal, less {}. {} points; {} of the area that is sampled densely \
         enough.</p>",
        text(&surface),
        text(&texture.f_operation),
        count(texture.points),
        percent(texture.measured)
    )?;
    for filter in &texture.filters {
        writeln!(out, "<p class=\"note\">{}.</p>", text(filter))?;
    }
    let simulated = texture.figures.iter().find_map(|figure| figure.simulated.as_ref());
    writeln!(
        out,
        "<table class=\"wide\"><thead><tr><th>parameter</th><th class=\"n\">value</th>{}<th>definition</th></tr></thead>\
         <tbody>",
        if simulated.is_some() {
            "<th class=\"n\">without noise \u{b1} u (k = 1); 95 %</th>"
        } else {
            ""
        }
    )?;
    for figure in &texture.figures {
        writeln!(
            out,
            "<tr><th>{}</th><td class=\"n\">{} {}</td>{}<td class=\"small\">{} <i>({})</i></td></tr>",
            text(&figure.name),
            short(figure.value),
            text(&figure.unit),
            if simulated.is_some() { uncertainty(figure) } else { String::new() },
            text(&figure.definition),
            text(&figure.source)
        )?;
    }
    out.push_str("</tbody></table>\n");
    match simulated {
        Some(simulated) => writeln!(
            out,
            "<p class=\"note\">Intervals cover 95 % of {}. They are of the surface without noise, whose share is taken off; those of \
             extremes (Sp, Sv, Sz, as of the minimum zone) reach up to what a defect of a single point may hide in it.{}</p>",
            text(&simulated.covers),
            draws(simulated)
        ),
        None => writeln!(out, "<p class=\"note\">No uncertainty was evaluated for these.</p>"),
    }
}

fn uncertainty(figure: &FormFigure) -> String {
    match (figure.u, &figure.simulated) {
        (Some(u), Some(simulated)) => format!(
            "<td class=\"n\">{} \u{b1} {}; {} to {}</td>",
            short(simulated.without_noise),
            short(u),
            short(simulated.low),
            short(simulated.high)
        ),
        _ => "<td class=\"n\">–</td>".to_owned(),
    }
}

/// What was simulated, as a sentence after another.
fn draws(simulated: &SimulatedFigures) -> String {
    let SimulatedFigures { model, draws, seed, .. } = simulated;
    format!(" {draws} simulated measurements, seed {seed} ({}).", text(model))
}
