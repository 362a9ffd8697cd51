//! Cost of the predicates where the plain computation decides, and on rasters where it does not.
//!
//! `cargo bench -p asphera-geometry --bench predicates`. Every item is one call; `robust` is the
//! crate of that name, an implementation of Shewchuk's adaptive predicates.

use std::hint::black_box;

use asphera_geometry::predicates::{self as exact, Place};
use divan::Bencher;
use divan::counter::ItemsCount;
use rand_core::{Rng, SeedableRng};
use rand_pcg::Pcg64;

#[expect(clippy::print_stdout, reason = "a figure without its size and seed says nothing")]
fn main() {
    println!("{COUNT} calls a sample, seed {SEED}");
    divan::main();
}

const SEED: u64 = 42;
const COUNT: usize = 4096;
const PITCH_MM: f64 = 0.003;

const LINES: [&str; 4] =
    ["scattered", "raster: along an axis", "raster: diagonals", "raster at 1e6 mm: diagonals"];

const SITUATIONS: [&str; 10] = [
    "scattered",
    "raster: rectangles",
    "raster: trapezoids",
    "raster: diamonds",
    "raster about the origin",
    "raster at 1e6 mm: rectangles",
    "raster at 1e6 mm",
    "coarse raster from the origin",
    "1e-40 mm beside 1e12 mm",
    "three neighbours, seen from far",
];

/// Places in the order of three counter-clockwise and one about their circle.
fn four(situation: &str) -> Vec<[Place; 4]> {
    let mut random = Random(Pcg64::seed_from_u64(SEED));
    // The index of the first column and row, how many there are, and how large a shape may be.
    let (first, columns, sizes) = match situation {
        "raster about the origin" => (-500, 1000, 4),
        "raster at 1e6 mm" | "raster at 1e6 mm: rectangles" => (333_333_333, 1000, 4),
        "coarse raster from the origin" => (1, 1, 1000),
        _ => (2_000, 1000, 4),
    };
    let mut call = || {
        let mut corners = match situation {
            "scattered" => return random.scattered(),
            "1e-40 mm beside 1e12 mm" => {
                let [x, y] = [1e-40, 1e12].map(|mm| mm * f64::from(1 + random.below(1000)) / 1e3);
                return [[-y, x], [x, -y], [y, x], [x, y]];
            }
            "three neighbours, seen from far" => return random.neighbours_and_far(),
            "raster: rectangles" | "raster at 1e6 mm: rectangles" => rectangle(random.size(sizes)),
            "raster: diamonds" => diamond(random.size(sizes)),
            "raster about the origin" => match random.below(3) {
                0 => rectangle(random.size(sizes)),
                1 => trapezoid(random.size(sizes)),
                _ => diamond(random.size(sizes)),
            },
            _ => trapezoid(random.size(sizes)),
        };
        corners.rotate_left(random.below(4) as usize);
        let [column, row] = [(); 2].map(|()| first + random.below(columns) as i32);
        corners.map(|[x, y]| on_raster(column + x, row + y))
    };
    (0..COUNT).map(|_| call()).collect()
}

/// Three places on a line, but for the scattered ones.
fn three(line: &str) -> Vec<[Place; 3]> {
    let mut random = Random(Pcg64::seed_from_u64(SEED));
    let first = if line == "raster at 1e6 mm: diagonals" { 333_333_333 } else { 2_000 };
    let mut call = || {
        if line == "scattered" {
            let [a, b, c, _] = random.scattered();
            return [a, b, c];
        }
        let [column, row] = [(); 2].map(|()| first + random.below(1000) as i32);
        let step = if line == "raster: along an axis" { 0 } else { 1 };
        [0, random.size(4), 5].map(|along| on_raster(column + along, row + step * along))
    };
    (0..COUNT).map(|_| call()).collect()
}

fn rectangle(size: i32) -> [[i32; 2]; 4] {
    [[0, 0], [size, 0], [size, 1], [0, 1]]
}

fn trapezoid(size: i32) -> [[i32; 2]; 4] {
    [[0, 0], [size + 2, 0], [size + 1, 1], [1, 1]]
}

fn diamond(size: i32) -> [[i32; 2]; 4] {
    [[0, size], [size, 0], [2 * size, size], [size, 2 * size]]
}

fn on_raster(column: i32, row: i32) -> Place {
    [column, row].map(|index| f64::from(index) * PITCH_MM)
}

struct Random(Pcg64);

impl Random {
    fn below(&mut self, limit: u32) -> u32 {
        self.0.next_u32() % limit
    }

    fn size(&mut self, limit: u32) -> i32 {
        1 + self.below(limit) as i32
    }

    /// Three of a million points on a circle of 1 mm that follow one another, and a place 100 mm away.
    fn neighbours_and_far(&mut self) -> [Place; 4] {
        let first = self.below(250_000);
        let on_circle = |step: u32| {
            let (sin, cos) = (1e-6 * std::f64::consts::TAU * f64::from(step)).sin_cos();
            [cos, sin]
        };
        let [x, y] = on_circle(self.below(500_000));
        [on_circle(first), on_circle(first + 1), on_circle(first + 2), [100.0 + x, y]]
    }

    fn scattered(&mut self) -> [Place; 4] {
        let mut place = || [(); 2].map(|()| f64::from(self.below(1 << 30)) * 1e-8);
        let [a, b, c, d] = [place(), place(), place(), place()];
        if exact::left_of(a, b, c) { [a, b, c, d] } else { [b, a, c, d] }
    }
}

/// Items are calls.
fn each<const N: usize>(
    bencher: Bencher,
    calls: Vec<[Place; N]>,
    predicate: impl Fn([Place; N]) -> bool,
) {
    bencher
        .counter(ItemsCount::new(calls.len()))
        .bench_local(|| black_box(&calls).iter().filter(|&&call| predicate(call)).count());
}

#[divan::bench(args = SITUATIONS)]
fn encloses(bencher: Bencher, situation: &str) {
    each(bencher, four(situation), |[a, b, c, d]| exact::encloses(a, b, c, d));
}

#[divan::bench(args = SITUATIONS)]
fn in_circle(bencher: Bencher, situation: &str) {
    each(bencher, four(situation), |[a, b, c, d]| exact::in_circle(a, b, c, d).is_gt());
}

#[divan::bench(args = SITUATIONS)]
fn in_circle_robust(bencher: Bencher, situation: &str) {
    each(bencher, four(situation), |call| {
        let [a, b, c, d] = call.map(|[x, y]| robust::Coord { x, y });
        robust::incircle(a, b, c, d) > 0.0
    });
}

#[divan::bench(args = LINES)]
fn left_of(bencher: Bencher, line: &str) {
    each(bencher, three(line), |[a, b, c]| exact::left_of(a, b, c));
}

#[divan::bench(args = LINES)]
fn orientation(bencher: Bencher, line: &str) {
    each(bencher, three(line), |[a, b, c]| exact::orientation(a, b, c).is_gt());
}

#[divan::bench(args = LINES)]
fn orientation_robust(bencher: Bencher, line: &str) {
    each(bencher, three(line), |call| {
        let [a, b, c] = call.map(|[x, y]| robust::Coord { x, y });
        robust::orient2d(a, b, c) > 0.0
    });
}

#[divan::bench(args = LINES)]
fn outside_edge(bencher: Bencher, line: &str) {
    each(bencher, three(line), |[a, b, c]| exact::outside_edge(a, b, c));
}
