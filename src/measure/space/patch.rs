//! Patches of a mesh in space, laid flat about their middle.

use std::collections::BTreeMap;

use asphera_geometry::PointMm;
use asphera_geometry::vector::{Vector, dot, minus};

use super::meshed::Meshed;
use super::shape::{Laid, across};

/// A patch laid flat.
pub(super) struct Patch {
    /// The seed first, where u, v and height are 0.
    pub(super) places_mm: Vec<PointMm>,
    pub(super) facets: Vec<[u32; 3]>,
}

/// The facets at every vertex.
pub(super) struct AtVertex {
    starts: Vec<u32>,
    facets: Vec<u32>,
}

impl AtVertex {
    pub(super) fn of(meshed: &Meshed) -> AtVertex {
        let mut starts = vec![0_u32; meshed.points_mm.len() + 1];
        for &corner in meshed.facets.as_flattened() {
            starts[corner as usize + 1] += 1;
        }
        for at in 1..starts.len() {
            starts[at] += starts[at - 1];
        }
        let mut next = starts.clone();
        let mut facets = vec![0; 3 * meshed.facets.len()];
        for (corners, facet) in meshed.facets.iter().zip(0..) {
            for &corner in corners {
                facets[next[corner as usize] as usize] = facet;
                next[corner as usize] += 1;
            }
        }
        AtVertex { starts, facets }
    }

    fn at(&self, vertex: u32) -> &[u32] {
        let vertex = vertex as usize;
        &self.facets[self.starts[vertex] as usize..self.starts[vertex + 1] as usize]
    }

    /// The vertices within some rings of a seed, and the facets about the inner ones. A patch that bends away from its middle by
    /// more than a right angle is none. Heights are deviations where a shape is given, else those over the tangent plane.
    pub(super) fn patch(
        &self,
        meshed: &Meshed,
        (seed, normal): (u32, Vector),
        rings: usize,
        laid: Option<&Laid>,
    ) -> Option<Patch> {
        let mut numbers: BTreeMap<u32, u32> = BTreeMap::from([(seed, 0)]);
        let mut order = vec![seed];
        let mut chosen = Vec::new();
        let mut from = 0;
        for _ in 0..rings {
            let to = order.len();
            for at in from..to {
                for &facet in self.at(order[at]) {
                    chosen.push(facet);
                    for corner in meshed.facets[facet as usize] {
                        let next = numbers.len() as u32;
                        numbers.entry(corner).or_insert_with(|| {
                            order.push(corner);
                            next
                        });
                    }
                }
            }
            from = to;
        }
        chosen.sort_unstable();
        chosen.dedup();
        let corners = |&facet: &u32| meshed.facets[facet as usize];
        if chosen.iter().map(corners).any(|facet| dot(meshed.double_area(facet), normal) <= 0.0) {
            return None;
        }
        let [u, v] = across(normal);
        let middle = meshed.points_mm[seed as usize];
        let flat = |&vertex: &u32| {
            let place = meshed.points_mm[vertex as usize];
            let way = minus(place, middle);
            let height = laid.map_or_else(|| dot(way, normal), |laid| laid.off(place).0);
            [dot(way, u), dot(way, v), height]
        };
        let places_mm = order.iter().map(flat).collect();
        let facets = chosen.iter().map(|facet| corners(facet).map(|corner| numbers[&corner]));
        Some(Patch { places_mm, facets: facets.collect() })
    }
}
