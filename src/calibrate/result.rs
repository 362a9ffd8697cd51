//! What a calibration found.

use crate::correction::Correction;
use crate::parameter::Parameter;

/// A parameter of the machine.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Estimate {
    /// Which.
    pub parameter: Parameter,
    /// Its value: a ratio, rad or mm.
    pub value: f64,
    /// Standard uncertainty, in the same unit.
    pub u: f64,
}

/// A term of a map of height or of the artefact's form, of unit RMS over the disc.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Term {
    /// Radial order.
    pub n: u32,
    /// Azimuthal order.
    pub m: i32,
    /// Coefficient in mm.
    pub value_mm: f64,
    /// Standard uncertainty in mm.
    pub u_mm: f64,
}

/// Errors of a machine, and form of the artefact.
///
/// Uncertainties count what the residuals show, correlated from point to point as they are found to be, and the
/// uncertainty of the radius. They do not count errors of the machine or the artefact beyond the parameters and terms.
#[derive(Clone, Debug, PartialEq)]
pub struct Calibration {
    /// What takes the errors out of later points.
    pub correction: Correction,
    /// Parameters that were found, in the order of the machine.
    pub parameters: Vec<Estimate>,
    /// Covariances of the parameters, row after row.
    pub covariance: Vec<f64>,
    /// Parameters that these points do not determine; they are 0 in the correction.
    pub undetermined: Vec<Parameter>,
    /// Errors of height of the machine.
    pub map: Vec<Term>,
    /// Orders of height errors that are not determined.
    pub map_undetermined: Vec<(u32, i32)>,
    /// Form of the artefact, in its own frame: that of the first pose. Positive towards +z.
    pub form: Vec<Term>,
    /// Orders of the form that cannot be told from the machine: of turns alone those of revolution.
    pub form_undetermined: Vec<(u32, i32)>,
    /// Radius of the disc of the form's terms, mm.
    pub form_radius_mm: f64,
    /// Root mean square of the form over the disc by its terms, mm, and its standard uncertainty.
    pub form_rms_mm: Option<[f64; 2]>,
    /// Radius that the points and the certificate give together, mm, and its standard uncertainty; of a sphere whose
    /// radius has one.
    pub radius_mm: Option<[f64; 2]>,
    /// Centres of the sphere, mm, or heights above the origin and the two slopes of the flat.
    pub places: Vec<[f64; 3]>,
    /// Root mean square of the residuals before any correction, mm.
    pub before_mm: f64,
    /// The same after.
    pub after_mm: f64,
    /// Factor by which correlated residuals make variances larger, 1 for independent ones.
    pub inflation: f64,
    /// Points in all.
    pub points: usize,
}
