//! A serial port of the bench: a pseudo-terminal under a stable name, with a plug.

use std::ffi::OsStr;
use std::io;
use std::os::fd::OwnedFd;
use std::os::unix::ffi::OsStrExt as _;
use std::path::{Path, PathBuf};
use std::pin::Pin;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::task::{Context, Poll, Waker, ready};
use std::time::Duration;

use rustix::event::{PollFd, PollFlags, Timespec, poll};
use rustix::io::ioctl_fionbio;
use rustix::pty::{OpenptFlags, grantpt, ioctl_tiocgptpeer, openpt, ptsname, unlockpt};
use rustix::termios::{OptionalActions, tcgetattr, tcsetattr};
use tokio::io::unix::AsyncFd;
use tokio::io::{AsyncRead, AsyncWrite, ReadBuf};
use tokio::time::{Instant, Sleep, sleep_until};

/// The bench's hand on a port. Clones are the same port.
#[derive(Clone, Debug)]
pub(crate) struct Port {
    shared: Arc<Shared>,
}

/// The simulator's end of a port: a stream that never ends and never fails.
///
/// Reading waits while nobody is there. What is written while nobody is there is lost, as on a
/// wire; a host that has the port open and does not read holds the writer back.
#[derive(Debug)]
pub(crate) struct Wire {
    shared: Arc<Shared>,
    /// When to look again whether a host is there.
    look: Pin<Box<Sleep>>,
}

#[derive(Debug)]
struct Shared {
    /// The stable name, a symbolic link.
    path: PathBuf,
    line: Mutex<Line>,
}

#[derive(Debug)]
struct Line {
    state: State,
    /// Outages that overlap: the plug is in at 0.
    outages: u32,
    reader: Option<Waker>,
    writer: Option<Waker>,
}

/// A pseudo-terminal cannot be waited on while no host has it open: it reports "hung up" all the
/// time, and goes on to after a host came. So it is looked at by a timer until a host is there, and
/// only then registered. After a host has left, a new one is made: the exclusive lock of a host
/// (TIOCEXCL) stays on a pseudo-terminal, and so do the bytes nobody read.
#[derive(Debug)]
enum State {
    /// The plug is out: there is no such device.
    Unplugged,
    /// No host has opened the port since it was made.
    Waiting(OwnedFd),
    /// A host has the port open.
    Connected(AsyncFd<OwnedFd>),
}

impl Port {
    /// Makes a port and its name. A symbolic link of that name is replaced, anything else is not.
    pub(crate) fn new(path: PathBuf) -> io::Result<Port> {
        if std::fs::symlink_metadata(&path).is_ok_and(|found| !found.is_symlink()) {
            return Err(io::ErrorKind::AlreadyExists.into());
        }
        let state = State::Waiting(open_under(&path)?);
        let line = Line { state, outages: 0, reader: None, writer: None };
        Ok(Port { shared: Arc::new(Shared { path, line: Mutex::new(line) }) })
    }

    /// The simulator's end. To be used by one simulator at a time.
    pub(crate) fn wire(&self) -> Wire {
        Wire { shared: self.shared.clone(), look: Box::pin(sleep_until(Instant::now())) }
    }

    /// The stable name a host opens.
    pub(crate) fn path(&self) -> &Path {
        &self.shared.path
    }

    /// Pulls the plug: the host's port hangs up and the name is gone.
    pub(crate) fn unplug(&self) {
        let mut line = self.shared.line();
        line.outages += 1;
        line.state = State::Unplugged;
        self.remove_name();
        line.wake();
    }

    /// Puts the plug back, if every outage is over: another device under the same name.
    pub(crate) fn plug(&self) {
        let mut line = self.shared.line();
        line.outages = line.outages.saturating_sub(1);
        if line.outages == 0 {
            line.state = self.shared.fresh();
            line.wake();
        }
    }

    /// Takes the port away for good.
    pub(crate) fn remove(&self) {
        self.shared.line().state = State::Unplugged;
        self.remove_name();
    }

    fn remove_name(&self) {
        if let Err(error) = std::fs::remove_file(&self.shared.path)
            && error.kind() != io::ErrorKind::NotFound
        {
            tracing::warn!(path = %self.shared.path.display(), %error, "the port's name stays");
        }
    }
}

impl Shared {
    /// A new device under the name; none if the system has no more.
    fn fresh(&self) -> State {
        match open_under(&self.path) {
            Ok(master) => State::Waiting(master),
            Err(error) => {
                tracing::error!(path = %self.path.display(), %error, "the port cannot come back");
                State::Unplugged
            }
        }
    }

    /// The line. Nothing panics while it is held, and each of its states is whole.
    fn line(&self) -> MutexGuard<'_, Line> {
        self.line.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl Line {
    fn wake(&mut self) {
        let wakers = [self.reader.take(), self.writer.take()];
        wakers.into_iter().flatten().for_each(Waker::wake);
    }

    /// Registers the pseudo-terminal a host has opened, or registers it anew: what the runtime
    /// remembers of a hang-up between two hosts would make it look ready for ever.
    fn register(&mut self) {
        let master = match std::mem::replace(&mut self.state, State::Unplugged) {
            State::Waiting(master) => master,
            State::Connected(registered) => registered.into_inner(),
            State::Unplugged => return,
        };
        #[expect(
            deprecated,
            reason = "its unsafe successor is for descriptors that may close early; an OwnedFd cannot"
        )]
        let registered = AsyncFd::new(master);
        match registered {
            Ok(registered) => self.state = State::Connected(registered),
            Err(error) => tracing::error!(%error, "a port cannot be watched and is gone"),
        }
    }
}

impl AsyncRead for Wire {
    fn poll_read(
        self: Pin<&mut Self>,
        cx: &mut Context<'_>,
        out: &mut ReadBuf<'_>,
    ) -> Poll<io::Result<()>> {
        let wire = self.get_mut();
        let mut line = wire.shared.line();
        line.reader = Some(cx.waker().clone());
        let mut blocked = false;
        loop {
            match &line.state {
                State::Unplugged => return Poll::Pending,
                State::Waiting(master) => match visit(master) {
                    Visit::Here => line.register(),
                    Visit::Gone => line.state = wire.shared.fresh(),
                    Visit::None => {
                        ready!(wire.look.as_mut().poll(cx));
                        wire.look.as_mut().reset(Instant::now() + LOOK);
                    }
                },
                State::Connected(master) => {
                    let mut guard = ready!(master.poll_read_ready(cx))?;
                    let read = guard.try_io(|master| {
                        Ok(rustix::io::read(master.get_ref(), out.initialize_unfilled())?)
                    });
                    match read {
                        Ok(Ok(len)) if len > 0 => {
                            out.advance(len);
                            return Poll::Ready(Ok(()));
                        }
                        // The host has closed the port.
                        Ok(_) => line.state = wire.shared.fresh(),
                        Err(_would_block) if blocked => line.register(),
                        Err(_would_block) => blocked = true,
                    }
                }
            }
        }
    }
}

impl AsyncWrite for Wire {
    fn poll_write(
        self: Pin<&mut Self>,
        cx: &mut Context<'_>,
        bytes: &[u8],
    ) -> Poll<io::Result<usize>> {
        let mut line = self.shared.line();
        let mut blocked = false;
        loop {
            // Nobody is there.
            let State::Connected(master) = &line.state else {
                return Poll::Ready(Ok(bytes.len()));
            };
            let Poll::Ready(guard) = master.poll_write_ready(cx) else {
                line.writer = Some(cx.waker().clone());
                return Poll::Pending;
            };
            let mut guard = guard?;
            match guard.try_io(|master| Ok(rustix::io::write(master.get_ref(), bytes)?)) {
                Ok(Ok(len)) => return Poll::Ready(Ok(len)),
                // The host has just left.
                Ok(Err(_)) => return Poll::Ready(Ok(bytes.len())),
                Err(_would_block) if blocked => {
                    line.register();
                    line.wake();
                    blocked = false;
                }
                Err(_would_block) => blocked = true,
            }
        }
    }

    fn poll_flush(self: Pin<&mut Self>, _: &mut Context<'_>) -> Poll<io::Result<()>> {
        Poll::Ready(Ok(()))
    }

    fn poll_shutdown(self: Pin<&mut Self>, _: &mut Context<'_>) -> Poll<io::Result<()>> {
        Poll::Ready(Ok(()))
    }
}

/// Who is at the other end of a pseudo-terminal.
enum Visit {
    /// Nobody so far.
    None,
    /// A host.
    Here,
    /// A host came and left between two looks.
    Gone,
}

fn visit(master: &OwnedFd) -> Visit {
    let mut polled = [PollFd::new(master, PollFlags::IN)];
    // Without waiting; a failure is looked at again.
    if poll(&mut polled, Some(&Timespec::default())).is_err() {
        return Visit::None;
    }
    let found = polled[0].revents();
    match (found.contains(PollFlags::HUP), found.contains(PollFlags::IN)) {
        (false, _) => Visit::Here,
        (true, true) => Visit::Gone,
        (true, false) => Visit::None,
    }
}

/// Makes a pseudo-terminal, raw and hung up, and has `path` lead to it.
fn open_under(path: &Path) -> io::Result<OwnedFd> {
    let flags = OpenptFlags::RDWR | OpenptFlags::NOCTTY | OpenptFlags::CLOEXEC;
    let master = openpt(flags)?;
    grantpt(&master)?;
    unlockpt(&master)?;
    // The settings belong to the pair: raw, 8 bits, no echo, no translation of CR or LF.
    let mut settings = tcgetattr(&master)?;
    settings.make_raw();
    tcsetattr(&master, OptionalActions::Now, &settings)?;
    ioctl_fionbio(&master, true)?;
    // Opened and closed once, so that it reports "hung up" until a host comes.
    drop(ioctl_tiocgptpeer(&master, flags)?);
    let device = ptsname(&master, Vec::new())?;
    let device = Path::new(OsStr::from_bytes(device.to_bytes()));
    // A name that changes in one step: a host finds the old port or the new one.
    let mut fresh = path.as_os_str().to_owned();
    fresh.push(".new");
    if let Err(error) = std::fs::remove_file(&fresh)
        && error.kind() != io::ErrorKind::NotFound
    {
        return Err(error);
    }
    std::os::unix::fs::symlink(device, &fresh)?;
    std::fs::rename(&fresh, path)?;
    Ok(master)
}

/// How long a host may wait until its first bytes are read.
const LOOK: Duration = Duration::from_millis(2);

#[cfg(test)]
mod tests;
