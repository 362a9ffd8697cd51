//! A probe that a rotary axis tilts about a pivot: from its readings to points in the part frame.

use asphera_calibrate::Axes;
use asphera_geometry::vector::{Vector, plus};
use asphera_link::Flags;

use super::kinematics::Axis;
use super::synchronizer::Record;

/// A probe that tilts about a pivot on linear axes, over a part that may turn.
///
/// The pivot stands at [x, y, z], mm. The probe tilts by β, rad, about the direction y through it, and its beam passes the
/// pivot at [a, b], mm. It reads d, mm, along the beam, upwards at β = 0. The part's angle is θ, rad.
///
/// ```text
/// position = R(θ) · ([x, y, z] + [a cos β + d sin β, b, d cos β − a sin β])
/// ```
///
/// R(θ) turns about z, counter-clockwise seen from +z. A positive β tilts +z towards +x.
#[derive(Clone, Debug, PartialEq)]
pub struct Tilting {
    /// Pivot along x, mm: the radial axis where the part turns.
    pub x: Axis,
    /// Pivot along y, mm.
    pub y: Axis,
    /// Pivot along z, mm.
    pub z: Axis,
    /// β, rad.
    pub tilt: Axis,
    /// d, mm.
    pub probe: Axis,
    /// θ, rad; `None` where the part does not turn.
    pub rotary: Option<Axis>,
    /// a and b, mm.
    pub pivot_offset_mm: [f64; 2],
}

/// Where the axes of a tilting probe stand.
#[derive(Clone, Copy)]
struct Stand {
    pivot_mm: Vector,
    tilt_rad: f64,
    probe_mm: f64,
}

impl Tilting {
    /// The axes, in no particular order.
    pub(super) fn axes(&self) -> Vec<&Axis> {
        let still = [&self.x, &self.y, &self.z, &self.tilt, &self.probe];
        still.into_iter().chain(&self.rotary).collect()
    }

    /// The axes of the point of a record with the standard uncertainties along x, y and z of its place, mm. What is wrong with
    /// the readings is added to `flags`.
    pub(super) fn point(&self, record: &Record, flags: &mut Flags) -> (Axes, [f64; 3]) {
        let mut value = |axis: &Axis| axis.value(record, flags);
        let stand = Stand {
            pivot_mm: [value(&self.x), value(&self.y), value(&self.z)],
            tilt_rad: value(&self.tilt),
            probe_mm: value(&self.probe),
        };
        let angle_rad = self.rotary.as_ref().map(value);
        let place_mm = self.place_mm(stand);
        let axes = match angle_rad {
            Some(angle_rad) => Axes::Turned { angle_rad, place_mm },
            None => Axes::Cartesian(place_mm),
        };
        let u_mm = if record.spreads.is_empty() {
            [0.0; 3]
        } else {
            self.spread_mm(record, stand, angle_rad.unwrap_or(0.0), axes.place_mm())
        };
        (axes, u_mm)
    }

    /// Unit vector along the beam at a record, upwards at β = 0, in the part frame.
    pub(super) fn up(&self, record: &Record) -> Vector {
        let value = |axis: &Axis| axis.value(record, &mut Flags::empty());
        let tilt_rad = value(&self.tilt);
        let angle_rad = self.rotary.as_ref().map_or(0.0, value);
        Axes::Turned { angle_rad, place_mm: [tilt_rad.sin(), 0.0, tilt_rad.cos()] }.place_mm()
    }

    /// The place before the turn of the part, mm.
    fn place_mm(&self, stand: Stand) -> Vector {
        let [a, b] = self.pivot_offset_mm;
        let (sin, cos) = stand.tilt_rad.sin_cos();
        let d = stand.probe_mm;
        plus(stand.pivot_mm, 1.0, [a * cos + d * sin, b, d * cos - a * sin])
    }

    /// Standard uncertainties along x, y and z of a record that was joined by time. All axes have one error of time, so what
    /// each adds to a coordinate adds up.
    fn spread_mm(&self, record: &Record, stand: Stand, angle_rad: f64, place_mm: Vector) -> Vector {
        let (sin, cos) = stand.tilt_rad.sin_cos();
        let ([a, _], d) = (self.pivot_offset_mm, stand.probe_mm);
        let moves = [
            (&self.x, [1.0, 0.0, 0.0]),
            (&self.y, [0.0, 1.0, 0.0]),
            (&self.z, [0.0, 0.0, 1.0]),
            (&self.tilt, [d * cos - a * sin, 0.0, -d * sin - a * cos]),
            (&self.probe, [sin, 0.0, cos]),
        ];
        let (sin, cos) = angle_rad.sin_cos();
        let turned =
            moves.map(|(axis, [x, y, z])| (axis, [x * cos - y * sin, x * sin + y * cos, z]));
        let turn = self.rotary.iter().map(|rotary| (rotary, [-place_mm[1], place_mm[0], 0.0]));
        turned.into_iter().chain(turn).fold([0.0; 3], |sum, (axis, along)| {
            plus(sum, axis.spread(record), along.map(f64::abs))
        })
    }
}

#[cfg(test)]
mod tests;
