//! The folder of the recordings belongs to one station at a time.

use std::fs::{File, OpenOptions};
use std::io::{Read as _, Seek as _, Write as _};
use std::os::unix::fs::MetadataExt as _;
use std::path::{Path, PathBuf};

use rustix::fs::{FlockOperation, flock};
use tracing::debug;

use super::StationError;

/// Held while a station lives; the system lets go of it when the process ends, however it ends. In good order it is removed.
#[derive(Debug)]
pub(super) struct Lock {
    file: Option<(File, PathBuf)>,
}

impl Drop for Lock {
    fn drop(&mut self) {
        // Still locked, so that it is no other station's. What cannot be removed is taken by the next one.
        if let Some((_, path)) = &self.file {
            let _ = std::fs::remove_file(path);
        }
    }
}

impl Lock {
    /// Takes the folder, which is made if it is not there, for a station of this name.
    ///
    /// A folder that cannot be written, or whose file system knows no locks, is not locked: whether a session can be recorded
    /// there is told when one begins.
    ///
    /// # Errors
    ///
    /// [`StationError::Shared`] where another station has it.
    pub(super) fn take(folder: &Path, station: &str) -> Result<Lock, StationError> {
        let path = folder.join(NAME);
        let open = || {
            std::fs::create_dir_all(folder)?;
            OpenOptions::new().read(true).write(true).create(true).truncate(false).open(&path)
        };
        for _ in 0..TRIES {
            let file = match open() {
                Ok(file) => file,
                Err(error) => {
                    debug!(%error, path = %path.display(), "the folder of the recordings is not locked");
                    return Ok(Lock { file: None });
                }
            };
            Lock::lock(&file, folder)?;
            // Another station may have ended and removed it between the two.
            if is_at(&file, &path) {
                let holder = format!("process {}, station {station:?}", std::process::id());
                // For the message of another station only.
                let _ = file
                    .set_len(0)
                    .and_then(|()| (&file).rewind())
                    .and_then(|()| writeln!(&file, "{holder}"));
                return Ok(Lock { file: Some((file, path)) });
            }
        }
        Ok(Lock { file: None })
    }

    fn lock(file: &File, folder: &Path) -> Result<(), StationError> {
        match flock(file, FlockOperation::NonBlockingLockExclusive) {
            Ok(()) => {}
            Err(rustix::io::Errno::WOULDBLOCK) => {
                let mut holder = String::new();
                // What cannot be read is not named.
                let _ = file.take(LONGEST).read_to_string(&mut holder);
                return Err(StationError::Shared {
                    folder: folder.display().to_string(),
                    holder: holder.trim().to_owned(),
                });
            }
            Err(error) => debug!(%error, "the folder of the recordings cannot be locked"),
        }
        Ok(())
    }
}

/// Whether a file is the one at a path still.
fn is_at(file: &File, path: &Path) -> bool {
    let there = |found: std::fs::Metadata| (found.dev(), found.ino());
    let at_path = std::fs::metadata(path).map(there);
    at_path.is_ok_and(|at_path| file.metadata().is_ok_and(|of_file| there(of_file) == at_path))
}

/// Of no session: those are folders.
const NAME: &str = ".asphera.lock";
/// How often a file is opened that another station removes at that moment.
const TRIES: usize = 100;
/// Bytes of it that are read.
const LONGEST: u64 = 300;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_folder_has_one_station() {
        let parent = tempfile::tempdir().unwrap();
        let folder = parent.path().join("recordings");
        let first = Lock::take(&folder, "line 1").unwrap();
        let words = Lock::take(&folder, "line 2").unwrap_err().to_string();
        let process = std::process::id();
        assert!(words.contains(&format!("process {process}, station \"line 1\"")), "{words}");
        assert!(words.contains("[session] dir (--out of demo)"), "{words}");
        drop(first);
        Lock::take(&folder, "line 2").unwrap();
        assert_eq!(std::fs::read_dir(&folder).unwrap().count(), 0, "it leaves nothing behind");
    }

    #[test]
    fn a_folder_that_cannot_be_made_is_told_when_a_session_begins() {
        let parent = tempfile::tempdir().unwrap();
        let file = parent.path().join("file");
        std::fs::write(&file, "").unwrap();
        assert!(Lock::take(&file.join("recordings"), "line 1").is_ok());
    }
}
