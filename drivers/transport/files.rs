//! Files, FIFOs and the standard input, opened for reading.

use std::fs::Metadata;
use std::io::{self, SeekFrom};
use std::os::unix::fs::{FileTypeExt as _, MetadataExt as _};
use std::path::{Path, PathBuf};

use tokio::fs::File;
use tokio::io::{AsyncReadExt as _, AsyncSeekExt as _};
use tokio::net::unix::pipe;

use crate::{FileSettings, OpenError};

/// An open file or pipe.
#[derive(Debug)]
pub(crate) enum FilePort {
    /// A file on a disk.
    Regular(RegularFile),
    /// A pipe.
    Pipe(Pipe),
}

/// A file on a disk, and how far it was read.
#[derive(Debug)]
pub(crate) struct RegularFile {
    file: File,
    id: FileId,
    offset: u64,
}

/// The reading end of a pipe.
#[derive(Debug)]
pub(crate) struct Pipe {
    /// The end.
    pub(crate) receiver: pipe::Receiver,
    /// Whether it has a name, by which another writer can come.
    pub(crate) is_named: bool,
}

/// Device and inode of a file: another file of the same name has others.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct FileId(u64, u64);

/// Where the next opening of a file begins to read.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) enum Bookmark {
    /// As the settings say: nothing was opened yet.
    #[default]
    AsSet,
    /// At the beginning, whatever file is there.
    Begin,
    /// Where reading stopped, if it is the same file still.
    At(FileMark),
}

/// A place in a file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct FileMark {
    id: FileId,
    offset: u64,
}

/// State of a file whose end was reached.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum AtEnd {
    /// It may grow.
    Waits,
    /// It has fewer bytes than were read: their number.
    Truncated(u64),
    /// Another file has its name.
    Replaced,
    /// No file has its name.
    Removed,
}

impl FilePort {
    /// Opens a file or a pipe; of a file that is not there, `bookmark` notes that it is new when it comes.
    pub(crate) async fn open(
        settings: &FileSettings,
        bookmark: &mut Bookmark,
    ) -> Result<FilePort, OpenError> {
        let path = settings.system_path();
        let found = tokio::fs::metadata(&path).await;
        if found.as_ref().is_err_and(|error| error.kind() == io::ErrorKind::NotFound) {
            *bookmark = Bookmark::Begin;
        }
        let metadata = found.map_err(|source| refused(settings, source))?;
        let kind = metadata.file_type();
        if kind.is_fifo() {
            let pipe = Pipe::open(&path).map_err(|source| refused(settings, source))?;
            return Ok(FilePort::Pipe(pipe));
        }
        if kind.is_dir() {
            return Err(refused(settings, io::ErrorKind::IsADirectory.into()));
        }
        if !kind.is_file() {
            return Err(OpenError::NoFile { path: settings.to_string() });
        }
        let regular = RegularFile::open(&path, settings, *bookmark).await;
        Ok(FilePort::Regular(regular.map_err(|source| refused(settings, source))?))
    }
}

impl RegularFile {
    async fn open(
        path: &Path,
        settings: &FileSettings,
        bookmark: Bookmark,
    ) -> io::Result<RegularFile> {
        let mut file = File::open(path).await?;
        let metadata = file.metadata().await?;
        let id = FileId::of(&metadata);
        let offset = match bookmark {
            Bookmark::AsSet if settings.from_end => metadata.len(),
            Bookmark::At(mark) if mark.id == id && mark.offset <= metadata.len() => mark.offset,
            Bookmark::AsSet | Bookmark::Begin | Bookmark::At(_) => 0,
        };
        file.seek(SeekFrom::Start(offset)).await?;
        Ok(RegularFile { file, id, offset })
    }

    /// Reads on; 0 at the end. A call that is given up loses nothing.
    pub(crate) async fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        let count = self.file.read(buffer).await?;
        self.offset += count as u64;
        Ok(count)
    }

    /// How far it was read.
    pub(crate) fn mark(&self) -> FileMark {
        FileMark { id: self.id, offset: self.offset }
    }

    /// Bytes before the place of reading.
    pub(crate) fn offset(&self) -> u64 {
        self.offset
    }

    /// State of the file, whose end was reached, and of its name.
    pub(crate) async fn at_end(&self, path: &Path) -> io::Result<AtEnd> {
        let own = self.file.metadata().await?;
        if own.len() < self.offset {
            return Ok(AtEnd::Truncated(own.len()));
        }
        match tokio::fs::metadata(path).await {
            Ok(named) if FileId::of(&named) == self.id => Ok(AtEnd::Waits),
            Ok(_) => Ok(AtEnd::Replaced),
            Err(error) if error.kind() == io::ErrorKind::NotFound => Ok(AtEnd::Removed),
            Err(error) => Err(error),
        }
    }
}

impl Pipe {
    /// Opens the reading end. Nobody needs to write yet.
    pub(crate) fn open(path: &Path) -> io::Result<Pipe> {
        let receiver = pipe::OpenOptions::new().open_receiver(path)?;
        // Below /proc a pipe without a name has a path that leads nowhere.
        Ok(Pipe { receiver, is_named: path.canonicalize().is_ok() })
    }
}

impl FileId {
    fn of(metadata: &Metadata) -> FileId {
        FileId(metadata.dev(), metadata.ino())
    }
}

impl FileSettings {
    /// Path by which the system knows it.
    pub(crate) fn system_path(&self) -> PathBuf {
        if self.is_standard_input() { PathBuf::from("/dev/stdin") } else { self.path.clone() }
    }
}

fn refused(settings: &FileSettings, source: io::Error) -> OpenError {
    let cure = match source.kind() {
        io::ErrorKind::NotFound => {
            "correct its path, let a program write it, or make a FIFO with `mkfifo`; it is tried again"
        }
        io::ErrorKind::PermissionDenied => {
            "let the user of asphera read it: `ls -l` shows who may, `chmod` and `chgrp` change it"
        }
        io::ErrorKind::IsADirectory => "name a file in this folder",
        _ => "check the disk and the path",
    };
    OpenError::File { path: settings.to_string(), cure, source }
}
