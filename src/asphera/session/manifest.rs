//! The manifest of a session's folder: written before the first entry, amended at the end.

use std::io::Write;
use std::path::Path;

use asphera_link::Nanos;
use serde::{Deserialize, Serialize};

use super::format::MANIFEST;
use super::header::FormatOnly;
use super::{FormatVersion, Header, ReadError, RecordError, Storage};

/// Content of `manifest.json`.
///
/// It repeats what every segment tells, so that a session without a readable segment can still be
/// named, and says how the session ended, which only a reading of all segments would show.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Manifest {
    /// Version of the format.
    pub format: FormatVersion,
    /// [`Header::started_rfc3339`], for people.
    pub started: String,
    /// Data known at the beginning.
    pub session: Header,
    /// Data known at the end; `None` while the session runs and when it was interrupted.
    pub end: Option<ManifestEnd>,
}

/// The end of a session as the manifest tells it.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct ManifestEnd {
    /// When, in nanoseconds since the station started.
    pub at_ns: u64,
    /// How.
    pub ended: Ended,
    /// Entries recorded, finish and results among them.
    pub entries: u64,
    /// Segments recorded.
    pub segments: u32,
}

/// How a recording ended.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(tag = "how", rename_all = "lowercase")]
pub enum Ended {
    /// It did not: killed, power cut, write error, or still running.
    Interrupted,
    /// The recorder stopped before the measurement ended.
    Stopped {
        /// Why, in words.
        reason: String,
    },
    /// The measurement ended.
    Finished {
        /// Why, in words.
        reason: String,
    },
}

impl Manifest {
    pub(super) fn of(header: &Header) -> Manifest {
        Manifest {
            format: FormatVersion::CURRENT,
            started: header.started_rfc3339(),
            session: header.clone(),
            end: None,
        }
    }

    /// Puts the manifest into a folder so that at any time there is the old one or the new one.
    pub(super) fn write(
        &self,
        storage: &mut dyn Storage,
        folder: &Path,
    ) -> Result<(), RecordError> {
        let error = RecordError::storage;
        let path = folder.join(MANIFEST);
        let temporary = folder.join(format!("{MANIFEST}.tmp"));
        let mut text =
            serde_json::to_string_pretty(self).expect("a manifest is numbers and strings");
        text.push('\n');
        let mut file = storage.create(&temporary).map_err(error("create", &temporary))?;
        file.write_all(text.as_bytes()).map_err(error("write", &temporary))?;
        file.sync_data().map_err(error("sync", &temporary))?;
        drop(file);
        storage.rename(&temporary, &path).map_err(error("replace", &path))?;
        storage.sync_dir(folder).map_err(error("sync", folder))
    }

    /// Reads a manifest. `Ok(None)` for bytes that are none, or not one of a format it knows how to
    /// name; an error for a format it does know to be too old or too new.
    pub(super) fn parse(bytes: &[u8]) -> Result<Option<Manifest>, ReadError> {
        let Ok(FormatOnly { format }) = serde_json::from_slice(bytes) else { return Ok(None) };
        format.check_readable()?;
        Ok(serde_json::from_slice(bytes).ok())
    }
}

impl ManifestEnd {
    /// When the session ended.
    pub fn at(&self) -> Nanos {
        Nanos::from_nanos(self.at_ns)
    }
}
