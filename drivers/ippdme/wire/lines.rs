//! Lines in a stream of bytes.

use thiserror::Error;

/// Most characters of a line, without its end.
pub const MAX_LINE: usize = 65_536;

/// Cuts a stream into lines.
#[derive(Clone, Debug, Default)]
pub struct Framer {
    line: Vec<u8>,
    /// The byte before was CR.
    is_ending: bool,
}

/// Why bytes are no line. None of them can be trusted, nor what follows.
#[derive(Clone, Copy, Debug, Error, PartialEq, Eq)]
pub enum LineError {
    /// A byte that no line may have.
    #[error("byte {0:#04x} in a line: expected bytes 32 to 126 and CR LF at its end")]
    Byte(u8),
    /// No end in sight.
    #[error("a line of more than {MAX_LINE} characters")]
    Length,
}

impl Framer {
    /// Takes a byte. Gives the line that it ends, without CR LF.
    ///
    /// # Errors
    ///
    /// When the line cannot become one.
    pub fn push(&mut self, byte: u8) -> Result<Option<Vec<u8>>, LineError> {
        match byte {
            b'\n' if self.is_ending => {
                self.is_ending = false;
                Ok(Some(std::mem::take(&mut self.line)))
            }
            b'\r' if !self.is_ending => {
                self.is_ending = true;
                Ok(None)
            }
            32..=126 if !self.is_ending => {
                if self.line.len() == MAX_LINE {
                    return Err(LineError::Length);
                }
                self.line.push(byte);
                Ok(None)
            }
            other => Err(LineError::Byte(other)),
        }
    }

    /// Forgets the begin of a line. Gives how many bytes it had.
    pub fn reset(&mut self) -> u64 {
        let bytes = self.line.len() as u64 + u64::from(self.is_ending);
        *self = Framer::default();
        bytes
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn lines(bytes: &[u8]) -> Result<Vec<String>, LineError> {
        let mut framer = Framer::default();
        let mut lines = Vec::new();
        for &byte in bytes {
            if let Some(line) = framer.push(byte)? {
                lines.push(String::from_utf8(line).expect("ASCII"));
            }
        }
        Ok(lines)
    }

    #[test]
    fn only_cr_lf_ends_a_line() {
        assert_eq!(lines(b"00001 &\r\n00001 %\r\n").unwrap(), ["00001 &", "00001 %"]);
        assert_eq!(lines(b"00001 &\n"), Err(LineError::Byte(b'\n')));
        assert_eq!(lines(b"00001 &\r00001"), Err(LineError::Byte(b'0')));
        assert_eq!(lines(b"00001 &\r\r\n"), Err(LineError::Byte(b'\r')));
        assert_eq!(lines(b"00001 \t"), Err(LineError::Byte(b'\t')));
        assert_eq!(lines(b"00001 \x7f"), Err(LineError::Byte(0x7f)));
    }

    #[test]
    fn the_longest_line_is_taken_and_no_longer_one() {
        let longest = [vec![b'1'; MAX_LINE], b"\r\n".to_vec()].concat();
        assert_eq!(lines(&longest).unwrap()[0].len(), MAX_LINE);
        assert_eq!(lines(&vec![b'1'; MAX_LINE + 1]), Err(LineError::Length));
    }
}
