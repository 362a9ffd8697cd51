//! Finds packets in the stream of one connection.
//!
//! A packet begins where the last one ended. Where no header stands there, bytes are passed over up to the next one.

use std::ops::Range;

use crate::wire::packet::{HEADER_LEN, Header, HeaderError, Kind, MAGIC};

/// Bytes received and not yet understood.
#[derive(Debug, Default)]
pub(super) struct Framing {
    buffer: Vec<u8>,
    /// Start of what is not yet understood.
    head: usize,
    /// Bytes passed over and not yet reported.
    discarded: u64,
    /// Why bytes were passed over first, since the last packet.
    trouble: Option<HeaderError>,
    troubled: bool,
}

/// A packet, which lies in the buffer until more bytes are received.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Packet {
    pub(super) kind: Kind,
    pub(super) body: Range<usize>,
}

impl Packet {
    /// Bytes of the whole packet.
    pub(super) fn len(&self) -> u64 {
        (HEADER_LEN + self.body.len()) as u64
    }
}

impl Framing {
    /// Adds bytes that follow those before.
    pub(super) fn receive(&mut self, bytes: &[u8]) {
        self.buffer.drain(..self.head);
        self.head = 0;
        self.buffer.extend_from_slice(bytes);
    }

    /// The next whole packet.
    pub(super) fn next(&mut self) -> Option<Packet> {
        loop {
            let waiting = &self.buffer[self.head..];
            match Header::decode(waiting)? {
                Ok(Header { len, kind }) => {
                    if waiting.len() < len {
                        return None;
                    }
                    let body = self.head + HEADER_LEN..self.head + len;
                    self.head += len;
                    self.troubled = false;
                    return Some(Packet { kind, body });
                }
                Err(error) => {
                    if !std::mem::replace(&mut self.troubled, true) {
                        self.trouble = Some(error);
                    }
                    let len = passed_over(waiting);
                    self.head += len;
                    self.discarded += len as u64;
                }
            }
        }
    }

    /// Body of a packet that [`Framing::next`] gave since bytes were received.
    pub(super) fn body(&self, packet: &Packet) -> &[u8] {
        &self.buffer[packet.body.clone()]
    }

    /// Drops all bytes that wait; they count as passed over.
    pub(super) fn abandon(&mut self) {
        self.discarded += (self.buffer.len() - self.head) as u64;
        self.head = self.buffer.len();
    }

    /// Counts the bytes of a packet that was of no use.
    pub(super) fn refuse(&mut self, packet: &Packet) {
        self.discarded += packet.len();
    }

    /// Bytes passed over since the last call.
    pub(super) fn take_discarded(&mut self) -> u64 {
        std::mem::take(&mut self.discarded)
    }

    /// Why bytes were passed over, once for each gap between packets.
    pub(super) fn take_trouble(&mut self) -> Option<HeaderError> {
        self.trouble.take()
    }
}

/// Bytes before the next place where a packet may begin, at least one: before four bytes that begin one, or a beginning of
/// them at the end.
fn passed_over(bytes: &[u8]) -> usize {
    let magic = MAGIC.to_le_bytes();
    let begins = |at: usize| {
        let len = magic.len().min(bytes.len() - at);
        bytes[at..at + len] == magic[..len]
    };
    (1..bytes.len()).find(|&at| begins(at)).unwrap_or(bytes.len())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::wire::packet::encode;

    fn packet(body: &[u8]) -> Vec<u8> {
        let mut bytes = Vec::new();
        encode(Kind::Data, &mut bytes, |out| out.extend(body));
        bytes
    }

    /// Bodies, and bytes passed over, of bytes that come so many at a time.
    fn bodies(bytes: &[u8], at_a_time: usize) -> (Vec<Vec<u8>>, u64) {
        let mut framing = Framing::default();
        let mut bodies = Vec::new();
        for bytes in bytes.chunks(at_a_time) {
            framing.receive(bytes);
            while let Some(packet) = framing.next() {
                bodies.push(framing.body(&packet).to_vec());
            }
        }
        framing.abandon();
        (bodies, framing.take_discarded())
    }

    #[test]
    fn packets_are_found_however_bytes_are_cut() {
        let mut bytes = packet(b"one1");
        bytes.extend([0x55, 0xAA, 0x55, 0x55, 0xAA, 0x55, 0xAA, 1]);
        bytes.extend(packet(b""));
        bytes.extend(packet(b"two2two2"));
        bytes.extend([0x55, 0xAA]);
        let whole = (vec![b"one1".to_vec(), Vec::new(), b"two2two2".to_vec()], 10);
        for at_a_time in [1, 2, 3, 7, 30, 1000] {
            assert_eq!(bodies(&bytes, at_a_time), whole, "{at_a_time} at a time");
        }
    }

    #[test]
    fn why_bytes_were_passed_over_is_said_once_a_gap() {
        let mut framing = Framing::default();
        framing.receive(&[0; 50]);
        assert_eq!(framing.next(), None);
        assert_eq!(framing.take_trouble(), Some(HeaderError::Magic(0)));
        framing.receive(&[0; 50]);
        assert_eq!(framing.next(), None);
        assert_eq!(framing.take_trouble(), None);
        framing.receive(&packet(b"abcd"));
        assert!(framing.next().is_some());
        framing.receive(&[1; 50]);
        assert_eq!(framing.next(), None);
        assert_eq!(framing.take_trouble(), Some(HeaderError::Magic(0x0101_0101)));
    }
}
