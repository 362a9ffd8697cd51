//! The slab between two corners that follow each other along x: sides go through it, and cross there or not.

use std::cmp::Reverse;
use std::collections::BinaryHeap;

use super::Side;

/// Areas of what both regions hold and of what either does, with what was crossed on the way.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Swept {
    pub(super) common: f64,
    pub(super) either: f64,
    /// How often sides of a region cross others of it.
    pub(super) own_crossings: [u64; 2],
}

/// A slab at work: its sides from below, as they lie at some x.
struct Slab<'a> {
    sides: &'a [Side],
    /// Heights of each side at the left and at the right end.
    heights: Vec<[f64; 2]>,
    ends: [f64; 2],
    /// The sides from below.
    order: Vec<usize>,
    place_of: Vec<usize>,
    /// The place of each side at the right end.
    last_of: Vec<usize>,
    /// Of the gap above each place of the order: since which x it has its sides, and in which regions it lies.
    gaps: Vec<(f64, [bool; 2])>,
    crossings: BinaryHeap<Reverse<Crossing>>,
}

/// Where a side meets the one above it.
#[derive(PartialEq)]
struct Crossing {
    x: f64,
    below: usize,
    above: usize,
}

impl Eq for Crossing {}

impl PartialOrd for Crossing {
    fn partial_cmp(&self, other: &Crossing) -> Option<std::cmp::Ordering> {
        Some(self.cmp(other))
    }
}

impl Ord for Crossing {
    fn cmp(&self, other: &Crossing) -> std::cmp::Ordering {
        self.x
            .total_cmp(&other.x)
            .then(self.below.cmp(&other.below))
            .then(self.above.cmp(&other.above))
    }
}

/// Adds the areas of a slab. Sides go through all of it; they are left as they lie at its right end, from below.
///
/// Time a·log a and log a for each crossing, of a sides. Two sides that lie beside each other change places until all lie as at the right end;
/// so rounding moves a crossing, and never loses one.
pub(super) fn sweep(sides: &mut [Side], ends: [f64; 2], least: f64, swept: &mut Swept) {
    let mut slab = Slab::new(sides, ends);
    while let Some(Reverse(Crossing { x, below, above })) = slab.crossings.pop() {
        if slab.place_of[below] + 1 == slab.place_of[above] {
            if slab.is_own_crossing(below, above, least) {
                swept.own_crossings[slab.sides[below].of] += 1;
            }
            slab.exchange(x, below, swept);
        }
    }
    (0..slab.order.len()).for_each(|place| slab.close(place, ends[1], swept));
    let sorted: Vec<Side> = slab.order.iter().map(|&side| sides[side]).collect();
    sides.copy_from_slice(&sorted);
}

impl Slab<'_> {
    fn new(sides: &[Side], ends: [f64; 2]) -> Slab<'_> {
        let heights: Vec<[f64; 2]> = sides.iter().map(|side| ends.map(|x| side.y_at(x))).collect();
        let by = |end: usize, sides: &mut Vec<usize>| {
            sides.sort_by(|&p, &q| heights[p][end].total_cmp(&heights[q][end]));
        };
        let mut order: Vec<usize> = (0..sides.len()).collect();
        by(1, &mut order);
        // Sides from one place on lie as they go on.
        by(0, &mut order);
        let mut last = order.clone();
        by(1, &mut last);
        let places = |order: &[usize]| {
            let mut places = vec![0; order.len()];
            (0..).zip(order).for_each(|(place, &side)| places[side] = place);
            places
        };
        let (place_of, last_of) = (places(&order), places(&last));
        let mut within = [false; 2];
        let gaps = order.iter().map(|&side| {
            within[sides[side].of] ^= true;
            (ends[0], within)
        });
        let gaps = gaps.collect();
        let crossings = BinaryHeap::new();
        let mut slab = Slab { sides, heights, ends, order, place_of, last_of, gaps, crossings };
        (0..sides.len()).for_each(|place| slab.look_above(place, ends[0]));
        slab
    }

    /// Whether two sides of one region cross, and not by rounding alone.
    fn is_own_crossing(&self, below: usize, above: usize, least: f64) -> bool {
        let apart = |end: usize| (self.heights[above][end] - self.heights[below][end]).abs();
        self.sides[below].of == self.sides[above].of && apart(0) > least && apart(1) > least
    }

    fn height(&self, side: usize, x: f64) -> f64 {
        let share = (x - self.ends[0]) / (self.ends[1] - self.ends[0]);
        let [from, to] = self.heights[side];
        from + share * (to - from)
    }

    /// Adds the area of the gap above a place up to x, where another begins.
    fn close(&mut self, place: usize, x: f64, swept: &mut Swept) {
        let Some(&above) = self.order.get(place + 1) else { return };
        let (since, within) = self.gaps[place];
        self.gaps[place].0 = x;
        if within == [false; 2] {
            return;
        }
        let below = self.order[place];
        // Sides are straight: the trapezium has the height in its middle.
        let middle = 0.5 * (since + x);
        let area = (self.height(above, middle) - self.height(below, middle)) * (x - since);
        swept.either += area;
        swept.common += if within == [true; 2] { area } else { 0.0 };
    }

    /// Lets a side and the one above it change places.
    fn exchange(&mut self, x: f64, below: usize, swept: &mut Swept) {
        let place = self.place_of[below];
        let above = self.order[place + 1];
        (place.saturating_sub(1)..place + 2).for_each(|place| self.close(place, x, swept));
        self.order.swap(place, place + 1);
        self.place_of.swap(below, above);
        for side in [below, above] {
            let of = self.sides[side].of;
            self.gaps[place].1[of] ^= true;
        }
        for place in place.saturating_sub(1)..place + 2 {
            self.look_above(place, x);
        }
    }

    /// Notes where the side at a place crosses the one above it, from x on.
    fn look_above(&mut self, place: usize, x: f64) {
        let Some(&[below, above]) = self.order.get(place..place + 2) else { return };
        if self.last_of[below] < self.last_of[above] {
            return;
        }
        let apart = |end: usize| self.heights[above][end] - self.heights[below][end];
        let [before, after] = [apart(0), apart(1)];
        let share = before / (before - after);
        let at = self.ends[0] + share * (self.ends[1] - self.ends[0]);
        // Sides that lie on each other cross anywhere.
        let at = if at.is_finite() { at.clamp(x, self.ends[1]) } else { x };
        self.crossings.push(Reverse(Crossing { x: at, below, above }));
    }
}
