//! The region of the part that counts.

use std::f64::consts::PI;

use thiserror::Error;

/// A region of the x-y plane of the part frame. The border belongs to it.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
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
}

/// Why an aperture is none.
#[derive(Clone, Copy, Debug, Error, PartialEq)]
pub enum ApertureError {
    /// A size that is not a positive finite number.
    #[error("aperture {name} is {value_mm} mm, expected a positive number")]
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
}

impl Aperture {
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
        }
    }

    /// The aperture whose edges lie further inside by `by_mm`; none where nothing would be left of it, and of
    /// [`Aperture::None`].
    pub fn narrowed(&self, by_mm: f64) -> Option<Aperture> {
        let narrower = match *self {
            Aperture::None => return None,
            Aperture::Circle { radius_mm } => Aperture::Circle { radius_mm: radius_mm - by_mm },
            Aperture::Rectangle { width_mm, height_mm } => Aperture::Rectangle {
                width_mm: width_mm - 2.0 * by_mm,
                height_mm: height_mm - 2.0 * by_mm,
            },
            // A disc has no inner edge.
            Aperture::Annulus { inner_mm, outer_mm } => Aperture::Annulus {
                inner_mm: if inner_mm > 0.0 { inner_mm + by_mm } else { 0.0 },
                outer_mm: outer_mm - by_mm,
            },
        };
        narrower.validate().is_ok().then_some(narrower)
    }

    /// Half its smallest width in mm: of a ring that between its edges; infinite for [`Aperture::None`].
    pub fn half_width_mm(&self) -> f64 {
        match *self {
            Aperture::None => f64::INFINITY,
            Aperture::Circle { radius_mm } => radius_mm,
            Aperture::Rectangle { width_mm, height_mm } => 0.5 * width_mm.min(height_mm),
            Aperture::Annulus { inner_mm, outer_mm } => 0.5 * (outer_mm - inner_mm),
        }
    }

    /// Projected area in mm²; infinite for [`Aperture::None`].
    pub fn area_mm2(&self) -> f64 {
        match *self {
            Aperture::None => f64::INFINITY,
            Aperture::Circle { radius_mm } => PI * radius_mm * radius_mm,
            Aperture::Rectangle { width_mm, height_mm } => width_mm * height_mm,
            Aperture::Annulus { inner_mm, outer_mm } => {
                PI * (outer_mm - inner_mm) * (outer_mm + inner_mm)
            }
        }
    }
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
