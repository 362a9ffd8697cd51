//! Smooth form errors for simulated parts: Fringe polynomials and a zone ring.
//!
//! Fringe polynomials are Zernike polynomials of unit height at the rim, in the order of the University of
//! Arizona: `R_n^|m|(ρ)·cos mφ` for m ≥ 0 and `R_n^|m|(ρ)·sin |m|φ` for m < 0. The radial polynomial is
//! `Σ_k (−1)^k (n−k)! / (k! ((n+|m|)/2−k)! ((n−|m|)/2−k)!) ρ^(n−2k)` (Born & Wolf, Principles of Optics,
//! 7th ed., 9.2.1, eq. 5).

/// Radial order n and azimuthal order m of the Fringe term `index`, which starts at 1 with the piston.
///
/// `None` for 0 and beyond 100. Inverse of `⌊(1+(n+|m|)/2)² − 2|m| − (1+sgn m)/2⌋ + 1`.
pub fn fringe_orders(index: u8) -> Option<(u32, i32)> {
    if index == 0 || index > 100 {
        return None;
    }
    let offset = u32::from(index) - 1;
    // (n + |m|)/2 is the same throughout a group, and groups begin at the squares.
    let group = offset.isqrt();
    let within = offset - group * group;
    let m = group - within / 2;
    let n = 2 * group - m;
    let signed = if within.is_multiple_of(2) { m.cast_signed() } else { -m.cast_signed() };
    Some((n, signed))
}

/// Value of the Fringe term `index` at (u, v) on the unit disc, `φ` counted from u; it goes on smoothly
/// beyond the rim. `None` as [`fringe_orders`].
pub fn fringe(index: u8, u: f64, v: f64) -> Option<f64> {
    let (n, m) = fringe_orders(index)?;
    let order = m.unsigned_abs();
    // ρ^|m|·(cos, sin)(|m|φ) by complex powers, so that no angle is needed at the centre.
    let (mut re, mut im) = (1.0, 0.0);
    for _ in 0..order {
        (re, im) = (re * u - im * v, re * v + im * u);
    }
    let square = u * u + v * v;
    let terms = (n - order) / 2;
    // Horner in ρ². From one k to the next the coefficient changes by
    // −((n+|m|)/2 − k)·((n−|m|)/2 − k) / ((k+1)·(n−k)).
    let mut coefficient =
        (1..=terms).fold(1.0, |product, i| product * f64::from(terms + order + i) / f64::from(i));
    let mut radial = 0.0;
    for k in 0..=terms {
        radial = radial * square + coefficient;
        let (a, b) = (f64::from(terms + order - k), f64::from(terms - k));
        coefficient *= -a * b / (f64::from(k + 1) * f64::from((n - k).max(1)));
    }
    Some(radial * if m >= 0 { re } else { im })
}

/// A smooth form error over a disc: Fringe terms and, if wanted, a ring as zonal polishing leaves it.
#[derive(Clone, Debug, PartialEq)]
pub struct FormError {
    /// Radius of the disc on which the polynomials have unit height, in mm.
    pub radius_mm: f64,
    /// Fringe index (1 to 100) and height in nm. Other indices count as 0.
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
        let terms = self.fringe_nm.iter();
        let polynomials: f64 =
            terms.filter_map(|&(index, nm)| fringe(index, u, v).map(|value| value * nm)).sum();
        let ring = self.ring.map_or(0.0, |ring| {
            let from_crest = (x_mm.hypot(y_mm) - ring.radius_mm) / ring.width_mm;
            ring.height_nm * (-from_crest * from_crest).exp()
        });
        polynomials + ring
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn orders_agree_with_the_forward_formula() {
        for index in 1..=100 {
            let (n, m) = fringe_orders(index).unwrap();
            let (n, a) = (f64::from(n), f64::from(m.abs()));
            let sign = f64::from(m.signum());
            let forward =
                ((1.0 + (n + a) / 2.0).powi(2) - 2.0 * a - (1.0 + sign) / 2.0).floor() + 1.0;
            assert_eq!(forward, f64::from(index));
        }
        assert_eq!((fringe_orders(0), fringe_orders(101)), (None, None));
    }

    #[test]
    fn first_terms_have_their_closed_forms() {
        let (r, phi) = (0.83_f64, 0.71_f64);
        let (u, v) = (r * phi.cos(), r * phi.sin());
        let closed = [
            (1, 1.0),
            (2, r * phi.cos()),
            (3, r * phi.sin()),
            (4, 2.0 * r * r - 1.0),
            (5, r * r * (2.0 * phi).cos()),
            (6, r * r * (2.0 * phi).sin()),
            (7, (3.0 * r.powi(3) - 2.0 * r) * phi.cos()),
            (8, (3.0 * r.powi(3) - 2.0 * r) * phi.sin()),
            (9, 6.0 * r.powi(4) - 6.0 * r * r + 1.0),
            (10, r.powi(3) * (3.0 * phi).cos()),
            (11, r.powi(3) * (3.0 * phi).sin()),
            (12, (4.0 * r.powi(4) - 3.0 * r * r) * (2.0 * phi).cos()),
            (16, 20.0 * r.powi(6) - 30.0 * r.powi(4) + 12.0 * r * r - 1.0),
        ];
        for (index, value) in closed {
            assert!((fringe(index, u, v).unwrap() - value).abs() < 1e-14, "term {index}");
        }
    }

    #[test]
    fn every_term_has_height_one_at_the_rim() {
        for index in 1..=100 {
            let (_, m) = fringe_orders(index).unwrap();
            let phi = if m >= 0 { 0.0 } else { std::f64::consts::FRAC_PI_2 / f64::from(-m) };
            let value = fringe(index, phi.cos(), phi.sin()).unwrap();
            assert!((value - 1.0).abs() < 1e-9, "term {index}: {value}");
        }
    }

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
