//! A text that a pattern accepts, with chosen texts in its groups.

use asphera_described::{Form, Pattern};
use regex::bytes::{Regex, RegexBuilder};
use regex_syntax::ParserBuilder;
use regex_syntax::hir::{Class, Hir, HirKind};

use crate::number::Print;

/// A pattern taken apart.
#[derive(Clone, Debug)]
pub(crate) struct Example(Hir);

impl Example {
    /// The parts of a pattern; `None` where it cannot be parsed as bytes.
    pub(crate) fn new(pattern: &Pattern) -> Option<Example> {
        let mut parser = ParserBuilder::new().unicode(false).utf8(false).build();
        parser.parse(pattern.text()).ok().map(Example)
    }

    /// The first text that it accepts: the first of alternatives, each part as rarely as it may be. `chosen` gives the text of a named
    /// group.
    pub(crate) fn text(&self, chosen: &dyn Fn(&str) -> Option<Vec<u8>>) -> Vec<u8> {
        let mut text = Vec::new();
        write(&self.0, chosen, &mut text);
        text
    }

    /// The expression of a named group.
    pub(crate) fn group(&self, name: &str) -> Option<Group> {
        find(&self.0, name).and_then(Group::new)
    }
}

/// The expression of a group, to find the print of a number in it.
#[derive(Clone, Debug)]
pub(crate) struct Group(Regex);

impl Group {
    fn new(part: &Hir) -> Option<Group> {
        let whole = format!(r"\A(?:{part})\z");
        RegexBuilder::new(&whole).unicode(false).build().ok().map(Group)
    }

    /// A number as the group accepts it, in the finest print there is.
    pub(crate) fn number(&self, form: Form, raw: f64) -> Option<String> {
        Print::all()
            .map(|print| print.text(form, raw))
            .find(|text| self.0.is_match(text.as_bytes()))
    }
}

fn write(part: &Hir, chosen: &dyn Fn(&str) -> Option<Vec<u8>>, text: &mut Vec<u8>) {
    match part.kind() {
        HirKind::Empty | HirKind::Look(_) => {}
        HirKind::Literal(literal) => text.extend_from_slice(&literal.0),
        HirKind::Class(class) => text.extend(one_of(class)),
        HirKind::Repetition(repetition) => {
            for _ in 0..repetition.min {
                write(&repetition.sub, chosen, text);
            }
        }
        HirKind::Capture(capture) => match capture.name.as_deref().and_then(chosen) {
            Some(given) => text.extend(given),
            None => write(&capture.sub, chosen, text),
        },
        HirKind::Concat(parts) => parts.iter().for_each(|part| write(part, chosen, text)),
        HirKind::Alternation(parts) => {
            if let Some(first) = parts.first() {
                write(first, chosen, text);
            }
        }
    }
}

/// A sign of a class that reads well: a digit, a letter, else its first.
fn one_of(class: &Class) -> Option<u8> {
    let ranges: Vec<(u8, u8)> = match class {
        Class::Bytes(bytes) => bytes.ranges().iter().map(|r| (r.start(), r.end())).collect(),
        Class::Unicode(signs) => {
            let ascii = |sign: char| u8::try_from(u32::from(sign)).unwrap_or(u8::MAX);
            signs.ranges().iter().map(|r| (ascii(r.start()), ascii(r.end()))).collect()
        }
    };
    let has = |sign: u8| ranges.iter().any(|(first, last)| (*first..=*last).contains(&sign));
    let likely = [b'0', b'A', b'a', b'+', b' '].into_iter().find(|sign| has(*sign));
    likely.or_else(|| ranges.first().map(|(first, _)| *first))
}

fn find<'a>(part: &'a Hir, name: &str) -> Option<&'a Hir> {
    match part.kind() {
        HirKind::Capture(capture) if capture.name.as_deref() == Some(name) => Some(&capture.sub),
        HirKind::Capture(capture) => find(&capture.sub, name),
        HirKind::Repetition(repetition) => find(&repetition.sub, name),
        HirKind::Concat(parts) | HirKind::Alternation(parts) => {
            parts.iter().find_map(|part| find(part, name))
        }
        HirKind::Empty | HirKind::Look(_) | HirKind::Literal(_) | HirKind::Class(_) => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn example(text: &str) -> Example {
        Example::new(&Pattern::new(text).expect("a pattern")).expect("one of bytes")
    }

    /// What is written is accepted by the expression itself, which is the crate regex.
    #[test]
    fn the_pattern_accepts_its_example() {
        for text in [
            "ARM 7,.*",
            r"T=(?<degc>[+-]\d{3}\.\d\d)",
            r"OK(?<state>\d{3})|NG",
            r"[A-F]{2,4}x?\s+\xFF",
            r"(?i)abc[^a-z]",
            "",
        ] {
            let written = example(text).text(&|_| None);
            assert!(
                Pattern::new(text).expect("a pattern").matches(&written),
                "{text}: {written:?}"
            );
        }
    }

    #[test]
    fn numbers_fit_their_group() {
        let pattern = example(r"T=(?<degc>[+-]\d{3}\.\d\d)");
        let group = pattern.group("degc").expect("the group");
        assert_eq!(group.number(Form::Decimal, 21.304).as_deref(), Some("+021.30"));
        assert_eq!(group.number(Form::Decimal, -4.0).as_deref(), Some("-004.00"));
        assert_eq!(group.number(Form::Decimal, 1e4), None, "it has three digits");
        let whole = pattern.text(&|_| Some(b"+021.30".to_vec()));
        assert_eq!(whole, b"T=+021.30");
        assert!(pattern.group("other").is_none());
    }
}
