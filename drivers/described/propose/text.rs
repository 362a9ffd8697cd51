//! Devices that send lines.

use asphera_link::{Capture, Proposal, Unit, shown};

use super::{column, poll, write};
use crate::checksum::{Algorithm, Checksum, Digits};
use crate::field::{Field, Place, Role};
use crate::framing::{End, Framing, Splitter};
use crate::pattern::Pattern;
use crate::settings::{Layout, Settings};

/// Lines that are needed before anything is proposed.
const LEAST_LINES: usize = 3;

/// Percent of the lines that must be alike.
const ALIKE: usize = 80;

pub(super) fn propose(capture: &Capture, bytes: &[u8]) -> Proposal {
    let framing = framing(bytes);
    let mut splitter = Splitter::new(framing.clone(), None, false);
    // Answers begin with the question, so the first is whole.
    splitter.clear(capture.asked.is_some());
    splitter.push(bytes);
    let lines: Vec<Vec<u8>> = std::iter::from_fn(|| splitter.next()).collect();
    if lines.len() < LEAST_LINES {
        let (bytes, lines) = (bytes.len(), lines.len());
        let remark = format!(
            "{bytes} bytes of text came, whole lines in them: {lines}. Listen longer, or ask more often"
        );
        return Proposal { settings: None, remarks: vec![remark] };
    }
    let checksum = checksum(&lines);
    let begin = framing.begin().len();
    let body = |line: &Vec<u8>| {
        let body = checksum.map_or(Some(&line[..]), |check| check.body(line))?;
        Some(String::from_utf8_lossy(body.get(begin..)?).into_owned())
    };
    let bodies: Vec<String> = lines.iter().filter_map(body).collect();
    let texts: Vec<&str> = bodies.iter().map(String::as_str).collect();
    let mut remarks = vec![format!(
        "{} lines of text, the last `{}`",
        lines.len(),
        bodies.last().map_or(String::new(), |body| shown(body.as_bytes()))
    )];
    let found = by_columns(&texts).or_else(|| by_pattern(&texts));
    let Some((layout, fields, more)) = found else {
        remarks.push("they have no number at the same place".to_owned());
        return Proposal { settings: None, remarks };
    };
    remarks.extend(more);
    let settings =
        Settings { framing, checksum, layout, fields, poll: poll(capture), ..Settings::default() };
    Proposal { settings: Some(write::toml(&settings)), remarks }
}

/// CR and LF as they come, else ETX; a beginning that every line has.
fn framing(bytes: &[u8]) -> Framing {
    let has_lines = bytes.iter().any(|byte| matches!(byte, b'\r' | b'\n'));
    let has_etx = bytes.contains(&3);
    let end = if !has_lines && has_etx { End::Bytes(vec![3]) } else { End::Any };
    let begin = if bytes.contains(&2) { vec![2] } else { Vec::new() };
    Framing::Lines { begin, end, longest: 256 }
}

/// The first check that every line has.
fn checksum(lines: &[Vec<u8>]) -> Option<Checksum> {
    let mut different = lines.to_vec();
    different.sort();
    different.dedup();
    if different.len() < LEAST_LINES {
        return None;
    }
    let skips = [(0, 0), (1, 1), (1, 0), (0, 1)];
    let all = Algorithm::ALL.iter().flat_map(|(_, algorithm)| {
        skips.map(|(skip_first, skip_last)| Checksum {
            algorithm: *algorithm,
            digits: Digits::Hex,
            skip_first,
            skip_last,
        })
    });
    let mut all = all;
    all.find(|check| different.iter().all(|line| check.body(line).is_some()))
}

type Found = (Layout, Vec<Field>, Vec<String>);

fn by_columns(lines: &[&str]) -> Option<Found> {
    let separators = [Some(';'), Some('\t'), Some(','), Some('|'), None];
    let cut = |line: &str, separator: Option<char>| -> Vec<String> {
        match separator {
            Some(sign) => line.split(sign).map(|text| text.trim().to_owned()).collect(),
            None => line.split_ascii_whitespace().map(str::to_owned).collect(),
        }
    };
    for separator in separators {
        let rows: Vec<Vec<String>> = lines.iter().map(|line| cut(line, separator)).collect();
        let columns = rows.last()?.len();
        let alike: Vec<&Vec<String>> = rows.iter().filter(|row| row.len() == columns).collect();
        let is_split = columns > 1 || separator.is_none();
        if !is_split || columns == 0 || alike.len() * 100 < rows.len() * ALIKE {
            continue;
        }
        let column = |index: usize| alike.iter().map(|row| row[index].as_str()).collect::<Vec<_>>();
        let table: Vec<Vec<&str>> = (0..columns).map(column).collect();
        let (fields, mut remarks) = fields(&table, |index| Place::Column(index + 1));
        if !have_channel(&fields) {
            continue;
        }
        if separator == Some(',') && columns == 2 && !lines.iter().any(|line| line.contains('.')) {
            remarks.push("if the comma is a decimal comma, set separator = \"blank\", columns = 1, form = \"decimal-comma\"".to_owned());
        }
        let separator = separator.and_then(|sign| u8::try_from(sign).ok());
        return Some((Layout::Columns { separator, columns: Some(columns) }, fields, remarks));
    }
    None
}

/// Fields of all columns. A column of one unit is the unit of the column before it.
fn fields(table: &[Vec<&str>], place: impl Fn(usize) -> Place) -> (Vec<Field>, Vec<String>) {
    let unit = |index: usize| -> Option<(Unit, f64)> {
        let texts = table.get(index)?;
        let first = texts.first()?;
        texts.iter().all(|text| text == first).then(|| column::unit(first)).flatten()
    };
    let (mut fields, mut remarks) = (Vec::new(), Vec::new());
    for (index, texts) in table.iter().enumerate() {
        let (field, more) = column::field(place(index), index + 1, texts, unit(index + 1));
        fields.extend(field);
        remarks.extend(more);
    }
    (fields, remarks)
}

/// A line as text between numbers.
#[derive(PartialEq)]
struct Skeleton<'a> {
    between: Vec<&'a str>,
}

/// Text and numbers of a line by turns, text first and last.
fn taken_apart(line: &str) -> (Skeleton<'_>, Vec<&str>) {
    let bytes = line.as_bytes();
    let (mut between, mut numbers) = (Vec::new(), Vec::new());
    let (mut from, mut at) = (0, 0);
    while at < bytes.len() {
        let sign = usize::from(matches!(bytes[at], b'+' | b'-'));
        if !bytes.get(at + sign).is_some_and(u8::is_ascii_digit) {
            at += 1;
            continue;
        }
        let is_digit = |byte: &u8| byte.is_ascii_digit() || *byte == b'.';
        let digits = bytes[at + sign..].iter().take_while(|byte| is_digit(byte)).count();
        let to = at + sign + digits;
        between.push(&line[from..at]);
        numbers.push(&line[at..to]);
        (from, at) = (to, to);
    }
    between.push(&line[from..]);
    (Skeleton { between }, numbers)
}

fn by_pattern(lines: &[&str]) -> Option<Found> {
    let parts: Vec<_> = lines.iter().map(|line| taken_apart(line)).collect();
    let (skeleton, numbers) = parts.last()?;
    let alike: Vec<_> = parts.iter().filter(|(other, _)| other == skeleton).collect();
    if numbers.is_empty() || alike.len() * 100 < parts.len() * ALIKE {
        return None;
    }
    let (mut pattern, mut fields, mut remarks) = (String::new(), Vec::new(), Vec::new());
    for (index, text) in skeleton.between.iter().enumerate() {
        pattern += &regex::escape(text);
        let texts: Vec<&str> = alike.iter().filter_map(|(_, n)| n.get(index).copied()).collect();
        if texts.is_empty() {
            continue;
        }
        let is_constant = texts.iter().all(|text| *text == texts[0]);
        if is_constant && numbers.len() > 1 {
            // A number that never changes is more likely an address or part of a name.
            pattern += &regex::escape(texts[0]);
            continue;
        }
        let group = format!("n{}", index + 1);
        pattern += &format!("(?<{group}>{})", shape(&texts));
        let after = skeleton.between.get(index + 1).map_or("", |text| text.trim());
        let (field, more) =
            column::field(Place::Group(group), index + 1, &texts, column::unit(after));
        fields.extend(field);
        remarks.extend(more);
    }
    let pattern = Pattern::new(&pattern).ok()?;
    have_channel(&fields).then_some((Layout::Pattern(pattern), fields, remarks))
}

/// Whether one of the fields is a reading: without one settings cannot be used.
fn have_channel(fields: &[Field]) -> bool {
    fields.iter().any(|field| field.role == Role::Channel)
}

/// Pattern of numbers: of their very width where all have one, so that a lost digit is noticed.
fn shape(texts: &[&str]) -> String {
    let mould = |text: &str| -> String {
        let kind = |sign: char| match sign {
            '+' | '-' => '+',
            '.' => '.',
            _ => '0',
        };
        text.chars().map(kind).collect()
    };
    let first = mould(texts[0]);
    if texts.iter().any(|text| mould(text) != first) {
        return r"[+-]?\d+(?:\.\d+)?".to_owned();
    }
    let digits =
        |count: usize| if count == 1 { r"\d".to_owned() } else { format!(r"\d{{{count}}}") };
    let unsigned = first.trim_start_matches('+');
    let sign = if unsigned.len() < first.len() { "[+-]" } else { "" };
    let parts: Vec<String> = unsigned
        .split('.')
        .map(|part| if part.is_empty() { String::new() } else { digits(part.len()) })
        .collect();
    format!("{sign}{}", parts.join(r"\."))
}
