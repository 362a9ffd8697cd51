//! A file for what memory has no room for. It has no name, and ends with the process.

use std::collections::{BTreeMap, HashMap};
use std::fs::{File, OpenOptions, remove_file};
use std::io;
use std::os::unix::fs::{FileExt as _, OpenOptionsExt as _};
use std::path::{Path, PathBuf};

use asphera_reconstruct::{TileShelf, TileShelfFailure};

use crate::cli::output::Failure;

/// Pieces in a file; the room of one that is forgotten is used again.
pub(super) struct DiskShelf {
    folder: PathBuf,
    file: File,
    pieces: HashMap<u32, Extent>,
    /// Room without a piece: lengths by where it begins.
    free: BTreeMap<u64, u64>,
    end: u64,
}

/// Bytes of the file.
#[derive(Clone, Copy)]
struct Extent {
    at: u64,
    len: u64,
}

impl DiskShelf {
    /// A file in a folder.
    pub(super) fn new(folder: &Path) -> Result<DiskShelf, Failure> {
        let failed = |error: io::Error| {
            format!("cannot make a file in {}: {error}; {CURE}", folder.display())
        };
        let path = folder.join(format!(".asphera-tiles-{}", std::process::id()));
        let mut options = OpenOptions::new();
        options.read(true).write(true).create_new(true).mode(0o600);
        let file = options.open(&path).map_err(failed)?;
        remove_file(&path).map_err(failed)?;
        let (pieces, free) = (HashMap::new(), BTreeMap::new());
        Ok(DiskShelf { folder: folder.to_owned(), file, pieces, free, end: 0 })
    }

    /// Takes room for so many bytes: the first that is free, else at the end.
    fn room(&mut self, len: u64) -> Extent {
        let found = self.free.iter().find(|&(_, &room)| room >= len).map(|(&at, &room)| (at, room));
        let Some((at, room)) = found else {
            let at = self.end;
            self.end += len;
            return Extent { at, len };
        };
        self.free.remove(&at);
        if room > len {
            self.free.insert(at + len, room - len);
        }
        Extent { at, len }
    }

    /// Gives room back, joined with what is free before and behind it.
    fn give_back(&mut self, Extent { mut at, mut len }: Extent) {
        if let Some(behind) = self.free.remove(&(at + len)) {
            len += behind;
        }
        if let Some((&before, &room)) = self.free.range(..at).next_back()
            && before + room == at
        {
            self.free.remove(&before);
            (at, len) = (before, len + room);
        }
        if len > 0 {
            self.free.insert(at, len);
        }
    }

    fn failed(&self, error: &io::Error) -> TileShelfFailure {
        format!("the file in {}: {error}; {CURE}", self.folder.display()).into()
    }
}

impl TileShelf for DiskShelf {
    fn put(&mut self, piece: u32, bytes: &[u8]) -> Result<(), TileShelfFailure> {
        let len = bytes.len() as u64;
        let same = self.pieces.get(&piece).copied().filter(|extent| extent.len == len);
        let extent = match same {
            Some(extent) => extent,
            None => {
                self.forget(piece);
                self.room(len)
            }
        };
        self.pieces.insert(piece, extent);
        self.file.write_all_at(bytes, extent.at).map_err(|error| self.failed(&error))
    }

    fn get(&mut self, piece: u32, bytes: &mut Vec<u8>) -> Result<(), TileShelfFailure> {
        let Extent { at, len } = *self.pieces.get(&piece).ok_or("a piece that is not there")?;
        bytes.resize(usize::try_from(len)?, 0);
        self.file.read_exact_at(bytes, at).map_err(|error| self.failed(&error))
    }

    fn forget(&mut self, piece: u32) {
        if let Some(extent) = self.pieces.remove(&piece) {
            self.give_back(extent);
        }
    }
}

const CURE: &str = "TMPDIR names another folder, which needs some 200 bytes a point";

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    proptest! {
        #![proptest_config(ProptestConfig { cases: 64, failure_persistence: None, ..ProptestConfig::default() })]

        /// Whatever is put, replaced and forgotten, each piece comes back as it was put last, and room is used again.
        #[test]
        fn pieces_come_back_as_they_were_put_last(steps in prop::collection::vec((0_u32..9, 0_usize..50, any::<u8>()), 0..60)) {
            let folder = tempfile::tempdir().unwrap();
            let mut shelf = DiskShelf::new(folder.path()).unwrap();
            let mut expected: BTreeMap<u32, Vec<u8>> = BTreeMap::new();
            for (piece, len, byte) in steps {
                if byte.is_multiple_of(4) {
                    shelf.forget(piece);
                    expected.remove(&piece);
                } else {
                    shelf.put(piece, &vec![byte; len]).unwrap();
                    expected.insert(piece, vec![byte; len]);
                }
                let mut found = vec![1, 2, 3];
                for piece in 0..9 {
                    let is_there = shelf.get(piece, &mut found).is_ok();
                    prop_assert_eq!(is_there.then_some(&found), expected.get(&piece));
                }
                let held: u64 = shelf.pieces.values().map(|extent| extent.len).sum();
                prop_assert_eq!(held + shelf.free.values().sum::<u64>(), shelf.end);
            }
            expected.keys().for_each(|&piece| shelf.forget(piece));
            prop_assert!(shelf.free.len() <= 1);
            // The file has no name.
            prop_assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 0);
        }
    }

    #[test]
    fn a_folder_that_is_not_there_is_named_with_the_cure() {
        let folder = tempfile::tempdir().unwrap();
        let failed = DiskShelf::new(&folder.path().join("gone")).err().unwrap().to_string();
        assert!(failed.contains("gone") && failed.contains("TMPDIR"), "{failed}");
    }
}
