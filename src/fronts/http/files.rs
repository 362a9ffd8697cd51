//! Files of a session as a browser saves them: their names and types.

use asphera_report::{ResultFile, SessionFigures};
use axum::http::{HeaderValue, header};
use axum::response::{IntoResponse, Response};

/// The answer that holds a file: shown where it is a page, else saved, under a name that tells part and time.
pub(super) fn answer(of: ResultFile, bytes: Vec<u8>, session: Option<&SessionFigures>) -> Response {
    let (kind, shown) = match of {
        ResultFile::Report => ("application/json", "attachment"),
        ResultFile::Html => ("text/html; charset=utf-8", "inline"),
        ResultFile::Qif => ("application/xml", "attachment"),
        ResultFile::Mesh | ResultFile::DeviationMesh | ResultFile::DeviationMap => {
            ("application/octet-stream", "attachment")
        }
    };
    let mut response = ([(header::CONTENT_TYPE, kind)], bytes).into_response();
    let headers = response.headers_mut();
    headers.insert(header::CONTENT_DISPOSITION, disposition(shown, of.name(), session));
    if of == ResultFile::Html {
        // The report has its style and pictures inside, and no script.
        headers.insert(header::CONTENT_SECURITY_POLICY, HeaderValue::from_static(PAPER_POLICY));
    }
    response
}

/// `attachment; filename="lens-7_0815_20261123T010203Z_report.json"`: part, serial number and start of the session, or the
/// station where no part was named.
pub(super) fn disposition(
    shown: &str,
    file: &str,
    session: Option<&SessionFigures>,
) -> HeaderValue {
    let mut name = String::new();
    if let Some(session) = session {
        let label = &session.label;
        let part = label.part.as_ref().or(label.serial.is_none().then_some(&session.station));
        for word in [part, label.serial.as_ref()].into_iter().flatten() {
            name += &plain(word);
        }
        // Without fractions of a second, and without signs a file system minds.
        let started = session.started.split('.').next().unwrap_or_default();
        let digits: String = started.chars().filter(char::is_ascii_alphanumeric).collect();
        name += &plain(digits.trim_end_matches('Z'));
    }
    let value = format!("{shown}; filename=\"{name}{file}\"");
    HeaderValue::from_str(&value).unwrap_or(HeaderValue::from_static("attachment"))
}

/// A word of letters, digits, dots and dashes, with `_` behind it; nothing of one that has none.
fn plain(word: &str) -> String {
    let kept = |sign: char| sign.is_ascii_alphanumeric() || matches!(sign, '.' | '-');
    let plain: String = word.chars().map(|sign| if kept(sign) { sign } else { '-' }).collect();
    let plain = plain.trim_matches(['-', '.']);
    let short: String = plain.chars().take(40).collect();
    if short.is_empty() { short } else { short + "_" }
}

/// Of a report: its own style and pictures, nothing from elsewhere, no script.
const PAPER_POLICY: &str = "default-src 'none'; style-src 'unsafe-inline'; img-src data:; \
                            base-uri 'none'; frame-ancestors 'none'; form-action 'none'";

#[cfg(test)]
mod tests {
    use asphera_report::Label;

    use super::*;

    #[test]
    fn names_tell_part_and_time_and_stay_plain() {
        let session = |part: Option<&str>, serial: Option<&str>| SessionFigures {
            started: "2026-11-23T01:02:03.456Z".to_owned(),
            station: "Bench 1".to_owned(),
            label: Label {
                part: part.map(str::to_owned),
                serial: serial.map(str::to_owned),
                operator: None,
            },
            ..SessionFigures::default()
        };
        let name = |session: &SessionFigures| {
            let value = disposition("attachment", "report.json", Some(session));
            value.to_str().unwrap().to_owned()
        };
        assert_eq!(
            name(&session(Some("Lens \"7\"\r\nµ"), Some("../08"))),
            "attachment; filename=\"Lens--7_08_20261123T010203_report.json\""
        );
        assert_eq!(
            name(&session(None, None)),
            "attachment; filename=\"Bench-1_20261123T010203_report.json\""
        );
        assert_eq!(
            disposition("attachment", "mesh.ply", None).to_str().unwrap(),
            "attachment; filename=\"mesh.ply\""
        );
    }
}
