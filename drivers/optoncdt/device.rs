//! The sensor as a state machine: it listens.

use std::collections::VecDeque;

use asphera_link::{
    Channel, Command, Count, Driver, Event, Fault, FaultKind, Flags, Input, Nanos, Output, Problem,
    Reading, Values,
};

use crate::settings::{Extra, Settings};
use crate::wire::{Decoder, MAX_18, TICK_NS, Width, Word};

/// Whole blocks, one after the other, that prove that the sensor is there. Bytes of anything else often look like one.
const PROOF: usize = 3;

/// Blocks of another length, one after the other, that are worth a message.
const WRONG_BLOCKS: u32 = 20;

/// Most words of a block: all extras.
const MOST_WORDS: usize = 8;

/// A sensor that sends by itself.
///
/// Each block gives a reading with its distance. Errors that the sensor sends in place of a distance are flags.
/// Nothing is ever sent to the sensor: [`Command`]s change nothing, and there is no time-out.
#[derive(Debug)]
pub struct Optoncdt {
    settings: Settings,
    channels: Vec<Channel>,
    decoder: Decoder,
    block: Vec<u32>,
    /// Readings before the sensor proved to be there.
    unproved: Vec<Reading>,
    online: bool,
    in_trouble: bool,
    wrong_blocks: u32,
    /// Bytes of words that belong to no block.
    stray: u64,
    /// Whether the word before was one of no block.
    strayed: bool,
    events: VecDeque<Event>,
    tally: Tally,
}

/// What happened since the driver was made.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Tally {
    /// Readings given.
    pub readings: u64,
    /// Blocks with another number of words.
    pub wrong_blocks: u64,
    /// Bytes passed over.
    pub discarded_bytes: u64,
}

impl Optoncdt {
    /// A driver for the sensor.
    ///
    /// # Errors
    ///
    /// [`Settings::problems`], when there are any.
    pub fn new(settings: Settings) -> Result<Optoncdt, Vec<Problem>> {
        let problems = settings.problems();
        if !problems.is_empty() {
            return Err(problems);
        }
        Ok(Optoncdt {
            channels: settings.channels(),
            decoder: Decoder::new(settings.series.width()),
            block: Vec::with_capacity(MOST_WORDS),
            unproved: Vec::new(),
            online: false,
            in_trouble: false,
            wrong_blocks: 0,
            stray: 0,
            strayed: false,
            events: VecDeque::new(),
            tally: Tally::default(),
            settings,
        })
    }

    /// What happened since the driver was made.
    pub fn tally(&self) -> Tally {
        self.tally
    }

    fn bytes_of_words(&self, words: usize) -> u64 {
        let width = if self.settings.series.width() == Width::Two { 2 } else { 3 };
        words as u64 * width
    }

    fn word(&mut self, now: Nanos, word: Word) {
        let words = self.settings.words();
        if word.is_first {
            if !self.block.is_empty() {
                self.wrong_block();
            } else if !std::mem::take(&mut self.strayed) {
                self.wrong_blocks = 0;
            }
        } else if self.block.is_empty() {
            // The end of a block whose beginning was lost, or more words than were set up.
            self.stray += self.bytes_of_words(1);
            self.strayed = true;
            self.wrong_block();
            return;
        }
        self.block.push(word.value);
        if self.block.len() == words {
            let reading = self.reading(now);
            self.block.clear();
            self.give(reading);
        }
    }

    /// A block that is too short, or a word too many.
    fn wrong_block(&mut self) {
        let short = self.block.len();
        let unproved = self.unproved.len() * self.settings.words();
        self.stray += self.bytes_of_words(short + unproved);
        self.block.clear();
        self.unproved.clear();
        self.tally.wrong_blocks += 1;
        self.wrong_blocks += 1;
        if self.wrong_blocks == WRONG_BLOCKS {
            let (words, more) = (self.settings.words(), if short == 0 { "more" } else { "fewer" });
            let detail = format!(
                "blocks have {more} words than the {words} described: set `extras` to what GETOUTINFO_RS422 lists, in its order"
            );
            self.events.push_back(Event::Fault(Fault { kind: FaultKind::Protocol, detail }));
        }
    }

    fn reading(&mut self, host: Nanos) -> Reading {
        let distance = self.settings.series.distance(self.block[0], self.settings.range_mm);
        let mut reading = Reading {
            host,
            device_time_ns: None,
            count: None,
            values: Values::new(),
            flags: distance.flags,
        };
        reading.values.push(distance.mm);
        let mut rest = &self.block[1..];
        for extra in &self.settings.extras {
            let (words, after) = rest.split_at(extra.words());
            rest = after;
            enter(*extra, words, &mut reading);
        }
        let was_in_trouble = std::mem::replace(&mut self.in_trouble, distance.trouble.is_some());
        if let Some(trouble) = distance.trouble.filter(|_| !was_in_trouble) {
            let detail = format!("the sensor reports: {trouble}");
            self.events.push_back(Event::Fault(Fault { kind: FaultKind::Device, detail }));
        }
        reading
    }

    fn give(&mut self, reading: Reading) {
        // In step only if nothing lay between this block and the one before.
        if !self.online {
            self.unproved.push(reading);
            if self.unproved.len() < PROOF {
                return;
            }
            self.online = true;
            self.events.extend([Event::Online, Event::Ready]);
            let readings = std::mem::take(&mut self.unproved);
            self.tally.readings += readings.len() as u64;
            self.events.extend(readings.into_iter().map(Event::Reading));
            return;
        }
        self.tally.readings += 1;
        self.events.push_back(Event::Reading(reading));
    }

    fn take_discarded(&mut self) -> u64 {
        let bytes = self.decoder.take_discarded();
        if bytes > 0 && !self.online {
            let words = self.unproved.len() * self.settings.words();
            self.stray += self.bytes_of_words(words);
            self.unproved.clear();
        }
        bytes
    }
}

/// Enters the words of one extra: ILD1420 manual, pages 65 and 66.
fn enter(extra: Extra, words: &[u32], reading: &mut Reading) {
    match (extra, words) {
        (Extra::Shutter, [word]) => reading.values.push(Some(f64::from(*word) * 1e-7)),
        (Extra::Intensity, [word]) => {
            reading.values.push(Some(f64::from(*word) * 100.0 / 65_472.0));
        }
        (Extra::Counter, [word]) => {
            reading.count = Some(Count { raw: *word, first: 0, modulus: MAX_18 + 1 });
        }
        (Extra::Timestamp, [low, high]) => {
            let steps = u64::from(*high) << 16 | u64::from(*low & 0xFFFF);
            reading.device_time_ns = Some(steps * TICK_NS);
        }
        (Extra::State, [word]) => {
            let bit = |bit: u32| word >> bit & 1 == 1;
            if bit(2) {
                reading.flags |= Flags::NO_SIGNAL;
            }
            if bit(5) || bit(6) {
                reading.flags |= Flags::OUT_OF_RANGE;
            }
            if bit(0) || bit(1) {
                // The peak reaches beyond the part of the detector that is evaluated.
                reading.flags |= Flags::SUSPECT;
            }
        }
        _ => {}
    }
}

impl Driver for Optoncdt {
    fn channels(&self) -> &[Channel] {
        &self.channels
    }

    fn connected(&mut self, _: Nanos) {
        self.decoder = Decoder::new(self.settings.series.width());
        self.block.clear();
        self.unproved.clear();
        (self.online, self.in_trouble, self.strayed) = (false, false, false);
        (self.wrong_blocks, self.stray) = (0, 0);
    }

    fn disconnected(&mut self, _: Nanos) {
        self.decoder.reset();
        let words = self.block.len() + self.unproved.len() * self.settings.words();
        let bytes = self.decoder.take_discarded() + self.bytes_of_words(words) + self.stray;
        self.block.clear();
        self.unproved.clear();
        self.stray = 0;
        if bytes > 0 {
            self.tally.discarded_bytes += bytes;
            self.events.push_back(Event::Discarded { bytes });
        }
    }

    fn receive(&mut self, now: Nanos, input: Input<'_>) {
        let Input::Bytes(bytes) = input else { return };
        let mut discarded = 0;
        for byte in bytes {
            let word = self.decoder.push(*byte);
            discarded += self.take_discarded();
            if let Some(word) = word {
                self.word(now, word);
            }
        }
        discarded += std::mem::take(&mut self.stray);
        if discarded > 0 {
            self.tally.discarded_bytes += discarded;
            self.events.push_back(Event::Discarded { bytes: discarded });
        }
    }

    fn timeout(&mut self, _: Nanos) {}

    fn poll_timeout(&self) -> Option<Nanos> {
        None
    }

    fn poll_transmit(&mut self) -> Option<Output> {
        None
    }

    fn poll_event(&mut self) -> Option<Event> {
        self.events.pop_front()
    }

    fn command(&mut self, _: Nanos, _: Command) {}
}
