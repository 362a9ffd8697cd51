//! The orders in which points arrive, each point computed from its number alone.
//!
//! A scan of any length is generated batch by batch, never stored: irregularities are a hash of the
//! seed and the number of the coordinate, not the state of a generator.

use std::f64::consts::{PI, TAU};

use asphera_geometry::PointMm;
use clap::ValueEnum;
use serde::Serialize;

/// Distance in mm between neighbours along a track and, unless said otherwise, between tracks.
///
/// A decimal fraction has no exact double: its multiples are rounded, so that points of an exact
/// grid lie nearly, but not exactly, on lines and circles.
const PITCH_MM: f64 = 0.003;

/// Largest shift of a point of the jittered grid, each coordinate to either side, in pitches.
const JITTER: f64 = 0.05;

/// Largest shift of a point of the line scanner along its line, to either side, in pitches.
const LINE_JITTER: f64 = 0.02;

/// Points a line of the line scanner has.
const LINE_POINTS: usize = 3200;

/// Distance between lines of the line scanner in pitches.
const LINE_PITCHES: f64 = 1.5;

/// Points a ring has.
const RING_POINTS: usize = 1000;

/// Points a ring has, of rings from the outside: a batch of 1,000 is not quite one.
const INWARD_RING_POINTS: usize = 1071;

/// Radius in mm of the sphere whose cap about the origin is measured: below it by far stays every
/// scan that fits into memory.
const SPHERE_RADIUS_MM: f64 = 10_000.0;

/// In which order the points of a surface arrive.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, ValueEnum)]
#[serde(rename_all = "kebab-case")]
pub(crate) enum Order {
    /// A square grid, row by row, every other row backwards; coordinates are column times pitch and
    /// row times pitch.
    ExactGrid,
    /// The same with every coordinate moved by up to 5 % of the pitch.
    JitteredGrid,
    /// An Archimedean spiral from the centre, tracks one pitch apart and points one pitch apart.
    Spiral,
    /// Rings of 1,000 points about the centre, one pitch apart, from the inside.
    Rings,
    /// Evenly scattered over a square, in no order.
    Random,
    /// Lines of 3,200 points, all in the same direction and one and a half pitches apart; points
    /// are moved along their line by up to 2 % of the pitch.
    LineScanner,
    /// A closed curve, r = 10 + 0.8 cos 7t + 0.3 sin 13t, traced once: triangles reach from side to side, and most of
    /// those about its end change with each point.
    Outline,
    /// Points in no order.
    OutlineShuffled,
    /// Two circles of radius 1 mm whose middles lie 100 mm apart, traced by turns a point each: triangles reach from one to
    /// the other.
    TwoOutlines,
    /// Points in no order.
    TwoOutlinesShuffled,
    /// A star of six spikes, traced once.
    Star,
    /// Points in no order.
    StarShuffled,
    /// A spiral of nine turns from the outside: each point sees all that is inside it.
    SpiralIn,
    /// Points in no order.
    SpiralInShuffled,
    /// Scattered evenly over a disc, by their distance from its middle: each batch lies about the hull, at any angle.
    FromInside,
    /// Points in no order.
    FromInsideShuffled,
    /// Rings of 1,071 points about the centre, one pitch apart, from the outside.
    RingsIn,
    /// Points in no order.
    RingsInShuffled,
    /// A rosette of 8.454 petals and 4.9 turns, through the middle with each petal.
    Rosette,
    /// Points in no order.
    RosetteShuffled,
}

impl Order {
    /// The name as options and reports have it.
    pub(crate) fn name(self) -> String {
        let value = self.to_possible_value().expect("no order is hidden from the options");
        value.get_name().to_owned()
    }

    /// Whether they are the points of another order, shuffled.
    pub(crate) fn is_shuffled(self) -> bool {
        matches!(
            self,
            Order::OutlineShuffled
                | Order::TwoOutlinesShuffled
                | Order::StarShuffled
                | Order::SpiralInShuffled
                | Order::FromInsideShuffled
                | Order::RingsInShuffled
                | Order::RosetteShuffled
        )
    }

    /// Whether four points on one circle, or three on a line at the outline, would be an accident:
    /// then there is one Delaunay triangulation, and every implementation must find as many
    /// triangles.
    pub(crate) fn is_in_general_position(self) -> bool {
        matches!(
            self,
            Order::JitteredGrid | Order::Random | Order::FromInside | Order::FromInsideShuffled
        )
    }
}

/// A scan: how many points arrive in which order.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Scan {
    pub(crate) order: Order,
    pub(crate) count: usize,
    pub(crate) seed: u64,
}

impl Scan {
    /// The points as they arrive.
    pub(crate) fn points(self) -> impl Iterator<Item = PointMm> {
        let columns = self.columns();
        (0..self.count).map(move |index| self.point(index, columns))
    }

    /// Calls `take` with one batch after the other; the last may be smaller.
    pub(crate) fn for_each_batch(self, batch: usize, mut take: impl FnMut(&[PointMm])) {
        let columns = self.columns();
        let mut points = Vec::with_capacity(batch.min(self.count));
        for from in (0..self.count).step_by(batch) {
            let to = self.count.min(from.saturating_add(batch));
            points.clear();
            points.extend((from..to).map(|index| self.point(index, columns)));
            take(&points);
        }
    }

    /// Points of a row of a grid as nearly square as the count allows.
    fn columns(self) -> usize {
        let floor = self.count.isqrt();
        if floor * floor == self.count { floor } else { floor + 1 }
    }

    fn point(self, index: usize, columns: usize) -> PointMm {
        let [x, y] = match self.order {
            Order::ExactGrid => {
                let [column, row] = serpentine(index, columns);
                [column as f64 * PITCH_MM, row as f64 * PITCH_MM]
            }
            Order::JitteredGrid => {
                let [column, row] = serpentine(index, columns);
                let [dx, dy] = self.offsets(index).map(|offset| JITTER * offset);
                [(column as f64 + dx) * PITCH_MM, (row as f64 + dy) * PITCH_MM]
            }
            Order::Spiral => {
                // The arc from the centre to the angle t is about pitch·t²/(4π) long.
                let angle = (2.0 * TAU * index as f64).sqrt();
                polar(PITCH_MM * angle / TAU, angle)
            }
            Order::Rings => {
                let (ring, step) = (index / RING_POINTS + 1, index % RING_POINTS);
                polar(ring as f64 * PITCH_MM, TAU * step as f64 / RING_POINTS as f64)
            }
            Order::Random => {
                let side_mm = (self.count as f64).sqrt() * PITCH_MM;
                self.offsets(index).map(|offset| side_mm * (0.5 + 0.5 * offset))
            }
            Order::LineScanner => {
                let (line, column) = (index / LINE_POINTS, index % LINE_POINTS);
                let [along, _] = self.offsets(index);
                let x = (column as f64 + LINE_JITTER * along) * PITCH_MM;
                [x, line as f64 * (LINE_PITCHES * PITCH_MM)]
            }
            Order::Outline => outline(index as f64 / self.count as f64),
            Order::OutlineShuffled => outline(self.shuffled(index) as f64 / self.count as f64),
            Order::TwoOutlines => self.of_two_outlines(index),
            Order::TwoOutlinesShuffled => self.of_two_outlines(self.shuffled(index)),
            Order::Star => star(index as f64 / self.count as f64),
            Order::StarShuffled => star(self.shuffled(index) as f64 / self.count as f64),
            Order::SpiralIn => few_turns(index as f64 / self.count as f64),
            Order::SpiralInShuffled => few_turns(self.shuffled(index) as f64 / self.count as f64),
            Order::FromInside => self.of_disc(index),
            Order::FromInsideShuffled => self.of_disc(self.shuffled(index)),
            Order::RingsIn => self.of_rings_inwards(index),
            Order::RingsInShuffled => self.of_rings_inwards(self.shuffled(index)),
            Order::Rosette => rosette(index as f64 / self.count as f64),
            Order::RosetteShuffled => rosette(self.shuffled(index) as f64 / self.count as f64),
        };
        [x, y, sag_mm(x, y)]
    }

    fn of_two_outlines(self, index: usize) -> [f64; 2] {
        let [x, y] = polar(1.0, TAU * index as f64 / self.count as f64);
        [x + 100.0 * (index % 2) as f64, y]
    }

    fn of_rings_inwards(self, index: usize) -> [f64; 2] {
        let left = self.count - 1 - index;
        let (ring, step) = (left / INWARD_RING_POINTS + 1, left % INWARD_RING_POINTS);
        polar(ring as f64 * PITCH_MM, TAU * step as f64 / INWARD_RING_POINTS as f64)
    }

    /// A place of a disc of as much area as a square of the pitch for each point, by the number of those inside it.
    fn of_disc(self, index: usize) -> [f64; 2] {
        let [share, turn] = self.offsets(index).map(|offset| 0.5 + 0.5 * offset);
        let radius_mm = PITCH_MM * ((index as f64 + share) / PI).sqrt();
        polar(radius_mm, TAU * turn)
    }

    /// Another number below the count for each number: cycles of a permutation of the next power of four that lead
    /// out are followed until they are back (J. Black, P. Rogaway, CT-RSA 2002, doi:10.1007/3-540-45760-7_9).
    fn shuffled(self, index: usize) -> usize {
        let half_bits = (usize::BITS - self.count.leading_zeros()).div_ceil(2);
        let mask = (1_u64 << half_bits) - 1;
        let mut at = index as u64;
        loop {
            let (mut high, mut low) = (at >> half_bits, at & mask);
            for round in 0..4 {
                (high, low) = (low, high ^ (split_mix(self.seed + round, low) & mask));
            }
            at = high << half_bits | low;
            if at < self.count as u64 {
                return at as usize;
            }
        }
    }

    /// Two numbers evenly distributed from -1 to below 1.
    fn offsets(self, index: usize) -> [f64; 2] {
        let counter = 2 * index as u64;
        [counter, counter + 1].map(|counter| {
            let bits = split_mix(self.seed, counter) >> 11;
            bits as f64 / (1_u64 << 52) as f64 - 1.0
        })
    }
}

/// Column and row of a point of a grid whose odd rows run backwards.
fn serpentine(index: usize, columns: usize) -> [usize; 2] {
    let (row, step) = (index / columns, index % columns);
    [if row.is_multiple_of(2) { step } else { columns - 1 - step }, row]
}

fn polar(radius: f64, angle: f64) -> [f64; 2] {
    [radius * angle.cos(), radius * angle.sin()]
}

/// A place of the closed curve, by the share of a turn.
fn outline(share: f64) -> [f64; 2] {
    let t = TAU * share;
    polar(10.0 + 0.8 * (7.0 * t).cos() + 0.3 * (13.0 * t).sin(), t)
}

/// A place on the sides of a star of six spikes, by the share of all.
fn star(share: f64) -> [f64; 2] {
    let side = 12.0 * share;
    let corner = |at: f64| polar(if at % 2.0 == 0.0 { 10.0 } else { 6.8 }, TAU * at / 12.0);
    let [from, to] = [corner(side.floor()), corner(side.floor() + 1.0)];
    [0, 1].map(|axis| from[axis] + side.fract() * (to[axis] - from[axis]))
}

/// A place of a spiral inwards of nine turns, by the share of the way.
fn few_turns(share: f64) -> [f64; 2] {
    let left = (1.0 - share).sqrt();
    polar(10.0 * left, 9.0 * TAU * left)
}

/// A place of a rosette, by the share of the way.
fn rosette(share: f64) -> [f64; 2] {
    let angle = 4.9 * TAU * share;
    polar(10.0 * (8.454 * angle).sin(), angle)
}

/// Height of the sphere above its vertex at the origin.
fn sag_mm(x: f64, y: f64) -> f64 {
    let squared = x * x + y * y;
    let radius_squared = SPHERE_RADIUS_MM * SPHERE_RADIUS_MM;
    squared / (SPHERE_RADIUS_MM + (radius_squared - squared).max(0.0).sqrt())
}

/// Output `counter` of SplitMix64 (Steele, Lea and Flood 2014, doi:10.1145/2660193.2660195), whose
/// state is a counter and so can be set.
fn split_mix(seed: u64, counter: u64) -> u64 {
    let state = seed.wrapping_add(counter.wrapping_add(1).wrapping_mul(0x9e37_79b9_7f4a_7c15));
    let mixed = (state ^ (state >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    let mixed = (mixed ^ (mixed >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    mixed ^ (mixed >> 31)
}
