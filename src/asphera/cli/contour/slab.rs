//! The points of a body near a plane, as its section there.

use std::path::Path;
use std::str::FromStr;

use asphera_contour::PlaceMm;
use asphera_geometry::PointMm;
use asphera_surface::Plane;

use crate::cli::output::Failure;

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
        let [a, b, c, d] = numbers.ok_or_else(expected)?;
        let share = d / (a * a + b * b + c * c);
        Plane::new([a, b, c].map(|it| share * it), [a, b, c]).map(Cutting).map_err(|_| expected())
    }
}

impl Cutting {
    /// The places in the plane of points not farther from it than `within_mm`; u and v are x and y where the plane is z = d.
    ///
    /// # Errors
    ///
    /// Where there is none: how far the nearest point is.
    pub(super) fn places(
        self,
        path: &Path,
        points: impl Iterator<Item = PointMm>,
        within_mm: f64,
    ) -> Result<Vec<PlaceMm>, Failure> {
        let mut nearest_mm = f64::INFINITY;
        let mut places = Vec::new();
        for point in points {
            let [u, v, w] = self.0.to_plane(point);
            nearest_mm = nearest_mm.min(w.abs());
            if w.abs() <= within_mm {
                places.push([u, v]);
            }
        }
        if places.is_empty() && nearest_mm.is_finite() {
            return Err(format!(
                "{}: expected points within {within_mm} mm of the plane, found the nearest {nearest_mm:.4} mm off; give another --plane or a larger --within",
                path.display()
            )
            .into());
        }
        Ok(places)
    }
}
