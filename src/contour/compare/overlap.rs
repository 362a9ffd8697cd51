//! Intersection over union of two regions with holes.

mod slab;

use thiserror::Error;

use self::slab::{Swept, sweep};
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
    /// The lines of a region cross each other so often that its places are in no order.
    #[error(
        "the lines cross themselves more than {MOST_CROSSINGS} times a side: expected places in order round closed lines"
    )]
    NoOrder {
        /// The region: 0 or 1.
        of: usize,
    },
}

/// Area common to two regions over the area of either, from 0 to 1.
///
/// A region is its closed lines, the first place not repeated; a place is in it if an odd number of lines encloses it, so
/// a line within another is a hole. The plane is cut into slabs at every corner; within a slab sides are straight, and change places where
/// they cross. Areas are sums of trapezia, and crossings are rounded. Time n·√n for outlines of n corners, n² at worst, and log n for every
/// crossing.
///
/// # Errors
///
/// No area at all; a coordinate that is not finite; lines that cross themselves everywhere.
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
    cuts.sort_by(f64::total_cmp);
    cuts.dedup();
    let most =
        [0, 1].map(|of| MOST_CROSSINGS * sides.iter().filter(|side| side.of == of).count() as u64);
    let highest = sides.iter().flat_map(|side| [side.low[1].abs(), side.high[1].abs()]);
    let least = ROUNDING * highest.fold(0.0, f64::max);
    let mut swept = Swept::default();
    let mut active: Vec<Side> = Vec::new();
    let mut waiting = sides.into_iter().peekable();
    for pair in cuts.windows(2) {
        let [from, to] = [pair[0], pair[1]];
        active.retain(|side| side.high[0] > from);
        while let Some(side) = waiting.next_if(|side| side.low[0] <= from) {
            active.push(side);
        }
        sweep(&mut active, [from, to], least, &mut swept);
        if let Some(of) = [0, 1].into_iter().find(|&of| swept.own_crossings[of] > most[of]) {
            return Err(IouError::NoOrder { of });
        }
    }
    let Swept { common, either, .. } = swept;
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

/// How often the lines of a region cross themselves at most, a side: those of some 600 places in no order do.
const MOST_CROSSINGS: u64 = 100;
/// Share of the largest height that two sides are apart by rounding.
const ROUNDING: f64 = 1e-12;
