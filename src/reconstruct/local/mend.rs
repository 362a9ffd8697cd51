//! Small holes filled where corners do not agree.
//!
//! Holes are filled one after another in the order of their first two corners by coordinates, for a filling may take what a later
//! one would need. None crosses the surface as it is then. After a change only those holes are asked again that it touches: holes
//! with a corner there, holes whose filling meets the box of a changed facet, and later holes touched by a filling that changed.

use std::collections::{BTreeMap, BTreeSet, HashMap};

use asphera_geometry::{BoxMm, PointMm};

use super::filling::best_filling;
use super::holes::{Borders, Door, Loop};
use super::normals::Places as _;
use super::place_tree::{PlaceTree, Sight};
use super::stars::{Exchange, Facet, sorted};
use crate::geometry::{dot, minus, squared};
use crate::neighbours::Near;
use crate::prove::cross_any;

/// The holes of a surface and what fills them.
#[derive(Clone, Debug, Default)]
pub(super) struct Mending {
    holes: HashMap<Door, Hole>,
    /// The holes at each corner.
    at_corner: HashMap<u32, Vec<Door>>,
}

#[derive(Clone, Debug)]
struct Hole {
    edge: Loop,
    /// The facets that fill it; none where it stays open.
    filling: Vec<Facet>,
    /// The box of the best filling, whether it is taken or crosses something.
    bounds: Option<BoxMm>,
    /// Facets with a corner within this distance of the first corner count, as its square, mm².
    sight_mm2: f64,
}

/// Place of a hole in the order in which holes are filled.
type Turn = ([u64; 6], Door);

/// The surface in which holes lie.
#[derive(Clone, Copy)]
pub(super) struct Surface<'a> {
    pub(super) tree: &'a PlaceTree,
    pub(super) borders: Borders<'a>,
}

impl Surface<'_> {
    fn place(&self, at: u32) -> PointMm {
        self.borders.points_mm[at as usize]
    }

    fn turn(&self, door: Door) -> Turn {
        let [a, b] = door.map(|at| self.place(at).map(in_order));
        ([a[0], a[1], a[2], b[0], b[1], b[2]], door)
    }

    fn box_of(&self, facets: &[Facet]) -> BoxMm {
        self.tree.about(facets.as_flattened().iter().copied())
    }
}

/// Holes to ask, and facets of fillings that came and went.
#[derive(Default)]
pub(super) struct Repair {
    doubtful: BTreeSet<Turn>,
    added: Vec<Facet>,
    removed: Vec<Facet>,
    /// Points whose holes changed.
    doors: BTreeSet<u32>,
}

impl Mending {
    /// The facets that fill holes.
    pub(super) fn facets(&self) -> impl Iterator<Item = Facet> + '_ {
        self.holes.values().flat_map(|hole| hole.filling.iter().copied())
    }

    /// Settles the fillings after facets of stars changed. At `points`, in ascending order, facets or planes changed.
    pub(super) fn settle(
        &mut self,
        surface: Surface<'_>,
        points: &[u32],
        exchange: &Exchange,
    ) -> Repair {
        let mut repair = Repair::default();
        let had_holes = !self.holes.is_empty();
        let mut old =
            if had_holes { self.take_holes(points, &mut repair) } else { BTreeMap::new() };
        for (door, edge) in surface.borders.loops_through(points) {
            let filling = old.remove(&door).map_or_else(Vec::new, |hole| hole.filling);
            let sight_mm2 = sight_mm2(surface, &edge);
            for &corner in &edge.corners {
                self.at_corner.entry(corner).or_default().push(door);
            }
            self.holes.insert(door, Hole { edge, filling, bounds: None, sight_mm2 });
            repair.doors.insert(door[0]);
            repair.doubtful.insert(surface.turn(door));
        }
        for hole in old.into_values() {
            repair.removed.extend(&hole.filling);
            self.doubt(surface, &hole.filling, None, &mut repair.doubtful);
        }
        if had_holes {
            self.doubt_about(surface, exchange, &mut repair.doubtful);
        }
        while let Some(turn) = repair.doubtful.pop_first() {
            self.fill(surface, turn, &mut repair);
        }
        repair
    }

    /// Sets how far the holes see whose doors changed; gives what changed in fillings.
    pub(super) fn finish(&self, tree: &mut PlaceTree, repair: Repair) -> Exchange {
        let sights = repair.doors.iter().map(|&first| {
            let doors = self.at_corner.get(&first).into_iter().flatten();
            let own = doors.filter(|door| door[0] == first).map(|door| &self.holes[door]);
            (first, own.map(|hole| hole.sight_mm2).fold(-1.0, f64::max))
        });
        tree.set_sights(Sight::Hole, sights);
        Exchange::of(repair.added, repair.removed)
    }

    /// Takes the holes out that have a corner among points.
    fn take_holes(&mut self, points: &[u32], repair: &mut Repair) -> BTreeMap<Door, Hole> {
        let mut old = BTreeMap::new();
        for point in points {
            for door in self.at_corner.remove(point).unwrap_or_default() {
                let Some(hole) = self.holes.remove(&door) else { continue };
                for corner in &hole.edge.corners {
                    if let Some(doors) = self.at_corner.get_mut(corner) {
                        doors.retain(|&other| other != door);
                        if doors.is_empty() {
                            self.at_corner.remove(corner);
                        }
                    }
                }
                repair.doors.insert(door[0]);
                old.insert(door, hole);
            }
        }
        old
    }

    /// Asks again which filling a hole has.
    fn fill(&mut self, surface: Surface<'_>, turn: Turn, repair: &mut Repair) {
        let door = turn.1;
        let Some(hole) = self.holes.get(&door) else { return };
        let found = best_filling(&surface.borders, &hole.edge, |one, other| {
            surface.borders.stars.facets_at_edge(one, other)
                + self.earlier_at(surface, one, turn).filter(|facet| facet.contains(&other)).count()
        });
        let mut filling = Vec::new();
        let bounds = found.as_deref().map(|facets| surface.box_of(facets));
        if let (Some(found), Some(bounds)) = (found, bounds) {
            let near = self.facets_about(surface, hole, turn, &bounds);
            if !cross_any(surface.borders.points_mm, &found, &near) {
                filling = found.into_iter().map(sorted).collect();
                filling.sort_unstable();
            }
        }
        let Some(hole) = self.holes.get_mut(&door) else { return };
        hole.bounds = bounds;
        if hole.filling == filling {
            return;
        }
        let old = std::mem::replace(&mut hole.filling, filling.clone());
        let change = Exchange::of(filling, old);
        repair.added.extend(&change.added);
        repair.removed.extend(&change.removed);
        let changed: Vec<Facet> = change.facets().collect();
        self.doubt(surface, &changed, Some(turn), &mut repair.doubtful);
    }

    /// Facets of earlier holes at a corner.
    fn earlier_at(
        &self,
        surface: Surface<'_>,
        corner: u32,
        turn: Turn,
    ) -> impl Iterator<Item = Facet> + '_ {
        let doors = self.at_corner.get(&corner).into_iter().flatten();
        let earlier: Vec<&Hole> = doors
            .filter(|&&door| surface.turn(door) < turn)
            .map(|door| &self.holes[door])
            .collect();
        let facets = earlier.into_iter().flat_map(|hole| hole.filling.iter().copied());
        facets.filter(move |facet| facet.contains(&corner))
    }

    /// The facets that may meet what fills a hole: with a corner near it, and within the box.
    fn facets_about(
        &self,
        surface: Surface<'_>,
        hole: &Hole,
        turn: Turn,
        bounds: &BoxMm,
    ) -> Vec<Facet> {
        let first = hole.edge.corners[0];
        let mut near: Vec<Near> = Vec::new();
        surface.tree.within(first, hole.sight_mm2.sqrt() * (1.0 + 1e-12), &mut near);
        near.retain(|&(square, _)| square <= hole.sight_mm2);
        let mut found: Vec<Facet> = Vec::new();
        for corner in near.iter().map(|&(_, corner)| corner).chain([first]) {
            let agreed =
                surface.borders.stars.facets_at(corner).map(|[q, r]| sorted([corner, q, r]));
            let facets = agreed.chain(self.earlier_at(surface, corner, turn));
            found.extend(facets.filter(|&facet| overlap(&surface.box_of(&[facet]), bounds)));
        }
        found.sort_unstable();
        found.dedup();
        found
    }

    /// Marks the holes that facets may touch, by a corner or by what fills them; after a turn only.
    fn doubt(
        &self,
        surface: Surface<'_>,
        facets: &[Facet],
        after: Option<Turn>,
        doubtful: &mut BTreeSet<Turn>,
    ) {
        let is_later = |turn: &Turn| after.is_none_or(|after| *turn > after);
        for corner in facets.as_flattened() {
            let doors = self.at_corner.get(corner).into_iter().flatten();
            doubtful.extend(doors.map(|&door| surface.turn(door)).filter(is_later));
        }
        for &facet in facets {
            let mut found = Vec::new();
            self.crossed(surface, &[facet], &mut found);
            doubtful.extend(found.into_iter().map(|door| surface.turn(door)).filter(is_later));
        }
    }

    /// Marks the holes whose fillings may meet changed facets of stars.
    fn doubt_about(
        &self,
        surface: Surface<'_>,
        exchange: &Exchange,
        doubtful: &mut BTreeSet<Turn>,
    ) {
        let mut facets: Vec<Facet> = exchange.facets().collect();
        let leaf = |facet: &Facet| surface.tree.leaf_of(facet[0]);
        facets.sort_unstable_by_key(|facet| (leaf(facet), *facet));
        let mut found = Vec::new();
        for group in facets.chunk_by(|a, b| leaf(a) == leaf(b)) {
            self.crossed(surface, group, &mut found);
        }
        doubtful.extend(found.into_iter().map(|door| surface.turn(door)));
    }

    /// The holes that some facets near each other may keep from being filled as they would be.
    fn crossed(&self, surface: Surface<'_>, facets: &[Facet], found: &mut Vec<Door>) {
        surface.tree.seeing(&[Sight::Hole], &surface.box_of(facets), &mut |first| {
            if surface.tree.sight_mm2(first, &[Sight::Hole]) < 0.0 {
                return;
            }
            let place = surface.place(first);
            for &door in self.at_corner.get(&first).into_iter().flatten() {
                let hole = &self.holes[&door];
                let Some(bounds) = hole.bounds.filter(|_| door[0] == first) else { continue };
                let meets = |facet: &Facet| {
                    let sees = |&at: &u32| squared(surface.place(at), place) <= hole.sight_mm2;
                    facet.iter().any(sees) && overlap(&surface.box_of(&[*facet]), &bounds)
                };
                if facets.iter().any(meets) {
                    found.push(door);
                }
            }
        });
    }
}

/// How far facets count for a hole, from its first corner, as the square in mm².
fn sight_mm2(surface: Surface<'_>, edge: &Loop) -> f64 {
    let origin = surface.place(edge.corners[0]);
    let far = |&corner: &u32| {
        let way = minus(surface.place(corner), origin);
        let plane = surface.borders.planes[corner as usize];
        dot(way, way).sqrt() + 2.0 * plane.map_or(0.0, |plane| plane.reach_mm)
    };
    let radius_mm = edge.corners.iter().map(far).fold(0.0, f64::max);
    radius_mm * radius_mm
}

fn overlap(a: &BoxMm, b: &BoxMm) -> bool {
    (0..3).all(|axis| a.low[axis] <= b.high[axis] && b.low[axis] <= a.high[axis])
}

/// A number in whose order finite values are, as [`f64::total_cmp`] has it.
fn in_order(value: f64) -> u64 {
    let bits = value.to_bits();
    if value.is_sign_negative() { !bits } else { bits | 1 << 63 }
}
