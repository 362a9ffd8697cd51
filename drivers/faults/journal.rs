//! What happened in a play, and the laws that it may not break.

use std::collections::BTreeSet;

use asphera_link::{Event, Fault, Flags, MotionEvent, Nanos, Output, Reading};

/// Everything that was delivered and everything that the driver said.
#[derive(Debug, Default)]
pub(crate) struct Journal {
    /// Whole measurements that were delivered and became no reading yet.
    open: Vec<Vec<Option<f64>>>,
    /// Length of a measurement.
    measurement_len: Option<u64>,
    delivered: u64,
    answers: u64,
    line_ends: u64,
    discarded: u64,
    readings: u64,
    /// Whether the driver said that its device is there, on any connection.
    pub(crate) is_online: bool,
    /// Good readings.
    pub(crate) good: u64,
    /// Flags of readings since the fault began.
    pub(crate) flags: Flags,
    /// Bytes discarded since the fault began.
    pub(crate) discarded_in_fault: u64,
    /// Faults since it began: kind and text.
    pub(crate) faults: BTreeSet<(&'static str, String)>,
    /// Texts of new connections that were asked for since it began.
    pub(crate) reopened: BTreeSet<String>,
    /// Texts of moves that broke off since it began.
    pub(crate) halted: BTreeSet<String>,
    /// Connections, and time-outs reported.
    pub(crate) proofs: u64,
    /// Laws that were broken; the first few.
    pub(crate) violations: Vec<String>,
    /// Texts that help nobody, each reported once.
    unhelpful: BTreeSet<String>,
    is_over: bool,
}

/// Violations that are written down; more say nothing new.
const MOST_VIOLATIONS: usize = 8;

/// Texts that are written down a play.
const MOST_TEXTS: usize = 64;

impl Journal {
    /// A law was broken.
    pub(crate) fn broken(&mut self, now: Nanos, law: impl std::fmt::Display) {
        if self.violations.len() < MOST_VIOLATIONS {
            self.violations.push(format!("at {now}: {law}"));
        }
    }

    /// The fault begins: what was reported before counts no more.
    pub(crate) fn begin_fault(&mut self) {
        self.flags = Flags::empty();
        self.discarded_in_fault = 0;
        self.faults.clear();
        self.reopened.clear();
        self.halted.clear();
    }

    /// The fault is over, and good readings come: what the end of the connection discards is no sign of it.
    pub(crate) fn end_fault(&mut self) {
        self.is_over = true;
    }

    /// A whole frame is about to be delivered.
    pub(crate) fn whole_frame(&mut self, parcel: &Output, is_measurement: bool) {
        let len = content(parcel).len() as u64;
        if is_measurement {
            assert_eq!(*self.measurement_len.get_or_insert(len), len, "a bench has one length");
        } else {
            self.answers += len;
        }
    }

    /// Values of a whole measurement are about to be delivered.
    pub(crate) fn measured(&mut self, values: &[Option<f64>]) {
        self.open.push(values.to_vec());
    }

    /// Bytes are delivered.
    pub(crate) fn deliver(&mut self, parcel: &Output) {
        let bytes = content(parcel);
        self.delivered += bytes.len() as u64;
        self.line_ends += bytes.iter().filter(|byte| matches!(byte, b'\r' | b'\n')).count() as u64;
    }

    /// Takes an event. Whether a new connection is asked for.
    pub(crate) fn take(&mut self, now: Nanos, event: Event) -> bool {
        match event {
            Event::Online => self.is_online = true,
            Event::Ready => {}
            Event::Reading(reading) => self.reading(now, &reading),
            Event::Discarded { bytes } => {
                if bytes == 0 {
                    self.broken(now, "0 bytes are said to be discarded");
                }
                self.discarded += bytes;
                self.discarded_in_fault += if self.is_over { 0 } else { bytes };
            }
            Event::Fault(fault) => self.fault(now, &fault),
            Event::Motion(MotionEvent::Failed(failure)) => {
                self.text(now, &failure.detail);
                insert(&mut self.halted, failure.detail);
            }
            Event::Motion(MotionEvent::Arrived | MotionEvent::Halted) => {}
            Event::Reopen(fault) => {
                self.text(now, &fault.detail);
                insert(&mut self.reopened, fault.detail);
                return true;
            }
        }
        false
    }

    fn fault(&mut self, now: Nanos, fault: &Fault) {
        self.text(now, &fault.detail);
        self.proofs += u64::from(fault.kind.name() == "timeout");
        if self.faults.len() < MOST_TEXTS {
            self.faults.insert((fault.kind.name(), fault.detail.clone()));
        }
    }

    fn reading(&mut self, now: Nanos, reading: &Reading) {
        self.readings += 1;
        self.flags |= if self.is_over { Flags::empty() } else { reading.flags };
        if reading.host > now {
            self.broken(now, format!("a reading has the time {}", reading.host));
        }
        if !reading.flags.is_empty() {
            return;
        }
        self.good += 1;
        let values: Vec<Option<f64>> = reading.values.iter().collect();
        match self.open.iter().position(|sent| is_same(sent, &values)) {
            // What is used cannot be used again, nor can what came before it.
            Some(at) => drop(self.open.drain(..=at)),
            None => self.broken(now, format!("a good reading {values:?} that was not sent")),
        }
    }

    /// A text of the driver: short, one line, and with a cure.
    fn text(&mut self, now: Nanos, text: &str) {
        let is_plain = !text.contains(char::is_control) && !text.ends_with('.');
        let is_short = text.chars().count() <= LONGEST_TEXT;
        let has_cure = CURES.iter().any(|cure| text.contains(cure));
        let is_new = |texts: &mut BTreeSet<String>| texts.insert(text.to_owned());
        if !(is_plain && is_short && has_cure) && is_new(&mut self.unhelpful) {
            self.broken(now, format!("a text that helps nobody: {text}"));
        }
    }

    /// Every byte is in a reading, in an answer, or counted as discarded.
    pub(crate) fn audit(&mut self, now: Nanos, has_line_ends: bool, proof_bytes: u64) {
        let used = self.readings * self.measurement_len.unwrap_or(0);
        let (delivered, counted) = (self.delivered, self.discarded + used);
        let ends = if has_line_ends { self.line_ends } else { 0 };
        let least = delivered.saturating_sub(self.answers + ends + self.proofs * proof_bytes);
        // A line end that was read is in a frame; one that was passed over may be counted or not.
        if counted > delivered + ends || counted < least {
            let Journal { readings, discarded, answers, .. } = self;
            let law = format!(
                "{delivered} bytes came, {readings} readings, {discarded} bytes discarded, answers of {answers} bytes: {counted} of {least} are accounted for"
            );
            self.broken(now, law);
        }
    }
}

fn insert(texts: &mut BTreeSet<String>, text: String) {
    if texts.len() < MOST_TEXTS {
        texts.insert(text);
    }
}

fn is_same(sent: &[Option<f64>], read: &[Option<f64>]) -> bool {
    sent.len() == read.len()
        && sent.iter().zip(read).all(|pair| match pair {
            (Some(sent), Some(read)) => (sent - read).abs() <= 1e-9 * sent.abs().max(1.0),
            (None, None) => true,
            _ => false,
        })
}

/// Bytes of a parcel; of a CAN frame its data.
pub(crate) fn content(parcel: &Output) -> &[u8] {
    match parcel {
        Output::Bytes(bytes) => bytes,
        Output::Frame(frame) => frame.data(),
    }
}

/// Most signs of a text.
const LONGEST_TEXT: usize = 400;

/// Words of cures: each text says what to do, or what the driver did about it.
const CURES: &[&str] = &[
    "check ",
    "set ",
    "see ",
    "home ",
    "press ",
    "take away ",
    "start ",
    "move ",
    "keep ",
    "increase ",
    "choose ",
    "do not ask",
    "is asked for",
    "was passed over",
    "was put in its place",
];

#[cfg(test)]
mod tests {
    use asphera_link::{FaultKind, Values};

    use super::*;

    fn reading(value: f64, flags: Flags) -> Event {
        let values: Values = [Some(value)].into_iter().collect();
        Event::Reading(Reading {
            host: Nanos::ZERO,
            device_time_ns: None,
            count: None,
            values,
            flags,
        })
    }

    fn bytes(len: usize) -> Output {
        Output::Bytes(vec![1; len])
    }

    #[test]
    fn a_good_reading_must_have_been_sent_and_counts_once() {
        let mut journal = Journal::default();
        journal.measured(&[Some(1.0)]);
        journal.measured(&[Some(2.0)]);
        journal.take(Nanos::ZERO, reading(2.0, Flags::empty()));
        assert_eq!((journal.violations.len(), journal.good), (0, 1));
        for wrong in [2.0, 1.0, 3.0] {
            journal.take(Nanos::ZERO, reading(wrong, Flags::SUSPECT));
            assert!(journal.violations.is_empty(), "a flagged one is not believed");
            journal.take(Nanos::ZERO, reading(wrong, Flags::empty()));
            assert_eq!(std::mem::take(&mut journal.violations).len(), 1, "{wrong}");
        }
    }

    #[test]
    fn a_lost_byte_is_found() {
        for (discarded, broken) in [(10, 0), (9, 1), (11, 1)] {
            let mut journal = Journal::default();
            journal.whole_frame(&bytes(4), true);
            journal.measured(&[Some(1.0)]);
            journal.deliver(&bytes(14));
            journal.take(Nanos::ZERO, reading(1.0, Flags::empty()));
            journal.take(Nanos::ZERO, Event::Discarded { bytes: discarded });
            journal.audit(Nanos::ZERO, false, 0);
            assert_eq!(journal.violations.len(), broken, "{discarded}: {:?}", journal.violations);
        }
    }

    #[test]
    fn a_text_without_a_cure_is_found() {
        for (detail, broken) in
            [("no answer: check the cable", 0), ("no answer", 1), ("check\u{1b}[2J", 1)]
        {
            let mut journal = Journal::default();
            let fault = Fault { kind: FaultKind::Timeout, detail: detail.to_owned() };
            assert!(journal.take(Nanos::ZERO, Event::Reopen(fault)));
            assert_eq!(journal.violations.len(), broken, "{detail}");
        }
    }
}
