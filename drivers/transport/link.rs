//! One link: a task that keeps an endpoint open.

use std::io;
use std::time::Duration;

use asphera_link::CanFrame;
use tokio::io::{AsyncReadExt as _, AsyncWrite, AsyncWriteExt as _};
use tokio::sync::mpsc;
use tokio::task::JoinHandle;
use tokio::time::{Instant, sleep, sleep_until, timeout};
use tracing::{debug, trace};

use crate::canlog::CanLog;
use crate::controller::{ControllerClock, Taken};
use crate::datagrams::Datagrams;
use crate::files::Bookmark;
use crate::socketcan::{CanPort, Received};
use crate::stream::{Bytes, OpenError, Port, open};
use crate::{Backoff, Endpoint};

/// How a link behaves.
#[derive(Clone, Debug)]
pub struct LinkSettings {
    /// Which link it is among the station's; stands in every event.
    pub index: usize,
    /// Where it leads.
    pub endpoint: Endpoint,
    /// How long it waits before it opens again.
    pub backoff: Backoff,
}

/// What a link has to tell.
#[derive(Debug)]
pub struct LinkEvent {
    /// Which link.
    pub link: usize,
    /// When: for bytes, when they were read, however long the event then waited to be handled; for CAN frames of the kernel, when
    /// it took them.
    pub at: Instant,
    /// Event.
    pub what: What,
}

/// What happened on a link.
#[derive(Debug, PartialEq, Eq)]
pub enum What {
    /// The endpoint is open. Nothing says yet that a device is there.
    Opened {
        /// The connection's epoch: 1, 2, 3 …
        epoch: u64,
    },
    /// Bytes arrived; for SocketCAN the whole record of a frame, of two connections an
    /// [`asphera_link::Connection::chunk`], of a log a line. Never empty.
    Received(Vec<u8>),
    /// The CAN controller reports trouble on the bus. The connection stays.
    BusError(String),
    /// The connection ended, in words for a person. It will be opened again.
    Closed(String),
    /// The endpoint could not be opened, in words for a person. It will be tried again.
    OpenFailed(String),
}

/// What a link can be told.
#[derive(Debug)]
pub enum LinkCommand {
    /// Send these bytes (for SocketCAN whole records) on connection `epoch`, and on no other.
    Send {
        /// The connection they are meant for.
        epoch: u64,
        /// The bytes.
        bytes: Vec<u8>,
    },
    /// A valid frame arrived: the connection is good, and the backoff starts over.
    Confirm,
    /// Close connection `epoch` and open a new one.
    Reopen {
        /// The connection to close.
        epoch: u64,
    },
}

/// A running link. It ends when the handle is dropped.
#[derive(Debug)]
pub struct Link {
    commands: mpsc::UnboundedSender<LinkCommand>,
    task: JoinHandle<()>,
}

impl Link {
    /// Starts the link's task on the current tokio runtime.
    ///
    /// Events go to `events`; while that is full the link reads nothing, and the kernel's buffer and
    /// the protocol's own flow control hold the other end back. CAN has none: there the kernel keeps
    /// about 550 frames (`net.core.rmem_max` of 212992, the usual value) and loses those after them.
    pub fn spawn(settings: LinkSettings, events: mpsc::Sender<LinkEvent>) -> Link {
        let (commands, receiver) = mpsc::unbounded_channel();
        let bookmark = Bookmark::default();
        let worker = Worker { settings, events, commands: receiver, epoch: 0, bookmark };
        Link { commands, task: tokio::spawn(worker.run()) }
    }

    /// Ends the link and waits until its port is closed.
    pub async fn close(mut self) {
        self.task.abort();
        // It ends because it was told to; there is nothing to learn from how.
        let _ = (&mut self.task).await;
    }

    /// Sends the link a command. A link that has ended takes no notice.
    pub fn command(&self, command: LinkCommand) {
        // The task ends only when the station is going down; what is said then is said to nobody.
        let _ = self.commands.send(command);
    }

    /// Hand for others that send it commands.
    pub fn remote(&self) -> LinkRemote {
        LinkRemote { commands: self.commands.clone() }
    }
}

/// Hand of a link, to send it commands from another task. It does not keep the link alive.
#[derive(Clone, Debug)]
pub struct LinkRemote {
    commands: mpsc::UnboundedSender<LinkCommand>,
}

impl LinkRemote {
    /// Sends the link a command. A link that has ended takes no notice.
    pub fn command(&self, command: LinkCommand) {
        let _ = self.commands.send(command);
    }
}

impl Drop for Link {
    fn drop(&mut self) {
        self.task.abort();
    }
}

struct Worker {
    settings: LinkSettings,
    events: mpsc::Sender<LinkEvent>,
    commands: mpsc::UnboundedReceiver<LinkCommand>,
    epoch: u64,
    bookmark: Bookmark,
}

/// Why a connection is over.
enum End {
    /// Open it again; the words say why it was closed.
    Closed(String),
    /// Nothing more will ever come; the words say why.
    Over(String),
    /// The station is going down.
    Shutdown,
}

impl Worker {
    async fn run(mut self) {
        loop {
            match open(&self.settings.endpoint, &mut self.bookmark).await {
                Ok(port) => {
                    self.epoch += 1;
                    debug!(endpoint = %self.settings.endpoint, epoch = self.epoch, "link open");
                    if !self.tell(What::Opened { epoch: self.epoch }).await {
                        return;
                    }
                    let end = match port {
                        Port::Stream(stream) => self.serve_stream(stream).await,
                        Port::Pair(streams) => self.serve_pair(streams).await,
                        Port::Datagrams(port) => self.serve_datagrams(port).await,
                        Port::Can(port) => self.serve_can(port).await,
                        Port::CanLog(log) => self.serve_log(log).await,
                        Port::File(settings, port) => self.serve_file(&settings, port).await,
                    };
                    match end {
                        End::Closed(reason) => {
                            debug!(endpoint = %self.settings.endpoint, %reason, "link closed");
                            if !self.tell(What::Closed(reason)).await {
                                return;
                            }
                        }
                        End::Over(reason) => {
                            if self.tell(What::Closed(reason)).await {
                                // What is said to a link that is over is said to nobody.
                                while self.commands.recv().await.is_some() {}
                            }
                            return;
                        }
                        End::Shutdown => return,
                    }
                }
                Err(error) => {
                    if !self.tell(What::OpenFailed(with_cause(&error))).await {
                        return;
                    }
                }
            }
            sleep(self.settings.backoff.next_wait()).await;
        }
    }

    /// Whether anybody listens still.
    async fn tell(&mut self, what: What) -> bool {
        let event = LinkEvent { link: self.settings.index, at: Instant::now(), what };
        self.events.send(event).await.is_ok()
    }

    async fn serve_stream(&mut self, stream: Box<dyn Bytes>) -> End {
        let (mut reader, mut writer) = tokio::io::split(stream);
        let mut buffer = vec![0; READ_BYTES];
        loop {
            tokio::select! {
                read = reader.read(&mut buffer) => match read {
                    // A port that reads nothing without an error is gone: unplugged adapters do that for ever.
                    Ok(0) => return End::Closed("the other end closed the connection".to_owned()),
                    Ok(count) => {
                        let bytes = buffer[..count].to_vec();
                        trace!(link = self.settings.index, bytes = %Hex(&bytes), "received");
                        if let Some(end) = self.tell_and_write(What::Received(bytes), &mut writer).await {
                            return end;
                        }
                    }
                    Err(error) => return End::Closed(self.reading_failed(&error)),
                },
                command = self.commands.recv() => if let Some(end) = self.write(command, &mut writer).await {
                    return end;
                },
            }
        }
    }

    /// Words on an error of a stream. A server of TLS may refuse its client after the handshake.
    fn reading_failed(&self, error: &io::Error) -> String {
        let cure = match &self.settings.endpoint {
            Endpoint::Tls { .. } => crate::tls::cure(error, ""),
            _ => None,
        };
        match cure {
            Some(cure) => format!("reading failed: {cure}: {error}"),
            None => format!("reading failed: {error}"),
        }
    }

    /// Tells what was read. Commands go out meanwhile: a halt does not wait until someone takes what was read.
    async fn tell_and_write(
        &mut self,
        what: What,
        writer: &mut (impl AsyncWrite + Unpin),
    ) -> Option<End> {
        let event = LinkEvent { link: self.settings.index, at: Instant::now(), what };
        let events = self.events.clone();
        let mut telling = std::pin::pin!(events.send(event));
        loop {
            tokio::select! {
                biased;
                told = &mut telling => return told.is_err().then_some(End::Shutdown),
                command = self.commands.recv() => {
                    let end = self.write(command, writer).await;
                    if end.is_some() {
                        return end;
                    }
                }
            }
        }
    }

    /// Carries out a command on a stream. Why the connection is over, if it is.
    async fn write(
        &mut self,
        command: Option<LinkCommand>,
        writer: &mut (impl AsyncWrite + Unpin),
    ) -> Option<End> {
        match self.act(command) {
            Act::Send(bytes) => {
                trace!(link = self.settings.index, bytes = %Hex(&bytes), "sent");
                match timeout(WRITE_TIMEOUT, writer.write_all(&bytes)).await {
                    Ok(Ok(())) => None,
                    Ok(Err(error)) => Some(End::Closed(format!("writing failed: {error}"))),
                    Err(_) => Some(End::Closed(format!("writing stalled for {WRITE_TIMEOUT:?}"))),
                }
            }
            Act::Nothing => None,
            Act::End(end) => Some(end),
        }
    }

    async fn serve_datagrams(&mut self, port: Datagrams) -> End {
        let mut buffer = vec![0; LARGEST_DATAGRAM];
        loop {
            tokio::select! {
                received = port.receive(&mut buffer) => match received {
                    // A datagram without a byte says nothing.
                    Ok(0) => {}
                    Ok(count) => {
                        let bytes = buffer[..count].to_vec();
                        trace!(link = self.settings.index, bytes = %Hex(&bytes), "received");
                        if !self.tell(What::Received(bytes)).await {
                            return End::Shutdown;
                        }
                    }
                    Err(error) => return End::Closed(format!("receiving failed: {error}")),
                },
                command = self.commands.recv() => match self.act(command) {
                    Act::Send(bytes) => {
                        trace!(link = self.settings.index, bytes = %Hex(&bytes), "sent");
                        match timeout(WRITE_TIMEOUT, port.send(&bytes)).await {
                            Ok(Ok(())) => {}
                            Ok(Err(error)) => return End::Closed(format!("sending failed: {error}")),
                            Err(_) => return End::Closed(format!("sending stalled for {WRITE_TIMEOUT:?}")),
                        }
                    }
                    Act::Nothing => {}
                    Act::End(end) => return end,
                },
            }
        }
    }

    async fn serve_can(&mut self, port: CanPort) -> End {
        let opened = Instant::now();
        let mut controller = port.is_stamped().then(|| ControllerClock::new(opened));
        loop {
            tokio::select! {
                received = port.receive() => {
                    let (received, came) = match received {
                        Ok(received) => received,
                        Err(error) => return End::Closed(format!("reading failed: {error}")),
                    };
                    // No frame is from before its connection.
                    let now = Instant::now();
                    let by_kernel = now.checked_sub(came.age).unwrap_or(now).max(opened);
                    let taken = match (&received, &mut controller) {
                        (Received::Record(_), Some(clock)) => clock.at(came.controller_ns, by_kernel),
                        _ => Ok(Taken { at: by_kernel, has_jumped: false }),
                    };
                    let Ok(Taken { at, has_jumped }) = taken else {
                        return End::Closed(port.without_stamps());
                    };
                    let jumped = has_jumped.then(|| What::BusError(JUMPED.to_owned()));
                    let what = match received {
                        Received::Record(record) => What::Received(record),
                        Received::BusError(error) => What::BusError(error.to_string()),
                    };
                    for what in jumped.into_iter().chain([what]) {
                        let event = LinkEvent { link: self.settings.index, at, what };
                        if self.events.send(event).await.is_err() {
                            return End::Shutdown;
                        }
                    }
                }
                command = self.commands.recv() => match self.act(command) {
                    Act::Send(bytes) => if let Some(end) = send_records(&port, &bytes).await {
                        return end;
                    },
                    Act::Nothing => {}
                    Act::End(end) => return end,
                },
            }
        }
    }

    /// Plays a log. An event has the time that its line has in the log, however late the task was.
    async fn serve_log(&mut self, mut log: CanLog) -> End {
        loop {
            let (bytes, at) = match log.next().await {
                Ok(Some(line)) => line,
                Ok(None) => return End::Over(format!("the log {} ended", self.settings.endpoint)),
                Err(error) => return End::Closed(format!("reading the log failed: {error}")),
            };
            loop {
                tokio::select! {
                    biased;
                    command = self.commands.recv() => match self.act(command) {
                        // Nobody is there to take it.
                        Act::Send(_) | Act::Nothing => {}
                        Act::End(end) => return end,
                    },
                    () = sleep_until(at) => break,
                }
            }
            trace!(link = self.settings.index, bytes = %Hex(&bytes), "received");
            let event = LinkEvent { link: self.settings.index, at, what: What::Received(bytes) };
            if self.events.send(event).await.is_err() {
                return End::Shutdown;
            }
        }
    }

    fn act(&mut self, command: Option<LinkCommand>) -> Act {
        match command {
            None => Act::End(End::Shutdown),
            Some(LinkCommand::Send { epoch, bytes }) if epoch == self.epoch => Act::Send(bytes),
            Some(LinkCommand::Reopen { epoch }) if epoch == self.epoch => {
                Act::End(End::Closed("closed to start over".to_owned()))
            }
            Some(LinkCommand::Confirm) => {
                self.settings.backoff.reset();
                Act::Nothing
            }
            // Meant for a connection that is gone.
            Some(LinkCommand::Send { .. } | LinkCommand::Reopen { .. }) => Act::Nothing,
        }
    }
}

enum Act {
    Send(Vec<u8>),
    Nothing,
    End(End),
}

/// Sends the frames of records one after the other. Why the connection is over, if it is.
async fn send_records(port: &CanPort, mut bytes: &[u8]) -> Option<End> {
    while !bytes.is_empty() {
        let (record, after) = CanFrame::split_record(bytes);
        bytes = after;
        let frame = match CanFrame::from_record(record) {
            Ok(frame) => frame,
            Err(error) => return Some(End::Closed(format!("writing failed: {error}"))),
        };
        match timeout(WRITE_TIMEOUT, port.send(&frame)).await {
            Ok(Ok(())) => {}
            Ok(Err(error)) => return Some(End::Closed(format!("writing failed: {error}"))),
            Err(_) => return Some(End::Closed(format!("writing stalled for {WRITE_TIMEOUT:?}"))),
        }
    }
    None
}

/// The first bytes in hex, for the trace.
struct Hex<'a>(&'a [u8]);

impl std::fmt::Display for Hex<'_> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        for byte in self.0.iter().take(32) {
            write!(f, "{byte:02x} ")?;
        }
        if self.0.len() > 32 {
            write!(f, "… {} bytes", self.0.len())?;
        }
        Ok(())
    }
}

const READ_BYTES: usize = 16 * 1024;
/// No datagram of IPv4 or IPv6 is larger, but for jumbograms.
const LARGEST_DATAGRAM: usize = 65_535;
const WRITE_TIMEOUT: Duration = Duration::from_secs(2);
const JUMPED: &str = "the clock of the CAN controller jumped: check its power and cable";

/// An error and its cause in one line.
fn with_cause(error: &OpenError) -> String {
    use std::error::Error as _;
    match error.source() {
        Some(cause) => format!("{error}: {cause}"),
        None => error.to_string(),
    }
}

mod file;
mod pair;

#[cfg(test)]
mod file_tests;
#[cfg(test)]
mod tests;
#[cfg(test)]
mod tls_tests;
