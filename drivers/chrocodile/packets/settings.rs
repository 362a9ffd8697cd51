//! Settings of the packet protocol.

use std::time::Duration;

use asphera_link::{Channel, MAX_CHANNELS, Problem, Unit, check_range};

use crate::Trigger;
use crate::settings::{channels, check_exposures, check_signals, longest_gap};
use crate::wire::{Mode, Part, Quantity, Signal};

/// Orders of the driver to the device, and how it judges what comes back.
#[derive(Clone, Debug, PartialEq)]
pub struct PacketSettings {
    /// Identifiers of the signals of a sample (`SODX`). 1 to 32, each once, in the order of the channels.
    pub signals: Vec<u16>,
    /// Exposures per second in Hz (`SHZ`), 1 to 100000; the device refuses what it cannot do.
    pub sample_rate_hz: f64,
    /// Exposures averaged into one sample (`AVD`), 1 to 10000.
    pub averaging: u16,
    /// What starts an exposure (`CTN`, `TRE`).
    pub trigger: Trigger,
    /// Full scale of the probe in µm. `None`: the device is asked (`SCA`).
    pub scale_um: Option<f64>,
    /// Intensity below which a reading is weak, or a point of a line is missing, in the unit the device sends.
    pub intensity_min: f64,
    /// Point of the device that readings are of, counted from 1. Not for a line.
    pub point: u16,
    /// Distance of neighbouring points of a line sensor, µm: each reading then has a profile of all points.
    pub pitch_um: Option<f64>,
    /// How long the device may take to answer a command, in ms. It is asked twice.
    pub ready_timeout_ms: u32,
}

impl Default for PacketSettings {
    fn default() -> PacketSettings {
        PacketSettings {
            signals: vec![75, 76, 65, 256, 257],
            sample_rate_hz: 1000.0,
            averaging: 1,
            trigger: Trigger::Each,
            scale_um: None,
            intensity_min: 0.0,
            point: 1,
            pitch_um: None,
            ready_timeout_ms: 1000,
        }
    }
}

impl PacketSettings {
    /// Everything that is wrong with them; empty when a driver can be made.
    pub fn problems(&self) -> Vec<Problem> {
        let mut problems = Vec::new();
        check_signals(&mut problems, &self.signals, self.intensity_min);
        let exposures = (self.sample_rate_hz, self.averaging);
        check_exposures(&mut problems, exposures, self.scale_um, self.intensity_min);
        check_range(&mut problems, "point", self.point, 1, u16::MAX);
        check_range(&mut problems, "ready_timeout_ms", self.ready_timeout_ms, 10, 60_000);
        if let Some(pitch_um) = self.pitch_um {
            check_range(&mut problems, "pitch_um", pitch_um, 0.01, 1e5);
            self.line_problems(&mut problems);
        }
        problems
    }

    /// A line has one distance a point, and the intensity of the same peak.
    fn line_problems(&self, problems: &mut Vec<Problem>) {
        let distances: Vec<u8> = self.peaks().filter_map(|peak| distance_of(peak.1)).collect();
        for (index, signal) in self.peaks() {
            let fits = match signal.quantity {
                Quantity::Peak { mode: Mode::Distance, part: Part::Value, .. } => {
                    distances.len() == 1
                }
                Quantity::Peak { mode: Mode::Distance, part: Part::Intensity, number } => {
                    distances.contains(&number)
                }
                _ => false,
            };
            if !fits {
                let expected = "of a line one distance, and the intensity of its peak";
                let key = format!("signals[{index}]");
                problems.push(Problem::new(key, expected, signal.id));
            }
        }
        if distances.is_empty() {
            let expected = "a distance such as 256, as pitch_um makes it a line";
            problems.push(Problem::new("signals", expected, format!("{:?}", self.signals)));
        }
        let channels = self.channels().len();
        if channels > MAX_CHANNELS {
            let expected = format!("at most {} signals of a whole sample", MAX_CHANNELS - 1);
            problems.push(Problem::new("signals", expected, channels - 1));
        }
        if self.point != 1 {
            let expected = "no point where pitch_um makes it a line";
            problems.push(Problem::new("point", expected, self.point));
        }
    }

    fn peaks(&self) -> impl Iterator<Item = (usize, Signal)> + '_ {
        let known = self.signals.iter().map(|&id| Signal::from_id(id).ok());
        let of_peaks = |signal: &Signal| matches!(signal.quantity, Quantity::Peak { .. });
        known.enumerate().filter_map(move |(index, signal)| Some((index, signal.filter(of_peaks)?)))
    }

    /// Channels of the readings in the order of the signals. Of a line those of the whole sample, and `valid`, how many
    /// points of the profile have a value.
    pub fn channels(&self) -> Vec<Channel> {
        if self.pitch_um.is_none() {
            return channels(&self.signals);
        }
        let globals: Vec<u16> =
            self.signals.iter().copied().filter(|id| id & 0x0100 == 0).collect();
        let mut channels = channels(&globals);
        channels.push(Channel::new("valid", Unit::One));
        channels
    }

    pub(crate) fn longest_gap(&self) -> Duration {
        longest_gap(self.sample_rate_hz, self.averaging, self.ready_timeout_ms)
    }

    /// Whether the time of a sample follows from that of its packet: the device runs free, and a sample is an exposure.
    pub(crate) fn times_samples(&self) -> bool {
        self.trigger == Trigger::Free && self.averaging == 1
    }
}

/// Number of the peak whose distance this is.
pub(super) fn distance_of(signal: Signal) -> Option<u8> {
    match signal.quantity {
        Quantity::Peak { mode: Mode::Distance, part: Part::Value, number } => Some(number),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn channels_of_a_point_and_of_a_line() {
        let names = |settings: &PacketSettings| -> Vec<String> {
            assert_eq!(settings.problems(), []);
            settings.channels().into_iter().map(|channel| channel.name).collect()
        };
        let point = PacketSettings::default();
        assert_eq!(names(&point), ["encoder_x", "distance1", "intensity1"]);
        let line = PacketSettings { pitch_um: Some(5.0), ..point };
        assert_eq!(names(&line), ["encoder_x", "valid"]);
    }

    #[test]
    fn each_problem_names_its_key() {
        let keys = |settings: PacketSettings| -> Vec<String> {
            settings.problems().into_iter().map(|problem| problem.key).collect()
        };
        let defaults = PacketSettings::default;
        assert_eq!(keys(PacketSettings { signals: vec![], ..defaults() }), ["signals", "signals"]);
        assert_eq!(keys(PacketSettings { point: 0, ..defaults() }), ["point"]);
        assert_eq!(keys(PacketSettings { averaging: 0, ..defaults() }), ["averaging"]);
        assert_eq!(keys(PacketSettings { scale_um: Some(0.0), ..defaults() }), ["scale_um"]);
        let line = |signals| PacketSettings { signals, pitch_um: Some(1.0), ..defaults() };
        assert_eq!(keys(line(vec![65, 257])), ["signals[1]", "signals"]);
        assert_eq!(keys(line(vec![256, 264])), ["signals[0]", "signals[1]"]);
        assert_eq!(keys(line(vec![256, 265])), ["signals[1]"]);
        assert_eq!(keys(line(vec![256, 768])), ["signals[1]"]);
        assert_eq!(keys(PacketSettings { point: 2, ..line(vec![256]) }), ["point"]);
        assert_eq!(keys(PacketSettings { pitch_um: Some(0.0), ..defaults() }), ["pitch_um"]);
    }
}
