//! Bit rates of the CAN bus as adapters number them.

use thiserror::Error;

/// A bit rate of the `Sn` command.
///
/// | code | kbit/s | | code | kbit/s | | code | kbit/s |
/// |---|---|---|---|---|---|---|---|
/// | S0 | 10 | | S3 | 100 | | S6 | 500 |
/// | S1 | 20 | | S4 | 125 | | S7 | **800** |
/// | S2 | 50 | | S5 | 250 | | S8 | 1000 |
///
/// **Trap.** python-can 4.6.1 sends S7 when asked for 750 kbit/s (and S9 for 83.3 kbit/s, which
/// Lawicel does not have). Adapters set 800 kbit/s on S7 (canable2-fw wiki, command list), and two
/// nodes at 750 and 800 kbit/s do not understand each other. 750 kbit/s is therefore refused here.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum BitRate {
    /// S0.
    Kbps10,
    /// S1.
    Kbps20,
    /// S2.
    Kbps50,
    /// S3.
    Kbps100,
    /// S4.
    Kbps125,
    /// S5.
    Kbps250,
    /// S6.
    Kbps500,
    /// S7.
    Kbps800,
    /// S8.
    Kbps1000,
}

/// A bit rate no `Sn` command sets.
#[derive(Clone, Copy, Debug, Error, PartialEq, Eq)]
#[error(
    "slcan has no bit rate of {bits_per_s} bit/s; it has 10, 20, 50, 100, 125, 250, 500, 800 and 1000 kbit/s"
)]
pub struct UnsupportedBitRate {
    /// What was asked for, in bit/s.
    pub bits_per_s: u32,
}

impl BitRate {
    /// All of them, in the order of their codes.
    pub const ALL: [BitRate; 9] = [
        BitRate::Kbps10,
        BitRate::Kbps20,
        BitRate::Kbps50,
        BitRate::Kbps100,
        BitRate::Kbps125,
        BitRate::Kbps250,
        BitRate::Kbps500,
        BitRate::Kbps800,
        BitRate::Kbps1000,
    ];

    /// The bit rate in bit/s.
    pub const fn bits_per_s(self) -> u32 {
        match self {
            BitRate::Kbps10 => 10_000,
            BitRate::Kbps20 => 20_000,
            BitRate::Kbps50 => 50_000,
            BitRate::Kbps100 => 100_000,
            BitRate::Kbps125 => 125_000,
            BitRate::Kbps250 => 250_000,
            BitRate::Kbps500 => 500_000,
            BitRate::Kbps800 => 800_000,
            BitRate::Kbps1000 => 1_000_000,
        }
    }

    /// The bit rate of exactly `bits_per_s`.
    pub fn from_bits_per_s(bits_per_s: u32) -> Result<BitRate, UnsupportedBitRate> {
        BitRate::ALL
            .into_iter()
            .find(|rate| rate.bits_per_s() == bits_per_s)
            .ok_or(UnsupportedBitRate { bits_per_s })
    }

    /// The digit after `S`.
    pub const fn code(self) -> u8 {
        b'0' + self as u8
    }

    /// The bit rate of the digit after `S`.
    pub fn from_code(code: u8) -> Option<BitRate> {
        BitRate::ALL.get(usize::from(code.checked_sub(b'0')?)).copied()
    }
}

/// A bit rate of the `Yn` command, for the data of CAN FD frames with BRS.
///
/// These four are in the command lists of both firmwares of the CANable 2 (normaldotcom/canable2-fw and
/// Nakakiyo092/canable2-fw, README.md). Y0 and Y8 are in the second alone, and are not here.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum DataBitRate {
    /// Y1.
    Mbps1,
    /// Y2.
    Mbps2,
    /// Y4.
    Mbps4,
    /// Y5.
    Mbps5,
}

/// A bit rate no `Yn` command sets.
#[derive(Clone, Copy, Debug, Error, PartialEq, Eq)]
#[error("slcan has no data bit rate of {bits_per_s} bit/s; it has 1, 2, 4 and 5 Mbit/s")]
pub struct UnsupportedDataBitRate {
    /// What was asked for, in bit/s.
    pub bits_per_s: u32,
}

impl DataBitRate {
    /// All of them, in the order of their codes.
    pub const ALL: [DataBitRate; 4] =
        [DataBitRate::Mbps1, DataBitRate::Mbps2, DataBitRate::Mbps4, DataBitRate::Mbps5];

    /// The bit rate in bit/s.
    pub const fn bits_per_s(self) -> u32 {
        (self.code() - b'0') as u32 * 1_000_000
    }

    /// The bit rate of exactly `bits_per_s`.
    pub fn from_bits_per_s(bits_per_s: u32) -> Result<DataBitRate, UnsupportedDataBitRate> {
        DataBitRate::ALL
            .into_iter()
            .find(|rate| rate.bits_per_s() == bits_per_s)
            .ok_or(UnsupportedDataBitRate { bits_per_s })
    }

    /// The digit after `Y`: the rate in Mbit/s.
    pub const fn code(self) -> u8 {
        match self {
            DataBitRate::Mbps1 => b'1',
            DataBitRate::Mbps2 => b'2',
            DataBitRate::Mbps4 => b'4',
            DataBitRate::Mbps5 => b'5',
        }
    }

    /// The bit rate of the digit after `Y`.
    pub fn from_code(code: u8) -> Option<DataBitRate> {
        DataBitRate::ALL.into_iter().find(|rate| rate.code() == code)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn s7_is_800_kbit_s_and_750_does_not_exist() {
        assert_eq!(BitRate::from_code(b'7').map(BitRate::bits_per_s), Some(800_000));
        let refused = BitRate::from_bits_per_s(750_000);
        assert_eq!(refused, Err(UnsupportedBitRate { bits_per_s: 750_000 }));
        assert!(refused.unwrap_err().to_string().contains("800"));
        assert_eq!((BitRate::from_code(b'9'), BitRate::from_code(b'/')), (None, None));
    }

    #[test]
    fn every_rate_is_found_by_its_number_and_by_its_code() {
        for rate in BitRate::ALL {
            assert_eq!(BitRate::from_bits_per_s(rate.bits_per_s()), Ok(rate));
            assert_eq!(BitRate::from_code(rate.code()), Some(rate));
        }
    }

    #[test]
    fn data_rates_are_those_of_both_firmwares() {
        let codes = DataBitRate::ALL.map(|rate| (char::from(rate.code()), rate.bits_per_s()));
        assert_eq!(codes, [('1', 1_000_000), ('2', 2_000_000), ('4', 4_000_000), ('5', 5_000_000)]);
        assert_eq!(DataBitRate::from_code(b'0'), None);
        assert!(
            DataBitRate::from_bits_per_s(8_000_000).unwrap_err().to_string().contains("4 and 5")
        );
        for rate in DataBitRate::ALL {
            assert_eq!(DataBitRate::from_bits_per_s(rate.bits_per_s()), Ok(rate));
        }
    }
}
