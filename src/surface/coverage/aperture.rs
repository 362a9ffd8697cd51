//! The region of the plane that is to be measured.

use std::f64::consts::PI;

use asphera_geometry::RANGE_MM;
use asphera_geometry::outline::{Outline, OutlineError};
use asphera_geometry::predicates::Place;
use thiserror::Error;

use super::border::Whereabouts;

/// A region of the x-y plane, in the frame of the points: what is to be covered by samples. Its
/// border belongs to it.
///
/// Every aperture is sound: finite, of positive area, and a polygon crosses itself nowhere.
#[derive(Clone, Debug, PartialEq)]
pub struct Aperture {
    pub(super) shape: Shape,
}

#[derive(Clone, Debug, PartialEq)]
pub(super) enum Shape {
    Circle { centre_mm: Place, radius_mm: f64 },
    Annulus { centre_mm: Place, inner_mm: f64, outer_mm: f64 },
    Rectangle { min_mm: Place, max_mm: Place },
    Outline(Outline),
}

/// Why an aperture is none.
#[derive(Clone, Copy, Debug, Error, PartialEq)]
pub enum ApertureError {
    /// A size that is not a positive number, or not one a mesh can have.
    #[error("aperture {name} is {value_mm:?} mm, expected a positive number up to 1e12")]
    Size {
        /// Which size.
        name: &'static str,
        /// Its value in mm.
        value_mm: f64,
    },
    /// A ring whose inner radius is not a positive number below the outer one.
    #[error("aperture ring from {inner_mm} mm to {outer_mm} mm, expected 0 < inner < outer")]
    Ring {
        /// Inner radius in mm.
        inner_mm: f64,
        /// Outer radius in mm.
        outer_mm: f64,
    },
    /// A place that is not finite, or where no mesh can be.
    #[error("aperture place ({}, {}) mm, expected finite numbers up to 1e12", .at_mm[0], .at_mm[1])]
    Place {
        /// The place in mm.
        at_mm: [f64; 2],
    },
    /// Closed lines that are no region.
    #[error("outline of the aperture: {0}")]
    Outline(#[from] OutlineError),
}

impl Aperture {
    /// A disc.
    ///
    /// # Errors
    ///
    /// When the radius is not positive or something is not finite.
    pub fn circle(centre_mm: [f64; 2], radius_mm: f64) -> Result<Aperture, ApertureError> {
        admitted(centre_mm)?;
        positive("radius", radius_mm)?;
        Ok(Aperture { shape: Shape::Circle { centre_mm, radius_mm } })
    }

    /// A disc without a smaller disc about the same centre.
    ///
    /// # Errors
    ///
    /// When the radii are not 0 < inner < outer or something is not finite.
    pub fn annulus(
        centre_mm: [f64; 2],
        inner_mm: f64,
        outer_mm: f64,
    ) -> Result<Aperture, ApertureError> {
        admitted(centre_mm)?;
        positive("outer radius", outer_mm)?;
        if inner_mm > 0.0 && inner_mm < outer_mm {
            Ok(Aperture { shape: Shape::Annulus { centre_mm, inner_mm, outer_mm } })
        } else {
            Err(ApertureError::Ring { inner_mm, outer_mm })
        }
    }

    /// A rectangle with sides along x and y.
    ///
    /// # Errors
    ///
    /// When a size is not positive or something is not finite.
    pub fn rectangle(
        centre_mm: [f64; 2],
        width_mm: f64,
        height_mm: f64,
    ) -> Result<Aperture, ApertureError> {
        admitted(centre_mm)?;
        positive("width", width_mm)?;
        positive("height", height_mm)?;
        let [x, y] = centre_mm;
        let min_mm = [x - 0.5 * width_mm, y - 0.5 * height_mm];
        let max_mm = [x + 0.5 * width_mm, y + 0.5 * height_mm];
        // Far from the origin a small rectangle has no size any more.
        for (name, axis, value_mm) in [("width", 0, width_mm), ("height", 1, height_mm)] {
            if min_mm[axis] >= max_mm[axis] {
                return Err(ApertureError::Size { name, value_mm });
            }
        }
        Ok(Aperture { shape: Shape::Rectangle { min_mm, max_mm } })
    }

    /// A polygon with holes, as [`Outline::new`] takes them.
    ///
    /// # Errors
    ///
    /// When the lines are no region.
    pub fn polygon(
        outline_mm: &[[f64; 2]],
        holes_mm: &[Vec<[f64; 2]>],
    ) -> Result<Aperture, ApertureError> {
        Ok(Aperture { shape: Shape::Outline(Outline::new(outline_mm, holes_mm)?) })
    }

    /// Its area in mm².
    pub fn area_mm2(&self) -> f64 {
        match &self.shape {
            Shape::Circle { radius_mm, .. } => PI * radius_mm * radius_mm,
            Shape::Annulus { inner_mm, outer_mm, .. } => {
                PI * (outer_mm - inner_mm) * (outer_mm + inner_mm)
            }
            Shape::Rectangle { min_mm, max_mm } => {
                (max_mm[0] - min_mm[0]) * (max_mm[1] - min_mm[1])
            }
            Shape::Outline(outline) => outline.area_mm2(),
        }
    }

    /// Whether a place, in mm, belongs to it. NaN belongs to none. Takes time in proportion to the
    /// sides of a polygon at its height.
    pub fn contains(&self, at_mm: [f64; 2]) -> bool {
        let distance_mm = |centre: Place| (at_mm[0] - centre[0]).hypot(at_mm[1] - centre[1]);
        match &self.shape {
            Shape::Circle { centre_mm, radius_mm } => distance_mm(*centre_mm) <= *radius_mm,
            Shape::Annulus { centre_mm, inner_mm, outer_mm } => {
                (*inner_mm..=*outer_mm).contains(&distance_mm(*centre_mm))
            }
            Shape::Rectangle { min_mm, max_mm } => {
                (0..2).all(|axis| (min_mm[axis]..=max_mm[axis]).contains(&at_mm[axis]))
            }
            Shape::Outline(outline) => outline.contains(at_mm),
        }
    }

    /// Where all lies that is no farther from a place than `reach_mm`; near, too, where that would take
    /// a look at many sides.
    pub(super) fn whereabouts_about(&self, at_mm: Place, reach_mm: f64) -> Whereabouts {
        // A disc is told by the distance from its rim, positive inside; rounding is left to those who look closer.
        let inside_by = |by_mm: f64, size_mm: f64| {
            let reach_mm = reach_mm + ROUNDING * (size_mm + at_mm[0].abs().max(at_mm[1].abs()));
            if by_mm >= reach_mm {
                Whereabouts::Inside
            } else if by_mm <= -reach_mm {
                Whereabouts::Outside
            } else {
                Whereabouts::Near
            }
        };
        let distance_mm = |[x, y]: Place| {
            let (x, y) = (at_mm[0] - x, at_mm[1] - y);
            (x * x + y * y).sqrt()
        };
        match &self.shape {
            Shape::Circle { centre_mm, radius_mm } => {
                inside_by(radius_mm - distance_mm(*centre_mm), *radius_mm)
            }
            Shape::Annulus { centre_mm, inner_mm, outer_mm } => {
                let distance_mm = distance_mm(*centre_mm);
                inside_by((outer_mm - distance_mm).min(distance_mm - inner_mm), *outer_mm)
            }
            Shape::Rectangle { min_mm: [left, low], max_mm: [right, high] } => {
                let [x, y] = at_mm;
                let by_mm = (x - left).min(right - x).min(y - low).min(high - y);
                inside_by(by_mm, left.abs().max(right.abs()).max(low.abs()).max(high.abs()))
            }
            Shape::Outline(_) => Whereabouts::Near,
        }
    }

    /// The smallest and the largest x and y in mm.
    pub fn bounds_mm(&self) -> [[f64; 2]; 2] {
        match &self.shape {
            Shape::Circle { centre_mm: [x, y], radius_mm: r }
            | Shape::Annulus { centre_mm: [x, y], outer_mm: r, .. } => {
                [[x - r, y - r], [x + r, y + r]]
            }
            Shape::Rectangle { min_mm, max_mm } => [*min_mm, *max_mm],
            Shape::Outline(outline) => outline.bounds_mm(),
        }
    }
}

/// Distances are told to this share of the coordinates at least.
const ROUNDING: f64 = 1e-12;

fn admitted(at_mm: Place) -> Result<(), ApertureError> {
    if at_mm.iter().all(|mm| mm.abs() <= RANGE_MM) {
        Ok(())
    } else {
        Err(ApertureError::Place { at_mm })
    }
}

fn positive(name: &'static str, value_mm: f64) -> Result<(), ApertureError> {
    if value_mm > 0.0 && value_mm <= RANGE_MM {
        Ok(())
    } else {
        Err(ApertureError::Size { name, value_mm })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn square(low: f64, high: f64) -> Vec<Place> {
        vec![[low, low], [high, low], [high, high], [low, high]]
    }

    #[test]
    fn what_is_about_a_place_is_told_by_the_border() {
        let apertures = [
            Aperture::circle([3.0, -1.0], 2.0).unwrap(),
            Aperture::annulus([3.0, -1.0], 1.0, 2.0).unwrap(),
            Aperture::rectangle([3.0, -1.0], 4.0, 3.0).unwrap(),
        ];
        for aperture in apertures {
            let mut seen = [0; 3];
            for (i, j) in (0..100).flat_map(|i| (0..100).map(move |j| (i, j))) {
                let at = [0.5 + 0.05 * f64::from(i), -3.5 + 0.05 * f64::from(j)];
                let whereabouts = aperture.whereabouts_about(at, 0.1);
                seen[whereabouts as usize] += 1;
                let inside = (0..16).filter(|step| {
                    let (sin, cos) = (f64::from(*step) * PI / 8.0).sin_cos();
                    aperture.contains([at[0] + 0.1 * cos, at[1] + 0.1 * sin])
                });
                match (whereabouts, inside.count()) {
                    (Whereabouts::Inside, 16)
                    | (Whereabouts::Outside, 0)
                    | (Whereabouts::Near, _) => {}
                    other => panic!("{other:?} about {at:?} of {aperture:?}"),
                }
            }
            let clear = seen[Whereabouts::Near as usize] < 2_800;
            assert!(clear && seen.iter().all(|&count| count > 500), "{seen:?}");
        }
        let polygon = Aperture::polygon(&square(0.0, 4.0), &[]).unwrap();
        assert_eq!(polygon.whereabouts_about([2.0; 2], 0.1), Whereabouts::Near);
    }

    #[test]
    fn areas_and_borders() {
        let circle = Aperture::circle([1.0, -2.0], 5.0).unwrap();
        assert!((circle.area_mm2() - 78.539_816_339_744_83).abs() < 1e-13);
        assert!(circle.contains([4.0, 2.0]) && !circle.contains([4.0, 2.000_001]));
        assert_eq!(circle.bounds_mm(), [[-4.0, -7.0], [6.0, 3.0]]);
        let ring = Aperture::annulus([0.0; 2], 3.0, 5.0).unwrap();
        assert!((ring.area_mm2() - 50.265_482_457_436_69).abs() < 1e-13);
        assert!(ring.contains([0.0, 3.0]) && ring.contains([-5.0, 0.0]));
        assert!(!ring.contains([1.0, 1.0]));
        let rectangle = Aperture::rectangle([1.0, 1.0], 4.0, 2.0).unwrap();
        assert_eq!((rectangle.area_mm2(), rectangle.bounds_mm()), (8.0, [[-1.0, 0.0], [3.0, 2.0]]));
        assert!(rectangle.contains([-1.0, 2.0]) && !rectangle.contains([1.0, 2.1]));
        for place in [[f64::NAN, 0.0], [0.0, f64::INFINITY]] {
            assert!(![&circle, &ring, &rectangle].iter().any(|it| it.contains(place)));
        }
    }

    #[test]
    fn a_polygon_may_turn_either_way_and_be_closed_or_not() {
        let mut expected = None;
        for turned in [false, true] {
            let (mut outline, mut hole) = (square(0.0, 4.0), square(1.0, 3.0));
            if turned {
                outline.reverse();
                outline.push(outline[0]);
                hole.reverse();
            }
            let polygon = Aperture::polygon(&outline, &[hole]).unwrap();
            assert_eq!(polygon.area_mm2(), 12.0);
            for (place, inside) in [
                ([0.5, 2.0], true),
                ([2.0, 2.0], false),
                ([1.0, 2.0], true),
                ([4.0, 4.0], true),
                ([2.0, 4.0], true),
                ([2.0, 4.1], false),
                ([f64::NAN, 1.0], false),
            ] {
                assert_eq!(polygon.contains(place), inside, "{place:?}");
            }
            assert_eq!(*expected.get_or_insert(polygon.bounds_mm()), [[0.0; 2], [4.0; 2]]);
        }
    }

    #[test]
    fn what_is_no_aperture() {
        for bad in [0.0, -1.0, f64::NAN, f64::INFINITY, 1e13] {
            assert!(matches!(Aperture::circle([0.0; 2], bad), Err(ApertureError::Size { .. })));
            assert!(Aperture::rectangle([0.0; 2], 1.0, bad).is_err());
            assert!(Aperture::rectangle([0.0; 2], bad, 1.0).is_err());
            assert!(Aperture::annulus([0.0; 2], 1.0, bad).is_err());
        }
        assert!(Aperture::rectangle([1e12, 0.0], 1e-9, 1.0).is_err());
        for inner_mm in [0.0, -1.0, 2.0, 3.0, f64::NAN] {
            let found = Aperture::annulus([0.0; 2], inner_mm, 2.0);
            assert!(matches!(found, Err(ApertureError::Ring { .. })));
        }
        let place = Aperture::circle([f64::NAN, 0.0], 1.0);
        assert!(matches!(place, Err(ApertureError::Place { .. })));
        let outline = Aperture::polygon(&square(0.0, 4.0), &[square(5.0, 6.0)]);
        assert_eq!(
            outline.expect_err("it is none").to_string(),
            "outline of the aperture: hole 1 does not lie inside the outline"
        );
    }
}
