//! Connections: so many at a time, each with its time-outs.
//!
//! A client that says nothing, or stops within the head of a request, is cut off after [`Limits::head_ms`]; one that does not
//! take what it asked for after [`Limits::answer_ms`] without a byte taken. So neither holds memory or a connection for long.

use std::convert::Infallible;
use std::io;
use std::net::SocketAddr;
use std::pin::{Pin, pin};
use std::task::{Context, Poll, ready};
use std::time::Duration;

use axum::Router;
use axum::body::Body;
use axum::extract::ConnectInfo;
use axum::http::Request;
use hyper::body::Incoming;
use hyper::server::conn::http1;
use hyper::service::service_fn;
use hyper_util::rt::{TokioIo, TokioTimer};
use tokio::io::{AsyncRead, AsyncWrite, ReadBuf};
use tokio::net::TcpListener;
use tokio::sync::watch;
use tokio::task::JoinSet;
use tokio::time::{Instant, Sleep, sleep};
use tower_service::Service as _;

use super::server::Limits;
use super::turns::{Turn, Turns};

/// Serves until `closing` becomes true, then until the open answers have ended.
pub(super) async fn serve(
    listener: TcpListener,
    router: Router,
    limits: Limits,
    mut closing: watch::Receiver<bool>,
) {
    let mut connections = JoinSet::new();
    let mut turned_away = TurnedAway::default();
    loop {
        let accepted = tokio::select! {
            biased;
            () = closed(&mut closing) => break,
            Some(_) = connections.join_next() => continue,
            accepted = listener.accept() => accepted,
        };
        match accepted {
            Ok((_, peer)) if connections.len() >= limits.connections => {
                if let Some(clients) = turned_away.count(Instant::now()) {
                    tracing::warn!(clients, last = %peer, "clients were turned away: too many connections");
                }
            }
            Ok((socket, peer)) => {
                // Snapshots are small and followed by a wait for the answer: Nagle's algorithm against delayed
                // acknowledgements would make that 40 ms each.
                if let Err(error) = socket.set_nodelay(true) {
                    tracing::debug!(%error, "cannot set TCP_NODELAY");
                }
                let router = router.clone();
                connections.spawn(connection(socket, peer, router, limits, closing.clone()));
            }
            Err(error) => {
                tracing::warn!(%error, "no connection can be accepted");
                sleep(PAUSE).await;
            }
        }
    }
    // Who comes now is refused at once.
    drop(listener);
    while connections.join_next().await.is_some() {}
}

/// Clients that were turned away: counted, and said now and then. A log line for each would fill a disk.
#[derive(Default)]
struct TurnedAway {
    unsaid: u64,
    said_at: Option<Instant>,
}

impl TurnedAway {
    /// One more. How many there were since it was said last, where it is to be said again.
    fn count(&mut self, now: Instant) -> Option<u64> {
        self.unsaid += 1;
        let is_due = self.said_at.is_none_or(|at| now.duration_since(at) >= SAID_EVERY);
        is_due.then(|| {
            self.said_at = Some(now);
            std::mem::take(&mut self.unsaid)
        })
    }
}

/// How often it is said that clients were turned away.
const SAID_EVERY: Duration = Duration::from_secs(10);

async fn closed(closing: &mut watch::Receiver<bool>) {
    // Without a sender nobody is left who could say it.
    let _ = closing.wait_for(|closing| *closing).await;
}

/// Serves one connection to its end, or until `closing` becomes true and the answer on its way has ended.
pub(super) async fn connection<S>(
    socket: S,
    peer: SocketAddr,
    router: Router,
    limits: Limits,
    mut closing: watch::Receiver<bool>,
) where
    S: AsyncRead + AsyncWrite + Send + Unpin + 'static,
{
    let turn = Turn::new();
    let socket =
        Patient { socket, patience: Duration::from_millis(limits.answer_ms), gives_up: None };
    let socket = Turns::new(socket, turn.clone());
    let service = service_fn(move |request: Request<Incoming>| {
        let mut request = request.map(Body::new);
        request.extensions_mut().insert(ConnectInfo(peer));
        // Before anything waits: hyper reads on as soon as it may.
        let is_last = turn.begin(&request);
        let (turn, answer) = (turn.clone(), router.clone().call(request));
        async move { Ok::<_, Infallible>(turn.answer(answer.await?, is_last)) }
    });
    let serving = http1::Builder::new()
        .timer(TokioTimer::new())
        .header_read_timeout(Duration::from_millis(limits.head_ms))
        .max_buf_size(BUFFER)
        .serve_connection(TokioIo::new(socket), service)
        .with_upgrades();
    let mut serving = pin!(serving);
    let ended = tokio::select! {
        ended = serving.as_mut() => ended,
        () = closed(&mut closing) => {
            serving.as_mut().graceful_shutdown();
            serving.await
        }
    };
    if let Err(error) = ended {
        tracing::debug!(%error, %peer, "a connection ended early");
    }
}

/// A socket that gives up where nothing of what is written is taken for some time.
struct Patient<S> {
    socket: S,
    patience: Duration,
    gives_up: Option<Pin<Box<Sleep>>>,
}

impl<S> Patient<S> {
    /// The outcome of an attempt to write, or that it took too long.
    fn wait<T>(
        &mut self,
        attempt: Poll<io::Result<T>>,
        context: &mut Context<'_>,
    ) -> Poll<io::Result<T>> {
        if attempt.is_ready() {
            self.gives_up = None;
            return attempt;
        }
        let patience = self.patience;
        ready!(
            self.gives_up.get_or_insert_with(|| Box::pin(sleep(patience))).as_mut().poll(context)
        );
        Poll::Ready(Err(io::Error::new(io::ErrorKind::TimedOut, "the client takes nothing")))
    }
}

impl<S: AsyncRead + Unpin> AsyncRead for Patient<S> {
    fn poll_read(
        mut self: Pin<&mut Self>,
        context: &mut Context<'_>,
        buffer: &mut ReadBuf<'_>,
    ) -> Poll<io::Result<()>> {
        Pin::new(&mut self.socket).poll_read(context, buffer)
    }
}

impl<S: AsyncWrite + Unpin> AsyncWrite for Patient<S> {
    fn poll_write(
        mut self: Pin<&mut Self>,
        context: &mut Context<'_>,
        bytes: &[u8],
    ) -> Poll<io::Result<usize>> {
        let attempt = Pin::new(&mut self.socket).poll_write(context, bytes);
        self.wait(attempt, context)
    }

    fn poll_write_vectored(
        mut self: Pin<&mut Self>,
        context: &mut Context<'_>,
        bytes: &[io::IoSlice<'_>],
    ) -> Poll<io::Result<usize>> {
        let attempt = Pin::new(&mut self.socket).poll_write_vectored(context, bytes);
        self.wait(attempt, context)
    }

    fn is_write_vectored(&self) -> bool {
        self.socket.is_write_vectored()
    }

    fn poll_flush(mut self: Pin<&mut Self>, context: &mut Context<'_>) -> Poll<io::Result<()>> {
        Pin::new(&mut self.socket).poll_flush(context)
    }

    fn poll_shutdown(mut self: Pin<&mut Self>, context: &mut Context<'_>) -> Poll<io::Result<()>> {
        Pin::new(&mut self.socket).poll_shutdown(context)
    }
}

/// Bytes of a request or an answer that are kept for a connection.
const BUFFER: usize = 64 * 1024;
/// Before the next try where none was accepted: without file handles a try costs a turn of the processor.
const PAUSE: Duration = Duration::from_millis(100);

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn clients_turned_away_are_said_at_once_and_then_counted() {
        let (mut turned_away, begun) = (TurnedAway::default(), Instant::now());
        let at = |seconds: f64| begun + Duration::from_secs_f64(seconds);
        assert_eq!(turned_away.count(at(0.0)), Some(1));
        for client in 1..200 {
            assert_eq!(turned_away.count(at(f64::from(client) * 0.01)), None);
        }
        assert_eq!(turned_away.count(at(10.0)), Some(200));
        assert_eq!(turned_away.count(at(11.0)), None);
    }
}
