//! Points packed by LASzip (rapidlasso, "LAZ Specification 1.4 R1", 2022), unpacked by the crate `laz`.
//!
//! The crate trusts the file: it takes memory by sizes that a file claims, and it may panic on bytes that no packer wrote. So all
//! sizes are held against the bytes that are there first, the table of chunks is never given to it, and a panic becomes an error.
//!
//! ```text
//! where the chunks end, i64, or -1    then the last 8 bytes of the file say so
//! chunks                              of formats 0 to 5 one after the other, as many points in each as the record of LASzip says
//! table of chunks
//! ```
//!
//! A chunk of formats 6 to 10 is the first point as it is, the number of points as u32, the sizes of all layers as u32, the layers.

use std::io::{self, Read, Seek, SeekFrom};
use std::ops::Range;
use std::panic::{AssertUnwindSafe, catch_unwind};

use laz::laszip::{LazItem, LazItemType};
use laz::{LasZipDecompressor, LazItemRecordBuilder, LazVlr, LazVlrBuilder};

use super::{FORMAT, Header, SHORTEST, malformed};
use crate::{Place, ReadError};

/// Unpacks all points, in the order of the file, each as a record of LAS.
pub(super) fn each_record(
    header: &Header,
    bytes: &[u8],
    mut take: impl FnMut(&[u8]) -> Result<(), ReadError>,
) -> Result<(), ReadError> {
    let packing = Packing::read(header, bytes)?;
    let end = chunks_end(bytes, header.start)?;
    let begin = header.start + 8;
    // Measured points have digits that no packer can guess: each needs a bit at least.
    let room = (end - begin) as u64;
    if header.count > room.saturating_mul(MOST_POINTS_PER_BYTE) {
        let expected = format!("room for {} points", header.count);
        return Err(malformed(begin, &expected, format!("{room} bytes of packed points")));
    }
    let mut record = vec![0; header.record_len];
    let mut left = header.count;
    if !packing.is_layered {
        let mut stream = Stream(&bytes[begin..end]);
        unpack(&packing.items, packing.chunk_size, &mut stream, left, &mut record, &mut take)
            .map_err(|fault| fault.at(begin, header))?;
        return packing.check_rest(stream.0.len(), end, header);
    }
    let mut at = begin;
    while left > 0 {
        let (chunk, count) = packing.layered_chunk(bytes, at..end, header)?;
        let mut stream = Stream(&bytes[chunk.clone()]);
        let wanted = left.min(u64::from(count));
        unpack(&packing.items, count, &mut stream, wanted, &mut record, &mut take)
            .map_err(|fault| fault.at(at, header))?;
        left -= wanted;
        at = chunk.end;
    }
    packing.check_rest(end - at, end, header)
}

/// How the points are packed.
struct Packing {
    items: Vec<LazItem>,
    is_layered: bool,
    /// Points in a chunk; of layered chunks each says it itself.
    chunk_size: u32,
    /// Layers of a chunk.
    layers: usize,
}

impl Packing {
    fn read(header: &Header, bytes: &[u8]) -> Result<Packing, ReadError> {
        let (at, data) = laszip_record(header, bytes)?;
        let found = LazVlr::read_from(data).map_err(|error| unsupported(at, error.to_string()))?;
        let extra = header.record_len - usize::from(SHORTEST[usize::from(header.point_format)]);
        // Below 2¹⁶, as the length of a record is.
        let expected =
            LazItemRecordBuilder::default_for_point_format_id(header.point_format, extra as u16)
                .map_err(|error| unsupported(at, error.to_string()))?;
        let items = found.items().clone();
        let kinds = |items: &[LazItem]| -> Vec<(LazItemType, u16)> {
            items.iter().map(|item| (item.item_type(), item.size())).collect()
        };
        let is_layered = header.point_format >= 6;
        let versions = if is_layered { 3..=4 } else { 2..=2 };
        if kinds(&items) != kinds(&expected) {
            let found = "fields other than those of the format of the points";
            return Err(unsupported(at, found.into()));
        }
        if !items.iter().all(|item| versions.contains(&item.version()))
            || items.iter().any(|item| item.version() != items[0].version())
        {
            return Err(unsupported(at, "an old or unknown version of LASzip".into()));
        }
        // 2 is in chunks, 3 in chunks of layers.
        let packer = data.first_chunk().map(|packer| u16::from_le_bytes(*packer));
        if packer != Some(if is_layered { 3 } else { 2 }) {
            return Err(unsupported(at, format!("packer {}", packer.unwrap_or(0))));
        }
        if !is_layered && found.uses_variable_size_chunks() {
            return Err(unsupported(at, "chunks of different sizes".into()));
        }
        let layers = items.iter().map(|item| match item.item_type() {
            LazItemType::Point14 => POINT_LAYERS,
            LazItemType::RGBNIR14 => 2,
            LazItemType::Byte14(count) => usize::from(count),
            _ => 1,
        });
        let layers = layers.sum();
        Ok(Packing { items, is_layered, chunk_size: found.chunk_size(), layers })
    }

    /// Where the chunk at the start of `room` lies, and how many points it has.
    fn layered_chunk(
        &self,
        bytes: &[u8],
        room: Range<usize>,
        header: &Header,
    ) -> Result<(Range<usize>, u32), ReadError> {
        let ended = || {
            let expected = format!("a chunk of packed points, for the file says {}", header.count);
            malformed(room.start, &expected, format!("{} bytes", room.len()))
        };
        let (sizes, rest) = bytes[room.clone()]
            .get(header.record_len..)
            .and_then(|rest| rest.split_at_checked(4 * (1 + self.layers)))
            .ok_or_else(ended)?;
        let (sizes, _) = sizes.as_chunks::<4>();
        let mut sizes = sizes.iter().map(|size| u32::from_le_bytes(*size));
        let count = sizes.next().unwrap_or(0);
        let len: u64 = sizes.map(u64::from).sum();
        if len > rest.len() as u64 || count == 0 {
            return Err(ended());
        }
        // As many bytes are there.
        let end = room.end - rest.len() + len as usize;
        Ok((room.start..end, count))
    }

    /// After the last point nothing may be left before the table of chunks.
    fn check_rest(&self, left: usize, end: usize, header: &Header) -> Result<(), ReadError> {
        if left == 0 {
            return Ok(());
        }
        let expected = format!("no bytes after {} packed points", header.count);
        Err(malformed(end - left, &expected, format!("{left}")))
    }
}

/// Why points cannot be unpacked.
enum Fault {
    Packed(u64, String),
    Point(ReadError),
}

impl Fault {
    fn at(self, at: usize, header: &Header) -> ReadError {
        match self {
            Fault::Point(error) => error,
            Fault::Packed(index, found) => {
                let expected = format!("{} packed points in the chunks from here on", header.count);
                malformed(at, &expected, format!("{found} in number {}", index + 1))
            }
        }
    }
}

/// Unpacks `count` points of chunks of `chunk_size`.
fn unpack(
    items: &[LazItem],
    chunk_size: u32,
    stream: &mut Stream<'_>,
    count: u64,
    record: &mut [u8],
    take: &mut impl FnMut(&[u8]) -> Result<(), ReadError>,
) -> Result<(), Fault> {
    let vlr = LazVlrBuilder::new(items.to_vec()).with_fixed_chunk_size(chunk_size).build();
    // The crate passes over 8 bytes in the place of the table that it cannot seek.
    let source = Unseekable { skipped: &[0; 8], stream };
    let mut unpacker = guarded(|| LasZipDecompressor::new(source, vlr).map_err(|e| e.to_string()))
        .map_err(|found| Fault::Packed(0, found))?;
    for index in 0..count {
        guarded(|| unpacker.decompress_one(record).map_err(|error| error.to_string()))
            .map_err(|found| Fault::Packed(index, found))?;
        take(record).map_err(Fault::Point)?;
    }
    Ok(())
}

/// Runs the crate; a panic is an error as any other. What panicked is not used again.
fn guarded<T>(run: impl FnOnce() -> Result<T, String>) -> Result<T, String> {
    catch_unwind(AssertUnwindSafe(run))
        .unwrap_or_else(|_| Err("bytes that no packer writes".into()))
}

/// Remainder of the packed points.
struct Stream<'a>(&'a [u8]);

/// The packed points as the crate reads them: it is not to look for the table of chunks.
struct Unseekable<'a, 'b> {
    skipped: &'a [u8],
    stream: &'a mut Stream<'b>,
}

impl Read for Unseekable<'_, '_> {
    fn read(&mut self, into: &mut [u8]) -> io::Result<usize> {
        match self.skipped {
            [] => self.stream.0.read(into),
            _ => self.skipped.read(into),
        }
    }
}

impl Seek for Unseekable<'_, '_> {
    fn seek(&mut self, _: SeekFrom) -> io::Result<u64> {
        Err(io::ErrorKind::Unsupported.into())
    }
}

/// Where the chunks end and their table begins.
fn chunks_end(bytes: &[u8], start: usize) -> Result<usize, ReadError> {
    let number = |at: Option<usize>| {
        let found = at.and_then(|at| bytes.get(at..)?.first_chunk());
        found.map(|found| i64::from_le_bytes(*found))
    };
    let stated = match number(Some(start)) {
        Some(-1) => number(bytes.len().checked_sub(8)),
        stated => stated,
    };
    let end = stated.and_then(|end| usize::try_from(end).ok());
    // The table has a version and the number of chunks.
    let is_there =
        |end: &usize| (start + 8..).contains(end) && end.saturating_add(8) <= bytes.len();
    end.filter(is_there).ok_or_else(|| {
        let found = stated.map_or_else(|| "none".to_owned(), |end| format!("at byte {end}"));
        let expected = format!("a table of chunks within the {} bytes of the file", bytes.len());
        malformed(start, &expected, found)
    })
}

/// The record of variable length that says how points are packed, with its place.
fn laszip_record<'a>(header: &Header, bytes: &'a [u8]) -> Result<(usize, &'a [u8]), ReadError> {
    let mut at = header.len;
    for _ in 0..header.variable_records {
        let record = bytes.get(at..header.start.min(bytes.len())).unwrap_or_default();
        let Some((head, rest)) = record.split_at_checked(RECORD_HEAD) else { break };
        let len = usize::from(u16::from_le_bytes([head[20], head[21]]));
        let Some(data) = rest.get(..len) else { break };
        if head[2..18].starts_with(LazVlr::USER_ID.as_bytes())
            && u16::from_le_bytes([head[18], head[19]]) == LazVlr::RECORD_ID
        {
            return Ok((at + RECORD_HEAD, data));
        }
        at += RECORD_HEAD + len;
    }
    Err(malformed(at, "a record \"laszip encoded\" before compressed points", "none".into()))
}

fn unsupported(at: usize, found: String) -> ReadError {
    ReadError::Unsupported {
        format: FORMAT,
        place: Place::Byte(at as u64),
        expected: "points packed by LASzip 2 or later in chunks (write the file as .las with another program)".into(),
        found,
    }
}

/// Bytes of a record of variable length before its data.
const RECORD_HEAD: usize = 54;
/// Layers of a point without colours, waves and extra bytes.
const POINT_LAYERS: usize = 9;
const MOST_POINTS_PER_BYTE: u64 = 64;
