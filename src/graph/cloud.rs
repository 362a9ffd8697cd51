//! Points as they are taken in: checked, each place once, in an order that depends on the places alone.

use rayon::prelude::*;
use thiserror::Error;

use crate::tree::{self, Node};

/// Number of a place: its index in [`Cloud::places`].
pub type PlaceId = u32;

/// Points of the plane (D = 2), of space (3) or of four dimensions (4), coordinates in mm.
///
/// Places are numbered along a k-d tree: neighbours have near numbers, and the numbers depend on the set of places
/// alone. So ties that fall by number fall by coordinates, and sums in the order of places do not depend on the order
/// of the points. Equal points share a place.
#[derive(Clone, Debug)]
pub struct Cloud<const D: usize> {
    places: Vec<[f64; D]>,
    /// The place of each row.
    of_row: Vec<PlaceId>,
    pub(crate) nodes: Vec<Node<D>>,
}

impl<const D: usize> Cloud<D> {
    /// The cloud of points in mm, whose rows count from 0. n·log n time, 60 bytes a point while it is made.
    ///
    /// # Errors
    ///
    /// A coordinate that is not finite or beyond [`RANGE_MM`]; more than [`MOST_POINTS`].
    pub fn new(points: &[[f64; D]]) -> Result<Cloud<D>, CloudError> {
        if points.len() > MOST_POINTS {
            return Err(CloudError::TooMany { found: points.len() });
        }
        let mut entries = Vec::with_capacity(points.len());
        for (row, point) in points.iter().enumerate() {
            for (axis, &value_mm) in point.iter().enumerate() {
                if value_mm.is_nan() || value_mm.abs() > RANGE_MM {
                    return Err(CloudError::OutOfRange { row, axis, value_mm });
                }
            }
            // −0 becomes 0, too.
            let place = point.map(|value| if value.abs() < TINY_MM { 0.0 } else { value });
            entries.push((place, row as u32));
        }
        let mut nodes = tree::build(&mut entries);
        let mut of_row = vec![0; entries.len()];
        let mut places: Vec<[f64; D]> = Vec::with_capacity(entries.len());
        // Where the places in front of each entry end, kept only from the first copy on.
        let mut moved: Vec<u32> = Vec::new();
        for (at, (place, row)) in entries.iter().enumerate() {
            if places.last() == Some(place) {
                if moved.is_empty() {
                    moved.extend(0..at as u32);
                }
            } else {
                places.push(*place);
            }
            let id = places.len() as u32 - 1;
            if !moved.is_empty() {
                moved.push(id);
            }
            of_row[*row as usize] = id;
        }
        if !moved.is_empty() {
            for node in &mut nodes {
                node.first = moved[node.first as usize];
                node.end = moved[node.end as usize - 1] + 1;
            }
            places.shrink_to_fit();
        }
        Ok(Cloud { places, of_row, nodes })
    }

    /// The places in mm, in the order of their numbers.
    pub fn places(&self) -> &[[f64; D]] {
        &self.places
    }

    /// How many different places there are.
    pub fn len(&self) -> usize {
        self.places.len()
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.places.is_empty()
    }

    /// The place of each row of the input.
    pub fn places_of_rows(&self) -> &[PlaceId] {
        &self.of_row
    }

    /// How many points lie in each place.
    pub fn copies(&self) -> Vec<u32> {
        let mut copies = vec![0; self.places.len()];
        self.of_row.iter().for_each(|&place| copies[place as usize] += 1);
        copies
    }

    /// The least and the largest coordinates in mm; `None` without points.
    pub fn bounds_mm(&self) -> Option<[[f64; D]; 2]> {
        self.nodes.first().map(|root| [root.low, root.high])
    }

    /// Length of the diagonal of the box around the points in mm.
    pub fn diagonal_mm(&self) -> f64 {
        self.bounds_mm().map_or(0.0, |[low, high]| tree::squared_distance(&low, &high).sqrt())
    }

    /// The mean of the places in mm; `None` without points.
    pub fn centre_mm(&self) -> Option<[f64; D]> {
        let [low, _] = self.bounds_mm()?;
        // Sums of what is left of a corner stay exact where the cloud lies far from the origin.
        let sums = self.places.par_chunks(CHUNK).map(|chunk| {
            let mut sum = [0.0; D];
            for place in chunk {
                (0..D).for_each(|axis| sum[axis] += place[axis] - low[axis]);
            }
            sum
        });
        let sums: Vec<[f64; D]> = sums.collect();
        let total: [f64; D] = std::array::from_fn(|axis| sums.iter().map(|sum| sum[axis]).sum());
        Some(std::array::from_fn(|axis| low[axis] + total[axis] / self.len() as f64))
    }

    /// Values a row as values a place; where points share a place, the middle of their least and largest.
    ///
    /// # Panics
    ///
    /// If there are not as many values as rows.
    pub fn by_place(&self, of_row: &[f64]) -> Vec<f64> {
        assert_eq!(of_row.len(), self.of_row.len(), "a value a row");
        let mut ends = vec![[f64::INFINITY, f64::NEG_INFINITY]; self.len()];
        for (&place, &value) in self.of_row.iter().zip(of_row) {
            let [low, high] = &mut ends[place as usize];
            (*low, *high) = (low.min(value), high.max(value));
        }
        ends.into_iter()
            .map(|[low, high]| if low == high { low } else { low / 2.0 + high / 2.0 })
            .collect()
    }
}

/// Reason why points are refused.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum CloudError {
    /// A coordinate is NaN, infinite or larger than [`RANGE_MM`].
    #[error(
        "point {}, coordinate {} is {value_mm} mm: expected at most 1e12 mm from 0; check the unit, or leave the point out",
        row + 1, axis + 1
    )]
    OutOfRange {
        /// The row, counted from 0.
        row: usize,
        /// The axis, counted from 0.
        axis: usize,
        /// The coordinate in mm.
        value_mm: f64,
    },
    /// More points than memory is planned for.
    #[error("{found} points: expected at most {MOST_POINTS}; reduce them first")]
    TooMany {
        /// How many there are.
        found: usize,
    },
    /// Lists of neighbours would take more than 4 GB.
    #[error(
        "{found} neighbours of {places} places: expected at most {MOST_NEIGHBOURS}; take fewer neighbours or a smaller radius"
    )]
    TooManyNeighbours {
        /// How many there would be.
        found: u64,
        /// Places of the cloud.
        places: usize,
    },
}

/// So many points are taken at most: at 100 bytes a point they need 4 GB.
pub const MOST_POINTS: usize = 40_000_000;

/// So many neighbours are listed at most: with their distances 4 GB.
pub const MOST_NEIGHBOURS: u64 = 350_000_000;

/// Coordinates reach so far, in mm.
pub const RANGE_MM: f64 = 1e12;

/// Coordinates below this count as zero, in mm, so that squares of distances neither vanish nor overflow.
const TINY_MM: f64 = 1e-100;

/// Places that are summed up one after the other; the sums of chunks are added in their order.
pub(crate) const CHUNK: usize = 1 << 14;
