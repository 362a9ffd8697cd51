//! The header of a `.npy` file: a dictionary as Python writes it.

/// A value of Python.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) enum Literal {
    Text(String),
    Flag(bool),
    Whole(u64),
    /// A list or a tuple.
    List(Vec<Literal>),
}

/// The entries of a dictionary, in its order; `None` where the text is none.
pub(super) fn dictionary(text: &str) -> Option<Vec<(String, Literal)>> {
    let mut parser = Parser { rest: text };
    parser.mark('{')?;
    let mut entries = Vec::new();
    while !parser.is_at('}') {
        let key = parser.text()?;
        parser.mark(':')?;
        entries.push((key, parser.value(0)?));
        if !parser.is_at('}') {
            parser.mark(',')?;
        }
    }
    parser.mark('}')?;
    parser.rest.trim().is_empty().then_some(entries)
}

struct Parser<'a> {
    rest: &'a str,
}

impl Parser<'_> {
    fn is_at(&mut self, mark: char) -> bool {
        self.rest = self.rest.trim_start();
        self.rest.starts_with(mark)
    }

    fn mark(&mut self, mark: char) -> Option<()> {
        self.rest = self.rest.trim_start().strip_prefix(mark)?;
        Some(())
    }

    fn text(&mut self) -> Option<String> {
        self.rest = self.rest.trim_start();
        let quote = self.rest.chars().next().filter(|first| ['\'', '"'].contains(first))?;
        let mut text = String::new();
        let mut letters = self.rest.char_indices().skip(1);
        while let Some((at, letter)) = letters.next() {
            match letter {
                '\\' => text.push(letters.next()?.1),
                letter if letter == quote => {
                    self.rest = &self.rest[at + letter.len_utf8()..];
                    return Some(text);
                }
                letter => text.push(letter),
            }
        }
        None
    }

    fn value(&mut self, depth: usize) -> Option<Literal> {
        self.rest = self.rest.trim_start();
        for (word, flag) in [("True", true), ("False", false)] {
            if let Some(rest) = self.rest.strip_prefix(word) {
                self.rest = rest;
                return Some(Literal::Flag(flag));
            }
        }
        match self.rest.chars().next()? {
            '(' if depth < DEEPEST => self.list('(', ')', depth),
            '[' if depth < DEEPEST => self.list('[', ']', depth),
            '\'' | '"' => self.text().map(Literal::Text),
            _ => {
                let end = self.rest.find(|letter: char| !letter.is_ascii_digit());
                let (digits, rest) = self.rest.split_at(end.unwrap_or(self.rest.len()));
                // Python 2 marks long ones.
                self.rest = rest.strip_prefix('L').unwrap_or(rest);
                digits.parse().ok().map(Literal::Whole)
            }
        }
    }

    fn list(&mut self, open: char, close: char, depth: usize) -> Option<Literal> {
        self.mark(open)?;
        let mut values = Vec::new();
        while !self.is_at(close) {
            values.push(self.value(depth + 1)?);
            if !self.is_at(close) {
                self.mark(',')?;
            }
        }
        self.mark(close)?;
        Some(Literal::List(values))
    }
}

/// Lists within lists; records of arrays within records need four.
const DEEPEST: usize = 16;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn dictionaries_are_read_as_python_writes_them() {
        let text = "{'descr': [('x', '<f8'), (\"it's\", '|V4', (2L,))], 'fortran_order': False, 'shape': (3, 4), }  \n";
        let text_of = |text: &str| Literal::Text(text.to_owned());
        let descr = Literal::List(vec![
            Literal::List(vec![text_of("x"), text_of("<f8")]),
            Literal::List(vec![
                text_of("it's"),
                text_of("|V4"),
                Literal::List(vec![Literal::Whole(2)]),
            ]),
        ]);
        let shape = Literal::List(vec![Literal::Whole(3), Literal::Whole(4)]);
        let expected = [
            ("descr".to_owned(), descr),
            ("fortran_order".to_owned(), Literal::Flag(false)),
            ("shape".to_owned(), shape),
        ];
        assert_eq!(dictionary(text).unwrap(), expected);
        for wrong in ["", "{", "{'a'}", "{'a': }", "{'a': 1", "{'a': 1} x", "{'a: 1}", "{'a': -1}"]
        {
            assert_eq!(dictionary(wrong), None, "{wrong}");
        }
        assert_eq!(dictionary(&format!("{{'a': {}", "(".repeat(100_000))), None);
    }
}
