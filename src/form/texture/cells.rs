//! Places sorted into square cells, to find those near a place.

/// Indices of places by cell. Invariant: `order` holds each index once, ascending in each cell.
pub(super) struct Cells<'a> {
    places_mm: &'a [[f64; 2]],
    low_mm: [f64; 2],
    side_mm: f64,
    columns: usize,
    rows: usize,
    /// Where in `order` each cell begins; one more than there are cells.
    begins: Vec<usize>,
    order: Vec<usize>,
}

impl Cells<'_> {
    /// Cells for finding what lies within a positive radius. `O(n)`.
    pub(super) fn new(places_mm: &[[f64; 2]], radius_mm: f64) -> Cells<'_> {
        let end = |start: f64, pick: fn(f64, f64) -> f64| {
            [0, 1].map(|axis| places_mm.iter().map(|place| place[axis]).fold(start, pick))
        };
        let (low, high) = (end(f64::INFINITY, f64::min), end(f64::NEG_INFINITY, f64::max));
        let empty = places_mm.is_empty();
        let low_mm = if empty { [0.0; 2] } else { low };
        let size = if empty { [0.0; 2] } else { [high[0] - low[0], high[1] - low[1]] };
        // Wider cells than the radius if there would be more cells than places.
        let most = (places_mm.len() as f64).sqrt().ceil().max(1.0);
        let side_mm = radius_mm.max(size[0].max(size[1]) / most);
        let count = |axis: usize| (size[axis] / side_mm) as usize + 1;
        let mut cells = Cells {
            places_mm,
            low_mm,
            side_mm,
            columns: count(0),
            rows: count(1),
            begins: Vec::new(),
            order: vec![0; places_mm.len()],
        };
        let of: Vec<usize> = places_mm.iter().map(|&place| cells.cell(place)).collect();
        let mut begins = vec![0; cells.columns * cells.rows + 1];
        of.iter().for_each(|&cell| begins[cell + 1] += 1);
        for cell in 1..begins.len() {
            begins[cell] += begins[cell - 1];
        }
        let mut next = begins.clone();
        for (index, &cell) in of.iter().enumerate() {
            cells.order[next[cell]] = index;
            next[cell] += 1;
        }
        cells.begins = begins;
        cells
    }

    /// Indices of the places in the cell of a place of the list and in those around it, always in the same
    /// order: all within the radius are among them.
    pub(super) fn near(&self, place: [f64; 2]) -> impl Iterator<Item = usize> + '_ {
        let [column, row] = self.column_and_row(place);
        let (left, right) = (column.saturating_sub(1), (column + 2).min(self.columns));
        (row.saturating_sub(1)..(row + 2).min(self.rows)).flat_map(move |row| {
            // Cells of one row follow one another.
            let begin = self.begins[row * self.columns + left];
            let end = self.begins[row * self.columns + right];
            self.order[begin..end].iter().copied()
        })
    }

    pub(super) fn place(&self, index: usize) -> [f64; 2] {
        self.places_mm[index]
    }

    fn cell(&self, place: [f64; 2]) -> usize {
        let [column, row] = self.column_and_row(place);
        row * self.columns + column
    }

    fn column_and_row(&self, place: [f64; 2]) -> [usize; 2] {
        let at = |axis: usize, count: usize| {
            (((place[axis] - self.low_mm[axis]) / self.side_mm) as usize).min(count - 1)
        };
        [at(0, self.columns), at(1, self.rows)]
    }
}

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
        assert_eq!(Cells::new(&[], 1.0).near([0.0; 2]).count(), 0);
    }
}
