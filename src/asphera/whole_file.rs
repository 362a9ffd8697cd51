//! Files that appear whole or not at all.

use std::fs::{self, File};
use std::io::{self, BufWriter, Write as _};
use std::path::{Path, PathBuf};

use thiserror::Error;

/// The file system refused.
#[derive(Debug, Error)]
#[error("cannot write {}", path.display())]
pub(crate) struct CannotWrite {
    pub(crate) path: PathBuf,
    pub(crate) source: io::Error,
}

/// A file that is written beside its place and moved there at the end. Dropped before, it leaves nothing, and what was there stays.
pub(crate) struct WholeFile {
    target: PathBuf,
    /// None where the target is no plain file: a pipe or a device takes bytes as they come; and once it lies at its place.
    beside: Option<PathBuf>,
}

impl WholeFile {
    /// A file that is to lie at `path`; of a link, where it points to.
    pub(crate) fn at(path: &Path) -> WholeFile {
        let is_special = fs::metadata(path).is_ok_and(|there| !there.is_file());
        let target = match path.canonicalize() {
            Ok(whole) if !is_special => whole,
            _ => path.to_owned(),
        };
        let mut beside = target.clone().into_os_string();
        // Another process may write the same file at the same time.
        beside.push(format!(".{}.part", std::process::id()));
        let beside = (!is_special).then(|| PathBuf::from(beside));
        WholeFile { target, beside }
    }

    /// Where it is written.
    pub(crate) fn place(&self) -> &Path {
        self.beside.as_deref().unwrap_or(&self.target)
    }

    /// Makes the file, empty.
    pub(crate) fn create(&self) -> Result<File, CannotWrite> {
        let created = || {
            let file = File::create(self.place())?;
            if let (Some(_), Ok(there)) = (&self.beside, fs::metadata(&self.target)) {
                file.set_permissions(there.permissions())?;
            }
            Ok(file)
        };
        created().map_err(|source| self.failed(source))
    }

    /// Moves the file to its place once the disk has it.
    pub(crate) fn finish(mut self) -> Result<(), CannotWrite> {
        if let Some(beside) = &self.beside {
            let moved = File::open(beside)
                .and_then(|file| file.sync_data())
                .and_then(|()| fs::rename(beside, &self.target));
            moved.map_err(|source| self.failed(source))?;
        }
        self.beside = None;
        Ok(())
    }

    fn failed(&self, source: io::Error) -> CannotWrite {
        CannotWrite { path: self.target.clone(), source }
    }
}

impl Drop for WholeFile {
    fn drop(&mut self) {
        if let Some(beside) = &self.beside {
            // It holds room that others may need. What cannot be removed is told by the error already.
            let _ = fs::remove_file(beside);
        }
    }
}

/// Writes a file with what `fill` gives.
pub(crate) fn write_whole<E: From<CannotWrite>>(
    path: &Path,
    fill: impl FnOnce(&mut BufWriter<File>) -> Result<(), E>,
) -> Result<(), E> {
    let whole = WholeFile::at(path);
    let mut writer = BufWriter::new(whole.create()?);
    fill(&mut writer)?;
    writer.flush().map_err(|source| whole.failed(source))?;
    drop(writer);
    Ok(whole.finish()?)
}

/// Writes a file of bytes.
pub(crate) fn write_bytes(path: &Path, bytes: impl AsRef<[u8]>) -> Result<(), CannotWrite> {
    write_whole(path, |writer| {
        let failed = |source| CannotWrite { path: path.to_owned(), source };
        writer.write_all(bytes.as_ref()).map_err(failed)
    })
}

#[cfg(test)]
mod tests {
    use std::io::Read as _;

    use super::*;

    fn names(folder: &Path) -> Vec<String> {
        let mut names: Vec<String> = fs::read_dir(folder)
            .unwrap()
            .map(|entry| entry.unwrap().file_name().into_string().unwrap())
            .collect();
        names.sort();
        names
    }

    #[test]
    fn what_is_not_finished_leaves_what_was_there() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.ply");
        write_bytes(&path, "good").unwrap();
        let failed: Result<(), CannotWrite> = write_whole(&path, |writer| {
            writer.write_all(b"half").unwrap();
            Err(CannotWrite { path: path.clone(), source: io::ErrorKind::StorageFull.into() })
        });
        assert!(failed.is_err());
        assert_eq!(fs::read_to_string(&path).unwrap(), "good");
        assert_eq!(names(folder.path()), ["a.ply"]);
        write_bytes(&path, "better").unwrap();
        assert_eq!(fs::read_to_string(&path).unwrap(), "better");
        assert_eq!(names(folder.path()), ["a.ply"]);
    }

    #[test]
    fn a_folder_that_is_not_there_is_named() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("none").join("a.ply");
        let error = write_bytes(&path, "x").unwrap_err();
        assert_eq!(error.to_string(), format!("cannot write {}", path.display()));
    }

    #[cfg(unix)]
    #[test]
    fn links_permissions_and_pipes_stay() {
        use std::os::unix::fs::{FileTypeExt as _, PermissionsExt as _, symlink};
        let folder = tempfile::tempdir().unwrap();
        let [file, link] = ["file", "link"].map(|name| folder.path().join(name));
        fs::write(&file, "old").unwrap();
        fs::set_permissions(&file, fs::Permissions::from_mode(0o640)).unwrap();
        symlink(&file, &link).unwrap();
        write_bytes(&link, "new").unwrap();
        assert!(link.is_symlink());
        assert_eq!(fs::read_to_string(&file).unwrap(), "new");
        assert_eq!(fs::metadata(&file).unwrap().permissions().mode() & 0o777, 0o640);

        let pipe = folder.path().join("pipe");
        let made = std::process::Command::new("mkfifo").arg(&pipe).status();
        assert!(made.unwrap().success());
        let reader = {
            let pipe = pipe.clone();
            std::thread::spawn(move || {
                let mut text = String::new();
                File::open(pipe).unwrap().read_to_string(&mut text).unwrap();
                text
            })
        };
        write_bytes(&pipe, "through").unwrap();
        assert_eq!(reader.join().unwrap(), "through");
        assert!(fs::metadata(&pipe).unwrap().file_type().is_fifo());
    }
}
