//! One link as the core sees it: bytes in, readings out, through the drivers of its devices.

use std::collections::BTreeMap;

use asphera_link::{
    CanFrame, Command, Driver, Event, Fault, Flags, Input, Motion, MotionEvent, MotionFailure,
    Nanos, Output, Reading,
};
use asphera_report::{ChannelFigures, DeviceFigures, LinkFigures};

use super::bus::{Bus, Piece};
use super::framing::Framing;
use super::heard::Heard;

/// One link and its devices.
pub struct Line {
    name: String,
    framing: Framing,
    bus: Bus,
    devices: Vec<Device>,
    /// The open connection, if there is one.
    epoch: Option<u64>,
    /// Whether the drivers know of it: behind a server the bus opens later than the connection.
    is_connected: bool,
    /// A driver asked for a new connection: what still arrives on this one is not decoded.
    distrusted: bool,
    figures: LinkFigures,
    last_error: Option<String>,
    /// What came on this connection while no device was known to be there.
    heard: Heard,
    /// How often bytes were discarded.
    discarded_runs: u64,
    /// Newest time that the drivers were given.
    given: Nanos,
}

struct Device {
    name: String,
    driver: Box<dyn Driver>,
    online: bool,
    ready: bool,
    readings: u64,
    last_reading: Option<Nanos>,
    flagged: BTreeMap<&'static str, u64>,
    faults: BTreeMap<&'static str, u64>,
    channels: Vec<Running>,
}

/// Smallest, mean and largest of a channel, as it runs.
#[derive(Clone, Copy)]
struct Running {
    min: f64,
    max: f64,
    sum: f64,
    count: u64,
}

/// Action that a line wants.
#[derive(Debug, PartialEq)]
pub(crate) enum Effect {
    /// Send these bytes on connection `epoch`.
    Send { epoch: u64, bytes: Vec<u8> },
    /// The connection proved good.
    Confirm,
    /// Close connection `epoch` and open a new one.
    Reopen { epoch: u64 },
    /// A device of this line is set up.
    Ready { device: usize },
    /// A device of this line gave a reading.
    Reading { device: usize, reading: Reading },
    /// Outcome of an order to the axes of a device of this line.
    Motion { event: MotionEvent },
    /// The connection is gone: counts of the device may have run on.
    Interrupted { device: usize },
}

impl Line {
    /// A line of that name with its devices, by name.
    pub fn new(name: String, framing: Framing, devices: Vec<(String, Box<dyn Driver>)>) -> Line {
        Line {
            figures: LinkFigures {
                name: name.clone(),
                clock: framing.clock().map(str::to_owned),
                ..LinkFigures::default()
            },
            name,
            framing,
            bus: Bus::Absent,
            devices: devices
                .into_iter()
                .map(|(name, driver)| Device {
                    name,
                    channels: vec![Running::NONE; driver.channels().len()],
                    driver,
                    online: false,
                    ready: false,
                    readings: 0,
                    last_reading: None,
                    flagged: BTreeMap::new(),
                    faults: BTreeMap::new(),
                })
                .collect(),
            epoch: None,
            is_connected: false,
            distrusted: false,
            last_error: None,
            heard: Heard::default(),
            discarded_runs: 0,
            given: Nanos::ZERO,
        }
    }

    /// Name in the configuration.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// Whether what is received at once had piled up: at the rates at which host times tell anything, what arrives
    /// between two reads of a stream is far less.
    pub(crate) fn is_backlog(&self, bytes: usize) -> bool {
        match self.framing {
            Framing::Datagrams => false,
            // A profile alone has thousands of bytes.
            Framing::TwoStreams | Framing::File => bytes >= FULL_READ_BYTES,
            // A log has the times of its frames.
            Framing::Candump { .. } => false,
            Framing::Raw
            | Framing::Slcan { .. }
            | Framing::CanRecords { .. }
            | Framing::Socketcand { .. } => bytes >= BACKLOG_BYTES,
        }
    }

    fn is_raw(&self) -> bool {
        matches!(
            self.framing,
            Framing::Raw | Framing::Datagrams | Framing::TwoStreams | Framing::File
        )
    }

    pub(crate) fn is_open(&self) -> bool {
        self.epoch.is_some()
    }

    /// Whether every device has shown a valid frame on this connection.
    pub(crate) fn is_online(&self) -> bool {
        self.devices.iter().all(|device| device.online)
    }

    pub(crate) fn is_ready(&self, device: usize) -> bool {
        self.devices[device].ready
    }

    pub(crate) fn device_names(&self) -> impl Iterator<Item = &str> {
        self.devices.iter().map(|device| device.name.as_str())
    }

    pub(crate) fn readings(&self) -> u64 {
        self.devices.iter().map(|device| device.readings).sum()
    }

    /// The device that has been silent longest decides.
    pub(crate) fn last_reading(&self) -> Option<Nanos> {
        self.devices.iter().map(|device| device.last_reading).min().flatten()
    }

    /// Bytes received and how often it was opened and lost.
    pub(crate) fn traffic(&self) -> &LinkFigures {
        &self.figures
    }

    pub(crate) fn last_error(&self) -> Option<&str> {
        self.last_error.as_deref()
    }

    /// Faults, flagged readings and runs of discarded bytes.
    pub(crate) fn errors(&self) -> u64 {
        let devices = self.devices.iter().map(|device| {
            device.faults.values().sum::<u64>() + device.flagged.values().sum::<u64>()
        });
        devices.sum::<u64>() + self.discarded_runs
    }

    /// Readings delivered so far; channels listed in `coordinates` (device, channel) are left out of the
    /// channel figures. What the synchronizer knows is filled in by the caller.
    pub(crate) fn figures(&self, coordinates: &[(usize, usize)]) -> LinkFigures {
        let mut figures = self.figures.clone();
        figures.devices = self
            .devices
            .iter()
            .enumerate()
            .map(|(index, device)| DeviceFigures {
                name: device.name.clone(),
                readings: device.readings,
                flagged: owned(&device.flagged),
                faults: owned(&device.faults),
                channels: device
                    .driver
                    .channels()
                    .iter()
                    .zip(&device.channels)
                    .enumerate()
                    .filter(|(channel, _)| !coordinates.contains(&(index, *channel)))
                    .filter_map(|(_, (channel, running))| {
                        Some((channel.name.clone(), running.figures(channel.unit.symbol())?))
                    })
                    .collect(),
                ..DeviceFigures::default()
            })
            .collect();
        figures
    }

    pub(crate) fn opened(&mut self, now: Nanos, epoch: u64, out: &mut Vec<Effect>) {
        self.epoch = Some(epoch);
        self.distrusted = false;
        self.figures.opened += 1;
        self.given = now;
        self.heard = Heard::default();
        let reads_fd = self.devices.iter().any(|device| device.driver.reads_fd());
        let (bus, first) = Bus::opened(&self.framing, reads_fd, now);
        self.bus = bus;
        if !first.is_empty() {
            out.push(Effect::Send { epoch, bytes: first });
        }
        if self.bus.is_open() {
            self.connect(now, out);
        }
    }

    fn connect(&mut self, now: Nanos, out: &mut Vec<Effect>) {
        self.is_connected = true;
        self.devices.iter_mut().for_each(|device| device.driver.connected(now));
        self.pump(out);
    }

    pub(crate) fn closed(&mut self, now: Nanos, reason: String, out: &mut Vec<Effect>) {
        self.figures.closed += 1;
        let discarded_before = self.figures.discarded_bytes;
        // Where a driver asked for a new connection, what it said then tells more than that this one closed.
        if !self.distrusted {
            self.last_error = Some(match self.bus.summary() {
                Some(summary) => format!("{reason}: {summary}"),
                None => reason,
            });
        }
        self.figures.discarded_bytes += self.bus.pending();
        self.bus = Bus::Absent;
        if std::mem::take(&mut self.is_connected) {
            self.devices.iter_mut().for_each(|device| device.driver.disconnected(now));
            // What they held back of the lost connection is told now.
            self.pump(out);
            self.interrupt(out);
        }
        let half = self.figures.discarded_bytes - discarded_before;
        if self.framing == Framing::File && half > 0 {
            let reason = self.last_error.take().unwrap_or_default();
            self.last_error = Some(format!(
                "{reason}; its last {half} bytes are no whole record: let the program end its last line, or write whole records"
            ));
        }
        self.epoch = None;
    }

    pub(crate) fn open_failed(&mut self, reason: String) {
        self.last_error = Some(reason);
    }

    pub(crate) fn received(&mut self, now: Nanos, bytes: &[u8], out: &mut Vec<Effect>) {
        self.figures.received_bytes += bytes.len() as u64;
        if self.epoch.is_none() || self.distrusted {
            self.figures.discarded_bytes += bytes.len() as u64;
            return;
        }
        // An adapter answers whatever the bus does.
        if self.is_raw() && !self.devices.iter().any(|device| device.online) {
            self.heard.take(bytes);
        }
        match self.framing {
            Framing::Raw | Framing::Datagrams | Framing::File => {
                for device in &mut self.devices {
                    device.driver.receive(now, Input::Bytes(bytes));
                }
                self.pump(out);
            }
            Framing::TwoStreams => match Input::of_chunk(bytes) {
                Some(input) => {
                    for device in &mut self.devices {
                        device.driver.receive(now, input);
                    }
                    self.pump(out);
                }
                None => self.figures.discarded_bytes += bytes.len() as u64,
            },
            Framing::Slcan { .. }
            | Framing::CanRecords { .. }
            | Framing::Candump { .. }
            | Framing::Socketcand { .. } => self.received_of_bus(now, bytes, out),
        }
    }

    fn received_of_bus(&mut self, now: Nanos, bytes: &[u8], out: &mut Vec<Effect>) {
        let mut rest = bytes;
        while let Some(piece) = self.bus.receive(now, &mut rest) {
            match piece {
                Piece::Frame(frame, stamped) => {
                    // Drivers get times in order, whatever an adapter says.
                    let at = stamped.map_or(now, |at| at.clamp(self.given.min(now), now));
                    self.given = at;
                    self.frame(at, &frame, out);
                }
                Piece::Discarded { bytes, why } => {
                    self.figures.discarded_bytes += bytes;
                    self.discarded_runs += 1;
                    if why.is_none() && !self.devices.iter().any(|device| device.online) {
                        self.heard.discard(bytes);
                    }
                    self.last_error = why.or(self.last_error.take());
                }
                Piece::Trouble(words) => self.last_error = Some(words),
                Piece::Send(bytes) => {
                    out.extend(self.epoch.map(|epoch| Effect::Send { epoch, bytes }));
                }
                Piece::Open => self.connect(now, out),
                Piece::Failed(words) => self.fail(words, out),
            }
        }
        // An adapter may refuse on one connection and stamp on the next, as after an update.
        if let Some(is_stamped) = self.bus.is_stamped()
            && self.figures.clock.is_some() != is_stamped
        {
            let clock = self.framing.clock().filter(|_| is_stamped);
            self.figures.clock = clock.map(str::to_owned);
        }
    }

    /// Nothing more can be had of this connection: a new one is asked for.
    fn fail(&mut self, reason: String, out: &mut Vec<Effect>) {
        self.last_error = Some(reason);
        out.extend(self.epoch.map(|epoch| Effect::Reopen { epoch }));
        self.interrupt(out);
        self.distrusted = true;
    }

    /// Commands every device of the line but one.
    pub(crate) fn command(
        &mut self,
        now: Nanos,
        command: Command,
        except: Option<usize>,
        out: &mut Vec<Effect>,
    ) {
        let devices = self.devices.iter_mut().enumerate();
        for (_, device) in devices.filter(|(index, _)| Some(*index) != except) {
            self.given = now;
            device.driver.command(now, command);
        }
        self.pump(out);
    }

    /// Commands one device of the line.
    pub(crate) fn command_device(
        &mut self,
        now: Nanos,
        device: usize,
        command: Command,
        out: &mut Vec<Effect>,
    ) {
        self.given = now;
        self.devices[device].driver.command(now, command);
        self.pump(out);
    }

    /// Moves or halts axes of one device of the line.
    pub(crate) fn motion(
        &mut self,
        now: Nanos,
        device: usize,
        motion: &Motion,
        out: &mut Vec<Effect>,
    ) -> Result<(), MotionFailure> {
        self.given = now;
        let result = self.devices[device].driver.motion(now, motion);
        self.pump(out);
        result
    }

    /// The open connection, and bytes that halt every axis on it; `None` where the link is closed or has no axes.
    pub(crate) fn halt_bytes(&self) -> Option<(u64, Vec<u8>)> {
        let drivers = self.devices.iter().map(|device| &device.driver);
        let mut bytes: Vec<u8> =
            drivers.clone().filter_map(|driver| driver.halt_bytes()).flatten().collect();
        for frame in drivers.flat_map(|driver| driver.halt_frames()) {
            self.bus.encode(&frame, &mut bytes);
        }
        self.epoch.filter(|_| !bytes.is_empty()).map(|epoch| (epoch, bytes))
    }

    pub(crate) fn poll_timeout(&self) -> Option<Nanos> {
        if self.epoch.is_none() || self.distrusted {
            return None;
        }
        let devices = self.devices.iter().filter(|_| self.is_connected);
        devices
            .filter_map(|device| device.driver.poll_timeout())
            .chain(self.bus.poll_timeout())
            .min()
    }

    pub(crate) fn timeout(&mut self, now: Nanos, out: &mut Vec<Effect>) {
        if let Some(reason) = self.bus.timeout(now) {
            return self.fail(reason, out);
        }
        for device in self.devices.iter_mut().filter(|_| self.is_connected) {
            if device.driver.poll_timeout().is_some_and(|due| due <= now) {
                self.given = now;
                device.driver.timeout(now);
            }
        }
        self.pump(out);
    }

    fn frame(&mut self, now: Nanos, frame: &CanFrame, out: &mut Vec<Effect>) {
        if self.distrusted {
            return;
        }
        let is_fd = frame.fd().is_some();
        for device in self.devices.iter_mut().filter(|device| !is_fd || device.driver.reads_fd()) {
            device.driver.receive(now, Input::Frame(frame));
        }
        self.pump(out);
    }

    /// Why a device cannot be used, and what came instead of its telegrams.
    fn with_heard(&self, reason: &str) -> String {
        let is_known = self.devices.iter().any(|device| device.online);
        match self.heard.words().filter(|_| !is_known) {
            Some(words) => format!("{reason} ({words})"),
            None => reason.to_owned(),
        }
    }

    /// Nothing that comes on this connection counts any more.
    fn interrupt(&mut self, out: &mut Vec<Effect>) {
        if self.distrusted {
            return;
        }
        for (index, device) in self.devices.iter_mut().enumerate() {
            device.online = false;
            device.ready = false;
            out.push(Effect::Interrupted { device: index });
        }
    }

    /// Takes what the drivers have to send and to tell.
    fn pump(&mut self, out: &mut Vec<Effect>) {
        let Some(epoch) = self.epoch else { return };
        let mut sent = Vec::new();
        let (mut failed, mut reopen) = (None, None);
        for (index, device) in self.devices.iter_mut().enumerate() {
            while let Some(output) = device.driver.poll_transmit() {
                match output {
                    Output::Bytes(bytes) => sent.extend(bytes),
                    Output::Frame(frame) => self.bus.encode(&frame, &mut sent),
                }
            }
            while let Some(event) = device.driver.poll_event() {
                match event {
                    Event::Online => {
                        device.online = true;
                        out.push(Effect::Confirm);
                    }
                    Event::Ready => {
                        device.ready = true;
                        out.push(Effect::Ready { device: index });
                    }
                    Event::Reading(reading) => {
                        device.note(&reading);
                        out.push(Effect::Reading { device: index, reading });
                    }
                    Event::Discarded { bytes } => {
                        self.figures.discarded_bytes += bytes;
                        self.discarded_runs += 1;
                    }
                    Event::Fault(fault) => failed = Some(device.fault(&fault)),
                    Event::Motion(event) => {
                        if let MotionEvent::Failed(failure) = &event {
                            failed = Some(device.fault(&failure.into()));
                        }
                        out.push(Effect::Motion { event });
                    }
                    Event::Reopen(fault) => reopen = Some(device.fault(&fault)),
                }
            }
        }
        if !sent.is_empty() {
            out.push(Effect::Send { epoch, bytes: sent });
        }
        if let Some(reason) = reopen.as_ref().or(failed.as_ref()) {
            self.last_error = Some(self.with_heard(reason));
        }
        if reopen.is_some() {
            out.push(Effect::Reopen { epoch });
            self.interrupt(out);
            self.distrusted = true;
        }
    }
}

impl Device {
    fn note(&mut self, reading: &Reading) {
        self.readings += 1;
        self.last_reading = Some(reading.host);
        if reading.flags != Flags::empty() {
            for name in reading.flags.names() {
                *self.flagged.entry(name).or_default() += 1;
            }
        }
        for (running, value) in self.channels.iter_mut().zip(reading.values.iter()) {
            if let Some(value) = value {
                running.take(value);
            }
        }
    }

    fn fault(&mut self, fault: &Fault) -> String {
        *self.faults.entry(fault.kind.name()).or_default() += 1;
        format!("{}: {}", self.name, fault.detail)
    }
}

impl Running {
    const NONE: Running =
        Running { min: f64::INFINITY, max: f64::NEG_INFINITY, sum: 0.0, count: 0 };

    fn take(&mut self, value: f64) {
        self.min = self.min.min(value);
        self.max = self.max.max(value);
        self.sum += value;
        self.count += 1;
    }

    fn figures(&self, unit: &str) -> Option<ChannelFigures> {
        (self.count > 0).then(|| ChannelFigures {
            unit: unit.to_owned(),
            min: self.min,
            mean: self.sum / self.count as f64,
            max: self.max,
            count: self.count,
        })
    }
}

/// One read of a stream of so much means that bytes had piled up.
const BACKLOG_BYTES: usize = 2048;

/// As much as a link reads at once.
const FULL_READ_BYTES: usize = 16 * 1024;

fn owned(counts: &BTreeMap<&'static str, u64>) -> BTreeMap<String, u64> {
    counts.iter().map(|(name, count)| ((*name).to_owned(), *count)).collect()
}

#[cfg(test)]
mod tests;
