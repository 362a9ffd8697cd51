//! Where the adapter can be reached: TCP, or a pseudo terminal.

use std::io;

use tokio::net::TcpListener;
use tokio_serial::{SerialPort, SerialStream};

use crate::Simulator;

/// Serves hosts on a TCP listener, one after the other, until the listener fails. A host that breaks
/// off makes room for the next.
pub async fn serve_tcp(simulator: &Simulator, listener: &TcpListener) -> io::Result<()> {
    loop {
        let (stream, _) = listener.accept().await?;
        stream.set_nodelay(true)?;
        match simulator.serve(stream).await {
            Err(error) if error.kind() == io::ErrorKind::ConnectionReset => {}
            Err(error) if error.kind() == io::ErrorKind::BrokenPipe => {}
            other => other?,
        }
    }
}

/// A pseudo terminal: the host opens [`Pty::path`] as its serial port, without parity.
pub struct Pty {
    adapter: SerialStream,
    /// Kept open: without it a read of the adapter fails while no host has the port.
    host: SerialStream,
}

impl Pty {
    /// Makes a pseudo terminal. Must be called within a tokio runtime.
    pub fn open() -> io::Result<Pty> {
        let (adapter, host) = SerialStream::pair().map_err(io::Error::from)?;
        Ok(Pty { adapter, host })
    }

    /// Path of the port for the host.
    pub fn path(&self) -> Option<String> {
        self.host.name()
    }

    /// Serves hosts that open the port, until [`Simulator::close_connection`].
    pub async fn serve(&mut self, simulator: &Simulator) -> io::Result<()> {
        simulator.serve(&mut self.adapter).await
    }
}
