//! The other side of a surface: a nominal file turned by half a turn about x.

use asphera_form::basis::Counting;
use thiserror::Error;
use toml_edit::{Array, ArrayOfTables, DocumentMut, Item, Table, TableLike, Value};

/// Why a nominal has no other side.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
pub enum FlipError {
    /// The text is no TOML.
    #[error("it is no TOML file: {0}")]
    Toml(String),
    /// Its kind cannot be turned key by key.
    #[error(
        "a surface of kind {0:?} cannot be turned in its file; measure it along the other direction: `--along 0,0,-1`"
    )]
    Kind(String),
    /// The outline of the aperture lies in a file of its own.
    #[error(
        "an aperture whose outline is in a file cannot be turned in this one; measure it along the other direction: \
         `--along 0,0,-1`"
    )]
    Outline,
}

/// The text of a nominal file with its surface turned by half a turn about x: what had the height z at (x, y) has -z at (x, -y).
/// That is how a surface looks from its other side: a convex one is concave. The middle of the aperture goes along. Comments and
/// all other keys stay.
///
/// # Errors
///
/// When it is no TOML file, or its kind holds its shape elsewhere (`grid`, `mirror`) or has none (`unknown`), or the aperture names a file.
pub fn flipped(text: &str) -> Result<String, FlipError> {
    let mut document: DocumentMut =
        text.parse().map_err(|error: toml_edit::TomlError| FlipError::Toml(error.to_string()))?;
    if let Some(surface) = document.get_mut("surface").and_then(Item::as_table_like_mut) {
        let kind = surface.get("kind").and_then(Item::as_str).unwrap_or_default().to_owned();
        if matches!(kind.as_str(), "grid" | "mirror" | "unknown") {
            return Err(FlipError::Kind(kind));
        }
        turn(surface);
    }
    if let Some(aperture) = document.get_mut("aperture").and_then(Item::as_table_like_mut) {
        if aperture.contains_key("file") {
            return Err(FlipError::Outline);
        }
        if let Some(centre) = aperture.get_mut("centre_mm").and_then(Item::as_array_mut) {
            negate_at(centre, 1);
        }
        if let Some(lines) = aperture.get_mut("lines_mm").and_then(Item::as_array_mut) {
            for line in lines.iter_mut().filter_map(Value::as_array_mut) {
                (1..line.len()).step_by(2).for_each(|at| negate_at(line, at));
            }
        }
    }
    Ok(document.to_string())
}

fn turn(surface: &mut dyn TableLike) {
    let word = |key: &str| surface.get(key).and_then(Item::as_str).map(str::to_owned);
    let counting = match word("indices").as_deref() {
        Some("fringe") => Some(Counting::Fringe),
        Some("noll") => Some(Counting::Noll),
        Some("ansi") => Some(Counting::Ansi),
        _ => None,
    };
    for (key, item) in surface.iter_mut() {
        match key.get() {
            "radius_mm" | "radius_x_mm" | "radius_y_mm" | "rotation_radius_mm" => negate(item),
            "coefficients_mm" => {
                if let Some(numbers) = item.as_array_mut() {
                    (0..numbers.len()).for_each(|at| negate_at(numbers, at));
                }
            }
            "terms" => terms(item, counting),
            "off_axis" => {
                if let Some(dy_mm) = item.as_table_like_mut().and_then(|it| it.get_mut("dy_mm")) {
                    negate(dy_mm);
                }
            }
            key if is_power(key) => negate(item),
            _ => {}
        }
    }
}

/// `A4`, `A12`: a coefficient of a power of the distance.
fn is_power(key: &str) -> bool {
    key.strip_prefix('A')
        .is_some_and(|order| !order.is_empty() && order.bytes().all(|byte| byte.is_ascii_digit()))
}

fn terms(item: &mut Item, counting: Option<Counting>) {
    let each = |term: &mut dyn TableLike| {
        // A term that is odd in y changes its sign twice.
        if !is_odd(term, counting)
            && let Some(size) = term.get_mut("mm")
        {
            negate(size);
        }
    };
    match item {
        Item::ArrayOfTables(tables) => {
            ArrayOfTables::iter_mut(tables).for_each(|table: &mut Table| each(table));
        }
        Item::Value(Value::Array(array)) => {
            for value in array.iter_mut() {
                if let Some(table) = value.as_inline_table_mut() {
                    each(table);
                }
            }
        }
        _ => {}
    }
}

/// Whether a term is odd in y: a sine of the angle, or an odd power of y.
fn is_odd(term: &dyn TableLike, counting: Option<Counting>) -> bool {
    let whole = |key: &str| term.get(key).and_then(Item::as_integer);
    if let Some(y) = whole("y") {
        return y % 2 != 0;
    }
    let m = whole("m").or_else(|| {
        let index = u32::try_from(whole("index")?).ok()?;
        counting?.orders(index).map(|(_, m)| m.into())
    });
    m.is_some_and(|m| m < 0)
}

fn negate(item: &mut Item) {
    if let Some(value) = item.as_value_mut() {
        negate_value(value);
    }
}

fn negate_at(numbers: &mut Array, at: usize) {
    if let Some(value) = numbers.get_mut(at) {
        negate_value(value);
    }
}

/// Spaces and comments beside the number stay.
fn negate_value(value: &mut Value) {
    let decor = value.decor().clone();
    let turned = match &*value {
        Value::Integer(number) => number.value().checked_neg().map(Value::from),
        // 0 has no sign in a file.
        Value::Float(number) if *number.value() != 0.0 => Some(Value::from(-number.value())),
        _ => None,
    };
    if let Some(turned) = turned {
        *value = turned;
        *value.decor_mut() = decor;
    }
}

#[cfg(test)]
mod tests {
    use super::super::part::parse;
    use super::*;

    /// Every kind of the reference files, by the heights of what is parsed from the turned text.
    #[test]
    fn every_kind_is_its_other_side_and_twice_itself() {
        let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/../../config/nominals");
        let (mut turned, mut refused) = (0, Vec::new());
        for entry in std::fs::read_dir(folder).unwrap() {
            let path = entry.unwrap().path();
            if path.extension().is_none_or(|extension| extension != "toml") {
                continue;
            }
            let text = std::fs::read_to_string(&path).unwrap();
            let name = path.display().to_string();
            let other = match flipped(&text) {
                Ok(other) => other,
                Err(FlipError::Kind(kind)) => {
                    refused.push(kind);
                    continue;
                }
                Err(error) => panic!("{name}: {error}"),
            };
            let parsed = |text: &str| parse(&name, text).unwrap_or_else(|e| panic!("{e}"));
            let (one, two) = (parsed(&text).nominal, parsed(&other).nominal);
            let mut seen = 0;
            for step in 0..200 {
                let (r_mm, angle) = (0.03 * f64::from(step), f64::from(step) * 0.7);
                let (x_mm, y_mm) = (r_mm * angle.cos(), r_mm * angle.sin());
                let heights = (one.height_mm(x_mm, y_mm), two.height_mm(x_mm, -y_mm));
                let (Some(z_mm), Some(turned_mm)) = heights else { continue };
                assert!((z_mm + turned_mm).abs() < 1e-9, "{name}: {z_mm} and {turned_mm}");
                seen += usize::from(z_mm.abs() > 1e-6);
            }
            assert!(seen > 50, "{name}: {seen} heights");
            assert_eq!(parsed(&flipped(&other).unwrap()).nominal, one, "{name}");
            turned += 1;
        }
        refused.sort();
        assert_eq!(refused, ["grid", "mirror", "unknown"]);
        assert!(turned >= 13, "{turned}");
    }

    #[test]
    fn comments_and_other_keys_stay() {
        let text = "# lens 7\n[surface]\nkind = \"conic\"\nradius_mm = 20 # of the drawing\nconic = -1.0\n\
                    [aperture]\nshape = \"circle\"\nradius_mm = 5.0\ncentre_mm = [1.0, 2.0]\n";
        assert_eq!(
            flipped(text).unwrap(),
            "# lens 7\n[surface]\nkind = \"conic\"\nradius_mm = -20 # of the drawing\nconic = -1.0\n\
             [aperture]\nshape = \"circle\"\nradius_mm = 5.0\ncentre_mm = [1.0, -2.0]\n"
        );
        assert!(matches!(flipped("surface = "), Err(FlipError::Toml(_))));
    }
}
