//! Small holes that are left where corners do not agree, as loops of border edges.
//!
//! A border edge walked with the hole on its left leads to one edge that follows: the first one clockwise from the way back. So
//! the edges are a map onto edges, and holes are its short cycles: each is the same wherever a walk begins.

use std::collections::{BTreeMap, HashMap};

use asphera_geometry::PointMm;
use rayon::prelude::*;

use super::normals::TangentPlane;
use super::stars::{Border, Stars};
use super::vote::basis;
use crate::geometry::{cross, dot, minus};
use crate::neighbours::by_coordinates;

/// Points that a thread takes in turn.
const POINTS_AT_ONCE: usize = 1 << 12;
/// A hole of more sides is left open.
pub(super) const MOST_SIDES: usize = 32;

/// A loop: its corners counter-clockwise about their normals, the first by coordinates first.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Loop {
    pub(super) corners: Vec<u32>,
    /// The normals of the corners, all to the side from which the hole lies on the left.
    pub(super) normals: Vec<PointMm>,
}

/// The first two corners of a loop. No other loop has them.
pub(super) type Door = [u32; 2];

/// Facets with marks, and the places and planes of their corners.
#[derive(Clone, Copy)]
pub(super) struct Borders<'a> {
    pub(super) points_mm: &'a [PointMm],
    pub(super) planes: &'a [Option<TangentPlane>],
    pub(super) stars: &'a Stars,
}

/// A border edge walked with the hole on its left.
#[derive(Clone, Copy)]
struct Step {
    from: u32,
    to: u32,
    third: u32,
}

impl Borders<'_> {
    /// The loops of at most [`MOST_SIDES`] sides through any of some points, in ascending order. Linear time.
    ///
    /// A loop and the way back along it count once: the one whose second corner is before its last.
    pub(super) fn loops_through(&self, points: &[u32]) -> BTreeMap<Door, Loop> {
        let mut loops = BTreeMap::new();
        // In which walk an edge was passed, and where in it.
        let mut passed: HashMap<Door, (usize, usize)> = HashMap::new();
        let mut walks = 0;
        let has_border = |&at: &u32| self.stars.borders_at(at).next().is_some();
        let at_borders = points.par_iter().copied().with_min_len(POINTS_AT_ONCE).filter(has_border);
        for from in at_borders.collect::<Vec<u32>>() {
            for Border { end, third } in self.stars.borders_at(from) {
                walks += 1;
                let step = Step { from, to: end, third };
                let Some(cycle) = self.cycle(step, walks, points, &mut passed) else { continue };
                if let Some((door, found)) = self.found(&cycle) {
                    loops.insert(door, found);
                }
            }
        }
        loops
    }

    /// The cycle that a walk ends in; `None` where it leaves the points for longer than a small loop does.
    fn cycle(
        &self,
        mut step: Step,
        walk: usize,
        points: &[u32],
        passed: &mut HashMap<Door, (usize, usize)>,
    ) -> Option<Vec<Step>> {
        let mut steps: Vec<Step> = Vec::new();
        let mut strange = 0;
        loop {
            match passed.get(&[step.from, step.to]) {
                Some(&(found, at)) if found == walk => return Some(steps.split_off(at)),
                Some(_) => return None,
                None => {}
            }
            passed.insert([step.from, step.to], (walk, steps.len()));
            steps.push(step);
            strange = if points.binary_search(&step.from).is_ok() { 0 } else { strange + 1 };
            if strange > MOST_SIDES {
                // A later walk may come back to a point from here.
                for step in &steps[steps.len() - strange..] {
                    passed.remove(&[step.from, step.to]);
                }
                return None;
            }
            step = self.next(step)?;
        }
    }

    /// A cycle as a loop, where it is a small one that passes no corner twice.
    fn found(&self, cycle: &[Step]) -> Option<(Door, Loop)> {
        if !(3..=MOST_SIDES).contains(&cycle.len()) {
            return None;
        }
        let mut numbers: Vec<u32> = cycle.iter().map(|step| step.to).collect();
        numbers.sort_unstable();
        numbers.dedup();
        if numbers.len() < cycle.len() {
            return None;
        }
        let order = |one: u32, other: u32| {
            by_coordinates(self.points_mm[one as usize], self.points_mm[other as usize])
        };
        let first = (0..cycle.len()).min_by(|&a, &b| order(cycle[a].to, cycle[b].to))?;
        let steps = || cycle[first..].iter().chain(&cycle[..first]);
        let corners: Vec<u32> = steps().map(|step| step.to).collect();
        if order(corners[1], corners[corners.len() - 1]).is_gt() {
            return None;
        }
        let normals = steps().map(|&step| self.normal(step)).collect::<Option<_>>()?;
        Some(([corners[0], corners[1]], Loop { corners, normals }))
    }

    /// The normal at the end of an edge, to the side from which the facet lies on the right.
    fn normal(&self, step: Step) -> Option<PointMm> {
        let normal = self.planes[step.to as usize]?.normal;
        let [a, b, c] = [step.from, step.to, step.third].map(|at| self.points_mm[at as usize]);
        let is_left = dot(cross(minus(b, a), minus(c, a)), normal) > 0.0;
        Some(if is_left { normal.map(|side| -side) } else { normal })
    }

    /// The border edge that follows: the first one clockwise from the way back.
    fn next(&self, step: Step) -> Option<Step> {
        let at = step.to;
        let others = || self.stars.borders_at(at).filter(|border| border.end != step.from);
        let first = others().next()?;
        let mut best = first;
        if others().nth(1).is_some() {
            let normal = self.normal(step)?;
            let along = basis(normal);
            let across = cross(normal, along);
            let angle = |end: u32| {
                let way = minus(self.points_mm[end as usize], self.points_mm[at as usize]);
                dot(way, across).atan2(dot(way, along))
            };
            let back = angle(step.from);
            let turn = |end: u32| (back - angle(end)).rem_euclid(std::f64::consts::TAU);
            let place = |end: u32| self.points_mm[end as usize];
            best = others().min_by(|one, other| {
                let by_turn = turn(one.end).total_cmp(&turn(other.end));
                by_turn.then_with(|| by_coordinates(place(one.end), place(other.end)))
            })?;
        }
        Some(Step { from: at, to: best.end, third: best.third })
    }
}
