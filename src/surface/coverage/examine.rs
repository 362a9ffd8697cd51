//! All that is told of the triangles of a mesh, step by step.

use super::aperture::Aperture;
use super::border::Border;
use super::density::{Density, Facet};
use super::gauge::{Gauged, Gauger, Gauges, lfs_at_points_mm};
use super::patches::Patches;
use super::regions::Measured;
use super::spread::{Distribution, Quantiles};
use super::target::Target;
use super::{CoverageError, Examination, Reference, without};
use crate::outline::island_counts;
use crate::rim::Rim;
use crate::triangle::Triangle;
use crate::{PointMm, VertexId};

/// The triangles of a mesh.
pub(super) struct Meshed<'a, R> {
    pub(super) points: &'a [PointMm],
    pub(super) triangles: &'a [[VertexId; 3]],
    /// Indices, ascending, of those that are bridges whatever their gap.
    pub(super) left_out: &'a [usize],
    /// Finds what lies along their outline.
    pub(super) rim: R,
}

impl<R: FnOnce() -> Rim + Send> Meshed<'_, R> {
    /// Looks at all of it. See [`super::examine`].
    pub(super) fn examine(
        self,
        aperture: Option<&Aperture>,
        target: &Target,
        density: Option<&Density>,
        lfs_mm: impl Fn(f64, f64) -> Option<f64> + Sync,
    ) -> Result<Examination, CoverageError> {
        let Meshed { points, triangles, left_out, rim } = self;
        target.validate()?;
        let (Rim { hull, refined }, (border, at_points_mm)) = rayon::join(rim, || {
            let border = aperture.map(|aperture| Border::new(aperture, triangles.len(), 0));
            (border, lfs_at_points_mm(points, &lfs_mm))
        });
        let aperture = aperture.zip(border.as_ref());
        let gauger = Gauger {
            points,
            triangles,
            left_out,
            refined: &refined,
            aperture,
            target,
            density,
            at_points_mm: &at_points_mm,
        };
        let gauges = gauger.gauge(gauger.windows());
        let Gauges { covered: mut tally, distribution, is_covered, mut open, area_mm2 } = gauges;
        let measured = Measured { points, triangles, target };
        if hull.is_none() && !triangles.is_empty() {
            return Err(CoverageError::NotAMesh { triangles: triangles.len() });
        }
        let mut outer = Vec::new();
        if let (Some(hull), None) = (&hull, aperture) {
            let (outside, sides) = without::outside(points.len(), triangles, &open, hull);
            outer = sides;
            open.retain(|gauged| outside.binary_search(&gauged.index).is_err());
        }
        for gauged in &open {
            if gauged.area_mm2 > 0.0 {
                tally.add_open(gauged, target.gap_mm(gauged.lfs_mm).is_none());
            }
            if let Some(density) = density.filter(|_| gauged.is_facet()) {
                let triangle = Triangle::new(points, triangles[gauged.index]);
                tally.add_facet(density, &Facet::of(&triangle));
            }
        }
        // None of these asks for another.
        let ((quantiles, islands), found) = rayon::join(
            || {
                let islands = hull
                    .as_deref()
                    .map(|hull| island_counts(points, triangles, &is_covered, hull))
                    .unwrap_or_default();
                (gauger.quantiles(distribution, &open), islands)
            },
            || match (aperture, &hull) {
                (Some((aperture, border)), Some(hull)) if tally.meets() => {
                    measured.inside(aperture, border, hull.clone(), &open, &lfs_mm)
                }
                (Some((aperture, border)), _) => {
                    Ok(Patches::whole(aperture, border, target, &lfs_mm))
                }
                (None, Some(_)) => measured.inside_outline(&open, &outer, &lfs_mm),
                (None, None) => Ok(Patches::none()),
            },
        );
        let Quantiles { gaps_mm, epsilons, facets_mm2 } = quantiles;
        let found = found?;
        let (reference, reference_mm2) = match aperture {
            Some((aperture, _)) => (Reference::Aperture, Some(aperture.area_mm2())),
            None => (Reference::DataOutline, (!triangles.is_empty()).then(|| tally.area_mm2())),
        };
        let dense = density.map(|density| {
            let epsilon = density.criteria.epsilon_limit();
            let lfs_mm = target.tightest_lfs_mm(epsilon, tally.lfs_min_mm());
            tally.crumpled().dense(density, facets_mm2, lfs_mm)
        });
        let coverage = tally.coverage(reference, reference_mm2, [gaps_mm, epsilons], found);
        Ok(Examination { coverage, covered: is_covered, islands, dense, area_mm2 })
    }
}

impl Gauger<'_> {
    /// The quantiles of all triangles that count: of the covered ones, which are distributed so, and the open ones.
    /// Takes another pass if the sample that said where to look for them was a poor one.
    fn quantiles(&self, mut distribution: Distribution, open: &[Gauged]) -> Quantiles {
        loop {
            open.iter().for_each(|gauged| distribution.add(&gauged.entry()));
            match distribution.quantiles() {
                Ok(quantiles) => return quantiles,
                Err(elsewhere) => distribution = self.gauge(elsewhere).distribution,
            }
        }
    }
}
