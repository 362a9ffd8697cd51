//! Drives on one bus behind an slcan adapter on a byte stream.

use std::io;
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Duration;

use asphera_link::{CanFrame, Nanos};
use asphera_slcan::{BEL, CR, Command, Decoder, Item, encode};
use tokio::io::{AsyncRead, AsyncReadExt as _, AsyncWrite, AsyncWriteExt as _};
use tokio::time::{Instant, sleep_until};

use crate::{Drive, Fault};

/// Drives of one bus that several hands hold, on the clock of its creation.
#[derive(Clone)]
pub struct SharedDrives {
    drives: Arc<Mutex<Vec<Drive>>>,
    origin: Instant,
}

impl SharedDrives {
    /// Drives whose time begins now.
    pub fn new(drives: Vec<Drive>) -> SharedDrives {
        SharedDrives { drives: Arc::new(Mutex::new(drives)), origin: Instant::now() }
    }

    /// Time since they were switched on.
    pub fn now(&self) -> Duration {
        self.origin.elapsed()
    }

    /// Place of each on its travel, in counts.
    pub fn places(&self) -> Vec<f64> {
        self.with(|drives, now| drives.iter().map(|drive| drive.place(now)).collect())
    }

    /// Whether one of them moves.
    pub fn is_moving(&self) -> bool {
        self.with(|drives, now| drives.iter().any(|drive| drive.is_moving(now)))
    }

    /// Runs that each began, homing among them.
    pub fn moves(&self) -> Vec<u64> {
        self.with(|drives, _| drives.iter().map(Drive::moves).collect())
    }

    /// Does harm to a drive, by its place in the list. What the drive sends because of it is lost.
    pub fn fault(&self, drive: usize, fault: Fault) {
        self.with(|drives, now| {
            drives.get_mut(drive).map(|drive| drive.fault(now, fault));
        });
    }

    fn with<T>(&self, act: impl FnOnce(&mut [Drive], Nanos) -> T) -> T {
        let now = Nanos::ZERO + self.origin.elapsed();
        // A panic while they were held cannot leave them half-changed in a way that matters to a simulator.
        act(&mut self.drives.lock().unwrap_or_else(PoisonError::into_inner), now)
    }

    /// Something else moves an axis, by its place in the list, to a place on its travel in counts.
    pub fn push(&self, drive: usize, place: f64) {
        self.with(|drives, now| {
            if let Some(drive) = drives.get_mut(drive) {
                drive.push(now, place);
            }
        });
    }

    /// Whether all of them are operational and send their positions.
    pub fn are_sending(&self) -> bool {
        self.with(|drives, _| drives.iter().all(Drive::is_sending))
    }

    /// When [`SharedDrives::timeout`] is to be called, if at all.
    pub fn due(&self) -> Option<Instant> {
        let due = self.with(|drives, _| drives.iter().filter_map(Drive::poll_timeout).min());
        due.map(|due| self.origin + due.since(Nanos::ZERO))
    }

    /// Frames that the drives send by themselves now.
    pub fn timeout(&self) -> Vec<CanFrame> {
        self.with(|drives, now| {
            let due = |drive: &&mut Drive| drive.poll_timeout().is_some_and(|due| due <= now);
            drives.iter_mut().filter(due).flat_map(|drive| drive.timeout(now)).collect()
        })
    }

    /// Takes a frame of the bus, and gives what the drives send in turn.
    pub fn receive(&self, frame: &CanFrame) -> Vec<CanFrame> {
        self.with(|drives, now| {
            drives.iter_mut().flat_map(|drive| drive.receive(now, frame)).collect()
        })
    }
}

/// Serves one host until it leaves or the stream fails. The adapter answers CR to what it does and BEL to what it does not.
pub async fn serve(
    shared: &SharedDrives,
    stream: impl AsyncRead + AsyncWrite + Unpin,
) -> io::Result<()> {
    let (mut reader, mut writer) = tokio::io::split(stream);
    let (mut decoder, mut buffer) = (Decoder::new(), [0; 4096]);
    let mut is_open = false;
    loop {
        let due = shared.due();
        let mut lines = Vec::new();
        tokio::select! {
            count = reader.read(&mut buffer) => {
                let count = count?;
                if count == 0 {
                    return Ok(());
                }
                let mut bytes = &buffer[..count];
                while !bytes.is_empty() {
                    if let Some(item) = decoder.decode(&mut bytes) {
                        take(shared, item, &mut is_open, &mut lines);
                    }
                }
            }
            () = until(due) => {
                let frames = shared.timeout();
                frames.iter().filter(|_| is_open).for_each(|frame| encode(frame, &mut lines));
            }
        }
        writer.write_all(&lines).await?;
        writer.flush().await?;
    }
}

fn take(shared: &SharedDrives, item: Item, is_open: &mut bool, lines: &mut Vec<u8>) {
    match item {
        Item::Frame(frame, _) if *is_open => {
            lines.push(CR);
            shared.receive(&frame).iter().for_each(|frame| encode(frame, lines));
        }
        Item::Command(Command::Open) if !*is_open => {
            *is_open = true;
            lines.push(CR);
        }
        Item::Command(Command::Close) if *is_open => {
            *is_open = false;
            lines.push(CR);
        }
        Item::Ok | Item::Command(Command::BitRate(_) | Command::Timestamps(_)) => lines.push(CR),
        _ => lines.push(BEL),
    }
}

async fn until(due: Option<Instant>) {
    match due {
        Some(due) => sleep_until(due).await,
        None => std::future::pending().await,
    }
}
