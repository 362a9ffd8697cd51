//! The samples by the cells of a grid over the surface, and the moments of each cell.

use asphera_geometry::{BoundsMm, PointMm, VertexId, place};

use super::{DefectsUnknown, Samples};

/// Most cells of the grid for each point: beyond, nearly all are empty.
const CELLS_PER_POINT: f64 = 16.0;
const CELLS_MIN: f64 = 4096.0;
/// The terms of a quartic.
pub(super) const QUARTIC: usize = 15;
/// Where the power a of x and b of y stands among the terms: by order, then by b.
const PLACES: [[usize; 5]; 5] = [
    [0, 2, 5, 9, 14],
    [1, 4, 8, 13, NO_TERM],
    [3, 7, 12, NO_TERM, NO_TERM],
    [6, 11, NO_TERM, NO_TERM, NO_TERM],
    [10, NO_TERM, NO_TERM, NO_TERM, NO_TERM],
];
const NO_TERM: usize = usize::MAX;
const BINOMIALS: [[f64; 5]; 5] = [
    [1.0, 0.0, 0.0, 0.0, 0.0],
    [1.0, 1.0, 0.0, 0.0, 0.0],
    [1.0, 2.0, 1.0, 0.0, 0.0],
    [1.0, 3.0, 3.0, 1.0, 0.0],
    [1.0, 4.0, 6.0, 4.0, 1.0],
];
/// No cell.
pub(super) const NONE: u32 = u32::MAX;

/// The samples, sorted by the cells of a grid that hold any.
pub(super) struct Cells {
    pub(super) low_mm: [f64; 2],
    pub(super) extent_mm: [f64; 2],
    pub(super) side_mm: f64,
    pub(super) size: [usize; 2],
    /// By place in the grid, which of the occupied cells it is, or [`NONE`].
    index: Vec<u32>,
    /// Column and row of each occupied cell.
    pub(super) places: Vec<[u32; 2]>,
    starts: Vec<u32>,
    members: Vec<VertexId>,
    pub(super) moments: Vec<Moments>,
}

/// The means over the samples of a cell of what a quartic is made of.
#[derive(Clone, Copy, Default)]
pub(super) struct Moments {
    pub(super) count: f64,
    /// Means of the terms in u and v, sides of a cell from its centre.
    powers: [f64; QUARTIC],
    /// Mean of the heights over the datum.
    pub(super) height_mm: f64,
}

/// Most cells of a grid over so many points.
pub(super) fn most(points: usize) -> f64 {
    CELLS_PER_POINT * points as f64 + CELLS_MIN
}

/// What is looked at: heights or deviations.
pub(super) fn height_mm(samples: &Samples<'_>, vertex: VertexId) -> f64 {
    match samples.deviations_mm {
        Some(deviations_mm) => deviations_mm[vertex as usize],
        None => samples.points[vertex as usize][2],
    }
}

impl Cells {
    /// Sorts those vertices that are `used` into cells of a side in mm.
    pub(super) fn new(
        samples: &Samples<'_>,
        used: &[bool],
        side_mm: f64,
    ) -> Result<Cells, DefectsUnknown> {
        let vertices =
            || (0..samples.points.len() as VertexId).filter(|&vertex| used[vertex as usize]);
        let bounds =
            BoundsMm::about(vertices().map(|vertex| place(samples.points[vertex as usize])));
        let (low, extent_mm) = (bounds.low, bounds.size_mm());
        let points = vertices().count();
        let counts = extent_mm.map(|extent| (extent / side_mm).floor() + 1.0);
        if counts[0] * counts[1] > most(points) {
            return Err(DefectsUnknown::Scattered { side_mm, extent_mm, points });
        }
        let size = counts.map(|count| count as usize);
        let mut cells = Cells {
            low_mm: low,
            extent_mm,
            side_mm,
            size,
            index: vec![NONE; size[0] * size[1]],
            places: Vec::new(),
            starts: vec![0],
            members: vec![0; points],
            moments: Vec::new(),
        };
        cells.sort(samples.points, vertices);
        cells.moments = (0..cells.len()).map(|cell| cells.moments_of(samples, cell)).collect();
        Ok(cells)
    }

    fn sort<V: Iterator<Item = VertexId>>(&mut self, points: &[PointMm], vertices: impl Fn() -> V) {
        let mut counts = vec![0_u32; self.index.len()];
        for vertex in vertices() {
            counts[self.slot(points[vertex as usize])] += 1;
        }
        let mut total = 0;
        for (slot, &count) in counts.iter().enumerate() {
            if count > 0 {
                self.index[slot] = self.places.len() as u32;
                self.places.push([(slot % self.size[0]) as u32, (slot / self.size[0]) as u32]);
                total += count;
                self.starts.push(total);
            }
        }
        let mut next: Vec<u32> = self.starts.clone();
        for vertex in vertices() {
            let cell = self.index[self.slot(points[vertex as usize])] as usize;
            self.members[next[cell] as usize] = vertex;
            next[cell] += 1;
        }
    }

    fn slot(&self, point: PointMm) -> usize {
        let [column, row] = [0, 1].map(|axis| {
            let cell = ((point[axis] - self.low_mm[axis]) / self.side_mm) as usize;
            cell.min(self.size[axis] - 1)
        });
        row * self.size[0] + column
    }

    /// How many cells hold samples.
    pub(super) fn len(&self) -> usize {
        self.places.len()
    }

    /// The occupied cell at a column and row; `None` if it is empty or off the grid.
    pub(super) fn at(&self, column: i64, row: i64) -> Option<usize> {
        let inside = |index: i64, axis: usize| (0..self.size[axis] as i64).contains(&index);
        if !inside(column, 0) || !inside(row, 1) {
            return None;
        }
        let cell = self.index[row as usize * self.size[0] + column as usize];
        (cell != NONE).then_some(cell as usize)
    }

    /// The occupied cell about a place.
    pub(super) fn around(&self, place_mm: [f64; 2]) -> Option<usize> {
        let [column, row] =
            [0, 1].map(|axis| ((place_mm[axis] - self.low_mm[axis]) / self.side_mm).floor() as i64);
        self.at(column, row)
    }

    /// Where the samples of cells lie among all, cell by cell.
    pub(super) fn range(&self, cell: usize) -> std::ops::Range<usize> {
        self.starts[cell] as usize..self.starts[cell + 1] as usize
    }

    /// The samples of a cell.
    pub(super) fn members(&self, cell: usize) -> &[VertexId] {
        &self.members[self.range(cell)]
    }

    /// The samples, cell by cell.
    pub(super) fn all(&self) -> &[VertexId] {
        &self.members
    }

    /// Centre of a cell in mm.
    pub(super) fn centre_mm(&self, cell: usize) -> [f64; 2] {
        let place = self.places[cell];
        [0, 1].map(|axis| self.low_mm[axis] + (f64::from(place[axis]) + 0.5) * self.side_mm)
    }

    fn moments_of(&self, samples: &Samples<'_>, cell: usize) -> Moments {
        let centre = self.centre_mm(cell);
        let mut powers = [0.0; QUARTIC];
        let mut height_mm = 0.0;
        for &vertex in self.members(cell) {
            let [x, y, _] = samples.points[vertex as usize];
            let [u, v] = [(x - centre[0]) / self.side_mm, (y - centre[1]) / self.side_mm];
            let terms = quartic(u, v);
            powers.iter_mut().zip(terms).for_each(|(sum, term)| *sum += term);
            height_mm += self::height_mm(samples, vertex);
        }
        let count = self.members(cell).len() as f64;
        Moments { count, powers: powers.map(|sum| sum / count), height_mm: height_mm / count }
    }
}

/// The terms of a quartic: 1, x, y, x², xy, y², and so on.
pub(super) fn quartic(x: f64, y: f64) -> [f64; QUARTIC] {
    let (xx, xy, yy) = (x * x, x * y, y * y);
    [
        1.0,
        x,
        y,
        xx,
        xy,
        yy,
        x * xx,
        xx * y,
        x * yy,
        y * yy,
        xx * xx,
        xx * xy,
        xx * yy,
        xy * yy,
        yy * yy,
    ]
}

impl Moments {
    /// Means over the cell of the terms of a quartic in coordinates in which the cell's centre lies at
    /// x, y and its side is `side`: products of (x + side·u)ᵃ and (y + side·v)ᵇ, multiplied out.
    pub(super) fn terms(&self, x: f64, y: f64, side: f64) -> [f64; QUARTIC] {
        let powers = |of: f64| [1.0, of, of * of, of * of * of, of * of * of * of];
        let [xs, ys, sides] = [powers(x), powers(y), powers(side)];
        let mut along = [[0.0; 5]; 5];
        for a in 0..5 {
            for j in 0..5 - a {
                along[a][j] = (0..=a)
                    .map(|i| BINOMIALS[a][i] * xs[a - i] * sides[i + j] * self.powers[PLACES[i][j]])
                    .sum();
            }
        }
        let mut terms = [0.0; QUARTIC];
        for a in 0..5 {
            for b in 0..5 - a {
                terms[PLACES[a][b]] =
                    (0..=b).map(|j| BINOMIALS[b][j] * ys[b - j] * along[a][j]).sum();
            }
        }
        terms
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The mean of a quartic over a cell is that of its values at the samples.
    #[test]
    fn means_of_terms_are_those_of_the_samples() {
        let places = [[0.3, -0.2], [-0.4, 0.1], [0.25, 0.45], [0.0, 0.5]];
        let mut moments = Moments { count: 4.0, ..Moments::default() };
        let (x, y, side) = (0.7, -1.3, 0.125);
        let mut means = [0.0; QUARTIC];
        for [u, v] in places {
            let add = |sums: &mut [f64], terms: &[f64]| {
                sums.iter_mut().zip(terms).for_each(|(sum, term)| *sum += term / 4.0);
            };
            add(&mut moments.powers, &quartic(u, v));
            add(&mut means, &quartic(x + side * u, y + side * v));
        }
        for (found, mean) in moments.terms(x, y, side).into_iter().zip(means) {
            assert!((found - mean).abs() < 1e-14, "{found} {mean}");
        }
    }
}
