//! Parts that no plane shows whole: meshed in space, and judged as a whole.
//!
//! [`Gathered`] takes the points and looks at them whenever they have grown by a quarter. A look is a function of the points it
//! is of, so running figures depend on how many points there were, and on nothing else. [`measure`] makes the final figures of all
//! of them.

mod assessment;
mod chart;
mod cover;
mod feature_size;
mod fit;
mod form;
mod growing;
mod matrix;
mod meshed;
mod noise;
mod openings;
mod patch;
mod reduction;
mod sampled;
mod shape;
mod surface;
mod verdict;

use std::borrow::Cow;
use std::sync::Arc;

use asphera_geometry::PointMm;
use asphera_mesh::Mesh;
use asphera_report::{
    Convergence, Cut, FormFigures, Map, MeshFigures, Points, Refusal, SamplingFigures,
    SectionRequest, Verdict,
};
use asphera_surface::Plane;

use self::assessment::SpaceAssessment;
use self::form::Formed;
use self::growing::GrowingMesh;
use self::meshed::Meshed;
pub use self::reduction::{
    ReducedInSpace, ReductionLimits, ReductionState, SparseInSpace, reduce_in_space,
};
pub use self::surface::{SurfaceInSpace, refuse_path};
use self::verdict::Evidence;
use super::cutting::{FinishedMesh, Setting};
use super::defects;
use super::measurement::{Measurement, report};
use super::pipeline::next_look;
use super::sampling::{PointsSampling, Remembered, Wanted};
use super::step::Step;
use crate::{Part, judgement};
use asphera_uncertainty::Noise;

/// When points are meshed in space.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum When {
    /// Whatever they are.
    Always,
    /// Where they fold over the plane.
    Folded,
}

/// The points of a part, to be meshed in space.
pub(super) struct Gathered {
    when: When,
    points_mm: Vec<PointMm>,
    /// The mesh of points that somebody looks at.
    growing: GrowingMesh,
    /// How many points there will be, as far as that was known at the last look.
    expected: Option<u64>,
    /// Up to how many points were looked at, and what that told.
    newest: Option<(usize, Arc<Result<SpaceAssessment, String>>)>,
    convergence: Convergence,
}

/// Running figures in space.
#[derive(Default)]
pub(super) struct RunningInSpace {
    pub(super) mesh: MeshFigures,
    pub(super) sampling: SamplingFigures,
    pub(super) form: Option<FormFigures>,
    pub(super) map: Option<Map>,
    pub(super) convergence: Convergence,
    pub(super) used: u64,
    pub(super) duplicates: u64,
    /// Points that are not in the mesh yet.
    pub(super) pending: u64,
}

impl Gathered {
    pub(super) fn new(when: When) -> Gathered {
        let convergence = Convergence::default();
        let growing = GrowingMesh::default();
        Gathered { when, points_mm: Vec::new(), growing, expected: None, newest: None, convergence }
    }

    /// Whether points go into the mesh in the plane as well.
    pub(super) fn is_beside_plane(&self) -> bool {
        self.when == When::Folded
    }

    pub(super) fn push(&mut self, point_mm: PointMm) {
        self.points_mm.push(point_mm);
        // Points of a file, at which nobody looks, are meshed at once in the end.
        if let Some((newest, _)) = self.newest {
            let next = next_look(newest as u64, self.expected) as usize;
            self.growing.follow(&self.points_mm, next);
        }
    }

    pub(super) fn is_empty(&self) -> bool {
        self.points_mm.is_empty()
    }

    /// Running figures as of the last number of points at which they are looked at; `folded` is why the points do not project,
    /// where that is known.
    pub(super) fn running(
        &mut self,
        part: &Part,
        expected: Option<u64>,
        folded: Option<&str>,
    ) -> RunningInSpace {
        let count = self.points_mm.len();
        let at = last_look(count as u64, expected) as usize;
        if at > 0 && self.newest.as_ref().is_none_or(|(newest, _)| *newest != at) {
            self.expected = expected;
            let meshed = self.growing.mesh(&self.points_mm[..at]);
            let wanted = Wanted::of(part);
            let found = meshed.map(|meshed| {
                SpaceAssessment::of_mesh(meshed, at, Some(part), wanted, reason(folded))
            });
            if let Ok(SpaceAssessment { formed: Ok(formed), .. }) = &found {
                self.note(at as u64, formed);
            }
            self.newest = Some((at, Arc::new(found)));
        }
        let (at, found) = match &self.newest {
            Some((at, found)) => (*at, Some(&**found)),
            None => (0, None),
        };
        let found = match found {
            Some(Ok(found)) => found,
            other => {
                let why = other.and_then(|other| other.as_ref().err());
                let unknown = why.into_iter().cloned().collect();
                return RunningInSpace {
                    sampling: SamplingFigures { unknown, ..SamplingFigures::default() },
                    convergence: self.convergence.clone(),
                    pending: count as u64,
                    ..RunningInSpace::default()
                };
            }
        };
        let form = found.formed.as_ref().ok();
        RunningInSpace {
            mesh: found.mesh.clone(),
            sampling: found.sampling.clone(),
            map: form.and_then(|formed| formed.chart(&found.meshed)),
            form: form.map(|formed| formed.report(part, is_noise_measured(part), true)),
            convergence: self.convergence.clone(),
            used: found.meshed.points_mm.len() as u64,
            duplicates: found.meshed.duplicates,
            pending: (count - at) as u64,
        }
    }

    fn note(&mut self, points: u64, formed: &Formed) {
        let errors = formed.errors.as_ref();
        let u_nm = [errors.map(|known| known.u_pv_nm), errors.map(|known| known.u_rms_nm)];
        let basis = "by the noise of the points alone, where it is known".to_owned();
        let values_nm = [formed.figures.pv_nm, formed.figures.rms_nm];
        self.convergence.push(points, values_nm, u_nm, [basis.clone(), basis]);
    }

    /// A section of the mesh of the last look; `None` before the first.
    pub(super) fn section(&self, request: &SectionRequest) -> Cut {
        let plane = match surface::plane_of(request) {
            Ok(plane) => plane,
            Err(refusal) => return (!self.is_empty()).then_some(Err(refusal)),
        };
        let (_, found) = self.newest.as_ref()?;
        Some(match &**found {
            Ok(SpaceAssessment { meshed, sampling, formed, .. }) => {
                let laid = formed.as_ref().ok().map(|formed| &formed.fit.laid);
                let Meshed { points_mm, facets, .. } = meshed;
                surface::cut(points_mm, facets, laid, sampling.gap_limit_mm, &plane)
                    .map_err(Refusal::new)
            }
            Err(why) => Err(Refusal(why.clone())),
        })
    }

    /// The mesh of the last look.
    pub(super) fn mesh(&self) -> (Cow<'_, [PointMm]>, Vec<[u32; 3]>) {
        match self.newest.as_ref().map(|(_, found)| &**found) {
            Some(Ok(found)) => {
                (Cow::Borrowed(&found.meshed.points_mm), found.meshed.facets.clone())
            }
            _ => (Cow::Borrowed(&[]), Vec::new()),
        }
    }
}

/// The last number of points, up to `count`, at which running figures are made; 0 before the first.
fn last_look(count: u64, expected: Option<u64>) -> u64 {
    let (mut last, mut next) = (0, FIRST_LOOK);
    while next <= count {
        last = next;
        next = next_look(last, expected);
    }
    last
}

/// The final figures of all points in space. `folded` is why they do not project, where that was the reason.
pub(super) fn measure(
    gathered: Gathered,
    mut points: Points,
    part: Part,
    folded: Option<&str>,
    begin: &mut dyn FnMut(Step),
) -> Measurement {
    begin(Step::Sampling);
    let Gathered { points_mm, mut growing, .. } = gathered;
    let meshed = growing.mesh(&points_mm);
    drop(growing);
    let look = meshed.map(|meshed| {
        let wanted = Wanted::of(&part);
        SpaceAssessment::of_mesh(meshed, points_mm.len(), Some(&part), wanted, reason(folded))
    });
    drop(points_mm);
    begin(Step::Verdict);
    let look = match look {
        Ok(look) => look,
        Err(why) => return unmeshed(points, part, &why),
    };
    let evidence = Evidence {
        part: &part,
        meshed: &look.meshed,
        formed: look.formed.as_ref().map_err(String::as_str),
        sampling: &look.sampling,
        openings: &look.openings,
    };
    let verdict = evidence.verdict();
    let form = look.formed.as_ref().ok();
    points.used = form.map_or(0, |formed| formed.deviations_mm.len() as u64);
    points.duplicates = look.meshed.duplicates;
    if look.meshed.rejected > 0 {
        *points.flagged.entry("not_meshable".to_owned()).or_default() += look.meshed.rejected;
    }
    let cells = form.and_then(|formed| formed.chart(&look.meshed));
    let deviations_nm = match form {
        Some(formed) => formed.deviations_mm.iter().map(|mm| 1e6 * mm).collect(),
        None => vec![f64::NAN; look.meshed.points_mm.len()],
    };
    let form = form.map(|formed| formed.report(&part, is_noise_measured(&part), false));
    let laid = look.formed.as_ref().ok().map(|formed| formed.fit.laid);
    let SpaceAssessment { meshed, sampling, mut mesh, .. } = look;
    mesh.decision = folded.map(|why| format!("in space, for {why}"));
    let report = report(points, mesh, sampling, defects::not_looked_for(IN_SPACE), form, verdict);
    let surface = SurfaceInSpace::new(&meshed, laid, report.sampling.gap_limit_mm);
    let surface = no_plane(part, Some(surface));
    Measurement {
        report,
        surface,
        points_mm: meshed.points_mm,
        triangles: meshed.facets,
        deviations_nm,
        map: None,
        cells,
        next: None,
    }
}

/// As [`measure`], of points that were meshed in the plane first and fold there.
pub(super) fn measure_folded(
    gathered: Gathered,
    mut points: Points,
    part: Part,
    why: &str,
    begin: &mut dyn FnMut(Step),
) -> Measurement {
    for of_plane in OF_PLANE {
        points.flagged.remove(of_plane);
    }
    measure(gathered, points, part, Some(why), begin)
}

/// The sampling of points of which nothing is known, meshed in space.
pub(super) fn sampling(
    points_mm: &[PointMm],
    wanted: Wanted,
    folded: Option<&str>,
) -> PointsSampling {
    let figures = match SpaceAssessment::at(points_mm, None, wanted, reason(folded)) {
        Ok(look) => look.sampling,
        Err(why) => SamplingFigures { unknown: vec![why], ..SamplingFigures::default() },
    };
    PointsSampling { figures, features: defects::not_looked_for(IN_SPACE), waypoints: None }
}

fn reason(folded: Option<&str>) -> &str {
    folded.unwrap_or("asked for: along = \"none\"")
}

fn unmeshed(points: Points, part: Part, why: &str) -> Measurement {
    let mut verdict = Verdict::default();
    judgement::doubt(&mut verdict, why.to_owned());
    let unknown = vec![why.to_owned()];
    let sampling = SamplingFigures { unknown, ..SamplingFigures::default() };
    Measurement {
        report: report(
            points,
            MeshFigures::default(),
            sampling,
            defects::not_looked_for(IN_SPACE),
            None,
            verdict,
        ),
        surface: no_plane(part, None),
        points_mm: Vec::new(),
        triangles: Vec::new(),
        deviations_nm: Vec::new(),
        map: None,
        cells: None,
        next: None,
    }
}

/// A mesh in the plane that is empty, and the surface in space where there is one.
fn no_plane(part: Part, surface: Option<SurfaceInSpace>) -> FinishedMesh {
    let setting = Setting {
        part,
        plane: Plane::XY,
        lies: None,
        gap_limit_mm: None,
        areas_mm2: Vec::new().into(),
        grid: None,
        maps_version: 0,
        remembered: Remembered::default(),
        in_space: Some(surface),
    };
    FinishedMesh::new(Mesh::new(), setting)
}

fn is_noise_measured(part: &Part) -> bool {
    let budget = part.judging.uncertainty.as_ref();
    budget.is_none_or(|(budget, _)| budget.noise == Noise::Measured)
}

/// Flags of points that a mesh in the plane cannot take.
pub(super) const OF_PLANE: [&str; 2] = ["conflict", "not_meshable"];
/// Why neither defects nor a partition are looked for.
const IN_SPACE: &str = "the mesh is in space";
/// What was chosen for points that do not fold.
pub(super) const PROJECTS: &str = "in the plane, for the points project along z";
/// Below this many points a mesh in space says little.
const FIRST_LOOK: u64 = 500;
