//! Figures of points that moved a little, after a fit of their own.

use std::collections::BTreeMap;

use asphera_figures::Subject;
use asphera_form::{
    Estimate, Figures, Fit, FitSettings, Nominal, deviations, fit_weighted, reference,
};
use asphera_geometry::PointMm;
use asphera_geometry::vector::{Vector, dot};
use asphera_surface::Plane;
use asphera_uncertainty::verdict::Limit;

use super::{Effect, Field, moved};
use crate::Part;
use crate::details::places_mm;
use crate::fitting::Fitted;
use crate::judgement::{Deviating, Plain, plainly};
use crate::running::fit_settings;

/// A measurement whose points are moved.
#[derive(Clone, Copy)]
pub(crate) struct Moving<'a> {
    /// The part with the free parameters and the aperture of its fit, and the limits that are of interest.
    pub(crate) part: &'a Part,
    /// Plane of projection, in whose frame points and fit are.
    pub(crate) plane: &'a Plane,
    pub(crate) fitted: &'a Fitted,
    pub(crate) points: &'a [PointMm],
    /// Deviation of each; NaN of one that does not count, wherever it is moved.
    pub(crate) deviations_mm: &'a [f64],
    /// The area that each point stands for.
    pub(crate) areas_mm2: &'a [f64],
}

/// The points of a measurement that count.
pub(super) struct Refit<'a> {
    moving: Moving<'a>,
    pub(super) points: Vec<PointMm>,
    /// Their places in the part frame, where figures are formed whatever moves: the edge of a zone shall not pick others.
    places_mm: Vec<[f64; 2]>,
    areas_mm2: Vec<f64>,
    uncertainties_mm: Option<Vec<f64>>,
}

/// Figures of one fit.
pub(super) struct Refitted {
    /// Deviation of each point that counts, mm.
    pub(super) deviations_mm: Vec<f64>,
    pub(super) pv_nm: f64,
    pub(super) rms_nm: f64,
    /// Values of figures that have a limit, by its name.
    pub(super) limits: BTreeMap<String, f64>,
    /// Pose and shape.
    pub(super) estimates: Vec<Estimate>,
}

impl<'a> Refit<'a> {
    pub(super) fn new(moving: Moving<'a>) -> Refit<'a> {
        let Moving { fitted, points, deviations_mm, areas_mm2, .. } = moving;
        let counts = |index: &usize| deviations_mm[*index].is_finite();
        let used: Vec<usize> = (0..points.len()).filter(counts).collect();
        let used = thinned(used, deviations_mm, moving.part);
        let of = |all: &[f64]| used.iter().map(|&index| all[index]).collect::<Vec<f64>>();
        let points: Vec<PointMm> = used.iter().map(|&index| points[index]).collect();
        Refit {
            places_mm: places_mm(&fitted.fit.pose, &points),
            points,
            areas_mm2: of(areas_mm2),
            uncertainties_mm: fitted.uncertainties_mm.as_deref().map(of),
            moving,
        }
    }

    /// The displacements of the points by one standard uncertainty of each error of a source, in their own frame, mm; `None` where
    /// one of them is not known.
    pub(super) fn displacements_mm(&self, effect: &Effect) -> Option<Vec<Vec<Vector>>> {
        let Moving { plane, fitted, .. } = self.moving;
        let axes = plane.axes();
        let by_field = |field: &Field| {
            let at = |&point: &PointMm| {
                let by_mm = field(plane.from_plane(point));
                Some(axes.map(|axis| dot(axis, by_mm)))
            };
            self.at_all(at)
        };
        match effect {
            Effect::Fields(fields) => fields.iter().map(|field| by_field(&**field)).collect(),
            Effect::Ball { u_mm, is_lowest } => {
                let lift = f64::from(u8::from(*is_lowest));
                let at = |&point: &PointMm| {
                    let normal = normal_at(&fitted.fit, point)?;
                    Some([-normal[0], -normal[1], lift - normal[2]].map(|share| share * u_mm))
                };
                Some(vec![self.at_all(at)?])
            }
            Effect::Unknown(_) => None,
        }
    }

    /// A displacement of every point; `None` where one is not known or not finite.
    fn at_all(&self, at: impl Fn(&PointMm) -> Option<Vector>) -> Option<Vec<Vector>> {
        let all: Option<Vec<Vector>> = self.points.iter().map(at).collect();
        all.filter(|all| all.iter().flatten().all(|mm| mm.is_finite()))
    }

    /// Figures of the points moved by a share of displacements, after a fit; `None` where there is none.
    pub(super) fn figures(&self, share: f64, by_mm: &[Vector]) -> Option<Refitted> {
        let points: Vec<PointMm> =
            self.points.iter().zip(by_mm).map(|(&at, &by)| moved(at, share, by)).collect();
        let Moving { part, fitted, .. } = self.moving;
        if let Some(settings) = part.reference.as_ref().filter(|_| fitted.reference.is_some()) {
            let made = reference(&points, settings).ok()?;
            return self.of_fit(&points, &made.fit, made.base_fit.estimates);
        }
        let fit = self.fit(&points, &fitted.fit.nominal, &fitted.fit, part.free.clone())?;
        let estimates = fit.estimates.clone();
        self.of_fit(&points, &fit, estimates)
    }

    /// A fit that starts where another ended.
    fn fit(
        &self,
        points: &[PointMm],
        nominal: &Nominal,
        from: &Fit,
        free: Vec<asphera_form::Parameter>,
    ) -> Option<Fit> {
        let settings =
            FitSettings { free, start: from.pose, search: false, ..fit_settings(self.moving.part) };
        fit_weighted(points, self.uncertainties_mm.as_deref(), nominal, &settings).ok()
    }

    fn of_fit(&self, points: &[PointMm], fit: &Fit, estimates: Vec<Estimate>) -> Option<Refitted> {
        let part = self.moving.part;
        let deviations_mm = deviations(points, &fit.nominal, &fit.pose);
        let found = figures_of(points, &deviations_mm)?;
        let deviating = |deviations_mm| Deviating {
            places_mm: &self.places_mm,
            deviations_mm,
            areas_mm2: &self.areas_mm2,
            nominal: &fit.nominal,
        };
        let of_design = self.design_of(points);
        let plain = Plain {
            found: Some(&found),
            errors: None,
            left: Some(deviating(&deviations_mm)),
            design: of_design.as_ref().map(|found| {
                let (nominal, deviations_mm) = found.as_ref().ok_or_else(String::new)?;
                Ok(Deviating { nominal, ..deviating(deviations_mm) })
            }),
        };
        let judged = plainly(part, &plain).ok()?;
        let limits = judged.iter().filter_map(|one| {
            let value = one.found.as_ref().ok()?.value;
            Some((one.limit.name(), value))
        });
        Some(Refitted {
            pv_nm: found.pv_nm,
            rms_nm: found.rms_nm,
            limits: limits.collect(),
            estimates,
            deviations_mm,
        })
    }

    /// Deviations from the design, where the shape was free; the inner value is absent where there is no fit.
    fn design_of(&self, points: &[PointMm]) -> Option<Option<(Nominal, Vec<f64>)>> {
        let design = self.moving.fitted.design.as_ref()?;
        let found = || {
            let design = design.as_ref().ok()?;
            let motions = asphera_figures::is_motion;
            let free = self.moving.part.free.iter().copied().filter(|&one| motions(one)).collect();
            let fit = self.fit(points, &design.nominal, design, free)?;
            let deviations_mm = deviations(points, &fit.nominal, &fit.pose);
            Some((fit.nominal, deviations_mm))
        };
        Some(found())
    }
}

/// Some of many points: every so many, and the extremes. Systematic errors are smooth, so that these tell how figures change. A
/// slope needs the neighbours of its points: with a limit of one all stay.
fn thinned(used: Vec<usize>, deviations_mm: &[f64], part: &Part) -> Vec<usize> {
    let is_slope = |limit: &Limit| limit.definition.subject() == Subject::Slope;
    if used.len() <= MOST_POINTS || part.limits().iter().any(is_slope) {
        return used;
    }
    let by_deviation = |a: &&usize, b: &&usize| deviations_mm[**a].total_cmp(&deviations_mm[**b]);
    let lowest = used.iter().min_by(by_deviation).copied();
    let highest = used.iter().max_by(by_deviation).copied();
    let step = used.len().div_ceil(MOST_POINTS);
    let stays = |(number, index): &(usize, usize)| {
        number % step == 0 || Some(*index) == lowest || Some(*index) == highest
    };
    used.into_iter().enumerate().filter(stays).map(|(_, index)| index).collect()
}

/// PV and RMS of all points, wherever the edge of the aperture lies now.
fn figures_of(points: &[PointMm], deviations_mm: &[f64]) -> Option<Figures> {
    let whole = asphera_form::Aperture::None;
    let found = Figures::new(points, deviations_mm, &asphera_form::Pose::default(), &whole)?;
    (found.count == points.len()).then_some(found)
}

/// Points of one fit at most, nearly.
const MOST_POINTS: usize = 1 << 16;

/// Unit normal of the fitted surface at a point of its frame, on the side of the probe.
fn normal_at(fit: &Fit, point: PointMm) -> Option<Vector> {
    let foot = fit.nominal.foot(fit.pose.to_part(point))?;
    let normal = fit.pose.rotation().map(|row| dot(row, foot.normal));
    let side = if normal[2] < 0.0 { -1.0 } else { 1.0 };
    Some(normal.map(|of| side * of))
}
