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
//! - Percentiles come from histograms: they are upper bounds of bins, by up to 1/8 too large. Triangles within the limits
//!   are entered by their farthest places, and the others are taken to lie as in half a square:
//!   where triangles are of other shapes that is off by some 6 % either way.
//! - Thin triangles along the outline count with their own gap, though samples that are no corners of
//!   theirs may be nearer.

use asphera_geometry::nearness::Nearness;
use asphera_geometry::{Gap, PointMm, Sizes, Triangle, VertexId, sizes};
use asphera_mesh::Mesh;
use rayon::prelude::*;

use super::bins::Bins;
use super::{Criteria, Sampling, State, StateCounts, sound};

/// The sampling of a growing mesh.
#[derive(Clone, Debug, Default)]
pub struct RunningSampling {
    /// The moment of the mesh up to which the figures hold.
    seen: Option<u32>,
    chunks: Vec<Tally>,
    /// What every [`A_GROUP`] chunks one after the other come to.
    groups: Vec<Tally>,
    total: Tally,
}

/// How gaps and facets are distributed over the area in space of the triangles that count.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct RunningSpread {
    /// An upper bound of the gap in mm that half of the area has at most, by up to 1/8 too large.
    pub gap_median_mm: Option<f64>,
    /// The same for 99 % of the area.
    pub gap_p99_mm: Option<f64>,
    /// Half of the area has facets of this spacing in mm or less, the side of a square of which the facet is
    /// half; interpolated, so off by less than 1/16.
    pub spacing_median_mm: Option<f64>,
    /// Area in space in mm² of all triangles, those that do not count among them.
    pub whole_area_mm2: f64,
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
    /// Takes time in proportion to what changed, in the rayon pool of the caller, and adds up some 60
    /// numbers for every 32,768 triangles there are, and for each 1,024 beside what changed. The figures of a mesh are the same to the last bit
    /// however often this is called before. How sums are rounded depends on where triangles are kept, which
    /// batches and threads may change.
    pub fn update(
        &mut self,
        mesh: &Mesh,
        criteria: &Criteria,
        inside: impl Fn(f64, f64) -> bool + Sync,
        lfs_mm: impl Fn(f64, f64) -> f64 + Sync,
    ) -> Sampling {
        let seen = self.seen.replace(mesh.now());
        let written = mesh.written();
        self.chunks.resize_with(written.len(), Tally::default);
        let mut changed: Vec<(&mut Tally, usize)> = self
            .chunks
            .iter_mut()
            .enumerate()
            .zip(written)
            .filter(|&(_, moment)| seen.is_none_or(|seen| moment > seen))
            .map(|((chunk, tally), _)| (tally, chunk))
            .collect();
        let gauge = Gauge { points: mesh.points(), mesh, criteria, inside, lfs_mm };
        let mut regrouped: Vec<usize> = changed.iter().map(|(_, chunk)| chunk / A_GROUP).collect();
        regrouped.dedup();
        let make = |work: &mut Work, (tally, chunk): &mut (&mut Tally, usize)| {
            **tally = gauge.tally(*chunk, work);
        };
        if changed.len() < WORTH_THREADS {
            let mut work = Work::default();
            changed.iter_mut().for_each(|entry| make(&mut work, entry));
        } else {
            changed.par_iter_mut().for_each_init(Work::default, make);
        }
        self.groups.resize_with(self.chunks.len().div_ceil(A_GROUP), Tally::default);
        for group in regrouped {
            let first = group * A_GROUP;
            let last = self.chunks.len().min(first + A_GROUP);
            self.groups[group] = Tally::of_all(&self.chunks[first..last]).trimmed();
        }
        self.total = Tally::of_all(&self.groups);
        self.total.figures(criteria.aperture_area_mm2)
    }

    /// The distributions up to the last update.
    pub fn spread(&self) -> RunningSpread {
        let Tally { gaps, place_gaps, facets, whole_area_mm2, widest, .. } = &self.total;
        let most_mm = widest.map(|gap| gap.mm);
        let gap_mm = |share| gaps.bound_of_places(place_gaps, share, most_mm);
        RunningSpread {
            gap_median_mm: gap_mm(0.5),
            gap_p99_mm: gap_mm(0.99),
            spacing_median_mm: facets.about(0.5).map(|area_mm2| (2.0 * area_mm2).sqrt()),
            whole_area_mm2: *whole_area_mm2,
        }
    }

    /// How many triangles the next update would look at, at most: what it would cost. Some operations for every
    /// 1,024 triangles there are.
    pub fn outdated(&self, mesh: &Mesh) -> usize {
        let written = mesh.written();
        let known = self.chunks.len();
        let is_outdated = |(chunk, moment): &(usize, u32)| {
            *chunk >= known || self.seen.is_none_or(|seen| *moment > seen)
        };
        A_CHUNK * written.enumerate().filter(is_outdated).count()
    }
}

/// Looks at triangles.
struct Gauge<'a, I, L> {
    points: &'a [PointMm],
    mesh: &'a Mesh,
    criteria: &'a Criteria,
    inside: I,
    lfs_mm: L,
}

impl<I: Fn(f64, f64) -> bool, L: Fn(f64, f64) -> f64> Gauge<'_, I, L> {
    fn tally(&self, chunk: usize, work: &mut Work) -> Tally {
        let Work { measured, bins } = work;
        measured.clear();
        // In two steps, each of which is short enough that the processor works on several triangles at a time.
        measured.extend(self.mesh.triangles_of(chunk).map(|corners| {
            // One by one: as an array they would go through memory.
            let [p, q, r] = corners;
            let (p, q, r) =
                (self.points[p as usize], self.points[q as usize], self.points[r as usize]);
            Measured { corners, centre: centre(p, q, r), sizes: sizes(p, q, r) }
        }));
        let mut tally = Tally::default();
        bins.iter_mut().for_each(Bins::clear);
        let [gaps, epsilons, facets, place_gaps, place_epsilons] = bins;
        for triangle in &*measured {
            let &Measured { corners, centre: [x, y], ref sizes } = triangle;
            let &Sizes { gap_mm, area_mm2, blunt, .. } = sizes;
            tally.whole_area_mm2 += area_mm2;
            if !(self.inside)(x, y) {
                continue;
            }
            let lfs_at = |corner: usize, less_mm: f64| {
                let [x, y, _] = self.points[corners[corner] as usize];
                sound((self.lfs_mm)(x, y) - less_mm)
            };
            let mut lfs_mm = lfs_at(blunt, 2.0 * gap_mm);
            let mut state = self.criteria.state(gap_mm, gap_mm / lfs_mm);
            if state != State::Good {
                // The nearest corner to a place is no farther than the gap, whichever of the three it is.
                let nearest_mm =
                    (0..3).map(|corner| lfs_at(corner, gap_mm)).fold(f64::INFINITY, f64::min);
                lfs_mm = lfs_mm.max(nearest_mm);
                state = self.criteria.state(gap_mm, gap_mm / lfs_mm);
            }
            let epsilon = gap_mm / lfs_mm;
            let beyond = if state == State::Good {
                0.0
            } else {
                self.criteria.share_beyond(state, &Nearness::new(sizes, gap_mm), lfs_mm)
            };
            tally.add(sizes, (state, beyond), epsilon);
            if state == State::Good || epsilon == f64::INFINITY {
                gaps.add(gap_mm, area_mm2);
                epsilons.add(epsilon, area_mm2);
            } else {
                let nearness = Nearness::new(sizes, gap_mm);
                place_gaps.add_places(&nearness, 1.0);
                place_epsilons.add_places(&nearness, lfs_mm);
            }
            facets.add(area_mm2, area_mm2);
            if tally.widest.is_none_or(|widest| gap_mm > widest.mm) {
                let at_mm = Triangle::new(self.points, corners).gap().at_mm;
                tally.widest = Some(Gap { mm: gap_mm, at_mm });
            }
        }
        let [gaps, epsilons, facets, place_gaps, place_epsilons] =
            bins.each_ref().map(Bins::trimmed);
        Tally { gaps, epsilons, facets, place_gaps, place_epsilons, ..tally }
    }
}

/// Memory that one chunk leaves to the next.
struct Work {
    /// Its triangles.
    measured: Vec<Measured>,
    /// Of gaps, ε and facets, and of the gaps and the ε of places.
    bins: [Bins; 5],
}

/// A triangle with what is needed of it.
struct Measured {
    corners: [VertexId; 3],
    /// In the plane.
    centre: [f64; 2],
    sizes: Sizes,
}

impl Default for Work {
    fn default() -> Work {
        Work { measured: Vec::new(), bins: std::array::from_fn(|_| Bins::all()) }
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
    /// Area in space of triangles by their gap and ε: of those that are good.
    gaps: Bins,
    epsilons: Bins,
    /// Area in space of the places of all others.
    place_gaps: Bins,
    place_epsilons: Bins,
    /// Area in space by the area of the triangle itself.
    facets: Bins,
    /// Area in space of all triangles, those that do not count among them.
    whole_area_mm2: f64,
}

impl Tally {
    /// What some come to, in their order.
    fn of_all(tallies: &[Tally]) -> Tally {
        let mut all = Tally {
            gaps: Bins::all(),
            epsilons: Bins::all(),
            place_gaps: Bins::all(),
            place_epsilons: Bins::all(),
            facets: Bins::all(),
            ..Tally::default()
        };
        tallies.iter().for_each(|tally| all.merge(tally));
        all
    }

    /// Bins without the empty ones at both ends.
    fn trimmed(self) -> Tally {
        let [gaps, epsilons, facets] =
            [&self.gaps, &self.epsilons, &self.facets].map(Bins::trimmed);
        let [place_gaps, place_epsilons] =
            [&self.place_gaps, &self.place_epsilons].map(Bins::trimmed);
        Tally { gaps, epsilons, facets, place_gaps, place_epsilons, ..self }
    }

    #[inline(always)]
    fn add(&mut self, sizes: &Sizes, (state, beyond): (State, f64), epsilon: f64) {
        self.area_mm2 += sizes.area_mm2;
        self.projected_mm2 += sizes.projected_area_mm2;
        let count = match state {
            State::Good => &mut self.counts.good,
            State::OverGap => &mut self.counts.over_gap,
            State::OverEpsilon => &mut self.counts.over_epsilon,
        };
        *count += 1;
        self.good_mm2 += sizes.projected_area_mm2 * (1.0 - beyond);
        self.undersampled_mm2 += sizes.projected_area_mm2 * beyond;
        self.epsilon_max = Some(self.epsilon_max.map_or(epsilon, |most| most.max(epsilon)));
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
        self.gaps.merge(&other.gaps);
        self.epsilons.merge(&other.epsilons);
        self.place_gaps.merge(&other.place_gaps);
        self.place_epsilons.merge(&other.place_epsilons);
        self.facets.merge(&other.facets);
        self.whole_area_mm2 += other.whole_area_mm2;
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
            epsilon_p99: self.epsilons.bound_of_places(
                &self.place_epsilons,
                0.99,
                self.epsilon_max,
            ),
            coverage: (reference_mm2 > 0.0).then(|| self.good_mm2 / reference_mm2),
        }
    }
}

/// Triangles of a chunk, as the mesh keeps them.
const A_CHUNK: usize = 1024;

/// Chunks whose sum is kept, so that what did not change need not be added up again.
const A_GROUP: usize = 32;

/// Fewer chunks are looked at before another thread has woken up.
const WORTH_THREADS: usize = 32;

#[cfg(test)]
mod tests;
