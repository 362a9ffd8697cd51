//! What a column of many lines holds.

use std::collections::BTreeMap;

use asphera_link::{Flags, Unit, shown};

use crate::field::{Field, Flagged, Place, Role};
use crate::number::Form;

/// A field for one column or group; `None` for text that says nothing. Remarks for a person.
pub(super) fn field(
    place: Place,
    number: usize,
    texts: &[&str],
    unit: Option<(Unit, f64)>,
) -> (Option<Field>, Vec<String>) {
    let mut counts: BTreeMap<&str, usize> = BTreeMap::new();
    texts.iter().for_each(|text| *counts.entry(text).or_default() += 1);
    let Some((form, words)) = numbers(&counts) else {
        return state(place, number, &counts, texts.len());
    };
    let mut remarks = Vec::new();
    let values: Vec<f64> = texts.iter().filter_map(|text| form.read(text.as_bytes())).collect();
    let counter = counter(&values);
    let name = if counter.is_some() { format!("count{number}") } else { format!("value{number}") };
    let (known, scale) = unit.unwrap_or((Unit::One, 1.0));
    let mut field = Field { form, scale, ..Field::channel(&name, place, known) };
    if !words.is_empty() {
        let words_shown: Vec<String> = words.iter().map(|word| shown(word.as_bytes())).collect();
        let told = words_shown.join("`, `");
        remarks
            .push(format!("{name}: `{told}` comes instead of a number, and is read as no_signal"));
        let texts = words.iter().map(|word| (*word).to_owned()).collect();
        field.flagged = vec![Flagged { flag: Flags::NO_SIGNAL, texts, means: String::new() }];
    }
    match counter {
        Some(Some((first, modulus))) => field.role = Role::Count { first, modulus },
        Some(None) => {
            field.unit = Unit::Count;
            remarks.push(format!(
                "{name} goes up by one a line: if it counts triggers, give it role = \"count\" and its modulus"
            ));
        }
        None if unit.is_none() => {
            remarks.push(format!("{name}: the device sends no unit. Set `unit`, and `scale` if it counts in another one"));
        }
        None => {}
    }
    (Some(field), remarks)
}

/// How the numbers are written, and the words among them. `None`: they are no numbers.
fn numbers<'a>(counts: &BTreeMap<&'a str, usize>) -> Option<(Form, Vec<&'a str>)> {
    /// Different words that may stand in place of numbers.
    const MOST_WORDS: usize = 4;
    let all: usize = counts.values().sum();
    for form in [Form::Decimal, Form::DecimalComma] {
        let no_number = |text: &&&str| form.read(text.as_bytes()).is_none();
        let words: Vec<&str> = counts.keys().filter(no_number).copied().collect();
        let worded: usize = words.iter().filter_map(|word| counts.get(word)).sum();
        let is_named = words.iter().all(|word| !word.is_empty());
        if 2 * worded < all && words.len() <= MOST_WORDS && is_named {
            return Some((form, words));
        }
    }
    None
}

/// Whether values go up by one, and if they began anew: the first number and how many there are.
fn counter(values: &[f64]) -> Option<Option<(u32, u32)>> {
    const LEAST: usize = 5;
    let is_whole =
        |value: &f64| value.fract() == 0.0 && (0.0..=f64::from(u32::MAX)).contains(value);
    if values.len() < LEAST || !values.iter().all(is_whole) {
        return None;
    }
    let mut wraps = Vec::new();
    for pair in values.windows(2) {
        match pair[1] - pair[0] {
            1.0 => {}
            step if step < 0.0 => wraps.push((pair[1], pair[0])),
            _ => return None,
        }
    }
    let (first, last) = match wraps.first() {
        None => return Some(None),
        Some(wrap) if wraps.iter().all(|other| other == wrap) => *wrap,
        Some(_) => return None,
    };
    Some(Some((first as u32, (last - first) as u32 + 1)))
}

fn state(
    place: Place,
    number: usize,
    counts: &BTreeMap<&str, usize>,
    all: usize,
) -> (Option<Field>, Vec<String>) {
    /// Different states a device may have sent.
    const MOST_STATES: usize = 6;
    let name = format!("state{number}");
    let is_measured = |text: &&str| text.bytes().any(|byte| byte.is_ascii_digit());
    if counts.len() > 2 && counts.keys().all(is_measured) {
        let last = counts.keys().next_back().map_or(String::new(), |last| shown(last.as_bytes()));
        let remark = format!(
            "column {number} holds a number within text, `{last}`: left out; a pattern can read it"
        );
        return (None, vec![remark]);
    }
    let most = counts.iter().max_by_key(|(_, count)| **count);
    let Some((good, count)) = most.filter(|_| counts.len() <= MOST_STATES) else {
        let remark = format!("column {number} holds text that differs from line to line: left out");
        return (None, vec![remark]);
    };
    let others: Vec<String> = counts
        .keys()
        .filter(|text| text != &good)
        .map(|text| format!("`{}`", shown(text.as_bytes())))
        .collect();
    let remarks = if others.is_empty() {
        Vec::new()
    } else {
        let others = others.join(", ");
        vec![format!(
            "{name} is `{}` in {count} of {all} lines, also {others}. Name those that mean weak, out_of_range or no_signal",
            shown(good.as_bytes())
        )]
    };
    let role = Role::Status { good: vec![(*good).to_owned()] };
    (Some(Field { role, ..Field::channel(&name, place, Unit::One) }), remarks)
}

/// Unit of a word that devices send, and what one of it is worth in ours.
pub(super) fn unit(word: &str) -> Option<(Unit, f64)> {
    Some(match word.to_ascii_lowercase().as_str() {
        "mm" => (Unit::Millimetre, 1.0),
        "um" | "µm" => (Unit::Millimetre, 1e-3),
        "nm" => (Unit::Millimetre, 1e-6),
        "cm" => (Unit::Millimetre, 10.0),
        "m" => (Unit::Millimetre, 1000.0),
        "in" | "inch" => (Unit::Millimetre, 25.4),
        "rad" => (Unit::Radian, 1.0),
        "deg" => (Unit::Radian, std::f64::consts::PI / 180.0),
        "degc" | "c" => (Unit::DegreeCelsius, 1.0),
        "s" => (Unit::Second, 1.0),
        "ms" => (Unit::Second, 1e-3),
        "us" => (Unit::Second, 1e-6),
        "hz" => (Unit::Hertz, 1.0),
        _ => return None,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn counters_are_found_with_their_modulus() {
        assert_eq!(counter(&[1.0, 2.0, 3.0, 4.0, 5.0]), Some(None));
        assert_eq!(counter(&[98.0, 99.0, 0.0, 1.0, 2.0]), Some(Some((0, 100))));
        assert_eq!(counter(&[3.0, 4.0, 1.0, 2.0, 3.0, 4.0, 1.0]), Some(Some((1, 4))));
        assert_eq!(counter(&[1.0, 2.0, 4.0, 5.0, 6.0]), None, "a gap");
        assert_eq!(counter(&[1.0, 2.0, 3.0]), None, "too few");
        assert_eq!(counter(&[1.5, 2.5, 3.5, 4.5, 5.5]), None);
        assert_eq!(counter(&[3.0, 1.0, 2.0, 1.0, 2.0]), None, "two ways to begin anew");
    }
}
