//! Answers on the command port.

use thiserror::Error;

use super::{u16_at, u32_at};

/// Answer of a controller.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Answer<'a> {
    /// Command that it answers.
    pub command: u8,
    /// Error; 0: the command was carried out.
    pub error: u8,
    /// Content; empty after an error.
    pub content: &'a [u8],
}

/// Why bytes are no answer.
#[derive(Clone, Copy, Debug, Error, PartialEq, Eq)]
pub enum AnswerError {
    /// No answer to a question of ours has such a length.
    #[error("an answer of {0} bytes, expected {SHORTEST} to {LONGEST}: check address and series")]
    Length(u32),
}

/// Unit of a controller: itself, or a head.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Unit {
    /// Model: `LJ-X8080`.
    pub model: String,
    /// Serial number.
    pub serial: String,
}

/// Codes of the errors that a controller has.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct ErrorCodes(pub Vec<u16>);

impl<'a> Answer<'a> {
    /// Reads the answer at the beginning of `bytes`, and its length. `None`: more bytes are needed.
    ///
    /// # Errors
    ///
    /// A length that no answer has: the stream of answers is lost then.
    pub fn decode(bytes: &'a [u8]) -> Result<Option<(Answer<'a>, usize)>, AnswerError> {
        let Some(length) = u32_at(bytes, 0) else { return Ok(None) };
        if !(SHORTEST..=LONGEST).contains(&length) {
            return Err(AnswerError::Length(length));
        }
        let len = 4 + length as usize;
        let Some(whole) = bytes.get(..len) else { return Ok(None) };
        let content = whole.get(CONTENT..).unwrap_or_default();
        Ok(Some((Answer { command: whole[16], error: whole[17], content }, len)))
    }

    /// Bytes of the answer.
    pub fn encode(&self) -> Vec<u8> {
        let mut bytes = vec![0; CONTENT];
        bytes[16] = self.command;
        bytes[17] = self.error;
        bytes.extend(self.content);
        // Contents are far shorter than 2³² bytes.
        let length = (bytes.len() - 4) as u32;
        bytes[..4].copy_from_slice(&length.to_le_bytes());
        bytes[12..16].copy_from_slice(&(length - 12).to_le_bytes());
        bytes
    }
}

impl Unit {
    /// Units of the content of an answer to [`super::Request::Units`]: the controller, then its heads.
    ///
    /// ```text
    /// 0 how many (u8)   16 + 52 n: model (32 bytes), serial number (16 bytes), reserved
    /// ```
    pub fn decode_all(content: &[u8]) -> Vec<Unit> {
        let count = usize::from(content.first().copied().unwrap_or(0));
        let units = content.get(UNITS..).unwrap_or_default().chunks(UNIT).take(count);
        let text = |bytes: Option<&[u8]>| {
            let text = bytes.unwrap_or_default().split(|byte| *byte == 0).next();
            let text = String::from_utf8_lossy(text.unwrap_or_default()).into_owned();
            text.chars().filter(|sign| !sign.is_control()).collect()
        };
        units
            .map(|unit| Unit { model: text(unit.get(..MODEL)), serial: text(unit.get(MODEL..48)) })
            .collect()
    }

    /// Content of an answer with these units.
    pub fn encode_all(units: &[Unit]) -> Vec<u8> {
        let mut content = vec![0; UNITS + UNIT * units.len()];
        // A controller has two heads at most.
        content[0] = units.len() as u8;
        for (unit, place) in units.iter().zip(content[UNITS..].chunks_mut(UNIT)) {
            for (text, field) in [(&unit.model, 0..MODEL), (&unit.serial, MODEL..48)] {
                let field = &mut place[field];
                let len = text.len().min(field.len());
                field[..len].copy_from_slice(&text.as_bytes()[..len]);
            }
        }
        content
    }
}

impl ErrorCodes {
    /// Codes of the content of an answer to [`super::Request::Errors`]: 0 how many (u8), then from 4 a u16 each.
    pub fn decode(content: &[u8]) -> ErrorCodes {
        let count = usize::from(content.first().copied().unwrap_or(0));
        ErrorCodes((0..count).map_while(|index| u16_at(content, 4 + 2 * index)).collect())
    }

    /// Content of an answer with these codes.
    pub fn encode(&self) -> Vec<u8> {
        let mut content = vec![self.0.len() as u8, 0, 0, 0];
        content.extend(self.0.iter().flat_map(|code| code.to_le_bytes()));
        content
    }
}

/// Where the content begins.
const CONTENT: usize = 28;

/// Length of an answer that ends behind its error.
const SHORTEST: u32 = 14;

/// Length of an answer with one profile of the most points and luminances, and twice as much.
const LONGEST: u32 = 32_768;

/// Where the units begin in their answer, and the bytes of one and of its model.
const UNITS: usize = 16;
const UNIT: usize = 52;
const MODEL: usize = 32;
