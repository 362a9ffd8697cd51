//! A stage that connections share, in real time.

use std::io;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

use tokio::io::{AsyncRead, AsyncReadExt as _, AsyncWrite, AsyncWriteExt as _};
use tokio::time::Instant;

use crate::{Fault, Stage};

/// A stage that several connections share. Clones are the same stage.
#[derive(Clone, Debug)]
pub struct SharedStage {
    start: Instant,
    shared: Arc<Mutex<Shared>>,
}

#[derive(Debug)]
struct Shared {
    stage: Stage,
    received: Vec<Received>,
}

/// Command that the stage received.
#[derive(Clone, Debug, PartialEq)]
pub struct Received {
    /// Time since the stage was started.
    pub at: Duration,
    /// Its bytes, as they were read together.
    pub bytes: Vec<u8>,
}

impl SharedStage {
    /// A stage whose time begins now.
    pub fn new(stage: Stage) -> SharedStage {
        let shared = Shared { stage, received: Vec::new() };
        SharedStage { start: Instant::now(), shared: Arc::new(Mutex::new(shared)) }
    }

    /// Time since the stage was started.
    pub fn now(&self) -> Duration {
        self.start.elapsed()
    }

    /// Positions in mm.
    pub fn places_mm(&self) -> Vec<f64> {
        let now_s = self.now().as_secs_f64();
        self.shared().stage.places_mm(now_s)
    }

    /// Whether an axis moves.
    pub fn is_moving(&self) -> bool {
        let now_s = self.now().as_secs_f64();
        self.shared().stage.is_moving(now_s)
    }

    /// Moves that were accepted so far.
    pub fn moves(&self) -> u64 {
        self.shared().stage.moves()
    }

    /// Lets something happen.
    pub fn fault(&self, fault: Fault) {
        let now_s = self.now().as_secs_f64();
        self.shared().stage.fault(now_s, fault);
    }

    /// Commands other than questions for the position, in the order in which they were read.
    pub fn received(&self) -> Vec<Received> {
        self.shared().received.clone()
    }

    /// Answers a connection to its end.
    ///
    /// # Errors
    ///
    /// Those of the connection.
    pub async fn serve(&self, mut stream: impl AsyncRead + AsyncWrite + Unpin) -> io::Result<()> {
        let mut buffer = [0; 1024];
        loop {
            let count = stream.read(&mut buffer).await?;
            if count == 0 {
                return Ok(());
            }
            let reply = self.receive(&buffer[..count]);
            stream.write_all(&reply).await?;
        }
    }

    fn receive(&self, bytes: &[u8]) -> Vec<u8> {
        let at = self.now();
        let mut shared = self.shared();
        if !bytes.ends_with(b"get pos\n") || bytes.iter().filter(|byte| **byte == b'\n').count() > 1
        {
            shared.received.push(Received { at, bytes: bytes.to_vec() });
        }
        shared.stage.receive(at.as_secs_f64(), bytes)
    }

    fn shared(&self) -> MutexGuard<'_, Shared> {
        // Whoever panicked left numbers that are whole.
        self.shared.lock().unwrap_or_else(PoisonError::into_inner)
    }
}
