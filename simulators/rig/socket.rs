//! TCP ports of devices, with a plug.

use std::io;
use std::net::SocketAddr;
use std::time::Duration;

use asphera_modbus::Transport;
use asphera_sim_chrocodile as chrocodile;
use asphera_sim_modbus as modbus;
use asphera_stand::{next_host, serve_hosts};
use tokio::net::TcpListener;
use tokio::sync::watch;
use tokio::time::{Instant, sleep};

/// The bench's hand on a TCP port of 127.0.0.1.
#[derive(Debug)]
pub(crate) struct Socket {
    address: SocketAddr,
    /// Outages that overlap: the plug is in at 0.
    outages: watch::Sender<u32>,
}

/// A device behind a TCP port. What is dropped of it, connections among it, ends at once.
pub(crate) trait Device: Send + 'static {
    /// Takes connections until the listener fails.
    fn accept(&mut self, listener: &TcpListener) -> impl Future<Output = ()> + Send;

    /// Runs while the plug is out, and never ends.
    fn unplugged(&self) -> impl Future<Output = ()> + Send;
}

impl Socket {
    /// Takes a free port, and gives the future that serves the device on it.
    pub(crate) async fn listen(
        device: impl Device,
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
    mut device: impl Device,
    mut outages: watch::Receiver<u32>,
) {
    let mut listener = Some(first);
    loop {
        if let Some(listener) = listener.take() {
            tokio::select! {
                () = device.accept(&listener) => {}
                out = outages.wait_for(|&outages| outages > 0) => if out.is_err() { return },
            }
            // Dropped here, as the connections are.
        }
        tokio::select! {
            plugged = outages.wait_for(|&outages| outages == 0) => if plugged.is_err() { return },
            () = device.unplugged() => {}
        }
        match TcpListener::bind(address).await {
            Ok(bound) => listener = Some(bound),
            Err(error) => {
                tracing::warn!(%address, %error, "the port of a device is not free");
                sleep(AGAIN).await;
            }
        }
    }
}

/// The thermometer: any number of hosts at once.
pub(crate) struct Thermometer {
    pub(crate) device: modbus::Device,
    pub(crate) start: Instant,
}

impl Device for Thermometer {
    async fn accept(&mut self, listener: &TcpListener) {
        let answer =
            |stream| modbus::serve(stream, self.device.clone(), Transport::Tcp, self.start);
        serve_hosts(listener, answer).await;
    }

    async fn unplugged(&self) {
        std::future::pending::<()>().await;
    }
}

/// The probe on its packet protocol: one host after the other. Without one its exposures are lost.
pub(crate) struct Probe(pub(crate) chrocodile::Simulator);

impl Device for Probe {
    async fn accept(&mut self, listener: &TcpListener) {
        loop {
            let host = tokio::select! {
                host = next_host(listener) => host,
                () = self.0.lose_exposures() => continue,
            };
            let Some(stream) = host else { return };
            let served = self.0.serve(stream).await;
            tracing::debug!(?served, "a connection of the probe has ended");
        }
    }

    async fn unplugged(&self) {
        self.0.lose_exposures().await;
    }
}

/// Between two attempts to have the port again.
const AGAIN: Duration = Duration::from_millis(50);
