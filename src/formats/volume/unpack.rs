//! Packed samples: gzip (RFC 1952) and zlib (RFC 1950). Memory grows with what comes out, and ends where the claimed size does.

use std::io::Read;

use flate2::read::{MultiGzDecoder, ZlibDecoder};

use crate::{Format, Place, ReadError};

/// How bytes are packed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Packing {
    Gzip,
    Zlib,
}

pub(super) fn is_gzip(bytes: &[u8]) -> bool {
    bytes.starts_with(&[0x1F, 0x8B])
}

/// The first `limit` bytes that come out, or all where there are fewer.
pub(super) fn unpacked(
    format: Format,
    place: u64,
    bytes: &[u8],
    packing: Packing,
    limit: u64,
) -> Result<Vec<u8>, ReadError> {
    unpacked_and_more(format, place, bytes, packing, limit).map(|(out, _)| out)
}

/// The first `limit` bytes that come out, and how many follow.
pub(super) fn unpacked_and_more(
    format: Format,
    place: u64,
    bytes: &[u8],
    packing: Packing,
    limit: u64,
) -> Result<(Vec<u8>, u64), ReadError> {
    let mut out = Vec::new();
    let mut unpacker: Box<dyn Read + '_> = match packing {
        Packing::Gzip => Box::new(MultiGzDecoder::new(bytes)),
        Packing::Zlib => Box::new(ZlibDecoder::new(bytes)),
    };
    let done = (&mut unpacker).take(limit).read_to_end(&mut out);
    done.map_err(|error| ReadError::Malformed {
        format,
        place: Place::Byte(place),
        expected: match packing {
            Packing::Gzip => "samples packed by gzip".into(),
            Packing::Zlib => "samples packed by zlib".into(),
        },
        found: format!("{error} after {} bytes", out.len()),
    })?;
    let more = if out.len() as u64 == limit { count_more(&mut unpacker) } else { 0 };
    Ok((out, more))
}

/// How many bytes a reader still gives, as far as it can be read: what follows packed samples may be no packed bytes.
pub(super) fn count_more(reader: &mut impl Read) -> u64 {
    let mut some = [0; 1 << 12];
    let mut more = 0;
    while let Ok(count @ 1..) = reader.read(&mut some) {
        more += count as u64;
    }
    more
}

/// Exactly `expected` bytes, or why there are not as many.
pub(super) fn exactly(
    format: Format,
    place: u64,
    mut bytes: Vec<u8>,
    expected: usize,
) -> Result<Vec<u8>, ReadError> {
    if bytes.len() < expected {
        return Err(ReadError::Malformed {
            format,
            place: Place::Byte(place),
            expected: format!("{expected} bytes of samples"),
            found: format!("{}", bytes.len()),
        });
    }
    bytes.truncate(expected);
    Ok(bytes)
}
