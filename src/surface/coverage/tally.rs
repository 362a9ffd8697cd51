//! The figures of a coverage, summed over triangles in their order.

use super::gauge::{Gauged, Standing};
use super::patches::Patches;
use super::spread::spread;
use super::{Coverage, CoverageCounts, CoveredAreas, Reference};
use crate::PointMm;
use crate::area::Sum;

/// What the figures are made of.
#[derive(Default)]
pub(super) struct Tally {
    counts: CoverageCounts,
    covered: Sum,
    undersampled: Sum,
    bridging: Sum,
    unknown: Sum,
    lfs_min_mm: Option<f64>,
    /// Gap and ε of each triangle, each with its area in space inside the aperture.
    gaps: Vec<(f64, f64)>,
    epsilons: Vec<(f64, f64)>,
    widest: Option<(f64, PointMm)>,
    worst: Option<(f64, PointMm)>,
}

impl Tally {
    /// Counts a triangle by its area in the plane and in space, as far as it is inside.
    pub(super) fn add(&mut self, gauged: &Gauged, unknown: bool, area_mm2: f64, in_space_mm2: f64) {
        let (count, sum) = match gauged.standing {
            Standing::Covered => (&mut self.counts.covered, &mut self.covered),
            Standing::Undersampled => (&mut self.counts.undersampled, &mut self.undersampled),
            Standing::Bridge => (&mut self.counts.bridging, &mut self.bridging),
        };
        *count += 1;
        sum.add(area_mm2);
        if unknown {
            self.unknown.add(area_mm2);
        }
        let at_mm = gauged.gap.at_mm;
        self.gaps.push((gauged.gap.mm, in_space_mm2));
        if self.widest.is_none_or(|(mm, _)| gauged.gap.mm > mm) {
            self.widest = Some((gauged.gap.mm, at_mm));
        }
        if let Some(epsilon) = gauged.epsilon() {
            self.epsilons.push((epsilon, in_space_mm2));
            if self.worst.is_none_or(|(worst, _)| epsilon > worst) {
                self.worst = Some((epsilon, at_mm));
            }
        }
        if let Some(lfs_mm) = gauged.lfs_mm {
            self.lfs_min_mm = Some(self.lfs_min_mm.map_or(lfs_mm, |least| least.min(lfs_mm)));
        }
    }

    /// Whether any triangle has a part in the aperture.
    pub(super) fn meets(&self) -> bool {
        !self.gaps.is_empty()
    }

    /// The figures, with the regions found.
    pub(super) fn coverage(
        mut self,
        reference: Reference,
        aperture_mm2: Option<f64>,
        found: Patches,
    ) -> Coverage {
        let areas = aperture_mm2.map(|aperture_mm2| {
            let (covered_mm2, undersampled_mm2) = (self.covered.total(), self.undersampled.total());
            CoveredAreas {
                aperture_mm2,
                covered_mm2,
                undersampled_mm2,
                uncovered_mm2: (aperture_mm2 - covered_mm2 - undersampled_mm2).max(0.0),
                lfs_unknown_mm2: self.unknown.total(),
            }
        });
        Coverage {
            reference,
            areas,
            triangles: self.counts,
            gap_mm: spread(&mut self.gaps),
            gap_max_at_mm: self.widest.map(|(_, at_mm)| at_mm),
            epsilon: spread(&mut self.epsilons),
            epsilon_max_at_mm: self.worst.map(|(_, at_mm)| at_mm),
            lfs_min_mm: self.lfs_min_mm,
            patches: found.listed,
            remainder_mm2: found.remainder_mm2,
            remainder_patches: found.remainder,
        }
    }
}
