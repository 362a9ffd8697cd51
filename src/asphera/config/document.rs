//! A TOML file read key by key, with the place of everything.
//!
//! Serde stops at the first mistake. A person who sets up a bench wants all of them at once, each with
//! file, line and key, and a key that nobody reads is a typing error. So the tables are read by hand:
//! what is asked for is noted, and what was never asked for is reported.

use std::cell::RefCell;
use std::collections::BTreeSet;
use std::fmt::Display;
use std::ops::RangeInclusive;
use std::str::FromStr;

use toml_edit::{Document, Item, TableLike, Value};

use super::problem::{Problem, Problems};

/// A TOML file.
pub(crate) struct File {
    name: String,
    document: Document<String>,
    /// Where its lines end, ascending: thousands of keys are asked for their lines.
    line_ends: Vec<usize>,
    problems: RefCell<Vec<Problem>>,
}

/// Whether a text is a Zemax prescription: it begins with its version, or has lines of surfaces.
fn is_zemax(text: &str) -> bool {
    text.starts_with("VERS ") || text.lines().any(|line| line.starts_with("SURF "))
}

impl File {
    /// Parses `text`; `name` stands in every problem.
    pub(crate) fn parse(name: &str, text: &str) -> Result<File, Problems> {
        match Document::from_str(text) {
            Ok(document) => {
                let line_ends = line_ends(text);
                let name = name.to_owned();
                Ok(File { name, document, line_ends, problems: RefCell::default() })
            }
            Err(error) => {
                let span = error.span().unwrap_or(0..0);
                Err(Problems(vec![Problem {
                    file: name.to_owned(),
                    line: line_of(&line_ends(text), span.start),
                    key: String::new(),
                    expected: if is_zemax(text) {
                        "TOML, not a Zemax file: `asphera nominal FILE.zmx --surface N` makes one of it"
                            .to_owned()
                    } else {
                        format!("TOML ({})", error.message())
                    },
                    found: text
                        .get(span)
                        .filter(|found| !found.trim().is_empty())
                        .map_or_else(|| "something else".to_owned(), |found| format!("{found:?}")),
                }]))
            }
        }
    }

    /// The whole file as a table.
    pub(crate) fn root(&self) -> Section<'_> {
        Section {
            file: self,
            path: String::new(),
            line: 1,
            table: Some(self.document.as_table()),
            read: RefCell::default(),
        }
    }

    /// What was found wrong so far, in the order of the file; `value` if there is nothing.
    pub(crate) fn conclude<T>(self, value: Option<T>) -> Result<T, Problems> {
        let mut problems = self.problems.into_inner();
        problems.sort_by_key(|problem| problem.line);
        problems.dedup();
        match value {
            Some(value) if problems.is_empty() => Ok(value),
            _ => Err(Problems(problems)),
        }
    }

    fn line(&self, offset: usize) -> usize {
        line_of(&self.line_ends, offset)
    }
}

fn line_ends(text: &str) -> Vec<usize> {
    text.bytes().enumerate().filter(|(_, byte)| *byte == b'\n').map(|(at, _)| at).collect()
}

fn line_of(line_ends: &[usize], offset: usize) -> usize {
    line_ends.partition_point(|end| *end < offset) + 1
}

/// One table of a file, whether it is there or not.
pub(crate) struct Section<'a> {
    file: &'a File,
    path: String,
    line: usize,
    table: Option<&'a dyn TableLike>,
    read: RefCell<BTreeSet<String>>,
}

impl<'a> Section<'a> {
    /// Whether the table stands in the file.
    pub(crate) fn is_present(&self) -> bool {
        self.table.is_some()
    }

    /// Whether `key` stands in the table.
    pub(crate) fn has(&self, key: &str) -> bool {
        self.item(key).is_some()
    }

    /// Whether `key` stands in the table and is true or false.
    pub(crate) fn is_bool(&self, key: &str) -> bool {
        self.item(key).is_some_and(Item::is_bool)
    }

    /// The table at `key`; an absent one reads as empty.
    pub(crate) fn section(&self, key: &str) -> Section<'a> {
        let item = self.item(key);
        let table = item.and_then(Item::as_table_like);
        if let (Some(item), None) = (item, table) {
            self.problem(key, "a table", item.type_name());
        }
        Section {
            file: self.file,
            path: self.path_of(key),
            line: self.line_of(key),
            table,
            read: RefCell::default(),
        }
    }

    /// The tables of a table of tables, in the order of the file, with their names.
    pub(crate) fn sections(&self, key: &str) -> Vec<(String, Section<'a>)> {
        let all = self.section(key);
        let mut named: Vec<_> = all
            .table
            .iter()
            .flat_map(|table| table.iter())
            .map(|(name, _)| (name.to_owned(), all.section(name)))
            .collect();
        named.sort_by_key(|(_, section)| section.line);
        named
    }

    /// The tables of an array of tables.
    pub(crate) fn array(&self, key: &str) -> Vec<Section<'a>> {
        let Some(item) = self.item(key) else { return Vec::new() };
        let tables: Vec<(&dyn TableLike, usize)> = match item {
            Item::ArrayOfTables(array) => array
                .iter()
                .map(|table| (table as &dyn TableLike, table.span().map_or(0, |span| span.start)))
                .collect(),
            Item::Value(Value::Array(array)) if array.iter().all(Value::is_inline_table) => array
                .iter()
                .filter_map(|value| {
                    let start = value.span().map_or(0, |span| span.start);
                    Some((value.as_inline_table()? as &dyn TableLike, start))
                })
                .collect(),
            other => {
                self.problem(key, "an array of tables", other.type_name());
                Vec::new()
            }
        };
        tables
            .into_iter()
            .enumerate()
            .map(|(index, (table, start))| Section {
                file: self.file,
                path: format!("{}[{index}]", self.path_of(key)),
                line: self.file.line(start),
                table: Some(table),
                read: RefCell::default(),
            })
            .collect()
    }

    /// The value at `key`, if it is there and of the right kind.
    pub(crate) fn get<T: FromItem>(&self, key: &str) -> Option<T> {
        let item = self.item(key)?;
        let value = T::from_item(item);
        if value.is_none() {
            self.problem(key, T::EXPECTED, found(item));
        }
        value
    }

    /// The value at `key`, or `default`.
    pub(crate) fn or<T: FromItem>(&self, key: &str, default: T) -> T {
        self.get(key).unwrap_or(default)
    }

    /// The value at `key`, which must be there.
    pub(crate) fn required<T: FromItem>(&self, key: &str) -> Option<T> {
        if !self.has(key) {
            self.problem(key, T::EXPECTED, "nothing");
            return None;
        }
        self.get(key)
    }

    /// A number at `key` within `range`, or `default`.
    pub(crate) fn within<T>(&self, key: &str, default: T, range: RangeInclusive<T>) -> T
    where
        T: FromItem + PartialOrd + Display + Copy,
    {
        match self.get::<T>(key) {
            Some(value) if range.contains(&value) => value,
            Some(value) => {
                let expected = format!("{} to {}", range.start(), range.end());
                self.problem(key, expected, value);
                default
            }
            None => default,
        }
    }

    /// The word at `key`, one of `words`, or `default`.
    pub(crate) fn word<T: Copy>(&self, key: &str, default: T, words: &[(&str, T)]) -> T {
        if self.has(key) { self.required_word(key, words).unwrap_or(default) } else { default }
    }

    /// The word at `key`, one of `words`, which must be there.
    pub(crate) fn required_word<T: Copy>(&self, key: &str, words: &[(&str, T)]) -> Option<T> {
        let all: Vec<_> = words.iter().map(|(word, _)| format!("{word:?}")).collect();
        let expected = all.join(" or ");
        if !self.has(key) {
            self.problem(key, expected, "nothing");
            return None;
        }
        let found: String = self.get(key)?;
        let value = words.iter().find(|(word, _)| *word == found).map(|(_, value)| *value);
        if value.is_none() {
            self.problem(key, expected, format!("{found:?}"));
        }
        value
    }

    /// The numbers at the keys that are `prefix` and a whole number: A4, A6. In the order of those.
    pub(crate) fn numbered(&self, prefix: &str) -> Vec<(u8, f64)> {
        let keys = self.table.iter().flat_map(|table| table.iter()).map(|(key, _)| key);
        let mut numbers: Vec<u8> = keys
            .filter_map(|key| key.strip_prefix(prefix))
            .filter(|number| number.bytes().all(|digit| digit.is_ascii_digit()))
            .filter(|number| !number.starts_with('0'))
            .filter_map(|number| number.parse().ok())
            .collect();
        numbers.sort_unstable();
        numbers
            .into_iter()
            .filter_map(|number| Some((number, self.get(&format!("{prefix}{number}"))?)))
            .collect()
    }

    /// Reports a problem with `key` of this table.
    pub(crate) fn problem(&self, key: &str, expected: impl Display, found: impl Display) {
        self.file.problems.borrow_mut().push(Problem {
            file: self.file.name.clone(),
            line: self.line_of(key),
            key: self.path_of(key),
            expected: expected.to_string(),
            found: found.to_string(),
        });
    }

    /// Reports every key that was never asked for. Call it when the table has been read.
    pub(crate) fn finish(&self) {
        let read = self.read.borrow();
        let known: Vec<_> = read.iter().map(String::as_str).collect();
        for (key, _) in self.table.iter().flat_map(|table| table.iter()) {
            if !read.contains(key) {
                let expected = match nearest(key, &known) {
                    Some(known) => format!("a known key (did you mean `{known}`?)"),
                    None => format!("one of the keys {}", known.join(", ")),
                };
                self.problem(key, expected, format!("`{key}`"));
            }
        }
    }

    fn item(&self, key: &str) -> Option<&'a Item> {
        self.read.borrow_mut().insert(key.to_owned());
        self.table?.get(key).filter(|item| !item.is_none())
    }

    fn path_of(&self, key: &str) -> String {
        if self.path.is_empty() { key.to_owned() } else { format!("{}.{key}", self.path) }
    }

    /// Line of a key of this table; of the key itself where an element of it is meant: `signals[3]`.
    fn line_of(&self, key: &str) -> usize {
        let key = key.split(['[', '.']).next().unwrap_or(key);
        let key = self.table.and_then(|table| table.key(key));
        key.and_then(toml_edit::Key::span).map_or(self.line, |span| self.file.line(span.start))
    }
}

/// What a TOML value can be read as.
pub(crate) trait FromItem: Sized {
    /// In words.
    const EXPECTED: &'static str;
    /// An array of them, in words.
    const EXPECTED_MANY: &'static str = "an array of values of one kind";

    /// The value, if it is one.
    fn from_item(item: &Item) -> Option<Self>;
}

impl FromItem for String {
    const EXPECTED: &'static str = "a string";
    const EXPECTED_MANY: &'static str = "an array of strings";

    fn from_item(item: &Item) -> Option<String> {
        item.as_str().map(str::to_owned)
    }
}

impl FromItem for bool {
    const EXPECTED: &'static str = "true or false";

    fn from_item(item: &Item) -> Option<bool> {
        item.as_bool()
    }
}

impl FromItem for f64 {
    const EXPECTED: &'static str = "a finite number";
    const EXPECTED_MANY: &'static str = "an array of finite numbers";

    fn from_item(item: &Item) -> Option<f64> {
        let number = item.as_float().or_else(|| item.as_integer().map(|number| number as f64));
        number.filter(|number| number.is_finite())
    }
}

/// A number, or that it is found by itself: the word `auto`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum OrAuto {
    /// The word.
    Auto,
    /// The number.
    Number(f64),
}

impl FromItem for OrAuto {
    const EXPECTED: &'static str = "a finite number or \"auto\"";

    fn from_item(item: &Item) -> Option<OrAuto> {
        if item.as_str() == Some("auto") {
            return Some(OrAuto::Auto);
        }
        f64::from_item(item).map(OrAuto::Number)
    }
}

macro_rules! integers {
    ($($kind:ty: $expected:literal),*) => {$(
        impl FromItem for $kind {
            const EXPECTED: &'static str = $expected;

            fn from_item(item: &Item) -> Option<$kind> {
                item.as_integer()?.try_into().ok()
            }
        }
    )*};
}

integers! {
    u8: "a whole number from 0 to 255",
    u16: "a whole number from 0 to 65535",
    u32: "a whole number from 0 to 4294967295",
    u64: "a whole number, not negative",
    i64: "a whole number",
    usize: "a whole number, not negative"
}

impl<T: FromItem> FromItem for Vec<T> {
    const EXPECTED: &'static str = T::EXPECTED_MANY;

    fn from_item(item: &Item) -> Option<Vec<T>> {
        item.as_array()?.iter().map(|value| T::from_item(&Item::Value(value.clone()))).collect()
    }
}

/// What stands there, in words.
fn found(item: &Item) -> String {
    match item {
        Item::Value(Value::String(text)) => format!("the string {:?}", text.value()),
        Item::Value(Value::Integer(number)) => number.value().to_string(),
        Item::Value(Value::Float(number)) => number.value().to_string(),
        Item::Value(Value::Boolean(value)) => value.value().to_string(),
        Item::Value(Value::Array(array)) => {
            array.to_string().trim().chars().take(LONGEST_ARRAY).collect()
        }
        other => format!("a value of type {}", other.type_name()),
    }
}

/// Letters of an array that are shown.
const LONGEST_ARRAY: usize = 60;

/// The known word nearest to `word`, if it is near enough to be a typing error or a unit left out.
pub(crate) fn nearest<'a>(word: &str, known: &[&'a str]) -> Option<&'a str> {
    if word.len() > LONGEST_MISTYPED {
        return None;
    }
    let without_unit =
        |known: &&&str| known.strip_prefix(word).is_some_and(|rest| rest.starts_with('_'));
    if let Some(known) = known.iter().find(without_unit) {
        return Some(known);
    }
    let (distance, nearest) = known.iter().map(|known| (edits(word, known), *known)).min()?;
    (distance <= 1 + word.len() / 4).then_some(nearest)
}

/// Bytes of a word that may be a known one mistyped; the known ones have some 20.
const LONGEST_MISTYPED: usize = 64;

/// Levenshtein's distance.
fn edits(a: &str, b: &str) -> usize {
    let b: Vec<char> = b.chars().collect();
    let mut row: Vec<usize> = (0..=b.len()).collect();
    for (i, a) in a.chars().enumerate() {
        let mut diagonal = row[0];
        row[0] = i + 1;
        for (j, b) in b.iter().enumerate() {
            let substituted = diagonal + usize::from(a != *b);
            diagonal = row[j + 1];
            row[j + 1] = substituted.min(row[j] + 1).min(diagonal + 1);
        }
    }
    row[b.len()]
}

#[cfg(test)]
mod tests {
    use super::*;

    const TEXT: &str = "name = 3\n\n[link.probe]\nbaud_bd = 115200\nparitty = \"none\"\n\n[link.stage]\nbaud_bd = \"fast\"\n";

    #[test]
    fn all_problems_come_at_once_with_line_and_key() {
        let file = File::parse("a.toml", TEXT).unwrap();
        let root = file.root();
        root.required::<String>("name");
        root.required::<f64>("speed");
        for (_, link) in root.sections("link") {
            link.within("baud_bd", 9600, 1..=100_000u32);
            link.word("parity", (), &[("none", ())]);
            link.finish();
        }
        root.finish();
        drop(root);
        let problems = file.conclude(Some(())).unwrap_err();
        assert_eq!(
            problems.to_string(),
            "a.toml:1: name: expected a string, found 3\n\
             a.toml:1: speed: expected a finite number, found nothing\n\
             a.toml:4: link.probe.baud_bd: expected 1 to 100000, found 115200\n\
             a.toml:5: link.probe.paritty: expected a known key (did you mean `parity`?), found `paritty`\n\
             a.toml:8: link.stage.baud_bd: expected a whole number from 0 to 4294967295, found the string \"fast\""
        );
    }

    #[test]
    fn a_zemax_file_is_known_for_one() {
        for text in ["VERS 140124 258 36214\nMODE SEQ\n", "UNIT MM X W X CM MR CPMM\nSURF 0\n"] {
            let Err(Problems(problems)) = File::parse("lens.zmx", text) else { panic!("{text}") };
            assert!(problems[0].expected.contains("asphera nominal"), "{problems:?}");
        }
    }

    #[test]
    fn syntax_errors_name_their_line() {
        let Err(problems) = File::parse("b.toml", "a = 1\nb = = 2\n") else { panic!("parsed") };
        assert_eq!(problems.0[0].line, 2);
    }

    #[test]
    fn lines_are_counted_from_one_wherever_a_key_stands() {
        let text = "\na = 1\r\n[b]\nc = 1";
        let ends = line_ends(text);
        let plain = |offset| text[..offset].matches('\n').count() + 1;
        for offset in 0..=text.len() {
            assert_eq!(line_of(&ends, offset), plain(offset), "{offset}");
        }
    }

    #[test]
    fn far_words_are_not_suggested() {
        assert_eq!(nearest("radius", &["radius_mm", "conic"]), Some("radius_mm"));
        assert_eq!(nearest("height", &["radius_mm", "conic"]), None);
        assert_eq!(nearest("radius_m", &["radius_mm", "conic"]), Some("radius_mm"));
        assert_eq!(nearest("x", &["conic"]), None);
        assert_eq!(nearest(&"conic".repeat(20), &["conic"]), None);
    }
}
