//! Finding the records of a segment, whole or damaged.
//!
//! MCAP has no marks to find the next record by once a length is damaged. But every chunk of ours
//! holds the word `zstd` at a fixed place and its length twice, and what looks like a chunk by chance
//! is found out by its checksum. So reading goes on at the next chunk.

use std::fs::File;
use std::io;
use std::os::unix::fs::FileExt;
use std::path::Path;

use mcap::MAGIC;
use mcap::records::{MessageHeader, Record, op};
use mcap::sans_io::linear_reader::{LinearReadEvent, LinearReader, LinearReaderOptions};

use super::format::MAX_RECORD_BYTES;

/// The records of one segment that carry something to read.
pub(super) struct Records {
    file: File,
    /// Where the next record begins.
    at: u64,
    /// Where the record given last begins.
    last: u64,
    /// Length of the file when it was opened.
    end: u64,
    body: Vec<u8>,
    /// Places where bytes had to be passed over.
    damaged: u64,
    saw_footer: bool,
    whole: bool,
}

/// What kind of record was found; its content is [`Records::body`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Found {
    Attachment,
    Chunk,
    Statistics,
}

impl Records {
    pub(super) fn open(path: &Path) -> io::Result<Records> {
        let file = File::open(path)?;
        let end = file.metadata()?.len();
        let mut records = Records {
            file,
            at: MAGIC.len() as u64,
            last: 0,
            end,
            body: Vec::new(),
            damaged: 0,
            saw_footer: false,
            whole: false,
        };
        if !records.magic_at(0)? {
            records.pass_over(0)?;
        }
        Ok(records)
    }

    /// The next record of interest; `None` at the end or where nothing more can be found.
    pub(super) fn next(&mut self) -> io::Result<Option<Found>> {
        while self.at < self.end {
            if self.saw_footer && self.at + MAGIC.len() as u64 == self.end {
                self.whole = self.magic_at(self.at)?;
                self.at = self.end;
                break;
            }
            let Some((opcode, len)) = self.head_at(self.at)? else {
                self.pass_over(self.at)?;
                continue;
            };
            self.last = self.at;
            self.at += HEAD_BYTES + len;
            let found = match opcode {
                op::ATTACHMENT => Found::Attachment,
                op::CHUNK => Found::Chunk,
                op::STATISTICS => Found::Statistics,
                op::FOOTER => {
                    self.saw_footer = true;
                    continue;
                }
                _ => continue,
            };
            let len = usize::try_from(len).map_err(io::Error::other)?;
            self.body.resize(len, 0);
            self.file.read_exact_at(&mut self.body, self.last + HEAD_BYTES)?;
            return Ok(Some(found));
        }
        Ok(None)
    }

    /// Content of the record given last.
    pub(super) fn body(&self) -> &[u8] {
        &self.body
    }

    /// Takes the record given last as damaged. Where its length seems damaged too, the next chunk is
    /// searched from its beginning.
    pub(super) fn reject(&mut self) -> io::Result<()> {
        let ends_well = self.at == self.end
            || (self.at + MAGIC.len() as u64 == self.end && self.magic_at(self.at)?)
            || self.head_at(self.at)?.is_some();
        if ends_well {
            self.damaged += 1;
            return Ok(());
        }
        self.pass_over(self.last)
    }

    /// Places where bytes had to be passed over, a torn end not counted.
    pub(super) fn damaged(&self) -> u64 {
        self.damaged
    }

    /// Whether the end mark was found: the segment was closed.
    pub(super) fn is_whole(&self) -> bool {
        self.whole
    }

    /// Opcode and length of a record, if there can be one at `at`.
    fn head_at(&self, at: u64) -> io::Result<Option<(u8, u64)>> {
        if self.end.saturating_sub(at) < HEAD_BYTES {
            return Ok(None);
        }
        let mut head = [0; HEAD_BYTES as usize];
        self.file.read_exact_at(&mut head, at)?;
        let [opcode, len @ ..] = head;
        let len = u64::from_le_bytes(len);
        let known = (op::HEADER..=op::DATA_END).contains(&opcode) || opcode >= FIRST_PRIVATE;
        let fits = len <= MAX_RECORD_BYTES as u64 && len <= self.end - at - HEAD_BYTES;
        Ok((known && fits).then_some((opcode, len)))
    }

    fn magic_at(&self, at: u64) -> io::Result<bool> {
        if self.end.saturating_sub(at) < MAGIC.len() as u64 {
            return Ok(false);
        }
        let mut magic = [0; MAGIC.len()];
        self.file.read_exact_at(&mut magic, at)?;
        Ok(magic == *MAGIC)
    }

    /// Goes on at the first chunk that begins after `from`, or to the end.
    fn pass_over(&mut self, from: u64) -> io::Result<()> {
        let mut window = Vec::new();
        let mut begin = from + 1;
        while begin + CHUNK_SIGNATURE_BYTES as u64 <= self.end {
            let len = (self.end - begin).min(WINDOW_BYTES);
            window.resize(usize::try_from(len).map_err(io::Error::other)?, 0);
            self.file.read_exact_at(&mut window, begin)?;
            for (offset, candidate) in (begin..).zip(window.windows(CHUNK_SIGNATURE_BYTES)) {
                if looks_like_chunk(candidate, self.end - offset) {
                    self.damaged += 1;
                    self.at = offset;
                    return Ok(());
                }
            }
            begin += len - (CHUNK_SIGNATURE_BYTES as u64 - 1);
        }
        self.at = self.end;
        Ok(())
    }
}

/// Whether a chunk record of ours can begin here, with `left` bytes to the end of the file.
fn looks_like_chunk(bytes: &[u8], left: u64) -> bool {
    if bytes[0] != op::CHUNK || bytes[37..45] != *ZSTD {
        return false;
    }
    let number = |at: usize| {
        bytes[at..at + 8].iter().rev().fold(0u64, |number, byte| number << 8 | u64::from(*byte))
    };
    let (len, compressed) = (number(1), number(45));
    len <= left - HEAD_BYTES && compressed.checked_add(CHUNK_HEADER_BYTES as u64) == Some(len)
}

/// Decodes chunks, one after the other.
pub(super) struct ChunkDecoder {
    reader: LinearReader,
}

/// One message of a chunk.
#[derive(Debug)]
pub(super) struct Message {
    pub(super) header: MessageHeader,
    pub(super) data: Vec<u8>,
}

impl ChunkDecoder {
    pub(super) fn new() -> ChunkDecoder {
        let options = LinearReaderOptions::default()
            .with_skip_start_magic(true)
            .with_skip_end_magic(true)
            .with_prevalidate_chunk_crcs(true)
            .with_record_length_limit(MAX_RECORD_BYTES);
        ChunkDecoder { reader: LinearReader::new_with_options(options) }
    }

    /// All messages of a chunk, or `None` if anything about it is damaged.
    pub(super) fn decode(&mut self, body: &[u8]) -> Option<Vec<Message>> {
        let messages = self.messages(body);
        if messages.is_none() {
            // It may wait for the rest of the damaged chunk.
            *self = ChunkDecoder::new();
        }
        messages
    }

    fn messages(&mut self, body: &[u8]) -> Option<Vec<Message>> {
        let uncompressed = checked_size(body)?;
        let record = self.reader.insert(HEAD_BYTES as usize + body.len());
        record[0] = op::CHUNK;
        record[1..9].copy_from_slice(&(body.len() as u64).to_le_bytes());
        record[9..].copy_from_slice(body);
        self.reader.notify_read(HEAD_BYTES as usize + body.len());

        let mut messages = Vec::new();
        let mut seen = 0;
        while let Some(event) = self.reader.next_event() {
            match event.ok()? {
                LinearReadEvent::ReadRequest(_) => break,
                LinearReadEvent::Record { opcode, data } => {
                    seen += HEAD_BYTES + data.len() as u64;
                    if opcode == op::MESSAGE {
                        let Ok(Record::Message { header, data }) = mcap::parse_record(opcode, data)
                        else {
                            return None;
                        };
                        messages.push(Message { header, data: data.into_owned() });
                    }
                }
            }
        }
        (seen == uncompressed).then_some(messages)
    }
}

/// Uncompressed size of a chunk of the one shape we write, `None` for any other.
///
/// ```text
/// 0         8       16             24   28  32      36               44
/// │ start   │ end   │ uncompressed │crc │ 4 │ z s t d │ compressed   │ … │
/// ```
///
/// A checksum of 0 means "none" to MCAP's readers. One chunk in 2³² has it by right; taking it as
/// damaged is better than not checking any chunk whose checksum was zeroed.
fn checked_size(body: &[u8]) -> Option<u64> {
    let number = |at: usize| Some(u64::from_le_bytes(*body.get(at..)?.first_chunk()?));
    let fits = *body.get(28..36)? == *ZSTD
        && *body.get(24..28)? != [0; 4]
        && number(36)? == (body.len() - CHUNK_HEADER_BYTES) as u64;
    number(16).filter(|size| fits && *size <= MAX_RECORD_BYTES as u64)
}

/// Name and content of an attachment whose checksum is right.
pub(super) fn attachment(body: &[u8]) -> Option<(String, &[u8])> {
    // Log time 8, create time 8, then name, media type and data, each after its length, and a
    // checksum 4. The lengths are added up first: `mcap::parse_record` panics where they do not fit.
    let length = |at: usize| Some(u32::from_le_bytes(*body.get(at..)?.first_chunk()?) as usize);
    let media_type = 20usize.checked_add(length(16)?)?;
    let begin = media_type.checked_add(4)?.checked_add(length(media_type)?)?.checked_add(8)?;
    if begin.checked_add(4)? > body.len() {
        return None;
    }
    match mcap::parse_record(op::ATTACHMENT, body).ok()? {
        Record::Attachment { header, crc, data: content } if crc != 0 => {
            Some((header.name, body.get(begin..begin + content.len())?))
        }
        _ => None,
    }
}

/// Number of messages a statistics record tells.
pub(super) fn message_count(body: &[u8]) -> Option<u64> {
    match mcap::parse_record(op::STATISTICS, body).ok()? {
        Record::Statistics(statistics) => Some(statistics.message_count),
        _ => None,
    }
}

/// Opcode 1, length 8.
const HEAD_BYTES: u64 = 9;

/// First opcode of those MCAP leaves to applications.
const FIRST_PRIVATE: u8 = 0x80;

/// Chunk record up to its compressed data, opcode and length not counted.
const CHUNK_HEADER_BYTES: usize = 44;

/// What [`looks_like_chunk`] needs to see.
const CHUNK_SIGNATURE_BYTES: usize = HEAD_BYTES as usize + CHUNK_HEADER_BYTES;

/// The compression as a chunk header names it: length 4, then the word.
const ZSTD: &[u8; 8] = b"\x04\0\0\0zstd";

/// How much is searched at a time.
const WINDOW_BYTES: u64 = 1 << 20;
