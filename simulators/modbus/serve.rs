//! A session on a real stream, in real time.

use std::fs::{File, OpenOptions};
use std::io;
use std::os::unix::fs::OpenOptionsExt as _;
use std::path::{Path, PathBuf};

use asphera_link::Nanos;
use asphera_modbus::Transport;
use tokio::io::{AsyncRead, AsyncReadExt as _, AsyncWrite, AsyncWriteExt as _};
use tokio::net::TcpListener;
use tokio::time::{Instant, sleep_until};
use tokio_serial::{SerialPort as _, SerialStream};

use crate::device::Device;
use crate::session::Session;

/// Serves one connection until either side closes it. `start` is the zero of the device's clock.
///
/// # Errors
///
/// Those of the stream.
pub async fn serve(
    mut stream: impl AsyncRead + AsyncWrite + Unpin,
    device: Device,
    transport: Transport,
    start: Instant,
) -> io::Result<()> {
    let mut session = Session::new(device, transport);
    let mut buffer = [0; 512];
    loop {
        let now = Nanos::ZERO + start.elapsed();
        while let Some(bytes) = session.poll_transmit(now) {
            stream.write_all(&bytes).await?;
        }
        if session.is_closed() {
            return Ok(());
        }
        let due = session.poll_timeout().map(|due| start + due.since(Nanos::ZERO));
        let until_due = async {
            match due {
                Some(due) => sleep_until(due).await,
                None => std::future::pending().await,
            }
        };
        tokio::select! {
            read = stream.read(&mut buffer) => match read? {
                0 => return Ok(()),
                len => session.receive(Nanos::ZERO + start.elapsed(), &buffer[..len]),
            },
            () = until_due => {}
        }
    }
}

/// Serves every connection of the listener by Modbus TCP, each in its own task, until the future is
/// dropped; the connections go on.
///
/// # Errors
///
/// When the listener cannot accept. A connection that fails ends alone.
pub async fn serve_tcp(listener: TcpListener, device: Device) -> io::Result<()> {
    let start = Instant::now();
    loop {
        let (stream, _) = listener.accept().await?;
        stream.set_nodelay(true)?;
        let device = device.clone();
        // A client that goes away in the middle of an answer is no trouble of the device.
        tokio::spawn(async move { serve(stream, device, Transport::Tcp, start).await.is_ok() });
    }
}

/// A serial line: a pair of pseudo-terminals, one end the device's, the other for a client to open.
///
/// Pseudo-terminals refuse parity: the client must ask for none.
pub struct Pty {
    device_end: SerialStream,
    path: PathBuf,
    /// Keeps the line up while no client has it open; without a lock, so that clients can have one.
    _client_end: File,
}

impl Pty {
    /// A new line.
    ///
    /// # Errors
    ///
    /// When the system has no pseudo-terminal left.
    pub fn open() -> io::Result<Pty> {
        let (device_end, mut client_end) = SerialStream::pair()?;
        let path = client_end.name().map(PathBuf::from).ok_or_else(|| {
            io::Error::new(io::ErrorKind::NotFound, "pseudo-terminal without name")
        })?;
        client_end.set_exclusive(false)?;
        let keeper =
            OpenOptions::new().read(true).write(true).custom_flags(O_NOCTTY).open(&path)?;
        Ok(Pty { device_end, path, _client_end: keeper })
    }

    /// The device file a client opens.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Serves the device on the line by Modbus RTU.
    ///
    /// # Errors
    ///
    /// Those of the pseudo-terminal.
    pub async fn serve(self, device: Device) -> io::Result<()> {
        serve(self.device_end, device, Transport::Rtu, Instant::now()).await
    }
}

/// `open(2)`: the terminal does not become the one that controls this process. Linux value.
const O_NOCTTY: i32 = 0o400;
