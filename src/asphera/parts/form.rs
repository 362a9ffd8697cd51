//! Parts measured with the nominal that they were found to be; the fit confirms that, or does not.

use asphera_geometry::PointMm;
use asphera_geometry::vector::{dot, length, minus};
use asphera_graph::library::{Candidate, Recognition};
use asphera_measure::{Measurement, Part};
use asphera_report::FormFigures;
use asphera_report::parts::PartForm;
use asphera_report::words::short;

use super::Library;
use super::scene::ScenePart;

/// The measurement of points in the frame of a nominal, with the standard uncertainties of their heights, if these are known.
pub(crate) type Measures<'a, E> =
    dyn Fn(Part, Vec<PointMm>, Vec<f64>) -> Result<Measurement, E> + 'a;

/// A part that was measured.
pub(crate) struct FormOfPart {
    pub(crate) measurement: Measurement,
    /// Its figures; `None` where the nominal could not be laid into the points.
    pub(crate) form: Option<PartForm>,
    /// Why the fit does not confirm the match, if so.
    pub(crate) reason: Option<String>,
}

/// Measures a part with the nominal of its nearest entry; `None` where that has none.
///
/// `rows` are the points of the part with their uncertainties; of points without these both lists differ. A second nominal that fits
/// by size and outline is measured as well: the nearer one must fit better.
pub(crate) fn form<E>(
    part: &ScenePart,
    (points, u_mm): (&[PointMm], &[f64]),
    library: &Library,
    measures: &Measures<'_, E>,
) -> Result<Option<FormOfPart>, E> {
    let Some(found) = &part.recognition else { return Ok(None) };
    let candidate = |at: usize| -> Option<(&Candidate, &Part)> {
        let candidate = found.candidates.get(at)?;
        Some((candidate, library.nominals[candidate.entry].as_ref()?))
    };
    // In the frame of the nominal, which begins where the part was found to lie.
    let measured = |candidate: &Candidate, nominal: &Part| {
        let own = part.rows.iter().map(|&row| candidate.pose.to_entry(points[row])).collect();
        let u_mm = part.rows.iter().filter_map(|&row| u_mm.get(row).copied()).collect();
        measures(nominal.clone(), own, u_mm)
    };
    let Some((first, nominal)) = candidate(0) else { return Ok(None) };
    let measurement = measured(first, nominal)?;
    let figures = measurement.report.form.as_ref();
    let mut reason = doubt(part, found, figures, measurement.report.points.used);
    let fits = |second: &Candidate| second.difference_mm <= found.limit_mm;
    let second = candidate(1).filter(|(second, _)| fits(second));
    if let (None, Some(figures), Some((second, other))) = (&reason, figures, second) {
        let rms_nm = measured(second, other)?.report.form.map(|form| form.deviation.rms_nm);
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
