//! Scans as a fuzzer can write them: pieces of a path in a frame, and where the batches end.

use std::f64::consts::TAU;

use arbitrary::Arbitrary;
use asphera_geometry::PointMm;

/// A scan of at most [`MOST_POINTS`] points.
#[derive(Arbitrary, Debug)]
pub struct Scan {
    frame: Frame,
    pieces: Vec<Piece>,
    /// Sizes of the batches, over and over.
    cuts: Vec<u16>,
    seed: u64,
}

/// What a step of a piece is in mm, and where its origin lies.
#[derive(Arbitrary, Clone, Copy, Debug)]
enum Frame {
    /// Whole mm: lines, circles and duplicates abound.
    Lattice,
    /// Steps that are no doubles, so that lines and circles are nearly such.
    Decimal { pitch: u8 },
    /// Steps of 1 µm, a kilometre away.
    Far { negative: [bool; 2] },
    /// Steps of any size the mesh admits, and of none that it does.
    Scaled { power_of_ten: i8 },
    /// Axes of quite different steps.
    Stretched { powers_of_ten: [i8; 2] },
    /// Axes turned by an angle.
    Turned { angle: u16 },
}

impl Frame {
    fn place(self, [x, y]: [f64; 2]) -> [f64; 2] {
        let size = |power: i8| 10.0_f64.powi(i32::from(power) % 45);
        match self {
            Frame::Lattice => [x, y],
            Frame::Decimal { pitch } => {
                let pitch = PITCHES_MM[usize::from(pitch) % PITCHES_MM.len()];
                [x * pitch, y * pitch]
            }
            Frame::Far { negative } => {
                let centre = negative.map(|negative| if negative { -1e6 } else { 1e6 });
                [centre[0] + x * 1e-3, centre[1] + y * 1e-3]
            }
            Frame::Scaled { power_of_ten } => [x * size(power_of_ten), y * size(power_of_ten)],
            Frame::Stretched { powers_of_ten: [along, across] } => {
                [x * size(along), y * size(across)]
            }
            Frame::Turned { angle } => {
                let (sin, cos) = (TAU * f64::from(angle) / 65536.0).sin_cos();
                [x * cos - y * sin, x * sin + y * cos]
            }
        }
    }
}

/// A part of the path, in steps.
#[derive(Arbitrary, Debug)]
enum Piece {
    /// Nodes of a small lattice, in any order.
    Nodes(Vec<Node>),
    /// Nodes of a small lattice, each one step from the last.
    Walk { from: Node, steps: Vec<u8> },
    /// A straight line, but for a bend.
    Line { from: Node, step: [i8; 2], count: u8, bend: Bend },
    /// Lines side by side.
    Raster {
        from: Node,
        columns: u8,
        rows: u8,
        /// One after another in the same sense, or there and back.
        there_and_back: bool,
        turn: u8,
        /// How far each line starts beside the last, in eighths of a step.
        slant: i8,
        jitter: Jitter,
        /// Points left out of some lines.
        missing: [u8; 2],
    },
    /// On a circle, or a part of one, or on several.
    Arc { centre: Node, radius: u8, from: u8, turns: u8, count: u8, growth: Growth },
    /// Numbers as they come.
    Raw(Vec<[f64; 2]>),
    /// What has been measured before, once more.
    Again { from: u16, count: u8, backwards: bool, jitter: Jitter },
    /// No numbers, or none of a size.
    Nonsense(u8),
}

/// A node of a lattice of 16 by 16.
#[derive(Arbitrary, Clone, Copy, Debug)]
struct Node(u8);

impl Node {
    fn place(self) -> [f64; 2] {
        [f64::from(self.0 & 15), f64::from(self.0 >> 4)]
    }
}

/// How far a line leaves its straight in its middle, in steps.
#[derive(Arbitrary, Clone, Copy, Debug)]
enum Bend {
    None,
    Tiny { negative: bool, power_of_ten: u8 },
    Sharp(i8),
}

impl Bend {
    fn steps(self) -> f64 {
        match self {
            Bend::None => 0.0,
            Bend::Tiny { negative, power_of_ten } => {
                let size = 10.0_f64.powi(-i32::from(power_of_ten % 18));
                if negative { -size } else { size }
            }
            Bend::Sharp(steps) => f64::from(steps),
        }
    }
}

/// How far points lie beside where they should, in steps.
#[derive(Arbitrary, Clone, Copy, Debug)]
enum Jitter {
    None,
    Some { power_of_ten: u8 },
    Large,
}

impl Jitter {
    fn steps(self) -> f64 {
        match self {
            Jitter::None => 0.0,
            Jitter::Some { power_of_ten } => 10.0_f64.powi(-i32::from(power_of_ten % 17)),
            Jitter::Large => 0.4,
        }
    }
}

/// How the radius of an arc changes.
#[derive(Arbitrary, Clone, Copy, Debug)]
enum Growth {
    Circle,
    Spiral {
        eighths_a_turn: i8,
    },
    /// Petals over the centre.
    Rosette {
        petals: u8,
    },
    /// Exact doubles in the four quadrants: many on one circle to the last bit.
    Pythagorean,
}

impl Scan {
    pub fn seed(&self) -> u64 {
        self.seed
    }

    /// All points, in order of arrival.
    pub fn points(&self) -> Vec<PointMm> {
        let mut random = Random(self.seed);
        let mut steps: Vec<[f64; 2]> = Vec::new();
        let mut points: Vec<PointMm> = Vec::new();
        for piece in &self.pieces {
            let first = steps.len();
            piece.lay(&mut steps, &mut random);
            steps.truncate(MOST_POINTS);
            let heights = (first..).map(|index| (index % 3) as f64 * 0.4e-4);
            points.extend(steps[first..].iter().zip(heights).map(|(&step, z)| {
                let raw = matches!(piece, Piece::Raw(_) | Piece::Nonsense(_));
                let [x, y] = if raw { step } else { self.frame.place(step) };
                [x, y, z]
            }));
        }
        points
    }

    /// The points cut into batches.
    pub fn batches<'a>(&self, points: &'a [PointMm]) -> Vec<&'a [PointMm]> {
        let mut batches = Vec::new();
        let mut rest = points;
        for index in 0.. {
            if rest.is_empty() || batches.len() == MOST_BATCHES {
                break;
            }
            let size = match self.cuts.len() {
                0 => rest.len(),
                cuts => 1 + usize::from(self.cuts[index % cuts]) % 1000,
            };
            let (batch, others) = rest.split_at(size.min(rest.len()));
            batches.push(batch);
            rest = others;
        }
        batches.push(rest);
        batches
    }
}

impl Piece {
    /// Appends the piece's points to those before it.
    fn lay(&self, path: &mut Vec<[f64; 2]>, random: &mut Random) {
        match self {
            Piece::Nodes(nodes) => path.extend(nodes.iter().map(|node| node.place())),
            Piece::Walk { from, steps } => {
                let mut place = from.place();
                path.push(place);
                path.extend(steps.iter().map(|step| {
                    let [x, y] = [step & 3, step >> 2 & 3].map(f64::from);
                    place = [place[0] + x - 1.0, place[1] + y - 1.0];
                    place
                }));
            }
            Piece::Line { from, step, count, bend } => {
                let [x, y] = from.place();
                let [dx, dy] = step.map(|step| f64::from(step) / 8.0);
                path.extend((0..*count).map(|index| {
                    let along = f64::from(index);
                    // A parabola, which lies strictly to one side.
                    let share = (2.0 * along + 1.0) / f64::from(*count) - 1.0;
                    let off = bend.steps() * (1.0 - share * share);
                    [x + along * dx - off * dy, y + along * dy + off * dx]
                }));
            }
            Piece::Raster { from, columns, rows, there_and_back, turn, slant, jitter, missing } => {
                let [x, y] = from.place();
                let (columns, rows) = (1 + columns % 64, 1 + rows % 32);
                for row in 0..rows {
                    for index in 0..columns {
                        let back = *there_and_back && row % 2 == 1;
                        let column = if back { columns - 1 - index } else { index };
                        if missing[0] > 0 && (row + column) % (1 + missing[0] % 32) < missing[1] % 8
                        {
                            continue;
                        }
                        let along =
                            f64::from(column) + f64::from(row) * f64::from(*slant % 16) / 8.0;
                        let place =
                            [along, f64::from(row)].map(|on| on + random.within(jitter.steps()));
                        let [dx, dy] = quarter_turns(place, *turn);
                        path.push([x + dx, y + dy]);
                    }
                }
            }
            Piece::Arc { centre, radius, from, turns, count, growth } => {
                let [x, y] = centre.place();
                let count = u16::from(*count) * 2;
                path.extend((0..count).map(|index| {
                    let turn = f64::from(*from) / 256.0
                        + f64::from(*turns) / 16.0 * f64::from(index) / f64::from(count);
                    let [dx, dy] = growth.place(f64::from(*radius) / 8.0, turn, index);
                    [x + dx, y + dy]
                }));
            }
            Piece::Raw(places) => path.extend(places.iter().copied()),
            Piece::Again { from, count, backwards, jitter } => {
                let known = path.len();
                for index in 0..usize::from(*count).min(known) {
                    let index = (usize::from(*from) + index) % known;
                    let index = if *backwards { known - 1 - index } else { index };
                    path.push(path[index].map(|on| on + random.within(jitter.steps())));
                }
            }
            Piece::Nonsense(which) => {
                const NONSENSE: [f64; 6] = [f64::NAN, f64::INFINITY, -1e300, 1.1e12, -1e-300, 0.0];
                let which = usize::from(*which);
                path.push([NONSENSE[which % 6], NONSENSE[which / 6 % 6]]);
            }
        }
    }
}

impl Growth {
    fn place(self, radius: f64, turn: f64, index: u16) -> [f64; 2] {
        let (sin, cos) = (TAU * turn).sin_cos();
        match self {
            Growth::Circle => [radius * cos, radius * sin],
            Growth::Spiral { eighths_a_turn } => {
                let radius = radius + turn * f64::from(eighths_a_turn) / 8.0;
                [radius * cos, radius * sin]
            }
            Growth::Rosette { petals } => {
                let radius = radius * (TAU * turn * f64::from(1 + petals % 8)).sin();
                [radius * cos, radius * sin]
            }
            Growth::Pythagorean => {
                // The twelve nodes of the circle of radius 5, of twice that, and of so on.
                const NODES: [[f64; 2]; 3] = [[5.0, 0.0], [4.0, 3.0], [3.0, 4.0]];
                let scale = f64::from(1 + index / 12);
                let node = NODES[usize::from(index % 3)].map(|on| on * scale);
                quarter_turns(node, (index / 3 % 4) as u8)
            }
        }
    }
}

fn quarter_turns([x, y]: [f64; 2], turns: u8) -> [f64; 2] {
    match turns % 4 {
        0 => [x, y],
        1 => [-y, x],
        2 => [-x, -y],
        _ => [y, -x],
    }
}

/// Brings the points into an order that depends on the seed alone.
pub fn shuffle(points: &mut [PointMm], seed: u64) {
    let mut random = Random(seed);
    for index in (1..points.len()).rev() {
        points.swap(index, (random.next() % (index as u64 + 1)) as usize);
    }
}

/// S. Vigna's splitmix64, <https://prng.di.unimi.it/splitmix64.c>.
struct Random(u64);

impl Random {
    fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mixed = (self.0 ^ self.0 >> 30).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let mixed = (mixed ^ mixed >> 27).wrapping_mul(0x94d0_49bb_1331_11eb);
        mixed ^ mixed >> 31
    }

    /// Evenly between `-size` and `size`.
    fn within(&mut self, size: f64) -> f64 {
        let unit = (self.next() >> 11) as f64 / (1_u64 << 53) as f64;
        size * (2.0 * unit - 1.0)
    }
}

const PITCHES_MM: [f64; 6] = [0.1, 0.003, 0.005, 1.0 / 3.0, 0.7, 1e-4];
const MOST_POINTS: usize = 2000;
/// Every batch is checked; what is left after so many comes as one.
const MOST_BATCHES: usize = 40;
