//! A contour in words.

use super::{Chapter, ChapterId, Fact};
use crate::contour::ContourReport;
use crate::words::{quantity, short, with_u};

pub(super) fn chapter(contour: &ContourReport) -> Chapter {
    let mut chapter = Chapter::new(ChapterId::Contour, "Contour");
    if contour.chains.is_empty() {
        chapter.brief.extend(contour.unknown.first().cloned());
        note_unknown(&mut chapter, contour);
        return chapter;
    }
    let closed = contour.chains.iter().filter(|chain| chain.closed).count();
    let length_mm: f64 = contour.chains.iter().map(|chain| chain.length_mm).sum();
    let open = contour.chains.len() - closed;
    let lines = format!("{closed} closed, {open} open, {} mm together", short(length_mm));
    chapter.brief.push(format!("{}: {lines}", contour.method));
    let method = Fact::new("Method", contour.method.clone());
    let mut facts = vec![
        match &contour.reason {
            Some(reason) => method.noted(reason.clone()),
            None => method,
        },
        Fact::new("Lines", lines),
        Fact::new("Spacing of the points", quantity(contour.input.spacing_median_mm, "mm"))
            .noted("median"),
    ];
    facts.extend(
        contour.area_mm2.map(|area_mm2| Fact::new("Area", format!("{} mm²", short(area_mm2)))),
    );
    if let Some(circle) = &contour.circle {
        let diameter = format!("{} mm", with_u(circle.diameter_mm, Some(circle.u_diameter_mm)));
        let roundness = format!("{} mm", with_u(circle.roundness_mm, Some(circle.u_roundness_mm)));
        chapter.brief.push(format!("diameter {diameter}, roundness {roundness}"));
        facts.push(Fact::new("Diameter", diameter).noted("least squares, ± u"));
        facts.push(Fact::new("Roundness", roundness).noted("about that circle, ± u"));
    }
    if let Some(deviation) = &contour.deviation {
        let [least, largest] = [deviation.least_mm, deviation.largest_mm].map(short);
        let found = format!("{least} to {largest} mm");
        chapter.brief.push(format!("deviation {found} from {}", deviation.outline));
        facts.push(Fact::new("Deviation", found).noted(format!("from {}", deviation.outline)));
    }
    chapter.facts(facts);
    note_unknown(&mut chapter, contour);
    chapter
}

/// The first reasons; files have all of them.
fn note_unknown(chapter: &mut Chapter, contour: &ContourReport) {
    for why in contour.unknown.iter().take(MOST_REASONS) {
        chapter.note(format!("Not known: {why}."));
    }
    let more = contour.unknown.len().saturating_sub(MOST_REASONS);
    if more > 0 {
        chapter.note(format!("{more} more that are not known stand in report.json."));
    }
}

/// Reasons that are listed: a noisy curve may have one for every piece.
const MOST_REASONS: usize = 8;
