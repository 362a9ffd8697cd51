//! The minimum zone with its certificate.

use asphera_figures::{Definition, Figure};
use asphera_form::{
    Contact, FitSettings, NM_PER_MM, Side, ZoneFit, ZoneSettings, ZoneTermination, minimum_zone,
};
use asphera_report::error_chain;
use asphera_report::standards::{ContactFigures, MinimumZoneFigures};
use asphera_uncertainty::Simulated;

use super::Measured;
use crate::details::FormDetails;
use crate::naming;
use crate::origin;
use crate::running::fit_settings;

/// Adds the zone. Some three times the time of the fit.
pub(super) fn add(measured: &Measured<'_>, details: &mut FormDetails) {
    let Measured { part, points, .. } = *measured;
    if !part.asks_for(Definition::MinimumZone) {
        return;
    }
    let fit_settings = FitSettings { start: origin::start_of(part, points), ..fit_settings(part) };
    let settings = ZoneSettings { fit: fit_settings, ..ZoneSettings::default() };
    let found = minimum_zone(points, &part.nominal, &settings).map_err(|why| error_chain(&why));
    let Some(found) = details.known("minimum zone", found) else { return };
    let simulated = details.simulated(measured, "minimum zone", |of| {
        of.uncertainty.minimum_zone_nm(&found, &of.draws)
    });
    let zone = figures(measured, &found, simulated.flatten().as_ref());
    // A zone that may still be too wide proves no limit broken.
    let least = (!zone.settled).then_some(zone.lower_nm);
    details.add_limited(Definition::MinimumZone, &zone.width, least);
    details.standards.minimum_zone = Some(zone);
}

/// The zone as reports write it.
pub(super) fn figures(
    measured: &Measured<'_>,
    found: &ZoneFit,
    simulated: Option<&Simulated>,
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
        width: measured.with_uncertainty(
            width.definition,
            naming::figure(width, "of all points used".to_owned()),
            simulated,
        ),
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
