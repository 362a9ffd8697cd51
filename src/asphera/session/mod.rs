//! Recording a session and reading it back.
//!
//! A session is one measurement of one part. Its recording holds what the links received and sent,
//! in one total order, so that a replay hands the drivers exactly what the live run handed them.
//!
//! # On disk
//!
//! ```text
//! session-20261121T004006Z-0badcafe/     mode 0700
//!   manifest.json     written before the first segment, amended at the end; nothing needs it at close
//!   0000.mcap         segments of the recording, MCAP (https://mcap.dev/spec), readable one by one
//!   0001.mcap
//! ```
//!
//! A segment begins with the attachments `segment.json` (who, when, with what, and which number the
//! first entry has) and `config.toml` (the effective configuration), and with a metadata record for
//! people who look at it with `mcap info`. Then come chunks of messages:
//!
//! | topic          | what                                                        |
//! |----------------|-------------------------------------------------------------|
//! | `/raw/<link>`  | received bytes, one message a read; a CAN frame is 16 bytes, of CAN FD 72 |
//! | `/sent/<link>` | sent bytes                                                  |
//! | `/points`      | `sensor_msgs/PointCloud2` of ROS 1: the points made of them, mm  |
//! | `/events`      | JSON: opened, closed, command, held up, scan, finish        |
//! | `/results`     | JSON of the verdict                                         |
//!
//! `log_time` is nanoseconds since the station started, `sequence` counts all messages of the session
//! (modulo 2³²), so that a gap is a loss.
//!
//! # What survives what
//!
//! - Killed process: everything [`Counters::flushed`] counted.
//! - Power cut: everything [`Counters::durable`] counted; a disk that lies about `fdatasync` excepted.
//! - Torn tail, flipped bits: every chunk whose checksum is right is read, also after a damaged one.
//!   What is missing is counted in [`Recovery`].
//!
//! This module reads no clock: time is an argument. Reading and writing files blocks, so a caller
//! with an async runtime gives the recorder a thread of its own.

mod entry;
mod error;
mod format;
mod header;
mod manifest;
mod message;
mod points;
mod reader;
mod recorder;
mod records;
mod segment;
mod settings;
mod storage;
#[cfg(test)]
mod tests;

pub use entry::{Entry, ResultsJson, What};
pub use error::{ReadError, RecordError};
pub(crate) use format::MANIFEST;
pub use format::{FormatVersion, MajorVersion, MinorVersion};
pub use header::{Header, LinkInfo, SessionId};
pub use manifest::{Ended, Manifest, ManifestEnd};
pub use points::{PointCloud, RecordedPoint};
pub use reader::{Entries, Recovery, Session};
pub use recorder::{Counters, Recorder, Summary, Tally};
pub use settings::Settings;
pub use storage::{Disk, Storage, StorageFile};
