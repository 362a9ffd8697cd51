//! The speed along a curved piece, as high as the axes allow.
//!
//! The speed limit at a node is the scan speed, or less where an axis would exceed its speed, or its acceleration at constant speed. From
//! there the speed rises and falls as the rest of the acceleration of each axis allows: one pass forward and one back, as in
//! J. E. Bobrow, S. Dubowsky, J. S. Gibson, Int. J. Robotics Research 4 (1985) 3-17, doi:10.1177/027836498500400301, without its switching
//! points: constant speed is always allowed below the limit. Between nodes the acceleration is constant.

use crate::piece::Motion;
use crate::{Axis, Machine, Piece};

/// Speeds and times at nodes of the way.
pub(crate) struct Speeds {
    ways_mm: Vec<f64>,
    speeds_mm_s: Vec<f64>,
    times_s: Vec<f64>,
}

impl Speeds {
    /// The run of a piece from rest to rest.
    pub(crate) fn new(piece: &Piece, machine: &Machine, speed_mm_s: f64) -> Speeds {
        let ways_mm = nodes(piece);
        let count = ways_mm.len() - 1;
        let step_mm = |k: usize| ways_mm[k + 1] - ways_mm[k];
        let motions: Vec<Motion> =
            ways_mm.iter().map(|&way_mm| machine.motion(piece, way_mm)).collect();
        let axes = machine.axes();
        let mut squares: Vec<f64> =
            motions.iter().map(|motion| limit(motion, &axes, speed_mm_s).powi(2)).collect();
        squares[0] = 0.0;
        squares[count] = 0.0;
        for k in 0..count {
            let rise = spare(&motions[k], &axes, squares[k]);
            squares[k + 1] = squares[k + 1].min(squares[k] + 2.0 * step_mm(k) * rise);
        }
        for k in (0..count).rev() {
            let fall = spare(&motions[k + 1], &axes, squares[k + 1]);
            squares[k] = squares[k].min(squares[k + 1] + 2.0 * step_mm(k) * fall);
        }
        let speeds_mm_s: Vec<f64> = squares.into_iter().map(f64::sqrt).collect();
        let mut times_s = vec![0.0];
        for (k, pair) in speeds_mm_s.windows(2).enumerate() {
            times_s.push(times_s[k] + 2.0 * step_mm(k) / (pair[0] + pair[1]));
        }
        Speeds { ways_mm, speeds_mm_s, times_s }
    }

    pub(crate) fn duration_s(&self) -> f64 {
        self.times_s[self.times_s.len() - 1]
    }

    /// When a part of the way is behind, in s.
    pub(crate) fn time_at_s(&self, way_mm: f64) -> f64 {
        let last = self.ways_mm.len() - 2;
        let k = self.ways_mm.partition_point(|&at| at <= way_mm).saturating_sub(1).min(last);
        let gone = (way_mm - self.ways_mm[k]).max(0.0);
        let step = self.ways_mm[k + 1] - self.ways_mm[k];
        let [begin, end] = [self.speeds_mm_s[k], self.speeds_mm_s[k + 1]];
        // The square of the speed grows evenly with the way.
        let square = begin * begin + (end * end - begin * begin) * gone / step;
        let mean = begin + square.max(0.0).sqrt();
        self.times_s[k] + if mean > 0.0 { 2.0 * gone / mean } else { 0.0 }
    }

    /// The length that is run at a speed.
    pub(crate) fn length_at(&self, speed_mm_s: f64) -> f64 {
        let full = |speed: f64| speed >= speed_mm_s * (1.0 - 1e-9);
        let steps = self.ways_mm.windows(2).zip(self.speeds_mm_s.windows(2));
        steps
            .filter(|(_, speeds)| full(speeds[0]) && full(speeds[1]))
            .map(|(ways, _)| ways[1] - ways[0])
            .sum()
    }
}

/// The largest speed in mm/s at which no axis exceeds a limit without the path speed changing.
fn limit(motion: &Motion, axes: &[Axis; 2], speed_mm_s: f64) -> f64 {
    let mut speed = speed_mm_s;
    for (axis, (&rate, &bend)) in axes.iter().zip(motion.rate.iter().zip(&motion.bend)) {
        if rate != 0.0 {
            speed = speed.min(axis.speed / rate.abs());
        }
        if bend != 0.0 {
            speed = speed.min((axis.acceleration / bend.abs()).sqrt());
        }
    }
    speed
}

/// The change of the speed in mm/s² that each axis has acceleration left for, whichever its sign.
fn spare(motion: &Motion, axes: &[Axis; 2], square: f64) -> f64 {
    let mut spare = f64::INFINITY;
    for (axis, (&rate, &bend)) in axes.iter().zip(motion.rate.iter().zip(&motion.bend)) {
        if rate != 0.0 {
            let left = (axis.acceleration - bend.abs() * square).max(0.0);
            spare = spare.min(left / rate.abs());
        }
    }
    spare
}

/// Lengths of way at which the speed is found: evenly by the angle, and closer and closer towards both ends, where it rises and falls.
fn nodes(piece: &Piece) -> Vec<f64> {
    let turned = piece.turned_rad() / std::f64::consts::TAU;
    let count = ((turned * NODES_A_TURN) as usize).clamp(LEAST_NODES, MOST_NODES);
    let even: Vec<f64> = (0..=count).map(|k| piece.way_at_mm(k as f64 / count as f64)).collect();
    let [first, last] = [even[1], even[count] - even[count - 1]];
    let halves = (1..=HALVES).map(|k| (-f64::from(k)).exp2());
    let begin = halves.clone().rev().map(|share| share * first);
    let end = halves.map(|share| even[count] - share * last);
    let middle = even[1..count].iter().copied();
    let all = [0.0].into_iter().chain(begin).chain(middle).chain(end).chain([even[count]]);
    let mut ways: Vec<f64> = all.collect();
    ways.dedup_by(|next, before| *next <= *before);
    ways
}

/// Steps in a turn.
const NODES_A_TURN: f64 = 256.0;
/// Steps of a short piece, and of any.
const LEAST_NODES: usize = 256;
const MOST_NODES: usize = 4_000_000;
/// How often the first and the last step are halved.
const HALVES: i32 = 24;
