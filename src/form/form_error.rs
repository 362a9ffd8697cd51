//! Smooth form errors for simulated parts: Fringe polynomials and a zone ring.

use crate::basis::{Counting, Normalisation, zernike_value};

/// A smooth form error over a disc: Fringe terms and, if wanted, a ring as zonal polishing leaves it.
#[derive(Clone, Debug, PartialEq)]
pub struct FormError {
    /// Radius of the disc on which the polynomials have unit height, in mm.
    pub radius_mm: f64,
    /// Fringe index (1 to 100, by the rule: 37 is (6, 6)) and height in nm. Other indices count as 0.
    pub fringe_nm: Vec<(u8, f64)>,
    /// The ring.
    pub ring: Option<Ring>,
}

/// A ring of raised material with a Gaussian section: `h·exp(−((ρ−ρ₀)/w)²)`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ring {
    /// Distance of its crest from the axis, in mm.
    pub radius_mm: f64,
    /// Distance from the crest in mm at which 1/e of the height is left.
    pub width_mm: f64,
    /// Height of the crest in nm.
    pub height_nm: f64,
}

impl FormError {
    /// Astigmatism, coma, trefoil, spherical aberration and a ring, about 200 nm from peak to valley over
    /// the disc.
    pub fn typical(radius_mm: f64) -> FormError {
        FormError {
            radius_mm,
            fringe_nm: vec![
                (5, 47.0),
                (6, -27.0),
                (7, 24.0),
                (8, 16.0),
                (9, 34.0),
                (10, 30.0),
                (11, 12.0),
            ],
            ring: Some(Ring {
                radius_mm: 0.62 * radius_mm,
                width_mm: 0.06 * radius_mm,
                height_nm: 40.0,
            }),
        }
    }

    /// Height in nm at a place of the part frame in mm.
    pub fn height_nm(&self, x_mm: f64, y_mm: f64) -> f64 {
        let (u, v) = (x_mm / self.radius_mm, y_mm / self.radius_mm);
        let term = |&(index, height_nm): &(u8, f64)| {
            let (n, m) =
                Counting::Fringe.orders(u32::from(index)).filter(|_| index <= LARGEST_FRINGE)?;
            Some(height_nm * zernike_value(n, m, Normalisation::UnitHeight, u, v)?)
        };
        let polynomials: f64 = self.fringe_nm.iter().filter_map(term).sum();
        let ring = self.ring.map_or(0.0, |ring| {
            let from_crest = (x_mm.hypot(y_mm) - ring.radius_mm) / ring.width_mm;
            ring.height_nm * (-from_crest * from_crest).exp()
        });
        polynomials + ring
    }
}

/// The largest Fringe index of a [`FormError`].
pub const LARGEST_FRINGE: u8 = 100;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn typical_error_has_about_200_nm() {
        let error = FormError::typical(9.0);
        let (mut low, mut high) = (f64::INFINITY, f64::NEG_INFINITY);
        for i in -90..=90 {
            for j in -90..=90 {
                let (x, y) = (f64::from(i) * 0.1, f64::from(j) * 0.1);
                if x.hypot(y) <= 9.0 {
                    low = error.height_nm(x, y).min(low);
                    high = error.height_nm(x, y).max(high);
                }
            }
        }
        assert!((180.0..220.0).contains(&(high - low)), "{}", high - low);
    }
}
