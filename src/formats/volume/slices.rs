//! Order of slices by the numbers in their names.

use crate::{Format, Place, ReadError};

/// Names in the order of their numbers: `cut_2.tif` before `cut_10.tif`.
///
/// The names differ in one number only, and its steps are all alike: a slice that lacks would bend the part.
///
/// # Errors
///
/// Names that differ otherwise, a number twice, a slice that lacks.
pub(super) fn ordered(format: Format, names: &[String]) -> Result<Vec<String>, ReadError> {
    let mut split: Vec<(Vec<&str>, &String)> =
        names.iter().map(|name| (parts(name), name)).collect();
    split.sort();
    let malformed = |name: &str, expected: String, found: String| ReadError::Malformed {
        format,
        place: Place::Slice(name.into()),
        expected,
        found,
    };
    let [(first, name), others @ ..] = &split[..] else {
        return Err(malformed("", "slices, .tif or .tiff".into(), "none".into()));
    };
    let mut varying = None;
    for (parts, other) in others {
        let differing: Vec<usize> = (0..parts.len().max(first.len()))
            .filter(|&at| {
                parts.get(at).map(|part| value(part)) != first.get(at).map(|part| value(part))
            })
            .collect();
        let is_number = |at: usize| parts.get(at).is_some_and(|part| is_digits(part));
        match differing[..] {
            [at] if is_number(at) && varying.is_none_or(|before| before == at) => {
                varying = Some(at);
            }
            _ => {
                return Err(malformed(
                    other,
                    format!("a name that differs from {name} in one and the same number"),
                    "another".into(),
                ));
            }
        }
    }
    let Some(at) = varying else { return Ok(vec![(*name).clone()]) };
    let mut numbered = Vec::new();
    for (parts, name) in &split {
        let number: u64 = parts[at].parse().map_err(|_| {
            malformed(name, "a number of a slice below 2⁶⁴".into(), parts[at].into())
        })?;
        numbered.push((number, (*name).clone()));
    }
    numbered.sort();
    let step = numbered[1].0 - numbered[0].0;
    for pair in numbered.windows(2) {
        let expected = pair[0].0.saturating_add(step);
        if pair[1].0 != expected || step == 0 {
            return Err(malformed(
                &pair[1].1,
                format!("the slice with number {expected} after {}", pair[0].1),
                format!("number {}", pair[1].0),
            ));
        }
    }
    Ok(numbered.into_iter().map(|(_, name)| name).collect())
}

/// A name cut where digits begin and end.
fn parts(name: &str) -> Vec<&str> {
    let mut parts = Vec::new();
    let mut start = 0;
    let letters: Vec<(usize, bool)> =
        name.char_indices().map(|(at, letter)| (at, letter.is_ascii_digit())).collect();
    for pair in letters.windows(2) {
        if pair[0].1 != pair[1].1 {
            parts.push(&name[start..pair[1].0]);
            start = pair[1].0;
        }
    }
    parts.push(&name[start..]);
    parts
}

fn is_digits(part: &str) -> bool {
    part.starts_with(|letter: char| letter.is_ascii_digit())
}

/// A number without leading zeros, or a text.
fn value(part: &str) -> &str {
    if is_digits(part) { part.trim_start_matches('0') } else { part }
}
