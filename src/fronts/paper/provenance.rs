//! Where a measurement comes from: files with their checksums, the software, the command.

use std::fmt::{self, Write as _};
use std::fs::{self, File};
use std::io::{self, Read};
use std::path::{Path, PathBuf};

use asphera_report::words::count;
use asphera_report::{Label, Report, ResultFile};
use sha2::{Digest, Sha256};
use thiserror::Error;

use super::words::text;

/// Statements of a paper on its origin, beside what the report itself knows.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Provenance {
    /// What was measured and by whom, as whoever asks for the paper has it. It goes before the label of the session.
    pub label: Label,
    /// When it was measured, as far as the file says; a session knows it itself.
    pub date: Option<String>,
    /// The instrument, as far as the file says.
    pub instrument: Option<String>,
    /// The files it was made from.
    pub files: Vec<SourceFile>,
    /// The command line.
    pub command: String,
}

/// A file and its checksum.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct SourceFile {
    /// Its name, without the folder.
    pub name: String,
    /// How large it is.
    pub bytes: u64,
    /// SHA-256 (FIPS 180-4) in hexadecimal.
    pub sha256: String,
}

/// Why a file has no checksum.
#[derive(Debug, Error)]
#[error("cannot read {}", path.display())]
pub struct SourceFileError {
    /// Which file or folder.
    path: PathBuf,
    /// Why.
    source: io::Error,
}

impl SourceFile {
    /// Reads a file once, in pieces.
    ///
    /// # Errors
    ///
    /// When it cannot be read.
    pub fn read(path: &Path) -> Result<SourceFile, SourceFileError> {
        let failed = |source| SourceFileError { path: path.to_owned(), source };
        let mut file = File::open(path).map_err(failed)?;
        let (mut hash, mut bytes) = (Sha256::new(), 0);
        let mut piece = vec![0; PIECE];
        loop {
            let read = file.read(&mut piece).map_err(failed)?;
            if read == 0 {
                break;
            }
            hash.update(&piece[..read]);
            bytes += read as u64;
        }
        let sha256 = hash.finalize().iter().map(|byte| format!("{byte:02x}")).collect();
        Ok(SourceFile { name: name(path), bytes, sha256 })
    }

    /// All files of a recording's folder, by name, without results that lie there; of one segment, that.
    ///
    /// # Errors
    ///
    /// When one of them cannot be read.
    pub fn read_session(path: &Path) -> Result<Vec<SourceFile>, SourceFileError> {
        if !path.is_dir() {
            return Ok(vec![SourceFile::read(path)?]);
        }
        let failed = |source| SourceFileError { path: path.to_owned(), source };
        let mut files = Vec::new();
        for entry in fs::read_dir(path).map_err(failed)? {
            let entry = entry.map_err(failed)?.path();
            // What was made of the recording lies beside it.
            let is_result = ResultFile::named(&name(&entry)).is_some();
            if entry.is_file() && !is_result {
                files.push(entry);
            }
        }
        files.sort();
        files.iter().map(|path| SourceFile::read(path)).collect()
    }
}

impl Provenance {
    /// The software that made the paper: name, version, and commit where the build knew it.
    pub fn software() -> String {
        let version = env!("CARGO_PKG_VERSION");
        match option_env!("ASPHERA_COMMIT") {
            Some(commit) => format!("asphera {version}, commit {commit}"),
            None => format!("asphera {version}"),
        }
    }

    /// What was measured and by whom: each entry as given, or as the session has it.
    pub(super) fn label_of(&self, report: &Report) -> Label {
        let session = report.session.as_ref().map(|session| session.label.clone());
        let Label { part, serial, operator } = session.unwrap_or_default();
        let given = self.label.clone();
        Label {
            part: given.part.or(part),
            serial: given.serial.or(serial),
            operator: given.operator.or(operator),
        }
    }

    /// Instrument, software, command and files as HTML.
    pub(super) fn draw(&self, out: &mut String, report: &Report) -> fmt::Result {
        let given = self.label.entries().map(|(name, entry)| (name, text(entry)));
        let mut rows: Vec<(&str, String)> = given.collect();
        if let Some(instrument) = &self.instrument {
            rows.push(("instrument", text(instrument)));
        }
        rows.push(("evaluated by", text(&Provenance::software())));
        rows.push(("command", format!("<code>{}</code>", text(&self.command))));
        rows.push(("layout of the figures", text(&report.format)));
        for (name, value) in rows {
            writeln!(out, "<p class=\"origin\"><span>{name}</span> {value}</p>")?;
        }
        if self.files.is_empty() {
            return Ok(());
        }
        out.push_str(
            "<table class=\"wide\"><thead><tr><th>file</th><th class=\"n\">bytes</th><th>SHA-256</th></tr>\
             </thead><tbody>\n",
        );
        for file in &self.files {
            writeln!(
                out,
                "<tr><td>{}</td><td class=\"n\">{}</td><td><code class=\"hash\">{}</code></td></tr>",
                text(&file.name),
                count(file.bytes),
                text(&file.sha256)
            )?;
        }
        out.push_str("</tbody></table>\n");
        Ok(())
    }
}

fn name(path: &Path) -> String {
    path.file_name().unwrap_or(path.as_os_str()).to_string_lossy().into_owned()
}

/// What is read at a time.
const PIECE: usize = 1 << 16;

#[cfg(test)]
mod tests {
    use super::*;

    /// The example "abc" of FIPS 180-4 (NIST, "SHA256.pdf" of the example algorithms).
    #[test]
    fn the_checksum_is_that_of_the_standard() {
        let folder = tempfile::tempdir().unwrap();
        fs::write(folder.path().join("b.txt"), "abc").unwrap();
        fs::write(folder.path().join("a.txt"), "").unwrap();
        let files = SourceFile::read_session(folder.path()).unwrap();
        let names: Vec<&str> = files.iter().map(|file| file.name.as_str()).collect();
        assert_eq!(names, ["a.txt", "b.txt"]);
        assert_eq!(files[1].bytes, 3);
        assert_eq!(
            files[1].sha256,
            "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad"
        );
        let missing = SourceFile::read(&folder.path().join("none")).unwrap_err();
        assert!(missing.to_string().ends_with("none"));
    }
}
