//! C that stands between a program and its system, by LD_PRELOAD.

use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::OnceLock;

use asphera_tests::skipped;

/// A source file of this folder, compiled when it is first asked for.
pub(crate) struct Preloaded {
    source: &'static str,
    built: OnceLock<Option<(tempfile::TempDir, PathBuf)>>,
}

impl Preloaded {
    pub(crate) const fn new(source: &'static str) -> Preloaded {
        Preloaded { source, built: OnceLock::new() }
    }

    /// The library; `None`, said on stderr, without a C compiler.
    pub(crate) fn library(&self) -> Option<&Path> {
        let built = self.built.get_or_init(|| {
            let folder = tempfile::tempdir().unwrap();
            let library = folder.path().join("preloaded.so");
            let source = Path::new(env!("CARGO_MANIFEST_DIR")).join("end_to_end").join(self.source);
            let arguments = ["-shared", "-fPIC", "-O1", "-Wall", "-Werror", "-o"];
            let compiled = Command::new("cc").args(arguments).arg(&library).arg(source).status();
            match compiled {
                Ok(status) => {
                    assert!(status.success(), "{} does not compile", self.source);
                    Some((folder, library))
                }
                Err(error) => {
                    skipped(&format!("{}: cc does not run: {error}", self.source));
                    None
                }
            }
        });
        built.as_ref().map(|(_, library)| library.as_path())
    }
}
