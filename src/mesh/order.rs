//! The order in which a batch of points is inserted: its two ends first, then by bisection.
//!
//! Inserting a scan line from one end to the other is the worst case of incremental Delaunay: the
//! newest point sees the whole last line, so each insertion tears down a fan of as many triangles
//! as the line has points and builds it anew. With both ends in first, the hull edge between them
//! covers the last line and only ever gets split. Bisection depth first keeps each new point next
//! to one that has just been inserted, in the mesh and in memory.

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
    let first = (len > 0).then_some(Step { index: 0, near: None });
    let last = (len > 1).then(|| Step { index: len - 1, near: Some(0) });
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
    first.into_iter().chain(last).chain(inner)
}

/// The indices of places in an order that keeps near ones together: by the squares of a grid over
/// all of them, row by row, every other row backwards.
pub(crate) fn by_place(places: impl ExactSizeIterator<Item = Place> + Clone) -> Vec<usize> {
    let (mut low, mut high) = ([f64::INFINITY; 2], [f64::NEG_INFINITY; 2]);
    for [x, y] in places.clone() {
        low = [low[0].min(x), low[1].min(y)];
        high = [high[0].max(x), high[1].max(y)];
    }
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
    order
}

/// Such an order cut in rounds: every fourth, of those every fourth, and so on down to a few, the fewest first.
pub(crate) fn in_rounds(order: &[usize]) -> Vec<Vec<usize>> {
    let mut rounds = Vec::new();
    let mut left = order.to_vec();
    while left.len() > SPREAD * SPREAD {
        let (next, round) =
            left.iter().enumerate().partition::<Vec<_>, _>(|(at, _)| at % SPREAD == 0);
        rounds.push(round.into_iter().map(|(_, &index)| index).collect());
        left = next.into_iter().map(|(_, &index)| index).collect();
    }
    rounds.push(left);
    rounds.reverse();
    rounds
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
                assert_eq!(step.near.is_none(), step.index == 0);
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

    /// Every index once, rounds in the order given, and each about four times as long as those before it in all.
    #[test]
    fn rounds_have_every_index_once_and_grow_fourfold() {
        assert_eq!(in_rounds(&[]), [[0_usize; 0]]);
        let order: Vec<usize> = (0..1000).map(|index| 7 * index % 1000).collect();
        let rounds = in_rounds(&order);
        let at = |index: usize| order.iter().position(|&other| other == index).unwrap();
        for round in &rounds {
            assert!(round.is_sorted_by_key(|&index| at(index)));
        }
        let mut all = rounds.concat();
        all.sort_unstable();
        assert!(all.into_iter().eq(0..1000));
        let lengths: Vec<usize> = rounds.iter().map(Vec::len).collect();
        assert_eq!(lengths, [16, 47, 187, 750]);
    }

    #[test]
    fn takes_the_ends_first() {
        let order: Vec<usize> = by_bisection(6).map(|step| step.index).collect();
        assert_eq!(order, [0, 5, 2, 1, 3, 4]);
    }
}
