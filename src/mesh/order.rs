//! The order in which a batch of points is inserted: its two ends first, the last one before the first, then by bisection.
//!
//! Inserting a scan line from one end to the other is the worst case of incremental Delaunay: the
//! newest point sees the whole last line, so each insertion tears down a fan of as many triangles
//! as the line has points and builds it anew. With both ends in first, the hull edge between them
//! covers the last line and only ever gets split. Bisection depth first keeps each new point next
//! to one that has just been inserted, in the mesh and in memory.
//!
//! Along a curve about an empty region the last point is a corner of most triangles across the region. What is
//! inserted before it would build them, and it would tear them down.

use asphera_geometry::BoundsMm;
use std::ops::Range;

use asphera_geometry::predicates::Place;

/// One step of the order.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Step {
    /// Index within the batch of the point to insert.
    pub(crate) index: usize,
    /// Index of a point of the batch inserted earlier, near in arrival and so probably in place.
    pub(crate) near: Option<usize>,
}

/// The order for a batch of `len` points: each index once, and `near` always earlier.
pub(crate) fn by_bisection(len: usize) -> impl Iterator<Item = Step> {
    let last = (len > 1).then(|| Step { index: len - 1, near: None });
    let first = (len > 0).then_some(Step { index: 0, near: None });
    let mut open = vec![(0, len.saturating_sub(1))];
    let inner = std::iter::from_fn(move || {
        loop {
            let (from, to) = open.pop()?;
            if to - from > 1 {
                let middle = from + (to - from) / 2;
                open.push((middle, to));
                open.push((from, middle));
                return Some(Step { index: middle, near: Some(from) });
            }
        }
    });
    last.into_iter().chain(first).chain(inner)
}

/// The indices of places in an order that keeps near ones together: by the squares of a grid over
/// all of them, row by row, every other row backwards, and within a crowded square in the same way.
pub(crate) fn by_place(places: impl ExactSizeIterator<Item = Place> + Clone) -> Vec<usize> {
    let (mut order, bounds) = by_squares(places.clone());
    let crowded: Vec<Range<usize>> = bounds
        .windows(2)
        .map(|pair| pair[0] as usize..pair[1] as usize)
        .filter(|square| square.len() > CROWD)
        .collect();
    if !crowded.is_empty() {
        let places: Vec<Place> = places.collect();
        crowded.into_iter().for_each(|square| refine(&places, &mut order[square]));
    }
    order
}

/// Indices of places, in order of arrival, along the lines they trace by turns, one line after the other. `None` where
/// that way is longer than the one by place, or its steps are longer than the `longest` on average.
pub(crate) fn along_lines(
    indices: &[usize],
    lines: usize,
    longest: f64,
    place: impl Fn(usize) -> Place,
) -> Option<Vec<usize>> {
    let mut order = indices.to_vec();
    order.sort_by_key(|index| index % lines);
    let step = |pair: &[usize]| {
        let [p, q] = [place(pair[0]), place(pair[1])];
        (q[0] - p[0]).hypot(q[1] - p[1])
    };
    let way: f64 = order.windows(2).map(step).sum();
    let [width, height] = BoundsMm::about(order.iter().map(|&index| place(index))).size_mm();
    // By place it goes along every row of squares, and up once.
    let rows = (order.len() as f64).sqrt();
    (way <= (rows * width + height).min(longest * order.len() as f64)).then_some(order)
}

/// Brings the indices of places of a crowded square into such an order.
fn refine(places: &[Place], indices: &mut [usize]) {
    // Squares within squares, on a stack of its own: far from all others there may be many, one in another.
    let mut open = vec![indices];
    while let Some(indices) = open.pop() {
        let (order, bounds) = by_squares(indices.iter().map(|&index| places[index]));
        let sorted: Vec<usize> = order.into_iter().map(|at| indices[at]).collect();
        indices.copy_from_slice(&sorted);
        let mut rest = indices;
        for pair in bounds.windows(2) {
            let (square, after) = rest.split_at_mut((pair[1] - pair[0]) as usize);
            rest = after;
            // Of many points in one place none is nearer than another.
            if square.len() > CROWD
                && square.iter().any(|&index| places[index] != places[square[0]])
            {
                open.push(square);
            }
        }
    }
}

/// The indices of places by the squares of one grid, and where in that order each square begins, and the last ends.
fn by_squares(places: impl ExactSizeIterator<Item = Place> + Clone) -> (Vec<usize>, Vec<u32>) {
    let BoundsMm { low, high } = BoundsMm::about(places.clone());
    let side = places.len().isqrt();
    let scale = [0, 1].map(|axis| side as f64 / (high[axis] - low[axis]).max(f64::MIN_POSITIVE));
    let square = |place: Place| {
        let index = |axis: usize| ((place[axis] - low[axis]) * scale[axis]) as usize;
        let [column, row] = [0, 1].map(|axis| index(axis).min(side));
        row * (side + 1) + if row % 2 == 0 { column } else { side - column }
    };
    let squares: Vec<u32> = places.map(|place| square(place) as u32).collect();
    // Sorted by counting: the next place of square i goes to `next[i]`.
    let mut next = vec![0_u32; (side + 1) * (side + 1) + 1];
    for &square in &squares {
        next[square as usize + 1] += 1;
    }
    for square in 1..next.len() {
        next[square] += next[square - 1];
    }
    let mut order = vec![0; squares.len()];
    for (index, &square) in squares.iter().enumerate() {
        let next = &mut next[square as usize];
        order[*next as usize] = index;
        *next += 1;
    }
    // Where each begins is by now where the one before it ended.
    next.rotate_right(1);
    next[0] = 0;
    (order, next)
}

/// More points in a square are a crowd; one to a few are the rule.
const CROWD: usize = 32;

/// Indices of places in order of arrival cut in two: the ends of the curves they trace, the last one first, and the others.
///
/// Curves traced by turns have one end each, so those of the last places are ends that lie far from one another.
pub(crate) fn ends_and_others(
    indices: &[usize],
    place: impl Fn(usize) -> Place,
) -> (Vec<usize>, Vec<usize>) {
    let count = (indices.len() / FOR_AN_END).min(MOST_ENDS);
    if count == 0 {
        return (Vec::new(), indices.to_vec());
    }
    let BoundsMm { low, high } = BoundsMm::about(indices.iter().map(|&index| place(index)));
    let distance = |p: Place, q: Place| (p[0] - q[0]).abs().max((p[1] - q[1]).abs());
    let far = distance(low, high) * FAR_ENDS;
    let (before, tail) = indices.split_at(indices.len() - count);
    let (mut ends, mut others): (Vec<usize>, Vec<usize>) = (Vec::new(), before.to_vec());
    for &index in tail.iter().rev() {
        let is_far = |&end: &usize| distance(place(end), place(index)) > far;
        if ends.iter().all(is_far) { ends.push(index) } else { others.push(index) }
    }
    others[before.len()..].reverse();
    (ends, others)
}

/// How many points of a batch there are for each that may be an end.
const FOR_AN_END: usize = 32;

/// Curves traced by turns of which the ends are found.
const MOST_ENDS: usize = 16;

/// Ends lie farther from one another than such a share of the longer side of the box about all points.
const FAR_ENDS: f64 = 1.0 / 16.0;

/// Such an order cut in rounds: every fourth, of those every fourth, and so on down to a few, the fewest first.
///
/// Along a curve each point tears down most of what lies between those beside it that are in. So the few go in by
/// bisection, and of three between two others the middle one goes first.
pub(crate) fn in_rounds(order: &[usize]) -> Vec<Vec<usize>> {
    let mut rounds = Vec::new();
    let mut left = order.to_vec();
    while left.len() > SPREAD * SPREAD {
        let next = left.iter().copied().step_by(SPREAD).collect();
        let mut round = Vec::with_capacity(left.len() - left.len() / SPREAD);
        for group in left.chunks(SPREAD) {
            match *group {
                [_, first, middle, last] => round.extend([middle, first, last]),
                _ => round.extend(&group[1..]),
            }
        }
        rounds.push(round);
        left = next;
    }
    rounds.push(by_bisection(left.len()).map(|step| left[step.index]).collect());
    rounds.reverse();
    rounds
}

/// A round but the first cut in two: the middle ones of its groups, so that those before it and they are every second
/// point, and the others.
pub(crate) fn middles_and_others(round: &[usize]) -> [Vec<usize>; 2] {
    let groups = round.chunks(SPREAD - 1);
    [
        groups.clone().map(|group| group[0]).collect(),
        groups.flat_map(|group| &group[1..]).copied().collect(),
    ]
}

/// Points of a round for each of those before it, and one.
const SPREAD: usize = 4;

/// Such an order cut in two, below the y of the one in the middle and from there on.
pub(crate) fn in_two(order: &[usize], place: impl Fn(usize) -> Place) -> (f64, [Vec<usize>; 2]) {
    let y = order.get(order.len() / 2).map_or(0.0, |&index| place(index)[1]);
    let (below, from): (Vec<usize>, Vec<usize>) =
        order.iter().partition(|&&index| place(index)[1] < y);
    (y, [below, from])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn visits_each_point_once_and_only_points_to_earlier_ones() {
        for len in [0, 1, 2, 3, 4, 5, 7, 64, 1000, 1024] {
            let mut visited = vec![false; len];
            for step in by_bisection(len) {
                assert!(!visited[step.index], "{len}: {} twice", step.index);
                assert!(step.near.is_none_or(|near| visited[near]), "{len}: {step:?}");
                assert_eq!(step.near.is_none(), step.index == 0 || step.index == len - 1);
                visited[step.index] = true;
            }
            assert!(visited.into_iter().all(|visited| visited), "{len}");
        }
    }

    #[test]
    fn goes_by_rows_there_and_back() {
        // The grid has rows 0 to 4, of which row 3 stays empty.
        let places: Vec<Place> =
            (0..16).map(|i: u8| [f64::from(i % 4), f64::from(i / 4)]).collect();
        let reversed = by_place(places.iter().rev().copied());
        assert_eq!(reversed, [15, 14, 13, 12, 8, 9, 10, 11, 7, 6, 5, 4, 3, 2, 1, 0]);
        // Of places in one square the first comes first.
        assert_eq!(by_place([[1.0, 2.0]; 3].into_iter()), [0, 1, 2]);
        assert_eq!(by_place([[1e12, -1e12], [-1e12, 1e12]].into_iter()), [0, 1]);
        assert_eq!(by_place(std::iter::empty()), []);
    }

    #[test]
    fn a_crowd_within_a_square_is_ordered_as_all_are() {
        // Two far squares of a hundred places, by turns: each row by row in turn.
        let places: Vec<Place> = (0..200)
            .map(|i: u8| {
                let (column, row) = (i / 2 % 10, i / 20);
                [column, row].map(|on| f64::from(on) + 1e6 * f64::from(i % 2))
            })
            .collect();
        let order = by_place(places.iter().copied());
        let mut all = order.clone();
        all.sort_unstable();
        assert!(all.into_iter().eq(0..200));
        let far = order.windows(2).filter(|pair| {
            let [p, q] = [places[pair[0]], places[pair[1]]];
            (p[0] - q[0]).hypot(p[1] - q[1]) > 3.0
        });
        assert!(far.count() < 6, "{order:?}");
        // Places of which none is nearer than another come to an end.
        assert_eq!(by_place([[1.0, 2.0]; 100].into_iter()), Vec::from_iter(0..100));
        let halves = (0..1000).map(|i| [0.5_f64.powi(i % 500), 0.0]);
        assert_eq!(by_place(halves).len(), 1000);
    }

    /// Every index once, rounds in the order given, and each about four times as long as those before it in all.
    #[test]
    fn rounds_have_every_index_once_and_grow_fourfold() {
        assert_eq!(in_rounds(&[]), [[0_usize; 0]]);
        let order: Vec<usize> = (0..1000).map(|index| 7 * index % 1000).collect();
        let rounds = in_rounds(&order);
        let at = |index: usize| order.iter().position(|&other| other == index).unwrap();
        for round in &rounds[1..] {
            // Of three between two others the middle one is the first.
            let threes = round.chunks(3).map(|three| match *three {
                [middle, first, last] => [first, middle, last].map(at).to_vec(),
                _ => three.iter().map(|&index| at(index)).collect(),
            });
            assert!(threes.flatten().is_sorted());
        }
        let mut all = rounds.concat();
        all.sort_unstable();
        assert!(all.into_iter().eq(0..1000));
        let lengths: Vec<usize> = rounds.iter().map(Vec::len).collect();
        assert_eq!(lengths, [16, 47, 187, 750]);
    }

    #[test]
    fn lines_by_turns_are_followed_one_after_the_other() {
        let line = |index: usize| [(index / 2) as f64, 40.0 * (index % 2) as f64];
        let indices: Vec<usize> = (0..100).filter(|index| *index != 7).collect();
        let order = along_lines(&indices, 2, 2.0, line).expect("the lines are the shorter way");
        let lines = [0, 1].map(|line| indices.iter().copied().filter(move |i| i % 2 == line));
        assert_eq!(order, lines.into_iter().flatten().collect::<Vec<_>>());
        assert_eq!(along_lines(&indices, 2, 0.5, line), None, "the steps are longer");
        assert_eq!(along_lines(&[], 1, 2.0, line), Some(Vec::new()));
    }

    /// Lines of a comb are longer than the way along rows of squares over all of it.
    #[test]
    fn lines_that_are_the_longer_way_are_not_followed() {
        let comb = |teeth: usize| {
            let per_tooth = 1000 / teeth;
            move |index: usize| {
                [index / per_tooth * per_tooth, index % per_tooth * teeth].map(|on| on as f64)
            }
        };
        let indices: Vec<usize> = (0..1000).collect();
        let is_followed = |teeth| along_lines(&indices, 1, f64::MAX, comb(teeth)).is_some();
        assert!(is_followed(10));
        assert!(!is_followed(200));
    }

    #[test]
    fn takes_the_ends_first() {
        let order: Vec<usize> = by_bisection(6).map(|step| step.index).collect();
        assert_eq!(order, [5, 0, 2, 1, 3, 4]);
    }

    /// One end of one curve, two of two by turns; and every index once.
    #[test]
    fn ends_are_those_of_the_curves_and_the_last_one_comes_first() {
        let of = |places: &[Place]| {
            let indices: Vec<usize> = (0..places.len()).collect();
            let (ends, others) = ends_and_others(&indices, |index| places[index]);
            assert!(others.is_sorted());
            let mut all = [&ends[..], &others].concat();
            all.sort_unstable();
            assert_eq!(all, indices);
            ends
        };
        let line: Vec<Place> = (0..1000).map(|i| [f64::from(i), 0.5 * f64::from(i)]).collect();
        assert_eq!(of(&line), [999]);
        let by_turns: Vec<Place> =
            (0..1000).map(|i| [f64::from(i / 2), 400.0 * f64::from(i % 2)]).collect();
        assert_eq!(of(&by_turns), [999, 998]);
        // Too few for a curve to have an end, and all in one place.
        assert_eq!(of(&line[..31]), []);
        assert_eq!(of(&line[..32]), [31]);
        assert_eq!(of(&[[1.0, 2.0]; 100]), [99]);
        assert_eq!(of(&[]), []);
    }
}
