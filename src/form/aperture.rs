//! The region of the part that counts.

use std::f64::consts::PI;
use std::sync::Arc;

use asphera_geometry::outline::Outline;
use thiserror::Error;

/// A region of the x-y plane of the part frame. The border belongs to it.
#[derive(Clone, Debug, Default, PartialEq)]
pub enum Aperture {
    /// Every point counts.
    #[default]
    None,
    /// A disc about the vertex.
    Circle {
        /// Radius in mm.
        radius_mm: f64,
    },
    /// A rectangle centred on the vertex.
    Rectangle {
        /// Size along x in mm.
        width_mm: f64,
        /// Size along y in mm.
        height_mm: f64,
    },
    /// A ring about the vertex.
    Annulus {
        /// Inner radius in mm.
        inner_mm: f64,
        /// Outer radius in mm.
        outer_mm: f64,
    },
    /// A region with straight sides, places from the vertex.
    Outline {
        /// The region.
        outline: Arc<Outline>,
        /// Distance in mm by which its edges lie further inside, negative further out.
        inset_mm: f64,
    },
}

/// Why an aperture is none.
#[derive(Clone, Copy, Debug, Error, PartialEq)]
pub enum ApertureError {
    /// A size that is not a positive finite number.
    #[error("aperture {name} is {value_mm:?} mm, expected a positive number")]
    Size {
        /// Which size.
        name: &'static str,
        /// Its value in mm.
        value_mm: f64,
    },
    /// A ring whose inner radius is negative or not below the outer one.
    #[error("aperture ring from {inner_mm} mm to {outer_mm} mm is empty")]
    Ring {
        /// Inner radius in mm.
        inner_mm: f64,
        /// Outer radius in mm.
        outer_mm: f64,
    },
    /// An outline whose edges were moved so far in that nothing is left.
    #[error("nothing is left of the aperture {inset_mm} mm inside its outline")]
    Inset {
        /// Distance of the edges from the outline in mm.
        inset_mm: f64,
    },
}

impl Aperture {
    /// The region that an outline encloses.
    pub fn of_outline(outline: Outline) -> Aperture {
        Aperture::Outline { outline: Arc::new(outline), inset_mm: 0.0 }
    }

    /// Fails unless every size is positive and finite and a ring is not empty. An inner radius of 0 is
    /// allowed.
    pub fn validate(&self) -> Result<(), ApertureError> {
        let positive = |name, value_mm: f64| {
            if value_mm.is_finite() && value_mm > 0.0 {
                Ok(())
            } else {
                Err(ApertureError::Size { name, value_mm })
            }
        };
        match *self {
            Aperture::None => Ok(()),
            Aperture::Outline { ref outline, inset_mm } if inset_mm < half_width_mm(outline) => {
                Ok(())
            }
            Aperture::Outline { inset_mm, .. } => Err(ApertureError::Inset { inset_mm }),
            Aperture::Circle { radius_mm } => positive("radius", radius_mm),
            Aperture::Rectangle { width_mm, height_mm } => {
                positive("width", width_mm).and_then(|()| positive("height", height_mm))
            }
            Aperture::Annulus { inner_mm, outer_mm } => {
                positive("outer radius", outer_mm)?;
                if inner_mm >= 0.0 && inner_mm < outer_mm {
                    Ok(())
                } else {
                    Err(ApertureError::Ring { inner_mm, outer_mm })
                }
            }
        }
    }

    /// Whether the place (x, y) of the part frame, in mm, belongs to it. NaN belongs only to
    /// [`Aperture::None`].
    pub fn contains(&self, x_mm: f64, y_mm: f64) -> bool {
        match *self {
            Aperture::None => true,
            Aperture::Circle { radius_mm } => x_mm.hypot(y_mm) <= radius_mm,
            Aperture::Rectangle { width_mm, height_mm } => {
                x_mm.abs() <= 0.5 * width_mm && y_mm.abs() <= 0.5 * height_mm
            }
            Aperture::Annulus { inner_mm, outer_mm } => {
                let r_mm = x_mm.hypot(y_mm);
                r_mm >= inner_mm && r_mm <= outer_mm
            }
            Aperture::Outline { ref outline, inset_mm } => {
                let at_mm = [x_mm, y_mm];
                let is_inside = outline.contains(at_mm);
                if inset_mm > 0.0 {
                    is_inside && !outline.passes_within(at_mm, inset_mm)
                } else {
                    is_inside || (inset_mm < 0.0 && outline.passes_within(at_mm, -inset_mm))
                }
            }
        }
    }

    /// The aperture whose edges lie further inside by `by_mm`; none where nothing would be left of it, and of
    /// [`Aperture::None`].
    pub fn narrowed(&self, by_mm: f64) -> Option<Aperture> {
        let narrower = self.widened(-by_mm);
        (narrower != Aperture::None && narrower.validate().is_ok()).then_some(narrower)
    }

    /// The aperture whose edges lie further out by `by_mm`, further inside where that is negative; a hole ends at nothing.
    /// The corners of an outline become round.
    #[must_use]
    pub fn widened(&self, by_mm: f64) -> Aperture {
        match *self {
            Aperture::None => Aperture::None,
            Aperture::Circle { radius_mm } => Aperture::Circle { radius_mm: radius_mm + by_mm },
            Aperture::Rectangle { width_mm, height_mm } => Aperture::Rectangle {
                width_mm: width_mm + 2.0 * by_mm,
                height_mm: height_mm + 2.0 * by_mm,
            },
            // A disc has no inner edge.
            Aperture::Annulus { inner_mm, outer_mm } => Aperture::Annulus {
                inner_mm: if inner_mm > 0.0 { (inner_mm - by_mm).max(0.0) } else { 0.0 },
                outer_mm: outer_mm + by_mm,
            },
            Aperture::Outline { ref outline, inset_mm } => {
                Aperture::Outline { outline: Arc::clone(outline), inset_mm: inset_mm - by_mm }
            }
        }
    }

    /// The aperture without its holes.
    #[must_use]
    pub fn filled(&self) -> Aperture {
        match self {
            Aperture::Annulus { outer_mm, .. } => Aperture::Circle { radius_mm: *outer_mm },
            Aperture::Outline { outline, inset_mm } if outline.rings().len() > 1 => {
                Aperture::Outline { outline: Arc::new(outline.filled()), inset_mm: *inset_mm }
            }
            other => other.clone(),
        }
    }

    /// Half its smallest width in mm: of a ring that between its edges, of an outline its area through its border's
    /// length, which is no more; infinite for [`Aperture::None`].
    pub fn half_width_mm(&self) -> f64 {
        match *self {
            Aperture::None => f64::INFINITY,
            Aperture::Circle { radius_mm } => radius_mm,
            Aperture::Rectangle { width_mm, height_mm } => 0.5 * width_mm.min(height_mm),
            Aperture::Annulus { inner_mm, outer_mm } => 0.5 * (outer_mm - inner_mm),
            Aperture::Outline { ref outline, inset_mm } => half_width_mm(outline) - inset_mm,
        }
    }

    /// Half the sides, along x and y in mm, of the smallest box about the vertex that holds it; `None` for
    /// [`Aperture::None`].
    pub fn half_extents_mm(&self) -> Option<[f64; 2]> {
        match *self {
            Aperture::None => None,
            Aperture::Circle { radius_mm } | Aperture::Annulus { outer_mm: radius_mm, .. } => {
                Some([radius_mm; 2])
            }
            Aperture::Rectangle { width_mm, height_mm } => Some([0.5 * width_mm, 0.5 * height_mm]),
            Aperture::Outline { ref outline, inset_mm } => {
                let [low, high] = outline.bounds_mm();
                Some([0, 1].map(|axis| high[axis].max(-low[axis]) - inset_mm))
            }
        }
    }

    /// The largest distance of a place of it from the vertex in mm, of an outline moved inside no less than that; `None`
    /// for [`Aperture::None`].
    pub fn reach_mm(&self) -> Option<f64> {
        match *self {
            Aperture::None => None,
            Aperture::Circle { radius_mm } | Aperture::Annulus { outer_mm: radius_mm, .. } => {
                Some(radius_mm)
            }
            Aperture::Rectangle { width_mm, height_mm } => Some(0.5 * width_mm.hypot(height_mm)),
            Aperture::Outline { ref outline, inset_mm } => {
                let corners = outline.rings()[0].iter();
                Some(corners.map(|[x, y]| x.hypot(*y)).fold(0.0, f64::max) - inset_mm)
            }
        }
    }

    /// The smallest distance of a place of it from the vertex in mm.
    pub fn hole_mm(&self) -> f64 {
        match *self {
            Aperture::None | Aperture::Circle { .. } | Aperture::Rectangle { .. } => 0.0,
            Aperture::Annulus { inner_mm, .. } => inner_mm,
            Aperture::Outline { ref outline, inset_mm } => {
                if outline.contains([0.0; 2]) {
                    return 0.0;
                }
                let [x, y] = outline.nearest_mm([0.0; 2]);
                (x.hypot(y) + inset_mm).max(0.0)
            }
        }
    }

    /// Whether its edges are circles about the vertex.
    pub fn is_round(&self) -> bool {
        matches!(self, Aperture::Circle { .. } | Aperture::Annulus { .. })
    }

    /// Projected area in mm²; infinite for [`Aperture::None`]. Of an outline with its edges moved, to first order.
    pub fn area_mm2(&self) -> f64 {
        match *self {
            Aperture::None => f64::INFINITY,
            Aperture::Circle { radius_mm } => PI * radius_mm * radius_mm,
            Aperture::Rectangle { width_mm, height_mm } => width_mm * height_mm,
            Aperture::Annulus { inner_mm, outer_mm } => {
                PI * (outer_mm - inner_mm) * (outer_mm + inner_mm)
            }
            Aperture::Outline { ref outline, inset_mm } => {
                outline.area_mm2() - inset_mm * outline.perimeter_mm()
            }
        }
    }
}

/// At most half the width of a region: no place of it is nearer to all of its border.
fn half_width_mm(outline: &Outline) -> f64 {
    outline.area_mm2() / outline.perimeter_mm()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_narrower_one_lies_inside() {
        let ring = Aperture::Annulus { inner_mm: 2.0, outer_mm: 5.0 };
        assert_eq!(ring.narrowed(0.5), Some(Aperture::Annulus { inner_mm: 2.5, outer_mm: 4.5 }));
        assert_eq!((ring.narrowed(1.5), ring.half_width_mm()), (None, 1.5));
        let disc = Aperture::Annulus { inner_mm: 0.0, outer_mm: 5.0 };
        assert!(disc.narrowed(0.5).is_some_and(|disc| disc.contains(0.0, 0.0)));
        let rectangle = Aperture::Rectangle { width_mm: 4.0, height_mm: 2.0 };
        assert!(
            rectangle
                .narrowed(0.5)
                .is_some_and(|inner| inner.contains(1.5, 0.5) && !inner.contains(1.6, 0.5))
        );
        assert_eq!((rectangle.narrowed(1.0), Aperture::None.narrowed(1.0)), (None, None));
        assert_eq!(Aperture::Circle { radius_mm: 1.0 }.narrowed(2.0), None);
    }

    #[test]
    fn borders_belong_and_the_area_is_right() {
        let circle = Aperture::Circle { radius_mm: 5.0 };
        assert!(circle.contains(3.0, 4.0) && !circle.contains(3.0, 4.000_001));
        assert!((circle.area_mm2() - 78.539_816_339_744_83).abs() < 1e-13);
        let rectangle = Aperture::Rectangle { width_mm: 4.0, height_mm: 2.0 };
        assert!(rectangle.contains(-2.0, 1.0) && !rectangle.contains(0.0, 1.1));
        assert_eq!(rectangle.area_mm2(), 8.0);
        let ring = Aperture::Annulus { inner_mm: 3.0, outer_mm: 5.0 };
        assert!(ring.contains(0.0, 3.0) && ring.contains(0.0, -5.0) && !ring.contains(1.0, 1.0));
        assert!((ring.area_mm2() - 50.265_482_457_436_69).abs() < 1e-13);
        assert!(Aperture::None.contains(1e9, -1e9) && Aperture::None.area_mm2().is_infinite());
        assert!(!circle.contains(f64::NAN, 0.0));
    }

    #[test]
    fn an_outline_is_the_rectangle_it_draws() {
        let rectangle = Aperture::Rectangle { width_mm: 4.0, height_mm: 2.0 };
        let corners = [[-2.0, -1.0], [2.0, -1.0], [2.0, 1.0], [-2.0, 1.0]];
        let outline = Aperture::of_outline(Outline::new(&corners, &[]).unwrap());
        for by_mm in [0.0, 0.25, -0.25] {
            let (plain, drawn) = (rectangle.widened(-by_mm), outline.widened(-by_mm));
            assert_eq!(plain.half_extents_mm(), drawn.half_extents_mm());
            for step in 0..=60_i32 {
                // Along both axes: corners are round.
                let at = 0.05 * f64::from(step) + 0.01;
                assert_eq!(plain.contains(at, 0.0), drawn.contains(at, 0.0), "{at} {by_mm}");
                assert_eq!(plain.contains(0.0, -at), drawn.contains(0.0, -at), "{at} {by_mm}");
            }
        }
        assert_eq!((outline.area_mm2(), outline.hole_mm()), (8.0, 0.0));
        assert_eq!(outline.reach_mm(), rectangle.reach_mm());
        assert_eq!((outline.narrowed(0.5).is_some(), outline.narrowed(0.7)), (true, None));
    }

    #[test]
    fn an_outline_beside_the_vertex_has_its_hole_there() {
        let corners = [[3.0, -1.0], [5.0, -1.0], [5.0, 1.0], [3.0, 1.0]];
        let outline = Aperture::of_outline(Outline::new(&corners, &[]).unwrap());
        assert_eq!((outline.hole_mm(), outline.half_extents_mm()), (3.0, Some([5.0, 1.0])));
        let hole = vec![[3.5, -0.5], [4.5, -0.5], [4.0, 0.5]];
        let pierced = Aperture::of_outline(Outline::new(&corners, &[hole]).unwrap());
        assert!(!pierced.contains(4.0, 0.0) && pierced.filled().contains(4.0, 0.0));
        assert_eq!((pierced.area_mm2(), pierced.filled().area_mm2()), (3.5, 4.0));
    }

    #[test]
    fn impossible_sizes_are_refused() {
        for size in [0.0, -1.0, f64::NAN, f64::INFINITY] {
            assert!(Aperture::Circle { radius_mm: size }.validate().is_err());
            assert!(Aperture::Rectangle { width_mm: 1.0, height_mm: size }.validate().is_err());
            assert!(Aperture::Annulus { inner_mm: 0.0, outer_mm: size }.validate().is_err());
        }
        for inner_mm in [-1.0, 2.0, 3.0, f64::NAN] {
            assert!(Aperture::Annulus { inner_mm, outer_mm: 2.0 }.validate().is_err());
        }
        assert_eq!(Aperture::Annulus { inner_mm: 0.0, outer_mm: 2.0 }.validate(), Ok(()));
        assert_eq!(Aperture::None.validate(), Ok(()));
    }
}
