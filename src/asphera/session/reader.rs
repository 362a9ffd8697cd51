//! Reading a session back.

use std::collections::VecDeque;
use std::fs;
use std::io::{self, ErrorKind};
use std::path::{Path, PathBuf};
use std::vec;

use asphera_link::Nanos;

use super::format::{MANIFEST, SEGMENT_ATTACHMENT, segment_number};
use super::header::{FormatOnly, SegmentHeader};
use super::records::{ChunkDecoder, Found, Message, Records, attachment, message_count};
use super::{Ended, Entry, FormatVersion, Header, Manifest, ReadError, What, message};

/// A recorded session: finished, interrupted, damaged, or still being recorded.
#[derive(Clone, Debug)]
pub struct Session {
    path: PathBuf,
    manifest: Manifest,
    manifest_damaged: bool,
    segments: Vec<PathBuf>,
    /// Sequence number to begin with, where it is known.
    first_sequence: Option<u64>,
}

/// Findings of reading a session, besides the entries.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Recovery {
    /// Entries read.
    pub entries: u64,
    /// Entries that are missing, by the gaps of their numbers. What an interrupted session had not yet
    /// handed to the operating system is not known to anyone and not counted.
    pub lost_at_least: u64,
    /// Segments without an end mark: the one being written when a session was interrupted, or truncated.
    pub torn_segments: u32,
    /// Places where a segment's bytes were damaged and passed over.
    pub damaged_places: u64,
    /// Entries of a newer minor version that this software does not know, left out.
    pub unknown: u64,
    /// Whether the manifest was missing or damaged, or did not agree with the segments.
    pub manifest_damaged: bool,
    /// How the session ended: by its entries, else by its manifest.
    pub ended: Ended,
}

impl Recovery {
    /// Whether the session is finished and every entry of it was read.
    pub fn is_whole(&self) -> bool {
        self.lost_at_least == 0
            && self.torn_segments == 0
            && self.damaged_places == 0
            && self.unknown == 0
            && !self.manifest_damaged
            && matches!(self.ended, Ended::Finished { .. })
    }
}

impl Session {
    /// Opens a session's folder, or one of its segments alone.
    ///
    /// What the session was is taken from the first segment that can tell, whose checksum is right;
    /// where none can, from the manifest. Fails if neither can, and for a format not read.
    pub fn open(path: &Path) -> Result<Session, ReadError> {
        let about = fs::metadata(path).map_err(ReadError::storage("open", path))?;
        let folder = about.is_dir();
        let segments = if folder { list_segments(path)? } else { vec![path.to_owned()] };
        let header = first_header(&segments)?;
        let manifest = if folder { read_manifest(path, header.is_some())? } else { None };
        let agrees = match (&header, &manifest) {
            (Some(header), Some(manifest)) => {
                header.session == manifest.session && header.format == manifest.format
            }
            _ => true,
        };
        let manifest_damaged = folder && (manifest.is_none() || !agrees);
        let first_sequence =
            if folder { Some(0) } else { header.as_ref().map(|of| of.first_sequence) };
        let manifest = match (header, manifest) {
            (Some(header), manifest) => Manifest {
                format: header.format,
                end: manifest.and_then(|manifest| manifest.end),
                ..Manifest::of(&header.session)
            },
            (None, Some(manifest)) => manifest,
            (None, None) => return Err(ReadError::NoHeader { path: path.to_owned() }),
        };
        let path = path.to_owned();
        Ok(Session { path, manifest, manifest_damaged, segments, first_sequence })
    }

    /// The folder or file.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// The manifest. Of a segment alone, and of a folder without manifest: what the segments tell.
    pub fn manifest(&self) -> &Manifest {
        &self.manifest
    }

    /// Data known when the session began.
    pub fn header(&self) -> &Header {
        &self.manifest.session
    }

    /// Version of the format it is recorded in.
    pub fn format(&self) -> FormatVersion {
        self.manifest.format
    }

    /// The configuration it was recorded with.
    pub fn config_toml(&self) -> &str {
        &self.manifest.session.config_toml
    }

    /// Segments that are there, in order.
    pub fn segments(&self) -> &[PathBuf] {
        &self.segments
    }

    /// How the session ended as its manifest tells. [`Recovery::ended`] knows better.
    pub fn ended(&self) -> Ended {
        self.manifest.end.as_ref().map_or(Ended::Interrupted, |end| end.ended.clone())
    }

    /// All entries, in the order they were appended, whatever is damaged left out.
    ///
    /// Holds one chunk in memory, which is at most a few entries longer than
    /// [`super::Settings::chunk_bytes`].
    pub fn entries(&self) -> Entries {
        Entries {
            header: self.header().clone(),
            promised: self.manifest.end.as_ref().map(|end| end.entries),
            segments: self.segments.clone().into_iter(),
            current: None,
            decoder: ChunkDecoder::new(),
            ready: VecDeque::new(),
            next_sequence: self.first_sequence,
            recovery: Recovery {
                entries: 0,
                lost_at_least: 0,
                torn_segments: 0,
                damaged_places: 0,
                unknown: 0,
                manifest_damaged: self.manifest_damaged,
                ended: self.ended(),
            },
        }
    }
}

/// The entries of a session, in order.
///
/// An error concerns one segment, which is left from there on; the next call goes on behind it.
pub struct Entries {
    header: Header,
    /// Entries the session has as its manifest tells; taken when compared.
    promised: Option<u64>,
    segments: vec::IntoIter<PathBuf>,
    current: Option<Segment>,
    decoder: ChunkDecoder,
    ready: VecDeque<Entry>,
    /// Number the next entry must have; `None` where any will do.
    next_sequence: Option<u64>,
    recovery: Recovery,
}

struct Segment {
    path: PathBuf,
    records: Records,
    messages: u64,
}

impl Entries {
    /// What was found so far; all of it once the iteration has ended.
    pub fn recovery(&self) -> &Recovery {
        &self.recovery
    }

    /// Reads on to the next chunk with an entry. `Ok(false)` at the end.
    fn fill(&mut self) -> Result<bool, ReadError> {
        while self.ready.is_empty() {
            let Some(mut segment) = self.current.take() else {
                let Some(path) = self.segments.next() else {
                    self.compare_with_manifest();
                    return Ok(false);
                };
                let records = self.tried(Records::open(&path), "open", &path)?;
                self.current = Some(Segment { path, records, messages: 0 });
                continue;
            };
            let found = segment.records.next();
            match self.tried(found, "read", &segment.path)? {
                None => {
                    self.recovery.damaged_places += segment.records.damaged();
                    self.recovery.torn_segments += u32::from(!segment.records.is_whole());
                    continue;
                }
                Some(Found::Attachment) => self.check_attachment(&mut segment)?,
                Some(Found::Statistics) => {
                    if message_count(segment.records.body()) != Some(segment.messages) {
                        self.recovery.damaged_places += 1;
                    }
                }
                Some(Found::Chunk) => {
                    if let Some(messages) = self.decoder.decode(segment.records.body()) {
                        segment.messages += messages.len() as u64;
                        messages.into_iter().for_each(|message| self.take(message));
                    } else {
                        let rejected = segment.records.reject();
                        self.tried(rejected, "read", &segment.path)?;
                    }
                }
            }
            self.current = Some(segment);
        }
        Ok(true)
    }

    fn check_attachment(&mut self, segment: &mut Segment) -> Result<(), ReadError> {
        let Some((name, data)) = attachment(segment.records.body()) else {
            let rejected = segment.records.reject();
            return self.tried(rejected, "read", &segment.path);
        };
        if name != SEGMENT_ATTACHMENT {
            return Ok(());
        }
        let Some(header) = parse_header(data)? else {
            self.recovery.damaged_places += 1;
            return Ok(());
        };
        if header.session.id != self.header.id {
            return Err(ReadError::ForeignSegment {
                path: segment.path.clone(),
                found: header.session.id,
                expected: self.header.id,
            });
        }
        self.expect(header.first_sequence);
        Ok(())
    }

    /// Counts as lost what should have come before the entry of this number.
    fn expect(&mut self, sequence: u64) {
        let next = self.next_sequence.unwrap_or(sequence);
        self.recovery.lost_at_least += sequence.saturating_sub(next);
        self.next_sequence = Some(next.max(sequence));
    }

    fn take(&mut self, message: Message) {
        let Message { header, data } = message;
        let next = self.next_sequence.unwrap_or(header.sequence.into());
        // Messages carry the low 32 bits. Between neighbours there is never half of that range.
        let ahead = header.sequence.wrapping_sub(next as u32);
        if ahead > u32::MAX / 2 {
            self.recovery.damaged_places += 1;
            return;
        }
        let sequence = next + u64::from(ahead);
        self.expect(sequence);
        self.next_sequence = Some(sequence + 1);
        let Some(what) = message::decode(header.channel_id, &data, &self.header.links) else {
            self.recovery.unknown += 1;
            return;
        };
        if let What::Finish { reason } = &what {
            self.recovery.ended = Ended::Finished { reason: reason.clone() };
        }
        self.recovery.entries += 1;
        self.ready.push_back(Entry { at: Nanos::from_nanos(header.log_time), what });
    }

    fn compare_with_manifest(&mut self) {
        if let Some(entries) = self.promised.take() {
            self.expect(entries);
        }
    }

    /// Counts a segment that the file system does not give as damaged.
    fn tried<T>(
        &mut self,
        result: io::Result<T>,
        action: &'static str,
        path: &Path,
    ) -> Result<T, ReadError> {
        result.map_err(|source| {
            self.recovery.damaged_places += 1;
            ReadError::storage(action, path)(source)
        })
    }
}

impl Iterator for Entries {
    type Item = Result<Entry, ReadError>;

    fn next(&mut self) -> Option<Result<Entry, ReadError>> {
        match self.fill() {
            Ok(_) => self.ready.pop_front().map(Ok),
            Err(error) => Some(Err(error)),
        }
    }
}

fn list_segments(folder: &Path) -> Result<Vec<PathBuf>, ReadError> {
    let mut segments = Vec::new();
    for entry in fs::read_dir(folder).map_err(ReadError::storage("list", folder))? {
        let path = entry.map_err(ReadError::storage("list", folder))?.path();
        let name = path.file_name().and_then(|name| name.to_str());
        if let Some(number) = name.and_then(segment_number) {
            segments.push((number, path));
        }
    }
    segments.sort();
    Ok(segments.into_iter().map(|(_, path)| path).collect())
}

fn read_manifest(folder: &Path, spare: bool) -> Result<Option<Manifest>, ReadError> {
    let path = folder.join(MANIFEST);
    let bytes = match fs::read(&path) {
        Ok(bytes) => bytes,
        Err(error) if error.kind() == ErrorKind::NotFound => return Ok(None),
        Err(error) => return Err(ReadError::storage("read", &path)(error)),
    };
    match Manifest::parse(&bytes) {
        // The segments, which have checksums, are of a format that is read: the manifest is wrong.
        Err(_) if spare => Ok(None),
        result => result,
    }
}

/// The header of the first segment that can tell.
fn first_header(segments: &[PathBuf]) -> Result<Option<SegmentHeader>, ReadError> {
    for path in segments {
        let mut records = Records::open(path).map_err(ReadError::storage("open", path))?;
        while let Some(Found::Attachment) =
            records.next().map_err(ReadError::storage("read", path))?
        {
            let Some((name, data)) = attachment(records.body()) else {
                records.reject().map_err(ReadError::storage("read", path))?;
                continue;
            };
            if name != SEGMENT_ATTACHMENT {
                continue;
            }
            if let Some(header) = parse_header(data)? {
                return Ok(Some(header));
            }
        }
    }
    Ok(None)
}

fn parse_header(json: &[u8]) -> Result<Option<SegmentHeader>, ReadError> {
    let Ok(FormatOnly { format }) = serde_json::from_slice(json) else { return Ok(None) };
    format.check_readable()?;
    Ok(serde_json::from_slice(json).ok())
}
