//! Points that memory has no room for: they wait in a file beside the recording, and come back in their order.
//!
//! All that they were made of is recorded before, so the file is of no use after the session: it has no name, and ends with the process.
//!
//! Layout of a point, 72 bytes, numbers with their lowest byte first:
//!
//! | at | bytes | content |
//! |---|---|---|
//! | 0 | 8 | count, 0 without one |
//! | 8 | 8 | time of its reading, ns |
//! | 16 | 4 | flags |
//! | 20 | 4 | 1 where it has a count |
//! | 24 | 24 | place, mm |
//! | 48 | 24 | standard uncertainty, mm |

use std::fs::{File, OpenOptions, remove_file};
use std::io;
use std::os::unix::fs::{FileExt as _, OpenOptionsExt as _};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use asphera_link::{Flags, Nanos};

use super::backlog::POINTS;
use crate::session::{Disk, Storage as _};
use crate::station::Point;

/// Points in a file, first in, first out. Clones are the same.
#[derive(Clone)]
pub(super) struct Overflow {
    shared: Arc<Shared>,
    /// Points that memory has room for.
    room_points: usize,
}

struct Shared {
    folder: PathBuf,
    /// Free space that is left to the recording, bytes.
    spared_bytes: u64,
    /// Points in the file.
    waiting: AtomicU64,
    file: Mutex<Spill>,
}

/// The file, and how far it is written and read, points.
#[derive(Default)]
struct Spill {
    file: Option<File>,
    written: u64,
    read: u64,
    /// Size at which the free space is looked at next, bytes.
    checked_at: u64,
}

impl Overflow {
    /// A file in a folder, made when it is needed. So much of the disk is left free beside it, and some for the recording.
    pub(super) fn beside(folder: &Path, reserve_bytes: u64) -> Overflow {
        let shared = Shared {
            folder: folder.to_owned(),
            spared_bytes: reserve_bytes.saturating_add(RECORDING_BYTES),
            waiting: AtomicU64::new(0),
            file: Mutex::default(),
        };
        Overflow { shared: Arc::new(shared), room_points: POINTS }
    }

    /// The same beside a memory with room for so many points.
    #[cfg(test)]
    pub(super) fn beyond(self, room_points: usize) -> Overflow {
        Overflow { room_points, ..self }
    }

    /// Points that memory has room for: what is beyond waits in the file.
    pub(super) fn room_points(&self) -> usize {
        self.room_points
    }

    /// Whether points wait in the file.
    pub(super) fn is_waiting(&self) -> bool {
        self.shared.waiting.load(Ordering::Acquire) > 0
    }

    /// Appends points. It may wait for the disk. None of them are in the file where it fails.
    ///
    /// # Errors
    ///
    /// Those of the disk, and [`io::ErrorKind::StorageFull`] where the rest of it is the recording's.
    pub(super) fn append(&self, points: &[Point]) -> io::Result<()> {
        let mut spill = self.spill();
        let mut bytes = Vec::with_capacity(points.len() * POINT_BYTES);
        points.iter().for_each(|point| write(point, &mut bytes));
        let at = spill.written * POINT_BYTES as u64;
        if spill.file.is_none() {
            spill.file = Some(self.create()?);
        }
        if at + bytes.len() as u64 > spill.checked_at {
            if Disk.free_bytes(&self.shared.folder)? < self.shared.spared_bytes {
                return Err(io::ErrorKind::StorageFull.into());
            }
            spill.checked_at = at + CHECKED_BYTES;
        }
        if let Some(file) = &spill.file {
            file.write_all_at(&bytes, at)?;
        }
        spill.written += points.len() as u64;
        self.shared.waiting.fetch_add(points.len() as u64, Ordering::Release);
        Ok(())
    }

    /// Takes the oldest points out of the file, not too many; none where none wait. It may wait for the disk.
    ///
    /// # Errors
    ///
    /// Those of the disk.
    pub(super) fn take(&self) -> io::Result<Vec<Point>> {
        let mut spill = self.spill();
        let count = (spill.written - spill.read).min(BLOCK);
        let Some(file) = spill.file.as_ref().filter(|_| count > 0) else { return Ok(Vec::new()) };
        let mut bytes = vec![0; count as usize * POINT_BYTES];
        file.read_exact_at(&mut bytes, spill.read * POINT_BYTES as u64)?;
        spill.read += count;
        if spill.read == spill.written {
            // All have been taken: the disk has its room back.
            let file = spill.file.take();
            *spill = Spill { file, ..Spill::default() };
            if let Some(file) = &spill.file {
                file.set_len(0)?;
            }
        }
        self.shared.waiting.fetch_sub(count, Ordering::Release);
        let (records, _) = bytes.as_chunks::<POINT_BYTES>();
        Ok(records.iter().map(read).collect())
    }

    /// A file that no one else reads, and that has no name any more.
    fn create(&self) -> io::Result<File> {
        let path = self.shared.folder.join(format!(".overflow-{}", std::process::id()));
        let file = OpenOptions::new()
            .read(true)
            .write(true)
            .create(true)
            .truncate(true)
            .mode(0o600)
            .open(&path)?;
        remove_file(&path)?;
        Ok(file)
    }

    fn spill(&self) -> MutexGuard<'_, Spill> {
        // Whoever panicked left whole numbers.
        self.shared.file.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

fn write(point: &Point, bytes: &mut Vec<u8>) {
    let Point { count, host, position_mm, flags, u_mm } = point;
    bytes.extend(count.unwrap_or(0).to_le_bytes());
    bytes.extend(host.as_nanos().to_le_bytes());
    bytes.extend(flags.bits().to_le_bytes());
    bytes.extend(u32::from(count.is_some()).to_le_bytes());
    for number in position_mm.iter().chain(u_mm) {
        bytes.extend(number.to_le_bytes());
    }
}

fn read(record: &[u8; POINT_BYTES]) -> Point {
    let (words, _) = record.as_chunks::<8>();
    let number = |word: usize| u64::from_le_bytes(words[word]);
    let coordinate = |word: usize| f64::from_le_bytes(words[word]);
    let (flags, has_count) = (number(2) as u32, number(2) >> 32 != 0);
    Point {
        count: has_count.then(|| number(0)),
        host: Nanos::from_nanos(number(1)),
        position_mm: [coordinate(3), coordinate(4), coordinate(5)],
        flags: Flags::from_bits_retain(flags),
        u_mm: [coordinate(6), coordinate(7), coordinate(8)],
    }
}

const POINT_BYTES: usize = 72;
/// Points that are taken at once.
const BLOCK: u64 = 8192;
/// Bytes of points between two looks at the free space.
const CHECKED_BYTES: u64 = 64 << 20;
/// Free space beyond the reserve that is left to the recording.
const RECORDING_BYTES: u64 = 512 << 20;

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    fn point(bits: u64) -> Point {
        let number = |k: u64| f64::from_bits(bits.rotate_left(k as u32 * 7) ^ k);
        Point {
            count: (!bits.is_multiple_of(3)).then_some(bits),
            host: Nanos::from_nanos(bits.rotate_left(9)),
            position_mm: [number(1), number(2), number(3)],
            flags: Flags::from_bits_truncate(bits as u32),
            u_mm: [number(4), number(5), number(6)],
        }
    }

    /// Bits of a point: a NaN equals no other.
    fn bits(point: &Point) -> Vec<u8> {
        let mut bytes = Vec::new();
        write(point, &mut bytes);
        bytes
    }

    proptest! {
        #![proptest_config(ProptestConfig { cases: 64, failure_persistence: None, ..ProptestConfig::default() })]

        /// However points are appended and taken, they come back in their order, bit for bit, and none is left.
        #[test]
        fn points_come_back_in_their_order(batches in prop::collection::vec((0_usize..60, any::<u64>(), 0_usize..3), 0..20)) {
            let folder = tempfile::tempdir().unwrap();
            let overflow = Overflow::beside(folder.path(), 0);
            let (mut sent, mut found) = (Vec::new(), Vec::new());
            for (count, seed, takes) in batches {
                let points: Vec<Point> =
                    (0..count as u64).map(|k| point(seed.wrapping_mul(2 * k + 1))).collect();
                overflow.append(&points).unwrap();
                sent.extend(points.iter().map(bits));
                for _ in 0..takes {
                    found.extend(overflow.take().unwrap().iter().map(bits));
                }
                prop_assert_eq!(overflow.is_waiting(), found.len() < sent.len());
            }
            while overflow.is_waiting() {
                found.extend(overflow.take().unwrap().iter().map(bits));
            }
            prop_assert_eq!(found, sent);
            prop_assert!(overflow.take().unwrap().is_empty());
            // The file has no name.
            prop_assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 0);
        }
    }

    #[test]
    fn the_space_of_the_recording_is_left_to_it() {
        let folder = tempfile::tempdir().unwrap();
        let overflow = Overflow::beside(folder.path(), u64::MAX / 2);
        let refused = overflow.append(&[point(1)]).unwrap_err();
        assert_eq!(refused.kind(), io::ErrorKind::StorageFull);
        assert!(!overflow.is_waiting());
        let gone = Overflow::beside(&folder.path().join("gone"), 0);
        assert!(gone.append(&[point(1)]).is_err() && !gone.is_waiting());
    }
}
