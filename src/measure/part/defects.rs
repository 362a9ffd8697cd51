//! Limits of the search for defects.

use asphera_surface::defects::DefectSettings;

/// Which defects are looked for, and how many of them are told.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DefectLimits {
    /// Largest width of a defect in mm; none: twenty times the distance of the points.
    pub largest_mm: Option<f64>,
    /// How many false ones are put up with on the whole surface.
    pub false_expected: f64,
    /// Least height or depth that is listed, nm.
    pub min_height_nm: f64,
    /// How many are listed at most.
    pub listed: usize,
}

impl Default for DefectLimits {
    fn default() -> DefectLimits {
        DefectLimits {
            largest_mm: None,
            false_expected: DefectSettings::FALSE_EXPECTED,
            // What is lower is the rounding of numbers: no instrument tells a picometre.
            min_height_nm: 0.001,
            listed: LISTED,
        }
    }
}

/// Defects that are listed by default.
pub const LISTED: usize = 50;
/// The curvature of a radius of a kilometre, 1/mm.
pub const FLAT_BELOW_PER_MM: f64 = 1e-6;
