//! A station of fixed figures and a plain HTTP/1.1 client, for the tests.

use std::net::{Ipv4Addr, SocketAddr};
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Arc, Mutex};
use std::time::Duration;

use asphera_report::contour::SessionContour;
use asphera_report::{
    Connection, ControlError, Convergence, Cut, FormView, FormViewAnswer, Label, LinkState,
    LiveStation, Map, MeshFigures, Points, Progress, Refusal, Report, ResultFile, SNAPSHOT_FORMAT,
    SamplingFigures, SamplingMaps, SectionRequest, SessionEntry, SessionFile, SliceAnswer,
    SliceRequest, Snapshot, State, Term, Timing, VOLUME_SLICE_FORMAT, Verdict, VolumeSlice,
    VolumeView, Waypoints,
};
use tokio::io::{AsyncReadExt, AsyncWriteExt};
use tokio::net::TcpStream;
use tokio::sync::{oneshot, watch};
use tokio::task::JoinHandle;
use tokio_tungstenite::tungstenite::client::IntoClientRequest;
use tokio_tungstenite::tungstenite::handshake::client::Response;
use tokio_tungstenite::{MaybeTlsStream, WebSocketStream, tungstenite};

use crate::{Limits, Server, Token};

pub(super) const TOKEN: &str = "an-operators-token_01";

/// What the fake station holds and how often it was asked.
#[derive(Clone)]
pub(super) struct Station {
    pub(super) snapshots: watch::Sender<Arc<Snapshot>>,
    pub(super) mesh: Option<Vec<u8>>,
    pub(super) maps: Option<Arc<SamplingMaps>>,
    pub(super) contour: Option<Arc<SessionContour>>,
    pub(super) parts: Option<Arc<asphera_report::parts::SessionParts>>,
    pub(super) volume: Option<Arc<VolumeView>>,
    pub(super) cut: fn(&SectionRequest) -> Cut,
    pub(super) view: FormViewAnswer,
    pub(super) waypoints: Option<Waypoints>,
    pub(super) report: Option<Arc<Report>>,
    pub(super) answer: Result<(), ControlError>,
    pub(super) sessions: Vec<SessionEntry>,
    /// A file of a session.
    pub(super) file: Option<(String, ResultFile, SessionFile)>,
    /// Of the session that was started last.
    pub(super) label: Arc<Mutex<Label>>,
    pub(super) started: Arc<AtomicUsize>,
    pub(super) stopped: Arc<AtomicUsize>,
}

impl Station {
    pub(super) fn new() -> Station {
        Station {
            snapshots: watch::Sender::new(Arc::new(snapshot(1, 0))),
            mesh: None,
            maps: None,
            contour: None,
            parts: None,
            volume: None,
            cut: |_| None,
            view: None,
            waypoints: None,
            report: None,
            answer: Ok(()),
            sessions: Vec::new(),
            file: None,
            label: Arc::default(),
            started: Arc::default(),
            stopped: Arc::default(),
        }
    }

    pub(super) fn publish(&self, snapshot: Snapshot) {
        self.snapshots.send_replace(Arc::new(snapshot));
    }
}

impl LiveStation for Station {
    fn snapshot(&self) -> Arc<Snapshot> {
        Arc::clone(&self.snapshots.borrow())
    }

    fn snapshot_after(&self, sequence: u64) -> asphera_report::Answer<'_, Option<Arc<Snapshot>>> {
        let mut snapshots = self.snapshots.subscribe();
        Box::pin(async move {
            let newer = snapshots.wait_for(|snapshot| snapshot.sequence != sequence).await;
            newer.ok().map(|snapshot| Arc::clone(&snapshot))
        })
    }

    fn mesh_ply(&self) -> asphera_report::Answer<'_, Option<Vec<u8>>> {
        Box::pin(async { self.mesh.clone() })
    }

    fn maps(&self) -> asphera_report::Answer<'_, Option<Arc<SamplingMaps>>> {
        Box::pin(async { self.maps.clone() })
    }

    fn contour(&self) -> asphera_report::Answer<'_, Option<Arc<SessionContour>>> {
        Box::pin(async { self.contour.clone() })
    }

    fn parts(
        &self,
    ) -> asphera_report::Answer<'_, Option<Arc<asphera_report::parts::SessionParts>>> {
        Box::pin(async { self.parts.clone() })
    }

    fn volume(&self) -> asphera_report::Answer<'_, Option<Arc<VolumeView>>> {
        Box::pin(async { self.volume.clone() })
    }

    /// Of a single grey pixel.
    fn volume_slice(&self, request: SliceRequest) -> asphera_report::Answer<'_, SliceAnswer> {
        Box::pin(async move {
            let SliceRequest { axis, index } = request;
            let volume = self.volume.as_ref()?;
            if index >= volume.size[axis.index()] {
                return Some(Err(Refusal(format!("no slice {index} across {}", axis.name()))));
            }
            Some(Ok(VolumeSlice {
                format: VOLUME_SLICE_FORMAT,
                axis,
                index,
                columns: 1,
                rows: 1,
                step: 1,
                pixels: vec![128],
                contour: vec![[0.0, 0.5, 1.0, 0.5]],
                contour_left_out: 0,
                points: Vec::new(),
                points_left_out: 0,
            }))
        })
    }

    fn section(&self, request: SectionRequest) -> asphera_report::Answer<'_, Cut> {
        Box::pin(async move { (self.cut)(&request) })
    }

    fn without(&self, terms: Vec<Term>) -> asphera_report::Answer<'_, FormViewAnswer> {
        Box::pin(async move {
            let view = self.view.clone()?;
            let removed = terms.iter().map(ToString::to_string).collect();
            Some(view.map(|view| FormView { removed, ..view }))
        })
    }

    fn waypoints(&self) -> asphera_report::Answer<'_, Option<Waypoints>> {
        Box::pin(async { self.waypoints.clone() })
    }

    fn report(&self) -> Option<Arc<Report>> {
        self.report.clone()
    }

    fn sessions(&self) -> asphera_report::Answer<'_, Vec<SessionEntry>> {
        Box::pin(async { self.sessions.clone() })
    }

    fn session_file(
        &self,
        id: String,
        of: ResultFile,
    ) -> asphera_report::Answer<'_, Option<SessionFile>> {
        let file = self.file.clone();
        let file = file.filter(|(session, name, _)| (session, name) == (&id, &of));
        Box::pin(async { file.map(|(_, _, file)| file) })
    }

    fn start(&self, label: Label) -> asphera_report::Answer<'_, Result<(), ControlError>> {
        *self.label.lock().unwrap() = label;
        self.started.fetch_add(1, Ordering::SeqCst);
        Box::pin(async { self.answer.clone() })
    }

    fn stop(&self) -> asphera_report::Answer<'_, Result<(), ControlError>> {
        self.stopped.fetch_add(1, Ordering::SeqCst);
        Box::pin(async { self.answer.clone() })
    }
}

/// A server that runs until it is asked to end.
pub(super) struct Running {
    pub(super) addr: SocketAddr,
    shutdown: oneshot::Sender<()>,
    task: JoinHandle<()>,
}

impl Running {
    pub(super) async fn start(station: &Station) -> Running {
        Running::with(station, Limits::default(), Vec::new()).await
    }

    pub(super) async fn with(
        station: &Station,
        limits: Limits,
        allowed_hosts: Vec<String>,
    ) -> Running {
        let server = Server::bind(
            (Ipv4Addr::LOCALHOST, 0).into(),
            Token::parse(TOKEN).unwrap(),
            station.clone(),
        )
        .await
        .unwrap()
        .with_limits(limits)
        .with_allowed_hosts(allowed_hosts);
        let addr = server.local_addr();
        let (shutdown, asked) = oneshot::channel();
        let task = tokio::spawn(server.serve(async move {
            let _ = asked.await;
        }));
        Running { addr, shutdown, task }
    }

    /// Ends the server and waits until it has ended.
    pub(super) async fn end(self) {
        self.shutdown.send(()).unwrap();
        within(self.task).await.unwrap();
    }

    /// One request with exactly these header lines beside `Connection`.
    pub(super) async fn ask(&self, method: &str, path: &str, headers: &[(&str, &str)]) -> Answer {
        self.send(method, path, headers, "").await
    }

    /// The same with a body, whose length the headers tell.
    pub(super) async fn send(
        &self,
        method: &str,
        path: &str,
        headers: &[(&str, &str)],
        body: &str,
    ) -> Answer {
        let mut text = format!("{method} {path} HTTP/1.1\r\nConnection: close\r\n");
        for (name, value) in headers {
            text.push_str(&format!("{name}: {value}\r\n"));
        }
        text.push_str("\r\n");
        text.push_str(body);
        let mut socket = TcpStream::connect(self.addr).await.unwrap();
        socket.write_all(text.as_bytes()).await.unwrap();
        let mut bytes = Vec::new();
        within(socket.read_to_end(&mut bytes)).await.unwrap();
        Answer::parse(&bytes)
    }

    pub(super) async fn get(&self, path: &str) -> Answer {
        self.ask("GET", path, &[("Host", &self.host())]).await
    }

    pub(super) fn host(&self) -> String {
        self.addr.to_string()
    }

    /// Opens the stream with these header lines beside those of the handshake; gives the answer too.
    pub(super) async fn handshake(
        &self,
        headers: &[(&'static str, &str)],
    ) -> Result<(Stream, Response), tungstenite::Error> {
        let mut request = format!("ws://{}/api/v1/stream", self.addr).into_client_request()?;
        for (name, value) in headers {
            request.headers_mut().insert(*name, value.parse().unwrap());
        }
        tokio_tungstenite::connect_async(request).await
    }

    pub(super) async fn stream_with(
        &self,
        headers: &[(&'static str, &str)],
    ) -> Result<Stream, tungstenite::Error> {
        self.handshake(headers).await.map(|(stream, _)| stream)
    }

    pub(super) async fn stream(&self) -> Stream {
        self.stream_with(&[]).await.unwrap()
    }
}

pub(super) type Stream = WebSocketStream<MaybeTlsStream<TcpStream>>;

/// Answer.
pub(super) struct Answer {
    pub(super) status: u16,
    head: String,
    pub(super) body: Vec<u8>,
}

impl Answer {
    fn parse(bytes: &[u8]) -> Answer {
        let split = bytes.windows(4).position(|w| w == b"\r\n\r\n").expect("a head");
        let head = String::from_utf8(bytes[..split].to_vec()).unwrap();
        let status = head.split(' ').nth(1).unwrap().parse().unwrap();
        let answer = Answer { status, head, body: bytes[split + 4..].to_vec() };
        if let Some(length) = answer.header("content-length")
            && !answer.body.is_empty()
        {
            assert_eq!(length, answer.body.len().to_string());
        }
        answer
    }

    pub(super) fn header(&self, name: &str) -> Option<&str> {
        self.head.lines().skip(1).find_map(|line| {
            let (key, value) = line.split_once(": ")?;
            key.eq_ignore_ascii_case(name).then_some(value)
        })
    }

    pub(super) fn json(&self) -> serde_json::Value {
        assert_eq!(self.header("content-type"), Some("application/json"), "{}", self.head);
        serde_json::from_slice(&self.body).unwrap()
    }

    /// Asserts the status and the four keys of an error; gives its text.
    pub(super) fn problem(&self, status: u16) -> String {
        assert_eq!(self.status, status, "{}", String::from_utf8_lossy(&self.body));
        let json = self.json();
        let keys: Vec<_> = json.as_object().unwrap().keys().map(String::as_str).collect();
        assert_eq!(keys, ["error", "expected", "found", "hint"]);
        assert!(json["error"].as_str().is_some_and(|text| !text.is_empty()));
        json.to_string()
    }
}

/// Fails the test instead of hanging.
pub(super) async fn within<T>(future: impl Future<Output = T>) -> T {
    tokio::time::timeout(Duration::from_secs(30), future).await.expect("an end within 30 s")
}

/// A snapshot with a map of `cells` cells.
pub(super) fn snapshot(sequence: u64, cells: usize) -> Snapshot {
    Snapshot {
        format: SNAPSHOT_FORMAT,
        sequence,
        station: "bench".to_owned(),
        state: State::Measuring,
        elapsed_s: 1.5,
        session: None,
        progress: Progress::default(),
        points: Points::default(),
        mesh: MeshFigures::default(),
        sampling: SamplingFigures::default(),
        features: Default::default(),
        form: None,
        verdict: Verdict::default(),
        map: (cells > 0).then(|| Map {
            nx: cells,
            ny: 1,
            x0_mm: 0.0,
            y0_mm: 0.0,
            dx_mm: 1.0,
            dy_mm: 1.0,
            values_nm: vec![Some(-123_456.7); cells],
        }),
        maps: None,
        contour: None,
        parts: None,
        volume: None,
        scan: None,
        convergence: Convergence::default(),
        outputs: None,
        links: vec![LinkState {
            name: "probe".to_owned(),
            kind: "tcp".to_owned(),
            address: "127.0.0.1:7891".to_owned(),
            devices: vec!["probe".to_owned()],
            state: Connection::Connected,
            rate_hz: 2000.0,
            readings: 10,
            received_bytes: 120,
            errors: 0,
            lost: 0,
            reconnects: 0,
            age_s: None,
            last_error: None,
        }],
    }
}

pub(super) fn report() -> Report {
    Report {
        format: asphera_report::REPORT_FORMAT.to_owned(),
        reading: None,
        volume: None,
        points: Points::default(),
        mesh: MeshFigures::default(),
        sampling: SamplingFigures::default(),
        features: Default::default(),
        form: None,
        profile: None,
        contour: None,
        parts: None,
        verdict: Verdict::default(),
        links: Vec::new(),
        timing: Timing::default(),
        session: None,
    }
}
