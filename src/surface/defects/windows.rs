//! How wide the windows of the reference are, by place.
//!
//! A defect is to stand off a reference that it does not move, so windows are wide against it. Form that is narrower than
//! they can follow, a ring or a turned edge, then stands off as well. So there are references of several widths, each half
//! of the one before, and a narrower one takes over where what they differ by is form:
//!
//! 1. It is *long*: it hangs together over more than 0.6 of the widest window. A pit is compact.
//! 2. It is *smooth*: the narrower reference follows it, and what it leaves is a small share of what it takes off. A
//!    scratch is steep at the scale of the points: no quartic over fifteen spacings follows it.
//!
//! Where form is long, and no such window follows it, windows of a few spacings may (`windows/fine.rs`).
//!
//! An edge along a border is form too, even where a piece of it fails these tests: bands beside the border go to narrower
//! windows as a whole, if these move them alike all along or already follow a part of them (`edges.rs`).
//!
//! What is compact or steep stays with the wider windows, with all about it that a window smears it over. What a reference of the chosen
//! width may still miss is told by how far the next one is from it (`followed.rs`), and where there is none by a share of
//! what it took off.

mod fine;

use std::collections::BTreeSet;

use super::cells::Cells;
use super::edges::Edges;
use super::line::Line;
use super::reference::Reference;
use super::{DefectsUnknown, Samples, followed, tail};

/// References of several widths.
pub(super) struct References<'a> {
    samples: &'a Samples<'a>,
    steps: Vec<Line>,
    /// The widest first.
    of: Vec<Reference>,
    widths_mm: Vec<f64>,
}

/// References of several widths, and where each is used.
struct Windows {
    references: Vec<Reference>,
    widths_mm: Vec<f64>,
    /// By cell, which of them.
    level: Vec<usize>,
    /// By cell, what narrower windows may miss of what they took off, in mm.
    missed_mm: Vec<f64>,
    /// Whether anything is long that the narrowest windows do not follow.
    is_long_left: bool,
}

/// What the choice goes by, and what it gives.
pub(super) struct ByPlace {
    pub(super) reference: Reference,
    /// By cell what the reference misses of the form, in mm along the normal.
    pub(super) missed_mm: Vec<f64>,
}

impl<'a> References<'a> {
    /// References that may jump at some steps, see [`Reference::new`].
    pub(super) fn new(
        samples: &'a Samples<'a>,
        cells: &Cells,
        window_mm: f64,
        steps: &[Line],
    ) -> Result<References<'a>, DefectsUnknown> {
        let mut of = vec![Reference::new(samples, cells, window_mm, steps, false)?];
        let mut widths_mm = vec![window_mm];
        loop {
            let narrower_mm = 0.5 * widths_mm[widths_mm.len() - 1];
            // A window for what the widest misses is needed even where it has few cells.
            if of.len() > 1 && narrower_mm < CELLS_LEAST * cells.side_mm {
                break;
            }
            match Reference::new(samples, cells, narrower_mm, steps, false) {
                Ok(reference) => of.push(reference),
                Err(DefectsUnknown::NoReference { .. }) => break,
                Err(other) => return Err(other),
            }
            widths_mm.push(narrower_mm);
        }
        Ok(References { samples, steps: steps.to_vec(), of, widths_mm })
    }

    /// That of the widest windows, and that of the narrowest.
    pub(super) fn ends(&self) -> [&Reference; 2] {
        [&self.of[0], &self.of[self.of.len() - 1]]
    }

    /// The reference of windows as wide as the form of each place allows. `sigma_mm` is the noise of single samples by cell.
    pub(super) fn by_place(self, cells: &Cells, sigma_mm: &[f64]) -> ByPlace {
        let (count, levels) = (cells.len(), self.of.len());
        let References { samples, steps, of: references, widths_mm } = self;
        let (level, missed_mm) = (vec![0; count], vec![0.0; count]);
        let mut windows = Windows { references, widths_mm, level, missed_mm, is_long_left: false };
        for wide in 0..levels {
            for narrow in wide + 1..levels {
                windows.refine(cells, sigma_mm, wide, narrow);
            }
            if wide + 1 < levels {
                windows.follow_edges(cells, sigma_mm, wide);
            }
        }
        if windows.is_long_left {
            let fine_mm = 0.5 * windows.widths_mm[levels - 1];
            if let Ok(fine) = Reference::new(samples, cells, fine_mm, &steps, false) {
                windows.references.push(fine);
                windows.widths_mm.push(fine_mm);
                (0..levels).for_each(|wide| windows.refine_finely(cells, sigma_mm, wide));
            }
        }
        windows.chosen(cells, levels)
    }
}

impl Windows {
    /// Gives places to narrower windows where what these take off the wider ones' residuals is form.
    fn refine(&mut self, cells: &Cells, sigma_mm: &[f64], wide: usize, narrow: usize) {
        let [from, to] = [wide, narrow].map(|level| &self.references[level]);
        let cell_of = |cell: usize| Taken::of(cells, cell, [from, to], sigma_mm[cell]);
        let mut taken: Vec<Option<Taken>> = (0..cells.len())
            .map(|cell| (self.level[cell] == wide).then(|| cell_of(cell)).flatten())
            .collect();
        // Means of cells may vary by more than noise that is white lets them.
        let mut left: Vec<f64> = taken.iter().flatten().map(|taken| taken.left.abs()).collect();
        let scatter = tail::scale(&mut left).unwrap_or(1.0);
        let colour = scatter.max(1.0);
        let mut seeds: Vec<usize> = (0..cells.len())
            .filter(|&cell| taken[cell].is_some_and(|taken| taken.significance > SEED * colour))
            .collect();
        let size =
            |cell: usize, taken: &[Option<Taken>]| taken[cell].map_or(0.0, |one| one.size_mm);
        // Form runs away from a quartic towards the rim of its window as noise does.
        let clear =
            |cell: usize, taken: &[Option<Taken>]| taken[cell].map_or(0.0, |one| one.significance);
        seeds.sort_by(|&p, &q| clear(q, &taken).total_cmp(&clear(p, &taken)).then(p.cmp(&q)));
        for seed in seeds {
            if taken[seed].is_none() {
                continue;
            }
            let least = (SHARE * clear(seed, &taken)).max(GROWTH * colour);
            let set = together(cells, seed, |cell| {
                taken[cell].is_some_and(|taken| taken.significance >= least)
            });
            let long = extent_mm(cells, &set) >= LONG * self.widths_mm[0];
            let most = FOLLOWED[(narrow - 1).min(FOLLOWED.len() - 1)];
            let left = if long { share_left(&set, &taken, (scatter, most)) } else { None };
            if let Some(left) = left {
                let size = |cell: usize| left.max(LEFT) * size(cell, &taken);
                self.narrow(cells, (&set, &[]), [wide, narrow], size);
            }
            self.is_long_left |= long && left.is_none() && narrow + 1 == self.references.len();
            // What a compact defect moves in the narrower windows, or a scratch or step in the wider ones, is no form.
            let about = match (long, left) {
                (false, _) => self.smear(cells, narrow),
                (true, None) => self.smear(cells, wide),
                (true, Some(_)) => 0,
            };
            for cell in set {
                near(cells, cell, about).for_each(|near| taken[near] = None);
            }
        }
    }

    /// Gives bands along a border to windows half as wide where these follow form that is alike all along.
    fn follow_edges(&mut self, cells: &Cells, sigma_mm: &[f64], wide: usize) {
        let [from, to] = [wide, wide + 1].map(|level| &self.references[level]);
        let taken: Vec<Option<Taken>> = (0..cells.len())
            .map(|cell| Taken::of(cells, cell, [from, to], sigma_mm[cell]))
            .collect();
        let mut left: Vec<f64> = taken.iter().flatten().map(|taken| taken.left.abs()).collect();
        let scatter = tail::scale(&mut left).unwrap_or(1.0);
        let least = ALIKE * scatter.max(1.0);
        let form = |rings: &[Vec<usize>]| {
            let band = rings.concat();
            let narrower = band.iter().filter(|&&cell| self.level[cell] > wide).count() as f64;
            let part = narrower / band.len() as f64;
            let moved = || quarter_moved(&band, &taken) > MOVED * scatter.max(1.0);
            part > SOME && moved()
                || rings.iter().any(|ring| middle_off(ring, &taken).abs() > least)
        };
        let edges = Edges::new(cells, self.widths_mm[wide]);
        for band in edges.inwards(form) {
            let scale = |of: fn(&Taken) -> f64| {
                let sizes = band.iter().filter_map(|&cell| taken[cell].as_ref());
                tail::scale(&mut sizes.map(|taken| of(taken).abs()).collect::<Vec<_>>())
                    .unwrap_or(0.0)
            };
            let [off, left] = [scale(|taken| taken.off), scale(|taken| taken.left)];
            let left = (left * left - scatter * scatter).max(0.0).sqrt() / off;
            let missed_mm =
                |cell: usize| left.max(LEFT) * taken[cell].map_or(0.0, |taken| taken.size_mm);
            self.narrow(cells, (&band, &[]), [wide, wide + 1], missed_mm);
        }
    }

    /// Gives a set of cells, and those beside it that do not stay, to narrower windows. `missed_mm` is what these may miss of
    /// the form there.
    fn narrow(
        &mut self,
        cells: &Cells,
        (set, stays): (&[usize], &[bool]),
        [wide, narrow]: [usize; 2],
        missed_mm: impl Fn(usize) -> f64,
    ) {
        for &cell in set {
            for near in near(cells, cell, BESIDE) {
                if self.level[near] == wide && !stays.get(near).is_some_and(|&stays| stays) {
                    (self.level[near], self.missed_mm[near]) = (narrow, 0.0);
                }
            }
        }
        let smear = self.smear(cells, narrow);
        for &cell in set {
            let missed_mm = missed_mm(cell);
            for near in near(cells, cell, smear) {
                if self.level[near] == narrow {
                    self.missed_mm[near] = self.missed_mm[near].max(missed_mm);
                }
            }
        }
    }

    /// How far a window reaches, in cells.
    fn smear(&self, cells: &Cells, level: usize) -> i64 {
        (0.5 * self.widths_mm[level] / cells.side_mm).round() as i64
    }

    /// The residuals of the windows that were chosen. What narrower windows miss is known of the first `levels`.
    fn chosen(mut self, cells: &Cells, levels: usize) -> ByPlace {
        let mut missed_mm = vec![0.0; cells.len()];
        for level in 0..levels - 1 {
            if level > 0 && !self.level.contains(&level) {
                continue;
            }
            let pair = [&self.references[level], &self.references[level + 1]];
            let missed = followed::missed_mm(cells, pair, self.widths_mm[level]);
            for (cell, missed) in missed.into_iter().enumerate() {
                if self.level[cell] == level {
                    missed_mm[cell] = missed;
                }
            }
        }
        let narrower = self.references.split_off(1);
        let mut reference = self.references.remove(0);
        for (cell, &level) in self.level.iter().enumerate() {
            // The narrowest that there is: at a border there may be none so narrow.
            let known = |level: &usize| narrower[level - 1].uncertainties[cell].is_finite();
            let Some(level) = (1..=level).rev().find(known) else { continue };
            let other = &narrower[level - 1];
            let range = cells.range(cell);
            reference.residuals_mm[range.clone()].copy_from_slice(&other.residuals_mm[range]);
            reference.secants[cell] = other.secants[cell];
            reference.uncertainties[cell] = other.uncertainties[cell];
            // Form runs away from a quartic towards the rim of its window as noise does.
            let rim = (other.uncertainties[cell] / other.typical).max(1.0);
            missed_mm[cell] = missed_mm[cell].hypot(rim * rim * self.missed_mm[cell]);
        }
        ByPlace { reference, missed_mm }
    }
}

/// What a narrower reference takes off the residuals of a cell.
#[derive(Clone, Copy)]
struct Taken {
    size_mm: f64,
    /// Its size over its standard deviation.
    significance: f64,
    /// The same with its sign, over the deviation of a cell's mean.
    off: f64,
    /// What is left over that.
    left: f64,
}

impl Taken {
    fn of(cells: &Cells, cell: usize, [from, to]: [&Reference; 2], sigma_mm: f64) -> Option<Taken> {
        let range = cells.range(cell);
        let count = range.len() as f64;
        let [before, after] = [from, to].map(|of| {
            of.residuals_mm[range.clone()].iter().sum::<f64>() / count / of.secants[cell]
        });
        let size_mm = (before - after).abs();
        let deviation = from.uncertainties[cell].hypot(to.uncertainties[cell]);
        let per_mm = count.sqrt() / sigma_mm;
        let taken = Taken {
            size_mm,
            significance: size_mm / (sigma_mm * deviation),
            off: (before - after) * per_mm,
            left: after * per_mm,
        };
        (taken.significance.is_finite() && taken.left.is_finite()).then_some(taken)
    }
}

/// The median of what was taken off some cells.
fn middle_off(set: &[usize], taken: &[Option<Taken>]) -> f64 {
    part_of(set, taken, 2, |taken| taken.off)
}

/// The significance of what was taken off that all but a quarter of some cells exceed, over what it is of normal noise.
fn quarter_moved(set: &[usize], taken: &[Option<Taken>]) -> f64 {
    part_of(set, taken, 4, |taken| taken.significance) / QUARTER
}

/// The value that one in `parts` of some cells falls short of; 0 without any.
fn part_of(set: &[usize], taken: &[Option<Taken>], parts: usize, of: impl Fn(Taken) -> f64) -> f64 {
    let mut values: Vec<f64> = set.iter().filter_map(|&cell| taken[cell]).map(of).collect();
    if values.is_empty() {
        return 0.0;
    }
    let at = values.len() / parts;
    *values.select_nth_unstable_by(at, f64::total_cmp).1
}

/// Remainder of a set of cells over what was taken off, by root mean squares, if its square is no more than the share
/// `most`. `scatter` is the standard deviation of what noise leaves.
fn share_left(set: &[usize], taken: &[Option<Taken>], (scatter, most): (f64, f64)) -> Option<f64> {
    let all = || set.iter().filter_map(|&cell| taken[cell]);
    let off: f64 = all().map(|cell| cell.off * cell.off).sum();
    let mut left: Vec<f64> = all().map(|cell| cell.left * cell.left).collect();
    left.sort_unstable_by(f64::total_cmp);
    left.truncate(((1.0 - SET_ASIDE) * left.len() as f64).ceil() as usize);
    let noise = scatter * scatter;
    let chance = CHANCE * noise * (2.0 * left.len() as f64).sqrt();
    let excess = left.iter().sum::<f64>() - KEPT * noise * left.len() as f64;
    (excess <= most * off + chance).then(|| (excess.max(0.0) / off).sqrt())
}

/// The cells that hang together with one.
fn together(cells: &Cells, first: usize, belongs: impl Fn(usize) -> bool) -> Vec<usize> {
    let mut seen = BTreeSet::from([first]);
    let mut set = vec![first];
    let mut next = 0;
    while let Some(&cell) = set.get(next) {
        next += 1;
        for other in near(cells, cell, 1) {
            if belongs(other) && seen.insert(other) {
                set.push(other);
            }
        }
    }
    set
}

/// The cells in the square of some cells to either side about one.
fn near(cells: &Cells, cell: usize, reach: i64) -> impl Iterator<Item = usize> + '_ {
    let [column, row] = cells.places[cell].map(i64::from);
    (row - reach..=row + reach).flat_map(move |row| {
        (column - reach..=column + reach).filter_map(move |column| cells.at(column, row))
    })
}

/// The longer side of the rectangle about cells.
fn extent_mm(cells: &Cells, set: &[usize]) -> f64 {
    let side = |axis: usize| {
        let places = set.iter().map(|&cell| cells.places[cell][axis]);
        let (low, high) = places.fold((u32::MAX, 0), |(low, high), at| (low.min(at), high.max(at)));
        f64::from(high - low + 1) * cells.side_mm
    };
    side(0).max(side(1))
}

/// Fewest cells along a window that is chosen.
const CELLS_LEAST: f64 = 5.9;
/// Standard deviations from which on what was taken off is looked at, and down to which it goes on.
const SEED: f64 = 4.0;
const GROWTH: f64 = 2.5;
/// Share of the largest down to which it goes on.
const SHARE: f64 = 0.2;
/// Cells beside form that go with it.
const BESIDE: i64 = 3;
/// Shortest form in widest windows: a compact defect a third of a window wide is no longer.
const LONG: f64 = 0.6;
/// Most of what was taken off that may be left, in squares, by windows half and a quarter as wide as the widest: of a ring as
/// wide as half the window 0.002 is, of a groove with steep walls a third of the window wide 0.4 of the half windows and
/// 0.01 of the quarter ones, of a step 0.3.
const FOLLOWED: [f64; 2] = [0.03, 0.003];
/// Share of the cells whose leftovers do not count: small defects on the form.
const SET_ASIDE: f64 = 0.03;
/// Mean square of what then is left of normal noise.
const KEPT: f64 = 0.83;
/// Standard deviations that the noise of what is left may add.
const CHANCE: f64 = 0.5;
/// The least a narrow window may miss of what it took off.
const LEFT: f64 = 0.025;
/// The median of what was taken off a ring along a border, from which on it is form, in deviations of a cell's mean: of white
/// noise and single defects it is up to 0.25, of edges up to 20. Down to 0.3 hides defects beside wide rings.
const ALIKE: f64 = 1.5;
/// Share of a band along a border that follows form already, from which on all of it does if it is moved, and by how much:
/// noise alone moves it by 0.7, but several wide pits by up to 1.5, so that this alone tells no form.
const SOME: f64 = 0.03;
const MOVED: f64 = 1.2;
/// The size that a quarter of normal values of deviation 1 falls short of.
const QUARTER: f64 = 0.318_639;
