//! Cells and where they touch, kept up while landmarks and edges come and go.

use std::collections::HashMap;

use super::cover::{Cover, Marks};
use super::near::{Before, Edges};
use crate::graph::Contact;
use crate::graph::landmarks::FAR;

/// The cell of every point, and the pairs of cells that touch.
#[derive(Clone, Debug, Default)]
pub(super) struct Cells {
    /// Hops to the nearest landmark.
    pub(super) hops: Vec<u8>,
    /// The landmark itself; of several as near, the first in the order.
    pub(super) owners: Vec<u32>,
    /// For points of the batch in `doubted` the owners before.
    before: Vec<u32>,
    doubted: Marks,
    doubts: Vec<u32>,
    pairs: HashMap<[u32; 2], Touch>,
}

/// How two cells touch.
#[derive(Clone, Copy, Debug, Default)]
struct Touch {
    /// Points of either with a neighbour in the other.
    contacts: u32,
    /// Points with both in their neighbourhood.
    meetings: u32,
}

impl Cells {
    /// Makes room for new points, and begins to collect doubts: of all new points.
    pub(super) fn begin(&mut self, points: usize) {
        let first = self.owners.len() as u32;
        self.hops.resize(points, FAR);
        self.owners.resize(points, NO_OWNER);
        self.before.resize(points, NO_OWNER);
        self.doubted.clear(points);
        self.doubts.clear();
        (first..points as u32).for_each(|point| self.doubt(point));
    }

    /// Notes that the cell of a point may change.
    #[inline]
    pub(super) fn doubt(&mut self, point: u32) {
        if self.doubted.mark(point) {
            self.before[point as usize] = self.owners[point as usize];
            self.doubts.push(point);
        }
    }

    pub(super) fn doubts(&self) -> &[u32] {
        &self.doubts
    }

    /// Finds the cells of points in doubt.
    pub(super) fn settle(&mut self, cover: &Cover) {
        for &point in &self.doubts {
            let (owner, hops) = cover.nearest(point).unwrap_or((NO_OWNER, FAR));
            self.owners[point as usize] = owner;
            self.hops[point as usize] = hops;
        }
    }

    /// Counts anew where cells touch. `linked` gives the neighbours before of points that have others now.
    pub(super) fn touch(&mut self, edges: &Edges, linked: &Before, marks: &mut Marks) {
        marks.clear(self.owners.len());
        let mut about = Vec::new();
        let mut add = |point: u32| {
            if marks.mark(point) {
                about.push(point);
            }
        };
        linked.keys().for_each(|&point| add(point));
        for &point in &self.doubts {
            if self.before[point as usize] != self.owners[point as usize] {
                add(point);
                edges.at(point).iter().for_each(|&near| add(near));
            }
        }
        let (mut was, mut is) = (Vec::new(), Vec::new());
        for point in about {
            let links = linked.get(&point).map_or(edges.at(point), Vec::as_slice);
            let owner_before = |at: u32| {
                let owners = if self.doubted.has(at) { &self.before } else { &self.owners };
                owners[at as usize]
            };
            let own = [owner_before(point), self.owners[point as usize]];
            around(owner_before, point, links, &mut was);
            around(|at| self.owners[at as usize], point, edges.at(point), &mut is);
            if own[0] == own[1] && was == is {
                continue;
            }
            // A point that is new had no cell to touch another.
            if own[0] != NO_OWNER {
                each_pair(own[0], &was, |pair, is_own| self.forget(pair, is_own));
            }
            each_pair(own[1], &is, |pair, is_own| {
                let touch = self.pairs.entry(pair).or_default();
                touch.contacts += u32::from(is_own);
                touch.meetings += 1;
            });
        }
    }

    fn forget(&mut self, pair: [u32; 2], is_own: bool) {
        if let Some(touch) = self.pairs.get_mut(&pair) {
            touch.contacts -= u32::from(is_own);
            touch.meetings -= 1;
            if touch.meetings == 0 {
                self.pairs.remove(&pair);
            }
        }
    }

    /// Contacts and meetings by the ranks of landmarks, in ascending order.
    pub(super) fn touching(&self, rank_of: &[u32]) -> (Vec<Contact>, Vec<[u32; 2]>) {
        let (mut contacts, mut meetings) = (Vec::new(), Vec::with_capacity(self.pairs.len()));
        for (pair, touch) in &self.pairs {
            let mut landmarks = pair.map(|landmark| rank_of[landmark as usize]);
            landmarks.sort_unstable();
            meetings.push(landmarks);
            if touch.contacts > 0 {
                contacts.push(Contact { landmarks, points: touch.contacts });
            }
        }
        contacts.sort_unstable();
        meetings.sort_unstable();
        (contacts, meetings)
    }
}

/// The owners of a point and its neighbours, each once.
fn around(owner: impl Fn(u32) -> u32, point: u32, links: &[u32], found: &mut Vec<u32>) {
    found.clear();
    found.push(owner(point));
    for owner in links.iter().map(|&near| owner(near)) {
        if !found.contains(&owner) {
            found.push(owner);
        }
    }
    found.sort_unstable();
}

/// Calls with all pairs of some cells, and whether one is that of the point.
fn each_pair(own: u32, cells: &[u32], mut with: impl FnMut([u32; 2], bool)) {
    for (at, &one) in cells.iter().enumerate() {
        for &other in &cells[at + 1..] {
            with([one, other], one == own || other == own);
        }
    }
}

/// No owner found yet.
const NO_OWNER: u32 = u32::MAX;
