//! The way to the shelf and back: what goes there is summed, and what comes back must have that sum.

use super::shelf::{Part, Shelf, ShelfError, ShelfFailure};

/// The shelf, and the bytes on their way.
pub(super) struct Desk<S> {
    pub(super) shelf: S,
    /// Those of one chunk.
    pub(super) bytes: Vec<u8>,
    pub(super) written_chunks: u64,
    pub(super) read_chunks: u64,
    pub(super) failed_puts: u64,
    pub(super) last_failure: Option<ShelfFailure>,
}

impl<S: Shelf> Desk<S> {
    pub(super) fn new(shelf: S, chunk_bytes: usize) -> Desk<S> {
        Desk {
            shelf,
            bytes: vec![0; chunk_bytes],
            written_chunks: 0,
            read_chunks: 0,
            failed_puts: 0,
            last_failure: None,
        }
    }

    /// Puts the bytes on the shelf; returns their checksum, `None` if the shelf failed.
    pub(super) fn put(&mut self, part: Part, chunk: usize) -> Option<u64> {
        match self.shelf.put(part.number(chunk), &self.bytes) {
            Ok(()) => {
                self.written_chunks += 1;
                Some(checksum(&self.bytes))
            }
            Err(failure) => {
                self.failed_puts += 1;
                self.last_failure = Some(failure);
                None
            }
        }
    }

    /// Fetches the bytes from the shelf.
    pub(super) fn get(
        &mut self,
        part: Part,
        chunk: usize,
        expected: u64,
    ) -> Result<(), ShelfError> {
        let number = part.number(chunk);
        if let Err(source) = self.shelf.get(number, &mut self.bytes) {
            return Err(ShelfError::Read { chunk: number, part, source });
        }
        self.read_chunks += 1;
        let found = checksum(&self.bytes);
        if found == expected {
            Ok(())
        } else {
            Err(ShelfError::Damaged { chunk: number, part, expected, found })
        }
    }
}

/// A checksum of 64 bits against damage, not against intent.
///
/// Every eight bytes, little-endian and the last filled up with zeros, are added modulo 2 to the sum so
/// far, which is then multiplied by an odd number and shifted onto itself. Each step can be undone,
/// so bytes that differ in one group of eight always differ in their sums, and others do but for one
/// case in 2⁶⁴.
fn checksum(bytes: &[u8]) -> u64 {
    let mut sum = bytes.len() as u64;
    for group in bytes.chunks(8) {
        let mut word = [0; 8];
        word[..group.len()].copy_from_slice(group);
        // The fractional part of the golden ratio in 64 bits.
        sum = (sum ^ u64::from_le_bytes(word)).wrapping_mul(0x9e37_79b9_7f4a_7c15);
        sum ^= sum >> 32;
    }
    sum
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_bit_and_every_order_counts() {
        let bytes: Vec<u8> = (0..61).map(|i| (i * 37 % 251) as u8).collect();
        let sum = checksum(&bytes);
        for bit in 0..8 * bytes.len() {
            let mut damaged = bytes.clone();
            damaged[bit / 8] ^= 1 << (bit % 8);
            assert_ne!(checksum(&damaged), sum, "bit {bit}");
        }
        let mut turned = bytes.clone();
        turned.rotate_left(8);
        assert_ne!(checksum(&turned), sum);
        assert_ne!(checksum(&bytes[..60]), sum);
        assert_ne!(checksum(&[0; 8]), checksum(&[0; 16]));
    }

    /// By hand: (0 ^ 8) is what the length makes of one group that equals it.
    #[test]
    fn a_sum_by_hand() {
        assert_eq!(checksum(&8_u64.to_le_bytes()), 0);
        // 8 ^ 9 = 1, times the number, and its upper half onto its lower.
        let expected = 0x9e37_79b9_7f4a_7c15_u64 ^ 0x9e37_79b9;
        assert_eq!(checksum(&9_u64.to_le_bytes()), expected);
    }
}
