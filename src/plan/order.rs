//! Scattered places in the order of a short path.

mod exact;
mod grid;
mod improve;

use std::collections::BTreeMap;

use crate::PlanError;
use crate::piece::distance_mm;

/// Order of places on a short open path from where the probe stands; it ends anywhere.
///
/// Up to 12 places the path is the shortest (M. Held, R. M. Karp, J. SIAM 10 (1962) 196-210, doi:10.1137/0110015). Of more it goes to
/// the nearest place each time, then is shortened: 2-opt reverses a piece (G. A. Croes, Operations Research 6 (1958) 791-812,
/// doi:10.1287/opre.6.6.791), Or-opt moves up to three places elsewhere (I. Or 1976). New neighbours come from the eight nearest of a place.
///
/// Ties are decided by coordinates, first x, then y, so the path does not depend on the order of the places. Lengths are rounded to 2⁻⁴⁰ of
/// the box about all places, and their sums are exact. Places that are equal follow each other.
///
/// # Errors
///
/// When a place is not finite or there are more than [`MOST_PLACES`].
pub fn short_order(from_mm: [f64; 2], places: &[[f64; 2]]) -> Result<Vec<usize>, PlanError> {
    let bad =
        places.iter().chain([&from_mm]).position(|place| !place.iter().all(|mm| mm.is_finite()));
    if let Some(index) = bad {
        let found = match places.get(index) {
            Some(place) => format!("{place:?} as place {}", index + 1),
            None => format!("{from_mm:?} as the beginning"),
        };
        return Err(PlanError::new("places", "two numbers in mm", found, "leave the place out"));
    }
    if places.len() > MOST_PLACES {
        return Err(PlanError::new(
            "places",
            format!("at most {MOST_PLACES}"),
            places.len().to_string(),
            "ask for a coarser sampling, or order one region after the other",
        ));
    }
    let mut same: BTreeMap<[Key; 2], Vec<usize>> = BTreeMap::new();
    for (index, place) in places.iter().enumerate() {
        same.entry(place.map(Key)).or_default().push(index);
    }
    let distinct: Vec<[f64; 2]> = same.keys().map(|key| key.map(|Key(mm)| mm)).collect();
    let ruler = Ruler::new(from_mm, &distinct);
    let order = if distinct.len() <= exact::MOST {
        exact::shortest(&ruler)
    } else {
        improve::shortened(&ruler, grid::nearest_first(&ruler), &grid::neighbours(&ruler))
    };
    let groups: Vec<Vec<usize>> = same.into_values().collect();
    Ok(order.into_iter().flat_map(|node| groups[node - 1].clone()).collect())
}

/// Length in mm of the path from a place through others.
pub fn path_length_mm(from_mm: [f64; 2], places: impl IntoIterator<Item = [f64; 2]>) -> f64 {
    let mut at = from_mm;
    let mut sum = 0.0;
    for place in places {
        sum += distance_mm(at, place);
        at = place;
    }
    sum
}

/// A coordinate with an order; both zeros are one.
#[derive(Clone, Copy, Debug)]
struct Key(f64);

impl PartialEq for Key {
    fn eq(&self, other: &Key) -> bool {
        self.cmp(other).is_eq()
    }
}

impl Eq for Key {}

impl PartialOrd for Key {
    fn partial_cmp(&self, other: &Key) -> Option<std::cmp::Ordering> {
        Some(self.cmp(other))
    }
}

impl Ord for Key {
    fn cmp(&self, other: &Key) -> std::cmp::Ordering {
        (self.0 + 0.0).total_cmp(&(other.0 + 0.0))
    }
}

/// Lengths in whole numbers between nodes: 0 is the beginning, 1 to n are the places in the order of their coordinates.
struct Ruler {
    nodes: Vec<[f64; 2]>,
    /// A power of two, units per mm.
    scale: f64,
}

impl Ruler {
    fn new(from_mm: [f64; 2], places: &[[f64; 2]]) -> Ruler {
        let nodes: Vec<[f64; 2]> = [from_mm].into_iter().chain(places.iter().copied()).collect();
        let extent = |axis: usize| {
            let values = || nodes.iter().map(|node| node[axis]);
            values().fold(f64::NEG_INFINITY, f64::max) - values().fold(f64::INFINITY, f64::min)
        };
        let size = extent(0).max(extent(1)).clamp(1e-200, 1e200);
        let scale = (UNITS_LOG2 - size.log2().ceil()).exp2();
        Ruler { nodes, scale }
    }

    /// How many places there are.
    fn places(&self) -> usize {
        self.nodes.len() - 1
    }

    fn length(&self, p: usize, q: usize) -> i64 {
        let [dx, dy] = [0, 1].map(|axis| self.scale * (self.nodes[q][axis] - self.nodes[p][axis]));
        (dx * dx + dy * dy).sqrt().round() as i64
    }
}

/// Units across the box of all places.
const UNITS_LOG2: f64 = 40.0;

/// Most places of one path.
pub const MOST_PLACES: usize = 50_000;

#[cfg(test)]
mod tests;
