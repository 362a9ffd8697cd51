//! The neighbours of each place, both ways.

use asphera_geometry::Sets;

use crate::cloud::{Cloud, PlaceId};
use crate::nearest::Nearest;

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
        let k = nearest.k();
        // Whether a place is among the nearest of a neighbour: most distances say so alone.
        let is_mutual = |place: PlaceId, other: PlaceId, mm: f64| {
            let last_mm = nearest.distances_mm(other)[k - 1];
            mm < last_mm || (mm == last_mm && nearest.neighbours(other).contains(&place))
        };
        let neighbours = |place: PlaceId| {
            let others = nearest.neighbours(place).iter().zip(nearest.distances_mm(place));
            others.map(move |(&other, &mm)| (other, mm, is_mutual(place, other, mm)))
        };
        let mut degrees = vec![k as u32; count as usize];
        for (other, ..) in (0..count).flat_map(neighbours).filter(|(.., is_mutual)| !is_mutual) {
            degrees[other as usize] += 1;
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
        let mut lengths_mm = vec![0.0; end as usize];
        let mut add = |place: PlaceId, other: PlaceId, mm: f64| {
            let at = &mut next[place as usize];
            (ids[*at as usize], lengths_mm[*at as usize]) = (other, mm);
            *at += 1;
        };
        for place in 0..count {
            for (other, mm, is_mutual) in neighbours(place) {
                add(place, other, mm);
                if !is_mutual {
                    add(other, place, mm);
                }
                // Mutual neighbours are joined once.
                if !is_mutual || place < other {
                    sets.join(place as usize, other as usize);
                }
            }
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
