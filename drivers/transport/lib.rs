//! Links: serial ports, TCP, UDP, SocketCAN, logs of CAN frames, files and pipes, opened, kept open, and named.
//!
//! A link knows how bytes come and go and nothing of what they mean: no device is named here. It is
//! one task that opens its [`Endpoint`], hands on what it receives as [`LinkEvent`]s, sends what it is
//! told, and opens again with jittered backoff when the other end goes away.
//!
//! Every connection has an epoch. What is sent names the epoch it was meant for, so that nothing meant
//! for one connection reaches the next; what is received stands between the `Opened` and the `Closed`
//! of its own connection.
//!
//! Recording is not done here: it happens where links are joined, because a recording must hold one
//! order over all links.

#![forbid(unsafe_code)]

mod backoff;
mod canlog;
mod certificates;
mod controller;
mod datagrams;
mod endpoint;
mod files;
mod holders;
mod link;
mod ports;
mod serial;
mod socketcan;
mod stream;
mod tls;

pub use backoff::{Backoff, BackoffError};
pub use endpoint::{Endpoint, FileSettings, FlowControl, Parity, SerialSettings};
pub use holders::{Holder, holder_of_file, holder_of_port};
pub use link::{Link, LinkCommand, LinkEvent, LinkRemote, LinkSettings, What};
pub use ports::{CanInterface, SerialPort, can_interfaces, serial_ports};
pub use stream::OpenError;
pub use tls::{ClientCertificate, TlsError, TlsSettings};
