//! The origin of the part frame, from which places, rings, Zernike terms and slopes along the meridian count.
//!
//! A surface with a vertex has it there, or in the middle of an aperture that lies beside the vertex. A surface that slides
//! (a plane; a cylinder along its axis, see [`asphera_form::Nominal::slides`]) has no place of its own, and the fit leaves
//! it where it starts: in the middle of the aperture, or of the points where there is no aperture. So figures of a map do
//! not depend on where its file counts from.

use asphera_form::{Aperture, Fit, Parameter, Pose, middle_mm};
use asphera_geometry::PointMm;
use asphera_report::OriginFigures;

use crate::Part;

/// Where the fit of a part begins; `middle_mm` is asked only where nothing but the points says where their middle is.
pub(super) fn start(part: &Part, middle_mm: impl FnOnce() -> [f64; 2]) -> Pose {
    let slides = part.nominal.slides();
    if part.reference.is_some() || slides == [false; 2] {
        return Pose::default();
    }
    let [x_mm, y_mm] = match part.aperture {
        Aperture::None => middle_mm(),
        _ => part.centre_mm,
    };
    // A shift that is held, and that moves the surface, stays as it is.
    let laid = |axis: usize, parameter: Parameter, at_mm: f64| {
        if slides[axis] || part.free.contains(&parameter) { at_mm } else { 0.0 }
    };
    Pose {
        tx_mm: laid(0, Parameter::Tx, x_mm),
        ty_mm: laid(1, Parameter::Ty, y_mm),
        ..Pose::default()
    }
}

/// As [`start`], of all points.
pub(super) fn start_of(part: &Part, points: &[PointMm]) -> Pose {
    start(part, || {
        let places_mm: Vec<[f64; 2]> = points.iter().map(|&[x, y, _]| [x, y]).collect();
        middle_mm(&places_mm).unwrap_or_default()
    })
}

/// The pose of a fit with its origin moved along the axis of a cylinder so far that the shift along it is that of `start`;
/// `None` where it is. A fit
/// that turned the part, or looked for it elsewhere, left it aside.
pub(super) fn moved_along(part: &Part, fit: &Fit, start: &Pose) -> Option<Pose> {
    let axis = match part.nominal.slides() {
        [true, false] => 0,
        [false, true] => 1,
        _ => return None,
    };
    let axis_to = |along_mm: f64| {
        let mut at_mm = [0.0; 3];
        at_mm[axis] = along_mm;
        fit.pose.to_measured(at_mm)
    };
    let lies_mm = [fit.pose.tx_mm, fit.pose.ty_mm, fit.pose.tz_mm];
    let [wanted_mm, there_mm] = [[start.tx_mm, start.ty_mm], [lies_mm[0], lies_mm[1]]];
    let along = axis_to(1.0)[axis] - lies_mm[axis];
    let aside_mm = if along.abs() > ACROSS {
        (wanted_mm[axis] - there_mm[axis]) / along
    } else {
        // A part that was turned by a quarter: the place of its axis next to the start.
        fit.pose.to_part([wanted_mm[0], wanted_mm[1], fit.pose.tz_mm])[axis]
    };
    let [tx_mm, ty_mm, tz_mm] = axis_to(aside_mm);
    (aside_mm.abs() > ASIDE_MM).then_some(Pose { tx_mm, ty_mm, tz_mm, ..fit.pose })
}

/// Origin of a part; `at_mm` is where it lies in the measured frame.
pub(super) fn figures(part: &Part, at_mm: PointMm) -> OriginFigures {
    let has_vertex = part.reference.is_none() && part.nominal.slides() == [false; 2];
    let place = match part.aperture {
        _ if has_vertex && part.centre_mm == [0.0; 2] => OriginFigures::VERTEX,
        Aperture::None => OriginFigures::MIDDLE_OF_POINTS,
        _ => OriginFigures::MIDDLE_OF_APERTURE,
    };
    OriginFigures { place: place.to_owned(), at_mm }
}

/// An axis of a cylinder that goes less along the direction it started in has another.
const ACROSS: f64 = 0.5;
/// A shorter way is rounding.
const ASIDE_MM: f64 = 1e-9;

#[cfg(test)]
mod tests;
