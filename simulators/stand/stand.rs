//! The devices on their links, and the trigger that they share.

use std::fmt;
use std::io;
use std::net::SocketAddr;
use std::sync::Arc;
use std::time::Duration;

use asphera_sim_ippdme::SharedMachine;
use thiserror::Error;
use tokio::net::TcpListener;
use tokio::sync::watch;
use tokio::task::JoinSet;
use tokio::time::{Instant, sleep, sleep_until};

use crate::axes::Axes;
use crate::bus::Bus;
use crate::connection;
use crate::gauges::Gauges;
use crate::moving::Moving;
use crate::opto::Opto;
use crate::played::{Instrument, Kind, Played};
use crate::port::serve_hosts;
use crate::probe::Probe;
use crate::profiler::Profiler;
use crate::registers;
use crate::rf60x::Rf60x;
use crate::scanner::Scanner;
use crate::showing::Showing;
use crate::voice::Voice;

/// Where a link of the configuration leads now.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Listing {
    /// Number of the link in the configuration.
    pub link: usize,
    /// Names of its devices.
    pub devices: Vec<String>,
    /// Kind of link: `tcp`, `tcp-pair` or `slcan-tcp`, which has to lead to the address; or `udp`, whose station listens there already.
    pub kind: &'static str,
    /// Its port.
    pub address: SocketAddr,
    /// The second port of a `tcp-pair`, at the same host.
    pub second_port: Option<u16>,
    /// Whether a device of the bus sends CAN FD.
    pub sends_fd: bool,
}

/// Why there is no stand.
#[derive(Debug, Error)]
pub enum StandError {
    /// No port can be had.
    #[error("cannot open a port of 127.0.0.1")]
    Port(#[from] io::Error),
    /// Two nodes of a bus have one number, or a map is not known.
    #[error("the devices of link {0} cannot be put together")]
    Devices(usize),
    /// An axis does not obey the station, in words.
    #[error("{0}")]
    Axes(String),
}

/// The devices at work. Dropped, it takes its ports away.
pub struct Stand {
    links: Vec<Listing>,
    scans: watch::Receiver<u64>,
    _tasks: JoinSet<()>,
}

/// What is behind one link.
#[derive(Clone)]
enum Line {
    Voice(Arc<Voice>),
    Bus(Arc<Bus>),
    Probe(Arc<Probe>),
    Scanner(Arc<Scanner>),
    Opto(Arc<Opto>),
    Rf60x(Arc<Rf60x>),
    /// With its second port.
    Profiler(Arc<Profiler>, u16),
    /// It is asked, whatever the trigger does: registers, a stage, a measuring machine.
    Asked,
}

impl Stand {
    /// Opens a port for each link and plays the devices at so many triggers a second, above 0, on the current tokio runtime.
    ///
    /// A scan begins when the host has armed every device that is triggered, and after it the devices stay at its last trigger. A host
    /// that disarms them and arms them again gets the same scan again. A host that does not read holds the scan back.
    ///
    /// # Errors
    ///
    /// When a port cannot be had, or the devices of a link do not fit together.
    pub async fn start(played: Vec<Played>, rate_hz: f64) -> Result<Stand, StandError> {
        Stand::open(played, rate_hz, None).await
    }

    /// The same of a station that moves its axes itself. Devices with a trigger send for as long as the station wants.
    ///
    /// # Errors
    ///
    /// As those of [`Stand::start`], and where an axis does not run as far as it would be moved.
    pub async fn start_moving(
        played: Vec<Played>,
        rate_hz: f64,
        moving: Moving,
    ) -> Result<Stand, StandError> {
        Stand::open(played, rate_hz, Some(moving)).await
    }

    async fn open(
        played: Vec<Played>,
        rate_hz: f64,
        moving: Option<Moving>,
    ) -> Result<Stand, StandError> {
        let period = Duration::from_secs_f64(1.0 / rate_hz);
        let axes = Axes::new(&played, moving.as_ref()).map_err(StandError::Axes)?;
        let showing = Arc::new(showing(&played, period, (axes, moving)));
        let mut links: Vec<usize> = played.iter().map(|played| played.instrument.link).collect();
        links.sort_unstable();
        links.dedup();
        let (mut tasks, mut listings, mut lines) = (JoinSet::new(), Vec::new(), Vec::new());
        for link in links {
            let port = TcpListener::bind(("127.0.0.1", 0)).await?;
            let there: Vec<(usize, &Played)> = played
                .iter()
                .enumerate()
                .filter(|(_, played)| played.instrument.link == link)
                .collect();
            let devices = there.iter().map(|(_, played)| played.instrument.name.clone()).collect();
            let listens = there.iter().find_map(|(_, played)| played.listen);
            let own = port.local_addr()?;
            let line =
                open(&there, port, &showing, &mut tasks)?.ok_or(StandError::Devices(link))?;
            let (kind, address, second_port) = match line {
                Line::Bus(_) => ("slcan-tcp", own, None),
                Line::Scanner(_) => ("udp", listens.unwrap_or(own), None),
                Line::Profiler(_, second_port) => ("tcp-pair", own, Some(second_port)),
                _ => ("tcp", own, None),
            };
            let sends_fd = there.iter().any(|(_, played)| played.instrument.sends_fd());
            listings.push(Listing { link, devices, kind, address, second_port, sends_fd });
            lines.push(line);
        }
        let (count, scans) = watch::channel(0);
        tasks.spawn(run(lines, showing, period, count));
        Ok(Stand { links: listings, scans, _tasks: tasks })
    }

    /// Where the links lead, in their order.
    pub fn listing(&self) -> &[Listing] {
        &self.links
    }

    /// Waits for the end of the next scan.
    pub async fn scanned(&mut self) {
        // The sender lives in a task of this stand.
        drop(self.scans.changed().await);
    }
}

impl fmt::Debug for Stand {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Stand").field("links", &self.links).finish_non_exhaustive()
    }
}

/// What all devices show.
fn showing(played: &[Played], period: Duration, axes: (Axes, Option<Moving>)) -> Showing {
    let still = |played: &Played| {
        let channels = 0..played.instrument.channels.len();
        channels.map(|channel| played.instrument.still(channel)).collect()
    };
    let courses = played.iter().map(|played| played.courses.clone()).collect();
    Showing::new(courses, played.iter().map(still).collect(), period, axes)
}

/// Puts the devices of one link behind its port. `None`: they do not fit together.
fn open(
    there: &[(usize, &Played)],
    port: TcpListener,
    showing: &Arc<Showing>,
    tasks: &mut JoinSet<()>,
) -> io::Result<Option<Line>> {
    let Some((device, first)) = there.first().copied() else { return Ok(None) };
    let Played { instrument: Instrument { channels, kind, link, .. }, sight, listen, .. } = first;
    Ok(Some(match kind {
        Kind::Transducer(_) | Kind::Gauge(_) | Kind::Drive(_) => {
            let Some(bus) = bus(*link, there, showing).map(Arc::new) else { return Ok(None) };
            tasks.spawn(bus.clone().serve(port));
            Line::Bus(bus)
        }
        Kind::Blocks(settings) => {
            let (sensor, queue) = Opto::new(device, settings);
            let sensor = Arc::new(sensor);
            let serving = sensor.clone();
            tasks.spawn(async move { connection::serve(&*serving, port, queue).await });
            Line::Opto(sensor)
        }
        Kind::Results(settings) => {
            let (sensor, queue) = Rf60x::new(device, settings, showing.clone());
            let (serving, repeating) = (sensor.clone(), sensor.clone());
            tasks.spawn(async move { connection::serve(&*serving, port, queue).await });
            tasks.spawn(async move { repeating.repeat().await });
            Line::Rf60x(sensor)
        }
        Kind::Profiler(settings) => {
            let Some(sight) = sight.clone() else { return Ok(None) };
            let streams = std::net::TcpListener::bind((port.local_addr()?.ip(), 0))?;
            streams.set_nonblocking(true)?;
            let streams = TcpListener::from_std(streams)?;
            let second_port = streams.local_addr()?.port();
            let (profiler, queue) = Profiler::new(device, settings, channels, sight);
            let profiler = Arc::new(profiler);
            let serving = profiler.clone();
            tasks.spawn(async move { serving.serve(port, streams, queue).await });
            Line::Profiler(profiler, second_port)
        }
        Kind::Stage(..) if showing.is_moved() => {
            let Some(stage) = showing.axes().stage(device).cloned() else { return Ok(None) };
            tasks.spawn(serve_hosts(port, move |stream| {
                let stage = stage.clone();
                async move { stage.serve(stream).await }
            }));
            Line::Asked
        }
        Kind::Machine => {
            let Some(touch) = &first.touch else { return Ok(None) };
            let machine = SharedMachine::new(touch.machine());
            tasks.spawn(serve_hosts(port, move |stream| {
                let machine = machine.clone();
                async move { machine.serve(stream).await }
            }));
            Line::Asked
        }
        Kind::Voice(frames) | Kind::Stage(_, frames) => {
            // A stage answers wherever it stands.
            let falls_silent = matches!(kind, Kind::Voice(_));
            let says = ((**frames).clone(), sight.clone());
            let (voice, queue) = Voice::new(device, says, falls_silent, showing.clone());
            let serving = voice.clone();
            tasks.spawn(async move { connection::serve(&*serving, port, queue).await });
            Line::Voice(voice)
        }
        Kind::Probe(protocol) => {
            let probe = Probe::new(device, protocol, channels.clone(), sight.clone());
            let probe = Arc::new(probe);
            let serving = probe.clone();
            tasks.spawn(async move { serving.serve(port).await });
            Line::Probe(probe)
        }
        Kind::Registers(settings) => {
            let Some(device) = registers::device(settings, device, showing.clone()) else {
                return Ok(None);
            };
            tasks.spawn(registers::answer(port, device, settings.clone()));
            Line::Asked
        }
        Kind::Scanner(settings) => {
            let Some((sight, listen)) = sight.clone().zip(*listen) else { return Ok(None) };
            Line::Scanner(Arc::new(Scanner::new(device, settings, channels, sight, listen)?))
        }
    }))
}

/// The bus of the devices of one link. `None`: they do not fit together.
fn bus(link: usize, there: &[(usize, &Played)], showing: &Arc<Showing>) -> Option<Bus> {
    let (mut nodes, mut gauges) = (Vec::new(), Vec::new());
    for (device, played) in there {
        match &played.instrument.kind {
            Kind::Transducer(settings) => nodes.push((*device, settings.clone())),
            Kind::Gauge(signals) => gauges.push((*device, (**signals).clone())),
            Kind::Drive(_) => {}
            _ => return None,
        }
    }
    let drives = showing.axes().drives(link).cloned();
    Bus::new(nodes, Gauges::new(gauges, showing.clone()), drives, showing.clone())
}

impl Line {
    fn is_triggered(&self) -> bool {
        match self {
            Line::Voice(voice) => voice.is_triggered(),
            Line::Bus(bus) => bus.is_triggered(),
            Line::Rf60x(sensor) => sensor.is_triggered(),
            Line::Probe(_) | Line::Scanner(_) | Line::Opto(_) | Line::Profiler(..) => true,
            Line::Asked => false,
        }
    }

    /// Whether it measures on after the scan.
    fn is_free(&self) -> bool {
        matches!(self, Line::Probe(probe) if probe.is_free())
    }

    fn is_armed(&self) -> bool {
        match self {
            Line::Voice(voice) => voice.is_armed(),
            Line::Bus(bus) => bus.is_armed(),
            Line::Probe(probe) => probe.is_armed(),
            Line::Scanner(scanner) => scanner.is_armed(),
            Line::Opto(sensor) => sensor.is_armed(),
            Line::Rf60x(sensor) => sensor.is_armed(),
            Line::Profiler(profiler, _) => profiler.is_armed(),
            Line::Asked => true,
        }
    }

    async fn trigger(&self, trigger: u64, showing: &Showing) {
        match self {
            Line::Voice(voice) => voice.trigger(trigger).await,
            Line::Bus(bus) => bus.trigger(trigger, showing).await,
            Line::Probe(probe) => probe.trigger(trigger, showing).await,
            Line::Scanner(scanner) => scanner.trigger(trigger, showing),
            Line::Opto(sensor) => sensor.trigger(trigger, showing).await,
            Line::Rf60x(sensor) => sensor.trigger(trigger).await,
            Line::Profiler(profiler, _) => profiler.trigger(trigger, showing).await,
            Line::Asked => {}
        }
    }
}

/// Scans whenever a host has armed everything.
async fn run(lines: Vec<Line>, showing: Arc<Showing>, period: Duration, count: watch::Sender<u64>) {
    if showing.triggers() == 0 {
        // Everything is asked, and nothing moves but by a program: no scan of the stand begins or ends.
        return std::future::pending().await;
    }
    // Where nothing is triggered, devices that are asked begin the scan.
    let is_any_triggered = lines.iter().any(Line::is_triggered);
    let waits_for = |line: &&Line| !is_any_triggered || line.is_triggered();
    loop {
        while !lines.iter().all(Line::is_armed) {
            sleep(POLL).await;
        }
        let began = Instant::now();
        let mut left_since = None;
        for trigger in 0..showing.triggers() {
            sleep_until(began + period.mul_f64(trigger as f64)).await;
            let is_left = !lines.iter().filter(waits_for).any(Line::is_armed);
            let since = is_left.then(|| left_since.unwrap_or_else(Instant::now));
            if since.is_some_and(|since: Instant| since.elapsed() > GONE) {
                break;
            }
            left_since = since;
            showing.step(trigger);
            for line in &lines {
                line.trigger(trigger, &showing).await;
            }
        }
        count.send_modify(|count| *count += 1);
        let (free, mut trigger) = (lines.iter().any(Line::is_free), showing.triggers());
        while lines.iter().filter(waits_for).any(Line::is_armed) {
            match free {
                // It measures on where the machine stands now.
                true => sleep_until(began + period.mul_f64(trigger as f64)).await,
                false => sleep(POLL).await,
            }
            for line in lines.iter().filter(|line| line.is_free()) {
                line.trigger(trigger, &showing).await;
            }
            trigger = trigger.saturating_add(1);
        }
        showing.back();
    }
}

/// Between two looks at whether the host is ready.
const POLL: Duration = Duration::from_millis(5);
/// A host that has disarmed everything for so long wants no more of the scan.
const GONE: Duration = Duration::from_millis(500);
