//! Triangles that cross, touch or cover each other, decided exactly.
//!
//! Two triangles meet where a side of one meets the other. Of two with a common corner the sides at that corner need not be
//! asked: what passes through it and lies in the other triangle reaches the far side of one of them.

use std::cmp::Ordering;

use asphera_geometry::predicates::{orientation, orientation_in_space};
use asphera_geometry::{BoxMm, PointMm};

use super::{boxes, corners};

/// Pairs of triangles that meet elsewhere than in common corners and edges. `degenerate` ones, in ascending order, are left out.
pub(super) fn all(points_mm: &[PointMm], facets: &[[u32; 3]], degenerate: &[u32]) -> Vec<[u32; 2]> {
    let bounds: Vec<_> =
        facets.iter().map(|&facet| BoxMm::about(corners(points_mm, facet))).collect();
    let is_flat = |facet: u32| degenerate.binary_search(&facet).is_ok();
    boxes::pairs(&bounds, |one, other| {
        cross(points_mm, facets[one as usize], facets[other as usize])
            && !is_flat(one)
            && !is_flat(other)
    })
}

/// Whether any of some triangles is without area, or meets another of them or of `others` elsewhere than in common corners and
/// edges. Takes time in proportion to the product of both numbers.
pub(crate) fn cross_any(points_mm: &[PointMm], some: &[[u32; 3]], others: &[[u32; 3]]) -> bool {
    some.iter().enumerate().any(|(index, &one)| {
        is_degenerate(corners(points_mm, one))
            || some[..index].iter().chain(others).any(|&other| cross(points_mm, one, other))
    })
}

/// Whether the corners of a triangle lie on a line.
pub(super) fn is_degenerate(corners: [PointMm; 3]) -> bool {
    plane_of(corners).is_none()
}

/// Whether two triangles with area meet elsewhere than in what they share by number.
fn cross(points_mm: &[PointMm], one: [u32; 3], other: [u32; 3]) -> bool {
    let shared = one.iter().filter(|corner| other.contains(corner)).count();
    let (a, b) = (corners(points_mm, one), corners(points_mm, other));
    match shared {
        0 => {
            (0..3).any(|side| meets([a[side], a[(side + 1) % 3]], b))
                || (0..3).any(|side| meets([b[side], b[(side + 1) % 3]], a))
        }
        1 => {
            let far = |own: [u32; 3], places: [PointMm; 3], other: [u32; 3]| {
                let common = (0..3).find(|&corner| other.contains(&own[corner])).unwrap_or(0);
                [places[(common + 1) % 3], places[(common + 2) % 3]]
            };
            meets(far(one, a, other), b) || meets(far(other, b, one), a)
        }
        2 => {
            let apex = |own: [u32; 3], places: [PointMm; 3], other: [u32; 3]| {
                let free = (0..3).find(|&corner| !other.contains(&own[corner])).unwrap_or(0);
                [places[free], places[(free + 1) % 3], places[(free + 2) % 3]]
            };
            let ([p, from, to], [q, ..]) = (apex(one, a, other), apex(other, b, one));
            is_folded(p, q, from, to)
        }
        _ => true,
    }
}

/// Whether two triangles over one edge lie in one plane on the same side of it.
fn is_folded(p: PointMm, q: PointMm, from: PointMm, to: PointMm) -> bool {
    if orientation_in_space(p, from, to, q).is_ne() {
        return false;
    }
    // Without area nothing is covered.
    plane_of([p, from, to]).is_some_and(|axes| {
        let [p, q, from, to] = [p, q, from, to].map(|place| flat(place, axes));
        let side = orientation(from, to, q);
        side.is_ne() && side == orientation(from, to, p)
    })
}

/// Whether a closed segment meets a closed triangle.
fn meets([p, q]: [PointMm; 2], [a, b, c]: [PointMm; 3]) -> bool {
    let sides = (orientation_in_space(a, b, c, p), orientation_in_space(a, b, c, q));
    match sides {
        (Ordering::Greater, Ordering::Greater) | (Ordering::Less, Ordering::Less) => false,
        (Ordering::Equal, Ordering::Equal) => plane_of([a, b, c]).is_some_and(|axes| {
            let [p, q, a, b, c] = [p, q, a, b, c].map(|place| flat(place, axes));
            meets_in_plane([p, q], [a, b, c])
        }),
        _ => {
            let turns =
                [(a, b), (b, c), (c, a)].map(|(from, to)| orientation_in_space(p, q, from, to));
            !(turns.contains(&Ordering::Greater) && turns.contains(&Ordering::Less))
        }
    }
}

fn meets_in_plane([p, q]: [Flat; 2], [a, b, c]: [Flat; 3]) -> bool {
    is_inside(p, [a, b, c])
        || is_inside(q, [a, b, c])
        || [(a, b), (b, c), (c, a)].into_iter().any(|(from, to)| segments_meet([p, q], [from, to]))
}

fn is_inside(p: Flat, [a, b, c]: [Flat; 3]) -> bool {
    let turns = [(a, b), (b, c), (c, a)].map(|(from, to)| orientation(from, to, p));
    !(turns.contains(&Ordering::Greater) && turns.contains(&Ordering::Less))
}

fn segments_meet([p, q]: [Flat; 2], [a, b]: [Flat; 2]) -> bool {
    let (at_a, at_b) = (orientation(p, q, a), orientation(p, q, b));
    let (at_p, at_q) = (orientation(a, b, p), orientation(a, b, q));
    if at_a == Ordering::Equal && at_b == Ordering::Equal {
        // On one line they meet where their ranges do, on both axes.
        return (0..2).all(|axis| {
            p[axis].min(q[axis]) <= a[axis].max(b[axis])
                && a[axis].min(b[axis]) <= p[axis].max(q[axis])
        });
    }
    let parts = |one: Ordering, other: Ordering| one != other || one == Ordering::Equal;
    parts(at_a, at_b) && parts(at_p, at_q)
}

/// Two axes on which a triangle has an area; `None` where it has none.
fn plane_of([a, b, c]: [PointMm; 3]) -> Option<[usize; 2]> {
    [[0, 1], [1, 2], [2, 0]].into_iter().find(|&axes| {
        let [a, b, c] = [a, b, c].map(|place| flat(place, axes));
        orientation(a, b, c).is_ne()
    })
}

fn flat(place: PointMm, [first, second]: [usize; 2]) -> Flat {
    [place[first], place[second]]
}

type Flat = [f64; 2];
