//! Minimum zone and surface texture in words.

use super::figures::definition;
use super::reliability::of_draws;
use super::{Chapter, ChapterId, Layout, Table};
use crate::words::{DASH, count, minus, percent, place, quantity, short};
use crate::{FormFigure, FormFigures, MinimumZoneFigures, PoseFigures, TextureFigures};

/// The chapters of those that the nominal file asks for.
pub(super) fn chapters(form: &FormFigures) -> Vec<Chapter> {
    let of = &form.standards;
    let zone = of.minimum_zone.as_ref().map(|zone| minimum_zone(zone, &form.fit.pose));
    zone.into_iter().chain(of.texture.as_ref().map(texture)).collect()
}

/// The zone, what it is beside the fit, and what shows that none near by is narrower.
fn minimum_zone(zone: &MinimumZoneFigures, pose: &PoseFigures) -> Chapter {
    let mut chapter = Chapter::new(ChapterId::MinimumZone, "Minimum zone");
    chapter.brief.push(format!(
        "{} nm{}; none near by is narrower than {} nm",
        short(zone.width.value),
        known_of(&zone.width),
        short(zone.lower_nm)
    ));
    chapter.note(format!(
        "Every point lies within {} nm between two parallels of the nominal; at the least-squares fit the same points span \
         {} nm. The middle of the zone lies {} nm above the nominal.",
        short(zone.width.value),
        short(zone.least_squares_pv_nm),
        short(zone.offset_nm)
    ));
    if let (Some(u), Some(simulated)) = (zone.width.u, &zone.width.simulated) {
        chapter.note(format!(
            "u = {} nm (k = 1); {} to {} nm, 95 % of {}; noise adds about {} nm. {}",
            short(u),
            short(simulated.low),
            short(simulated.high),
            simulated.covers,
            short(simulated.bias),
            of_draws(simulated)
        ));
    }
    chapter.note(format!(
        "{}, {}. Certificate: no zone near by is narrower than {} nm, which is {} nm less; all {} points were held against \
         it {} times, and these hold it:",
        zone.method,
        zone.termination,
        short(zone.lower_nm),
        minus(format!("{:.0e}", zone.gap_nm)),
        count(zone.points),
        count(zone.passes)
    ));
    let mut table = Table::new(&[
        ("border", Layout::Head),
        ("at", Layout::Text),
        ("share in holding it", Layout::Number),
    ]);
    table.rows.extend(zone.contacts.iter().map(|contact| {
        vec![contact.side.clone(), place(&pose.to_measured(contact.at_mm)), percent(contact.share)]
    }));
    chapter.table(table);
    chapter.note(definition(&zone.width));
    chapter
}

/// The scale, then the parameters.
fn texture(texture: &TextureFigures) -> Chapter {
    let mut chapter = Chapter::new(ChapterId::Texture, "Surface texture");
    let surface = match texture.surface.as_str() {
        kind @ ("S-F" | "S-L") => format!("{kind} surface"),
        kind => format!("Surface of {kind}"),
    };
    let first = texture.figures.iter().take(BRIEF).map(|figure| {
        format!(
            "{} {}{}",
            figure.name,
            quantity(Some(figure.value), &figure.unit),
            known_of(figure)
        )
    });
    chapter.brief.push(format!("{surface}: {}", first.collect::<Vec<_>>().join(", ")));
    chapter.note(format!(
        "{surface} of the deviation from the fitted nominal, less {}. {} points; {} of the area that is sampled densely \
         enough.",
        texture.f_operation,
        count(texture.points),
        percent(texture.measured)
    ));
    for filter in &texture.filters {
        chapter.note(format!("{filter}."));
    }
    let simulated = texture.figures.iter().find_map(|figure| figure.simulated.as_ref());
    let mut columns = vec![("parameter", Layout::Head), ("value", Layout::Number)];
    if simulated.is_some() {
        columns.push(("without noise ± u (k = 1); 95 %", Layout::Number));
    }
    columns.push(("definition", Layout::Fine));
    let mut table = Table::new(&columns);
    table.rows.extend(texture.figures.iter().map(|figure| {
        let mut row = vec![figure.name.clone(), quantity(Some(figure.value), &figure.unit)];
        if simulated.is_some() {
            row.push(uncertainty(figure));
        }
        row.push(definition(figure));
        row
    }));
    chapter.table(table);
    chapter.note(match simulated {
        Some(simulated) => format!(
            "Intervals cover 95 % of {}. They are of the surface without the share of noise. Those of extremes (Sp, Sv, Sz, \
             minimum zone) include a defect of a single point that noise may hide. {}",
            simulated.covers,
            of_draws(simulated)
        ),
        None => "No uncertainty was evaluated for these.".to_owned(),
    });
    chapter
}

fn uncertainty(figure: &FormFigure) -> String {
    match (figure.u, &figure.simulated) {
        (Some(u), Some(simulated)) => format!(
            "{} ± {}; {} to {}",
            short(simulated.without_noise),
            short(u),
            short(simulated.low),
            short(simulated.high)
        ),
        _ => DASH.to_owned(),
    }
}

/// u and interval behind a value; the interval is of what noise leaves of it where it does not hold the value.
fn known_of(figure: &FormFigure) -> String {
    let (Some(u), Some(of)) = (figure.u, &figure.simulated) else { return String::new() };
    let without = if (of.low..=of.high).contains(&figure.value) {
        String::new()
    } else {
        format!("without noise {}, ", short(of.without_noise))
    };
    let (u, low, high) = (short(u), short(of.low), short(of.high));
    format!(" ({without}u {u}, {:.0} %: {low} to {high})", 100.0 * of.p)
}

/// Parameters of texture that a summary has: the first of the list, Sa, Sq and what follows.
const BRIEF: usize = 3;
