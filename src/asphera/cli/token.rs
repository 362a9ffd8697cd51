//! The token of the page, where its operator chooses it.

use std::path::PathBuf;

use clap::Args;

use super::output::Failure;
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

/// Not an argument: other users of the machine see those.
const VARIABLE: &str = "ASPHERA_TOKEN";
