//! How far the figures can be trusted, in sentences: errors, unmeasured area, correlated deviations.

use crate::words::{count, percent, short};
use crate::{
    CorrelationFigures, FitDetails, FitFigures, SimulatedFigures, SystematicFigures,
    UncertaintyFigures, UnmeasuredFigures,
};

/// Errors that the uncertainty of PV and RMS counts.
pub(super) fn of_uncertainty(
    known: &UncertaintyFigures,
    systematic: &[SystematicFigures],
) -> String {
    let counts_systematic = systematic.iter().any(|one| one.not_counted.is_none());
    let errors = match counts_systematic {
        true => format!(
            "{} and the systematic errors below",
            known.model.replacen("noise only", "noise", 1)
        ),
        false => known.model.clone(),
    };
    let mut text = format!(
        "Uncertainty (k = 1) by {errors}. PV covers {}; noise makes {} {} nm of it. RMS covers {}. Noise of a point {} nm ({}).",
        known.pv_covers,
        if known.pv_at_most { "at most" } else { "about" },
        short(known.pv_bias_nm),
        known.rms_covers,
        short(known.noise_nm),
        if known.noise_measured { "measured" } else { "given" },
    );
    if let (Some(draws), Some(seed)) = (known.draws, known.seed) {
        text.push_str(&format!(" {draws} simulated measurements, seed {seed}."));
    }
    if known.model == UncertaintyFigures::NOISE_ONLY {
        let beside = if counts_systematic { " beside the systematic ones below" } else { "" };
        text.push_str(&format!(
            " It does not include errors correlated from point to point, nor those of the machine{beside}. State them in the table \
             [uncertainty] of the nominal file."
        ));
    }
    text
}

/// What is counted of systematic errors, and what is not. `known`: whether there is a u that counts them.
pub(super) fn of_systematic(all: &[SystematicFigures], known: bool) -> String {
    let mut said = Vec::new();
    if all.iter().any(|one| one.not_counted.is_none()) {
        said.push(match known {
            true => "u of PV, RMS, limited figures, pose and shape counts these sources as independent of each other. What the fit \
                     takes up of them is not in it"
                .to_owned(),
            false => "u of pose and shape counts these sources. PV and RMS have no u, as their noise is not known".to_owned(),
        });
    }
    let not_counted = |one: &SystematicFigures| {
        Some(format!("Not counted: {}: {}", one.source, one.not_counted.as_deref()?))
    };
    said.extend(all.iter().filter_map(not_counted));
    format!("{}.", said.join(". "))
}

/// What the unmeasured area and the gaps between points may hide.
pub(super) fn of_unmeasured(found: &UnmeasuredFigures) -> String {
    let mut said = vec![match (found.share, found.area_mm2) {
        (Some(share), Some(area_mm2)) => format!(
            "Not measured: {} of the aperture ({} mm²) not sampled densely enough, which holds the highest or the \
             lowest place with up to {}",
            percent(share),
            short(area_mm2),
            percent(found.extreme_missed_p.unwrap_or(1.0))
        ),
        (Some(share), None) => format!("Not measured: {} of the aperture", percent(share)),
        _ => "Not measured: how much of the aperture is not known".to_owned(),
    }];
    if let (Some(between_nm), Some(gap_mm), Some(bend)) =
        (found.between_nm, found.gap_mm, found.bend_nm_per_mm2)
    {
        said.push(format!(
            "between the points, with a gap of {} mm and a bend of {} nm/mm², {} nm may stand out at either end",
            short(gap_mm),
            short(bend),
            short(between_nm)
        ));
    }
    if let Some(rms_nm) = found.rms_hidden_nm {
        said.push(format!("the RMS may be {} nm larger (p = {})", short(rms_nm), percent(found.p)));
    }
    said.extend(found.unknown.iter().cloned());
    format!("{}.", said.join("; "))
}

/// What the uncertainty of the parameters counts, and what it does not.
pub(super) fn of_parameters(fit: &FitFigures) -> String {
    let model = fit.details.u_model.as_deref().unwrap_or(FitDetails::BY_RESIDUALS);
    let mut text = format!("u (k = 1) by {model}.");
    if model == FitDetails::BY_RESIDUALS {
        text.push_str(
            " It says how far the best fit to this very part changes with the choice of points.",
        );
    }
    match &fit.details.correlation {
        Some(found) if found.counted => text.push_str(&correlation(found)),
        Some(found) => text.push_str(&by_form(fit, found)),
        None => {}
    }
    if let Some(covers) = &fit.details.expanded_covers {
        text.push_str(&format!(" Expanded uncertainties (95 %, report.json) cover {covers}."));
    }
    text
}

/// Changes of the parameters from part to part.
fn by_form(fit: &FitFigures, found: &CorrelationFigures) -> String {
    let changes = fit.parameters.iter().filter_map(|(name, of)| {
        let unit = if of.unit == "1" { String::new() } else { format!(" {}", of.unit) };
        Some(format!("{name} by {}{unit}", short(of.u_by_form?)))
    });
    let changes: Vec<String> = changes.collect();
    let ratio = found
        .largest_ratio
        .map_or(String::new(), |ratio| format!(": up to {} times as much", short(ratio)));
    format!(
        " Form error like that of this part, correlated over about {} mm, changes {} from part to part (k = 1, roughly). u \
         does not include that{ratio}.",
        short(found.length_mm),
        changes.join(", "),
    )
}

fn correlation(found: &CorrelationFigures) -> String {
    let mut text = format!(
        " Correlation over about {} mm ({}, {}) of a wave of {} nm RMS, beside {} nm that are independent from patch to \
         patch, of {} patches.",
        short(found.length_mm),
        found.kernel,
        percent(found.kernels.get(&found.kernel).copied().unwrap_or(0.0)),
        short(found.sigma_nm),
        short(found.rest_nm),
        count(found.patches)
    );
    if let (Some(ratio), Some(name)) = (found.largest_ratio, &found.largest_ratio_of) {
        text.push_str(&format!(
            " u of independent deviations would be up to {} times smaller ({name}).",
            short(ratio)
        ));
    }
    text.push_str(
        " Waves longer than the part look like a change of its parameters, and no deviation shows them.",
    );
    text
}

/// Number and seed of simulated measurements.
pub(crate) fn of_draws(simulated: &SimulatedFigures) -> String {
    let SimulatedFigures { model, draws, seed, .. } = simulated;
    format!("{draws} simulated measurements, seed {seed} ({model}).")
}
