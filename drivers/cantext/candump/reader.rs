//! A log from its first line on.

use std::fmt;

use asphera_link::CanFrame;

use super::{Content, Line, MAX_LINE};
use crate::BusError;

/// Bytes of a log, cut anywhere, to frames of one interface, with the number of each line that is left out.
///
/// O(1) memory: a line longer than [`MAX_LINE`] is no line.
#[derive(Clone, Debug)]
pub struct Reader {
    /// The interface whose frames are wanted; `None`: those of all.
    interface: Option<String>,
    /// Whether CAN FD frames are given.
    gives_fd: bool,
    line: Vec<u8>,
    /// Bytes of the unfinished line, also of those that no longer fit.
    pending: u64,
    /// Lines that have ended.
    lines: u64,
    frames: u64,
    left_out: Vec<LeftOut>,
}

/// Content of a line that somebody must know of.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Item {
    /// A frame of the interface: classic, or CAN FD where it is wanted.
    Frame(CanFrame),
    /// An error frame of the interface.
    BusError(BusError),
    /// A line that gives no frame.
    LeftOut {
        /// Bytes of the line with its end.
        bytes: u64,
        /// Number of the line and reason.
        why: String,
    },
}

/// Lines left out for the same reason.
#[derive(Clone, Debug, PartialEq, Eq)]
struct LeftOut {
    kind: &'static str,
    count: u64,
    first: u64,
}

impl Reader {
    /// A reader of classic frames before the first line. Without `interface` it takes the frames of every one.
    pub fn new(interface: Option<String>) -> Reader {
        Reader {
            interface,
            gives_fd: false,
            line: Vec::new(),
            pending: 0,
            lines: 0,
            frames: 0,
            left_out: Vec::new(),
        }
    }

    /// The same reader, which gives CAN FD frames too where `gives_fd` says so.
    #[must_use]
    pub fn with_fd(self, gives_fd: bool) -> Reader {
        Reader { gives_fd, ..self }
    }

    /// Bytes that wait for the end of their line.
    pub fn pending(&self) -> u64 {
        self.pending
    }

    /// Takes bytes off the front of `input` up to the next item, or all of them if no item ends in them.
    #[must_use]
    pub fn read(&mut self, input: &mut &[u8]) -> Option<Item> {
        while let Some(end) = input.iter().position(|&byte| byte == b'\n') {
            let (head, rest) = input.split_at(end);
            *input = &rest[1..];
            self.store(head);
            let bytes = self.pending + 1;
            self.lines += 1;
            let line = std::mem::take(&mut self.line);
            let item = self.item(&line, bytes);
            self.line = line;
            self.line.clear();
            self.pending = 0;
            if item.is_some() {
                return item;
            }
        }
        self.store(input);
        *input = &[];
        None
    }

    fn store(&mut self, bytes: &[u8]) {
        let free = MAX_LINE.saturating_sub(self.line.len());
        self.line.extend_from_slice(&bytes[..bytes.len().min(free)]);
        self.pending += bytes.len() as u64;
    }

    fn item(&mut self, line: &[u8], bytes: u64) -> Option<Item> {
        if self.pending > MAX_LINE as u64 {
            let why = format!("expected at most {MAX_LINE} bytes, found {}", self.pending);
            return Some(self.leave_out(bytes, MALFORMED, &why));
        }
        let line = line.trim_ascii();
        if line.is_empty() {
            return None;
        }
        let line = match Line::parse(line) {
            Ok(line) => line,
            Err(error) => return Some(self.leave_out(bytes, MALFORMED, &error)),
        };
        if self.interface.as_ref().is_some_and(|wanted| wanted != line.interface) {
            return None;
        }
        Some(match line.content {
            Content::Frame(frame) if frame.fd().is_some() && !self.gives_fd => {
                self.leave_out(bytes, FLEXIBLE, &CLASSIC_ONLY)
            }
            Content::Frame(frame) => {
                self.frames += 1;
                Item::Frame(frame)
            }
            Content::BusError(error) => Item::BusError(error),
            Content::ExtraLong => self.leave_out(bytes, EXTRA_LONG, &NO_XL),
        })
    }

    fn leave_out(&mut self, bytes: u64, kind: &'static str, why: &dyn fmt::Display) -> Item {
        let number = self.lines;
        match self.left_out.iter_mut().find(|known| known.kind == kind) {
            Some(known) => known.count += 1,
            None => self.left_out.push(LeftOut { kind, count: 1, first: number }),
        }
        Item::LeftOut { bytes, why: format!("line {number} of the log is {kind}: {why}") }
    }

    /// Number of frames given, and the lines that were left out with the first of each kind.
    pub fn summary(&self) -> String {
        let mut text = format!("{} frames in {} lines", self.frames, self.lines);
        for LeftOut { kind, count, first } in &self.left_out {
            text += &format!("; {count} times {kind}, first in line {first}");
        }
        text
    }
}

const MALFORMED: &str = "no line of candump";
const FLEXIBLE: &str = "a CAN FD frame";
const EXTRA_LONG: &str = "a CAN XL frame";
const CLASSIC_ONLY: &str = "drivers read classic frames alone, of up to 8 bytes";
const NO_XL: &str = "no driver reads it";
