//! A machine that connections share, in real time.

use std::io;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

use tokio::io::{AsyncRead, AsyncReadExt as _, AsyncWrite, AsyncWriteExt as _};
use tokio::time::{Instant, sleep};

use crate::{Fault, Machine};

/// A machine that several connections may serve, one after the other. Clones are the same machine.
#[derive(Clone, Debug)]
pub struct SharedMachine {
    start: Instant,
    shared: Arc<Mutex<Shared>>,
}

#[derive(Debug)]
struct Shared {
    machine: Machine,
    received: Vec<Received>,
}

/// Bytes that the machine received together.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Received {
    /// Time since the machine was started.
    pub at: Duration,
    /// The bytes as text.
    pub text: String,
}

impl SharedMachine {
    /// A machine whose time begins now.
    pub fn new(machine: Machine) -> SharedMachine {
        let shared = Shared { machine, received: Vec::new() };
        SharedMachine { start: Instant::now(), shared: Arc::new(Mutex::new(shared)) }
    }

    /// Time since the machine was started.
    pub fn now(&self) -> Duration {
        self.start.elapsed()
    }

    /// Whether it moves.
    pub fn is_moving(&self) -> bool {
        self.shared().machine.is_moving()
    }

    /// Lets something happen.
    pub fn fault(&self, fault: Fault) {
        let now_s = self.now().as_secs_f64();
        self.shared().machine.fault(now_s, fault);
    }

    /// Commands in the order in which they were read.
    pub fn received(&self) -> Vec<Received> {
        self.shared().received.clone()
    }

    /// Serves a connection to its end.
    ///
    /// # Errors
    ///
    /// Those of the connection.
    pub async fn serve(&self, mut stream: impl AsyncRead + AsyncWrite + Unpin) -> io::Result<()> {
        self.shared().machine.connected(self.now().as_secs_f64());
        let mut buffer = [0; 4096];
        loop {
            let (answers, due_s) = {
                let now_s = self.now().as_secs_f64();
                let mut shared = self.shared();
                let answers = shared.machine.poll_transmit(now_s);
                let due_s = shared.machine.poll_timeout();
                (answers, due_s.map_or(LONGEST_S, |due_s| (due_s - now_s).clamp(0.0, LONGEST_S)))
            };
            stream.write_all(&answers).await?;
            tokio::select! {
                count = stream.read(&mut buffer) => {
                    let count = count?;
                    if count == 0 {
                        return Ok(());
                    }
                    self.receive(&buffer[..count]);
                }
                () = sleep(Duration::from_secs_f64(due_s)) => {}
            }
        }
    }

    fn receive(&self, bytes: &[u8]) {
        let at = self.now();
        let mut shared = self.shared();
        let text = String::from_utf8_lossy(bytes).into_owned();
        shared.received.push(Received { at, text });
        shared.machine.receive(at.as_secs_f64(), bytes);
    }

    fn shared(&self) -> MutexGuard<'_, Shared> {
        // Whoever panicked left numbers that are whole.
        self.shared.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// Longest time without a look at faults.
const LONGEST_S: f64 = 0.05;
