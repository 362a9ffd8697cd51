//! Datagrams on their way.

use std::io;
use std::net::SocketAddr;
use std::time::Duration;

use tokio::net::UdpSocket;
use tokio::time::{Instant, sleep_until};

use crate::Departure;

/// Sends datagrams to a host, each at its time from now on. Late ones are sent at once.
///
/// # Errors
///
/// The socket's. That nobody listens is none: a scanner does not notice it.
pub async fn send(departures: &[Departure], host: SocketAddr) -> io::Result<()> {
    let socket = UdpSocket::bind(if host.is_ipv4() { "0.0.0.0:0" } else { "[::]:0" }).await?;
    let start = Instant::now();
    for Departure { at_ns, datagram } in departures {
        let due = start + Duration::from_nanos(*at_ns);
        if due > Instant::now() {
            sleep_until(due).await;
        }
        match socket.send_to(datagram, host).await {
            Err(error) if error.kind() == io::ErrorKind::ConnectionRefused => {}
            sent => drop(sent?),
        }
    }
    Ok(())
}
