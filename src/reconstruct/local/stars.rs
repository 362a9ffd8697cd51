//! Stars of all points, and the facets in which all three corners agree.
//!
//! A facet is a mark at each of its corners, in the ring of neighbours: a mark stands for the facet with that neighbour and the
//! next one. So the facets at a point, and the borders there, are read from its own ring.

use rayon::prelude::*;

use super::star::GAP;

/// Rings of neighbours by point.
#[derive(Clone, Debug, Default)]
pub(super) struct Stars {
    /// Neighbours, marked where the facet with the next one is agreed.
    rings: Vec<Box<[u32]>>,
}

/// Facets in which all corners agree, and the places in rings that stand for them.
#[derive(Default)]
struct Agreed {
    facets: Vec<Facet>,
    marks: Vec<(u32, usize)>,
}

/// Facets by numbers of the tree, corners ascending.
pub(super) type Facet = [u32; 3];

/// Facets that came and went, each in ascending order.
#[derive(Clone, Debug, Default)]
pub(super) struct Exchange {
    pub(super) added: Vec<Facet>,
    pub(super) removed: Vec<Facet>,
}

impl Exchange {
    /// Adds facets, and takes away those that came and went.
    pub(super) fn of(mut added: Vec<Facet>, mut removed: Vec<Facet>) -> Exchange {
        sort_facets(&mut added);
        sort_facets(&mut removed);
        if added.is_empty() || removed.is_empty() {
            return Exchange { added, removed };
        }
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
        self.rings.resize_with(points, Box::default);
    }

    /// Whether a point has a ring of some neighbours.
    pub(super) fn has_ring(&self, at: u32, ring: impl Iterator<Item = u32>) -> bool {
        self.rings[at as usize].iter().map(|&entry| neighbour(entry)).eq(ring)
    }

    /// Puts a new ring in place of one. Facets that were marked there and are in it no more are appended.
    pub(super) fn replace(&mut self, at: u32, mut ring: Box<[u32]>, lost: &mut Vec<Facet>) {
        let own = &mut self.rings[at as usize];
        for [q, r] in marks(own) {
            match slot(&ring, q, r) {
                Some(at) => ring[at] |= MARK,
                None => lost.push(sorted([at, q, r])),
            }
        }
        *own = ring;
    }

    /// Settles marks after rings of some points have changed. `lost` are the facets that these are without now.
    pub(super) fn agree(
        &mut self,
        changed: &[u32],
        mut lost: Vec<Facet>,
        is_changed: impl Fn(u32) -> bool + Sync,
    ) -> Exchange {
        sort_facets(&mut lost);
        lost.dedup();
        for &facet in &lost {
            self.unmark(facet);
        }
        let mut found = Vec::new();
        for points in changed.chunks(POINTS_HELD) {
            let find_all = |points: &[u32]| {
                let mut agreed = Agreed::default();
                points.iter().for_each(|&p| self.find(p, &is_changed, &mut agreed));
                agreed
            };
            let parts: Vec<Agreed> = points.par_chunks(POINTS_AT_ONCE).map(find_all).collect();
            for Agreed { facets, marks } in parts {
                found.extend(facets);
                marks.into_iter().for_each(|(at, slot)| self.rings[at as usize][slot] |= MARK);
            }
        }
        sort_facets(&mut found);
        found.dedup();
        Exchange { added: found, removed: lost }
    }

    /// Finds the facets at a point that are agreed and not marked. Of corners that changed, the first tells a facet.
    fn find(&self, p: u32, is_changed: &impl Fn(u32) -> bool, agreed: &mut Agreed) {
        let rings = &self.rings;
        let ring = &rings[p as usize];
        // In a ring of two both pairs are one facet, marked at either.
        let pairs = match **ring {
            [_, last] => usize::from(last & MARK == 0),
            _ => ring.len(),
        };
        for at in (0..pairs).filter(|&at| ring[at] & MARK == 0) {
            let (q, r) = (ring[at], neighbour(ring[after(at, ring.len())]));
            let is_first = || [q, r].into_iter().all(|other| p < other || !is_changed(other));
            if q == GAP || r == GAP || q == r || !is_first() {
                continue;
            }
            let slots = slot(&rings[q as usize], p, r).zip(slot(&rings[r as usize], p, q));
            if let Some((at_q, at_r)) = slots {
                agreed.facets.push(sorted([p, q, r]));
                agreed.marks.extend([(p, at), (q, at_q), (r, at_r)]);
            }
        }
    }

    fn unmark(&mut self, facet: Facet) {
        for corner in 0..3 {
            let [p, q, r] = [facet[corner], facet[(corner + 1) % 3], facet[(corner + 2) % 3]];
            let ring = &mut self.rings[p as usize];
            if let Some(at) = slot(ring, q, r) {
                ring[at] = neighbour(ring[at]);
            }
        }
    }

    /// The other corners of the facets at a point.
    pub(super) fn facets_at(&self, at: u32) -> impl Iterator<Item = [u32; 2]> + '_ {
        marks(&self.rings[at as usize])
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
            let (before, own) = (ring[if index > 0 { index } else { len } - 1], ring[index]);
            let third = match (before & MARK != 0, own & MARK != 0) {
                (true, false) => before,
                (false, true) => ring[after(index, len)],
                _ => return None,
            };
            Some(Border { end: neighbour(own), third: neighbour(third) })
        })
    }

    /// All facets, in ascending order of their smallest corners.
    pub(super) fn facets(&self) -> impl Iterator<Item = Facet> + '_ {
        self.rings.iter().zip(0..).flat_map(|(ring, p)| {
            marks(ring).filter(move |&[q, r]| p < q && p < r).map(move |[q, r]| sorted([p, q, r]))
        })
    }
}

/// The pairs of neighbours in a ring that make a facet.
fn marks(ring: &[u32]) -> impl Iterator<Item = [u32; 2]> + '_ {
    (0..ring.len())
        .filter(|&at| ring[at] & MARK != 0)
        .map(|at| [neighbour(ring[at]), neighbour(ring[after(at, ring.len())])])
}

/// Where two neighbours follow each other in a ring, whichever is first.
fn slot(ring: &[u32], a: u32, b: u32) -> Option<usize> {
    let mut before = ring.iter().position(|&entry| neighbour(entry) == a)?;
    let next = after(before, ring.len());
    if neighbour(ring[next]) == b {
        return Some(before);
    }
    before = if before > 0 { before } else { ring.len() } - 1;
    (neighbour(ring[before]) == b).then_some(before)
}

/// The next place in a ring.
fn after(index: usize, len: usize) -> usize {
    if index + 1 < len { index + 1 } else { 0 }
}

fn neighbour(entry: u32) -> u32 {
    entry & !MARK
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
/// Set in an entry of a ring whose facet with the next entry is agreed. Numbers of points and [`GAP`] are below it.
const MARK: u32 = 1 << 31;
