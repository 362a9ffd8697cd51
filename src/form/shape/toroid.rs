//! The toroid: a curve in the y-z plane turned about an axis parallel to y.

use std::sync::Arc;

use super::argument::{count, parameter, radius};
use super::at_first_use::AtFirstUse;
use super::even_powers::EvenPowers;
use super::section::{ConicSection, NAMES};
use super::taylor::{Taylor, defined, number};
use super::{Jet, Shape, ShapeError, ShapeParameter};

/// A toroid: the curve `f(y) = conic(y) + Σ A_n·y^n`, n even from 2 on, turned about the line parallel to y
/// through (0, 0, R) (ISO 10110-12:2019; Zemax' TOROIDAL, whose `PARM 1` is R, 0 there meaning infinite,
/// and whose `PARM 2` is A2).
///
/// Its part on the vertex side of that line: `(R − z)² + x² = (R − f(y))²`.
#[derive(Clone, Debug, PartialEq)]
pub struct Toroid {
    /// Infinite if not turned.
    rotation_mm: f64,
    section: ConicSection,
    powers: EvenPowers,
    domain: AtFirstUse,
}

impl Toroid {
    /// From the radius of rotation R in mm, positive where the axis lies on the +z side, the conic of the
    /// curve, and its terms (order, coefficient in mm^(1−order)). Parameters `rotation_radius`, then
    /// `radius` and `conic` unless flat, then `A2`, `A4` … of the terms given. Fails on a radius of 0 or
    /// not finite, on an order that is odd, 0 or given twice, and on a coefficient that is not finite.
    pub fn new(
        rotation_radius_mm: f64,
        section: ConicSection,
        terms: &[(u8, f64)],
    ) -> Result<Toroid, ShapeError> {
        let rotation_mm = radius(KIND, ROTATION, rotation_radius_mm)?;
        let powers = EvenPowers::new(KIND, terms)?;
        Ok(Toroid { rotation_mm, section, powers, domain: AtFirstUse::default() })
    }

    /// With an infinite radius of rotation: an acylinder that does not change along x. As
    /// [`Toroid::new`], without `rotation_radius`.
    pub fn unrotated(section: ConicSection, terms: &[(u8, f64)]) -> Result<Toroid, ShapeError> {
        let powers = EvenPowers::new(KIND, terms)?;
        let (rotation_mm, domain) = (f64::INFINITY, AtFirstUse::default());
        Ok(Toroid { rotation_mm, section, powers, domain })
    }

    fn is_rotated(&self) -> bool {
        self.rotation_mm.is_finite()
    }

    /// With k = 1/R: w = 1 − k·f and s = √(w² − k²·x²) are (R − f)/R and (R − z)/R.
    fn terms(&self, x_mm: f64, f_mm: f64) -> Option<Terms> {
        let k = self.rotation_mm.recip();
        let w = 1.0 - k * f_mm;
        let kx = k * x_mm;
        let square = (w - kx) * (w + kx);
        (w > 0.0 && square > 0.0).then(|| {
            let s = square.sqrt();
            Terms { k, w, s, rise_mm: kx * x_mm / (w + s) }
        })
    }
}

struct Terms {
    k: f64,
    w: f64,
    s: f64,
    /// z − f, in a form that keeps its digits however small k·x² is.
    rise_mm: f64,
}

impl Shape for Toroid {
    fn kind(&self) -> &'static str {
        KIND
    }

    /// The derivatives of (1 − k·z)² + k²·x² = w², by which every division by k cancels.
    fn jet(&self, x_mm: f64, y_mm: f64) -> Option<Jet> {
        let t = y_mm * y_mm;
        let Taylor { value: f, first: f1, second: f2 } =
            self.section.at(t)?.plus(self.powers.at(t)).of_square(y_mm);
        let Terms { k, w, s, rise_mm } = self.terms(x_mm, f)?;
        let (kx, s3) = (k * x_mm, s * s * s);
        defined(Jet {
            z_mm: f + rise_mm,
            gradient: [kx / s, w * f1 / s],
            hessian_per_mm: [
                k * w * w / s3,
                k * kx * w * f1 / s3,
                w * f2 / s + k * kx * kx * f1 * f1 / s3,
            ],
        })
    }

    fn sag_mm(&self, x_mm: f64, y_mm: f64) -> Option<f64> {
        let t = y_mm * y_mm;
        let f = self.section.sag_mm(t)? + self.powers.value(t);
        number(f + self.terms(x_mm, f)?.rise_mm)
    }

    fn parameters(&self) -> Vec<ShapeParameter> {
        let mut parameters = Vec::new();
        if self.is_rotated() {
            parameters.push(parameter(ROTATION, "mm", self.rotation_mm));
        }
        parameters.extend(self.section.parameters(NAMES));
        parameters.extend(self.powers.parameters());
        parameters
    }

    fn by_parameters(&self, x_mm: f64, y_mm: f64, derivatives: &mut [f64]) -> Option<()> {
        let t = y_mm * y_mm;
        let f = self.section.sag_mm(t)? + self.powers.value(t);
        let Terms { k, w, s, rise_mm } = self.terms(x_mm, f)?;
        let (rotation, curve) = derivatives.split_at_mut(usize::from(self.is_rotated()));
        if let [by_rotation] = rotation {
            // d/dk of the rise k·x²/(w+s), with dw/dk = −f and s·ds/dk = −(f·w + k·x²).
            let squares = f + (f * w + k * x_mm * x_mm) / s;
            *by_rotation = -k * k * (x_mm * x_mm + rise_mm * squares) / (w + s);
        }
        let (section, powers) = curve.split_at_mut(self.section.count());
        self.section.write_derivatives(t, section)?;
        self.powers.write_derivatives(t, powers);
        // What moves f moves z by ∂z/∂f = w/s times as much.
        curve.iter_mut().for_each(|derivative| *derivative *= w / s);
        Some(())
    }

    fn with_parameters(&self, values: &[f64]) -> Result<Arc<dyn Shape>, ShapeError> {
        let rotated = usize::from(self.is_rotated());
        count(KIND, values, rotated + self.section.count() + self.powers.count())?;
        let (rotation, curve) = values.split_at(rotated);
        let (section, powers) = curve.split_at(self.section.count());
        let rotation_mm = match rotation {
            [value] => radius(KIND, ROTATION, *value)?,
            _ => f64::INFINITY,
        };
        Ok(Arc::new(Toroid {
            rotation_mm,
            section: self.section.with_values(KIND, NAMES, section)?,
            powers: self.powers.with_values(KIND, powers)?,
            domain: AtFirstUse::default(),
        }))
    }

    /// A lower bound, close where the curve is a conic. The domain ends at |x| = |R| − f(y)·sgn R; a disc
    /// is inside if in every strip of it the widest x stays below the largest f possible in that strip,
    /// taken from the bounds that are monotonic in |y|. `O(1)`, some microseconds the first time.
    fn domain_mm(&self) -> f64 {
        self.domain.or_find(|| self.find_domain_mm())
    }
}

impl Toroid {
    fn find_domain_mm(&self) -> f64 {
        let end_mm = self.section.domain_mm();
        if !self.is_rotated() {
            return end_mm;
        }
        // At y = 0 the domain ends at |x| = |R|.
        let (mut inside, mut outside) = (0.0, end_mm.min(self.rotation_mm.abs()));
        for _ in 0..BISECTIONS {
            let middle = 0.5 * (inside + outside);
            if self.holds(middle) { inside = middle } else { outside = middle }
        }
        inside
    }

    /// Whether every place of the disc of this radius is certainly in the domain.
    fn holds(&self, disc_mm: f64) -> bool {
        (0..STRIPS).all(|strip| {
            let near = disc_mm * f64::from(strip) / f64::from(STRIPS);
            let far = disc_mm * f64::from(strip + 1) / f64::from(STRIPS);
            let Some(highest) = self.highest_mm(near, far) else { return false };
            let widest = (disc_mm * disc_mm - near * near).sqrt();
            widest < self.rotation_mm.abs() - highest
        })
    }

    /// A bound from above of f(y)·sgn R for near ≤ |y| ≤ far.
    fn highest_mm(&self, near: f64, far: f64) -> Option<f64> {
        let sign = self.rotation_mm.signum();
        let rising = self.section.curvature_per_mm() * sign > 0.0;
        let conic = sign * self.section.sag_mm(if rising { far * far } else { near * near })?;
        self.section.root(far * far)?;
        let (positive, negative) = if sign > 0.0 {
            (self.powers.split(far * far).0, self.powers.split(near * near).1)
        } else {
            (-self.powers.split(far * far).1, -self.powers.split(near * near).0)
        };
        number(conic + positive + negative)
    }
}

const KIND: &str = "toroid";
const ROTATION: &str = "rotation_radius";
/// Strips of a disc, and halvings of the interval in which its radius is sought.
const STRIPS: u32 = 64;
const BISECTIONS: u32 = 50;
