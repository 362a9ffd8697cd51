//! Methods with their arguments: `GoTo(X(1.5), Tool.A(45))`.

use std::fmt;

use thiserror::Error;

/// Method with its arguments, or a value with its name.
#[derive(Clone, Debug, PartialEq)]
pub struct Call {
    /// Name, with dots where it has several parts: `Tool.PtMeasPar.Speed`.
    pub name: String,
    /// Arguments in their order.
    pub arguments: Vec<Argument>,
}

/// Argument of a method.
#[derive(Clone, Debug, PartialEq)]
pub enum Argument {
    /// A number.
    Number(f64),
    /// A text between quotation marks.
    Text(String),
    /// A bare word, as `PartCsy`.
    Word(String),
    /// A value with its name.
    Group(Call),
}

/// Why a text is no method.
#[derive(Clone, Copy, Debug, Error, PartialEq, Eq)]
#[error("expected {expected} at character {at}")]
pub struct CallError {
    /// Character from 1.
    pub at: usize,
    /// What should stand there.
    pub expected: &'static str,
}

impl Call {
    /// The method in a whole text.
    ///
    /// # Errors
    ///
    /// The first character that does not fit.
    pub fn parse(text: &str) -> Result<Call, CallError> {
        let mut reader = Reader { text: text.as_bytes(), at: 0 };
        let call = reader.call(0)?;
        reader.end()?;
        Ok(call)
    }

    /// The arguments, where all of them are numbers.
    pub fn numbers(&self) -> Option<Vec<f64>> {
        let number = |argument: &Argument| match argument {
            Argument::Number(number) => Some(*number),
            Argument::Text(_) | Argument::Word(_) | Argument::Group(_) => None,
        };
        self.arguments.iter().map(number).collect()
    }

    /// The argument of a name.
    pub fn group(&self, name: &str) -> Option<&Call> {
        self.arguments.iter().find_map(|argument| match argument {
            Argument::Group(group) if group.name == name => Some(group),
            _ => None,
        })
    }
}

/// Values with their names, as data have them: `X(99.93), Y(17.148)`. `None` where the text is none.
pub fn items(text: &str) -> Option<Vec<Call>> {
    let mut reader = Reader { text: text.as_bytes(), at: 0 };
    let mut items = vec![reader.call(0).ok()?];
    while reader.took(b',') {
        items.push(reader.call(0).ok()?);
    }
    reader.end().ok()?;
    Some(items)
}

struct Reader<'a> {
    text: &'a [u8],
    at: usize,
}

impl Reader<'_> {
    fn peek(&self) -> Option<u8> {
        self.text.get(self.at).copied()
    }

    fn skip_spaces(&mut self) {
        while self.peek() == Some(b' ') {
            self.at += 1;
        }
    }

    /// Takes a sign with the spaces about it, if it is the next.
    fn took(&mut self, sign: u8) -> bool {
        self.skip_spaces();
        let is_next = self.peek() == Some(sign);
        if is_next {
            self.at += 1;
            self.skip_spaces();
        }
        is_next
    }

    fn fail<T>(&self, expected: &'static str) -> Result<T, CallError> {
        Err(CallError { at: self.at + 1, expected })
    }

    fn end(&mut self) -> Result<(), CallError> {
        self.skip_spaces();
        if self.at == self.text.len() { Ok(()) } else { self.fail("the end") }
    }

    fn taken(&mut self, is_part: impl Fn(u8) -> bool) -> String {
        let begin = self.at;
        while self.peek().is_some_and(&is_part) {
            self.at += 1;
        }
        self.text[begin..self.at].iter().map(|&byte| char::from(byte)).collect()
    }

    fn word(&mut self) -> Result<String, CallError> {
        if !self.peek().is_some_and(|byte| byte.is_ascii_alphabetic()) {
            return self.fail("a name");
        }
        Ok(self.taken(|byte| byte.is_ascii_alphanumeric() || byte == b'.'))
    }

    fn call(&mut self, depth: usize) -> Result<Call, CallError> {
        let name = self.word()?;
        if !self.took(b'(') {
            return self.fail("(");
        }
        self.arguments(name, depth)
    }

    /// What follows the bracket that opens.
    fn arguments(&mut self, name: String, depth: usize) -> Result<Call, CallError> {
        let mut arguments = Vec::new();
        if depth == DEEPEST {
            return self.fail("fewer brackets in brackets");
        }
        if self.took(b')') {
            return Ok(Call { name, arguments });
        }
        loop {
            arguments.push(self.argument(depth)?);
            if self.took(b')') {
                return Ok(Call { name, arguments });
            }
            if !self.took(b',') {
                return self.fail(", or )");
            }
        }
    }

    fn argument(&mut self, depth: usize) -> Result<Argument, CallError> {
        match self.peek() {
            Some(b'"') => {
                self.at += 1;
                let text = self.taken(|byte| byte != b'"');
                if self.peek().is_none() {
                    return self.fail("\"");
                }
                self.at += 1;
                Ok(Argument::Text(text))
            }
            Some(byte) if byte.is_ascii_alphabetic() => {
                let word = self.word()?;
                match self.took(b'(') {
                    true => Ok(Argument::Group(self.arguments(word, depth + 1)?)),
                    false => Ok(Argument::Word(word)),
                }
            }
            _ => {
                let begin = self.at;
                let text = self.taken(|byte| b"0123456789+-.eE".contains(&byte));
                match number(&text) {
                    Some(number) => Ok(Argument::Number(number)),
                    None => {
                        self.at = begin;
                        self.fail("a number, a text or a name")
                    }
                }
            }
        }
    }
}

/// A finite number as the protocol writes it: digits, one point, an exponent.
pub(super) fn number(text: &str) -> Option<f64> {
    let first = text.trim_start_matches(['+', '-']).bytes().next()?;
    let is_plain = text.bytes().all(|byte| b"0123456789+-.eE".contains(&byte));
    let number = || text.parse::<f64>().ok().filter(|number| number.is_finite());
    if is_plain && (first.is_ascii_digit() || first == b'.') { number() } else { None }
}

impl fmt::Display for Call {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}(", self.name)?;
        for (index, argument) in self.arguments.iter().enumerate() {
            let comma = if index == 0 { "" } else { ", " };
            match argument {
                Argument::Number(number) => write!(f, "{comma}{number}")?,
                Argument::Text(text) => write!(f, "{comma}\"{text}\"")?,
                Argument::Word(word) => write!(f, "{comma}{word}")?,
                Argument::Group(call) => write!(f, "{comma}{call}")?,
            }
        }
        write!(f, ")")
    }
}

/// Most brackets within each other.
const DEEPEST: usize = 8;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn arguments_of_all_kinds() {
        let call = Call::parse("A.B ( 1, -2.6E01, \"x, y\" , PartCsy,C( D() ),.5)").unwrap();
        assert_eq!(call.to_string(), "A.B(1, -26, \"x, y\", PartCsy, C(D()), 0.5)");
        assert_eq!(call.group("C").unwrap().to_string(), "C(D())");
        assert_eq!(call.numbers(), None);
    }

    #[test]
    fn what_does_not_fit_is_named_by_its_place() {
        let wrong = |text| Call::parse(text).unwrap_err().to_string();
        assert_eq!(wrong("GoTo"), "expected ( at character 5");
        assert_eq!(wrong("GoTo(X(1)"), "expected , or ) at character 10");
        assert_eq!(wrong("GoTo(X(1)) x"), "expected the end at character 12");
        assert_eq!(wrong("GoTo(1.2.3)"), "expected a number, a text or a name at character 6");
        assert_eq!(wrong("ChangeTool(\"Probe1)"), "expected \" at character 20");
        assert_eq!(wrong("7()"), "expected a name at character 1");
        assert!(Call::parse(&"A(".repeat(100)).is_err(), "no deep stack");
    }

    #[test]
    fn numbers_are_finite_decimals() {
        assert_eq!(number("+1.9473294E-01"), Some(0.194_732_94));
        assert_eq!(number(".1"), Some(0.1));
        assert_eq!(number("4."), Some(4.0));
        for strange in ["inf", "NaN", "1e999", "", "+", "E5", "0x1", "1 2", "--1", "1-2"] {
            assert_eq!(number(strange), None, "{strange}");
        }
    }
}
