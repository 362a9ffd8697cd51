//! The compensation in a report: its figures, and the cautions of the verdict.

use asphera_figures::texture::{Mesh, hybrid_parameters};
use asphera_form::NM_PER_MM;
use asphera_geometry::PointMm;
use asphera_report::{TipFigures, Verdict};

use super::solve::{Found, Solved, TOO_HOLLOW};
use crate::judgement::{doubt, undecide};
use crate::measurement::Measurement;
use crate::systematic::BALL;

/// Adds to the figures of the contacts what is known of their compensation.
pub(crate) fn conclude(solved: &Solved, measurement: &mut Measurement) {
    let mut figures = figures(solved);
    if solved.found.is_ok() {
        let profile = measurement.report.profile.as_ref();
        let slope = profile.and_then(|profile| profile.slope_rms_urad).map(|urad| urad * 1e-6);
        let slope = slope.or_else(|| slope_rms(measurement));
        figures.neglected_nm =
            slope.map(|slope| 0.5 * figures.radius_mm * slope * slope * NM_PER_MM);
    }
    let form = measurement.report.form.as_ref();
    let of_radius = form.and_then(|form| {
        form.deviation.systematic.iter().find(|systematic| systematic.source == BALL)
    });
    figures.u_pv_nm = of_radius.and_then(|found| found.u_pv_nm);
    figures.u_rms_nm = of_radius.and_then(|found| found.u_rms_nm);
    judge(solved, &figures, &mut measurement.report.verdict);
    measurement.report.points.tip = Some(Box::new(figures));
}

fn figures(solved: &Solved) -> TipFigures {
    let tip = &solved.tip;
    let of_settings = TipFigures {
        radius_mm: tip.radius_mm,
        u_radius_mm: tip.u_radius_mm,
        reads: tip.reads.word().to_owned(),
        ..TipFigures::default()
    };
    let Found { contacts, steepest, most_hollow } = match &solved.found {
        Ok(found) => *found,
        Err(why) => return TipFigures { uncompensated: Some(why.to_string()), ..of_settings },
    };
    let of_settings = TipFigures { contacts: Some(contacts), passes: solved.passes, ..of_settings };
    if contacts == 0 {
        return of_settings;
    }
    let (cosine, steepest_at_mm) = steepest;
    let sine = (1.0 - cosine * cosine).max(0.0).sqrt();
    let radius_nm = tip.radius_mm * NM_PER_MM;
    let (hollow_per_mm, hollow_at_mm) = most_hollow;
    let is_hollow = hollow_per_mm > 0.0;
    let share = tip.radius_mm * hollow_per_mm;
    TipFigures {
        last_move_nm: solved.last_move_mm * NM_PER_MM,
        steepest_deg: sine.atan2(cosine).to_degrees(),
        // As sin²/(cos·(1 + cos)): near the crest the difference would be rounding.
        largest_height_nm: radius_nm * sine * sine / (cosine * (1.0 + cosine)),
        largest_shift_nm: radius_nm * sine,
        steepest_at_mm,
        hollow_share: (is_hollow && share.is_finite()).then_some(share),
        hollow_at_mm: is_hollow.then_some(hollow_at_mm),
        ..of_settings
    }
}

/// RMS slope of the deviation over the area of the triangles, rad.
fn slope_rms(measurement: &Measurement) -> Option<f64> {
    let Measurement { points_mm, triangles, deviations_nm, .. } = measurement;
    let heights = points_mm.iter().zip(deviations_nm);
    let heights: Vec<PointMm> = heights.map(|(&[x, y, _], nm)| [x, y, nm / NM_PER_MM]).collect();
    let mesh = Mesh::new(&heights, triangles).ok()?;
    let slopes = hybrid_parameters((&mesh).into()).ok()?;
    Some(1e-6 * slopes.sdq_urad)
}

/// Says what the compensation leaves open.
fn judge(solved: &Solved, figures: &TipFigures, verdict: &mut Verdict) {
    if let Some(why) = &figures.uncompensated {
        let why = format!("points are the lowest points of the ball tip, not its contacts: {why}");
        return doubt(verdict, why);
    }
    if figures.contacts == Some(0) {
        return doubt(
            verdict,
            "no centre of the ball tip has a contact with the nominal".to_owned(),
        );
    }
    if let (Some(count), Some([x, y, z])) = (solved.untouched.get(TOO_HOLLOW), figures.hollow_at_mm)
    {
        let why = format!(
            "the ball tip of {} mm does not fit at {count} points, first with its centre at x {x:.3}, y {y:.3}, z {z:.3} mm: \
             measure there with a smaller ball",
            figures.radius_mm
        );
        undecide(verdict, why);
    }
    if figures.last_move_nm > SETTLED_NM {
        let why = format!(
            "contacts of the ball tip still moved by {:.3} nm after {} fits",
            figures.last_move_nm, figures.passes
        );
        undecide(verdict, why);
    }
    if let Some(nm) = figures.neglected_nm.filter(|nm| *nm > NEGLIGIBLE_NM) {
        verdict.reasons.push(format!(
            "contacts of the ball tip take the normals of the nominal, which leaves an error of about {nm:.3} nm: use a smaller ball"
        ));
    }
}

/// Moves of contacts beyond this are worth a word.
const SETTLED_NM: f64 = 1.0;
/// Errors beyond this are worth a word.
const NEGLIGIBLE_NM: f64 = 1.0;
