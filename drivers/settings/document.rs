//! A TOML file and its tables, read key by key.

use std::cell::RefCell;
use std::collections::{BTreeSet, HashSet};
use std::fmt::Display;
use std::ops::RangeInclusive;
use std::str::FromStr;

use toml_edit::{Document, Item, TableLike, Value};

use crate::item::{FromItem, found};
use crate::nearest::nearest;
use crate::problem::{Problem, Problems};
use crate::syntax;

/// A TOML file and what was found wrong with it so far.
pub struct File {
    name: String,
    document: Document<String>,
    /// Where its lines end, ascending: thousands of keys are asked for their lines.
    line_ends: Vec<usize>,
    problems: RefCell<Vec<Problem>>,
}

impl File {
    /// Parses `text`; `name` stands in every problem.
    ///
    /// # Errors
    ///
    /// One problem without a key, at the place where the text stops being TOML.
    pub fn parse(name: &str, text: &str) -> Result<File, Problems> {
        match Document::from_str(text) {
            Ok(document) => {
                let line_ends = line_ends(text);
                let name = name.to_owned();
                Ok(File { name, document, line_ends, problems: RefCell::default() })
            }
            Err(error) => {
                let span = error.span().unwrap_or(0..0);
                let line = line_of(&line_ends(text), span.start);
                let (expected, found) = syntax::in_words(error.message(), text.get(span));
                let (file, key) = (name.to_owned(), String::new());
                Err(Problems(vec![Problem { file, line, key, expected, found }]))
            }
        }
    }

    /// The whole file as a table.
    pub fn root(&self) -> Section<'_> {
        Section {
            file: self,
            path: String::new(),
            line: 1,
            table: Some(self.document.as_table()),
            read: RefCell::default(),
        }
    }

    /// `value`, if nothing is wrong with the file.
    ///
    /// # Errors
    ///
    /// All that was found wrong, in the order of the file. Without a value there may be no problem in the list.
    pub fn conclude<T>(self, value: Option<T>) -> Result<T, Problems> {
        let mut problems = self.problems.into_inner();
        let mut seen = HashSet::new();
        problems.retain(|problem| seen.insert(problem.clone()));
        problems.sort_by_key(|problem| problem.line);
        match value {
            Some(value) if problems.is_empty() => Ok(value),
            _ => Err(Problems(problems)),
        }
    }

    fn line(&self, offset: usize) -> usize {
        line_of(&self.line_ends, offset)
    }
}

/// The parts of `signals[3]`.
fn name_and_index(step: &str) -> (&str, Option<usize>) {
    let parts = step.strip_suffix(']').and_then(|step| step.split_once('['));
    parts.map_or((step, None), |(name, index)| (name, index.parse().ok()))
}

fn line_ends(text: &str) -> Vec<usize> {
    text.bytes().enumerate().filter(|(_, byte)| *byte == b'\n').map(|(at, _)| at).collect()
}

fn line_of(line_ends: &[usize], offset: usize) -> usize {
    line_ends.partition_point(|end| *end < offset) + 1
}

/// One table of a file, whether it is there or not.
///
/// Keys are relative to the table. A method that reads a key notes it as known, and reports a value of the wrong
/// kind as a problem; the caller goes on with `None` or its default, so that one run finds all mistakes.
pub struct Section<'a> {
    file: &'a File,
    path: String,
    line: usize,
    table: Option<&'a dyn TableLike>,
    read: RefCell<BTreeSet<String>>,
}

impl<'a> Section<'a> {
    /// Whether the table stands in the file.
    pub fn is_present(&self) -> bool {
        self.table.is_some()
    }

    /// Whether `key` stands in the table.
    pub fn has(&self, key: &str) -> bool {
        self.item(key).is_some()
    }

    /// Whether `key` stands in the table and is true or false.
    pub fn is_bool(&self, key: &str) -> bool {
        self.item(key).is_some_and(Item::is_bool)
    }

    /// The table at `key`; an absent one reads as empty.
    pub fn section(&self, key: &str) -> Section<'a> {
        let item = self.item(key);
        let path = self.path_of(key);
        let mut table = item.and_then(Item::as_table_like);
        if let (Some(item), None) = (item, table) {
            // The first of a list is read all the same, so that its own mistakes are found.
            let first = item.as_array_of_tables().and_then(|list| list.get(0));
            table = first.map(|first| first as &dyn TableLike);
            match first {
                Some(_) => {
                    self.problem(key, format!("one table, headed [{path}]"), format!("[[{path}]]"));
                }
                None => self.problem(key, format!("a table, headed [{path}]"), found(item)),
            }
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
    pub fn sections(&self, key: &str) -> Vec<(String, Section<'a>)> {
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
    pub fn array(&self, key: &str) -> Vec<Section<'a>> {
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

    /// The value at `key`, if it is there and of the right kind. Another kind is a problem; absence is none.
    pub fn get<T: FromItem>(&self, key: &str) -> Option<T> {
        let item = self.item(key)?;
        let value = T::from_item(item);
        if value.is_none() {
            self.problem(key, T::EXPECTED, found(item));
        }
        value
    }

    /// The value at `key`; `default` where there is none, or one of the wrong kind.
    pub fn or<T: FromItem>(&self, key: &str, default: T) -> T {
        self.get(key).unwrap_or(default)
    }

    /// The value at `key`, which must be there.
    pub fn required<T: FromItem>(&self, key: &str) -> Option<T> {
        if !self.has(key) {
            self.problem(key, T::EXPECTED, "nothing");
            return None;
        }
        self.get(key)
    }

    /// A number at `key` within `range`; `default` where there is none, or one outside.
    pub fn within<T>(&self, key: &str, default: T, range: RangeInclusive<T>) -> T
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

    /// The two ends of a range, `[lowest, highest]`, if the key is there.
    pub fn range(&self, key: &str) -> Option<(f64, f64)> {
        let range: Vec<f64> = self.get(key)?;
        match range[..] {
            [low, high] if low < high => Some((low, high)),
            _ => {
                self.problem(key, "[lowest, highest]", format!("{range:?}"));
                None
            }
        }
    }

    /// The value of the word at `key`, one of `words`; `default` where there is none, or another word.
    pub fn word<T: Copy>(&self, key: &str, default: T, words: &[(&str, T)]) -> T {
        if self.has(key) { self.required_word(key, words).unwrap_or(default) } else { default }
    }

    /// The value of the word at `key`, one of `words`, which must be there.
    pub fn required_word<T: Copy>(&self, key: &str, words: &[(&str, T)]) -> Option<T> {
        let all: Vec<_> = words.iter().map(|(word, _)| format!("{word:?}")).collect();
        let expected = all.join(" or ");
        if !self.has(key) {
            self.problem(key, expected, "nothing");
            return None;
        }
        let found: String = self.get(key)?;
        let value = words.iter().find(|(word, _)| *word == found).map(|(_, value)| *value);
        if value.is_none() {
            let known: Vec<&str> = words.iter().map(|(word, _)| *word).collect();
            let meant = nearest(&found, &known)
                .map_or_else(String::new, |word| format!(" (did you mean {word:?}?)"));
            self.problem(key, format!("{expected}{meant}"), format!("{found:?}"));
        }
        value
    }

    /// The numbers at the keys that are `prefix` and a whole number: A4, A6. In the order of those.
    pub fn numbered(&self, prefix: &str) -> Vec<(u8, f64)> {
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

    /// Reports a problem with `key` of this table, at its line; an absent key has the line of the table. A key may
    /// lead to an element or into tables within: `signals[3]`, `pose.tx_mm`.
    pub fn problem(&self, key: &str, expected: impl Display, found: impl Display) {
        self.file.problems.borrow_mut().push(Problem {
            file: self.file.name.clone(),
            line: self.line_of(key),
            key: self.path_of(key),
            expected: expected.to_string(),
            found: found.to_string(),
        });
    }

    /// Reports every key that was never asked for. Call it when the table has been read.
    pub fn finish(&self) {
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

    /// Line of what `key` means, which may be an element or lie in tables within: `field[3].scale`. Where that is
    /// absent, the line of the nearest table or key about it.
    fn line_of(&self, key: &str) -> usize {
        let own = self.table.and_then(|table| table.key(key)).and_then(toml_edit::Key::span);
        if let Some(span) = own {
            return self.file.line(span.start);
        }
        let (mut table, mut line) = (self.table, self.line);
        for step in key.split('.') {
            let (name, index) = name_and_index(step);
            let Some((name, item)) = table.and_then(|table| table.get_key_value(name)) else {
                break;
            };
            let element = index.and_then(|index| item.get(index));
            let place = element.and_then(Item::span).or_else(|| name.span());
            line = place.map_or(line, |span| self.file.line(span.start));
            table = element.unwrap_or(item).as_table_like();
        }
        line
    }
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
    fn a_problem_stands_where_its_element_does() {
        let text = "[stage.at]\nx = 1\n[[field]]\na = 1\n[[field]]\nb = 2\nlist = [\n  1,\n  2]\n\
                    inline = [{ c = 1 },\n { c = 2 }]\n\"a.b\" = 3\n";
        let file = File::parse("c.toml", text).unwrap();
        let root = file.root();
        for (key, line) in [
            ("stage.at.x", 2),
            ("stage.at.y", 1),
            ("stage.none.x", 1),
            ("field[0].a", 4),
            ("field[1]", 5),
            ("field[1].b", 6),
            ("field[1].list[1]", 9),
            ("field[1].inline[1].c", 11),
            ("field[1].absent", 5),
            ("field[7].a", 3),
            ("absent[0].a", 1),
        ] {
            assert_eq!(root.line_of(key), line, "{key}");
        }
        assert_eq!(root.array("field")[1].line_of("a.b"), 12);
    }

    #[test]
    fn messages_say_what_to_write() {
        let syntax = |text: &str| match File::parse("c.toml", text) {
            Ok(_) => panic!("{text} was parsed"),
            Err(problems) => problems.to_string(),
        };
        for (text, said) in [
            (
                "[a]\nx = 1\n[a]\n",
                "c.toml:3: expected each key and each table once, found \"a\" again",
            ),
            (
                "x = polar\n",
                "c.toml:1: expected a value: text in quotes, a number, true or false, found \"polar\"",
            ),
            (
                "x = \"polar\n",
                "c.toml:1: expected a quote at the end of the text, found the end of the line",
            ),
        ] {
            assert_eq!(syntax(text), said);
        }
        let file = File::parse("c.toml", "[[link.probe]]\nkind = \"seriel\"\n[b]\n").unwrap();
        {
            let link = file.root().section("link");
            let _ = link.section("probe");
            let words = [("serial", 1), ("tcp", 2)];
            assert_eq!(link.section("probe").required_word("kind", &words), None);
        }
        let problems = file.conclude(Some(())).unwrap_err().to_string();
        assert_eq!(
            problems,
            "c.toml:1: link.probe: expected one table, headed [link.probe], found [[link.probe]]\n\
             c.toml:2: link.probe.kind: expected \"serial\" or \"tcp\" (did you mean \"serial\"?), found \"seriel\""
        );
    }

    #[test]
    fn numbers_are_shown_in_few_digits() {
        let shown = [9.0, -0.25, 1e308, 5e-324, 0.0, 123_456.75, f64::INFINITY].map(crate::number);
        assert_eq!(shown, ["9", "-0.25", "1e308", "5e-324", "0", "123456.75", "inf"]);
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
}
