//! Numbers and texts as the paper writes them.

use jiff::Timestamp;

/// Text for HTML and XML, between tags or in an attribute: what has a meaning there is escaped, and control
/// characters, which XML forbids, are replaced.
pub(super) fn text(words: &str) -> String {
    let allowed = |c: char| match c {
        '\t' | '\n' | '\r' => c,
        '\u{fffe}' | '\u{ffff}' => '\u{fffd}',
        c if c.is_control() => '\u{fffd}',
        c => c,
    };
    quick_xml::escape::escape(words.chars().map(allowed).collect::<String>()).into_owned()
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

/// Four significant digits, and all before the point.
pub(super) fn short(value: f64) -> String {
    if value.abs() < 1e-12 {
        return "0".to_owned();
    }
    if !value.is_finite() {
        return "not known".to_owned();
    }
    let places = (3 - value.abs().log10().floor() as i32).clamp(0, 12) as usize;
    minus(format!("{value:.places$}"))
}

/// As [`short`]; a dash where there is none.
pub(super) fn short_or_dash(value: Option<f64>, unit: &str) -> String {
    value.map_or_else(|| "–".to_owned(), |value| format!("{} {unit}", short(value)))
}

/// A value to the digit that its uncertainty leaves, with that.
pub(super) fn with_u(value: f64, u: Option<f64>) -> String {
    match u.filter(|u| u.is_finite() && *u > 0.0) {
        Some(u) => {
            // Two digits of the uncertainty (GUM 7.2.6).
            let places = (1 - u.log10().floor() as i32).clamp(0, 15) as usize;
            minus(format!("{value:.places$} ± {u:.places$}"))
        }
        None => minus(format!("{value:.9}")),
    }
}

/// A share in percent; 100 % only where nothing is missing.
pub(super) fn percent(share: f64) -> String {
    let rounded = (1e4 * share).round() / 1e2;
    if rounded >= 100.0 && share < 1.0 { "99.99 %".to_owned() } else { format!("{rounded:.2} %") }
}

/// A count in groups of three.
pub(super) fn count(count: u64) -> String {
    let digits = count.to_string();
    let mut grouped = String::new();
    for (index, digit) in digits.chars().enumerate() {
        if index > 0 && (digits.len() - index).is_multiple_of(3) {
            grouped.push('\u{202f}');
        }
        grouped.push(digit);
    }
    grouped
}

/// A place of the measured frame in mm.
pub(super) fn place([x, y, z]: &[f64; 3]) -> String {
    // Adding zero makes negative zero positive.
    let [x, y, z] = [x, y, z].map(|mm| (1e3 * mm).round() / 1e3 + 0.0);
    minus(format!("({x:.3}, {y:.3}, {z:.3}) mm"))
}

/// With its sign, but for zero.
pub(super) fn signed(value: f64) -> String {
    if value == 0.0 { "0".to_owned() } else { minus(format!("{value:+}")) }
}

/// An instant as people read it, to the second; as it stands where it is in no form that is known.
pub(super) fn instant(rfc3339: &str) -> String {
    match rfc3339.parse::<Timestamp>() {
        Ok(instant) => instant.strftime("%Y-%m-%d %H:%M:%S UTC").to_string(),
        Err(_) => rfc3339.to_owned(),
    }
}

/// With the sign of typographers.
pub(super) fn minus(number: String) -> String {
    number.replace('-', "\u{2212}")
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
    fn numbers_have_the_digits_that_count() {
        assert_eq!(short(1234.56), "1235");
        assert_eq!(short(-0.012_344), "\u{2212}0.01234");
        assert_eq!(short(0.0), "0");
        assert_eq!(
            (signed(-0.0), signed(2.0), signed(-2.5)),
            ("0".into(), "+2".into(), "\u{2212}2.5".into())
        );
        assert_eq!(instant("2026-11-21T11:02:24.850250114Z"), "2026-11-21 11:02:24 UTC");
        assert_eq!(instant("last Tuesday"), "last Tuesday");
        assert_eq!(with_u(1.234_567_8, Some(0.000_12)), "1.23457 ± 0.00012");
        assert_eq!(with_u(-2.5, None), "\u{2212}2.500000000");
        assert_eq!(count(1_234_567), "1\u{202f}234\u{202f}567");
        assert_eq!((percent(1.0), percent(0.999_999)), ("100.00 %".into(), "99.99 %".into()));
    }
}
