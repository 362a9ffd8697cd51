//! Parts measured with the nominal that they were found to be; the fit confirms that, or does not.

use std::path::Path;

use asphera_formats::{Cloud, Format};
use asphera_geometry::PointMm;
use asphera_geometry::vector::{dot, length, minus};
use asphera_graph::library::{Candidate, Recognition};
use asphera_measure::{Along, Measurement, Part};
use asphera_report::FormFigures;

use super::super::files::measured;
use super::super::output::Failure;
use super::super::progress::Progress;
use super::super::source::Source;
use super::super::summary::short;
use super::figures::PartForm;
use super::library::Library;
use super::scene::ScenePart;

/// The points of a scene as they were read.
pub(super) struct Read<'a> {
    pub(super) path: &'a Path,
    /// In mm, in the order of the file.
    pub(super) points: &'a [PointMm],
    /// The standard uncertainties of their heights in mm; empty where the file has none.
    pub(super) u_mm: &'a [f64],
    pub(super) format: Format,
    pub(super) progress: &'a Progress,
}

/// A part that was measured.
pub(super) struct FormOfPart {
    pub(super) measurement: Measurement,
    /// Its figures; `None` where the nominal could not be laid into the points.
    pub(super) form: Option<PartForm>,
    /// Why the fit does not confirm the match, if so.
    pub(super) reason: Option<String>,
}

impl Read<'_> {
    /// Measures a part with the nominal of its nearest entry; `None` where that has none.
    ///
    /// A second nominal that fits by size and outline is measured as well: the nearer one must fit better.
    pub(super) fn form(
        &self,
        part: &ScenePart,
        library: &Library,
    ) -> Result<Option<FormOfPart>, Failure> {
        let Some(found) = &part.recognition else { return Ok(None) };
        let candidate = |at: usize| -> Option<(&Candidate, &Part)> {
            let candidate = found.candidates.get(at)?;
            Some((candidate, library.nominals[candidate.entry].as_ref()?))
        };
        let Some((first, nominal)) = candidate(0) else { return Ok(None) };
        let measurement = self.measured(part, first, nominal)?;
        let figures = measurement.report.form.as_ref();
        let mut reason = doubt(part, found, figures, measurement.report.points.used);
        let fits = |second: &Candidate| second.difference_mm <= found.limit_mm;
        let second = candidate(1).filter(|(second, _)| fits(second));
        if let (None, Some(figures), Some((second, other))) = (&reason, figures, second) {
            let other = self.measured(part, second, other)?;
            let rms_nm = other.report.form.map(|form| form.deviation.rms_nm);
            if let Some(rms_nm) = rms_nm.filter(|rms_nm| *rms_nm <= figures.deviation.rms_nm) {
                reason = Some(format!(
                    "the fit of {} leaves {} nm RMS, that of {} {} nm",
                    library.name(second.entry),
                    short(rms_nm),
                    library.name(first.entry),
                    short(figures.deviation.rms_nm)
                ));
            }
        }
        let form = figures.map(|figures| form_of(first, figures, &measurement));
        Ok(Some(FormOfPart { measurement, form, reason }))
    }

    /// The measurement of a part in the frame of a nominal, which begins where the part was found to lie.
    fn measured(
        &self,
        part: &ScenePart,
        candidate: &Candidate,
        nominal: &Part,
    ) -> Result<Measurement, Failure> {
        let cloud = Cloud {
            points_mm: part
                .rows
                .iter()
                .map(|&row| candidate.pose.to_entry(self.points[row]))
                .collect(),
            uncertainties_mm: part
                .rows
                .iter()
                .filter_map(|&row| self.u_mm.get(row).copied())
                .collect(),
            ..Cloud::default()
        };
        let source = Source::of_cloud(self.path, cloud, self.format);
        measured(nominal.clone(), Along::Z, &source, self.progress)
    }
}

/// Why a fit does not confirm a match, if so.
fn doubt(
    part: &ScenePart,
    found: &Recognition,
    form: Option<&FormFigures>,
    used: u64,
) -> Option<String> {
    let Some(form) = form else {
        return Some("its nominal cannot be laid into the points".to_owned());
    };
    if form.fit.details.converged == Some(false) {
        return Some(format!("the fit of its nominal did not converge: {}", form.fit.termination));
    }
    let origin_mm = form.fit.pose.to_measured([0.0; 3]);
    let upwards = minus(form.fit.pose.to_measured([0.0, 0.0, 1.0]), origin_mm);
    if upwards[2] <= 0.0 {
        return Some("the fit turns the nominal over".to_owned());
    }
    let [low, high] = part.figures.box_mm;
    let (moved_mm, size_mm) = (length(origin_mm), length(minus(high, low)));
    if moved_mm > FARTHEST * size_mm {
        return Some(format!("the fit moves the nominal by {} mm", short(moved_mm)));
    }
    if (used as f64) < LEAST_USED * part.rows.len() as f64 {
        return Some(format!("the fit used {used} of its {} points alone", part.rows.len()));
    }
    let rms_mm = form.deviation.rms_nm * 1e-6;
    (rms_mm > found.limit_mm).then(|| {
        format!(
            "the fit leaves {} mm RMS, where up to {} mm fits",
            short(rms_mm),
            short(found.limit_mm)
        )
    })
}

/// The figures of a part in short, with its place in the scene.
fn form_of(candidate: &Candidate, form: &FormFigures, measurement: &Measurement) -> PartForm {
    let in_scene = |place_mm: PointMm| candidate.pose.to_scene(form.fit.pose.to_measured(place_mm));
    let place_mm = in_scene([0.0; 3]);
    let axis = minus(in_scene([0.0, 0.0, 1.0]), place_mm);
    let aside = dot([axis[0], axis[1], 0.0], axis).sqrt();
    let deviation = &form.deviation;
    let uncertainty = deviation.uncertainty.as_ref();
    PartForm {
        pv_nm: deviation.pv_nm,
        u_pv_nm: uncertainty.map(|found| found.u_pv_nm),
        rms_nm: deviation.rms_nm,
        u_rms_nm: uncertainty.map(|found| found.u_rms_nm),
        rms_without_noise_nm: uncertainty.map(|found| found.rms_without_noise_nm),
        used: measurement.report.points.used,
        place_mm,
        tilt_deg: aside.atan2(axis[2].abs()).to_degrees(),
        verdict: measurement.report.verdict.clone(),
    }
}

/// A fit that moves a nominal farther, as a share of the diagonal of the part's box, found something else.
const FARTHEST: f64 = 0.25;

/// The least share of the points of a part that its fit uses.
const LEAST_USED: f64 = 0.5;
