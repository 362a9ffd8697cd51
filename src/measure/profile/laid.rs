//! The fit of a profile: what a line feels, and the turn of an oblique one.

use asphera_form::{Aperture, Parameter, Pose};
use asphera_geometry::PointMm;

use super::line::{Line, Way};
use crate::Part;
use crate::fitting::{Fitted, NoFit};

/// The free parameters that a line feels: those of an oblique one as of one along x.
pub(super) fn in_plane(free: &[Parameter], way: Way) -> Vec<Parameter> {
    use Parameter::{Rx, Ry, Rz, Tx, Ty};
    let mut own: Vec<Parameter> =
        free.iter().copied().filter(|free| ![Tx, Ty, Rx, Ry, Rz].contains(free)).collect();
    let has = |any: &[Parameter]| any.iter().any(|parameter| free.contains(parameter));
    let (shift, turn, of_shift, of_turn): (Parameter, Parameter, &[Parameter], &[Parameter]) =
        match way {
            Way::X => (Tx, Ry, &[Tx], &[Ry]),
            Way::Y => (Ty, Rx, &[Ty], &[Rx]),
            Way::Oblique => (Tx, Ry, &[Tx, Ty], &[Rx, Ry]),
        };
    own.extend(has(of_shift).then_some(shift));
    own.extend(has(of_turn).then_some(turn));
    own.sort_by_key(|parameter| Parameter::POSE.iter().position(|pose| pose == parameter));
    own
}

/// The fit along the line, its pose in the frame of the points.
pub(super) fn laid(
    points: &[PointMm],
    part: &Part,
    line: &Line,
    fit: impl FnOnce(&[PointMm], &Part) -> Result<Fitted, NoFit>,
) -> Result<Fitted, NoFit> {
    if line.way() != Way::Oblique || part.reference.is_some() {
        return fit(points, part);
    }
    let is_round = part.aperture == Aperture::None || part.aperture.is_round();
    if !part.nominal.is_rotational() || !is_round {
        return Err(NoFit::Oblique);
    }
    let turned: Vec<PointMm> = points.iter().map(|&point| line.turned(point)).collect();
    let mut fitted = fit(&turned, part)?;
    fitted.fit.pose = turned_back(&fitted.fit.pose, line);
    Ok(fitted)
}

/// The pose of a surface of revolution, before its points were turned: the same turn, about an axis that lies across the line.
fn turned_back(pose: &Pose, line: &Line) -> Pose {
    let [cos, sin] = line.direction;
    let turn = [[cos, -sin, 0.0], [sin, cos, 0.0], [0.0, 0.0, 1.0]];
    let row = |a: [f64; 3], b: [[f64; 3]; 3]| -> [f64; 3] {
        std::array::from_fn(|column| (0..3).map(|i| a[i] * b[i][column]).sum())
    };
    let back = [[cos, sin, 0.0], [-sin, cos, 0.0], [0.0, 0.0, 1.0]];
    let whole = turn.map(|of| row(row(of, pose.rotation()), back));
    Pose {
        tx_mm: cos * pose.tx_mm - sin * pose.ty_mm,
        ty_mm: sin * pose.tx_mm + cos * pose.ty_mm,
        tz_mm: pose.tz_mm,
        rx_rad: whole[2][1].atan2(whole[2][2]),
        ry_rad: (-whole[2][0]).clamp(-1.0, 1.0).asin(),
        rz_rad: whole[1][0].atan2(whole[0][0]),
    }
}
