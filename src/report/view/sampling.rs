//! The sampling in words: whether the points lie densely enough, and what to measure next.

use super::{Chapter, ChapterId, Fact, Layout, Table};
use crate::SamplingFigures;
use crate::words::{DASH, count, direction, percent, place, quantity, short};

pub(super) fn chapter(sampling: &SamplingFigures) -> Chapter {
    let mut chapter = Chapter::new(ChapterId::Sampling, "Sampling");
    if is_empty(sampling) {
        return chapter;
    }
    brief(&mut chapter.brief, sampling);
    chapter.facts(facts(sampling));
    for why in &sampling.unknown {
        chapter.note(format!("Not known: {why}."));
    }
    if !sampling.next.is_empty() {
        next(&mut chapter, sampling);
    }
    chapter
}

fn is_empty(sampling: &SamplingFigures) -> bool {
    *sampling == SamplingFigures::default()
}

/// Coverage, what is missing and what is not known; noise and spacing.
fn brief(lines: &mut Vec<String>, sampling: &SamplingFigures) {
    let missing = [
        (sampling.undersampled_area_mm2, "mm² too coarse"),
        (sampling.uncovered_area_mm2, "mm² not scanned"),
    ];
    let missing = missing.iter().filter_map(|&(area_mm2, what)| {
        let area_mm2 = area_mm2.filter(|area_mm2| *area_mm2 > 0.0)?;
        Some(format!("{} {what}", short(area_mm2)))
    });
    let covered =
        sampling.coverage.map(|share| format!("{} sampled densely enough", percent(share)));
    push(lines, covered.into_iter().chain(missing), ", ");
    let gap = (sampling.gap_max_mm, sampling.gap_allowed_mm());
    let gap = gap.0.map(|mm| {
        let allowed = gap.1.map_or(String::new(), |mm| format!(" of {} mm allowed", short(mm)));
        format!("largest gap {} mm{allowed}", short(mm))
    });
    let epsilon = sampling.epsilon_max.map(|epsilon| {
        let allowed = sampling
            .epsilon_target
            .map_or(String::new(), |of| format!(" of {} allowed", short(of)));
        format!("largest ε {}{allowed}", short(epsilon))
    });
    push(lines, [gap, epsilon].into_iter().flatten(), ", ");
    if let (Some(allowed), Some(rho)) = (sampling.rho_target, sampling.rho_max) {
        let reach = sampling.reach_mm.map(|mm| format!("reach {} mm", short(mm)));
        let rho = format!("largest ρ {} of {} allowed", short(rho), short(allowed));
        push(lines, std::iter::once(rho).chain(reach), ", ");
    }
    push(lines, density(sampling), "; ");
    lines.extend(sampling.unknown.iter().cloned());
    push(
        lines,
        sampling.next.first().map(|first| {
            let regions = sampling.next.len() as u64 + sampling.next_more;
            let adds = first
                .adds_coverage
                .map_or(String::new(), |share| format!(", adds {}", percent(share)));
            let others = if regions > 1 {
                format!("; {} regions in all", count(regions))
            } else {
                String::new()
            };
            let from = first
                .approach
                .as_ref()
                .map_or(String::new(), |from| format!(" from {}", direction(from)));
            format!(
                "measure next {} mm² about {}{from}{adds}{others}",
                short(first.area_mm2),
                place(&first.at_mm)
            )
        }),
        "",
    );
}

fn push(lines: &mut Vec<String>, parts: impl IntoIterator<Item = String>, between: &str) {
    let parts: Vec<String> = parts.into_iter().collect();
    if !parts.is_empty() {
        lines.push(parts.join(between));
    }
}

/// Noise and spacing, with the spacings that would do.
fn density(sampling: &SamplingFigures) -> Vec<String> {
    let noise = sampling.noise_sigma_nm.map(|nm| format!("noise {} nm", short(nm)));
    let bounds = [
        sampling.spacing_coarsest_mm.map(|mm| format!("coarsest that meets ε: {} mm", short(mm))),
        sampling.spacing_finest_mm.map(|mm| format!("finest useful: {} mm", short(mm))),
        sampling.spacing_recommended_mm.map(|mm| format!("recommended: {} mm", short(mm))),
    ];
    let bounds: Vec<String> = bounds.into_iter().flatten().collect();
    let spacing = sampling.spacing_median_mm.map(|mm| {
        let around =
            if bounds.is_empty() { String::new() } else { format!(" ({})", bounds.join("; ")) };
        format!("point spacing {} mm{around}", short(mm))
    });
    let share = sampling.overdense_fraction.filter(|share| *share > 0.0);
    let dense = share.map(|share| format!("{} of the surface finer than that", percent(share)));
    [noise, spacing, dense].into_iter().flatten().collect()
}

fn facts(sampling: &SamplingFigures) -> Vec<Fact> {
    let share = |share: Option<f64>| share.map_or_else(|| DASH.to_owned(), percent);
    let known = |name: &str, value: Option<f64>, unit: &str| Fact::new(name, quantity(value, unit));
    let mut facts = vec![
        Fact::new("Coverage of the aperture", share(sampling.coverage)),
        known("Scanned too coarsely", sampling.undersampled_area_mm2, "mm²"),
        known("Not scanned", sampling.uncovered_area_mm2, "mm²"),
    ];
    // While points arrive these are kept up with them; all else waits for the next look at the whole mesh.
    let newest = sampling.current.as_ref();
    let [gap_max_mm, gap_p99_mm, epsilon_max, epsilon_p99, rho_max] = match newest {
        Some(now) => {
            [now.gap_max_mm, now.gap_p99_mm, now.epsilon_max, now.epsilon_p99, now.rho_max]
        }
        None => [
            sampling.gap_max_mm,
            sampling.gap_p99_mm,
            sampling.epsilon_max,
            sampling.epsilon_p99,
            sampling.rho_max,
        ],
    };
    facts.extend([
        known("Largest gap", gap_max_mm, "mm"),
        known("Gap, 99 % of the area up to", gap_p99_mm, "mm"),
        known("Gap allowed", sampling.gap_limit_mm, "mm"),
        known("Largest ε, gap / lfs", epsilon_max, ""),
        known("ε, 99 % of the area up to", epsilon_p99, ""),
        known("ε allowed", sampling.epsilon_target, ""),
    ]);
    if sampling.rho_target.is_some() {
        facts.extend([
            known("Largest ρ, gap / reach", rho_max, ""),
            known("ρ allowed", sampling.rho_target, ""),
            known("Reach, smallest lfs", sampling.reach_mm, "mm"),
        ]);
    }
    let whole = |number: Option<u64>| number.map_or_else(|| DASH.to_owned(), count);
    let source = sampling.lfs_source.clone().unwrap_or_else(|| "not known".to_owned());
    facts.extend([
        known("Smallest local feature size (lfs)", sampling.lfs_min_mm, "mm"),
        Fact::new("Its source", source),
        known("Noise from point to point", sampling.noise_sigma_nm, "nm"),
        known("Median spacing", sampling.spacing_median_mm, "mm"),
        known("Coarsest spacing that meets ε", sampling.spacing_coarsest_mm, "mm"),
        known("Finest useful spacing", sampling.spacing_finest_mm, "mm"),
        known("Recommended spacing", sampling.spacing_recommended_mm, "mm"),
        Fact::new("Denser than the noise allows", share(sampling.overdense_fraction)),
        Fact::new(
            "Islands, holes",
            format!("{}, {}", whole(sampling.islands), whole(sampling.holes)),
        ),
    ]);
    if let Some(now) = newest {
        facts.extend([
            Fact::new("Gap, ε and ρ as of", format!("{} points", count(now.as_of_points))),
            Fact::new("The rest as of", format!("{} points", count(sampling.as_of_points))),
        ]);
    }
    facts
}

fn next(chapter: &mut Chapter, sampling: &SamplingFigures) {
    let in_space = sampling.next.iter().any(|next| next.approach.is_some());
    let mut columns = vec![
        ("", Layout::Head),
        ("area", Layout::Number),
        ("about", Layout::Number),
        ("adds to the coverage", Layout::Number),
        ("largest ε", Layout::Number),
        ("spacing needed", Layout::Number),
        ("points", Layout::Number),
    ];
    columns.extend(in_space.then_some(("from", Layout::Number)));
    let mut table = Table::new(&columns).titled("To measure next");
    table.rows.extend((1..).zip(&sampling.next).take(NEXT_SHOWN).map(
        |(number, next): (u32, _)| {
            let from = next.approach.as_ref().map_or_else(|| DASH.to_owned(), direction);
            let mut row = vec![
                number.to_string(),
                quantity(Some(next.area_mm2), "mm²"),
                place(&next.at_mm),
                next.adds_coverage.map_or_else(|| DASH.to_owned(), percent),
                quantity(next.epsilon_max, ""),
                quantity(next.spacing_needed_mm, "mm"),
                next.points_needed.map_or_else(|| DASH.to_owned(), count),
            ];
            row.extend(in_space.then_some(from));
            row
        },
    ));
    chapter.table(table);
    let more = sampling.next.len().saturating_sub(NEXT_SHOWN) as u64 + sampling.next_more;
    if more > 0 {
        chapter.note(format!("And {} smaller regions.", count(more)));
    }
}

/// Regions that are listed.
const NEXT_SHOWN: usize = 8;
