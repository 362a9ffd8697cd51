//! How far the figures can be trusted: their uncertainty, what was not measured, what the fit says of itself.

use std::fmt::{Result, Write as _};

use asphera_report::{
    CorrelationFigures, CovarianceFigures, FitDetails, FitFigures, FormFigures, UncertaintyFigures,
    UnmeasuredFigures,
};

use super::words::{count, minus, percent, short, text};

/// The uncertainty of PV and RMS, by which model, and what the unmeasured part may hide.
pub(super) fn of_figures(out: &mut String, form: &FormFigures) -> Result {
    if let Some(known) = &form.deviation.uncertainty {
        uncertainty(out, known)?;
    }
    if let Some(found) = &form.deviation.unmeasured {
        unmeasured(out, found)?;
    }
    Ok(())
}

fn uncertainty(out: &mut String, known: &UncertaintyFigures) -> Result {
    let [pv, rms] = [known.pv_95_nm, known.rms_95_nm]
        .map(|[low, high]| format!("{} to {} nm", short(low), short(high)));
    let (about, at_most) = if known.pv_at_most { ("at most", "at most ") } else { ("about", "") };
    write!(
        out,
        "<p class=\"note\">Uncertainty ({}): u(PV) {at_most}{} nm, u(RMS) {} nm. PV {pv}, 95 % of {}; noise makes \
         {about} {} nm of it. RMS without the noise {} nm, {rms}, 95 % of {}. Noise of a point {} nm ({}).",
        text(&known.model),
        short(known.u_pv_nm),
        short(known.u_rms_nm),
        text(&known.pv_covers),
        short(known.pv_bias_nm),
        short(known.rms_without_noise_nm),
        text(&known.rms_covers),
        short(known.noise_nm),
        if known.noise_measured { "measured" } else { "given" },
    )?;
    if let (Some(draws), Some(seed)) = (known.draws, known.seed) {
        write!(out, " {draws} simulated measurements, seed {seed}.")?;
    }
    if known.model == UncertaintyFigures::NOISE_ONLY {
        out.push_str(
            " Errors that are correlated from point to point, and those of the machine, are <b>not</b> in it: they \
             need a table [uncertainty] in the nominal file.",
        );
    }
    out.push_str("</p>\n");
    Ok(())
}

fn unmeasured(out: &mut String, found: &UnmeasuredFigures) -> Result {
    out.push_str("<p class=\"note\">Not measured: ");
    match (found.share, found.area_mm2) {
        (Some(share), Some(area_mm2)) => write!(
            out,
            "{} of the aperture ({} mm²) not sampled densely enough, which holds the highest or the lowest place with up \
             to {}",
            percent(share),
            short(area_mm2),
            percent(found.extreme_missed_p.unwrap_or(1.0))
        )?,
        (Some(share), None) => write!(out, "{} of the aperture", percent(share))?,
        _ => out.push_str("how much of the aperture is not known"),
    }
    if let (Some(between_nm), Some(gap_mm), Some(bend)) =
        (found.between_nm, found.gap_mm, found.bend_nm_per_mm2)
    {
        write!(
            out,
            "; between the points, with a gap of {} mm and a bend of {} nm/mm², {} nm may stand out at either end",
            short(gap_mm),
            short(bend),
            short(between_nm)
        )?;
    }
    if let Some(rms_nm) = found.rms_hidden_nm {
        write!(out, "; the RMS may be {} nm larger (p = {})", short(rms_nm), percent(found.p))?;
    }
    for why in &found.unknown {
        write!(out, "; {}", text(why))?;
    }
    out.push_str(".</p>\n");
    Ok(())
}

/// Sources of u of the parameters, and what it does not count.
pub(super) fn of_parameters(out: &mut String, fit: &FitFigures) -> Result {
    let model = fit.details.u_model.as_deref().unwrap_or(FitDetails::BY_RESIDUALS);
    write!(out, "<p class=\"note\">u by {}.", text(model))?;
    if model == FitDetails::BY_RESIDUALS {
        out.push_str(
            " It tells how far the best fit to this very part changes with the points that were taken of it.",
        );
    }
    match &fit.details.correlation {
        Some(found) if found.counted => correlation(out, found)?,
        Some(found) => by_form(out, fit, found)?,
        None => {}
    }
    if let Some(covers) = &fit.details.expanded_covers {
        write!(out, " Expanded uncertainties (95 %, report.json) cover {}.", text(covers))?;
    }
    out.push_str("</p>\n");
    Ok(())
}

/// What the parameters would vary by from part to part.
fn by_form(out: &mut String, fit: &FitFigures, found: &CorrelationFigures) -> Result {
    let changes = fit.parameters.iter().filter_map(|(name, of)| {
        let unit = if of.unit == "1" { String::new() } else { format!(" {}", of.unit) };
        Some(format!("{} by {}{}", text(name), short(of.u_by_form?), text(&unit)))
    });
    let changes: Vec<String> = changes.collect();
    write!(
        out,
        " Form error like that of this part, correlated over about {} mm, changes {} from part to part (k = 1, roughly), \
         which u does not count",
        short(found.length_mm),
        changes.join(", "),
    )?;
    if let Some(ratio) = found.largest_ratio {
        write!(out, ": up to {} times as much", short(ratio))?;
    }
    out.push('.');
    Ok(())
}

fn correlation(out: &mut String, found: &CorrelationFigures) -> Result {
    write!(
        out,
        " Correlation over about {} mm ({}, {}) of a wave of {} nm RMS, beside {} nm that are independent from patch to \
         patch, of {} patches.",
        short(found.length_mm),
        text(&found.kernel),
        percent(found.kernels.get(&found.kernel).copied().unwrap_or(0.0)),
        short(found.sigma_nm),
        short(found.rest_nm),
        found.patches
    )?;
    if let (Some(ratio), Some(name)) = (found.largest_ratio, &found.largest_ratio_of) {
        write!(
            out,
            " u of independent deviations would be up to {} times smaller ({}).",
            short(ratio),
            text(name)
        )?;
    }
    out.push_str(
        " Waves longer than the part look as a change of its parameters, and no deviation tells of them.",
    );
    Ok(())
}

/// What a fit says of itself beside its parameters.
pub(super) fn of_fit(out: &mut String, details: &FitDetails) -> Result {
    for caution in &details.cautions {
        writeln!(
            out,
            "<p class=\"caution\"><b>Caution:</b> {}.{}</p>",
            text(&caution.text),
            if caution.forbids_verdict { " No verdict can be given." } else { "" }
        )?;
    }
    // Of a combination the caution says all.
    for lacks in details.undetermined.iter().filter(|lacks| !lacks.combined) {
        writeln!(
            out,
            "<p class=\"note\"><b>{}</b> is not determined {}: the points do not feel {}.</p>",
            text(&lacks.parameter),
            if lacks.by_shape { "by any points on this shape" } else { "by these points" },
            text(&minus(lacks.combination.text.clone()))
        )?;
    }
    let facts = [
        details.sigma_nm.map(|nm| format!("standard deviation {} nm", short(nm))),
        details.dof.map(|dof| format!("{} degrees of freedom", count(dof))),
        details.evaluations.map(|number| format!("{} passes over the points", count(number))),
        details.condition.map(|condition| format!("condition {}", short(condition))),
        details
            .weakest
            .as_ref()
            .filter(|weakest| weakest.shares.len() > 1)
            .map(|weakest| format!("determined worst: {}", text(&minus(weakest.text.clone())))),
    ];
    let facts: Vec<String> = facts.into_iter().flatten().collect();
    if !facts.is_empty() {
        writeln!(out, "<p class=\"note\">{}.</p>", facts.join("; "))?;
    }
    match &details.covariance {
        Some(found) if found.parameters.len() > 1 => correlations(out, found),
        _ => Ok(()),
    }
}

fn correlations(out: &mut String, found: &CovarianceFigures) -> Result {
    let shown = found.parameters.len().min(MOST_SHOWN);
    out.push_str("<h3>Correlation of the parameters</h3>\n<table><thead><tr><th></th>");
    for name in &found.parameters[..shown] {
        write!(out, "<th class=\"n\">{}</th>", text(name))?;
    }
    out.push_str("</tr></thead><tbody>\n");
    for (name, row) in found.parameters.iter().zip(&found.correlation).take(shown) {
        write!(out, "<tr><th>{}</th>", text(name))?;
        for value in &row[..shown] {
            let value = value.map_or("–".to_owned(), |value| minus(format!("{value:.3}")));
            write!(out, "<td class=\"n\">{value}</td>")?;
        }
        out.push_str("</tr>\n");
    }
    out.push_str("</tbody></table>\n");
    if shown < found.parameters.len() {
        writeln!(
            out,
            "<p class=\"note\">The first {shown} of them; all stand in report.json.</p>"
        )?;
    }
    Ok(())
}

/// Parameters that fit beside each other on a sheet.
const MOST_SHOWN: usize = 10;
