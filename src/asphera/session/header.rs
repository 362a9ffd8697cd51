//! Whose recording it is: what the manifest and the beginning of every segment tell.

use std::collections::BTreeSet;
use std::fmt;

use asphera_report::Label;
use jiff::Timestamp;
use serde::{Deserialize, Serialize};

use super::format::{MAX_CONFIG_BYTES, MAX_LINKS};
use super::{FormatVersion, RecordError};

/// Data known when a session begins.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Header {
    /// Tells sessions of the same second apart.
    pub id: SessionId,
    /// Name of the station.
    pub station: String,
    /// Version of the software that records.
    pub version: String,
    /// Start of the station's monotonic clock on the wall clock: nanoseconds since 1970-01-01T00:00Z,
    /// leap seconds not counted. An entry's wall time is this plus its `at`.
    pub started_wall_ns: i64,
    /// The effective configuration.
    pub config_toml: String,
    /// The links, in the order entries number them.
    pub links: Vec<LinkInfo>,
    /// Part and operator, where that was told.
    #[serde(default)]
    pub label: Label,
}

/// One link of a session.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct LinkInfo {
    /// Name, unique within the session.
    pub name: String,
    /// Kind as the configuration names it: `serial`, `tcp`, `can`.
    pub kind: String,
    /// Where it leads: `/dev/ttyUSB0`, `192.168.170.2:7891`, `can0`.
    pub address: String,
}

/// Number of a session; eight hexadecimal digits in names and JSON.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
#[serde(into = "String", try_from = "String")]
pub struct SessionId(pub u32);

impl Header {
    /// Name of the session's folder: `session-YYYYMMDDThhmmssZ-<id>`, in UTC.
    pub fn folder_name(&self) -> String {
        format!("session-{}-{}", self.started().strftime("%Y%m%dT%H%M%SZ"), self.id)
    }

    /// Start of the station's clock as RFC 3339 writes it, in UTC.
    pub fn started_rfc3339(&self) -> String {
        self.started().to_string()
    }

    fn started(&self) -> Timestamp {
        Timestamp::from_nanosecond(self.started_wall_ns.into())
            .expect("64 bits of nanoseconds span the years 1677 to 2262, which a timestamp holds")
    }

    pub(super) fn check(&self) -> Result<(), RecordError> {
        let value = |key: &str, expected, found| RecordError::Value {
            key: key.to_owned(),
            expected,
            found,
        };
        if self.links.len() > MAX_LINKS {
            return Err(value(
                "links",
                format!("at most {MAX_LINKS}"),
                self.links.len().to_string(),
            ));
        }
        if self.config_toml.len() > MAX_CONFIG_BYTES {
            return Err(value(
                "config_toml",
                format!("at most {MAX_CONFIG_BYTES} bytes"),
                format!("{} bytes", self.config_toml.len()),
            ));
        }
        let mut names = BTreeSet::new();
        for link in &self.links {
            let fits = !link.name.is_empty() && !link.name.chars().any(char::is_control);
            if !fits || !names.insert(&link.name) {
                return Err(value(
                    "link name",
                    "unique, not empty, without control characters".to_owned(),
                    format!("{:?}", link.name),
                ));
            }
        }
        Ok(())
    }
}

impl SessionId {
    /// A number from the system's random source.
    pub fn random() -> Result<SessionId, getrandom::Error> {
        getrandom::u32().map(SessionId)
    }
}

impl fmt::Display for SessionId {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{:08x}", self.0)
    }
}

impl From<SessionId> for String {
    fn from(id: SessionId) -> String {
        id.to_string()
    }
}

impl TryFrom<String> for SessionId {
    type Error = String;

    fn try_from(text: String) -> Result<SessionId, String> {
        u32::from_str_radix(&text, 16)
            .map(SessionId)
            .ok()
            .filter(|id| id.to_string() == text)
            .ok_or_else(|| format!("session id {text:?}, expected eight hexadecimal digits"))
    }
}

/// Content of the attachment `segment.json`.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub(super) struct SegmentHeader {
    pub(super) format: FormatVersion,
    pub(super) session: Header,
    /// Number of the segment within the session.
    pub(super) segment: u32,
    /// Sequence number of its first entry.
    pub(super) first_sequence: u64,
}

/// What is read of a header before anything else: whether the rest can be understood.
#[derive(Deserialize)]
pub(super) struct FormatOnly {
    pub(super) format: FormatVersion,
}

#[cfg(test)]
mod tests {
    use super::*;

    fn header() -> Header {
        Header {
            id: SessionId(0xbad_cafe),
            station: String::new(),
            version: String::new(),
            // 2026-11-21T00:40:06.5Z: 20,778 days and 2406.5 s after 1970.
            started_wall_ns: (20_778 * 86_400 + 2406) * 1_000_000_000 + 500_000_000,
            config_toml: String::new(),
            links: Vec::new(),
            label: Label::default(),
        }
    }

    #[test]
    fn folder_name_is_utc_and_id() {
        assert_eq!(header().folder_name(), "session-20261121T004006Z-0badcafe");
        assert_eq!(header().started_rfc3339(), "2026-11-21T00:40:06.5Z");
    }

    #[test]
    fn extreme_wall_times_have_a_name() {
        for ns in [i64::MIN, -1, 0, i64::MAX] {
            let header = Header { started_wall_ns: ns, ..header() };
            assert_eq!(header.folder_name().len(), "session-20261121T004006Z-0badcafe".len());
        }
    }

    #[test]
    fn ids_are_eight_digits() {
        assert_eq!(SessionId::try_from("0badcafe".to_owned()), Ok(SessionId(0xbad_cafe)));
        for text in ["", "badcafe", "0BADCAFE", "+badcafe", "00badcafe"] {
            assert!(SessionId::try_from(text.to_owned()).is_err(), "{text}");
        }
    }

    #[test]
    fn link_names_are_checked() {
        let link = |name: &str| LinkInfo {
            name: name.to_owned(),
            kind: "tcp".to_owned(),
            address: String::new(),
        };
        let with = |links| Header { links, ..header() }.check();
        assert!(with(vec![link("probe"), link("stage")]).is_ok());
        for links in [vec![link("")], vec![link("a\n")], vec![link("probe"), link("probe")]] {
            assert!(
                matches!(with(links), Err(RecordError::Value { key, .. }) if key == "link name")
            );
        }
    }
}
