//! The form of a profile, and what systematic errors add to its uncertainties.

use asphera_figures::Sample;
use asphera_form::Figures;
use asphera_geometry::PointMm;
use asphera_report::{FormFigures, ProfileFigures};
use asphera_surface::Plane;

use super::{details, sources};
use crate::Part;
use crate::details::places_mm;
use crate::figures::{self, Ingredients};
use crate::fitting::{Fitted, NoFit};
use crate::judged::{AllJudged, Sure, of_narrow_limits};
use crate::systematic::{Contributions, Moving, Systematic};
use crate::uncertainties::{self, Assessed};
use crate::unmeasured::Unmeasured;

/// Ingredients of the form of a profile.
pub(super) struct Formed<'a> {
    /// The part, with the freedoms that a line feels, and with the limits of the deviation.
    pub(super) parts: [&'a Part; 3],
    pub(super) points: &'a [PointMm],
    pub(super) deviations_mm: &'a [f64],
    pub(super) by_budget: Option<&'a Assessed>,
    pub(super) systematic: &'a Contributions,
    pub(super) limits: &'a AllJudged<'a>,
    pub(super) profile: &'a ProfileFigures,
}

impl Formed<'_> {
    pub(super) fn form(
        &self,
        fitted: &Fitted,
        found: &Figures,
        unmeasured: &Unmeasured,
        plane: &Plane,
    ) -> FormFigures {
        let Formed { parts, points, deviations_mm, by_budget, systematic, limits, profile } = *self;
        let [part, own, judged] = parts;
        let places_mm = places_mm(&fitted.fit.pose, points);
        let sample = Sample::new(&places_mm, deviations_mm, None, &part.aperture);
        let uncertainty = by_budget.map(|assessed| {
            let heights = uncertainties::of_heights(assessed, judged);
            systematic.with_heights(heights, found.pv_nm)
        });
        let sure = uncertainty.as_ref().map(|heights| [heights.u_pv_nm, heights.u_rms_nm]);
        let mut details = details(sample.ok().as_ref(), profile, &Sure::new(sure, limits));
        let (sources, lacks) =
            sources(judged, fitted, (points, deviations_mm), by_budget, profile.turned);
        let sources = sources.with_systematic(fitted, systematic);
        let narrow = of_narrow_limits(limits, &details.figures);
        details.figures.extend(narrow);
        details
            .unknown
            .extend(lacks.map(str::to_owned).into_iter().chain(sources.unknown.iter().cloned()));
        let (systematic, unmeasured) = (systematic.figures(), unmeasured.figures());
        let of =
            Ingredients { fitted, found, details, sources, uncertainty, systematic, unmeasured };
        figures::form(own, &part.free, of, plane)
    }
}

/// What systematic errors add to the uncertainties of a profile; of an oblique one nothing is known. `own` has the freedoms that
/// a line feels, `judged` the limits.
pub(super) fn contributions(
    all: &[Systematic],
    (own, judged, plane): (&Part, &Part, &Plane),
    (fitted, turned): (&Result<Fitted, NoFit>, bool),
    points: &[PointMm],
    deviations_mm: &[f64],
) -> Contributions {
    let Ok(fitted) = fitted else { return Contributions::default() };
    if turned {
        return Contributions::none(all, "worked out of profiles along x or y only");
    }
    let part = &Part { free: own.free.clone(), ..judged.clone() };
    let areas_mm2 = &vec![0.0; points.len()];
    Contributions::new(all, Moving { part, plane, fitted, points, deviations_mm, areas_mm2 })
}
