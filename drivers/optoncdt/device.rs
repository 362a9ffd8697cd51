//! The sensor as a state machine: it listens.

use asphera_link::{
    Channel, Command, Count, Driver, Event, Events, FaultKind, Flags, Input, Nanos, Output,
    Problem, Reading, Values, millis,
};

use crate::settings::{Extra, Settings};
use crate::wire::{Decoder, MAX_18, TICK_NS, Width, Word};

/// Whole blocks, one after the other, that prove that the sensor is there, and that blocks are in step again after other
/// bytes. Bytes of anything else often look like one.
const PROOF: usize = 3;

/// Silence after which the newest block counts as good though none follows it, in ms.
pub(crate) const HELD_MS: u32 = 50;

/// Blocks of another length, one after the other, that are worth a message.
const WRONG_BLOCKS: u32 = 20;

/// Most words of a block: all extras.
const MOST_WORDS: usize = 8;

/// A sensor that sends by itself.
///
/// Each block gives a reading with its distance. Errors that the sensor sends in place of a distance are flags.
/// The newest block is held back until another follows it, or the line is silent: with other bytes behind it, it may be
/// noise and is flagged. Nothing is ever sent to the sensor: [`Command`]s change nothing.
#[derive(Debug)]
pub struct Optoncdt {
    settings: Settings,
    channels: Vec<Channel>,
    decoder: Decoder,
    block: Vec<u32>,
    /// Blocks that are not yet known to be in step.
    unproved: Vec<Block>,
    in_step: bool,
    /// The newest block in step, which nothing follows yet.
    held: Option<Block>,
    /// Counter of the newest block.
    last_count: Option<u32>,
    last_receipt: Nanos,
    last_block: Nanos,
    is_open: bool,
    in_trouble: bool,
    wrong_blocks: u32,
    /// Bytes of words that belong to no block.
    stray: u64,
    /// Whether the word before was one of no block.
    strayed: bool,
    events: Events,
    tally: Tally,
}

/// Content of a whole block.
#[derive(Debug)]
struct Block {
    reading: Reading,
    /// Trouble of the sensor itself, in words.
    trouble: Option<&'static str>,
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
            in_step: false,
            held: None,
            last_count: None,
            last_receipt: Nanos::ZERO,
            last_block: Nanos::ZERO,
            is_open: false,
            in_trouble: false,
            wrong_blocks: 0,
            stray: 0,
            strayed: false,
            events: Events::default(),
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
            let block = self.content(now);
            self.block.clear();
            self.last_block = now;
            self.give(block);
        }
    }

    /// A block that is too short, or a word too many.
    fn wrong_block(&mut self) {
        let short = self.block.len();
        self.stray += self.bytes_of_words(short);
        self.block.clear();
        self.disturbed();
        self.tally.wrong_blocks += 1;
        self.wrong_blocks += 1;
        if self.wrong_blocks == WRONG_BLOCKS {
            let (words, more) = (self.settings.words(), if short == 0 { "more" } else { "fewer" });
            let detail = format!(
                "blocks have {more} words than the {words} described: set `extras` to what GETOUTINFO_RS422 lists, in its order"
            );
            self.events.fault(FaultKind::Protocol, detail);
        }
    }

    fn content(&self, host: Nanos) -> Block {
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
        Block { reading, trouble: distance.trouble }
    }

    fn give(&mut self, block: Block) {
        if self.in_step {
            self.hold(block);
            return;
        }
        // In step only if nothing lay between this block and the one before.
        self.unproved.push(block);
        if self.unproved.len() < PROOF {
            return;
        }
        self.in_step = true;
        self.events.prove_online();
        self.events.prove_ready();
        std::mem::take(&mut self.unproved).into_iter().for_each(|block| self.hold(block));
    }

    /// Holds the newest block back and gives the one before it.
    fn hold(&mut self, mut block: Block) {
        let reading = &mut block.reading;
        let count = reading.count.map(|count| count.raw);
        if count.is_some() && count == self.last_count {
            // A block that came twice, or a counter that stands: no measurement of its own.
            reading.flags |= Flags::AMBIGUOUS_COUNT;
            reading.count = None;
        }
        self.last_count = count;
        if let Some(before) = self.held.replace(block) {
            self.release(before);
        }
    }

    fn release(&mut self, Block { reading, trouble }: Block) {
        // Noise tells nothing of the sensor.
        let trouble = trouble.filter(|_| !reading.flags.contains(Flags::SUSPECT));
        let was_in_trouble = std::mem::replace(&mut self.in_trouble, trouble.is_some());
        if let Some(trouble) = trouble.filter(|_| !was_in_trouble) {
            let detail = format!("the sensor reports: {trouble}");
            self.events.fault(FaultKind::Device, detail);
        }
        self.tally.readings += 1;
        self.events.push(Event::Reading(reading));
    }

    /// Other bytes follow the newest block.
    fn disturbed(&mut self) {
        if let Some(mut block) = self.held.take() {
            block.reading.flags |= Flags::SUSPECT;
            self.release(block);
        }
        let words = self.unproved.len() * self.settings.words();
        self.stray += self.bytes_of_words(words);
        self.unproved.clear();
        self.in_step = false;
    }

    fn take_discarded(&mut self) -> u64 {
        let bytes = self.decoder.take_discarded();
        if bytes > 0 {
            // Noise tells nothing of how long blocks are.
            self.wrong_blocks = 0;
            self.disturbed();
        }
        bytes
    }

    /// When the newest reading is given though nothing follows it.
    fn held_until(&self) -> Option<Nanos> {
        self.held.as_ref().map(|_| self.last_receipt + millis(HELD_MS))
    }

    /// When the sensor has been silent for too long.
    fn silent_at(&self) -> Option<Nanos> {
        let is_watched = self.is_open && self.events.is_online() && self.settings.silence_ms > 0;
        is_watched.then(|| self.last_block + millis(self.settings.silence_ms))
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

    fn connected(&mut self, now: Nanos) {
        self.decoder = Decoder::new(self.settings.series.width());
        self.block.clear();
        self.unproved.clear();
        self.events.restart();
        (self.in_trouble, self.strayed) = (false, false);
        (self.wrong_blocks, self.stray) = (0, 0);
        (self.in_step, self.held, self.last_count) = (false, None, None);
        (self.is_open, self.last_receipt, self.last_block) = (true, now, now);
    }

    fn disconnected(&mut self, _: Nanos) {
        self.is_open = false;
        if let Some(block) = self.held.take() {
            self.release(block);
        }
        self.decoder.reset();
        let words = self.block.len() + self.unproved.len() * self.settings.words();
        let bytes = self.decoder.take_discarded() + self.bytes_of_words(words) + self.stray;
        self.block.clear();
        self.unproved.clear();
        self.stray = 0;
        self.tally.discarded_bytes += bytes;
        self.events.discarded(bytes);
    }

    fn receive(&mut self, now: Nanos, input: Input<'_>) {
        let Input::Bytes(bytes) = input else { return };
        let mut discarded = 0;
        self.last_receipt = now;
        for byte in bytes {
            let word = self.decoder.push(*byte);
            discarded += self.take_discarded();
            if let Some(word) = word {
                self.word(now, word);
            }
        }
        discarded += std::mem::take(&mut self.stray);
        self.tally.discarded_bytes += discarded;
        self.events.discarded(discarded);
    }

    fn timeout(&mut self, now: Nanos) {
        if self.held_until().is_some_and(|until| until <= now)
            && let Some(block) = self.held.take()
        {
            self.release(block);
        }
        if self.silent_at().is_some_and(|due| due <= now) {
            let silence = now.since(self.last_block).as_millis();
            let detail = format!(
                "no measurement for {silence} ms: check cable, power and laser, or set silence_ms"
            );
            self.is_open = false;
            self.events.reopen(FaultKind::Timeout, detail);
        }
    }

    fn poll_timeout(&self) -> Option<Nanos> {
        self.held_until().into_iter().chain(self.silent_at()).min()
    }

    fn poll_transmit(&mut self) -> Option<Output> {
        None
    }

    fn poll_event(&mut self) -> Option<Event> {
        self.events.pop()
    }

    fn command(&mut self, _: Nanos, _: Command) {}
}
