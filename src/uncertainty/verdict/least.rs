//! What any fit must leave of points: bounds that more points cannot lower, over a zone and with terms removed.
//!
//! A figure over a zone is that of the fit of the whole aperture, and one with terms removed that of what these leave
//! of it. Whatever that fit will be, it moves the deviations by the derivatives of its parameters, and a removal by its
//! terms. So what no combination of these columns takes off the points there are is left in the end: of the squares
//! the least sum; of the range at least Σλ·d/½Σ|λ| for any weights λ that are orthogonal to every column and to
//! a constant (the dual of the linear program; Watson, Approximation Theory and Numerical Methods, 1980, ch. 1). Such
//! weights are those of a weighted least-squares fit times its residuals; Lawson's rule, which multiplies the weights
//! by the size of the residuals, takes the bound towards the minimum zone (Rice & Usow, Math. Comp. 22 (1968) 118).
//!
//! Columns are derivatives at the present pose: what it moves by until the end changes distances by terms of second
//! order, far below a picometre once a fit is determinate.

use rayon::prelude::*;

use asphera_figures::{Term, Terms, joined};
use asphera_form::linear::{CHUNK, Model, System, Triangle};
use asphera_form::{NM_PER_MM, Nominal, Parameter, PointMm, Pose};

/// Least share of the points that is left.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Least {
    /// Sum of the squares of their deviations in nm².
    pub square_nm2: f64,
    /// Range of their deviations in nm.
    pub range_nm: f64,
    /// How many points it is of.
    pub count: usize,
}

/// Remainder of `points` of the measured frame, whatever values the `free` parameters have near these of `pose` and
/// `nominal`, and after removal of `less`. `None` with fewer points than columns, or where a point has no distance.
/// `O(n·p²)`.
pub fn least(
    points: &[PointMm],
    nominal: &Nominal,
    pose: &Pose,
    free: &[Parameter],
    less: &Terms,
) -> Option<Least> {
    let columns = Columns::new(points, nominal, pose, free, less);
    let triangle = columns.triangle(points)?;
    let (system, without, with) = solved(&triangle)?;
    let outer = columns.outer(points, &with)?;
    Some(Least {
        square_nm2: system.square_after(&without) * NM_PER_MM * NM_PER_MM,
        range_nm: range_mm(&columns, &outer).unwrap_or(0.0) * NM_PER_MM,
        count: points.len(),
    })
}

/// The sum of squares of [`least`] alone, in nm², in less time.
pub fn least_square_nm2(
    points: &[PointMm],
    nominal: &Nominal,
    pose: &Pose,
    free: &[Parameter],
    less: &Terms,
) -> Option<f64> {
    let columns = Columns::new(points, nominal, pose, free, less);
    let (system, without, _) = solved(&columns.triangle(points)?)?;
    Some(system.square_after(&without) * NM_PER_MM * NM_PER_MM)
}

/// A lower bound of the range of what is left of some points.
fn range_mm(columns: &Columns<'_>, points: &[PointMm]) -> Option<f64> {
    let width = columns.width();
    let mut rows = vec![vec![0.0; width + 1]; points.len()];
    for (row, &point) in rows.iter_mut().zip(points) {
        columns.row(point, row)?;
    }
    let mut weights = vec![1.0 / points.len() as f64; points.len()];
    let mut best_mm = 0.0_f64;
    for _ in 0..ROUNDS {
        let mut triangle = Triangle::new(width + 1);
        for (row, weight) in rows.iter().zip(&weights) {
            let scaled: Vec<f64> = row.iter().map(|entry| entry * weight.sqrt()).collect();
            triangle.push(&scaled);
        }
        triangle.flush();
        let (_, _, change) = solved(&triangle)?;
        let left_mm = rows.iter().map(|row| (row[width] + dot(row, &change)).abs());
        let left_mm: Vec<f64> = left_mm.collect();
        let sum = |power: i32| -> f64 {
            weights.iter().zip(&left_mm).map(|(weight, mm)| weight * mm.powi(power)).sum()
        };
        let all = sum(1);
        if !(all > 0.0 && all.is_finite()) {
            break;
        }
        best_mm = best_mm.max(2.0 * sum(2) / all);
        weights.iter_mut().zip(&left_mm).for_each(|(weight, mm)| *weight *= mm / all);
    }
    Some(best_mm)
}

/// The system with its changes without and with the constant, which is the last column.
fn solved(triangle: &Triangle) -> Option<(System, Vec<f64>, Vec<f64>)> {
    if !triangle.is_finite() {
        return None;
    }
    let system = System::new(triangle);
    let width = triangle.columns() - 1;
    let change = |columns: usize| {
        let kept = system.determinate(&[(0..columns).collect()], RANK_TOLERANCE);
        let mut change = vec![0.0; width];
        let step = system.solve(&kept, 0.0);
        kept.iter().zip(&step.change).for_each(|(&column, &value)| change[column] = value);
        change
    };
    let (without, with) = (change(width - 1), change(width));
    Some((system, without, with))
}

/// The columns of a row: parameters, terms, a constant, and the distance in mm.
struct Columns<'a> {
    model: Model<'a>,
    terms: Vec<Term>,
    /// Functions the terms are made of.
    functions: usize,
    reach_mm: f64,
    free: usize,
}

impl<'a> Columns<'a> {
    fn new(
        points: &[PointMm],
        nominal: &'a Nominal,
        pose: &Pose,
        free: &'a [Parameter],
        less: &Terms,
    ) -> Columns<'a> {
        let model = Model::new(nominal, pose, free);
        let reach_mm = points.iter().map(|&point| {
            let [x, y, _] = model.to_part(point);
            x.hypot(y)
        });
        let reach_mm = reach_mm.fold(f64::MIN_POSITIVE, f64::max);
        let terms = less.list();
        let functions = terms.iter().map(|&term| functions(term, [0.0; 2]).len()).sum();
        Columns { model, terms, functions, reach_mm, free: free.len() }
    }

    /// Without the distance.
    fn width(&self) -> usize {
        self.free + self.functions + 1
    }

    fn place(&self, point: PointMm) -> [f64; 2] {
        let [x, y, _] = self.model.to_part(point);
        [x / self.reach_mm, y / self.reach_mm]
    }

    fn row(&self, point: PointMm, row: &mut [f64]) -> Option<()> {
        self.model.row(point, &mut row[..=self.free])?;
        let distance_mm = row[self.free];
        let place = self.place(point);
        let values = self.terms.iter().flat_map(|&term| functions(term, place));
        row[self.free..].iter_mut().zip(values.chain([1.0])).for_each(|(entry, v)| *entry = v);
        row[self.width()] = distance_mm;
        Some(())
    }
}

impl Columns<'_> {
    /// The triangular factor of all rows; `None` with no more points than columns, or where one has no distance. By chunks
    /// joined in order, so that the bits do not depend on the threads.
    fn triangle(&self, points: &[PointMm]) -> Option<Triangle> {
        let width = self.width();
        if points.len() <= width {
            return None;
        }
        let of_chunk = |chunk: &[PointMm]| {
            let mut row = vec![0.0; width + 1];
            let mut triangle = Triangle::new(width + 1);
            for &point in chunk {
                self.row(point, &mut row)?;
                triangle.push(&row);
            }
            triangle.flush();
            Some(triangle)
        };
        let factors: Option<Vec<Triangle>> = points.par_chunks(CHUNK).map(of_chunk).collect();
        Some(joined(factors?, width + 1))
    }

    /// The highest and the lowest points of each block once parameters and terms have changed by this.
    fn outer(&self, points: &[PointMm], change: &[f64]) -> Option<Vec<PointMm>> {
        let width = self.width();
        let left_mm = |&point: &PointMm| {
            let mut row = vec![0.0; width + 1];
            self.row(point, &mut row)?;
            Some(row[width] + dot(&row, change))
        };
        let left_mm: Option<Vec<f64>> =
            points.par_iter().with_min_len(CHUNK).map(left_mm).collect();
        let mut blocks = Blocks::default();
        for (index, (&point, left_mm)) in points.iter().zip(left_mm?).enumerate() {
            blocks.take(self.place(point), index, left_mm);
        }
        Some(blocks.extremes().map(|index| points[index]).collect())
    }
}

/// What a term is made of, whatever radius it refers to: the radius of a sample without an aperture is that of its
/// farthest point, which is not known before the last.
fn functions(term: Term, [x, y]: [f64; 2]) -> Vec<f64> {
    let square = x * x + y * y;
    match term {
        Term::Piston => vec![1.0],
        Term::Tilt => vec![x, y],
        Term::Power => vec![square, 1.0],
        Term::Astigmatism => vec![x * x - y * y, x * y],
        Term::Coma => vec![x * square, y * square, x, y],
        Term::Spherical => vec![square * square, square, 1.0],
    }
}

/// The highest and the lowest of each of some blocks.
struct Blocks(Vec<Option<[(f64, usize); 2]>>);

impl Default for Blocks {
    fn default() -> Blocks {
        Blocks(vec![None; SIDE * SIDE])
    }
}

impl Blocks {
    fn take(&mut self, place: [f64; 2], index: usize, value: f64) {
        let [column, row] =
            place.map(|share| ((0.5 * (share + 1.0) * SIDE as f64) as usize).min(SIDE - 1));
        let here = (value, index);
        let [low, high] = self.0[row * SIDE + column].get_or_insert([here, here]);
        if value < low.0 {
            *low = here;
        }
        if value > high.0 {
            *high = here;
        }
    }

    fn extremes(&self) -> impl Iterator<Item = usize> {
        self.0.iter().flatten().flat_map(|[low, high]| {
            let both = if low.1 == high.1 { 1 } else { 2 };
            [low.1, high.1].into_iter().take(both)
        })
    }
}

fn dot(row: &[f64], change: &[f64]) -> f64 {
    row.iter().zip(change).map(|(entry, step)| entry * step).sum()
}

/// Blocks along either side.
const SIDE: usize = 12;
/// Rounds of Lawson's rule: the bound is then some percent short of the minimum zone, and holds after any number.
const ROUNDS: usize = 40;
/// Columns nearer to each other than this are one.
const RANK_TOLERANCE: f64 = 1e-9;

#[cfg(test)]
mod tests {
    use super::*;
    use asphera_figures::{Reference, Sample, peak_to_valley, remove, rms};
    use asphera_form::{Aperture, FitSettings, deviations, fit};

    /// A disc of 8 mm radius, line by line, with a saddle, waves and a little that has no order.
    fn scan() -> Vec<PointMm> {
        let mut points = Vec::new();
        for line in 0..65_u32 {
            for column in 0..65_u32 {
                let [x, y] = [column, line].map(|at| 0.25 * f64::from(at) - 8.0);
                if x.hypot(y) <= 8.0 {
                    let rough = f64::from((column * 7919 + line * 104_729) % 101) / 50.0 - 1.0;
                    let nm = x * x - y * y + 20.0 * (1.1 * x).sin() * (0.8 * y).cos() + 3.0 * rough;
                    points.push([x, y, 1e-6 * nm + 1e-5 * y]);
                }
            }
        }
        points
    }

    /// PV and RMS of the fit of all points, after removal.
    fn figures(points: &[PointMm], less: &Terms) -> [f64; 2] {
        let found = fit(points, &Nominal::Plane, &FitSettings::default()).unwrap();
        let deviations_mm = deviations(points, &found.nominal, &found.pose);
        let places: Vec<[f64; 2]> = points.iter().map(|[x, y, _]| [*x, *y]).collect();
        let sample = Sample::new(&places, &deviations_mm, None, &Aperture::None).unwrap();
        let left = remove(&sample, &less.list()).unwrap().sample;
        [peak_to_valley(&left).unwrap().value, rms(&left, Reference::Zero).unwrap().value]
    }

    #[test]
    fn no_more_points_can_leave_less() {
        let points = scan();
        let free = [Parameter::Tz, Parameter::Rx, Parameter::Ry];
        let terms = [Term::Power, Term::Astigmatism, Term::Coma, Term::Spherical];
        for less in [Terms::NONE, Terms::new(&terms[1..2]), Terms::new(&terms)] {
            let [pv_nm, rms_nm] = figures(&points, &less);
            let mut before = [0.0; 2];
            for share in [3, 6, 10] {
                let some = &points[..share * points.len() / 10];
                let found = least(some, &Nominal::Plane, &Pose::default(), &free, &less).unwrap();
                let least_rms_nm = (found.square_nm2 / points.len() as f64).sqrt();
                assert!(
                    found.range_nm <= pv_nm && least_rms_nm <= rms_nm * (1.0 + 1e-9),
                    "{found:?}"
                );
                assert!(found.square_nm2 >= before[0] && found.range_nm >= 0.9 * before[1]);
                before = [found.square_nm2, found.range_nm];
            }
            // Of all points the removal leaves little more than the least.
            let [square_nm2, range_nm] = before;
            assert!((square_nm2 / points.len() as f64).sqrt() > 0.98 * rms_nm, "{less}");
            assert!(range_nm > 0.7 * pv_nm, "{less}: {range_nm} {pv_nm}");
            let pose = Pose::default();
            let alone = least_square_nm2(&points, &Nominal::Plane, &pose, &free, &less);
            assert_eq!(alone, Some(square_nm2));
        }
    }

    #[test]
    fn what_columns_make_up_and_too_few_points_leave_nothing() {
        let bowl: Vec<PointMm> =
            scan().iter().map(|&[x, y, _]| [x, y, 1e-6 * (x * x + y * y) + 1e-5 * x]).collect();
        let of = |points: &[PointMm], less: &[Term]| {
            least(points, &Nominal::Plane, &Pose::default(), &[Parameter::Tz], &Terms::new(less))
        };
        let found = of(&bowl, &[Term::Tilt, Term::Power]).unwrap();
        assert!(found.square_nm2 < 1e-12 && found.range_nm < 1e-6, "{found:?}");
        assert!(of(&bowl, &[Term::Tilt]).unwrap().range_nm > 30.0);
        assert_eq!(of(&bowl[..2], &[]), None);
        assert_eq!(of(&[], &[Term::Piston]), None);
    }
}
