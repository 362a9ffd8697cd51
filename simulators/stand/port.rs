//! Ports of the devices.

use tokio::net::{TcpListener, TcpStream};

/// The next host; `None`, said in the log, where the port takes none any more. Small frames go out at once.
pub(crate) async fn next_host(port: &TcpListener) -> Option<TcpStream> {
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
