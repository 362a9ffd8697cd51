//! Whether closed lines meet themselves or each other.

use std::cmp::Ordering;

use crate::predicates::{Place, orientation};

/// A side of a closed line.
struct Side {
    line: usize,
    /// Its number along the line.
    index: usize,
    ends: [Place; 2],
}

/// The lines and the beginning of two sides that share more than the corner between them.
///
/// Sides are taken by their smallest x; only those whose ranges of x overlap are compared.
pub(super) fn meeting(rings: &[Vec<Place>]) -> Option<([usize; 2], Place)> {
    let mut sides: Vec<Side> = Vec::new();
    for (line, ring) in rings.iter().enumerate() {
        for index in 0..ring.len() {
            let ends = [ring[index], ring[(index + 1) % ring.len()]];
            sides.push(Side { line, index, ends });
        }
    }
    let low = |side: &Side| side.ends[0][0].min(side.ends[1][0]);
    let high = |side: &Side| side.ends[0][0].max(side.ends[1][0]);
    sides.sort_by(|left, right| {
        low(left)
            .total_cmp(&low(right))
            .then((left.line, left.index).cmp(&(right.line, right.index)))
    });
    for (at, side) in sides.iter().enumerate() {
        let reached = high(side);
        for other in sides[at + 1..].iter().take_while(|other| low(other) <= reached) {
            if meet(side, other, rings) {
                let (first, second) =
                    if side.line <= other.line { (side, other) } else { (other, side) };
                return Some(([first.line, second.line], first.ends[0]));
            }
        }
    }
    None
}

fn meet(side: &Side, other: &Side, rings: &[Vec<Place>]) -> bool {
    let ([a, b], [c, d]) = (side.ends, other.ends);
    if side.line == other.line {
        let count = rings[side.line].len();
        if (side.index + 1) % count == other.index {
            return folds_back(a, b, d);
        }
        if (other.index + 1) % count == side.index {
            return folds_back(c, d, b);
        }
    }
    let turns = [orientation(a, b, c), orientation(a, b, d)];
    let returns = [orientation(c, d, a), orientation(c, d, b)];
    let apart = |turns: [Ordering; 2]| turns[0] != Ordering::Equal && turns[0] == turns[1];
    // On one line neither is apart from the other by turning: their ranges decide.
    !apart(turns)
        && !apart(returns)
        && (0..2).all(|axis| {
            let range = |p: Place, q: Place| [p[axis].min(q[axis]), p[axis].max(q[axis])];
            let ([low, high], [other_low, other_high]) = (range(a, b), range(c, d));
            low <= other_high && other_low <= high
        })
}

/// Whether the way from `b` to `c` leads back over the one from `a` to `b`.
fn folds_back(a: Place, b: Place, c: Place) -> bool {
    if orientation(a, b, c) != Ordering::Equal {
        return false;
    }
    let axis = usize::from(a[0] == b[0]);
    (a[axis] < b[axis]) == (c[axis] < b[axis])
}
