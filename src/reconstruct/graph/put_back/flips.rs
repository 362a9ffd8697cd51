//! Flips of edges about a new vertex, until each is locally Delaunay in its two facets laid flat.

use asphera_geometry::PointMm;

use super::{Filling, RINGS, cosine};
use crate::geometry::{cross, dot, double_area, minus, plus, unit};
use crate::prove::cross_any;

impl Filling<'_> {
    /// Flips edges opposite a new vertex, in the facets given and in those that flips bring to it.
    pub(super) fn flip_about(&mut self, point: u32, facets: Vec<u32>) {
        let mut waiting = facets;
        while let Some(facet) = waiting.pop() {
            let Some(corner) = self.mesh.corner(facet, point) else { continue };
            if self.wants_flip(facet, corner) {
                waiting.extend(self.mesh.flip(facet, corner).into_iter().flatten());
            }
        }
    }

    /// Whether the edge opposite a corner is not locally Delaunay, and its flip turns no facet far and makes no edge twice.
    fn wants_flip(&mut self, facet: u32, corner: usize) -> bool {
        let Some(across) = self.mesh.over(facet, corner) else { return false };
        let [p, a, b] = self.mesh.from(facet, corner);
        let far = self.mesh.apex(across, [a, b]);
        let [at_p, at_a, at_b, at_d] = [p, a, b, far].map(|vertex| self.place(vertex));
        let angle = |apex: PointMm| {
            let ways = [minus(at_a, apex), minus(at_b, apex)];
            let across = cross(ways[0], ways[1]);
            [dot(across, across).sqrt(), dot(ways[0], ways[1])]
        };
        let [[sine_p, cosine_p], [sine_d, cosine_d]] = [angle(at_p), angle(at_d)];
        // The sine of the sum of both angles, times lengths: below zero where the sum is above 180°.
        let sine = sine_p * cosine_d + cosine_p * sine_d;
        let sizes = (sine_p + cosine_p.abs()) * (sine_d + cosine_d.abs());
        if sine >= -TIE * sizes || p == far {
            return false;
        }
        let before = [[at_p, at_a, at_b], [at_d, at_b, at_a]].map(double_area);
        let after = [[at_p, at_a, at_d], [at_p, at_d, at_b]].map(double_area);
        let [Some(one), Some(other)] = before.map(unit) else { return false };
        let mean = plus(one, 1.0, other);
        let turns = after.into_iter().all(|normal| cosine(normal, mean) > TURN_COSINE);
        let least = dot(one, other).min(FOLD_COSINE);
        if !turns || cosine(after[0], after[1]) < least {
            return false;
        }
        let mut fan = std::mem::take(&mut self.fan);
        let is_joined = self.mesh.may_be_joined(p, far, &mut fan);
        self.fan = fan;
        let pair = [facet, across];
        let near = || self.mesh.around(&pair, &pair, RINGS);
        !is_joined
            && (self.is_calm(pair, [p, a, far, b], after)
                || !cross_any(self.points_mm, &[[p, a, far], [p, far, b]], &near()))
    }

    /// Whether facets bend little from those about them, away from borders. A pair becomes two with the corners p, a, d and p, d, b.
    fn is_calm(&self, pair: [u32; 2], [p, a, d, b]: [u32; 4], after: [PointMm; 2]) -> bool {
        let sides = [
            (pair[0], [p, a], after[0]),
            (pair[1], [a, d], after[0]),
            (pair[1], [d, b], after[1]),
            (pair[0], [b, p], after[1]),
        ];
        sides.into_iter().all(|(facet, [u, v], normal)| {
            let outer = self.mesh.over(facet, self.mesh.opposite(facet, [u, v]));
            outer.is_some_and(|outer| {
                let corners = [v, u, self.mesh.apex(outer, [u, v])];
                cosine(double_area(corners.map(|vertex| self.place(vertex))), normal) > TURN_COSINE
            })
        })
    }
}

/// Facets turn by less than 60° in a flip. Where they bend less from those about them they cross nothing near.
const TURN_COSINE: f64 = 0.5;
/// A flip may bend a flatter pair to this cosine, and no pair more than it is bent.
const FOLD_COSINE: f64 = 0.8;
/// Angles whose sum is so near to 180° count as a tie, and the edge stays.
const TIE: f64 = 1e-9;
