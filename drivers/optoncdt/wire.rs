//! Words of the stream.
//!
//! Three bytes carry 18 bits and whether the word is the first of its block (ILD1420 manual, page 84):
//!
//! ```text
//! L: 0 0 D5  D4  D3  D2  D1  D0
//! M: 0 1 D11 D10 D9  D8  D7  D6
//! H: 1 b D17 D16 D15 D14 D13 D12      b = 0: first word of a block; 1: a further one
//! ```
//!
//! Two bytes carry 14 bits (ILD1402, ILD1700): `H: 1 D13 … D7`, `L: 0 D6 … D0`, the high byte first.
//!
//! Each byte says which of its word it is, so a lost byte costs its word and no more.

/// How many bytes a word has.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Width {
    /// 14 bits in two bytes.
    Two,
    /// 18 bits in three bytes.
    Three,
}

/// One word.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Word {
    /// 14 or 18 bits.
    pub value: u32,
    /// Whether it is the first of its block. Words of two bytes always are.
    pub is_first: bool,
}

/// Largest value of a word of three bytes.
pub const MAX_18: u32 = 0x3_FFFF;

/// A step of the time stamp: ILD1420 manual, page 66.
pub const TICK_NS: u64 = 10_000;

/// Finds words in bytes that are cut anywhere.
#[derive(Clone, Debug)]
pub struct Decoder {
    width: Width,
    /// Bits of the word so far.
    value: u32,
    /// Bytes of it so far.
    taken: u8,
    discarded: u64,
}

impl Decoder {
    /// A decoder of words of this width, at no word yet.
    pub fn new(width: Width) -> Decoder {
        Decoder { width, value: 0, taken: 0, discarded: 0 }
    }

    /// Takes one byte. A word, if it is the last of one.
    pub fn push(&mut self, byte: u8) -> Option<Word> {
        match self.width {
            Width::Three => self.push_three(byte),
            Width::Two => self.push_two(byte),
        }
    }

    fn push_three(&mut self, byte: u8) -> Option<Word> {
        let bits = u32::from(byte & 0x3F);
        match (byte >> 6, self.taken) {
            (0, taken) => {
                self.discarded += u64::from(taken);
                (self.value, self.taken) = (bits, 1);
                None
            }
            (1, 1) => {
                (self.value, self.taken) = (self.value | bits << 6, 2);
                None
            }
            (high @ 2.., 2) => {
                self.taken = 0;
                Some(Word { value: self.value | bits << 12, is_first: high == 2 })
            }
            (_, taken) => {
                self.discarded += u64::from(taken) + 1;
                self.taken = 0;
                None
            }
        }
    }

    fn push_two(&mut self, byte: u8) -> Option<Word> {
        let bits = u32::from(byte & 0x7F);
        match (byte >> 7, self.taken) {
            (1, taken) => {
                self.discarded += u64::from(taken);
                (self.value, self.taken) = (bits << 7, 1);
                None
            }
            (_, 1) => {
                self.taken = 0;
                Some(Word { value: self.value | bits, is_first: true })
            }
            _ => {
                self.discarded += 1;
                None
            }
        }
    }

    /// Forgets a word that is not whole; its bytes are passed over.
    pub fn reset(&mut self) {
        self.discarded += u64::from(std::mem::take(&mut self.taken));
    }

    /// Bytes of no word since the last call.
    pub fn take_discarded(&mut self) -> u64 {
        std::mem::take(&mut self.discarded)
    }
}

/// Bytes of a word of three bytes; bits above the 18th are left out.
pub fn encode_three(word: Word) -> [u8; 3] {
    let bits = |shift: u32| (word.value >> shift & 0x3F) as u8;
    let further = if word.is_first { 0 } else { 0x40 };
    [bits(0), 0x40 | bits(6), 0x80 | further | bits(12)]
}

/// Bytes of a word of two bytes; bits above the 14th are left out.
pub fn encode_two(value: u32) -> [u8; 2] {
    [0x80 | (value >> 7 & 0x7F) as u8, (value & 0x7F) as u8]
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    fn all(width: Width, bytes: &[u8]) -> (Vec<Word>, u64) {
        let mut decoder = Decoder::new(width);
        let words = bytes.iter().filter_map(|byte| decoder.push(*byte)).collect();
        decoder.reset();
        (words, decoder.take_discarded())
    }

    /// 32760 in the bit table of the manual: 111 111111 111000.
    #[test]
    fn three_bytes_as_the_table_draws_them() {
        let word = Word { value: 32_760, is_first: true };
        assert_eq!(all(Width::Three, &[0b0011_1000, 0b0111_1111, 0b1000_0111]), (vec![word], 0));
        let further = Word { value: MAX_18, is_first: false };
        assert_eq!(all(Width::Three, &[0x3F, 0x7F, 0xFF]), (vec![further], 0));
        assert_eq!(encode_three(further), [0x3F, 0x7F, 0xFF]);
    }

    /// 8184 in the bit table of the ILD1402: 0111111 1111000.
    #[test]
    fn two_bytes_as_the_table_draws_them() {
        let word = Word { value: 8184, is_first: true };
        assert_eq!(all(Width::Two, &[0b1011_1111, 0b0111_1000]), (vec![word], 0));
        assert_eq!(encode_two(8184), [0b1011_1111, 0b0111_1000]);
    }

    /// Whichever byte is lost, only its word is.
    #[test]
    fn a_lost_byte_costs_its_word() {
        let words = [1u32, 70_000, 200_000].map(|value| Word { value, is_first: true });
        let bytes: Vec<u8> = words.iter().flat_map(|word| encode_three(*word)).collect();
        for lost in 0..bytes.len() {
            let rest = [&bytes[..lost], &bytes[lost + 1..]].concat();
            let expected: Vec<Word> =
                words.iter().enumerate().filter(|(i, _)| *i != lost / 3).map(|(_, w)| *w).collect();
            assert_eq!(all(Width::Three, &rest), (expected, 2), "{lost}");
        }
    }

    proptest! {
        /// Text of an answer between two words changes none.
        #[test]
        fn text_between_words_is_passed_over(text in "[ -~\r\n]{0,40}", value in 0..=MAX_18) {
            let word = Word { value, is_first: true };
            let bytes = [&encode_three(word)[..], text.as_bytes(), &encode_three(word)].concat();
            let (words, discarded) = all(Width::Three, &bytes);
            prop_assert_eq!(words, vec![word, word]);
            prop_assert_eq!(discarded, text.len() as u64);
        }

        #[test]
        fn bytes_are_words_or_passed_over(bytes: Vec<u8>) {
            for (width, len) in [(Width::Two, 2), (Width::Three, 3)] {
                let (words, discarded) = all(width, &bytes);
                prop_assert_eq!(words.len() as u64 * len + discarded, bytes.len() as u64);
            }
        }
    }
}
