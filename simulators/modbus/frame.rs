//! Requests cut out of a stream, answers put into frames; by hand, apart from the driver's.

use asphera_modbus::Transport;

/// A request and what its answer must repeat.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Request {
    pub(crate) transaction: u16,
    pub(crate) unit_id: u8,
    pub(crate) pdu: Vec<u8>,
}

/// Takes the first whole request out of the buffer, with everything in front of it.
///
/// RTU frames end by a pause, which a stream does not show; here a request is eight bytes with a
/// valid CRC, as all of the functions 01 to 06 are.
pub(crate) fn take_request(transport: Transport, buffer: &mut Vec<u8>) -> Option<Request> {
    match transport {
        Transport::Tcp => {
            let len = usize::from(u16::from_be_bytes([*buffer.get(4)?, *buffer.get(5)?]));
            if len < 2 || buffer[2..4] != [0, 0] {
                buffer.clear();
                return None;
            }
            if buffer.len() < 6 + len {
                return None;
            }
            let frame: Vec<u8> = buffer.drain(..6 + len).collect();
            let transaction = u16::from_be_bytes([frame[0], frame[1]]);
            Some(Request { transaction, unit_id: frame[6], pdu: frame[7..].to_vec() })
        }
        Transport::Rtu => {
            let start = buffer.windows(8).position(|frame| {
                crc(&frame[..6]).to_le_bytes() == frame[6..] && (1..=6).contains(&frame[1])
            });
            let Some(start) = start else {
                // No request begins earlier than in the last seven bytes.
                buffer.drain(..buffer.len().saturating_sub(7));
                return None;
            };
            let frame: Vec<u8> = buffer.drain(..start + 8).skip(start).collect();
            Some(Request { transaction: 0, unit_id: frame[0], pdu: frame[1..6].to_vec() })
        }
    }
}

/// The frame of an answer; a corrupt one is not to be accepted by anybody.
pub(crate) fn answer(
    transport: Transport,
    transaction: u16,
    unit_id: u8,
    pdu: &[u8],
    corrupt: bool,
) -> Vec<u8> {
    match transport {
        Transport::Tcp => {
            let mut frame = transaction.to_be_bytes().to_vec();
            frame.extend(u16::from(corrupt).to_be_bytes());
            frame.extend((pdu.len() as u16 + 1).to_be_bytes());
            frame.push(unit_id);
            frame.extend(pdu);
            frame
        }
        Transport::Rtu => {
            let mut frame = vec![unit_id];
            frame.extend(pdu);
            let crc = crc(&frame) ^ u16::from(corrupt);
            frame.extend(crc.to_le_bytes());
            frame
        }
    }
}

/// CRC-16 of MODBUS over Serial Line Specification V1.02, section 6.2.2, by a table of the sixteen
/// half bytes.
fn crc(bytes: &[u8]) -> u16 {
    bytes.iter().fold(0xFFFF, |crc, byte| {
        let crc = crc ^ u16::from(*byte);
        let crc = (crc >> 4) ^ HALF_BYTE[usize::from(crc & 15)];
        (crc >> 4) ^ HALF_BYTE[usize::from(crc & 15)]
    })
}

const HALF_BYTE: [u16; 16] = [
    0x0000, 0xCC01, 0xD801, 0x1400, 0xF001, 0x3C00, 0x2800, 0xE401, 0xA001, 0x6C00, 0x7800, 0xB401,
    0x5000, 0x9C01, 0x8801, 0x4400,
];

#[cfg(test)]
mod tests {
    use super::*;

    /// Simply Modbus (simplymodbus.ca), FC 03 and exceptions.
    #[test]
    fn published_rtu_frames() {
        let mut line = vec![0xFF, 0x11, 3, 0, 0x6B, 0, 3, 0x76, 0x87, 0x11];
        let request = take_request(Transport::Rtu, &mut line).unwrap();
        assert_eq!((request.unit_id, &request.pdu[..]), (0x11, &[3, 0, 0x6B, 0, 3][..]));
        assert_eq!(line, [0x11]);
        let refused = answer(Transport::Rtu, 0, 0x0A, &[0x81, 2], false);
        assert_eq!(refused, [0x0A, 0x81, 2, 0xB0, 0x53]);
    }

    /// UFACTORY, xArm Modbus TCP manual (docs.ufactory.cc/modbustcp_cn).
    #[test]
    fn published_tcp_frames() {
        let mut stream = vec![0, 1, 0, 0, 0, 6, 1, 3, 0, 3, 0, 2];
        let request = take_request(Transport::Tcp, &mut stream).unwrap();
        assert_eq!((request.transaction, &request.pdu[..]), (1, &[3, 0, 3, 0, 2][..]));
        let frame = answer(Transport::Tcp, 1, 1, &[3, 4, 0, 5, 0, 6], false);
        assert_eq!(frame, [0, 1, 0, 0, 0, 7, 1, 3, 4, 0, 5, 0, 6]);
    }
}
