//! What can go wrong when recording and when reading.

use std::io;
use std::path::{Path, PathBuf};

use thiserror::Error;

use super::{FormatVersion, MajorVersion, SessionId};

/// Why a recording cannot begin or go on.
///
/// After [`RecordError::Storage`], [`RecordError::Encode`] and [`RecordError::DiskReserve`] the
/// recorder has stopped. The others refuse one call and leave it as it was.
#[derive(Debug, Error)]
pub enum RecordError {
    /// The file system refused.
    #[error("cannot {action} {}", path.display())]
    Storage {
        /// Action that was tried.
        action: &'static str,
        /// On which file or folder.
        path: PathBuf,
        /// Error of the file system.
        source: io::Error,
    },
    /// Less free space than the reserve. The recording was closed in good order: everything appended
    /// is durable. The entry of the call that fails is not among it.
    #[error("only {free_bytes} bytes free at {}, the reserve is {wanted_bytes}", path.display())]
    DiskReserve {
        /// The session's folder, or its parent when the session could not begin.
        path: PathBuf,
        /// Free bytes found.
        free_bytes: u64,
        /// Free bytes wanted: [`super::Settings::reserve_bytes`].
        wanted_bytes: u64,
    },
    /// The MCAP writer refused.
    #[error("cannot encode a record")]
    Encode(#[source] mcap::McapError),
    /// A value of the settings or the header that cannot be used.
    #[error("{key} is {found}, expected {expected}")]
    Value {
        /// Which value.
        key: String,
        /// Value that would do.
        expected: String,
        /// Content found there.
        found: String,
    },
    /// An entry of a link the header does not name.
    #[error("entry of link {link}, but there are {links} links")]
    UnknownLink {
        /// The entry's link.
        link: usize,
        /// How many links the header names.
        links: usize,
    },
    /// An entry above the longest allowed.
    #[error("entry of {bytes} bytes, at most {limit} are recorded")]
    EntryTooLarge {
        /// The entry's size.
        bytes: usize,
        /// The longest allowed.
        limit: usize,
    },
    /// Finish and results were appended instead of being handed to [`super::Recorder::finish`].
    #[error("finish and results are written by finishing the recording only")]
    OnlyByFinish,
    /// The recorder stopped at an earlier error.
    #[error("the recording has stopped")]
    Stopped,
}

impl RecordError {
    pub(super) fn storage(action: &'static str, path: &Path) -> impl FnOnce(io::Error) -> Self {
        move |source| RecordError::Storage { action, path: path.to_owned(), source }
    }
}

/// Why a recording cannot be read.
#[derive(Debug, Error)]
pub enum ReadError {
    /// The file system refused.
    #[error("cannot {action} {}", path.display())]
    Storage {
        /// Action that was tried.
        action: &'static str,
        /// On which file or folder.
        path: PathBuf,
        /// Error of the file system.
        source: io::Error,
    },
    /// Neither a manifest nor the beginning of any segment can be read.
    #[error("{} is no recording: it has neither a manifest nor a segment that can be read. Give a folder session-… or one of its .mcap files", path.display())]
    NoHeader {
        /// The folder or file.
        path: PathBuf,
    },
    /// Recorded by software whose format is not read any more.
    #[error("the recording has format {found}, and this asphera reads {oldest} and newer")]
    TooOld {
        /// The recording's format.
        found: FormatVersion,
        /// The oldest major version read.
        oldest: MajorVersion,
    },
    /// Recorded by newer software.
    #[error(
        "the recording has format {found}, and this asphera reads up to {newest}: use a newer one"
    )]
    TooNew {
        /// The recording's format.
        found: FormatVersion,
        /// The newest version read.
        newest: FormatVersion,
    },
    /// A segment of another session lies in the folder. It is left out.
    #[error("{} belongs to session {found}, not to {expected}", path.display())]
    ForeignSegment {
        /// The segment.
        path: PathBuf,
        /// The session it belongs to.
        found: SessionId,
        /// The session read.
        expected: SessionId,
    },
}

impl ReadError {
    pub(super) fn storage(action: &'static str, path: &Path) -> impl FnOnce(io::Error) -> Self {
        move |source| ReadError::Storage { action, path: path.to_owned(), source }
    }
}
