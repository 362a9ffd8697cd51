//! A station with its page, until a signal: what `run` and `demo` share.

use std::io;
use std::net::{SocketAddr, TcpListener};
use std::time::Duration;

use asphera_http::{BindError, Server, TextRoute, Token};
use asphera_link::Command;
use asphera_report::LiveStation;
use asphera_transport::{Holder, holder_of_port};
use thiserror::Error;
use tokio::signal::unix::{SignalKind, signal};
use tokio::sync::oneshot;
use tokio::task::JoinHandle;
use tokio::time::{sleep, timeout};

use super::exit::Exit;
use super::output::{Failure, say};
use crate::live::{Closed, Station, StationError};
use crate::shown::ShownMeasurement;

/// Why the page is not served.
#[derive(Debug, Error)]
#[error("cannot listen on {addr}{}", held(holder.as_ref()))]
struct ListenError {
    addr: SocketAddr,
    /// Who has the port, where that is the reason and can be seen.
    holder: Option<Holder>,
    source: io::Error,
}

impl ListenError {
    fn of(error: BindError) -> ListenError {
        let BindError { addr, source } = error;
        let taken = source.kind() == io::ErrorKind::AddrInUse;
        ListenError { addr, holder: taken.then(|| holder_of_port(addr)).flatten(), source }
    }
}

fn held(holder: Option<&Holder>) -> String {
    holder.map_or_else(String::new, |holder| {
        format!(": it is in use by {holder}; end that, or set another [publish] listen (--listen of demo)")
    })
}

/// The page of a station, being served.
pub(super) struct Page {
    url: String,
    shutdown: oneshot::Sender<()>,
    task: JoinHandle<()>,
}

impl Page {
    /// Serves the page of a station and prints its address: with the token, unless its operator chose it and so knows it. What is
    /// printed may end in a log.
    pub(super) async fn serve(
        station: impl LiveStation,
        listen: SocketAddr,
        allowed_hosts: Vec<String>,
        chosen: Option<Token>,
    ) -> Result<Page, Failure> {
        let is_known = chosen.is_some();
        let token = chosen.map_or_else(Token::random, Ok)?;
        let server = Server::bind(listen, token, station).await.map_err(ListenError::of)?;
        Ok(Page::of(server.with_allowed_hosts(allowed_hosts), is_known))
    }

    /// Serves; the token is printed unless its operator knows it.
    fn of(server: Server, is_known: bool) -> Page {
        let server = server.with_text(METRICS);
        let url = server.url();
        let address = if is_known { url.clone() } else { server.url_with_token() };
        say(&format!("page: {address}"));
        let (shutdown, stop) = oneshot::channel::<()>();
        let task = tokio::spawn(server.serve(async {
            // A dropped sender stops the server too.
            let _ = stop.await;
        }));
        Page { url, shutdown, task }
    }

    /// Its address, without the token.
    pub(super) fn url(&self) -> &str {
        &self.url
    }

    /// Stops serving. Open answers end first, if they do so soon: a browser may never read its own.
    pub(super) async fn close(mut self) -> Result<(), Failure> {
        // The server may have ended by itself; then there is nothing to stop.
        let _ = self.shutdown.send(());
        if let Ok(ended) = timeout(ANSWERS, &mut self.task).await {
            return Ok(ended?);
        }
        self.task.abort();
        Ok(())
    }
}

/// Binds an address before long work, so that one that is taken is told now, and nobody takes it meanwhile. Browsers that come wait.
pub(super) fn bound(listen: SocketAddr) -> Result<TcpListener, Failure> {
    TcpListener::bind(listen)
        .map_err(|source| ListenError::of(BindError { addr: listen, source }).into())
}

/// Shows a finished measurement on the page until a signal. On this machine the page is read-only, as nothing can be started; others
/// need the token to read.
pub(super) fn show(shown: ShownMeasurement, listener: TcpListener) -> Result<(), Failure> {
    block_on(async {
        let is_here = listener.local_addr()?.ip().is_loopback();
        let page = Page::of(Server::of_bound(listener, Token::random()?, shown)?, is_here);
        say("the page stays; Ctrl-C ends");
        interrupted().await?;
        page.close().await?;
        Ok(Exit::Done)
    })
    .map(|_| ())
}

/// Runs a station to its end, on a runtime of its own. What then still works in the background is left to itself.
pub(super) fn block_on(
    station: impl Future<Output = Result<Exit, Failure>>,
) -> Result<Exit, Failure> {
    let runtime = tokio::runtime::Runtime::new()?;
    end_in_any_case()?;
    let exit = runtime.block_on(station);
    runtime.shutdown_timeout(BACKGROUND);
    exit
}

/// Ends the process some time after a signal, where the station could not: a log that nobody reads may hold up each of its threads.
/// So the wait has a thread and a runtime of its own. What reached the disk is in the recording.
fn end_in_any_case() -> io::Result<()> {
    let runtime = tokio::runtime::Builder::new_current_thread().enable_all().build()?;
    std::thread::Builder::new().name("signals".to_owned()).spawn(move || {
        runtime.block_on(async {
            if interrupted().await.is_ok() {
                sleep(IN_ANY_CASE).await;
                // On a thread: stderr may be what holds everything up.
                std::thread::spawn(|| {
                    say("ended before its work was done: files of results may be missing; a replay of the recording makes them");
                });
                sleep(LAST_WORD).await;
                std::process::exit(1);
            }
        });
    })?;
    Ok(())
}

/// Waits for SIGINT or SIGTERM.
pub(super) async fn interrupted() -> io::Result<()> {
    let mut terminate = signal(SignalKind::terminate())?;
    tokio::select! {
        result = tokio::signal::ctrl_c() => result,
        _ = terminate.recv() => Ok(()),
    }
}

/// Ends a running session in good order, so that its recording says why it ended; `None` if none ran.
///
/// # Errors
///
/// Where its figures are not there in time. Its recording is, and the words say how to make them of it.
pub(super) async fn stop_session(station: &mut Station) -> Result<Option<Closed>, Failure> {
    let handle = station.handle();
    let ended = timeout(FIGURES, async {
        match handle.session(Command::Stop).await {
            Ok(()) => station.closed().await.map(Some),
            Err(StationError::NotRunning) => Ok(None),
            Err(error) => Err(error),
        }
    });
    if let Ok(ended) = ended.await {
        return Ok(ended?);
    }
    let words = match (timeout(RECORDING, handle.abandon()).await, handle.recording()) {
        (Ok(Some(folder)), _) => {
            format!("the recording is complete: asphera replay {}", folder.display())
        }
        (_, Some(folder)) => format!(
            "what reached the disk is in the recording: asphera replay {}",
            folder.display()
        ),
        (_, None) => "there is no recording".to_owned(),
    };
    Err(format!("ended without the figures, which were not there within {FIGURES:?}; {words}")
        .into())
}

/// For Prometheus.
const METRICS: TextRoute = TextRoute {
    path: "/metrics",
    content_type: asphera_metrics::CONTENT_TYPE,
    text: asphera_metrics::text,
};

// Together below the 5 s in which a signal ends a station.
/// How long the figures of a session may take that a signal ends.
const FIGURES: Duration = Duration::from_millis(3200);
/// How long its recording may take that gets no figures.
const RECORDING: Duration = Duration::from_millis(500);
/// How long open answers may take.
const ANSWERS: Duration = Duration::from_millis(300);
/// How long threads may take that a signal found at work: at the disk, at a port, or waiting for a command.
const BACKGROUND: Duration = Duration::from_millis(300);
/// When a station ends that could not do so by itself.
const IN_ANY_CASE: Duration = Duration::from_millis(4700);
/// How long its last word may take.
const LAST_WORD: Duration = Duration::from_millis(100);

#[cfg(test)]
mod tests {
    use std::error::Error as _;

    use super::*;

    #[test]
    fn a_taken_port_is_named_with_who_has_it_and_what_to_do() {
        let listener = bound(([127, 0, 0, 1], 0).into()).unwrap();
        let addr = listener.local_addr().unwrap();
        // What was bound stays so while the work goes on.
        assert!(bound(addr).unwrap_err().to_string().contains("it is in use by"));
        let source = TcpListener::bind(addr).unwrap_err();
        let error = ListenError::of(BindError { addr, source });
        let words = error.to_string();
        assert!(words.starts_with(&format!("cannot listen on {addr}: it is in use by")), "{words}");
        assert!(words.ends_with("set another [publish] listen (--listen of demo)"), "{words}");
        assert_eq!(error.holder.as_ref().unwrap().process, std::process::id());
        assert_eq!(error.source().unwrap().to_string(), error.source.to_string());
    }
}
