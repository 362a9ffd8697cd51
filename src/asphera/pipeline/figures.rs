//! From the kernel's types to those of the report.

use std::collections::BTreeMap;

use asphera_form::{
    Estimate, Figures, Fit, Grid, LiveEstimate, Nominal, Parameter, Pose, Termination,
};
use asphera_surface::Plane;

use super::cells;
use super::details::FormDetails;
use super::errors::Errors;
use super::fit_details;
use crate::config::Part;
use crate::report::{DeviationFigures, FitFigures, FormFigures, ParameterFigures, PoseFigures};
use crate::snapshot::Map;

/// `plane` is that of projection, in whose frame the fit was made.
pub(super) fn form(
    part: &Part,
    fit: &Fit,
    figures: &Figures,
    details: FormDetails,
    plane: &Plane,
) -> FormFigures {
    FormFigures {
        nominal: part.nominal.to_string(),
        fit: FitFigures {
            method: fit.method.to_owned(),
            termination: termination(&fit.termination),
            iterations: u32::try_from(fit.iterations).unwrap_or(u32::MAX),
            free: names(&part.free, &part.nominal),
            parameters: parameters(&fit.estimates, &part.nominal),
            indeterminate: names(&fit.indeterminate, &part.nominal),
            pose: pose(&fit.pose, plane),
            details: fit_details::of_fit(fit),
        },
        deviation: deviation(figures),
        provisional: false,
        figures: details.figures,
        zernike: details.zernike,
        histogram: details.histogram,
        rings: details.rings,
        unknown: details.unknown,
    }
}

/// As [`form`], of running figures.
pub(super) fn running_form(
    part: &Part,
    estimate: &LiveEstimate,
    plane: &Plane,
    errors: &Errors,
) -> FormFigures {
    let known = errors.of(&estimate.figures);
    let uncertainty =
        known.map(|known| known.figures(estimate.figures.pv_nm, errors.is_measured(part)));
    let details = cells::details(&estimate.map, &part.aperture);
    FormFigures {
        nominal: part.nominal.to_string(),
        fit: FitFigures {
            method: asphera_form::METHOD.to_owned(),
            termination: "running".to_owned(),
            iterations: 0,
            free: names(&part.free, &part.nominal),
            parameters: parameters(&estimate.estimates, &part.nominal),
            indeterminate: names(&estimate.indeterminate, &part.nominal),
            pose: pose(&estimate.pose, plane),
            details: fit_details::of_running(estimate),
        },
        deviation: DeviationFigures { uncertainty, ..deviation(&estimate.figures) },
        provisional: true,
        figures: Vec::new(),
        zernike: details.zernike,
        histogram: details.histogram,
        rings: Vec::new(),
        unknown: details.unknown,
    }
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
        unmeasured: None,
    }
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
            format!("{changed} points kept crossing the edge of the aperture")
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
fn turns_rad([[_, r01, r02], [_, r11, r12], [r20, r21, r22]]: &[[f64; 3]; 3]) -> [f64; 3] {
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
