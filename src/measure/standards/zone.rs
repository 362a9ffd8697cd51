//! The minimum zone with its certificate.

use asphera_figures::{Definition, Figure};
use asphera_form::{
    Contact, FitError, FitSettings, Side, ZoneFit, ZoneSettings, ZoneTermination, minimum_zone,
};
use asphera_report::{ContactFigures, FormFigure, MinimumZoneFigures};
use asphera_uncertainty::{Simulated, UncertaintyError};

use super::Measured;
use super::uncertain::{Sure, with};
use crate::naming;
use crate::origin;
use crate::running::fit_settings;
use crate::uncertainties::Assessed;

/// The zone. Some three times the time of the fit.
pub(super) fn found(measured: &Measured<'_>) -> Result<ZoneFit, FitError> {
    let Measured { part, points, .. } = *measured;
    let fit_settings = FitSettings { start: origin::start_of(part, points), ..fit_settings(part) };
    let settings = ZoneSettings { fit: fit_settings, ..ZoneSettings::default() };
    minimum_zone(points, &part.nominal, &settings)
}

/// Its width. A zone that may still be too wide proves no limit broken: then the least it may be, too.
pub(super) fn held(zone: &MinimumZoneFigures) -> (&FormFigure, Option<f64>) {
    (&zone.width, (!zone.settled).then_some(zone.lower_nm))
}

/// Its width by simulated measurements; `None` of a zone without a width.
pub(super) fn simulated(
    found: &ZoneFit,
    assessed: &Assessed,
) -> Result<Option<Simulated>, UncertaintyError> {
    assessed.uncertainty.minimum_zone_nm(found, &assessed.draws)
}

/// The zone as reports write it.
pub(super) fn figures(
    measured: &Measured<'_>,
    found: &ZoneFit,
    sure: Option<Sure>,
) -> MinimumZoneFigures {
    let Measured { fit, points, deviations_mm, .. } = *measured;
    let [low_mm, high_mm] = deviations_mm
        .iter()
        .filter(|deviation| deviation.is_finite())
        .fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], &z| [low.min(z), high.max(z)]);
    let contact = |contact: &Contact| ContactFigures {
        at_mm: fit.pose.to_part(points[contact.index]),
        side: match contact.side {
            Side::High => "high".to_owned(),
            Side::Low => "low".to_owned(),
        },
        share: contact.multiplier,
    };
    let mut contacts: Vec<ContactFigures> = found.contacts.iter().map(contact).collect();
    contacts.sort_by(|a, b| b.share.total_cmp(&a.share));
    let width = Figure { definition: Definition::MinimumZone, value: found.zone_mm * NM_PER_MM };
    MinimumZoneFigures {
        width: with(naming::figure(width, "of all points used".to_owned()), sure.as_ref()),
        method: found.method.to_owned(),
        termination: termination(found),
        settled: found.termination.is_settled(),
        lower_nm: found.certificate.lower_mm * NM_PER_MM,
        gap_nm: found.certificate.gap_mm * NM_PER_MM,
        offset_nm: found.offset_mm * NM_PER_MM,
        points: found.used as u64,
        passes: found.certificate.scans as u64,
        least_squares_pv_nm: (high_mm - low_mm) * NM_PER_MM,
        contacts,
    }
}

fn termination(found: &ZoneFit) -> String {
    match found.termination {
        ZoneTermination::Settled { .. } => "settled".to_owned(),
        ZoneTermination::NoDescent { gap_mm } => {
            format!("no step made it narrower, {:.1e} nm may be left", gap_mm * NM_PER_MM)
        }
        ZoneTermination::MaxScans { limit, gap_mm } => {
            format!("stopped after {limit} passes, {:.1e} nm may be left", gap_mm * NM_PER_MM)
        }
    }
}

const NM_PER_MM: f64 = 1e6;
