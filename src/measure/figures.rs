//! From the kernel's types to those of the report.

use std::collections::BTreeMap;

use asphera_form::{
    Estimate, Figures, Fit, Grid, LiveEstimate, Loss, Nominal, Parameter, Pose, Robust, Smoothing,
    Termination,
};
use asphera_report::words::counted;
use asphera_report::{
    DeviationFigures, FitDetails, FitFigures, FormFigures, LossFigures, Map, ParameterFigures,
    PoseFigures, ReferenceFigures, StandardFigures, SystematicFigures, UncertaintyFigures,
    UnmeasuredFigures, WeightFigures,
};
use asphera_surface::Plane;

use super::cells;
use super::correlated::Sources;
use super::details::FormDetails;
use super::errors::Errors;
use super::fit_details;
use super::fitting::Fitted;
use super::origin;
use super::running::MadeReference;
use crate::Part;

/// All that the final figures of a form are made of.
pub(super) struct Ingredients<'a> {
    pub(super) fitted: &'a Fitted,
    /// PV and RMS.
    pub(super) found: &'a Figures,
    pub(super) details: FormDetails,
    pub(super) sources: Sources,
    /// Uncertainties of PV and RMS.
    pub(super) uncertainty: Option<UncertaintyFigures>,
    /// What systematic errors add to them.
    pub(super) systematic: Vec<SystematicFigures>,
    pub(super) unmeasured: UnmeasuredFigures,
}

/// The final figures, written once. `free` are the parameters that the nominal file names; `plane` is that of projection, in
/// whose frame the fit was made.
pub(super) fn form(
    part: &Part,
    free: &[Parameter],
    of: Ingredients<'_>,
    plane: &Plane,
) -> FormFigures {
    let Ingredients { fitted, found, details, sources, uncertainty, systematic, unmeasured } = of;
    let fit = &fitted.fit;
    // Of a surface made from the points, what was fitted by its parameters is the base.
    let reference = fitted.reference.as_ref().map(MadeReference::from);
    let (laid, nominal) = match &reference {
        Some(reference) => (reference.base_fit, unknown(reference)),
        None => (fit, part.nominal.to_string()),
    };
    let of_fit = fit_details::of_fit(fit, reference.as_ref(), part);
    FormFigures {
        nominal,
        reference: reference.map(|found| reference_figures(&found, part)),
        fit: FitFigures {
            method: fit.method.to_owned(),
            termination: termination(&fit.termination),
            iterations: u32::try_from(laid.iterations).unwrap_or(u32::MAX),
            free: reference.map_or_else(|| names(free, &part.nominal), |_| free_of_base(laid)),
            parameters: sources.parameters,
            indeterminate: fit_details::held(&laid.undetermined),
            pose: pose(&fit.pose, plane),
            effective_points: (!part.criterion.is_plain()).then_some(fit.effective_points),
            loss: fit.robust.and_then(loss),
            weights: weights(fitted),
            details: FitDetails {
                u_model: Some(sources.u_model.to_owned()),
                covariance: sources.covariance.or(of_fit.covariance),
                expanded_covers: sources.expanded_covers,
                aperture_narrowed_nm: fitted.narrowed_mm.map(|mm| 1e6 * mm),
                cautions: of_fit.cautions.into_iter().chain(sources.caution).collect(),
                correlation: sources.correlation,
                ..of_fit
            },
        },
        origin: Some(origin::figures(part, plane.from_plane(fit.pose.to_measured([0.0; 3])))),
        deviation: DeviationFigures {
            uncertainty,
            systematic,
            unmeasured: Some(unmeasured),
            ..deviation(found)
        },
        provisional: false,
        figures: details.figures,
        zernike: details.zernike,
        zernike_unknown: details.zernike_unknown,
        histogram: details.histogram,
        rings: details.rings,
        standards: details.standards,
        unknown: details.unknown,
    }
}

/// As [`form`], of running figures; `reference` is what the points have made of an unknown surface so far.
pub(super) fn running_form(
    part: &Part,
    estimate: &LiveEstimate,
    reference: Option<&MadeReference<'_>>,
    plane: &Plane,
    errors: &Errors,
) -> FormFigures {
    let known = errors.of(&estimate.figures);
    let uncertainty =
        known.map(|known| known.figures(estimate.figures.pv_nm, errors.is_measured(part)));
    let details = cells::details(&estimate.map, part);
    let [x_mm, y_mm] = details.origin_mm;
    let origin_mm = estimate.pose.to_measured([x_mm, y_mm, 0.0]);
    // Of a surface made from the points, what is fitted by its parameters is the base.
    let (nominal, method, laid, free) = match reference {
        Some(made) => {
            (unknown(made), made.method, &made.base_fit.nominal, free_of_base(made.base_fit))
        }
        None => {
            let free = names(&part.free, &part.nominal);
            (part.nominal.to_string(), estimate.method(), &part.nominal, free)
        }
    };
    let as_of_points = Some(estimate.reference_count as u64);
    FormFigures {
        nominal,
        reference: reference
            .map(|made| ReferenceFigures { as_of_points, ..reference_figures(made, part) }),
        fit: FitFigures {
            method: method.to_owned(),
            termination: "running".to_owned(),
            iterations: 0,
            free,
            parameters: parameters(&estimate.estimates, laid),
            indeterminate: fit_details::held(&estimate.undetermined),
            pose: pose(&estimate.pose, plane),
            effective_points: (estimate.weights.is_some() || estimate.robust.is_some())
                .then_some(estimate.effective_points),
            loss: estimate.robust.and_then(loss),
            weights: estimate.weights.map(|weights| WeightFigures {
                u_min_nm: 1e6 * weights.u_min_mm,
                u_max_nm: 1e6 * weights.u_max_mm,
                reduced_chi_square: weights.reduced_chi_square,
            }),
            details: fit_details::of_running(estimate, reference, part),
        },
        origin: Some(origin::figures(part, plane.from_plane(origin_mm))),
        deviation: DeviationFigures { uncertainty, ..deviation(&estimate.figures) },
        provisional: true,
        figures: Vec::new(),
        zernike: details.zernike,
        zernike_unknown: details.zernike_unknown,
        histogram: details.histogram,
        rings: Vec::new(),
        standards: StandardFigures::default(),
        unknown: details.unknown,
    }
}

/// That a reference was made from the points, and what that hides.
pub(super) fn made_from_points(reference: &MadeReference<'_>) -> String {
    let [x_mm, y_mm] = reference.spline.cutoff_mm;
    format!(
        "the reference was made from these points. It contains form error of waves longer than about {:.3} mm, and no deviation shows it",
        x_mm.max(y_mm)
    )
}

/// An unknown surface in words.
fn unknown(reference: &MadeReference<'_>) -> String {
    let cells = reference.spline.surface.cells();
    let radius = match reference.base_fit.nominal.radius_mm() {
        Some(radius_mm) => format!(" R {radius_mm:.6} mm"),
        None => String::new(),
    };
    format!(
        "unknown; made from the points: {}{radius} and splines over {} × {} cells of {:.4} mm",
        reference.base.name(),
        cells.nx,
        cells.ny,
        cells.step_x_mm.max(cells.step_y_mm)
    )
}

fn reference_figures(reference: &MadeReference<'_>, part: &Part) -> ReferenceFigures {
    let spline = reference.spline;
    let cells = spline.surface.cells();
    let smoothing = match part.reference.as_ref().map(|settings| settings.smoothing) {
        Some(Smoothing::Noise { .. }) => "noise",
        Some(Smoothing::Relative { .. }) => "given",
        Some(Smoothing::CrossValidation) | None => "cross validation",
    };
    ReferenceFigures {
        base: reference.base.name().to_owned(),
        base_rms_nm: 1e6 * reference.base_fit.residuals.rms_mm,
        // At most 128 each way.
        cells: [cells.nx as u32, cells.ny as u32],
        knots_mm: [cells.step_x_mm, cells.step_y_mm],
        smoothing: smoothing.to_owned(),
        lambda: spline.lambda,
        effective_parameters: spline.effective_parameters,
        follows_mm: spline.cutoff_mm[0].max(spline.cutoff_mm[1]),
        noise_nm: spline.noise_mm.map(|noise_mm| 1e6 * noise_mm),
        as_of_points: None,
    }
}

/// Free parameters of a base: what was estimated and what could not be.
fn free_of_base(fit: &Fit) -> Vec<String> {
    let estimated = fit.estimates.iter().map(|estimate| estimate.parameter);
    let all: Vec<Parameter> = estimated.chain(fit.indeterminate.iter().copied()).collect();
    names(&all, &fit.nominal)
}

fn loss(robust: Robust) -> Option<LossFigures> {
    let (name, k) = match robust.loss {
        Loss::Squares => return None,
        Loss::Huber { k } => ("huber", k),
        Loss::Tukey { k } => ("tukey", k),
    };
    Some(LossFigures {
        name: name.to_owned(),
        threshold_nm: 1e6 * k * robust.scale_mm,
        threshold_given: robust.scale_given,
        scale_nm: 1e6 * robust.scale_mm,
        below_half: robust.below_half as u64,
        left_out: robust.zero as u64,
        rounds: robust.rounds as u64,
    })
}

fn weights(fitted: &Fitted) -> Option<WeightFigures> {
    let u_mm = fitted.uncertainties_mm.as_ref()?;
    let extremes = u_mm
        .iter()
        .fold([f64::INFINITY, 0.0_f64], |[low, high], u_mm| [low.min(*u_mm), high.max(*u_mm)]);
    Some(WeightFigures {
        u_min_nm: 1e6 * extremes[0],
        u_max_nm: 1e6 * extremes[1],
        reduced_chi_square: fitted.fit.reduced_chi_square,
    })
}

pub(super) fn map(estimate: &LiveEstimate) -> Map {
    map_of(&estimate.map.grid, &estimate.map.mean_nm)
}

/// A map of one value for each cell, NaN where there is none.
pub(super) fn map_of(grid: &Grid, values_nm: &[f64]) -> Map {
    let dx_mm = (grid.x_max_mm - grid.x_min_mm) / grid.nx as f64;
    let dy_mm = (grid.y_max_mm - grid.y_min_mm) / grid.ny as f64;
    Map {
        nx: grid.nx,
        ny: grid.ny,
        x0_mm: grid.x_min_mm + dx_mm / 2.0,
        y0_mm: grid.y_min_mm + dy_mm / 2.0,
        dx_mm,
        dy_mm,
        values_nm: values_nm
            .iter()
            .map(|mean| mean.is_finite().then(|| (mean * 10.0).round() / 10.0))
            .collect(),
    }
}

fn deviation(figures: &Figures) -> DeviationFigures {
    DeviationFigures {
        pv_nm: figures.pv_nm,
        rms_nm: figures.rms_nm,
        max_nm: figures.max_nm,
        min_nm: figures.min_nm,
        at_max_mm: figures.at_max_mm,
        at_min_mm: figures.at_min_mm,
        uncertainty: None,
        systematic: Vec::new(),
        unmeasured: None,
    }
}

/// Every free parameter of a fit, of a surface made from the points those of its base, with u by the residuals.
pub(super) fn parameters_of(fitted: &Fitted) -> BTreeMap<String, ParameterFigures> {
    let reference = fitted.reference.as_ref().map(MadeReference::from);
    let laid = reference.as_ref().map_or(&fitted.fit, |reference| reference.base_fit);
    parameters(&laid.estimates, &laid.nominal)
}

fn parameters(estimates: &[Estimate], nominal: &Nominal) -> BTreeMap<String, ParameterFigures> {
    estimates
        .iter()
        .map(|estimate| {
            let figures = ParameterFigures {
                value: estimate.value,
                unit: estimate.parameter.unit(nominal).unwrap_or_default(),
                u: estimate.u.filter(|u| u.is_finite()),
                expanded_95: None,
                u_by_form: None,
            };
            (estimate.parameter.name(nominal), figures)
        })
        .collect()
}

/// Why an iteration ended, in words.
pub(super) fn termination(termination: &Termination) -> String {
    match termination {
        Termination::Converged { .. } => "converged".to_owned(),
        Termination::NoDescent { motion_mm } => {
            format!("no step made the sum of squares smaller, {motion_mm:.1e} mm were left")
        }
        Termination::MaxIterations { limit, motion_mm } => {
            format!("stopped after {limit} steps, the last of {motion_mm:.1e} mm")
        }
        Termination::UnstableAperture { changed } => {
            format!("{} kept crossing the edge of the aperture", counted(*changed as u64, "point"))
        }
    }
}

fn names(parameters: &[Parameter], nominal: &Nominal) -> Vec<String> {
    parameters.iter().map(|parameter| parameter.name(nominal)).collect()
}

/// The pose as reports write it: from the part frame into the measured one, whatever plane lies between.
fn pose(pose: &Pose, plane: &Plane) -> PoseFigures {
    let Pose { tx_mm, ty_mm, tz_mm, rx_rad, ry_rad, rz_rad } = *pose;
    if *plane == Plane::XY {
        return PoseFigures { tx_mm, ty_mm, tz_mm, rx_rad, ry_rad, rz_rad };
    }
    let (axes, in_plane) = (plane.axes(), pose.rotation());
    let turned: [[f64; 3]; 3] = std::array::from_fn(|row| {
        std::array::from_fn(|column| (0..3).map(|k| axes[k][row] * in_plane[k][column]).sum())
    });
    let [rx_rad, ry_rad, rz_rad] = turns_rad(&turned);
    let [tx_mm, ty_mm, tz_mm] = plane.from_plane([tx_mm, ty_mm, tz_mm]);
    PoseFigures { tx_mm, ty_mm, tz_mm, rx_rad, ry_rad, rz_rad }
}

/// The angles about x, y and z of the matrix `Rz·Ry·Rx`, that about y between -π/2 and π/2.
///
/// The angle about z is taken after that about x is undone. So it makes up for whatever that one came to
/// where the two cannot be told apart, with y at a right angle.
pub(super) fn turns_rad(
    [[_, r01, r02], [_, r11, r12], [r20, r21, r22]]: &[[f64; 3]; 3],
) -> [f64; 3] {
    let rx_rad = r21.atan2(*r22);
    let (sin, cos) = rx_rad.sin_cos();
    let ry_rad = (-r20).atan2(sin * r21 + cos * r22);
    let rz_rad = (sin * r02 - cos * r01).atan2(cos * r11 - sin * r12);
    [rx_rad, ry_rad, rz_rad]
}

#[cfg(test)]
mod tests {
    use asphera_form::Pose;
    use proptest::prelude::*;

    use super::*;

    fn assert_leads_the_same_way(pose_in_plane: &Pose, plane: &Plane) {
        let found = pose(pose_in_plane, plane);
        let found = Pose {
            tx_mm: found.tx_mm,
            ty_mm: found.ty_mm,
            tz_mm: found.tz_mm,
            rx_rad: found.rx_rad,
            ry_rad: found.ry_rad,
            rz_rad: found.rz_rad,
        };
        for part_mm in [[0.0; 3], [10.0, 0.0, 0.0], [0.0, 10.0, 0.0], [0.0, 0.0, 10.0]] {
            let expected = plane.from_plane(pose_in_plane.to_measured(part_mm));
            let measured_mm = found.to_measured(part_mm);
            for axis in 0..3 {
                let error = (measured_mm[axis] - expected[axis]).abs();
                assert!(error < 1e-13 * 30.0, "{plane}: {measured_mm:?}, not {expected:?}");
            }
        }
    }

    #[test]
    fn upright_planes_have_a_pose_too() {
        let tilted = Pose { rx_rad: 1e-9, ry_rad: -2e-5, rz_rad: 0.3, ..Pose::default() };
        for normal in [[1.0, 0.0, 0.0], [-1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, -1.0]] {
            let plane = Plane::new([1.0, 2.0, 3.0], normal).unwrap();
            assert_leads_the_same_way(&Pose::default(), &plane);
            assert_leads_the_same_way(&tilted, &plane);
        }
    }

    proptest! {
        #[test]
        fn the_pose_leads_from_the_part_through_the_plane_into_the_measured_frame(
            normal in prop::array::uniform3(-1.0..1.0f64),
            t in prop::array::uniform3(-10.0..10.0f64),
            r in prop::array::uniform3(-3.0..3.0f64),
        ) {
            prop_assume!(normal.iter().any(|coordinate| *coordinate != 0.0));
            let plane = Plane::new([1.0, -2.0, 3.0], normal).unwrap();
            let pose = Pose {
                tx_mm: t[0], ty_mm: t[1], tz_mm: t[2], rx_rad: r[0], ry_rad: r[1], rz_rad: r[2],
            };
            assert_leads_the_same_way(&pose, &plane);
        }
    }
}
