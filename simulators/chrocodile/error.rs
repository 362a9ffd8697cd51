//! What can go wrong in a simulator.

use std::io;
use std::net::SocketAddr;

use thiserror::Error;

/// What can go wrong in a simulator.
#[derive(Debug, Error)]
pub enum Error {
    /// The stream failed.
    #[error("the link of the simulated CHRocodile failed")]
    Link(#[source] io::Error),
    /// No pseudo-terminal could be made.
    #[error("no pseudo-terminal")]
    Pty(#[source] tokio_serial::Error),
    /// The pseudo-terminal has no path.
    #[error("the pseudo-terminal has no name")]
    PtyName,
    /// The address cannot be listened on.
    #[error("cannot listen on {address}")]
    Listen {
        /// The address asked for.
        address: SocketAddr,
        /// Why.
        #[source]
        source: io::Error,
    },
    /// The simulator runs no more.
    #[error("the simulated CHRocodile has stopped")]
    Stopped,
}
