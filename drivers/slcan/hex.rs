//! Hexadecimal digits.

/// Value of each byte as a hexadecimal digit, [`NONE`] for the others.
const VALUES: [u8; 256] = {
    let mut values = [NONE; 256];
    let mut digit = 0;
    while digit < 10 {
        values[b'0' as usize + digit] = digit as u8;
        digit += 1;
    }
    let mut digit = 0;
    while digit < 6 {
        values[b'A' as usize + digit] = 10 + digit as u8;
        values[b'a' as usize + digit] = 10 + digit as u8;
        digit += 1;
    }
    values
};

const NONE: u8 = 0xFF;
const DIGITS: [u8; 16] = *b"0123456789ABCDEF";

/// The number of up to eight digits, or nothing if one of them is no digit.
pub(crate) fn number(digits: &[u8]) -> Option<u32> {
    debug_assert!(digits.len() <= 8, "a u32 has eight digits");
    let mut bad = 0;
    let mut number = 0;
    for &digit in digits {
        let value = VALUES[usize::from(digit)];
        bad |= value;
        number = number << 4 | u32::from(value & 0xF);
    }
    (bad & 0xF0 == 0).then_some(number)
}

/// Fills `bytes` from twice as many digits, or says that one of them is no digit.
pub(crate) fn bytes(digits: &[u8], bytes: &mut [u8]) -> bool {
    debug_assert_eq!(digits.len(), 2 * bytes.len());
    let mut bad = 0;
    for (byte, pair) in bytes.iter_mut().zip(digits.chunks_exact(2)) {
        let high = VALUES[usize::from(pair[0])];
        let low = VALUES[usize::from(pair[1])];
        bad |= high | low;
        *byte = high << 4 | low & 0xF;
    }
    bad & 0xF0 == 0
}

/// Appends the lowest `count` digits of `number`, in upper case.
pub(crate) fn push(out: &mut Vec<u8>, number: u32, count: u32) {
    for place in (0..count).rev() {
        out.push(DIGITS[(number >> (4 * place) & 0xF) as usize]);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_byte_is_judged_as_the_standard_library_does() {
        for byte in 0..=255_u8 {
            let expected = char::from(byte).to_digit(16);
            assert_eq!(number(&[byte]), expected, "byte {byte:#04x}");
            let mut one = [0];
            assert_eq!(bytes(&[b'0', byte], &mut one), expected.is_some());
        }
    }

    #[test]
    fn numbers_keep_their_leading_zeros() {
        let mut out = Vec::new();
        push(&mut out, 0xA5, 4);
        assert_eq!(out, b"00A5");
        assert_eq!(number(&out), Some(0xA5));
    }
}
