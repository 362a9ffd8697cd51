//! From the kernel's types to those of the report.

use std::collections::BTreeMap;

use asphera_form::{Estimate, Figures, Fit, LiveEstimate, Nominal, Parameter, Pose, Termination};

use crate::config::Part;
use crate::report::{DeviationFigures, FitFigures, FormFigures, ParameterFigures, PoseFigures};
use crate::snapshot::Map;

/// The largest gap allowed: that of the part, or four times the distance the points have on average. On a
/// flat surface ε allows anything, and a triangulation fills every hole.
pub(super) fn gap_limit_mm(part: &Part, points: usize, projected_area_mm2: f64) -> Option<f64> {
    let distance_mm = (projected_area_mm2 / points as f64).sqrt();
    part.gap_limit_mm.or((distance_mm > 0.0).then_some(4.0 * distance_mm))
}

/// An upper bound of the local feature size at a place of the measured frame: the nominal's smallest
/// radius of curvature there. Tilts of a part are small, so the place is only shifted.
pub(super) fn lfs_mm(nominal: &Nominal, pose: &Pose) -> impl Fn(f64, f64) -> f64 + use<> {
    let (nominal, tx, ty) = (*nominal, pose.tx_mm, pose.ty_mm);
    move |x, y| nominal.lfs_bound_mm((x - tx).hypot(y - ty))
}

pub(super) fn form(part: &Part, fit: &Fit, figures: &Figures) -> FormFigures {
    FormFigures {
        nominal: part.nominal.to_string(),
        fit: FitFigures {
            method: fit.method.to_owned(),
            termination: termination(&fit.termination),
            iterations: u32::try_from(fit.iterations).unwrap_or(u32::MAX),
            free: names(&part.free),
            parameters: parameters(&fit.estimates),
            indeterminate: names(&fit.indeterminate),
            pose: pose(&fit.pose),
        },
        deviation: deviation(figures),
        provisional: false,
    }
}

pub(super) fn running_form(part: &Part, estimate: &LiveEstimate) -> FormFigures {
    FormFigures {
        nominal: part.nominal.to_string(),
        fit: FitFigures {
            method: asphera_form::METHOD.to_owned(),
            termination: "running".to_owned(),
            iterations: 0,
            free: names(&part.free),
            parameters: parameters(&estimate.estimates),
            indeterminate: names(&estimate.indeterminate),
            pose: pose(&estimate.pose),
        },
        deviation: deviation(&estimate.figures),
        provisional: true,
    }
}

pub(super) fn map(estimate: &LiveEstimate) -> Map {
    let grid = estimate.map.grid;
    let dx_mm = (grid.x_max_mm - grid.x_min_mm) / grid.nx as f64;
    let dy_mm = (grid.y_max_mm - grid.y_min_mm) / grid.ny as f64;
    Map {
        nx: grid.nx,
        ny: grid.ny,
        x0_mm: grid.x_min_mm + dx_mm / 2.0,
        y0_mm: grid.y_min_mm + dy_mm / 2.0,
        dx_mm,
        dy_mm,
        values_nm: estimate
            .map
            .mean_nm
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
    }
}

fn parameters(estimates: &[Estimate]) -> BTreeMap<String, ParameterFigures> {
    estimates
        .iter()
        .map(|estimate| {
            let figures = ParameterFigures {
                value: estimate.value,
                unit: estimate.parameter.unit(),
                u: estimate.u.filter(|u| u.is_finite()),
            };
            (estimate.parameter.to_string(), figures)
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
            format!("{changed} points kept crossing the edge of the aperture")
        }
    }
}

fn names(parameters: &[Parameter]) -> Vec<String> {
    parameters.iter().map(ToString::to_string).collect()
}

/// The pose as reports write it.
fn pose(pose: &Pose) -> PoseFigures {
    PoseFigures {
        tx_mm: pose.tx_mm,
        ty_mm: pose.ty_mm,
        tz_mm: pose.tz_mm,
        rx_rad: pose.rx_rad,
        ry_rad: pose.ry_rad,
        rz_rad: pose.rz_rad,
    }
}
