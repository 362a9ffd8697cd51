//! The points a curve is looked for in: admitted, each place once, in the order of their coordinates.

use asphera_geometry::predicates::{by_x_then_y, orientation};
use asphera_geometry::{BoundsMm, RANGE_MM, TINY_MM};
use rayon::prelude::*;
use thiserror::Error;

use crate::counting::{Entry, entry, key, number, sort_by_key};

/// A place in the plane: x and y in mm.
pub type PlaceMm = [f64; 2];

/// Number of a sample: its index in [`Samples::places`].
pub type SampleId = u32;

/// Points in the plane, each place once.
///
/// Samples are numbered by x, then y. So every decision that falls by the smaller number falls by coordinates, and
/// nothing depends on the order in which points came.
#[derive(Clone, Debug)]
pub struct Samples {
    places: Vec<PlaceMm>,
    /// The sample of each row.
    of_row: Vec<SampleId>,
    /// The first row of each sample.
    rows: Vec<u32>,
}

impl Samples {
    /// The samples of points in mm, with coordinates below [`TINY_MM`] taken as zero; n·log n time.
    ///
    /// # Errors
    ///
    /// A coordinate that is not finite or larger than [`RANGE_MM`]; more than [`MOST_POINTS`].
    pub fn new(points: &[PlaceMm]) -> Result<Samples, SamplesError> {
        if points.len() > MOST_POINTS {
            return Err(SamplesError::TooMany { found: points.len() });
        }
        let mut places = Vec::with_capacity(points.len());
        for (row, &[x_mm, y_mm]) in points.iter().enumerate() {
            if !x_mm.is_finite() || !y_mm.is_finite() {
                return Err(SamplesError::NotFinite { row, x_mm, y_mm });
            }
            if x_mm.abs() > RANGE_MM || y_mm.abs() > RANGE_MM {
                return Err(SamplesError::OutOfRange { row, x_mm, y_mm });
            }
            places.push([x_mm, y_mm].map(|value| if value.abs() < TINY_MM { 0.0 } else { value }));
        }
        let mut samples =
            Samples { places: Vec::new(), of_row: vec![0; places.len()], rows: Vec::new() };
        for row in sorted(&places).into_iter().map(number) {
            let place = places[row as usize];
            if samples.places.last() != Some(&place) {
                samples.places.push(place);
                samples.rows.push(row);
            }
            samples.of_row[row as usize] = samples.places.len() as SampleId - 1;
        }
        Ok(samples)
    }

    /// The places of the samples in mm, by x, then y.
    pub fn places(&self) -> &[PlaceMm] {
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

    /// Whether all lie on one straight line, as one or two do.
    pub fn are_on_line(&self) -> bool {
        let [Some(&first), Some(&last)] = [self.places.first(), self.places.last()] else {
            return true;
        };
        self.places.iter().all(|&place| orientation(first, last, place).is_eq())
    }

    /// How many points were given, repeated ones among them.
    pub fn points(&self) -> usize {
        self.of_row.len()
    }

    /// The sample of a row of the input, counted from 0.
    ///
    /// # Panics
    ///
    /// If there is no such row.
    pub fn of_row(&self, row: usize) -> SampleId {
        self.of_row[row]
    }

    /// The first row, counted from 0, that holds a sample's place.
    ///
    /// # Panics
    ///
    /// If there is no such sample.
    pub fn row_of(&self, sample: SampleId) -> u32 {
        self.rows[sample as usize]
    }
}

/// The rows of places by x, then y, equal places in their order.
fn sorted(places: &[PlaceMm]) -> Vec<Entry> {
    let BoundsMm { low, high } = BoundsMm::about(places.iter().copied());
    // Strips across x, so narrow that few places share one; in their order. Of one x alone each number becomes nought.
    let per_mm = f64::from(u32::MAX) / (high[0] - low[0]);
    let strip = |place: &PlaceMm| ((place[0] - low[0]) * per_mm) as u32;
    let mut rows: Vec<Entry> =
        (0..).zip(places).map(|(row, place)| entry(strip(place), row)).collect();
    sort_by_key(&mut rows);
    for strip in rows.chunk_by_mut(|&a, &b| key(a) == key(b)).filter(|strip| strip.len() > 1) {
        let place = |row: Entry| places[number(row) as usize];
        strip.par_sort_unstable_by(|&a, &b| by_x_then_y(place(a), place(b)).then(a.cmp(&b)));
    }
    rows
}

/// Reason why points are refused.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum SamplesError {
    /// A coordinate is NaN or infinite.
    #[error("point {} is ({x_mm}, {y_mm}): expected finite coordinates; leave the point out", row + 1)]
    NotFinite {
        /// The row, counted from 0.
        row: usize,
        /// Its x in mm.
        x_mm: f64,
        /// Its y in mm.
        y_mm: f64,
    },
    /// A coordinate is larger than [`RANGE_MM`].
    #[error(
        "point {} is ({x_mm}, {y_mm}) mm: expected coordinates of at most 1e12 mm; check the unit",
        row + 1
    )]
    OutOfRange {
        /// The row, counted from 0.
        row: usize,
        /// Its x in mm.
        x_mm: f64,
        /// Its y in mm.
        y_mm: f64,
    },
    /// More points than edges can be numbered for.
    #[error("{found} points: expected at most {MOST_POINTS}; take fewer")]
    TooMany {
        /// How many there are.
        found: usize,
    },
}

/// So many points are taken at most: the mesh of points and Voronoi vertices together, three times as many, still has
/// numbers for its vertices.
pub const MOST_POINTS: usize = 1 << 27;
