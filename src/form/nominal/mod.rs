//! Nominal surfaces: sag, slope, curvature.

pub(crate) mod foot;
pub(crate) mod freeform;
pub(crate) mod parameter;
mod slide;

pub use foot::Foot;
pub use parameter::{Parameter, ParameterError};

use std::fmt;
use std::sync::Arc;

use thiserror::Error;

use crate::shape::{Jet, Shape};

/// Lowest order of the even power series of an asphere.
pub(crate) const LOWEST_ORDER: u8 = 4;
/// Highest order of the even power series of an asphere.
pub(crate) const HIGHEST_ORDER: u8 = 20;
const COEFFICIENTS: usize = 9;
/// Parameters of a freeform that are written out.
const MOST_NAMED: usize = 12;

/// The design surface in the part frame: vertex at the origin, axis +z.
///
/// The first three are rotationally symmetric, and a distance is found in their meridian plane; a freeform
/// is any graph z(x, y), and a distance is found over the plane. What is a function of the distance from
/// the axis ([`Nominal::sag_mm`] and others) is NaN for a freeform: [`Nominal::jet`] knows every kind.
///
/// A radius of curvature is positive where the centre of curvature lies on the +z side of the vertex.
#[derive(Clone, Debug)]
pub enum Nominal {
    /// The plane z = 0.
    Plane,
    /// The half of a sphere on the vertex side of its equator.
    Sphere {
        /// Radius of curvature in mm, with sign, not 0.
        radius_mm: f64,
    },
    /// A rotationally symmetric asphere.
    Asphere(Asphere),
    /// Any other shape.
    Freeform(Arc<dyn Shape>),
}

/// An even asphere after ISO 10110-12: `z = c·r²/(1 + √(1 − (1+κ)·c²·r²)) + Σ A_n·r^n`, c = 1/R, n even
/// from 4 to 20.
///
/// There is no r² term. Lens files that have one (Zemax starts its even asphere at r²) must carry it as 0.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Asphere {
    /// Radius of curvature at the vertex in mm, with sign, not 0.
    pub radius_mm: f64,
    /// Conic constant κ: 0 sphere, −1 paraboloid.
    pub conic: f64,
    /// `A4, A6, … A20` in mm^(1−n).
    pub coefficients: [f64; COEFFICIENTS],
}

/// Principal curvatures in 1/mm, positive where the surface bends towards +z.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Curvatures {
    /// Along the meridian.
    pub meridional_per_mm: f64,
    /// Across the meridian.
    pub azimuthal_per_mm: f64,
}

/// Why a nominal is none.
#[derive(Clone, Copy, Debug, Error, PartialEq)]
pub enum NominalError {
    /// The radius of curvature is zero or not finite.
    #[error(
        "radius of curvature is {0:?} mm, expected a number other than 0, at most 1e307 in size (what is flat has no radius)"
    )]
    Radius(f64),
    /// The conic constant is not finite.
    #[error("conic constant is {0}, expected a finite number")]
    Conic(f64),
    /// A coefficient is not finite.
    #[error("coefficient A{order} is {value}, expected a finite number")]
    Coefficient {
        /// Its order.
        order: u8,
        /// Its value in mm^(1−order).
        value: f64,
    },
    /// A coefficient of an order the power series does not have.
    #[error("coefficient of order {0}, expected an even order from 4 to 20")]
    Order(u8),
}

impl Nominal {
    /// Fails on a zero or non-finite radius and on non-finite constants.
    pub fn validate(&self) -> Result<(), NominalError> {
        if let Some(radius_mm) = self.radius_mm()
            && (!radius_mm.is_normal() || !radius_mm.recip().is_normal())
        {
            return Err(NominalError::Radius(radius_mm));
        }
        let Nominal::Asphere(asphere) = self else { return Ok(()) };
        if !asphere.conic.is_finite() {
            return Err(NominalError::Conic(asphere.conic));
        }
        for (order, value) in asphere.orders() {
            if !value.is_finite() {
                return Err(NominalError::Coefficient { order, value });
            }
        }
        Ok(())
    }

    /// Whether it is a function of the distance from the axis by its kind. A freeform is not, whatever its
    /// shape.
    pub fn is_rotational(&self) -> bool {
        !matches!(self, Nominal::Freeform(_))
    }

    /// The shape of a freeform, if it is one.
    pub fn freeform(&self) -> Option<&Arc<dyn Shape>> {
        match self {
            Nominal::Freeform(shape) => Some(shape),
            _ => None,
        }
    }

    /// Radius of curvature at the vertex in mm; `None` for a plane and for a freeform.
    pub fn radius_mm(&self) -> Option<f64> {
        match self {
            Nominal::Plane | Nominal::Freeform(_) => None,
            Nominal::Sphere { radius_mm } => Some(*radius_mm),
            Nominal::Asphere(asphere) => Some(asphere.radius_mm),
        }
    }

    /// The asphere, if it is one.
    pub fn asphere(&self) -> Option<&Asphere> {
        match self {
            Nominal::Asphere(asphere) => Some(asphere),
            _ => None,
        }
    }

    /// Height and derivatives at a place of the part frame in mm; `None` beyond the domain and for places
    /// that are not finite.
    ///
    /// With ρ = r, e = (x, y)/r and the meridian z(r): ∇z = z′·e and the Hessian is
    /// `z″·e·eᵀ + (z′/r)·(1 − e·eᵀ)`, whose limit at the vertex is z″·1.
    pub fn jet(&self, x_mm: f64, y_mm: f64) -> Option<Jet> {
        if let Nominal::Freeform(shape) = self {
            return shape.jet(x_mm, y_mm);
        }
        let r_mm = x_mm.hypot(y_mm);
        let Profile { z_mm, slope, second_per_mm } = self.profile(r_mm);
        if !(r_mm.is_finite() && z_mm.is_finite() && slope.is_finite() && second_per_mm.is_finite())
        {
            return None;
        }
        if r_mm == 0.0 {
            let hessian_per_mm = [second_per_mm, 0.0, second_per_mm];
            return Some(Jet { z_mm, gradient: [0.0; 2], hessian_per_mm });
        }
        let (cos, sin) = (x_mm / r_mm, y_mm / r_mm);
        let across = slope / r_mm;
        let beyond = second_per_mm - across;
        Some(Jet {
            z_mm,
            gradient: [slope * cos, slope * sin],
            hessian_per_mm: [
                across + beyond * cos * cos,
                beyond * cos * sin,
                across + beyond * sin * sin,
            ],
        })
    }

    /// Height at a place of the part frame, both in mm; `None` where there is no [`Nominal::jet`].
    pub fn height_mm(&self, x_mm: f64, y_mm: f64) -> Option<f64> {
        match self {
            Nominal::Freeform(shape) => shape.sag_mm(x_mm, y_mm),
            _ => Some(self.sag_mm(x_mm.hypot(y_mm))).filter(|z_mm| z_mm.is_finite()),
        }
    }

    /// Height over the vertex plane at the distance `r_mm` from the axis, in mm. NaN beyond
    /// [`Nominal::domain_mm`] and for a freeform.
    pub fn sag_mm(&self, r_mm: f64) -> f64 {
        self.profile(r_mm).z_mm
    }

    /// Slope dz/dr at the distance `r_mm` from the axis. NaN beyond the domain and for a freeform, infinite
    /// at the equator of a sphere.
    pub fn slope(&self, r_mm: f64) -> f64 {
        self.profile(r_mm).slope
    }

    /// Gradient (∂z/∂x, ∂z/∂y) at a place of the part frame in mm; NaN beyond the domain.
    pub fn gradient(&self, x_mm: f64, y_mm: f64) -> [f64; 2] {
        if let Nominal::Freeform(shape) = self {
            return shape.jet(x_mm, y_mm).map_or([f64::NAN; 2], |jet| jet.gradient);
        }
        let r_mm = x_mm.hypot(y_mm);
        if r_mm == 0.0 {
            return [0.0, 0.0];
        }
        let slope = self.slope(r_mm);
        [slope * (x_mm / r_mm), slope * (y_mm / r_mm)]
    }

    /// Principal curvatures at the distance `r_mm` from the axis; NaN beyond the domain and for a freeform.
    ///
    /// For z(r) they are `z″/(1+z′²)^{3/2}` and `z′/(r·√(1+z′²))`.
    pub fn curvatures(&self, r_mm: f64) -> Curvatures {
        let profile = self.profile(r_mm);
        let stretch = profile.slope.mul_add(profile.slope, 1.0).sqrt();
        let azimuthal_per_mm =
            if r_mm == 0.0 { profile.second_per_mm } else { profile.slope / (r_mm * stretch) };
        Curvatures {
            meridional_per_mm: profile.second_per_mm / (stretch * stretch * stretch),
            azimuthal_per_mm,
        }
    }

    /// Smallest principal radius of curvature at the distance `r_mm` from the axis, in mm: an upper bound
    /// of the local feature size (Amenta & Bern, Discrete Comput. Geom. 22 (1999) 481: the medial axis
    /// comes at least as near as the nearest centre of curvature). Infinite where flat, NaN beyond the
    /// domain and for a freeform, which has [`Nominal::lfs_bound_at_mm`].
    pub fn lfs_bound_mm(&self, r_mm: f64) -> f64 {
        let Curvatures { meridional_per_mm, azimuthal_per_mm } = self.curvatures(r_mm);
        if meridional_per_mm.is_nan() || azimuthal_per_mm.is_nan() {
            return f64::NAN;
        }
        meridional_per_mm.abs().max(azimuthal_per_mm.abs()).recip()
    }

    /// As [`Nominal::lfs_bound_mm`] at a place of the part frame in mm, for every kind of nominal; `None`
    /// beyond the domain.
    pub fn lfs_bound_at_mm(&self, x_mm: f64, y_mm: f64) -> Option<f64> {
        let [mean, beyond] = self.jet(x_mm, y_mm)?.mean_curvature();
        Some((mean.abs() + beyond).recip())
    }

    /// Distance from the axis in mm at which the root of the conic ends: |R|/√(1+κ) for κ > −1, else
    /// infinite; that of its shape for a freeform.
    pub fn domain_mm(&self) -> f64 {
        match self {
            Nominal::Freeform(shape) => shape.domain_mm(),
            Nominal::Plane => f64::INFINITY,
            Nominal::Sphere { radius_mm } => radius_mm.abs(),
            Nominal::Asphere(asphere) => asphere.domain_mm(),
        }
    }

    /// `plane`, `sphere`, `asphere`, or what a freeform calls itself.
    pub fn kind(&self) -> &'static str {
        match self {
            Nominal::Plane => "plane",
            Nominal::Sphere { .. } => "sphere",
            Nominal::Asphere(_) => "asphere",
            Nominal::Freeform(shape) => shape.kind(),
        }
    }

    pub(crate) fn profile(&self, r_mm: f64) -> Profile {
        match self {
            Nominal::Plane => Profile { z_mm: 0.0, slope: 0.0, second_per_mm: 0.0 },
            Nominal::Sphere { radius_mm } => conic_profile(radius_mm.recip(), 0.0, r_mm),
            Nominal::Asphere(asphere) => asphere.profile(r_mm),
            Nominal::Freeform(_) => {
                Profile { z_mm: f64::NAN, slope: f64::NAN, second_per_mm: f64::NAN }
            }
        }
    }
}

impl Asphere {
    /// An asphere from its non-zero coefficients as (order, value in mm^(1−order)). A repeated order
    /// counts with its last value. Fails as [`Nominal::validate`] does and on a wrong order.
    pub fn new(
        radius_mm: f64,
        conic: f64,
        coefficients: &[(u8, f64)],
    ) -> Result<Asphere, NominalError> {
        let mut asphere = Asphere { radius_mm, conic, coefficients: [0.0; COEFFICIENTS] };
        for &(order, value) in coefficients {
            *asphere.coefficient_mut(order).ok_or(NominalError::Order(order))? = value;
        }
        Nominal::Asphere(asphere).validate()?;
        Ok(asphere)
    }

    /// The coefficient of `r^order`; `None` unless the order is even and from 4 to 20.
    pub fn coefficient(&self, order: u8) -> Option<f64> {
        index(order).map(|index| self.coefficients[index])
    }

    pub(crate) fn coefficient_mut(&mut self, order: u8) -> Option<&mut f64> {
        index(order).map(|index| &mut self.coefficients[index])
    }

    pub(crate) fn domain_mm(&self) -> f64 {
        let shape = 1.0 + self.conic;
        if shape > 0.0 { self.radius_mm.abs() / shape.sqrt() } else { f64::INFINITY }
    }

    pub(crate) fn profile(&self, r_mm: f64) -> Profile {
        let conic = conic_profile(self.radius_mm.recip(), self.conic, r_mm);
        // Horner in u = r² for P(u)/u² = Σ A_{2i}·u^{i−2} and its first two derivatives in u.
        let u = r_mm * r_mm;
        let (mut p, mut p1, mut p2) = (0.0, 0.0, 0.0);
        for a in self.coefficients.iter().rev() {
            p2 = p2 * u + p1;
            p1 = p1 * u + p;
            p = p * u + a;
        }
        // With P = u²·p: P′ = 2u·p + u²·p′ and P″ = 2p + 4u·p′ + u²·p″, where p″ is twice Horner's.
        let first = u * (2.0 * p + u * p1);
        let second = 2.0 * p + u * (4.0 * p1 + u * 2.0 * p2);
        Profile {
            z_mm: conic.z_mm + u * u * p,
            slope: conic.slope + 2.0 * r_mm * first,
            second_per_mm: conic.second_per_mm + 2.0 * first + 4.0 * u * second,
        }
    }

    fn orders(&self) -> impl Iterator<Item = (u8, f64)> {
        (LOWEST_ORDER..=HIGHEST_ORDER).step_by(2).zip(self.coefficients)
    }
}

/// Freeforms are equal if they are one object or have the same fields, as `Debug` shows them.
impl PartialEq for Nominal {
    fn eq(&self, other: &Nominal) -> bool {
        match (self, other) {
            (Nominal::Plane, Nominal::Plane) => true,
            (Nominal::Sphere { radius_mm: a }, Nominal::Sphere { radius_mm: b }) => a == b,
            (Nominal::Asphere(a), Nominal::Asphere(b)) => a == b,
            (Nominal::Freeform(a), Nominal::Freeform(b)) => {
                Arc::ptr_eq(a, b) || format!("{a:?}") == format!("{b:?}")
            }
            _ => false,
        }
    }
}

/// In words, as a report names it: `asphere R 11.65 mm, conic -1.1, A4 3.69e-5 mm^-3`.
impl fmt::Display for Nominal {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Nominal::Plane => f.write_str("plane"),
            Nominal::Sphere { radius_mm } => write!(f, "sphere R {radius_mm} mm"),
            Nominal::Asphere(asphere) => {
                write!(f, "asphere R {} mm, conic {}", asphere.radius_mm, asphere.conic)?;
                asphere.orders().filter(|&(_, value)| value != 0.0).try_for_each(
                    |(order, value)| write!(f, ", A{order} {value:e} {}", power_unit(order)),
                )
            }
            Nominal::Freeform(shape) => {
                f.write_str(shape.kind())?;
                let parameters = shape.parameters();
                let told = parameters.iter().filter(|parameter| parameter.value != 0.0);
                for parameter in told.clone().take(MOST_NAMED) {
                    write!(f, ", {} {}", parameter.name, parameter.value)?;
                    if parameter.unit != "1" {
                        write!(f, " {}", parameter.unit)?;
                    }
                }
                match told.count().saturating_sub(MOST_NAMED) {
                    0 => Ok(()),
                    more => write!(f, " and {more} more parameters"),
                }
            }
        }
    }
}

/// The unit of the coefficient of `r^order`.
pub(crate) fn power_unit(order: u8) -> String {
    format!("mm^{}", 1 - i32::from(order))
}

/// The meridian z(r) at one r.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Profile {
    pub(crate) z_mm: f64,
    pub(crate) slope: f64,
    pub(crate) second_per_mm: f64,
}

/// Sag `c·r²/(1+φ)`, slope `c·r/φ` and second derivative `c/φ³` with φ = √(1 − (1+κ)·c²·r²) (Křen, J. Eur.
/// Opt. Soc. 13 (2017) 12).
fn conic_profile(c: f64, conic: f64, r_mm: f64) -> Profile {
    let phi = conic_root(c, conic, r_mm);
    Profile {
        z_mm: c * r_mm * r_mm / (1.0 + phi),
        slope: c * r_mm / phi,
        second_per_mm: c / (phi * phi * phi),
    }
}

/// φ = √(1 − (1+κ)·c²·r²); NaN beyond the domain.
pub(crate) fn conic_root(c: f64, conic: f64, r_mm: f64) -> f64 {
    let cr = c * r_mm;
    (1.0 - (1.0 + conic) * cr * cr).sqrt()
}

fn index(order: u8) -> Option<usize> {
    let even = order.is_multiple_of(2) && (LOWEST_ORDER..=HIGHEST_ORDER).contains(&order);
    even.then(|| usize::from((order - LOWEST_ORDER) / 2))
}
