//! The signed distance that natural neighbours of a place interpolate from the tangent planes of points.
//!
//! Natural neighbours of a place are the points whose Voronoi cells would lose to its own. Weights are those of V. Belikov and others (1997,
//! "The non-Sibsonian interpolation"): the area of the facet of the new cell between both, over their distance. They are positive.
//! So where all tangent planes of the neighbours agree, the sign is known without weights.

use std::collections::HashMap;

use asphera_geometry::PointMm;

use crate::centres::centre;
use crate::delaunay::Delaunay;
use crate::geometry::{cross, dot, minus};

/// The distance function of points with outward normals.
pub(super) struct Function<'a> {
    pub(super) delaunay: &'a Delaunay,
    /// Centres of the spheres of tetrahedra, and squares of their radii in mm².
    pub(super) spheres: &'a [(PointMm, f64)],
    pub(super) outward: &'a [Option<PointMm>],
}

/// The sign of the function at a place.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Sign {
    /// Outside, and whether tangent planes disagreed.
    Outside(bool),
    /// Inside, and whether tangent planes disagreed.
    Inside(bool),
    /// Too many neighbours that disagree.
    Open,
}

/// Memory of a thread between places.
#[derive(Default)]
pub(super) struct Room {
    cavity: Vec<u32>,
    border: Vec<(u32, usize)>,
}

impl Function<'_> {
    /// The sign at the centre of a tetrahedron.
    pub(super) fn sign(&self, cell: u32, room: &mut Room) -> Sign {
        let (place, _) = self.spheres[cell as usize];
        let is_whole = match self.dig(cell, place, room) {
            Dug::BeyondHull => return Sign::Outside(false),
            Dug::Whole => true,
            Dug::Part => false,
        };
        let (mut is_above, mut is_below) = (false, false);
        for &cell in &room.cavity {
            for corner in self.delaunay.corners[cell as usize] {
                let height = self.height(corner, place);
                is_above |= height > 0.0;
                is_below |= height < 0.0;
            }
        }
        match (is_above, is_below) {
            (true, false) => Sign::Outside(false),
            (false, true) => Sign::Inside(false),
            _ if is_whole => {
                let value = self.value(place, &room.border);
                if value > 0.0 {
                    Sign::Outside(true)
                } else if value < 0.0 {
                    Sign::Inside(true)
                } else {
                    Sign::Open
                }
            }
            _ => Sign::Open,
        }
    }

    /// How high a place lies over the tangent plane of a point; 0 where it has none.
    fn height(&self, corner: u32, place: PointMm) -> f64 {
        self.outward[corner as usize]
            .map_or(0.0, |normal| dot(minus(place, self.delaunay.place(corner)), normal))
    }

    /// Gathers the cells whose spheres hold a place, from one of them on.
    fn dig(&self, cell: u32, place: PointMm, room: &mut Room) -> Dug {
        let delaunay = self.delaunay;
        room.cavity.clear();
        room.border.clear();
        room.cavity.push(cell);
        let mut at = 0;
        while let Some(&cell) = room.cavity.get(at) {
            at += 1;
            for slot in 0..4 {
                let next = delaunay.neighbours[cell as usize][slot];
                if room.cavity.contains(&next) {
                    continue;
                }
                if delaunay.is_outside(next) {
                    let facet = delaunay.facet(cell, slot).map(|corner| delaunay.place(corner));
                    let [a, b, c] = facet;
                    // Counter-clockwise seen from inside: a place beyond lies on the other side.
                    let is_beyond = dot(minus(place, a), cross(minus(b, a), minus(c, a))) < 0.0;
                    if is_beyond {
                        return Dug::BeyondHull;
                    }
                    room.border.push((cell, slot));
                    continue;
                }
                let (centre, square) = self.spheres[next as usize];
                let way = minus(place, centre);
                if dot(way, way) >= square * (1.0 - ROUNDING) {
                    room.border.push((cell, slot));
                } else if room.cavity.len() < MOST_CELLS {
                    room.cavity.push(next);
                } else {
                    return Dug::Part;
                }
            }
        }
        Dug::Whole
    }

    /// The weighted mean of the heights over tangent planes, but for a positive factor.
    fn value(&self, place: PointMm, border: &[(u32, usize)]) -> f64 {
        let weights = self.weights(place, border);
        let sum: f64 = weights.iter().map(|&(of, weight)| weight * self.height(of, place)).sum();
        let whole: f64 = weights.iter().map(|(_, weight)| weight).sum();
        sum * whole.signum()
    }

    /// Parts of the weights of the corners of a cavity, but for a common factor: the weight of a corner is the sum of its parts.
    fn weights(&self, place: PointMm, border: &[(u32, usize)]) -> Vec<(u32, f64)> {
        let delaunay = self.delaunay;
        let centres: Vec<PointMm> = border
            .iter()
            .map(|&(cell, slot)| {
                let [a, b, c] = delaunay.facet(cell, slot).map(|corner| delaunay.place(corner));
                minus(centre([a, b, c, place]), place)
            })
            .collect();
        let sides = |&(cell, slot): &(u32, usize)| {
            let [a, b, c] = delaunay.facet(cell, slot);
            [(a, b), (b, c), (c, a)]
        };
        let mut across = HashMap::new();
        for (facet, at) in border.iter().zip(0_usize..) {
            across.extend(sides(facet).map(|side| (side, at)));
        }
        // The corners of the facet toward a neighbour are the centres about it, one step across an edge from each to the next.
        let mut weights = Vec::with_capacity(3 * border.len());
        for (facet, at) in border.iter().zip(0_usize..) {
            for (from, to) in sides(facet) {
                if let Some(&next) = across.get(&(to, from)) {
                    let way = minus(delaunay.place(from), place);
                    let area = dot(cross(centres[at], centres[next]), way);
                    weights.push((from, area / dot(way, way)));
                }
            }
        }
        weights
    }
}

/// The outcome of gathering cells.
enum Dug {
    Whole,
    Part,
    BeyondHull,
}

/// Cells whose spheres hold a place, at most.
const MOST_CELLS: usize = 64;
/// A place so near to a sphere counts as outside it.
const ROUNDING: f64 = 1e-9;

#[cfg(test)]
mod tests {
    use super::*;
    use crate::centres;

    /// Weights of this kind reproduce places: the mean of the neighbours by weight is the place itself (K. Sugihara 1999).
    #[test]
    fn weights_are_positive_and_reproduce_the_place() {
        let mut state = 7_u64;
        let mut random = || {
            state = state
                .wrapping_mul(6_364_136_223_846_793_005)
                .wrapping_add(1_442_695_040_888_963_407);
            (state >> 11) as f64 * 2_f64.powi(-53)
        };
        let points: Vec<PointMm> = (0..400).map(|_| [random(), random(), random()]).collect();
        let delaunay = Delaunay::new(&points).unwrap();
        let spheres: Vec<(PointMm, f64)> = (centres::of(&delaunay).iter().zip(&delaunay.corners))
            .map(|(&centre, corners)| {
                let way = minus(centre, delaunay.place(corners[0]));
                (centre, dot(way, way))
            })
            .collect();
        let function = Function { delaunay: &delaunay, spheres: &spheres, outward: &[] };
        let mut room = Room::default();
        let mut tried = 0;
        for cell in 0..delaunay.tetrahedra as u32 {
            let (place, _) = spheres[cell as usize];
            let is_inner = place.iter().all(|value| (0.25..0.75).contains(value));
            if !is_inner || !matches!(function.dig(cell, place, &mut room), Dug::Whole) {
                continue;
            }
            let mut weights: HashMap<u32, f64> = HashMap::new();
            for (corner, part) in function.weights(place, &room.border) {
                *weights.entry(corner).or_default() += part;
            }
            let whole: f64 = weights.values().sum();
            let mut off = [0.0; 3];
            for (&corner, weight) in &weights {
                assert!(weight / whole > -1e-9, "{weight} of {whole}");
                let way = minus(delaunay.place(corner), place);
                off = [0, 1, 2].map(|axis| off[axis] + weight / whole * way[axis]);
            }
            assert!(dot(off, off).sqrt() < 1e-9, "{off:?}");
            tried += 1;
        }
        assert!(tried > 100, "{tried}");
    }
}
