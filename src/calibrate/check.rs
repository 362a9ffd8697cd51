//! Input that is refused before anything is computed.

use crate::artefact::{Artefact, HIGHEST_ORDER, Pose, Settings};
use crate::columns::Columns;
use crate::correction::Axes;
use crate::error::CalibrateError;
use crate::parameter::Machine;

/// Refuses what no fit can be made of.
pub(crate) fn check(
    machine: Machine,
    artefact: Artefact,
    poses: &[Pose],
    settings: &Settings,
) -> Result<(), CalibrateError> {
    if poses.is_empty() {
        return Err(CalibrateError::NoPose);
    }
    if let Artefact::Sphere { radius_mm, u_radius_mm } = artefact {
        let is_right = radius_mm.is_finite() && radius_mm > 0.0;
        if !is_right || !(0.0..=0.1 * radius_mm).contains(&u_radius_mm) {
            return Err(CalibrateError::BadRadius { radius_mm, u_radius_mm });
        }
    }
    let mut parameters = settings.parameters.clone();
    parameters.sort_unstable();
    let twice = parameters.windows(2).find(|pair| pair[0] == pair[1]).map(|pair| pair[0]);
    let foreign = parameters.iter().copied().find(|one| !machine.parameters().contains(one));
    if let Some(parameter) = twice.or(foreign) {
        return Err(CalibrateError::BadParameter { parameter, machine });
    }
    if let Some(order) =
        [settings.map_order, settings.form_order].into_iter().find(|order| *order > HIGHEST_ORDER)
    {
        return Err(CalibrateError::BadOrder { order });
    }
    let columns = Columns::new(parameters, [settings.map_order, settings.form_order], poses.len());
    for (index, pose) in poses.iter().enumerate() {
        check_pose(index + 1, pose, machine, columns.count())?;
    }
    let is_alike = |pose: &Pose| {
        pose.turn_rad == poses[0].turn_rad
            && (artefact != Artefact::Flat || pose.shift_mm == poses[0].shift_mm)
    };
    if settings.form_order >= 2 && poses.iter().all(is_alike) {
        return Err(CalibrateError::NoReversal);
    }
    Ok(())
}

fn check_pose(
    pose: usize,
    measured: &Pose,
    machine: Machine,
    unknowns: usize,
) -> Result<(), CalibrateError> {
    let points = measured.axes.len();
    if points <= unknowns {
        return Err(CalibrateError::TooFewPoints { pose, points, unknowns });
    }
    let [shift_x, shift_y] = measured.shift_mm;
    if ![measured.turn_rad, shift_x, shift_y].iter().all(|value| value.is_finite()) {
        return Err(CalibrateError::BadPose { pose });
    }
    for (index, axes) in measured.axes.iter().enumerate() {
        let point = index + 1;
        let values = match (machine, *axes) {
            (Machine::Cartesian, Axes::Cartesian(values)) => values,
            (Machine::Polar, Axes::Polar { angle_rad, radius_mm, z_mm }) => {
                [angle_rad, radius_mm, z_mm]
            }
            _ => return Err(CalibrateError::OtherMachine { pose, point, machine }),
        };
        if !values.iter().all(|value| value.abs() < LARGEST) {
            return Err(CalibrateError::NotFinite { pose, point });
        }
    }
    Ok(())
}

/// Readings of a machine are smaller, mm or rad.
const LARGEST: f64 = 1e9;
