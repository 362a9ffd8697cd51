//! The server: binding, serving and an orderly end.

use std::io;
use std::net::{IpAddr, Ipv4Addr, Ipv6Addr, SocketAddr};
use std::sync::Arc;
use std::time::Duration;

use asphera_report::{LiveStation, Snapshot};
use axum::Router;
use tokio::net::TcpListener;
use tokio::sync::{Semaphore, watch};

use super::encoder::Encoder;
use super::token::Token;
use super::{api, connections, guard};

/// A bound port that is not served yet.
pub struct Server {
    listener: TcpListener,
    local_addr: SocketAddr,
    token: Token,
    source: Arc<dyn LiveStation>,
    allowed_hosts: Vec<String>,
    limits: Limits,
    texts: Vec<TextRoute>,
}

/// A front that says a snapshot as text, and the path at which it is answered. Who may read it may read the snapshot.
#[derive(Clone, Copy, Debug)]
pub struct TextRoute {
    /// Path: `/metrics`.
    pub path: &'static str,
    /// Media type of the answer.
    pub content_type: &'static str,
    /// Text of a snapshot.
    pub text: fn(&Snapshot) -> String,
}

/// Bounds on clients.
#[derive(Clone, Copy, Debug)]
pub struct Limits {
    /// Connections at one time; one more is closed at once. Default 256. A stream no longer counts as one.
    pub connections: usize,
    /// How long a client may take for the head of a request, and stay silent before the next one, ms. Default 30,000.
    pub head_ms: u64,
    /// Streams (WebSockets) at one time; one more is answered with 503. Default 50.
    pub streams: usize,
    /// How long a client may take to receive a snapshot before its stream is closed, or take nothing of an answer, ms. Default
    /// 10,000.
    pub answer_ms: u64,
    /// After how long without a new snapshot a stream says that it is alive, ms. Default 2,000; the
    /// page takes a stream that is silent for 6 s for broken.
    pub alive_ms: u64,
    /// How long answers may take to end after the shutdown began, ms. Default 3,000.
    pub shutdown_ms: u64,
}

impl Default for Limits {
    fn default() -> Limits {
        Limits {
            connections: 256,
            head_ms: 30_000,
            streams: 50,
            answer_ms: 10_000,
            alive_ms: 2_000,
            shutdown_ms: 3_000,
        }
    }
}

/// Why a port could not be bound: the system's answer.
#[derive(Debug, thiserror::Error)]
#[error("cannot listen on {addr}")]
pub struct BindError {
    /// The address asked for.
    pub addr: SocketAddr,
    /// Why: taken, not ours or not allowed.
    pub source: io::Error,
}

impl Server {
    /// Binds `addr`; port 0 takes a free one, see [`Server::local_addr`]. Clients that connect wait
    /// until [`Server::serve`] runs.
    ///
    /// # Errors
    /// Where the address is taken, not ours or not allowed.
    pub async fn bind(
        addr: SocketAddr,
        token: Token,
        source: impl LiveStation,
    ) -> Result<Server, BindError> {
        let refused = |source: io::Error| BindError { addr, source };
        let listener = TcpListener::bind(addr).await.map_err(refused)?;
        Server::of(listener, token, source).map_err(refused)
    }

    /// The server of a port that was bound before.
    ///
    /// # Errors
    /// Where the runtime cannot take the port.
    pub fn of_bound(
        listener: std::net::TcpListener,
        token: Token,
        source: impl LiveStation,
    ) -> io::Result<Server> {
        listener.set_nonblocking(true)?;
        Server::of(TcpListener::from_std(listener)?, token, source)
    }

    fn of(listener: TcpListener, token: Token, source: impl LiveStation) -> io::Result<Server> {
        let local_addr = listener.local_addr()?;
        if !local_addr.ip().is_loopback() {
            tracing::warn!(%local_addr, "the page is reachable from other machines, unencrypted");
        }
        Ok(Server {
            listener,
            local_addr,
            token,
            source: Arc::new(source),
            allowed_hosts: Vec::new(),
            limits: Limits::default(),
            texts: Vec::new(),
        })
    }

    /// Host names, without port, under which the server answers beside `localhost` and IP literals.
    #[must_use]
    pub fn with_allowed_hosts(mut self, names: Vec<String>) -> Server {
        self.allowed_hosts = names;
        self
    }

    /// Answers the text of another front, too.
    #[must_use]
    pub fn with_text(mut self, route: TextRoute) -> Server {
        self.texts.push(route);
        self
    }

    /// Other limits than the default ones.
    #[must_use]
    pub fn with_limits(mut self, limits: Limits) -> Server {
        self.limits = limits;
        self
    }

    /// The address that was bound.
    #[must_use]
    pub fn local_addr(&self) -> SocketAddr {
        self.local_addr
    }

    /// The page's address, read-only.
    #[must_use]
    pub fn url(&self) -> String {
        let ip = match self.local_addr.ip() {
            IpAddr::V4(ip) if ip.is_unspecified() => Ipv4Addr::LOCALHOST.into(),
            IpAddr::V6(ip) if ip.is_unspecified() => Ipv6Addr::LOCALHOST.into(),
            ip => ip,
        };
        format!("http://{}/", SocketAddr::new(ip, self.local_addr.port()))
    }

    /// The page's address with the token: for whoever started the daemon, not for a log. A browser
    /// never sends the part behind `#`.
    #[must_use]
    pub fn url_with_token(&self) -> String {
        format!("{}#token={}", self.url(), self.token.reveal())
    }

    /// Serves until `shutdown` resolves, then closes the streams and lets open answers end within
    /// [`Limits::shutdown_ms`].
    pub async fn serve(self, shutdown: impl Future<Output = ()> + Send + 'static) {
        let (closing, _) = watch::channel(false);
        let Server { listener, token, source, allowed_hosts, limits, texts, .. } = self;
        let shared = Shared::new(source, token, allowed_hosts, limits, closing.clone());
        let router = guarded(&shared, &texts);
        let signal = async {
            shutdown.await;
            closing.send_replace(true);
        };
        let serving = connections::serve(listener, router, limits, closing.subscribe());
        let patience = async {
            let mut closing = closing.subscribe();
            // The sender lives in this function: waiting ends by the signal only.
            let _ = closing.wait_for(|closing| *closing).await;
            tokio::time::sleep(Duration::from_millis(limits.shutdown_ms)).await;
        };
        let streams = u32::try_from(limits.streams).unwrap_or(u32::MAX);
        tokio::select! {
            () = async {
                tokio::join!(signal, serving);
                // Every stream gives its permit back when its close frame is sent. The semaphore
                // is never closed, so that acquiring cannot fail.
                let _ = shared.streams.acquire_many(streams).await;
            } => {}
            () = patience => {
                tracing::warn!("clients were cut off at shutdown: they did not finish in time");
            }
        }
    }
}

/// All routes behind the checks that every request must pass.
pub(super) fn guarded(shared: &Arc<Shared>, texts: &[TextRoute]) -> Router {
    api::router(shared, texts)
        .layer(axum::middleware::from_fn_with_state(Arc::clone(shared), guard::every))
}

/// State that every request handler sees.
pub(super) struct Shared {
    pub(super) source: Arc<dyn LiveStation>,
    pub(super) token: Token,
    pub(super) allowed_hosts: Vec<String>,
    pub(super) limits: Limits,
    pub(super) encoder: Encoder,
    /// One permit for each stream that may still be opened.
    pub(super) streams: Arc<Semaphore>,
    /// A mesh is large: one at a time is made into a file.
    pub(super) meshes: Semaphore,
    /// Becomes true when the shutdown begins.
    pub(super) closing: watch::Sender<bool>,
}

impl Shared {
    pub(super) fn new(
        source: Arc<dyn LiveStation>,
        token: Token,
        allowed_hosts: Vec<String>,
        limits: Limits,
        closing: watch::Sender<bool>,
    ) -> Arc<Shared> {
        Arc::new(Shared {
            source,
            token,
            allowed_hosts,
            limits,
            encoder: Encoder::default(),
            streams: Arc::new(Semaphore::new(limits.streams.min(Semaphore::MAX_PERMITS))),
            meshes: Semaphore::new(1),
            closing,
        })
    }
}
