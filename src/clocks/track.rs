//! The way of a companion: its readings in the order of their times, and what it showed in between.

use std::collections::VecDeque;

use asphera_link::{Flags, MAX_CHANNELS, Nanos, Reading, Values};

use crate::clock::{Clock, Placed};
use crate::keeper::{Keeper, Moment};

/// Readings of one companion.
#[derive(Debug, Default)]
pub(crate) struct Track {
    entries: VecDeque<Entry>,
    /// Counts the interruptions: between readings before and after one nothing is known.
    piece: u32,
    /// Readings that were passed over: without a time of their own.
    pub(crate) untimed: u64,
}

#[derive(Debug)]
struct Entry {
    moment: Moment,
    piece: u32,
    reading: Reading,
}

/// Answer of a track.
#[derive(Debug)]
pub(crate) enum Between {
    /// Readings before and after the time are there.
    Found(Box<Interpolated>),
    /// The next reading may bring it.
    NotYet,
    /// No reading will.
    Never,
}

/// Values of a companion at a time between two of its readings.
#[derive(Debug)]
pub(crate) struct Interpolated {
    /// A reading as it would have been.
    pub(crate) reading: Reading,
    /// Standard uncertainty of each channel by the interpolation, in its unit; infinite where nothing bounds it.
    pub(crate) u: [f64; MAX_CHANNELS],
}

/// What is asked of a track.
pub(crate) struct Question<'a> {
    pub(crate) keeper: &'a Keeper,
    /// The time, ns, and its standard uncertainty.
    pub(crate) at_ns: f64,
    pub(crate) u_ns: f64,
    /// Longest time between two readings that is interpolated.
    pub(crate) gap_ns: f64,
    /// Values of a full turn of each channel that turns; 0 of others.
    pub(crate) turns: &'a [f64; MAX_CHANNELS],
    pub(crate) now: Nanos,
}

impl Track {
    /// Takes the next reading.
    pub(crate) fn push(&mut self, moment: Moment, reading: Reading, capacity: usize) {
        let same =
            |entry: &Entry| matches!(entry.moment, Moment::Arrival(_)) && entry.moment == moment;
        if self.entries.back().is_some_and(same) {
            // Several by one read of the port: the last alone is as new as its arrival.
            self.entries.pop_back();
            self.untimed += 1;
        }
        self.entries.push_back(Entry { moment, piece: self.piece, reading });
        if self.entries.len() > capacity {
            self.entries.pop_front();
        }
    }

    /// Between the readings before and those after nothing is known.
    pub(crate) fn interrupted(&mut self) {
        self.piece += 1;
    }

    /// Forgets what arrived before `host`, but for the readings that a time from then on needs.
    pub(crate) fn forget_before(&mut self, host: Nanos) {
        while self.entries.get(NEEDED).is_some_and(|entry| entry.reading.host < host) {
            self.entries.pop_front();
        }
    }

    /// What the companion showed at a time. Times asked for never go back, but for what the clocks' lines change.
    pub(crate) fn at(&mut self, question: &Question<'_>) -> Between {
        let mut index = 0;
        loop {
            let Some(entry) = self.entries.get(index) else { return Between::NotYet };
            match question.keeper.placed(entry.moment, question.now) {
                Placed::NotYet => return Between::NotYet,
                Placed::Never => {
                    self.entries.remove(index);
                    self.untimed += 1;
                    self.piece += 1;
                    self.entries.iter_mut().skip(index).for_each(|entry| entry.piece += 1);
                }
                Placed::At { ns, .. } if ns >= question.at_ns => break,
                Placed::At { .. } if index > NEEDED => {
                    self.entries.pop_front();
                }
                Placed::At { .. } => index += 1,
            }
        }
        self.before(index, question).map_or(Between::Never, |found| Between::Found(Box::new(found)))
    }

    /// Interpolates between the entry `next` and the one before; two more before show how the motion bends.
    fn before(&self, next: usize, question: &Question<'_>) -> Option<Interpolated> {
        let first = next.checked_sub(3)?;
        let mut times_ns = [0.0; 4];
        let mut u_ns: f64 = 0.0;
        let entries: [&Entry; 4] = std::array::from_fn(|at| &self.entries[first + at]);
        for (at, entry) in entries.iter().enumerate() {
            let Placed::At { ns, u_ns: own_ns } =
                question.keeper.placed(entry.moment, question.now)
            else {
                return None;
            };
            (times_ns[at], u_ns) = (ns, own_ns);
        }
        let is_one_piece = entries.windows(2).all(|pair| pair[0].is_followed_by(pair[1]));
        let is_dense = times_ns.windows(2).all(|pair| {
            let gap_ns = pair[1] - pair[0];
            gap_ns > 0.0 && gap_ns <= question.gap_ns
        });
        if !is_one_piece || !is_dense {
            return None;
        }
        let times_s = times_ns.map(|ns| (ns - question.at_ns) * 1e-9);
        let u_s = u_ns.hypot(question.u_ns) * 1e-9;
        let mut u = [0.0; MAX_CHANNELS];
        let [before, after] = [&entries[2].reading, &entries[3].reading];
        let values = (0..before.values.len()).map(|channel| {
            let four = entries.map(|entry| entry.reading.values.get(channel));
            let (value, u_value) = interpolated(four, &times_s, u_s, question.turns[channel])?;
            u[channel] = u_value;
            Some(value)
        });
        let values: Values = values.collect();
        let flags: Flags = before.flags | after.flags;
        let host = after.host;
        let reading = Reading { host, device_time_ns: None, count: None, values, flags };
        Some(Interpolated { reading, u })
    }
}

impl Entry {
    fn is_followed_by(&self, next: &Entry) -> bool {
        let is_one_run = match (self.moment, next.moment) {
            (Moment::Device(one), Moment::Device(other)) => {
                Clock::run_of(one) == Clock::run_of(other)
            }
            (Moment::Arrival(_), Moment::Arrival(_)) => true,
            _ => false,
        };
        is_one_run && self.piece == next.piece
    }
}

/// Value at time 0 between the last two of four, and its standard uncertainty.
///
/// A motion x(t) lies off the chord of length L by at most M·L²/8, with M the largest |x''| in between. M is taken from the
/// second differences of the four readings: the larger of the two, and by how much they differ, as much again as it may
/// change on the way. It bounds, so it counts whole; and it is as large near the ends, for a counter that begins again at its
/// zero bends nowhere else. An error of the times counts by the speed.
fn interpolated(
    four: [Option<f64>; 4],
    times_s: &[f64; 4],
    u_s: f64,
    turn: f64,
) -> Option<(f64, f64)> {
    let (before, after) = (four[2]?, four[3]?);
    let (step, is_clear) = way(before, after, turn);
    let length_s = times_s[3] - times_s[2];
    let share = -times_s[2] / length_s;
    let speed = step / length_s;
    let value = before + share * step;
    let (Some(a), Some(b)) = (four[0], four[1]) else { return Some((value, f64::INFINITY)) };
    let ((first, first_clear), (second, second_clear)) = (way(a, b, turn), way(b, before, turn));
    if !(is_clear && first_clear && second_clear) {
        return Some((value, f64::INFINITY));
    }
    let speeds = [first / (times_s[1] - times_s[0]), second / (times_s[2] - times_s[1]), speed];
    let bend = |at: usize| 2.0 * (speeds[at + 1] - speeds[at]) / (times_s[at + 2] - times_s[at]);
    let (earlier, later) = (bend(0), bend(1));
    let most = earlier.abs().max(later.abs()) + (later - earlier).abs();
    let bulge = most * length_s * length_s / 8.0;
    Some((value, (speed.abs() * u_s).hypot(bulge)))
}

/// Way from one value to the next, for one that turns the shorter way round, and whether that is clear.
fn way(from: f64, to: f64, turn: f64) -> (f64, bool) {
    let way = to - from;
    if turn <= 0.0 {
        return (way, true);
    }
    let way = way - turn * (way / turn).round();
    (way, way.abs() <= turn / 4.0)
}

/// Readings before the one after a time: the one before it, two that show how the motion bends, and one to spare.
const NEEDED: usize = 4;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_shorter_way_round_is_taken_and_half_a_turn_is_none() {
        assert_eq!(way(350.0, 10.0, 360.0), (20.0, true));
        assert_eq!(way(10.0, 350.0, 360.0), (-20.0, true));
        assert!(!way(0.0, 100.0, 360.0).1);
        assert_eq!(way(350.0, 10.0, 0.0), (-340.0, true));
    }

    #[test]
    fn a_parabola_lies_within_the_bulge_and_a_line_has_none() {
        let times_s = [-0.25, -0.15, -0.05, 0.05];
        let bent = times_s.map(|t| Some(3.0 * t * t + t + 7.0));
        let (value, u) = interpolated(bent, &times_s, 0.0, 0.0).unwrap();
        assert!((value - 7.0 - 3.0 * 0.0025).abs() < 1e-12, "{value}");
        assert!((u - 3.0 * 0.0025).abs() < 1e-12, "{u}");
        let straight = times_s.map(|t| Some(5.0 * t));
        let (value, u) = interpolated(straight, &times_s, 1e-3, 0.0).unwrap();
        assert!(value.abs() < 1e-12 && (u - 5e-3).abs() < 1e-9, "{value} {u}");
    }

    #[test]
    fn a_missing_neighbour_bounds_nothing_and_a_missing_end_is_a_gap() {
        let times_s = [-0.25, -0.15, -0.05, 0.05];
        let (_, u) =
            interpolated([None, Some(1.0), Some(1.0), Some(1.0)], &times_s, 0.0, 0.0).unwrap();
        assert_eq!(u, f64::INFINITY);
        assert_eq!(interpolated([Some(1.0), Some(1.0), None, Some(1.0)], &times_s, 0.0, 0.0), None);
    }
}
