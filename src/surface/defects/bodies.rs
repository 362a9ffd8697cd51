//! Wide bumps and pits, fitted together with the form about them.
//!
//! A bump of a third of a window is so wide that a quartic over the window takes a part of it, and leaves a moat about it. So
//! where one is found, a quartic over two windows and a bump of any width and steepness are fitted to the means of cells
//! together. That gives its height with what is not known of width and steepness. The reference is then fitted again to what
//! is left, as it is where a surface steps.
//!
//! A bump counts only if what it leaves is white: of form that is none, neighbouring cells stand off alike.

use super::cells::{Cells, QUARTIC};
use super::{Defect, DefectKind, Samples};

/// Bump, or pit, over the form about it.
#[derive(Clone, Debug)]
pub(super) struct Body {
    shape: Shape,
    /// Heights of the terms of its shape, in mm.
    heights_mm: [f64; TERMS],
    /// Standard uncertainty of its height in mm.
    pub(super) uncertainty_mm: f64,
}

type Matrix = nalgebra::SMatrix<f64, TERMS, TERMS>;
type Vector = nalgebra::SVector<f64, TERMS>;

/// Hill of height 1.
#[derive(Clone, Copy, Debug)]
struct Shape {
    centre_mm: [f64; 2],
    along: [f64; 2],
    /// From its middle to half of its height.
    half_mm: [f64; 2],
    /// 2 of Gaussian hills, more of steeper ones.
    steepness: f64,
}

impl Shape {
    /// Its height at a place, and how that changes as it moves along its axes, is drawn out along them, or between them, in
    /// its half widths.
    fn terms(&self, place_mm: [f64; 2]) -> [f64; TERMS] {
        let [u, v] = super::line::local_mm(self.centre_mm, self.along, place_mm);
        let [u, v] = [u / self.half_mm[0], v / self.half_mm[1]];
        let square = (u * u + v * v).max(1e-12);
        let inner = std::f64::consts::LN_2 * square.powf(0.5 * self.steepness);
        let height = (-inner).exp();
        let slope = -height * inner * self.steepness / square;
        [height, slope * u, slope * v, slope * (u * u - v * v), 2.0 * slope * u * v]
    }
}

impl Body {
    /// Its height at a place in mm.
    pub(super) fn height_mm(&self, place_mm: [f64; 2]) -> f64 {
        self.shape.terms(place_mm).iter().zip(self.heights_mm).map(|(p, q)| p * q).sum()
    }

    /// Whether a place lies within its half height.
    pub(super) fn holds(&self, [x, y]: [f64; 2]) -> bool {
        self.shape.terms([x, y])[0] >= 0.5
    }

    fn is_near(&self, [x, y]: [f64; 2], least_mm: f64) -> bool {
        let [cx, cy] = self.shape.centre_mm;
        (x - cx).hypot(y - cy) < least_mm + self.shape.half_mm[0]
    }
}

/// Finds the bodies of wide defects, the most significant first; one that lies about another's is its moat.
pub(super) fn bodies(
    samples: &Samples<'_>,
    cells: &Cells,
    defects: &[Defect],
    window_mm: f64,
) -> Vec<Body> {
    let mut bodies: Vec<Body> = Vec::new();
    for defect in defects.iter().filter(|defect| is_wide(defect, window_mm)) {
        let [x, y, _] = defect.centre_mm;
        if bodies.len() < MOST && !bodies.iter().any(|body| body.is_near([x, y], 0.5 * window_mm)) {
            bodies.extend(Fit::new(samples, cells, defect, window_mm).and_then(Fit::body));
        }
    }
    bodies
}

/// Whether windows take a part of it.
pub(super) fn is_wide(defect: &Defect, window_mm: f64) -> bool {
    matches!(defect.kind, DefectKind::Bump | DefectKind::Pit)
        && defect.significance > CLEAR
        && defect.width_mm.is_some_and(|width_mm| width_mm >= WIDE * window_mm)
}

/// Cells about a defect.
struct Fit {
    shape: Shape,
    spacing_mm: f64,
    /// By cell, its place in the grid, and places of its samples.
    places: Vec<[u32; 2]>,
    samples_mm: Vec<Vec<[f64; 2]>>,
    /// Roots of the numbers of samples.
    weights: Vec<f64>,
    heights: Vec<f64>,
    /// Quartics, each with those before it taken off.
    basis: Vec<Vec<f64>>,
}

/// Result for one width and steepness.
#[derive(Clone, Copy)]
struct Tried {
    shape: Shape,
    heights_mm: [f64; TERMS],
    /// Variance of the height for samples of variance 1.
    variance: f64,
    squares: f64,
}

impl Tried {
    /// The middle of the shape as it was moved.
    fn middle_mm(&self) -> [f64; 2] {
        let [height_mm, ways @ ..] = self.heights_mm;
        let Shape { centre_mm: [x, y], along: [cos, sin], half_mm, .. } = self.shape;
        let [u, v] =
            [0, 1].map(|axis| -half_mm[axis] * (ways[axis] / height_mm).clamp(-FARTHEST, FARTHEST));
        [x + cos * u - sin * v, y + sin * u + cos * v]
    }
}

impl Fit {
    fn new(samples: &Samples<'_>, cells: &Cells, defect: &Defect, window_mm: f64) -> Option<Fit> {
        let [x, y, _] = defect.centre_mm;
        let (length_mm, width_mm) = defect.length_mm.zip(defect.width_mm)?;
        let ratio =
            Some((length_mm / width_mm).sqrt()).filter(|&ratio| ratio > ROUND).unwrap_or(1.0);
        let shape = Shape {
            centre_mm: [x, y],
            along: defect.direction.unwrap_or([1.0, 0.0]),
            half_mm: [ratio, ratio.recip()],
            steepness: 2.0,
        };
        let near = |cell: &usize| {
            let [cx, cy] = cells.centre_mm(*cell);
            (cx - x).abs() <= window_mm && (cy - y).abs() <= window_mm
        };
        let chosen: Vec<usize> = (0..cells.len()).filter(near).collect();
        if chosen.len() < CELLS_LEAST {
            return None;
        }
        let of = |cell: usize| -> Vec<[f64; 2]> {
            let members = cells.members(cell).iter();
            members.map(|&vertex| samples.points[vertex as usize]).map(|[x, y, _]| [x, y]).collect()
        };
        let weights: Vec<f64> =
            chosen.iter().map(|&cell| cells.moments[cell].count.sqrt()).collect();
        let mut columns = vec![Vec::new(); QUARTIC];
        for (&cell, weight) in chosen.iter().zip(&weights) {
            let [cx, cy] = cells.centre_mm(cell);
            let [u, v] = [(cx - x) / window_mm, (cy - y) / window_mm];
            let terms = cells.moments[cell].terms(u, v, cells.side_mm / window_mm);
            columns.iter_mut().zip(terms).for_each(|(column, term)| column.push(weight * term));
        }
        let mut fit = Fit {
            shape,
            spacing_mm: cells.side_mm / super::reference::CELL_SPACINGS,
            places: chosen.iter().map(|&cell| cells.places[cell]).collect(),
            samples_mm: chosen.iter().map(|&cell| of(cell)).collect(),
            heights: Vec::new(),
            weights,
            basis: Vec::new(),
        };
        for mut column in columns {
            let before = dot(&column, &column);
            fit.take_off(&mut column);
            let size = dot(&column, &column);
            let is_told = size > DEPENDS * before;
            if !is_told {
                return None;
            }
            column.iter_mut().for_each(|value| *value /= size.sqrt());
            fit.basis.push(column);
        }
        let datum_mm = cells.moments[chosen[0]].height_mm;
        let heights = chosen.iter().zip(&fit.weights);
        let mut heights: Vec<f64> = heights
            .map(|(&cell, weight)| weight * (cells.moments[cell].height_mm - datum_mm))
            .collect();
        fit.take_off(&mut heights);
        fit.heights = heights;
        Some(fit)
    }

    /// Takes the quartics off a column.
    fn take_off(&self, column: &mut [f64]) {
        for term in &self.basis {
            let by = dot(term, column);
            column.iter_mut().zip(term).for_each(|(value, term)| *value -= by * term);
        }
    }

    /// The shape with half widths at half of its height of so many mm, and what it leaves.
    fn tried(&self, half_mm: f64, steepness: f64) -> Option<(Tried, Vec<f64>)> {
        let [a, b] = self.shape.half_mm;
        let shape = Shape { half_mm: [a * half_mm, b * half_mm], steepness, ..self.shape };
        let mut columns: [Vec<f64>; TERMS] = Default::default();
        for (places_mm, weight) in self.samples_mm.iter().zip(&self.weights) {
            let sums = places_mm.iter().fold([0.0; TERMS], |sums, &place_mm| {
                let terms = shape.terms(place_mm);
                std::array::from_fn(|term| sums[term] + terms[term])
            });
            let mean = weight / places_mm.len() as f64;
            columns.iter_mut().zip(sums).for_each(|(column, sum)| column.push(mean * sum));
        }
        columns.iter_mut().for_each(|column| self.take_off(column));
        let normal = Matrix::from_fn(|i, j| dot(&columns[i], &columns[j]));
        let right = Vector::from_fn(|i, _| dot(&columns[i], &self.heights));
        let inverse = normal.cholesky()?.inverse();
        let solved = inverse * right;
        let mut left = self.heights.clone();
        for (column, by) in columns.iter().zip(solved.iter()) {
            left.iter_mut().zip(column).for_each(|(left, term)| *left -= by * term);
        }
        let squares = dot(&left, &left);
        let heights_mm = solved.into();
        Some((Tried { shape, heights_mm, variance: inverse[(0, 0)], squares }, left))
    }

    /// The body that leaves the least squares, if it explains what is there.
    fn body(mut self) -> Option<Body> {
        let widths = |first: f64, ratio: f64, count: i32| {
            (0..=count).map(move |step| first * ratio.powi(step)).collect::<Vec<f64>>()
        };
        let first_mm = NARROWEST * self.spacing_mm;
        let best = |tried: &[(f64, Tried)]| {
            tried.iter().copied().min_by(|p, q| p.1.squares.total_cmp(&q.1.squares))
        };
        let all = |fit: &Fit, halves: &[f64]| -> Vec<(f64, Tried)> {
            let pairs = halves.iter().flat_map(|&half| STEEPNESSES.map(|steep| (half, steep)));
            pairs.filter_map(|(half, steep)| Some((half, fit.tried(half, steep)?.0))).collect()
        };
        let mut coarse = first_mm;
        for _ in 0..ROUNDS {
            let (half_mm, found) = best(&all(&self, &widths(first_mm, COARSE, COARSE_STEPS)))?;
            coarse = half_mm;
            self.shape.centre_mm = found.middle_mm();
        }
        let fine = all(&self, &widths(coarse / FINE.powi(FINE_STEPS / 2), FINE, FINE_STEPS));
        let (half_mm, chosen) = best(&fine)?;
        let (_, left) = self.tried(half_mm, chosen.shape.steepness)?;
        let single_mm2 = chosen.squares / (self.heights.len() - QUARTIC - TERMS - 2) as f64;
        // The mean over all widths and steepnesses, each as likely as what it leaves makes it.
        let likely = |tried: &Tried| (0.5 * (chosen.squares - tried.squares) / single_mm2).exp();
        let total: f64 = fine.iter().map(|(_, tried)| likely(tried)).sum();
        let spread = fine.iter().map(|(_, tried)| {
            likely(tried) / total * (tried.heights_mm[0] - chosen.heights_mm[0]).powi(2)
        });
        let uncertainty_mm = (spread.sum::<f64>() + single_mm2 * chosen.variance).sqrt();
        let [first, last] = [fine.first()?.0, fine.last()?.0];
        let at_ends = fine.iter().filter(|(half, _)| *half == first || *half == last);
        let is_told = at_ends.map(|(_, tried)| likely(tried)).sum::<f64>() < ENDS * total;
        let is_clear = chosen.heights_mm[0].abs() > SURE * uncertainty_mm;
        (is_told && is_clear && self.alike(&left) < WHITE).then_some(Body {
            shape: chosen.shape,
            heights_mm: chosen.heights_mm,
            uncertainty_mm,
        })
    }

    /// How much neighbouring cells stand off alike, from 0 of white noise to 1.
    fn alike(&self, left: &[f64]) -> f64 {
        let index: std::collections::BTreeMap<[u32; 2], usize> =
            self.places.iter().enumerate().map(|(at, &place)| (place, at)).collect();
        let (mut product, mut pairs) = (0.0, 0.0);
        for (&[column, row], value) in self.places.iter().zip(left) {
            for beside in [[column + 1, row], [column, row + 1]] {
                if let Some(&other) = index.get(&beside) {
                    product += value * left[other];
                    pairs += 1.0;
                }
            }
        }
        product / pairs / (dot(left, left) / left.len() as f64)
    }
}

fn dot(left: &[f64], right: &[f64]) -> f64 {
    left.iter().zip(right).map(|(p, q)| p * q).sum()
}

/// Width over that of a window from which on quartics take more of a bump than a twentieth.
const WIDE: f64 = 0.18;
/// Standard deviations from which on a defect is fitted so.
const CLEAR: f64 = 8.0;
/// Most bodies of one surface.
const MOST: usize = 16;
/// Root of the ratio of length to width up to which a defect is taken for round.
const ROUND: f64 = 1.25;
/// Terms of a shape.
const TERMS: usize = 5;
/// Rounds in which a shape is moved to its middle, and how far at once, in half widths.
const ROUNDS: usize = 3;
const FARTHEST: f64 = 0.5;
/// Fewest cells that tell quartic and bump.
const CELLS_LEAST: usize = 100;
/// Share of a quartic's term that those before it must leave, in squares.
const DEPENDS: f64 = 1e-8;
/// Narrowest half width that is tried, in spacings.
const NARROWEST: f64 = 3.0;
/// Ratio of the half widths tried first, and how many there are.
const COARSE: f64 = 1.12;
const COARSE_STEPS: i32 = 24;
/// The same about the best of these.
const FINE: f64 = 1.015;
const FINE_STEPS: i32 = 32;
/// Steepnesses that are tried: from a peak to nearly a disc.
const STEEPNESSES: [f64; 5] = [1.5, 2.0, 2.5, 3.5, 6.0];
/// Share of likelihood at the ends of the widths from which on the width is not told.
const ENDS: f64 = 0.02;
/// Standard uncertainties by which a body stands out.
const SURE: f64 = 4.0;
/// Correlation of neighbouring cells below which what is left is white.
const WHITE: f64 = 0.1;
