//! Intersection over union of two regions with holes.

use thiserror::Error;

use crate::PlaceMm;

/// Why no overlap can be told.
#[derive(Clone, Copy, Debug, Error, PartialEq, Eq)]
pub enum IouError {
    /// Neither region has an area.
    #[error("neither outline encloses an area: expected closed lines")]
    NoArea,
    /// A coordinate is not finite.
    #[error("a coordinate is not finite: expected places in mm")]
    NotFinite,
}

/// Area common to two regions over the area of either, from 0 to 1.
///
/// A region is its closed lines, the first place not repeated; a place is in it if an odd number of lines encloses it, so
/// a line within another is a hole. The plane is cut into slabs at every corner and every crossing; within a slab sides
/// are straight and in one order, and areas are sums of trapezia. Crossings are rounded. Time grows with the sides that a
/// slab meets: n·√n for outlines of n corners, n² at worst.
///
/// # Errors
///
/// No area at all; a coordinate that is not finite.
pub fn intersection_over_union(a: &[Vec<PlaceMm>], b: &[Vec<PlaceMm>]) -> Result<f64, IouError> {
    if a.iter().chain(b).flatten().any(|[x, y]| !x.is_finite() || !y.is_finite()) {
        return Err(IouError::NotFinite);
    }
    let mut sides: Vec<Side> = Vec::new();
    for (lines, of) in [(a, 0), (b, 1)] {
        for line in lines {
            let next = line.iter().cycle().skip(1);
            sides.extend(line.iter().zip(next).filter_map(|(&p, &q)| Side::new(p, q, of)));
        }
    }
    sides.sort_by(|a, b| a.low[0].total_cmp(&b.low[0]));
    let mut cuts: Vec<f64> = sides.iter().flat_map(|side| [side.low[0], side.high[0]]).collect();
    cuts.extend(crossings(&sides));
    cuts.sort_by(f64::total_cmp);
    cuts.dedup();
    let (mut common, mut either) = (0.0, 0.0);
    let mut active: Vec<Side> = Vec::new();
    let mut waiting = sides.into_iter().peekable();
    for pair in cuts.windows(2) {
        let [from, to] = [pair[0], pair[1]];
        active.retain(|side| side.high[0] > from);
        while let Some(side) = waiting.next_if(|side| side.low[0] <= from) {
            active.push(side);
        }
        let middle = 0.5 * (from + to);
        let mut heights: Vec<(f64, usize)> =
            active.iter().map(|side| (side.y_at(middle), side.of)).collect();
        heights.sort_by(|a, b| a.0.total_cmp(&b.0));
        let mut within = [false; 2];
        for (index, &(y, of)) in heights.iter().enumerate() {
            within[of] = !within[of];
            let Some(&(next, _)) = heights.get(index + 1) else { break };
            // Sides are straight within the slab: the trapezium has the height in its middle.
            let area = (next - y) * (to - from);
            common += if within == [true; 2] { area } else { 0.0 };
            either += if within == [false; 2] { 0.0 } else { area };
        }
    }
    if either > 0.0 { Ok(common / either) } else { Err(IouError::NoArea) }
}

/// A side that is not upright, from its left end to its right.
#[derive(Clone, Copy)]
struct Side {
    low: PlaceMm,
    high: PlaceMm,
    of: usize,
}

impl Side {
    /// The side between two places; none if it is upright, as it then bounds no slab.
    fn new(p: PlaceMm, q: PlaceMm, of: usize) -> Option<Side> {
        let [low, high] = if p[0] < q[0] { [p, q] } else { [q, p] };
        (low[0] < high[0]).then_some(Side { low, high, of })
    }

    fn y_at(&self, x: f64) -> f64 {
        let share = (x - self.low[0]) / (self.high[0] - self.low[0]);
        self.low[1] + share * (self.high[1] - self.low[1])
    }
}

/// The x at which sides cross, of sides sorted by their left ends.
fn crossings(sides: &[Side]) -> Vec<f64> {
    let mut found = Vec::new();
    let mut active: Vec<&Side> = Vec::new();
    for side in sides {
        active.retain(|other| other.high[0] > side.low[0]);
        for other in &active {
            let [from, to] = [side.low[0], side.high[0].min(other.high[0])];
            let [before, after] = [from, to].map(|x| side.y_at(x) - other.y_at(x));
            if before * after < 0.0 {
                let x = from + (to - from) * (before / (before - after));
                if x > from && x < to {
                    found.push(x);
                }
            }
        }
        active.push(side);
    }
    found
}
