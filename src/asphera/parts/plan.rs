//! The parts of a session: what a station's configuration asks for, from the points to the verdict.

use asphera_form::Nominal;
use asphera_geometry::PointMm;
use asphera_graph::compare::Size;
use asphera_graph::{Cloud, PlaceId, RunningGraph, RunningPart, RunningSettings};
use asphera_measure::{Along, Measurement, Part, Pipeline, ask, undecide};
use asphera_report::parts::{Answer, PartReport, SessionPart, SessionParts};
use asphera_report::{FeatureFigures, FormFigures, Map, SamplingFigures, Status, Verdict};

use super::{Library, ScenePart, figures_of, form, judged, matched, pieces};

/// Parts that a station finds in the points of every session.
#[derive(Clone, Debug)]
pub struct PartsPlan {
    /// Axis, τ and strips.
    pub(crate) settings: RunningSettings,
    /// Pieces of fewer points are islands.
    pub(crate) min_points: u64,
    /// What parts may be.
    pub(crate) library: Option<Library>,
    /// The largest difference of a part from an entry that fits, RMS in mm; `None` leaves it to the points.
    pub(crate) within_mm: Option<f64>,
    /// Whether each part is measured by itself, and all points together have no form: their nominal is a plane without limits.
    pub(crate) has_no_whole: bool,
}

/// What became of a part that ended.
#[derive(Debug, Default)]
pub(crate) struct Judged {
    pub(crate) parts: Vec<SessionPart>,
    /// Points of an island; `None` of a part.
    pub(crate) island_points: Option<u64>,
    pub(crate) crumbs: u64,
}

/// The sampling of points that are parts alone: gaps and places to measure next would lie between the parts.
pub(crate) fn sampling_without_whole(sampling: &SamplingFigures) -> SamplingFigures {
    SamplingFigures {
        as_of_points: sampling.as_of_points,
        noise_sigma_nm: sampling.noise_sigma_nm,
        noise_u_nm: sampling.noise_u_nm,
        noise_rms_nm: sampling.noise_rms_nm,
        spacing_median_mm: sampling.spacing_median_mm,
        unknown: vec![NO_WHOLE.to_owned()],
        ..SamplingFigures::default()
    }
}

/// Why points of parts have no coverage.
const NO_WHOLE: &str = "coverage and form of the whole: parts lie apart, so each has its own (a limit in [nominal.tolerance] asks for that of the whole)";

/// The heights of all points over a plane, in the frame that parts are placed in.
pub(crate) fn heights_of_parts(map: Option<Map>, form: Option<&FormFigures>) -> Option<Map> {
    map.zip(form).map(|(map, form)| map.placed(&form.fit.pose))
}

/// Takes the form of all points together out of a measurement, and what was decided by it.
fn leave_out_whole(measurement: &mut Measurement) {
    let report = &mut measurement.report;
    let form = report.form.take();
    measurement.cells = heights_of_parts(measurement.cells.take(), form.as_ref());
    report.profile = None;
    report.features = FeatureFigures::default();
    report.sampling = sampling_without_whole(&report.sampling);
    report.verdict = Verdict { status: Status::None, ..Verdict::default() };
    measurement.deviations_nm.fill(f64::NAN);
    measurement.map = None;
    measurement.next = None;
}

impl PartsPlan {
    /// Says whether the nominal of all points is a design, or a plane that nothing is held against.
    pub(crate) fn with_whole(self, whole: &Part) -> PartsPlan {
        let is_stand_in = whole.nominal == Nominal::Plane && !whole.has_limits();
        PartsPlan { has_no_whole: is_stand_in && self.library.is_some(), ..self }
    }

    /// The graph of a session without points.
    pub(crate) fn graph(&self) -> RunningGraph {
        // The configuration holds what it asks for.
        RunningGraph::new(self.settings).unwrap_or_else(|error| unreachable!("{error}"))
    }

    /// The parts of a session without points.
    pub(crate) fn nothing(&self) -> SessionParts {
        let sign = if self.settings.is_reversed { "-" } else { "" };
        SessionParts {
            as_of_points: 0,
            axis: format!("{sign}{}", ["x", "y", "z"][self.settings.axis.min(2)]),
            tau_mm: self.settings.tau_mm,
            strip_mm: self.settings.strip_mm,
            entries: self.library.as_ref().map(|library| library.entries.len()),
            parts: Vec::new(),
            open: 0,
            waiting: 0,
            islands: 0,
            island_points: 0,
            crumbs: 0,
            late: 0,
            outside: 0,
            events: Vec::new(),
            earlier_events: 0,
        }
    }

    /// Recognises and measures a part that ended. Touching parts are taken apart.
    pub(crate) fn judge(&self, ended: &RunningPart) -> Judged {
        if ended.points < self.min_points {
            return Judged { island_points: Some(ended.points), ..Judged::default() };
        }
        let points: Vec<PointMm> = ended.rows.iter().map(|&(_, at_mm)| at_mm).collect();
        // Points of a running graph are finite and in range.
        let Ok(cloud) = Cloud::new(&points) else {
            return Judged { crumbs: ended.points, ..Judged::default() };
        };
        let limits = (Size::Counts, self.within_mm);
        let all: Vec<PlaceId> = (0..cloud.len() as PlaceId).collect();
        let (found, of_places) = pieces(&cloud, &all, self.library.as_ref(), limits);
        let mut piece_of_place: Vec<Option<usize>> = vec![None; cloud.len()];
        for (place, piece) in of_places {
            piece_of_place[place as usize] = Some(piece);
        }
        let mut rows: Vec<Vec<usize>> = vec![Vec::new(); found.len()];
        let mut crumbs = 0;
        for (row, &place) in cloud.places_of_rows().iter().enumerate() {
            match piece_of_place[place as usize] {
                Some(piece) => rows[piece].push(row),
                None => crumbs += 1,
            }
        }
        let mut parts = Vec::new();
        for ((places, recognition), rows) in found.into_iter().zip(rows) {
            // Points that have no extent are no part: they count as left over.
            let Ok(mut figures) = figures_of(&places, self.settings.tau_mm) else {
                crumbs += rows.len() as u64;
                continue;
            };
            figures.points = rows.len() as u64;
            let part = ScenePart { figures, rows, places, recognition };
            let part = self.report(&part, &points);
            parts.push(SessionPart { scanned: ended.id, is_open: ended.is_open, part });
        }
        Judged { parts, island_points: None, crumbs }
    }

    fn report(&self, part: &ScenePart, points: &[PointMm]) -> PartReport {
        let figures = part.figures.clone();
        let Some((library, recognition)) = self.library.as_ref().zip(part.recognition.as_ref())
        else {
            return PartReport { figures, found: None, form: None };
        };
        let found = matched(recognition, library, Size::Counts);
        if found.reason.is_some() {
            return PartReport { figures, found: Some(found), form: None };
        }
        match form(part, (points, &[]), library, &measured) {
            Ok(Some(formed)) => {
                PartReport { figures, found: Some(judged(found, formed.reason)), form: formed.form }
            }
            Ok(None) => PartReport { figures, found: Some(found), form: None },
            Err(error) => match error {},
        }
    }

    /// Puts the parts into a measurement, and their verdicts into its own. To be done before the session is concluded, which may
    /// take a pass back.
    pub(crate) fn conclude(&self, parts: SessionParts, measurement: &mut Measurement) {
        if self.has_no_whole {
            leave_out_whole(measurement);
        }
        let verdict = &mut measurement.report.verdict;
        if self.library.is_some() {
            if parts.parts.is_empty() {
                ask(verdict);
                undecide(verdict, "no part was found in the scan".to_owned());
            }
            for (number, part) in (1..).zip(&parts.parts) {
                judge(number, &part.part, verdict);
            }
        }
        if parts.waiting > 0 {
            ask(verdict);
            undecide(
                verdict,
                format!("{} parts could not be measured: see the log", parts.waiting),
            );
        }
        let lost = parts.late + parts.outside;
        if lost > 0 {
            ask(verdict);
            undecide(
                verdict,
                format!(
                    "{lost} points are in no part: they came when the scan had left their place, or lie too far away. Check [parts] axis"
                ),
            );
        }
        if verdict.status == Status::Pass {
            verdict.reasons.extend(all_pass(&parts));
        }
        measurement.report.parts = Some(parts);
    }
}

/// What a pass says of the parts, where limits are held against any.
fn all_pass(parts: &SessionParts) -> Option<String> {
    let status = |part: &SessionPart| Some(part.part.form.as_ref()?.verdict.status);
    let held = parts.parts.iter().filter(|part| status(part) == Some(Status::Pass)).count() as u64;
    let all = parts.parts.len() as u64;
    match held {
        0 => None,
        1 if all == 1 => Some("the part holds the limits of its nominal".to_owned()),
        _ if held == all => Some(format!("all {all} parts hold the limits of their nominals")),
        _ => Some(format!(
            "{held} of {all} parts hold the limits of their nominals; the others have none"
        )),
    }
}

/// Adds what a part is to the verdict of its session.
fn judge(number: usize, part: &PartReport, verdict: &mut Verdict) {
    let Some(found) = &part.found else { return };
    let Some((name, form)) =
        found.name.as_ref().filter(|_| found.verdict == Answer::Confirmed).zip(part.form.as_ref())
    else {
        let why = found.reason.as_deref().unwrap_or("its entry has no nominal to measure it with");
        ask(verdict);
        return undecide(verdict, format!("part {number} is unknown: {why}"));
    };
    let first = || form.verdict.reasons.first().map_or(String::new(), |why| format!(": {why}"));
    match form.verdict.status {
        Status::None => {}
        Status::Pass => ask(verdict),
        Status::Undecided => {
            ask(verdict);
            undecide(verdict, format!("part {number}, {name}, is undecided{}", first()));
        }
        Status::Fail => {
            ask(verdict);
            verdict.status = Status::Fail;
            let broken = form.verdict.checks.iter().filter(|check| !check.ok);
            let names: Vec<&str> = broken.map(|check| check.figure.symbol.as_str()).collect();
            verdict.reasons.push(format!("part {number}, {name}, fails: {}", names.join(", ")));
        }
    }
}

/// The measurement of a part. A session's points have no uncertainties of their own here.
fn measured(
    nominal: Part,
    points_mm: Vec<PointMm>,
    _: Vec<f64>,
) -> Result<Measurement, std::convert::Infallible> {
    let mut pipeline = Pipeline::along(nominal, Along::Z);
    pipeline.take_positions(points_mm);
    Ok(pipeline.finish())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn plan() -> PartsPlan {
        let settings = RunningSettings {
            axis: 1,
            is_reversed: false,
            tau_mm: 1.0,
            strip_mm: 2.0,
            keeps_points: true,
        };
        let (library, within_mm) = (None, None);
        PartsPlan { settings, min_points: 20, library, within_mm, has_no_whole: false }
    }

    fn verdict_of(parts: SessionParts) -> (Status, Vec<String>) {
        let mut measurement = Pipeline::along(Part::new(Nominal::Plane), Along::Z).finish();
        plan().conclude(parts, &mut measurement);
        let verdict = measurement.report.verdict;
        (verdict.status, verdict.reasons)
    }

    #[test]
    fn what_is_in_no_part_or_not_measured_leaves_the_session_undecided() {
        let nothing = plan().nothing();
        for (parts, why) in [
            (SessionParts { waiting: 2, ..nothing.clone() }, "2 parts could not be measured"),
            (SessionParts { late: 3, outside: 1, ..nothing.clone() }, "4 points are in no part"),
        ] {
            let (status, reasons) = verdict_of(parts);
            assert_eq!(status, Status::Undecided);
            assert!(reasons.iter().any(|reason| reason.contains(why)), "{reasons:?}");
        }
    }

    #[test]
    fn parts_alone_have_no_form_together_and_heights_where_they_lie() {
        let at = |index: u32| {
            let [x, y] = [f64::from(index % 20), f64::from(index / 20)];
            [50.0 + x, 20.0 + y, if x < 10.0 { 0.0 } else { 2.0 }]
        };
        let mut pipeline = Pipeline::along(Part::new(Nominal::Plane), Along::Z);
        pipeline.take_positions((0..400).map(at).collect::<Vec<PointMm>>());
        let mut measurement = pipeline.finish();
        assert!(measurement.report.form.is_some() && measurement.next.is_some());
        PartsPlan { has_no_whole: true, ..plan() }.conclude(plan().nothing(), &mut measurement);
        let report = &measurement.report;
        assert!(report.form.is_none() && measurement.next.is_none() && measurement.map.is_none());
        assert_eq!((report.sampling.coverage, report.sampling.next.len()), (None, 0));
        assert_eq!(report.verdict.status, Status::None);
        let map = measurement.cells.unwrap();
        assert!((map.x0_mm - 50.0).abs() < map.dx_mm + 0.5, "{}", map.x0_mm);
        assert!((map.y0_mm - 20.0).abs() < map.dy_mm + 0.5, "{}", map.y0_mm);
    }

    #[test]
    fn a_plane_without_limits_stands_in_for_a_whole_of_parts() {
        let library = Library::of_texts(
            std::path::Path::new(""),
            &[(
                "a.toml".to_owned(),
                "[surface]\nkind = \"plane\"\n[aperture]\nshape = \"circle\"\nradius_mm = 5\n"
                    .to_owned(),
            )],
        );
        let of = |library: Option<Library>, whole: Nominal| {
            PartsPlan { library, ..plan() }.with_whole(&Part::new(whole)).has_no_whole
        };
        let library = library.unwrap_or_else(|_| panic!("no library"));
        assert!(of(Some(library.clone()), Nominal::Plane) && !of(None, Nominal::Plane));
        assert!(!of(Some(library), Nominal::Sphere { radius_mm: 9.0 }));
    }

    /// Every point of what ended is in a part, in an island or left over.
    #[test]
    fn no_point_of_what_ended_is_dropped() {
        let square = |count: u32| {
            (0..count).map(|at| [f64::from(at % 6) * 0.3, f64::from(at / 6) * 0.3, 0.0])
        };
        let one_place = |count: u32| (0..count).map(|_| [1.0, 2.0, 3.0]);
        let clouds: [Vec<PointMm>; 3] =
            [square(36).collect(), square(12).collect(), one_place(30).collect()];
        for points in clouds {
            let mut graph = plan().graph();
            graph.take(&points).unwrap();
            graph.finish();
            let ended = graph.take_ended();
            assert_eq!(ended.len(), 1);
            let judged = plan().judge(&ended[0]);
            let in_parts: u64 = judged.parts.iter().map(|part| part.part.figures.points).sum();
            let all = in_parts + judged.island_points.unwrap_or(0) + judged.crumbs;
            assert_eq!(all, points.len() as u64, "{judged:?}");
        }
    }
}
