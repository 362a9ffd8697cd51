//! Bytes to elements.

use super::{Item, parse};

/// Longest element that counts, with its brackets.
pub const MAX_ELEMENT: usize = 256;

/// Bytes of a server, cut anywhere, to elements.
///
/// Every byte is in exactly one item, or waits for the end of its element, or is white space between elements.
#[derive(Clone, Debug, Default)]
pub struct Decoder {
    /// The element that has begun, from its bracket on; empty between elements.
    element: Vec<u8>,
    /// Bytes between elements that are no white space.
    stray: u64,
}

impl Decoder {
    /// A decoder that has received nothing.
    pub fn new() -> Decoder {
        Decoder::default()
    }

    /// Bytes that wait for the end of their element.
    pub fn pending(&self) -> u64 {
        self.element.len() as u64 + self.stray
    }

    /// Takes bytes off the front of `input` up to the next item, or all of them if none ends in them.
    #[must_use]
    pub fn decode(&mut self, input: &mut &[u8]) -> Option<Item> {
        while let Some((&byte, rest)) = input.split_first() {
            let begins = byte == b'<';
            // What stood before a bracket that opens is no element: the bracket waits for the next call.
            if begins && self.pending() > 0 {
                let bytes = self.pending();
                *self = Decoder::default();
                return Some(Item::Malformed { bytes });
            }
            *input = rest;
            if !begins && self.element.is_empty() {
                self.stray += u64::from(!byte.is_ascii_whitespace() || self.stray > 0);
                if self.stray as usize >= MAX_ELEMENT {
                    let bytes = std::mem::take(&mut self.stray);
                    return Some(Item::Malformed { bytes });
                }
                continue;
            }
            self.element.push(byte);
            if byte == b'>' {
                let element = std::mem::take(&mut self.element);
                return Some(parse(&element[1..element.len() - 1]));
            }
            if self.element.len() >= MAX_ELEMENT {
                let bytes = std::mem::take(&mut self.element).len() as u64;
                return Some(Item::Malformed { bytes });
            }
        }
        None
    }
}
