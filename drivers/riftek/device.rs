//! The sensor as a state machine.

use std::collections::VecDeque;

use asphera_link::{
    Asking, AskingStep, Channel, Command, Driver, Event, Events, FaultKind, Flags, Input, Nanos,
    Output, Pace, Problem, Reading, Unanswered, Values, millis,
};

use crate::settings::{Mode, Settings};
use crate::wire::{Answer, Decoder, FULL_RANGE, Identity, LONGEST, Request};

/// Silence that shows that a stream has stopped, in ms: some bytes at 2400 Bd.
const QUIET_MS: u32 = 50;

/// Longest time a stream may go on after it was stopped, in ms.
const STOP_MS: u32 = 2000;

/// How often the sensor is asked who it is.
const ATTEMPTS: u8 = 2;

/// Silence after which an answer is known to be no longer than it should, in ms.
pub(crate) const HELD_MS: u32 = 20;

/// Bytes of a result.
const RESULT: usize = 2;

/// An RF60x sensor.
///
/// ```text
///        connected: stop        silence: who?           it is the right one
/// Closed ─────────▶ Quieting ───────────▶ Greeting ───────────▶ Streaming, or Polling
/// ```
///
/// A stream that still runs from before is stopped first, so that its results are not taken for the identity.
/// A result is held back until something else follows it, or the line is silent: a byte of noise before an answer looks
/// like its begin, and only the byte too many at its end shows it.
/// A sensor that is polled is asked by the rules of [`Asking`].
#[derive(Debug)]
pub struct Riftek {
    settings: Settings,
    channels: Vec<Channel>,
    decoder: Decoder,
    state: State,
    asking: Asking,
    last_answer: Nanos,
    /// The answer before came after others that were lost; the first of a run is worth a message.
    in_gap: bool,
    /// Bytes that came unasked.
    stray: u64,
    /// The newest reading, and when nothing more can belong to its answer.
    held: Option<(Reading, Nanos)>,
    outputs: VecDeque<Vec<u8>>,
    events: Events,
    tally: Tally,
}

/// What happened since the driver was made.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Tally {
    /// Readings given.
    pub readings: u64,
    /// Answers with a result that the sensor had sent before.
    pub repeated: u64,
    /// Results of a stream that were lost; those of whole rounds of the counter are missing here.
    pub lost: u64,
    /// Questions without an answer in time.
    pub timeouts: u64,
    /// Due times passed over because another question was under way.
    pub missed: u64,
    /// Bytes passed over.
    pub discarded_bytes: u64,
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum State {
    /// No connection, or none to be trusted.
    Closed,
    /// Waits for the end of a stream from before.
    Quieting { until: Nanos, latest: Nanos },
    /// Asked who is there.
    Greeting { deadline: Nanos, attempt: u8 },
    /// The sensor sends by itself.
    Streaming,
    /// The sensor is asked.
    Polling,
}

impl Riftek {
    /// A driver for the sensor.
    ///
    /// # Errors
    ///
    /// [`Settings::problems`], when there are any.
    pub fn new(settings: Settings) -> Result<Riftek, Vec<Problem>> {
        let problems = settings.problems();
        if !problems.is_empty() {
            return Err(problems);
        }
        Ok(Riftek {
            channels: settings.channels(),
            decoder: Decoder::new(LONGEST),
            state: State::Closed,
            asking: Asking::new(pace(&settings)),
            last_answer: Nanos::ZERO,
            in_gap: false,
            stray: 0,
            held: None,
            outputs: VecDeque::new(),
            events: Events::default(),
            tally: Tally::default(),
            settings,
        })
    }

    /// What happened since the driver was made.
    pub fn tally(&self) -> Tally {
        self.tally
    }

    fn send(&mut self, request: Request) {
        self.outputs.push_back(request.encode(self.settings.address).to_vec());
    }

    fn greet(&mut self, now: Nanos, attempt: u8) {
        self.send(Request::Identify);
        self.decoder.reset(LONGEST);
        let deadline = now + millis(self.settings.timeout_ms);
        self.state = State::Greeting { deadline, attempt };
    }

    fn identified(&mut self, now: Nanos, identity: Identity) {
        let Settings { range_mm, serial, mode, .. } = self.settings;
        if identity.range_mm != range_mm {
            let found = identity.range_mm;
            self.abandon(
                FaultKind::Protocol,
                format!(
                    "the sensor has a measuring range of {found} mm, expected {range_mm} mm: set range_mm, or connect the right sensor"
                ),
            );
            return;
        }
        if let Some(serial) = serial.filter(|serial| *serial != identity.serial) {
            let found = identity.serial;
            let detail = format!(
                "the sensor has the serial number {found}, expected {serial}: set serial, or connect the right sensor"
            );
            self.abandon(FaultKind::Protocol, detail);
            return;
        }
        self.events.prove_online();
        self.decoder.reset(RESULT);
        self.last_answer = now;
        match mode {
            Mode::Stream { .. } => {
                self.send(Request::StartStream);
                self.state = State::Streaming;
            }
            Mode::Poll { .. } => {
                self.asking.restart(now);
                self.state = State::Polling;
                self.ask();
            }
        }
    }

    /// Sends the question that is under way now.
    fn ask(&mut self) {
        self.release(Flags::empty());
        self.send(Request::Result);
        self.decoder.reset(RESULT);
    }

    fn wait(&mut self, now: Nanos) {
        self.tally.missed += self.asking.wait(now);
    }

    fn byte(&mut self, now: Nanos, byte: u8) {
        match self.state {
            State::Closed => {
                self.stray += 1;
                self.release(Flags::SUSPECT);
            }
            State::Quieting { latest, .. } => {
                self.stray += 1;
                self.state = State::Quieting { until: now + millis(QUIET_MS), latest };
            }
            State::Greeting { .. } => {
                let answer = self.decoder.push(byte);
                if let Some(identity) = answer.and_then(|answer| answer.identity()) {
                    self.identified(now, identity);
                }
            }
            State::Polling => self.polled_byte(now, byte),
            State::Streaming => {
                let answer = self.decoder.push(byte);
                let is_overlong = self.decoder.take_overlong();
                self.release(if is_overlong { Flags::SUSPECT } else { Flags::empty() });
                if let Some(answer) = answer {
                    self.note_lost(answer.lost);
                    self.read(now, answer);
                }
                if is_overlong {
                    let detail = "results of the stream have more than 2 bytes, or come twice: check that no other program or sensor uses the line".to_owned();
                    self.abandon(FaultKind::Protocol, detail);
                }
            }
        }
    }

    fn polled_byte(&mut self, now: Nanos, byte: u8) {
        match self.asking.step() {
            AskingStep::Asking { .. } => {
                if let Some(answer) = self.decoder.push(byte) {
                    self.asking.answered();
                    self.read(now, answer);
                    self.wait(now);
                }
            }
            AskingStep::Settling { .. } => {
                self.stray += 1;
                self.asking.disturbed(now);
            }
            AskingStep::Off | AskingStep::Idle { .. } => {
                self.stray += 1;
                self.release(Flags::SUSPECT);
            }
        }
    }

    fn note_lost(&mut self, lost: u8) {
        self.tally.lost += u64::from(lost);
        let was_in_gap = std::mem::replace(&mut self.in_gap, lost > 0);
        if lost > 0 && !was_in_gap {
            let detail = format!(
                "{lost} or more results of the stream were lost on the line: check cable and baud rate"
            );
            self.events.fault(FaultKind::Protocol, detail);
        }
    }

    fn read(&mut self, now: Nanos, answer: Answer) {
        let Some(result) = answer.result() else { return };
        if !answer.is_clean && !answer.is_new {
            // Noise that looks like an answer without a result of its own.
            self.stray += 2 * RESULT as u64;
            return;
        }
        if answer.is_clean {
            self.last_answer = now;
        }
        if answer.is_new {
            // Noise right behind an answer does not go on counting, but for one time in four.
            let is_in_step = answer.is_clean && answer.lost == 0;
            let flags = if is_in_step { Flags::empty() } else { Flags::SUSPECT };
            let reading = self.reading(now, result, flags);
            self.held = Some((reading, now + millis(HELD_MS)));
        } else {
            self.tally.repeated += 1;
        }
        if answer.is_clean {
            self.events.prove_ready();
        }
    }

    /// X = D · S / 16384 (RF602 manual, page 15, equation 1).
    fn reading(&self, host: Nanos, result: u16, flags: Flags) -> Reading {
        // At the ends of the range nobody knows whether the sensor sees the target or only its limit.
        let flags = flags
            | match result {
                0 | FULL_RANGE => Flags::OUT_OF_RANGE,
                1..FULL_RANGE => Flags::empty(),
                _ => Flags::SUSPECT,
            };
        let mm = f64::from(result) * f64::from(self.settings.range_mm) / f64::from(FULL_RANGE);
        let mut values = Values::new();
        values.push(flags.is_empty().then_some(mm));
        Reading { host, device_time_ns: None, count: None, values, flags }
    }

    /// Gives the reading that was held back.
    fn release(&mut self, doubt: Flags) {
        let Some((mut reading, _)) = self.held.take() else { return };
        if !doubt.is_empty() {
            reading.flags |= doubt;
            reading.values = Values::from_iter([None]);
        }
        self.tally.readings += 1;
        self.events.push(Event::Reading(reading));
    }

    fn unanswered(&mut self, now: Nanos) {
        self.tally.timeouts += 1;
        let timeout_ms = self.settings.timeout_ms;
        let detail = format!(
            "no answer to the question for a result within {timeout_ms} ms: check cable and power, or increase timeout_ms"
        );
        match self.asking.unanswered(now) {
            Unanswered::GiveUp => self.abandon(FaultKind::Timeout, detail),
            Unanswered::Settle => {
                self.events.fault(FaultKind::Timeout, detail);
                self.decoder.reset(RESULT);
            }
        }
    }

    fn ungreeted(&mut self, now: Nanos, attempt: u8) {
        self.tally.timeouts += 1;
        if attempt < ATTEMPTS {
            self.greet(now, attempt + 1);
            return;
        }
        let Settings { address, timeout_ms, .. } = self.settings;
        let detail = format!(
            "address {address} does not say who it is within {timeout_ms} ms, asked {ATTEMPTS} times: check baud rate, even parity, address, and that the sensor speaks the RIFTEK protocol"
        );
        self.abandon(FaultKind::Timeout, detail);
    }

    /// When the state has something to do.
    fn state_due(&self) -> Option<Nanos> {
        match self.state {
            State::Closed => None,
            State::Quieting { until, latest } => Some(until.min(latest)),
            State::Greeting { deadline, .. } => Some(deadline),
            State::Streaming => match self.settings.mode {
                Mode::Stream { silence_ms: 0 } | Mode::Poll { .. } => None,
                Mode::Stream { silence_ms } => Some(self.last_answer + millis(silence_ms)),
            },
            State::Polling => self.asking.due(),
        }
    }

    fn abandon(&mut self, kind: FaultKind, detail: String) {
        self.release(Flags::empty());
        self.outputs.clear();
        self.decoder.reset(RESULT);
        self.asking.stop();
        self.events.reopen(kind, detail);
        self.state = State::Closed;
    }

    fn report_discarded(&mut self) {
        let bytes = std::mem::take(&mut self.stray) + self.decoder.take_discarded();
        self.tally.discarded_bytes += bytes;
        self.events.discarded(bytes);
    }
}

impl Driver for Riftek {
    fn channels(&self) -> &[Channel] {
        &self.channels
    }

    fn connected(&mut self, now: Nanos) {
        self.decoder = Decoder::new(LONGEST);
        self.events.restart();
        self.asking.stop();
        (self.in_gap, self.stray, self.held) = (false, 0, None);
        self.outputs.clear();
        self.send(Request::StopStream);
        let latest = now + millis(STOP_MS);
        self.state = State::Quieting { until: now + millis(QUIET_MS), latest };
    }

    fn disconnected(&mut self, _: Nanos) {
        self.release(Flags::empty());
        self.decoder.reset(RESULT);
        self.report_discarded();
        self.outputs.clear();
        self.asking.stop();
        self.state = State::Closed;
    }

    fn receive(&mut self, now: Nanos, input: Input<'_>) {
        let Input::Bytes(bytes) = input else { return };
        for byte in bytes {
            self.byte(now, *byte);
        }
        self.report_discarded();
    }

    fn timeout(&mut self, now: Nanos) {
        if self.held.as_ref().is_some_and(|(_, until)| *until <= now) {
            self.release(Flags::empty());
        }
        if self.state_due().is_none_or(|due| now < due) {
            return;
        }
        match self.state {
            State::Closed => {}
            State::Quieting { latest, .. } if now >= latest => {
                let detail = "a stream goes on after it was stopped: check that no other program or sensor uses the line".to_owned();
                self.abandon(FaultKind::Protocol, detail);
            }
            State::Quieting { .. } => self.greet(now, 1),
            State::Greeting { attempt, .. } => self.ungreeted(now, attempt),
            State::Streaming => {
                self.tally.timeouts += 1;
                let silence = now.since(self.last_answer).as_millis();
                self.abandon(
                    FaultKind::Timeout,
                    format!(
                        "no result of the stream for {silence} ms: check cable, power and laser"
                    ),
                );
            }
            State::Polling => match self.asking.step() {
                AskingStep::Off => {}
                AskingStep::Idle { .. } => {
                    self.asking.ask_due(now);
                    self.ask();
                }
                AskingStep::Asking { .. } => self.unanswered(now),
                AskingStep::Settling { .. } => self.wait(now),
            },
        }
        self.report_discarded();
    }

    fn poll_timeout(&self) -> Option<Nanos> {
        let held_until = self.held.as_ref().map(|(_, until)| *until);
        self.state_due().into_iter().chain(held_until).min()
    }

    fn poll_transmit(&mut self) -> Option<Output> {
        self.outputs.pop_front().map(Output::Bytes)
    }

    fn poll_event(&mut self) -> Option<Event> {
        self.events.pop()
    }

    fn command(&mut self, _: Nanos, _: Command) {}
}

fn pace(settings: &Settings) -> Pace {
    let Settings { mode, timeout_ms, late_limit_ms, .. } = *settings;
    let interval_ms = match mode {
        Mode::Poll { interval_ms } => interval_ms,
        Mode::Stream { .. } => 0,
    };
    Pace { interval_ms, timeout_ms, late_limit_ms }
}
