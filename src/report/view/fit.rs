//! How the nominal was laid into the points, in words.

use super::reliability;
use super::{Block, Chapter, ChapterId, Fact, Layout, Table};
use crate::words::{count, counted, minus, place, quantity, raised, short, with_u};
use crate::{CovarianceFigures, FitDetails, FitFigures, FormFigures, ReferenceFigures};

pub(super) fn chapter(form: &FormFigures) -> Chapter {
    let mut chapter = Chapter::new(ChapterId::Fit, "Fit");
    let fit = &form.fit;
    brief(&mut chapter, fit);
    for caution in &fit.details.cautions {
        let end = if caution.forbids_verdict { " No verdict can be given." } else { "" };
        chapter.blocks.push(Block::Caution { text: format!("{}.{end}", caution.text) });
    }
    chapter.note(format!("Nominal: {}.", raised(&form.nominal)));
    let mut facts = vec![
        Fact::new("Method", fit.method.clone()),
        Fact::new(
            "Ended",
            format!("{}, after {}", fit.termination, counted(fit.iterations.into(), "step")),
        ),
        Fact::new(
            "Free",
            if fit.free.is_empty() { "nothing".to_owned() } else { fit.free.join(", ") },
        ),
    ];
    if !fit.indeterminate.is_empty() {
        let names = fit.indeterminate.join(", ");
        facts.push(
            Fact::new("Not determined by the points, left at their start", names)
                .bad_if(!lacking(fit).is_empty()),
        );
    }
    facts.extend(criterion(fit));
    facts.extend(form.reference.iter().flat_map(reference));
    facts.extend(quality(&fit.details));
    chapter.facts(facts);
    if let Some(nm) = fit.details.aperture_narrowed_nm {
        chapter.note(format!(
            "Points lie on the edge of the aperture. It was taken {} nm further inside, where none come in and go out with the \
             place of the part.",
            short(nm)
        ));
    }
    // Of a combination the caution says all.
    for lacks in fit.details.undetermined.iter().filter(|lacks| !lacks.combined) {
        let any = if lacks.by_shape { "; no points on this shape tell it" } else { "" };
        chapter.note(format!("{}{any}.", minus(lacks.text.clone())));
    }
    parameters(&mut chapter, fit);
    if let Some(found) = fit.details.covariance.as_ref().filter(|found| found.parameters.len() > 1)
    {
        correlations(&mut chapter, found);
    }
    pose(&mut chapter, form);
    chapter
}

/// Only what must be known to trust the figures: how a fit ended that did not converge, and cautions.
fn brief(chapter: &mut Chapter, fit: &FitFigures) {
    if fit.details.converged == Some(false) {
        chapter.brief.push(format!(
            "{}, after {}",
            fit.termination,
            counted(fit.iterations.into(), "step")
        ));
    }
    let lacking = lacking(fit);
    if !lacking.is_empty() {
        chapter.brief.push(format!("not determined by these points: {}", lacking.join(", ")));
    }
    chapter
        .brief
        .extend(fit.details.cautions.iter().map(|caution| format!("caution: {}", caution.text)));
}

/// Parameters that points elsewhere could tell: a shift of a plane along itself, which none tells, is no news.
fn lacking(fit: &FitFigures) -> Vec<&str> {
    let by_shape = |name: &str| {
        fit.details.undetermined.iter().any(|lacks| lacks.by_shape && lacks.parameter == name)
    };
    fit.indeterminate.iter().map(String::as_str).filter(|name| !by_shape(name)).collect()
}

/// How points were counted, where that is not alike and by squares.
fn criterion(fit: &FitFigures) -> Vec<Fact> {
    let mut facts = Vec::new();
    if let Some(loss) = &fit.loss {
        let origin = if loss.threshold_given { "given" } else { "found from the deviations" };
        facts.push(Fact::new(
            "Loss",
            format!(
                "{}, threshold {} nm ({origin}), at a scale of {} nm",
                loss.name,
                short(loss.threshold_nm),
                short(loss.scale_nm)
            ),
        ));
        facts.push(Fact::new(
            "Below half weight",
            format!("{} points, {} of them left out", count(loss.below_half), count(loss.left_out)),
        ));
    }
    if let Some(weights) = &fit.weights {
        facts.push(Fact::new(
            "Weights 1/u², u along the normal",
            format!("{} to {} nm", short(weights.u_min_nm), short(weights.u_max_nm)),
        ));
        facts.push(Fact::new("Reduced χ²", quantity(weights.reduced_chi_square, "")));
    }
    if let Some(points) = fit.effective_points {
        facts.push(Fact::new("As many as points of equal weight", format!("{points:.0}")));
    }
    facts
}

/// The surface that was made from the points, where no design is known.
fn reference(reference: &ReferenceFigures) -> Vec<Fact> {
    let [nx, ny] = reference.cells;
    let knots_mm = reference.knots_mm[0].max(reference.knots_mm[1]);
    let mut facts = vec![
        Fact::new(
            "Base under the splines",
            format!("{}, RMS from it {} nm", reference.base, short(reference.base_rms_nm)),
        ),
        Fact::new("Cells of the splines", format!("{nx} × {ny}, of {} mm", short(knots_mm))),
        Fact::new("Smoothing", format!("{}, λ {}", reference.smoothing, short(reference.lambda))),
        Fact::new("Effective parameters", format!("{:.0}", reference.effective_parameters)),
        Fact::new("Half followed: waves of", format!("{} mm", short(reference.follows_mm))),
        Fact::new("Noise left", quantity(reference.noise_nm, "nm")),
    ];
    if let Some(points) = reference.as_of_points {
        facts.push(Fact::new(
            "Base and knots made of",
            format!("the first {} points", count(points)),
        ));
    }
    facts
}

/// What a fit says of itself beside its parameters.
fn quality(details: &FitDetails) -> Vec<Fact> {
    let weakest = details.weakest.as_ref().filter(|weakest| weakest.shares.len() > 1);
    [
        details.sigma_nm.map(|nm| Fact::new("Standard deviation", format!("{} nm", short(nm)))),
        details.dof.map(|dof| Fact::new("Degrees of freedom", count(dof))),
        details.evaluations.map(|number| Fact::new("Passes over the points", count(number))),
        details.condition.map(|condition| Fact::new("Condition", short(condition))),
        weakest.map(|weakest| Fact::new("Determined worst", minus(weakest.text.clone()))),
    ]
    .into_iter()
    .flatten()
    .collect()
}

fn parameters(chapter: &mut Chapter, fit: &FitFigures) {
    if fit.parameters.is_empty() {
        return;
    }
    let mut table = Table::new(&[
        ("parameter", Layout::Head),
        ("value ± u (k = 1)", Layout::Number),
        ("unit", Layout::Text),
    ]);
    table.rows.extend(fit.parameters.iter().map(|(name, parameter)| {
        vec![name.clone(), with_u(parameter.value, parameter.u), raised(&parameter.unit)]
    }));
    chapter.table(table);
    chapter.note(reliability::of_parameters(fit));
}

fn correlations(chapter: &mut Chapter, found: &CovarianceFigures) {
    let shown = found.parameters.len().min(MOST_SHOWN);
    let names = &found.parameters[..shown];
    let mut heads = vec![("", Layout::Head)];
    heads.extend(names.iter().map(|name| (name.as_str(), Layout::Number)));
    let mut table = Table::new(&heads).titled("Correlation of the parameters");
    for (name, row) in names.iter().zip(&found.correlation) {
        let cells = row[..shown].iter().map(|value| match value {
            Some(value) => minus(format!("{value:.3}")),
            None => crate::words::DASH.to_owned(),
        });
        table.rows.push(std::iter::once(name.clone()).chain(cells).collect());
    }
    chapter.table(table);
    if shown < found.parameters.len() {
        chapter.note(format!("The first {shown} of them; all stand in report.json."));
    }
}

fn pose(chapter: &mut Chapter, form: &FormFigures) {
    if let Some(origin) = &form.origin {
        chapter.note(format!(
            "Places of the part, rings, Zernike terms and slopes along the meridian count from the {}, at {} of the \
             measured frame.",
            origin.place,
            place(&origin.at_mm)
        ));
    }
    let pose = &form.fit.pose;
    chapter.note(format!(
        "Pose of the part in the measured frame, p′ = Rz·Ry·Rx·p + t: t {}, R ({}, {}, {}) rad.",
        minus(format!("({:.6}, {:.6}, {:.6}) mm", pose.tx_mm, pose.ty_mm, pose.tz_mm)),
        minus(format!("{:.3e}", pose.rx_rad)),
        minus(format!("{:.3e}", pose.ry_rad)),
        minus(format!("{:.3e}", pose.rz_rad)),
    ));
}

/// Parameters that fit beside each other on a sheet.
const MOST_SHOWN: usize = 10;
