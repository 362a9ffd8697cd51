//! All places within a radius of every place.

use rayon::prelude::*;

use crate::cloud::{Cloud, CloudError, MOST_NEIGHBOURS, PlaceId};

/// The places nearer than a radius to every place, by number.
#[derive(Clone, Debug)]
pub struct Within {
    starts: Vec<u64>,
    ids: Vec<PlaceId>,
}

impl Within {
    /// The places nearer than the radius to a place, by number.
    ///
    /// # Panics
    ///
    /// If there is no such place.
    pub fn neighbours(&self, place: PlaceId) -> &[PlaceId] {
        let at = place as usize;
        &self.ids[self.starts[at] as usize..self.starts[at + 1] as usize]
    }

    /// How many pairs of a place and a neighbour there are; each pair counts twice.
    pub fn len(&self) -> usize {
        self.ids.len()
    }

    /// Whether no place has a neighbour.
    pub fn is_empty(&self) -> bool {
        self.ids.is_empty()
    }
}

impl<const D: usize> Cloud<D> {
    /// All other places nearer to a place than `radius_mm`, of every place. Time grows with places times neighbours.
    ///
    /// # Errors
    ///
    /// Lists of more than [`MOST_NEIGHBOURS`] in all.
    pub fn within(&self, radius_mm: f64) -> Result<Within, CloudError> {
        let places: Vec<PlaceId> = (0..self.len() as u32).collect();
        let counts: Vec<u64> = places
            .par_chunks(RUN)
            .flat_map_iter(|run| run.iter().map(|&place| self.count_within(place, radius_mm)))
            .collect();
        let mut starts = vec![0];
        let mut found = 0;
        for count in counts {
            found += count;
            starts.push(found);
        }
        if found > MOST_NEIGHBOURS {
            return Err(CloudError::TooManyNeighbours { found, places: self.len() });
        }
        let lists = places.par_chunks(RUN).flat_map_iter(|run| {
            run.iter().flat_map(|&place| {
                let mut list = Vec::new();
                self.visit_within(place, radius_mm, |other, _| list.push(other));
                list.sort_unstable();
                list
            })
        });
        Ok(Within { ids: lists.collect(), starts })
    }

    fn count_within(&self, place: PlaceId, radius_mm: f64) -> u64 {
        let mut count = 0;
        self.visit_within(place, radius_mm, |_, _| count += 1);
        count
    }
}

/// Places that one job takes.
const RUN: usize = 1024;
