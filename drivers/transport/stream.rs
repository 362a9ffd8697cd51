//! Opening an endpoint.

use std::io;
use std::time::Duration;

use socket2::{SockRef, TcpKeepalive};
use thiserror::Error;
use tokio::io::{AsyncRead, AsyncWrite};
use tokio::net::TcpStream;
use tokio::time::timeout;

use crate::canlog::CanLog;
use crate::datagrams::Datagrams;
use crate::files::{Bookmark, FilePort};
use crate::socketcan::CanPort;
use crate::tls::{self, TlsError};
use crate::{Endpoint, FileSettings, Holder, Parity, serial};

/// Why an endpoint could not be opened.
#[derive(Debug, Error)]
pub enum OpenError {
    /// The serial port is not there, or not ours.
    #[error(
        "cannot open serial port {path}; `asphera ports` lists the ports by their stable names"
    )]
    Serial {
        /// The path tried.
        path: String,
        /// Error of the system.
        source: io::Error,
    },
    /// Another process has the port: what it reads would be missing here.
    #[error("serial port {path} is in use by {holder}: end that, or give this link another port")]
    Held {
        /// The path tried.
        path: String,
        /// Who has it.
        holder: Holder,
    },
    /// The port refuses this parity. Pseudo terminals do: they are 8N1 only.
    #[error(
        "serial port {path} refuses {parity:?} parity (a pseudo terminal takes none only): set parity = \"none\" or use a real port"
    )]
    Parity {
        /// The path tried.
        path: String,
        /// The parity asked for.
        parity: Parity,
    },
    /// No TCP connection.
    #[error("cannot connect to {address}")]
    Tcp {
        /// The address tried.
        address: String,
        /// Error of the system.
        source: io::Error,
    },
    /// No TLS connection.
    #[error(transparent)]
    Tls(#[from] TlsError),
    /// The port is not free, or the address is none of this host.
    #[error(
        "cannot receive datagrams at {address}; `ss -lunp` lists who has the port, `ip address` the addresses"
    )]
    Udp {
        /// The address tried.
        address: String,
        /// Error of the system.
        source: io::Error,
    },
    /// The device's address means nothing.
    #[error("cannot find the device {peer}")]
    Peer {
        /// Host and port of the device.
        peer: String,
        /// Error of the system.
        source: io::Error,
    },
    /// No CAN interface.
    #[error("cannot open CAN interface {interface}; `asphera ports` lists those there are")]
    SocketCan {
        /// The interface tried.
        interface: String,
        /// Error of the system.
        source: io::Error,
    },
    /// No log.
    #[error("cannot open the log {path}: set file to one that candump -l wrote")]
    CanLog {
        /// The path tried.
        path: String,
        /// Error of the system.
        source: io::Error,
    },
    /// No file or pipe that can be read.
    #[error("cannot read {path}; {cure}")]
    File {
        /// The path tried.
        path: String,
        /// Cure in words for a person.
        cure: &'static str,
        /// Error of the system.
        source: io::Error,
    },
    /// A device or a socket.
    #[error(
        "{path} is neither a file nor a pipe: name one of these; a serial port needs kind = \"serial\""
    )]
    NoFile {
        /// The path tried.
        path: String,
    },
}

/// Anything that carries bytes both ways.
pub(crate) trait Bytes: AsyncRead + AsyncWrite + Send + Unpin {}

impl<T: AsyncRead + AsyncWrite + Send + Unpin> Bytes for T {}

/// An open endpoint.
pub(crate) enum Port {
    /// A stream of bytes.
    Stream(Box<dyn Bytes>),
    /// Two streams of bytes that open and end together.
    Pair([Box<dyn Bytes>; 2]),
    /// Datagrams.
    Datagrams(Datagrams),
    /// A CAN socket.
    Can(CanPort),
    /// A log of CAN frames.
    CanLog(CanLog),
    /// A file or a pipe.
    File(FileSettings, FilePort),
}

/// Opens `endpoint`, within a few seconds. What the kernel still held from before is thrown away, but of pipes. `bookmark` is
/// the place where a file is read on.
pub(crate) async fn open(endpoint: &Endpoint, bookmark: &mut Bookmark) -> Result<Port, OpenError> {
    match endpoint {
        Endpoint::Serial(settings) => Ok(Port::Stream(Box::new(serial::open(settings)?))),
        Endpoint::Tcp { address } => Ok(Port::Stream(Box::new(connect(address).await?))),
        Endpoint::Tls { address, tls } => {
            let stream = connect(address).await?;
            Ok(Port::Stream(Box::new(tls::connect(stream, address, tls).await?)))
        }
        Endpoint::TcpPair { address, second_port } => {
            let first = connect(address).await?;
            let host = address.rsplit_once(':').map_or(address.as_str(), |(host, _)| host);
            let second = connect(&format!("{host}:{second_port}")).await?;
            Ok(Port::Pair([Box::new(first), Box::new(second)]))
        }
        Endpoint::Udp { listen, peer } => {
            Ok(Port::Datagrams(Datagrams::open(listen, peer.as_deref()).await?))
        }
        Endpoint::SocketCan { interface, timestamps } => {
            Ok(Port::Can(CanPort::open(interface, *timestamps)?))
        }
        Endpoint::CanLog { path, speed } => Ok(Port::CanLog(CanLog::open(path, *speed).await?)),
        Endpoint::File(settings) => {
            let port = FilePort::open(settings, bookmark).await?;
            Ok(Port::File(settings.clone(), port))
        }
    }
}

async fn connect(address: &str) -> Result<TcpStream, OpenError> {
    let tcp = |source| OpenError::Tcp { address: address.to_owned(), source };
    let stream = timeout(CONNECT_TIMEOUT, TcpStream::connect(address))
        .await
        .unwrap_or_else(|_| Err(io::ErrorKind::TimedOut.into()))
        .map_err(tcp)?;
    // Commands are short and wanted at once.
    stream.set_nodelay(true).map_err(tcp)?;
    keep_alive(&stream).map_err(tcp)?;
    Ok(stream)
}

/// A connection whose other end is gone without a word ends within [`LONGEST_SILENCE`], though nobody sends anything.
fn keep_alive(stream: &TcpStream) -> io::Result<()> {
    let probes =
        TcpKeepalive::new().with_time(PROBE_AFTER).with_interval(PROBE_PERIOD).with_retries(PROBES);
    let socket = SockRef::from(stream);
    socket.set_tcp_keepalive(&probes)?;
    // What was sent and never acknowledged ends it as well: probes do not go out then.
    socket.set_tcp_user_timeout(Some(LONGEST_SILENCE))
}

/// Silence after which the other end is asked whether it is there.
const PROBE_AFTER: Duration = Duration::from_secs(5);
const PROBE_PERIOD: Duration = Duration::from_secs(2);
const PROBES: u32 = 3;
const LONGEST_SILENCE: Duration = Duration::from_secs(11);
const CONNECT_TIMEOUT: Duration = Duration::from_secs(3);

#[cfg(test)]
mod tests {
    use tokio::net::TcpListener;

    use super::*;

    /// A peer that is gone without a word is found within 5 s + 3 × 2 s.
    #[tokio::test]
    async fn a_silent_peer_is_asked_whether_it_is_there() {
        let listener = TcpListener::bind("127.0.0.1:0").await.unwrap();
        let stream = connect(&listener.local_addr().unwrap().to_string()).await.unwrap();
        let socket = SockRef::from(&stream);
        assert!(socket.keepalive().unwrap());
        let after = socket.tcp_keepalive_time().unwrap();
        let period = socket.tcp_keepalive_interval().unwrap();
        assert_eq!(after + period * socket.tcp_keepalive_retries().unwrap(), LONGEST_SILENCE);
        assert_eq!(socket.tcp_user_timeout().unwrap(), Some(LONGEST_SILENCE));
    }
}
