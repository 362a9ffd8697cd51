//! Recording a session.

use std::path::{Path, PathBuf};
use std::time::Duration;

use asphera_link::Nanos;

use super::format::{MAX_MESSAGE_BYTES, MESSAGE_OVERHEAD_BYTES, segment_name};
use super::header::SegmentHeader;
use super::segment::SegmentWriter;
use super::{
    Ended, Entry, FormatVersion, Header, Manifest, ManifestEnd, RecordError, ResultsJson, Settings,
    Storage, What, message,
};

/// Writes a session into a folder of its own.
///
/// Entries are written in the order of [`Recorder::append`]. Between entries the caller calls
/// [`Recorder::tick`] at the time [`Recorder::poll_timeout`] asks for, so that a quiet link's last
/// bytes become durable too. Every call may write and wait for the disk.
///
/// After an error of the disk the recorder has stopped, and every call fails with
/// [`RecordError::Stopped`]: what an operating system does with pages it failed to write is not to be
/// relied on, so nothing is written after them. A new recorder can be created.
///
/// Dropped without [`Recorder::finish`], it writes what it has, and the session is an interrupted one.
pub struct Recorder {
    folder: PathBuf,
    header: Header,
    settings: Settings,
    storage: Box<dyn Storage>,
    state: State,
    counters: Counters,
    /// Free space when last looked.
    free_bytes: u64,
    /// Time of the oldest entry the operating system does not have.
    first_unflushed: Option<Nanos>,
    /// Time of the oldest entry that is not durable.
    first_undurable: Option<Nanos>,
    /// Segments begun.
    segments: u32,
    /// Bytes of all segments that are closed.
    closed_bytes: u64,
}

/// How far entries have come. Each is part of the one before.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Counters {
    /// Taken by [`Recorder::append`]. A killed process may lose those that are not flushed.
    pub appended: Tally,
    /// Handed to the operating system. A power cut may lose those that are not durable.
    pub flushed: Tally,
    /// On the disk: `fdatasync` returned.
    pub durable: Tally,
}

/// A number of entries and of their bytes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Tally {
    /// Entries, finish and results among them.
    pub entries: u64,
    /// Bytes of their messages: what was received and sent, and the JSON of events and results.
    pub bytes: u64,
}

/// Amounts recorded.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Summary {
    /// The session's folder.
    pub folder: PathBuf,
    /// Number of segments.
    pub segments: u32,
    /// Entries and bytes, all durable.
    pub recorded: Tally,
    /// Size of all segments, bytes.
    pub file_bytes: u64,
}

enum State {
    Recording { segment: Box<SegmentWriter>, began: Nanos },
    Stopped,
}

impl Recorder {
    /// Makes the session's folder ([`Header::folder_name`]) in `parent`, which must be there, with its
    /// manifest and its first segment. `now` is the time of the beginning on the station's clock.
    ///
    /// When it fails the folder may be left behind, without any entry.
    pub fn create(
        parent: &Path,
        header: Header,
        settings: Settings,
        mut storage: Box<dyn Storage>,
        now: Nanos,
    ) -> Result<Recorder, RecordError> {
        header.check()?;
        settings.check()?;
        let free_bytes = free_bytes(storage.as_mut(), parent)?;
        if free_bytes < settings.reserve_bytes {
            return Err(RecordError::DiskReserve {
                path: parent.to_owned(),
                free_bytes,
                wanted_bytes: settings.reserve_bytes,
            });
        }
        let folder = parent.join(header.folder_name());
        storage.create_dir(&folder).map_err(RecordError::storage("create", &folder))?;
        storage.sync_dir(parent).map_err(RecordError::storage("sync", parent))?;
        Manifest::of(&header).write(storage.as_mut(), &folder)?;
        let mut recorder = Recorder {
            folder,
            header,
            settings,
            storage,
            state: State::Stopped,
            counters: Counters::default(),
            free_bytes,
            first_unflushed: None,
            first_undurable: None,
            segments: 0,
            closed_bytes: 0,
        };
        recorder.begin_segment(now)?;
        Ok(recorder)
    }

    /// Appends an entry. Its time is also taken for now: what is due by then is done first.
    ///
    /// O(bytes); closes a chunk, and now and then a segment. If it fails, [`Recorder::counters`] tell
    /// whether the entry was taken.
    pub fn append(&mut self, entry: &Entry) -> Result<(), RecordError> {
        if matches!(entry.what, What::Finish { .. } | What::Results(_)) {
            return Err(RecordError::OnlyByFinish);
        }
        let links = self.header.links.len();
        if let Some(link) = entry.what.link().filter(|link| *link >= links) {
            return Err(RecordError::UnknownLink { link, links });
        }
        let result = self.append_checked(entry);
        self.settle(result)
    }

    /// Does what is due: closes a chunk that is old enough, makes durable what has waited long enough,
    /// and stops in good order with [`RecordError::DiskReserve`] when free space runs out.
    pub fn tick(&mut self, now: Nanos) -> Result<(), RecordError> {
        let result = self.advance(now);
        self.settle(result)
    }

    /// When [`Recorder::tick`] is to be called, if at all.
    #[must_use]
    pub fn poll_timeout(&self) -> Option<Nanos> {
        if matches!(self.state, State::Stopped) {
            return None;
        }
        let chunk = self.first_unflushed.map(|first| first + self.chunk_age());
        let sync = self.first_undurable.map(|first| first + self.sync_age());
        chunk.into_iter().chain(sync).min()
    }

    /// Makes everything appended durable now.
    pub fn sync(&mut self) -> Result<(), RecordError> {
        let result = self.flush().and_then(|()| self.sync_flushed());
        self.settle(result)
    }

    /// Ends the session: records why and the results, makes everything durable and amends the manifest.
    /// This also runs below the disk reserve, which is there for it.
    ///
    /// Results longer than 16 MiB are left out: the session is finished without them, and the error is
    /// [`RecordError::EntryTooLarge`].
    pub fn finish(
        mut self,
        now: Nanos,
        reason: &str,
        results: Option<&ResultsJson>,
    ) -> Result<Summary, RecordError> {
        let size = results.map_or(0, |results| results.as_str().len());
        let fitting = results.filter(|_| size <= MAX_MESSAGE_BYTES);
        let result = self.write_end(now, reason, fitting);
        self.settle(result)?;
        if size > MAX_MESSAGE_BYTES {
            return Err(RecordError::EntryTooLarge { bytes: size, limit: MAX_MESSAGE_BYTES });
        }
        Ok(Summary {
            folder: self.folder.clone(),
            segments: self.segments,
            recorded: self.counters.durable,
            file_bytes: self.closed_bytes,
        })
    }

    /// How far entries have come.
    pub fn counters(&self) -> Counters {
        self.counters
    }

    /// The session's folder.
    pub fn folder(&self) -> &Path {
        &self.folder
    }

    /// Free space when last looked, bytes: an alarm can come before the reserve is reached.
    pub fn free_bytes(&self) -> u64 {
        self.free_bytes
    }

    /// Whether the recorder has stopped at an error.
    pub fn is_stopped(&self) -> bool {
        matches!(self.state, State::Stopped)
    }

    fn write_end(
        &mut self,
        now: Nanos,
        reason: &str,
        results: Option<&ResultsJson>,
    ) -> Result<(), RecordError> {
        self.push(&Entry { at: now, what: What::Finish { reason: reason.to_owned() } })?;
        if let Some(results) = results {
            self.push(&Entry { at: now, what: What::Results(results.clone()) })?;
        }
        self.close(now, Ended::Finished { reason: reason.to_owned() })
    }

    fn append_checked(&mut self, entry: &Entry) -> Result<(), RecordError> {
        self.advance(entry.at)?;
        self.rotate_if_due(entry.at)?;
        self.push(entry)?;
        if self.settings.sync_ms == 0 {
            self.flush()?;
            self.sync_flushed()?;
        }
        Ok(())
    }

    fn advance(&mut self, now: Nanos) -> Result<(), RecordError> {
        self.segment()?;
        if self.free_bytes < self.settings.reserve_bytes {
            return self.stop_at_reserve(now);
        }
        let due =
            |first: Option<Nanos>, age: Duration| first.is_some_and(|first| now >= first + age);
        if due(self.first_undurable, self.sync_age()) {
            self.flush()?;
            self.sync_flushed()
        } else if due(self.first_unflushed, self.chunk_age()) {
            self.flush()
        } else {
            Ok(())
        }
    }

    fn rotate_if_due(&mut self, now: Nanos) -> Result<(), RecordError> {
        let State::Recording { segment, began } = &self.state else {
            return Err(RecordError::Stopped);
        };
        let age = Duration::from_secs(self.settings.segment_s.into());
        if segment.file_bytes() < self.settings.segment_bytes && now < *began + age {
            return Ok(());
        }
        self.end_segment()?;
        self.begin_segment(now)
    }

    /// Encodes an entry into the open chunk, which is closed before where the entry would not fit and
    /// after where it is full.
    fn push(&mut self, entry: &Entry) -> Result<(), RecordError> {
        let limit = self.settings.chunk_bytes as usize;
        let (channel, data) = message::encode(&entry.what, &self.header.links);
        if data.len() > MAX_MESSAGE_BYTES {
            return Err(RecordError::EntryTooLarge { bytes: data.len(), limit: MAX_MESSAGE_BYTES });
        }
        let open = self.segment()?.chunk_bytes();
        if open > 0 && open + data.len() + MESSAGE_OVERHEAD_BYTES > limit {
            self.flush()?;
        }
        let sequence = self.counters.appended.entries;
        let segment = self.segment()?;
        segment.push(channel, sequence, entry.at, &data)?;
        let full = segment.chunk_bytes() >= limit;
        self.counters.appended.entries += 1;
        self.counters.appended.bytes += data.len() as u64;
        self.first_unflushed.get_or_insert(entry.at);
        self.first_undurable.get_or_insert(entry.at);
        if full { self.flush() } else { Ok(()) }
    }

    fn flush(&mut self) -> Result<(), RecordError> {
        self.segment()?.close_chunk()?;
        self.counters.flushed = self.counters.appended;
        self.first_unflushed = None;
        self.free_bytes = free_bytes(self.storage.as_mut(), &self.folder)?;
        Ok(())
    }

    fn sync_flushed(&mut self) -> Result<(), RecordError> {
        self.segment()?.sync()?;
        self.counters.durable = self.counters.flushed;
        self.first_undurable = None;
        Ok(())
    }

    fn begin_segment(&mut self, now: Nanos) -> Result<(), RecordError> {
        let header = SegmentHeader {
            format: FormatVersion::CURRENT,
            session: self.header.clone(),
            segment: self.segments,
            first_sequence: self.counters.appended.entries,
        };
        let path = self.folder.join(segment_name(self.segments));
        let segment = SegmentWriter::create(self.storage.as_mut(), path, &header, now)?;
        self.segments += 1;
        self.state = State::Recording { segment: Box::new(segment), began: now };
        Ok(())
    }

    fn end_segment(&mut self) -> Result<(), RecordError> {
        let segment = self.segment()?;
        segment.finish()?;
        self.closed_bytes += self.segment()?.file_bytes();
        self.counters.flushed = self.counters.appended;
        self.counters.durable = self.counters.appended;
        self.first_unflushed = None;
        self.first_undurable = None;
        self.state = State::Stopped;
        Ok(())
    }

    fn close(&mut self, now: Nanos, ended: Ended) -> Result<(), RecordError> {
        self.end_segment()?;
        let end = ManifestEnd {
            at_ns: now.as_nanos(),
            ended,
            entries: self.counters.durable.entries,
            segments: self.segments,
        };
        let manifest = Manifest { end: Some(end), ..Manifest::of(&self.header) };
        manifest.write(self.storage.as_mut(), &self.folder)
    }

    fn stop_at_reserve(&mut self, now: Nanos) -> Result<(), RecordError> {
        let error = RecordError::DiskReserve {
            path: self.folder.clone(),
            free_bytes: self.free_bytes,
            wanted_bytes: self.settings.reserve_bytes,
        };
        self.close(now, Ended::Stopped { reason: error.to_string() })?;
        Err(error)
    }

    fn segment(&mut self) -> Result<&mut SegmentWriter, RecordError> {
        match &mut self.state {
            State::Recording { segment, .. } => Ok(segment),
            State::Stopped => Err(RecordError::Stopped),
        }
    }

    /// Stops after an error that leaves the file in an unknown state.
    fn settle(&mut self, result: Result<(), RecordError>) -> Result<(), RecordError> {
        if let Err(RecordError::Storage { .. } | RecordError::Encode(_)) = result {
            self.state = State::Stopped;
        }
        result
    }

    fn chunk_age(&self) -> Duration {
        Duration::from_millis(self.settings.chunk_ms.into())
    }

    fn sync_age(&self) -> Duration {
        Duration::from_millis(self.settings.sync_ms.into())
    }
}

impl Drop for Recorder {
    fn drop(&mut self) {
        // There is nobody to tell: a reader finds an interrupted session with what could be written.
        let _ = self.end_segment();
    }
}

fn free_bytes(storage: &mut dyn Storage, path: &Path) -> Result<u64, RecordError> {
    storage.free_bytes(path).map_err(RecordError::storage("ask for the free space of", path))
}
