//! The outer layer of sheets: of each part that hangs together by edges.

use std::collections::VecDeque;

use asphera_geometry::{PointMm, Sets};

use super::sheets::Sheets;
use crate::geometry::{cross, dot, minus, scaled, unit};

/// A facet seen from a side: its corners turn counter-clockwise.
type Seen = (u32, [u32; 3]);

/// The facets of the outer layer.
pub(super) fn outer(sheets: &Sheets<'_>) -> Vec<[u32; 3]> {
    let mut is_taken = vec![false; sheets.facets.len()];
    let mut layer = Vec::new();
    for (facet, corners) in starts(sheets) {
        let mut front = VecDeque::from([(facet, corners)]);
        is_taken[facet as usize] = true;
        while let Some((facet, [a, b, c])) = front.pop_front() {
            layer.push([a, b, c]);
            for (from, to, third) in [(a, b, c), (b, c, a), (c, a, b)] {
                // Through the outer side the turn goes left about the way from one corner to the next.
                let next = sheets.next(facet, corner_of(sheets, facet, third), from < to);
                if !is_taken[next.facet as usize] && has_room(sheets, &is_taken, next.facet) {
                    is_taken[next.facet as usize] = true;
                    front.push_back((next.facet, [to, from, next.third]));
                }
            }
        }
    }
    layer
}

fn corner_of(sheets: &Sheets<'_>, facet: u32, corner: u32) -> usize {
    sheets.facets[facet as usize].iter().position(|&at| at == corner).unwrap_or(0)
}

/// Whether no edge of a facet has two facets of the layer already.
fn has_room(sheets: &Sheets<'_>, is_taken: &[bool], facet: u32) -> bool {
    let taken = |corner: usize| {
        sheets.ring(facet, corner).iter().filter(|fin| is_taken[fin.facet as usize]).count()
    };
    (0..3).all(|corner| taken(corner) < 2)
}

/// Of each part a facet that is seen from the outside: at its last vertex by coordinates, at the edge there that makes the least angle with
/// the x axis. No facet of the part passes between both.
fn starts(sheets: &Sheets<'_>) -> Vec<Seen> {
    let count = sheets.facets.len();
    let mut parts = Sets::new(count);
    for facet in (0..count).filter(|&facet| sheets.is_present[facet]) {
        for corner in 0..3 {
            for fin in sheets.present(facet as u32, corner) {
                parts.join(facet, fin.facet as usize);
            }
        }
    }
    // Vertices are in the order of coordinates. Of each part the last, and the facets there.
    let mut last: Vec<(u32, Vec<u32>)> = vec![(0, Vec::new()); count];
    for facet in (0..count).filter(|&facet| sheets.is_present[facet]) {
        let vertex = sheets.facets[facet][2];
        let (best, facets) = &mut last[parts.root(facet)];
        if facets.is_empty() || vertex > *best {
            *best = vertex;
            facets.clear();
        }
        if vertex == *best {
            facets.push(facet as u32);
        }
    }
    let parts = last.into_iter().filter(|(_, facets)| !facets.is_empty());
    parts.filter_map(|(vertex, facets)| start(sheets, vertex, &facets)).collect()
}

fn start(sheets: &Sheets<'_>, vertex: u32, facets: &[u32]) -> Option<Seen> {
    let place = |at: u32| sheets.places_mm[at as usize];
    let way = |to: u32| minus(place(to), place(vertex));
    let others = facets.iter().flat_map(|&facet| {
        let corners = sheets.facets[facet as usize];
        [(facet, 0, corners[0]), (facet, 1, corners[1])]
    });
    let steepness = |to: u32| unit(way(to)).map_or(f64::NEG_INFINITY, |way: PointMm| way[0]);
    let (facet, corner, to) = others.max_by(|one, other| {
        steepness(one.2).total_cmp(&steepness(other.2)).then(one.2.cmp(&other.2))
    })?;
    // The edge from the vertex to `to` is opposite the third corner of the facet.
    let ring: Vec<_> = sheets.present(facet, 1 - corner).copied().collect();
    let axis = unit(way(to))?;
    let across = |out: PointMm| minus(out, scaled(axis, dot(out, axis)));
    let right = across([1.0, 0.0, 0.0]);
    let up = cross(axis, right);
    // The first that a turn from the x axis meets, to the left about the way from the vertex.
    let turn = |third: u32| {
        let out = across(way(third));
        dot(out, up).atan2(dot(out, right)).rem_euclid(std::f64::consts::TAU)
    };
    let turns: Vec<f64> = ring.iter().map(|fin| turn(fin.third)).collect();
    let mut first = (0..ring.len()).min_by(|&one, &other| turns[one].total_cmp(&turns[other]))?;
    // The ring is in exact order, the angles are not: of facets at one angle the first of the turn. The ring turns to the left about the
    // way to the vertex, which comes last by coordinates.
    for _ in 1..ring.len() {
        let before = (first + 1) % ring.len();
        let gap = (turns[first] - turns[before] + ROUNDING).rem_euclid(std::f64::consts::TAU);
        if gap > 2.0 * ROUNDING {
            break;
        }
        first = before;
    }
    // Met by a turn to the left, it is seen with the edge backwards.
    Some((ring[first].facet, [to, vertex, ring[first].third]))
}

/// Angles nearer than this count as one.
const ROUNDING: f64 = 1e-6;
