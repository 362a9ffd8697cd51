//! Form without ends that only windows of a few spacings follow.
//!
//! A ring about any place, or the crest of a wave, may be so narrow that no window with cells for its samples follows it. A
//! scratch of that width may be as smooth. But a scratch has ends, while such form closes on itself or runs from border to
//! border: it *divides* the surface. And it is smooth at the scale of the points: quartics over seven spacings leave nothing
//! but noise of it, while steep walls stay. That is told by the squares of all its samples, for there are many.

use super::{GROWTH, LEFT, LONG, SEED, SHARE, Taken, Windows, extent_mm, near, together};
use crate::defects::cells::Cells;
use crate::defects::reference::Reference;

impl Windows {
    /// Gives places to the finest windows where what these take off the wider ones' residuals is form without ends.
    pub(super) fn refine_finely(&mut self, cells: &Cells, sigma_mm: &[f64], wide: usize) {
        let fine = self.references.len() - 1;
        let pair = [wide, fine].map(|level| &self.references[level]);
        let taken_of = |cell: usize| Taken::of(cells, cell, pair, sigma_mm[cell]);
        let taken: Vec<Option<Taken>> = (0..cells.len())
            .map(|cell| (self.level[cell] == wide).then(|| taken_of(cell)).flatten())
            .collect();
        let energies: Vec<Option<Energy>> = (0..cells.len())
            .map(|cell| taken[cell].and_then(|_| Energy::of(cells, cell, pair, sigma_mm[cell])))
            .collect();
        let clear = |cell: usize| taken[cell].map_or(0.0, |taken| taken.significance);
        let mut seeds: Vec<usize> = (0..cells.len()).filter(|&cell| clear(cell) > SEED).collect();
        seeds.sort_by(|&p, &q| clear(q).total_cmp(&clear(p)).then(p.cmp(&q)));
        // What was judged already; what of it a form may run through, for it is no form itself; and what of that stays.
        let mut judged = vec![false; cells.len()];
        let mut closes = vec![false; cells.len()];
        let mut stays = vec![false; cells.len()];
        let mut forms = Vec::new();
        for seed in seeds {
            if judged[seed] {
                continue;
            }
            let least = (SHARE * clear(seed)).max(GROWTH);
            let is_raised = |cell: usize| taken[cell].is_some_and(|taken| taken.off > 0.0);
            let set = together(cells, seed, |cell| {
                !judged[cell] && clear(cell) >= least && is_raised(cell) == is_raised(seed)
            });
            set.iter().for_each(|&cell| judged[cell] = true);
            let least_mm = LONG * self.widths_mm[0];
            let is_form =
                extent_mm(cells, &set) >= least_mm && divides(cells, (&set, &closes), least_mm);
            if let Some(left) = is_form.then(|| share_left(&set, &energies)).flatten() {
                forms.push((set, left));
                continue;
            }
            for cell in set {
                closes[cell] = true;
                stays[cell] |= clear(seed) > STAYS;
            }
        }
        for (set, left) in forms {
            let size = |cell: usize| taken[cell].map_or(0.0, |taken| taken.size_mm);
            let missed_mm = |cell: usize| left.max(LEFT) * size(cell);
            self.narrow(cells, (&set, &stays), [wide, fine], missed_mm);
        }
    }
}

/// Squares of residuals of the samples of a cell, in those of noise.
#[derive(Clone, Copy)]
struct Energy {
    count: f64,
    /// Of what was taken off.
    off: f64,
    /// Of what is left, in what is expected of noise alone.
    left: f64,
}

impl Energy {
    /// What one of two references takes off the residuals of the other; `None` where one of them is not known.
    fn of(
        cells: &Cells,
        cell: usize,
        [wide, fine]: [&Reference; 2],
        sigma_mm: f64,
    ) -> Option<Energy> {
        let range = cells.range(cell);
        let unit_mm = sigma_mm * fine.secants[cell];
        // What quartics take of the noise itself.
        let share = (1.0 - fine.uncertainties[cell].powi(2)).max(LEAST_SHARE);
        let pairs = wide.residuals_mm[range.clone()].iter().zip(&fine.residuals_mm[range]);
        let sums = pairs.fold([0.0; 3], |[count, off, left], (before, after)| {
            let [moved, after] = [before - after, *after].map(|mm| (mm / unit_mm).powi(2));
            [count + 1.0, off + moved, left + after / share]
        });
        let [count, off, left] = sums;
        (off.is_finite() && left.is_finite()).then_some(Energy { count, off, left })
    }

    fn mean_left(&self) -> f64 {
        self.left / self.count
    }
}

/// Whether a set of cells parts the surface in more pieces that are no smaller than a length each. What `closes` it lies in it
/// but is no form, a pit on a ring for instance.
fn divides(cells: &Cells, (set, closes): (&[usize], &[bool]), least_mm: f64) -> bool {
    let mut without = closes.to_vec();
    set.iter().for_each(|&cell| without[cell] = false);
    let mut with = closes.to_vec();
    for &cell in set {
        near(cells, cell, 1).for_each(|near| with[near] = true);
    }
    pieces(cells, with, least_mm) > pieces(cells, without, least_mm)
}

/// Pieces of the surface without the cells that are `seen`, as far as they are no smaller than a length.
fn pieces(cells: &Cells, mut seen: Vec<bool>, least_mm: f64) -> usize {
    let mut count = 0;
    for first in 0..cells.len() {
        if seen[first] {
            continue;
        }
        seen[first] = true;
        let mut piece = vec![first];
        let mut next = 0;
        while let Some(&cell) = piece.get(next) {
            next += 1;
            let [column, row] = cells.places[cell].map(i64::from);
            for [i, j] in [[-1, 0], [1, 0], [0, -1], [0, 1]] {
                if let Some(other) = cells.at(column + i, row + j)
                    && !seen[other]
                {
                    seen[other] = true;
                    piece.push(other);
                }
            }
        }
        count += usize::from(extent_mm(cells, &piece) >= least_mm);
    }
    count
}

/// Remainder of a set over what was taken off, by root mean squares; `None` if it is more than smooth form leaves. Noise is
/// what the cells outside of the set have.
fn share_left(set: &[usize], energies: &[Option<Energy>]) -> Option<f64> {
    let mut outside = energies.to_vec();
    set.iter().for_each(|&cell| outside[cell] = None);
    let (noise, count) = trimmed(outside.into_iter().flatten());
    let inside: Vec<Energy> = set.iter().filter_map(|&cell| energies[cell]).collect();
    let off: f64 = inside.iter().map(|energy| energy.off).sum();
    let (left, samples) = trimmed(inside.into_iter());
    if count == 0.0 || samples == 0.0 {
        return None;
    }
    let unit = noise / count;
    let chance = CHANCE * unit * (2.0 * samples).sqrt();
    let excess = left - unit * samples;
    (excess <= SMOOTH * off + chance).then(|| (excess.max(0.0) / off).sqrt())
}

/// Sum of what is left without the cells of which most is, and the samples in it: small defects do not count.
fn trimmed(energies: impl Iterator<Item = Energy>) -> (f64, f64) {
    let mut all: Vec<Energy> = energies.collect();
    all.sort_unstable_by(|p, q| p.mean_left().total_cmp(&q.mean_left()));
    all.truncate(((1.0 - SET_ASIDE) * all.len() as f64).ceil() as usize);
    all.iter().fold((0.0, 0.0), |(left, count), of| (left + of.left, count + of.count))
}

/// Most of the squares taken off that smooth form leaves: a ridge of Gaussian section leaves 0.001 if it is five spacings wide
/// at half of its height, and 0.04 if it is three; one with steep walls 0.1 of any width.
const SMOOTH: f64 = 0.02;
/// Standard deviations from which on what is no form stays with the wider windows where form runs through it.
const STAYS: f64 = 8.0;
/// Share of the cells whose leftovers do not count.
const SET_ASIDE: f64 = 0.03;
/// Standard deviations that the noise of what is left may add.
const CHANCE: f64 = 1.0;
/// Least share of the noise that a window is taken to leave.
const LEAST_SHARE: f64 = 0.1;
