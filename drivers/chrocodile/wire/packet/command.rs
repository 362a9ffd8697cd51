//! Bodies of `CMD`: commands, their answers and updates.

use std::fmt;

use super::{Kind, encode, pad, u16_at, u32_at};

/// Bytes before the arguments.
const FIXED_LEN: usize = 20;

/// Name of a command: up to four letters, filled with zeros.
#[derive(Clone, Copy, PartialEq, Eq)]
pub struct Name([u8; 4]);

impl Name {
    /// The name of a command.
    ///
    /// # Panics
    ///
    /// When it has more than four letters.
    pub const fn new(letters: &str) -> Name {
        let (mut name, mut at) = ([0; 4], 0);
        while at < letters.len() {
            name[at] = letters.as_bytes()[at];
            at += 1;
        }
        Name(name)
    }

    /// The code as it is sent.
    pub const fn code(self) -> u32 {
        u32::from_le_bytes(self.0)
    }
}

impl fmt::Display for Name {
    /// Its letters; bytes that are none as hexadecimal.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let text = self.0.into_iter().take_while(|&byte| byte != 0);
        write!(
            f,
            "{}",
            text.flat_map(std::ascii::escape_default).map(char::from).collect::<String>()
        )
    }
}

impl fmt::Debug for Name {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        fmt::Display::fmt(self, f)
    }
}

bitflags::bitflags! {
    /// Flags of a command or an answer.
    #[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
    pub struct CommandFlags: u16 {
        /// It asks, or answers a question.
        const QUERY = 0x0001;
        /// The device tells of a change that this host did not order. Its ticket is 0.
        const UPDATE = 0x2000;
        /// The device did it, with a warning.
        const WARNING = 0x4000;
        /// The device did not do it.
        const ERROR = 0x8000;
    }
}

/// Argument of a command or an answer.
#[derive(Clone, Debug, PartialEq)]
pub enum Argument {
    /// Kind 0.
    Int(i32),
    /// Kind 1.
    Float(f32),
    /// Kind 2; the bytes as sent, meant to be text.
    Text(Vec<u8>),
    /// Kind 4.
    Blob(Vec<u8>),
}

impl Argument {
    /// The number it is; `None` for text and bytes.
    pub fn number(&self) -> Option<f64> {
        match self {
            Argument::Int(value) => Some(f64::from(*value)),
            Argument::Float(value) => Some(f64::from(*value)),
            Argument::Text(_) | Argument::Blob(_) => None,
        }
    }

    /// Reads the argument at the start of `bytes`, and its length.
    fn decode(bytes: &[u8]) -> Option<(Argument, usize)> {
        let head = bytes.get(..8)?;
        let word = u32_at(head, 4);
        let counted = || {
            let len = usize::try_from(word).ok()?;
            let content = bytes.get(8..8_usize.checked_add(len)?)?;
            let end = 8 + len.next_multiple_of(4);
            (end <= bytes.len()).then(|| (content.to_vec(), end))
        };
        match u32_at(head, 0) {
            0 => Some((Argument::Int(word.cast_signed()), 8)),
            1 => Some((Argument::Float(f32::from_bits(word)), 8)),
            2 => counted().map(|(text, end)| (Argument::Text(text), end)),
            4 => counted().map(|(blob, end)| (Argument::Blob(blob), end)),
            _ => None,
        }
    }

    fn encode(&self, out: &mut Vec<u8>) {
        let (kind, content): (u32, &[u8]) = match self {
            Argument::Int(value) => {
                out.extend(0_u32.to_le_bytes());
                out.extend(value.to_le_bytes());
                return;
            }
            Argument::Float(value) => {
                out.extend(1_u32.to_le_bytes());
                out.extend(value.to_le_bytes());
                return;
            }
            Argument::Text(text) => (2, text),
            Argument::Blob(blob) => (4, blob),
        };
        out.extend(kind.to_le_bytes());
        out.extend((content.len() as u32).to_le_bytes());
        let start = out.len();
        out.extend(content);
        pad(out, start);
    }
}

impl fmt::Display for Argument {
    /// A number, text in quotation marks with its signs escaped, or the length of bytes.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Argument::Int(value) => write!(f, "{value}"),
            Argument::Float(value) => write!(f, "{value}"),
            Argument::Text(text) => {
                let end = text.iter().rposition(|&byte| byte != 0).map_or(0, |last| last + 1);
                write!(f, "{:?}", String::from_utf8_lossy(&text[..end]))
            }
            Argument::Blob(blob) => write!(f, "{} bytes", blob.len()),
        }
    }
}

/// A command, an answer or an update.
#[derive(Clone, Debug, PartialEq)]
pub struct Message {
    /// The command.
    pub name: Name,
    /// Filter of the destination; 0 from a host.
    pub destination: u32,
    /// Filter of the source; 0 from a host.
    pub source: u32,
    /// What it is.
    pub flags: CommandFlags,
    /// Number that the answer repeats; 0 for updates.
    pub ticket: u16,
    /// Arguments.
    pub arguments: Vec<Argument>,
}

impl Message {
    /// A command of a host.
    pub fn command(name: Name, ticket: u16, arguments: Vec<Argument>) -> Message {
        let flags = CommandFlags::empty();
        Message { name, destination: 0, source: 0, flags, ticket, arguments }
    }

    /// A question of a host.
    pub fn query(name: Name, ticket: u16) -> Message {
        Message { flags: CommandFlags::QUERY, ..Message::command(name, ticket, Vec::new()) }
    }

    /// Reads the body of a packet; `None` where it is no message.
    ///
    /// An argument of an undocumented kind ends the list: nobody knows its length.
    pub fn decode(body: &[u8]) -> Option<Message> {
        let (fixed, mut rest) = body.split_at_checked(FIXED_LEN)?;
        let mut arguments = Vec::new();
        for _ in 0..u16_at(fixed, 18) {
            let Some((argument, len)) = Argument::decode(rest) else { break };
            arguments.push(argument);
            rest = &rest[len..];
        }
        Some(Message {
            name: Name(u32_at(fixed, 0).to_le_bytes()),
            destination: u32_at(fixed, 4),
            source: u32_at(fixed, 8),
            flags: CommandFlags::from_bits_retain(u16_at(fixed, 12)),
            ticket: u16_at(fixed, 16),
            arguments,
        })
    }

    /// Appends the packet. The caller keeps the arguments short enough for one.
    pub fn encode(&self, out: &mut Vec<u8>) {
        encode(Kind::Command, out, |out| {
            for word in [self.name.code(), self.destination, self.source] {
                out.extend(word.to_le_bytes());
            }
            let arguments = self.arguments.len() as u16;
            for half in [self.flags.bits(), 0, self.ticket, arguments] {
                out.extend(half.to_le_bytes());
            }
            self.arguments.iter().for_each(|argument| argument.encode(out));
        });
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::wire::packet::HEADER_LEN;

    /// Codes of `chr_cmd_id.py` in the maker's library, version 5.1.
    #[test]
    fn names_have_the_codes_of_the_maker() {
        for (name, code) in [
            ("SODX", 0x5844_4F53),
            ("STA", 0x0041_5453),
            ("STO", 0x004F_5453),
            ("SHZ", 0x005A_4853),
            ("AVD", 0x0044_5641),
            ("SCA", 0x0041_4353),
        ] {
            assert_eq!(Name::new(name).code(), code, "{name}");
            assert_eq!(Name::new(name).to_string(), name);
        }
        assert_eq!(Name([0x1B, b'A', 0, 0]).to_string(), "\\x1bA");
    }

    #[test]
    fn arguments_of_every_kind_are_read_back() {
        let arguments = vec![
            Argument::Int(-5),
            Argument::Text(b"abcde".to_vec()),
            Argument::Float(1.5),
            Argument::Blob(vec![1, 2, 3, 4]),
            Argument::Text(Vec::new()),
        ];
        let message = Message::command(Name::new("SODX"), 300, arguments);
        let mut bytes = Vec::new();
        message.encode(&mut bytes);
        assert_eq!(bytes.len() % 4, 0);
        assert_eq!(Message::decode(&bytes[HEADER_LEN..]), Some(message.clone()));
        // Cut anywhere there is no panic, and no argument that the bytes do not hold.
        for len in HEADER_LEN..bytes.len() {
            let cut = Message::decode(&bytes[HEADER_LEN..len]);
            assert_eq!(cut.is_some(), len >= 2 * HEADER_LEN);
            let arguments = cut.map_or(0, |cut| cut.arguments.len());
            assert!(arguments < message.arguments.len());
        }
    }

    #[test]
    fn an_argument_of_an_unknown_kind_ends_the_list() {
        let message = Message::command(Name::new("SCA"), 1, vec![Argument::Int(1); 3]);
        let mut bytes = Vec::new();
        message.encode(&mut bytes);
        bytes[2 * HEADER_LEN + 8] = 3;
        let read = Message::decode(&bytes[HEADER_LEN..]).unwrap();
        assert_eq!(read.arguments, [Argument::Int(1)]);
        let huge = [&[4, 0, 0, 0][..], &[0xFF; 4], &[0; 8]].concat();
        assert_eq!(Argument::decode(&huge), None);
    }
}
