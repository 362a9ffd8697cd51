//! Pruning of facets with a sharp edge: one at which two facets that follow each other are more than 270° apart.
//!
//! Taking a facet away makes edges sharper only, so what stays does not depend on the order.

use std::f64::consts::{PI, TAU};

use crate::geometry::{cross, dot, minus, scaled, unit};
use crate::rings::{FacetSet, Turn, turns};
use crate::sampling::radius_mm;

/// Removes facets of which no corner is flat, as lids of holes, and facets with a sharp edge until there are none.
pub(super) fn sharp(set: &mut FacetSet<'_>, flat: &[bool]) {
    lids(set, flat);
    let mut doubtful: Vec<(u32, usize)> = set.all().collect();
    let mut angles = Vec::new();
    while let Some((cell, slot)) = doubtful.pop() {
        if !set.has(cell, slot)
            || !turns(cell, slot).any(|turn| is_sharp(set, turn, flat, &mut angles))
        {
            continue;
        }
        set.remove(cell, slot);
        for turn in turns(cell, slot) {
            set.about(turn, |turn| doubtful.push((turn.cell, turn.ahead)));
        }
    }
}

/// Removes facets of which no corner is flat and whose circle is wide beside those of the facets of flat points there: they close
/// the border of an open surface as a lid.
fn lids(set: &mut FacetSet<'_>, flat: &[bool]) {
    let delaunay = set.delaunay;
    let mut means = vec![(0.0, 0.0); flat.len()];
    let mut doubtful = Vec::new();
    for (cell, slot) in set.all() {
        let corners = delaunay.facet(cell, slot);
        let radius_mm = radius_mm(corners.map(|corner| delaunay.place(corner)));
        if corners.iter().all(|&corner| !flat[corner as usize]) {
            doubtful.push((cell, slot, corners, radius_mm));
            continue;
        }
        for corner in corners {
            let (sum, count) = &mut means[corner as usize];
            *sum += radius_mm;
            *count += 1.0;
        }
    }
    for (cell, slot, corners, radius_mm) in doubtful {
        let mean = |&corner: &u32| {
            let (sum, count) = means[corner as usize];
            if count > 0.0 { sum / count } else { f64::INFINITY }
        };
        if radius_mm > LID * corners.iter().map(mean).fold(0.0, f64::max) {
            set.remove(cell, slot);
        }
    }
}

fn is_sharp(set: &FacetSet<'_>, start: Turn, flat: &[bool], angles: &mut Vec<f64>) -> bool {
    let delaunay = set.delaunay;
    let ends = start.edge(delaunay);
    if ends.iter().any(|&end| !flat[end as usize]) {
        return false;
    }
    let [from, to] = ends.map(|end| delaunay.place(end));
    let Some(axis) = unit(minus(to, from)) else { return false };
    angles.clear();
    let mut frame = None;
    set.about(start, |turn| {
        // The third corner of the facet that the turn crosses.
        let third = delaunay.corners[turn.cell as usize][turn.behind];
        let way = minus(delaunay.place(third), from);
        let across = minus(way, scaled(axis, dot(way, axis)));
        let (right, up) = *frame.get_or_insert_with(|| (across, cross(axis, across)));
        // `up` is as long as `right`.
        angles.push(dot(across, up).atan2(dot(across, right)));
    });
    angles.sort_unstable_by(f64::total_cmp);
    if angles.len() < 2 {
        return turns(start.cell, start.behind).any(|turn| count(set, turn) > 2);
    }
    let (Some(first), Some(last)) = (angles.first(), angles.last()) else { return true };
    let around = first + TAU - last;
    let widest = angles.windows(2).map(|pair| pair[1] - pair[0]).fold(around, f64::max);
    widest > SHARP
}

fn count(set: &FacetSet<'_>, turn: Turn) -> usize {
    let mut count = 0;
    set.about(turn, |_| count += 1);
    count
}

pub(super) const SHARP: f64 = 1.5 * PI;
/// A lid's circle is wider than the mean at its corners by so much.
pub(super) const LID: f64 = 3.0;
