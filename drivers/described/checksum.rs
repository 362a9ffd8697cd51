//! What guards a frame.

use crc::{CRC_8_SMBUS, CRC_16_IBM_3740, CRC_16_MODBUS, CRC_16_XMODEM, CRC_32_ISO_HDLC, Crc};

use crate::number::ByteOrder;

/// Check at the end of each frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Checksum {
    /// How it is worked out.
    pub algorithm: Algorithm,
    /// How it is written.
    pub digits: Digits,
    /// Bytes at the beginning of the frame that it does not cover, 0 to 64.
    pub skip_first: usize,
    /// Bytes between those it covers and itself, 0 to 64: 1 for the `*` of NMEA 0183.
    pub skip_last: usize,
}

/// How a check is worked out.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Algorithm {
    /// Sum of the bytes, modulo 256.
    Sum8,
    /// All bytes joined by exclusive or: NMEA 0183.
    Xor8,
    /// Two's complement of the sum: with it the sum of all is 0. Modbus ASCII, Zaber.
    Lrc8,
    /// CRC-8/SMBUS of the catalogue of CRC algorithms.
    Crc8Smbus,
    /// CRC-16/MODBUS.
    Crc16Modbus,
    /// CRC-16/XMODEM.
    Crc16Xmodem,
    /// CRC-16/IBM-3740, often called CCITT-FALSE.
    Crc16Ibm3740,
    /// CRC-32/ISO-HDLC, that of Ethernet and zip.
    Crc32IsoHdlc,
}

/// How a check is written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Digits {
    /// As bytes.
    Binary(ByteOrder),
    /// As hexadecimal digits, the highest first; read in either case, written in capitals.
    Hex,
}

const SMBUS: Crc<u8> = Crc::<u8>::new(&CRC_8_SMBUS);
const MODBUS: Crc<u16> = Crc::<u16>::new(&CRC_16_MODBUS);
const XMODEM: Crc<u16> = Crc::<u16>::new(&CRC_16_XMODEM);
const IBM_3740: Crc<u16> = Crc::<u16>::new(&CRC_16_IBM_3740);
const ISO_HDLC: Crc<u32> = Crc::<u32>::new(&CRC_32_ISO_HDLC);

impl Algorithm {
    /// Every algorithm with its word in a configuration.
    pub const ALL: [(&'static str, Algorithm); 8] = [
        ("sum8", Algorithm::Sum8),
        ("xor8", Algorithm::Xor8),
        ("lrc8", Algorithm::Lrc8),
        ("crc8-smbus", Algorithm::Crc8Smbus),
        ("crc16-modbus", Algorithm::Crc16Modbus),
        ("crc16-xmodem", Algorithm::Crc16Xmodem),
        ("crc16-ibm-3740", Algorithm::Crc16Ibm3740),
        ("crc32-iso-hdlc", Algorithm::Crc32IsoHdlc),
    ];

    /// Its word in a configuration.
    pub fn word(self) -> &'static str {
        Algorithm::ALL.iter().find(|(_, known)| *known == self).map_or("", |(word, _)| word)
    }

    /// Bytes of its value.
    pub fn width(self) -> usize {
        match self {
            Algorithm::Sum8 | Algorithm::Xor8 | Algorithm::Lrc8 | Algorithm::Crc8Smbus => 1,
            Algorithm::Crc16Modbus | Algorithm::Crc16Xmodem | Algorithm::Crc16Ibm3740 => 2,
            Algorithm::Crc32IsoHdlc => 4,
        }
    }

    /// Its value for these bytes.
    pub fn value(self, bytes: &[u8]) -> u32 {
        let sum = || bytes.iter().fold(0u8, |sum, byte| sum.wrapping_add(*byte));
        match self {
            Algorithm::Sum8 => sum().into(),
            Algorithm::Xor8 => bytes.iter().fold(0, |all, byte| all ^ byte).into(),
            Algorithm::Lrc8 => sum().wrapping_neg().into(),
            Algorithm::Crc8Smbus => SMBUS.checksum(bytes).into(),
            Algorithm::Crc16Modbus => MODBUS.checksum(bytes).into(),
            Algorithm::Crc16Xmodem => XMODEM.checksum(bytes).into(),
            Algorithm::Crc16Ibm3740 => IBM_3740.checksum(bytes).into(),
            Algorithm::Crc32IsoHdlc => ISO_HDLC.checksum(bytes),
        }
    }
}

impl Checksum {
    /// Bytes it takes at the end of a frame.
    pub fn bytes(&self) -> usize {
        match self.digits {
            Digits::Binary(_) => self.algorithm.width(),
            Digits::Hex => 2 * self.algorithm.width(),
        }
    }

    /// Bytes of a frame before [`Checksum::skip_last`], if its check is right.
    pub fn body<'a>(&self, frame: &'a [u8]) -> Option<&'a [u8]> {
        let (rest, check) = frame.split_at_checked(frame.len().checked_sub(self.bytes())?)?;
        let (body, _) = rest.split_at_checked(rest.len().checked_sub(self.skip_last)?)?;
        let value = self.algorithm.value(body.get(self.skip_first..)?);
        check.eq_ignore_ascii_case(&self.written(value)).then_some(body)
    }

    /// The check of a frame that so far has all bytes before it, [`Checksum::skip_last`] among them. `None`: the
    /// frame is shorter than the bytes left out.
    pub fn compute(&self, frame: &[u8]) -> Option<Vec<u8>> {
        let body = frame.get(self.skip_first..frame.len().checked_sub(self.skip_last)?)?;
        Some(self.written(self.algorithm.value(body)))
    }

    fn written(&self, value: u32) -> Vec<u8> {
        let width = self.algorithm.width();
        let big = &value.to_be_bytes()[4 - width..];
        match self.digits {
            Digits::Binary(ByteOrder::Big) => big.to_vec(),
            Digits::Binary(ByteOrder::Little) => big.iter().rev().copied().collect(),
            Digits::Hex => format!("{value:0digits$X}", digits = 2 * width).into_bytes(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn hex(algorithm: Algorithm, skip_first: usize, skip_last: usize) -> Checksum {
        Checksum { algorithm, digits: Digits::Hex, skip_first, skip_last }
    }

    /// The check values of the catalogue: each algorithm over "123456789".
    #[test]
    fn catalogued_check_values() {
        let value = |algorithm: Algorithm| algorithm.value(b"123456789");
        assert_eq!(value(Algorithm::Crc8Smbus), 0xF4);
        assert_eq!(value(Algorithm::Crc16Modbus), 0x4B37);
        assert_eq!(value(Algorithm::Crc16Xmodem), 0x31C3);
        assert_eq!(value(Algorithm::Crc16Ibm3740), 0x29B1);
        assert_eq!(value(Algorithm::Crc32IsoHdlc), 0xCBF4_3926);
    }

    /// Zaber ASCII: "01 tools echo" has 8F (test vector of zproto 0.4.2).
    #[test]
    fn lrc_of_zaber() {
        assert_eq!(hex(Algorithm::Lrc8, 0, 0).compute(b"01 tools echo"), Some(b"8F".to_vec()));
        let framed = hex(Algorithm::Lrc8, 1, 1);
        assert_eq!(framed.body(b"/01 tools echo:8F"), Some(&b"/01 tools echo"[..]));
        assert_eq!(framed.body(b"/01 tools echo:8E"), None);
    }

    /// NMEA 0183: the sentence that receivers' manuals show.
    #[test]
    fn xor_of_nmea() {
        let sentence =
            b"$GPGGA,123519,4807.038,N,01131.000,E,1,08,0.9,545.4,M,46.9,M,,*47".as_slice();
        let check = hex(Algorithm::Xor8, 1, 1);
        assert_eq!(check.body(sentence), Some(&sentence[..sentence.len() - 3]));
        assert_eq!(check.body(&[&sentence[..10], b"9", &sentence[11..]].concat()), None);
    }

    /// The rule of TMCL: the ninth byte is the sum of the first eight.
    #[test]
    fn sum_of_tmcl() {
        let check = Checksum {
            algorithm: Algorithm::Sum8,
            digits: Digits::Binary(ByteOrder::Big),
            skip_first: 0,
            skip_last: 0,
        };
        let frame = [1, 1, 0, 0, 0, 0, 1, 0x5E, 0x61];
        assert_eq!(check.body(&frame), Some(&frame[..8]));
        assert_eq!(check.compute(&frame[..8]), Some(vec![0x61]));
    }

    #[test]
    fn short_frames_have_no_check() {
        let check = hex(Algorithm::Crc16Modbus, 2, 1);
        for len in 0..7 {
            assert_eq!(check.body(&b"0000000"[..len]), None, "{len}");
        }
        assert_eq!(check.compute(b"0"), None);
    }

    #[test]
    fn both_orders_of_bytes() {
        let check = |order| Checksum {
            algorithm: Algorithm::Crc16Modbus,
            digits: Digits::Binary(order),
            skip_first: 0,
            skip_last: 0,
        };
        assert_eq!(check(ByteOrder::Big).compute(b"123456789"), Some(vec![0x4B, 0x37]));
        assert_eq!(check(ByteOrder::Little).compute(b"123456789"), Some(vec![0x37, 0x4B]));
    }
}
