//! The bytes and the text of a file that a person named.

use std::fs;
use std::io;
use std::os::unix::fs::FileTypeExt as _;
use std::path::Path;

use asphera_formats::zemax;
use asphera_settings::{File, Problems};

/// The bytes of a file or a pipe. A device such as `/dev/zero`, which may have no end, is an error.
pub fn bytes_of(path: &Path) -> io::Result<Vec<u8>> {
    let kind = fs::metadata(path)?.file_type();
    if kind.is_char_device() || kind.is_block_device() {
        return Err(io::Error::new(io::ErrorKind::InvalidInput, "expected a file, found a device"));
    }
    fs::read(path)
}

/// The bytes of a TOML file as text. `Err` holds what they are instead, and what to do; `name` is the path of the file.
pub fn text_of(name: &str, bytes: Vec<u8>) -> Result<String, String> {
    if zemax::is_zemax(&bytes) {
        return Err(format!(
            "a Zemax lens file: make a nominal of it with `asphera nominal {name} --surface N --out NOMINAL.toml`"
        ));
    }
    let is_utf16 = matches!(bytes[..], [0xFF, 0xFE, ..] | [0xFE, 0xFF, ..]);
    String::from_utf8(bytes).map_err(|error| match is_utf16 {
        true => "text in UTF-16: save it in UTF-8".to_owned(),
        false => format!("{}: save it in UTF-8", error.utf8_error()),
    })
}

/// Parses the text of a TOML file. Lines of a lens file that were saved as text are known for what they are.
pub fn parse(name: &str, text: &str) -> Result<File, Problems> {
    File::parse(name, text).map_err(|Problems(mut problems)| {
        if has_lens_lines(text) {
            problems.iter_mut().for_each(|problem| {
                "TOML, not a Zemax file: `asphera nominal FILE.zmx --surface N` makes one of it"
                    .clone_into(&mut problem.expected);
            });
        }
        Problems(problems)
    })
}

/// Whether a text is a Zemax prescription: it begins with its version, or has lines of surfaces.
fn has_lens_lines(text: &str) -> bool {
    text.starts_with("VERS ") || text.lines().any(|line| line.starts_with("SURF "))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_device_without_an_end_is_no_file() {
        let error = bytes_of(Path::new("/dev/zero")).unwrap_err();
        assert_eq!(error.to_string(), "expected a file, found a device");
        assert!(bytes_of(Path::new("/proc/self/status")).is_ok_and(|bytes| !bytes.is_empty()));
    }

    #[test]
    fn a_lens_file_that_is_no_toml_is_known_for_one() {
        for text in ["VERS 140124 258 36214\nMODE SEQ\n", "UNIT MM X W X CM MR CPMM\nSURF 0\n"] {
            let Err(Problems(problems)) = parse("lens.zmx", text) else { panic!("{text}") };
            assert!(problems[0].expected.contains("asphera nominal"), "{problems:?}");
        }
    }

    #[test]
    fn lens_files_and_other_encodings_are_named() {
        let lens = "VERS 140124\r\nMODE SEQ\r\nUNIT MM\r\nSURF 0\r\n";
        let wide = |text: &str| -> Vec<u8> {
            [0xFEFF].into_iter().chain(text.encode_utf16()).flat_map(u16::to_le_bytes).collect()
        };
        for bytes in [lens.as_bytes().to_vec(), wide(lens)] {
            let found = text_of("a.zmx", bytes).unwrap_err();
            assert!(found.starts_with("a Zemax lens file: make a nominal"), "{found}");
            assert!(found.contains("`asphera nominal a.zmx --surface"), "{found}");
        }
        let toml = "[surface]\nkind = \"plane\"\n";
        assert_eq!(text_of("a", toml.into()).unwrap(), toml);
        assert_eq!(text_of("a", wide(toml)).unwrap_err(), "text in UTF-16: save it in UTF-8");
        let found = text_of("a", b"\x80".to_vec()).unwrap_err();
        assert!(found.ends_with("from index 0: save it in UTF-8"), "{found}");
    }
}
