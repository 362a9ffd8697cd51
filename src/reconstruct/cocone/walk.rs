//! The walk along the outer side of candidate facets.
//!
//! At an edge the walk goes on with the first facet that a turn through the outside meets. Of each set of facets that hang
//! together by edges it takes one layer: so tetrahedra that are flat do not thicken the surface.

use std::collections::VecDeque;

use asphera_geometry::{PointMm, Sets};

use crate::rings::{FacetSet, turns};

/// Facets of the outer layers, by vertices.
pub(super) fn outer(set: &FacetSet<'_>) -> Vec<[u32; 3]> {
    let facets: Vec<(u32, usize)> = set.all().collect();
    let levels = levels(set);
    let mut is_taken = FacetSet::empty(set.delaunay);
    let mut outer = Vec::new();
    for (cell, slot) in starts(set, &facets, &levels) {
        let mut front = VecDeque::from([(cell, slot)]);
        is_taken.insert(cell, slot);
        while let Some((cell, slot)) = front.pop_front() {
            outer.push(set.delaunay.facet(cell, slot));
            for turn in turns(cell, slot) {
                // Seen from the cell before it; at a border that is the facet itself from its other side.
                let (next, ahead) = set.first_met(turn);
                if !is_taken.has(next, ahead) && has_room(&is_taken, next, ahead) {
                    is_taken.insert(next, ahead);
                    front.push_back((next, ahead));
                }
            }
        }
    }
    outer
}

/// Whether no edge of a facet has two facets of the layer already: a walk through a hole must not add the inner layer.
fn has_room(layer: &FacetSet<'_>, cell: u32, slot: usize) -> bool {
    turns(cell, slot).all(|turn| {
        let mut count = 0;
        layer.about(turn, |_| count += 1);
        count < 2
    })
}

/// How many facets of the set lie between infinity and each cell, at the least.
fn levels(set: &FacetSet<'_>) -> Vec<u32> {
    let cells = set.delaunay.corners.len() as u32;
    let mut levels = vec![u32::MAX; cells as usize];
    let mut front = VecDeque::new();
    for cell in set.delaunay.tetrahedra as u32..cells {
        levels[cell as usize] = 0;
        front.push_back((cell, 0));
    }
    while let Some((cell, level)) = front.pop_front() {
        if levels[cell as usize] < level {
            continue;
        }
        for slot in 0..4 {
            let next = set.delaunay.neighbours[cell as usize][slot];
            let crossed = level + u32::from(set.has(cell, slot));
            if crossed < levels[next as usize] {
                levels[next as usize] = crossed;
                if crossed == level {
                    front.push_front((next, crossed));
                } else {
                    front.push_back((next, crossed));
                }
            }
        }
    }
    levels
}

/// Where a walk may begin: facets to infinity, places of the facet, the facet seen from its outer side.
type Start = (u32, [PointMm; 3], (u32, usize));

/// Of each part the facet nearest to infinity, of these the first by places, seen from its outer side.
fn starts(set: &FacetSet<'_>, facets: &[(u32, usize)], levels: &[u32]) -> Vec<(u32, usize)> {
    let delaunay = set.delaunay;
    let mut numbers = vec![[u32::MAX; 4]; delaunay.corners.len()];
    for (&(cell, slot), number) in facets.iter().zip(0..) {
        let (other, back) = set.other_side(cell, slot);
        numbers[cell as usize][slot] = number;
        numbers[other as usize][back] = number;
    }
    let mut parts = Sets::new(facets.len());
    for (number, &(cell, slot)) in facets.iter().enumerate() {
        // Both ways about each edge, so that all facets there hang together.
        let (other, back) = set.other_side(cell, slot);
        for turn in turns(cell, slot).chain(turns(other, back)) {
            let (next, ahead) = set.first_met(turn);
            parts.join(number, numbers[next as usize][ahead] as usize);
        }
    }
    let places = |cell: u32, slot: usize| -> [PointMm; 3] {
        let mut places = delaunay.facet(cell, slot).map(|corner| delaunay.place(corner));
        places.sort_by(|a, b| a.partial_cmp(b).unwrap_or(std::cmp::Ordering::Equal));
        places
    };
    let mut best: Vec<Option<Start>> = vec![None; facets.len()];
    for (number, &(cell, slot)) in facets.iter().enumerate() {
        let (other, back) = set.other_side(cell, slot);
        let [near, far] = [levels[cell as usize], levels[other as usize]];
        // Where both sides are alike, as of an open surface, the side of the corner that comes first by places.
        let apex = |cell: u32, slot: usize| {
            let corner = delaunay.corners[cell as usize][slot];
            delaunay.points_mm.get(corner as usize).copied()
        };
        let is_first = near < far || (near == far && apex(cell, slot) < apex(other, back));
        let seen = if is_first { (cell, slot) } else { (other, back) };
        let found = (near.min(far), places(cell, slot), seen);
        let best = &mut best[parts.root(number)];
        if best.as_ref().is_none_or(|old| (found.0, found.1) < (old.0, old.1)) {
            *best = Some(found);
        }
    }
    best.into_iter().flatten().map(|(_, _, seen)| seen).collect()
}
