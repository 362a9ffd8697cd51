//! Writing one segment: MCAP is encoded in memory, and goes to the file chunk by chunk.

use std::borrow::Cow;
use std::collections::BTreeMap;
use std::io::{self, Write};
use std::mem;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use asphera_link::{Flags, Nanos};
use mcap::records::MessageHeader;
use mcap::write::{Metadata, NoSeek};
use mcap::{Attachment, Compression, McapError, WriteOptions, Writer};

use super::format::{
    CONFIG_ATTACHMENT, ChannelId, MESSAGE_OVERHEAD_BYTES, PROFILE, SEGMENT_ATTACHMENT,
};
use super::header::SegmentHeader;
use super::points::{SCHEMA, SCHEMA_NAME};
use super::{LinkInfo, RecordError, Storage, StorageFile};

/// A segment being written.
///
/// The MCAP writer writes into memory only. So an error of the disk never reaches it: it cannot be
/// left half-way through a record, write after one that failed, or fail while it is dropped.
pub(super) struct SegmentWriter {
    writer: Writer<NoSeek<Pipe>>,
    pipe: Pipe,
    file: Box<dyn StorageFile>,
    path: PathBuf,
    file_bytes: u64,
    chunk_bytes: usize,
}

impl SegmentWriter {
    /// Makes the file, durable by name, and writes what stands before the first entry.
    pub(super) fn create(
        storage: &mut dyn Storage,
        path: PathBuf,
        header: &SegmentHeader,
        at: Nanos,
    ) -> Result<SegmentWriter, RecordError> {
        let file = storage.create(&path).map_err(RecordError::storage("create", &path))?;
        let folder = path.parent().unwrap_or(Path::new("."));
        storage.sync_dir(folder).map_err(RecordError::storage("sync", folder))?;
        let pipe = Pipe::default();
        let writer = begin(&pipe, header, at).map_err(RecordError::Encode)?;
        let mut segment = SegmentWriter { writer, pipe, file, path, file_bytes: 0, chunk_bytes: 0 };
        segment.close_chunk()?;
        Ok(segment)
    }

    /// Adds a message to the open chunk.
    pub(super) fn push(
        &mut self,
        channel: ChannelId,
        sequence: u64,
        at: Nanos,
        data: &[u8],
    ) -> Result<(), RecordError> {
        let header = MessageHeader {
            channel_id: channel.number(),
            // The low 32 bits: a reader carries the rest over.
            sequence: sequence as u32,
            log_time: at.as_nanos(),
            publish_time: at.as_nanos(),
        };
        self.writer.write_to_known_channel(&header, data).map_err(RecordError::Encode)?;
        self.chunk_bytes += MESSAGE_OVERHEAD_BYTES + data.len();
        Ok(())
    }

    /// Uncompressed size of the open chunk.
    pub(super) fn chunk_bytes(&self) -> usize {
        self.chunk_bytes
    }

    /// Bytes in the file.
    pub(super) fn file_bytes(&self) -> u64 {
        self.file_bytes
    }

    /// Closes the open chunk and hands it to the operating system.
    pub(super) fn close_chunk(&mut self) -> Result<(), RecordError> {
        self.writer.flush().map_err(RecordError::Encode)?;
        self.chunk_bytes = 0;
        self.drain()
    }

    /// Makes durable what the operating system has.
    pub(super) fn sync(&mut self) -> Result<(), RecordError> {
        self.file.sync_data().map_err(RecordError::storage("sync", &self.path))
    }

    /// Closes the open chunk, writes the summary and makes all of it durable. Nothing may follow.
    pub(super) fn finish(&mut self) -> Result<(), RecordError> {
        self.writer.finish().map_err(RecordError::Encode)?;
        self.chunk_bytes = 0;
        self.drain()?;
        self.sync()
    }

    fn drain(&mut self) -> Result<(), RecordError> {
        let mut bytes = mem::take(&mut *self.pipe.bytes());
        self.file.write_all(&bytes).map_err(RecordError::storage("write", &self.path))?;
        self.file_bytes += bytes.len() as u64;
        // Handed back for its capacity.
        bytes.clear();
        *self.pipe.bytes() = bytes;
        Ok(())
    }
}

/// Magic, header, attachments, metadata, and a chunk with nothing but the channels.
fn begin(
    pipe: &Pipe,
    header: &SegmentHeader,
    at: Nanos,
) -> Result<Writer<NoSeek<Pipe>>, McapError> {
    let session = &header.session;
    let mut writer = WriteOptions::new()
        .profile(PROFILE)
        .library(format!("asphera/{}", session.version))
        .compression(Some(Compression::Zstd))
        // In the caller's thread: with threads the bytes would depend on how many there are.
        .compression_threads(0)
        // The recorder decides when a chunk ends, by size and by time.
        .chunk_size(None)
        .disable_seeking(true)
        .create(NoSeek::new(pipe.clone()))?;
    let mut attach = |name: &str, media_type: &str, data: Cow<'_, [u8]>| {
        writer.attach(&Attachment {
            log_time: at.as_nanos(),
            create_time: u64::try_from(session.started_wall_ns).unwrap_or(0),
            name: name.to_owned(),
            media_type: media_type.to_owned(),
            data,
        })
    };
    let json = serde_json::to_vec(header).expect("a header is numbers and strings");
    attach(SEGMENT_ATTACHMENT, "application/json", json.into())?;
    attach(CONFIG_ATTACHMENT, "application/toml", session.config_toml.as_bytes().into())?;
    writer.write_metadata(&metadata(header))?;

    for (channel, topic, encoding) in
        [(ChannelId::Events, "/events", "json"), (ChannelId::Results, "/results", "json")]
    {
        writer.add_channel_with_id(channel.number(), 0, topic, encoding, &BTreeMap::new())?;
    }
    let schema = writer.add_schema(SCHEMA_NAME, "ros1msg", SCHEMA.as_bytes())?;
    let about =
        BTreeMap::from([("unit".to_owned(), "mm".to_owned()), ("flags".to_owned(), flag_names())]);
    writer.add_channel_with_id(ChannelId::Points.number(), schema, "/points", "ros1", &about)?;
    for (index, link) in session.links.iter().enumerate() {
        let about = BTreeMap::from([
            ("kind".to_owned(), link.kind.clone()),
            ("address".to_owned(), link.address.clone()),
        ]);
        for (channel, prefix) in [(ChannelId::Raw(index), "raw"), (ChannelId::Sent(index), "sent")]
        {
            let topic = format!("/{prefix}/{}", link.name);
            let encoding = "application/octet-stream";
            writer.add_channel_with_id(channel.number(), 0, &topic, encoding, &about)?;
        }
    }
    Ok(writer)
}

/// Meaning of the bits of a point's flags.
fn flag_names() -> String {
    let names = Flags::all().iter_names().map(|(name, flag)| format!("{} {name}", flag.bits()));
    names.collect::<Vec<_>>().join(", ").to_lowercase()
}

/// What `mcap info` shows. Nothing reads it back: metadata records have no checksum.
fn metadata(header: &SegmentHeader) -> Metadata {
    let session = &header.session;
    let link = |link: &LinkInfo| format!("{} ({} {})", link.name, link.kind, link.address);
    let entries = [
        ("format", header.format.to_string()),
        ("session", session.id.to_string()),
        ("segment", header.segment.to_string()),
        ("first_sequence", header.first_sequence.to_string()),
        ("station", session.station.clone()),
        ("software", session.version.clone()),
        ("started", session.started_rfc3339()),
        ("started_wall_ns", session.started_wall_ns.to_string()),
        ("links", session.links.iter().map(link).collect::<Vec<_>>().join(", ")),
    ];
    Metadata {
        name: PROFILE.to_owned(),
        metadata: entries.map(|(key, value)| (key.to_owned(), value)).into(),
    }
}

/// Where the MCAP writer writes, and the segment takes from.
#[derive(Clone, Default)]
struct Pipe(Arc<Mutex<Vec<u8>>>);

impl Pipe {
    fn bytes(&self) -> MutexGuard<'_, Vec<u8>> {
        // Whoever panicked left whole bytes: a vector is never half-way extended.
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl Write for Pipe {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.bytes().extend_from_slice(bytes);
        Ok(bytes.len())
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}
