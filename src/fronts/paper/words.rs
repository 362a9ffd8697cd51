//! Texts as the paper writes them: escaped, and instants in words.

use jiff::Timestamp;

/// Text for HTML and XML, between tags or in an attribute: what has a meaning there is escaped, and control
/// characters, which XML forbids, are replaced.
pub(super) fn text(words: &str) -> String {
    quick_xml::escape::escape(printable(words)).into_owned()
}

/// Words without control characters, which XML forbids.
pub(super) fn printable(words: &str) -> String {
    let allowed = |c: char| match c {
        '\t' | '\n' | '\r' => c,
        '\u{fffe}' | '\u{ffff}' => '\u{fffd}',
        c if c.is_control() => '\u{fffd}',
        c => c,
    };
    words.chars().map(allowed).collect()
}

/// Text for a string of a style sheet, quotes included, that can end neither the string nor the sheet.
pub(super) fn css_string(words: &str) -> String {
    let mut css = String::from("\"");
    for c in words.chars() {
        if c.is_alphanumeric() || " .,:;+-_()/".contains(c) {
            css.push(c);
        } else {
            css.push_str(&format!("\\{:x} ", u32::from(c)));
        }
    }
    css.push('"');
    css
}

/// An instant as people read it, to the second; as it stands where it is in no form that is known.
pub(super) fn instant(rfc3339: &str) -> String {
    match rfc3339.parse::<Timestamp>() {
        Ok(instant) => instant.strftime("%Y-%m-%d %H:%M:%S UTC").to_string(),
        Err(_) => rfc3339.to_owned(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn text_ends_no_element_and_no_attribute() {
        assert_eq!(text("a<b>&\"c'\u{0}"), "a&lt;b&gt;&amp;&quot;c&apos;\u{fffd}");
        let css = css_string("\"}</style><script>\\");
        assert!(!css[1..css.len() - 1].contains(['"', '<', '>', '}']), "{css}");
    }

    #[test]
    fn an_instant_is_shown_to_the_second() {
        assert_eq!(instant("2026-11-21T11:02:24.850250114Z"), "2026-11-21 11:02:24 UTC");
        assert_eq!(instant("last Tuesday"), "last Tuesday");
    }
}
