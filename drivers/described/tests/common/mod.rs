//! A driver on a table: virtual time, no link.

use asphera_described::FAMILY;
use asphera_link::{Driver, Event, Fault, FaultKind, Input, Nanos, Output, Reading};
use asphera_settings::Problems;

/// A connected driver and everything it said.
pub(crate) struct Bench {
    pub(crate) driver: Box<dyn Driver>,
    pub(crate) now: Nanos,
    pub(crate) events: Vec<Event>,
    pub(crate) sent: Vec<String>,
}

/// A driver of a table `settings`.
pub(crate) fn driver(text: &str) -> Result<Box<dyn Driver>, Problems> {
    let settings = FAMILY.parse("settings", text)?;
    Ok(settings.driver().expect("settings without problems make a driver"))
}

impl Bench {
    /// Connects at time zero.
    pub(crate) fn new(settings: &str) -> Bench {
        let driver = driver(settings).expect("settings of a test are sound");
        let mut bench = Bench { driver, now: Nanos::ZERO, events: Vec::new(), sent: Vec::new() };
        bench.driver.connected(bench.now);
        bench.drain();
        bench
    }

    /// Receives bytes at the present time.
    pub(crate) fn receive(&mut self, bytes: impl AsRef<[u8]>) {
        self.driver.receive(self.now, Input::Bytes(bytes.as_ref()));
        self.drain();
    }

    /// Goes to the time of the next time-out and lets it happen.
    pub(crate) fn next_timeout(&mut self) {
        self.now = self.driver.poll_timeout().expect("the driver waits for something");
        self.driver.timeout(self.now);
        self.drain();
    }

    /// Lets time-outs happen until another question is sent.
    pub(crate) fn next_question(&mut self) {
        let before = self.sent.len();
        while self.sent.len() == before {
            self.next_timeout();
        }
    }

    pub(crate) fn drain(&mut self) {
        while let Some(output) = self.driver.poll_transmit() {
            let Output::Bytes(bytes) = output else { panic!("a frame of CAN") };
            self.sent.push(asphera_link::text_of(&bytes));
        }
        while let Some(event) = self.driver.poll_event() {
            self.events.push(event);
        }
    }

    /// All readings so far.
    pub(crate) fn readings(&self) -> Vec<Reading> {
        let reading = |event: &Event| match event {
            Event::Reading(reading) => Some(reading.clone()),
            _ => None,
        };
        self.events.iter().filter_map(reading).collect()
    }

    /// Values of the first channel.
    pub(crate) fn values(&self) -> Vec<Option<f64>> {
        self.readings().iter().map(|reading| reading.values.get(0)).collect()
    }

    /// All faults so far, those that ended the connection too.
    pub(crate) fn faults(&self) -> Vec<(FaultKind, String)> {
        let fault = |event: &Event| match event {
            Event::Fault(Fault { kind, detail }) | Event::Reopen(Fault { kind, detail }) => {
                Some((*kind, detail.clone()))
            }
            _ => None,
        };
        self.events.iter().filter_map(fault).collect()
    }

    /// Bytes passed over so far.
    pub(crate) fn discarded(&self) -> u64 {
        let bytes = |event: &Event| match event {
            Event::Discarded { bytes } => Some(*bytes),
            _ => None,
        };
        self.events.iter().filter_map(bytes).sum()
    }

    pub(crate) fn count(&self, wanted: &Event) -> usize {
        self.events.iter().filter(|event| *event == wanted).count()
    }
}
