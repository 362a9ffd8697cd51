//! A driver on a table: virtual time, no link.

use asphera_link::{Driver as _, Event, Fault, FaultKind, Input, Nanos, Output, Reading};
use asphera_modbus::{Modbus, Settings};

/// A connected driver and everything it said.
pub(crate) struct Bench {
    pub(crate) driver: Modbus,
    pub(crate) now: Nanos,
    pub(crate) events: Vec<Event>,
    pub(crate) sent: Vec<Vec<u8>>,
}

impl Bench {
    /// Connects at time zero.
    pub(crate) fn new(settings: Settings) -> Bench {
        let driver = Modbus::new(settings).expect("settings of a test are sound");
        let (events, sent) = (Vec::new(), Vec::new());
        let mut bench = Bench { driver, now: Nanos::ZERO, events, sent };
        bench.driver.connected(bench.now);
        bench.drain();
        bench
    }

    /// Receives bytes at the present time.
    pub(crate) fn receive(&mut self, bytes: &[u8]) {
        self.driver.receive(self.now, Input::Bytes(bytes));
        self.drain();
    }

    /// Goes to the time of the next time-out and lets it happen.
    pub(crate) fn next_timeout(&mut self) {
        self.now = self.driver.poll_timeout().expect("the driver waits for something");
        self.driver.timeout(self.now);
        self.drain();
    }

    /// Lets time-outs happen until another request is sent, and gives it.
    pub(crate) fn next_request(&mut self) -> Vec<u8> {
        let before = self.sent.len();
        while self.sent.len() == before {
            self.next_timeout();
        }
        self.sent[before].clone()
    }

    pub(crate) fn drain(&mut self) {
        while let Some(output) = self.driver.poll_transmit() {
            let Output::Bytes(bytes) = output else { panic!("a frame of CAN from Modbus") };
            self.sent.push(bytes);
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

    /// The values of the last reading.
    pub(crate) fn values(&self) -> Vec<Option<f64>> {
        self.readings().last().expect("a reading").values.iter().collect()
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
}
