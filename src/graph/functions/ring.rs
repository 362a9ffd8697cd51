//! The neighbours of each place, both ways.

use asphera_geometry::Sets;

use crate::cloud::{Cloud, PlaceId};
use crate::nearest::Nearest;
use crate::tree::squared_distance;

/// Places and their neighbours: q is one of p if either is among the nearest of the other.
pub(super) struct Rings {
    starts: Vec<u32>,
    ids: Vec<PlaceId>,
    lengths_mm: Vec<f64>,
    part_of: Vec<u32>,
    /// Connected parts of the graph.
    pub(super) parts: u32,
}

impl Rings {
    pub(super) fn new<const D: usize>(cloud: &Cloud<D>, nearest: &Nearest) -> Rings {
        let count = cloud.len() as u32;
        let is_mutual = |p: PlaceId, q: PlaceId| nearest.neighbours(q).contains(&p);
        let mut degrees = vec![nearest.k() as u32; count as usize];
        for place in 0..count {
            for &other in
                nearest.neighbours(place).iter().filter(|&&other| !is_mutual(place, other))
            {
                degrees[other as usize] += 1;
            }
        }
        let mut starts = vec![0];
        let mut end = 0;
        for degree in degrees {
            end += degree;
            starts.push(end);
        }
        let mut sets = Sets::new(count as usize);
        let mut next = starts.clone();
        let mut ids = vec![0; end as usize];
        let mut add = |place: PlaceId, other: PlaceId| {
            ids[next[place as usize] as usize] = other;
            next[place as usize] += 1;
        };
        for place in 0..count {
            for &other in nearest.neighbours(place) {
                add(place, other);
                if !is_mutual(place, other) {
                    add(other, place);
                }
                sets.join(place as usize, other as usize);
            }
        }
        let places = cloud.places();
        let mut lengths_mm = Vec::with_capacity(ids.len());
        for (at, place) in places.iter().enumerate() {
            let own = &ids[starts[at] as usize..starts[at + 1] as usize];
            let length = |&other: &PlaceId| squared_distance(place, &places[other as usize]).sqrt();
            lengths_mm.extend(own.iter().map(length));
        }
        let (part_of, parts) = sets.numbered();
        Rings { starts, ids, lengths_mm, part_of, parts }
    }

    /// The neighbours of a place with their distances in mm.
    pub(super) fn neighbours(&self, place: PlaceId) -> impl Iterator<Item = (PlaceId, f64)> {
        let at = place as usize;
        let range = self.starts[at] as usize..self.starts[at + 1] as usize;
        self.ids[range.clone()].iter().copied().zip(self.lengths_mm[range].iter().copied())
    }

    /// The connected part of a place.
    pub(super) fn part(&self, place: PlaceId) -> u32 {
        self.part_of[place as usize]
    }
}
