//! Where the machine meets the part.

use asphera_form::artefact::{Artefact, ArtefactError};
use asphera_form::{Nominal, PointMm, Pose};

use crate::Scene;

/// A place of the part, (x, y) in mm in the part frame.
pub(crate) type PlaceMm = [f64; 2];

/// The part under the machine's positions, in the order of the triggers.
pub(crate) struct Meeting {
    /// The points of the part, machine frame, mm.
    pub(crate) points: Vec<PointMm>,
    /// Form error there along the normal, mm.
    pub(crate) deviations_mm: Vec<f64>,
}

/// Why the machine does not meet the part.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Missed {
    /// Over this position of the machine, (x, y) in mm, there is no part, or none is found.
    At(PlaceMm),
    /// The form error has no projection.
    Artefact(ArtefactError),
}

/// Lays the part of a scene under the machine's positions.
///
/// Which places are met depends on the form error, and its projection on the null space of the
/// free parameters depends on the places (`asphera_form::artefact`). A form error of 100 nm moves
/// a place by no more than that, and the projection by a ten-thousandth of its gradient, so two
/// rounds are exact to rounding: the third would move a place by less than 1e-12 mm.
pub(crate) fn meet(scene: &Scene, machine_mm: &[PlaceMm]) -> Result<Meeting, Missed> {
    let (nominal, pose) = (&scene.nominal, scene.pose);
    let bare = artefact(nominal, pose, &[], &[], |_, _| 0.0)?;
    let mut places = machine_mm.to_vec();
    settle(&bare, machine_mm, &mut places)?;
    let error_mm = |x_mm: f64, y_mm: f64| scene.form_error.height_nm(x_mm, y_mm) * MM_PER_NM;
    let first = artefact(nominal, pose, &scene.free, &places, error_mm)?;
    settle(&first, machine_mm, &mut places)?;
    let part = artefact(nominal, pose, &scene.free, &places, error_mm)?;
    settle(&part, machine_mm, &mut places)?;

    let mut points = Vec::with_capacity(places.len());
    let mut deviations_mm = Vec::with_capacity(places.len());
    for (&[x_mm, y_mm], &position) in places.iter().zip(machine_mm) {
        let there = part.point_mm(x_mm, y_mm).zip(part.deviation_mm(x_mm, y_mm));
        let (point, deviation_mm) = there.ok_or(Missed::At(position))?;
        points.push(point);
        deviations_mm.push(deviation_mm);
    }
    Ok(Meeting { points, deviations_mm })
}

fn artefact<E: Fn(f64, f64) -> f64>(
    nominal: &Nominal,
    pose: Pose,
    free: &[asphera_form::Parameter],
    places: &[PlaceMm],
    error_mm: E,
) -> Result<Artefact<E>, Missed> {
    Artefact::new(nominal.clone(), pose, free, places, error_mm).map_err(Missed::Artefact)
}

/// Moves each place until the part's point there stands over the machine's position.
///
/// Each step takes the miss back into the part frame as if the part were flat. What is left is the
/// miss times tilt times slope, so four or five steps reach rounding.
pub(crate) fn settle<E: Fn(f64, f64) -> f64>(
    part: &Artefact<E>,
    machine_mm: &[PlaceMm],
    places: &mut [PlaceMm],
) -> Result<(), Missed> {
    let [[xx, xy, _], [yx, yy, _], _] = part.pose().rotation();
    for (place, &[x_mm, y_mm]) in places.iter_mut().zip(machine_mm) {
        let mut found = false;
        for _ in 0..MAX_STEPS {
            let Some(point) = part.point_mm(place[0], place[1]) else { break };
            let (dx, dy) = (x_mm - point[0], y_mm - point[1]);
            if dx.hypot(dy) < MISS_MM {
                found = true;
                break;
            }
            place[0] += xx * dx + yx * dy;
            place[1] += xy * dx + yy * dy;
        }
        if !found {
            return Err(Missed::At([x_mm, y_mm]));
        }
    }
    Ok(())
}

/// A miss of which the effect on z is below any rounding, and that f64 still tells at 100 mm.
const MISS_MM: f64 = 2e-13;
const MAX_STEPS: usize = 50;
const MM_PER_NM: f64 = 1e-6;
