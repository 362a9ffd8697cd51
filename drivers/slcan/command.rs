//! Commands of a host to its adapter.

use crate::{BitRate, CR, DataBitRate, hex};

/// A command for an adapter.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Command {
    /// `Sn`: bit rate of the bus. Only while the channel is closed.
    BitRate(BitRate),
    /// `Yn`: bit rate of the data of CAN FD frames with BRS. Only while the channel is closed.
    DataBitRate(DataBitRate),
    /// `sxxyy` or `sxxyyzz`: registers of the adapter's CAN controller. Only while the channel is closed.
    Registers {
        /// Two or three registers, the first in the highest byte used.
        value: u32,
        /// 2 or 3.
        count: u8,
    },
    /// `O`: take part in the bus.
    Open,
    /// `L`: listen without acknowledging.
    Listen,
    /// `C`: leave the bus.
    Close,
    /// `P`: give one received frame.
    PollOne,
    /// `A`: give all received frames.
    PollAll,
    /// `X0`, `X1`: give received frames unasked.
    AutoPoll(bool),
    /// `Z0`, `Z1`: append the time to received frames.
    Timestamps(bool),
    /// `F`: tell the status.
    Status,
    /// `V`: tell the versions.
    Version,
    /// `N`: tell the serial number.
    SerialNumber,
    /// `Mxxxxxxxx`: acceptance code.
    AcceptanceCode(u32),
    /// `mxxxxxxxx`: acceptance mask.
    AcceptanceMask(u32),
    /// `Un`: bit rate of the serial port, by number.
    Uart(u8),
    /// `Wn`: filter mode, by number.
    FilterMode(u8),
}

impl Command {
    /// Appends the command with its CR.
    pub fn encode(self, out: &mut Vec<u8>) {
        match self {
            Command::BitRate(rate) => out.extend([b'S', rate.code()]),
            Command::DataBitRate(rate) => out.extend([b'Y', rate.code()]),
            Command::Registers { value, count } => {
                out.push(b's');
                hex::push(out, value, 2 * u32::from(count));
            }
            Command::Open => out.push(b'O'),
            Command::Listen => out.push(b'L'),
            Command::Close => out.push(b'C'),
            Command::PollOne => out.push(b'P'),
            Command::PollAll => out.push(b'A'),
            Command::AutoPoll(on) => out.extend([b'X', b'0' + u8::from(on)]),
            Command::Timestamps(on) => out.extend([b'Z', b'0' + u8::from(on)]),
            Command::Status => out.push(b'F'),
            Command::Version => out.push(b'V'),
            Command::SerialNumber => out.push(b'N'),
            Command::AcceptanceCode(code) => {
                out.push(b'M');
                hex::push(out, code, 8);
            }
            Command::AcceptanceMask(mask) => {
                out.push(b'm');
                hex::push(out, mask, 8);
            }
            Command::Uart(number) => out.extend([b'U', b'0' + number]),
            Command::FilterMode(number) => out.extend([b'W', b'0' + number]),
        }
        out.push(CR);
    }

    /// The command of a line without its CR.
    pub(crate) fn parse(line: &[u8]) -> Option<Command> {
        let (&letter, rest) = line.split_first()?;
        let digit = || match *rest {
            [digit @ b'0'..=b'9'] => Some(digit - b'0'),
            _ => None,
        };
        let switch = || digit().filter(|&digit| digit < 2).map(|digit| digit == 1);
        let word = || if rest.len() == 8 { hex::number(rest) } else { None };
        if rest.is_empty() {
            return Some(match letter {
                b'O' => Command::Open,
                b'L' => Command::Listen,
                b'C' => Command::Close,
                b'P' => Command::PollOne,
                b'A' => Command::PollAll,
                b'F' => Command::Status,
                b'V' => Command::Version,
                b'N' => Command::SerialNumber,
                _ => return None,
            });
        }
        match letter {
            b'S' if rest.len() == 1 => BitRate::from_code(rest[0]).map(Command::BitRate),
            b'Y' if rest.len() == 1 => DataBitRate::from_code(rest[0]).map(Command::DataBitRate),
            b's' if rest.len() == 4 || rest.len() == 6 => hex::number(rest)
                .map(|value| Command::Registers { value, count: (rest.len() / 2) as u8 }),
            b'X' => switch().map(Command::AutoPoll),
            b'Z' => switch().map(Command::Timestamps),
            b'M' => word().map(Command::AcceptanceCode),
            b'm' => word().map(Command::AcceptanceMask),
            b'U' => digit().map(Command::Uart),
            b'W' => digit().map(Command::FilterMode),
            _ => None,
        }
    }
}
