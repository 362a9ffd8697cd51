//! The places and deviations that count.

use rayon::prelude::*;
use thiserror::Error;

use asphera_form::Aperture;
use asphera_form::linear::CHUNK;
use asphera_form::{ApertureError, NM_PER_MM};

/// Places of the part frame with their deviations, those that count.
///
/// Invariants: places and deviations are finite and below 1e60 mm; areas are in units of the largest, which
/// is 1 unless the sample is empty.
#[derive(Clone, Debug, PartialEq)]
pub struct Sample {
    places_mm: Vec<[f64; 2]>,
    values_nm: Vec<f64>,
    areas: Vec<f64>,
    indices: Vec<usize>,
    total_area: f64,
    weighted: usize,
    radius_mm: f64,
    aperture: Aperture,
    left_out: LeftOut,
}

/// Points a sample leaves out, by reason.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct LeftOut {
    /// A coordinate or the deviation is not finite, or beyond 1e60 mm.
    pub not_finite: usize,
    /// The place lies outside the aperture.
    pub outside_aperture: usize,
}

/// Why points make no sample.
#[derive(Clone, Copy, Debug, Error, PartialEq)]
pub enum SampleError {
    /// Lists of different lengths.
    #[error("{places} places, but {values} {name}")]
    Lengths {
        /// Places given.
        places: usize,
        /// What there is another number of.
        name: &'static str,
        /// How many of these.
        values: usize,
    },
    /// The aperture is none.
    #[error("the aperture is not usable")]
    Aperture(#[from] ApertureError),
    /// An area that is negative or not finite.
    #[error("the area of point {index} is {area_mm2} mm², expected a finite number not below 0")]
    Area {
        /// Index of the point.
        index: usize,
        /// Its area in mm².
        area_mm2: f64,
    },
    /// No point that counts has an area.
    #[error("each of {points} points in the aperture has area 0")]
    NoArea {
        /// Points in the aperture.
        points: usize,
    },
}

impl Sample {
    /// The places (x, y) of `places_mm`, part frame, within `aperture` that have a deviation. `O(n)`.
    ///
    /// `deviations_mm` has one entry a point, NaN for none. `areas_mm2` is the area each point stands for,
    /// in mm² or any common unit; without it all points weigh the same. A point of area 0, or of less than
    /// 1e-20 of the largest, takes part in extremes and in nothing else.
    pub fn new(
        places_mm: &[[f64; 2]],
        deviations_mm: &[f64],
        areas_mm2: Option<&[f64]>,
        aperture: &Aperture,
    ) -> Result<Sample, SampleError> {
        aperture.validate()?;
        let places = places_mm.len();
        let same = |name, values| {
            if values == places {
                Ok(())
            } else {
                Err(SampleError::Lengths { places, name, values })
            }
        };
        same("deviations", deviations_mm.len())?;
        if let Some(areas_mm2) = areas_mm2 {
            same("areas", areas_mm2.len())?;
        }
        let mut sample = Sample {
            places_mm: Vec::with_capacity(places),
            values_nm: Vec::with_capacity(places),
            areas: Vec::with_capacity(places),
            indices: Vec::with_capacity(places),
            total_area: 0.0,
            weighted: 0,
            radius_mm: 0.0,
            aperture: aperture.clone(),
            left_out: LeftOut::default(),
        };
        for (index, (&[x, y], &deviation_mm)) in places_mm.iter().zip(deviations_mm).enumerate() {
            let area_mm2 = areas_mm2.map_or(1.0, |areas_mm2| areas_mm2[index]);
            if !(0.0..LARGEST).contains(&area_mm2) {
                return Err(SampleError::Area { index, area_mm2 });
            }
            // A NaN is in no range.
            if ![x, y, deviation_mm].iter().all(|number| (-LARGEST..LARGEST).contains(number)) {
                sample.left_out.not_finite += 1;
            } else if !aperture.contains(x, y) {
                sample.left_out.outside_aperture += 1;
            } else {
                sample.places_mm.push([x, y]);
                sample.values_nm.push(deviation_mm * NM_PER_MM);
                sample.areas.push(area_mm2);
                sample.indices.push(index);
            }
        }
        // In units of the largest, so that products of areas neither overflow nor vanish.
        let largest = sample.areas.iter().copied().fold(0.0, f64::max);
        for area in sample.areas.iter_mut().filter(|area| **area > 0.0) {
            let share = *area / largest;
            *area = if share >= SMALLEST_SHARE { share } else { 0.0 };
        }
        sample.weighted = sample.areas.iter().filter(|&&area| area > 0.0).count();
        if sample.weighted == 0 && !sample.is_empty() {
            return Err(SampleError::NoArea { points: sample.len() });
        }
        sample.total_area = sample.sum(|_| 1.0);
        sample.radius_mm = aperture.reach_mm().unwrap_or_else(|| {
            sample.places_mm.iter().map(|p| p[0].hypot(p[1])).fold(0.0, f64::max)
        });
        Ok(sample)
    }

    /// As [`Sample::new`]; where no point has an area, all weigh the same.
    pub fn by_area(
        places_mm: &[[f64; 2]],
        deviations_mm: &[f64],
        areas_mm2: Option<&[f64]>,
        aperture: &Aperture,
    ) -> Result<Sample, SampleError> {
        match Sample::new(places_mm, deviations_mm, areas_mm2, aperture) {
            Err(SampleError::NoArea { .. }) => {
                Sample::new(places_mm, deviations_mm, None, aperture)
            }
            found => found,
        }
    }

    /// How many points count.
    pub fn len(&self) -> usize {
        self.values_nm.len()
    }

    /// Whether no point counts.
    pub fn is_empty(&self) -> bool {
        self.values_nm.is_empty()
    }

    /// Places that count, part frame, mm, in the order given.
    pub fn places_mm(&self) -> &[[f64; 2]] {
        &self.places_mm
    }

    /// Deviations in nm, one a place.
    pub fn values_nm(&self) -> &[f64] {
        &self.values_nm
    }

    /// For each place that counts, the index of its point in the lists the sample was made from.
    pub fn indices(&self) -> &[usize] {
        &self.indices
    }

    /// Points left out, by reason.
    pub fn left_out(&self) -> LeftOut {
        self.left_out
    }

    /// Radius in mm that polynomials on the unit disc refer to: that of the smallest disc about the vertex
    /// that holds the aperture, or the farthest place where there is no aperture.
    pub fn radius_mm(&self) -> f64 {
        self.radius_mm
    }

    /// Places kept, with other deviations, one a place.
    pub(crate) fn with_values(&self, values_nm: Vec<f64>) -> Sample {
        debug_assert_eq!(values_nm.len(), self.len(), "one value a place");
        Sample { values_nm, ..self.clone() }
    }

    /// Distance from the axis of the nearest and the farthest place of the aperture, in mm; of the sample
    /// where there is no aperture.
    pub(crate) fn reach_mm(&self) -> [f64; 2] {
        if self.aperture != Aperture::None {
            return [self.aperture.hole_mm(), self.radius_mm];
        }
        let radii = self.places_mm.iter().map(|place| place[0].hypot(place[1]));
        [radii.fold(self.radius_mm, f64::min), self.radius_mm]
    }

    /// The part of the surface that the sample is of, lengths in mm.
    pub fn aperture(&self) -> &Aperture {
        &self.aperture
    }

    pub(crate) fn areas(&self) -> &[f64] {
        &self.areas
    }

    pub(crate) fn total_area(&self) -> f64 {
        self.total_area
    }

    /// Points with a positive area.
    pub(crate) fn weighted(&self) -> usize {
        self.weighted
    }

    /// Area-weighted mean of a quantity of the points, by index. The sample must not be empty.
    pub fn mean(&self, quantity: impl Fn(usize) -> f64 + Sync) -> f64 {
        self.sum(quantity) / self.total_area
    }

    /// Smallest and largest of a list with one entry a place; `None` for an empty sample.
    pub fn range(values: &[f64]) -> Option<[f64; 2]> {
        let &first = values.first()?;
        Some(values.iter().fold([first; 2], |[low, high], &v| [low.min(v), high.max(v)]))
    }

    fn sum(&self, quantity: impl Fn(usize) -> f64 + Sync) -> f64 {
        let chunks: Vec<f64> = self
            .areas
            .par_chunks(CHUNK)
            .enumerate()
            .map(|(chunk, areas)| {
                let terms = areas.iter().enumerate();
                terms.map(|(i, area)| area * quantity(chunk * CHUNK + i)).sum::<f64>()
            })
            .collect();
        chunks.iter().sum()
    }
}

/// Numbers up to this have squares and sums of squares that do not overflow.
const LARGEST: f64 = 1e60;
/// Points of a smaller share of the largest area could not be told from rounding.
const SMALLEST_SHARE: f64 = 1e-20;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_does_not_count_is_counted() {
        let points = [[0.0, 0.0], [f64::NAN, 0.0], [3.0, 0.0], [1.0, 0.0], [0.5, 0.5]];
        let deviations = [1e-6, 1e-6, 1e-6, f64::NAN, -2e-6];
        let circle = Aperture::Circle { radius_mm: 2.0 };
        let sample = Sample::new(&points, &deviations, None, &circle).unwrap();
        assert_eq!(sample.indices(), [0, 4]);
        assert_eq!(sample.left_out(), LeftOut { not_finite: 2, outside_aperture: 1 });
        assert!((sample.mean(|i| sample.values_nm()[i]) + 0.5).abs() < 1e-15);
        assert_eq!((sample.radius_mm(), sample.reach_mm()), (2.0, [0.0, 2.0]));
        let free = Sample::new(&points, &deviations, None, &Aperture::None).unwrap();
        assert_eq!(free.reach_mm(), [0.0, 3.0]);
    }

    #[test]
    fn lists_and_areas_that_do_not_fit_are_refused() {
        let points = [[0.0; 2]; 2];
        let new = |deviations: &[f64], areas: &[f64]| {
            Sample::new(&points, deviations, Some(areas), &Aperture::None)
        };
        let error = new(&[0.0], &[1.0, 1.0]).unwrap_err();
        assert_eq!(error.to_string(), "2 places, but 1 deviations");
        assert!(matches!(new(&[0.0; 2], &[1.0]), Err(SampleError::Lengths { name: "areas", .. })));
        for bad in [-1.0, f64::NAN, f64::INFINITY] {
            assert!(matches!(new(&[0.0; 2], &[1.0, bad]), Err(SampleError::Area { index: 1, .. })));
        }
        assert_eq!(new(&[0.0; 2], &[0.0; 2]), Err(SampleError::NoArea { points: 2 }));
        let nothing = Aperture::Circle { radius_mm: 0.0 };
        let refused = Sample::new(&points, &[0.0; 2], None, &nothing);
        assert!(matches!(refused, Err(SampleError::Aperture(_))));
    }
}
