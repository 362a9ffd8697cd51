//! The nearest neighbours of every point, kept up while points arrive.
//!
//! New points ask leaf by leaf: what may be near to any point of a leaf is gathered once. An earlier point takes a new one into its
//! list where it is nearer than the last. Of equal distances the smaller coordinates come first, so that lists depend on places alone.

use asphera_geometry::{BoxMm, PointMm};

use super::MOST_POINTS;
use super::normals::{NEAREST, Places as _};
use super::place_tree::{NewInLeaf, PlaceTree};
use crate::geometry::{gap, squared};

/// At most [`NEAREST`] points, the nearest first, then [`NONE`].
pub(super) type NearList = [u32; NEAREST];

/// Lists of all points.
#[derive(Clone, Debug, Default)]
pub(super) struct NearLists {
    lists: Vec<NearList>,
}

/// Memory of a thread between leaves.
#[derive(Default)]
pub(super) struct Room {
    radius_mm: f64,
    waiting: Vec<u32>,
    gathered: Vec<u32>,
    /// Places of the gathered points.
    places_mm: Vec<PointMm>,
    keys: Vec<u64>,
    /// The square of the distance of the last of the nearest, of the point before, mm².
    far_mm2: f64,
}

impl Room {
    /// Takes the places of what was gathered, without points farther from a box than the root of a limit.
    fn take_places(&mut self, tree: &PlaceTree, own: &BoxMm, limit_mm2: f64) {
        let points = tree.points_mm();
        self.places_mm.clear();
        self.gathered.retain(|&other| {
            let place = points[other as usize];
            let is_near = gap(&BoxMm { low: place, high: place }, own) <= limit_mm2;
            if is_near {
                self.places_mm.push(place);
            }
            is_near
        });
    }

    /// Takes keys of what was gathered, but for a point itself and what is farther from it than the root of a limit; gives how many.
    fn take_keys(&mut self, place: PointMm, at: u32, limit_mm2: f64) -> usize {
        // Written first and counted then: what is near is in no order that a processor could foresee.
        self.keys.resize(self.places_mm.len(), 0);
        let mut count = 0;
        for (&other, &point) in self.gathered.iter().zip(&self.places_mm) {
            let square = squared(place, point);
            self.keys[count] = square.to_bits() & !NUMBER | u64::from(other);
            count += usize::from(square <= limit_mm2 && other != at);
        }
        count
    }
}

impl NearLists {
    /// Makes room for so many points in all; gives the lists of the new ones, to be filled.
    pub(super) fn grow(&mut self, points: usize) -> &mut [NearList] {
        let before = self.lists.len();
        if before == 0 {
            // Memory that the threads which fill the lists are the first to touch.
            self.lists = vec![[0; NEAREST]; points];
        }
        self.lists.resize(points, [NONE; NEAREST]);
        &mut self.lists[before..]
    }

    /// The nearest of a point; fewer than [`NEAREST`] where there are no more.
    #[inline]
    pub(super) fn of(&self, at: u32) -> &[u32] {
        let list = &self.lists[at as usize];
        if list[NEAREST - 1] != NONE {
            return list;
        }
        let len = list.iter().position(|&other| other == NONE).unwrap_or(NEAREST);
        &list[..len]
    }

    /// Whether a point is among the nearest of another.
    #[inline]
    pub(super) fn has(&self, at: u32, other: u32) -> bool {
        self.lists[at as usize].contains(&other)
    }

    /// Takes new points into the list of an earlier one. Gives whether the list changed; `lost` gets what left it.
    pub(super) fn take(
        &mut self,
        tree: &PlaceTree,
        at: u32,
        new: impl Iterator<Item = u32>,
        lost: &mut Vec<u32>,
    ) -> bool {
        let points = tree.points_mm();
        let place = points[at as usize];
        let list = &mut self.lists[at as usize];
        let mut len = list.iter().position(|&other| other == NONE).unwrap_or(NEAREST);
        let mut squares_mm2 = [f64::INFINITY; NEAREST];
        for (square, &other) in squares_mm2.iter_mut().zip(&list[..len]) {
            *square = squared(place, points[other as usize]);
        }
        let mut is_changed = false;
        for other in new {
            let own = (squared(place, points[other as usize]), other);
            let is_before = |at: usize| tree.order(&own, &(squares_mm2[at], list[at])).is_lt();
            let mut to = len;
            while to > 0 && is_before(to - 1) {
                to -= 1;
            }
            if to == NEAREST {
                continue;
            }
            if len == NEAREST {
                lost.push(list[NEAREST - 1]);
            }
            len = NEAREST.min(len + 1);
            list.copy_within(to..len - 1, to + 1);
            squares_mm2.copy_within(to..len - 1, to + 1);
            (squares_mm2[to], list[to]) = own;
            is_changed = true;
        }
        is_changed
    }
}

/// Fills the lists of new points of a leaf. Gives `false` where several points lie too far from each other to ask together.
pub(super) fn ask_together(
    tree: &PlaceTree,
    new: NewInLeaf,
    room: &mut Room,
    lists: &mut [NearList],
) -> bool {
    let wanted = NEAREST.min(tree.len() - 1);
    let own = tree.about(new.from..new.to);
    let wide = (0..3).map(|axis| own.high[axis] - own.low[axis]).fold(0.0, f64::max);
    // What the last leaf asked for is a good start; of a single point nothing else is known.
    let mut radius = match (room.radius_mm > 0.0, wide > 0.0) {
        (true, true) => room.radius_mm.min(4.0 * wide),
        (true, false) => room.radius_mm,
        _ => tree.side_mm(new.from).max(f64::MIN_POSITIVE * 1e200),
    };
    let mut most = MOST_GATHERED;
    loop {
        room.gathered.clear();
        let found = (&mut room.waiting, &mut room.gathered);
        let is_whole = tree.gather(&own, radius * radius, most, found);
        if !is_whole {
            if new.to > new.from + 1 {
                return false;
            }
            most = usize::MAX;
        }
        let is_all = room.gathered.len() == tree.len();
        room.take_places(tree, &own, if is_all { f64::INFINITY } else { radius * radius });
        if room.places_mm.len() <= wanted {
            radius *= 2.0;
            continue;
        }
        // Of the point that is worst off.
        let mut farthest_mm2: f64 = 0.0;
        let mut before = None;
        for (at, to) in (new.from..new.to).zip(&mut *lists) {
            let (list, far_mm2) = select(tree, at, before, room);
            // The next one has as many about it: those of this one and this one itself.
            before = (wanted == NEAREST).then_some(at);
            farthest_mm2 = farthest_mm2.max(far_mm2);
            *to = list;
        }
        if is_all || is_whole && farthest_mm2 <= radius * radius {
            room.radius_mm = farthest_mm2.sqrt() * 1.05;
            return true;
        }
        radius = farthest_mm2.sqrt() * (1.0 + 1e-9);
    }
}

/// The nearest of what was gathered, and the square of the distance of the last, mm². `before` is the point that was asked before,
/// where it has all its neighbours among the same.
///
/// They are sorted as numbers: a square without its last bits, and the point in their place. Squares that differ in these bits alone
/// are put in order afterwards.
fn select(tree: &PlaceTree, at: u32, before: Option<u32>, room: &mut Room) -> (NearList, f64) {
    let points = tree.points_mm();
    let place = points[at as usize];
    // Few lie farther than the last of the point before: the fewer are sorted the better.
    let mut count = room.take_keys(place, at, FARTHER * room.far_mm2);
    if count < NEAREST {
        let limit_mm2 = before.map_or(f64::INFINITY, |before| {
            let reach_mm = room.far_mm2.sqrt() + squared(points[before as usize], place).sqrt();
            reach_mm * reach_mm * (1.0 + 1e-9)
        });
        count = room.take_keys(place, at, limit_mm2);
    }
    let keys = &mut room.keys[..count];
    keys.sort_unstable();
    let number = |key: u64| (key & NUMBER) as u32;
    let near = |key: u64| (squared(place, points[number(key) as usize]), number(key));
    let is_alike = |one: u64, other: u64| (one ^ other) & !NUMBER == 0;
    let pairs = keys.windows(2).take(NEAREST);
    if pairs.fold(false, |any, pair| any | is_alike(pair[0], pair[1])) {
        let mut first = 0;
        while first < keys.len().min(NEAREST) {
            let alike = keys[first..].iter().take_while(|&&key| is_alike(key, keys[first]));
            let next = first + alike.count();
            if next > first + 1 {
                keys[first..next].sort_unstable_by(|&a, &b| tree.order(&near(a), &near(b)));
            }
            first = next;
        }
    }
    let mut list = [NONE; NEAREST];
    for (to, &key) in list.iter_mut().zip(&*keys) {
        *to = number(key);
    }
    let last = keys[..count.min(NEAREST)].last();
    room.far_mm2 = last.map_or(0.0, |&key| near(key).0);
    (list, room.far_mm2)
}

/// How far the nearest of a point are looked for first, of the square of the distance of the last of the point before.
const FARTHER: f64 = 1.5;

/// The bits of a key that are the number of a point.
const NUMBER: u64 = (1 << 24) - 1;
const _: () =
    assert!(MOST_POINTS as u64 <= NUMBER, "a key must have room for the number of every point");
/// More points than any leaf needs that lies in a surface: so many are gathered where points are far from each other.
const MOST_GATHERED: usize = 600;
const NONE: u32 = u32::MAX;

#[cfg(test)]
mod tests {
    use rand_core::{Rng as _, SeedableRng as _};
    use rand_pcg::Pcg64;

    use super::*;
    use crate::neighbours::Neighbours;

    /// Places in clusters of very different spacing, and a lattice full of equal distances.
    fn places() -> Vec<PointMm> {
        let mut random = Pcg64::seed_from_u64(11);
        let mut uniform = || (random.next_u64() >> 11) as f64 * 2_f64.powi(-53);
        let mut places: Vec<PointMm> = Vec::new();
        for size in [1e-6, 1.0, 1e7] {
            places.extend(
                (0..300).map(|_| [size * uniform(), size * uniform(), 0.1 * size * uniform()]),
            );
        }
        places.extend((0..400).map(|at| [f64::from(at % 20), f64::from(at / 20) - 30.0, 5.0]));
        places
    }

    #[test]
    fn lists_that_take_batches_are_those_of_a_tree_of_all_points() {
        let places = places();
        for size in [1, 7, 100, 1300] {
            let (mut tree, mut lists) = (PlaceTree::default(), NearLists::default());
            let mut room = Room::default();
            for (batch, first) in places.chunks(size).zip((0_u32..).step_by(size)) {
                let before = tree.len() as u32;
                let mut batch: Vec<_> = batch.iter().copied().zip(first..).collect();
                let inserted = tree.insert(&mut batch);
                let mut new = lists.grow(tree.len());
                for own in inserted.leaves {
                    let (filled, others) = new.split_at_mut(own.len() as usize);
                    new = others;
                    if !ask_together(&tree, own, &mut room, filled) {
                        for (from, list) in (own.from..own.to).zip(filled.chunks_mut(1)) {
                            let own = NewInLeaf { from, to: from + 1 };
                            assert!(ask_together(&tree, own, &mut room, list));
                        }
                    }
                }
                for at in 0..before {
                    lists.take(&tree, at, before..tree.len() as u32, &mut Vec::new());
                }
            }
            let all = Neighbours::of(places.iter().copied().zip(0..).collect());
            let expected = all.map_nearest(NEAREST, |at, near, _: &mut ()| {
                let near = near.iter().map(|&(_, other)| all.ids[other as usize]);
                (all.ids[at as usize], near.collect::<Vec<_>>())
            });
            let mut found: Vec<(u32, Vec<u32>)> = (0..tree.len() as u32)
                .map(|at| {
                    let near = lists.of(at).iter().map(|&other| tree.ids[other as usize]);
                    (tree.ids[at as usize], near.collect())
                })
                .collect();
            found.sort_unstable();
            let mut expected = expected;
            expected.sort_unstable();
            assert_eq!(found, expected, "batches of {size}");
        }
    }
}
