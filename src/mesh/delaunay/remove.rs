//! Removal of one vertex: its star goes, and the hole is triangulated anew.
//!
//! O. Devillers, On deletion in Delaunay triangulations, Proc. 15th Symp. on Computational Geometry
//! (1999) 181-188, doi:10.1145/304893.304969. The rim of the hole is seen whole from the vertex.
//! Three corners a, b, c that follow one another are an ear if they turn left and the vertex is not
//! right of the line from a to c: then their triangle lies inside the rim, and what is left of
//! the hole is still seen whole. Of all ears that one belongs to the Delaunay triangulation in
//! whose circumcircle the vertex lies least deep (it has the greatest power):
//!
//! ```text
//!       c ◀── b          depth = r² - d², of the circle through a, b, c
//!       │   ↗            r its radius, d the distance of the vertex from its centre
//!        \ a
//!     vertex
//! ```
//!
//! **Where we deviate.** The depths are compared in doubles, ties by the rule of
//! [`encloses`](asphera_geometry::predicates::encloses): of corners on one circle the last by x, then y, is cut off
//! first. Rounding may cut a wrong ear, though never one that is none, since turns are told
//! exactly. So flips follow; they start from a triangulation of the hole and end with that of
//! Delaunay, and as a rule there is nothing to flip.
//!
//! Of a vertex on the hull the rim passes infinity. Ears are cut as long as corners turn left; what
//! is left of the rim is the new hull.

use std::cmp::Ordering;
use std::collections::BinaryHeap;

use asphera_geometry::VertexId;
use asphera_geometry::predicates::{Place, by_x_then_y, left_of, orientation};

use super::Delaunay;
use super::cells::{Cells, GHOST, Side, Slot};
use super::editor::Editor;
use super::line::Line;
use super::places::Places;
use super::star::Spoke;

impl<C: Cells> Delaunay<C> {
    /// Removes a vertex; its point stays among `points`. Afterwards the triangulation is that of
    /// the other vertices, exactly.
    ///
    /// Takes time in proportion to k·log k for k neighbours, and to the walk.
    pub(crate) fn remove(&mut self, points: &(impl Places + ?Sized), vertex: VertexId) {
        let at = points.place(vertex);
        let near = self.near(points, at);
        self.sheet.vertices -= 1;
        let (Some(plane), Some(near)) = (&mut self.sheet.plane, near) else {
            self.sheet.line.remove(points, at);
            return;
        };
        let mut editor = Editor { points, cells: &self.cells, work: &mut self.sheet.work };
        let star = editor.star(editor.spoke(vertex, near));
        if editor.leaves_a_line(&star, self.sheet.vertices) {
            editor.dissolve(&star);
            self.sheet.line = Line::of(points, star.iter().map(|spoke| spoke.end));
            self.sheet.plane = None;
            return;
        }
        let Hole { kept, freed } = editor.remove(vertex, &star);
        for slot in [&mut plane.recent, &mut plane.run_start] {
            if freed.contains(slot) {
                *slot = kept;
            }
        }
    }
}

/// Fate of the cells of a star.
struct Hole {
    /// One that is in use still.
    kept: Slot,
    /// Those that are not any more.
    freed: [Slot; 2],
}

impl<P: Places + ?Sized, C: Cells> Editor<'_, P, C> {
    /// Whether the `others` vertices without that of the star all lie on one line.
    fn leaves_a_line(&self, star: &[Spoke], others: usize) -> bool {
        // A vertex off a line of all others is a neighbour of all, and on the hull.
        let Some((Spoke { end: GHOST, .. }, ends)) = star.split_last() else { return false };
        let at = |spoke: &Spoke| self.at(spoke.end);
        ends.len() == others
            && (ends[2..].iter())
                .all(|spoke| orientation(at(&ends[0]), at(&ends[1]), at(spoke)).is_eq())
    }

    /// Takes all triangles away, when all others than those of the star are ghosts on its rim.
    fn dissolve(&mut self, star: &[Spoke]) {
        let chain = star.windows(2).filter(|pair| pair[1].end != GHOST);
        let beyond = chain.map(|pair| pair[0].outside.slot());
        for slot in star.iter().map(|spoke| spoke.slot).chain(beyond) {
            self.cells.write(slot, [GHOST; 3], [Side::NONE; 3]);
            self.work.spare.push(slot);
        }
        self.work.ghosts = 0;
    }

    /// Removes the vertex of a star.
    fn remove(&mut self, vertex: VertexId, star: &[Spoke]) -> Hole {
        let on_hull = star.last().is_some_and(|spoke| spoke.end == GHOST);
        let mut rim = Rim::new(self.at(vertex), star);
        let mut slots = star.iter().map(|spoke| spoke.slot);
        let mut take = || slots.next().expect("a hole has two triangles less than the star");
        for corner in 0..star.len() {
            rim.consider(self, corner);
        }
        while rim.corners > 3
            && let Some(tip) = rim.ear()
        {
            rim.cut(self, tip, take());
        }
        if on_hull {
            let ghosts = rim.close(self, &mut take);
            self.work.ghosts = self.work.ghosts - 2 + ghosts;
        } else {
            assert_eq!(rim.corners, 3, "a polygon seen whole from a place inside has an ear");
            rim.finish(self, take());
        }
        let freed = [take(), take()];
        self.legalize();
        let kept = star[0].slot;
        for slot in freed {
            // Hints may name it still: as a ghost of no length it leads to where it was.
            let corner = star[0].end;
            self.cells.write(slot, [corner, corner, GHOST], [Side::new(kept, 0); 3]);
            self.work.spare.push(slot);
        }
        Hole { kept, freed }
    }
}

/// Remainder of the rim of a hole: a closed line, counter-clockwise, the hole on its left.
struct Rim<'a> {
    /// The vertex that was removed.
    seen_from: Place,
    star: &'a [Spoke],
    /// What lies across the line from each corner to the next, seen from there.
    outside: Vec<Side>,
    next: Vec<usize>,
    prev: Vec<usize>,
    /// How many ears each corner was the tip of; what was found of one before the last is outdated.
    versions: Vec<u32>,
    /// How many corners are left, infinity included, and one of them.
    corners: usize,
    left: usize,
    ears: BinaryHeap<Ear>,
}

/// A triangle that may be cut off: least depth is greatest.
struct Ear {
    depth: f64,
    at: Place,
    tip: usize,
    version: u32,
}

impl<'a> Rim<'a> {
    fn new(seen_from: Place, star: &'a [Spoke]) -> Rim<'a> {
        let count = star.len();
        Rim {
            seen_from,
            star,
            outside: star.iter().map(|spoke| spoke.outside).collect(),
            next: (0..count).map(|corner| (corner + 1) % count).collect(),
            prev: (0..count).map(|corner| (corner + count - 1) % count).collect(),
            versions: vec![0; count],
            corners: count,
            left: 0,
            ears: BinaryHeap::with_capacity(count),
        }
    }

    /// The corner before, the corner, and the one after.
    fn about(&self, tip: usize) -> [VertexId; 3] {
        [self.prev[tip], tip, self.next[tip]].map(|corner| self.star[corner].end)
    }

    /// Notes the ear with this tip, if it is one.
    fn consider(&mut self, editor: &Editor<'_, impl Places + ?Sized, impl Cells>, tip: usize) {
        self.versions[tip] += 1;
        let corners = self.about(tip);
        if corners.contains(&GHOST) {
            return;
        }
        let [a, b, c] = corners.map(|corner| editor.at(corner));
        if left_of(a, b, c) && !left_of(c, a, self.seen_from) {
            let depth = depth([a, b, c], self.seen_from);
            self.ears.push(Ear { depth, at: b, tip, version: self.versions[tip] });
        }
    }

    /// The next ear to cut; its tip.
    fn ear(&mut self) -> Option<usize> {
        while let Some(ear) = self.ears.pop() {
            if self.versions[ear.tip] == ear.version {
                return Some(ear.tip);
            }
        }
        None
    }

    fn cut(
        &mut self,
        editor: &mut Editor<'_, impl Places + ?Sized, impl Cells>,
        tip: usize,
        slot: Slot,
    ) {
        let (before, after) = (self.prev[tip], self.next[tip]);
        let (left, right) = (self.outside[before], self.outside[tip]);
        let open = Side::new(slot, 1);
        editor.cells.write(slot, self.about(tip), [right, Side::NONE, left]);
        editor.cells.set_across(right, Side::new(slot, 0));
        editor.cells.set_across(left, Side::new(slot, 2));
        editor.work.suspects.push(open);
        self.outside[before] = open;
        (self.next[before], self.prev[after]) = (after, before);
        self.versions[tip] += 1;
        (self.corners, self.left) = (self.corners - 1, before);
        self.consider(editor, before);
        self.consider(editor, after);
    }

    /// Puts the last triangle in.
    fn finish(&self, editor: &mut Editor<'_, impl Places + ?Sized, impl Cells>, slot: Slot) {
        let tip = self.left;
        let across =
            [self.outside[tip], self.outside[self.next[tip]], self.outside[self.prev[tip]]];
        editor.cells.write(slot, self.about(tip), across);
        for (index, side) in across.into_iter().enumerate() {
            editor.cells.set_across(side, Side::new(slot, index));
        }
    }

    /// Puts ghosts before all that is left, but infinity; returns how many.
    fn close(
        &self,
        editor: &mut Editor<'_, impl Places + ?Sized, impl Cells>,
        mut take: impl FnMut() -> Slot,
    ) -> usize {
        let infinity = self.star.len() - 1;
        let mut before = self.outside[infinity];
        let mut corner = self.next[infinity];
        let mut ghosts = 0;
        while self.next[corner] != infinity {
            let after = self.next[corner];
            let (ghost, inner) = (take(), self.outside[corner]);
            let corners = [self.star[corner].end, self.star[after].end, GHOST];
            editor.cells.write(ghost, corners, [Side::NONE, before, inner]);
            editor.cells.set_across(before, Side::new(ghost, 1));
            editor.cells.set_across(inner, Side::new(ghost, 2));
            before = Side::new(ghost, 0);
            corner = after;
            ghosts += 1;
        }
        editor.cells.join(before, self.outside[corner]);
        ghosts
    }
}

impl Ord for Ear {
    fn cmp(&self, other: &Ear) -> Ordering {
        other.depth.total_cmp(&self.depth).then_with(|| by_x_then_y(self.at, other.at))
    }
}

impl PartialOrd for Ear {
    fn partial_cmp(&self, other: &Ear) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl PartialEq for Ear {
    fn eq(&self, other: &Ear) -> bool {
        self.cmp(other).is_eq()
    }
}

impl Eq for Ear {}

/// How deep `place` lies in the circle through three corners that turn left, as good as doubles
/// tell it: r² - d² in mm².
fn depth(corners: [Place; 3], place: Place) -> f64 {
    let [a, b, c] = corners.map(|[x, y]| [x - place[0], y - place[1]]);
    let cross = |p: Place, q: Place| p[0] * q[1] - p[1] * q[0];
    let lift = |p: Place| p[0] * p[0] + p[1] * p[1];
    let (bc, ca, ab) = (cross(b, c), cross(c, a), cross(a, b));
    (lift(a) * bc + lift(b) * ca + lift(c) * ab) / (bc + ca + ab)
}
