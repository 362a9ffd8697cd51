//! Rims: where the surface of the part meets the faces that close a volume at its border.
//!
//! The part goes on beyond the border. Its face there is flat and has a sharp rim, which is no edge of the part.

use crate::Samples;

/// A mixed edge of the grid in a slice at the border stands for so much rim, in spacings: a line of length L in a random direction crosses
/// 4L/π edges of a square grid (Crofton).
const RIM: f64 = std::f64::consts::FRAC_PI_4;

/// The length of all rims, in spacings.
pub(super) fn rims(samples: &Samples) -> f64 {
    let mut length = 0.0;
    visit_rims(samples, |_| length += RIM);
    length
}

/// The rims by the blocks that `block_of` says they lie in, in spacings.
pub(super) fn rims_of_blocks(
    samples: &Samples,
    blocks: usize,
    block_of: impl Fn([usize; 3]) -> usize,
) -> Vec<f64> {
    let mut lengths = vec![0.0; blocks];
    visit_rims(samples, |sample| lengths[block_of(sample)] += RIM);
    lengths
}

/// Calls `visit` with the lower sample of each mixed edge within the six slices at the border.
fn visit_rims(samples: &Samples, mut visit: impl FnMut([usize; 3])) {
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
                            visit(place);
                        }
                    }
                }
            }
            if size[across] == 1 {
                break;
            }
        }
    }
}
