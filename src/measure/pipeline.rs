//! The running measurement of one part.

use std::borrow::Cow;
use std::collections::BTreeMap;
use std::sync::Arc;

use asphera_form::{Aperture, LiveEstimate};
use asphera_geometry::{Point, PointMm};
use asphera_mesh::{BATCH_POINTS, Mesh};
use asphera_report::{
    Convergence, Cut, FormFigures, FormViewAnswer, Map, MeshFigures, Outlook, Points, Refusal,
    SamplingFigures, SamplingMaps, SectionRequest, Term,
};
use asphera_surface::Plane;

use crate::errors::Errors;
use crate::heights::{Height, Heights, up};
use crate::measurement::{self, Gathered, Grids, Measurement};
use crate::profile;
use crate::projection::{self, Along, Projector};
use crate::prospects::{self, Now, Prospects};
use crate::running::{History, Running};
use crate::sampling::{Current, Next, Remembered};
use crate::space::{self, Gathered as InSpace};
use crate::step::Step;
use crate::systematic::{Contributions, Systematic};
use crate::tip::{self, Centres, Tip};
use crate::{
    Part, Weights, assessment, cells, cutting, figures, fit_details, maps, origin, removal,
};

/// Takes the points of one part.
pub struct Pipeline {
    part: Part,
    projector: Projector,
    /// In the frame of the plane of projection, as are the points of the running figures.
    mesh: Mesh,
    pub(crate) running: Running,
    history: History,
    /// Errors of the points, as of the last look.
    pub(crate) errors: Errors,
    pub(crate) prospects: Prospects,
    /// Points there will be, at most.
    expected_points: Option<u64>,
    received: u64,
    flagged: BTreeMap<&'static str, u64>,
    /// The sampling, as of the last time it was looked at.
    pub(crate) sampling: SamplingFigures,
    /// Figures of the mesh as of then.
    seen: MeshFigures,
    /// Maps as of then.
    maps: Option<Arc<SamplingMaps>>,
    /// How often it was looked at.
    looks: u64,
    /// Next measurements, as of then.
    next: Option<Next>,
    /// Points at which it is looked at again.
    next_sampling: u64,
    /// Points from which on a look foresees limits again.
    next_foresight: u64,
    remembered: Remembered,
    /// The sampling as of the last batch.
    current: Current,
    /// How well the heights of points are known; `None` where these are no weights.
    heights: Option<Heights>,
    /// Slopes of a file that has them.
    slopes: profile::Slopes,
    /// The points, where they may be meshed in space.
    space: Option<InSpace>,
    /// Why they do not project, as of the last look.
    folded: Option<String>,
    /// Along what they are projected, as it was asked for.
    along: Along,
    /// Centres of a ball tip, whose contacts the points are.
    centres: Option<Centres>,
    /// Errors that all points have together.
    systematic: Vec<Systematic>,
    /// Whether more of them will be known at the end.
    awaits_systematic: bool,
}

/// The running figures of a part.
pub struct RunningFigures {
    /// Counts of the points by their fate; `used` are those of the running fit.
    pub points: Points,
    /// The mesh; points wait up to a batch before they are in it.
    pub mesh: MeshFigures,
    /// The sampling, as of [`SamplingFigures::as_of_points`], and what is kept current of it.
    pub sampling: SamplingFigures,
    /// The form, once a fit could be made.
    pub form: Option<FormFigures>,
    /// The deviation over the aperture.
    pub map: Option<Map>,
    /// The cells of that map, to take terms out of.
    cells: Option<Cells>,
    /// The sampling over the aperture, as of [`SamplingFigures::as_of_points`].
    pub maps: Option<Arc<SamplingMaps>>,
    /// PV and RMS so far.
    pub convergence: Convergence,
    /// Outlook for the limits; absent without one, and before the first fit.
    pub outlook: Option<Outlook>,
    /// Points received but not yet in the mesh.
    pub pending: u64,
}

/// The cells of a running map.
struct Cells {
    map: asphera_form::Map,
    aperture: Aperture,
    /// Where figures count from, beside the origin of the map.
    origin_mm: [f64; 2],
    used: u64,
}

impl RunningFigures {
    /// The deviation without `terms`, of the cells of the map; `None` before the first fit.
    pub fn without(&self, terms: &[Term]) -> FormViewAnswer {
        let Cells { map, aperture, origin_mm, used } = self.cells.as_ref()?;
        let view = removal::of_cells((map, *origin_mm), aperture, *used, terms);
        Some(view.map_err(Refusal::new))
    }
}

impl Pipeline {
    /// For one part, whose points are projected along z.
    pub fn new(part: Part) -> Pipeline {
        Pipeline::along(part, Along::Z)
    }

    /// For one part and a plane of projection. Until a plane that is to be fitted is known, points wait.
    pub fn along(part: Part, along: Along) -> Pipeline {
        let is_weighted = part.criterion.weights == Weights::Uncertainty;
        let heights = is_weighted.then(Heights::default);
        Pipeline {
            projector: Projector::new(along),
            running: Running::new(&part),
            history: History::default(),
            errors: Errors::new(&part),
            prospects: Prospects::default(),
            expected_points: None,
            mesh: Mesh::new(),
            part,
            received: 0,
            flagged: BTreeMap::new(),
            sampling: SamplingFigures::default(),
            seen: MeshFigures::default(),
            maps: None,
            looks: 0,
            next: None,
            next_sampling: FIRST_SAMPLING,
            next_foresight: 0,
            remembered: Remembered::default(),
            current: Current::default(),
            heights,
            slopes: profile::Slopes::default(),
            space: along.in_space().map(InSpace::new),
            folded: None,
            along,
            centres: None,
            systematic: Vec::new(),
            awaits_systematic: false,
        }
    }

    /// The same for centres of a ball, whose contacts with the surface are then measured. `None`, and a ball of radius 0, leave
    /// points as they are. Call it before the first point.
    #[must_use]
    pub fn with_tip(self, tip: Option<Tip>) -> Pipeline {
        let centres = tip.and_then(|tip| Centres::new(tip, &self.part, self.along));
        Pipeline { centres, ..self }
    }

    /// The same, told that no more than so many points will come.
    #[must_use]
    pub fn expecting(self, expected_points: Option<u64>) -> Pipeline {
        Pipeline { expected_points, ..self }
    }

    /// The same where [`Pipeline::know_systematic`] will be called at the end: with a guard band no limit is certain before.
    #[must_use]
    pub fn awaiting_systematic(self, awaits_systematic: bool) -> Pipeline {
        Pipeline { awaits_systematic, ..self }
    }

    /// Takes a point of a station. `forbidden_by` names the flags that forbid its use: such a point is counted under each
    /// of them and no more.
    pub fn take(
        &mut self,
        point: impl Into<Point>,
        forbidden_by: impl IntoIterator<Item = &'static str>,
    ) {
        self.received += 1;
        let mut is_good = true;
        for name in forbidden_by {
            is_good = false;
            *self.flagged.entry(name).or_default() += 1;
        }
        if is_good {
            self.accept(point.into());
        }
    }

    /// Takes a point of a file.
    pub fn take_position(&mut self, point: impl Into<Point>) {
        self.take_positions([point]);
    }

    /// Takes points of a file. The mesh gets many at a time, which two threads can share. Where the nominal asks for weights
    /// by uncertainty, every point needs one.
    pub fn take_positions(&mut self, points: impl IntoIterator<Item = impl Into<Point>>) {
        let (mesh, running, heights) = (&mut self.mesh, &mut self.running, &mut self.heights);
        let mut accepted = Vec::new();
        for point in points {
            let point = point.into();
            self.received += 1;
            if !point.at_mm.iter().all(|coordinate| coordinate.is_finite()) {
                *self.flagged.entry("not_finite").or_default() += 1;
                continue;
            }
            let Some(point) = over_plane(&mut self.centres, &mut self.space, point) else {
                continue;
            };
            self.projector.take(point, |point, plane| {
                accepted.push(point.at_mm);
                know(running, heights.as_mut(), point, plane);
            });
            if accepted.len() >= AT_A_TIME {
                mesh.extend(accepted.drain(..));
            }
        }
        mesh.extend(accepted);
    }

    /// Says which slopes dz/dx the heights of a profile along x are integrated from, by x in mm.
    pub fn know_slopes(&mut self, of: impl IntoIterator<Item = (f64, f64)>) {
        self.slopes.extend(of);
    }

    /// Says which errors all points have together, beside those said before. They count in the uncertainties of the final figures;
    /// running figures do not know them.
    pub fn know_systematic(&mut self, errors: impl IntoIterator<Item = Systematic>) {
        self.systematic.extend(errors);
    }

    /// Counts `gaps` places of a file without a value.
    pub fn take_gaps(&mut self, gaps: u64) {
        if gaps > 0 {
            self.received += gaps;
            *self.flagged.entry("missing").or_default() += gaps;
        }
    }

    /// Points received so far, good or not.
    pub fn received(&self) -> u64 {
        self.received
    }

    /// The figures now. The cost depends on the cells of the map and on what changed in the mesh, not on the
    /// points; what needs a look at the whole mesh is looked at only when they have grown by a quarter, once when
    /// nearly all that are expected have arrived, and when so much is covered that a pass may be certain.
    pub fn figures(&mut self) -> RunningFigures {
        self.figures_now(true)
    }

    /// The same without a look at the whole mesh, even where one is due; a later call of [`Pipeline::figures`] takes it. Points that
    /// are meshed in space are looked at nevertheless.
    pub fn figures_without_evaluation(&mut self) -> RunningFigures {
        self.figures_now(false)
    }

    /// How often the whole mesh was looked at.
    pub fn evaluations(&self) -> u64 {
        self.looks
    }

    /// Whether a look at the whole mesh is due; never where points may be meshed in space.
    pub fn awaits_evaluation(&self) -> bool {
        self.space.is_none() && self.mesh.counts().vertices >= self.next_sampling
    }

    fn figures_now(&mut self, evaluates: bool) -> RunningFigures {
        if self.space.as_ref().is_some_and(|space| !space.is_beside_plane()) {
            return self.figures_in_space();
        }
        let counts = self.mesh.counts();
        let plane = self.projector.plane();
        let is_due = counts.vertices >= self.next_sampling;
        if !is_due || !evaluates {
            self.current.keep_up(&self.mesh, &self.part, &self.remembered);
        }
        let may_tell_more = evaluates && self.may_tell_more(counts.pushed);
        if is_due && evaluates || may_tell_more {
            self.look(may_tell_more);
        }
        if self.space.is_some() && self.folded.is_some() {
            return self.figures_in_space();
        }
        let estimate = self.running.estimate();
        if let Some(estimate) = &estimate {
            self.history.note(estimate, &self.errors);
        }
        let outlook = estimate.as_ref().and_then(|estimate| self.outlook(estimate));
        let mut points = self.points();
        points.used = estimate.as_ref().map_or(0, |estimate| estimate.count as u64);
        RunningFigures {
            points,
            mesh: MeshFigures {
                projection: self.projector.figures(),
                area_mm2: self
                    .seen
                    .area_mm2
                    .map(|seen| self.current.whole_area_mm2().unwrap_or(seen)),
                // Looking at the whole mesh anew would cost every triangle.
                ..assessment::with_counts(&self.mesh, self.seen.clone())
            },
            sampling: SamplingFigures { current: self.current.figures(), ..self.sampling.clone() },
            form: estimate.as_ref().map(|estimate| {
                let made = self.running.reference();
                let mut form = figures::running_form(
                    &self.part,
                    estimate,
                    made.as_ref(),
                    &plane,
                    &self.errors,
                );
                let of_tip = self.centres.as_ref().map(|_| tip::PROVISIONAL);
                let caution = |text: &str| fit_details::mild("provisional", text.to_owned());
                form.fit.details.cautions.extend(of_tip.map(caution));
                form
            }),
            map: estimate.as_ref().map(figures::map),
            cells: estimate.map(|estimate| Cells {
                aperture: self.part.aperture.clone(),
                origin_mm: cells::origin_mm(&estimate.map, &self.part),
                used: estimate.count as u64,
                map: estimate.map,
            }),
            maps: self.maps.clone(),
            convergence: self.history.convergence(),
            outlook,
            pending: counts.pending + self.projector.waiting(),
        }
    }

    /// Looks at the whole mesh.
    fn look(&mut self, may_tell_more: bool) {
        let (counts, plane) = (self.mesh.counts(), self.projector.plane());
        self.next_sampling = next_look(counts.vertices, self.expected_points);
        let estimate = self.running.estimate();
        let pose = estimate.as_ref().map_or_else(
            || origin::start_of(&self.part, self.mesh.points()),
            |estimate| estimate.pose,
        );
        let look = assessment::assess(&self.mesh, &self.part, &pose, &plane, &mut self.remembered);
        self.looks += 1;
        self.maps = self.running.grid().and_then(|grid| {
            let lfs_mm = self.remembered.lfs_mm(&pose);
            let raster = maps::Raster { grid: &grid, version: self.looks };
            maps::maps(&self.mesh, &look, &self.part, &pose, raster, lfs_mm).ok().map(Arc::new)
        });
        self.current.begin(&self.mesh, &self.part, &pose, &look.sampling, &self.remembered);
        let noise_nm = look.sampling.noise_in_rms_nm();
        self.errors.look(&self.part, self.mesh.points(), &plane, noise_nm);
        let expected = self.expected().unwrap_or(0);
        let nearly_all = counts.vertices >= expected - expected / LAST_SHARE;
        let foresees = may_tell_more || nearly_all || counts.vertices >= self.next_foresight;
        if let Some(estimate) = estimate.as_ref().filter(|_| foresees) {
            // Of many points to come a few more tell little.
            self.next_foresight = counts.vertices + expected / FORESIGHT_SHARE;
            let arrived = counts.pushed - counts.pending;
            self.prospects.see(&prospects::Evidence {
                part: &self.part,
                points: self.mesh.points(),
                estimate,
                sampling: &look.sampling,
                zones: &look.zones,
                errors: &self.errors,
                to_come: self.expected().map(|expected| expected.saturating_sub(arrived)),
            });
        }
        (self.sampling, self.seen, self.next) = (look.sampling, look.mesh, look.next);
        self.folded = look.folded;
    }

    /// The figures now of points that are meshed in space: as of the last number of points at which these are looked at.
    fn figures_in_space(&mut self) -> RunningFigures {
        let expected = self.expected();
        let mut points = self.points();
        let part = &self.part;
        let folded = self.folded.as_deref();
        let found = self.space.as_mut().map(|space| space.running(part, expected, folded));
        let found = found.unwrap_or_default();
        for of_plane in space::OF_PLANE {
            points.flagged.remove(of_plane);
        }
        let space::RunningInSpace { mesh, sampling, form, map, convergence, .. } = found;
        let (used, duplicates, pending) = (found.used, found.duplicates, found.pending);
        RunningFigures {
            points: Points { used, duplicates, ..points },
            mesh,
            sampling,
            form,
            map,
            cells: None,
            maps: None,
            convergence,
            outlook: None,
            pending,
        }
    }

    /// The same with a look at the whole mesh, of every point that was taken: for a decision that depends on it.
    pub fn figures_of_all(&mut self) -> RunningFigures {
        self.mesh.flush();
        self.next_sampling = 0;
        self.figures()
    }

    /// Whether so much may have been covered since the last look that another calls a pass certain, if every point covers as much as
    /// those before. Not before points have grown by a sixty-fourth, should they cover less.
    fn may_tell_more(&self, pushed: u64) -> bool {
        let then = self.sampling.as_of_points;
        let coverage = self.sampling.coverage.filter(|_| then > 0);
        pushed >= then + then / 64
            && coverage.is_some_and(|coverage| {
                self.prospects.awaits((coverage * pushed as f64 / then as f64).min(1.0))
            })
    }

    /// Points there will be, at most.
    pub(crate) fn expected(&self) -> Option<u64> {
        self.expected_points.map(|expected| expected.max(self.received))
    }

    fn outlook(&mut self, estimate: &LiveEstimate) -> Option<Outlook> {
        let doubt = if self.part.reference.is_some() {
            // It may follow what stands off it now.
            Some("the reference is made anew from all points at the end")
        } else if self.centres.is_some() {
            Some(tip::FOUND_ANEW)
        } else if self.awaits_systematic && self.part.judging.guard.is_some() {
            Some("systematic errors of the station count at the end")
        } else if !self.mesh.projectable() {
            Some("points stand above or below others")
        } else if self.mesh.counts().duplicates > 0 {
            // They count once in the end, and as often as they were measured until then.
            Some("places were measured more than once")
        } else {
            (!self.seen.relief.folds.is_empty()).then_some("the surface is folded")
        };
        self.prospects.look(&Now {
            part: &self.part,
            estimate,
            extremes: &|| self.running.extremes(),
            errors: self.errors.of(&estimate.figures),
            coverage: self.sampling.coverage,
            expected_points: self.expected(),
            doubt,
        })
    }

    /// The final figures, from all points.
    pub fn finish(self) -> Measurement {
        self.finish_by_steps(&mut |_| {})
    }

    /// The final figures, from all points; `begin` hears of each step. The figures do not depend on that.
    pub fn finish_by_steps(mut self, begin: &mut dyn FnMut(Step)) -> Measurement {
        if let Some(centres) = self.centres.take() {
            return self.finish_contacts(centres, begin);
        }
        let systematic = std::mem::take(&mut self.systematic);
        let mut measurement = self.measure(systematic.clone(), begin);
        if let Some(form) = measurement.report.form.as_mut().filter(|_| !systematic.is_empty())
            && form.deviation.systematic.is_empty()
        {
            form.deviation.systematic = Contributions::none(&systematic, IN_SPACE).figures();
        }
        measurement
    }

    /// The final figures with these systematic errors.
    fn measure(mut self, systematic: Vec<Systematic>, begin: &mut dyn FnMut(Step)) -> Measurement {
        begin(Step::Mesh);
        if let Some(space) = self.space.take_if(|space| !space.is_beside_plane()) {
            return space::measure(space, self.points(), self.part, None, begin);
        }
        let (mesh, running, heights) = (&mut self.mesh, &mut self.running, &mut self.heights);
        self.projector.finish(|point, plane| {
            mesh.push(point.at_mm);
            know(running, heights.as_mut(), point, plane);
        });
        self.mesh.flush();
        let points = self.points();
        let (grid, version) = (self.running.grid(), self.looks + 1);
        let grids = Grids { grid, version };
        let Pipeline { mesh, part, projector, heights, slopes, remembered, space, .. } = self;
        let heights_mm = heights.and_then(|heights| heights.of_vertices(&mesh));
        if let Some(line) = profile::Line::through(mesh.points()) {
            let taken =
                profile::Taken { mesh, line, points, heights_mm, slopes, remembered, systematic };
            return profile::measure(taken, part, &projector);
        }
        let gathered = Gathered { mesh, points, heights_mm, grids, remembered, space, systematic };
        measurement::measure(gathered, part, &projector, begin)
    }

    /// The final figures of the contacts of a ball tip: those of a measurement of the contacts themselves.
    fn finish_contacts(mut self, centres: Centres, begin: &mut dyn FnMut(Step)) -> Measurement {
        self.projector.finish(|_, _| {});
        let solved = centres.solve(&self.part, &self.projector.plane());
        let Pipeline {
            part, along, expected_points, received, mut flagged, looks, systematic, ..
        } = self;
        let mut again = Pipeline::along(part, along).expecting(expected_points);
        again.take_positions(solved.contacts.iter().copied());
        again.know_systematic(solved.systematic().into_iter().chain(systematic));
        for (reason, count) in &solved.untouched {
            *flagged.entry(*reason).or_default() += count;
        }
        (again.received, again.flagged, again.looks) = (received, flagged, looks);
        let mut measurement = again.finish_by_steps(begin);
        tip::conclude(&solved, &mut measurement);
        measurement
    }

    /// The mesh so far, as vertices in the measured frame and triangles; points still waiting for their
    /// batch, or for the plane of projection, are not in it.
    pub fn mesh(&self) -> (Cow<'_, [PointMm]>, Vec<[u32; 3]>) {
        if let Some(space) = self.meshed_in_space() {
            return space.mesh();
        }
        (projection::measured(&self.mesh, &self.projector.plane()), self.mesh.triangles())
    }

    /// A section of the mesh so far, with the deviation from the running fit, if there is one; `None` without
    /// a vertex. Takes time in proportion to the triangles met, and to the cells of the map.
    ///
    /// # Errors
    ///
    /// When the path makes no sense.
    pub fn section(&self, request: &SectionRequest) -> Cut {
        if let Some(space) = self.meshed_in_space() {
            return space.section(request);
        }
        if self.mesh.points().is_empty() {
            return None;
        }
        let estimate = self.running.estimate();
        let lies = estimate.as_ref().map(|estimate| (&estimate.nominal, &estimate.pose));
        let gap_limit_mm = self.sampling.gap_limit_mm.or(self.part.gap_limit_mm);
        let plane = self.projector.plane();
        Some(cutting::cut(&self.mesh, (&self.part, &plane), lies, gap_limit_mm, request))
    }

    /// The points, where they are meshed in space by now.
    fn meshed_in_space(&self) -> Option<&InSpace> {
        self.space.as_ref().filter(|space| !space.is_beside_plane() || self.folded.is_some())
    }

    /// Next measurements, as of the last time the sampling was looked at; `None` before the first.
    pub fn next(&self) -> Option<&Next> {
        self.next.as_ref()
    }

    fn accept(&mut self, point: Point) {
        let Some(point) = over_plane(&mut self.centres, &mut self.space, point) else { return };
        let (mesh, running, heights) = (&mut self.mesh, &mut self.running, &mut self.heights);
        self.projector.take(point, |point, plane| {
            mesh.push(point.at_mm);
            know(running, heights.as_mut(), point, plane);
        });
    }

    fn points(&self) -> Points {
        let counts = self.mesh.counts();
        let mut flagged: BTreeMap<String, u64> =
            self.flagged.iter().map(|(name, count)| ((*name).to_owned(), *count)).collect();
        for (reason, count) in [("conflict", counts.conflicts), ("not_meshable", counts.rejected)] {
            if count > 0 {
                *flagged.entry(reason.to_owned()).or_default() += count;
            }
        }
        Points {
            received: self.received,
            used: 0,
            flagged,
            duplicates: counts.duplicates,
            lost: 0,
            missing: 0,
            tip: None,
        }
    }
}

/// The point as its surface has it, for the mesh over the plane; `None` where it is meshed in space alone.
fn over_plane(
    centres: &mut Option<Centres>,
    space: &mut Option<InSpace>,
    point: Point,
) -> Option<Point> {
    let point = match centres {
        Some(centres) => centres.take(point),
        None => point,
    };
    if let Some(space) = space {
        space.push(point.at_mm);
        return space.is_beside_plane().then_some(point);
    }
    Some(point)
}

/// Takes a point in the frame of the plane of projection into the running figures, with its uncertainty where that counts.
fn know(running: &mut Running, heights: Option<&mut Heights>, point: Point, plane: &Plane) {
    let height = heights.and_then(|heights| {
        heights.push(point.u_z_mm);
        Some(Height { u_mm: point.u_z_mm?, up: up(plane) })
    });
    running.push(point.at_mm, height);
}

/// How many points there are at the next look at the whole mesh: a quarter more, but once when all but a few of those
/// that are expected have arrived.
pub(crate) fn next_look(points: u64, expected: Option<u64>) -> u64 {
    let next = points + points / 4;
    let nearly_all = expected.map(|expected| expected - expected / LAST_SHARE);
    nearly_all.filter(|nearly_all| *nearly_all > points).map_or(next, |all| next.min(all))
}

/// Why figures count no systematic errors.
const IN_SPACE: &str =
    "worked out of points that are projected only, and these are meshed in space";

/// Points of a file are handed to the mesh by so many, a multiple of what it gathers by itself.
const AT_A_TIME: usize = 64 * BATCH_POINTS;

/// All but one in so many points are nearly all.
const LAST_SHARE: u64 = 64;

/// Limits are foreseen anew when one in so many of the points expected has arrived, or later.
const FORESIGHT_SHARE: u64 = 32;

/// Below this many vertices the sampling says little.
const FIRST_SAMPLING: u64 = 2000;

#[cfg(test)]
mod tests;
