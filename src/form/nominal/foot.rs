//! The foot of a point: the place of the nominal the point stands over.

use crate::nominal::Asphere;
use crate::nominal::freeform::{self, FreeFoot};
use crate::{Nominal, PointMm};

/// A point, its foot on the nominal, and its signed distance.
///
/// The foot is the place whose normal goes through the point. It is the nearest place of the surface if
/// the point lies nearer than the local feature size; further away there may be several, and this is the
/// one below or above the point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Foot {
    /// The foot in the part frame, mm.
    pub foot_mm: PointMm,
    /// Unit normal at the foot, part frame, z component positive.
    pub normal: [f64; 3],
    /// Distance along the normal in mm; positive on the +z side.
    pub distance_mm: f64,
}

impl Nominal {
    /// The foot of a point of the part frame; `None` where the point stands over no place of the surface
    /// (beyond the equator of a sphere or the domain of an asphere) or is not finite.
    pub fn foot(&self, part_mm: PointMm) -> Option<Foot> {
        let found = self.surface_foot(part_mm)?;
        let [x, y] = match found {
            SurfaceFoot::Meridian(foot) => [foot.s_mm * foot.cos, foot.s_mm * foot.sin],
            SurfaceFoot::Free(foot) => [foot.x_mm, foot.y_mm],
        };
        let z = match found {
            SurfaceFoot::Meridian(foot) => self.sag_mm(foot.s_mm),
            SurfaceFoot::Free(_) => self.height_mm(x, y)?,
        };
        Some(Foot { foot_mm: [x, y, z], normal: found.normal(), distance_mm: found.distance_mm() })
    }

    /// The foot, in the form the kind of the nominal has it.
    pub(crate) fn surface_foot(&self, part_mm: PointMm) -> Option<SurfaceFoot> {
        match self {
            Nominal::Freeform(shape) => {
                freeform::foot(shape.as_ref(), part_mm).map(SurfaceFoot::Free)
            }
            _ => self.meridian_foot(part_mm).map(SurfaceFoot::Meridian),
        }
    }

    /// The foot on a rotational nominal; `None` for a freeform.
    fn meridian_foot(&self, part_mm: PointMm) -> Option<MeridianFoot> {
        let [x, y, zeta] = part_mm;
        let rho = (x * x + y * y).sqrt();
        if !rho.is_finite() || !zeta.is_finite() {
            return None;
        }
        let (cos, sin) = if rho > 0.0 { (x / rho, y / rho) } else { (1.0, 0.0) };
        let (s_mm, n_r, n_z, distance_mm) = match self {
            Nominal::Plane => (rho, 0.0, 1.0, zeta),
            Nominal::Sphere { radius_mm } => sphere(*radius_mm, rho, zeta)?,
            Nominal::Asphere(surface) => asphere(surface, rho, zeta)?,
            Nominal::Freeform(_) => return None,
        };
        distance_mm.is_finite().then_some(MeridianFoot {
            rho_mm: rho,
            zeta_mm: zeta,
            cos,
            sin,
            s_mm,
            n_r,
            n_z,
            distance_mm,
        })
    }
}

/// A point and its foot, with what the derivatives of the distance need.
#[derive(Clone, Copy, Debug)]
pub(crate) enum SurfaceFoot {
    /// On a rotational nominal.
    Meridian(MeridianFoot),
    /// On a freeform.
    Free(FreeFoot),
}

impl SurfaceFoot {
    pub(crate) fn distance_mm(&self) -> f64 {
        match self {
            SurfaceFoot::Meridian(foot) => foot.distance_mm,
            SurfaceFoot::Free(foot) => foot.distance_mm,
        }
    }

    /// Height of the point, not of the foot, over the vertex plane.
    pub(crate) fn point_height_mm(&self) -> f64 {
        match self {
            SurfaceFoot::Meridian(foot) => foot.zeta_mm,
            SurfaceFoot::Free(foot) => foot.part_mm[2],
        }
    }

    /// Unit normal at the foot in the part frame, z positive.
    pub(crate) fn normal(&self) -> [f64; 3] {
        match self {
            SurfaceFoot::Meridian(foot) => foot.normal(),
            SurfaceFoot::Free(foot) => foot.normal,
        }
    }
}

/// A point and its foot in the half plane through the axis that contains both.
#[derive(Clone, Copy, Debug)]
pub(crate) struct MeridianFoot {
    /// Distance of the point from the axis.
    pub(crate) rho_mm: f64,
    /// Height of the point over the vertex plane.
    pub(crate) zeta_mm: f64,
    /// Direction of the half plane.
    pub(crate) cos: f64,
    pub(crate) sin: f64,
    /// Distance of the foot from the axis.
    pub(crate) s_mm: f64,
    /// Unit normal at the foot.
    pub(crate) n_r: f64,
    pub(crate) n_z: f64,
    pub(crate) distance_mm: f64,
}

impl MeridianFoot {
    pub(crate) fn normal(&self) -> [f64; 3] {
        [self.n_r * self.cos, self.n_r * self.sin, self.n_z]
    }
}

/// With v the vector from the centre (0, R): d = sgn(R)·(|R| − |v|) and n = −sgn(R)·v/|v|. The difference
/// is written as a quotient, so that a large radius costs no digits.
fn sphere(radius: f64, rho: f64, zeta: f64) -> Option<(f64, f64, f64, f64)> {
    let sign = radius.signum();
    let (v_r, v_z) = (rho, zeta - radius);
    let length = v_r.hypot(v_z);
    let (n_r, n_z) = (-sign * v_r / length, -sign * v_z / length);
    let beyond = rho * rho + zeta * (zeta - 2.0 * radius);
    let distance = -sign * beyond / (length + radius.abs());
    (n_z > 0.0).then_some((rho * (radius.abs() / length), n_r, n_z, distance))
}

/// Newton's method for g(s) = (s − ρ) + (z(s) − ζ)·z′(s) = 0, half the derivative of the squared distance.
///
/// g(0) = −ρ is not positive, so 0 bounds the root from below; the bound from above is the end of the
/// domain or the first s with g > 0. A step that leaves the bounds is replaced by a bisection. The
/// distance depends on s only to second order, so an ulp of s is more than enough.
fn asphere(surface: &Asphere, rho: f64, zeta: f64) -> Option<(f64, f64, f64, f64)> {
    let end = surface.domain_mm() * INSIDE_DOMAIN;
    let mut s = rho.min(end);
    let (mut low, mut high, mut bounded) = (0.0, end, false);
    for _ in 0..MAX_STEPS {
        let profile = surface.profile(s);
        let above = profile.z_mm - zeta;
        let g = (s - rho) + above * profile.slope;
        let slope_of_g = 1.0 + profile.slope * profile.slope + above * profile.second_per_mm;
        let next = s - g / slope_of_g;
        // Rounding of g moves its root by about this much: s cannot be known better.
        let tolerance = STEP_TOLERANCE * (s + rho + above.abs());
        let settled = slope_of_g > 0.0 && (next - s).abs() <= tolerance;
        let step = next - s;
        // So short a last step is made by Taylor's series: what it leaves out is less than rounding.
        let short = slope_of_g > 0.0 && step.abs() <= SHORT * s.min(end - s);
        if short && !settled && profile.slope.abs() <= STEEPEST {
            let slope = profile.slope + profile.second_per_mm * step;
            let above = above + step * (profile.slope + 0.5 * profile.second_per_mm * step);
            return Some(stand(next, rho, slope, above));
        }
        // At the vertex of a point on the axis g is exactly 0 whatever the curvature.
        if g == 0.0 || settled || (bounded && high - low <= tolerance) {
            // Where the power series has run away, the surface is as good as upright everywhere and every
            // point would lie on it.
            if profile.slope.abs() > STEEPEST {
                return None;
            }
            return Some(stand(s, rho, profile.slope, above));
        }
        if g < 0.0 {
            if s >= end {
                return None;
            }
            low = s;
        } else {
            // A NaN from an overflowing power series lies outwards of the root too.
            (high, bounded) = (s, true);
        }
        s = if slope_of_g > 0.0 && next > low && next < high {
            next
        } else if bounded {
            0.5 * (low + high)
        } else if high.is_finite() {
            high
        } else {
            2.0 * low + rho + zeta.abs()
        };
    }
    None
}

/// Place, normal and distance at a foot, with the slope there and its height above the point.
fn stand(s: f64, rho: f64, slope: f64, above: f64) -> (f64, f64, f64, f64) {
    let n_z = (1.0 + slope * slope).sqrt().recip();
    (s, -slope * n_z, n_z, (slope * (s - rho) - above) * n_z)
}

/// Share of the distances from the axis and from the end of the domain that a step has of which the square, times
/// the orders of a power series, is rounding.
const SHORT: f64 = 1e-9;
/// The last piece before the end of the root is left out: there the slope grows beyond all bounds.
const INSIDE_DOMAIN: f64 = 1.0 - 1e-12;
/// Steeper than any place within [`INSIDE_DOMAIN`] of a sphere.
const STEEPEST: f64 = 1e7;
/// Relative size of the last Newton step.
const STEP_TOLERANCE: f64 = 4.0 * f64::EPSILON;
/// Bisection alone needs about 60 steps from the widest bounds.
const MAX_STEPS: usize = 200;
