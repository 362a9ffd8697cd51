//! The neighbours about a point, and which of them make agreed facets.
//!
//! Most rings are short: they lie in place, without memory of their own. Marks are atomic, so that threads set marks in each other's
//! rings while they read them. Each mark is set for one facet, which one thread finds: so marks do not depend on who comes first.

use std::sync::atomic::{AtomicU32, Ordering};

use super::star::GAP;

/// Neighbours in their order, marked where the facet with the next one is agreed.
#[derive(Debug)]
pub(super) enum Ring {
    /// So many entries of these.
    Few(u8, [AtomicU32; FEW]),
    Many(Box<[AtomicU32]>),
}

impl Ring {
    /// A ring without marks.
    pub(super) fn new(neighbours: impl ExactSizeIterator<Item = u32>) -> Ring {
        let len = neighbours.len();
        if len > FEW {
            return Ring::Many(neighbours.map(AtomicU32::new).collect());
        }
        let mut entries = [const { AtomicU32::new(0) }; FEW];
        for (entry, neighbour) in entries.iter_mut().zip(neighbours) {
            *entry = AtomicU32::new(neighbour);
        }
        Ring::Few(len as u8, entries)
    }

    #[inline(always)]
    fn entries(&self) -> &[AtomicU32] {
        match self {
            Ring::Few(len, entries) => &entries[..usize::from(*len)],
            Ring::Many(entries) => entries,
        }
    }

    #[inline(always)]
    pub(super) fn len(&self) -> usize {
        self.entries().len()
    }

    /// The neighbours, with [`GAP`] where no facet is.
    #[inline(always)]
    pub(super) fn neighbours(&self) -> impl Iterator<Item = u32> + '_ {
        self.entries().iter().map(|entry| neighbour(read(entry)))
    }

    /// The neighbour at a place.
    #[inline(always)]
    pub(super) fn neighbour(&self, at: usize) -> u32 {
        neighbour(read(&self.entries()[at]))
    }

    /// The neighbours at a place and at the next one.
    #[inline(always)]
    pub(super) fn pair(&self, at: usize) -> [u32; 2] {
        let entries = self.entries();
        let next = after(at, entries.len());
        [at, next].map(|at| neighbour(read(&entries[at])))
    }

    /// Whether the facet with the neighbour at a place and the next one is agreed.
    #[inline(always)]
    pub(super) fn is_marked(&self, at: usize) -> bool {
        read(&self.entries()[at]) & MARK != 0
    }

    #[inline(always)]
    pub(super) fn mark(&self, at: usize) {
        let entry = &self.entries()[at];
        // No other thread sets this mark.
        entry.store(read(entry) | MARK, Ordering::Relaxed);
    }

    pub(super) fn unmark(&self, at: usize) {
        let entry = &self.entries()[at];
        entry.store(neighbour(read(entry)), Ordering::Relaxed);
    }

    /// The pairs of neighbours that make a facet.
    #[inline(always)]
    pub(super) fn marks(&self) -> impl Iterator<Item = [u32; 2]> + '_ {
        (0..self.len()).filter(|&at| self.is_marked(at)).map(|at| self.pair(at))
    }

    /// Where two neighbours follow each other, whichever is first.
    #[inline(always)]
    pub(super) fn slot(&self, a: u32, b: u32) -> Option<usize> {
        let entries = self.entries();
        let is = |at: usize, other: u32| neighbour(read(&entries[at])) == other;
        let found = (0..entries.len()).find(|&at| is(at, a))?;
        if is(after(found, entries.len()), b) {
            return Some(found);
        }
        let before = if found > 0 { found } else { entries.len() } - 1;
        is(before, b).then_some(before)
    }
}

impl Default for Ring {
    fn default() -> Ring {
        Ring::new(std::iter::empty())
    }
}

impl Clone for Ring {
    fn clone(&self) -> Ring {
        Ring::new(self.entries().iter().map(read))
    }
}

/// Nothing else is read after a mark that must be there with it.
#[inline(always)]
fn read(entry: &AtomicU32) -> u32 {
    entry.load(Ordering::Relaxed)
}

/// The next place in a ring.
#[inline(always)]
pub(super) fn after(index: usize, len: usize) -> usize {
    if index + 1 < len { index + 1 } else { 0 }
}

#[inline(always)]
fn neighbour(entry: u32) -> u32 {
    entry & !MARK
}

/// Entries in place: a ring takes 32 bytes.
const FEW: usize = 7;
const _: () = assert!(size_of::<Ring>() == 32, "a ring must take 32 bytes");
/// Set in an entry whose facet with the next entry is agreed. Numbers of points and [`GAP`] are below it.
const MARK: u32 = 1 << 31;
const _: () = assert!(GAP < MARK, "a mark must be above all neighbours");
