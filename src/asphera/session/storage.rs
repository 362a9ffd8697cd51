//! The file operations a recorder needs, so that tests can let each of them fail.

use std::fs::{DirBuilder, File, OpenOptions, rename};
use std::io::{self, Write};
use std::os::unix::fs::{DirBuilderExt, OpenOptionsExt};
use std::path::Path;

/// A file system as a recorder uses it. The real one is [`Disk`].
pub trait Storage: Send {
    /// Makes a folder only its owner can enter (mode 0700). Fails where something is there already.
    fn create_dir(&mut self, path: &Path) -> io::Result<()>;

    /// Makes an empty file only its owner can read and write (mode 0600), or empties the one there.
    fn create(&mut self, path: &Path) -> io::Result<Box<dyn StorageFile>>;

    /// Moves a file, replacing the one there.
    fn rename(&mut self, from: &Path, to: &Path) -> io::Result<()>;

    /// Makes the names in a folder durable.
    fn sync_dir(&mut self, path: &Path) -> io::Result<()>;

    /// Space an ordinary user can still use on the file system of a path, bytes.
    fn free_bytes(&mut self, path: &Path) -> io::Result<u64>;
}

/// A file being written, at its end.
pub trait StorageFile: Write + Send {
    /// Makes everything written durable.
    fn sync_data(&mut self) -> io::Result<()>;
}

/// The file system of the machine.
#[derive(Clone, Copy, Debug, Default)]
pub struct Disk;

impl Storage for Disk {
    fn create_dir(&mut self, path: &Path) -> io::Result<()> {
        DirBuilder::new().mode(0o700).create(path)
    }

    fn create(&mut self, path: &Path) -> io::Result<Box<dyn StorageFile>> {
        let file =
            OpenOptions::new().write(true).create(true).truncate(true).mode(0o600).open(path)?;
        Ok(Box::new(file))
    }

    fn rename(&mut self, from: &Path, to: &Path) -> io::Result<()> {
        rename(from, to)
    }

    fn sync_dir(&mut self, path: &Path) -> io::Result<()> {
        File::open(path)?.sync_all()
    }

    fn free_bytes(&mut self, path: &Path) -> io::Result<u64> {
        let found = rustix::fs::statvfs(path)?;
        Ok(found.f_bavail.saturating_mul(found.f_frsize))
    }
}

impl StorageFile for File {
    fn sync_data(&mut self) -> io::Result<()> {
        File::sync_data(self)
    }
}
