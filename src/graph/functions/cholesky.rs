//! The factor of 1 minus the operator, front by front (J. W. H. Liu, SIAM Review 34 (1992) 82-109, doi:10.1137/1034004), and
//! solutions by it.
//!
//! The matrix is singular: the roots of the degrees solve it with nothing on the right. Its last pivot is 0 but for rounding, and is
//! taken as 1. So one of all solutions is found, and the one wanted is that without a share of the null vector.

use rayon::prelude::*;

use super::dissection::{Dissection, Front};
use super::laplacian::Laplacian;

/// Values of some functions at a place.
pub(super) type Row = [f64; COLUMNS];

/// Functions that are solved for at once.
pub(super) const COLUMNS: usize = 6;

/// The factor. Sums run in an order that the fronts fix: threads change no bit.
pub(super) struct Cholesky {
    dissection: Dissection,
    /// Columns of the pivots of each front, over all its rows.
    panels: Vec<Vec<f64>>,
}

impl Cholesky {
    /// The factor of the operator of a cloud in one piece; `None` where rounding spoils a pivot.
    pub(super) fn new(operator: &Laplacian, dissection: Dissection) -> Option<Cholesky> {
        let mut panels = vec![Vec::new(); dissection.fronts.len()];
        let of = Eliminated { operator, dissection: &dissection };
        of.eliminate(dissection.fronts.len() - 1, &mut panels)?;
        Some(Cholesky { dissection, panels })
    }

    /// A solution for rows on the right, both by place.
    pub(super) fn solve(&self, right: &[Row]) -> Vec<Row> {
        let order = &self.dissection.order;
        let mut rows: Vec<Row> = order.par_iter().map(|&place| right[place as usize]).collect();
        let last = self.panels.len() - 1;
        self.forward(last, &mut rows);
        self.backward(last, &mut rows, &[]);
        self.dissection.position.par_iter().map(|&position| rows[position as usize]).collect()
    }

    /// Solves from below up to a front; gives what its border has to bear.
    fn forward(&self, at: usize, rows: &mut [Row]) -> Vec<Row> {
        let front = &self.dissection.fronts[at];
        let (below, own) = rows.split_at_mut(rows.len() - front.pivots);
        let mut all = vec![[0.0; COLUMNS]; front.rows()];
        all[..front.pivots].copy_from_slice(own);
        let parts = self.parts(front, at, below);
        let border = each(front, parts, |(below, rows)| self.forward(below, rows));
        for (&below, border) in front.below.iter().zip(border) {
            for (&row, value) in self.dissection.fronts[below].above.iter().zip(border) {
                add(&mut all[row as usize], &value, 1.0);
            }
        }
        solve_down(&self.panels[at], &mut all);
        own.copy_from_slice(&all[..front.pivots]);
        all.split_off(front.pivots)
    }

    /// Solves from a front downwards, with what its border is.
    fn backward(&self, at: usize, rows: &mut [Row], border: &[Row]) {
        let front = &self.dissection.fronts[at];
        let (below, own) = rows.split_at_mut(rows.len() - front.pivots);
        let mut all = [&*own, border].concat();
        solve_up(&self.panels[at], &mut all);
        own.copy_from_slice(&all[..front.pivots]);
        let parts = self.parts(front, at, below);
        each(front, parts, |(below, rows)| {
            let above = self.dissection.fronts[below].above.iter();
            let border: Vec<Row> = above.map(|&row| all[row as usize]).collect();
            self.backward(below, rows, &border);
        });
    }

    /// The fronts below one, each with its rows.
    fn parts<'a>(
        &self,
        front: &Front,
        at: usize,
        mut rows: &'a mut [Row],
    ) -> Vec<(usize, &'a mut [Row])> {
        let mut parts = Vec::new();
        for &below in &front.below {
            debug_assert!(below < at);
            let (own, further) = rows.split_at_mut(self.dissection.fronts[below].places);
            parts.push((below, own));
            rows = further;
        }
        parts
    }
}

/// The work for each front below one, on two threads where there is much of it.
fn each<T: Send, R: Send>(
    front: &Front,
    mut parts: Vec<T>,
    work: impl Fn(T) -> R + Sync,
) -> Vec<R> {
    if parts.len() == 2
        && front.places > SHARED
        && let (Some(right), Some(left)) = (parts.pop(), parts.pop())
    {
        let (left, right) = rayon::join(|| work(left), || work(right));
        return vec![left, right];
    }
    parts.into_iter().map(work).collect()
}

/// Solves for the pivots of a front, and takes their part from its border. Two columns at a time load and store half as often.
fn solve_down(panel: &[f64], rows: &mut [Row]) {
    let count = rows.len().max(1);
    for (pair, columns) in panel.chunks(2 * count).enumerate() {
        let pivot = 2 * pair;
        let (first, second) = columns.split_at(count);
        let (done, ahead) = rows.split_at_mut(pivot + 1);
        let one = done[pivot].map(|value| value / first[pivot]);
        done[pivot] = one;
        if second.is_empty() {
            for (row, factor) in ahead.iter_mut().zip(&first[pivot + 1..]) {
                add(row, &one, -factor);
            }
            return;
        }
        let (next, ahead) = ahead.split_at_mut(1);
        add(&mut next[0], &one, -first[pivot + 1]);
        let two = next[0].map(|value| value / second[pivot + 1]);
        next[0] = two;
        let factors = first[pivot + 2..].iter().zip(&second[pivot + 2..]);
        for (row, (a, b)) in ahead.iter_mut().zip(factors) {
            for (at, value) in row.iter_mut().enumerate() {
                *value -= a * one[at] + b * two[at];
            }
        }
    }
}

/// Solves for the pivots of a front whose border is known, two columns at a time.
fn solve_up(panel: &[f64], rows: &mut [Row]) {
    let count = rows.len().max(1);
    for (pair, columns) in panel.chunks(2 * count).enumerate().rev() {
        let pivot = 2 * pair;
        let (first, second) = columns.split_at(count);
        let (done, ahead) = rows.split_at_mut(pivot + 1);
        let mut one = [0.0; COLUMNS];
        if second.is_empty() {
            for (row, factor) in ahead.iter().zip(&first[pivot + 1..]) {
                add(&mut one, row, *factor);
            }
        } else {
            let (next, ahead) = ahead.split_at_mut(1);
            let mut two = [0.0; COLUMNS];
            let factors = first[pivot + 2..].iter().zip(&second[pivot + 2..]);
            for (row, (a, b)) in ahead.iter().zip(factors) {
                add(&mut one, row, *a);
                add(&mut two, row, *b);
            }
            for (value, sum) in next[0].iter_mut().zip(two) {
                *value = (*value - sum) / second[pivot + 1];
            }
            add(&mut one, &next[0], first[pivot + 1]);
        }
        for (value, sum) in done[pivot].iter_mut().zip(one) {
            *value = (*value - sum) / first[pivot];
        }
    }
}

fn add(row: &mut Row, other: &Row, times: f64) {
    for (value, other) in row.iter_mut().zip(other) {
        *value += times * other;
    }
}

struct Eliminated<'a> {
    operator: &'a Laplacian,
    dissection: &'a Dissection,
}

impl Eliminated<'_> {
    /// Eliminates the pivots of a front and of all below it; gives what is left for its border, column by column. `panels` are
    /// those of all these fronts.
    fn eliminate(&self, at: usize, panels: &mut [Vec<f64>]) -> Option<Vec<f64>> {
        let front = &self.dissection.fronts[at];
        let (below, own) = panels.split_at_mut(front.fronts - 1);
        let mut parts = Vec::new();
        let mut further = below;
        for &below in &front.below {
            let (part, others) = further.split_at_mut(self.dissection.fronts[below].fronts);
            parts.push((below, part));
            further = others;
        }
        let updates = each(front, parts, |(below, panels)| self.eliminate(below, panels));
        let (rows, pivots) = (front.rows(), front.pivots);
        let border = rows - pivots;
        let mut panel = vec![0.0; rows * pivots];
        let mut update = vec![0.0; border * border];
        self.fill(front, &mut panel);
        for (&below, given) in front.below.iter().zip(updates) {
            let (above, given) = (&self.dissection.fronts[below].above, given?);
            for (column, values) in given.chunks_exact(above.len().max(1)).enumerate() {
                let into = above[column] as usize;
                let (target, skipped) = match into.checked_sub(pivots) {
                    None => (&mut panel[into * rows..][..rows], 0),
                    Some(into) => (&mut update[into * border..][..border], pivots),
                };
                for (&row, value) in above[column..].iter().zip(&values[column..]) {
                    target[row as usize - skipped] += value;
                }
            }
        }
        let is_last = front.first + pivots == self.dissection.order.len();
        reduce(&mut panel, &mut update, (rows, pivots), is_last)?;
        own[0] = panel;
        Some(update)
    }

    /// Writes the entries of the matrix into the columns of the pivots.
    fn fill(&self, front: &Front, panel: &mut [f64]) {
        for (pivot, column) in panel.chunks_exact_mut(front.rows().max(1)).enumerate() {
            column[pivot] = 1.0;
            let own = front.first + pivot;
            let place = self.dissection.order[own] as usize;
            for (other, weight) in self.operator.neighbours(place) {
                let position = self.dissection.position[other];
                if position as usize > own {
                    column[front.row(position)] -= weight;
                }
            }
        }
    }
}

/// Cholesky's method on the pivots of a front: the panel becomes columns of the factor, the update what is left.
fn reduce(
    panel: &mut [f64],
    update: &mut [f64],
    (rows, pivots): (usize, usize),
    is_last: bool,
) -> Option<()> {
    for start in (0..pivots).step_by(DEPTH) {
        let end = (start + DEPTH).min(pivots);
        let (done, ahead) = panel.split_at_mut(end * rows);
        let block = &mut done[start * rows..];
        for own in start..end {
            let (before, from) = block.split_at_mut((own - start) * rows);
            let column = &mut from[..rows];
            for other in before.chunks_exact(rows) {
                let factor = other[own];
                for (value, other) in column[own..].iter_mut().zip(&other[own..]) {
                    *value -= factor * other;
                }
            }
            let mut pivot = column[own];
            if is_last && own + 1 == pivots {
                pivot = 1.0;
            }
            if pivot.is_nan() || pivot <= 0.0 {
                return None;
            }
            let root = pivot.sqrt();
            column[own..].iter_mut().for_each(|value| *value /= root);
            column[own] = root;
        }
        for (at, column) in ahead.chunks_exact_mut(rows).enumerate() {
            subtract(&mut column[end + at..], block, (rows, end + at));
        }
        let border = rows - pivots;
        for (at, column) in update.chunks_exact_mut(border.max(1)).enumerate() {
            subtract(&mut column[at..], block, (rows, pivots + at));
        }
    }
    Some(())
}

/// Subtracts from the rows of a column, from `first` on, what columns of a block have there times their entry in row `first`.
fn subtract(target: &mut [f64], block: &[f64], (rows, first): (usize, usize)) {
    let count = target.len();
    if block.len() == DEPTH * rows {
        let column = |at: usize| &block[at * rows + first..][..count];
        let columns: [&[f64]; DEPTH] = std::array::from_fn(column);
        let factors: [f64; DEPTH] = columns.map(|column| column[0]);
        let [a, b, c, d, e, f, g, h] = columns;
        for (at, value) in target.iter_mut().enumerate() {
            let one = a[at] * factors[0] + b[at] * factors[1];
            let two = c[at] * factors[2] + d[at] * factors[3];
            let three = e[at] * factors[4] + f[at] * factors[5];
            let four = g[at] * factors[6] + h[at] * factors[7];
            *value -= (one + two) + (three + four);
        }
        return;
    }
    for column in block.chunks_exact(rows) {
        let column = &column[first..];
        let factor = column[0];
        for (value, other) in target.iter_mut().zip(column) {
            *value -= factor * other;
        }
    }
}

/// Columns that are subtracted at once.
const DEPTH: usize = 8;

/// Fronts over more places are parted on two threads.
const SHARED: usize = 4_000;
