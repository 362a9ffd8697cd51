//! The final figures of a part from its fit, its sampling and its deviations.

use asphera_figures::{Sample, SampleError};
use asphera_form::{Aperture, Figures, Fit, Grid as MapGrid, Parameter, Pose};
use asphera_mesh::Mesh;
use asphera_report::{FeatureFigures, FormFigures, Map, UncertaintyFigures, Verdict};
use asphera_surface::Plane;
use asphera_uncertainty::verdict::{Deviations, Limit, forecast};
use asphera_uncertainty::{Places, UncertaintyError};

use super::assessment::Assessment;
use super::correlated::Sources;
use super::defects::{self, Meshed};
use super::design::Design;
use super::details::{Beside, FormDetails, Indicated, details, places_mm, sample};
use super::deviation_map::DeviationMap;
use super::errors::{Errors, ErrorsOfFigures};
use super::figures::{self, Ingredients};
use super::fitting::{Fitted, NoFit};
use super::judged::{self, AllJudged, Sure, of_narrow_limits};
use super::judgement::{Deviating, Plain, judge, plainly};
use super::removal::cells_of;
use super::standards::{self, Measured};
use super::step::Step;
use super::systematic::{Contributions, Moving, Systematic};
use super::uncertainties::{self, Assessed, assess};
use super::unmeasured::{Laid, Unmeasured};
use crate::Part;

/// Ingredients of the final figures.
pub(super) struct Inspection<'a> {
    pub(super) part: &'a Part,
    pub(super) mesh: &'a Mesh,
    pub(super) plane: &'a Plane,
    /// Where the part lies in the frame of the plane.
    pub(super) pose: &'a Pose,
    pub(super) fitted: Result<&'a Fitted, &'a NoFit>,
    pub(super) look: &'a Assessment,
    /// Why the mesh is none of the surface, if it is not.
    pub(super) folded: Option<&'a str>,
    /// Deviation of every vertex; NaN outside the aperture or without a fit.
    pub(super) deviations_mm: &'a [f64],
    /// Their figures.
    pub(super) found: Option<&'a Figures>,
    /// The area each vertex stands for.
    pub(super) areas_mm2: &'a [f64],
    /// Errors that all points have together.
    pub(super) systematic: &'a [Systematic],
}

/// Result of an inspection.
pub(super) struct Inspected {
    pub(super) form: Option<FormFigures>,
    pub(super) features: FeatureFigures,
    pub(super) verdict: Verdict,
    /// Deviation of every vertex, nm.
    pub(super) deviations_nm: Vec<f64>,
    pub(super) map: Option<DeviationMap>,
    /// The cells of the maps, and the deviation over them.
    pub(super) grid: Option<MapGrid>,
    pub(super) cells: Option<Map>,
}

impl Inspection<'_> {
    /// All figures, and the verdict. The cells of the maps lie on `grid`; `begin` hears of each step.
    pub(super) fn figures(&self, grid: Option<MapGrid>, begin: &mut dyn FnMut(Step)) -> Inspected {
        let (part, mesh, look) = (self.part, self.mesh, self.look);
        let fitted = self.fitted.ok();
        let points = mesh.points();
        let taken = fitted.and_then(|fitted| {
            uncertainties::taken(part, points, self.deviations_mm, fitted, self.areas_mm2)
        });
        let assessed = self.assessed(taken.as_ref());
        let mut errors = Errors::new(part);
        let known = self.errors(&mut errors, taken.as_ref());
        let noise_nm = match &assessed {
            Some(assessed) => assessed.as_ref().ok().map(|of| of.uncertainty.noise.sigma_mm * 1e6),
            None => errors.noise_nm(),
        };
        let sample = sample(part, self.pose, points, self.deviations_mm, self.areas_mm2);
        let design = fitted.and_then(|fitted| Design::new(part, mesh, fitted, self.areas_mm2));
        let systematic = self.contributions();
        let mut judged = self.judged(assessed.as_ref(), design.as_ref(), known.as_ref());
        systematic.count_limits(&mut judged);
        let made = fitted.zip(self.found);
        let heights = self.heights(known.as_ref(), assessed.as_ref(), &systematic);
        let sure = heights.as_ref().map(|heights| [heights.u_pv_nm, heights.u_rms_nm]);
        let sure = Sure::new(sure, &judged);
        let mut details = made.map(|(fitted, found)| {
            let beside = Beside { rms_nm: found.rms_nm, noise_nm, sure: &sure };
            self.details(&sample, design.as_ref(), fitted, beside)
        });
        begin(Step::Standards);
        // Without a fit no deviation is known.
        let counted = fitted.and(sample.as_ref().ok());
        let grid = grid.map(|grid| counted.map_or(grid, |sample| grid_of(sample, part, grid)));
        let cells = grid.as_ref().zip(counted).map(|(grid, sample)| cells_of(sample, grid));
        let deviations_nm: Vec<f64> = self.deviations_mm.iter().map(|mm| mm * 1e6).collect();
        let map = made
            .and_then(|_| DeviationMap::of(mesh, (&look.triangles, &look.covered), &deviations_nm));
        let by_budget = assessed.as_ref().and_then(|assessed| assessed.as_ref().ok());
        if let Some(((fitted, _), details)) = made.zip(details.as_mut()) {
            let measured = self.measured(fitted, map.as_ref(), noise_nm, (by_budget, &systematic));
            standards::add(&measured, details);
        }
        let sources = made.map(|(fitted, _)| self.sources(fitted, by_budget, &systematic));
        begin(Step::Unmeasured);
        let unmeasured =
            self.unmeasured(fitted.map(|fitted| &fitted.fit), self.deviations_mm, self.found);
        let of_design = design.as_ref().and_then(|design| design.as_ref().ok());
        let unmeasured_of_design = of_design.map(|design| {
            self.unmeasured(Some(design.fit), &design.deviations_mm, design.found.as_ref())
        });
        begin(Step::Defects);
        let features = self.features(made.is_some());
        begin(Step::Verdict);
        let known = details.as_ref().map_or(&[][..], |details| &details.figures);
        let narrow = of_narrow_limits(&judged, known);
        let hidden = unmeasured_of_design.as_ref().unwrap_or(&unmeasured);
        let guard = part.judging.guard.filter(|_| assessed.is_some());
        let mut compared = judged::verdict(part, guard, judged, [&unmeasured, hidden]);
        let noise_dof = by_budget.map_or(f64::INFINITY, |of| of.uncertainty.noise.dof);
        standards::hold(&mut compared, part, details.as_ref(), noise_dof, &unmeasured);
        let slopes_missing = details.as_ref().and_then(|details| details.slopes_missing.as_deref());
        judged::hold_slopes(&mut compared, part, slopes_missing);
        let verdict = judge(compared, part, mesh, self.fitted, &look.mesh, &look.sampling);
        let parts = made.zip(details).zip(sources);
        let form = parts.map(|(((fitted, found), mut details), sources)| {
            details.figures.extend(narrow);
            details.unknown.extend(sources.unknown.iter().cloned());
            if heights.is_none() {
                let why = "uncertainties: the noise of the points is not known";
                details.unknown.push(why.to_owned());
            }
            let of = Ingredients {
                fitted,
                found,
                details,
                sources,
                uncertainty: heights,
                systematic: systematic.figures(),
                unmeasured: unmeasured.figures(),
            };
            figures::form(part, &part.free, of, self.plane)
        });
        Inspected { form, features, verdict, deviations_nm, map, grid, cells }
    }

    /// What systematic errors add to the uncertainties.
    fn contributions(&self) -> Contributions {
        let Ok(fitted) = self.fitted else { return Contributions::default() };
        let (part, plane) = (self.part, self.plane);
        let (points, deviations_mm, areas_mm2) =
            (self.mesh.points(), self.deviations_mm, self.areas_mm2);
        let moving = Moving { part, plane, fitted, points, deviations_mm, areas_mm2 };
        Contributions::new(self.systematic, moving)
    }

    /// What the fit says of its uncertainties.
    fn sources(
        &self,
        fitted: &Fitted,
        by_budget: Option<&Assessed>,
        systematic: &Contributions,
    ) -> Sources {
        let deviating = (self.mesh.points(), self.deviations_mm);
        let sources = Sources::new(self.part, fitted, deviating, by_budget);
        sources.with_systematic(fitted, systematic)
    }

    /// Uncertainties of PV and RMS, where they are known.
    fn heights(
        &self,
        known: Option<&ErrorsOfFigures>,
        assessed: Option<&Result<Assessed, UncertaintyError>>,
        systematic: &Contributions,
    ) -> Option<UncertaintyFigures> {
        let found = self.found?;
        let heights = match (known, assessed) {
            (Some(known), _) => known.figures(found.pv_nm, true),
            (None, Some(Ok(assessed))) => uncertainties::of_heights(assessed, self.part),
            _ => return None,
        };
        Some(systematic.with_heights(heights, found.pv_nm))
    }

    /// The uncertainties that the nominal file asks for.
    fn assessed(&self, taken: Option<&Places>) -> Option<Result<Assessed, UncertaintyError>> {
        let fitted = self.fitted.ok()?;
        let step_nm = self.look.sampling.height_step_nm;
        assess(self.part, self.mesh.points(), fitted, self.plane, taken, step_nm)
    }

    /// Errors by the noise alone, where no uncertainties are asked for.
    fn errors(&self, errors: &mut Errors, taken: Option<&Places>) -> Option<ErrorsOfFigures> {
        if self.part.judging.uncertainty.is_some() {
            return None;
        }
        let noise_nm = self.look.sampling.noise_in_rms_nm();
        errors.look(self.part, self.mesh.points(), self.plane, noise_nm);
        let known = errors.of(self.found?)?;
        Some(taken.map_or(known, |taken| known.over(taken)))
    }

    /// The figures of the form by the deviations.
    fn details(
        &self,
        sample: &Result<Sample, SampleError>,
        design: Option<&Result<Design<'_>, String>>,
        fitted: &Fitted,
        beside: Beside<'_>,
    ) -> FormDetails {
        let indicated = match design {
            Some(design) => design.as_ref().map_err(Clone::clone).and_then(Design::indicated),
            None => sample.as_ref().map_err(ToString::to_string).map(|sample| Indicated {
                sample,
                nominal: &fitted.fit.nominal,
                from_design: false,
            }),
        };
        details(self.part, sample, indicated, self.areas_mm2, beside)
    }

    /// What the figures of standards are formed of.
    fn measured<'a>(
        &'a self,
        fitted: &'a Fitted,
        map: Option<&'a DeviationMap>,
        noise_nm: Option<f64>,
        (assessed, systematic): (Option<&'a Assessed>, &'a Contributions),
    ) -> Measured<'a> {
        Measured {
            part: self.part,
            fit: &fitted.fit,
            points: self.mesh.points(),
            deviations_mm: self.deviations_mm,
            triangles: &self.look.triangles,
            covered: &self.look.covered,
            areas_mm2: self.areas_mm2,
            map,
            noise_nm,
            assessed,
            systematic,
        }
    }

    /// Allowance for the part that was not measured, as it adds to the figures of a fit.
    fn unmeasured(
        &self,
        fit: Option<&Fit>,
        deviations_mm: &[f64],
        found: Option<&Figures>,
    ) -> Unmeasured {
        let (Some(fit), Some(found)) = (fit, found) else { return Unmeasured::default() };
        let sampling = &self.look.sampling;
        let places_mm = places_mm(&fit.pose, self.mesh.points());
        let laid = Laid {
            places_mm: &places_mm,
            deviations_mm,
            sampling,
            zones: &self.look.zones,
            most_bent: usize::MAX,
        };
        let free: Vec<Parameter> =
            fit.estimates.iter().map(|estimate| estimate.parameter).collect();
        let missing = sampling.coverage.map(|coverage| 1.0 - coverage);
        // Where nothing is missing there is nothing to foresee.
        let forecast = missing.filter(|missing| *missing > 0.0).and_then(|missing| {
            let (nominal, pose) = (&fit.nominal, &fit.pose);
            let aperture = &self.part.aperture;
            let measured = Deviations { places_mm: &places_mm, deviations_mm };
            forecast(measured, aperture, nominal, pose, &free, Some(missing))
        });
        let limits: Vec<&Limit> = self.part.limits().iter().collect();
        Unmeasured::of(self.part, &limits, &laid, found.rms_nm, forecast.as_ref())
    }

    fn features(&self, has_form: bool) -> FeatureFigures {
        let Assessment { triangles, sampling, .. } = self.look;
        let (mesh, plane, pose) = (self.mesh, self.plane, Some(self.pose));
        let meshed = Meshed { mesh, triangles, plane, pose, sampling };
        let deviating = has_form.then_some(self.deviations_mm);
        match self.folded {
            Some(why) => defects::not_looked_for(why),
            None => {
                defects::of_part(meshed, self.part, deviating.ok_or("there is no fit".to_owned()))
            }
        }
    }

    /// What was found of the limits.
    fn judged(
        &self,
        assessed: Option<&Result<Assessed, UncertaintyError>>,
        design: Option<&Result<Design<'_>, String>>,
        known: Option<&ErrorsOfFigures>,
    ) -> AllJudged<'_> {
        let points = self.mesh.points();
        let areas_mm2 = self.areas_mm2;
        match assessed {
            None => {}
            Some(Ok(assessed)) => {
                return uncertainties::judged(self.part, assessed, Some(areas_mm2));
            }
            Some(Err(error)) => return Err(uncertainties::unknown(error)),
        }
        let left = self.fitted.ok().map(|fitted| &fitted.fit);
        let left = left.map(|fit| (places_mm(&fit.pose, points), &fit.nominal));
        let left = left.as_ref().map(|(places_mm, nominal)| Deviating {
            places_mm,
            deviations_mm: self.deviations_mm,
            areas_mm2,
            nominal,
        });
        let design = design.map(|design| match design {
            Ok(design) => Ok(design.deviating(areas_mm2)),
            Err(why) => Err(why.clone()),
        });
        let plain = Plain { found: self.found, errors: known, left, design };
        plainly(self.part, &plain)
    }
}

/// The cells of the maps: without an aperture those of the running maps lie where the points had come to, about another
/// origin.
fn grid_of(sample: &Sample, part: &Part, grid: MapGrid) -> MapGrid {
    let side_mm = |axis: usize| {
        sample.places_mm().iter().fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], place| {
            [low.min(place[axis]), high.max(place[axis])]
        })
    };
    let ([x_min_mm, x_max_mm], [y_min_mm, y_max_mm]) = (side_mm(0), side_mm(1));
    if part.aperture != Aperture::None || x_min_mm >= x_max_mm || y_min_mm >= y_max_mm {
        return grid;
    }
    MapGrid { x_min_mm, x_max_mm, y_min_mm, y_max_mm, ..grid }
}
