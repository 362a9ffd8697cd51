//! Where a simulated device can be reached.

use std::net::SocketAddr;
use std::path::{Path, PathBuf};

use tokio::net::TcpListener;
use tokio_serial::{SerialPort, SerialStream};

use crate::{Ended, Error, Simulator};

/// A pseudo-terminal with the simulator on one end.
#[derive(Debug)]
pub struct Pty {
    simulator: Simulator,
    path: PathBuf,
    master: SerialStream,
    /// Held open so that the simulator meets no end of file between two hosts.
    _slave: SerialStream,
}

impl Pty {
    /// The path a host opens, `/dev/pts/…`.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Serves until [`crate::Fault::Close`]. A host that closes the port is not noticed, as on a
    /// real serial line; the settings stay until they are changed.
    pub async fn run(self) -> Result<Ended, Error> {
        self.simulator.serve(self.master).await
    }
}

/// Makes a pseudo-terminal in raw mode: no echo, no line editing, no translation of CR or LF.
///
/// Needs a running tokio reactor.
pub fn pty(simulator: Simulator) -> Result<Pty, Error> {
    // The serial library makes the pair raw (`cfmakeraw`) and takes no lock on it, so that a host
    // may have the port for itself.
    let (master, slave) = SerialStream::pair().map_err(Error::Pty)?;
    let path = slave.name().ok_or(Error::PtyName)?.into();
    Ok(Pty { simulator, path, master, _slave: slave })
}

/// Listens on `address` (port 0: any), gives the address in use and a future that serves one host
/// after the other and ends only with an error of the listener.
///
/// A connection that fails is over like one that is closed.
pub async fn tcp(
    simulator: Simulator,
    address: SocketAddr,
) -> Result<(SocketAddr, impl Future<Output = Error> + Send), Error> {
    let failed = |source| Error::Listen { address, source };
    let listener = TcpListener::bind(address).await.map_err(failed)?;
    let bound = listener.local_addr().map_err(failed)?;
    let serving = async move {
        loop {
            match listener.accept().await {
                Ok((stream, _)) => {
                    // Without it, single telegrams would wait for the acknowledgement of the last.
                    let served = match stream.set_nodelay(true) {
                        Ok(()) => simulator.serve(stream).await,
                        Err(error) => Err(Error::Link(error)),
                    };
                    drop(served);
                }
                Err(source) => return Error::Listen { address: bound, source },
            }
        }
    };
    Ok((bound, serving))
}
