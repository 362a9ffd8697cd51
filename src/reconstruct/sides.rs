//! Sides of tetrahedra: inside or outside of a body.
//!
//! Balls on one side of a surface meet deeply, balls on different sides hardly, and the two poles of a point lie on different sides.
//! So sides spread from infinity, the most certain first (N. Amenta, S. Choi, R. K. Kolluri 2001, "The power crust",
//! doi:10.1145/376957.376986). Against noise only *big* balls take part at first (T. K. Dey, S. Goswami 2006, "Provable surface
//! reconstruction from noisy samples", doi:10.1016/j.comgeo.2005.10.006): those that are wide beside the spacing of the points on
//! them. Big balls that nothing reaches are inside. Small balls then join a neighbour, the deepest meeting first.

use std::cmp::Ordering;
use std::collections::BinaryHeap;

use asphera_geometry::PointMm;
use rayon::prelude::*;

use crate::delaunay::{Delaunay, INFINITE};
use crate::geometry::{dot, minus};
use crate::neighbours::{Neighbours, by_coordinates};
use crate::poles::{Poles, outward_normal};

/// The sides of cells.
pub(crate) struct Sides {
    /// Whether a cell lies outside.
    pub(crate) is_outside: Vec<bool>,
    /// Whether its ball is big; cells beyond the hull have the largest.
    pub(crate) is_big: Vec<bool>,
}

impl Sides {
    /// The sides, where balls are big whose radius is at least `least` times the distance of the 8th neighbour of each corner.
    pub(crate) fn of(delaunay: &Delaunay, centres: &[PointMm], poles: &Poles, least: f64) -> Sides {
        let is_big = big(delaunay, centres, least);
        let pairs = pairs(delaunay, poles, &is_big);
        let mut spread = Spread {
            delaunay,
            centres,
            sides: vec![None; delaunay.corners.len()],
            certainty: vec![[0.0; 2]; delaunay.corners.len()],
            steps: BinaryHeap::new(),
        };
        spread.spread_from_outside(&pairs, &is_big);
        for (side, _) in spread.sides.iter_mut().zip(&is_big).filter(|(_, is_big)| **is_big) {
            side.get_or_insert(false);
        }
        spread.join_small();
        // Every cell hangs together with those beyond the hull.
        let is_outside = spread.sides.into_iter().map(|side| side.unwrap_or(true)).collect();
        Sides { is_outside, is_big }
    }

    /// How many big balls lie inside.
    pub(crate) fn inner(&self) -> usize {
        let inner = self.is_big.iter().zip(&self.is_outside);
        inner.filter(|&(is_big, is_outside)| *is_big && !is_outside).count()
    }

    /// Facets between inside and outside.
    pub(crate) fn border<'a>(
        &'a self,
        delaunay: &'a Delaunay,
    ) -> impl Iterator<Item = (u32, usize)> + 'a {
        delaunay.facets().filter(|&(cell, slot)| {
            let other = delaunay.neighbours[cell as usize][slot];
            self.is_outside[cell as usize] != self.is_outside[other as usize]
        })
    }
}

/// Cells whose balls are wide beside the distance of the neighbours of their corners.
fn big(delaunay: &Delaunay, centres: &[PointMm], least: f64) -> Vec<bool> {
    let tree = Neighbours::of(delaunay.points_mm.iter().copied().zip(0..).collect());
    let far = tree
        .map_nearest(NEAREST, |_, near, _: &mut ()| near.last().map_or(0.0, |&(square, _)| square));
    let mut squares = vec![0.0; far.len()];
    for (&vertex, far) in tree.ids.iter().zip(far) {
        squares[vertex as usize] = far;
    }
    (0..delaunay.corners.len())
        .into_par_iter()
        .map(|cell| {
            let Some(&centre) = centres.get(cell) else { return true };
            let corners = &delaunay.corners[cell];
            let way = minus(centre, delaunay.place(corners[0]));
            let widest = corners.iter().map(|&corner| squares[corner as usize]).fold(0.0, f64::max);
            dot(way, way) >= least * least * widest
        })
        .collect()
}

/// Two cells on different sides of a point, and how certain that is.
type Pair = (u32, u32, f64);

/// Big cells that are the poles of one point, in the order of the first, each pair both ways. Of a point of the hull the first is
/// [`INFINITE`].
fn pairs(delaunay: &Delaunay, poles: &Poles, is_big: &[bool]) -> Vec<Pair> {
    let mut pairs = Vec::new();
    for (vertex, &[one, other]) in poles.cells.iter().enumerate() {
        let (Some(normal), Some(second)) = (poles.normals[vertex], poles.second[vertex]) else {
            continue;
        };
        let are_big = [one, other].iter().all(|&cell| cell == INFINITE || is_big[cell as usize]);
        if !are_big {
            continue;
        }
        let way = minus(second, delaunay.points_mm[vertex]);
        let certainty = -dot(way, normal) / dot(way, way).sqrt();
        pairs.extend([(one, other, certainty), (other, one, certainty)]);
    }
    pairs.sort_unstable_by_key(|&(cell, ..)| cell);
    pairs
}

struct Spread<'a> {
    delaunay: &'a Delaunay,
    centres: &'a [PointMm],
    /// Whether a cell lies outside; `None` where that is not known yet.
    sides: Vec<Option<bool>>,
    /// How certainly a cell lies inside and outside, from what its neighbours are.
    certainty: Vec<[f64; 2]>,
    steps: BinaryHeap<Step>,
}

/// A cell whose side may be told.
struct Step {
    certainty: f64,
    cell: u32,
    centre: PointMm,
    is_outside: bool,
}

impl Ord for Step {
    fn cmp(&self, other: &Step) -> Ordering {
        (self.certainty.total_cmp(&other.certainty))
            .then_with(|| by_coordinates(self.centre, other.centre))
            .then(self.is_outside.cmp(&other.is_outside))
    }
}

impl PartialOrd for Step {
    fn partial_cmp(&self, other: &Step) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl PartialEq for Step {
    fn eq(&self, other: &Step) -> bool {
        self.cmp(other).is_eq()
    }
}

impl Eq for Step {}

impl Spread<'_> {
    /// Tells the sides of big cells, the most certain first.
    fn spread_from_outside(&mut self, pairs: &[Pair], is_big: &[bool]) {
        let outside = self.delaunay.tetrahedra as u32..self.delaunay.corners.len() as u32;
        for cell in outside {
            self.settle(cell, true, is_big);
        }
        self.oppose(INFINITE, true, pairs);
        while let Some(Step { certainty, cell, is_outside, .. }) = self.steps.pop() {
            if self.sides[cell as usize].is_none() && self.best(cell) == (certainty, is_outside) {
                self.settle(cell, is_outside, is_big);
                self.oppose(cell, is_outside, pairs);
            }
        }
    }

    /// The side of a cell by what is known, and how certain that is: less where both sides claim it.
    fn best(&self, cell: u32) -> (f64, bool) {
        let [inside, outside] = self.certainty[cell as usize];
        let is_outside = outside > inside;
        let certainty = if inside > 0.0 && outside > 0.0 {
            (inside - outside).abs() - 1.0
        } else {
            inside.max(outside)
        };
        (certainty, is_outside)
    }

    /// Tells the side of a cell, and its big neighbours that they are on it too.
    fn settle(&mut self, cell: u32, is_outside: bool, is_big: &[bool]) {
        self.sides[cell as usize] = Some(is_outside);
        for slot in 0..4 {
            let next = self.delaunay.neighbours[cell as usize][slot];
            if is_big[next as usize] && !self.delaunay.is_outside(next) {
                self.claim(next, is_outside, self.depth(cell, slot));
            }
        }
    }

    /// Tells the other poles of the points of a cell that they are on the other side.
    fn oppose(&mut self, cell: u32, is_outside: bool, pairs: &[Pair]) {
        let first = pairs.partition_point(|pair| pair.0 < cell);
        for &(_, other, certainty) in pairs[first..].iter().take_while(|pair| pair.0 == cell) {
            if other != INFINITE {
                self.claim(other, !is_outside, certainty);
            }
        }
    }

    fn claim(&mut self, cell: u32, is_outside: bool, certainty: f64) {
        let known = &mut self.certainty[cell as usize][usize::from(is_outside)];
        if self.sides[cell as usize].is_none() && certainty > *known {
            *known = certainty;
            let (certainty, is_outside) = self.best(cell);
            let centre = self.centres[cell as usize];
            self.steps.push(Step { certainty, cell, centre, is_outside });
        }
    }

    fn join_small(&mut self) {
        self.steps.clear();
        for cell in 0..self.delaunay.corners.len() as u32 {
            if let Some(is_outside) = self.sides[cell as usize] {
                self.offer(cell, is_outside);
            }
        }
        while let Some(Step { cell, is_outside, .. }) = self.steps.pop() {
            if self.sides[cell as usize].is_none() {
                self.sides[cell as usize] = Some(is_outside);
                self.offer(cell, is_outside);
            }
        }
    }

    fn offer(&mut self, cell: u32, is_outside: bool) {
        for slot in 0..4 {
            let next = self.delaunay.neighbours[cell as usize][slot];
            if self.sides[next as usize].is_none() {
                let (certainty, centre) = (self.depth(cell, slot), self.centres[next as usize]);
                self.steps.push(Step { certainty, cell: next, centre, is_outside });
            }
        }
    }

    /// The cosine of the angle at which the balls on both sides of a facet meet: 1 of equal balls, -1 of balls that touch from
    /// outside. Balls beyond the hull are half-spaces.
    fn depth(&self, cell: u32, slot: usize) -> f64 {
        let delaunay = self.delaunay;
        let other = delaunay.neighbours[cell as usize][slot];
        let corners = &delaunay.corners[cell as usize];
        // The first of the common corners by coordinates.
        let common = (0..4)
            .filter(|&at| at != slot)
            .filter_map(|at| delaunay.points_mm.get(corners[at] as usize).copied());
        let Some(place) = common.min_by(|p, q| by_coordinates(*p, *q)) else { return 1.0 };
        let [one, two] = [cell, other].map(|cell| match self.centres.get(cell as usize) {
            Some(&centre) => minus(centre, place),
            None => outward_normal(delaunay, cell),
        });
        let size = (dot(one, one) * dot(two, two)).sqrt();
        if size > 0.0 { dot(one, two) / size } else { -1.0 }
    }
}

/// Which neighbour tells the spacing.
const NEAREST: usize = 8;
