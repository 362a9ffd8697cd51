//! Rims: where the surface of the part meets the border of the volume.
//!
//! The part goes on beyond the border. A face that closes it there is flat and has a sharp rim, which is no edge of the part. A mirror
//! image beyond the border has a crease there, unless the surface meets it at a right angle.

use crate::Samples;

/// A mixed edge of the grid in a slice at the border stands for so much rim, in spacings: a line of length L in a random direction crosses
/// 4L/π edges of a square grid (Crofton).
const RIM: f64 = std::f64::consts::FRAC_PI_4;

/// The length of all rims, in spacings.
pub(super) fn rims(samples: &Samples) -> f64 {
    let mut mixed = 0_u64;
    let size = samples.size();
    let inside = |place: [usize; 3]| samples.padded_bit(place[0] + 1, place[1] + 1, place[2] + 1);
    for across in 0..3 {
        let [u, v] = [(across + 1) % 3, (across + 2) % 3];
        for end in [0, size[across] - 1] {
            for i in 0..size[u] {
                for j in 0..size[v] {
                    let mut place = [end; 3];
                    (place[u], place[v]) = (i, j);
                    let own = inside(place);
                    for axis in [u, v] {
                        let mut next = place;
                        next[axis] += 1;
                        if next[axis] < size[axis] && inside(next) != own {
                            mixed += 1;
                        }
                    }
                }
            }
            if size[across] == 1 {
                break;
            }
        }
    }
    RIM * mixed as f64
}

/// Slices between the border and the first that shows how far walls lean; one twice as deep shows how that changes.
const DEPTH: usize = 2;

/// Side of the squares of a face at the border whose walls count as equally steep, in samples.
const SQUARE: usize = 8;

/// Tangent of the angle from upright, beyond which a wall counts as no flatter.
const FLATTEST: f64 = 1.75;

const CREASE_LOSS: f64 = 0.45;

/// What blur takes off the creases of the mirrored volume, over σ, in spacings.
///
/// A wall that leans by the tangent t from upright loses 0.45·t² times σ a unit of length on its side of the crease, within a fifth up to 60°:
/// by the blurred wedge of each angle, on a fine grid.
pub(super) fn creases(samples: &Samples) -> f64 {
    let mut length = 0.0;
    visit_creases(samples, |_, crease| length += crease);
    length
}

/// The same by the blocks that `block_of` says they lie in.
pub(super) fn creases_of_blocks(
    samples: &Samples,
    blocks: usize,
    block_of: impl Fn([usize; 3]) -> usize,
) -> Vec<f64> {
    let mut lengths = vec![0.0; blocks];
    visit_creases(samples, |sample, crease| lengths[block_of(sample)] += crease);
    lengths
}

/// Calls `visit` with the lowest sample of each square of the six faces, and what blur takes off its creases over σ.
fn visit_creases(samples: &Samples, mut visit: impl FnMut([usize; 3], f64)) {
    let size = samples.size();
    let inside = |place: [usize; 3]| samples.padded_bit(place[0] + 1, place[1] + 1, place[2] + 1);
    for across in 0..3 {
        let [u, v] = [(across + 1) % 3, (across + 2) % 3];
        if size[across] <= 2 * DEPTH {
            continue;
        }
        let last = size[across] - 1;
        for (end, deeper) in [(0, [DEPTH, 2 * DEPTH]), (last, [last - DEPTH, last - 2 * DEPTH])] {
            for (from_u, from_v) in squares(size[u], size[v]) {
                let (mut rims, mut moved) = (0.0, [0.0; 2]);
                for i in from_u..(from_u + SQUARE).min(size[u]) {
                    for j in from_v..(from_v + SQUARE).min(size[v]) {
                        let at = |across_at: usize, i: usize, j: usize| {
                            let mut place = [across_at; 3];
                            (place[u], place[v]) = (i, j);
                            inside(place)
                        };
                        let own = at(end, i, j);
                        for (moved, deep) in moved.iter_mut().zip(deeper) {
                            *moved += f64::from(u8::from(at(deep, i, j) != own));
                        }
                        let beside = [(i + 1, j), (i, j + 1)];
                        let mixed = beside
                            .into_iter()
                            .filter(|&(i, j)| i < size[u] && j < size[v] && at(end, i, j) != own);
                        rims += RIM * mixed.count() as f64;
                    }
                }
                if rims > 0.0 {
                    // In the middle of the way to each slice, and from there on to the border.
                    let steps = DEPTH as f64 * rims;
                    let lean = 2.0 * moved[0] / steps - moved[1] / (2.0 * steps);
                    let lean = lean.clamp(0.0, FLATTEST);
                    let mut place = [end; 3];
                    (place[u], place[v]) = (from_u, from_v);
                    visit(place, CREASE_LOSS * lean * lean * rims);
                }
            }
        }
    }
}

/// The lowest samples of the squares of a face.
fn squares(columns: usize, rows: usize) -> impl Iterator<Item = (usize, usize)> {
    (0..columns).step_by(SQUARE).flat_map(move |i| (0..rows).step_by(SQUARE).map(move |j| (i, j)))
}
