//! Stars of many triangles that were made lately, to start long walks from.
//!
//! Along a curve a vertex may have a hundred thousand neighbours. A walk that turns about it would meet half of its
//! triangles. Those that an insertion makes are in order around their point. So the one that faces a place is found by
//! bisection.
//!
//! From the nearest vertex the walk then meets hardly any triangles but those that make way for the place: the edge
//! between the two is Delaunay once the place is a vertex.
//!
//! Later insertions make other triangles of some. Those do not begin at the star's place any more, and are passed over.
//! What is found is a hint.

use std::collections::VecDeque;

use asphera_geometry::VertexId;
use asphera_geometry::predicates::{Place, estimated_orientation};

use super::cells::{Cells, GHOST, Slot};
use super::editor::Editor;
use super::places::Places;

/// The wide stars made last, the latest at the end.
#[derive(Default)]
pub(super) struct WideStars {
    stars: VecDeque<WideStar>,
    /// How many slots they have in all.
    slots: usize,
}

/// Triangles that were made about one vertex, counter-clockwise.
struct WideStar {
    apex: Place,
    slots: Vec<Slot>,
}

impl WideStars {
    /// Takes note of a star that has just been made, if it is wide. The oldest ones go as long as all have more than
    /// `most_slots`.
    #[inline(always)]
    pub(super) fn note(&mut self, apex: Place, slots: &[Slot], most_slots: usize) {
        if slots.len() >= WIDE {
            self.add(WideStar { apex, slots: slots.to_vec() }, most_slots);
        }
    }

    #[cold]
    fn add(&mut self, star: WideStar, most_slots: usize) {
        self.slots += star.slots.len();
        while !self.stars.is_empty() && (self.stars.len() >= MOST_STARS || self.slots > most_slots)
        {
            self.remove(0);
        }
        self.stars.push_back(star);
    }

    fn remove(&mut self, index: usize) {
        let removed = self.stars.remove(index);
        self.slots -= removed.map_or(0, |star| star.slots.len());
    }

    /// The nearest star to a place of those whose squared distance is at most so much.
    fn nearest(&self, place: Place, most: f64) -> Option<usize> {
        let stars = self.stars.iter().enumerate();
        let distances = stars.map(|(index, star)| (squared_distance(star.apex, place), index));
        let nearest = distances.min_by(|(one, _), (other, _)| one.total_cmp(other));
        nearest.filter(|&(distance, _)| distance <= most).map(|(_, index)| index)
    }

    /// Bytes of memory, but for a few a star.
    pub(super) fn bytes(&self) -> usize {
        self.slots * size_of::<Slot>()
    }
}

impl<P: Places + ?Sized, C: Cells> Editor<'_, P, C> {
    /// A triangle that faces a place from the nearest of the wide stars or from the point inserted last, in all likelihood.
    /// None if both are farther than the corners of the triangle `from`. Stars of which nothing is left go.
    pub(super) fn facing(&mut self, place: Place, from: Slot) -> Option<Slot> {
        let squared = |corner: VertexId| squared_distance(self.at(corner), place);
        let corners = self.cells.corners(from).into_iter().filter(|&corner| corner != GHOST);
        let there = corners.map(squared).fold(f64::INFINITY, f64::min);
        let last = self.last_apex().filter(|&apex| squared_distance(apex, place) <= there);
        let most = last.map_or(there, |apex| squared_distance(apex, place));
        while let Some(index) = self.work.wide.nearest(place, most) {
            let WideStar { apex, slots } = &self.work.wide.stars[index];
            let facing = self.facing_from(*apex, slots, place);
            if facing.is_some() {
                return facing;
            }
            self.work.wide.remove(index);
        }
        self.facing_from(last?, &self.work.doomed, place)
    }

    /// Where the point inserted last lies.
    fn last_apex(&self) -> Option<Place> {
        // A ghost has its apex elsewhere, and there are two next to one another.
        let mut star = self.work.doomed.iter().take(3).map(|&slot| self.cells.corners(slot));
        star.find(|corners| !corners.contains(&GHOST)).map(|[apex, ..]| self.at(apex))
    }

    /// The triangle of a star that faces a place, or the next one where others took the place of some.
    fn facing_from(&self, apex: Place, star: &[Slot], place: Place) -> Option<Slot> {
        let is_left = |of: Place, place: Place| estimated_orientation(apex, of, place).0 > 0.0;
        let (first, start) = self.spoke_from(apex, star, 0)?;
        let is_near_half = is_left(start, place);
        // Spokes up to `low` are passed on the way around to the place. After the last one comes the first.
        let (mut low, mut is_beyond_low) = (first, is_near_half);
        let (mut high, mut end) = (first, star.len());
        while end - low > 1 {
            let middle = low + (end - low) / 2;
            let Some((index, spoke)) = self.spoke_from(apex, &star[..end], middle) else {
                end = middle;
                continue;
            };
            let is_beyond = is_left(spoke, place);
            let is_passed = match (is_left(start, spoke), is_near_half) {
                (true, false) => true,
                (false, true) => false,
                _ => is_beyond,
            };
            if is_passed {
                (low, is_beyond_low) = (index, is_beyond);
            } else {
                (high, end) = (index, index);
            }
        }
        Some(star[if is_beyond_low { low } else { high }])
    }

    /// A triangle that is still the star's, and where its spoke ends: that of an index, or one not far behind.
    fn spoke_from(&self, apex: Place, star: &[Slot], index: usize) -> Option<(usize, Place)> {
        let steps = std::iter::successors(Some(1), |step| Some(2 * step));
        let tried = std::iter::once(0).chain(steps).map(|step| index + step);
        tried.take_while(|&index| index < star.len()).find_map(|index| {
            let corners = self.cells.corners(star[index]);
            // Where another thread writes, any corner may be the one at infinity.
            let is_of_star = !corners.contains(&GHOST) && self.at(corners[0]) == apex;
            is_of_star.then(|| (index, self.at(corners[1])))
        })
    }
}

fn squared_distance(p: Place, q: Place) -> f64 {
    (p[0] - q[0]).powi(2) + (p[1] - q[1]).powi(2)
}

/// Stars of fewer triangles are as well walked about.
const WIDE: usize = 64;

/// How many stars there are at most.
const MOST_STARS: usize = 64;

#[cfg(test)]
mod tests {
    use asphera_geometry::PointMm;

    use super::super::Delaunay;
    use super::super::cells::FlatCells;
    use super::*;

    /// Points of a circle about one in its middle, which comes last and has a spoke to each.
    fn wheel(spokes: u32) -> (Vec<PointMm>, Delaunay) {
        let on_rim = |i: u32| std::f64::consts::TAU * f64::from(i) / f64::from(spokes);
        let rim = (0..spokes).map(on_rim).map(|angle| [angle.cos(), angle.sin(), 0.0]);
        let mut points: Vec<PointMm> = rim.collect();
        let mut mesh = Delaunay::default();
        add(&mut mesh, &mut points, [0.001, 0.002]);
        (points, mesh)
    }

    /// Adds a place and all points that are not in yet.
    fn add(mesh: &mut Delaunay, points: &mut Vec<PointMm>, [x, y]: Place) {
        let first = mesh.sheet.vertices as VertexId;
        if first == 0 {
            let rim = points.len() as VertexId;
            assert!(!mesh.insert(&points[..], 0..rim));
        }
        points.push([x, y, 0.0]);
        let last = points.len() as VertexId;
        assert!(!mesh.insert(&points[..], last - 1..last));
    }

    /// Steps from what faces each place to where it lies, at most.
    fn most_steps(points: &[PointMm], mesh: &mut Delaunay, radius: f64) -> usize {
        let recent = mesh.sheet.plane.as_ref().expect("there are triangles").recent;
        let mut editor: Editor<'_, _, FlatCells> =
            Editor { points, cells: &mesh.cells, work: &mut mesh.sheet.work };
        let steps = (0..500).map(|i| {
            let angle = 0.0123 * f64::from(i);
            let place = [radius * angle.cos(), radius * angle.sin()];
            // All places lie nearer to the middle than any rim does.
            let far = editor.locate([3.0, 0.0], recent);
            let start = editor.facing(place, far).expect("the middle is nearer");
            let met = std::cell::Cell::new(0);
            let start = editor.inside(start);
            editor.locate_among(place, start, |_, _| {
                met.set(met.get() + 1);
                true
            });
            met.get()
        });
        steps.max().unwrap_or(0)
    }

    #[test]
    fn the_triangle_that_faces_a_place_is_found_in_any_sense() {
        let (points, mut mesh) = wheel(1000);
        assert_eq!(mesh.sheet.work.wide.stars.back().map(|star| star.slots.len()), Some(1000));
        assert!(most_steps(&points, &mut mesh, 0.3) <= 2);
    }

    #[test]
    fn triangles_that_are_others_by_now_are_passed_over() {
        let (mut points, mut mesh) = wheel(1000);
        // Each takes a part of the wheel's triangles.
        for place in [[0.8, 0.0], [-0.1, 0.8], [-0.6, -0.5], [0.5, -0.6]] {
            add(&mut mesh, &mut points, place);
        }
        assert_eq!(mesh.sheet.work.wide.stars.len(), 5);
        // Behind those a walk may meet about as many that were not tried.
        assert!(most_steps(&points, &mut mesh, 0.05) <= 100);
    }

    #[test]
    fn the_oldest_stars_go_where_there_are_too_many() {
        let mut wide = WideStars::default();
        let slots: Vec<Slot> = (0..100).collect();
        for index in 0..100 {
            wide.note([f64::from(index), 0.0], &slots, 100_000);
        }
        assert_eq!((wide.stars.len(), wide.bytes()), (MOST_STARS, 400 * MOST_STARS));
        assert_eq!(wide.nearest([0.0; 2], 1e9), Some(0));
        assert_eq!(wide.stars[0].apex, [36.0, 0.0]);
        wide.note([0.0; 2], &slots, 250);
        assert_eq!((wide.stars.len(), wide.bytes()), (2, 800));
        // One that is too large on its own stays alone, and narrow ones are not noted.
        wide.note([1.0, 0.0], &slots, 50);
        wide.note([2.0, 0.0], &slots[..WIDE - 1], 50);
        assert_eq!((wide.stars.len(), wide.bytes()), (1, 400));
        assert_eq!(wide.nearest([0.0; 2], 0.5), None);
    }
}
