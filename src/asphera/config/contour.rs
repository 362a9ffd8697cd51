//! `[contour]`: the contour that is formed of the points of every session.

use std::path::Path;

use asphera_contour::strokes::{Hint, hints_of};
use asphera_contour::{Kind, Method, Parameters};
use asphera_nominal::{DRAWINGS, guard};
use asphera_settings::Section;

use super::attached::{embedded, text_of};
use crate::contour::{ContourLimits, ContourPlan, ContourSettings, Nominal, Slab, plane_of};

/// Reads the table; `None` where it is absent or cannot be used. `folder` is that of the configuration, where the outline is
/// found. Gives the text of the configuration with the outline in it, so that a recording can be replayed without that file.
pub(super) fn read(
    table: &Section<'_>,
    folder: &Path,
    text: &str,
) -> (Option<ContourPlan>, String) {
    if !table.is_present() {
        return (None, text.to_owned());
    }
    let method = method(table);
    let parameters_table = table.section("parameters");
    let parameters = method.map(|method| parameters(&parameters_table, method));
    let tolerance_mm = table.within("tolerance_mm", 0.0, 0.0..=1e6);
    let is_airfoil = table.or("airfoil", false);
    let hints = hints(table, method);
    let gap_mm = table.has("gap_mm").then(|| table.within("gap_mm", 1.0, 1e-9..=1e6));
    let slab = slab(table);
    let (nominal, outline_text) = outline(table, folder).unzip();
    let limits = limits(&table.section("limits"), table.has("outline"));
    table.finish();
    let text = outline_text
        .map_or_else(|| text.to_owned(), |outline| embedded(text, "contour", "outline", &outline));
    let settings = method.zip(parameters).map(|(method, parameters)| ContourSettings {
        method,
        parameters,
        tolerance_mm,
        is_airfoil,
        gap_mm,
        nominal,
        hints,
    });
    (settings.map(|settings| ContourPlan { settings, slab, limits }), text)
}

fn method(table: &Section<'_>) -> Option<Method> {
    let words: Vec<(&str, Method)> = Method::ALL
        .iter()
        .filter(|method| method.kind() != Kind::Graph)
        .map(|method| (method.name(), *method))
        .collect();
    match table.has("method") {
        true => table.required_word("method", &words),
        false => Some(Method::Auto),
    }
}

/// The parameters of the method: numbers within their range; true and false are 1 and 0.
fn parameters(table: &Section<'_>, method: Method) -> Parameters {
    let mut parameters = Parameters::new();
    for parameter in method.parameters() {
        let name = parameter.name;
        let value = match table.is_bool(name) {
            true => table.get::<bool>(name).map(|is| f64::from(u8::from(is))),
            false => table.get::<f64>(name),
        };
        let Some(value) = value else { continue };
        if (parameter.low..=parameter.high).contains(&value) {
            parameters = parameters.with(name, value);
        } else {
            table.problem(name, format!("{} to {}", parameter.low, parameter.high), value);
        }
    }
    table.finish();
    parameters
}

/// The places within regions, with their labels: for the methods that need them, and for no others.
fn hints(table: &Section<'_>, method: Option<Method>) -> Vec<Hint> {
    const EXPECTED: &str = "a place within each region with its label, as \"1.5,2=hole;8,2=plate\"";
    let text: Option<String> = table.get("hints");
    let Some(method) = method else { return Vec::new() };
    if !method.takes_hints() {
        if table.has("hints") {
            let names = Method::ALL.iter().filter(|method| method.takes_hints());
            let names = names.map(Method::name).collect::<Vec<_>>().join(" or ");
            table.problem("hints", format!("method {names} beside it"), method.name());
        }
        return Vec::new();
    }
    match text.as_deref().map(hints_of) {
        Some(Ok(hints)) if !hints.is_empty() => hints,
        Some(Err(error)) => {
            table.problem("hints", EXPECTED, error);
            Vec::new()
        }
        // A value of another type has been named already.
        None if table.has("hints") => Vec::new(),
        Some(Ok(_)) | None => {
            table.problem("hints", EXPECTED, "none");
            Vec::new()
        }
    }
}

/// The plane and how far points may lie off it.
fn slab(table: &Section<'_>) -> Option<Slab> {
    let within_mm = table.within("within_mm", 0.0, 0.0..=1e6);
    if !table.has("plane") {
        if table.has("within_mm") {
            table.problem("within_mm", "no such key, or plane = [a, b, c, d]", "`within_mm`");
        }
        return None;
    }
    if within_mm <= 0.0 {
        table.problem("within_mm", "a distance above 0 mm beside plane", within_mm);
    }
    let numbers: Vec<f64> = table.get("plane")?;
    let plane = <[f64; 4]>::try_from(&numbers[..]).ok().and_then(plane_of);
    if plane.is_none() {
        let expected = "[a, b, c, d] of the plane a·x + b·y + c·z = d in mm, as [0, 0, 1, 5]";
        table.problem("plane", expected, format!("{numbers:?}"));
    }
    Some(Slab { plane: plane?, within_mm })
}

/// The nominal outline and its text: that beside it, or else of the file.
fn outline(table: &Section<'_>, folder: &Path) -> Option<(Nominal, String)> {
    let (name, text) = text_of(table, "outline", folder, "a drawing as text in UTF-8")?;
    match Nominal::of_drawing(Path::new(&name), |_| Ok(text.clone().into_bytes())) {
        Some(Ok(nominal)) => Some((nominal, text)),
        Some(Err(error)) => {
            table.problem("outline", "a drawing of an outline", error);
            None
        }
        None => {
            table.problem("outline", DRAWINGS, format!("{name:?}"));
            None
        }
    }
}

fn limits(table: &Section<'_>, has_outline: bool) -> ContourLimits {
    let limit = |key: &str| table.has(key).then(|| table.within(key, 1.0, 1e-9..=1e6));
    let (deviation_mm, roundness_mm) = (limit("deviation_mm"), limit("roundness_mm"));
    let guard = guard(table);
    if guard.is_some() && deviation_mm.is_none() && roundness_mm.is_none() {
        let key = if table.has("guard_factor") { "guard_factor" } else { "guard_probability" };
        table.problem(key, "a limit beside it, as deviation_mm or roundness_mm", "none");
    }
    let limits = ContourLimits { deviation_mm, roundness_mm, guard };
    if limits.deviation_mm.is_some() && !has_outline {
        let expected = "contour.outline beside it: the deviation is from that";
        table.problem("deviation_mm", expected, "none");
    }
    table.finish();
    limits
}
