//! One cell of an octree: its points, their surroundings, and the facets whose dual edges meet their cocones.
//!
//! The surroundings are the points within a margin and a few of all others. With a *certificate* spheres of tetrahedra at the cell's
//! own points are searched for points that are missing, and these join until there are none. Then the Voronoi cells of its own
//! points are those of all points.

use std::cell::Cell as Best;
use std::collections::HashSet;

use asphera_geometry::predicates::{orientation_in_space, sphere_encloses};
use asphera_geometry::{BoxMm, PointMm, WeightedTree};

use super::candidates::{dual, reach};
use crate::centres;
use crate::delaunay::{Delaunay, INFINITE, NoDelaunay};
use crate::geometry::{cross, dot, minus};
use crate::poles::Poles;

/// All points, and what cells ask of them.
pub(super) struct Surroundings<'a> {
    /// In the order of coordinates.
    pub(super) places_mm: &'a [PointMm],
    pub(super) tree: &'a WeightedTree,
    /// A few of all points, by number.
    pub(super) sample: &'a [u32],
    /// How far each point sees, mm.
    pub(super) reach_mm: &'a [f64],
    pub(super) is_certified: bool,
}

/// A facet whose dual edge meets the cocone of a corner.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Meeting {
    /// Corners in ascending order.
    pub(super) facet: [u32; 3],
    /// Which of them.
    pub(super) corner: u8,
    /// How far the edge reaches in the cocone, mm.
    pub(super) reach_mm: f64,
}

/// Findings of a cell.
pub(super) struct CellFindings {
    pub(super) meetings: Vec<Meeting>,
    /// Its own points: number, normal, poles.
    pub(super) points: Vec<(u32, Option<PointMm>, [Option<PointMm>; 2])>,
    /// How often points were missing.
    pub(super) rounds: usize,
}

impl Surroundings<'_> {
    /// The findings of a cell with its own points.
    pub(super) fn examine(&self, own: &[u32]) -> Result<CellFindings, NoDelaunay> {
        let mut members = self.members(own);
        let mut rounds = 0;
        let mut empty = HashSet::new();
        loop {
            let places: Vec<PointMm> =
                members.iter().map(|&at| self.places_mm[at as usize]).collect();
            let delaunay = match Delaunay::new(&places) {
                Ok(delaunay) => delaunay,
                // All points span space.
                Err(_) if members.len() < self.places_mm.len() => {
                    members = (0..self.places_mm.len() as u32).collect();
                    continue;
                }
                Err(why) => return Err(why),
            };
            let local = Local::new(self, &delaunay, &members, own);
            let missing = if self.is_certified { local.missing(&mut empty) } else { Vec::new() };
            if missing.is_empty() {
                return Ok(local.findings(rounds));
            }
            rounds += 1;
            members.extend(missing);
            members.sort_unstable();
            members.dedup();
        }
    }

    /// Own points, those within a margin of their box, and the sample; in ascending order.
    fn members(&self, own: &[u32]) -> Vec<u32> {
        let about = BoxMm::about(own.iter().map(|&at| self.places_mm[at as usize]));
        let margin = own.iter().map(|&at| self.reach_mm[at as usize]).fold(0.0, f64::max);
        let mut members: Vec<u32> = own.to_vec();
        members.extend(self.sample);
        self.tree.visit(
            |other, _| {
                (0..3).all(|axis| {
                    other.low[axis] <= about.high[axis] + margin
                        && other.high[axis] >= about.low[axis] - margin
                })
            },
            |at| {
                if about.squared_distance_mm2(self.places_mm[at as usize]) <= margin * margin {
                    members.push(at);
                }
                false
            },
        );
        members.sort_unstable();
        members.dedup();
        members
    }
}

/// The triangulation of a cell and its surroundings.
struct Local<'a> {
    all: &'a Surroundings<'a>,
    delaunay: &'a Delaunay,
    centres: Vec<PointMm>,
    /// The number of each vertex among all points.
    numbers: Vec<u32>,
    /// Whether a vertex is the cell's own.
    is_own: Vec<bool>,
}

impl<'a> Local<'a> {
    fn new(
        all: &'a Surroundings<'a>,
        delaunay: &'a Delaunay,
        members: &[u32],
        own: &[u32],
    ) -> Local<'a> {
        let numbers: Vec<u32> = delaunay.ids.iter().map(|&id| members[id as usize]).collect();
        let own: HashSet<u32> = own.iter().copied().collect();
        let is_own = numbers.iter().map(|number| own.contains(number)).collect();
        Local { all, delaunay, centres: centres::of(delaunay), numbers, is_own }
    }

    fn touches_own(&self, corners: &[u32]) -> bool {
        corners.iter().any(|&corner| self.is_own.get(corner as usize) == Some(&true))
    }

    /// Points that lie in spheres of cells at own points, or beyond hull facets there: one for each such cell.
    ///
    /// Cells without one are noted in `empty`, by corners in ascending order.
    fn missing(&self, empty: &mut HashSet<[u32; 4]>) -> Vec<u32> {
        let delaunay = self.delaunay;
        let mut missing = Vec::new();
        for cell in 0..delaunay.corners.len() as u32 {
            let corners = delaunay.corners[cell as usize];
            if !self.touches_own(&corners) {
                continue;
            }
            let number = |at: u32| self.numbers.get(at as usize).copied().unwrap_or(INFINITE);
            let mut numbers = corners.map(number);
            numbers.sort_unstable();
            if empty.contains(&numbers) {
                continue;
            }
            let found =
                if delaunay.is_outside(cell) { self.beyond(cell) } else { self.enclosed(cell) };
            match found {
                Some(found) => missing.push(found),
                None => {
                    empty.insert(numbers);
                }
            }
        }
        missing
    }

    /// A point inside the sphere of a tetrahedron.
    fn enclosed(&self, cell: u32) -> Option<u32> {
        let centre = self.centres[cell as usize];
        let [a, b, c, d] = self.delaunay.places(cell);
        let corners = self.delaunay.corners[cell as usize].map(|at| self.numbers[at as usize]);
        let encloses = |at: u32| {
            !corners.contains(&at) && sphere_encloses(a, b, c, d, self.all.places_mm[at as usize])
        };
        let (nearest, distance) = self.all.tree.nearest(centre, |_| true)?;
        let way = minus(centre, d);
        let radius = dot(way, way).sqrt();
        if distance < radius * (1.0 - NEAR) && encloses(nearest) {
            return Some(nearest);
        }
        // Nearly on the sphere: the exact sign decides. Of wide spheres, as about the poles of a ball without noise, ties change the
        // triangulation about the centre and nothing at the surface.
        let sees = |&at: &u32| radius <= self.all.reach_mm[at as usize];
        if !corners.iter().any(sees) {
            return None;
        }
        let limit = radius * (1.0 + NEAR);
        let mut found = None;
        self.all.tree.visit(
            |about, _| about.squared_distance_mm2(centre) <= limit * limit,
            |at| {
                let way = minus(self.all.places_mm[at as usize], centre);
                if dot(way, way) > limit * limit {
                    return false;
                }
                if encloses(at) {
                    found = Some(at);
                }
                found.is_some()
            },
        );
        found
    }

    /// The farthest point beyond a hull facet.
    fn beyond(&self, cell: u32) -> Option<u32> {
        let [a, b, c, _] = self.delaunay.corners[cell as usize];
        let [a, b, c] = [a, b, c].map(|corner| self.delaunay.place(corner));
        // Seen from outside they turn clockwise.
        let normal = cross(minus(c, a), minus(b, a));
        let height = |place: PointMm| dot(minus(place, a), normal);
        let best = Best::new((0.0, None));
        self.all.tree.visit(
            |about, _| {
                let far = [0, 1, 2].map(|axis| {
                    if normal[axis] > 0.0 { about.high[axis] } else { about.low[axis] }
                });
                height(far) >= best.get().0
            },
            |at| {
                let place = self.all.places_mm[at as usize];
                let height = height(place);
                if height > best.get().0 && orientation_in_space(a, b, c, place).is_gt() {
                    best.set((height, Some(at)));
                }
                false
            },
        );
        best.get().1
    }

    fn findings(&self, rounds: usize) -> CellFindings {
        let delaunay = self.delaunay;
        let poles = Poles::of(delaunay, &self.centres);
        let mut meetings = Vec::new();
        for (cell, slot) in delaunay.facets() {
            let corners = delaunay.facet(cell, slot);
            if !self.touches_own(&corners) {
                continue;
            }
            let edge = dual(delaunay, &self.centres, cell, slot);
            let mut facet = corners.map(|corner| self.numbers[corner as usize]);
            facet.sort_unstable();
            for corner in corners.into_iter().filter(|&corner| self.is_own[corner as usize]) {
                let Some(normal) = poles.normals[corner as usize] else { continue };
                let reach_mm = reach(&edge, delaunay.place(corner), normal);
                let at = facet.iter().position(|&at| at == self.numbers[corner as usize]);
                if let Some(at) = at.filter(|_| reach_mm >= 0.0) {
                    meetings.push(Meeting { facet, corner: at as u8, reach_mm });
                }
            }
        }
        let points = (0..self.numbers.len()).filter(|&vertex| self.is_own[vertex]);
        let of = |vertex: usize| {
            let poles_mm = [poles.first[vertex], poles.second[vertex]];
            (self.numbers[vertex], poles.normals[vertex], poles_mm)
        };
        CellFindings { meetings, points: points.map(of).collect(), rounds }
    }
}

/// So near to a sphere, as a share of its radius, exact signs decide.
const NEAR: f64 = 1e-9;
