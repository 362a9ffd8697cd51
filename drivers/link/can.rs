//! CAN frames, classic and CAN FD.

use std::fmt;

use thiserror::Error;

mod record;

pub use record::{FD_RECORD_LEN, RECORD_LEN};

/// Data lengths by the length code of a frame, 0 to 15 (ISO 11898-1:2015, table 5). Codes above 8 occur in CAN FD alone.
pub const FD_LENGTHS: [usize; 16] = [0, 1, 2, 3, 4, 5, 6, 7, 8, 12, 16, 20, 24, 32, 48, 64];

/// Identifier of a CAN frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum CanId {
    /// 11 bits, 0 to 0x7FF.
    Standard(u16),
    /// 29 bits, 0 to 0x1FFF_FFFF.
    Extended(u32),
}

/// One CAN frame: classic (CAN 2.0 A or B) with 0 to 8 data bytes, or CAN FD with up to 64.
#[derive(Clone, Copy, PartialEq, Eq, Hash)]
pub struct CanFrame {
    id: CanId,
    format: Format,
    len: u8,
    data: [u8; 64],
}

/// Format of a frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
enum Format {
    Data,
    Remote,
    Flexible(FdFlags),
}

/// Flags of a CAN FD frame.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub struct FdFlags {
    /// BRS: the data went at the higher bit rate.
    pub bit_rate_switch: bool,
    /// ESI: the sender is error passive.
    pub error_passive: bool,
}

/// Why bytes are no CAN frame.
#[derive(Clone, Copy, Debug, Error, PartialEq, Eq)]
pub enum FrameError {
    /// The identifier does not fit its kind.
    #[error("identifier {0:#x} is out of range")]
    Id(u32),
    /// More data than a classic frame holds.
    #[error("{0} data bytes, expected at most 8")]
    Length(usize),
    /// Data of a length that no CAN FD frame has.
    #[error("{0} data bytes, expected 0 to 8, 12, 16, 20, 24, 32, 48 or 64")]
    FdLength(usize),
    /// A recorded frame of the wrong size.
    #[error("recorded frame of {0} bytes, expected {RECORD_LEN}, or {FD_RECORD_LEN} of CAN FD")]
    Record(usize),
}

impl CanFrame {
    /// A data frame. Fails when the identifier or the length is out of range.
    pub fn data_frame(id: CanId, data: &[u8]) -> Result<CanFrame, FrameError> {
        CanFrame::build(id, Format::Data, data.len(), data)
    }

    /// A remote frame asking for `len` bytes.
    pub fn remote_frame(id: CanId, len: usize) -> Result<CanFrame, FrameError> {
        CanFrame::build(id, Format::Remote, len, &[])
    }

    /// A CAN FD frame. Fails when the identifier is out of range, or the length none of [`FD_LENGTHS`].
    pub fn fd_frame(id: CanId, data: &[u8], flags: FdFlags) -> Result<CanFrame, FrameError> {
        CanFrame::build(id, Format::Flexible(flags), data.len(), data)
    }

    fn build(id: CanId, format: Format, len: usize, bytes: &[u8]) -> Result<CanFrame, FrameError> {
        match id {
            CanId::Standard(id) if id > 0x7FF => return Err(FrameError::Id(id.into())),
            CanId::Extended(id) if id > 0x1FFF_FFFF => return Err(FrameError::Id(id)),
            _ => {}
        }
        match format {
            Format::Data | Format::Remote if len > 8 => return Err(FrameError::Length(len)),
            Format::Flexible(_) if !FD_LENGTHS.contains(&len) => {
                return Err(FrameError::FdLength(len));
            }
            _ => {}
        }
        let mut data = [0; 64];
        data[..bytes.len()].copy_from_slice(bytes);
        Ok(CanFrame { id, format, len: len as u8, data })
    }

    /// The identifier.
    pub fn id(&self) -> CanId {
        self.id
    }

    /// Whether this is a remote frame, which carries no data.
    pub fn is_remote(&self) -> bool {
        self.format == Format::Remote
    }

    /// The flags of a CAN FD frame; `None` for a classic one.
    pub fn fd(&self) -> Option<FdFlags> {
        match self.format {
            Format::Flexible(flags) => Some(flags),
            Format::Data | Format::Remote => None,
        }
    }

    /// The data length code: 0 to 8, of a CAN FD frame to 15 (see [`FD_LENGTHS`]). A remote frame has one too.
    pub fn dlc(&self) -> usize {
        let len = usize::from(self.len);
        FD_LENGTHS.iter().position(|known| *known == len).unwrap_or(len)
    }

    /// The data; empty for a remote frame.
    pub fn data(&self) -> &[u8] {
        if self.is_remote() { &[] } else { &self.data[..usize::from(self.len)] }
    }
}

/// As `candump` writes it: `185#40E20100`, `1F334455#R`, `123##1112233`.
impl fmt::Debug for CanFrame {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.id {
            CanId::Standard(id) => write!(f, "{id:03X}#")?,
            CanId::Extended(id) => write!(f, "{id:08X}#")?,
        }
        match self.format {
            Format::Remote => return write!(f, "R{}", self.len),
            Format::Flexible(FdFlags { bit_rate_switch, error_passive }) => {
                write!(f, "#{:X}", u8::from(bit_rate_switch) | u8::from(error_passive) << 1)?;
            }
            Format::Data => {}
        }
        self.data().iter().try_for_each(|byte| write!(f, "{byte:02X}"))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn recorded_frame_has_the_layout_of_struct_can_frame() {
        let frame = CanFrame::data_frame(CanId::Standard(0x185), &[0x40, 0xE2, 1, 0]).unwrap();
        let record = frame.to_record();
        assert_eq!(record[..], [0x85, 1, 0, 0, 4, 0, 0, 0, 0x40, 0xE2, 1, 0, 0, 0, 0, 0]);
        assert_eq!(CanFrame::from_record(&record), Ok(frame));
        assert_eq!(format!("{frame:?}"), "185#40E20100");
    }

    #[test]
    fn remote_and_extended_frames_survive_a_recording() {
        let frame = CanFrame::remote_frame(CanId::Extended(0x1FFF_FFFF), 7).unwrap();
        assert_eq!(CanFrame::from_record(&frame.to_record()), Ok(frame));
        assert_eq!((frame.dlc(), frame.data()), (7, &[][..]));
    }

    #[test]
    fn out_of_range_is_refused() {
        assert_eq!(CanFrame::data_frame(CanId::Standard(0x800), &[]), Err(FrameError::Id(0x800)));
        assert_eq!(CanFrame::data_frame(CanId::Standard(1), &[0; 9]), Err(FrameError::Length(9)));
        assert_eq!(CanFrame::from_record(&[0; 3]), Err(FrameError::Record(3)));
        let mut long = [0; RECORD_LEN];
        long[4] = 9;
        assert_eq!(CanFrame::from_record(&long), Err(FrameError::Length(9)));
    }

    /// `struct canfd_frame` of `<linux/can.h>`: identifier, length, flags (1 BRS, 2 ESI, 4 FDF), two bytes of padding, 64 of data.
    #[test]
    fn recorded_fd_frame_has_the_layout_of_struct_canfd_frame() {
        let flags = FdFlags { bit_rate_switch: true, error_passive: false };
        let data: Vec<u8> = (1..=12).collect();
        let frame = CanFrame::fd_frame(CanId::Extended(0x1234_5678), &data, flags).unwrap();
        let record = frame.to_record();
        assert_eq!(record.len(), FD_RECORD_LEN);
        assert_eq!(record[..10], [0x78, 0x56, 0x34, 0x92, 12, 5, 0, 0, 1, 2]);
        assert_eq!(record[18..], [[11, 12].as_slice(), &[0; 52]].concat());
        assert_eq!(CanFrame::from_record(&record), Ok(frame));
        assert_eq!((frame.dlc(), frame.data().len(), frame.fd()), (9, 12, Some(flags)));
        assert_eq!(format!("{frame:?}"), "12345678##10102030405060708090A0B0C");
    }

    #[test]
    fn every_length_and_flag_survives_a_recording_and_others_are_refused() {
        for len in 0..=65 {
            for bits in 0..4 {
                let flags =
                    FdFlags { bit_rate_switch: bits & 1 != 0, error_passive: bits & 2 != 0 };
                let frame = CanFrame::fd_frame(CanId::Standard(7), &vec![0xA5; len], flags);
                match FD_LENGTHS.contains(&len) {
                    true => {
                        let frame = frame.unwrap();
                        assert_eq!(FD_LENGTHS[frame.dlc()], len);
                        assert_eq!(CanFrame::from_record(&frame.to_record()), Ok(frame));
                    }
                    false => assert_eq!(frame, Err(FrameError::FdLength(len))),
                }
            }
        }
    }

    #[test]
    fn records_one_after_the_other_are_told_apart() {
        let classic = CanFrame::data_frame(CanId::Standard(1), &[9; 8]).unwrap();
        let flexible =
            CanFrame::fd_frame(CanId::Standard(2), &[4; 64], FdFlags::default()).unwrap();
        let bytes = [classic, flexible, classic].map(|frame| frame.to_record()).concat();
        let (mut left, mut found) = (&bytes[..], Vec::new());
        while !left.is_empty() {
            let (record, after) = CanFrame::split_record(left);
            found.push(CanFrame::from_record(record).unwrap());
            left = after;
        }
        assert_eq!(found, [classic, flexible, classic]);
        // What is too short for its kind is one piece, and no frame.
        let (record, after) = CanFrame::split_record(&bytes[16..40]);
        assert_eq!((record.len(), after.len()), (24, 0));
        assert_eq!(CanFrame::from_record(record), Err(FrameError::Record(24)));
    }
}
