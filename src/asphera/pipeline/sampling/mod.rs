//! How densely a part is sampled: one look at a whole mesh, and what it tells.
//!
//! The figures are those of `asphera_surface::coverage`, made in the plane of projection; the aperture is laid
//! there with the part ([`border`]), and what has a place is turned back into the measured frame. The local
//! feature size is the nominal's ([`meridian`], [`freeform`]), or, without one, that of the points ([`measured`]).

mod border;
mod current;
mod freeform;
mod measured;
mod meridian;
mod next;
mod noise;
mod places;
mod reach;
mod wanted;
mod zones;

use std::f64::consts::SQRT_2;

use asphera_form::{Nominal, Pose};
use asphera_surface::coverage::{
    Aperture, Coverage, CoverageError, Density, Examination, cover, examine,
};
use asphera_surface::noise::{Advice, Noise, NoiseEstimate};
use asphera_surface::{Mesh, Plane, PointMm, Relief, VertexId, topography};
use rayon::prelude::*;

use self::freeform::{Footprint, Freeform};
use self::measured::{Cells, Measured};
use self::meridian::Meridian;
use self::places::Lifted;
use super::defects::{self, Meshed};
use super::look::look;
use super::projection::{Along, Projector};
use crate::config::Part;
use crate::report::{FeatureFigures, SamplingFigures};

pub(crate) use self::current::Current;
pub use self::next::{MOST_PLACES, Next, Waypoints};
pub use self::wanted::Wanted;
pub(crate) use self::zones::ZoneSampling;

/// A mesh in the frame of its plane of projection.
#[derive(Clone, Copy)]
pub(crate) struct Sampled<'a> {
    pub(crate) mesh: &'a Mesh,
    /// Its triangles.
    pub(crate) triangles: &'a [[VertexId; 3]],
    pub(crate) plane: &'a Plane,
}

/// What was found.
pub(crate) struct Findings {
    pub(crate) figures: SamplingFigures,
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

/// The sampling of points of which nothing else is known.
#[derive(Clone, Debug)]
pub struct PointsSampling {
    /// The figures.
    pub figures: SamplingFigures,
    /// Defects, and which way the surface bends.
    pub features: FeatureFigures,
    /// Where to measure next, if anything is known.
    pub waypoints: Option<Waypoints>,
}

/// Says how densely points sample their surface, projected as `along` says. Those that are not finite are left
/// out.
pub fn sampling_of_points(
    points: impl IntoIterator<Item = PointMm>,
    along: Along,
    wanted: Wanted,
) -> PointsSampling {
    let (mut mesh, mut projector) = (Mesh::new(), Projector::new(along));
    for point in points {
        projector.take(point, |point, _| mesh.push(point));
    }
    projector.finish(|point, _| mesh.push(point));
    mesh.flush();
    let (triangles, plane) = (mesh.triangles(), projector.plane());
    let folds: Vec<usize> =
        topography(mesh.points(), &triangles, &Relief::default()).triangles_of_folds().collect();
    let sampled = Sampled { mesh: &mesh, triangles: &triangles, plane: &plane };
    let findings = of_points(sampled, &folds, wanted);
    let waypoints = findings.waypoints(sampled);
    let meshed =
        Meshed { mesh: &mesh, triangles: &triangles, plane: &plane, sampling: &findings.figures };
    let features = defects::of_points(meshed);
    PointsSampling { figures: findings.figures, features, waypoints }
}

/// The sampling of a mesh in the frame of `plane`, of a part that lies there at `pose`: all that the final
/// report says of it. `remembered` saves the second look at one part what only depends on its nominal.
pub fn sampling_of_mesh(
    mesh: &Mesh,
    part: &Part,
    pose: &Pose,
    plane: &Plane,
    remembered: &mut Remembered,
) -> SamplingFigures {
    look(mesh, part, pose, plane, remembered).sampling
}

impl Findings {
    /// What to measure next on a part that lies at `pose` in the frame of the plane.
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

/// The local feature size of a part that was looked at before, for the next look.
#[derive(Clone, Debug, Default)]
pub struct Remembered(Known);

/// What is known of a local feature size.
#[derive(Clone, Debug, Default)]
enum Known {
    #[default]
    Nothing,
    /// That of a nominal of revolution, over a disc of this radius in mm.
    Nominal { radius_mm: f64, meridian: Meridian },
    /// That of a freeform nominal.
    Freeform(Freeform),
    /// That of the points, at places of the plane.
    Points(Lfs),
}

impl Remembered {
    /// That of a part at `pose`, at places of the plane; `None` where it is not known.
    pub(crate) fn lfs_mm(&self, pose: &Pose) -> impl Fn(f64, f64) -> Option<f64> + use<'_> {
        let (tx, ty) = (pose.tx_mm, pose.ty_mm);
        let [[ax, bx, _], [ay, by, _], _] = pose.rotation();
        // Tilts of a part are small, so the place is only shifted, and turned about z; a local feature size
        // changes by no more than the way between.
        move |x, y| match &self.0 {
            Known::Nothing => None,
            Known::Nominal { meridian, .. } => {
                let (x, y) = (x - tx, y - ty);
                // Not hypot, which is slower: a place of a mesh neither overflows nor vanishes.
                meridian.at((x * x + y * y).sqrt())
            }
            Known::Freeform(freeform) => {
                let (x, y) = (x - tx, y - ty);
                freeform.at(ax * x + ay * y, bx * x + by * y)
            }
            Known::Points(lfs) => lfs.at(x, y),
        }
    }

    /// Looks for that of the nominal, unless it is known. Fails with the reason in words.
    fn look_at_nominal(
        &mut self,
        part: &Part,
        points: &[PointMm],
        pose: &Pose,
    ) -> Result<(), String> {
        if part.nominal.freeform().is_some() {
            return self.look_at_freeform(part, points, pose);
        }
        let radius_mm =
            border::radius_mm(&part.aperture).unwrap_or_else(|| reach_mm_of(points, pose));
        if matches!(&self.0, Known::Nominal { radius_mm: known, .. } if *known == radius_mm) {
            return Ok(());
        }
        self.0 = Known::Nothing;
        let meridian = Meridian::of(&part.nominal, radius_mm)
            .map_err(|error| format!("the nominal has no local feature size: {error}"))?;
        self.0 = Known::Nominal { radius_mm, meridian };
        Ok(())
    }

    /// The same of a freeform.
    fn look_at_freeform(
        &mut self,
        part: &Part,
        points: &[PointMm],
        pose: &Pose,
    ) -> Result<(), String> {
        let footprint = Footprint::of(&part.aperture, points, pose);
        if matches!(&self.0, Known::Freeform(known) if *known.footprint() == footprint) {
            return Ok(());
        }
        self.0 = Known::Nothing;
        let freeform = Freeform::of(&part.nominal, footprint)
            .map_err(|error| format!("the nominal has no local feature size: {error}"))?;
        self.0 = Known::Freeform(freeform);
        Ok(())
    }
}

/// Looks at the sampling of a part that lies at `pose` in the frame of the plane. Triangles of `left_out`,
/// ascending indices, are not surface.
pub(crate) fn of_part(
    sampled: Sampled<'_>,
    left_out: &[usize],
    part: &Part,
    pose: &Pose,
    remembered: &mut Remembered,
) -> Findings {
    let points = sampled.mesh.points();
    let wanted = Wanted::of(part);
    let scale = Scale::of(sampled, wanted);
    let mut unknown = Vec::new();
    let aperture = match border::laid(&part.aperture, &part.nominal, pose) {
        Ok(aperture) => aperture,
        Err(error) => {
            unknown.push(format!("the aperture cannot be laid into the points: {error}"));
            return Findings::unknown(sampled, wanted, &scale, unknown);
        }
    };
    let counts = |point: PointMm| {
        let [x, y, _] = pose.to_part(point);
        part.aperture.contains(x, y)
    };
    let reach_mm = scale.reach_mm().ok_or_else(nothing_spanned);
    let noise = reach_mm.clone().and_then(|reach_mm| noise::noise(sampled.mesh, reach_mm, counts));
    let looked = match part.reference {
        Some(_) => Err("no design is known".to_owned()),
        None => remembered.look_at_nominal(part, points, pose).map(|()| "nominal"),
    };
    let found = looked.or_else(|why| {
        if part.reference.is_none() && part.nominal.is_rotational() {
            return Err(why);
        }
        // No design, or a freeform finer than a raster shows: the points tell more.
        Lfs::of_points(sampled, &noise, &reach_mm).map(|(lfs, source)| {
            remembered.0 = Known::Points(lfs);
            source
        })
    });
    let source = found
        .map_err(|why| {
            remembered.0 = Known::Nothing;
            unknown.push(why);
        })
        .ok();
    let reach_mm = remembered.reach_mm(&part.aperture, points, pose);
    let lfs_mm = remembered.lfs_mm(pose);
    let lifted = Lifted::onto_nominal(*sampled.plane, &part.nominal, pose);
    let zones = zones::laid(part, pose);
    Look { sampled, left_out, wanted, scale, aperture, zones, noise, source, reach_mm, unknown }
        .findings(lfs_mm, &lifted)
}

/// Looks at the sampling of a surface of which nothing is known but the points.
pub(crate) fn of_points(sampled: Sampled<'_>, left_out: &[usize], wanted: Wanted) -> Findings {
    let scale = Scale::of(sampled, wanted);
    let mut unknown = Vec::new();
    let reach_mm = scale.reach_mm().ok_or_else(nothing_spanned);
    let noise =
        reach_mm.clone().and_then(|reach_mm| noise::noise(sampled.mesh, reach_mm, |_| true));
    let (lfs, source) = match Lfs::of_points(sampled, &noise, &reach_mm) {
        Ok((lfs, source)) => (lfs, Some(source)),
        Err(why) => {
            unknown.push(why);
            (Lfs::Unknown, None)
        }
    };
    let lfs_mm = |x: f64, y: f64| lfs.at(x, y);
    let reach_mm = reach::least_at(sampled.mesh.points(), |_| true, lfs_mm);
    let lifted = Lifted::onto_mesh(*sampled.plane, sampled.mesh);
    let (aperture, zones) = (None, Vec::new());
    Look { sampled, left_out, wanted, scale, aperture, zones, noise, source, reach_mm, unknown }
        .findings(lfs_mm, &lifted)
}

/// The local feature size of points.
#[derive(Clone, Debug)]
enum Lfs {
    Cells(Cells),
    Everywhere(f64),
    Unknown,
}

impl Lfs {
    /// What the points say, and where they say it from: `measured` of medial balls, `curvature` where noise
    /// leaves no more than a bound. Fails with the reason in words.
    fn of_points(
        sampled: Sampled<'_>,
        noise: &Result<NoiseEstimate, String>,
        reach_mm: &Result<f64, String>,
    ) -> Result<(Lfs, &'static str), String> {
        let found = match (noise, reach_mm) {
            (Ok(noise), Ok(reach_mm)) => {
                measured::measured(sampled.mesh.points(), sampled.triangles, noise.noise, *reach_mm)
            }
            _ => Err("the noise is not known".to_owned()),
        };
        match found {
            Ok(Measured::Balls(cells)) => Ok((Lfs::Cells(cells), "measured")),
            Ok(Measured::Curvature(radius_mm)) => Ok((Lfs::Everywhere(radius_mm), "curvature")),
            Err(why) => Err(format!("the local feature size is not known: {why}")),
        }
    }

    /// At a place of the plane, in mm.
    fn at(&self, x_mm: f64, y_mm: f64) -> Option<f64> {
        match self {
            Lfs::Cells(cells) => cells.at(x_mm, y_mm),
            Lfs::Everywhere(mm) => Some(*mm),
            Lfs::Unknown => None,
        }
    }
}

/// What is looked at.
struct Look<'a> {
    sampled: Sampled<'a>,
    left_out: &'a [usize],
    wanted: Wanted,
    scale: Scale,
    aperture: Option<Aperture>,
    zones: Vec<(asphera_form::Aperture, Aperture)>,
    noise: Result<NoiseEstimate, String>,
    /// Where the local feature size comes from.
    source: Option<&'static str>,
    /// The smallest one, infinite over a plane.
    reach_mm: Option<f64>,
    unknown: Vec<String>,
}

impl Look<'_> {
    fn findings(
        mut self,
        lfs_mm: impl Fn(f64, f64) -> Option<f64> + Sync,
        lifted: &Lifted<'_>,
    ) -> Findings {
        let Sampled { mesh, triangles, plane } = self.sampled;
        let target = self.wanted.target(self.scale.gap_mm, self.reach_mm);
        let is_reach_wanting = self.wanted.rho.is_some() && self.reach_mm.is_none();
        if is_reach_wanting {
            self.unknown.push("the reach is not known, and so ρ is not".to_owned());
        }
        let noise: Option<Noise> = match &self.noise {
            Ok(found) => Some(found.noise),
            Err(why) => {
                self.unknown.push(format!("the noise is not known: {why}"));
                None
            }
        };
        // A target that is none is told by the examination.
        let density = self.wanted.criteria().map(|criteria| Density { noise, criteria });
        let zones = self.zones.iter().map(|(zone, laid)| {
            let found =
                cover(mesh.points(), triangles, self.left_out, Some(laid), &target, &lfs_mm);
            ZoneSampling::of(*zone, found.ok())
        });
        let zones = zones.collect();
        let examined = examine(
            mesh,
            triangles,
            self.left_out,
            self.aperture.as_ref(),
            &target,
            density.as_ref(),
            lfs_mm,
        );
        let Examination { coverage, covered, islands, dense, area_mm2 } = match examined {
            Ok(examination) => examination,
            Err(error) => {
                self.unknown.push(not_examined(&error));
                return Findings::unknown(self.sampled, self.wanted, &self.scale, self.unknown);
            }
        };
        let nothing = if triangles.is_empty() {
            Some(nothing_spanned())
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
        let shown_mm2: f64 = listed.iter().map(|next| next.area_mm2).sum();
        let all_mm2: f64 = coverage.patches.iter().map(|patch| patch.area_mm2).sum::<f64>()
            + coverage.remainder_mm2;
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
            noise_sigma_nm: noise.map(|noise| 1e6 * noise.sigma_mm()),
            spacing_median_mm: dense.and_then(|dense| dense.spacing_median_mm),
            overdense_fraction: dense.and_then(|dense| dense.overdense_fraction),
            spacing_recommended_mm: dense.and_then(|dense| recommended_mm(dense.advice?)),
            next: listed,
            next_more: more as u64 + coverage.remainder_patches,
            next_more_area_mm2: (all_mm2 - shown_mm2).max(0.0),
            unknown: self.unknown,
            as_of_points: mesh.counts().pushed,
            islands: areas.map(|_| islands.islands),
            holes: areas.map(|_| islands.holes),
            hole_max_mm2: areas.and(islands.hole_max_mm2),
            current: None,
        };
        let coverage = Some(coverage);
        Findings { figures, covered, area_mm2, coverage, zones, otherwise_mm: target.spacing_mm }
    }
}

impl Findings {
    /// Nothing is known but what was asked.
    fn unknown(
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
            covered: vec![false; sampled.triangles.len()],
            area_mm2: asphera_surface::area(points, sampled.triangles.iter().copied()).lifted_mm2,
            coverage: None,
            zones: Vec::new(),
            otherwise_mm: scale.gap_mm.map(|gap_mm| SQRT_2 * gap_mm),
        }
    }
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
    format!("the sampling is not known: {}", crate::error_chain(error))
}

fn nothing_spanned() -> String {
    "the points span no area".to_owned()
}

/// The scale of the samples.
#[derive(Clone, Copy, Debug)]
struct Scale {
    /// The distance points have on average.
    distance_mm: Option<f64>,
    /// The largest gap allowed.
    gap_mm: Option<f64>,
}

impl Scale {
    fn of(sampled: Sampled<'_>, wanted: Wanted) -> Scale {
        let points = sampled.mesh.points();
        let area_mm2 = projected_mm2(points, sampled.triangles);
        let distance_mm = (area_mm2 / points.len() as f64).sqrt();
        let distance_mm = (distance_mm > 0.0 && distance_mm.is_finite()).then_some(distance_mm);
        // On a flat surface ε allows anything, and a triangulation fills every hole.
        let gap_mm = wanted.gap_mm.or(distance_mm.map(|distance_mm| GAP * distance_mm));
        Scale { distance_mm, gap_mm }
    }

    /// The length from which an edge bridges a gap.
    fn reach_mm(&self) -> Option<f64> {
        Some(REACH * self.distance_mm?)
    }
}

/// Area of the hull in mm².
fn projected_mm2(points: &[PointMm], triangles: &[[VertexId; 3]]) -> f64 {
    let twice_mm2 = |&[a, b, c]: &[VertexId; 3]| {
        let [[ax, ay, _], [bx, by, _], [cx, cy, _]] =
            [a, b, c].map(|corner| points[corner as usize]);
        (bx - ax) * (cy - ay) - (by - ay) * (cx - ax)
    };
    let chunks: Vec<f64> =
        triangles.par_chunks(CHUNK).map(|chunk| chunk.iter().map(twice_mm2).sum::<f64>()).collect();
    0.5 * chunks.into_iter().sum::<f64>()
}

/// The largest distance of a point from the axis in mm.
fn reach_mm_of(points: &[PointMm], pose: &Pose) -> f64 {
    let distance_mm = |point: &PointMm| (point[0] - pose.tx_mm).hypot(point[1] - pose.ty_mm);
    points.par_iter().with_min_len(CHUNK).map(distance_mm).reduce(|| 0.0, f64::max)
}

/// The height of a nominal over a place of the part in mm; beyond its domain that at the end of it, on the
/// way to the axis.
fn height_mm(nominal: &Nominal, [x, y]: [f64; 2]) -> f64 {
    if nominal.is_rotational() {
        return nominal.sag_mm(x.hypot(y).min(nominal.domain_mm()));
    }
    nominal.height_mm(x, y).unwrap_or_else(|| {
        let inwards = (nominal.domain_mm() / x.hypot(y)).min(1.0) * WITHIN;
        nominal.height_mm(x * inwards, y * inwards).unwrap_or(f64::NAN)
    })
}

/// The border of a domain itself may be beyond it by rounding.
const WITHIN: f64 = 1.0 - 1e-12;

/// The largest gap allowed where nothing is said, in average distances.
const GAP: f64 = 4.0;
/// The length of an edge that bridges, in the same.
const REACH: f64 = 6.0;
/// Triangles of a chunk. Sums over it are part of the result.
const CHUNK: usize = 1 << 14;

#[cfg(test)]
mod tests;
