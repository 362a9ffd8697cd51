//! Moves as commands of the protocol, and replies to them.
//!
//! ```text
//! /1 1 7 set maxspeed 52429⏎      speed, kept until it is set anew
//! /1 1 8 move abs 32000⏎          place in microsteps
//! /1 0 9 home⏎                    all axes of the device, and so for the next
//! /1 0 9 stop⏎
//! @01 1 08 OK BUSY -- 0⏎          reply with the number of the message
//! ```

use crate::reply::CHECKSUM;
use crate::settings::{Axis, Settings};

/// Command to an axis.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) enum Order {
    /// Speed in the unit of the setting `maxspeed`.
    Speed(i64),
    /// Acceleration in the unit of the setting `accel`.
    Acceleration(i64),
    /// Place in microsteps.
    MoveTo(i64),
    /// Home.
    Home,
    /// Halt.
    Stop,
    /// Question for all warnings at once.
    Warnings,
}

impl Order {
    pub(crate) fn words(&self) -> String {
        match self {
            Order::Speed(data) => format!("set maxspeed {data}"),
            Order::Acceleration(data) => format!("set accel {data}"),
            Order::MoveTo(microsteps) => format!("move abs {microsteps}"),
            Order::Home => "home".to_owned(),
            Order::Stop => "stop".to_owned(),
            Order::Warnings => "warnings".to_owned(),
        }
    }
}

/// Number of an axis on its device.
pub(crate) fn axis_number(settings: &Settings, index: usize) -> u8 {
    match settings.axis {
        0 => u8::try_from(index + 1).unwrap_or(u8::MAX),
        number => number,
    }
}

/// Place, speed or acceleration of an axis as data of the protocol, a whole number; `None` beyond what the protocol holds.
pub(crate) fn data(axis: &Axis, value: f64, factor: f64) -> Option<i64> {
    let (_, microstep) = axis.microstep.in_channel();
    let data = (value / microstep * factor).round();
    (data.abs() <= f64::from(i32::MAX)).then_some(data as i64)
}

/// `maxspeed` counts so much for a microstep per second.
pub(crate) const SPEED: f64 = 1.6384;
/// `accel` counts so much for a microstep per second squared.
pub(crate) const ACCELERATION: f64 = 1.6384 / 10_000.0;

/// Reply to a command.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Reply<'a> {
    /// Number of the message; `None` for a reply to a question for the position.
    pub(crate) number: Option<u8>,
    pub(crate) is_accepted: bool,
    pub(crate) is_busy: bool,
    /// Two letters, or `--`.
    pub(crate) warning: &'a str,
    pub(crate) data: &'a str,
}

impl<'a> Reply<'a> {
    /// The reply in a line without its end, if it is a whole one of the device.
    pub(crate) fn parse(line: &'a [u8], address: u8, is_checked: bool) -> Option<Reply<'a>> {
        let body = if is_checked { CHECKSUM.body(line)? } else { line };
        let text = std::str::from_utf8(body).ok()?.strip_prefix('@')?;
        let mut words = text.splitn(4, ' ');
        let (device, axis) = (words.next()?, words.next()?);
        if device.parse() != Ok(address)
            || axis.len() != 1
            || !axis.bytes().all(|b| b.is_ascii_digit())
        {
            return None;
        }
        let third = words.next()?;
        let (number, flag, rest) = match third.parse::<u8>() {
            Ok(number) if number <= 99 => {
                let (flag, rest) = words.next()?.split_once(' ')?;
                (Some(number), flag, rest)
            }
            _ => (None, third, words.next()?),
        };
        let is_accepted = match flag {
            "OK" => true,
            "RJ" => false,
            _ => return None,
        };
        let mut rest = rest.splitn(3, ' ');
        let is_busy = match rest.next()? {
            "BUSY" => true,
            "IDLE" => false,
            _ => return None,
        };
        let warning = rest.next().filter(|letters| letters.len() == 2)?;
        Some(Reply { number, is_accepted, is_busy, warning, data: rest.next().unwrap_or("") })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::settings::Microstep;

    /// Replies in tests of `zaber-python` and `zproto`, and in a program for a controller with two axes.
    #[test]
    fn replies_of_others_are_read() {
        let reply = |text: &'static str| Reply::parse(text.as_bytes(), 1, false);
        let found = reply("@01 1 OK BUSY -- 0").unwrap();
        assert_eq!((found.number, found.is_accepted, found.is_busy), (None, true, true));
        let stopped = reply("@01 0 12 OK BUSY NI 0").unwrap();
        assert_eq!((stopped.number, stopped.warning, stopped.data), (Some(12), "NI", "0"));
        let rejected = reply("@01 0 RJ IDLE -- BADDATA").unwrap();
        assert_eq!((rejected.is_accepted, rejected.data), (false, "BADDATA"));
        assert_eq!(reply("@01 0 OK IDLE WR 01 WR").unwrap().data, "01 WR");
        for strange in [
            "@02 0 OK IDLE -- 0",
            "!01 1 IDLE --",
            "#01 0 text",
            "@01 0 OK",
            "@01 0 OK IDLE",
            "@01 0 NO IDLE -- 0",
            "@01 12 OK IDLE -- 0",
        ] {
            assert_eq!(reply(strange), None, "{strange}");
        }
    }

    #[test]
    fn a_reply_with_a_wrong_check_is_none() {
        assert!(Reply::parse(b"@01 1 OK IDLE -- 64:52", 1, true).is_some());
        assert!(Reply::parse(b"@01 1 OK IDLE -- 65:52", 1, true).is_none());
        assert!(Reply::parse(b"@01 1 OK IDLE -- 64", 1, true).is_none());
    }

    /// 1 mm/s of a stage with 0.2 µm: 5000 microsteps, and 1.6384 for each, as programs of users count.
    #[test]
    fn data_of_the_protocol() {
        let axis = Axis { name: "x".to_owned(), microstep: Microstep::Micrometres(0.2) };
        assert_eq!(data(&axis, 1.0, SPEED), Some(8192));
        assert_eq!(data(&axis, 100.0, ACCELERATION), Some(82));
        assert_eq!(data(&axis, 2.0468, 1.0), Some(10_234));
        assert_eq!(data(&axis, 1e9, 1.0), None);
        assert_eq!(data(&axis, f64::NAN, 1.0), None);
    }
}
