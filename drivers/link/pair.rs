//! Bytes of a link with two connections, as it hands them on and as a recording holds them.

use crate::Input;

/// Connection of a link that has two.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Connection {
    /// The first one: what is sent goes there.
    First,
    /// The second one, which is only read.
    Second,
}

impl Connection {
    /// Chunk of what was read from the connection at once: the number of the connection, 0 or 1, then the bytes.
    pub fn chunk(self, bytes: &[u8]) -> Vec<u8> {
        let number = match self {
            Connection::First => FIRST,
            Connection::Second => SECOND,
        };
        let mut chunk = Vec::with_capacity(bytes.len() + 1);
        chunk.push(number);
        chunk.extend_from_slice(bytes);
        chunk
    }
}

impl<'a> Input<'a> {
    /// Content of a [`Connection::chunk`]; `None` for bytes that are no such chunk.
    pub fn of_chunk(chunk: &'a [u8]) -> Option<Input<'a>> {
        match chunk {
            [FIRST, bytes @ ..] => Some(Input::Bytes(bytes)),
            [SECOND, bytes @ ..] => Some(Input::Second(bytes)),
            _ => None,
        }
    }
}

const FIRST: u8 = 0;
const SECOND: u8 = 1;

#[cfg(test)]
mod tests {
    use super::*;

    /// The numbers are part of the format of recordings.
    #[test]
    fn a_chunk_names_its_connection() {
        assert_eq!(Connection::First.chunk(b"ab"), b"\x00ab");
        assert_eq!(Connection::Second.chunk(b""), b"\x01");
        assert!(matches!(Input::of_chunk(b"\x00ab"), Some(Input::Bytes(b"ab"))));
        assert!(matches!(Input::of_chunk(b"\x01\x00"), Some(Input::Second(b"\x00"))));
        assert!(Input::of_chunk(b"\x02ab").is_none() && Input::of_chunk(b"").is_none());
    }
}
