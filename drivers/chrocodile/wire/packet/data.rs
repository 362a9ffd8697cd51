//! Bodies of `DAT`: samples.

use thiserror::Error;

use super::{Kind, encode, pad, u32_at};

/// Bytes before the samples.
const FIXED_LEN: usize = 20;

/// Samples of one packet.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Data<'a> {
    /// The stream: 1 for measurements.
    pub stream: u32,
    /// Format counter of the samples.
    pub counter: i32,
    /// Time of the packet in s: 32 bits before and 32 behind the point.
    pub time: u64,
    /// How many samples there are.
    pub rows: usize,
    /// The samples, one after the other; up to three zeros may follow.
    pub samples: &'a [u8],
}

/// Why data cannot be read.
#[derive(Clone, Copy, Debug, Error, PartialEq, Eq)]
pub enum DataError {
    /// Fewer bytes than there are before the samples.
    #[error("data of {0} bytes, expected at least {FIXED_LEN}")]
    Short(usize),
    /// A negative number of samples.
    #[error("data of {0} samples")]
    Rows(i32),
    /// Bytes that do not fit the format.
    #[error("{rows} samples of {sample_len} bytes in {found} bytes")]
    Length {
        /// Samples as sent.
        rows: usize,
        /// Bytes of a sample by its format.
        sample_len: usize,
        /// Bytes that are there.
        found: usize,
    },
}

impl<'a> Data<'a> {
    /// Reads the body of a packet.
    ///
    /// # Errors
    ///
    /// Why it holds no data.
    pub fn decode(body: &'a [u8]) -> Result<Data<'a>, DataError> {
        let (fixed, samples) =
            body.split_at_checked(FIXED_LEN).ok_or(DataError::Short(body.len()))?;
        let rows = u32_at(fixed, 16).cast_signed();
        Ok(Data {
            stream: u32_at(fixed, 0),
            counter: u32_at(fixed, 4).cast_signed(),
            time: u64::from(u32_at(fixed, 8)) | u64::from(u32_at(fixed, 12)) << 32,
            rows: usize::try_from(rows).map_err(|_| DataError::Rows(rows))?,
            samples,
        })
    }

    /// Time of the packet in ns.
    pub fn time_ns(&self) -> u64 {
        ((u128::from(self.time) * 1_000_000_000) >> 32) as u64
    }

    /// The samples, each of `sample_len` bytes.
    ///
    /// # Errors
    ///
    /// When the bytes are not those of the samples and of up to three zeros behind them, or a sample has none.
    pub fn split(&self, sample_len: usize) -> Result<impl Iterator<Item = &'a [u8]>, DataError> {
        let found = self.samples.len();
        let len = self.rows.checked_mul(sample_len);
        let fits = |len: &usize| sample_len > 0 && len.checked_next_multiple_of(4) == Some(found);
        match len.filter(fits) {
            Some(len) => Ok(self.samples[..len].chunks_exact(sample_len)),
            None => Err(DataError::Length { rows: self.rows, sample_len, found }),
        }
    }

    /// Appends the packet. The caller keeps it within a packet's length.
    pub fn encode(&self, out: &mut Vec<u8>) {
        encode(Kind::Data, out, |out| {
            out.extend(self.stream.to_le_bytes());
            out.extend(self.counter.to_le_bytes());
            out.extend(self.time.to_le_bytes());
            out.extend((self.rows as u32).to_le_bytes());
            let start = out.len();
            out.extend(self.samples);
            pad(out, start);
        });
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::wire::packet::HEADER_LEN;

    #[test]
    fn samples_come_back_and_lengths_must_fit() {
        let mut bytes = Vec::new();
        let samples = &[1, 2, 3, 4, 5, 6];
        Data { stream: 1, counter: 9, time: 3 << 31, rows: 2, samples }.encode(&mut bytes);
        assert_eq!(bytes.len(), HEADER_LEN + FIXED_LEN + 8);
        let data = Data::decode(&bytes[HEADER_LEN..]).unwrap();
        assert_eq!((data.stream, data.counter, data.time_ns()), (1, 9, 1_500_000_000));
        let samples: Vec<&[u8]> = data.split(3).unwrap().collect();
        assert_eq!(samples, [[1, 2, 3], [4, 5, 6]]);
        // Four bytes a sample fill the eight bytes as well: the format decides, not the data.
        assert_eq!(data.split(4).unwrap().count(), 2);
        for sample_len in [0, 1, 2, 5, usize::MAX] {
            let error = data.split(sample_len).err().unwrap();
            assert_eq!(error, DataError::Length { rows: 2, sample_len, found: 8 });
        }
        assert_eq!(Data::decode(&bytes[HEADER_LEN..39]), Err(DataError::Short(19)));
        bytes[HEADER_LEN + 19] = 0x80;
        assert!(matches!(Data::decode(&bytes[HEADER_LEN..]), Err(DataError::Rows(_))));
    }
}
