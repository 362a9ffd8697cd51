//! How densely zones of the aperture are sampled, where a limit is for one.

use asphera_form::{Aperture, Pose};
use asphera_surface::coverage::{self, Coverage};

use super::border;
use crate::Part;

/// The sampling of a zone.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct ZoneSampling {
    pub(crate) zone: Aperture,
    /// Share of it that is sampled densely enough, 0 to 1; none where that is not known.
    pub(crate) coverage: Option<f64>,
    /// The largest gap in it, mm.
    pub(crate) gap_max_mm: Option<f64>,
}

/// The zones that have a limit, each once, with where they lie in the plane.
pub(super) fn laid(part: &Part, pose: &Pose) -> Vec<(Aperture, coverage::Aperture)> {
    let mut zones: Vec<(Aperture, coverage::Aperture)> = Vec::new();
    for limit in part.limits() {
        if zones.iter().any(|(zone, _)| *zone == limit.zone) {
            continue;
        }
        let inside = within(&limit.zone, &part.aperture);
        if let Ok(Some(laid)) = border::laid(&inside, &part.nominal, pose) {
            zones.push((limit.zone.clone(), laid));
        }
    }
    zones
}

/// Part of a ring that lies in a round aperture.
fn within(zone: &Aperture, aperture: &Aperture) -> Aperture {
    match (zone, aperture) {
        (&Aperture::Annulus { inner_mm, outer_mm }, &Aperture::Circle { radius_mm }) => {
            Aperture::Annulus { inner_mm, outer_mm: outer_mm.min(radius_mm) }
        }
        (
            &Aperture::Annulus { inner_mm, outer_mm },
            &Aperture::Annulus { inner_mm: hole_mm, outer_mm: rim_mm },
        ) => Aperture::Annulus { inner_mm: inner_mm.max(hole_mm), outer_mm: outer_mm.min(rim_mm) },
        _ => zone.clone(),
    }
}

impl ZoneSampling {
    /// By what was found of it.
    pub(super) fn of(zone: Aperture, found: Option<Coverage>) -> ZoneSampling {
        // As of the whole: of a zone that was not met at all nothing is said.
        let found = found.filter(|found| found.gap_mm.is_some());
        ZoneSampling {
            zone,
            coverage: found.as_ref().and_then(Coverage::coverage),
            gap_max_mm: found.as_ref().and_then(|found| found.gap_mm).map(|gap| gap.max),
        }
    }
}
