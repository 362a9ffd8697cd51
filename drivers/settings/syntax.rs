//! Places where a text stops being TOML, in words that say what to write.

/// What the parser expected and what it found, from its message and the text at the place.
pub(crate) fn in_words(message: &str, at: Option<&str>) -> (String, String) {
    let text = at.filter(|text| !text.trim().is_empty());
    let found = text.map_or_else(|| "something else".to_owned(), |text| format!("{text:?}"));
    let starts = |words: &str| message.starts_with(words);
    if starts("duplicate key") {
        ("each key and each table once".into(), format!("{found} again"))
    } else if starts("string values must be quoted") {
        ("a value: text in quotes, a number, true or false".into(), found)
    } else if starts("invalid basic string") || starts("invalid literal string") {
        ("a quote at the end of the text".into(), "the end of the line".into())
    } else if starts("cannot extend value") {
        ("a table of this name, but a key has it above".into(), found)
    } else {
        (format!("TOML ({message})"), found)
    }
}
