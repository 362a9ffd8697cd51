//! Requests as a fuzzer can write them, and what must hold for whatever the server answers.
//!
//! The first byte of an input says from where the client calls; what follows is all it sends. Behind the server lies a
//! session that has ended: its figures in memory, its files in a folder.

use std::net::{Ipv4Addr, SocketAddr};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Arc, OnceLock};

use asphera::results::{finished_mesh_ply, write};
use asphera::sessions::{file, list};
use asphera_http::{InProcess, Token};
use asphera_measure::{Measurement, Pipeline};
use asphera_report::contour::SessionContour;
use asphera_report::{
    Answer, ControlError, Cut, FormViewAnswer, Label, LiveStation, Report, ResultFile,
    SNAPSHOT_FORMAT, SamplingMaps, SectionRequest, SessionEntry, SessionFigures, SessionFile,
    Snapshot, State, Term, Waypoints,
};
use tokio::runtime::Runtime;
use tokio::sync::watch;

/// Sends an input and checks what came back.
///
/// # Panics
///
/// Where a law is broken.
pub fn hold(input: &[u8]) {
    let [peer, request @ ..] = input else { return };
    let is_near = peer % 2 == 0;
    let peer = if is_near { Ipv4Addr::LOCALHOST } else { Ipv4Addr::new(192, 0, 2, 7) };
    let desk = desk();
    let before = desk.asked();
    let answer =
        desk.runtime.block_on(desk.server.answer(SocketAddr::from((peer, 50_000)), request));
    let asked = desk.asked();
    let has_token = contains(request, TOKEN.as_bytes());
    assert!(has_token || asked.controls == before.controls, "a control without the token");
    assert!(has_token || is_near || asked.reads == before.reads, "a reading without the token");
    assert!(!contains(&answer, SECRET.as_bytes()), "a file beside the sessions was read");
    assert!(!contains(&answer, TOKEN.as_bytes()) || has_token, "the token was told");
    is_sound(&answer);
}

/// Every answer of ours carries the headers that keep a browser from harm; errors are JSON with four keys.
fn is_sound(answer: &[u8]) {
    if answer.is_empty() {
        // A client that sent no whole request.
        return;
    }
    let end = answer.windows(4).position(|bytes| bytes == b"\r\n\r\n").expect("a head that ends");
    let head = std::str::from_utf8(&answer[..end]).expect("a head is text");
    let (status, lines) = head.split_once("\r\n").expect("headers below the status");
    assert!(status.starts_with("HTTP/1.1 ") || status.starts_with("HTTP/1.0 "), "{status}");
    let status: u16 = status[9..12].parse().expect("a status");
    let header = |name: &str| {
        lines.split("\r\n").find_map(|line| {
            let (key, value) = line.split_once(": ")?;
            key.eq_ignore_ascii_case(name).then_some(value)
        })
    };
    for name in HEADERS {
        assert!(header(name).is_some(), "{status} without {name}:\n{head}");
    }
    assert_ne!(status, 500, "{}", String::from_utf8_lossy(answer));
    let length = header("content-length").and_then(|length| length.parse::<usize>().ok());
    let body =
        length.and_then(|length| answer[end + 4..].get(..length)).filter(|body| !body.is_empty());
    let (Some(body), Some("application/json")) = (body, header("content-type")) else { return };
    // The answer to HEAD has the length of a body and none; the next answer stands in its place.
    if body.starts_with(b"HTTP/1.") {
        return;
    }
    let json: serde_json::Value =
        serde_json::from_slice(body).expect("what says that it is JSON is");
    if status >= 400 {
        for key in ["error", "expected", "found", "hint"] {
            assert!(json.get(key).is_some(), "{status} without {key}: {json}");
        }
        assert!(body.len() < 4096, "an error of {} bytes", body.len());
    }
}

/// The server, and what it was asked for.
struct Desk {
    runtime: Runtime,
    server: InProcess,
    station: Arc<Station>,
}

#[derive(Clone, Copy)]
struct Asked {
    reads: usize,
    controls: usize,
}

impl Desk {
    fn asked(&self) -> Asked {
        let Station { reads, controls, .. } = &*self.station;
        Asked { reads: reads.load(Ordering::SeqCst), controls: controls.load(Ordering::SeqCst) }
    }
}

/// The one server of this process.
fn desk() -> &'static Desk {
    static DESK: OnceLock<Desk> = OnceLock::new();
    DESK.get_or_init(|| {
        let runtime = tokio::runtime::Builder::new_current_thread().enable_time().build();
        let runtime =
            runtime.expect("a runtime without input and output needs nothing of the system");
        let station = Arc::new(Station::with_a_session());
        let token = Token::parse(TOKEN).expect("a token of letters");
        let server = InProcess::new(token, Shown(Arc::clone(&station)));
        Desk { runtime, server, station }
    })
}

/// A station whose session has ended.
struct Station {
    measurement: Measurement,
    snapshots: watch::Sender<Arc<Snapshot>>,
    report: Arc<Report>,
    recordings: PathBuf,
    reads: AtomicUsize,
    controls: AtomicUsize,
}

impl Station {
    /// Measures a sphere of 400 points and leaves its files in a folder of its own.
    fn with_a_session() -> Station {
        let part =
            asphera_nominal::parse("nominal.toml", NOMINAL).expect("a nominal that can be read");
        let mut pipeline = Pipeline::new(part);
        let places = (0..400).map(|index| [f64::from(index % 20), f64::from(index / 20)]);
        pipeline.take_positions(places.map(|[column, row]| {
            let [x, y] = [column, row].map(|count| 0.5 * (count - 9.5));
            let noise_mm = 1e-6 * (7.0 * column + 3.0 * row * row).sin();
            [x, y, 50.0 - (2500.0 - x * x - y * y).sqrt() + noise_mm]
        }));
        let mut measurement = pipeline.finish();
        let session = SessionFigures {
            id: SESSION.to_owned(),
            started: "2026-05-04T03:02:01.5Z".to_owned(),
            station: "bench".to_owned(),
            label: Label { part: Some("Lens \"7\"".to_owned()), ..Label::default() },
            ..SessionFigures::default()
        };
        measurement.report.session = Some(session);
        let folder = std::env::temp_dir().join("asphera-http");
        let recordings = folder.join("recordings");
        write(&recordings.join(SESSION), &measurement)
            .expect("the temporary folder can be written");
        for secret in [folder.join("report.json"), recordings.join("report.json")] {
            std::fs::write(secret, SECRET).expect("the temporary folder can be written");
        }
        let report = Arc::new(measurement.report.clone());
        let snapshots = watch::Sender::new(Arc::new(shown(&report)));
        let (reads, controls) = (AtomicUsize::new(0), AtomicUsize::new(0));
        Station { measurement, snapshots, report, recordings, reads, controls }
    }

    fn read(&self) {
        self.reads.fetch_add(1, Ordering::SeqCst);
    }

    fn folder(&self) -> &Path {
        &self.recordings
    }
}

/// The snapshot of a session that has ended.
fn shown(report: &Report) -> Snapshot {
    Snapshot {
        format: SNAPSHOT_FORMAT,
        sequence: 1,
        station: "bench".to_owned(),
        state: State::Complete,
        elapsed_s: 1.5,
        session: report.session.clone(),
        progress: Default::default(),
        points: report.points.clone(),
        mesh: report.mesh.clone(),
        sampling: report.sampling.clone(),
        features: report.features.clone(),
        form: report.form.clone(),
        verdict: report.verdict.clone(),
        map: None,
        maps: None,
        contour: None,
        parts: None,
        volume: None,
        scan: None,
        convergence: Default::default(),
        outputs: None,
        links: Vec::new(),
    }
}

/// A station as the server sees it.
struct Shown(Arc<Station>);

impl LiveStation for Shown {
    fn snapshot(&self) -> Arc<Snapshot> {
        // Not counted: the health of a station is anybody's to ask, and comes from here too.
        Arc::clone(&self.0.snapshots.borrow())
    }

    fn snapshot_after(&self, sequence: u64) -> Answer<'_, Option<Arc<Snapshot>>> {
        let mut snapshots = self.0.snapshots.subscribe();
        Box::pin(async move {
            let newer = snapshots.wait_for(|snapshot| snapshot.sequence != sequence).await;
            newer.ok().map(|snapshot| Arc::clone(&snapshot))
        })
    }

    fn mesh_ply(&self) -> Answer<'_, Option<Vec<u8>>> {
        self.0.read();
        Box::pin(async { finished_mesh_ply(&self.0.measurement) })
    }

    fn maps(&self) -> Answer<'_, Option<Arc<SamplingMaps>>> {
        self.0.read();
        Box::pin(async { self.0.measurement.surface.maps() })
    }

    fn contour(&self) -> Answer<'_, Option<Arc<SessionContour>>> {
        self.0.read();
        Box::pin(async { None })
    }

    fn parts(&self) -> Answer<'_, Option<Arc<asphera_report::parts::SessionParts>>> {
        self.0.read();
        Box::pin(async { self.0.measurement.report.parts.clone().map(Arc::new) })
    }

    fn section(&self, request: SectionRequest) -> Answer<'_, Cut> {
        self.0.read();
        Box::pin(async move { self.0.measurement.surface.section(&request) })
    }

    fn without(&self, terms: Vec<Term>) -> Answer<'_, FormViewAnswer> {
        self.0.read();
        Box::pin(async move { self.0.measurement.surface.without(&terms) })
    }

    fn waypoints(&self) -> Answer<'_, Option<Waypoints>> {
        self.0.read();
        Box::pin(async { self.0.measurement.next.as_ref().map(asphera_measure::Next::waypoints) })
    }

    fn report(&self) -> Option<Arc<Report>> {
        self.0.read();
        Some(Arc::clone(&self.0.report))
    }

    fn sessions(&self) -> Answer<'_, Vec<SessionEntry>> {
        self.0.read();
        Box::pin(async { list(self.0.folder(), 10) })
    }

    fn session_file(&self, id: String, of: ResultFile) -> Answer<'_, Option<SessionFile>> {
        self.0.read();
        Box::pin(async move {
            let (bytes, session) = file(self.0.folder(), &id, of)?;
            Some(SessionFile { bytes, session })
        })
    }

    fn start(&self, label: Label) -> Answer<'_, Result<(), ControlError>> {
        self.0.controls.fetch_add(1, Ordering::SeqCst);
        for text in [label.part, label.serial, label.operator].into_iter().flatten() {
            assert!(!text.trim().is_empty() && !text.chars().any(char::is_control), "{text:?}");
        }
        Box::pin(async { Ok(()) })
    }

    fn stop(&self) -> Answer<'_, Result<(), ControlError>> {
        self.0.controls.fetch_add(1, Ordering::SeqCst);
        let message = "no session is running".to_owned();
        Box::pin(async { Err(ControlError { conflict: true, message }) })
    }
}

fn contains(text: &[u8], part: &[u8]) -> bool {
    text.windows(part.len()).any(|window| window == part)
}

/// The token of the server; seeds hold it, so that a fuzzer need not guess it.
pub const TOKEN: &str = "an-operators-token_01";
/// What lies beside the sessions and is nobody's to read.
const SECRET: &str = "a secret beside the sessions";
const SESSION: &str = "session-20260504T030201Z-0badcafe";
const NOMINAL: &str = "[surface]\nkind = \"sphere\"\nradius_mm = 50\n\
                       [aperture]\nshape = \"circle\"\nradius_mm = 5\n[tolerance]\npv_nm = 100\n";
/// Headers of every answer.
const HEADERS: [&str; 7] = [
    "content-security-policy",
    "x-content-type-options",
    "x-frame-options",
    "referrer-policy",
    "cache-control",
    "cross-origin-resource-policy",
    "cross-origin-opener-policy",
];
