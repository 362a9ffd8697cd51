//! Forbes' Q-bfs and Q-con aspheres of revolution.

use std::sync::Arc;

use super::argument::{count, finite, parameter, refused};
use super::q_basis::{SagOrthogonal, SlopeOrthogonal};
use super::section::{ConicSection, NAMES};
use super::taylor::{Taylor, number};
use super::{Jet, Shape, ShapeError, ShapeParameter};

/// An asphere of revolution in Forbes' orthogonal polynomials, u = ρ/ρmax:
///
/// - Q-bfs `z = conic(ρ) + σ(ρ)·u²(1−u²)·Σ a_m·Q_m^bfs(u²)` (Forbes, Opt. Express 15 (2007) 5218 and
///   18 (2010) 19700; Zemax' QED_TYPE with type 0);
/// - Q-con `z = conic(ρ) + u⁴·Σ a_m·Q_m^con(u²)` (Forbes 2007; Zemax' type 1).
///
/// It ends at ρmax: beyond, the polynomials say nothing about the part.
///
/// ```
/// use asphera_form::shape::{ConicSection, Projection, QAsphere, Shape};
///
/// let base = ConicSection::new(17.3729, -0.67609)?;
/// let lens = QAsphere::bfs(base, 27.0, Projection::ConicNormal, &[-0.815, -0.323, 0.106])?;
/// let names: Vec<_> = lens.parameters().into_iter().map(|parameter| parameter.name).collect();
/// assert_eq!(names, ["radius", "conic", "Q0", "Q1", "Q2"]);
/// assert!(lens.sag_mm(27.1, 0.0).is_none());
/// # Ok::<(), asphera_form::shape::ShapeError>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct QAsphere {
    base: ConicSection,
    rho_max_mm: f64,
    coefficients_mm: Vec<f64>,
    family: Family,
}

/// How the departure of a Q-bfs asphere becomes a height: the factor σ.
///
/// Programs differ here and the files do not say. The departure of a Q-bfs asphere is meant along the normal
/// of its base, and σ is the inverse of the cosine of that normal.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Projection {
    /// σ = 1: the departure is along the axis (prysm's `compute_z_zprime_Qbfs`).
    Axis,
    /// σ = 1/√(1 − c²ρ²): along the normal of the sphere that has the curvature of the base (Forbes 2007
    /// and 2010, where the base is a sphere).
    SphereNormal,
    /// σ = √(1 − κc²ρ²)/√(1 − (1+κ)c²ρ²): along the normal of the conic (Forbes, Opt. Express 19 (2011)
    /// 9923; CODE V, Optiland). Equal to the former for a sphere.
    ///
    /// Heights published from Zemax agree with this and exclude [`Projection::Axis`]; a lens sold by its
    /// QED_TYPE, Thorlabs ASL5040-UV, reaches beyond |R|, where [`Projection::SphereNormal`] has ended.
    ConicNormal,
}

#[derive(Clone, Debug, PartialEq)]
enum Family {
    Bfs { projection: Projection, basis: SlopeOrthogonal, auxiliary_mm: Vec<f64> },
    Con { basis: SagOrthogonal },
}

impl QAsphere {
    /// A Q-bfs asphere from ρmax and a_0, a_1 … in mm. Parameters `radius` and `conic`, unless the base is
    /// flat, and `Q0`, `Q1` …. Fails on a ρmax that is not positive and finite and on a coefficient that
    /// is not finite.
    pub fn bfs(
        base: ConicSection,
        rho_max_mm: f64,
        projection: Projection,
        coefficients_mm: &[f64],
    ) -> Result<QAsphere, ShapeError> {
        check(BFS, rho_max_mm, coefficients_mm)?;
        let basis = SlopeOrthogonal::new(coefficients_mm.len());
        let auxiliary_mm = basis.auxiliary(coefficients_mm);
        let family = Family::Bfs { projection, basis, auxiliary_mm };
        Ok(QAsphere { base, rho_max_mm, coefficients_mm: coefficients_mm.to_vec(), family })
    }

    /// A Q-con asphere; as [`QAsphere::bfs`].
    pub fn con(
        base: ConicSection,
        rho_max_mm: f64,
        coefficients_mm: &[f64],
    ) -> Result<QAsphere, ShapeError> {
        check(CON, rho_max_mm, coefficients_mm)?;
        let family = Family::Con { basis: SagOrthogonal::new(coefficients_mm.len()) };
        Ok(QAsphere { base, rho_max_mm, coefficients_mm: coefficients_mm.to_vec(), family })
    }

    /// u² at t = ρ²; `None` beyond ρmax. What lies beyond only by the rounding of x² + y² is on the rim.
    fn x(&self, t: f64) -> Option<f64> {
        let x = t / self.rho_max_mm / self.rho_max_mm;
        (x <= 1.0 + 4.0 * f64::EPSILON).then(|| x.min(1.0))
    }

    /// The departure as a function of t = ρ².
    fn departure(&self, t: f64) -> Option<Taylor> {
        let x = self.x(t)?;
        let (envelope, sum, factor) = match &self.family {
            Family::Bfs { projection, auxiliary_mm, .. } => {
                let envelope = Taylor { value: x * (1.0 - x), first: 1.0 - 2.0 * x, second: -2.0 };
                let factor = projection.factor(&self.base, t)?;
                (envelope, SlopeOrthogonal::sum(auxiliary_mm, x), factor)
            }
            Family::Con { basis } => {
                let envelope = Taylor { value: x * x, first: 2.0 * x, second: 2.0 };
                (envelope, basis.sum(&self.coefficients_mm, x), UNITY)
            }
        };
        let by_x = envelope.times(sum);
        let scale = (self.rho_max_mm * self.rho_max_mm).recip();
        let by_t = Taylor {
            value: by_x.value,
            first: by_x.first * scale,
            second: by_x.second * scale * scale,
        };
        Some(factor.times(by_t))
    }
}

impl Shape for QAsphere {
    fn kind(&self) -> &'static str {
        match self.family {
            Family::Bfs { .. } => BFS,
            Family::Con { .. } => CON,
        }
    }

    fn jet(&self, x_mm: f64, y_mm: f64) -> Option<Jet> {
        let t = x_mm * x_mm + y_mm * y_mm;
        self.base.at(t)?.plus(self.departure(t)?).revolved(x_mm, y_mm)
    }

    fn sag_mm(&self, x_mm: f64, y_mm: f64) -> Option<f64> {
        let t = x_mm * x_mm + y_mm * y_mm;
        let x = self.x(t)?;
        let departure = match &self.family {
            Family::Bfs { projection, auxiliary_mm, .. } => {
                let sum = SlopeOrthogonal::value(auxiliary_mm, x);
                projection.factor(&self.base, t)?.value * (x * (1.0 - x) * sum)
            }
            Family::Con { basis } => x * x * basis.value(&self.coefficients_mm, x),
        };
        number(self.base.sag_mm(t)? + departure)
    }

    fn parameters(&self) -> Vec<ShapeParameter> {
        let mut parameters = self.base.parameters(NAMES);
        let terms = self.coefficients_mm.iter().enumerate();
        parameters.extend(terms.map(|(m, &value)| parameter(&format!("Q{m}"), "mm", value)));
        parameters
    }

    fn by_parameters(&self, x_mm: f64, y_mm: f64, derivatives: &mut [f64]) -> Option<()> {
        let t = x_mm * x_mm + y_mm * y_mm;
        let x = self.x(t)?;
        let (base, terms) = derivatives.split_at_mut(self.base.count());
        self.base.write_derivatives(t, base)?;
        let factor = match &self.family {
            Family::Bfs { projection, basis, auxiliary_mm } => {
                basis.values(x, terms);
                let envelope = x * (1.0 - x);
                let factor = projection.factor(&self.base, t)?.value;
                // The base turns the normal along which the departure is laid.
                let departure = factor * envelope * SlopeOrthogonal::value(auxiliary_mm, x);
                let turned = projection.relative_by_base(&self.base, t);
                base.iter_mut().zip(turned).for_each(|(d, relative)| *d += relative * departure);
                factor * envelope
            }
            Family::Con { basis } => {
                basis.values(x, terms);
                x * x
            }
        };
        terms.iter_mut().for_each(|term| *term *= factor);
        Some(())
    }

    fn with_parameters(&self, values: &[f64]) -> Result<Arc<dyn Shape>, ShapeError> {
        let kind = self.kind();
        count(kind, values, self.base.count() + self.coefficients_mm.len())?;
        let (base, terms) = values.split_at(self.base.count());
        let base = self.base.with_values(kind, NAMES, base)?;
        let shape = match self.family {
            Family::Bfs { projection, .. } => {
                QAsphere::bfs(base, self.rho_max_mm, projection, terms)
            }
            Family::Con { .. } => QAsphere::con(base, self.rho_max_mm, terms),
        };
        Ok(Arc::new(shape?))
    }

    /// ρmax, or where a root ends if that is nearer.
    fn domain_mm(&self) -> f64 {
        let root = match self.family {
            Family::Bfs { projection: Projection::SphereNormal, .. } => self.base.radius_mm().abs(),
            _ => f64::INFINITY,
        };
        self.rho_max_mm.min(self.base.domain_mm()).min(root)
    }
}

impl Projection {
    /// σ = √((1 − e·c²t)/(1 − d·c²t)): the pair (e, d).
    fn shapes(self, base: &ConicSection) -> [f64; 2] {
        match self {
            Projection::Axis => [0.0, 0.0],
            Projection::SphereNormal => [0.0, 1.0],
            Projection::ConicNormal => [base.conic(), 1.0 + base.conic()],
        }
    }

    /// σ as a function of t = ρ²; `None` from the end of its root on.
    fn factor(self, base: &ConicSection, t: f64) -> Option<Taylor> {
        if self == Projection::Axis || base.is_flat() {
            return Some(UNITY);
        }
        let [e, d] = self.shapes(base);
        let square = base.curvature_per_mm() * base.curvature_per_mm();
        let (above, below) = (1.0 - e * square * t, 1.0 - d * square * t);
        // With ln σ = (ln above − ln below)/2 every derivative of σ is σ times a polynomial in these.
        let (p, q) = (e * square / above, d * square / below);
        let rate = 0.5 * (q - p);
        (above > 0.0 && below > 0.0).then(|| {
            let value = (above / below).sqrt();
            let second = value * (rate * rate + 0.5 * (q * q - p * p));
            Taylor { value, first: value * rate, second }
        })
    }

    /// ∂σ/∂R and ∂σ/∂κ, each over σ.
    fn relative_by_base(self, base: &ConicSection, t: f64) -> [f64; 2] {
        let [e, d] = self.shapes(base);
        let c = base.curvature_per_mm();
        let w = c * c * t;
        let (above, below) = (1.0 - e * w, 1.0 - d * w);
        // c²t changes with R by −2c³t.
        let by_radius = -c * w * (d / below - e / above);
        let by_conic = match self {
            Projection::ConicNormal => 0.5 * w * (1.0 / below - 1.0 / above),
            _ => 0.0,
        };
        [by_radius, by_conic]
    }
}

fn check(kind: &'static str, rho_max_mm: f64, coefficients: &[f64]) -> Result<(), ShapeError> {
    let square = rho_max_mm * rho_max_mm;
    if !(rho_max_mm > 0.0 && square.is_normal() && square.recip().is_normal()) {
        return Err(refused(kind, "normalisation radius", rho_max_mm, "a finite number above 0"));
    }
    for (m, &value) in coefficients.iter().enumerate() {
        finite(kind, &format!("Q{m}"), value)?;
    }
    Ok(())
}

const UNITY: Taylor = Taylor { value: 1.0, first: 0.0, second: 0.0 };
const BFS: &str = "Q-bfs asphere";
const CON: &str = "Q-con asphere";
