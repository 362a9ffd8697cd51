//! The figures of a coverage, summed over triangles in their order.

use asphera_geometry::{Gap, PointMm, Sum};

use super::density::{Crumpled, Crumpling, Density, Facet};
use super::gauge::{Gauged, Plain, Standing};
use super::patches::Patches;
use super::percentiles::{Percentiles, Spread};
use super::{Coverage, CoverageCounts, CoveredAreas, Reference};

/// What the figures are made of.
#[derive(Default)]
pub(super) struct Tally {
    counts: CoverageCounts,
    covered: Sum,
    undersampled: Sum,
    bridging: Sum,
    unknown: Sum,
    lfs_min_mm: Option<f64>,
    widest: Option<(f64, PointMm)>,
    worst: Option<(f64, PointMm)>,
    facets: Sum,
    overdense: Sum,
    loudest_mm: Option<f64>,
}

impl Tally {
    /// Counts a covered triangle by its area in the plane, as far as it is inside; its gap is noted beside.
    pub(super) fn add(&mut self, lfs_mm: Option<f64>, area_mm2: f64) {
        self.counts.covered += 1;
        self.covered.add(area_mm2);
        if let Some(lfs_mm) = lfs_mm {
            self.note_lfs_mm(lfs_mm);
        }
    }

    /// Counts one that is not.
    pub(super) fn add_open(&mut self, gauged: &Gauged, unknown: bool) {
        let (count, sum) = match gauged.standing {
            Standing::Undersampled => (&mut self.counts.undersampled, &mut self.undersampled),
            Standing::Bridge => (&mut self.counts.bridging, &mut self.bridging),
        };
        *count += 1;
        let beyond_mm2 = gauged.beyond_mm2();
        sum.add(beyond_mm2);
        self.covered.add(gauged.area_mm2 - beyond_mm2);
        if unknown {
            self.unknown.add(gauged.area_mm2);
        }
        self.note(gauged.gap, gauged.lfs_mm);
    }

    /// Counts covered triangles whose largest gap and ε were noted.
    pub(super) fn add_plain(&mut self, plain: &Plain) {
        if plain.count == 0 {
            return;
        }
        self.counts.covered += plain.count;
        self.covered.join(plain.projected);
        self.note_lfs_mm(plain.lfs_min_mm);
        if let Some(crumpling) = &plain.crumpling {
            self.facets.join(plain.area);
            self.overdense.join(crumpling.overdense);
            self.loudest_mm = larger(self.loudest_mm, Some(crumpling.loudest_mm));
        }
    }

    /// Counts a facet of the surface by how far noise turns it.
    pub(super) fn add_facet(&mut self, density: &Density, facet: &Facet) {
        if let Some(mut crumpling) = Crumpling::new(density) {
            crumpling.add(facet);
            self.facets.add(facet.area_mm2);
            self.overdense.join(crumpling.overdense);
            self.loudest_mm = larger(self.loudest_mm, Some(crumpling.loudest_mm));
        }
    }

    /// Takes note of how large gap and ε are, and where.
    pub(super) fn note(&mut self, gap: Gap, lfs_mm: Option<f64>) {
        if self.widest.is_none_or(|(mm, _)| gap.mm > mm) {
            self.widest = Some((gap.mm, gap.at_mm));
        }
        if let Some(lfs_mm) = lfs_mm {
            let epsilon = gap.mm / lfs_mm;
            if self.worst.is_none_or(|(worst, _)| epsilon > worst) {
                self.worst = Some((epsilon, gap.at_mm));
            }
            self.note_lfs_mm(lfs_mm);
        }
    }

    fn note_lfs_mm(&mut self, lfs_mm: f64) {
        self.lfs_min_mm = Some(self.lfs_min_mm.map_or(lfs_mm, |least| least.min(lfs_mm)));
    }

    /// Adds the figures of triangles that come after these.
    pub(super) fn join(&mut self, after: Tally) {
        self.counts.covered += after.counts.covered;
        self.counts.undersampled += after.counts.undersampled;
        self.counts.bridging += after.counts.bridging;
        for (sum, other) in [
            (&mut self.covered, after.covered),
            (&mut self.undersampled, after.undersampled),
            (&mut self.bridging, after.bridging),
            (&mut self.unknown, after.unknown),
            (&mut self.facets, after.facets),
            (&mut self.overdense, after.overdense),
        ] {
            sum.join(other);
        }
        for (had, found) in [(&mut self.widest, after.widest), (&mut self.worst, after.worst)] {
            if let Some((value, _)) = found
                && had.is_none_or(|(largest, _)| value > largest)
            {
                *had = found;
            }
        }
        self.lfs_min_mm = match (self.lfs_min_mm, after.lfs_min_mm) {
            (Some(left), Some(right)) => Some(left.min(right)),
            (left, right) => left.or(right),
        };
        self.loudest_mm = larger(self.loudest_mm, after.loudest_mm);
    }

    /// Whether any triangle has a part in the aperture.
    pub(super) fn meets(&self) -> bool {
        self.widest.is_some()
    }

    /// The largest gap in mm and the largest ε; 0 where none is known.
    pub(super) fn most(&self) -> [f64; 2] {
        [self.widest, self.worst].map(|largest| largest.map_or(0.0, |(value, _)| value))
    }

    /// The area of all triangles that count, in the plane.
    pub(super) fn area_mm2(&self) -> f64 {
        let mut sum = self.covered;
        sum.join(self.undersampled);
        sum.join(self.bridging);
        sum.total()
    }

    pub(super) fn lfs_min_mm(&self) -> Option<f64> {
        self.lfs_min_mm
    }

    /// Data known of the facets that noise turns too far.
    pub(super) fn crumpled(&self) -> Crumpled {
        Crumpled {
            area_mm2: self.facets.total(),
            overdense_mm2: self.overdense.total(),
            loudest_mm: self.loudest_mm,
        }
    }

    /// The figures, with the regions found.
    pub(super) fn coverage(
        self,
        reference: Reference,
        aperture_mm2: Option<f64>,
        [gaps_mm, epsilons]: Percentiles,
        found: Patches,
    ) -> Coverage {
        let areas = aperture_mm2.map(|aperture_mm2| {
            let undersampled_mm2 = self.undersampled.total();
            // Where nothing is left all is covered; the sum over triangles may differ by rounding.
            let nothing_left = found.listed.is_empty() && found.remainder == 0;
            let covered_mm2 = if nothing_left { aperture_mm2 } else { self.covered.total() };
            let left_mm2 = aperture_mm2 - covered_mm2 - undersampled_mm2;
            let uncovered_mm2 = if left_mm2 > ROUNDING * aperture_mm2 { left_mm2 } else { 0.0 };
            CoveredAreas {
                aperture_mm2,
                covered_mm2,
                undersampled_mm2,
                uncovered_mm2,
                lfs_unknown_mm2: self.unknown.total(),
            }
        });
        Coverage {
            reference,
            areas,
            triangles: self.counts,
            gap_mm: spread(gaps_mm, self.widest),
            gap_max_at_mm: self.widest.map(|(_, at_mm)| at_mm),
            epsilon: spread(epsilons, self.worst),
            epsilon_max_at_mm: self.worst.map(|(_, at_mm)| at_mm),
            lfs_min_mm: self.lfs_min_mm,
            patches: found.listed,
            remainder_mm2: found.remainder_mm2,
            remainder_patches: found.remainder,
        }
    }
}

/// The spread with these quantiles and this largest value.
fn spread(quantiles: Option<[f64; 2]>, largest: Option<(f64, PointMm)>) -> Option<Spread> {
    // The largest may be rounded otherwise than the rest.
    let ([median, p99], (max, _)) = quantiles.zip(largest)?;
    Some(Spread { median: median.min(max), p99: p99.min(max), max })
}

fn larger(left: Option<f64>, right: Option<f64>) -> Option<f64> {
    match (left, right) {
        (Some(left), Some(right)) => Some(left.max(right)),
        (left, right) => left.or(right),
    }
}

/// What sums over triangles leave of an aperture by rounding, as a share.
const ROUNDING: f64 = 1e-12;
