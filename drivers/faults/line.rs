//! The line between device and driver, and what is done to the frames on it.

use std::collections::VecDeque;
use std::time::Duration;

use asphera_link::{CanFrame, CanId, Connection, Nanos, Output};

use crate::Sent;
use crate::journal::content;
use crate::noise::Noise;

/// What is done to frames of the device.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Meddling {
    Nothing,
    /// Bytes come one by one.
    Slow,
    /// Random bytes stand before each frame.
    Noisy,
    /// The second half of the next measurement is lost.
    Half,
    /// The next measurement comes twice.
    Twice,
    /// A bit of the next measurement is wrong.
    Damaged,
    /// The next measurement comes later by so much.
    Late(Duration),
}

/// Bytes on their way.
#[derive(Debug)]
pub(crate) struct Delivery {
    pub(crate) at: Nanos,
    pub(crate) parcel: Output,
    /// The frame that ends with them, whole.
    pub(crate) whole: Option<Sent>,
    /// Whether it is a frame of another device on the bus, which is no byte of ours.
    pub(crate) is_foreign: bool,
    pub(crate) connection: Connection,
}

/// A line in one direction, from device to driver.
#[derive(Debug)]
pub(crate) struct Line {
    queue: VecDeque<Delivery>,
    /// Connection of the last frame; noise comes on the same.
    connection: Connection,
    /// When its last byte is over.
    free_at: Nanos,
    pub(crate) meddling: Meddling,
    /// Whether frames come whole or not at all.
    is_cut_nowhere: bool,
    /// The half of a measurement that was lost.
    pub(crate) lost_half: Option<Vec<u8>>,
    noise: Noise,
}

impl Line {
    pub(crate) fn new(is_cut_nowhere: bool) -> Line {
        Line {
            queue: VecDeque::new(),
            connection: Connection::First,
            free_at: Nanos::ZERO,
            meddling: Meddling::Nothing,
            is_cut_nowhere,
            lost_half: None,
            noise: Noise::new(2026),
        }
    }

    /// Whether it carries a frame that is not over yet.
    pub(crate) fn is_busy(&self, now: Nanos) -> bool {
        self.free_at > now + LATENCY
    }

    /// Drops all that is on its way.
    pub(crate) fn clear(&mut self, now: Nanos) {
        self.queue.clear();
        self.free_at = now;
    }

    pub(crate) fn next_at(&self) -> Option<Nanos> {
        self.queue.front().map(|delivery| delivery.at)
    }

    pub(crate) fn pop(&mut self) -> Option<Delivery> {
        self.queue.pop_front()
    }

    /// Sends a frame of the device.
    pub(crate) fn send(&mut self, now: Nanos, sent: Sent) {
        let at = self.free_at.max(now + LATENCY);
        self.connection = sent.connection;
        let meddling = self.meddling;
        let is_once = !matches!(meddling, Meddling::Nothing | Meddling::Slow | Meddling::Noisy);
        if is_once && !sent.is_measurement {
            self.whole(at, sent);
            return;
        }
        if is_once {
            self.meddling = Meddling::Nothing;
        }
        match meddling {
            Meddling::Nothing => self.whole(at, sent),
            Meddling::Slow => self.slow(at, sent),
            Meddling::Noisy => {
                let junk = self.junk(&sent.parcel);
                self.noise(at, junk);
                self.whole(at, sent);
            }
            Meddling::Half => {
                let (first, second) = halves(&sent.parcel);
                self.lost_half = second;
                self.raw(at, first);
            }
            Meddling::Twice => {
                let again = sent.parcel.clone();
                self.whole(at, sent);
                self.raw(at, again);
            }
            Meddling::Damaged => self.raw(at, damaged(&sent.parcel)),
            Meddling::Late(delay) => {
                let (is_can, free_at) = (matches!(sent.parcel, Output::Frame(_)), self.free_at);
                self.whole(at + delay, sent);
                if is_can {
                    // Others overtake it on the bus.
                    self.free_at = free_at;
                }
            }
        }
    }

    /// Sends bytes of nobody.
    pub(crate) fn raw(&mut self, at: Nanos, parcel: Output) {
        self.push(at, parcel, None, false);
    }

    /// Sends noise; on a bus it is frames of others.
    pub(crate) fn noise(&mut self, at: Nanos, parcel: Output) {
        let is_foreign = matches!(parcel, Output::Frame(_));
        self.push(at, parcel, None, is_foreign);
    }

    fn whole(&mut self, at: Nanos, sent: Sent) {
        let parcel = sent.parcel.clone();
        self.push(at, parcel, Some(sent), false);
    }

    fn slow(&mut self, at: Nanos, sent: Sent) {
        let Output::Bytes(bytes) = &sent.parcel else { return self.whole(at + SLOW_FRAME, sent) };
        if self.is_cut_nowhere {
            return self.whole(at + SLOW_FRAME, sent);
        }
        // A line is whole with the first byte of its end.
        let last = bytes.trim_ascii_end().len().min(bytes.len().saturating_sub(1));
        let (before, end) =
            bytes.split_at(if bytes.ends_with(b"\r\n") { last } else { bytes.len() - 1 });
        let (before, end) = (before.to_vec(), end.to_vec());
        let mut at = at;
        for byte in before {
            self.raw(at, Output::Bytes(vec![byte]));
            at = at + SLOW_BYTE;
        }
        let parcel = Output::Bytes(end);
        self.push(at, parcel, Some(sent), false);
    }

    fn push(&mut self, at: Nanos, parcel: Output, whole: Option<Sent>, is_foreign: bool) {
        let delivery = Delivery { at, parcel, whole, is_foreign, connection: self.connection };
        self.free_at = self.free_at.max(delivery.at);
        let place = self.queue.partition_point(|other| other.at <= delivery.at);
        self.queue.insert(place, delivery);
    }

    /// Bytes that are none of the device, in the form of its frames.
    pub(crate) fn junk(&mut self, like: &Output) -> Output {
        match like {
            Output::Bytes(_) => {
                let len = 1 + self.noise.number() as usize % 64;
                Output::Bytes(self.noise.bytes(len))
            }
            Output::Frame(_) => self.foreign_frame(),
        }
    }

    /// So many random bytes, or a frame of another node.
    pub(crate) fn flood(&mut self, is_can: bool, len: usize) -> Output {
        if is_can { self.foreign_frame() } else { Output::Bytes(self.noise.bytes(len)) }
    }

    /// A frame that is none of the node's: of another node, remote, or with a long identifier.
    fn foreign_frame(&mut self) -> Output {
        let number = self.noise.number();
        let len = number as usize % 9;
        let data = self.noise.bytes(len);
        let node = 100 + (number >> 8 & 7) as u16;
        let id = (number >> 16) as u16 & 0x780 | node;
        let frame = match number >> 32 & 3 {
            0 => CanFrame::remote_frame(CanId::Standard(0x185), len),
            1 => CanFrame::data_frame(CanId::Extended(0x185), &data),
            _ => CanFrame::data_frame(CanId::Standard(id), &data),
        };
        Output::Frame(frame.expect("identifiers and lengths are in range"))
    }
}

fn halves(parcel: &Output) -> (Output, Option<Vec<u8>>) {
    let (first, second) = content(parcel).split_at(content(parcel).len() / 2);
    match parcel {
        Output::Bytes(_) => (Output::Bytes(first.to_vec()), Some(second.to_vec())),
        Output::Frame(frame) => {
            let half = CanFrame::data_frame(frame.id(), first).expect("shorter than before");
            (Output::Frame(half), None)
        }
    }
}

/// The lowest bit of the middle byte is wrong.
fn damaged(parcel: &Output) -> Output {
    let mut bytes = content(parcel).to_vec();
    let middle = bytes.len() / 2;
    if let Some(byte) = bytes.get_mut(middle) {
        *byte ^= 1;
    }
    match parcel {
        Output::Bytes(_) => Output::Bytes(bytes),
        Output::Frame(frame) => {
            Output::Frame(CanFrame::data_frame(frame.id(), &bytes).expect("as long as before"))
        }
    }
}

/// Time from the device to the driver.
const LATENCY: Duration = Duration::from_millis(1);

/// Time from one byte to the next on a slow line.
const SLOW_BYTE: Duration = Duration::from_millis(2);

/// Delay of a frame that comes whole.
const SLOW_FRAME: Duration = Duration::from_millis(5);
