//! Stars of all points, and the facets in which all three corners agree.
//!
//! A facet is a mark at each of its corners, in the ring of neighbours: a mark stands for the facet with that neighbour and the
//! next one. So the facets at a point, and the borders there, are read from its own ring.

use rayon::prelude::*;

use super::growing::grow;
use super::ring::{Ring, after};
use super::star::GAP;

/// Rings of neighbours by point.
#[derive(Clone, Debug, Default)]
pub(super) struct Stars {
    rings: Vec<Ring>,
}

/// Facets by numbers of the tree, corners ascending.
pub(super) type Facet = [u32; 3];

/// Facets that came and went.
#[derive(Clone, Debug, Default)]
pub(super) struct Exchange {
    pub(super) added: Vec<Facet>,
    pub(super) removed: Vec<Facet>,
}

impl Exchange {
    /// Adds facets, and takes away those that came and went.
    pub(super) fn of(mut added: Vec<Facet>, mut removed: Vec<Facet>) -> Exchange {
        if added.is_empty() || removed.is_empty() {
            return Exchange { added, removed };
        }
        sort_facets(&mut added);
        sort_facets(&mut removed);
        let without = |from: &[Facet], what: &[Facet]| {
            let mut what = what.iter().copied().peekable();
            let mut is_there = |facet: &Facet| {
                while what.next_if(|other| number(other) < number(facet)).is_some() {}
                what.peek() == Some(facet)
            };
            from.iter().filter(|facet| !is_there(facet)).copied().collect()
        };
        Exchange { added: without(&added, &removed), removed: without(&removed, &added) }
    }

    pub(super) fn facets(&self) -> impl Iterator<Item = Facet> + '_ {
        self.added.iter().chain(&self.removed).copied()
    }
}

/// A border edge at a point: its other end, and the third corner of its only facet.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Border {
    pub(super) end: u32,
    pub(super) third: u32,
}

impl Stars {
    /// Makes room for new points, with empty stars.
    pub(super) fn grow(&mut self, points: usize) {
        grow(&mut self.rings, points, Ring::default);
    }

    /// Whether a point has a ring of the same neighbours.
    pub(super) fn has_ring(&self, at: u32, ring: &Ring) -> bool {
        self.rings[at as usize].neighbours().eq(ring.neighbours())
    }

    pub(super) fn has_neighbours(&self, at: u32) -> bool {
        self.rings[at as usize].len() > 0
    }

    /// The rings from a point on.
    pub(super) fn rings_mut(&mut self, first: u32) -> &mut [Ring] {
        &mut self.rings[first as usize..]
    }

    /// Puts a new ring in place of one. Facets that were marked there and are in it no more are appended.
    pub(super) fn replace(&mut self, at: u32, ring: Ring, lost: &mut Vec<Facet>) {
        let own = &mut self.rings[at as usize];
        for [q, r] in own.marks() {
            match ring.slot(q, r) {
                Some(at) => ring.mark(at),
                None => lost.push(sorted([at, q, r])),
            }
        }
        *own = ring;
    }

    /// Settles marks after rings of some points have changed. `lost` are the facets that these are without now. Facets that came are
    /// listed where `lists`.
    pub(super) fn agree(
        &mut self,
        changed: &[u32],
        mut lost: Vec<Facet>,
        is_changed: impl Fn(u32) -> bool + Sync,
        lists: bool,
    ) -> Exchange {
        sort_facets(&mut lost);
        lost.dedup();
        for &facet in &lost {
            self.unmark(facet);
        }
        let mut found = Vec::new();
        for points in changed.chunks(POINTS_HELD) {
            let find_all = |points: &[u32]| {
                let mut own = Vec::with_capacity(if lists { 2 * points.len() } else { 0 });
                let mut take = |facet| {
                    if lists {
                        own.push(facet);
                    }
                };
                points.iter().for_each(|&p| self.find(p, &is_changed, &mut take));
                own
            };
            let parts: Vec<Vec<Facet>> = points.par_chunks(POINTS_AT_ONCE).map(find_all).collect();
            if points.len() == changed.len() {
                found.reserve_exact(parts.iter().map(Vec::len).sum());
            }
            parts.into_iter().for_each(|part| found.extend(part));
        }
        Exchange { added: found, removed: lost }
    }

    /// Finds the facets at a point that are agreed and not marked, and marks them. Of corners that changed, the first tells a facet.
    fn find(&self, p: u32, is_changed: &impl Fn(u32) -> bool, take: &mut impl FnMut(Facet)) {
        let rings = &self.rings;
        let ring = &rings[p as usize];
        // In a ring of two both pairs are one facet, marked at either.
        let pairs = match ring.len() {
            2 => usize::from(!ring.is_marked(1)),
            len => len,
        };
        for at in (0..pairs).filter(|&at| !ring.is_marked(at)) {
            let [q, r] = ring.pair(at);
            let is_first = || [q, r].into_iter().all(|other| p < other || !is_changed(other));
            if q == GAP || r == GAP || q == r || !is_first() {
                continue;
            }
            let (at_q, at_r) = (&rings[q as usize], &rings[r as usize]);
            if let Some((of_q, of_r)) = at_q.slot(p, r).zip(at_r.slot(p, q)) {
                take(sorted([p, q, r]));
                ring.mark(at);
                at_q.mark(of_q);
                at_r.mark(of_r);
            }
        }
    }

    fn unmark(&self, facet: Facet) {
        for corner in 0..3 {
            let [p, q, r] = [facet[corner], facet[(corner + 1) % 3], facet[(corner + 2) % 3]];
            let ring = &self.rings[p as usize];
            if let Some(at) = ring.slot(q, r) {
                ring.unmark(at);
            }
        }
    }

    /// The other corners of the facets at a point.
    pub(super) fn facets_at(&self, at: u32) -> impl Iterator<Item = [u32; 2]> + '_ {
        self.rings[at as usize].marks()
    }

    /// How many facets an edge has.
    pub(super) fn facets_at_edge(&self, one: u32, other: u32) -> usize {
        self.facets_at(one).filter(|ends| ends.contains(&other)).count()
    }

    /// The border edges at a point.
    pub(super) fn borders_at(&self, at: u32) -> impl Iterator<Item = Border> + '_ {
        let ring = &self.rings[at as usize];
        let len = ring.len();
        (0..len).filter_map(move |index| {
            let before = if index > 0 { index } else { len } - 1;
            let third = match (ring.is_marked(before), ring.is_marked(index)) {
                (true, false) => ring.neighbour(before),
                (false, true) => ring.neighbour(after(index, len)),
                _ => return None,
            };
            Some(Border { end: ring.neighbour(index), third })
        })
    }
}

pub(super) fn sorted(mut facet: Facet) -> Facet {
    facet.sort_unstable();
    facet
}

/// A facet as one number, which is compared faster.
fn number(&[a, b, c]: &Facet) -> u128 {
    u128::from(a) << 64 | u128::from(b) << 32 | u128::from(c)
}

/// Sorts facets by their corners.
pub(super) fn sort_facets(facets: &mut [Facet]) {
    if facets.len() < SORTED_ALONE || rayon::current_num_threads() == 1 {
        facets.sort_unstable_by_key(number);
    } else {
        facets.par_sort_unstable_by_key(number);
    }
}

/// Sorts in threads where that is worth it.
pub(super) fn sort<T: Ord + Send>(items: &mut [T]) {
    if items.len() < SORTED_ALONE || rayon::current_num_threads() == 1 {
        items.sort_unstable();
    } else {
        items.par_sort_unstable();
    }
}

/// Items that one thread sorts faster than many.
const SORTED_ALONE: usize = 100_000;
/// Points whose facets are held beside those of all.
const POINTS_HELD: usize = 1 << 16;
/// Points that a thread takes in turn.
const POINTS_AT_ONCE: usize = 1024;
