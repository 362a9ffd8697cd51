//! Parts of a session in words.

use super::{Chapter, ChapterId, Fact, Layout, Table};
use crate::Status;
use crate::parts::{Answer, PartReport, SessionParts};
use crate::words::{DASH, count, counted, short, with_u};

/// How many parts there are, as it stands in large letters.
pub(super) fn headline(found: &SessionParts) -> Vec<Fact> {
    let parts = Fact::new("Parts", count(found.parts.len() as u64));
    vec![match confirmed(found) {
        Some(confirmed) => parts.noted(confirmed),
        None => parts,
    }]
}

/// How many parts a library confirms.
fn confirmed(found: &SessionParts) -> Option<String> {
    let known = found.parts.iter().filter(|part| answer(&part.part) == Some(Answer::Confirmed));
    let entries = match found.entries? {
        1 => "1 entry".to_owned(),
        entries => format!("{entries} entries"),
    };
    Some(format!("{} confirmed by a library of {entries}", known.count()))
}

pub(super) fn chapter(found: &SessionParts) -> Chapter {
    let mut chapter = Chapter::new(ChapterId::Parts, "Parts");
    let parts = counted(found.parts.len() as u64, "part");
    chapter.brief.push(match confirmed(found) {
        Some(confirmed) => format!("{parts}, {confirmed}"),
        None => parts,
    });
    let mut table = Table::new(&[
        ("No.", Layout::Head),
        ("part", Layout::Text),
        ("answer", Layout::Text),
        ("points", Layout::Number),
        ("PV ± u", Layout::Number),
        ("RMS ± u", Layout::Number),
        ("x, y, z", Layout::Number),
        ("holes", Layout::Number),
    ]);
    for (number, session_part) in (1_u64..).zip(&found.parts) {
        let part = &session_part.part;
        let nm = |pick: fn(&crate::parts::PartForm) -> (f64, Option<f64>)| {
            part.form.as_ref().map_or(DASH.to_owned(), |form| {
                let (value, u) = pick(form);
                format!("{} nm", with_u(value, u))
            })
        };
        table.rows.push(vec![
            count(number),
            part.found.as_ref().and_then(|found| found.name.clone()).unwrap_or(DASH.to_owned()),
            word(part).to_owned(),
            count(part.figures.points),
            nm(|form| (form.pv_nm, form.u_pv_nm)),
            nm(|form| (form.rms_nm, form.u_rms_nm)),
            format!("{} mm", part.figures.centre_mm.map(short).join(", ")),
            part.figures.loops.to_string(),
        ]);
    }
    if !table.rows.is_empty() {
        chapter.table(table);
    }
    for (number, session_part) in (1_u64..).zip(&found.parts) {
        if session_part.is_open {
            chapter.note(format!("Part {number} reaches the end of the scan: it may be cut off."));
        }
    }
    if found.islands > 0 {
        chapter.note(format!(
            "{} of {} in all are too few for a part.",
            counted(found.islands as u64, "island"),
            counted(found.island_points, "point")
        ));
    }
    let lost = found.late + found.outside + found.crumbs;
    if lost > 0 {
        chapter.note(format!("{} lie in no part.", counted(lost, "point")));
    }
    if found.waiting > 0 {
        chapter.note(format!("{} not measured.", counted(found.waiting as u64, "part")));
    }
    chapter
}

fn answer(part: &PartReport) -> Option<Answer> {
    part.found.as_ref().map(|found| found.verdict)
}

/// The answer on a part: its verdict where its fit confirms what it is.
fn word(part: &PartReport) -> &'static str {
    match (answer(part), &part.form) {
        (None, _) => DASH,
        (Some(Answer::Unknown), _) => "unknown",
        (Some(_), None) => "not measured",
        (Some(_), Some(form)) => match form.verdict.status {
            Status::Pass => "PASS",
            Status::Fail => "FAIL",
            Status::Undecided => "UNDECIDED",
            Status::None => "no limits",
        },
    }
}
