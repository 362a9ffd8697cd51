//! The verdict in words.

use super::{Chapter, ChapterId, Layout, Table};
use crate::words::{DASH, quantity};
use crate::{Check, Status, Verdict};

impl Status {
    /// The word of a verdict in capitals: `PASS`, `NO LIMITS`.
    pub fn word(self) -> &'static str {
        match self {
            Status::Pass => "PASS",
            Status::Fail => "FAIL",
            Status::Undecided => "UNDECIDED",
            Status::None => "NO LIMITS",
        }
    }
}

/// The word first, then a line a check, then the reasons.
pub(super) fn chapter(verdict: &Verdict) -> Chapter {
    let mut chapter = Chapter::new(ChapterId::Verdict, "Verdict");
    chapter.brief.push(verdict.status.word().to_owned());
    chapter.brief.extend(verdict.checks.iter().map(line));
    let rule = verdict.checks.iter().find_map(|check| check.rule.clone());
    chapter.brief.extend(rule.clone());
    chapter.brief.extend(verdict.reasons.iter().cloned());
    let mut table = Table::new(&[
        ("figure", Layout::Head),
        ("value", Layout::Number),
        ("limit", Layout::Number),
        ("u (k = 1)", Layout::Number),
        ("guard band", Layout::Number),
        ("holds", Layout::Text),
    ]);
    table.rows.extend(verdict.checks.iter().map(row));
    chapter.table(table);
    for check in &verdict.checks {
        let name = check.figure.words();
        chapter.blocks.extend(
            check
                .u_covers
                .as_ref()
                .map(|covers| super::Block::Note { text: format!("u of {name} covers {covers}.") }),
        );
    }
    if let Some(rule) = rule {
        chapter.note(format!("Rule: {rule}."));
    }
    chapter
}

/// Value and limit; what is not proven stands among the reasons.
fn line(check: &Check) -> String {
    let sign = if check.value <= check.limit { "≤" } else { ">" };
    let unit = &check.figure.unit;
    let band = check
        .guard_band
        .map_or(String::new(), |band| format!(", guard band {}", quantity(Some(band), unit)));
    format!(
        "{} {} {sign} {}{band}",
        check.figure.words(),
        quantity(Some(check.value), unit),
        quantity(Some(check.limit), unit)
    )
}

fn row(check: &Check) -> Vec<String> {
    let unit = &check.figure.unit;
    let holds = match (check.ok, &check.doubt) {
        (true, _) => "yes".to_owned(),
        (false, Some(doubt)) => format!("not proven: {doubt}"),
        (false, None) if check.is_broken() => "no".to_owned(),
        (false, None) => "within the guard band".to_owned(),
    };
    let known = |value: Option<f64>| match value {
        Some(_) => quantity(value, unit),
        None => DASH.to_owned(),
    };
    vec![
        check.figure.words(),
        quantity(Some(check.value), unit),
        quantity(Some(check.limit), unit),
        known(check.u),
        known(check.guard_band),
        holds,
    ]
}
