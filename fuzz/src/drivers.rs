//! Bytes of a device, cut and timed anyhow, and what must hold for whatever a driver makes of them.
//!
//! The first byte of an input chooses the device. Pieces follow: a byte of time or of what happens, a byte of length, and
//! as many bytes from the device. The variable `ASPHERA_FUZZ_DEVICE` chooses one device for all inputs, by its row in
//! [`DEVICES`]; the row behind the last is the proposal of settings.

use std::sync::LazyLock;
use std::time::Duration;

use asphera_link::{
    CanFrame, Capture, Carries, Command, DeviceSettings, Driver, Event, Family, Fault, Input,
    Motion, Nanos, Reading,
};

/// Gives an input to a driver and checks what came out of it.
///
/// # Panics
///
/// Where a law is broken.
pub fn hold(input: &[u8]) {
    let [which, script @ ..] = input else { return };
    let which = ONE_DEVICE.unwrap_or(usize::from(*which)) % (DEVICES.len() + 1);
    let Some((family, _, is_stream)) = DEVICES.get(which) else {
        proposed(script);
        return;
    };
    let new_driver = || driver(&*SETTINGS[which]);
    let mut machine = Machine::new(*family, new_driver());
    for (what, bytes) in pieces(script) {
        machine.happen(what);
        machine.receive(bytes);
    }
    if *is_stream {
        let pieces: Vec<&[u8]> = pieces(script).map(|(_, bytes)| bytes).collect();
        let whole = readings(new_driver(), &[&pieces.concat()]);
        assert_eq!(readings(new_driver(), &pieces), whole, "chunks change readings");
    }
}

/// Devices: family, settings, and whether readings depend on the bytes alone, not on how they are cut.
const DEVICES: [(Family, &str, bool); 23] = [
    (asphera_chrocodile::FAMILY, "", false),
    (asphera_chrocodile::FAMILY, "signals = [75, 76, 65, 256, 257]\ntrigger = \"free\"", false),
    (asphera_cia406::FAMILY, "node_id = 5", false),
    (asphera_modbus::FAMILY, "framing = \"tcp\"\nmap = \"baumer-om20\"", false),
    (asphera_modbus::FAMILY, "framing = \"rtu\"\nmap = \"baumer-om20\"", false),
    (
        asphera_described::FAMILY,
        "separator = ','\nfield = [{ name = 'z', column = 2, unit = 'mm', no_signal = ['-----'] }, { name = 'n', column = 1, \
         role = 'count', modulus = 100 }]",
        true,
    ),
    (
        asphera_described::FAMILY,
        "begin = '$'\nend = '\\r\\n'\nlongest = 40\nchecksum = { kind = 'xor8', form = 'hex', skip_first = 1, skip_last = 1 }\n\
         field = [{ name = 'z', column = 1 }, { name = 's', column = 2, role = 'status', good = ['0'] }]",
        true,
    ),
    (
        asphera_described::FAMILY,
        "frame = 'record'\nlength = 6\nbegin = 'AB'\nfield = [{ name = 'z', at = 2, form = 'f32', order = 'little' }]",
        false,
    ),
    (
        asphera_described::FAMILY,
        "pattern = 'OK(?<z>[+-]\\d+)'\nhello = { ask = 'I', answer = 'ID.*' }\npoll = { ask = 'M' }\n\
         refusal = [{ pattern = 'E\\d' }]\nignore = ['#.*']\nfield = [{ name = 'z', group = 'z', scale = 1e-3 }]",
        false,
    ),
    (
        asphera_optoncdt::FAMILY,
        "series = \"ild1420\"\nrange_mm = 10\nextras = [\"counter\", \"timestamp\", \"state\"]\ntriggered = true",
        true,
    ),
    (asphera_optoncdt::FAMILY, "series = \"ild1700\"\nrange_mm = 10", true),
    (
        asphera_scpi::FAMILY,
        "identity = 'ID.*'\nquery = 'READ?'\nfield = [{ name = 'z', unit = 'mm' }]",
        false,
    ),
    (
        asphera_zaber::FAMILY,
        "checksum = true\naxis = [{ name = 'x', microstep_um = 0.1 }, { name = 'y', microstep_deg = 0.01 }]",
        false,
    ),
    (asphera_riftek::FAMILY, "range_mm = 50", false),
    (asphera_riftek::FAMILY, "range_mm = 50\nmode = \"poll\"", false),
    (asphera_rf627::FAMILY, "silence_ms = 1000", false),
    (asphera_chrocodile::FAMILY, "protocol = \"packets\"", true),
    (
        asphera_chrocodile::FAMILY,
        "protocol = \"packets\"\nsignals = [65, 16640, 257]\ntrigger = \"free\"\nscale_um = 2000\npitch_um = 5",
        true,
    ),
    (
        asphera_ippdme::FAMILY,
        "commands = ['Home()', 'PtMeas(X(1), Y(2), Z(3))', 'ScanOnLine(0,0,0,1,0,0,0,0,1,0.1)']\nquality_limit = 50\nsilence_s = 2",
        false,
    ),
    (asphera_keyence::FAMILY, "batch = true\nsilence_ms = 2000", false),
    (asphera_keyence::FAMILY, "series = \"lj-v7000\"", false),
    (
        asphera_cia402::FAMILY,
        "node_id = 5\nstep_nm = 100\nhoming = { method = 17, switch_mm_s = 10, zero_mm_s = 1 }",
        false,
    ),
    (asphera_cia406::FAMILY, "node_id = 5\nlisten_only = true\nstep_nm = 100", false),
];

/// Settings of [`DEVICES`], read once: to read them for each input took most of its time.
static SETTINGS: LazyLock<Vec<Box<dyn DeviceSettings>>> =
    LazyLock::new(|| DEVICES.iter().map(|(family, text, _)| settings(*family, text)).collect());

static ONE_DEVICE: LazyLock<Option<usize>> =
    LazyLock::new(|| std::env::var("ASPHERA_FUZZ_DEVICE").ok()?.parse().ok());

fn settings(family: Family, text: &str) -> Box<dyn DeviceSettings> {
    family.parse("settings", text).unwrap_or_else(|problems| panic!("{problems}"))
}

fn driver(settings: &dyn DeviceSettings) -> Box<dyn Driver> {
    settings.driver().unwrap_or_else(|problems| panic!("{problems:?}"))
}

/// What happens, and the bytes that come then.
fn pieces(script: &[u8]) -> impl Iterator<Item = (u8, &[u8])> {
    let mut rest = script;
    std::iter::from_fn(move || {
        let [what, len, after @ ..] = rest else { return None };
        let (bytes, after) = after.split_at(after.len().min(usize::from(*len)));
        rest = after;
        Some((*what, bytes))
    })
}

/// A driver, and what is known of its connection.
struct Machine {
    driver: Box<dyn Driver>,
    carries: Carries,
    now: Nanos,
    online: bool,
    ready: bool,
    /// An order was begun on some connection.
    ordered: bool,
}

impl Machine {
    fn new(family: Family, driver: Box<dyn Driver>) -> Machine {
        let mut machine = Machine {
            driver,
            carries: family.carries,
            now: Nanos::ZERO,
            online: false,
            ready: false,
            ordered: false,
        };
        machine.connect();
        machine
    }

    fn connect(&mut self) {
        (self.online, self.ready) = (false, false);
        self.driver.connected(self.now);
        self.drain(0);
    }

    /// 251 to 255: halt, run the program, start, stop, another connection. Else so many times 20 ms pass.
    fn happen(&mut self, what: u8) {
        match what {
            255 => {
                self.driver.disconnected(self.now);
                self.drain(0);
                self.connect();
            }
            254 => self.driver.command(self.now, Command::Stop),
            253 => self.driver.command(self.now, Command::Start),
            252 => self.ordered |= self.driver.motion(self.now, &Motion::Run).is_ok(),
            251 => self.ordered |= self.driver.motion(self.now, &Motion::Halt).is_ok(),
            steps => {
                let until = self.now + Duration::from_millis(20 * u64::from(steps));
                let mut timeouts = 0;
                while let Some(due) = self.driver.poll_timeout().filter(|due| *due <= until) {
                    self.now = self.now.max(due);
                    self.driver.timeout(self.now);
                    self.drain(0);
                    timeouts += 1;
                    assert!(timeouts < 6000, "it spins");
                }
                self.now = until;
            }
        }
        self.drain(0);
    }

    fn receive(&mut self, bytes: &[u8]) {
        if self.carries == Carries::TwoStreams {
            // The first byte of a piece is the number of its connection.
            if let Some(input) = Input::of_chunk(bytes) {
                self.driver.receive(self.now, input);
            }
        } else if self.carries == Carries::CanFrames {
            let mut left = bytes;
            while !left.is_empty() {
                let (record, after) = CanFrame::split_record(left);
                left = after;
                match CanFrame::from_record(record) {
                    // As a line does: see `Driver::reads_fd`.
                    Ok(frame) if frame.fd().is_none() || self.driver.reads_fd() => {
                        self.driver.receive(self.now, Input::Frame(&frame));
                    }
                    _ => {}
                }
            }
        } else {
            self.driver.receive(self.now, Input::Bytes(bytes));
        }
        self.drain(bytes.len());
    }

    /// Takes what the driver says. A reading needs a device that proved to be there; a fault is read by a person.
    fn drain(&mut self, received: usize) {
        let mut sent = 0;
        while self.driver.poll_transmit().is_some() {
            sent += 1;
        }
        assert!(sent <= 64 + received, "{sent} messages to the device");
        let (mut events, mut reopen) = (0, false);
        while let Some(event) = self.driver.poll_event() {
            events += 1;
            match event {
                Event::Online => {
                    assert!(!self.online, "online twice");
                    self.online = true;
                }
                Event::Ready => self.ready = true,
                Event::Motion(event) => assert!(self.ordered, "{event:?} of no order"),
                Event::Reading(reading) => {
                    assert!(self.online, "a reading of nobody");
                    assert_eq!(reading.values.len(), self.driver.channels().len());
                }
                // A frame of CAN may have no data, and belong to nothing still.
                Event::Discarded { bytes } => {
                    assert!(bytes > 0 || self.carries == Carries::CanFrames);
                }
                Event::Fault(fault) => is_readable(&fault),
                Event::Reopen(fault) => {
                    is_readable(&fault);
                    reopen = true;
                }
            }
        }
        assert!(events <= 64 + 4 * received, "{events} events of {received} bytes");
        if reopen {
            self.driver.disconnected(self.now);
            while self.driver.poll_event().is_some() {}
            (self.online, self.ready) = (false, false);
            self.driver.connected(self.now);
        }
    }
}

fn is_readable(fault: &Fault) {
    let text = &fault.detail;
    assert!(!text.trim().is_empty() && text.chars().count() <= 600, "{text:?}");
    assert!(!text.contains(char::is_control), "{text:?}");
}

fn readings(mut driver: Box<dyn Driver>, chunks: &[&[u8]]) -> Vec<Reading> {
    let mut found = Vec::new();
    driver.connected(Nanos::ZERO);
    for chunk in chunks {
        driver.receive(Nanos::ZERO, Input::Bytes(chunk));
        while let Some(event) = driver.poll_event() {
            found.extend(if let Event::Reading(reading) = event { Some(reading) } else { None });
        }
    }
    found
}

/// Settings that are proposed can be used, and read what they were made of.
fn proposed(bytes: &[u8]) {
    let family = asphera_described::FAMILY;
    let Some(propose) = family.propose else { return };
    let proposal = propose(&Capture { received: bytes.to_vec(), asked: None });
    assert!(!proposal.remarks.is_empty(), "nothing is said");
    for remark in &proposal.remarks {
        assert!(!remark.contains(char::is_control), "{remark:?}");
    }
    if let Some(text) = proposal.settings {
        readings(driver(&*settings(family, &text)), &[bytes]);
    }
}
