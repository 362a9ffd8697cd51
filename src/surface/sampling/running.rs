//! The state of the sampling kept current while points arrive.
//!
//! The mesh keeps its triangles in chunks, nearly in the order in which they came, and knows when each
//! chunk was changed last. A scan changes the triangles at its border, which came last: so the figures
//! are kept for each chunk, and only those of changed chunks are made anew. A point then costs the look
//! at its two triangles, and now and then one at those beside them.
//!
//! Three simplifications against [`crate::assess`], all to the safe side:
//!
//! - The local feature size is asked for once a triangle, at the corner with the largest angle, and lowered
//!   by twice the gap: no point that `assess` asks about is farther away, and it changes by no more than the
//!   way gone.
//! - The percentile of ε comes from a histogram: it is the upper bound of a bin, by up to 1/8 too large.
//! - Thin triangles along the outline count with their own gap, though samples that are no corners of
//!   theirs may be nearer.

use rayon::prelude::*;

use super::{Criteria, Sampling, State, StateCounts};
use crate::delaunay::FlatCells;
use crate::triangle::{Gap, Sizes, Triangle, sizes};
use crate::{Mesh, PointMm};

/// The sampling of a growing mesh.
#[derive(Clone, Debug, Default)]
pub struct RunningSampling {
    /// The moment of the mesh up to which the figures hold.
    seen: Option<u32>,
    chunks: Vec<Tally>,
}

impl RunningSampling {
    /// Of no mesh yet.
    pub fn new() -> RunningSampling {
        RunningSampling::default()
    }

    /// Forgets all figures: the next [`RunningSampling::update`] looks at every triangle. To be called
    /// when the criteria, the local feature size or what is inside have changed by so much that it matters.
    pub fn restart(&mut self) {
        *self = RunningSampling::new();
    }

    /// Takes in what changed in the mesh since the last time. Points that wait to be inserted take no part.
    ///
    /// `criteria` are those of [`crate::assess`]; the area of the aperture is taken as it is now.
    /// `inside(x, y)` says of the centre of a triangle whether it counts, `lfs_mm(x, y)` is the local
    /// feature size in mm. Chunks that did not change keep what they were given then.
    ///
    /// Takes time in proportion to what changed, in the rayon pool of the caller, and adds up some 200
    /// numbers for every 1,024 triangles there are. The figures of a mesh are the same to the last bit
    /// however often this is called before. How sums are rounded depends on where triangles are kept, which
    /// batches and threads may change.
    pub fn update(
        &mut self,
        mesh: &Mesh,
        criteria: &Criteria,
        inside: impl Fn(f64, f64) -> bool + Sync,
        lfs_mm: impl Fn(f64, f64) -> f64 + Sync,
    ) -> Sampling {
        let cells = mesh.cells();
        let seen = self.seen.replace(cells.now());
        let written = cells.written();
        self.chunks.resize_with(written.len(), Tally::default);
        let changed: Vec<(&mut Tally, usize)> = self
            .chunks
            .iter_mut()
            .enumerate()
            .zip(written)
            .filter(|&(_, moment)| seen.is_none_or(|seen| moment > seen))
            .map(|((chunk, tally), _)| (tally, chunk))
            .collect();
        let gauge = Gauge { points: mesh.points(), cells, criteria, inside, lfs_mm };
        let make = |(tally, chunk): (&mut Tally, usize)| *tally = gauge.tally(chunk);
        if changed.len() < WORTH_THREADS {
            changed.into_iter().for_each(make);
        } else {
            changed.into_par_iter().for_each(make);
        }
        self.sampling(criteria.aperture_area_mm2)
    }

    /// The figures up to the last update.
    fn sampling(&self, aperture_area_mm2: Option<f64>) -> Sampling {
        let mut total = Tally::default();
        for tally in &self.chunks {
            total.merge(tally);
        }
        total.figures(aperture_area_mm2)
    }
}

/// Looks at triangles.
struct Gauge<'a, I, L> {
    points: &'a [PointMm],
    cells: &'a FlatCells,
    criteria: &'a Criteria,
    inside: I,
    lfs_mm: L,
}

impl<I: Fn(f64, f64) -> bool, L: Fn(f64, f64) -> f64> Gauge<'_, I, L> {
    fn tally(&self, chunk: usize) -> Tally {
        let mut tally = Tally::default();
        for corners in self.cells.triangles_of(chunk) {
            // One by one: as an array they would go through memory.
            let [p, q, r] = corners;
            let (p, q, r) =
                (self.points[p as usize], self.points[q as usize], self.points[r as usize]);
            let [x, y] = centre(p, q, r);
            if !(self.inside)(x, y) {
                continue;
            }
            let sizes = sizes(p, q, r);
            let [x, y, _] = match sizes.blunt {
                0 => p,
                1 => q,
                _ => r,
            };
            let lfs_mm = (self.lfs_mm)(x, y) - 2.0 * sizes.gap_mm;
            let epsilon = super::epsilon(sizes.gap_mm, lfs_mm);
            let state = self.criteria.state(sizes.gap_mm, epsilon);
            tally.add(&sizes, state, epsilon);
            if tally.widest.is_none_or(|widest| sizes.gap_mm > widest.mm) {
                let at_mm = Triangle::new(self.points, corners).gap().at_mm;
                tally.widest = Some(Gap { mm: sizes.gap_mm, at_mm });
            }
        }
        tally
    }
}

#[inline(always)]
fn centre(p: PointMm, q: PointMm, r: PointMm) -> [f64; 2] {
    [0, 1].map(|axis| (p[axis] + q[axis] + r[axis]) * (1.0 / 3.0))
}

/// The figures of some triangles.
#[derive(Clone, Debug, Default)]
struct Tally {
    counts: StateCounts,
    area_mm2: f64,
    projected_mm2: f64,
    good_mm2: f64,
    undersampled_mm2: f64,
    widest: Option<Gap>,
    epsilon_max: Option<f64>,
    /// Area in space by ε; empty for no triangles.
    epsilons: Vec<f64>,
}

impl Tally {
    #[inline(always)]
    fn add(&mut self, sizes: &Sizes, state: State, epsilon: f64) {
        self.area_mm2 += sizes.area_mm2;
        self.projected_mm2 += sizes.projected_area_mm2;
        let (count, sum) = match state {
            State::Good => (&mut self.counts.good, &mut self.good_mm2),
            State::OverGap => (&mut self.counts.over_gap, &mut self.undersampled_mm2),
            State::OverEpsilon => (&mut self.counts.over_epsilon, &mut self.undersampled_mm2),
        };
        *count += 1;
        *sum += sizes.projected_area_mm2;
        self.epsilon_max = Some(self.epsilon_max.map_or(epsilon, |most| most.max(epsilon)));
        if self.epsilons.is_empty() {
            self.epsilons.resize(BINS, 0.0);
        }
        self.epsilons[bin(epsilon)] += sizes.area_mm2;
    }

    fn merge(&mut self, other: &Tally) {
        self.counts.good += other.counts.good;
        self.counts.over_gap += other.counts.over_gap;
        self.counts.over_epsilon += other.counts.over_epsilon;
        self.area_mm2 += other.area_mm2;
        self.projected_mm2 += other.projected_mm2;
        self.good_mm2 += other.good_mm2;
        self.undersampled_mm2 += other.undersampled_mm2;
        if let Some(gap) = other.widest
            && self.widest.is_none_or(|widest| gap.mm > widest.mm)
        {
            self.widest = Some(gap);
        }
        self.epsilon_max = match (self.epsilon_max, other.epsilon_max) {
            (Some(most), Some(other)) => Some(most.max(other)),
            (most, other) => most.or(other),
        };
        if self.epsilons.len() < other.epsilons.len() {
            self.epsilons.resize(BINS, 0.0);
        }
        for (sum, area_mm2) in self.epsilons.iter_mut().zip(&other.epsilons) {
            *sum += area_mm2;
        }
    }

    fn figures(&self, aperture_area_mm2: Option<f64>) -> Sampling {
        let reference_mm2 = aperture_area_mm2.unwrap_or(self.projected_mm2);
        Sampling {
            triangles: self.counts,
            area_mm2: self.area_mm2,
            projected_area_mm2: self.projected_mm2,
            undersampled_area_mm2: self.undersampled_mm2,
            gap_max_mm: self.widest.map(|gap| gap.mm),
            gap_max_at_mm: self.widest.map(|gap| gap.at_mm),
            epsilon_max: self.epsilon_max,
            epsilon_p99: self.quantile(0.99),
            coverage: (reference_mm2 > 0.0).then(|| self.good_mm2 / reference_mm2),
        }
    }

    /// An upper bound of the smallest ε such that the triangles up to it hold at least `share` of the area.
    fn quantile(&self, share: f64) -> Option<f64> {
        let wanted = share * self.epsilons.iter().sum::<f64>();
        let mut below = 0.0;
        let reached = self.epsilons.iter().position(|area_mm2| {
            below += area_mm2;
            *area_mm2 > 0.0 && below >= wanted
        });
        let upper = reached.map(upper_bound);
        // The largest of all is known better than to its bin.
        upper.zip(self.epsilon_max).map(|(upper, most)| upper.min(most))
    }
}

/// The bin of a value: eight to an octave, the first for all below 2⁻²⁰ and the last for all from 16 on.
fn bin(value: f64) -> usize {
    let eighths = (value.to_bits() >> (52 - BINS_PER_OCTAVE.ilog2())) as usize;
    (eighths + 1).saturating_sub(SMALLEST_IN_BINS).min(BINS - 1)
}

/// The upper bound of a bin.
fn upper_bound(bin: usize) -> f64 {
    if bin == BINS - 1 {
        return f64::INFINITY;
    }
    f64::from_bits(((SMALLEST_IN_BINS + bin) as u64) << (52 - BINS_PER_OCTAVE.ilog2()))
}

/// Fewer chunks are looked at before another thread has woken up.
const WORTH_THREADS: usize = 32;

const BINS_PER_OCTAVE: usize = 8;
/// From 2⁻²⁰ to 2⁴, and what is below and above.
const BINS: usize = 24 * BINS_PER_OCTAVE + 2;
/// Bits of 2⁻²⁰ down to the eighths of an octave.
const SMALLEST_IN_BINS: usize = (1023 - 20) * BINS_PER_OCTAVE;

#[cfg(test)]
mod tests;
