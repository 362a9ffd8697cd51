//! Numbers as people read them: digits that count, typographic signs, a dash for what is not known.
//!
//! Files keep all digits; these are for the terminal, the page and the paper. A front that wants other signs
//! replaces [`MINUS`] and [`NARROW`].

/// Sign of what is not known. Never a zero.
pub const DASH: &str = "–";
/// Minus sign of typographers, U+2212.
pub const MINUS: char = '\u{2212}';
/// Narrow space between groups of three digits, U+202F.
pub const NARROW: char = '\u{202f}';

/// Four significant digits, and all before the point up to twelve; with a power of ten beyond.
pub fn short(value: f64) -> String {
    if value.abs() < 1e-12 {
        return "0".to_owned();
    }
    if !value.is_finite() {
        return "not known".to_owned();
    }
    if value.abs() >= 1e12 {
        return minus(format!("{value:.3e}"));
    }
    let places = (3 - value.abs().log10().floor() as i32).clamp(0, 12) as usize;
    minus(format!("{value:.places$}"))
}

/// [`short`] with a unit; [`DASH`] where there is no value. A pure number has the unit "" or "1".
pub fn quantity(value: Option<f64>, unit: &str) -> String {
    match value {
        Some(value) => format!("{}{}", short(value), self::unit(unit)),
        None => DASH.to_owned(),
    }
}

/// A value and its standard uncertainty, both to two digits of the uncertainty (GUM 7.2.6); without one,
/// nine decimals.
pub fn with_u(value: f64, u: Option<f64>) -> String {
    match u.filter(|u| u.is_finite() && *u > 0.0) {
        Some(u) => {
            let places = (1 - u.log10().floor() as i32).clamp(0, 15) as usize;
            minus(format!("{value:.places$} ± {u:.places$}"))
        }
        None => minus(format!("{value:.9}")),
    }
}

/// A share in percent; 100 % only where nothing is missing, 0 % only where there is nothing.
pub fn percent(share: f64) -> String {
    let rounded = (1e4 * share).round() / 1e2;
    if rounded >= 100.0 && share < 1.0 {
        "99.99 %".to_owned()
    } else if rounded <= 0.0 && share > 0.0 {
        "< 0.01 %".to_owned()
    } else {
        format!("{rounded:.2} %")
    }
}

/// A count, its digits in groups of three from five digits on (ISO 80000-1, 7.3.1).
pub fn count(count: u64) -> String {
    let digits = count.to_string();
    if digits.len() < 5 {
        return digits;
    }
    let mut grouped = String::new();
    for (index, digit) in digits.chars().enumerate() {
        if index > 0 && (digits.len() - index).is_multiple_of(3) {
            grouped.push(NARROW);
        }
        grouped.push(digit);
    }
    grouped
}

/// A count with its noun: `1 link`, `3 links`.
pub fn counted(number: u64, noun: &str) -> String {
    let ending = if number == 1 { "" } else { "s" };
    format!("{} {noun}{ending}", count(number))
}

/// A unit behind its number; nothing of a pure number, whose unit is written 1.
pub fn unit(unit: &str) -> String {
    if unit.is_empty() || unit == "1" { String::new() } else { format!(" {unit}") }
}

/// A direction, as a unit vector.
pub fn direction([x, y, z]: &[f64; 3]) -> String {
    let [x, y, z] = [x, y, z].map(|side| (1e3 * side).round() / 1e3 + 0.0);
    minus(format!("({x:.3}, {y:.3}, {z:.3})"))
}

/// A place of the measured frame, in mm.
pub fn place([x, y, z]: &[f64; 3]) -> String {
    // Adding zero makes negative zero positive.
    let [x, y, z] = [x, y, z].map(|mm| (1e3 * mm).round() / 1e3 + 0.0);
    minus(format!("({x:.3}, {y:.3}, {z:.3}) mm"))
}

/// A number with its sign; zero has none.
pub fn signed(value: f64) -> String {
    if value == 0.0 { "0".to_owned() } else { minus(format!("{value:+}")) }
}

/// A number whose hyphen becomes [`MINUS`].
pub fn minus(number: String) -> String {
    number.replace('-', "\u{2212}")
}

/// Powers of units with raised digits: `mm^-3` becomes `mm⁻³`.
pub fn raised(words: &str) -> String {
    let mut parts = words.split('^');
    let mut text = parts.next().unwrap_or_default().to_owned();
    for part in parts {
        let sign = usize::from(part.starts_with('-'));
        let digits = part[sign..].chars().take_while(char::is_ascii_digit).count();
        if digits == 0 {
            text.push('^');
            text.push_str(part);
            continue;
        }
        let (power, rest) = part.split_at(sign + digits);
        text.extend(power.chars().map(|sign| match sign {
            '-' => '⁻',
            '1' => '¹',
            '2' => '²',
            '3' => '³',
            digit => char::from_u32(0x2070 + u32::from(digit) - u32::from('0')).unwrap_or(digit),
        }));
        text.push_str(rest);
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_have_the_digits_that_count() {
        assert_eq!(short(1234.56), "1235");
        assert_eq!(short(-0.012_344), "\u{2212}0.01234");
        assert_eq!((short(0.0), short(f64::NAN)), ("0".into(), "not known".into()));
        assert_eq!(
            (short(999_999_999_999.4), short(-1e250)),
            ("999999999999".into(), "\u{2212}1.000e250".into())
        );
        assert_eq!(quantity(Some(2.5), "nm"), "2.500 nm");
        assert_eq!((quantity(Some(2.5), "1"), quantity(None, "nm")), ("2.500".into(), DASH.into()));
        assert_eq!(
            (signed(-0.0), signed(2.0), signed(-2.5)),
            ("0".into(), "+2".into(), "\u{2212}2.5".into())
        );
        assert_eq!(with_u(1.234_567_8, Some(0.000_12)), "1.23457 ± 0.00012");
        assert_eq!(with_u(-2.5, None), "\u{2212}2.500000000");
        assert_eq!(
            (count(1234), count(1_234_567)),
            ("1234".into(), "1\u{202f}234\u{202f}567".into())
        );
        assert_eq!([0, 1, 2].map(|n| counted(n, "point")), ["0 points", "1 point", "2 points"]);
        assert_eq!((percent(1.0), percent(0.999_999)), ("100.00 %".into(), "99.99 %".into()));
        assert_eq!((percent(0.0), percent(1e-9)), ("0.00 %".into(), "< 0.01 %".into()));
        assert_eq!(raised("A4 -2 mm^-3, A10 mm^10 ^ ^x"), "A4 -2 mm⁻³, A10 mm¹⁰ ^ ^x");
        assert_eq!(place(&[-0.000_01, 1.0, -2.5]), "(0.000, 1.000, \u{2212}2.500) mm");
    }
}
