//! What one look at the sampling finds.

use std::f64::consts::SQRT_2;

use asphera_form::Pose;
use asphera_report::words::short;
use asphera_report::{SamplingFigures, Waypoints};
use asphera_surface::Plane;
use asphera_surface::coverage::{
    Aperture, Coverage, CoverageError, Density, Examination, Patch, cover, examine,
};
use asphera_surface::noise::{Advice, Noise, NoiseEstimate, UnevenNoise};

use super::next::{self, Next};
use super::places::Lifted;
use super::scale::Scale;
use super::wanted::Wanted;
use super::zones::ZoneSampling;
use super::{Sampled, no_area};
use crate::Part;

/// Findings about the sampling.
pub(crate) struct Findings {
    pub(crate) figures: SamplingFigures,
    /// Why the noise is not known.
    pub(crate) noise_unknown: Option<String>,
    /// For each triangle whether it is sampled densely enough and has a part in the aperture.
    pub(crate) covered: Vec<bool>,
    /// Area in space of all triangles in mm².
    pub(crate) area_mm2: f64,
    pub(crate) coverage: Option<Coverage>,
    /// The same of zones that have a limit.
    pub(crate) zones: Vec<ZoneSampling>,
    /// The spacing for regions that name none, in mm.
    pub(crate) otherwise_mm: Option<f64>,
}

/// Data of a look at the sampling.
pub(super) struct Look<'a> {
    pub(super) sampled: Sampled<'a>,
    pub(super) wanted: Wanted,
    pub(super) scale: Scale,
    pub(super) aperture: Option<Aperture>,
    pub(super) zones: Vec<(asphera_form::Aperture, Aperture)>,
    pub(super) noise: Result<NoiseEstimate, String>,
    /// Where the local feature size comes from.
    pub(super) source: Option<&'static str>,
    /// The smallest one, infinite over a plane.
    pub(super) reach_mm: Option<f64>,
    pub(super) unknown: Vec<String>,
}

impl Look<'_> {
    pub(super) fn findings(
        mut self,
        lfs_mm: impl Fn(f64, f64) -> Option<f64> + Sync,
        lifted: &Lifted<'_>,
    ) -> Findings {
        let Sampled { mesh, triangles, plane } = self.sampled;
        let target = self.wanted.target(self.scale.gap_mm, self.reach_mm);
        let is_reach_wanting = self.wanted.rho.is_some() && self.reach_mm.is_none();
        if is_reach_wanting {
            self.unknown.push("without the reach there is no ρ".to_owned());
        }
        let (noise, noise_unknown) = self.known_noise();
        // A target that is none is told by the examination.
        let density = self.wanted.criteria().map(|criteria| Density { noise, criteria });
        let zones = self.zones.iter().map(|(zone, laid)| {
            let found = cover(mesh.points(), triangles, &[], Some(laid), &target, &lfs_mm);
            ZoneSampling::of(zone.clone(), found.ok())
        });
        let zones = zones.collect();
        let aperture = self.aperture.as_ref();
        let examined = examine(mesh, triangles, aperture, &target, density.as_ref(), lfs_mm);
        let Examination { coverage, covered, islands, dense, area_mm2 } = match examined {
            Ok(examination) => examination,
            Err(error) => {
                self.unknown.push(not_examined(&error));
                let unknown =
                    Findings::unknown(self.sampled, self.wanted, &self.scale, self.unknown);
                return Findings { noise_unknown, ..unknown };
            }
        };
        let nothing = if triangles.is_empty() {
            Some(no_area(self.sampled.mesh))
        } else if coverage.gap_mm.is_none() {
            Some("no point was measured in the aperture".to_owned())
        } else {
            None
        };
        // Of an aperture that was not met at all it is not said that nothing of it is covered: more likely it
        // lies elsewhere. Nor is it where the limits hold of what is known nowhere.
        let is_decided = nothing.is_none() && self.source.is_some() && !is_reach_wanting;
        let areas = coverage.areas.filter(|_| is_decided);
        self.unknown.splice(..0, nothing);
        let at_max = match coverage.epsilon {
            Some(epsilon) if epsilon.max > 0.0 => coverage.epsilon_max_at_mm,
            _ => coverage.gap_max_at_mm,
        };
        let finite = |value: f64| value.is_finite().then_some(value);
        let listed = next::figures(&coverage, lifted);
        let more = coverage.patches.len() - listed.len();
        let missing_mm2 = |patches: &[Patch]| patches.iter().map(Patch::missing_mm2).sum::<f64>();
        let more_mm2 = missing_mm2(&coverage.patches[listed.len()..]) + coverage.remainder_mm2;
        let figures = SamplingFigures {
            lfs_min_mm: coverage.lfs_min_mm.and_then(finite),
            lfs_source: self.source.map(str::to_owned),
            gap_max_mm: coverage.gap_mm.map(|gap| gap.max),
            gap_p99_mm: coverage.gap_mm.map(|gap| gap.p99),
            gap_limit_mm: self.scale.gap_mm,
            epsilon_target: self.wanted.epsilon,
            rho_target: self.wanted.rho,
            rho_max: coverage.gap_mm.zip(self.reach_mm).map(|(gap, reach_mm)| gap.max / reach_mm),
            reach_mm: self.reach_mm.and_then(finite),
            epsilon_max: coverage.epsilon.and_then(|epsilon| finite(epsilon.max)),
            epsilon_p99: coverage.epsilon.and_then(|epsilon| finite(epsilon.p99)),
            at_max_mm: at_max.map(|at_mm| plane.from_plane(at_mm)),
            coverage: areas.and_then(|_| coverage.coverage()),
            undersampled_area_mm2: areas.map(|areas| areas.undersampled_mm2),
            uncovered_area_mm2: areas.map(|areas| areas.uncovered_mm2),
            spacing_median_mm: dense.and_then(|dense| dense.spacing_median_mm),
            overdense_fraction: dense.and_then(|dense| dense.overdense_fraction),
            spacing_coarsest_mm: dense.and_then(|dense| bounds_mm(dense.advice?).1),
            spacing_finest_mm: dense.and_then(|dense| bounds_mm(dense.advice?).0),
            spacing_recommended_mm: dense.and_then(|dense| recommended_mm(dense.advice?)),
            next: listed,
            next_more: more as u64 + coverage.remainder_patches,
            next_more_area_mm2: more_mm2,
            unknown: self.unknown,
            as_of_points: mesh.counts().pushed,
            islands: areas.map(|_| islands.islands),
            holes: areas.map(|_| islands.holes),
            hole_max_mm2: areas.and(islands.hole_max_mm2),
            ..of_noise(self.noise.as_ref().ok())
        };
        let coverage = Some(coverage);
        let otherwise_mm = target.spacing_mm;
        Findings { figures, noise_unknown, covered, area_mm2, coverage, zones, otherwise_mm }
    }

    /// The noise, or why it is not known, which is then said.
    fn known_noise(&mut self) -> (Option<Noise>, Option<String>) {
        match &self.noise {
            Ok(found) => {
                self.unknown.extend(found.step_mm.map(in_steps));
                self.unknown.extend(differs(found));
                (Some(found.noise), None)
            }
            Err(why) => {
                self.unknown.push(format!("the noise is not known: {why}"));
                (None, Some(why.clone()))
            }
        }
    }
}

/// The figures of the noise; nothing else is known.
pub(crate) fn of_noise(found: Option<&NoiseEstimate>) -> SamplingFigures {
    let nm = |mm: f64| 1e6 * mm;
    let uneven = found.and_then(|found| found.uneven);
    SamplingFigures {
        noise_sigma_nm: found.map(|found| nm(found.noise.sigma_mm())),
        noise_u_nm: found.map(|found| nm(found.u_mm())),
        noise_range_nm: uneven.map(|found| [found.least_mm, found.most_mm].map(nm)),
        noise_rms_nm: uneven.map(|found| nm(found.rms_mm)),
        height_step_nm: found.and_then(|found| found.step_mm).map(nm),
        ..SamplingFigures::default()
    }
}

/// What one noise does not tell where regions differ.
pub(crate) fn differs(found: &NoiseEstimate) -> Option<String> {
    let UnevenNoise { least_mm, most_mm, rms_mm, .. } = found.uneven?;
    let nm = [least_mm, most_mm, rms_mm, found.noise.sigma_mm()].map(|mm| short(1e6 * mm));
    let [least, most, rms, sigma] = nm;
    Some(format!(
        "the noise differs over the part, {least} to {most} nm: the RMS without noise counts {rms} nm, their root mean square, and all \
         else {sigma} nm everywhere"
    ))
}

/// What heights in steps do not tell.
pub(crate) fn in_steps(step_mm: f64) -> String {
    let step = short(1e6 * step_mm);
    format!(
        "form below {step} nm is not known: the heights come in steps of {step} nm, and neighbours share their errors"
    )
}

impl Findings {
    /// Next measurements on a part that lies at `pose` in the frame of the plane.
    pub(crate) fn next(&mut self, plane: &Plane, part: &Part, pose: &Pose) -> Option<Next> {
        let patches = std::mem::take(&mut self.coverage.as_mut()?.patches);
        let lifted = Lifted::onto_nominal(*plane, &part.nominal, pose);
        Some(Next::new(patches, self.otherwise_mm, lifted))
    }

    /// Places to measure, at the height of the mesh.
    pub(crate) fn waypoints(&self, sampled: Sampled<'_>) -> Option<Waypoints> {
        let lifted = Lifted::onto_mesh(*sampled.plane, sampled.mesh);
        let patches = &self.coverage.as_ref()?.patches;
        Some(next::places_to_go(patches, self.otherwise_mm, &lifted))
    }
}

impl Findings {
    /// Nothing is known but what was asked.
    pub(super) fn unknown(
        sampled: Sampled<'_>,
        wanted: Wanted,
        scale: &Scale,
        unknown: Vec<String>,
    ) -> Findings {
        let points = sampled.mesh.points();
        Findings {
            figures: SamplingFigures {
                epsilon_target: wanted.epsilon,
                rho_target: wanted.rho,
                gap_limit_mm: scale.gap_mm,
                as_of_points: sampled.mesh.counts().pushed,
                unknown,
                ..SamplingFigures::default()
            },
            noise_unknown: None,
            covered: vec![false; sampled.triangles.len()],
            area_mm2: asphera_mesh::area(points, sampled.triangles.iter().copied()).lifted_mm2,
            coverage: None,
            zones: Vec::new(),
            otherwise_mm: scale.gap_mm.map(|gap_mm| SQRT_2 * gap_mm),
        }
    }
}

/// The smallest and the largest spacing that will do, as far as there are such bounds. Where they contradict each other both are told.
fn bounds_mm(advice: Advice) -> (Option<f64>, Option<f64>) {
    let (finest_mm, coarsest_mm) = match advice {
        Advice::Between { noise_bound_mm, epsilon_bound_mm, .. }
        | Advice::Conflict { noise_bound_mm, epsilon_bound_mm } => {
            (noise_bound_mm, Some(epsilon_bound_mm))
        }
        Advice::AtLeast { noise_bound_mm } => (noise_bound_mm, None),
    };
    let told = |mm: &f64| mm.is_finite() && *mm > 0.0;
    (Some(finest_mm).filter(told), coarsest_mm.filter(told))
}

/// The spacing to be recommended, if there is one.
fn recommended_mm(advice: Advice) -> Option<f64> {
    match advice {
        Advice::Between { recommended_mm, epsilon_bound_mm, .. } => {
            // Without noise the truest normals are those of samples without distance: the widest will do.
            Some(if recommended_mm > 0.0 { recommended_mm } else { epsilon_bound_mm })
        }
        Advice::AtLeast { .. } | Advice::Conflict { .. } => None,
    }
}

fn not_examined(error: &CoverageError) -> String {
    format!("the sampling is not known: {}", asphera_report::error_chain(error))
}
