//! Artefacts of known shape, and how they were measured.

use crate::correction::Axes;
use crate::parameter::Parameter;

/// Artefact whose shape is known but for its form error.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Artefact {
    /// A sphere or a cap of one, seen from outside or inside.
    Sphere {
        /// Radius by its certificate, mm.
        radius_mm: f64,
        /// Standard uncertainty of that radius, mm; 0 where it is exact.
        u_radius_mm: f64,
    },
    /// A flat.
    Flat,
}

/// One measurement of the artefact, which is turned or shifted between two of them.
#[derive(Clone, Debug, PartialEq)]
pub struct Pose {
    /// Readings of the machine, uncorrected, in the order they were taken.
    pub axes: Vec<Axes>,
    /// Turn of the artefact against the first pose, about the axis z of the machine, rad, counter-clockwise seen from +z.
    pub turn_rad: f64,
    /// Place of the flat's origin in the machine, mm. A sphere's centre is found, and this is not used.
    pub shift_mm: [f64; 2],
}

/// What is to be found.
#[derive(Clone, Debug, PartialEq)]
pub struct Settings {
    /// Parameters of the machine; those that the points do not determine are named and stay 0.
    pub parameters: Vec<Parameter>,
    /// Highest radial order of the machine's errors of height, from 2; less for none.
    pub map_order: u32,
    /// Highest radial order of the artefact's form error, from 2; less for none. It needs two poses that differ.
    pub form_order: u32,
}

/// Highest order of maps and forms: 66 terms.
pub(crate) const HIGHEST_ORDER: u32 = 10;
