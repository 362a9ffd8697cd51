//! Requests and answers (RF602 user's manual 1.2.0, pages 11 to 17; Acuity AR100-50 manual, page 22).
//!
//! ```text
//! request:  0 A6 … A0 | 1 0 0 0 C3 … C0                     address, code; the only byte without its highest bit
//! answer:   1 SB C1 C0 D3 … D0 | 1 SB C1 C0 D7 … D4 | …      each byte in two halves, the lower one first
//! ```
//!
//! `SB` says that the result is a new one. `C` counts answers and is the same in all bytes of one: this tells where
//! the next answer begins, and that answers were lost.

use std::ops::RangeInclusive;

/// What a sensor is asked.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Request {
    /// Type, firmware, serial number, base distance and range: 8 bytes.
    Identify,
    /// The present result: 2 bytes.
    Result,
    /// Results of 2 bytes again and again, until something is asked.
    StartStream,
    /// No more results. There is no answer.
    StopStream,
}

impl Request {
    /// Code of the request.
    pub const fn code(self) -> u8 {
        match self {
            Request::Identify => 0x01,
            Request::Result => 0x06,
            Request::StartStream => 0x07,
            Request::StopStream => 0x08,
        }
    }

    /// Request of a code.
    pub fn from_code(code: u8) -> Option<Request> {
        let all = [Request::Identify, Request::Result, Request::StartStream, Request::StopStream];
        all.into_iter().find(|request| request.code() == code)
    }

    /// Bytes of the request to a sensor of this address, of which the lowest 7 bits are sent.
    pub const fn encode(self, address: u8) -> [u8; 2] {
        [address & 0x7F, 0x80 | self.code()]
    }
}

/// Addresses of a sensor; 0 is that of all.
pub const ADDRESSES: RangeInclusive<u8> = 1..=127;

/// Longest answer in bytes.
pub const LONGEST: usize = 8;

/// Result at the end of the measuring range.
pub const FULL_RANGE: u16 = 0x4000;

/// Finds requests in bytes that are cut anywhere.
#[derive(Clone, Copy, Debug, Default)]
pub struct RequestDecoder {
    /// Address of a request whose code has not come.
    address: Option<u8>,
}

impl RequestDecoder {
    /// Takes one byte. The address and the request, if it is the last of one that is known.
    pub fn push(&mut self, byte: u8) -> Option<(u8, Request)> {
        if byte & 0x80 == 0 {
            self.address = Some(byte);
            return None;
        }
        let address = self.address.take()?;
        // The upper half of every further byte is 1000.
        let code = (byte & 0x70 == 0).then_some(byte & 0x0F)?;
        Request::from_code(code).map(|request| (address, request))
    }
}

/// Result of a distance in mm from the start of a measuring range in mm: the nearest one, 0 to [`FULL_RANGE`].
pub fn result_of(mm: f64, range_mm: u16) -> u16 {
    // Equation 1 of the RF602 manual, page 15, the other way round.
    let result = mm * f64::from(FULL_RANGE) / f64::from(range_mm);
    result.round().clamp(0.0, f64::from(FULL_RANGE)) as u16
}

/// One answer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Answer {
    /// Whether the sensor measured anew since the last answer.
    pub is_new: bool,
    /// Number of the answer, 0 to 3.
    pub count: u8,
    /// Answers that were lost before it, as far as the counter tells: 0 to 3.
    pub lost: u8,
    /// Whether no bytes of anything else came since the answer before it, or since the question. Four bytes of noise may
    /// look like an answer.
    pub is_clean: bool,
    bytes: [u8; LONGEST],
    len: usize,
}

impl Identity {
    /// Content of the answer that says it.
    pub fn encode(&self) -> [u8; LONGEST] {
        let Identity { device_type, firmware, serial, base_mm, range_mm } = *self;
        let [serial_low, serial_high] = serial.to_le_bytes();
        let [base_low, base_high] = base_mm.to_le_bytes();
        let [range_low, range_high] = range_mm.to_le_bytes();
        let numbers = [serial_low, serial_high, base_low, base_high, range_low, range_high];
        let mut content = [device_type, firmware, 0, 0, 0, 0, 0, 0];
        content[2..].copy_from_slice(&numbers);
        content
    }
}

impl Answer {
    /// Its bytes.
    pub fn bytes(&self) -> &[u8] {
        &self.bytes[..self.len]
    }

    /// Its result, if it is one.
    pub fn result(&self) -> Option<u16> {
        let bytes: [u8; 2] = self.bytes().try_into().ok()?;
        Some(u16::from_le_bytes(bytes))
    }

    /// Who the sensor is, if the answer says that.
    pub fn identity(&self) -> Option<Identity> {
        let [
            device_type,
            firmware,
            serial_low,
            serial_high,
            base_low,
            base_high,
            range_low,
            range_high,
        ] = self.bytes().try_into().ok()?;
        let serial = u16::from_le_bytes([serial_low, serial_high]);
        let base_mm = u16::from_le_bytes([base_low, base_high]);
        let range_mm = u16::from_le_bytes([range_low, range_high]);
        Some(Identity { device_type, firmware, serial, base_mm, range_mm })
    }
}

/// Who a sensor is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Identity {
    /// Number of the type.
    pub device_type: u8,
    /// Number of the firmware.
    pub firmware: u8,
    /// Serial number.
    pub serial: u16,
    /// Distance from the sensor to the start of its range, in mm.
    pub base_mm: u16,
    /// Measuring range in mm.
    pub range_mm: u16,
}

/// Finds answers in bytes that are cut anywhere.
#[derive(Clone, Debug)]
pub struct Decoder {
    /// Bytes of an answer, 1 to [`LONGEST`].
    len: usize,
    /// Upper half of the bytes of the answer that comes in, or of the one before.
    head: u8,
    /// Halves so far; all of them: the answer was given.
    halves: usize,
    bytes: [u8; LONGEST],
    /// Number of the last whole answer.
    last: Option<u8>,
    /// The answer is longer than expected.
    is_overlong: bool,
    /// Bytes were passed over since the last answer.
    is_disturbed: bool,
    discarded: u64,
}

impl Decoder {
    /// A decoder of answers of so many bytes, at most [`LONGEST`].
    pub fn new(len: usize) -> Decoder {
        let len = len.clamp(1, LONGEST);
        // An upper half that no byte of an answer has.
        Decoder {
            len,
            head: 0,
            halves: 0,
            bytes: [0; LONGEST],
            last: None,
            is_overlong: false,
            is_disturbed: false,
            discarded: 0,
        }
    }

    /// Takes one byte. An answer, if it is the last of one.
    pub fn push(&mut self, byte: u8) -> Option<Answer> {
        let (head, half) = (byte & 0xF0, byte & 0x0F);
        if byte & 0x80 == 0 {
            // A request of somebody, or a damaged byte: the answer is no longer whole.
            self.give_up();
            self.pass_over(1);
            return None;
        }
        if head != self.head {
            self.give_up();
            self.head = head;
        } else if self.halves == 2 * self.len {
            self.pass_over(1);
            self.is_overlong = true;
            return None;
        }
        let byte = &mut self.bytes[self.halves / 2];
        *byte = if self.halves.is_multiple_of(2) { half } else { *byte | half << 4 };
        self.halves += 1;
        (self.halves == 2 * self.len).then(|| self.answer())
    }

    fn answer(&mut self) -> Answer {
        let count = self.head >> 4 & 3;
        let step = self.last.map_or(1, |last| count.wrapping_sub(last) & 3);
        self.last = Some(count);
        Answer {
            is_new: self.head & 0x40 != 0,
            count,
            // The same number as before: a whole round is missing.
            lost: step.wrapping_sub(1) & 3,
            is_clean: !std::mem::take(&mut self.is_disturbed),
            bytes: self.bytes,
            len: self.len,
        }
    }

    /// Forgets an answer that is not whole; its bytes are passed over.
    fn give_up(&mut self) {
        if self.halves < 2 * self.len {
            self.pass_over(self.halves as u64);
        }
        (self.head, self.halves) = (0, 0);
    }

    fn pass_over(&mut self, bytes: u64) {
        self.discarded += bytes;
        self.is_disturbed |= bytes > 0;
    }

    /// Forgets all, the number of the last answer too: answers of so many bytes come next.
    pub fn reset(&mut self, len: usize) {
        self.give_up();
        let discarded = self.discarded;
        *self = Decoder { discarded, ..Decoder::new(len) };
    }

    /// Whether an answer was longer than expected, since the last call.
    pub fn take_overlong(&mut self) -> bool {
        std::mem::take(&mut self.is_overlong)
    }

    /// Bytes of no answer since the last call.
    pub fn take_discarded(&mut self) -> u64 {
        std::mem::take(&mut self.discarded)
    }
}

/// Bytes of an answer with this number, of which the lowest 2 bits are sent.
pub fn encode_answer(is_new: bool, count: u8, bytes: &[u8]) -> Vec<u8> {
    let head = 0x80 | u8::from(is_new) << 6 | (count & 3) << 4;
    bytes.iter().flat_map(|byte| [head | byte & 0x0F, head | byte >> 4]).collect()
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    fn all(len: usize, bytes: &[u8]) -> (Vec<Answer>, u64) {
        let mut decoder = Decoder::new(len);
        let answers = bytes.iter().filter_map(|byte| decoder.push(*byte)).collect();
        decoder.reset(len);
        (answers, decoder.take_discarded())
    }

    fn results(bytes: &[u8]) -> Vec<u16> {
        all(2, bytes).0.iter().map(|answer| answer.result().unwrap()).collect()
    }

    /// Results with a counter, as a sensor sends them.
    fn stream(results: &[u16]) -> Vec<Vec<u8>> {
        let answer =
            |(n, result): (usize, &u16)| encode_answer(true, n as u8, &result.to_le_bytes());
        results.iter().enumerate().map(answer).collect()
    }

    /// Whichever byte is lost or damaged so that its highest bit is gone, only its answer is lost, and it is counted.
    #[test]
    fn a_lost_byte_costs_its_answer() {
        let sent = [1u16, 700, 16_000, 5];
        let bytes = stream(&sent).concat();
        for lost in 0..bytes.len() {
            let rest = [&bytes[..lost], &bytes[lost + 1..]].concat();
            let damaged = [&bytes[..lost], &[bytes[lost] & 0x7F], &bytes[lost + 1..]].concat();
            for (bytes, discarded) in [(rest, 3), (damaged, 4)] {
                let (answers, passed) = all(2, &bytes);
                let expected: Vec<u16> = sent
                    .iter()
                    .enumerate()
                    .filter(|(n, _)| *n != lost / 4)
                    .map(|(_, r)| *r)
                    .collect();
                let found: Vec<u16> =
                    answers.iter().map(|answer| answer.result().unwrap()).collect();
                assert_eq!((found, passed), (expected, discarded), "byte {lost}");
                let between = (1..3).contains(&(lost / 4));
                let missed: u8 = answers.iter().map(|answer| answer.lost).sum();
                assert_eq!(missed, u8::from(between), "byte {lost}");
            }
        }
    }

    /// Requests of the RF602 manual, page 16 and 17, cut anywhere, with the answer of another sensor between.
    #[test]
    fn requests_are_found() {
        let mut decoder = RequestDecoder::default();
        let bytes = [0x86, 0x01, 0x81, 0xF5, 0x01, 0x86, 0x03, 0xC6, 0x01, 0x01, 0x87];
        let found: Vec<_> = bytes.into_iter().filter_map(|byte| decoder.push(byte)).collect();
        let expected = [Request::Identify, Request::Result, Request::StartStream];
        assert_eq!(found, expected.map(|request| (1, request)));
    }

    /// The result that the RF602 manual prints, page 17: 677 is 2.066 mm of 50 mm.
    #[test]
    fn results_of_distances() {
        assert_eq!(result_of(2.066, 50), 677);
        assert_eq!([-1.0, 0.0, 50.0, 51.0].map(|mm| result_of(mm, 50)), [0, 0, 16_384, 16_384]);
    }

    #[test]
    fn a_longer_answer_is_found_out() {
        let mut decoder = Decoder::new(2);
        let bytes = encode_answer(true, 1, &[1, 2, 3]);
        assert_eq!(bytes.iter().filter_map(|byte| decoder.push(*byte)).count(), 1);
        assert_eq!((decoder.take_overlong(), decoder.take_discarded()), (true, 2));
    }

    proptest! {
        /// Requests and text between answers change none: only answers have the highest bit.
        #[test]
        fn bytes_without_the_highest_bit_are_passed_over(
            pieces in proptest::collection::vec((0u16..=FULL_RANGE, proptest::collection::vec(0u8..0x80, 0..20)), 0..20),
        ) {
            let sent: Vec<u16> = pieces.iter().map(|(result, _)| *result).collect();
            let mut bytes = Vec::new();
            for ((_, garbage), answer) in pieces.iter().zip(stream(&sent)) {
                bytes.extend(garbage);
                bytes.extend(answer);
            }
            let garbage: usize = pieces.iter().map(|(_, garbage)| garbage.len()).sum();
            let (answers, discarded) = all(2, &bytes);
            prop_assert_eq!(results(&bytes), sent);
            prop_assert_eq!(discarded, garbage as u64);
            prop_assert!(answers.iter().all(|answer| answer.lost == 0));
        }

        #[test]
        fn bytes_are_answers_or_passed_over(bytes: Vec<u8>, len in 1usize..=LONGEST) {
            let (answers, discarded) = all(len, &bytes);
            prop_assert_eq!((answers.len() * 2 * len) as u64 + discarded, bytes.len() as u64);
        }
    }
}
