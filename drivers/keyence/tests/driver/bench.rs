//! A driver, and answers to what it asks.

use std::time::Duration;

use asphera_keyence::wire::{Answer, ErrorCodes, Height, Layout, Profile, Request, Unit};
use asphera_keyence::{Profiler, Settings};
use asphera_link::{Command, Driver as _, Event, Fault, Input, Nanos, Output, Reading};

/// Eight points 0.1 mm apart, in units of 80 nm.
pub(crate) const LAYOUT: Layout = Layout {
    start_code: 0xC0DE,
    kind: 1,
    points: 8,
    unit_10nm: 8,
    x_start_10nm: -35_000,
    x_pitch_10nm: 10_000,
};

/// A driver with what it said, and the time.
pub(crate) struct Bench {
    pub(crate) driver: Profiler,
    pub(crate) now: Nanos,
    pub(crate) asked: Vec<Request>,
    pub(crate) events: Vec<Event>,
}

impl Bench {
    /// Connected; what it asked first was not answered.
    pub(crate) fn new(settings: Settings) -> Bench {
        let mut driver = Profiler::new(settings).unwrap();
        driver.connected(Nanos::ZERO);
        let mut bench = Bench { driver, now: Nanos::ZERO, asked: Vec::new(), events: Vec::new() };
        bench.drain();
        bench
    }

    /// Streaming: everything was asked and answered.
    pub(crate) fn streaming(settings: Settings) -> Bench {
        let mut bench = Bench::new(settings);
        bench.command(Command::Start);
        bench.answer_all();
        bench.events.clear();
        bench.asked.clear();
        bench
    }

    pub(crate) fn command(&mut self, command: Command) {
        self.driver.command(self.now, command);
        self.drain();
    }

    /// The question that has no answer yet.
    pub(crate) fn last(&self) -> u8 {
        self.asked.last().unwrap().command()
    }

    /// Answers the last question.
    pub(crate) fn answer(&mut self, error: u8, content: &[u8]) {
        let answer = Answer { command: self.last(), error, content }.encode();
        self.commands(&answer);
    }

    /// Answers until nothing more is asked.
    pub(crate) fn answer_all(&mut self) {
        let mut answered = 0;
        while answered < self.asked.len() {
            answered = self.asked.len();
            self.answer(0, &content(self.asked[answered - 1]));
        }
    }

    pub(crate) fn commands(&mut self, bytes: &[u8]) {
        self.driver.receive(self.now, Input::Bytes(bytes));
        self.drain();
    }

    pub(crate) fn stream(&mut self, bytes: &[u8]) {
        self.driver.receive(self.now, Input::Second(bytes));
        self.drain();
    }

    /// Lets time pass, and does what is due.
    pub(crate) fn wait_ms(&mut self, ms: u64) {
        let until = self.now + Duration::from_millis(ms);
        while let Some(due) = self.driver.poll_timeout().filter(|due| *due <= until) {
            self.now = self.now.max(due);
            self.driver.timeout(self.now);
            self.drain();
        }
        self.now = until;
    }

    pub(crate) fn drain(&mut self) {
        while let Some(output) = self.driver.poll_transmit() {
            let Output::Bytes(bytes) = output else { panic!("a frame") };
            let (_, request, len) = Request::decode(&bytes).unwrap().unwrap();
            assert_eq!(len, bytes.len());
            self.asked.push(request);
        }
        self.events.extend(std::iter::from_fn(|| self.driver.poll_event()));
    }

    pub(crate) fn readings(&self) -> Vec<&Reading> {
        let events = self.events.iter();
        events
            .filter_map(|event| if let Event::Reading(it) = event { Some(it) } else { None })
            .collect()
    }

    pub(crate) fn triggers(&self) -> Vec<u32> {
        self.readings().iter().map(|reading| reading.count.unwrap().raw).collect()
    }

    pub(crate) fn faults(&self) -> Vec<&Fault> {
        let events = self.events.iter();
        events
            .filter_map(|event| if let Event::Fault(it) = event { Some(it) } else { None })
            .collect()
    }

    pub(crate) fn discarded(&self) -> u64 {
        let bytes = |event: &Event| match event {
            Event::Discarded { bytes } => *bytes,
            _ => 0,
        };
        self.events.iter().map(bytes).sum()
    }

    pub(crate) fn reopens(&self) -> Option<&Fault> {
        self.events.iter().find_map(|event| match event {
            Event::Reopen(fault) => Some(fault),
            _ => None,
        })
    }
}

/// Content of the answer of a controller without errors.
pub(crate) fn content(request: Request) -> Vec<u8> {
    let unit = |model: &str, serial: &str| Unit { model: model.into(), serial: serial.into() };
    match request {
        Request::Units => {
            Unit::encode_all(&[unit("LJ-X8000", "1A230004"), unit("LJ-X8080", "9C870001")])
        }
        Request::Errors => ErrorCodes::default().encode(),
        Request::Prepare => LAYOUT.encode(),
        Request::Profile => {
            let mut content = vec![0; 36];
            content[26] = 16;
            content
        }
        _ => Vec::new(),
    }
}

/// A profile of a trigger, all of one height.
pub(crate) fn profile(trigger: u32, height: Height) -> Vec<u8> {
    Profile::encode(&LAYOUT, trigger, trigger.wrapping_mul(4).cast_signed(), [height; 8])
}
