//! What no points on a nominal could determine: its symmetries.

use crate::Nominal;
use crate::fit::model::Model;
use crate::fit::refine::priority;
use crate::fit::solve::System;
use crate::fit::triangle::Triangle;
use crate::{Parameter, Pose};

/// Indices of the free parameters that points all over a disc of the nominal about its vertex determine.
/// All of them if the nominal has too few places there to say.
pub(crate) fn determined_by_shape(
    nominal: &Nominal,
    pose: &Pose,
    free: &[Parameter],
    radius_mm: f64,
) -> Vec<usize> {
    let model = Model::new(nominal, pose, free);
    let mut triangle = Triangle::new(model.columns());
    let mut row = vec![0.0; model.columns()];
    for [x_mm, y_mm] in disc(radius_mm.min(WITHIN * nominal.domain_mm()), PLACES) {
        let point = nominal.height_mm(x_mm, y_mm).map(|z_mm| pose.to_measured([x_mm, y_mm, z_mm]));
        if point.and_then(|point| model.row(point, &mut row)).is_some() {
            triangle.push(&row);
        }
    }
    triangle.flush();
    if triangle.rows() < PLACES / 4 || !triangle.is_finite() {
        return (0..free.len()).collect();
    }
    System::new(&triangle).determinate(&priority(free, nominal), RANK_TOLERANCE)
}

/// Places spread evenly over a disc about the origin: a spiral by the golden angle, which no symmetry of a
/// part shares.
pub(crate) fn disc(radius_mm: f64, count: usize) -> impl Iterator<Item = [f64; 2]> {
    let golden = std::f64::consts::PI * (3.0 - 5.0_f64.sqrt());
    (0..count).map(move |index| {
        let r = radius_mm * ((index as f64 + 0.5) / count as f64).sqrt();
        let (sin, cos) = (golden * index as f64).sin_cos();
        [r * cos, r * sin]
    })
}

/// Places looked at: several for each parameter a shape may have.
const PLACES: usize = 512;
/// Where slopes may be infinite nothing is told.
const WITHIN: f64 = 0.999;
/// What is dependent but for rounding is so by the shape.
const RANK_TOLERANCE: f64 = 1e-11;
