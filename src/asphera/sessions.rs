//! The sessions that lie in the folder of the recordings, by the results left in them.

use std::fs;
use std::path::Path;

use asphera_report::{Label, ResultFile, SessionEntry, SessionFigures, Status};
use serde::Deserialize;

use crate::session::MANIFEST;

/// Part of a `report.json` that is read; the rest is passed over.
#[derive(Deserialize)]
struct Told {
    session: Option<SessionFigures>,
    points: ToldPoints,
    form: Option<ToldForm>,
    verdict: ToldVerdict,
}

#[derive(Deserialize)]
struct ToldPoints {
    used: u64,
}

#[derive(Deserialize)]
struct ToldForm {
    deviation: ToldDeviation,
}

#[derive(Deserialize)]
struct ToldDeviation {
    pv_nm: Option<f64>,
    rms_nm: Option<f64>,
}

#[derive(Deserialize)]
struct ToldVerdict {
    status: Status,
}

/// The newest sessions of a folder, the newest first, at most `most`. A folder that is not there has none; what cannot be read of a
/// session is `None`. Reads one `report.json` a session.
pub fn list(recordings: &Path, most: usize) -> Vec<SessionEntry> {
    let Ok(entries) = fs::read_dir(recordings) else { return Vec::new() };
    let names = entries.flatten().filter_map(|entry| entry.file_name().into_string().ok());
    let mut ids: Vec<String> = names.filter(|name| is_session(name)).collect();
    // The name begins with the time.
    ids.sort_unstable_by(|a, b| b.cmp(a));
    ids.truncate(most);
    ids.into_iter().map(|id| entry(recordings, id)).collect()
}

/// A result file of a session with the session it belongs to, as far as that is told; `None` where there is no such file.
pub fn file(
    recordings: &Path,
    id: &str,
    file: ResultFile,
) -> Option<(Vec<u8>, Option<SessionFigures>)> {
    if !is_session(id) {
        return None;
    }
    let folder = recordings.join(id);
    let bytes = fs::read(folder.join(file.name())).ok()?;
    Some((bytes, told(&folder).and_then(|told| told.session)))
}

/// Whether a name is that of a session's folder, and nothing that leads elsewhere.
fn is_session(name: &str) -> bool {
    name.strip_prefix("session-").is_some_and(|rest| {
        !rest.is_empty() && rest.bytes().all(|byte| byte.is_ascii_alphanumeric() || byte == b'-')
    })
}

fn told(folder: &Path) -> Option<Told> {
    let bytes = fs::read(folder.join(ResultFile::Report.name())).ok()?;
    serde_json::from_slice(&bytes).ok()
}

fn entry(recordings: &Path, id: String) -> SessionEntry {
    let folder = recordings.join(&id);
    let there = ResultFile::ALL.iter().map(|file| file.name());
    let files = there.filter(|name| folder.join(name).is_file()).collect();
    let Some(Told { session, points, form, verdict }) = told(&folder) else {
        // It runs, or was interrupted: its manifest was written before its first byte.
        let (started, label) = begun(&folder).unzip();
        return SessionEntry {
            id,
            started,
            label: label.unwrap_or_default(),
            ended: None,
            verdict: None,
            points: None,
            pv_nm: None,
            rms_nm: None,
            files,
        };
    };
    let deviation = form.map(|form| form.deviation);
    SessionEntry {
        id,
        started: session.as_ref().map(|session| session.started.clone()),
        label: session.as_ref().map(|session| session.label.clone()).unwrap_or_default(),
        ended: session.map(|session| session.ended),
        verdict: Some(verdict.status),
        points: Some(points.used),
        pv_nm: deviation.as_ref().and_then(|deviation| deviation.pv_nm),
        rms_nm: deviation.and_then(|deviation| deviation.rms_nm),
        files,
    }
}

/// When a session began and of what, by its manifest.
fn begun(folder: &Path) -> Option<(String, Label)> {
    #[derive(Deserialize)]
    struct Begun {
        started: String,
        session: BegunSession,
    }
    #[derive(Deserialize)]
    struct BegunSession {
        #[serde(default)]
        label: Label,
    }
    let bytes = fs::read(folder.join(MANIFEST)).ok()?;
    let begun: Begun = serde_json::from_slice(&bytes).ok()?;
    Some((begun.started, begun.session.label))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_session_without_a_report_has_its_start_and_its_label() {
        use crate::session::{Disk, Header, Recorder, SessionId, Settings};
        let folder = tempfile::tempdir().unwrap();
        let label = Label { part: Some("Lens 7".to_owned()), ..Label::default() };
        let header = Header {
            id: SessionId(7),
            station: "bench".to_owned(),
            version: "1".to_owned(),
            started_wall_ns: 1_800_000_000_000_000_000,
            config_toml: String::new(),
            links: Vec::new(),
            label: label.clone(),
        };
        let begun = asphera_link::Nanos::ZERO;
        let recorder =
            Recorder::create(folder.path(), header, Settings::default(), Box::new(Disk), begun);
        let running = recorder.unwrap();
        let found = list(folder.path(), 10);
        assert_eq!(found[0].started.as_deref(), Some("2027-01-15T08:00:00Z"));
        assert_eq!((&found[0].label, found[0].verdict), (&label, None));
        drop(running);
    }

    #[test]
    fn the_newest_come_first_and_what_is_no_session_is_passed_over() {
        let folder = tempfile::tempdir().unwrap();
        for name in ["session-20260101T000000Z-00000001", "session-20270101T000000Z-00000000", "a"]
        {
            fs::create_dir(folder.path().join(name)).unwrap();
        }
        let broken = folder.path().join("session-20260101T000000Z-00000001");
        fs::write(broken.join("report.json"), "{\"form").unwrap();
        fs::write(broken.join("report.html"), "<html>").unwrap();
        let found = list(folder.path(), 10);
        let ids: Vec<_> = found.iter().map(|entry| entry.id.as_str()).collect();
        assert_eq!(ids, ["session-20270101T000000Z-00000000", "session-20260101T000000Z-00000001"]);
        assert_eq!(
            (found[1].verdict, &found[1].files[..]),
            (None, &["report.json", "report.html"][..])
        );
        assert_eq!(list(folder.path(), 1).len(), 1);
        assert_eq!(list(&folder.path().join("none"), 1), []);
        let (bytes, session) =
            file(folder.path(), "session-20260101T000000Z-00000001", ResultFile::Html).unwrap();
        assert_eq!((&bytes[..], session), (&b"<html>"[..], None));
    }

    #[test]
    fn a_name_leads_to_no_other_folder() {
        let folder = tempfile::tempdir().unwrap();
        let recordings = folder.path().join("recordings");
        fs::create_dir_all(recordings.join("session-1")).unwrap();
        fs::write(folder.path().join("report.html"), "secret").unwrap();
        for id in ["..", "session-1/../..", "session-/../..", "session-", "", "/", "session-1/.."] {
            assert_eq!(file(&recordings, id, ResultFile::Html), None, "{id}");
        }
    }
}
