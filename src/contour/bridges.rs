//! Edges of a chain that bridge a stretch without points.

use crate::PlaceMm;
use crate::triangulation::distance_mm;

/// The edges of a chain that are far longer than those about them, by the place where each begins; in order.
///
/// About an edge are up to [`ABOUT`] edges before it and as many after it. An edge is far longer if its length is above [`TIMES`] times their
/// mean, and above their mean and [`SPREADS`] times their standard deviation. So points at random have few such edges, and where the
/// spacing changes from one stretch to the next there are none.
pub(crate) fn far_edges(places_mm: &[PlaceMm], is_closed: bool) -> Vec<usize> {
    let count = places_mm.len();
    let edges = if is_closed { count } else { count.saturating_sub(1) };
    let lengths_mm: Vec<f64> = (0..edges)
        .map(|from| distance_mm(places_mm[from], places_mm[(from + 1) % count]))
        .collect();
    let is_far = |&index: &usize| {
        let reach = if is_closed { ABOUT.min((edges - 1) / 2) } else { ABOUT };
        let about = (1..=reach).flat_map(|step| {
            let [before, after] = match is_closed {
                true => [Some((index + edges - step) % edges), Some((index + step) % edges)],
                false => [index.checked_sub(step), Some(index + step).filter(|it| *it < edges)],
            };
            before.into_iter().chain(after)
        });
        let (number, sum, squares) = about.fold((0.0, 0.0, 0.0), |(number, sum, squares), it| {
            let length_mm: f64 = lengths_mm[it];
            (number + 1.0, sum + length_mm, squares + length_mm * length_mm)
        });
        let mean_mm = sum / number;
        let spread_mm = (squares / number - mean_mm * mean_mm).max(0.0).sqrt();
        let most_mm = (TIMES * mean_mm).max(mean_mm + SPREADS * spread_mm);
        number >= LEAST_ABOUT && lengths_mm[index] > most_mm
    };
    (0..edges).filter(is_far).collect()
}

/// How far the way of a chain turns over an edge, in radians: from the places [`BESIDE`] edges before it to the edge, and from there to those
/// after it, each taken above 0.
pub(crate) fn turn_over(places_mm: &[PlaceMm], is_closed: bool, from: usize) -> f64 {
    let count = places_mm.len();
    let last = count - 1;
    let to = (from + 1) % count;
    let [before, after] = match is_closed {
        true => [(from + count - BESIDE.min(last)) % count, (to + BESIDE) % count],
        false => [from.saturating_sub(BESIDE), (to + BESIDE).min(last)],
    };
    let way = |from: usize, to: usize| {
        let [p, q] = [places_mm[from], places_mm[to]];
        [q[0] - p[0], q[1] - p[1]]
    };
    let turn =
        |[ux, uy]: [f64; 2], [vx, vy]: [f64; 2]| (ux * vy - uy * vx).abs().atan2(ux * vx + uy * vy);
    let over = way(from, to);
    // A way without length turns by 0.
    turn(way(before, from), over) + turn(over, way(to, after))
}

/// Turn over an edge up to which points beside it show the way between them, radians: 15°. An arc over such an edge differs from its chord by less than
/// 0.07 of the edge.
pub(crate) const SHOWN_TURN: f64 = 0.26;
/// Edges on either side that an edge is compared with.
const ABOUT: usize = 8;
/// Least edges that an edge is compared with.
const LEAST_ABOUT: f64 = 6.0;
/// Length of a far edge over the mean of those about it.
const TIMES: f64 = 3.0;
/// Standard deviations by which a far edge is above that mean.
const SPREADS: f64 = 5.0;
/// Edges beside an edge by which the way there goes.
const BESIDE: usize = 3;

#[cfg(test)]
mod tests {
    use super::*;

    fn arc(count: usize, turn: f64) -> Vec<PlaceMm> {
        let angle = |index: usize| turn * index as f64 / (count - 1) as f64;
        (0..count).map(angle).map(|angle| [5.0 * angle.cos(), 5.0 * angle.sin()]).collect()
    }

    #[test]
    fn the_chord_of_an_arc_is_far_and_turns() {
        for (turn, far) in [(3.5, true), (5.9, true), (std::f64::consts::TAU * 59.0 / 60.0, false)]
        {
            let places = arc(60, turn);
            assert_eq!(far_edges(&places, true), if far { vec![59] } else { vec![] }, "{turn}");
            assert!(far_edges(&places, false).is_empty());
            let gap = std::f64::consts::TAU - turn;
            assert!(turn_over(&places, true, 59) > gap, "{turn}");
        }
    }

    #[test]
    fn a_change_of_spacing_is_no_gap() {
        let sparse = (0..4).map(|x| [10.0 * f64::from(x), 0.0]);
        let dense = (1..40).map(|x| [30.0 + f64::from(x), 0.0]);
        let places: Vec<PlaceMm> = sparse.chain(dense).collect();
        assert!(far_edges(&places, false).is_empty());
        assert!(far_edges(&places[3..], false).is_empty());
        assert_eq!(far_edges(&places[2..], false), [0]);
        assert_eq!(turn_over(&places[2..], false, 0), 0.0);
    }
}
