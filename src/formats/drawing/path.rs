//! The data of an SVG path (SVG 1.1, 8.3): commands and numbers.

use super::arc::Arc;
use super::{DrawnLine, PlaceMm, straight};

/// The lines of path data in its own units; `Err` says what was found where something else was expected.
pub(super) fn lines(data: &str) -> Result<Vec<DrawnLine>, String> {
    let mut words = Words { rest: data };
    let mut pen = Pen::default();
    let mut command = None;
    loop {
        words.skip();
        match words.command() {
            Some(next) => command = Some(next),
            None if words.rest.is_empty() => break,
            // Numbers that go on: the same command again, but lines after the first place of a move.
            None => {}
        }
        let Some(letter) = command else { return Err(words.found()) };
        pen.draw(letter, &mut words)?;
        command = match letter {
            'M' => Some('L'),
            'm' => Some('l'),
            'Z' | 'z' => None,
            other => Some(other),
        };
    }
    pen.lift(false);
    Ok(pen.done)
}

/// Where the pen is, and what it drew.
#[derive(Default)]
struct Pen {
    at: PlaceMm,
    start: PlaceMm,
    /// The last control point of a curve, by the kind of curve.
    handle: Option<(char, PlaceMm)>,
    pieces: Vec<[PlaceMm; 4]>,
    done: Vec<DrawnLine>,
}

impl Pen {
    fn lift(&mut self, closed: bool) {
        let pieces = std::mem::take(&mut self.pieces);
        if !pieces.is_empty() {
            self.done.push(DrawnLine { pieces, closed });
        }
    }

    fn draw(&mut self, letter: char, words: &mut Words<'_>) -> Result<(), String> {
        let origin = if letter.is_ascii_lowercase() { self.at } else { [0.0; 2] };
        let kind = letter.to_ascii_uppercase();
        let place = |words: &mut Words<'_>| -> Result<PlaceMm, String> {
            Ok([origin[0] + words.number()?, origin[1] + words.number()?])
        };
        let before = self.handle.take();
        let mirrored = |pen: &Pen, kind: char| match before {
            Some((of, [x, y])) if of == kind => [2.0 * pen.at[0] - x, 2.0 * pen.at[1] - y],
            _ => pen.at,
        };
        match kind {
            'M' => {
                let to = place(words)?;
                self.lift(false);
                (self.at, self.start) = (to, to);
            }
            'Z' => {
                self.line_to(self.start);
                self.lift(true);
                self.at = self.start;
            }
            'L' => {
                let to = place(words)?;
                self.line_to(to);
            }
            'H' => self.line_to([origin[0] + words.number()?, self.at[1]]),
            'V' => self.line_to([self.at[0], origin[1] + words.number()?]),
            'C' => {
                let [a, b, to] = [place(words)?, place(words)?, place(words)?];
                self.curve(a, b, to);
            }
            'S' => {
                let a = mirrored(self, 'C');
                let [b, to] = [place(words)?, place(words)?];
                self.curve(a, b, to);
            }
            'Q' => {
                let [control, to] = [place(words)?, place(words)?];
                self.quadratic(control, to);
            }
            'T' => {
                let control = mirrored(self, 'Q');
                let to = place(words)?;
                self.quadratic(control, to);
            }
            _ => {
                let radii = [words.number()?, words.number()?];
                let turn = words.number()?.to_radians();
                let flags = [words.flag()?, words.flag()?];
                let to = place(words)?;
                match Arc::between(self.at, to, radii, turn, flags) {
                    Some(arc) => {
                        let mut pieces = arc.pieces();
                        // Rounding must not leave a gap.
                        if let Some(first) = pieces.first_mut() {
                            first[0] = self.at;
                        }
                        if let Some(last) = pieces.last_mut() {
                            last[3] = to;
                        }
                        self.pieces.extend(pieces);
                        self.at = to;
                    }
                    None => self.line_to(to),
                }
            }
        }
        Ok(())
    }

    fn line_to(&mut self, to: PlaceMm) {
        if to != self.at {
            self.pieces.push(straight(self.at, to));
            self.at = to;
        }
    }

    fn curve(&mut self, a: PlaceMm, b: PlaceMm, to: PlaceMm) {
        self.handle = Some(('C', b));
        self.push([self.at, a, b, to]);
    }

    fn quadratic(&mut self, control: PlaceMm, to: PlaceMm) {
        self.handle = Some(('Q', control));
        let towards = |from: PlaceMm| {
            std::array::from_fn(|axis| from[axis] + 2.0 / 3.0 * (control[axis] - from[axis]))
        };
        self.push([self.at, towards(self.at), towards(to), to]);
    }

    fn push(&mut self, piece: [PlaceMm; 4]) {
        if piece.iter().any(|place| *place != piece[0]) {
            self.pieces.push(piece);
        }
        self.at = piece[3];
    }
}

/// What of the data is left.
struct Words<'a> {
    rest: &'a str,
}

impl Words<'_> {
    fn skip(&mut self) {
        self.rest = self
            .rest
            .trim_start_matches(|letter: char| letter == ',' || letter.is_ascii_whitespace());
    }

    fn command(&mut self) -> Option<char> {
        let letter = self.rest.chars().next()?;
        if !"MmZzLlHhVvCcSsQqTtAa".contains(letter) {
            return None;
        }
        self.rest = &self.rest[1..];
        Some(letter)
    }

    fn flag(&mut self) -> Result<bool, String> {
        self.skip();
        let is_set = match self.rest.as_bytes().first() {
            Some(b'0') => false,
            Some(b'1') => true,
            _ => return Err(self.found()),
        };
        self.rest = &self.rest[1..];
        Ok(is_set)
    }

    /// The longest number that the rest begins with.
    fn number(&mut self) -> Result<f64, String> {
        self.skip();
        let bytes = self.rest.as_bytes();
        let mut end = usize::from(matches!(bytes.first(), Some(b'+' | b'-')));
        let digits = |mut end: usize| {
            while bytes.get(end).is_some_and(u8::is_ascii_digit) {
                end += 1;
            }
            end
        };
        end = digits(end);
        if bytes.get(end) == Some(&b'.') {
            end = digits(end + 1);
        }
        if matches!(bytes.get(end), Some(b'e' | b'E')) {
            let sign = end + 1 + usize::from(matches!(bytes.get(end + 1), Some(b'+' | b'-')));
            if bytes.get(sign).is_some_and(u8::is_ascii_digit) {
                end = digits(sign);
            }
        }
        let value = self.rest[..end].parse::<f64>().ok().filter(|value| value.is_finite());
        let value = value.ok_or_else(|| self.found())?;
        self.rest = &self.rest[end..];
        Ok(value)
    }

    /// The next letters, for a message.
    fn found(&self) -> String {
        match self.rest.is_empty() {
            true => "the end of the path".to_owned(),
            false => self.rest.chars().take(20).collect(),
        }
    }
}
