//! What a device answers to a request.

use asphera_modbus::{Block, Function};

use crate::image::Image;

/// The answer to a read, or an exception: MODBUS Application Protocol Specification V1.1b3, sections
/// 6.1 to 6.4 and 7.
pub(crate) fn answer(image: &Image, pdu: &[u8]) -> Vec<u8> {
    let Some(&code) = pdu.first() else { return Vec::new() };
    let function = match code {
        1 => Function::ReadCoils,
        2 => Function::ReadDiscrete,
        3 => Function::ReadHolding,
        4 => Function::ReadInput,
        _ => return exception(code, ILLEGAL_FUNCTION),
    };
    let [_, a1, a0, n1, n0] = *pdu else {
        return exception(code, ILLEGAL_DATA_VALUE);
    };
    let (address, len) = (u16::from_be_bytes([a1, a0]), u16::from_be_bytes([n1, n0]));
    if !(1..=function.max_len()).contains(&len) {
        return exception(code, ILLEGAL_DATA_VALUE);
    }
    let block = Block { function, address, len };
    match image.read(block) {
        Some(words) if !image.cuts_block(block) => {
            let bytes = if function.reads_bits() { pack(&words) } else { be_bytes(&words) };
            let mut answer = vec![code, bytes.len() as u8];
            answer.extend(bytes);
            answer
        }
        _ => exception(code, ILLEGAL_DATA_ADDRESS),
    }
}

/// An exception to a request of this function.
pub(crate) fn exception(function: u8, code: u8) -> Vec<u8> {
    vec![function | 0x80, code]
}

fn be_bytes(words: &[u16]) -> Vec<u8> {
    words.iter().flat_map(|word| word.to_be_bytes()).collect()
}

/// The first bit is the least significant of the first byte.
fn pack(bits: &[u16]) -> Vec<u8> {
    let byte =
        |bits: &[u16]| bits.iter().rev().fold(0, |byte, bit| byte << 1 | u8::from(*bit != 0));
    bits.chunks(8).map(byte).collect()
}

const ILLEGAL_FUNCTION: u8 = 1;
const ILLEGAL_DATA_ADDRESS: u8 = 2;
const ILLEGAL_DATA_VALUE: u8 = 3;

#[cfg(test)]
mod tests {
    use asphera_modbus::Map;

    use super::*;

    /// The examples of V1.1b3, sections 6.1, 6.3 and 7.
    #[test]
    fn examples_of_the_specification() {
        let mut image = Image::new(Map::default());
        let bits = [0xCD_u8, 0x6B, 5].map(|byte| (0..8).map(move |bit| byte >> bit & 1));
        for (address, bit) in (19..38).zip(bits.into_iter().flatten()) {
            image.set_register(Function::ReadCoils, address, bit.into());
        }
        for (address, word) in (107..).zip([0x022B, 0, 0x64]) {
            image.set_register(Function::ReadHolding, address, word);
        }
        assert_eq!(answer(&image, &[1, 0, 0x13, 0, 0x13]), [1, 3, 0xCD, 0x6B, 5]);
        assert_eq!(answer(&image, &[3, 0, 0x6B, 0, 3]), [3, 6, 2, 0x2B, 0, 0, 0, 0x64]);
        assert_eq!(answer(&image, &[1, 0x04, 0xA1, 0, 1]), [0x81, 2]);
    }

    #[test]
    fn a_whole_block_is_read_whole() {
        let image = Image::new(Map::built_in("baumer-om20").unwrap());
        assert_eq!(answer(&image, &[4, 0, 200, 0, 13]).len(), 28);
        assert_eq!(answer(&image, &[4, 0, 202, 0, 2]), [0x84, 2]);
        assert_eq!(answer(&image, &[4, 0, 200, 0, 0]), [0x84, 3]);
        assert_eq!(answer(&image, &[4, 0, 200, 0, 126]), [0x84, 3]);
        assert_eq!(answer(&image, &[6, 0, 200, 0, 1]), [0x86, 1]);
        assert_eq!(answer(&image, &[4, 0xFF, 0xFF, 0, 2]), [0x84, 2]);
    }
}
