//! Files and pipes as links. Nothing can be sent to them.

use std::io;
use std::time::Duration;

use tokio::io::AsyncReadExt as _;
use tokio::time::{Instant, sleep, sleep_until};
use tracing::trace;

use super::{Act, End, Hex, READ_BYTES, What, Worker};
use crate::FileSettings;
use crate::files::{AtEnd, Bookmark, FilePort, Pipe, RegularFile};

/// Event that a file waits for.
enum Next {
    Read(io::Result<usize>),
    End(End),
}

impl Worker {
    /// Serves a file or a pipe.
    pub(super) async fn serve_file(&mut self, settings: &FileSettings, port: FilePort) -> End {
        match port {
            FilePort::Regular(mut file) => {
                let end = self.serve_regular(settings, &mut file).await;
                if self.bookmark == Bookmark::AsSet {
                    self.bookmark = Bookmark::At(file.mark());
                }
                end
            }
            FilePort::Pipe(pipe) => self.serve_pipe(settings, pipe).await,
        }
    }

    /// Reads a file to its end, and on where it is followed.
    async fn serve_regular(&mut self, settings: &FileSettings, file: &mut RegularFile) -> End {
        // Where a new connection to the same file goes on; set anew where that would be wrong.
        self.bookmark = Bookmark::AsSet;
        let mut buffer = vec![0; READ_BYTES];
        // The file lost its name: what stands in it is read first.
        let mut leaving = None;
        loop {
            let next = tokio::select! {
                biased;
                end = self.obey() => Next::End(end),
                read = file.read(&mut buffer) => Next::Read(read),
            };
            match next {
                Next::End(end) => return end,
                Next::Read(Err(error)) => return End::Closed(reading_failed(settings, &error)),
                Next::Read(Ok(0)) if !settings.follow => {
                    return End::Over(format!("{settings} was read to its end"));
                }
                Next::Read(Ok(0)) => {
                    if let Some(words) = leaving {
                        self.bookmark = Bookmark::Begin;
                        return End::Closed(words);
                    }
                    match file.at_end(&settings.path).await {
                        Ok(AtEnd::Waits) => {
                            if let Some(end) = self.wait_for_growth().await {
                                return end;
                            }
                        }
                        Ok(AtEnd::Truncated(len)) => {
                            self.bookmark = Bookmark::Begin;
                            return End::Closed(truncated(settings, file.offset(), len));
                        }
                        Ok(state) => leaving = Some(left(settings, state)),
                        Err(error) => return End::Closed(reading_failed(settings, &error)),
                    }
                }
                Next::Read(Ok(count)) => {
                    if !self.tell_read(&buffer[..count]).await {
                        return End::Shutdown;
                    }
                }
            }
        }
    }

    /// Reads a pipe. A writer that closes one with a name ends the connection; the next begins another. The pipe has a
    /// reader all the time, so that no byte of the next writer is lost.
    async fn serve_pipe(&mut self, settings: &FileSettings, mut pipe: Pipe) -> End {
        let mut buffer = vec![0; READ_BYTES];
        loop {
            let next = tokio::select! {
                biased;
                end = self.obey() => Next::End(end),
                read = pipe.receiver.read(&mut buffer) => Next::Read(read),
            };
            let words = match next {
                Next::Read(Ok(0)) if !pipe.is_named => {
                    return End::Over(format!("the program that wrote to {settings} ended"));
                }
                Next::Read(Ok(0)) => format!(
                    "the program that wrote to {settings} closed it: start it again, or another"
                ),
                Next::Read(Ok(count)) => {
                    if !self.tell_read(&buffer[..count]).await {
                        return End::Shutdown;
                    }
                    continue;
                }
                Next::Read(Err(error)) => return End::Closed(reading_failed(settings, &error)),
                Next::End(End::Closed(words)) => words,
                Next::End(end) => return end,
            };
            // Opened again before the old end closes.
            pipe = match Pipe::open(&settings.system_path()) {
                Ok(pipe) => pipe,
                Err(error) => return End::Closed(reading_failed(settings, &error)),
            };
            if !self.tell(What::Closed(words)).await {
                return End::Shutdown;
            }
            sleep(self.settings.backoff.next_wait()).await;
            self.epoch += 1;
            if !self.tell(What::Opened { epoch: self.epoch }).await {
                return End::Shutdown;
            }
        }
    }

    /// Takes commands until one ends the connection. What is sent goes nowhere.
    async fn obey(&mut self) -> End {
        loop {
            let command = self.commands.recv().await;
            if let Act::End(end) = self.act(command) {
                return end;
            }
        }
    }

    async fn wait_for_growth(&mut self) -> Option<End> {
        let due = Instant::now() + FOLLOW_PERIOD;
        tokio::select! {
            biased;
            end = self.obey() => Some(end),
            () = sleep_until(due) => None,
        }
    }

    /// Whether anybody listens still.
    async fn tell_read(&mut self, bytes: &[u8]) -> bool {
        trace!(link = self.settings.index, bytes = %Hex(bytes), "received");
        self.tell(What::Received(bytes.to_vec())).await
    }
}

fn reading_failed(settings: &FileSettings, error: &io::Error) -> String {
    format!("reading {settings} failed: {error}")
}

fn truncated(settings: &FileSettings, from: u64, to: u64) -> String {
    format!(
        "{settings} was truncated from {from} to {to} bytes: reading begins anew at its beginning; what it lost unread is missing. \
         Let the program append to it, or rename a new file over it"
    )
}

fn left(settings: &FileSettings, state: AtEnd) -> String {
    match state {
        AtEnd::Replaced => format!(
            "{settings} was replaced by another file: that is read from its beginning, the old one was read to its end"
        ),
        _ => format!("{settings} was removed: a new file of this name is waited for"),
    }
}

/// Time from one look at a file that may have grown to the next.
const FOLLOW_PERIOD: Duration = Duration::from_millis(50);
