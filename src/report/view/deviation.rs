//! The form deviation in words: PV and RMS, their uncertainty, what was not measured.

use super::reliability;
use super::{Chapter, ChapterId, Fact, Layout, Table};
use crate::words::{percent, place, short, with_u};
use crate::{
    DeviationFigures, FormFigures, SamplingFigures, SystematicFigures, UncertaintyFigures,
    UnmeasuredFigures,
};

/// PV, RMS and coverage, as they stand in large letters.
pub(super) fn headline(form: Option<&FormFigures>, sampling: &SamplingFigures) -> Vec<Fact> {
    let mut facts = Vec::new();
    if let Some(form) = form {
        let deviation = &form.deviation;
        let known = deviation.uncertainty.as_ref();
        let about = |nm: f64, u_nm: Option<f64>| match u_nm.filter(|u_nm| *u_nm > 1e-9) {
            Some(u_nm) => format!("{} nm", with_u(nm, Some(2.0 * u_nm))),
            None => format!("{} nm", short(nm)),
        };
        let model = known.map_or(String::new(), |known| {
            let bound = if known.pv_at_most { ". PV: an upper bound" } else { "" };
            format!("; ± k = 2, {}{bound}", known.model)
        });
        let [lowest, highest] = extremes(form);
        facts.push(
            Fact::new("PV", about(deviation.pv_nm, known.map(|known| known.u_pv_nm)))
                .noted(format!("{lowest} to {highest}, measured frame")),
        );
        facts.push(
            Fact::new("RMS", about(deviation.rms_nm, known.map(|known| known.u_rms_nm)))
                .noted(format!("about the nominal, over the points used{model}")),
        );
    }
    let coverage = sampling.coverage.map_or_else(|| "not known".to_owned(), percent);
    facts.push(Fact::new("Coverage", coverage).noted("of the aperture sampled densely enough"));
    facts
}

/// The lowest and the highest place, with their deviations.
fn extremes(form: &FormFigures) -> [String; 2] {
    let DeviationFigures { min_nm, max_nm, at_min_mm, at_max_mm, .. } = &form.deviation;
    [(min_nm, at_min_mm), (max_nm, at_max_mm)].map(|(nm, at_mm)| {
        format!("{} nm at {}", short(*nm), place(&form.fit.pose.to_measured(*at_mm)))
    })
}

pub(super) fn chapter(form: &FormFigures) -> Chapter {
    let mut chapter = Chapter::new(ChapterId::Deviation, "Deviation");
    let deviation = &form.deviation;
    chapter.brief.push(format!(
        "PV {} nm{}, RMS {} nm{}",
        short(deviation.pv_nm),
        brief_u_of_pv(deviation),
        short(deviation.rms_nm),
        brief_u_of_rms(deviation),
    ));
    chapter.brief.extend(deviation.unmeasured.as_ref().and_then(hidden));
    let [lowest, highest] = extremes(form);
    let mut facts = vec![
        Fact::new("PV", format!("{} nm", short(deviation.pv_nm))),
        Fact::new("RMS about the nominal", format!("{} nm", short(deviation.rms_nm))),
        Fact::new("Highest, measured frame", highest),
        Fact::new("Lowest, measured frame", lowest),
    ];
    if let Some(known) = &deviation.uncertainty {
        facts.extend(uncertainty(known));
    }
    chapter.facts(facts);
    if let Some(known) = &deviation.uncertainty {
        chapter.note(reliability::of_uncertainty(known, &deviation.systematic));
    }
    if !deviation.systematic.is_empty() {
        chapter.table(systematic(&deviation.systematic));
        chapter.note(reliability::of_systematic(
            &deviation.systematic,
            deviation.uncertainty.is_some(),
        ));
    }
    if let Some(found) = &deviation.unmeasured {
        chapter.note(reliability::of_unmeasured(found));
    }
    chapter
}

fn brief_u_of_pv(deviation: &DeviationFigures) -> String {
    let Some(known) = &deviation.uncertainty else { return String::new() };
    let most = if known.pv_at_most { "at most " } else { "" };
    format!(" (u {most}{})", short(known.u_pv_nm))
}

fn brief_u_of_rms(deviation: &DeviationFigures) -> String {
    match &deviation.uncertainty {
        // The uncertainty is of what noise leaves of the RMS, over the area: that may be more than the RMS over the points.
        Some(known) if holds(known.rms_95_nm, deviation.rms_nm) => {
            format!(" (u {})", short(known.u_rms_nm))
        }
        Some(known) => format!(
            " (over the area without noise {}, u {})",
            short(known.rms_without_noise_nm),
            short(known.u_rms_nm)
        ),
        None => String::new(),
    }
}

fn holds([low, high]: [f64; 2], value: f64) -> bool {
    (low..=high).contains(&value)
}

/// Allowance for unmeasured area, in the few words of a summary.
fn hidden(found: &UnmeasuredFigures) -> Option<String> {
    let between = found
        .between_nm
        .map(|nm| format!("up to {} nm may stand out between the points at either end", short(nm)));
    let share = found.share.filter(|share| *share > 0.0);
    let share = share.map(|share| format!("{} of the aperture not measured", percent(share)));
    let said: Vec<String> = [between, share].into_iter().flatten().collect();
    (!said.is_empty()).then(|| said.join("; "))
}

/// Contributions of systematic errors, a row a source that is counted.
fn systematic(all: &[SystematicFigures]) -> Table {
    let columns = [
        ("Source", Layout::Text),
        ("u of PV, nm", Layout::Number),
        ("u of RMS, nm", Layout::Number),
    ];
    let mut table = Table::new(&columns).titled("Systematic errors, k = 1");
    let row = |one: &SystematicFigures| {
        Some(vec![one.source.clone(), short(one.u_pv_nm?), short(one.u_rms_nm?)])
    };
    table.rows.extend(all.iter().filter_map(row));
    table
}

/// Standard uncertainties and intervals of PV and RMS.
fn uncertainty(known: &UncertaintyFigures) -> Vec<Fact> {
    let interval = |[low, high]: [f64; 2]| format!("{} to {} nm", short(low), short(high));
    let most = if known.pv_at_most { "at most " } else { "" };
    vec![
        Fact::new("u of PV", format!("{most}{} nm", short(known.u_pv_nm))),
        Fact::new("u of RMS", format!("{} nm", short(known.u_rms_nm))),
        Fact::new("PV, 95 %", interval(known.pv_95_nm)),
        Fact::new("RMS without noise", format!("{} nm", short(known.rms_without_noise_nm))),
        Fact::new("RMS without noise, 95 %", interval(known.rms_95_nm)),
    ]
}
