//! The format of a recording: its version, names, channel numbers and limits.

use std::fmt;

use serde::{Deserialize, Serialize};

use super::ReadError;

/// First part of a format version. A new one may mean anything else; older software refuses it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
#[serde(transparent)]
pub struct MajorVersion(pub u16);

/// Second part of a format version. A new one only adds what older software may pass over.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
#[serde(transparent)]
pub struct MinorVersion(pub u16);

/// Version of the recording format.
///
/// # Changelog
///
/// - 1.0: first version.
/// - 1.1: the event "held up".
/// - 1.2: the channel `/points`.
/// - 1.3: `suspended_ns` of the event "held up".
/// - 1.4: the event "scan".
/// - 1.5: of a link with two connections, each read begins with the number of its connection, 0 or 1.
/// - 1.6: a CAN FD frame of an interface of the kernel is a record of 72 bytes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct FormatVersion {
    /// First part.
    pub major: MajorVersion,
    /// Second part.
    pub minor: MinorVersion,
}

impl FormatVersion {
    /// The version written.
    pub const CURRENT: FormatVersion =
        FormatVersion { major: MajorVersion(1), minor: MinorVersion(6) };

    /// The oldest major version read.
    pub const OLDEST_READ: MajorVersion = MajorVersion(1);

    /// Whether this software reads the version; [`ReadError::TooOld`] or [`ReadError::TooNew`] if not.
    pub fn check_readable(self) -> Result<(), ReadError> {
        if self.major < FormatVersion::OLDEST_READ {
            return Err(ReadError::TooOld { found: self, oldest: FormatVersion::OLDEST_READ });
        }
        if self.major > FormatVersion::CURRENT.major {
            return Err(ReadError::TooNew { found: self, newest: FormatVersion::CURRENT });
        }
        Ok(())
    }
}

impl fmt::Display for FormatVersion {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}.{}", self.major, self.minor)
    }
}

impl fmt::Display for MajorVersion {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.0.fmt(f)
    }
}

impl fmt::Display for MinorVersion {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.0.fmt(f)
    }
}

/// Profile named in the MCAP header record.
pub(super) const PROFILE: &str = "asphera-session";

/// Attachment with the [`super::header::SegmentHeader`].
pub(super) const SEGMENT_ATTACHMENT: &str = "segment.json";

/// Attachment with the effective configuration.
pub(super) const CONFIG_ATTACHMENT: &str = "config.toml";

/// The manifest's name in the session's folder.
pub(crate) const MANIFEST: &str = "manifest.json";

/// Longest message, bytes. A read of a link is thousands of times shorter.
pub(super) const MAX_MESSAGE_BYTES: usize = 16 << 20;

/// Longest record and longest decompressed chunk a reader accepts, bytes: a damaged length must not
/// make it allocate without bound. Two messages of the longest kind fit.
pub(super) const MAX_RECORD_BYTES: usize = 2 * MAX_MESSAGE_BYTES + (1 << 20);

/// Longest configuration, bytes.
pub(super) const MAX_CONFIG_BYTES: usize = 8 << 20;

/// Most links of a session: MCAP numbers channels with 16 bits.
pub(super) const MAX_LINKS: usize = 1000;

/// Bytes MCAP adds to a message in a chunk: opcode 1, length 8, channel 2, sequence 4, two times 8.
pub(super) const MESSAGE_OVERHEAD_BYTES: usize = 31;

/// Channels. The numbers are part of the format, so that messages stay readable when the chunk with
/// the channel records is damaged.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum ChannelId {
    /// `/events`, number 1.
    Events,
    /// `/results`, number 2.
    Results,
    /// `/points`, number 60,000.
    Points,
    /// `/raw/<link>`, number 3 + 2 × link.
    Raw(usize),
    /// `/sent/<link>`, number 4 + 2 × link.
    Sent(usize),
}

impl ChannelId {
    pub(super) fn number(self) -> u16 {
        let of_link =
            |first: usize, link: usize| u16::try_from(first + 2 * link).unwrap_or(u16::MAX);
        match self {
            ChannelId::Events => 1,
            ChannelId::Results => 2,
            ChannelId::Points => POINTS,
            ChannelId::Raw(link) => of_link(3, link),
            ChannelId::Sent(link) => of_link(4, link),
        }
    }

    /// The channel of a number, among those of a session with so many links.
    pub(super) fn from_number(number: u16, links: usize) -> Option<ChannelId> {
        let link = (usize::from(number).checked_sub(3)).map(|above| above / 2);
        match (number, link) {
            (1, _) => Some(ChannelId::Events),
            (2, _) => Some(ChannelId::Results),
            (POINTS, _) => Some(ChannelId::Points),
            (_, Some(link)) if link < links && number % 2 == 1 => Some(ChannelId::Raw(link)),
            (_, Some(link)) if link < links => Some(ChannelId::Sent(link)),
            _ => None,
        }
    }
}

/// Beyond the channels of [`MAX_LINKS`] links.
const POINTS: u16 = 60_000;

/// File name of a segment.
pub(super) fn segment_name(number: u32) -> String {
    format!("{number:04}.mcap")
}

/// Number of the segment a file name stands for, if it is one.
pub(super) fn segment_number(name: &str) -> Option<u32> {
    let digits = name.strip_suffix(".mcap")?;
    let number = digits.parse().ok()?;
    (segment_name(number) == name).then_some(number)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn channel_numbers_are_one_to_one() {
        let links = MAX_LINKS;
        let all = [ChannelId::Events, ChannelId::Results]
            .into_iter()
            .chain((0..links).flat_map(|link| [ChannelId::Raw(link), ChannelId::Sent(link)]));
        for (index, channel) in all.enumerate() {
            assert_eq!(usize::from(channel.number()), index + 1);
            assert_eq!(ChannelId::from_number(channel.number(), links), Some(channel));
        }
        assert_eq!(ChannelId::Points.number(), 60_000);
        assert_eq!(ChannelId::from_number(60_000, links), Some(ChannelId::Points));
        assert_eq!(ChannelId::from_number(0, links), None);
        assert_eq!(ChannelId::from_number(5, 1), None);
    }

    #[test]
    fn segment_names() {
        assert_eq!(segment_number("0007.mcap"), Some(7));
        assert_eq!(segment_number("12345.mcap"), Some(12345));
        for name in ["7.mcap", "+007.mcap", "00007.mcap", "0007.mcap.tmp", "a.mcap", ".mcap"] {
            assert_eq!(segment_number(name), None, "{name}");
        }
    }

    #[test]
    fn major_versions_decide() {
        let version =
            |major, minor| FormatVersion { major: MajorVersion(major), minor: MinorVersion(minor) };
        assert!(version(1, 0).check_readable().is_ok());
        assert!(version(1, 9).check_readable().is_ok());
        assert!(matches!(version(0, 9).check_readable(), Err(ReadError::TooOld { .. })));
        assert!(matches!(version(2, 0).check_readable(), Err(ReadError::TooNew { .. })));
    }
}
