//! Files beside a configuration, whose text a recording keeps in their stead.

use std::path::Path;
use std::str::FromStr as _;

use asphera_measure::Part;
use asphera_nominal::{aperture_lines_mm, bytes_of};
use asphera_settings::Section;
use toml_edit::{Array, DocumentMut};

/// Text of the file that `key` names, found from `folder`; of a recording the one kept as `key_text`. `None` where there is no
/// such key, or the file cannot be read as `expected`, which is a problem of the table.
pub(super) fn text_of(
    table: &Section<'_>,
    key: &str,
    folder: &Path,
    expected: &str,
) -> Option<(String, String)> {
    let recorded: Option<String> = table.get(&kept(key));
    let name: String = table.get(key)?;
    if let Some(text) = recorded {
        return Some((name, text));
    }
    match bytes_of(&folder.join(&name)).map(String::from_utf8) {
        Ok(Ok(text)) => return Some((name, text)),
        Ok(Err(_)) => table.problem(key, expected, "other bytes"),
        Err(error) => {
            table.problem(key, "a file that can be read", format!("{name}: {error}"));
        }
    }
    None
}

/// The configuration with the text of a file beside its name in a table, which may lie in others: `kinematics.x`.
pub(super) fn embedded(text: &str, table: &str, key: &str, content: &str) -> String {
    let Ok(mut document) = DocumentMut::from_str(text) else { return text.to_owned() };
    let whole = Some(document.as_item_mut());
    let item = table.split('.').fold(whole, |item, name| item?.get_mut(name));
    if let Some(table) = item.and_then(|item| item.as_table_like_mut()) {
        table.insert(&kept(key), toml_edit::value(content));
    }
    document.to_string()
}

/// The configuration with the closed lines of the outline of its nominal's aperture, and their middle, in the place of the
/// file that they were read from.
pub(super) fn with_outline(text: &str, part: &Part) -> String {
    let (Some(lines), Ok(mut document)) =
        (aperture_lines_mm(&part.aperture), DocumentMut::from_str(text))
    else {
        return text.to_owned();
    };
    let nominal = document.get_mut("nominal").and_then(|nominal| nominal.get_mut("aperture"));
    if let Some(table) = nominal.and_then(|table| table.as_table_like_mut()) {
        table.remove("file");
        let lines = lines.into_iter().map(Array::from_iter);
        table.insert("lines_mm", toml_edit::value(Array::from_iter(lines)));
        if part.centre_mm != [0.0; 2] {
            table.insert("centre_mm", toml_edit::value(Array::from_iter(part.centre_mm)));
        }
    }
    document.to_string()
}

/// The key under which the text is kept.
fn kept(key: &str) -> String {
    format!("{key}_text")
}
