//! The star of a point: its Voronoi cell cut by its tangent plane, ties and near ties by the rule of [`super::vote`].

use asphera_geometry::{PointMm, greater};

use super::near_lists::NearLists;
use super::normals::{Places as _, TangentPlane};
use super::place_tree::{Ball, PlaceTree};
use super::ring::Ring;
use super::vote::{Votes, basis};
use crate::geometry::{cross, dot, minus, plus, squared};
use crate::neighbours::Near;

/// Stands in a star where two neighbours have no facet between them.
pub(crate) const GAP: u32 = u32::MAX >> 1;

/// Ingredients of stars.
pub(super) struct Maker<'a> {
    pub(super) tree: &'a PlaceTree,
    pub(super) near: &'a NearLists,
    pub(super) planes: &'a [Option<TangentPlane>],
}

/// A star, and what it depends on beside its point's plane and nearest neighbours.
pub(super) struct Star {
    /// The neighbours about the point, with [`GAP`] where no facet is.
    pub(super) ring: Ring,
    /// The square of the distance within which a new point may change it, where that is beyond the nearest, mm².
    pub(super) sight_mm2: f64,
    /// The square of the distance of the farthest point whose plane was asked for, mm²; below 0 where none was.
    pub(super) asked_mm2: f64,
    /// Points whose planes were asked for.
    pub(super) asked: Vec<u32>,
}

/// Memory of a thread between stars.
#[derive(Default)]
pub(super) struct Room {
    wider: Vec<Near>,
    /// Points whose planes were asked for.
    asked: Vec<u32>,
    /// What may touch the cell lies in one of these balls: middles, and squares of radii, mm².
    balls: Vec<Ball>,
    waiting: Vec<u32>,
    cell: Vec<Corner>,
    next: Vec<Corner>,
    /// Half-planes that have cut the cell; the first is the border of what is looked at.
    sides: Vec<Half>,
    near_ties: Vec<Half>,
    ring: Vec<Half>,
    /// Near ties that are not in the ring, by number.
    ties: Vec<usize>,
    /// Near ties, and the sides of the ring after which they may stand, by number.
    gaps: Vec<(usize, usize)>,
    votes: Votes,
}

/// A half-plane of the cell: x·a + y·b ≤ offset.
#[derive(Clone, Copy, Default)]
struct Half {
    x: f64,
    y: f64,
    offset: f64,
    /// The neighbour beyond, or [`GAP`].
    of: u32,
}

/// A corner of the cell, and the half-plane of the side that starts there, by its place in [`Room::sides`].
#[derive(Clone, Copy)]
struct Corner {
    x: f64,
    y: f64,
    /// The square of its distance from the point.
    square: f64,
    side: u32,
}

impl Corner {
    fn new(x: f64, y: f64, side: u32) -> Corner {
        Corner { x, y, square: x * x + y * y, side }
    }

    /// How far it lies beyond a half-plane, times the distance of the neighbour.
    #[inline(always)]
    fn beyond(&self, half: Half) -> f64 {
        self.x * half.x + self.y * half.y - half.offset
    }
}

impl Maker<'_> {
    /// A direction in the plane of a point.
    pub(super) fn along(&self, at: u32) -> PointMm {
        self.planes[at as usize].map_or([0.0; 3], |plane| basis(plane.normal))
    }

    /// The star of a point, with the direction that [`Maker::along`] gives; empty where it has no plane.
    pub(super) fn star(&self, at: u32, along: PointMm, room: &mut Room) -> Star {
        let Some(plane) = self.planes[at as usize] else {
            let (ring, asked) = (Ring::default(), Vec::new());
            return Star { ring, sight_mm2: -1.0, asked_mm2: -1.0, asked };
        };
        let points_mm = self.tree.points_mm();
        let across = cross(plane.normal, along);
        let reach = plane.reach_mm;
        let place = points_mm[at as usize];
        let square = |other: u32| squared(place, points_mm[other as usize]);
        let half = |(square, other): Near| {
            let way = minus(points_mm[other as usize], place);
            Half { x: dot(way, along), y: dot(way, across), offset: square / 2.0, of: other }
        };
        start(room, reach);
        room.near_ties.clear();
        room.asked.clear();
        let near = self.near.of(at);
        let widest = cut_all(room, near.iter().map(|&other| half((square(other), other))), reach);
        let seen = near.last().map_or(0.0, |&last| square(last));
        let mut sight_mm2 = -1.0;
        if 4.0 * widest > seen {
            let radius = (2.0 * widest.sqrt()).min(reach) * (1.0 + 1e-9);
            sight_mm2 = radius * radius;
            // What can neither cut the cell nor nearly touch it now cannot later: the cell only shrinks.
            let mut wider = std::mem::take(&mut room.wider);
            wider.clear();
            room.balls.clear();
            let far = room.cell.iter().filter(|corner| TOUCHING * corner.square > seen);
            // More than the rounding of what is near.
            let margin_mm = place.iter().fold(reach, |most, side| most.max(side.abs())) * 1e-14;
            room.balls.extend(far.map(|corner| {
                let middle = plus(plus(place, corner.x, along), corner.y, across);
                let radius = (NEARLY_WITHIN * corner.square).sqrt() * (1.0 + 1e-7) + margin_mm;
                (middle, radius * radius)
            }));
            let (within, known) = ((place, sight_mm2), (place, seen));
            self.tree.gather_in_balls(
                &room.balls,
                within,
                known,
                &mut room.waiting,
                &mut |other| {
                    let square = square(other);
                    // Nearer ones are known, and this point itself.
                    if square < seen || square > sight_mm2 || other == at {
                        return;
                    }
                    let own = (square, other);
                    let is_known = square == seen && near.contains(&other);
                    if !is_known && is_near(&room.cell, half(own)) {
                        wider.push(own);
                    }
                },
            );
            wider.sort_unstable_by(|a, b| self.tree.order(a, b));
            cut_all(room, wider.iter().map(|&near| half(near)), reach);
            room.wider = wider;
        }
        self.settle(at, reach * reach / 4.0, room);
        let ring = Ring::new(room.ring.iter().map(|half| half.of));
        room.asked.sort_unstable();
        room.asked.dedup();
        let squares = room.asked.iter().map(|&other| squared(place, points_mm[other as usize]));
        let asked_mm2 = squares.fold(-1.0, f64::max);
        Star { ring, sight_mm2, asked_mm2, asked: room.asked.clone() }
    }

    /// The ring of neighbours, with near ties settled.
    fn settle(&self, at: u32, limit: f64, room: &mut Room) {
        let ring = &mut room.ring;
        ring.clear();
        let mut before = room.cell.last().map_or(GAP, |last| room.sides[last.side as usize].of);
        for corner in &room.cell {
            // Between the side before this corner and the one that starts here is a facet, unless it is too wide.
            let side = room.sides[corner.side as usize];
            if corner.square > limit && before != GAP && side.of != GAP {
                ring.push(Half { of: GAP, ..Half::default() });
            }
            ring.push(side);
            before = side.of;
        }
        let Room { asked, gaps, ties, votes, .. } = room;
        let mut rule = Rule { maker: self, at, asked, gaps, ties, votes };
        let mut from = 0;
        for _ in 0..MOST_FLIPS {
            let flipped = rule.remove_one(limit, ring, from);
            match flipped.or_else(|| rule.insert_one(limit, ring, &room.near_ties)) {
                // Earlier edges have the sides that they had.
                Some(at) => from = if ring.len() > 4 { at.saturating_sub(2) } else { 0 },
                None => return,
            }
        }
    }
}

/// The rule for near ties at a point, and whose planes it asked for.
struct Rule<'a> {
    maker: &'a Maker<'a>,
    at: u32,
    asked: &'a mut Vec<u32>,
    gaps: &'a mut Vec<(usize, usize)>,
    ties: &'a mut Vec<usize>,
    votes: &'a mut Votes,
}

impl Rule<'_> {
    /// Takes a neighbour out of the ring whose edge the rule denies; gives where it was. The first to be asked follows `from`.
    fn remove_one(&mut self, limit: f64, ring: &mut Vec<Half>, from: usize) -> Option<usize> {
        let len = ring.len();
        for index in from..len {
            let middle = wrapped(index + 1, len);
            let (q, r, s) = (ring[index], ring[middle], ring[wrapped(middle + 1, len)]);
            let is_near_tie =
                || corner_within(q, s, limit).is_some_and(|corner| touches(r, corner));
            if len < 4 || [q.of, r.of, s.of].contains(&GAP) || !is_near_tie() {
                continue;
            }
            if self.has_edge(r.of, [q.of, s.of]) == Some(false) {
                ring.remove(middle);
                return Some(middle);
            }
        }
        None
    }

    /// Takes a neighbour into the ring whose edge the rule asks for; gives where it is.
    fn insert_one(
        &mut self,
        limit: f64,
        ring: &mut Vec<Half>,
        near_ties: &[Half],
    ) -> Option<usize> {
        self.gaps.clear();
        let is_there = |tie: &Half| ring.iter().any(|half| half.of == tie.of);
        self.ties.clear();
        self.ties.extend((0..near_ties.len()).filter(|&number| !is_there(&near_ties[number])));
        if self.ties.is_empty() {
            return None;
        }
        for index in 0..ring.len() {
            let (q, r) = (ring[index], ring[wrapped(index + 1, ring.len())]);
            let Some(corner) = corner_within(q, r, limit).filter(|_| q.of != GAP && r.of != GAP)
            else {
                continue;
            };
            for &number in &*self.ties {
                let tie = near_ties[number];
                let is_between = q.x * tie.y > q.y * tie.x && tie.x * r.y > tie.y * r.x;
                if is_between && touches(tie, corner) {
                    self.gaps.push((number, index));
                }
            }
        }
        // Ties in their order: the nearest first.
        self.gaps.sort_unstable();
        for at in 0..self.gaps.len() {
            let (number, index) = self.gaps[at];
            let tie = near_ties[number];
            let sides = [ring[index].of, ring[wrapped(index + 1, ring.len())].of];
            if self.has_edge(tie.of, sides) == Some(true) {
                ring.insert(index + 1, tie);
                return Some(index + 1);
            }
        }
        None
    }

    fn has_edge(&mut self, over: u32, sides: [u32; 2]) -> Option<bool> {
        let Maker { tree, planes, .. } = self.maker;
        self.votes.diagonal(tree.points_mm(), planes, [self.at, over], sides, self.asked)
    }
}

/// An index that has gone at most once round.
#[inline(always)]
fn wrapped(index: usize, len: usize) -> usize {
    if index < len { index } else { index - len }
}

/// A square about the point and the circle that its facets may have.
fn start(room: &mut Room, reach: f64) {
    room.sides.clear();
    room.sides.push(Half { of: GAP, ..Half::default() });
    let corners = [(1.0, -1.0), (1.0, 1.0), (-1.0, 1.0), (-1.0, -1.0)];
    let side = reach / 2.0 * (1.0 + 1e-9);
    room.cell.clear();
    room.cell.extend(corners.map(|(x, y)| Corner::new(x * side, y * side, 0)));
}

/// Cuts the cell until the next neighbours are too far to matter; the square of its radius, as far as it counts.
fn cut_all(room: &mut Room, halves: impl Iterator<Item = Half>, reach: f64) -> f64 {
    let limit = reach * reach / 4.0;
    let widest =
        |cell: &[Corner]| cell.iter().map(|corner| corner.square).fold(0.0, greater).min(limit);
    let mut radius = widest(&room.cell);
    for half in halves {
        // The neighbour is at twice the radius or farther: with a margin for those that nearly touch.
        if half.offset > 2.0 * radius * (1.0 + NEAR_TIE) {
            break;
        }
        if cut(room, half) {
            radius = widest(&room.cell);
        }
    }
    radius
}

/// Whether a half-plane cuts the cell or nearly touches it.
///
/// The margin grows with the square of the distance from the point, a convex figure: within the cell it is largest at a corner.
fn is_near(cell: &[Corner], half: Half) -> bool {
    cell.iter().any(|corner| corner.beyond(half) > -NEAR_TIE * corner.square)
}

/// Cuts the cell by a half-plane; gives whether it lost anything.
fn cut(room: &mut Room, half: Half) -> bool {
    let mut is_cut = false;
    let mut is_near = false;
    for corner in &room.cell {
        let beyond = corner.beyond(half);
        is_cut |= beyond > 0.0;
        is_near |= beyond > -NEAR_TIE * corner.square;
    }
    if is_near {
        room.near_ties.push(half);
    }
    if !is_cut {
        return false;
    }
    let own = room.sides.len() as u32;
    room.sides.push(half);
    room.next.clear();
    let mut from = room.cell[room.cell.len() - 1];
    let mut a = from.beyond(half);
    // The sides in their order, the last one first.
    for &to in &room.cell {
        let b = to.beyond(half);
        let crossing = |side: u32| {
            let share = a / (a - b);
            Corner::new(from.x + share * (to.x - from.x), from.y + share * (to.y - from.y), side)
        };
        if a <= 0.0 && b > 0.0 {
            room.next.push(crossing(own));
        } else if a > 0.0 && b <= 0.0 {
            room.next.push(crossing(from.side));
        }
        if b <= 0.0 {
            room.next.push(to);
        }
        (from, a) = (to, b);
    }
    std::mem::swap(&mut room.cell, &mut room.next);
    true
}

/// The corner that two neighbours in their order make, with the square of its distance, where that is within a limit.
#[inline(always)]
fn corner_within(q: Half, s: Half, limit: f64) -> Option<[f64; 3]> {
    let turn = q.x * s.y - q.y * s.x;
    if turn <= 0.0 {
        return None;
    }
    let x = (q.offset * s.y - s.offset * q.y) / turn;
    let y = (q.x * s.offset - s.x * q.offset) / turn;
    let square = x * x + y * y;
    (square <= limit).then_some([x, y, square])
}

/// Whether a neighbour nearly touches a corner.
#[inline(always)]
fn touches(r: Half, [x, y, square]: [f64; 3]) -> bool {
    (x * r.x + y * r.y - r.offset).abs() <= NEAR_TIE * square
}

/// Of the square of a circle's radius: within it a point nearly lies on the circle.
const NEAR_TIE: f64 = 0.3;
/// The square of the distance of a point that nearly touches a corner, of that of the corner, is at most (1 + √(1 + 2·[`NEAR_TIE`]))²:
/// a little less than this.
const TOUCHING: f64 = 5.2;
/// The square of its distance from the corner is at most 1 + 2·[`NEAR_TIE`], of that of the corner.
const NEARLY_WITHIN: f64 = 1.0 + 2.0 * NEAR_TIE;
/// A star of more flips is left as it is; its facets then do not agree.
const MOST_FLIPS: u32 = 32;
