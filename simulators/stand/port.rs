//! TCP ports of simulated devices.

use std::borrow::Borrow;

use tokio::net::{TcpListener, TcpStream};
use tokio::task::JoinSet;

/// The next host; `None`, with a line in the log, where the port takes none any more. Small frames go out at once.
pub async fn next_host(port: &TcpListener) -> Option<TcpStream> {
    match port.accept().await {
        Ok((stream, _)) => {
            drop(stream.set_nodelay(true));
            Some(stream)
        }
        Err(error) => {
            tracing::warn!(%error, "a simulated device takes no connections");
            None
        }
    }
}

/// Answers any number of hosts at once, each by a task of its own, until the port takes none any more. Dropped, it ends their
/// connections.
pub async fn serve_hosts<S, F>(port: impl Borrow<TcpListener>, answer: S)
where
    S: Fn(TcpStream) -> F,
    F: Future<Output: Send> + Send + 'static,
{
    let mut connections = JoinSet::new();
    loop {
        tokio::select! {
            host = next_host(port.borrow()) => {
                let Some(stream) = host else { return };
                let answered = answer(stream);
                connections.spawn(async move { drop(answered.await) });
            }
            // A host that goes away in the middle of an answer is no trouble of the device.
            Some(_) = connections.join_next() => {}
        }
    }
}
