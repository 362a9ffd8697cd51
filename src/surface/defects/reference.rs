//! The surface without its defects: quartics over windows that overlap, blended.
//!
//! Windows of width w stand on a lattice, not more than w/2 apart, the outermost flush with the
//! surface's extent so that no window of a rectangular surface is cut. Over each a quartic is fitted to
//! the means of its cells (see `fit.rs`): the mean of a quartic over the samples of a cell is known
//! exactly, so nothing is lost by it but what differs within a cell. The reference at a place is the
//! mean of the up to four quartics about it, weighted as in bilinear interpolation and by how much of
//! their window is filled.
//!
//! Along a border that is none of the rectangle's, windows of the lattice are cut, and their quartics would have to reach
//! beyond what they see, where they swing out. A quartic counts only where its variance is no larger than in the corner
//! of a filled window; places where none does get windows of their own, moved inwards until the place is at their rim
//! (`rim.rs`).

use asphera_geometry::VertexId;
use rayon::prelude::*;

use super::cells::{Cells, NONE, QUARTIC, height_mm, quartic};
use super::fit::{Fitted, STEPS_MAX, TERMS, Work};
use super::line::Line;
use super::rim::Rim;
use super::rows::{rows_of_cells, rows_of_samples};
use super::{DefectsUnknown, Samples};

/// Cells along a window where samples are not too scarce.
const CELLS_PER_WINDOW: f64 = 24.0;
/// Cells along half of a window from which on their means are fitted, and not the samples themselves.
const BY_CELLS: f64 = 2.0;
/// Sides of a cell in spacings: six samples in each.
pub(super) const CELL_SPACINGS: f64 = 2.5;
/// A window is used if it has this share of the cells of the fullest.
const FILLED: f64 = 0.3;
/// How many nodes away a window is looked for where none is about.
const FARTHEST: i64 = 2;
/// Variance of a quartic's height in the corner of evenly filled samples, over the mean of theirs: the sum of
/// (2i + 1)·(2j + 1) over i + j up to 4, by Legendre's polynomials, is 155; for cells and scatter a little more.
const CORNER: f64 = 165.0;
/// How far from a window's centre its quartic is used where there is none else, in half widths.
const BEYOND: f64 = 1.5;

/// Residuals from the reference, and what is known of it.
pub(super) struct Reference {
    /// By order of [`Cells::all`], in mm along z or along the deviations; NaN where there is no reference.
    pub(super) residuals_mm: Vec<f64>,
    /// For each cell area over projected area.
    pub(super) secants: Vec<f64>,
    /// For each cell the standard uncertainty of the reference in its middle, for samples of deviation 1.
    pub(super) uncertainties: Vec<f64>,
    /// The median of these.
    pub(super) typical: f64,
}

/// Side of a cell for windows of a width over samples of a spacing.
pub(super) fn side_mm(window_mm: f64, spacing_mm: f64) -> f64 {
    (window_mm / CELLS_PER_WINDOW).max(CELL_SPACINGS * spacing_mm)
}

pub(super) struct Patch {
    pub(super) centre_mm: [f64; 2],
    /// What the fitted heights are over, so that a far origin costs no digits.
    datum_mm: f64,
    fitted: Fitted,
    filled: f64,
    /// Which steps cross it.
    steps: [u32; STEPS_MAX],
}

impl Patch {
    /// Whether the quartic is told where its height has a variance: as well as in the corner of its samples, were these in a
    /// rectangle. It is the same for rectangles of any size and any ratio of the sides.
    pub(super) fn sees(&self, variance: f64) -> bool {
        variance * self.fitted.samples <= CORNER
    }
}

/// How well windows tell the height of a place.
#[derive(Clone, Copy)]
pub(super) struct Told {
    /// Variance of the height for samples of variance 1.
    pub(super) variance: f64,
    /// The same over that of the mean of the samples of a window.
    pub(super) loss: f64,
}

/// The lattice of the windows.
pub(super) struct Lattice {
    first_mm: [f64; 2],
    pitch_mm: [f64; 2],
    size: [usize; 2],
    pub(super) half_mm: f64,
}

impl Lattice {
    fn new(cells: &Cells, window_mm: f64) -> Lattice {
        let (mut first_mm, mut pitch_mm, mut size) = ([0.0; 2], [1.0; 2], [1; 2]);
        for axis in 0..2 {
            let rest = cells.extent_mm[axis] - window_mm;
            if rest > 0.0 {
                let gaps = (2.0 * rest / window_mm).ceil().max(1.0);
                size[axis] = gaps as usize + 1;
                pitch_mm[axis] = rest / gaps;
                first_mm[axis] = cells.low_mm[axis] + 0.5 * window_mm;
            } else {
                first_mm[axis] = cells.low_mm[axis] + 0.5 * cells.extent_mm[axis];
            }
        }
        Lattice { first_mm, pitch_mm, size, half_mm: 0.5 * window_mm }
    }

    fn centre_mm(&self, node: usize) -> [f64; 2] {
        let place = [node % self.size[0], node / self.size[0]];
        [0, 1].map(|axis| self.first_mm[axis] + place[axis] as f64 * self.pitch_mm[axis])
    }

    /// Where a place lies in the lattice: the node below, and the way to the next from 0 to 1.
    fn at(&self, place_mm: [f64; 2], axis: usize) -> (usize, f64) {
        let along = (place_mm[axis] - self.first_mm[axis]) / self.pitch_mm[axis];
        let along = along.clamp(0.0, (self.size[axis] - 1) as f64);
        let below = (along as usize).min(self.size[axis].saturating_sub(2));
        (below, along - below as f64)
    }
}

impl Reference {
    /// Fits the windows. `steps` jump in it; where they are to be `kept`, what they add is then not
    /// taken off the residuals.
    pub(super) fn new(
        samples: &Samples<'_>,
        cells: &Cells,
        window_mm: f64,
        steps: &[Line],
        kept: bool,
    ) -> Result<Reference, DefectsUnknown> {
        let lattice = Lattice::new(cells, window_mm);
        let nodes = lattice.size[0] * lattice.size[1];
        let patches: Vec<Option<Patch>> = (0..nodes)
            .into_par_iter()
            .map_init(Work::default, |work, node| {
                patch(samples, cells, &lattice, steps, lattice.centre_mm(node), work)
            })
            .collect();
        let fullest = patches.iter().flatten().map(|patch| patch.filled).fold(0.0, f64::max);
        let patches: Vec<Option<Patch>> = patches
            .into_iter()
            .map(|patch| patch.filter(|patch| patch.filled >= FILLED * fullest))
            .collect();
        if patches.iter().all(Option::is_none) {
            return Err(DefectsUnknown::NoReference { window_mm });
        }
        let blend = Blend { samples, lattice: &lattice, patches: &patches, steps, kept };
        let rim = Rim::new(&blend, cells);
        let parts: Vec<(Vec<f64>, f64, f64)> = (0..cells.len())
            .into_par_iter()
            .with_min_len(64)
            .map(|cell| blend.residuals(cells, cell, rim.of(cell)))
            .collect();
        let mut reference = Reference {
            residuals_mm: Vec::with_capacity(cells.all().len()),
            secants: Vec::with_capacity(cells.len()),
            uncertainties: Vec::with_capacity(cells.len()),
            typical: 0.0,
        };
        for (residuals_mm, secant, uncertainty) in parts {
            reference.residuals_mm.extend(residuals_mm);
            reference.secants.push(secant);
            reference.uncertainties.push(uncertainty);
        }
        let mut known: Vec<f64> =
            reference.uncertainties.iter().copied().filter(|one| one.is_finite()).collect();
        let middle = known.len() / 2;
        if !known.is_empty() {
            reference.typical = *known.select_nth_unstable_by(middle, f64::total_cmp).1;
        }
        Ok(reference)
    }
}

/// Fits the window about a place.
pub(super) fn patch(
    samples: &Samples<'_>,
    cells: &Cells,
    lattice: &Lattice,
    lines: &[Line],
    centre_mm: [f64; 2],
    work: &mut Work,
) -> Option<Patch> {
    let half_mm = lattice.half_mm;
    let mut steps = [NONE; STEPS_MAX];
    let crossing =
        (0..lines.len() as u32).filter(|&line| lines[line as usize].crosses(centre_mm, half_mm));
    steps.iter_mut().zip(crossing).for_each(|(step, line)| *step = line);
    let crossed = steps.iter().filter(|&&step| step != NONE).count();
    let jumps = |members: &[VertexId], terms: &mut [f64; TERMS]| {
        for (term, &step) in terms[QUARTIC..].iter_mut().zip(&steps[..crossed]) {
            let line = &lines[step as usize];
            let sides = members.iter().map(|&vertex| {
                let [x, y, _] = samples.points[vertex as usize];
                line.side([x, y])
            });
            *term = sides.sum::<f64>() / members.len() as f64;
        }
    };
    work.rows.clear();
    if half_mm < BY_CELLS * cells.side_mm {
        rows_of_samples((samples, cells), (centre_mm, half_mm), jumps, &mut work.rows);
    } else {
        rows_of_cells(cells, (centre_mm, half_mm), jumps, &mut work.rows);
    }
    let datum_mm = work.rows.first()?.height_mm;
    work.rows.iter_mut().for_each(|row| row.height_mm -= datum_mm);
    // A step that hardly enters the window cannot be told: without it then.
    let fitted = (QUARTIC..=QUARTIC + crossed).rev().find_map(|terms| work.fit(terms))?;
    Some(Patch { centre_mm, datum_mm, fitted, filled: work.rows.len() as f64, steps })
}

/// The windows a cell's reference is made of, with the variance of each at the middle of the cell.
type Trusted<'a> = Vec<(usize, &'a Patch, f64)>;

pub(super) struct Blend<'a> {
    pub(super) samples: &'a Samples<'a>,
    pub(super) lattice: &'a Lattice,
    pub(super) patches: &'a [Option<Patch>],
    pub(super) steps: &'a [Line],
    kept: bool,
}

impl<'a> Blend<'a> {
    /// Residuals of the samples of a cell, its secant, and the uncertainty of the reference. `own` is a window made for
    /// it.
    fn residuals(
        &self,
        cells: &Cells,
        cell: usize,
        own: Option<&'a Patch>,
    ) -> (Vec<f64>, f64, f64) {
        let centre_mm = cells.centre_mm(cell);
        let trusted = self.trusted(centre_mm);
        let mut secant = f64::NAN;
        let mut uncertainty = f64::NAN;
        let residuals = cells.members(cell).iter().map(|&vertex| {
            let [x, y, _] = self.samples.points[vertex as usize];
            let (mut sum, mut total) = (0.0, 0.0);
            self.about([x, y], &trusted, own, |weight, patch| {
                sum += weight * self.height_mm(patch, [x, y]);
                total += weight;
            });
            height_mm(self.samples, vertex) - sum / total
        });
        let residuals = residuals.collect();
        let (mut slope, mut variance, mut total) = ([0.0; 2], 0.0, 0.0);
        self.about(centre_mm, &trusted, own, |weight, patch| {
            let parts = self.slope(patch, centre_mm);
            slope[0] += weight * parts[0];
            slope[1] += weight * parts[1];
            variance += weight * self.variance(patch, centre_mm);
            total += weight;
        });
        if total > 0.0 {
            // Deviations are along the normal already.
            secant = match self.samples.deviations_mm {
                Some(_) => 1.0,
                None => (slope[0] / total).hypot(slope[1] / total).hypot(1.0),
            };
            uncertainty = (variance / total).sqrt();
        }
        (residuals, secant, uncertainty)
    }

    /// How well the windows about a place tell its height; `None` where all would have to reach beyond what they see.
    pub(super) fn told(&self, place_mm: [f64; 2]) -> Option<Told> {
        let trusted = self.trusted(place_mm);
        let (mut variance, mut loss, mut total) = (0.0, 0.0, 0.0);
        self.blended(place_mm, &trusted, |weight, patch| {
            let of = self.variance(patch, place_mm);
            variance += weight * of;
            loss += weight * of * patch.fitted.samples;
            total += weight;
        });
        (total > 0.0).then(|| Told { variance: variance / total, loss: loss / total })
    }

    /// The windows that tell a height at a place without reaching beyond what they see, of those near it.
    fn trusted(&self, place_mm: [f64; 2]) -> Trusted<'a> {
        let [i, j] = [0, 1].map(|axis| self.lattice.at(place_mm, axis).0);
        let [width, height] = self.lattice.size;
        let rows = j.saturating_sub(1)..(j + 3).min(height);
        let nodes = rows.flat_map(|row| {
            (i.saturating_sub(1)..(i + 3).min(width)).map(move |column| row * width + column)
        });
        nodes
            .filter_map(|node| {
                let patch = self.patches[node].as_ref()?;
                let variance = self.variance(patch, place_mm);
                patch.sees(variance).then_some((node, patch, variance))
            })
            .collect()
    }

    /// Calls `with` for the windows about a place and their weights: those that are trusted, else its own, else any.
    fn about(
        &self,
        place_mm: [f64; 2],
        trusted: &Trusted<'_>,
        own: Option<&Patch>,
        mut with: impl FnMut(f64, &Patch),
    ) {
        if let Some(own) = own {
            return with(1.0, own);
        }
        let mut found = false;
        self.blended(place_mm, trusted, |weight, patch| {
            found = true;
            with(weight, patch);
        });
        // A place in a cell whose middle lies between other windows.
        if !found && let Some((_, patch, _)) = trusted.iter().min_by(|p, q| p.2.total_cmp(&q.2)) {
            return with(1.0, patch);
        }
        let node = [0, 1].map(|axis| self.lattice.at(place_mm, axis).0 as i64);
        if !found && let Some(patch) = self.nearest(place_mm, node) {
            with(1.0, patch);
        }
    }

    /// Calls `with` for the trusted windows about a place and their weights.
    fn blended(
        &self,
        place_mm: [f64; 2],
        trusted: &Trusted<'_>,
        mut with: impl FnMut(f64, &Patch),
    ) {
        let [(i, u), (j, v)] = [0, 1].map(|axis| self.lattice.at(place_mm, axis));
        for (row, across) in [(j, 1.0 - v), (j + 1, v)] {
            for (column, along) in [(i, 1.0 - u), (i + 1, u)] {
                let node = row * self.lattice.size[0] + column;
                if along * across > 0.0
                    && let Some((_, patch, _)) = trusted.iter().find(|one| one.0 == node)
                {
                    with(along * across * patch.filled * patch.filled, patch);
                }
            }
        }
    }

    /// The nearest window of those about a node that is not too far from a place.
    fn nearest(&self, place_mm: [f64; 2], node: [i64; 2]) -> Option<&'a Patch> {
        let size = self.lattice.size;
        let mut best: Option<(f64, &Patch)> = None;
        for row in (node[1] - FARTHEST).max(0)..=(node[1] + FARTHEST + 1).min(size[1] as i64 - 1) {
            for column in
                (node[0] - FARTHEST).max(0)..=(node[0] + FARTHEST + 1).min(size[0] as i64 - 1)
            {
                let Some(patch) = &self.patches[row as usize * size[0] + column as usize] else {
                    continue;
                };
                let away = [0, 1].map(|axis| (place_mm[axis] - patch.centre_mm[axis]).abs());
                let away_mm = away[0].max(away[1]);
                if away_mm <= BEYOND * self.lattice.half_mm
                    && best.is_none_or(|(nearest_mm, _)| away_mm < nearest_mm)
                {
                    best = Some((away_mm, patch));
                }
            }
        }
        best.map(|(_, patch)| patch)
    }

    /// Variance of a window's height at a place for samples of variance 1.
    pub(super) fn variance(&self, patch: &Patch, place_mm: [f64; 2]) -> f64 {
        let [x, y] =
            [0, 1].map(|axis| (place_mm[axis] - patch.centre_mm[axis]) / self.lattice.half_mm);
        let mut terms = [0.0; TERMS];
        terms[..QUARTIC].copy_from_slice(&quartic(x, y));
        let steps = patch.steps.iter().take_while(|&&step| step != NONE);
        for (term, &step) in terms[QUARTIC..].iter_mut().zip(steps) {
            *term = self.steps[step as usize].side(place_mm);
        }
        patch.fitted.variance(&terms)
    }

    fn height_mm(&self, patch: &Patch, place_mm: [f64; 2]) -> f64 {
        let [x, y] =
            [0, 1].map(|axis| (place_mm[axis] - patch.centre_mm[axis]) / self.lattice.half_mm);
        let t = &patch.fitted.terms;
        let smooth: f64 = quartic(x, y).iter().zip(t).map(|(p, q)| p * q).sum();
        if self.kept {
            return patch.datum_mm + smooth;
        }
        let steps = t[QUARTIC..].iter().zip(&patch.steps).filter(|&(_, &step)| step != NONE);
        let jumps: f64 =
            steps.map(|(jump, &step)| jump * self.steps[step as usize].side(place_mm)).sum();
        patch.datum_mm + smooth + jumps
    }

    fn slope(&self, patch: &Patch, place_mm: [f64; 2]) -> [f64; 2] {
        let [x, y] =
            [0, 1].map(|axis| (place_mm[axis] - patch.centre_mm[axis]) / self.lattice.half_mm);
        let t = &patch.fitted.terms;
        let (xx, xy, yy) = (x * x, x * y, y * y);
        let along =
            t[1] + 2.0 * t[3] * x + t[4] * y + 3.0 * t[6] * xx + 2.0 * t[7] * xy + t[8] * yy;
        let across =
            t[2] + t[4] * x + 2.0 * t[5] * y + t[7] * xx + 2.0 * t[8] * xy + 3.0 * t[9] * yy;
        let fourth = [
            4.0 * t[10] * x * xx + 3.0 * t[11] * x * xy + 2.0 * t[12] * x * yy + t[13] * y * yy,
            t[11] * x * xx + 2.0 * t[12] * x * xy + 3.0 * t[13] * x * yy + 4.0 * t[14] * y * yy,
        ];
        [along + fourth[0], across + fourth[1]].map(|part| part / self.lattice.half_mm)
    }
}
