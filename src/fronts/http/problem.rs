//! An error as a client reads it.

use std::fmt;

use axum::http::{HeaderValue, StatusCode, header};
use axum::response::{IntoResponse, Response};
use serde::Serialize;

/// A status and the JSON object `{error, expected, found, hint}`.
#[derive(Debug, Serialize)]
pub(super) struct Problem {
    #[serde(skip)]
    status: StatusCode,
    error: String,
    expected: Option<String>,
    found: Option<String>,
    hint: Option<String>,
}

impl Problem {
    pub(super) fn new(status: StatusCode, error: impl Into<String>) -> Problem {
        Problem { status, error: error.into(), expected: None, found: None, hint: None }
    }

    pub(super) fn expected(mut self, text: impl Into<String>) -> Problem {
        self.expected = Some(text.into());
        self
    }

    /// What came instead, shortened: a header can be long and comes from outside.
    pub(super) fn found(mut self, text: &str) -> Problem {
        let mut found: String = text.chars().take(FOUND_MAX).collect();
        if found.len() < text.len() {
            found.push('…');
        }
        self.found = Some(found);
        self
    }

    pub(super) fn hint(mut self, text: impl Into<String>) -> Problem {
        self.hint = Some(text.into());
        self
    }

    /// The object alone, for an answer that no route gives.
    pub(super) fn json(&self) -> Vec<u8> {
        // Strings are JSON; without them the status still says it.
        serde_json::to_vec(self).unwrap_or_default()
    }
}

/// For the log. What was found comes from outside: it is quoted.
impl fmt::Display for Problem {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.error)?;
        if let Some(expected) = &self.expected {
            write!(f, ": expected {expected}")?;
        }
        if let Some(found) = &self.found {
            write!(f, ", found {found:?}")?;
        }
        Ok(())
    }
}

impl IntoResponse for Problem {
    fn into_response(self) -> Response {
        let status = self.status;
        let mut response = (status, axum::Json(self)).into_response();
        if status == StatusCode::UNAUTHORIZED {
            // RFC 9110 section 11.6.1: a 401 names the scheme.
            let scheme = HeaderValue::from_static("Bearer realm=\"asphera\"");
            response.headers_mut().insert(header::WWW_AUTHENTICATE, scheme);
        }
        response
    }
}

const FOUND_MAX: usize = 120;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_log_has_words_and_quotes_what_came() {
        let problem = Problem::new(StatusCode::FORBIDDEN, "unknown host name")
            .expected("localhost")
            .found("evil\u{1b}[2J");
        let words = problem.to_string();
        assert_eq!(words, r#"unknown host name: expected localhost, found "evil\u{1b}[2J""#);
    }
}
