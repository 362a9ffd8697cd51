//! Figures by standards and optical shops, and Zernike terms, as tables.

use super::{Chapter, ChapterId, Layout, Table};
use crate::words::{DASH, percent, quantity, short};
use crate::{FormFigure, FormFigures};

pub(super) fn chapter(form: &FormFigures) -> Chapter {
    let mut chapter = Chapter::new(ChapterId::Figures, "Figures");
    if let Some(indication) = &form.standards.indication {
        if let Some(asked) = &indication.asked {
            chapter.brief.push(format!("drawing asks {asked}; found {}", indication.found));
        }
        chapter.note(match &indication.asked {
            Some(asked) => format!("By ISO 10110-5 found {}; asked {asked}.", indication.found),
            None => format!("By ISO 10110-5 found {}.", indication.found),
        });
    }
    let (removed, whole): (Vec<&FormFigure>, Vec<&FormFigure>) =
        form.figures.iter().partition(|figure| !figure.removed.is_empty());
    let is_evaluated = whole.iter().any(|figure| {
        figure.u.is_some() || figure.expanded.is_some() || figure.noise_adds.is_some()
    });
    chapter.table(of_whole(&whole, is_evaluated));
    if !is_evaluated && !whole.is_empty() {
        chapter.note("No uncertainty was evaluated for these figures.");
    }
    if !removed.is_empty() {
        chapter.table(with_terms_removed(&removed));
        chapter.note(
            "Fringe terms over the aperture, fitted together and subtracted. The verdict is by these only where a limit \
             names them.",
        );
    }
    for why in &form.unknown {
        chapter.note(format!("Not known: {why}."));
    }
    chapter
}

fn of_whole(figures: &[&FormFigure], is_evaluated: bool) -> Table {
    let mut columns =
        vec![("figure", Layout::Head), ("of", Layout::Text), ("value", Layout::Number)];
    if is_evaluated {
        columns.push(("uncertainty", Layout::Number));
    }
    columns.push(("definition", Layout::Fine));
    let mut table = Table::new(&columns);
    table.rows.extend(figures.iter().map(|figure| {
        let mut row = vec![
            figure.name.clone(),
            figure.variant.clone(),
            quantity(Some(figure.value), &figure.unit),
        ];
        if is_evaluated {
            row.push(uncertainty(figure));
        }
        row.push(definition(figure));
        row
    }));
    table
}

/// Definition and source of a figure.
pub(crate) fn definition(figure: &FormFigure) -> String {
    format!("{} ({})", figure.definition, figure.source)
}

fn uncertainty(figure: &FormFigure) -> String {
    let unit = &figure.unit;
    match (&figure.expanded, figure.u) {
        (Some(expanded), _) => format!(
            "U = {} {unit} (k = {:.2}, p = {})",
            short(expanded.value),
            expanded.k,
            percent(expanded.p)
        ),
        (None, Some(u)) => format!("u = {} {unit} (k = 1)", short(u)),
        (None, None) => match (figure.without_noise, figure.noise_adds) {
            (Some(without), _) => format!("without noise {} {unit}", short(without)),
            (None, Some(adds)) => format!("noise adds at most {} {unit}", short(adds)),
            (None, None) => "not evaluated".to_owned(),
        },
    }
}

/// u and interval behind a value; the interval is of what noise leaves of it where it does not hold the value.
pub(crate) fn known_of(figure: &FormFigure) -> String {
    let (Some(u), Some(of)) = (figure.u, &figure.simulated) else { return String::new() };
    let without = if (of.low..=of.high).contains(&figure.value) {
        String::new()
    } else {
        format!("without noise {}, ", short(of.without_noise))
    };
    let (u, low, high) = (short(u), short(of.low), short(of.high));
    format!(" ({without}u {u}, {:.0} %: {low} to {high})", 100.0 * of.p)
}

/// One row a set of terms removed, one column a figure.
fn with_terms_removed(figures: &[&FormFigure]) -> Table {
    let mut sets: Vec<&[String]> = Vec::new();
    for figure in figures {
        if !sets.contains(&&figure.removed[..]) {
            sets.push(&figure.removed);
        }
    }
    let mut columns: Vec<(&str, &str)> = Vec::new();
    for figure in figures {
        if !columns.iter().any(|(id, _)| *id == figure.id) {
            columns.push((&figure.id, &figure.name));
        }
    }
    let mut heads = vec![("removed", Layout::Head)];
    heads.extend(columns.iter().map(|(_, name)| (*name, Layout::Number)));
    let mut table = Table::new(&heads).titled("With terms removed");
    for set in sets {
        let mut row = vec![set.join(", ")];
        row.extend(columns.iter().map(|(id, _)| {
            let found = figures.iter().find(|figure| figure.removed == set && figure.id == *id);
            found.map_or_else(|| DASH.to_owned(), |one| quantity(Some(one.value), &one.unit))
        }));
        table.rows.push(row);
    }
    table
}

/// Zernike terms: how they are defined, and their coefficients.
pub(super) fn zernike(form: &FormFigures) -> Option<Chapter> {
    let zernike = form.zernike.as_ref()?;
    let mut chapter = Chapter::new(ChapterId::Zernike, "Zernike terms");
    chapter.note(format!(
        "{} order, {}, over a disc of {} mm radius about the origin; fitted together. They leave an RMS of {} nm.",
        zernike.scheme,
        zernike.normalisation,
        short(zernike.radius_mm),
        short(zernike.residual_rms_nm)
    ));
    if !zernike.indeterminate.is_empty() {
        let numbers: Vec<String> = zernike.indeterminate.iter().map(ToString::to_string).collect();
        chapter.note(format!("Not told from lower ones by these places: {}.", numbers.join(", ")));
    }
    Some(chapter)
}
