//! Registers to numbers and back.

use crate::error::ValueError;
use crate::map::{Field, Kind, WordOrder};

/// The raw number in registers: before scale and offset. A not-a-number stays one.
///
/// Every kind but `f64` is exact; `f64` is the number itself.
///
/// # Panics
///
/// When there are not [`Kind::words`] registers.
pub fn decode(kind: Kind, order: WordOrder, words: &[u16]) -> f64 {
    match kind {
        Kind::U16 => f64::from(u16::from_be_bytes(bytes(order, words))),
        Kind::I16 => f64::from(i16::from_be_bytes(bytes(order, words))),
        Kind::U32 => f64::from(u32::from_be_bytes(bytes(order, words))),
        Kind::I32 => f64::from(i32::from_be_bytes(bytes(order, words))),
        Kind::F32 => f64::from(f32::from_be_bytes(bytes(order, words))),
        Kind::F64 => f64::from_be_bytes(bytes(order, words)),
        Kind::Bit(bit) => {
            let word = u16::from_be_bytes(bytes(order, words));
            f64::from(word >> (bit & 15) & 1)
        }
    }
}

/// The registers of a raw number, as a device would hold it. Whole numbers are rounded to the nearest.
///
/// A bit gives its register with all other bits clear.
///
/// # Errors
///
/// When the rounded number is out of the kind's range, or not finite and the kind is a whole number.
pub fn encode(kind: Kind, order: WordOrder, raw: f64) -> Result<Vec<u16>, ValueError> {
    let whole = |low: f64, high: f64| {
        let rounded = raw.round();
        if rounded >= low && rounded <= high {
            Ok(rounded as i64)
        } else {
            Err(ValueError { value: raw, kind })
        }
    };
    let big_endian: Vec<u8> = match kind {
        Kind::U16 => (whole(0.0, f64::from(u16::MAX))? as u16).to_be_bytes().to_vec(),
        Kind::I16 => {
            (whole(f64::from(i16::MIN), f64::from(i16::MAX))? as i16).to_be_bytes().to_vec()
        }
        Kind::U32 => (whole(0.0, f64::from(u32::MAX))? as u32).to_be_bytes().to_vec(),
        Kind::I32 => {
            (whole(f64::from(i32::MIN), f64::from(i32::MAX))? as i32).to_be_bytes().to_vec()
        }
        Kind::F32 => (raw as f32).to_be_bytes().to_vec(),
        Kind::F64 => raw.to_be_bytes().to_vec(),
        Kind::Bit(bit) => ((whole(0.0, 1.0)? as u16) << (bit & 15)).to_be_bytes().to_vec(),
    };
    let mut words: Vec<u16> =
        big_endian.chunks_exact(2).map(|pair| u16::from_be_bytes([pair[0], pair[1]])).collect();
    arrange(order, &mut words);
    Ok(words)
}

/// The value of a field in its unit: `raw · scale + offset`. Panics as [`decode`] does.
pub fn decode_field(field: &Field, words: &[u16]) -> f64 {
    decode(field.kind, field.word_order, words) * field.scale + field.offset
}

/// The registers in which a device shows `value`, in the field's unit. Fails as [`encode`] does.
pub fn encode_field(field: &Field, value: f64) -> Result<Vec<u16>, ValueError> {
    encode(field.kind, field.word_order, (value - field.offset) / field.scale)
}

/// CRC-16 of an RTU frame: polynomial A001h reflected, start FFFFh; sent low byte first.
///
/// MODBUS over Serial Line Specification V1.02, section 6.2.2.
pub(crate) fn crc16(bytes: &[u8]) -> u16 {
    bytes.iter().fold(0xFFFF, |crc, byte| {
        (0..8).fold(
            crc ^ u16::from(*byte),
            |crc, _| {
                if crc & 1 == 1 { crc >> 1 ^ 0xA001 } else { crc >> 1 }
            },
        )
    })
}

/// The bytes of a number, most significant first.
fn bytes<const B: usize>(order: WordOrder, words: &[u16]) -> [u8; B] {
    let mut sorted = [0; 4];
    let sorted = &mut sorted[..B / 2];
    sorted.copy_from_slice(words);
    arrange(order, sorted);
    let mut bytes = [0; B];
    for (pair, word) in bytes.chunks_exact_mut(2).zip(sorted) {
        pair.copy_from_slice(&word.to_be_bytes());
    }
    bytes
}

/// Turns registers of the given order into big-endian ones, or back: it is its own inverse.
fn arrange(order: WordOrder, words: &mut [u16]) {
    if matches!(order, WordOrder::Cdab | WordOrder::Dcba) {
        words.reverse();
    }
    if matches!(order, WordOrder::Badc | WordOrder::Dcba) {
        words.iter_mut().for_each(|word| *word = word.swap_bytes());
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;
    use proptest::test_runner::FileFailurePersistence;

    use super::*;

    /// Baumer OM20/OM30 manual, page 45: 202 = 7C37h, 203 = 428Bh is 69.743 mm.
    #[test]
    fn worked_example_of_the_om20_manual() {
        let mm = decode(Kind::F32, WordOrder::Cdab, &[0x7C37, 0x428B]);
        assert_eq!(format!("{mm:.3}"), "69.743");
        assert_eq!(encode(Kind::F32, WordOrder::Cdab, mm), Ok(vec![0x7C37, 0x428B]));
    }

    /// 1.0 is 3F80_0000h and 3FF0_0000_0000_0000h (IEEE 754-2019, section 3.4).
    #[test]
    fn every_word_order_finds_the_same_number() {
        for (order, words) in [
            (WordOrder::Abcd, [0x3F80, 0x0001]),
            (WordOrder::Cdab, [0x0001, 0x3F80]),
            (WordOrder::Badc, [0x803F, 0x0100]),
            (WordOrder::Dcba, [0x0100, 0x803F]),
        ] {
            assert_eq!(decode(Kind::F32, order, &words), f64::from(1.0 + f32::EPSILON));
            assert_eq!(decode(Kind::U32, order, &words), f64::from(0x3F80_0001_u32));
        }
        assert_eq!(decode(Kind::F64, WordOrder::Abcd, &[0x3FF0, 0, 0, 0]), 1.0);
        assert_eq!(decode(Kind::F64, WordOrder::Dcba, &[0, 0, 0, 0xF03F]), 1.0);
    }

    #[test]
    fn signs_and_bits() {
        assert_eq!(decode(Kind::I16, WordOrder::Abcd, &[0xFFFE]), -2.0);
        assert_eq!(decode(Kind::I16, WordOrder::Badc, &[0xFEFF]), -2.0);
        assert_eq!(decode(Kind::I32, WordOrder::Cdab, &[0xFFFE, 0xFFFF]), -2.0);
        assert_eq!(decode(Kind::Bit(1), WordOrder::Abcd, &[2]), 1.0);
        assert_eq!(decode(Kind::Bit(0), WordOrder::Abcd, &[2]), 0.0);
        assert_eq!(encode(Kind::Bit(15), WordOrder::Abcd, 1.0), Ok(vec![0x8000]));
    }

    #[test]
    fn what_does_not_fit_is_refused() {
        assert!(encode(Kind::U16, WordOrder::Abcd, 65536.0).is_err());
        assert!(encode(Kind::U32, WordOrder::Abcd, -1.0).is_err());
        assert!(encode(Kind::I16, WordOrder::Abcd, f64::NAN).is_err());
        assert!(encode(Kind::F32, WordOrder::Abcd, f64::NAN).is_ok());
    }

    /// Check value of CRC-16/MODBUS for "123456789" in the catalogue of parametrised CRC algorithms.
    #[test]
    fn crc_of_the_catalogue() {
        assert_eq!(crc16(b"123456789"), 0x4B37);
    }

    fn any_order() -> impl Strategy<Value = WordOrder> {
        prop_oneof![
            Just(WordOrder::Abcd),
            Just(WordOrder::Cdab),
            Just(WordOrder::Badc),
            Just(WordOrder::Dcba)
        ]
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_failure_persistence(FileFailurePersistence::WithSource(
            "regressions"
        )))]

        #[test]
        fn numbers_survive(order in any_order(), whole: i32, short: u16, single: f32, double: f64) {
            for (kind, raw) in [
                (Kind::I32, f64::from(whole)),
                (Kind::U32, f64::from(whole as u32)),
                (Kind::U16, f64::from(short)),
                (Kind::F32, f64::from(single)),
                (Kind::F64, double),
            ] {
                let words = encode(kind, order, raw).unwrap();
                prop_assert_eq!(words.len(), usize::from(kind.words()));
                prop_assert_eq!(decode(kind, order, &words).to_bits(), raw.to_bits());
            }
        }
    }
}
