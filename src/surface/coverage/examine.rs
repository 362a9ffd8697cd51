//! All that is told of the triangles of a mesh, step by step.

use asphera_geometry::{PointMm, Triangle, VertexId};

use super::aperture::Aperture;
use super::border::Border;
use super::density::{Density, Facet};
use super::gauge::{Gauged, Gauger, Gauges, Guess, lfs_at_points_mm};
use super::patches::Patches;
use super::percentiles::{Percentiles, Searches, Values};
use super::regions::Measured;
use super::target::Target;
use super::{CoverageError, Examination, Reference, without};
use crate::outline::island_counts;
use crate::rim::Rim;

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
        let mut gauges = gauger.gauge(gauger.guess());
        let mut open = std::mem::take(&mut gauges.open);
        let mut tally = std::mem::take(&mut gauges.covered);
        let area_mm2 = gauges.area_mm2;
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
        let most = tally.most();
        let ((distributed, islands), found) = rayon::join(
            || {
                let islands = hull
                    .as_deref()
                    .map(|hull| island_counts(points, triangles, &gauges.is_covered, hull))
                    .unwrap_or_default();
                (gauger.distributed(&mut gauges, &open, most), islands)
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
        let Distributed { places, facets_mm2 } = distributed;
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
        let coverage = tally.coverage(reference, reference_mm2, places, found);
        Ok(Examination { coverage, covered: gauges.is_covered, islands, dense, area_mm2 })
    }
}

/// Medians and percentiles over all triangles that count.
struct Distributed {
    places: Percentiles,
    /// The median of the areas of facets.
    facets_mm2: Option<f64>,
}

impl Gauger<'_> {
    /// The medians and percentiles of all triangles that count: of the covered ones, which are gauged, and the open
    /// ones; `most` are the largest gap and the largest ε.
    fn distributed(&self, gauges: &mut Gauges, open: &[Gauged], most: [f64; 2]) -> Distributed {
        let triangle = |gauged: &Gauged| Triangle::new(self.points, self.triangles[gauged.index]);
        let mut searches = Searches::up_to(most);
        let mut places = gauges.places;
        let places = loop {
            for gauged in open {
                places.add(&gauged.placed(&triangle(gauged)));
            }
            match searches.percentiles(&places) {
                Ok(percentiles) => break percentiles,
                Err(values) => {
                    places = self.places(values, &gauges.is_covered, &gauges.cared);
                }
            }
        };
        let facets_mm2 = loop {
            for gauged in open.iter().filter(|gauged| gauged.is_facet()) {
                gauges.facets.add(triangle(gauged).area_mm2());
            }
            match gauges.facets.median() {
                Ok(median) => break median,
                // The sample that told where to look was a poor one.
                Err(facets) => {
                    let guess = Guess { facets, places: Values::default() };
                    gauges.facets = self.gauge(guess).facets;
                }
            }
        };
        Distributed { places, facets_mm2 }
    }
}
