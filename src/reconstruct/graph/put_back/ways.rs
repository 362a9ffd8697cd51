//! The ways in which a point becomes a vertex, and whether they would fold the surface.

use super::{Bounds, Filling, RINGS, cosine};
use crate::geometry::{dot, double_area, squared};
use crate::prove::cross_any;

/// A way to make a point a vertex of a facet.
#[derive(Clone, Copy)]
pub(super) enum Way {
    Facet,
    /// The edge opposite a corner.
    Edge(usize),
    /// Over the border opposite a corner.
    Ear(usize),
}

impl Way {
    /// The corner opposite the edge that it is over.
    pub(super) fn corner(self) -> Option<usize> {
        match self {
            Way::Facet => None,
            Way::Edge(corner) | Way::Ear(corner) => Some(corner),
        }
    }
}

impl Filling<'_> {
    /// The mean square of the distances to the neighbours in the graph.
    pub(super) fn reach(&self, point: u32) -> f64 {
        let (own, links) = (self.place(point), self.graph.links.at(point));
        let squares = links.iter().map(|&near| squared(own, self.place(near)));
        squares.sum::<f64>() / links.len() as f64
    }

    /// The first way that turns no facet far: into the facet where the point lies well within, else over an edge.
    pub(super) fn way(&self, facet: u32, point: u32, bounds: &Bounds) -> Option<Way> {
        let (own, places) = (self.place(point), self.places(facet));
        let normal = double_area(places);
        let size = dot(normal, normal);
        let weights = [0, 1, 2].map(|corner| {
            let mut sub = places;
            sub[corner] = own;
            dot(normal, double_area(sub)) / size
        });
        // Height over each edge as a share of its length.
        let heights = [0, 1, 2].map(|corner| {
            let side = squared(places[(corner + 1) % 3], places[(corner + 2) % 3]);
            weights[corner] * size.sqrt() / side
        });
        let mut corners = [0, 1, 2];
        corners.sort_by(|&a, &b| heights[a].total_cmp(&heights[b]));
        let is_within = heights[corners[0]] > FLAT;
        let whole = std::iter::once(Way::Facet);
        let edges = corners.into_iter().filter(|&corner| weights[corner] < 0.5).map(|corner| {
            if heights[corner] < -FLAT && self.mesh.is_border(facet, corner) {
                Way::Ear(corner)
            } else {
                Way::Edge(corner)
            }
        });
        let is_fit = |way: &Way| self.is_fit(facet, *way, point, bounds);
        if is_within {
            whole.chain(edges).find(is_fit)
        } else {
            edges.chain(whole.filter(|_| heights[corners[0]] > 0.0)).find(is_fit)
        }
    }

    /// Whether a step turns no facet far, and crosses nothing where that is asked.
    fn is_fit(&self, facet: u32, way: Way, point: u32, bounds: &Bounds) -> bool {
        let sign = if matches!(way, Way::Ear(_)) { -1.0 } else { 1.0 };
        let is_border = way.corner().is_some_and(|corner| self.mesh.is_border(facet, corner));
        let Some(pieces) = self.pieces(facet, way) else { return false };
        let turns = pieces.iter().all(|&(from, corner)| {
            let mut places = self.places(from);
            let before = double_area(places);
            places[corner] = self.place(point);
            sign * cosine(before, double_area(places)) > bounds.turn_cosine
        });
        turns && !(bounds.crosses_nothing && self.crosses(way, &pieces, point, is_border))
    }

    /// New facets of a step: each is a facet that there is, with the point in place of a corner. `None` where there is no such step.
    fn pieces(&self, facet: u32, way: Way) -> Option<Vec<(u32, usize)>> {
        let halves = |facet: u32, far: usize| [1, 2].map(|more| (facet, (far + more) % 3));
        match way {
            Way::Facet => Some([0, 1, 2].map(|corner| (facet, corner)).to_vec()),
            Way::Ear(corner) => Some(vec![(facet, corner)]),
            Way::Edge(corner) => {
                let mut pieces = halves(facet, corner).to_vec();
                if let Some(other) = self.mesh.over(facet, corner) {
                    let [own, a, b] = self.mesh.from(facet, corner);
                    // Two facets with the same corners would share the new edge too.
                    if self.mesh.apex(other, [a, b]) == own {
                        return None;
                    }
                    pieces.extend(halves(other, self.mesh.opposite(other, [a, b])));
                } else if !self.mesh.is_border(facet, corner) {
                    return None;
                }
                Some(pieces)
            }
        }
    }

    /// Whether new facets cross what is within two rings of facets about them.
    fn crosses(&self, way: Way, pieces: &[(u32, usize)], point: u32, is_border: bool) -> bool {
        let new = pieces.iter().map(|&(from, corner)| {
            let mut corners = self.mesh.corners[from as usize];
            corners[corner] = point;
            corners
        });
        let new: Vec<[u32; 3]> = new.collect();
        let parents: Vec<u32> = pieces.iter().map(|&(from, _)| from).collect();
        let gone = if matches!(way, Way::Ear(_)) { &[] } else { &parents[..] };
        let mut near = parents.clone();
        if is_border {
            // The other side of a notch is near in space, but many rings away.
            let mut fan = Vec::new();
            for &neighbour in self.graph.links.at(point) {
                self.mesh.fan(neighbour, &mut fan);
                near.extend(&fan);
            }
        }
        cross_any(self.points_mm, &new, &self.mesh.around(&near, gone, RINGS))
    }
}

/// A point whose height over an edge is a smaller share of the edge lies over the edge: the facet on it would be a sliver.
const FLAT: f64 = 0.05;
