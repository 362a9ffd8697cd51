//! The plane of a section as a word of the command line.

use std::path::Path;
use std::str::FromStr;

use asphera_contour::PlaceMm;
use asphera_geometry::PointMm;
use asphera_surface::Plane;

use crate::cli::output::Failure;
use crate::contour::{Slab, plane_of};

/// A plane as a word of the command line: `a,b,c,d` of a·x + b·y + c·z = d, lengths in mm.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Cutting(Plane);

impl FromStr for Cutting {
    type Err = String;

    fn from_str(word: &str) -> Result<Cutting, String> {
        let expected = || {
            format!(
                "expected a,b,c,d of the plane a·x + b·y + c·z = d in mm, as 0,0,1,5; found {word:?}"
            )
        };
        let numbers: Option<Vec<f64>> =
            word.split(',').map(|number| number.trim().parse().ok()).collect();
        let numbers: Option<[f64; 4]> = numbers.and_then(|numbers| numbers.try_into().ok());
        numbers.and_then(plane_of).map(Cutting).ok_or_else(expected)
    }
}

impl Cutting {
    /// What lies so near to the plane.
    pub(super) fn slab(self, within_mm: f64) -> Slab {
        Slab { plane: self.0, within_mm }
    }
}

/// The places in the plane of points that are near enough; u and v are x and y where the plane is z = d.
///
/// # Errors
///
/// Where there is none: how far the nearest point is.
pub(super) fn cut(
    slab: &Slab,
    path: &Path,
    points: impl Iterator<Item = PointMm>,
) -> Result<Vec<PlaceMm>, Failure> {
    let within_mm = slab.within_mm;
    slab.places(points).map_err(|nearest_mm| {
        format!(
            "{}: expected points within {within_mm} mm of the plane, found the nearest {nearest_mm:.4} mm off; give another --plane or a larger --within",
            path.display()
        )
        .into()
    })
}
