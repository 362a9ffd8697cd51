//! Places sorted into square cells, to find those near a place.

use asphera_geometry::BoundsMm;

/// Indices of places by cell. Cells without a place cost nothing, so that a place far from all others does no
/// harm. Invariant: `order` holds each index once, by cell, ascending in each.
pub(super) struct Cells<'a> {
    places_mm: &'a [[f64; 2]],
    low_mm: [f64; 2],
    side_mm: f64,
    /// Row and column of the cell, and the index of the place.
    order: Vec<([i64; 2], usize)>,
}

impl Cells<'_> {
    /// Cells for finding what lies within a positive radius. `O(n log n)`.
    pub(super) fn new(places_mm: &[[f64; 2]], radius_mm: f64) -> Cells<'_> {
        let low_mm = [0, 1]
            .map(|axis| places_mm.iter().map(|place| place[axis]).reduce(f64::min).unwrap_or(0.0));
        let side_mm = MARGIN * radius_mm;
        let mut cells = Cells { places_mm, low_mm, side_mm, order: Vec::new() };
        cells.order =
            places_mm.iter().map(|&place| cells.cell(place)).zip(0..places_mm.len()).collect();
        cells.order.sort_unstable();
        cells
    }

    /// Indices of the places in the cell of a place and in those around it, always in the same order: all
    /// within the radius are among them. `O(log n)` beside them.
    pub(super) fn near(&self, place: [f64; 2]) -> impl Iterator<Item = usize> + '_ {
        let [row, column] = self.cell(place);
        (row - 1..=row + 1).flat_map(move |row| {
            // Cells of one row follow one another.
            let begin = self.order.partition_point(|(cell, _)| *cell < [row, column - 1]);
            let cells = self.order[begin..].iter();
            cells.take_while(move |(cell, _)| *cell <= [row, column + 1]).map(|&(_, index)| index)
        })
    }

    pub(super) fn place(&self, index: usize) -> [f64; 2] {
        self.places_mm[index]
    }

    /// Row and column, at most the largest a float counts exactly.
    fn cell(&self, place: [f64; 2]) -> [i64; 2] {
        [1, 0].map(|axis| {
            ((place[axis] - self.low_mm[axis]) / self.side_mm).min(MOST_CELLS).floor() as i64
        })
    }
}

/// Lowest and highest x and y of places; `None` without any.
pub(super) fn box_of(places_mm: impl Iterator<Item = [f64; 2]>) -> Option<[[f64; 2]; 2]> {
    BoundsMm::about(places_mm).corners()
}

/// Side of a cell in radii: so much more that rounding does not move what is within the radius beyond the
/// next cell.
const MARGIN: f64 = 1.001;
/// 2⁵³.
const MOST_CELLS: f64 = 9_007_199_254_740_992.0;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn all_places_within_the_radius_are_near() {
        let places: Vec<[f64; 2]> = (0..400)
            .map(|i| {
                [f64::from(i * 7919 % 1000) * 0.01 + 5e3, f64::from(i * 104_729 % 997) * 0.002]
            })
            .collect();
        for radius_mm in [1e-9, 0.05, 0.4, 100.0] {
            let cells = Cells::new(&places, radius_mm);
            for (index, &[x, y]) in places.iter().enumerate() {
                let near: Vec<usize> = cells.near([x, y]).collect();
                assert!(near.contains(&index));
                let within = |&i: &usize| (places[i][0] - x).hypot(places[i][1] - y) <= radius_mm;
                assert!((0..400).filter(within).all(|i| near.contains(&i)), "{radius_mm} {index}");
            }
        }
        let far = [[0.0, 0.0], [1e50, 1e-9], [0.1, 0.0], [1e50, 0.0]];
        assert_eq!(Cells::new(&far, 0.5).near(far[0]).collect::<Vec<_>>(), [0, 2]);
        assert_eq!(Cells::new(&far, 1e-8).near(far[1]).collect::<Vec<_>>(), [1, 3]);
        assert_eq!(Cells::new(&[], 1.0).near([0.0; 2]).count(), 0);
    }
}
