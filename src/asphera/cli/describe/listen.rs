//! A device that is listened to, outside of any station.

use std::time::Duration;

use asphera_link::{Command, Driver, Event, Input, Nanos, Output, Reading};
use asphera_transport::{Backoff, Endpoint, Link, LinkCommand, LinkEvent, LinkSettings, What};
use tokio::sync::mpsc;
use tokio::time::{Instant, sleep_until};

use super::super::output::{Failure, progress, say};
use crate::clock::Clock;

/// Readings that are enough to show that settings work.
const ENOUGH: usize = 5;

/// An open link.
pub(super) struct Listener {
    link: Link,
    events: mpsc::Receiver<LinkEvent>,
    /// The connection that is open; 0: none yet.
    epoch: u64,
    clock: Clock,
}

impl Listener {
    /// Begins to open the link; within a tokio runtime.
    pub(super) fn open(endpoint: Endpoint) -> Result<Listener, Failure> {
        let backoff = Backoff::try_new(Duration::from_millis(100), Duration::from_secs(1), 1)?;
        let (sender, events) = mpsc::channel(256);
        let link = Link::spawn(LinkSettings { index: 0, endpoint, backoff }, sender);
        Ok(Listener { link, events, epoch: 0, clock: Clock::start() })
    }

    /// Bytes received in so many seconds. With a question it is asked again and again.
    ///
    /// Fails when the link cannot be opened.
    pub(super) async fn hear(
        &mut self,
        asked: Option<(Vec<u8>, u32)>,
        seconds: u32,
    ) -> Result<Vec<u8>, Failure> {
        let mut received = Vec::new();
        let end = Instant::now() + Duration::from_secs(seconds.into());
        let mut ask_at = Instant::now();
        loop {
            let question = asked.as_ref().filter(|_| self.epoch > 0);
            tokio::select! {
                event = self.events.recv() => match event.map(|event| event.what) {
                    Some(What::Opened { epoch }) => self.epoch = epoch,
                    Some(What::Received(bytes)) => received.extend(bytes),
                    Some(What::OpenFailed(why)) => return Err(why.into()),
                    Some(What::Closed(why)) => {
                        self.epoch = 0;
                        say(&format!("the link was closed: {why}"));
                    }
                    Some(What::BusError(why)) => say(&why),
                    None => return Err("the link ended".into()),
                },
                () = sleep_until(ask_at), if question.is_some() => {
                    if let Some((bytes, every_ms)) = question {
                        self.link.command(LinkCommand::Send { epoch: self.epoch, bytes: bytes.clone() });
                        // From now on: a link that was closed for a while has no questions to make up for.
                        ask_at = Instant::now() + Duration::from_millis((*every_ms).into());
                    }
                }
                () = sleep_until(end) => return Ok(received),
            }
            progress(&format!("listening: {} bytes", received.len()));
        }
    }

    /// Runs a driver on a new connection until it gave enough readings, or for so many seconds.
    pub(super) async fn run(
        &mut self,
        mut driver: Box<dyn Driver>,
        seconds: u32,
    ) -> Result<Vec<Reading>, Failure> {
        let mut readings = Vec::new();
        let end = Instant::now() + Duration::from_secs(seconds.into());
        self.link.command(LinkCommand::Reopen { epoch: self.epoch });
        let mut is_open = false;
        while readings.len() < ENOUGH {
            let due = driver.poll_timeout().filter(|_| is_open);
            let wait = due.map_or(Duration::MAX, |due| due.since(self.clock.now()));
            let due_at = Instant::now().checked_add(wait).unwrap_or(end);
            tokio::select! {
                event = self.events.recv() => {
                    let Some(LinkEvent { at, what, .. }) = event else { break };
                    let now = self.clock.at(at.into_std());
                    match what {
                        What::Opened { epoch } => {
                            self.epoch = epoch;
                            is_open = true;
                            driver.connected(now);
                            driver.command(now, Command::Start);
                        }
                        What::Received(bytes) if is_open => driver.receive(now, Input::Bytes(&bytes)),
                        What::Closed(_) if is_open => {
                            is_open = false;
                            driver.disconnected(now);
                        }
                        What::OpenFailed(why) => return Err(why.into()),
                        _ => {}
                    }
                }
                () = sleep_until(due_at), if due.is_some() => driver.timeout(self.clock.now()),
                () = sleep_until(end) => break,
            }
            self.serve(&mut *driver, &mut readings);
        }
        Ok(readings)
    }

    /// Sends what the driver says, and takes its readings. Faults are printed.
    fn serve(&self, driver: &mut dyn Driver, readings: &mut Vec<Reading>) {
        while let Some(output) = driver.poll_transmit() {
            if let Output::Bytes(bytes) = output {
                self.link.command(LinkCommand::Send { epoch: self.epoch, bytes });
            }
        }
        while let Some(event) = driver.poll_event() {
            match event {
                Event::Reading(reading) => readings.push(reading),
                Event::Fault(fault) => say(&fault.detail),
                Event::Reopen(fault) => {
                    say(&fault.detail);
                    self.link.command(LinkCommand::Reopen { epoch: self.epoch });
                }
                Event::Online | Event::Ready | Event::Discarded { .. } | Event::Motion(_) => {}
            }
        }
    }
}

/// Readings that a driver makes of bytes, all received at once.
pub(super) fn replay(driver: &mut dyn Driver, bytes: &[u8]) -> Vec<Reading> {
    driver.connected(Nanos::ZERO);
    driver.receive(Nanos::ZERO, Input::Bytes(bytes));
    let mut readings = Vec::new();
    while let Some(event) = driver.poll_event() {
        if let Event::Reading(reading) = event {
            readings.push(reading);
        }
    }
    readings
}
