//! The scanner as a state machine.

use asphera_link::{
    Channel, Command, Count, Driver, Event, Events, FaultKind, Flags, Input, Nanos, Output,
    Problem, Profile, Reading, Values, millis,
};

use crate::Settings;
use crate::order::{Arrival, Order, Placed, Stamp};
use crate::wire::{Header, Packet};

/// How many numbers the count of readings has: the measure count without its highest bit.
pub(crate) const COUNTS: u32 = 1 << 31;

/// An RF627 scanner that sends profiles.
///
/// It says nothing to the scanner. A connection is online with the first profile of the right scanner.
#[derive(Debug)]
pub struct Rf627 {
    settings: Settings,
    channels: Vec<Channel>,
    is_open: bool,
    /// Serial number of the scanner that is listened to on this connection.
    serial: Option<u32>,
    /// The datagram before was refused; the first of a run is worth a message.
    is_muddled: bool,
    last_profile: Nanos,
    order: Order<Reading>,
    placed: Vec<Placed<Reading>>,
    events: Events,
    tally: Tally,
}

/// What happened since the driver was made.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Tally {
    /// Readings given.
    pub readings: u64,
    /// Points of these readings, with and without a value.
    pub points: u64,
    /// Points without a value.
    pub empty_points: u64,
    /// Measurements missing between readings.
    pub missing: u64,
    /// Profiles that came after later ones and were put in their place.
    pub overtaken: u64,
    /// Profiles that came after they were given up.
    pub late: u64,
    /// Datagrams that came twice.
    pub repeated: u64,
    /// Datagrams that are no profile in mm of this scanner.
    pub refused: u64,
    /// Times the scanner started over.
    pub restarts: u64,
    /// Bytes passed over.
    pub discarded_bytes: u64,
}

impl Rf627 {
    /// A driver for the scanner.
    ///
    /// # Errors
    ///
    /// [`Settings::problems`], when there are any.
    pub fn new(settings: Settings) -> Result<Rf627, Vec<Problem>> {
        let problems = settings.problems();
        if !problems.is_empty() {
            return Err(problems);
        }
        Ok(Rf627 {
            channels: settings.channels(),
            is_open: false,
            serial: None,
            is_muddled: false,
            last_profile: Nanos::ZERO,
            order: new_order(&settings),
            placed: Vec::new(),
            events: Events::default(),
            tally: Tally::default(),
            settings,
        })
    }

    /// What happened since the driver was made.
    pub fn tally(&self) -> Tally {
        self.tally
    }

    fn datagram(&mut self, now: Nanos, datagram: &[u8]) {
        let packet = match Packet::decode(datagram) {
            Ok(packet) => packet,
            Err(error) => {
                self.refuse(datagram.len(), error.to_string());
                return;
            }
        };
        if let Some(detail) = self.stranger(packet.header.serial) {
            self.refuse(datagram.len(), detail);
            return;
        }
        self.is_muddled = false;
        self.discard(packet.trailing());
        self.last_profile = now;
        self.events.prove_online();
        self.events.prove_ready();
        let Header { packet_count, measure_count, time_ns, .. } = packet.header;
        let stamp = Stamp { packet: packet_count, measure: measure_count, time_ns };
        let (arrival, back) = self.order.take(now, stamp, reading(now, &packet), &mut self.placed);
        self.note(arrival, stamp, datagram.len());
        self.give_placed();
        match (arrival, back) {
            (Arrival::Late, Some(reading)) => {
                // Its number has been passed: it cannot be joined by it any more.
                let flags = reading.flags | Flags::DELAYED;
                self.give(Reading { count: None, flags, ..reading });
            }
            (Arrival::Doubled, Some(reading)) => {
                let flags = reading.flags | Flags::AMBIGUOUS_COUNT;
                self.give(Reading { count: None, flags, ..reading });
            }
            _ => {}
        }
    }

    /// Why a profile is none of the scanner that is listened to; `None` where it is.
    fn stranger(&mut self, serial: u32) -> Option<String> {
        let known = *self.serial.get_or_insert(self.settings.serial.unwrap_or(serial));
        (serial != known).then(|| {
            format!(
                "a profile of the scanner {serial}, expected {known}: set serial, or give each scanner a port of its own"
            )
        })
    }

    fn refuse(&mut self, bytes: usize, detail: String) {
        self.tally.refused += 1;
        self.discard(bytes);
        if !std::mem::replace(&mut self.is_muddled, true) {
            self.events.fault(FaultKind::Protocol, detail);
        }
    }

    /// Reports how a profile came.
    fn note(&mut self, arrival: Arrival, stamp: Stamp, bytes: usize) {
        let measure = stamp.measure;
        let (tally, kind, words) = match arrival {
            Arrival::Ahead => return,
            Arrival::Overtaken => (
                &mut self.tally.overtaken,
                FaultKind::Protocol,
                format!("profile {measure} came after later ones and was put in its place"),
            ),
            Arrival::Late => (
                &mut self.tally.late,
                FaultKind::Protocol,
                format!(
                    "profile {measure} came after it was given up: it is used without its number; increase reorder_ms"
                ),
            ),
            Arrival::Repeated => (
                &mut self.tally.repeated,
                FaultKind::Protocol,
                format!(
                    "profile {measure} came twice: the network repeats datagrams, and the copy was passed over"
                ),
            ),
            Arrival::Doubled => (
                &mut self.tally.repeated,
                FaultKind::Protocol,
                format!(
                    "two different profiles with the number {measure}: check that one scanner alone sends to this port"
                ),
            ),
            Arrival::StartedOver => (
                &mut self.tally.restarts,
                FaultKind::Device,
                format!(
                    "the scanner counts from {measure} again: it was restarted, or its counters were reset, and the zero of its steps is lost; start the scan anew"
                ),
            ),
        };
        *tally += 1;
        self.events.fault(kind, words);
        if arrival == Arrival::Repeated {
            self.discard(bytes);
        }
    }

    /// Gives the readings that are in their place.
    fn give_placed(&mut self) {
        let mut placed = std::mem::take(&mut self.placed);
        for Placed { stamp, item, missing, missing_packets } in placed.drain(..) {
            if missing > 0 {
                self.tally.missing += u64::from(missing);
                let why = match missing_packets {
                    0 => "the scanner did not send them, check its rate and trigger",
                    _ => "datagrams were lost on the way, check the network",
                };
                let measure = stamp.measure;
                let detail = format!("{missing} profiles are missing before {measure}: {why}");
                self.events.fault(FaultKind::Protocol, detail);
            }
            self.give(item);
        }
        self.placed = placed;
    }

    fn give(&mut self, reading: Reading) {
        self.tally.readings += 1;
        if let Some(profile) = reading.values.profile() {
            let points = profile.points_mm().len();
            self.tally.points += points as u64;
            self.tally.empty_points += (points - profile.valid()) as u64;
        }
        self.events.push(Event::Reading(reading));
    }

    fn discard(&mut self, bytes: usize) {
        self.tally.discarded_bytes += bytes as u64;
        self.events.discarded(bytes as u64);
    }

    /// When the scanner has been silent for too long.
    fn silent_at(&self) -> Option<Nanos> {
        let watched = self.is_open && self.events.is_online() && self.settings.silence_ms > 0;
        watched.then(|| self.last_profile + millis(self.settings.silence_ms))
    }
}

impl Driver for Rf627 {
    fn channels(&self) -> &[Channel] {
        &self.channels
    }

    fn connected(&mut self, now: Nanos) {
        self.is_open = true;
        self.events.restart();
        (self.serial, self.last_profile) = (None, now);
        self.is_muddled = false;
        self.order = new_order(&self.settings);
    }

    fn disconnected(&mut self, _: Nanos) {
        self.order.flush(&mut self.placed);
        self.give_placed();
        self.is_open = false;
    }

    fn receive(&mut self, now: Nanos, input: Input<'_>) {
        let Input::Bytes(datagram) = input else { return };
        if self.is_open {
            self.datagram(now, datagram);
        } else {
            self.discard(datagram.len());
        }
    }

    fn timeout(&mut self, now: Nanos) {
        let is_silent = self.silent_at().is_some_and(|due| due <= now);
        if is_silent {
            self.order.flush(&mut self.placed);
        } else {
            self.order.expire(now, &mut self.placed);
        }
        self.give_placed();
        if is_silent {
            let silence = now.since(self.last_profile).as_millis();
            let detail = format!(
                "no profile for {silence} ms: check cable, power, laser, trigger, and that the stream goes to this host"
            );
            self.is_open = false;
            self.events.reopen(FaultKind::Timeout, detail);
        }
    }

    fn poll_timeout(&self) -> Option<Nanos> {
        self.order.due().into_iter().chain(self.silent_at()).min()
    }

    fn poll_transmit(&mut self) -> Option<Output> {
        None
    }

    fn poll_event(&mut self) -> Option<Event> {
        self.events.pop()
    }

    fn command(&mut self, _: Nanos, _: Command) {}
}

fn reading(host: Nanos, packet: &Packet<'_>) -> Reading {
    let header = packet.header;
    let profile: Profile = packet.points_mm().collect();
    let flags = if profile.valid() == 0 { Flags::NO_SIGNAL } else { Flags::empty() };
    // An encoder that goes back below its zero counts down from 2³²: as a signed number it goes on.
    let step = f64::from(header.step_count.cast_signed());
    let exposure_s = f64::from(header.exposure_ns) * 1e-9;
    let values = [step, exposure_s, profile.valid() as f64].map(Some);
    Reading {
        host,
        device_time_ns: Some(header.time_ns),
        count: Some(Count { raw: header.measure_count % COUNTS, first: 0, modulus: COUNTS }),
        values: Values::from_iter(values).with_profile(profile),
        flags,
    }
}

fn new_order(settings: &Settings) -> Order<Reading> {
    Order::new(millis(settings.reorder_ms))
}
