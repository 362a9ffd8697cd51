//! The line below all pairs of two clocks, over a sliding window.
//!
//! A reading reaches the host late, never early. So the pairs (device time, host time) lie on or above a line, and
//! how far above is their delay. A least-squares line would follow the delays; the line sought lies below every pair
//! and has the smallest sum of distances to them. It is the edge of the lower convex hull over the mean of the device
//! times (Moon, Skelly and Towsley 1999, "Estimation and removal of clock skew from network delay measurements",
//! doi:10.1109/INFCOM.1999.749286).
//!
//! The window is cut into blocks of equal length, each with the lower hull of its pairs. While the window grows the
//! blocks grow with it; at full length the oldest block goes. So memory is bounded, whatever the rate.

use std::collections::VecDeque;

/// A straight line, and how well it is known. Times in ns.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Line {
    x_ns: f64,
    y_ns: f64,
    slope: f64,
    /// Standard uncertainty of its height at the newest pair, ns.
    pub(crate) u_ns: f64,
    /// Standard uncertainty of its slope.
    pub(crate) u_slope: f64,
}

impl Line {
    /// Height over a device time.
    pub(crate) fn at_ns(&self, x_ns: f64) -> f64 {
        self.y_ns + self.slope * (x_ns - self.x_ns)
    }

    /// Host time that passes beside each unit of device time.
    pub(crate) fn slope(&self) -> f64 {
        self.slope
    }
}

/// Pairs (x, y) in ns: x the device's time, y by how much the host's is ahead of it.
#[derive(Clone, Debug)]
pub(crate) struct Envelope {
    blocks: VecDeque<Block>,
    block_ns: f64,
    line: Option<Line>,
}

#[derive(Clone, Debug)]
struct Block {
    /// Blocks of this length since the first pair.
    index: u64,
    pairs: f64,
    sum_x_ns: f64,
    hull: Vec<[f64; 2]>,
}

impl Envelope {
    pub(crate) fn new() -> Envelope {
        Envelope { blocks: VecDeque::new(), block_ns: FIRST_BLOCK_NS, line: None }
    }

    /// The line; `None` before the second pair.
    pub(crate) fn line(&self) -> Option<Line> {
        self.line
    }

    /// Takes the next pair, later in x than all before.
    pub(crate) fn take(&mut self, x_ns: f64, y_ns: f64) {
        let index = (x_ns / self.block_ns) as u64;
        let is_new = self.blocks.back().is_none_or(|block| block.index < index);
        if is_new {
            self.blocks.push_back(Block { index, pairs: 0.0, sum_x_ns: 0.0, hull: Vec::new() });
        }
        if let Some(block) = self.blocks.back_mut() {
            block.pairs += 1.0;
            block.sum_x_ns += x_ns;
            extend(&mut block.hull, [x_ns, y_ns]);
            thin(&mut block.hull);
        }
        if self.blocks.len() > MOST_BLOCKS {
            self.shorten();
        }
        if is_new || self.line.is_none_or(|line| y_ns < line.at_ns(x_ns)) {
            self.line = self.fitted();
        }
    }

    /// Makes room: neighbours become one block, or the oldest goes.
    fn shorten(&mut self) {
        if self.block_ns >= LONGEST_BLOCK_NS {
            self.blocks.pop_front();
            return;
        }
        self.block_ns *= 2.0;
        let mut merged: VecDeque<Block> = VecDeque::new();
        for block in self.blocks.drain(..) {
            let index = block.index / 2;
            match merged.back_mut().filter(|last| last.index == index) {
                Some(last) => {
                    last.pairs += block.pairs;
                    last.sum_x_ns += block.sum_x_ns;
                    block.hull.into_iter().for_each(|pair| extend(&mut last.hull, pair));
                    thin(&mut last.hull);
                }
                None => merged.push_back(Block { index, ..block }),
            }
        }
        self.blocks = merged;
    }

    fn fitted(&self) -> Option<Line> {
        let mut hull = Vec::new();
        for pair in self.blocks.iter().flat_map(|block| &block.hull) {
            extend(&mut hull, *pair);
        }
        let pairs: f64 = self.blocks.iter().map(|block| block.pairs).sum();
        let mean_ns = self.blocks.iter().map(|block| block.sum_x_ns).sum::<f64>() / pairs;
        let (first, last) = (*hull.first()?, *hull.last()?);
        let after = hull.iter().position(|pair| pair[0] > mean_ns).filter(|after| *after > 0)?;
        let [[x0, y0], [x1, y1]] = [hull[after - 1], hull[after]];
        let slope = (y1 - y0) / (x1 - x0);
        let line = Line { x_ns: x0, y_ns: y0, slope, u_ns: 0.0, u_slope: 0.0 };
        let u_ns = self.spread_ns(&line);
        Some(Line { u_ns, u_slope: 2.0 * u_ns / (last[0] - first[0]), ..line })
    }

    /// Root mean square of the least distances to the line, each of one of a few equal shares of the pairs.
    ///
    /// Delays differ from share to share, or the clock does not run evenly: either moves the line by as much.
    fn spread_ns(&self, line: &Line) -> f64 {
        // The newest block has few pairs yet: it belongs to the last share.
        let each = (self.blocks.len() / SHARES).max(1);
        let mut least = [f64::INFINITY; SHARES];
        for (number, block) in self.blocks.iter().enumerate() {
            let share = &mut least[(number / each).min(SHARES - 1)];
            for [x_ns, y_ns] in &block.hull {
                *share = share.min(y_ns - line.at_ns(*x_ns));
            }
        }
        let (mut sum, mut shares) = (0.0, 0.0);
        for least_ns in least.into_iter().filter(|least_ns| least_ns.is_finite()) {
            sum += least_ns * least_ns;
            shares += 1.0;
        }
        f64::sqrt(sum / f64::max(shares, 1.0))
    }
}

/// Appends a pair to a lower hull of pairs that all lie before it.
fn extend(hull: &mut Vec<[f64; 2]>, pair: [f64; 2]) {
    while let [.., a, b] = hull[..] {
        let turn = (b[0] - a[0]) * (pair[1] - a[1]) - (b[1] - a[1]) * (pair[0] - a[0]);
        if turn > 0.0 {
            break;
        }
        hull.pop();
    }
    hull.push(pair);
}

/// Bounds a hull, as of a clock whose rate wanders: every other corner goes, which moves it by less than it bends.
fn thin(hull: &mut Vec<[f64; 2]>) {
    if hull.len() > MOST_CORNERS {
        let last = hull.len() - 1;
        let mut at = 0;
        hull.retain(|_| {
            at += 1;
            at % 2 == 1 || at > last
        });
    }
}

/// Blocks of a window.
const MOST_BLOCKS: usize = 64;
/// Shares whose least delays are compared.
const SHARES: usize = 8;
/// Length of the first blocks.
const FIRST_BLOCK_NS: f64 = 1e7;
/// Length of blocks of a full window, which is then 82 s: quartz wanders by some 0.01 ppm in that time.
const LONGEST_BLOCK_NS: f64 = 1.28e9;
/// Corners of a block's hull.
const MOST_CORNERS: usize = 48;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_line_lies_below_all_pairs_and_touches_two() {
        let mut envelope = Envelope::new();
        let pairs: Vec<[f64; 2]> = (0..5000_u32)
            .map(|n| {
                let x_ns = f64::from(n) * 1e6;
                let delay_ns = f64::from(n.wrapping_mul(2_654_435_761) >> 12);
                [x_ns, 3e-5 * x_ns + delay_ns]
            })
            .collect();
        pairs.iter().for_each(|[x_ns, y_ns]| envelope.take(*x_ns, *y_ns));
        let line = envelope.line().unwrap();
        let above = pairs.iter().map(|[x_ns, y_ns]| y_ns - line.at_ns(*x_ns));
        let mut above: Vec<f64> = above.collect();
        above.sort_by(f64::total_cmp);
        assert!(above[0] > -1e-3 && above[1] < 1e-3, "{:?}", &above[..3]);
        assert!((line.slope() - 3e-5).abs() < line.u_slope.max(1e-9), "{line:?}");
        assert!(envelope.blocks.len() <= MOST_BLOCKS);
    }

    #[test]
    fn a_window_forgets_what_is_older_and_stays_bounded() {
        let mut envelope = Envelope::new();
        // A clock that runs 20 ppm slow for 200 s, then 20 ppm fast.
        let mut y_ns = 0.0;
        for n in 0..40_000_u32 {
            y_ns += if n < 20_000 { 200.0 } else { -200.0 };
            envelope.take(f64::from(n) * 1e7, y_ns);
        }
        let line = envelope.line().unwrap();
        assert!((line.slope() + 2e-5).abs() < 1e-9, "{line:?}");
        let corners: usize = envelope.blocks.iter().map(|block| block.hull.len()).sum();
        assert!(corners <= MOST_BLOCKS * MOST_CORNERS);
    }
}
