//! The device: commands in, replies out.

use crate::AxisSettings;
use crate::axis::Axis;

/// A controller with one or more linear axes. Times are seconds that never go back.
#[derive(Clone, Debug)]
pub struct Stage {
    address: u8,
    axes: Vec<Axis>,
    /// Warning flags that are set, the first counts most.
    warnings: Vec<&'static str>,
    line: Vec<u8>,
    is_silent: bool,
    moves: u64,
}

/// Something that happens to the stage.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Fault {
    /// It has lost its reference, as after it was switched off and on.
    NotHomed,
    /// An axis (from 0) runs into an end it should not have reached.
    Limit(usize),
    /// An axis (from 0) is blocked.
    Stall(usize),
    /// It answers nothing from now on, or again.
    Silent(bool),
    /// Someone turns the knob of an axis (from 0) by so many mm.
    Knob(usize, f64),
}

impl Stage {
    /// A stage at an address, homed and at rest. At most 9 axes.
    pub fn new(address: u8, axes: &[AxisSettings]) -> Stage {
        Stage {
            address,
            axes: axes.iter().take(9).map(|&axis| Axis::new(axis)).collect(),
            warnings: Vec::new(),
            line: Vec::new(),
            is_silent: false,
            moves: 0,
        }
    }

    /// Positions in mm.
    pub fn places_mm(&self, now_s: f64) -> Vec<f64> {
        let mm = |axis: &Axis| axis.state(now_s).0 * axis.settings.microstep_um * 1e-3;
        self.axes.iter().map(mm).collect()
    }

    /// Whether an axis moves.
    pub fn is_moving(&self, now_s: f64) -> bool {
        self.axes.iter().any(|axis| axis.is_busy(now_s))
    }

    /// Moves that were accepted so far.
    pub fn moves(&self) -> u64 {
        self.moves
    }

    /// Takes bytes and gives the replies.
    pub fn receive(&mut self, now_s: f64, bytes: &[u8]) -> Vec<u8> {
        let mut replies = Vec::new();
        for &byte in bytes {
            if !matches!(byte, b'\n' | b'\r') {
                self.line.push(byte);
                continue;
            }
            let line = std::mem::take(&mut self.line);
            if let Ok(line) = std::str::from_utf8(&line)
                && let Some(reply) = self.command(now_s, line)
                && !self.is_silent
            {
                replies.extend(reply.into_bytes());
            }
        }
        replies
    }

    /// Lets something happen.
    pub fn fault(&mut self, now_s: f64, fault: Fault) {
        match fault {
            Fault::NotHomed => self.warn("WR"),
            Fault::Limit(axis) => {
                self.axes[axis].block(now_s);
                self.warn("WL");
            }
            Fault::Stall(axis) => {
                self.axes[axis].block(now_s);
                self.warn("FS");
            }
            Fault::Silent(is_silent) => self.is_silent = is_silent,
            Fault::Knob(axis, by_mm) => {
                let axis = &mut self.axes[axis];
                let to = axis.state(now_s).0 + by_mm * 1000.0 / axis.settings.microstep_um;
                axis.go(now_s, to.round());
            }
        }
    }

    fn warn(&mut self, letters: &'static str) {
        if !self.warnings.contains(&letters) {
            self.warnings.push(letters);
            // Faults before warnings before notices.
            self.warnings.sort_by_key(|letters| match letters.as_bytes()[0] {
                b'F' => 0,
                b'W' => 1,
                _ => 2,
            });
        }
    }

    /// `/1 2 34 words`: device, axis and number of the message may be left out.
    fn command(&mut self, now_s: f64, line: &str) -> Option<String> {
        let mut words: Vec<&str> = line.strip_prefix('/')?.split_whitespace().collect();
        let mut number = || {
            let number = words.first().and_then(|word| word.parse::<u8>().ok());
            if number.is_some() {
                words.remove(0);
            }
            number
        };
        let (device, axis, message) = (number().unwrap_or(0), number().unwrap_or(0), number());
        if ![0, self.address].contains(&device) {
            return None;
        }
        let data = match usize::from(axis) {
            0 => self.execute(now_s, 0..self.axes.len(), &words),
            one if one <= self.axes.len() => self.execute(now_s, one - 1..one, &words),
            _ => Err("BADAXIS"),
        };
        let busy = match axis {
            0 => self.is_moving(now_s),
            one => self.axes.get(usize::from(one) - 1).is_some_and(|axis| axis.is_busy(now_s)),
        };
        let message = message.map_or(String::new(), |message| format!(" {message:02}"));
        let (flag, data) = match data {
            Ok(data) => ("OK", data),
            Err(reason) => ("RJ", reason.to_owned()),
        };
        let state = if busy { "BUSY" } else { "IDLE" };
        let warning = self.warnings.first().unwrap_or(&"--");
        Some(format!("@{:02} {axis}{message} {flag} {state} {warning} {data}\r\n", self.address))
    }

    fn execute(
        &mut self,
        now_s: f64,
        axes: std::ops::Range<usize>,
        words: &[&str],
    ) -> Result<String, &'static str> {
        let number = |word: &str| word.parse::<i64>().map_err(|_| "BADDATA");
        match *words {
            [] => Ok("0".to_owned()),
            ["get", "pos"] => {
                let shown = axes.map(|axis| self.axes[axis].shown(now_s).to_string());
                Ok(shown.collect::<Vec<_>>().join(" "))
            }
            ["set", name @ ("maxspeed" | "accel"), word] => {
                let data = number(word)?;
                if data <= 0 {
                    return Err("BADDATA");
                }
                for axis in axes {
                    let axis = &mut self.axes[axis];
                    *(if name == "accel" { &mut axis.accel } else { &mut axis.maxspeed }) = data;
                }
                Ok("0".to_owned())
            }
            ["warnings"] => {
                let all: Vec<&str> = self.warnings.clone();
                let count = format!("{:02}", all.len());
                Ok(std::iter::once(count.as_str()).chain(all).collect::<Vec<_>>().join(" "))
            }
            ["warnings", "clear"] => {
                self.warnings.retain(|letters| *letters == "WR");
                Ok("00".to_owned())
            }
            ["home"] => {
                self.warnings
                    .retain(|letters| !matches!(*letters, "WR" | "WH" | "WL" | "FS" | "NI"));
                axes.for_each(|axis| self.axes[axis].go(now_s, 0.0));
                Ok("0".to_owned())
            }
            ["stop"] => {
                if axes.clone().any(|axis| self.axes[axis].is_busy(now_s)) {
                    self.warn("NI");
                }
                axes.for_each(|axis| self.axes[axis].stop(now_s));
                Ok("0".to_owned())
            }
            ["move", "abs", word] => {
                let to = number(word)?;
                if axes.clone().any(|axis| to < 0 || to > self.axes[axis].longest()) {
                    return Err("BADDATA");
                }
                self.warnings.retain(|letters| *letters != "NI");
                self.moves += 1;
                axes.for_each(|axis| self.axes[axis].go(now_s, to as f64));
                Ok("0".to_owned())
            }
            _ => Err("BADCOMMAND"),
        }
    }
}
