//! The classical aberrations of a form deviation, and the spectrum of its Fringe terms.

use std::f64::consts::TAU;

use super::FringeFit;
use super::expansion::fringe_orders;

/// A term with an azimuth: magnitude and direction of a cosine and a sine term together.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Directed {
    /// Root of the sum of the squares of the two Fringe coefficients in nm: the height at the rim in its
    /// direction.
    pub magnitude_nm: f64,
    /// Azimuth of the largest height at the rim in rad, from +x towards +y, from 0 to below 2π/m for a
    /// term of azimuthal order m. `None` where the magnitude is 0.
    pub direction_rad: Option<f64>,
}

/// Aberrations of the surface (not of the wavefront, which a mirror doubles) from Fringe coefficients.
///
/// All are coefficients of Fringe terms of height 1 at the rim; over the whole disc the range of
/// power, astigmatism, coma and trefoil is twice the coefficient and that of spherical 1.5 times.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Aberrations {
    /// Fringe 4 in nm, positive if the rim deviates to +z.
    pub power_nm: f64,
    /// Fringe 5 and 6; the direction is the axis of the ridge, below π.
    pub astigmatism: Directed,
    /// Fringe 7 and 8.
    pub coma: Directed,
    /// Fringe 9 in nm.
    pub spherical_nm: f64,
    /// Fringe 10 and 11; one of three directions, below 2π/3.
    pub trefoil: Directed,
}

/// What the Fringe terms of one radial and azimuthal order contribute.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SpectrumLine {
    /// Radial order.
    pub n: u32,
    /// Azimuthal order, not negative: cosine and sine are taken together.
    pub m: u32,
    /// Magnitude, and direction for m > 0.
    pub height: Directed,
    /// RMS over the whole disc in nm: the magnitude over √(2(n+1)), for m = 0 over √(n+1). For the piston
    /// its size.
    pub rms_nm: f64,
}

impl FringeFit {
    /// The classical aberrations; `None` if one of the Fringe terms 4 to 11 is not determined.
    pub fn aberrations(&self) -> Option<Aberrations> {
        let pair = |cosine: u8, m: u32| {
            Some(directed(self.coefficient_nm(cosine)?, self.coefficient_nm(cosine + 1)?, m))
        };
        Some(Aberrations {
            power_nm: self.coefficient_nm(4)?,
            astigmatism: pair(5, 2)?,
            coma: pair(7, 1)?,
            spherical_nm: self.coefficient_nm(9)?,
            trefoil: pair(10, 3)?,
        })
    }

    /// One line an order pair in the order of the Fringe terms; pairs with a term that is not determined
    /// are left out.
    pub fn spectrum(&self) -> Vec<SpectrumLine> {
        let terms = (1_u8..).zip(&self.coefficients_nm);
        let lines = terms.filter_map(|(index, coefficient_nm)| {
            let (n, m) = fringe_orders(index)?;
            let m = u32::try_from(m).ok()?;
            let sine_nm = if m == 0 { 0.0 } else { self.coefficient_nm(index + 1)? };
            let cosine_nm = (*coefficient_nm)?;
            let height = if m == 0 {
                Directed { magnitude_nm: cosine_nm.abs(), direction_rad: None }
            } else {
                directed(cosine_nm, sine_nm, m)
            };
            let norm = f64::from(if m == 0 { n + 1 } else { 2 * (n + 1) });
            Some(SpectrumLine { n, m, height, rms_nm: height.magnitude_nm / norm.sqrt() })
        });
        lines.collect()
    }
}

/// c·cos mφ + s·sin mφ = magnitude·cos m(φ − direction).
fn directed(cosine_nm: f64, sine_nm: f64, m: u32) -> Directed {
    let magnitude_nm = cosine_nm.hypot(sine_nm);
    let direction_rad = (magnitude_nm > 0.0).then(|| {
        let turned = sine_nm.atan2(cosine_nm);
        // A tiny negative angle plus 2π rounds to 2π, which is 0.
        let positive = if turned < 0.0 { turned + TAU } else { turned };
        if positive >= TAU { 0.0 } else { positive / f64::from(m) }
    });
    Directed { magnitude_nm, direction_rad }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::PI;

    use super::*;

    #[test]
    fn directions_are_those_of_the_ridge() {
        let at = |c, s, m| directed(c, s, m).direction_rad.unwrap();
        assert_eq!(at(1.0, 0.0, 2), 0.0);
        assert!((at(-1.0, 0.0, 2) - PI / 2.0).abs() < 1e-15);
        assert!((at(0.0, -1.0, 2) - 0.75 * PI).abs() < 1e-15);
        assert!((at(0.0, -1.0, 1) - 1.5 * PI).abs() < 1e-15);
        assert!((at(-2.0, 0.0, 3) - PI / 3.0).abs() < 1e-15);
        assert_eq!(at(1.0, -1e-300, 2), 0.0);
        assert_eq!(directed(0.0, 0.0, 2), Directed { magnitude_nm: 0.0, direction_rad: None });
    }
}
