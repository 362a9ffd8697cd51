//! The secret that allows control of a station.

use std::fmt::{self, Write as _};

/// A bearer token. Neither `Debug` nor any log shows it.
#[derive(Clone)]
pub struct Token(String);

/// Why there is no token.
#[derive(Debug, thiserror::Error)]
pub enum TokenError {
    /// The system gave no random bytes.
    #[error("cannot draw a random token")]
    Random(#[source] getrandom::Error),
    /// Shorter than a guess must be unlikely, or longer than any proxy passes.
    #[error("a token has {LEN_MIN} to {LEN_MAX} characters, found {found}")]
    Length {
        /// Characters found.
        found: usize,
    },
    /// A character that cannot stand in a URL fragment, a header and a WebSocket subprotocol alike.
    #[error("a token consists of letters, digits, `-` and `_`; character {position} is another")]
    Character {
        /// Which character, counted from 1.
        position: usize,
    },
}

impl Token {
    /// 128 bits from the system's random source, as 32 hexadecimal digits.
    ///
    /// # Errors
    /// [`TokenError::Random`] where the system has no randomness to give.
    pub fn random() -> Result<Token, TokenError> {
        let mut bytes = [0_u8; 16];
        getrandom::fill(&mut bytes).map_err(TokenError::Random)?;
        Ok(Token(bytes.iter().fold(String::with_capacity(32), |mut text, byte| {
            write!(text, "{byte:02x}").expect("writing to a String does not fail");
            text
        })))
    }

    /// A token chosen by the operator: 16 to 128 letters, digits, `-` or `_`.
    ///
    /// # Errors
    /// [`TokenError::Length`] and [`TokenError::Character`]; neither repeats the text.
    pub fn parse(text: &str) -> Result<Token, TokenError> {
        let found = text.chars().count();
        if !(LEN_MIN..=LEN_MAX).contains(&found) {
            return Err(TokenError::Length { found });
        }
        let allowed = |c: char| c.is_ascii_alphanumeric() || c == '-' || c == '_';
        match text.chars().position(|c| !allowed(c)) {
            Some(at) => Err(TokenError::Character { position: at + 1 }),
            None => Ok(Token(text.to_owned())),
        }
    }

    /// The token itself, to be shown once to whoever started the daemon.
    #[must_use]
    pub fn reveal(&self) -> &str {
        &self.0
    }

    /// Whether `candidate` is the token. Takes as long for a nearly right guess as for a wrong one
    /// of the same length; the length itself is no secret.
    pub(super) fn matches(&self, candidate: &str) -> bool {
        let (ours, theirs) = (self.0.as_bytes(), candidate.as_bytes());
        if ours.len() != theirs.len() {
            return false;
        }
        let difference = ours.iter().zip(theirs).fold(0_u8, |sum, (a, b)| sum | (a ^ b));
        // The compiler must not see that the fold could end early.
        std::hint::black_box(difference) == 0
    }
}

impl fmt::Debug for Token {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("Token(…)")
    }
}

const LEN_MIN: usize = 16;
const LEN_MAX: usize = 128;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn random_tokens_differ_and_parse() {
        let (a, b) = (Token::random().unwrap(), Token::random().unwrap());
        assert_ne!(a.reveal(), b.reveal());
        assert_eq!(Token::parse(a.reveal()).unwrap().reveal(), a.reveal());
        assert!(a.matches(a.reveal()) && !a.matches(b.reveal()));
    }

    #[test]
    fn only_the_whole_token_matches() {
        let token = Token::parse("0123456789abcdef").unwrap();
        for wrong in
            ["", "0123456789abcde", "0123456789abcdeg", "0123456789abcdef0", "X123456789abcdef"]
        {
            assert!(!token.matches(wrong), "{wrong}");
        }
    }

    #[test]
    fn bad_tokens_are_refused_and_never_shown() {
        assert!(matches!(Token::parse("short"), Err(TokenError::Length { found: 5 })));
        let error = Token::parse("0123456789 abcdefgh").unwrap_err();
        assert!(matches!(error, TokenError::Character { position: 11 }));
        assert!(!error.to_string().contains("0123456789"));
        assert_eq!(format!("{:?}", Token::parse("0123456789abcdef").unwrap()), "Token(…)");
    }
}
