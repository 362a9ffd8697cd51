//! The points in a cell of the running map of an unknown surface: how far they lie from it, and how that changes with it.

use crate::PointMm;

/// The points of one cell of the map. Distances are along the normal, places are of the part frame.
#[derive(Clone, Copy, Debug)]
pub(super) struct MapCell {
    count: usize,
    /// Sums of the distances and of their squares.
    sum_mm: f64,
    square_mm2: f64,
    place_sum_mm: [f64; 2],
    /// Sums of the products of places with distances.
    beside_mm2: [f64; 2],
    /// Sums of x², x·y and y².
    spread_mm2: [f64; 3],
    low: Extreme,
    high: Extreme,
}

/// The farthest point on one side.
#[derive(Clone, Copy, Debug)]
pub(super) struct Extreme {
    pub(super) distance_mm: f64,
    /// Part frame.
    pub(super) place_mm: [f64; 2],
    /// Measured frame.
    pub(super) point: PointMm,
}

/// By how much distances change at a place, in mm, and the slopes of that change along x and y.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Change {
    pub(super) by_mm: f64,
    pub(super) slopes: [f64; 2],
}

impl MapCell {
    /// Of one point.
    pub(super) fn new(one: Extreme) -> MapCell {
        let Extreme { distance_mm, place_mm: [x, y], .. } = one;
        MapCell {
            count: 1,
            sum_mm: distance_mm,
            square_mm2: distance_mm * distance_mm,
            place_sum_mm: [x, y],
            beside_mm2: [x * distance_mm, y * distance_mm],
            spread_mm2: [x * x, x * y, y * y],
            low: one,
            high: one,
        }
    }

    /// The points of both; of points equally far out the one that is here stays.
    pub(super) fn merge(&mut self, other: &MapCell) {
        self.count += other.count;
        self.sum_mm += other.sum_mm;
        self.square_mm2 += other.square_mm2;
        self.place_sum_mm.iter_mut().zip(other.place_sum_mm).for_each(|(sum, part)| *sum += part);
        self.beside_mm2.iter_mut().zip(other.beside_mm2).for_each(|(sum, part)| *sum += part);
        self.spread_mm2.iter_mut().zip(other.spread_mm2).for_each(|(sum, part)| *sum += part);
        if other.low.distance_mm < self.low.distance_mm {
            self.low = other.low;
        }
        if other.high.distance_mm > self.high.distance_mm {
            self.high = other.high;
        }
    }

    /// These points about a surface that has moved: sums exactly where the change is a plane over the cell, extremes
    /// by the change at their own places.
    pub(super) fn moved(&self, change: impl Fn([f64; 2]) -> Change) -> MapCell {
        let count = self.count as f64;
        let [x, y] = self.centroid_mm();
        let Change { by_mm, slopes: [p, q] } = change([x, y]);
        // Of places about their mean: what a change that is 0 there adds to sums of places and distances.
        let [xx, xy, yy] = self.spread_mm2;
        let [xx, xy, yy] = [xx - count * x * x, xy - count * x * y, yy - count * y * y];
        let tilted = [xx * p + xy * q, xy * p + yy * q];
        let [xd, yd] = self.beside_mm2;
        let across = p * (xd - x * self.sum_mm) + q * (yd - y * self.sum_mm);
        let square = 2.0 * (by_mm * self.sum_mm + across)
            + count * by_mm * by_mm
            + p * tilted[0]
            + q * tilted[1];
        let moved = |extreme: Extreme| {
            let distance_mm = extreme.distance_mm + change(extreme.place_mm).by_mm;
            Extreme { distance_mm, ..extreme }
        };
        let [x_sum, y_sum] = self.place_sum_mm;
        MapCell {
            sum_mm: self.sum_mm + count * by_mm,
            square_mm2: (self.square_mm2 + square).max(0.0),
            beside_mm2: [xd + by_mm * x_sum + tilted[0], yd + by_mm * y_sum + tilted[1]],
            low: moved(self.low),
            high: moved(self.high),
            ..*self
        }
    }

    pub(super) fn count(&self) -> usize {
        self.count
    }

    pub(super) fn mean_mm(&self) -> f64 {
        self.sum_mm / self.count as f64
    }

    /// Mean square of the distances; by rounding never below that of their mean.
    pub(super) fn mean_square_mm2(&self) -> f64 {
        let mean_mm = self.mean_mm();
        (self.square_mm2 / self.count as f64).max(mean_mm * mean_mm)
    }

    pub(super) fn centroid_mm(&self) -> [f64; 2] {
        self.place_sum_mm.map(|sum| sum / self.count as f64)
    }

    pub(super) fn low(&self) -> Extreme {
        self.low
    }

    pub(super) fn high(&self) -> Extreme {
        self.high
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Moved by a plane, sums are those of the moved points.
    #[test]
    fn sums_move_with_a_plane() {
        let places = [[3.0, 1.0], [3.2, 1.1], [3.1, 0.8], [2.9, 1.3], [3.3, 1.0]];
        let at = |[x, y]: [f64; 2]| 0.2 - 0.3 * (x - 3.0) + 0.7 * (y - 1.0);
        let of = |distance: &dyn Fn(usize) -> f64| {
            let cells = places.iter().enumerate().map(|(index, &place_mm)| {
                let point = [place_mm[0], place_mm[1], 5.0];
                MapCell::new(Extreme { distance_mm: distance(index), place_mm, point })
            });
            cells.reduce(|mut all, cell| {
                all.merge(&cell);
                all
            })
        };
        let came = |index: usize| [0.01, -0.02, 0.005, 0.03, -0.01][index];
        let change = |place_mm: [f64; 2]| Change { by_mm: at(place_mm), slopes: [-0.3, 0.7] };
        let moved = of(&came).unwrap().moved(change);
        let anew = of(&|index| came(index) + at(places[index])).unwrap();
        for cell in [moved, moved.moved(|_| Change::default())] {
            assert!((cell.mean_mm() - anew.mean_mm()).abs() < 1e-14);
            assert!((cell.mean_square_mm2() - anew.mean_square_mm2()).abs() < 1e-14);
        }
        let back = moved.moved(|place_mm| {
            let Change { by_mm, slopes: [p, q] } = change(place_mm);
            Change { by_mm: -by_mm, slopes: [-p, -q] }
        });
        assert!((back.mean_square_mm2() - of(&came).unwrap().mean_square_mm2()).abs() < 1e-13);
        // Of the lowest and the highest as they came: those that overtake them are for the next time all are looked at.
        assert_eq!((moved.low().place_mm, moved.high().place_mm), (places[1], places[3]));
        assert!((moved.high().distance_mm - came(3) - at(places[3])).abs() < 1e-15);
        assert_eq!((moved.count(), moved.centroid_mm()), (5, of(&came).unwrap().centroid_mm()));
    }
}
