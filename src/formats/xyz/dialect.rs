//! How the lines of one file separate columns and decimals.

use crate::error::quoted;
use crate::scan::{finite, says_missing};

/// Separator and decimal mark, the same in all lines of points of a file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Dialect {
    pub(super) separator: Separator,
    /// `None` until a number shows one.
    decimal: Option<Decimal>,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Separator {
    Semicolon,
    Comma,
    /// One tab; two have an empty column between them.
    Tab,
    /// Any white space.
    Space,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Decimal {
    Point,
    Comma,
}

/// A field as a number.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Field {
    Number(f64),
    Missing,
    /// No number, or one whose decimal mark is not that of the file.
    Unreadable,
}

impl Dialect {
    /// The dialect of a line of points. `Err` holds the line as an error shows it where its commas may separate
    /// columns or decimals.
    pub(super) fn of(content: &[u8]) -> Result<Dialect, String> {
        let has = |mark: u8| content.contains(&mark);
        let separator = if has(b';') {
            Separator::Semicolon
        } else if has(b',') {
            match commas(content) {
                Commas::Separate => Separator::Comma,
                Commas::Decimal if has(b'\t') => Separator::Tab,
                Commas::Decimal => Separator::Space,
                Commas::Doubtful => return Err(quoted(content)),
            }
        } else if has(b'\t') && split(content, Separator::Tab).all(|field| !field.is_empty()) {
            Separator::Tab
        } else {
            Separator::Space
        };
        Ok(Dialect { separator, decimal: None })
    }

    /// Whether decimals have a comma, as far as numbers showed.
    pub(super) fn has_decimal_commas(&self) -> bool {
        self.decimal == Some(Decimal::Comma)
    }

    /// A field as a number. The first number with a decimal mark decides which mark the file has.
    pub(super) fn number(&mut self, field: &[u8]) -> Field {
        if field.is_empty() || says_missing(field) {
            return Field::Missing;
        }
        let mark = match (field.contains(&b'.'), field.contains(&b',')) {
            (false, false) => None,
            (true, false) => Some(Decimal::Point),
            (false, true) => Some(Decimal::Comma),
            (true, true) => return Field::Unreadable,
        };
        if let Some(mark) = mark
            && *self.decimal.get_or_insert(mark) != mark
        {
            return Field::Unreadable;
        }
        let value = match mark {
            Some(Decimal::Comma) => finite(&with_point(field)),
            _ => finite(field),
        };
        value.map_or(Field::Unreadable, Field::Number)
    }
}

/// The fields of a line, without quotes and white space about them.
pub(super) fn fields<'a>(content: &'a [u8], separator: Separator, into: &mut Vec<&'a [u8]>) {
    into.clear();
    into.extend(split(content, separator));
}

fn split(content: &[u8], separator: Separator) -> impl Iterator<Item = &[u8]> {
    let mark = match separator {
        Separator::Semicolon => Some(b';'),
        Separator::Comma => Some(b','),
        Separator::Tab => Some(b'\t'),
        Separator::Space => None,
    };
    let is_end = move |byte: &u8| mark.map_or(byte.is_ascii_whitespace(), |mark| *byte == mark);
    let fields = content.split(is_end).map(|field| unquoted(field.trim_ascii()));
    fields.filter(move |field| mark.is_some() || !field.is_empty())
}

fn unquoted(field: &[u8]) -> &[u8] {
    match field {
        [b'"', inner @ .., b'"'] => inner.trim_ascii(),
        _ => field,
    }
}

fn with_point(field: &[u8]) -> Vec<u8> {
    field.iter().map(|&byte| if byte == b',' { b'.' } else { byte }).collect()
}

/// A line without the comma at its end: it has no column behind it.
fn without_empty_end(content: &[u8]) -> &[u8] {
    let line = content.trim_ascii_end();
    line.strip_suffix(b",").unwrap_or(line)
}

enum Commas {
    Separate,
    Decimal,
    Doubtful,
}

/// What the commas of a line are that has no semicolon.
fn commas(content: &[u8]) -> Commas {
    let beside = |index: usize| {
        let before = index.checked_sub(1).and_then(|before| content.get(before));
        [before, content.get(index + 1)]
    };
    let is_space = |byte: Option<&u8>| byte.is_none_or(u8::is_ascii_whitespace);
    let content = without_empty_end(content);
    let places = || content.iter().enumerate().filter(|(_, byte)| **byte == b',').map(|(at, _)| at);
    let is_spaced = |at: usize| beside(at).into_iter().any(is_space);
    let is_in_number =
        |at: usize| beside(at).into_iter().all(|byte| byte.is_some_and(u8::is_ascii_digit));
    // White space that does not stand beside a comma separates columns by itself.
    let columns = content.split(|&byte| byte == b',');
    let has_spaces =
        columns.map(<[u8]>::trim_ascii).any(|column| column.iter().any(u8::is_ascii_whitespace));
    if has_spaces {
        let words = || content.split(u8::is_ascii_whitespace).filter(|word| !word.is_empty());
        let one_each = words().all(|word| word.iter().filter(|byte| **byte == b',').count() <= 1);
        let is_decimal = one_each && places().all(is_in_number) && !content.contains(&b'.');
        return if is_decimal { Commas::Decimal } else { Commas::Doubtful };
    }
    // `1,5, 2,5, 3,5` would give six whole columns, unless points show what the decimals are.
    let uneven = places().any(is_spaced) && places().any(|at| !is_spaced(at));
    let has_points = || content.split(|&byte| byte == b',').all(|column| column.contains(&b'.'));
    if uneven && !has_points() { Commas::Doubtful } else { Commas::Separate }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn numbers(line: &str) -> Vec<Field> {
        let mut dialect = Dialect::of(line.as_bytes()).unwrap();
        let mut columns = Vec::new();
        fields(line.as_bytes(), dialect.separator, &mut columns);
        columns.iter().map(|field| dialect.number(field)).collect()
    }

    #[test]
    fn decimal_commas_are_read_where_something_else_separates_columns() {
        let values = [1.5, -2.25, 3e-4].map(Field::Number);
        for line in
            ["1,5 -2,25 3,0e-4", "1,5;-2,25;3,0E-4", "1,5\t-2,25\t3,0e-4", "1,5 ; -2,25 ; 0,0003"]
        {
            assert_eq!(numbers(line), values, "{line}");
        }
        assert_eq!(numbers("1\t\t3").len(), 2, "two tabs in the first line are white space");
        assert_eq!(numbers("1;;3")[1], Field::Missing);
        for line in ["1,5, 2,5, 3,5", "1,5, 2.0, 3.0", "1.5,2 3.5", "1,5,2 3"] {
            assert!(Dialect::of(line.as_bytes()).is_err(), "{line}");
        }
    }

    #[test]
    fn one_file_has_one_decimal_mark() {
        assert_eq!(numbers("1.5;2,5;3")[1], Field::Unreadable);
        assert_eq!(numbers("1,234.5;2;3")[0], Field::Unreadable);
        assert_eq!(numbers("\"1.5\",\"2\",\"3\""), [1.5, 2.0, 3.0].map(Field::Number));
    }
}
