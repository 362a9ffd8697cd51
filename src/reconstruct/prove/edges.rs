//! The edges of a mesh, and whether its triangles can be turned alike.

use rayon::prelude::*;

/// The edges by how many triangles they have.
pub(super) struct Edges {
    /// How many there are.
    pub(super) count: usize,
    /// Edges of one triangle.
    pub(super) border: Vec<Side>,
    /// Edges of two, with the sides of both.
    pub(super) inner: Vec<[Side; 2]>,
    /// Edges of three or more, or of one triangle twice.
    pub(super) nonmanifold: Vec<Crowded>,
    /// Whether neighbours agree as they are listed.
    pub(super) is_oriented: bool,
    /// Whether they can be turned so that they do.
    pub(super) is_orientable: bool,
}

/// An edge of more than two sides.
pub(super) struct Crowded {
    pub(super) ends: [u32; 2],
    pub(super) facets: Vec<u32>,
}

/// A side of a triangle.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct Side {
    pub(super) low: u32,
    pub(super) high: u32,
    /// The triangle, and which of its sides: 3·facet + the corner where the side starts.
    pub(super) slot: u32,
    /// Whether the triangle runs from the lower number to the higher.
    pub(super) ascends: bool,
}

impl Side {
    pub(super) fn facet(self) -> u32 {
        self.slot / 3
    }

    /// Slots of the corners at the low and the high end.
    pub(super) fn corners(self) -> [u32; 2] {
        let next = 3 * self.facet() + (self.slot + 1) % 3;
        // 3·facet is a multiple of 3, so that the remainder of a slot is its corner.
        if self.ascends { [self.slot, next] } else { [next, self.slot] }
    }
}

impl Edges {
    pub(super) fn of(facets: &[[u32; 3]]) -> Edges {
        let mut sides: Vec<Side> = facets
            .par_iter()
            .enumerate()
            .flat_map_iter(|(facet, corners)| {
                (0..3).map(move |corner| {
                    let (from, to) = (corners[corner], corners[(corner + 1) % 3]);
                    let slot = 3 * facet as u32 + corner as u32;
                    Side { low: from.min(to), high: from.max(to), slot, ascends: from < to }
                })
            })
            .collect();
        sides.par_sort_unstable();
        let mut edges = Edges {
            count: 0,
            border: Vec::new(),
            inner: Vec::with_capacity(sides.len() / 2),
            nonmanifold: Vec::new(),
            is_oriented: true,
            is_orientable: true,
        };
        for group in sides.chunk_by(|a, b| (a.low, a.high) == (b.low, b.high)) {
            edges.count += 1;
            match *group {
                [only] if only.low != only.high => edges.border.push(only),
                [one, other] if one.low != one.high && one.facet() != other.facet() => {
                    edges.is_oriented &= one.ascends != other.ascends;
                    edges.inner.push([one, other]);
                }
                _ => {
                    let facets = group.iter().map(|side| side.facet()).collect();
                    edges.nonmanifold.push(Crowded { ends: [group[0].low, group[0].high], facets });
                }
            }
        }
        edges.is_orientable = edges.is_oriented || edges.turns(facets.len()).is_some();
        edges
    }

    /// Which triangles must be turned so that neighbours agree, the first of each patch not; `None` where it cannot be.
    pub(super) fn turns(&self, facets: usize) -> Option<Vec<bool>> {
        let mut beside = vec![[NONE; 3]; facets];
        for [one, other] in &self.inner {
            let agrees = u32::from(one.ascends != other.ascends);
            beside[one.facet() as usize][one.slot as usize % 3] = other.facet() << 1 | agrees;
            beside[other.facet() as usize][other.slot as usize % 3] = one.facet() << 1 | agrees;
        }
        let mut turned: Vec<Option<bool>> = vec![None; facets];
        let mut waiting = Vec::new();
        for first in 0..facets {
            if turned[first].is_some() {
                continue;
            }
            turned[first] = Some(false);
            waiting.push(first);
            while let Some(facet) = waiting.pop() {
                let is_turned = turned[facet] == Some(true);
                for &way in beside[facet].iter().filter(|&&way| way != NONE) {
                    let (other, agrees) = ((way >> 1) as usize, way & 1 == 1);
                    let wanted = is_turned == agrees;
                    match turned[other] {
                        None => {
                            turned[other] = Some(wanted);
                            waiting.push(other);
                        }
                        Some(found) if found != wanted => return None,
                        Some(_) => {}
                    }
                }
            }
        }
        Some(turned.into_iter().map(|turned| turned == Some(true)).collect())
    }
}

const NONE: u32 = u32::MAX;
