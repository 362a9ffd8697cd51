//! Defects and curvature in words.

use super::{Chapter, ChapterId, Layout, Table};
use crate::words::{count, percent, place, quantity, short};
use crate::{DefectFigures, DefectSearchFigures, FeatureFigures};

/// Defects, the most significant first, and the partition by curvature; empty where neither was looked for.
pub(super) fn chapter(features: &FeatureFigures) -> Chapter {
    let mut chapter = Chapter::new(ChapterId::Defects, "Defects");
    if let Some(why) = &features.defects_unknown {
        chapter.brief.push(format!("not looked for: {why}"));
        chapter.note(format!("Defects were not looked for: {why}."));
    }
    if let Some(defects) = features.defects.as_deref() {
        brief(&mut chapter.brief, features, defects);
        if defects.is_empty() {
            chapter.note("No defect was found.");
        } else {
            table(&mut chapter, features, defects);
        }
    }
    if let Some(search) = &features.defects_search {
        chapter.note(of_search(search));
    }
    if let Some(partition) = &features.partition {
        let shares = partition.shares.iter();
        let shares: Vec<String> =
            shares.map(|(class, share)| format!("{class} {}", percent(*share))).collect();
        chapter.note(format!("By curvature: {}.", shares.join(", ")));
    }
    if let Some(why) = &features.partition_unknown {
        chapter.note(format!("Curvature is not known: {why}."));
    }
    chapter
}

fn brief(lines: &mut Vec<String>, features: &FeatureFigures, defects: &[DefectFigures]) {
    let all = defects.len() as u64 + features.defects_more;
    let number = if all == 0 { "none".to_owned() } else { count(all) };
    let search = features.defects_search.as_ref().map_or(String::new(), |by| {
        let lower = if by.lower > 0 {
            format!("; {} lower than {} nm", count(by.lower), short(by.min_height_nm))
        } else {
            String::new()
        };
        let wide = short(by.largest_mm);
        // The tails of deviations in steps tell no threshold.
        if by.threshold_sigmas > MOST_SIGMAS {
            return format!(", but no threshold is known: most neighbours deviate alike; up to {wide} mm wide{lower}");
        }
        let (sigmas, sigma_nm) = (by.threshold_sigmas, short(by.sigma_nm));
        format!(" beyond {sigmas:.1} σ of {sigma_nm} nm, up to {wide} mm wide{lower}")
    });
    lines.push(format!("{number}{search}"));
    lines.extend(defects.iter().take(BRIEF).map(line));
    let more = all.saturating_sub(BRIEF as u64);
    if more > 0 {
        lines.push(format!("and {} more", count(more)));
    }
}

/// A threshold above this is none.
const MOST_SIGMAS: f64 = 1e4;

fn line(defect: &DefectFigures) -> String {
    let known = |mm: Option<f64>| mm.filter(|mm| mm.is_finite());
    let size = match (known(defect.length_mm), known(defect.width_mm)) {
        (Some(length), Some(width)) => format!(", {} × {} mm", short(length), short(width)),
        (Some(length), None) => format!(", {} mm long", short(length)),
        _ => String::new(),
    };
    let sign = if defect.height_nm > 0.0 { "+" } else { "" };
    format!(
        "{} {sign}{} nm{size} at {}, {:.0} σ",
        defect.kind,
        short(defect.height_nm),
        place(&defect.at_mm),
        defect.significance
    )
}

fn table(chapter: &mut Chapter, features: &FeatureFigures, defects: &[DefectFigures]) {
    let mut table = Table::new(&[
        ("", Layout::Head),
        ("kind", Layout::Text),
        ("about, measured frame", Layout::Number),
        ("height ± u", Layout::Number),
        ("area", Layout::Number),
        ("length", Layout::Number),
        ("width", Layout::Number),
        ("significance", Layout::Number),
    ]);
    table.rows.extend((1..).zip(defects).take(SHOWN).map(|(number, defect): (u32, _)| {
        vec![
            number.to_string(),
            format!("{}, {}", defect.kind, defect.shape),
            place(&defect.at_mm),
            format!("{} ± {} nm", short(defect.height_nm), short(defect.height_u_nm)),
            quantity(defect.area_mm2, "mm²"),
            quantity(defect.length_mm, "mm"),
            quantity(defect.width_mm, "mm"),
            short(defect.significance),
        ]
    }));
    chapter.table(table);
    let more = defects.len().saturating_sub(SHOWN) as u64 + features.defects_more;
    if more > 0 {
        chapter.note(format!("And {} less significant ones.", count(more)));
    }
}

fn of_search(search: &DefectSearchFigures) -> String {
    let reference =
        if search.reference == "nominal" { "deviation from the nominal" } else { "points" };
    format!(
        "Against a smooth surface through the {reference}, in windows of {} mm, up to {} mm wide; threshold {} times a noise \
         of {} nm, {} false ones expected; {} lower than {} nm not listed.",
        short(search.window_mm),
        short(search.largest_mm),
        short(search.threshold_sigmas),
        short(search.sigma_nm),
        short(search.false_expected),
        count(search.lower),
        short(search.min_height_nm)
    )
}

/// Defects of a summary.
const BRIEF: usize = 3;
/// Defects of the table.
const SHOWN: usize = 20;
