//! Neighbours and edges, kept up while points arrive.
//!
//! New points ask leaf by leaf. Earlier points that see a new one as near as the last in their list take it in. An edge is there while
//! one of its ends has the other in its list.

use std::collections::HashMap;

use asphera_geometry::BoxMm;
use rayon::prelude::*;

use crate::geometry::{gap, squared};
use crate::local::Places as _;
use crate::local::place_tree::{Inserted, NewInLeaf, PlaceTree, Sight};
use crate::neighbours::Near;

/// Lists of the nearest of all points, and the edges that they make.
#[derive(Clone, Debug)]
pub(super) struct Edges {
    count: usize,
    /// So many a point, the nearest first, then [`NONE`].
    lists: Vec<u32>,
    /// The neighbours of each point in the graph.
    links: Vec<Vec<u32>>,
}

/// What a batch changes in the graph, before it is changed.
#[derive(Default)]
pub(super) struct EdgeChanges {
    /// Pairs of which the first lost or won the second as one of its nearest.
    lost: Vec<[u32; 2]>,
    pub(super) won: Vec<[u32; 2]>,
}

/// Neighbours of points before a batch, where it changed them.
pub(super) type Before = HashMap<u32, Vec<u32>>;

impl Edges {
    pub(super) fn new(count: usize) -> Edges {
        Edges { count, lists: Vec::new(), links: Vec::new() }
    }

    pub(super) fn at(&self, point: u32) -> &[u32] {
        &self.links[point as usize]
    }

    fn list(&self, point: u32) -> &[u32] {
        let list = &self.lists[point as usize * self.count..][..self.count];
        let len = list.iter().position(|&other| other == NONE).unwrap_or(self.count);
        &list[..len]
    }

    /// Brings the lists up to date, and gives what that changes in the graph.
    pub(super) fn take(&mut self, tree: &mut PlaceTree, inserted: &Inserted) -> EdgeChanges {
        let first_new = self.links.len() as u32;
        let asked: Vec<Asked> = inserted
            .leaves
            .par_chunks(LEAVES_AT_ONCE)
            .map(|leaves| Asked::of(tree, leaves, self.count, first_new))
            .collect();
        self.lists.resize(tree.len() * self.count, NONE);
        self.links.resize(tree.len(), Vec::new());
        let mut changes = EdgeChanges::default();
        let (mut seen, mut next) = (Vec::new(), first_new as usize);
        for own in asked {
            for list in own.lists.chunks(self.count) {
                let ends = list.iter().filter(|&&end| end != NONE);
                changes.won.extend(ends.map(|&end| [next as u32, end]));
                self.lists[next * self.count..][..self.count].copy_from_slice(list);
                next += 1;
            }
            seen.extend(own.seen);
        }
        seen.sort_unstable();
        let mut changed: Vec<u32> = (first_new..tree.len() as u32).collect();
        for group in seen.chunk_by(|one, other| one[0] == other[0]) {
            if self.take_new(tree, group, &mut changes) {
                changed.push(group[0][0]);
            }
        }
        let sights: Vec<(u32, f64)> =
            changed.into_iter().map(|at| (at, self.far_mm2(tree, at))).collect();
        tree.set_sights(Sight::Plane, sights.into_iter());
        changes
    }

    /// The square of the distance of the last of the nearest; without end where there are fewer than wanted.
    fn far_mm2(&self, tree: &PlaceTree, at: u32) -> f64 {
        let list = self.list(at);
        let place = |point: u32| tree.points_mm()[point as usize];
        match list.last() {
            Some(&last) if list.len() == self.count => squared(place(at), place(last)),
            _ => f64::INFINITY,
        }
    }

    /// Takes new points that an earlier one sees into its list; gives whether it changed.
    fn take_new(&mut self, tree: &PlaceTree, seen: &[[u32; 2]], changes: &mut EdgeChanges) -> bool {
        let at = seen[0][0];
        let place = |point: u32| tree.points_mm()[point as usize];
        let before = self.list(at).to_vec();
        let others = before.iter().copied().chain(seen.iter().map(|pair| pair[1]));
        let mut near: Vec<Near> =
            others.map(|other| (squared(place(at), place(other)), other)).collect();
        near.sort_unstable_by(|a, b| tree.order(a, b));
        near.truncate(self.count);
        let is_near = |point: u32| near.iter().any(|&(_, other)| other == point);
        let lost = before.iter().filter(|&&other| !is_near(other));
        changes.lost.extend(lost.map(|&other| [at, other]));
        let won = seen.iter().filter(|pair| is_near(pair[1]));
        let wins = changes.won.len();
        changes.won.extend(won);
        let list = &mut self.lists[at as usize * self.count..][..self.count];
        for (to, &(_, other)) in list.iter_mut().zip(&near) {
            *to = other;
        }
        changes.won.len() > wins
    }

    /// Changes the graph; gives the neighbours before of all points that have others now.
    pub(super) fn change(&mut self, changes: &EdgeChanges) -> Before {
        let mut before = Before::new();
        for &[start, end] in &changes.lost {
            if !self.list(end).contains(&start) && self.at(start).contains(&end) {
                for [one, other] in [[start, end], [end, start]] {
                    let links = &mut self.links[one as usize];
                    before.entry(one).or_insert_with(|| links.clone());
                    links.retain(|&near| near != other);
                }
            }
        }
        for &[start, end] in &changes.won {
            if !self.at(start).contains(&end) {
                for [one, other] in [[start, end], [end, start]] {
                    let links = &mut self.links[one as usize];
                    before.entry(one).or_insert_with(|| links.clone());
                    links.push(other);
                }
            }
        }
        before
    }
}

/// Answers to the new points of some leaves.
#[derive(Default)]
struct Asked {
    lists: Vec<u32>,
    /// Earlier points, and the new ones that they see.
    seen: Vec<[u32; 2]>,
}

/// Memory between leaves.
#[derive(Default)]
struct Room {
    waiting: Vec<u32>,
    gathered: Vec<u32>,
    near: Vec<Near>,
    radius_mm: f64,
}

impl Asked {
    fn of(tree: &PlaceTree, leaves: &[NewInLeaf], count: usize, first_new: u32) -> Asked {
        let (mut asked, mut room) = (Asked::default(), Room::default());
        for &new in leaves {
            if !asked.ask(tree, new, count, &mut room) {
                for at in new.from..new.to {
                    asked.ask(tree, NewInLeaf { from: at, to: at + 1 }, count, &mut room);
                }
            }
            asked.see(tree, new, first_new);
        }
        asked
    }

    /// Appends the lists of some new points; `false` and none where they lie too far from each other.
    fn ask(&mut self, tree: &PlaceTree, new: NewInLeaf, count: usize, room: &mut Room) -> bool {
        let wanted = count.min(tree.len() - 1);
        let own = tree.about(new.from..new.to);
        let mut radius = match room.radius_mm {
            0.0 => tree.side_mm(new.from).max(f64::MIN_POSITIVE * 1e200),
            radius => radius,
        };
        let start = self.lists.len();
        let mut most = MOST_GATHERED * count;
        loop {
            room.gathered.clear();
            let found = (&mut room.waiting, &mut room.gathered);
            let is_whole = tree.gather(&own, radius * radius, most, found);
            if !is_whole {
                if new.len() > 1 {
                    self.lists.truncate(start);
                    return false;
                }
                // What was gathered bounds how far the nearest can be.
                most = usize::MAX;
            }
            if room.gathered.len() <= wanted {
                radius *= 2.0;
                continue;
            }
            let mut far_mm2: f64 = 0.0;
            self.lists.truncate(start);
            for at in new.from..new.to {
                far_mm2 = far_mm2.max(self.select(tree, at, count, room));
            }
            let is_all = room.gathered.len() == tree.len();
            if is_whole && (far_mm2 <= radius * radius || is_all) {
                room.radius_mm = far_mm2.sqrt() * 1.05;
                return true;
            }
            radius = far_mm2.sqrt() * (1.0 + 1e-9);
        }
    }

    /// Appends the nearest of what was gathered; gives the square of the distance of the last, mm².
    fn select(&mut self, tree: &PlaceTree, at: u32, count: usize, room: &mut Room) -> f64 {
        let points = tree.points_mm();
        let place = points[at as usize];
        let others = room.gathered.iter().filter(|&&other| other != at);
        room.near.clear();
        room.near.extend(others.map(|&other| (squared(place, points[other as usize]), other)));
        let order = |a: &Near, b: &Near| tree.order(a, b);
        if room.near.len() > count {
            room.near.select_nth_unstable_by(count - 1, order);
            room.near.truncate(count);
        }
        room.near.sort_unstable_by(order);
        let ends = room.near.iter().map(|&(_, other)| other);
        self.lists.extend(ends.chain(std::iter::repeat(NONE)).take(count));
        room.near.last().map_or(0.0, |near| near.0)
    }

    /// Finds the earlier points that see new points of a leaf.
    fn see(&mut self, tree: &PlaceTree, new: NewInLeaf, first_new: u32) {
        let points = tree.points_mm();
        let own = tree.about(new.from..new.to);
        tree.seeing(&[Sight::Plane], &own, &mut |at| {
            if at >= first_new {
                return;
            }
            let (place, sight) = (points[at as usize], tree.sight_mm2(at, &[Sight::Plane]));
            if gap(&BoxMm { low: place, high: place }, &own) * (1.0 - 1e-12) > sight {
                return;
            }
            let seen =
                (new.from..new.to).filter(|&new| squared(place, points[new as usize]) <= sight);
            self.seen.extend(seen.map(|new| [at, new]));
        });
    }
}

/// Stands in a list for a neighbour that is not there.
const NONE: u32 = u32::MAX;
/// So many times as many points as wanted are gathered for the points of a leaf together.
const MOST_GATHERED: usize = 40;
/// Leaves that a thread asks for in turn.
const LEAVES_AT_ONCE: usize = 32;
