//! The driver of a node over a link, in real time.

use std::time::Duration;

use asphera_cia406::{Cia406, Settings};
use asphera_link::{CanFrame, Command, Driver as _, Event, Flags, Input, Nanos, Output, Reading};
use asphera_sim_cia406::NodeConfig;
use asphera_transport::{LinkCommand, What};
use tokio::time::{Instant, interval, sleep_until, timeout_at};

use crate::frames::{PATIENCE, Probe};
use crate::interface::Interface;
use crate::node::SimulatedNode;
use crate::report::{Report, note};

/// A link, the driver behind it, and what both told.
struct Station {
    probe: Probe,
    driver: Cia406,
    origin: Instant,
    /// The present connection, if there is one.
    epoch: Option<u64>,
    /// The latest connection, present or past.
    latest_epoch: u64,
    /// All the link told but frames.
    link: Vec<What>,
    /// All the driver told.
    told: Vec<Event>,
}

const NODE: u8 = 5;
/// Counters of SYNC go from 1 to this.
const OVERFLOW: u8 = 10;
const SYNC_PERIOD: Duration = Duration::from_millis(2);
const STEP_NM: u32 = 1000;

/// The driver measures, survives the interface going down, and survives it going away.
pub(crate) async fn measures_and_comes_back(interface: &Interface, report: &mut Report) {
    let (mut station, mut node) = match start(interface) {
        Ok(both) => both,
        Err(error) => return report.check("node operational", Err(error)),
    };
    let ready = station.ready(&mut node).await;
    let go_on = ready.is_ok();
    report.check("node operational", ready);
    if !go_on {
        return;
    }
    report.check("500 SYNCs", station.measure(&node, 500).await);
    report.check("a second of silence", station.idle().await);

    report.check("interface down", station.loses(interface.down(), &["down"]).await);
    report.check("stays closed while down", station.stays_closed(interface.name(), "down").await);
    report.check("interface up again", station.returns(interface.up(), &mut node).await);
    report.check("500 SYNCs after that", station.measure(&node, 500).await);

    report.check("interface removed", station.loses(interface.remove(), &["down", "device"]).await);
    report.check("stays closed while gone", station.stays_closed(interface.name(), "device").await);
    let back = interface.add().and_then(|()| interface.up());
    report.check("interface added again", station.returns(back, &mut node).await);
    report.check("500 SYNCs in the end", station.measure(&node, 500).await);
}

fn start(interface: &Interface) -> Result<(Station, SimulatedNode), String> {
    let config = NodeConfig { node_id: NODE, position_step_nm: STEP_NM, ..NodeConfig::default() };
    let node = SimulatedNode::spawn(interface.name(), config)?;
    let settings =
        Settings { node_id: NODE, sync_counter_overflow: Some(OVERFLOW), ..Settings::default() };
    let mut driver = Cia406::new(settings).map_err(|problems| format!("{problems:?}"))?;
    driver.command(Nanos::ZERO, Command::Start);
    let station = Station {
        probe: Probe::start(interface.name(), 64)?,
        driver,
        origin: Instant::now(),
        epoch: None,
        latest_epoch: 0,
        link: Vec::new(),
        told: Vec::new(),
    };
    Ok((station, node))
}

impl Station {
    /// Waits for the driver to say that the node is ready.
    async fn ready(&mut self, node: &mut SimulatedNode) -> Result<String, String> {
        let begin = Instant::now();
        self.until(|station| station.told.contains(&Event::Ready)).await?;
        self.quiet()?;
        if !*node.armed.borrow_and_update() {
            return Err("the driver calls the node ready, and it is not operational".to_owned());
        }
        Ok(format!("epoch {}, after {} ms", self.epoch.unwrap_or(0), begin.elapsed().as_millis()))
    }

    /// Sends SYNCs in real time and compares each reading with what the node was told.
    async fn measure(&mut self, node: &SimulatedNode, count: usize) -> Result<String, String> {
        self.told.clear();
        self.link.clear();
        let mut ticks = interval(SYNC_PERIOD);
        let begin = Instant::now();
        for cycle in 0..count {
            node.sync(counter(cycle), position(cycle));
            let at = ticks.tick().await;
            self.run_to(at).await?;
        }
        self.until(|station| station.readings().count() >= count).await?;
        let elapsed = begin.elapsed();
        self.quiet()?;
        if !self.link.is_empty() {
            return Err(format!("the link told {:?}", self.link));
        }
        for (cycle, reading) in self.readings().enumerate() {
            let expected = f64::from(position(cycle)) * f64::from(STEP_NM) * 1e-6;
            // Far below the step of 1 µm, far above the rounding of a double.
            let exact = reading.values.get(0).is_some_and(|mm| (mm - expected).abs() < 1e-9);
            let counted = reading.count.map(|count| count.raw) == Some(counter(cycle).into());
            if !exact || !counted || reading.flags != Flags::empty() {
                return Err(format!("reading {cycle} is {reading:?}, expected {expected} mm"));
            }
        }
        let got = self.readings().count();
        if got != count {
            return Err(format!("{got} readings for {count} SYNCs"));
        }
        Ok(format!(
            "{got} readings with the exact position and count in {} ms",
            elapsed.as_millis()
        ))
    }

    /// Heartbeats keep the node alive while nothing is measured.
    async fn idle(&mut self) -> Result<String, String> {
        self.told.clear();
        self.run_to(Instant::now() + Duration::from_millis(1500)).await?;
        if !self.told.is_empty() {
            return Err(format!("the driver told {:?}", self.told));
        }
        Ok("heartbeats come, nothing to tell".to_owned())
    }

    /// Waits for the link to close, with a reason that has one of the words in it.
    async fn loses(&mut self, done: Result<(), String>, words: &[&str]) -> Result<String, String> {
        done?;
        self.link.clear();
        self.until(|station| !station.link.is_empty()).await?;
        match &self.link[0] {
            What::Closed(reason) if words.iter().any(|word| reason.contains(word)) => {
                Ok(format!("Closed \"{reason}\""))
            }
            other => Err(format!("expected Closed with one of {words:?}, got {other:?}")),
        }
    }

    /// While there is nothing to open, the link says so and does not open.
    async fn stays_closed(&mut self, name: &str, word: &str) -> Result<String, String> {
        self.link.clear();
        self.run_to(Instant::now() + Duration::from_secs(1)).await?;
        let opened = self.link.iter().filter(|what| matches!(what, What::Opened { .. })).count();
        if opened > 0 {
            return Err(format!("opened {opened} times in 1 s: {:?}", self.link));
        }
        let mut failures = self.link.iter().map(|what| match what {
            What::OpenFailed(words) if words.contains(name) && words.contains(word) => Ok(words),
            other => {
                Err(format!("expected OpenFailed with \"{name}\" and \"{word}\", got {other:?}"))
            }
        });
        let words = failures.next().ok_or("the link told nothing for 1 s")??;
        failures.try_for_each(|failure| failure.map(|_| ()))?;
        Ok(format!("{} times OpenFailed \"{words}\"", self.link.len()))
    }

    /// Waits for a new connection and a node that is ready again.
    async fn returns(
        &mut self,
        done: Result<(), String>,
        node: &mut SimulatedNode,
    ) -> Result<String, String> {
        done?;
        let before = self.latest_epoch;
        self.told.clear();
        let begin = Instant::now();
        self.until(|station| station.told.contains(&Event::Ready)).await?;
        let ready_ms = begin.elapsed().as_millis();
        if !*node.armed.borrow_and_update() {
            return Err("the driver calls the node ready, and it is not operational".to_owned());
        }
        match self.epoch {
            Some(epoch) if epoch > before => {
                Ok(format!("epoch {before} became {epoch}, node ready after {ready_ms} ms"))
            }
            epoch => Err(format!("epoch was {before} and is {epoch:?}")),
        }
    }

    fn readings(&self) -> impl Iterator<Item = &Reading> {
        self.told.iter().filter_map(|event| match event {
            Event::Reading(reading) => Some(reading),
            _ => None,
        })
    }

    /// Whether the driver told nothing bad.
    fn quiet(&self) -> Result<(), String> {
        let bad = |event: &&Event| {
            matches!(event, Event::Fault(_) | Event::Discarded { .. } | Event::Reopen(_))
        };
        match self.told.iter().find(bad) {
            Some(event) => Err(format!("the driver told {event:?}")),
            None => Ok(()),
        }
    }

    async fn until(&mut self, done: impl Fn(&Station) -> bool) -> Result<(), String> {
        let deadline = Instant::now() + PATIENCE;
        while !done(self) {
            if timeout_at(deadline, self.step()).await.map_err(|_| self.stuck())?.is_none() {
                return Err("the link ended".to_owned());
            }
        }
        Ok(())
    }

    async fn run_to(&mut self, deadline: Instant) -> Result<(), String> {
        while let Ok(alive) = timeout_at(deadline, self.step()).await {
            alive.ok_or("the link ended")?;
        }
        Ok(())
    }

    fn stuck(&self) -> String {
        let last = |count: usize| count.saturating_sub(3);
        format!(
            "not within {PATIENCE:?}; epoch {:?}, {} readings, link told last {:?}, driver told last {:?}",
            self.epoch,
            self.readings().count(),
            &self.link[last(self.link.len())..],
            &self.told[last(self.told.len())..],
        )
    }

    /// Takes the next thing the link tells or does what is due; `None` when the link has ended. Nothing is
    /// lost when it is dropped while it waits.
    async fn step(&mut self) -> Option<()> {
        let due = self.driver.poll_timeout().filter(|_| self.epoch.is_some());
        let due = due.map(|at| self.origin + at.since(Nanos::ZERO));
        let what = tokio::select! {
            event = self.probe.events.recv() => Some(event?.what),
            () = sleep_until(due.unwrap_or(self.origin)), if due.is_some() => None,
        };
        let now = Nanos::ZERO + self.origin.elapsed();
        match what {
            None => self.driver.timeout(now),
            Some(What::Received(bytes)) => match CanFrame::from_record(&bytes) {
                Ok(frame) => self.driver.receive(now, Input::Frame(&frame)),
                Err(error) => note(&format!("no frame: {error}")),
            },
            Some(what) => {
                match &what {
                    What::Opened { epoch } => {
                        self.epoch = Some(*epoch);
                        self.latest_epoch = *epoch;
                        self.driver.connected(now);
                    }
                    What::Closed(_) => {
                        self.driver.disconnected(now);
                        self.epoch = None;
                    }
                    _ => {}
                }
                self.link.push(what);
            }
        }
        while let Some(Output::Frame(frame)) = self.driver.poll_transmit() {
            if let Some(epoch) = self.epoch {
                let bytes = frame.to_record();
                self.probe.link.command(LinkCommand::Send { epoch, bytes });
            }
        }
        while let Some(event) = self.driver.poll_event() {
            if matches!(event, Event::Online | Event::Ready) {
                self.probe.link.command(LinkCommand::Confirm);
            }
            self.told.push(event);
        }
        Some(())
    }
}

fn counter(cycle: usize) -> u8 {
    1 + (cycle % usize::from(OVERFLOW)) as u8
}

/// Positions of both signs, no two alike.
fn position(cycle: usize) -> i32 {
    let place = cycle as i32;
    if cycle.is_multiple_of(2) { 7_919 * place } else { -7_919 * place }
}
