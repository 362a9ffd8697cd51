//! What the pipeline's thread does next.

use tokio::runtime::Handle;
use tokio::sync::mpsc;
use tokio::sync::mpsc::error::TryRecvError;
use tokio::time::timeout;

use super::{PERIOD, Work};
use crate::live::overflow::Overflow;
use crate::station::Point;

/// What the thread takes its work from: first what was sent, then points of the file, all of which are newer than those that were sent.
pub(super) struct Queue {
    pub(super) work: mpsc::Receiver<Work>,
    pub(super) overflow: Overflow,
}

/// What is next.
pub(super) enum Turn {
    Work(Work),
    Overflown(Vec<Point>),
    Nothing,
    End,
}

impl Queue {
    /// The next work; waits for some, but no longer than [`PERIOD`]. Fails with the error of the disk.
    pub(super) fn next(&mut self, runtime: &Handle) -> std::io::Result<Turn> {
        if self.overflow.is_waiting() {
            return match self.work.try_recv() {
                Ok(work) => Ok(Turn::Work(work)),
                Err(TryRecvError::Empty) => Ok(Turn::Overflown(self.overflow.take()?)),
                // Nobody waits for figures any more.
                Err(TryRecvError::Disconnected) => Ok(Turn::End),
            };
        }
        let work = &mut self.work;
        Ok(match runtime.block_on(async { timeout(PERIOD, work.recv()).await }) {
            Ok(Some(work)) => Turn::Work(work),
            Ok(None) => Turn::End,
            Err(_) => Turn::Nothing,
        })
    }
}
