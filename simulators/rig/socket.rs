//! The thermometer's TCP port, with a plug.

use std::io;
use std::net::SocketAddr;
use std::time::Duration;

use asphera_modbus::Transport;
use asphera_sim_modbus::{Device, serve};
use tokio::net::TcpListener;
use tokio::sync::watch;
use tokio::task::JoinSet;
use tokio::time::{Instant, sleep};

/// The bench's hand on a TCP port of 127.0.0.1.
#[derive(Debug)]
pub(crate) struct Socket {
    address: SocketAddr,
    /// Outages that overlap: the plug is in at 0.
    outages: watch::Sender<u32>,
}

impl Socket {
    /// Takes a free port, and gives the future that serves the device on it.
    pub(crate) async fn listen(
        device: Device,
    ) -> io::Result<(Socket, impl Future<Output = ()> + Send + 'static)> {
        let listener = TcpListener::bind(("127.0.0.1", 0)).await?;
        let address = listener.local_addr()?;
        let outages = watch::Sender::new(0);
        let watched = outages.subscribe();
        Ok((Socket { address, outages }, run(listener, address, device, watched)))
    }

    /// Where hosts connect.
    pub(crate) fn address(&self) -> SocketAddr {
        self.address
    }

    /// Closes every connection and refuses new ones.
    pub(crate) fn unplug(&self) {
        self.outages.send_modify(|outages| *outages += 1);
    }

    /// Takes connections again, if every outage is over.
    pub(crate) fn plug(&self) {
        self.outages.send_modify(|outages| *outages = outages.saturating_sub(1));
    }
}

/// Serves until the [`Socket`] is dropped.
async fn run(
    first: TcpListener,
    address: SocketAddr,
    device: Device,
    mut outages: watch::Receiver<u32>,
) {
    let start = Instant::now();
    let mut listener = Some(first);
    loop {
        if let Some(listener) = listener.take() {
            let mut connections = JoinSet::new();
            tokio::select! {
                () = accept(&listener, &device, start, &mut connections) => {}
                out = outages.wait_for(|&outages| outages > 0) => if out.is_err() { return },
            }
            // Both are dropped here: the connections end with the listener.
        }
        if outages.wait_for(|&outages| outages == 0).await.is_err() {
            return;
        }
        match TcpListener::bind(address).await {
            Ok(bound) => listener = Some(bound),
            Err(error) => {
                tracing::warn!(%address, %error, "the thermometer's port is not free");
                sleep(AGAIN).await;
            }
        }
    }
}

/// Takes connections until the listener fails.
async fn accept(
    listener: &TcpListener,
    device: &Device,
    start: Instant,
    connections: &mut JoinSet<io::Result<()>>,
) {
    loop {
        tokio::select! {
            accepted = listener.accept() => match accepted {
                Ok((stream, _)) => {
                    connections.spawn(serve(stream, device.clone(), Transport::Tcp, start));
                }
                Err(error) => {
                    tracing::warn!(%error, "the thermometer takes no connections");
                    return;
                }
            },
            // A client that goes away in the middle of an answer is no trouble of the device.
            Some(_) = connections.join_next() => {}
        }
    }
}

/// Between two attempts to have the port again.
const AGAIN: Duration = Duration::from_millis(50);
