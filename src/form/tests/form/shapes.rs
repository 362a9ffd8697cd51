//! Freeform shapes the tests fit: written out here, apart from those of the crate.

use std::sync::Arc;

use asphera_form::Nominal;
use asphera_form::shape::{Jet, Shape, ShapeError, ShapeParameter};

/// Parameters of these names and units.
fn named<const N: usize>(names: [(&str, &str); N], values: &[f64; N]) -> Vec<ShapeParameter> {
    let parameter = |((name, unit), value): ((&str, &str), &f64)| ShapeParameter {
        name: name.to_owned(),
        unit: unit.to_owned(),
        value: *value,
    };
    names.into_iter().zip(values).map(parameter).collect()
}

/// As many values as there are parameters.
fn counted<const N: usize>(kind: &'static str, values: &[f64]) -> Result<[f64; N], ShapeError> {
    let found = values.len();
    values.try_into().map_err(|_| ShapeError::Count { kind, found, expected: N })
}

/// `(c_x·x² + c_y·y²)/(1 + √(1 − (1+κ_x)·c_x²·x² − (1+κ_y)·c_y²·y²))` with R_x, R_y, κ_x, κ_y.
#[derive(Debug)]
pub(crate) struct Biconic(pub(crate) [f64; 4]);

/// Curvatures, squares of x and y in the root, and the root.
struct BiconicParts {
    c: [f64; 2],
    under: [f64; 2],
    phi: f64,
}

impl Biconic {
    fn parts(&self, x: f64, y: f64) -> Option<BiconicParts> {
        let [rx, ry, kx, ky] = self.0;
        let c = [rx.recip(), ry.recip()];
        let under = [(1.0 + kx) * c[0] * c[0], (1.0 + ky) * c[1] * c[1]];
        let square = 1.0 - under[0] * x * x - under[1] * y * y;
        (square > 0.0).then(|| BiconicParts { c, under, phi: square.sqrt() })
    }
}

impl Shape for Biconic {
    fn kind(&self) -> &'static str {
        "biconic"
    }

    fn parameters(&self) -> Vec<ShapeParameter> {
        named([("radius_x", "mm"), ("radius_y", "mm"), ("conic_x", "1"), ("conic_y", "1")], &self.0)
    }

    fn with_parameters(&self, values: &[f64]) -> Result<Arc<dyn Shape>, ShapeError> {
        Ok(Arc::new(Self(counted(self.kind(), values)?)))
    }

    fn jet(&self, x: f64, y: f64) -> Option<Jet> {
        let BiconicParts { c, under: [a, b], phi } = self.parts(x, y)?;
        let d = 1.0 + phi;
        let z = (c[0] * x * x + c[1] * y * y) / d;
        let (phi_x, phi_y) = (-a * x / phi, -b * y / phi);
        let (z_x, z_y) = ((2.0 * c[0] * x - z * phi_x) / d, (2.0 * c[1] * y - z * phi_y) / d);
        let cube = phi * phi * phi;
        let phi_xx = -a / phi - a * a * x * x / cube;
        let phi_yy = -b / phi - b * b * y * y / cube;
        let phi_xy = -a * b * x * y / cube;
        Some(Jet {
            z_mm: z,
            gradient: [z_x, z_y],
            hessian_per_mm: [
                (2.0 * c[0] - 2.0 * z_x * phi_x - z * phi_xx) / d,
                -(z_x * phi_y + z_y * phi_x + z * phi_xy) / d,
                (2.0 * c[1] - 2.0 * z_y * phi_y - z * phi_yy) / d,
            ],
        })
    }

    fn by_parameters(&self, x: f64, y: f64, derivatives: &mut [f64]) -> Option<()> {
        let BiconicParts { c, phi, .. } = self.parts(x, y)?;
        let z = self.jet(x, y)?.z_mm;
        for (axis, place) in [x, y].into_iter().enumerate() {
            let (c, k, square) = (c[axis], self.0[2 + axis], place * place);
            let phi_c = -(1.0 + k) * c * square / phi;
            derivatives[axis] = -c * c * (square - z * phi_c) / (1.0 + phi);
            derivatives[2 + axis] = z * c * c * square / (2.0 * phi) / (1.0 + phi);
        }
        Some(())
    }

    fn domain_mm(&self) -> f64 {
        let [rx, ry, kx, ky] = self.0;
        let reach =
            |r: f64, k: f64| if k > -1.0 { r.abs() / (1.0 + k).sqrt() } else { f64::INFINITY };
        reach(rx, kx).min(reach(ry, ky))
    }
}

/// `a·x² + b·x·y + c·y² + d·x³ + e·x²·y + f·y³`.
#[derive(Debug)]
pub(crate) struct Saddle(pub(crate) [f64; 6]);

impl Shape for Saddle {
    fn kind(&self) -> &'static str {
        "saddle"
    }

    fn parameters(&self) -> Vec<ShapeParameter> {
        named(
            [
                ("X2", "mm^-1"),
                ("X1Y1", "mm^-1"),
                ("Y2", "mm^-1"),
                ("X3", "mm^-2"),
                ("X2Y1", "mm^-2"),
                ("Y3", "mm^-2"),
            ],
            &self.0,
        )
    }

    fn with_parameters(&self, values: &[f64]) -> Result<Arc<dyn Shape>, ShapeError> {
        Ok(Arc::new(Self(counted(self.kind(), values)?)))
    }

    fn jet(&self, x: f64, y: f64) -> Option<Jet> {
        let [a, b, c, d, e, f] = self.0;
        (x.is_finite() && y.is_finite()).then_some(Jet {
            z_mm: a * x * x + b * x * y + c * y * y + d * x * x * x + e * x * x * y + f * y * y * y,
            gradient: [
                2.0 * a * x + b * y + 3.0 * d * x * x + 2.0 * e * x * y,
                b * x + 2.0 * c * y + e * x * x + 3.0 * f * y * y,
            ],
            hessian_per_mm: [
                2.0 * a + 6.0 * d * x + 2.0 * e * y,
                b + 2.0 * e * x,
                2.0 * c + 6.0 * f * y,
            ],
        })
    }

    fn by_parameters(&self, x: f64, y: f64, derivatives: &mut [f64]) -> Option<()> {
        derivatives.copy_from_slice(&[x * x, x * y, y * y, x * x * x, x * x * y, y * y * y]);
        Some(())
    }

    fn domain_mm(&self) -> f64 {
        f64::INFINITY
    }
}

/// A circle of radius `R_y` in the y-z plane, turned about the axis parallel to y at z = `R_x` > 0. With an
/// infinite `R_y` a cylinder along y.
#[derive(Debug)]
pub(crate) struct Toroid(pub(crate) [f64; 2]);

impl Shape for Toroid {
    fn kind(&self) -> &'static str {
        "toroid"
    }

    fn parameters(&self) -> Vec<ShapeParameter> {
        named([("radius_x", "mm"), ("radius_y", "mm")], &self.0)
    }

    fn with_parameters(&self, values: &[f64]) -> Result<Arc<dyn Shape>, ShapeError> {
        Ok(Arc::new(Self(counted(self.kind(), values)?)))
    }

    fn jet(&self, x: f64, y: f64) -> Option<Jet> {
        let [rx, ry] = self.0;
        let c = ry.recip();
        let phi = (1.0 - c * c * y * y).sqrt();
        let w = rx - c * y * y / (1.0 + phi);
        let (w_y, w_yy) = (-c * y / phi, -c / (phi * phi * phi));
        let s = (w * w - x * x).sqrt();
        let (g_x, g_y, g_yy) = (-2.0 * x, 2.0 * w * w_y, 2.0 * (w_y * w_y + w * w_yy));
        let cube = 4.0 * s * s * s;
        s.is_normal().then(|| Jet {
            z_mm: rx - s,
            gradient: [-g_x / (2.0 * s), -g_y / (2.0 * s)],
            hessian_per_mm: [
                1.0 / s + g_x * g_x / cube,
                g_x * g_y / cube,
                -g_yy / (2.0 * s) + g_y * g_y / cube,
            ],
        })
    }

    /// By differences that are exact enough for what the tests free of it: nothing but its rank.
    fn by_parameters(&self, x: f64, y: f64, derivatives: &mut [f64]) -> Option<()> {
        for index in 0..2 {
            let h = 1e-4 * self.0[index];
            let moved = |step: f64| {
                let mut values = self.0;
                values[index] += step;
                Toroid(values).sag_mm(x, y)
            };
            derivatives[index] = (moved(h)? - moved(-h)?) / (2.0 * h);
        }
        Some(())
    }

    fn domain_mm(&self) -> f64 {
        0.99 * self.0[0].abs().min(self.0[1].abs())
    }
}

/// A nominal of revolution in the guise of a freeform, without parameters.
#[derive(Debug)]
pub(crate) struct Revolved(pub(crate) Nominal);

impl Shape for Revolved {
    fn kind(&self) -> &'static str {
        "revolved"
    }

    fn jet(&self, x: f64, y: f64) -> Option<Jet> {
        self.0.jet(x, y)
    }

    fn parameters(&self) -> Vec<ShapeParameter> {
        Vec::new()
    }

    fn by_parameters(&self, _: f64, _: f64, _: &mut [f64]) -> Option<()> {
        Some(())
    }

    fn with_parameters(&self, _: &[f64]) -> Result<Arc<dyn Shape>, ShapeError> {
        Ok(Arc::new(Revolved(self.0.clone())))
    }

    fn domain_mm(&self) -> f64 {
        self.0.domain_mm()
    }
}

pub(crate) fn biconic() -> Nominal {
    Nominal::Freeform(Arc::new(Biconic([30.0, -45.0, -0.7, 0.4])))
}

pub(crate) fn saddle() -> Nominal {
    Nominal::Freeform(Arc::new(Saddle([1e-2, 2e-3, -8e-3, 2e-4, -1.5e-4, 1e-4])))
}

pub(crate) fn toroid() -> Nominal {
    Nominal::Freeform(Arc::new(Toroid([40.0, 65.0])))
}

pub(crate) fn cylinder() -> Nominal {
    Nominal::Freeform(Arc::new(Toroid([40.0, f64::INFINITY])))
}
