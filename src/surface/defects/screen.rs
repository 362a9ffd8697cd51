//! Where on a large surface defects may be: a quick look at its deviations, cell by cell.
//!
//! What stands off noise shows in the means of cells, at the cost of one visit to each sample. So:
//!
//! 1. The samples are added up in cells of 2.5 spacings: number, sum, squares, extremes.
//! 2. Windows as wide as those of the reference get a quartic through the means of wider cells, robust as in
//!    `fit.rs`; a cell's residual is that from the nearest window.
//! 3. A cell is *suspect* if its extreme, its mean, or the mean of the 2×2 or 3×3 cells it is part of stands off
//!    by a threshold somewhat lower than that of `detect.rs`, in units of what half of all cells tell.
//! 4. Suspect cells with half a window about them are the *parts* in which defects are then looked for.
//!
//! Extremes count the slope within a cell, so it is deviations from a nominal that are looked at, not heights.
//!
//! What it may miss: the means of `detect.rs` are about each vertex, those of cells lie anywhere. A shallow
//! defect that is seen by means only is sure to make a cell suspect from some 1.3 times the threshold on.

use asphera_geometry::{BoundsMm, PointMm, VertexId};
use rayon::prelude::*;

use super::DefectsUnknown;
use super::cells::{NONE, QUARTIC, quartic};
use super::detect::{SAMPLES, SCALES};
use super::fit::{Row, TERMS, Work};
use super::ground::{Ground, ground, planes};
use super::reference::CELL_SPACINGS;
use super::tail;
use super::tally::Tally;

/// What is looked at, and how.
#[derive(Clone, Copy)]
pub(super) struct Screen<'a> {
    pub(super) points: &'a [PointMm],
    /// NaN where it is not known: such vertices are left out.
    pub(super) deviations_mm: &'a [f64],
    pub(super) spacing_mm: f64,
    pub(super) window_mm: f64,
    /// Standard deviation of the noise, 0 if it is not known.
    pub(super) sigma_mm: f64,
    pub(super) false_expected: f64,
}

/// Where defects may be.
pub(super) struct Parts {
    /// The vertices of each, ascending.
    pub(super) vertices: Vec<Vec<VertexId>>,
    /// How many vertices the surface has.
    pub(super) used: u64,
    /// Standard deviation of single residuals in mm: that of the noise, or of what half of the cells tell.
    pub(super) sigma_mm: f64,
    /// Standard deviations from which on something is a defect.
    pub(super) threshold: f64,
    /// What the parts were cut out about.
    pub(super) suspects: Suspects,
    /// The noise of the whole surface.
    pub(super) ground: Ground,
}

/// Where a defect was suspected. Where a part was cut out of the surface, half a window away from there, nothing holds
/// its reference, which may run away from form that it cannot follow.
pub(super) struct Suspects {
    raster: Raster,
    cells: Vec<bool>,
}

impl Suspects {
    /// Whether something was suspected in a rectangle.
    pub(super) fn meet(&self, BoundsMm { low, high }: &BoundsMm) -> bool {
        let [first, last] = [low, high].map(|corner| {
            let slot = self.raster.slot([corner[0], corner[1], 0.0]);
            [slot % self.raster.size[0], slot / self.raster.size[0]]
        });
        (first[1]..=last[1]).any(|row| {
            let row = row * self.raster.size[0];
            self.cells[row + first[0]..=row + last[0]].contains(&true)
        })
    }
}

/// Square cells in rows.
#[derive(Clone, Copy)]
pub(super) struct Raster {
    pub(super) low_mm: [f64; 2],
    pub(super) per_mm: f64,
    pub(super) size: [usize; 2],
}

impl Raster {
    pub(super) fn slot(&self, [x, y, _]: PointMm) -> usize {
        let [column, row] = [(x, 0), (y, 1)].map(|(coordinate, axis)| {
            let cell = ((coordinate - self.low_mm[axis]) * self.per_mm) as usize;
            cell.min(self.size[axis] - 1)
        });
        row * self.size[0] + column
    }

    /// A place in a cell from its middle, in sides.
    pub(super) fn place_in(&self, slot: usize, [x, y, _]: PointMm) -> [f64; 2] {
        let [mx, my] = self.middle_mm(slot);
        [(x - mx) * self.per_mm, (y - my) * self.per_mm]
    }

    pub(super) fn middle_mm(&self, slot: usize) -> [f64; 2] {
        let [column, row] = [slot % self.size[0], slot / self.size[0]];
        [(column, 0), (row, 1)]
            .map(|(at, axis)| self.low_mm[axis] + (at as f64 + 0.5) / self.per_mm)
    }
}

impl Screen<'_> {
    /// Looks at all samples once.
    pub(super) fn parts(&self) -> Result<Parts, DefectsUnknown> {
        let (raster, used) = self.raster()?;
        let tallies = self.tallies(&raster);
        let planes = planes(&raster, &tallies);
        let ground = ground((&raster, &planes), || self.used(), used);
        let thresholds = |false_expected: f64| {
            let probability = (false_expected / (SCALES as f64 * used as f64)).min(0.1);
            SAMPLES.map(|samples| ground.tail.threshold(probability, samples))
        };
        let threshold = thresholds(self.false_expected)[0];
        let suspicions = thresholds(SUSPECTED * self.false_expected);
        let shapes = ground.shapes(&raster);
        let side_mm = raster.per_mm.recip();
        let coarseness = ((self.window_mm / ACROSS as f64 / side_mm).round() as usize).max(1);
        let coarse = Coarse::new(&raster, &tallies, coarseness);
        let residuals = coarse.residuals(&raster, &tallies);
        let scales = Scales::of((&raster, &shapes), &residuals, self.sigma_mm);
        let ground = ground.with_colour((&raster, &shapes), &planes, scales.single_mm);
        let mut suspect = vec![false; coarse.raster.size[0] * coarse.raster.size[1]];
        let flagged: Vec<usize> = (0..tallies.len())
            .into_par_iter()
            .with_min_len(4096)
            .filter(|&slot| scales.flags((&raster, &shapes), &residuals, slot, suspicions))
            .collect();
        for slot in flagged {
            suspect[coarse.over(&raster, slot)] = true;
        }
        let parts = coarse.parts(&suspect, used);
        if parts.is_whole {
            suspect.fill(true);
        }
        Ok(Parts {
            vertices: self.vertices(&coarse.raster, &parts),
            used,
            sigma_mm: scales.single_mm,
            threshold,
            ground,
            suspects: Suspects { raster: coarse.raster, cells: suspect },
        })
    }

    fn used(&self) -> impl Iterator<Item = (VertexId, PointMm, f64)> + '_ {
        (0..).zip(self.points.iter().zip(self.deviations_mm)).filter_map(
            |(vertex, (&point, &deviation))| {
                deviation.is_finite().then_some((vertex, point, deviation))
            },
        )
    }

    /// The cells over the extent of the samples, and how many samples there are.
    fn raster(&self) -> Result<(Raster, u64), DefectsUnknown> {
        let (bounds, used) = self
            .points
            .par_iter()
            .zip(self.deviations_mm)
            .with_min_len(1 << 16)
            .filter(|(_, deviation)| deviation.is_finite())
            .fold(
                || (BoundsMm::EMPTY, 0_u64),
                |(mut bounds, used), (&[x, y, _], _)| {
                    bounds.add([x, y]);
                    (bounds, used + 1)
                },
            )
            .reduce(
                || (BoundsMm::EMPTY, 0),
                |(mut bounds, used), (other, more)| {
                    bounds.join(&other);
                    (bounds, used + more)
                },
            );
        if used == 0 {
            return Err(DefectsUnknown::NoArea);
        }
        let side_mm = CELL_SPACINGS * self.spacing_mm;
        let extent_mm = bounds.size_mm();
        let counts = extent_mm.map(|extent| (extent / side_mm).floor() + 1.0);
        // Written so that NaN fails.
        if !(side_mm > 0.0 && counts[0] * counts[1] <= super::cells::most(used as usize)) {
            return Err(DefectsUnknown::Scattered { side_mm, extent_mm, points: used as usize });
        }
        let size = counts.map(|count| count as usize);
        Ok((Raster { low_mm: bounds.low, per_mm: side_mm.recip(), size }, used))
    }

    fn tallies(&self, raster: &Raster) -> Vec<Tally> {
        let mut tallies = vec![Tally::EMPTY; raster.size[0] * raster.size[1]];
        for (_, point, deviation) in self.used() {
            let slot = raster.slot(point);
            tallies[slot].add(raster.place_in(slot, point), deviation);
        }
        tallies
    }

    /// The vertices of each part.
    fn vertices(&self, raster: &Raster, part_of: &PartOf) -> Vec<Vec<VertexId>> {
        let mut vertices = vec![Vec::new(); part_of.count];
        if part_of.count > 0 {
            for (vertex, point, _) in self.used() {
                let part = part_of.slots[raster.slot(point)];
                if part != NONE {
                    vertices[part as usize].push(vertex);
                }
            }
        }
        vertices
    }
}

/// Remainder of a cell.
#[derive(Clone, Copy)]
struct Residual {
    count: f64,
    /// Sum of the residuals; NaN where there is no window.
    sum: f64,
    /// The largest size of one.
    extreme: f64,
    /// Mean of the squares about the slope of the form.
    square: f64,
}

const NOTHING: Residual = Residual { count: 0.0, sum: 0.0, extreme: 0.0, square: 0.0 };

/// Wider cells, and what is fitted to them.
struct Coarse {
    raster: Raster,
    /// Cells of the fine raster along one of these.
    coarseness: usize,
    /// Number and sum of the samples.
    sums: Vec<(f64, f64)>,
    /// Along each axis, the first cell of each window.
    firsts: [Vec<usize>; 2],
    /// The quartics of the windows, row by row, in half widths from their middles.
    fitted: Vec<Option<[f64; QUARTIC]>>,
}

impl Coarse {
    fn new(raster: &Raster, tallies: &[Tally], coarseness: usize) -> Coarse {
        let size = raster.size.map(|count| count.div_ceil(coarseness));
        let per_mm = raster.per_mm / coarseness as f64;
        let mut sums = vec![(0.0, 0.0); size[0] * size[1]];
        for (slot, tally) in tallies.iter().enumerate().filter(|(_, tally)| tally.count > 0) {
            let (column, row) = (slot % raster.size[0], slot / raster.size[0]);
            let (count, sum) = &mut sums[row / coarseness * size[0] + column / coarseness];
            *count += f64::from(tally.count);
            *sum += tally.sum;
        }
        let firsts = size.map(|count| {
            let rest = count.saturating_sub(ACROSS);
            let windows = rest.div_ceil(ACROSS / 2) + 1;
            (0..windows).map(|window| (window * ACROSS / 2).min(rest)).collect()
        });
        let raster = Raster { low_mm: raster.low_mm, per_mm, size };
        let mut coarse = Coarse { raster, coarseness, sums, firsts, fitted: Vec::new() };
        let windows = coarse.firsts[0].len() * coarse.firsts[1].len();
        coarse.fitted = (0..windows)
            .into_par_iter()
            .map_init(Work::default, |work, window| coarse.fit(work, window))
            .collect();
        coarse
    }

    fn fit(&self, work: &mut Work, window: usize) -> Option<[f64; QUARTIC]> {
        let across = self.firsts[0].len();
        let [first, below] = [self.firsts[0][window % across], self.firsts[1][window / across]];
        work.rows.clear();
        for row in below..(below + ACROSS).min(self.raster.size[1]) {
            for column in first..(first + ACROSS).min(self.raster.size[0]) {
                let (count, sum) = self.sums[row * self.raster.size[0] + column];
                if count > 0.0 {
                    let mut terms = [0.0; TERMS];
                    terms[..QUARTIC].copy_from_slice(&quartic(
                        place(column as f64 + 0.5, first),
                        place(row as f64 + 0.5, below),
                    ));
                    let place = [column - first, row - below];
                    work.rows.push(Row { terms, height_mm: sum / count, count, place });
                }
            }
        }
        let fitted = work.fit(QUARTIC)?;
        let mut terms = [0.0; QUARTIC];
        terms.copy_from_slice(&fitted.terms[..QUARTIC]);
        Some(terms)
    }

    /// The window whose middle is nearest to a cell, of those near it that have a quartic.
    fn window(&self, at: [f64; 2]) -> Option<[usize; 2]> {
        let nearest = [0, 1].map(|axis| {
            let first = (at[axis] - 0.5 * ACROSS as f64) / (ACROSS as f64 / 2.0);
            (first.round().max(0.0) as usize).min(self.firsts[axis].len() - 1)
        });
        let has = |&[i, j]: &[usize; 2]| self.fitted[j * self.firsts[0].len() + i].is_some();
        if has(&nearest) {
            return Some(nearest);
        }
        let away = |&[i, j]: &[usize; 2]| {
            place(at[0], self.firsts[0][i]).abs().max(place(at[1], self.firsts[1][j]).abs())
        };
        let about = |axis: usize| {
            nearest[axis].saturating_sub(1)..(nearest[axis] + 2).min(self.firsts[axis].len())
        };
        about(1)
            .flat_map(|j| about(0).map(move |i| [i, j]))
            .filter(has)
            .min_by(|p, q| away(p).total_cmp(&away(q)))
    }

    /// What each cell of the fine raster leaves of its window.
    fn residuals(&self, raster: &Raster, tallies: &[Tally]) -> Vec<Residual> {
        tallies
            .par_iter()
            .with_min_len(4096)
            .enumerate()
            .map(|(slot, tally)| {
                if tally.count == 0 {
                    return NOTHING;
                }
                let count = f64::from(tally.count);
                let cell = [slot % raster.size[0], slot / raster.size[0]];
                let at = cell.map(|cell| (cell as f64 + 0.5) / self.coarseness as f64);
                let Some([i, j]) = self.window(at) else {
                    return Residual { count, sum: f64::NAN, extreme: f64::NAN, square: f64::NAN };
                };
                let terms = self.fitted[j * self.firsts[0].len() + i].as_ref();
                let level = |[x, y]: [f64; 2]| {
                    let at = quartic(place(x, self.firsts[0][i]), place(y, self.firsts[1][j]));
                    terms.map_or(f64::NAN, |terms| at.iter().zip(terms).map(|(p, q)| p * q).sum())
                };
                let side = 1.0 / self.coarseness as f64;
                let slope = [0, 1].map(|axis| {
                    let end = |way: f64| {
                        let mut at = at;
                        at[axis] += way * side;
                        level(at)
                    };
                    end(0.5) - end(-0.5)
                });
                let middle = tally.middle();
                let level: f64 = level([0, 1].map(|axis| at[axis] + middle[axis] * side));
                Residual {
                    count,
                    sum: tally.sum - count * level,
                    extreme: (tally.high - level).max(level - tally.low),
                    square: tally.squares_about(level, slope) / count,
                }
            })
            .collect()
    }

    /// Which of these cells a fine one lies in.
    fn over(&self, raster: &Raster, slot: usize) -> usize {
        let (column, row) = (slot % raster.size[0], slot / raster.size[0]);
        row / self.coarseness * self.raster.size[0] + column / self.coarseness
    }

    /// The suspect cells with half a window about them, by what hangs together.
    fn parts(&self, suspect: &[bool], used: u64) -> PartOf {
        let size = self.raster.size;
        let mut near = vec![false; suspect.len()];
        for slot in (0..suspect.len()).filter(|&slot| suspect[slot]) {
            let [columns, rows] = [(slot % size[0], 0), (slot / size[0], 1)].map(|(at, axis)| {
                at.saturating_sub(ACROSS / 2)..(at + ACROSS / 2 + 1).min(size[axis])
            });
            for row in rows {
                near[row * size[0] + columns.start..row * size[0] + columns.end].fill(true);
            }
        }
        let within: f64 =
            near.iter().zip(&self.sums).filter(|&(&near, _)| near).map(|(_, sum)| sum.0).sum();
        if within > MOST_LOOKED_AT * used as f64 {
            return PartOf { slots: vec![0; near.len()], count: 1, is_whole: true };
        }
        let mut part_of = PartOf { slots: vec![NONE; near.len()], count: 0, is_whole: false };
        let mut open = Vec::new();
        for start in 0..near.len() {
            if !near[start] || part_of.slots[start] != NONE {
                continue;
            }
            let part = part_of.count as u32;
            part_of.count += 1;
            part_of.slots[start] = part;
            open.push(start);
            while let Some(slot) = open.pop() {
                let (column, row) = (slot % size[0], slot / size[0]);
                for row in row.saturating_sub(1)..(row + 2).min(size[1]) {
                    for column in column.saturating_sub(1)..(column + 2).min(size[0]) {
                        let other = row * size[0] + column;
                        if near[other] && part_of.slots[other] == NONE {
                            part_of.slots[other] = part;
                            open.push(other);
                        }
                    }
                }
            }
        }
        part_of
    }
}

/// Which part each wider cell belongs to, or [`NONE`].
struct PartOf {
    slots: Vec<u32>,
    count: usize,
    /// Whether the one part is the whole surface.
    is_whole: bool,
}

/// A place in cells, in half widths of a window from its middle.
fn place(cells: f64, first: usize) -> f64 {
    let half = 0.5 * ACROSS as f64;
    (cells - first as f64 - half) / half
}

/// What the deviations of single residuals, and of sums over blocks by the root of their number, are taken for.
struct Scales {
    single_mm: f64,
    blocks_mm: [f64; BLOCKS],
}

impl Scales {
    fn of((raster, shapes): (&Raster, &[f64]), residuals: &[Residual], sigma_mm: f64) -> Scales {
        let step = residuals.len() / MEDIAN_OF + 1;
        let chosen = || {
            (0..residuals.len()).step_by(step).filter(|&slot| residuals[slot].square.is_finite())
        };
        let filled = || chosen().filter(|&slot| residuals[slot].count > 1.0);
        let mut squares: Vec<f64> =
            filled().map(|slot| residuals[slot].square / shapes[slot].powi(2)).collect();
        let middle = squares.len() / 2;
        let single_mm = match squares.get(middle) {
            Some(_) => squares.select_nth_unstable_by(middle, f64::total_cmp).1.sqrt(),
            None => 0.0,
        };
        let single_mm = single_mm.max(sigma_mm).max(f64::MIN_POSITIVE);
        let blocks_mm = std::array::from_fn(|block| {
            let mut sizes: Vec<f64> = chosen()
                .filter_map(|slot| {
                    Some(over_block(raster, residuals, slot, block)?.abs() / shapes[slot])
                })
                .filter(|size| size.is_finite())
                .collect();
            tail::scale(&mut sizes).unwrap_or(0.0).max(sigma_mm).max(f64::MIN_POSITIVE)
        });
        Scales { single_mm, blocks_mm }
    }

    /// Whether a cell is suspect. The sizes are those of single readings, and of means by widths.
    fn flags(
        &self,
        (raster, shapes): (&Raster, &[f64]),
        residuals: &[Residual],
        slot: usize,
        suspicions: [f64; SCALES],
    ) -> bool {
        let residual = residuals[slot];
        if residual.count == 0.0 {
            return false;
        }
        let shape = shapes[slot];
        let single_mm = shape * self.single_mm;
        if !residual.sum.is_finite() || residual.extreme > (suspicions[0] - SLACK) * single_mm {
            return true;
        }
        (0..BLOCKS).any(|block| {
            // A cell has about as many samples as the narrowest sum of several, blocks as many as the next, or more.
            let threshold = SHARE * suspicions[block + 1];
            over_block(raster, residuals, slot, block)
                .is_some_and(|sum| sum.abs() > threshold * shape * self.blocks_mm[block])
        })
    }
}

/// The sum of the residuals over the block of 1, 2×2 or 3×3 cells from a cell on, over the root of their number.
fn over_block(raster: &Raster, residuals: &[Residual], slot: usize, block: usize) -> Option<f64> {
    let (column, row) = (slot % raster.size[0], slot / raster.size[0]);
    let (mut sum, mut count) = (0.0, 0.0);
    for row in row..(row + block + 1).min(raster.size[1]) {
        for column in column..(column + block + 1).min(raster.size[0]) {
            let residual = residuals[row * raster.size[0] + column];
            if residual.count > 0.0 && residual.sum.is_finite() {
                sum += residual.sum;
                count += residual.count;
            }
        }
    }
    (count > 0.0).then(|| sum / count.sqrt())
}

/// Wider cells along a window.
const ACROSS: usize = 12;
/// Sizes of blocks.
const BLOCKS: usize = 3;
/// How many times as many false ones as are put up with may be expected where suspicion begins.
const SUSPECTED: f64 = 10.0;
/// By how many standard deviations the threshold of single readings is lower here.
const SLACK: f64 = 0.5;
/// The threshold of means here, over that of `detect.rs`.
const SHARE: f64 = 0.78;
/// Share of the surface from which on all of it is looked at closely.
const MOST_LOOKED_AT: f64 = 0.5;
/// Cells that are enough for a median.
const MEDIAN_OF: usize = 20_000;
