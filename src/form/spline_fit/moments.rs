//! Sums of products of splines over points: what a penalised fit needs of them, whatever their number.

use super::band::Band;
use super::{LEAST_USED, System, penalty, spline_weights};
use crate::shape::Cells;

/// The normal equations of the splines of a net, about a surface they have already.
#[derive(Clone, Debug)]
pub(super) struct Moments {
    net: Cells,
    /// Of the residuals along z, whose squares are to be least.
    along_z: Sums,
    /// Of the residuals along the normal: what an RMS is of.
    along_normal: Sums,
    /// Points in each cell.
    counts: Vec<u32>,
    used: usize,
}

/// Sums over points of residuals r, each with a weight w.
#[derive(Clone, Debug)]
struct Sums {
    /// Σw·B·Bᵀ: for every spline its products with those not after it, `NEIGHBOURS` of them, seven a row.
    products: Vec<[f64; NEIGHBOURS]>,
    /// Σw·B·r.
    along: Vec<f64>,
    /// Σw·r².
    square: f64,
}

/// The splines at one place of a net.
#[derive(Clone, Copy, Debug)]
pub(super) struct Place {
    cell: usize,
    /// Index of the first of four splines in the first of four rows.
    first: usize,
    /// Splines in a row of the net.
    columns: usize,
    /// Values of the four along x and along y.
    values: [[f64; 4]; 2],
    /// Their slopes, in 1/mm.
    slopes_per_mm: [[f64; 4]; 2],
}

/// A part of the cells of a net.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Part {
    /// First cell along x and along y.
    first: [usize; 2],
    /// Cells along x and along y.
    count: [usize; 2],
}

impl Moments {
    pub(super) fn new(net: Cells) -> Moments {
        let sums = Sums::new(net.splines());
        let counts = vec![0; net.nx * net.ny];
        Moments { net, along_z: sums.clone(), along_normal: sums, counts, used: 0 }
    }

    pub(super) fn net(&self) -> &Cells {
        &self.net
    }

    pub(super) fn used(&self) -> usize {
        self.used
    }

    /// Adds the residual along z at a place, and the cosine of the slope there. `O(1)`.
    pub(super) fn add(&mut self, place: &Place, residual_mm: f64, cosine: f64) {
        self.used += 1;
        self.counts[place.cell] = self.counts[place.cell].saturating_add(1);
        let splines = place.splines();
        self.along_z.add(&splines, residual_mm, 1.0);
        self.along_normal.add(&splines, residual_mm, cosine * cosine);
    }

    /// The sums of another of the same net and surface.
    pub(super) fn merge(&mut self, other: &Moments) {
        self.along_z.merge(&other.along_z);
        self.along_normal.merge(&other.along_normal);
        let counts = self.counts.iter_mut().zip(&other.counts);
        counts.for_each(|(sum, part)| *sum = sum.saturating_add(*part));
        self.used += other.used;
    }

    /// Moves the surface by a change of the coefficients of all splines: the sums become what they were if the points
    /// had been added about it, but for the slopes.
    pub(super) fn move_by(&mut self, change_mm: &[f64]) {
        self.along_z.move_by(self.net.nx + 3, change_mm);
        self.along_normal.move_by(self.net.nx + 3, change_mm);
    }

    /// Sum of the squares of the residuals along z, in mm².
    pub(super) fn square_in_z_mm2(&self) -> f64 {
        self.along_z.square
    }

    /// Sum of the squares of the residuals along the normal, in mm², after a change of all coefficients.
    pub(super) fn square_mm2(&self, change_mm: &[f64]) -> f64 {
        self.along_normal.moved(self.net.nx + 3, change_mm).1
    }

    /// The cells between the outermost that hold points; `None` without points.
    pub(super) fn occupied(&self) -> Option<Part> {
        let cells = self.counts.iter().enumerate().filter(|(_, count)| **count > 0);
        let places = cells.map(|(cell, _)| [cell % self.net.nx, cell / self.net.nx]);
        let (low, high) = places.fold(([usize::MAX; 2], [0; 2]), |(low, high), place| {
            ([0, 1].map(|k| low[k].min(place[k])), [0, 1].map(|k| high[k].max(place[k])))
        });
        (self.used > 0).then(|| Part { first: low, count: [0, 1].map(|k| high[k] - low[k] + 1) })
    }

    /// Whether each cell of a part holds a point.
    pub(super) fn holding(&self, part: &Part) -> Vec<bool> {
        part.cells_of(&self.net).map(|cell| self.counts[cell] > 0).collect()
    }

    /// The penalised problem of a part, whose splines it numbers as [`Part::splines`] does; `None` with too few points.
    /// `O(splines)`, whatever the number of points.
    pub(super) fn system(&self, part: &Part, coefficients_mm: &[f64]) -> Option<System> {
        if self.used < LEAST_USED {
            return None;
        }
        let splines = part.splines(&self.net);
        let [columns, rows] = part.sides();
        let mut gram = Band::new(splines.len(), 3 * columns + 3);
        for (own, &spline) in splines.iter().enumerate() {
            let (row, column) = (own / columns, own % columns);
            for other_row in row.saturating_sub(3)..=row {
                let last = if other_row == row { column } else { (column + 3).min(columns - 1) };
                for other_column in column.saturating_sub(3)..=last {
                    let other = other_row * columns + other_column;
                    gram.add(own, other, self.product(spline, splines[other]));
                }
            }
        }
        let penalty = penalty(columns, rows);
        Some(System {
            unit: gram.trace() / penalty.trace(),
            gram,
            penalty,
            begin_mm: splines.iter().map(|&spline| coefficients_mm[spline]).collect(),
            along: splines.iter().map(|&spline| self.along_z.along[spline]).collect(),
            square: self.along_z.square,
            used: self.used,
        })
    }

    /// The sum of the products of two splines.
    fn product(&self, a: usize, b: usize) -> f64 {
        let (late, early) = (a.max(b), a.min(b));
        let columns = self.net.nx + 3;
        let down = late / columns - early / columns;
        // From 0, three columns to the right of the late one, to 6.
        let across = 3 + late % columns - early % columns;
        self.along_z.products[late][7 * down + across]
    }
}

impl Sums {
    fn new(splines: usize) -> Sums {
        Sums { products: vec![[0.0; NEIGHBOURS]; splines], along: vec![0.0; splines], square: 0.0 }
    }

    fn add(&mut self, splines: &[(usize, f64); 16], residual: f64, weight: f64) {
        self.square += weight * residual * residual;
        for (k, &(index, value)) in splines.iter().enumerate() {
            let value = weight * value;
            self.along[index] += value * residual;
            let products = &mut self.products[index];
            for (l, &(_, beside)) in splines[..=k].iter().enumerate() {
                products[neighbour(k, l)] += value * beside;
            }
        }
    }

    fn merge(&mut self, other: &Sums) {
        for (own, others) in self.products.iter_mut().zip(&other.products) {
            own.iter_mut().zip(others).for_each(|(sum, part)| *sum += part);
        }
        self.along.iter_mut().zip(&other.along).for_each(|(sum, part)| *sum += part);
        self.square += other.square;
    }

    fn move_by(&mut self, columns: usize, change: &[f64]) {
        let (products, square) = self.moved(columns, change);
        self.along.iter_mut().zip(products).for_each(|(along, product)| *along -= product);
        self.square = square;
    }

    /// Σw·B·Bᵀ·c and Σw·(r − Bᵀ·c)², for a change c of the coefficients of splines in rows of so many.
    fn moved(&self, columns: usize, change: &[f64]) -> (Vec<f64>, f64) {
        let mut products = vec![0.0; change.len()];
        for (late, own) in self.products.iter().enumerate() {
            for (k, &product) in own.iter().enumerate().filter(|(_, product)| **product != 0.0) {
                let early = late + 3 - (k / 7 * columns + k % 7);
                products[late] += product * change[early];
                if early != late {
                    products[early] += product * change[late];
                }
            }
        }
        let sums = change.iter().zip(&products).zip(&self.along);
        let lost: f64 = sums.map(|((c, product), along)| c * (product - 2.0 * along)).sum();
        (products, (self.square + lost).max(0.0))
    }
}

impl Place {
    /// `None` outside the net.
    pub(super) fn of(net: &Cells, x_mm: f64, y_mm: f64) -> Option<Place> {
        let (cell, [u, v]) = net.at(x_mm, y_mm)?;
        let ([along, along_slopes, _], [across, across_slopes, _]) =
            (spline_weights(u), spline_weights(v));
        let slopes_per_mm = [
            along_slopes.map(|slope| slope / net.step_x_mm),
            across_slopes.map(|slope| slope / net.step_y_mm),
        ];
        let (first, columns) = (net.first_spline(cell), net.nx + 3);
        Some(Place { cell, first, columns, values: [along, across], slopes_per_mm })
    }

    /// Height in mm and slopes of the surface that splines of these coefficients are.
    pub(super) fn height(&self, coefficients_mm: &[f64]) -> (f64, [f64; 2]) {
        let (mut height_mm, mut slopes) = (0.0, [0.0; 2]);
        for row in 0..4 {
            let coefficients_mm = &coefficients_mm[self.first + row * self.columns..][..4];
            let sum = |weights: &[f64; 4]| -> f64 {
                coefficients_mm.iter().zip(weights).map(|(own, weight)| own * weight).sum()
            };
            let value_mm = sum(&self.values[0]);
            height_mm += self.values[1][row] * value_mm;
            slopes[0] += self.values[1][row] * sum(&self.slopes_per_mm[0]);
            slopes[1] += self.slopes_per_mm[1][row] * value_mm;
        }
        (height_mm, slopes)
    }

    /// Index and value of the splines, ascending.
    fn splines(&self) -> [(usize, f64); 16] {
        let [along, across] = &self.values;
        let spline =
            |k: usize| (self.first + k / 4 * self.columns + k % 4, across[k / 4] * along[k % 4]);
        std::array::from_fn(spline)
    }
}

impl Part {
    pub(super) fn cells(&self, net: &Cells) -> Cells {
        Cells {
            x_min_mm: net.x_min_mm + self.first[0] as f64 * net.step_x_mm,
            y_min_mm: net.y_min_mm + self.first[1] as f64 * net.step_y_mm,
            nx: self.count[0],
            ny: self.count[1],
            ..*net
        }
    }

    /// The cells of a net that others with the same knots have, too.
    pub(super) fn common(net: &Cells, others: &Cells) -> Part {
        let axis = |min: [f64; 2], step: f64, count: [usize; 2]| {
            let from = ((min[1] - min[0]) / step).round() as i64;
            let first = from.clamp(0, count[0] as i64 - 1);
            let end = (from + count[1] as i64).clamp(first + 1, count[0] as i64);
            [first as usize, (end - first) as usize]
        };
        let x = axis([net.x_min_mm, others.x_min_mm], net.step_x_mm, [net.nx, others.nx]);
        let y = axis([net.y_min_mm, others.y_min_mm], net.step_y_mm, [net.ny, others.ny]);
        Part { first: [x[0], y[0]], count: [x[1], y[1]] }
    }

    /// The coefficients of the splines of the part among those of the net, row after row with x running faster.
    pub(super) fn coefficients(&self, net: &Cells, all: &[f64]) -> Vec<f64> {
        let [nx, ny] = self.count.map(|cells| cells + 3);
        let first = |row: usize| (self.first[1] + row) * (net.nx + 3) + self.first[0];
        (0..ny).flat_map(|row| &all[first(row)..][..nx]).copied().collect()
    }

    /// Values for the splines of the net that are `values` for those of the part, as [`Part::splines`] numbers them, and
    /// 0 for the others.
    pub(super) fn spread(&self, net: &Cells, values: &[f64]) -> Vec<f64> {
        let mut all = vec![0.0; net.splines()];
        for (spline, value) in self.splines(net).into_iter().zip(values) {
            all[spline] = *value;
        }
        all
    }

    /// How many cells of the net lie beyond the part to the left and to the right, below and above.
    pub(super) fn margins(&self, net: &Cells) -> [[usize; 2]; 2] {
        let beyond =
            |axis: usize, all: usize| [self.first[axis], all - self.first[axis] - self.count[axis]];
        [beyond(0, net.nx), beyond(1, net.ny)]
    }

    /// The splines of the part by their numbers in the net. Rows go along the shorter side: the band of a problem is as
    /// wide as three of them.
    fn splines(&self, net: &Cells) -> Vec<usize> {
        let [columns, rows] = self.sides();
        let numbers = (0..rows).flat_map(|row| (0..columns).map(move |column| [column, row]));
        let place = |[column, row]: [usize; 2]| {
            let [i, j] = if self.is_wide() { [row, column] } else { [column, row] };
            (self.first[1] + j) * (net.nx + 3) + self.first[0] + i
        };
        numbers.map(place).collect()
    }

    /// Splines in a row, and rows.
    fn sides(&self) -> [usize; 2] {
        let [nx, ny] = self.count.map(|cells| cells + 3);
        if self.is_wide() { [ny, nx] } else { [nx, ny] }
    }

    fn is_wide(&self) -> bool {
        self.count[0] > self.count[1]
    }

    fn cells_of<'a>(&'a self, net: &'a Cells) -> impl Iterator<Item = usize> + 'a {
        let rows = self.first[1]..self.first[1] + self.count[1];
        rows.flat_map(move |j| (0..self.count[0]).map(move |i| j * net.nx + self.first[0] + i))
    }
}

/// Where the product of the k-th and the l-th of the 16 splines of a cell, l not after k, stands with the k-th.
fn neighbour(k: usize, l: usize) -> usize {
    7 * (k / 4 - l / 4) + 3 + k % 4 - l % 4
}

/// Splines in the same row up to three to either side, and in the three rows before it.
const NEIGHBOURS: usize = 28;

#[cfg(test)]
mod tests {
    use super::*;
    use crate::PointMm;
    use crate::shape::Shape;
    use crate::spline_fit::{Smoothing, fit_spline};

    const NET: Cells =
        Cells { x_min_mm: -1.0, y_min_mm: 2.0, step_x_mm: 0.5, step_y_mm: 0.25, nx: 9, ny: 14 };

    fn points(count: u32, net: &Cells) -> Vec<PointMm> {
        let width = [net.nx as f64 * net.step_x_mm, net.ny as f64 * net.step_y_mm];
        let at = |i: u32| [0.618_034, 0.754_878].map(|step: f64| (step * f64::from(i)).fract());
        let place = |[u, v]: [f64; 2]| [net.x_min_mm + u * width[0], net.y_min_mm + v * width[1]];
        (0..count).map(|i| place(at(i))).map(|[x, y]| [x, y, (3.0 * x).sin() * y]).collect()
    }

    /// From sums, about any surface, in parts, over cells that hold points alone: the splines of the fit of the points.
    #[test]
    fn sums_give_the_fit_of_the_points() {
        for (wide, margin) in [(NET, 0), (NET, 3), (Cells { nx: 14, ny: 5, ..NET }, 2)] {
            let points = points(900, &wide);
            let found = fit_spline(&points, &wide, Smoothing::Relative { lambda: 0.01 }).unwrap();
            let net = Cells {
                x_min_mm: wide.x_min_mm - margin as f64 * wide.step_x_mm,
                y_min_mm: wide.y_min_mm - margin as f64 * wide.step_y_mm,
                nx: wide.nx + 2 * margin,
                ny: wide.ny + 2 * margin,
                ..wide
            };
            let begin_mm: Vec<f64> = (0..net.splines()).map(|i| (0.3 * i as f64).sin()).collect();
            let height_mm = |place: &Place| place.height(&begin_mm).0;
            let (mut some, mut others) = (Moments::new(net), Moments::new(net));
            let cosine = |[x, _, _]: &PointMm| (1.0 + x * x).sqrt().recip();
            for (index, point) in points.iter().enumerate() {
                let to = if index % 3 == 0 { &mut some } else { &mut others };
                let place = Place::of(&net, point[0], point[1]).unwrap();
                to.add(&place, point[2] - height_mm(&place), cosine(point));
            }
            some.merge(&others);
            let part = some.occupied().unwrap();
            assert_eq!((part.cells(&net).nx, part.cells(&net).ny), (wide.nx, wide.ny));
            let system = some.system(&part, &begin_mm).unwrap();
            let trial = system.trial(0.01).unwrap();
            assert!(((trial.square / 900.0).sqrt() - found.residual_rms_mm).abs() < 1e-9);
            assert!((trial.effective - found.effective_parameters).abs() < 1e-6);
            let (change, _) = system.change(0.01 * system.unit).unwrap();
            let change = part.spread(&net, &change);
            let all: Vec<f64> = begin_mm.iter().zip(&change).map(|(a, b)| a + b).collect();
            let coefficients_mm = part.coefficients(&net, &all);
            for (found, truth) in coefficients_mm.iter().zip(found.surface.coefficients_mm()) {
                assert!((found - truth).abs() < 1e-9, "{found} {truth}");
            }
            assert_eq!(some.holding(&part), found.surface.defined());
            // Squares along the normal, before and after the sums have moved with the surface.
            let square = |point: &PointMm| {
                let left_mm = point[2] - found.surface.sag_mm(point[0], point[1]).unwrap();
                (left_mm * cosine(point)).powi(2)
            };
            let truth: f64 = points.iter().map(square).sum();
            assert!((some.square_mm2(&change) / truth - 1.0).abs() < 1e-9);
            some.move_by(&change);
            let still = vec![0.0; net.splines()];
            assert!((some.square_mm2(&still) / truth - 1.0).abs() < 1e-9);
            let there = some.system(&part, &all).unwrap();
            let (further, _) = there.change(0.01 * there.unit).unwrap();
            assert!(further.iter().all(|mm| mm.abs() < 1e-10), "{further:?}");
            assert!(Place::of(&net, 1e3, 0.0).is_none() && some.used() == 900);
        }
        assert_eq!(Moments::new(NET).occupied(), None);
    }
}
