//! The token of the page, where its operator chooses it.

use std::os::unix::fs::PermissionsExt as _;
use std::path::{Path, PathBuf};

use clap::Args;

use super::output::{Failure, say};
use asphera_http::Token;

#[derive(Args)]
pub(super) struct TokenArgs {
    /// The token of the page is in this file: 16 to 128 letters, digits, - or _. Without it ASPHERA_TOKEN holds it; without either it
    /// is drawn anew at every start, and printed.
    #[arg(long, value_name = "FILE", env = "ASPHERA_TOKEN_FILE")]
    token_file: Option<PathBuf>,
}

impl TokenArgs {
    /// The token that was chosen.
    pub(super) fn token(&self) -> Result<Option<Token>, Failure> {
        let (place, text) = match &self.token_file {
            Some(path) => {
                let text = std::fs::read_to_string(path).map_err(|error| {
                    format!("cannot read the token in {}: {error}", path.display())
                })?;
                if is_readable_by_others(path) {
                    say(&format!(
                        "warning: other users of this machine can read the token in {0}: chmod 600 {0}",
                        path.display()
                    ));
                }
                (path.display().to_string(), text)
            }
            None => match std::env::var(VARIABLE) {
                Ok(text) => (VARIABLE.to_owned(), text),
                Err(_) => return Ok(None),
            },
        };
        // The text is not repeated: it may be a token but for a slip.
        Token::parse(text.trim()).map(Some).map_err(|error| format!("{place}: {error}").into())
    }
}

/// Whether the mode of a file lets its group or everyone read it.
fn is_readable_by_others(path: &Path) -> bool {
    std::fs::metadata(path).is_ok_and(|found| found.permissions().mode() & 0o044 != 0)
}

/// Not an argument: other users of the machine see those.
const VARIABLE: &str = "ASPHERA_TOKEN";

#[cfg(test)]
mod tests {
    use std::fs::Permissions;

    use super::*;

    #[test]
    fn a_token_that_others_can_read_is_told() {
        let file = tempfile::NamedTempFile::new().unwrap();
        for (mode, expected) in [(0o600, false), (0o400, false), (0o640, true), (0o644, true)] {
            std::fs::set_permissions(file.path(), Permissions::from_mode(mode)).unwrap();
            assert_eq!(is_readable_by_others(file.path()), expected, "{mode:o}");
        }
        assert!(!is_readable_by_others(Path::new("/none")));
    }
}
