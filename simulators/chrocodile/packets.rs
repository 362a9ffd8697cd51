//! The instrument on the packet protocol as a state machine: bytes and exposures in, packets out.

use asphera_chrocodile::wire::packet::{
    Argument, CommandFlags, Data, Format, FormatSignal, HEADER_LEN, Header, Kind, MAX_LEN, Message,
    Name, NumberType,
};
use asphera_chrocodile::wire::{MAX_SIGNALS, Quantity, Signal};
use rand_core::{Rng, SeedableRng};
use rand_pcg::Pcg64Mcg;

use crate::{Exposure, Sample, TriggerMode};

/// A CHRocodile with one point or a line of them, as far as the packet protocol shows it.
///
/// Samples are gathered until something is to be sent, at most as many as a packet holds. What CR does not say is chosen
/// here: a connection is started, and sends once it has its signals; formats are counted from 1 on each connection; an
/// error is answered with a number and a text.
#[derive(Debug)]
pub struct PacketDevice {
    full_scale_um: f64,
    points: u16,
    settings: Settings,
    /// Bytes of the host that are no whole packet yet.
    input: Vec<u8>,
    /// Samples that wait for their packet, their number, and the time of the first.
    rows: Vec<u8>,
    row_count: usize,
    first_ns: u64,
    output: Vec<u8>,
    dropped: u64,
    drop_next: bool,
    corrupt_next: bool,
    noise_next: Option<Vec<u8>>,
}

#[derive(Debug)]
struct Settings {
    /// Signals of a sample; `None` until the host has chosen them.
    format: Option<Format>,
    counter: i32,
    is_started: bool,
    is_started_by_host: bool,
    trigger: TriggerMode,
    sample_rate_hz: f64,
    averaging: u16,
}

/// Why a command was not carried out.
struct NotValid;

impl PacketDevice {
    /// A device with a probe of this full scale in µm, positive and finite, and so many points, at least 1.
    pub fn new(full_scale_um: f64, points: u16) -> PacketDevice {
        PacketDevice {
            full_scale_um,
            points: points.max(1),
            settings: Settings {
                format: None,
                counter: 0,
                is_started: true,
                is_started_by_host: false,
                trigger: TriggerMode::Free,
                sample_rate_hz: 1000.0,
                averaging: 1,
            },
            input: Vec::new(),
            rows: Vec::new(),
            row_count: 0,
            first_ns: 0,
            output: Vec::new(),
            dropped: 0,
            drop_next: false,
            corrupt_next: false,
            noise_next: None,
        }
    }

    /// A new connection, or the power coming back: every setting is forgotten.
    pub fn restart(&mut self) {
        let dropped = self.dropped + self.row_count as u64;
        *self = PacketDevice { dropped, ..PacketDevice::new(self.full_scale_um, self.points) };
    }

    /// Takes bytes from the host. Bytes that are no packet are passed over one by one.
    pub fn receive(&mut self, bytes: &[u8]) {
        self.input.extend_from_slice(bytes);
        let mut at = 0;
        while let Some(header) = Header::decode(&self.input[at..]) {
            let Ok(Header { len, kind }) = header else {
                at += 1;
                continue;
            };
            let Some(packet) = self.input.get(at..at + len) else { break };
            let message = Message::decode(&packet[HEADER_LEN..]).filter(|_| kind == Kind::Command);
            at += len;
            if let Some(message) = message {
                self.answer(&message);
            }
        }
        self.input.drain(..at);
    }

    /// Everything to send, in order.
    pub fn transmit(&mut self) -> Vec<u8> {
        self.flush();
        std::mem::take(&mut self.output)
    }

    /// One exposure. It is dropped and counted while no data are sent. Points beyond those of the exposure see nothing.
    pub fn expose(&mut self, exposure: &Exposure) {
        let Some(format) = &self.settings.format else {
            self.dropped += 1;
            return;
        };
        if !self.settings.is_started || std::mem::take(&mut self.drop_next) {
            self.dropped += 1;
            return;
        }
        let sample = &exposure.sample;
        if self.row_count == 0 {
            self.first_ns = sample.start_ns;
        }
        let mut write = |signal: &FormatSignal, sample: &Sample| {
            // The format has known signals only.
            let Ok(known) = Signal::from_id(signal.id) else { return };
            let (multiplier, divisor) = known.scale(self.full_scale_um);
            let number = sample.value(known.quantity) / multiplier * divisor;
            signal.number.write(number, &mut self.rows);
        };
        let (of_points, globals): (Vec<_>, Vec<_>) =
            format.signals.iter().partition(|signal| signal.is_of_points());
        globals.iter().for_each(|signal| write(signal, sample));
        let points = of_points.first().map_or(0, |signal| usize::from(signal.points));
        for point in 0..points {
            let at_point = Sample { distance_um: exposure.distance_um(point), ..*sample };
            of_points.iter().for_each(|signal| write(signal, &at_point));
        }
        self.row_count += 1;
        let sample_len = self.rows.len() / self.row_count;
        if self.rows.len() + sample_len > MAX_LEN - 2 * HEADER_LEN {
            self.flush();
        }
    }

    /// An exposure that no host could hear of.
    pub(crate) const fn lose_exposure(&mut self) {
        self.dropped += 1;
    }

    /// Whether the host has chosen signals and started the data on this connection: it waits for exposures.
    pub fn armed(&self) -> bool {
        self.settings.is_started_by_host && self.settings.format.is_some()
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

    /// The next sample is lost.
    pub fn drop_next(&mut self) {
        self.drop_next = true;
    }

    /// Every bit of the next packet of data is inverted, so that its header is gone, too.
    pub fn corrupt_next(&mut self) {
        self.corrupt_next = true;
    }

    /// Random bytes are sent before the next packet of data. The same seed gives the same bytes.
    pub fn inject(&mut self, len: usize, seed: u64) {
        let mut noise = vec![0; len];
        Pcg64Mcg::seed_from_u64(seed).fill_bytes(&mut noise);
        self.noise_next = Some(noise);
    }

    /// Data go on with another format number, and the packet that describes it is lost.
    pub fn lose_format(&mut self) {
        self.flush();
        self.settings.counter += 1;
        if let Some(format) = &mut self.settings.format {
            format.counter = self.settings.counter;
        }
    }

    /// The probe is changed for one of this full scale in µm; the host is told by an update.
    pub fn change_probe(&mut self, full_scale_um: f64) {
        self.flush();
        self.full_scale_um = full_scale_um;
        let scale = Argument::Float(full_scale_um as f32);
        let message = Message::command(SCALE, 0, vec![scale]);
        Message { flags: CommandFlags::UPDATE, ..message }.encode(&mut self.output);
    }

    /// Sends the samples that wait.
    fn flush(&mut self) {
        let rows = std::mem::take(&mut self.row_count);
        let Some(format) = self.settings.format.as_ref().filter(|_| rows > 0) else { return };
        let time = ((u128::from(self.first_ns) << 32) / 1_000_000_000) as u64;
        let (stream, counter, mut packet) = (format.stream, format.counter, Vec::new());
        Data { stream, counter, time, rows, samples: &self.rows }.encode(&mut packet);
        self.rows.clear();
        if std::mem::take(&mut self.corrupt_next) {
            packet.iter_mut().for_each(|byte| *byte = !*byte);
        }
        self.output.extend(self.noise_next.take().into_iter().flatten());
        self.output.extend(packet);
    }

    /// Carries a command out and answers it; the answer stands behind the samples before it.
    fn answer(&mut self, message: &Message) {
        self.flush();
        let is_query = message.flags.contains(CommandFlags::QUERY);
        let outcome = if is_query { self.ask(message) } else { self.set(message) };
        let is_set = outcome.is_ok();
        let (flags, arguments) = match outcome {
            Ok(arguments) => (CommandFlags::empty(), arguments),
            Err(NotValid) => {
                let text = Argument::Text(b"not valid".to_vec());
                (CommandFlags::ERROR, vec![Argument::Int(NOT_VALID), text])
            }
        };
        let flags = flags | (message.flags & CommandFlags::QUERY);
        let answer = Message::command(message.name, message.ticket, arguments);
        Message { flags, ..answer }.encode(&mut self.output);
        if let ("SODX", false, true, Some(format)) =
            (message.name.to_string().as_str(), is_query, is_set, &self.settings.format)
        {
            format.encode(&mut self.output);
        }
    }

    fn ask(&self, message: &Message) -> Result<Vec<Argument>, NotValid> {
        let settings = &self.settings;
        let float = |value: f64| Argument::Float(value as f32);
        Ok(match message.name.to_string().as_str() {
            "SCA" => vec![float(self.full_scale_um)],
            "SHZ" => vec![float(settings.sample_rate_hz)],
            "AVD" => vec![Argument::Int(settings.averaging.into())],
            "SODX" => {
                let signals = settings.format.iter().flat_map(|format| &format.signals);
                signals.map(|signal| Argument::Int(signal.id.into())).collect()
            }
            _ => return Err(NotValid),
        })
    }

    fn set(&mut self, message: &Message) -> Result<Vec<Argument>, NotValid> {
        let name = message.name.to_string();
        let settings = &mut self.settings;
        let number = || match message.arguments.as_slice() {
            [only] => only.number().ok_or(NotValid),
            _ => Err(NotValid),
        };
        let within = |low: f64, high: f64| {
            number().and_then(
                |value| if (low..=high).contains(&value) { Ok(value) } else { Err(NotValid) },
            )
        };
        match (name.as_str(), message.arguments.is_empty()) {
            ("STA" | "STO", true) => {
                settings.is_started = name == "STA";
                settings.is_started_by_host = settings.is_started;
            }
            ("CTN", true) => settings.trigger = TriggerMode::Free,
            ("TRE", true) => settings.trigger = TriggerMode::Each,
            ("SHZ", _) => settings.sample_rate_hz = within(32.0, 70_000.0)?,
            ("AVD", _) => settings.averaging = within(1.0, 9999.0)? as u16,
            ("SODX", _) => self.select(&message.arguments)?,
            _ => return Err(NotValid),
        }
        Ok(message.arguments.clone())
    }

    /// Chooses signals. The device sends those of the whole sample first, each kind by its identifier, whatever the order
    /// asked for.
    fn select(&mut self, ids: &[Argument]) -> Result<(), NotValid> {
        let id = |argument: &Argument| match argument {
            Argument::Int(id) => u16::try_from(*id).map_err(|_| NotValid),
            _ => Err(NotValid),
        };
        let ids = ids.iter().map(id).collect::<Result<Vec<u16>, _>>()?;
        if !(1..=MAX_SIGNALS).contains(&ids.len()) {
            return Err(NotValid);
        }
        let mut signals = Vec::new();
        for id in ids {
            let signal = Signal::from_id(id).map_err(|_| NotValid)?;
            let number = NumberType::ALL[usize::from(signal.value_type.dtf_code())];
            let is_peak = matches!(signal.quantity, Quantity::Peak { .. });
            let points = if is_peak { self.points } else { 1 };
            signals.push(FormatSignal { number, points, first_point: 0, id });
        }
        signals.sort_by_key(|signal| (signal.is_of_points(), signal.id));
        self.settings.counter += 1;
        let format = Format {
            stream: 1,
            counter: self.settings.counter,
            sample_rate_hz: self.settings.sample_rate_hz as f32,
            signals,
        };
        let sample_len = format.layout().map_err(|_| NotValid)?.sample_len();
        if sample_len > MAX_LEN - 2 * HEADER_LEN {
            return Err(NotValid);
        }
        self.settings.format = Some(format);
        Ok(())
    }
}

/// Number of the refusal of a value.
const NOT_VALID: i32 = -1;

/// Name of the command of the full scale.
const SCALE: Name = Name::new("SCA");

#[cfg(test)]
mod tests {
    use super::*;

    fn say(device: &mut PacketDevice, message: &Message) -> Vec<u8> {
        let mut bytes = Vec::new();
        message.encode(&mut bytes);
        device.receive(&bytes);
        device.transmit()
    }

    fn kinds(mut bytes: &[u8]) -> Vec<Kind> {
        let mut kinds = Vec::new();
        while let Some(Ok(Header { len, kind })) = Header::decode(bytes) {
            kinds.push(kind);
            bytes = &bytes[len..];
        }
        assert!(bytes.is_empty(), "{bytes:?}");
        kinds
    }

    fn signals(ids: &[i32]) -> Message {
        let arguments = ids.iter().map(|&id| Argument::Int(id)).collect();
        Message::command(Name::new("SODX"), 3, arguments)
    }

    #[test]
    fn nothing_is_sent_before_signals_are_chosen() {
        let mut device = PacketDevice::new(2000.0, 1);
        device.expose(&Sample::default().into());
        assert_eq!((device.transmit().len(), device.dropped()), (0, 1));
        let answer = say(&mut device, &signals(&[256, 75]));
        assert_eq!(kinds(&answer), [Kind::Command, Kind::Format]);
        let format = Format::decode(&answer[76..]).unwrap();
        let ids: Vec<u16> = format.signals.iter().map(|signal| signal.id).collect();
        assert_eq!((format.counter, ids), (1, vec![75, 256]));
        device.expose(&Sample::default().into());
        device.expose(&Sample::default().into());
        let sent = device.transmit();
        assert_eq!((sent.len(), kinds(&sent)), (40 + 12, vec![Kind::Data]));
        assert!(!device.armed());
        say(&mut device, &Message::command(Name::new("STA"), 4, Vec::new()));
        assert!(device.armed());
    }

    #[test]
    fn wrong_commands_are_refused_and_change_nothing() {
        let mut device = PacketDevice::new(2000.0, 1);
        let refused = |device: &mut PacketDevice, message: Message| {
            let answer = say(device, &message);
            let answer = Message::decode(&answer[HEADER_LEN..]).unwrap();
            assert_eq!((answer.flags, answer.ticket), (CommandFlags::ERROR, 3));
        };
        for ids in [&[][..], &[1], &[-3], &[70_000], &[79]] {
            refused(&mut device, signals(ids));
        }
        refused(&mut device, Message::command(Name::new("SHZ"), 3, vec![Argument::Float(1.0)]));
        refused(&mut device, Message::command(Name::new("XYZ"), 3, Vec::new()));
        assert_eq!((device.sample_rate_hz(), device.transmit().len()), (1000.0, 0));
        // A line too long for a packet.
        let mut line = PacketDevice::new(2000.0, 2000);
        refused(&mut line, signals(&[256]));
    }

    #[test]
    fn packets_are_full_at_most() {
        let mut device = PacketDevice::new(2000.0, 192);
        say(&mut device, &signals(&[75, 16640]));
        for _ in 0..25 {
            device.expose(&Sample::default().into());
        }
        let sent = device.transmit();
        // 4056 bytes hold ten samples of 386.
        assert_eq!(kinds(&sent), [Kind::Data; 3]);
        assert_eq!(sent.len(), 2 * (40 + 3860) + 40 + 1930 + 2);
    }
}
