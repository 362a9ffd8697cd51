//! The table `profile`: a row of heights in each frame.

use asphera_settings::Section;

use super::form;
use crate::field::Place;
use crate::profile::{Abscissae, ProfileRow};

pub(super) fn read(table: &Section<'_>) -> Option<ProfileRow> {
    let place = place(table);
    let form = form(table);
    let abscissae = abscissae(table);
    let (scale, offset_mm) = (table.or("scale", 1.0), table.or("offset_mm", 0.0));
    Some(ProfileRow {
        form,
        scale,
        offset_mm,
        valid_range_mm: table.range("valid_range_mm"),
        no_value: table.get("no_value"),
        no_signal: table.or("no_signal", Vec::new()),
        place: place?,
        abscissae: abscissae?,
    })
}

fn place(table: &Section<'_>) -> Option<Place> {
    match (table.get("column"), table.get("at")) {
        (Some(column), None) => Some(Place::Column(column)),
        (None, Some(at)) => Some(Place::At(at)),
        (None, None) => {
            table.problem("column", "one of `column` and `at`, of the first height", "nothing");
            None
        }
        (Some(_), Some(_)) => {
            table.problem("column", "one of `column` and `at`, of the first height", "both");
            None
        }
    }
}

/// Places along the line: given, or even.
fn abscissae(table: &Section<'_>) -> Option<Abscissae> {
    if table.has("x_mm") {
        for key in ["points", "x_first_mm", "pitch_mm"] {
            if table.has(key) {
                table.problem(key, "either x_mm, or points, x_first_mm and pitch_mm", "both");
            }
        }
        return table.get("x_mm").map(Abscissae::Given);
    }
    let points = table.required("points");
    let first_mm = table.or("x_first_mm", 0.0);
    let pitch_mm = table.required("pitch_mm");
    Some(Abscissae::Even { points: points?, first_mm, pitch_mm: pitch_mm? })
}
