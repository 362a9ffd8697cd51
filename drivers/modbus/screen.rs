//! Cuts the received stream into frames and lets only the answer to the question through.
//!
//! The library never sees a byte that is not part of a whole frame addressed to the call under way,
//! so nothing stale can end or poison a call.

use crate::settings::Transport;
use crate::wire::crc16;

/// How the answer to a request is to be known.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Question {
    pub(crate) unit_id: u8,
    pub(crate) function: u8,
    /// Bytes of data a positive answer carries.
    pub(crate) byte_count: u8,
    /// Modbus TCP only.
    pub(crate) transaction: u16,
}

/// The frame boundaries of a Modbus TCP stream are lost.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct OutOfStep {
    pub(crate) protocol: u16,
    pub(crate) len: u16,
}

/// The received bytes that are not yet judged.
#[derive(Debug)]
pub(crate) struct Screen {
    transport: Transport,
    buffer: Vec<u8>,
    passed_over: u64,
    stranger: Option<u8>,
}

impl Screen {
    pub(crate) fn new(transport: Transport) -> Screen {
        Screen { transport, buffer: Vec::new(), passed_over: 0, stranger: None }
    }

    /// A new question: what strangers said before does not count.
    pub(crate) fn forget_stranger(&mut self) {
        self.stranger = None;
    }

    /// Adds received bytes.
    pub(crate) fn push(&mut self, bytes: &[u8]) {
        self.buffer.extend_from_slice(bytes);
    }

    /// Passes over everything there is.
    pub(crate) fn clear(&mut self) {
        self.drop_front(self.buffer.len());
    }

    /// Counts bytes of a frame already taken as passed over.
    pub(crate) fn pass_over(&mut self, bytes: usize) {
        self.passed_over += bytes as u64;
    }

    /// How many bytes were passed over since the last call.
    pub(crate) fn take_passed_over(&mut self) -> u64 {
        std::mem::take(&mut self.passed_over)
    }

    /// The frame that answers the question, if it is there whole; what cannot belong to it is passed
    /// over. Without a question all whole frames (RTU: all bytes) are passed over.
    ///
    /// # Errors
    ///
    /// When a Modbus TCP stream has no frame where one must begin.
    pub(crate) fn take(
        &mut self,
        question: Option<&Question>,
    ) -> Result<Option<Vec<u8>>, OutOfStep> {
        match (self.transport, question) {
            (Transport::Tcp, _) => self.take_tcp(question),
            (Transport::Rtu, Some(question)) => Ok(self.take_rtu(question)),
            (Transport::Rtu, None) => {
                self.clear();
                Ok(None)
            }
        }
    }

    /// MODBUS Messaging on TCP/IP Implementation Guide V1.0b, section 3.1.3: transaction (2), protocol
    /// = 0 (2), length of the rest (2), unit (1), then function and data.
    fn take_tcp(&mut self, question: Option<&Question>) -> Result<Option<Vec<u8>>, OutOfStep> {
        loop {
            let Some((header, _)) = self.buffer.split_first_chunk::<MBAP_LEN>() else {
                return Ok(None);
            };
            let [t1, t0, p1, p0, l1, l0, unit_id] = *header;
            let (protocol, len) = (u16::from_be_bytes([p1, p0]), u16::from_be_bytes([l1, l0]));
            // The unit, a function code and at least one byte; a PDU is at most 253 bytes (V1.1b3,
            // section 4.1).
            if protocol != 0 || !(3..=254).contains(&len) {
                self.clear();
                return Err(OutOfStep { protocol, len });
            }
            let whole = MBAP_LEN - 1 + usize::from(len);
            if self.buffer.len() < whole {
                return Ok(None);
            }
            if let Some(question) = question
                && u16::from_be_bytes([t1, t0]) == question.transaction
            {
                if unit_id == question.unit_id {
                    return Ok(Some(self.buffer.drain(..whole).collect()));
                }
                self.stranger = Some(unit_id);
            }
            self.drop_front(whole);
        }
    }

    /// Of all whole frames with the right unit, function, length and CRC, the one that ends first.
    /// Noise in front, an echo of the request or another unit's frame is passed over.
    fn take_rtu(&mut self, question: &Question) -> Option<Vec<u8>> {
        let mut answer: Option<(usize, usize)> = None;
        for start in 0..self.buffer.len() {
            let Some(len) = question.rtu_len(&self.buffer[start..]) else { continue };
            let end = start + len;
            let earlier = answer.is_none_or(|(_, best)| end < best);
            if earlier && end <= self.buffer.len() && crc_holds(&self.buffer[start..end]) {
                answer = Some((start, end));
            }
        }
        let Some((start, end)) = answer else {
            // The window is longer than any frame, so no answer under way is cut.
            self.drop_front(self.buffer.len().saturating_sub(RTU_WINDOW));
            return None;
        };
        self.drop_front(start);
        Some(self.buffer.drain(..end - start).collect())
    }

    /// A unit that answered a read though it was not asked.
    pub(crate) fn stranger(&self, question: &Question) -> Option<u8> {
        match self.transport {
            Transport::Tcp => self.stranger,
            Transport::Rtu => (0..self.buffer.len()).find_map(|start| {
                let bytes = &self.buffer[start..];
                let [unit_id, function, count, ..] = *bytes else { return None };
                let len = match function {
                    1..=4 => RTU_MIN_LEN + usize::from(count),
                    0x81..=0x84 => RTU_MIN_LEN,
                    _ => return None,
                };
                let frame = bytes.get(..len)?;
                (unit_id != question.unit_id && crc_holds(frame)).then_some(unit_id)
            }),
        }
    }

    fn drop_front(&mut self, len: usize) {
        self.passed_over += len as u64;
        self.buffer.drain(..len);
    }
}

impl Question {
    /// How long a frame that starts here and answers the question is, if it can be one.
    ///
    /// Serial Line Specification V1.02, section 2.5.1: unit (1), function and data, CRC (2).
    fn rtu_len(&self, bytes: &[u8]) -> Option<usize> {
        let [unit_id, function, next, ..] = *bytes else { return None };
        if unit_id != self.unit_id {
            None
        } else if function == self.function | 0x80 {
            Some(RTU_MIN_LEN)
        } else if function == self.function && next == self.byte_count {
            Some(RTU_MIN_LEN + usize::from(next))
        } else {
            None
        }
    }
}

/// Over a frame with its CRC appended, low byte first, the CRC is zero.
fn crc_holds(frame: &[u8]) -> bool {
    crc16(frame) == 0
}

/// Bytes of a Modbus TCP header with the unit identifier.
const MBAP_LEN: usize = 7;
/// Unit, function, one byte (exception code or byte count) and CRC.
const RTU_MIN_LEN: usize = 5;
/// Received bytes looked at while waiting for an RTU answer: twice the longest frame (256 bytes,
/// Serial Line Specification V1.02, section 2.5.1).
const RTU_WINDOW: usize = 512;
