//! A file system in memory that fails on demand and knows what a power cut leaves.

use std::collections::BTreeMap;
use std::fs;
use std::io::{self, Write};
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex};

use super::super::{Storage, StorageFile};

/// The disk is full (Linux, errno.h).
pub(super) const ENOSPC: i32 = 28;

/// The disk is broken (Linux, errno.h).
pub(super) const EIO: i32 = 5;

/// How an operation fails.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Fault {
    /// Nothing is done.
    Error(i32),
    /// A write takes half of the bytes, and the next one fails; other operations fail at once.
    Short,
}

/// A file system in memory that knows what a power cut would leave.
#[derive(Clone, Default)]
pub(super) struct MemoryDisk(Arc<Mutex<Inner>>);

#[derive(Default)]
struct Inner {
    files: Vec<File>,
    /// Names now, and names after a power cut.
    names: BTreeMap<PathBuf, usize>,
    durable_names: BTreeMap<PathBuf, usize>,
    folders: Vec<PathBuf>,
    durable_folders: Vec<PathBuf>,
    steps: u64,
    /// The step that fails and how; all later ones fail too where it lasts.
    fault: Option<(u64, Fault)>,
    lasting: bool,
    free_bytes: Option<u64>,
}

#[derive(Default)]
struct File {
    bytes: Vec<u8>,
    synced: usize,
}

impl MemoryDisk {
    pub(super) fn failing(step: u64, fault: Fault, lasting: bool) -> MemoryDisk {
        let inner = Inner { fault: Some((step, fault)), lasting, ..Inner::default() };
        MemoryDisk(Arc::new(Mutex::new(inner)))
    }

    pub(super) fn set_free(&self, bytes: u64) {
        self.0.lock().unwrap().free_bytes = Some(bytes);
    }

    pub(super) fn steps(&self) -> u64 {
        self.0.lock().unwrap().steps
    }

    /// How many files were made.
    pub(super) fn files(&self) -> usize {
        self.0.lock().unwrap().files.len()
    }

    /// Writes what is there into a real folder.
    pub(super) fn copy_to(&self, target: &Path) {
        let inner = self.0.lock().unwrap();
        for folder in &inner.folders {
            fs::create_dir_all(target.join(folder)).unwrap();
        }
        for (path, file) in &inner.names {
            fs::write(target.join(path), &inner.files[*file].bytes).unwrap();
        }
    }

    /// Writes what a power cut leaves into a real folder: what is synced, and of the rest a part, in
    /// quarters.
    pub(super) fn copy_after_power_cut(&self, target: &Path, quarters: usize) {
        let inner = self.0.lock().unwrap();
        for folder in &inner.durable_folders {
            fs::create_dir_all(target.join(folder)).unwrap();
        }
        for (path, file) in &inner.durable_names {
            let File { bytes, synced } = &inner.files[*file];
            let left = synced + (bytes.len() - synced) * quarters / 4;
            let path = target.join(path);
            if path.parent().unwrap().is_dir() {
                fs::write(path, &bytes[..left]).unwrap();
            }
        }
    }
}

impl Inner {
    fn step(&mut self) -> Option<Fault> {
        let step = self.steps;
        self.steps += 1;
        let (at, fault) = self.fault?;
        (step == at || (self.lasting && step > at)).then_some(match fault {
            Fault::Short if step > at => Fault::Error(ENOSPC),
            fault => fault,
        })
    }

    fn check(&mut self) -> io::Result<()> {
        match self.step() {
            None => Ok(()),
            Some(Fault::Error(code)) => Err(io::Error::from_raw_os_error(code)),
            Some(Fault::Short) => Err(io::Error::from_raw_os_error(ENOSPC)),
        }
    }
}

impl Storage for MemoryDisk {
    fn create_dir(&mut self, path: &Path) -> io::Result<()> {
        let mut inner = self.0.lock().unwrap();
        inner.check()?;
        inner.folders.push(path.to_owned());
        Ok(())
    }

    fn create(&mut self, path: &Path) -> io::Result<Box<dyn StorageFile>> {
        let mut inner = self.0.lock().unwrap();
        inner.check()?;
        inner.files.push(File::default());
        let file = inner.files.len() - 1;
        inner.names.insert(path.to_owned(), file);
        Ok(Box::new(MemoryFile { disk: self.clone(), file }))
    }

    fn rename(&mut self, from: &Path, to: &Path) -> io::Result<()> {
        let mut inner = self.0.lock().unwrap();
        inner.check()?;
        let file = inner.names.remove(from).unwrap();
        inner.names.insert(to.to_owned(), file);
        Ok(())
    }

    fn sync_dir(&mut self, path: &Path) -> io::Result<()> {
        let mut inner = self.0.lock().unwrap();
        inner.check()?;
        let within = |name: &Path| name.parent() == Some(path);
        inner.durable_names.retain(|name, _| !within(name));
        let names: Vec<_> =
            inner.names.clone().into_iter().filter(|(name, _)| within(name)).collect();
        inner.durable_names.extend(names);
        inner.durable_folders.retain(|name| !within(name));
        let folders: Vec<_> = inner.folders.iter().filter(|name| within(name)).cloned().collect();
        inner.durable_folders.extend(folders);
        Ok(())
    }

    fn free_bytes(&mut self, _: &Path) -> io::Result<u64> {
        let mut inner = self.0.lock().unwrap();
        inner.check()?;
        Ok(inner.free_bytes.unwrap_or(u64::MAX))
    }
}

struct MemoryFile {
    disk: MemoryDisk,
    file: usize,
}

impl Write for MemoryFile {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        let mut inner = self.disk.0.lock().unwrap();
        let taken = match inner.step() {
            None => bytes.len(),
            Some(Fault::Short) => bytes.len() / 2,
            Some(Fault::Error(code)) => return Err(io::Error::from_raw_os_error(code)),
        };
        inner.files[self.file].bytes.extend_from_slice(&bytes[..taken]);
        Ok(taken)
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}

impl StorageFile for MemoryFile {
    fn sync_data(&mut self) -> io::Result<()> {
        let mut inner = self.disk.0.lock().unwrap();
        inner.check()?;
        let file = &mut inner.files[self.file];
        file.synced = file.bytes.len();
        Ok(())
    }
}
