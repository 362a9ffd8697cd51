//! A station with its page, until a signal: what `run` and `demo` share.

use std::net::SocketAddr;
use std::sync::Arc;
use std::time::Duration;

use asphera_link::Command;
use tokio::signal::unix::{SignalKind, signal};
use tokio::sync::oneshot;
use tokio::task::JoinHandle;
use tokio::time::timeout;

use super::output::{Failure, say};
use crate::live::{Finished, Handle, Station, StationError};
use crate::publish::{Server, Token};

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
        station: Handle,
        listen: SocketAddr,
        allowed_hosts: Vec<String>,
        chosen: Option<Token>,
    ) -> Result<Page, Failure> {
        let is_known = chosen.is_some();
        let token = chosen.map_or_else(Token::random, Ok)?;
        let server = Server::bind(listen, token, station).await?.with_allowed_hosts(allowed_hosts);
        let url = server.url();
        let address = if is_known { url.clone() } else { server.url_with_token() };
        say(&format!("page: {address}"));
        let (shutdown, stop) = oneshot::channel::<()>();
        let task = tokio::spawn(server.serve(async {
            // A dropped sender stops the server too.
            let _ = stop.await;
        }));
        Ok(Page { url, shutdown, task })
    }

    /// Its address, without the token.
    pub(super) fn url(&self) -> &str {
        &self.url
    }

    /// Stops serving; open answers end first.
    pub(super) async fn close(self) -> Result<(), Failure> {
        // The server may have ended by itself; then there is nothing to stop.
        let _ = self.shutdown.send(());
        Ok(self.task.await?)
    }
}

/// Waits for SIGINT or SIGTERM.
pub(super) async fn interrupted() -> std::io::Result<()> {
    let mut terminate = signal(SignalKind::terminate())?;
    tokio::select! {
        result = tokio::signal::ctrl_c() => result,
        _ = terminate.recv() => Ok(()),
    }
}

/// Ends a running session in good order, so that its recording says why it ended; `None` if none ran.
pub(super) async fn stop_session(station: &mut Station) -> Result<Option<Arc<Finished>>, Failure> {
    match timeout(STOP, station.handle().session(Command::Stop)).await {
        Ok(Ok(())) => {}
        Ok(Err(StationError::NotRunning)) => return Ok(None),
        Ok(Err(error)) => return Err(error.into()),
        Err(_) => return Err(format!("the station did not stop within {STOP:?}").into()),
    }
    let finished = timeout(STOP, station.finished())
        .await
        .map_err(|_| format!("the figures were not there within {STOP:?}"))?;
    Ok(Some(finished?))
}

/// How long the end of a session may take: the disk, the links and the figures.
const STOP: Duration = Duration::from_secs(30);
