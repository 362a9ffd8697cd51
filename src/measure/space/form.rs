//! The form of a part as a whole: deviations out of the fitted shape, and their figures.

use std::collections::BTreeMap;

use asphera_figures::{Definition, Figure, Subject};
use asphera_form::{Figures, METHOD};
use asphera_geometry::PointMm;
use asphera_report::{
    DeviationFigures, FitDetails, FitFigures, FormFigures, HistogramFigures, Map, OriginFigures,
    ParameterFigures, PoseFigures, Source, StandardFigures,
};

use super::chart::chart;
use super::fit::ShapeFit;
use super::meshed::Meshed;
use super::shape::Shape;
use crate::Part;
use crate::details::histogram_of;
use crate::errors::{Errors, ErrorsOfFigures};
use crate::judged::Sure;
use crate::naming;

/// A fitted part.
#[derive(Clone, Debug)]
pub(super) struct Formed {
    pub(super) fit: ShapeFit,
    /// Deviation of every point, mm.
    pub(super) deviations_mm: Vec<f64>,
    pub(super) figures: Figures,
    /// Root mean square by area, nm: about the nominal, and about the mean; `None` where no facet counts.
    pub(super) by_area_nm: Option<[f64; 2]>,
    /// Errors by the noise.
    pub(super) errors: Option<ErrorsOfFigures>,
}

impl Formed {
    /// Deviations of the points of a mesh from a fit; `None` without a point. Areas are those of the facets that are `covered`.
    pub(super) fn of(
        meshed: &Meshed,
        fit: ShapeFit,
        covered: &[bool],
        part: &Part,
        errors: &Errors,
    ) -> Option<Formed> {
        let deviations_mm: Vec<f64> =
            meshed.points_mm.iter().map(|&place| fit.laid.off(place).0).collect();
        let figures = figures(&meshed.points_mm, &deviations_mm, &fit, part)?;
        let by_area_nm = by_area_nm(meshed, covered, &deviations_mm);
        let errors = errors.of(&figures);
        Some(Formed { fit, deviations_mm, figures, by_area_nm, errors })
    }

    /// The value of a figure in nm; `None` of one that is not formed in space.
    pub(super) fn value_nm(&self, definition: Definition) -> Option<f64> {
        match definition {
            Definition::PeakToValley => Some(self.figures.pv_nm),
            Definition::RmsOverPoints => Some(self.figures.rms_nm),
            Definition::RmsAboutZero => self.by_area_nm.map(|[zero, _]| zero),
            Definition::RmsAboutMean => self.by_area_nm.map(|[_, mean]| mean),
            _ => None,
        }
    }

    /// Standard uncertainty of a figure in nm, where it is known.
    pub(super) fn u_nm(&self, definition: Definition) -> Option<f64> {
        let errors = self.errors.as_ref()?;
        match definition {
            Definition::PeakToValley => Some(errors.u_pv_nm),
            Definition::RmsOverPoints => Some(errors.u_rms_nm),
            _ => None,
        }
    }

    /// Deviations on a flat chart; `None` without extent.
    pub(super) fn chart(&self, meshed: &Meshed) -> Option<Map> {
        chart(&self.fit.laid, &meshed.points_mm, &self.deviations_mm)
    }

    /// As reports write it.
    pub(super) fn report(
        &self,
        part: &Part,
        noise_measured: bool,
        provisional: bool,
    ) -> FormFigures {
        let u_nm = self.errors.as_ref().map(|errors| [errors.u_pv_nm, errors.u_rms_nm]);
        let sure = Sure::new(u_nm, &Ok(Vec::new()));
        let formed = |definition: Definition| {
            let value = self.value_nm(definition)?;
            let variant = match definition {
                Definition::PeakToValley | Definition::RmsOverPoints => {
                    "in space, every point counted alike"
                }
                _ => "in space, by area",
            };
            Some(naming::figure_of_all(Figure { definition, value }, variant, &sure))
        };
        let figures: Vec<_> = FORMED.into_iter().filter_map(formed).collect();
        let values_nm: Vec<f64> = self.deviations_mm.iter().map(|mm| 1e6 * mm).collect();
        let Figures { pv_nm, rms_nm, max_nm, min_nm, at_max_mm, at_min_mm, .. } = self.figures;
        let uncertainty = self.errors.as_ref().map(|known| known.figures(pv_nm, noise_measured));
        let mut unknown = vec![not_formed()];
        if uncertainty.is_none() {
            unknown.push(match part.judging.uncertainty {
                Some(_) => "uncertainties: of a budget only the noise is worked out in space, and it is not known or not all".to_owned(),
                None => "uncertainties: the noise of the points is not known".to_owned(),
            });
        }
        FormFigures {
            nominal: part.nominal.to_string(),
            reference: None,
            fit: self.fit_figures(part, provisional),
            origin: Some(self.origin()),
            deviation: DeviationFigures {
                pv_nm,
                rms_nm,
                max_nm,
                min_nm,
                at_max_mm,
                at_min_mm,
                uncertainty,
                systematic: Vec::new(),
                unmeasured: None,
            },
            provisional,
            figures: if provisional { Vec::new() } else { figures },
            zernike: None,
            zernike_unknown: Some("the part is meshed in space".to_owned()),
            histogram: histogram_of(&values_nm, values_nm.iter().map(|_| 1), Source::Points).map(
                |histogram| HistogramFigures {
                    pv_limit_nm: part.judging.pv_limit_nm(),
                    ..histogram
                },
            ),
            rings: Vec::new(),
            standards: StandardFigures::default(),
            unknown,
        }
    }

    fn fit_figures(&self, part: &Part, provisional: bool) -> FitFigures {
        let fit = &self.fit;
        let pose = fit.laid.pose(&part.nominal);
        let dof = self.deviations_mm.len().saturating_sub(fit.unknowns);
        let squares: f64 = self.deviations_mm.iter().map(|mm| mm * mm).sum();
        let sigma_mm = (dof > 0).then(|| (squares / dof as f64).sqrt());
        let named = |name: &str, value: f64, variance: f64| {
            let u = sigma_mm.map(|sigma_mm| sigma_mm * variance.sqrt());
            let figures = ParameterFigures {
                value,
                unit: "mm".to_owned(),
                u,
                expanded_95: None,
                u_by_form: None,
            };
            (name.to_owned(), figures)
        };
        let mut parameters: BTreeMap<String, ParameterFigures> = BTreeMap::new();
        let [x, y, z] = fit.laid.centre_mm;
        let variances = fit.variances;
        let of_place = match fit.laid.shape {
            Shape::Sphere { .. } => {
                parameters.extend([
                    named("centre_x", x, variances[0]),
                    named("centre_y", y, variances[1]),
                    named("centre_z", z, variances[2]),
                ]);
                3
            }
            Shape::Cylinder { .. } => 4,
            Shape::Plane => 3,
        };
        if fit.unknowns > of_place {
            parameters.extend([named("radius", fit.laid.shape.radius_mm(), variances[of_place])]);
        }
        let mut free = vec![place_of(fit.laid.shape).to_owned()];
        free.extend((fit.unknowns > of_place).then(|| "radius".to_owned()));
        let termination = if fit.converged { "converged" } else { "stopped before it converged" };
        FitFigures {
            method: method(fit.laid.shape),
            termination: if provisional { "running".to_owned() } else { termination.to_owned() },
            iterations: fit.iterations,
            free,
            parameters,
            indeterminate: Vec::new(),
            pose: PoseFigures {
                tx_mm: pose.tx_mm,
                ty_mm: pose.ty_mm,
                tz_mm: pose.tz_mm,
                rx_rad: pose.rx_rad,
                ry_rad: pose.ry_rad,
                rz_rad: pose.rz_rad,
            },
            effective_points: None,
            loss: None,
            weights: None,
            details: FitDetails {
                converged: (!provisional).then_some(fit.converged),
                dof: Some(dof as u64),
                sigma_nm: sigma_mm.map(|mm| 1e6 * mm),
                u_model: Some(FitDetails::BY_RESIDUALS.to_owned()),
                ..FitDetails::default()
            },
        }
    }

    fn origin(&self) -> OriginFigures {
        let place = match self.fit.laid.shape {
            Shape::Plane => OriginFigures::MIDDLE_OF_POINTS,
            Shape::Sphere { .. } => OriginFigures::CENTRE,
            Shape::Cylinder { .. } => OriginFigures::AXIS,
        };
        OriginFigures { place: place.to_owned(), at_mm: self.fit.laid.centre_mm }
    }
}

fn place_of(shape: Shape) -> &'static str {
    match shape {
        Shape::Plane => "distance and tilts of the plane",
        Shape::Sphere { .. } => "centre",
        Shape::Cylinder { .. } => "place and direction of the axis",
    }
}

/// The criterion, and on which side a deviation is positive.
fn method(shape: Shape) -> String {
    let side = match shape {
        Shape::Plane => "on the side that the normal points to",
        Shape::Sphere { .. } | Shape::Cylinder { .. } => "outside",
    };
    format!("{METHOD} in space, positive {side}")
}

/// PV and RMS over the points; `None` without a point.
fn figures(
    points_mm: &[PointMm],
    deviations_mm: &[f64],
    fit: &ShapeFit,
    part: &Part,
) -> Option<Figures> {
    let (mut low, mut high) = (0, 0);
    let mut squares = 0.0;
    for (at, mm) in deviations_mm.iter().enumerate() {
        squares += mm * mm;
        if *mm < deviations_mm[low] {
            low = at;
        }
        if *mm > deviations_mm[high] {
            high = at;
        }
    }
    let (least, most) = (*deviations_mm.get(low)?, *deviations_mm.get(high)?);
    let pose = fit.laid.pose(&part.nominal);
    Some(Figures {
        pv_nm: 1e6 * (most - least),
        rms_nm: 1e6 * (squares / deviations_mm.len() as f64).sqrt(),
        max_nm: 1e6 * most,
        min_nm: 1e6 * least,
        at_max_mm: pose.to_part(points_mm[high]),
        at_min_mm: pose.to_part(points_mm[low]),
        count: deviations_mm.len(),
    })
}

/// Root mean squares by area, a point standing for a third of its facets: about the nominal, and about the mean.
fn by_area_nm(meshed: &Meshed, covered: &[bool], deviations_mm: &[f64]) -> Option<[f64; 2]> {
    let [mut area, mut sum, mut square] = [0.0; 3];
    for (&facet, _) in meshed.facets.iter().zip(covered).filter(|(_, covered)| **covered) {
        let own = asphera_geometry::vector::length(meshed.double_area(facet));
        let values = facet.map(|corner| deviations_mm[corner as usize]);
        area += own;
        sum += own * values.iter().sum::<f64>() / 3.0;
        square += own * values.iter().map(|mm| mm * mm).sum::<f64>() / 3.0;
    }
    let (mean, mean_square) = (sum / area, square / area);
    (area > 0.0)
        .then(|| [1e6 * mean_square.sqrt(), 1e6 * (mean_square - mean * mean).max(0.0).sqrt()])
}

/// Figures that are formed in space.
const FORMED: [Definition; 4] = [
    Definition::PeakToValley,
    Definition::RmsOverPoints,
    Definition::RmsAboutZero,
    Definition::RmsAboutMean,
];

/// Why figures are missing in space.
fn not_formed() -> String {
    let points = Subject::Points.figures();
    format!(
        "figures of a map, such as Zernike terms, slopes, texture and {points}, are not formed in space"
    )
}
