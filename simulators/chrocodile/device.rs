//! The instrument as a state machine: bytes and exposures in, bytes out.

use std::collections::VecDeque;

use asphera_chrocodile::wire::{Layout, MAX_SIGNALS, NOT_VALID, READY, Request, SYNC};
use rand_core::{Rng, SeedableRng};
use rand_pcg::Pcg64Mcg;

use crate::Sample;

/// Signals of a new connection (Command Reference, command SODX).
const DEFAULT_SIGNALS: [u16; 2] = [256, 257];

/// Samples held while a command interrupts the data; what comes on top is dropped and counted.
const HELD_SAMPLES: usize = 4096;

/// Longest command line; a longer one is answered as unknown.
const MAX_LINE_LEN: usize = 512;

/// What starts an exposure.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TriggerMode {
    /// The device's own clock (`CTN`).
    Free,
    /// Each trigger (`TRE`).
    Each,
}

/// A CHRocodile 2 with one channel, as far as the dollar protocol shows it.
///
/// Answers are formed as the manuals print them: CR after the echo of a setting, none after that of
/// a question. What no manual says is chosen here: a new connection streams in ASCII at 1000 Hz; an
/// error is answered on a line of its own between the echo and `ready`.
#[derive(Debug)]
pub struct Device {
    full_scale_um: f64,
    settings: Settings,
    /// The command line being received, without its CR.
    line: Option<Vec<u8>>,
    held: VecDeque<Sample>,
    output: Vec<u8>,
    dropped: u64,
    drop_next: bool,
    corrupt_next: bool,
    noise_next: Option<Vec<u8>>,
    noise_place: u64,
}

#[derive(Debug)]
struct Settings {
    signals: Vec<u16>,
    layout: Layout,
    is_binary: bool,
    is_started: bool,
    is_started_by_host: bool,
    trigger: TriggerMode,
    sample_rate_hz: f64,
    averaging: u16,
    encoder: [i32; 5],
}

/// Why a command was not carried out.
struct NotValid;

impl Settings {
    fn new() -> Settings {
        Settings {
            signals: DEFAULT_SIGNALS.into(),
            layout: Layout::new(SYNC, &DEFAULT_SIGNALS).expect("the default signals are supported"),
            is_binary: false,
            is_started: true,
            is_started_by_host: false,
            trigger: TriggerMode::Free,
            sample_rate_hz: 1000.0,
            averaging: 1,
            encoder: [0; 5],
        }
    }
}

impl Device {
    /// A device with a probe of this full scale in µm, positive and finite.
    pub fn new(full_scale_um: f64) -> Device {
        Device {
            full_scale_um,
            settings: Settings::new(),
            line: None,
            held: VecDeque::new(),
            output: Vec::new(),
            dropped: 0,
            drop_next: false,
            corrupt_next: false,
            noise_next: None,
            noise_place: 0,
        }
    }

    /// A new connection, or the power coming back: every setting is forgotten.
    pub fn restart(&mut self) {
        *self = Device { dropped: self.dropped, ..Device::new(self.full_scale_um) };
    }

    /// Takes bytes from the host.
    pub fn receive(&mut self, bytes: &[u8]) {
        for &byte in bytes {
            self.receive_byte(byte);
        }
    }

    /// Everything to send, in order.
    pub fn transmit(&mut self) -> Vec<u8> {
        std::mem::take(&mut self.output)
    }

    /// One exposure. Its telegram follows those before it, after a command's answer if one is being
    /// given; it is dropped and counted while the data are stopped.
    pub fn trigger(&mut self, sample: Sample) {
        if self.line.is_none() {
            self.send(sample);
        } else if self.held.len() < HELD_SAMPLES {
            self.held.push_back(sample);
        } else {
            self.dropped += 1;
        }
    }

    /// An exposure that no host could hear of.
    pub(crate) const fn lose_exposure(&mut self) {
        self.dropped += 1;
    }

    /// Whether the host has started the data on this connection: it waits for exposures. A host
    /// that merely finds the device streaming does not.
    pub fn armed(&self) -> bool {
        self.settings.is_started_by_host
    }

    /// What starts an exposure, as the host has chosen.
    pub fn trigger_mode(&self) -> TriggerMode {
        self.settings.trigger
    }

    /// Exposures per second, as the host has chosen.
    pub fn sample_rate_hz(&self) -> f64 {
        self.settings.sample_rate_hz
    }

    /// Exposures that were not sent since the device was made, faults included.
    pub fn dropped(&self) -> u64 {
        self.dropped
    }

    /// The next telegram is lost.
    pub fn drop_next(&mut self) {
        self.drop_next = true;
    }

    /// Every bit of the next telegram is inverted, so that its sync is gone, too.
    pub fn corrupt_next(&mut self) {
        self.corrupt_next = true;
    }

    /// Random bytes are sent, from a random place of the next telegram on; before and behind it
    /// counts as well. The same seed gives the same bytes at the same place.
    pub fn inject(&mut self, len: usize, seed: u64) {
        let mut rng = Pcg64Mcg::seed_from_u64(seed);
        let mut noise = vec![0; len];
        rng.fill_bytes(&mut noise);
        self.noise_place = rng.next_u64();
        self.noise_next = Some(noise);
    }

    fn receive_byte(&mut self, byte: u8) {
        if byte == b'$' {
            self.line = Some(Vec::new());
        }
        let Some(line) = &mut self.line else { return };
        if byte != b'\r' {
            line.push(byte);
            self.output.push(byte);
            return;
        }
        let line = self.line.take().unwrap_or_default();
        let request = Request::parse(&line).filter(|_| line.len() <= MAX_LINE_LEN);
        let answer = match &request {
            Some(request) if request.is_question() => {
                self.ask(request).map(|text| format!(" {text}"))
            }
            Some(request) => self.set(request).map(|text| format!("\r{text}")),
            None => Err(NotValid),
        };
        let text = answer.unwrap_or_else(|NotValid| format!("\r{NOT_VALID}\r\n"));
        self.output.extend(text.into_bytes());
        self.output.extend(READY);
        while let Some(sample) = self.held.pop_front() {
            self.send(sample);
        }
    }

    fn ask(&self, request: &Request) -> Result<String, NotValid> {
        let settings = &self.settings;
        let join =
            |numbers: &mut dyn Iterator<Item = String>| numbers.collect::<Vec<_>>().join(" ");
        Ok(match request.name.as_str() {
            "SCA" => self.full_scale_um.to_string(),
            "SHZ" => settings.sample_rate_hz.to_string(),
            "AVD" => settings.averaging.to_string(),
            "SODX" => join(&mut settings.signals.iter().map(ToString::to_string)),
            "ENC" => join(&mut settings.encoder.iter().map(ToString::to_string)),
            "DTF" => self.data_format(),
            "IDE" => "CHRocodile 2 simulated".into(),
            "VER" => version(),
            _ => return Err(NotValid),
        })
    }

    /// Carries out a setting; gives the text that stands before `ready`, if any.
    fn set(&mut self, request: &Request) -> Result<String, NotValid> {
        let settings = &mut self.settings;
        match (request.name.as_str(), request.arguments.as_slice()) {
            ("STA" | "STO", []) => {
                settings.is_started = request.name == "STA";
                settings.is_started_by_host = settings.is_started;
            }
            ("BIN", []) => settings.is_binary = true,
            ("ASC", []) => settings.is_binary = false,
            ("CTN", []) => settings.trigger = TriggerMode::Free,
            ("TRE", []) => settings.trigger = TriggerMode::Each,
            ("SHZ", [rate]) => settings.sample_rate_hz = within(rate, 32.0, 70_000.0)?,
            ("AVD", [exposures]) => settings.averaging = within(exposures, 1.0, 9999.0)? as u16,
            ("SODX", ids) => self.select(ids)?,
            ("DTF", []) => return Ok(format!("{}\r\n", self.data_format())),
            ("IDE", []) => return Ok("CHRocodile 2 simulated\r\n".into()),
            ("VER", []) => return Ok(format!("{}\r\n", version())),
            _ => return Err(NotValid),
        }
        Ok(String::new())
    }

    fn select(&mut self, ids: &[String]) -> Result<(), NotValid> {
        let signals: Vec<u16> =
            ids.iter().map(|id| id.parse()).collect::<Result<_, _>>().map_err(|_| NotValid)?;
        if !(1..=MAX_SIGNALS).contains(&signals.len()) {
            return Err(NotValid);
        }
        self.settings.layout = Layout::new(SYNC, &signals).map_err(|_| NotValid)?;
        self.settings.signals = signals;
        Ok(())
    }

    /// Length of a telegram, then identifier, type and offset of each signal (command DTF).
    fn data_format(&self) -> String {
        let layout = &self.settings.layout;
        layout.fields().iter().fold(layout.telegram_len().to_string(), |text, (offset, signal)| {
            format!("{text} {} {} {offset}", signal.id, signal.value_type.dtf_code())
        })
    }

    fn send(&mut self, sample: Sample) {
        self.settings.encoder = sample.encoder;
        if !self.settings.is_started || std::mem::take(&mut self.drop_next) {
            self.dropped += 1;
            return;
        }
        let mut telegram = Vec::new();
        let layout = &self.settings.layout;
        if self.settings.is_binary {
            let value_of =
                |signal: &asphera_chrocodile::wire::Signal| sample.value(signal.quantity);
            layout.encode(self.full_scale_um, value_of, &mut telegram);
        } else {
            // A line starts with a space and ends with CR LF (Command Reference, ASCII mode).
            for (_, signal) in layout.fields() {
                telegram.extend(format!(" {}", sample.value(signal.quantity)).into_bytes());
            }
            telegram.extend(b"\r\n");
        }
        if std::mem::take(&mut self.corrupt_next) {
            telegram.iter_mut().for_each(|byte| *byte = !*byte);
        }
        if let Some(noise) = self.noise_next.take() {
            let place = (self.noise_place % (telegram.len() as u64 + 1)) as usize;
            telegram.splice(place..place, noise);
        }
        self.output.extend(telegram);
    }
}

fn within(text: &str, low: f64, high: f64) -> Result<f64, NotValid> {
    let number: f64 = text.parse().map_err(|_| NotValid)?;
    if (low..=high).contains(&number) { Ok(number) } else { Err(NotValid) }
}

fn version() -> String {
    format!("simulator={}", env!("CARGO_PKG_VERSION"))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn answer(device: &mut Device, command: &str) -> String {
        device.receive(command.as_bytes());
        String::from_utf8(device.transmit()).unwrap()
    }

    /// "CHRocodile C" operation manual p. 55 and 61, "CHRocodile CLS 0.2" p. 47 and 48.
    #[test]
    fn answers_as_the_manuals_print_them() {
        let mut device = Device::new(3320.0);
        assert_eq!(answer(&mut device, "$STO\r"), "$STO\rready\r\n");
        assert_eq!(answer(&mut device, "$SHZ 1000\r"), "$SHZ 1000\rready\r\n");
        assert_eq!(answer(&mut device, "$SHZ ?\r"), "$SHZ ? 1000ready\r\n");
        assert_eq!(answer(&mut device, "$SCA ?\r"), "$SCA ? 3320ready\r\n");
        assert!(answer(&mut device, "$SHZ 1\r").contains("not valid"));
        assert!(answer(&mut device, "$XYZ\r").ends_with("not valid\r\nready\r\n"));
    }

    #[test]
    fn unknown_signals_change_nothing() {
        let mut device = Device::new(3320.0);
        answer(&mut device, "$SODX 75, 16640\r");
        for wrong in ["$SODX\r", "$SODX 75 1\r", "$SODX 75 -3\r", "$SODX 70000\r"] {
            assert!(answer(&mut device, wrong).contains("not valid"), "{wrong}");
        }
        assert_eq!(answer(&mut device, "$SODX ?\r"), "$SODX ? 75 16640ready\r\n");
        assert_eq!(answer(&mut device, "$DTF ?\r"), "$DTF ? 6 75 2 2 16640 3 4ready\r\n");
    }

    #[test]
    fn a_command_holds_the_data_back() {
        let mut device = Device::new(32768.0);
        answer(&mut device, "$BIN\r$SODX 16640\r");
        let at = |distance_um| Sample { distance_um: Some(distance_um), ..Sample::default() };
        device.trigger(at(1.0));
        device.receive(b"$AVD");
        device.trigger(at(2.0));
        device.receive(b" 2\r");
        device.trigger(at(3.0));
        let sent = device.transmit();
        let expected =
            [&b"\xFF\xFF\x00\x01$AVD 2\rready\r\n"[..], b"\xFF\xFF\x00\x02", b"\xFF\xFF\x00\x03"];
        assert_eq!(sent, expected.concat());
        assert_eq!(device.dropped(), 0);
    }

    #[test]
    fn stopped_dropped_and_forgotten() {
        let mut device = Device::new(3320.0);
        device.drop_next();
        device.trigger(Sample::default());
        device.trigger(Sample::default());
        assert_eq!(device.transmit(), b" 1000 100\r\n");
        assert!(!device.armed(), "streaming, but not by this host's wish");
        answer(&mut device, "$STO\r");
        device.trigger(Sample::default());
        assert_eq!((device.transmit().len(), device.dropped()), (0, 2));
        answer(&mut device, "$STA\r");
        assert!(device.armed());
        device.restart();
        assert_eq!((device.armed(), device.dropped()), (false, 2));
    }

    #[test]
    fn without_a_peak_zeros_are_sent() {
        let mut device = Device::new(3320.0);
        device.trigger(Sample { distance_um: None, ..Sample::default() });
        assert_eq!(device.transmit(), b" 0 0\r\n");
    }
}
