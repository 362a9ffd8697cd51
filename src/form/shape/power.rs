//! Aspheres of revolution from powers of the distance from the axis: even, and even and odd.

use std::sync::Arc;

use super::argument::{coefficient, count};
use super::even_powers::{EvenPowers, dense};
use super::section::{ConicSection, NAMES};
use super::taylor::{defined, number};
use super::{Jet, Shape, ShapeError, ShapeParameter};

/// An even asphere: `z = conic(r) + Σ A_n·r^n`, n even from 2 on.
///
/// ISO 10110-12:2019 begins at r⁴; Zemax' EVENASPH begins at r², and its `PARM 1` is A2 here. A2 and the
/// radius bend the vertex alike, and only beyond it do they differ: a fit of both is badly conditioned
/// unless the aperture is large or the base flat.
#[derive(Clone, Debug, PartialEq)]
pub struct EvenAsphere {
    base: ConicSection,
    powers: EvenPowers,
}

impl EvenAsphere {
    /// From the base and the terms (order, coefficient in mm^(1−order)). Parameters `radius` and `conic`,
    /// unless the base is flat, and `A2`, `A4` … of the terms given, those with the value 0 too. Fails on
    /// an order that is odd, 0 or given twice, and on a coefficient that is not finite.
    pub fn new(base: ConicSection, terms: &[(u8, f64)]) -> Result<EvenAsphere, ShapeError> {
        Ok(EvenAsphere { base, powers: EvenPowers::new(EVEN, terms)? })
    }
}

impl Shape for EvenAsphere {
    fn kind(&self) -> &'static str {
        EVEN
    }

    fn jet(&self, x_mm: f64, y_mm: f64) -> Option<Jet> {
        let t = x_mm * x_mm + y_mm * y_mm;
        self.base.at(t)?.plus(self.powers.at(t)).revolved(x_mm, y_mm)
    }

    fn sag_mm(&self, x_mm: f64, y_mm: f64) -> Option<f64> {
        let t = x_mm * x_mm + y_mm * y_mm;
        number(self.base.sag_mm(t)? + self.powers.value(t))
    }

    fn parameters(&self) -> Vec<ShapeParameter> {
        let mut parameters = self.base.parameters(NAMES);
        parameters.extend(self.powers.parameters());
        parameters
    }

    fn by_parameters(&self, x_mm: f64, y_mm: f64, derivatives: &mut [f64]) -> Option<()> {
        let t = x_mm * x_mm + y_mm * y_mm;
        let (base, powers) = derivatives.split_at_mut(self.base.count());
        self.base.write_derivatives(t, base)?;
        self.powers.write_derivatives(t, powers);
        Some(())
    }

    fn with_parameters(&self, values: &[f64]) -> Result<Arc<dyn Shape>, ShapeError> {
        count(EVEN, values, self.base.count() + self.powers.count())?;
        let (base, powers) = values.split_at(self.base.count());
        Ok(Arc::new(EvenAsphere {
            base: self.base.with_values(EVEN, NAMES, base)?,
            powers: self.powers.with_values(EVEN, powers)?,
        }))
    }

    fn domain_mm(&self) -> f64 {
        self.base.domain_mm()
    }
}

/// An asphere with odd orders too: `z = conic(r) + Σ A_n·r^n`, n from 1 on (ISO 10110-12:2019; Zemax'
/// ODDASPHE, whose `PARM 1` is A1).
///
/// With A1 other than 0 the vertex is the tip of a cone. There [`Shape::sag_mm`] gives its height, while
/// [`Shape::jet`] and [`Shape::by_parameters`] give `None`: a tip has no tangent plane, and any one slope
/// would be a guess.
#[derive(Clone, Debug, PartialEq)]
pub struct OddAsphere {
    base: ConicSection,
    /// The orders that are parameters, ascending.
    orders: Vec<u8>,
    /// `dense[i]` belongs to r^(i+1).
    dense: Vec<f64>,
}

impl OddAsphere {
    /// From the base and the terms (order, coefficient in mm^(1−order)), even orders included. Parameters
    /// `radius` and `conic`, unless the base is flat, and `A1`, `A2` … of the terms given. Fails on an
    /// order that is 0 or given twice, and on a coefficient that is not finite.
    pub fn new(base: ConicSection, terms: &[(u8, f64)]) -> Result<OddAsphere, ShapeError> {
        let (orders, dense) = dense(ODD, terms, 1)?;
        Ok(OddAsphere { base, orders, dense })
    }

    /// With P = Σ A_n·r^n: P, P′/r and P″ − P′/r. `None` at a tip.
    fn powers(&self, r: f64) -> Option<(f64, f64, f64)> {
        let tip = self.dense.first().copied().unwrap_or(0.0);
        let (mut sum, mut slope, mut cross) = (0.0, 0.0, 0.0);
        let above = self.dense.iter().enumerate().skip(1).rev();
        for (index, a) in above {
            // This term is A_n·r^n; the three sums run over A_n·r^(n−2) with weights 1, n and n(n−2).
            let n = (index + 1) as f64;
            sum = sum * r + a;
            slope = slope * r + n * a;
            cross = cross * r + n * (n - 2.0) * a;
        }
        if tip == 0.0 {
            return Some((r * r * sum, slope, cross));
        }
        (r > 0.0).then(|| (r * (tip + r * sum), tip / r + slope, cross - tip / r))
    }
}

impl Shape for OddAsphere {
    fn kind(&self) -> &'static str {
        ODD
    }

    fn jet(&self, x_mm: f64, y_mm: f64) -> Option<Jet> {
        let base = self.base.at(x_mm * x_mm + y_mm * y_mm)?.revolved(x_mm, y_mm)?;
        let r = x_mm.hypot(y_mm);
        let (sum, slope, cross) = self.powers(r)?;
        // At the vertex the direction is free, and `cross` is 0.
        let (cos, sin) = if r > 0.0 { (x_mm / r, y_mm / r) } else { (1.0, 0.0) };
        let [xx, xy, yy] = base.hessian_per_mm;
        defined(Jet {
            z_mm: base.z_mm + sum,
            gradient: [base.gradient[0] + slope * x_mm, base.gradient[1] + slope * y_mm],
            hessian_per_mm: [
                xx + slope + cross * cos * cos,
                xy + cross * cos * sin,
                yy + slope + cross * sin * sin,
            ],
        })
    }

    fn sag_mm(&self, x_mm: f64, y_mm: f64) -> Option<f64> {
        let r = x_mm.hypot(y_mm);
        let sum = r * self.dense.iter().rev().fold(0.0, |sum, a| sum * r + a);
        number(self.base.sag_mm(x_mm * x_mm + y_mm * y_mm)? + sum)
    }

    fn parameters(&self) -> Vec<ShapeParameter> {
        let mut parameters = self.base.parameters(NAMES);
        let terms = self.orders.iter().map(|&n| coefficient(n, self.dense[usize::from(n) - 1]));
        parameters.extend(terms);
        parameters
    }

    fn by_parameters(&self, x_mm: f64, y_mm: f64, derivatives: &mut [f64]) -> Option<()> {
        let r = x_mm.hypot(y_mm);
        let (base, powers) = derivatives.split_at_mut(self.base.count());
        self.powers(r)?;
        self.base.write_derivatives(x_mm * x_mm + y_mm * y_mm, base)?;
        for (derivative, &order) in powers.iter_mut().zip(&self.orders) {
            *derivative = r.powi(i32::from(order));
        }
        Some(())
    }

    fn with_parameters(&self, values: &[f64]) -> Result<Arc<dyn Shape>, ShapeError> {
        count(ODD, values, self.base.count() + self.orders.len())?;
        let (base, powers) = values.split_at(self.base.count());
        let terms: Vec<_> = self.orders.iter().copied().zip(powers.iter().copied()).collect();
        let base = self.base.with_values(ODD, NAMES, base)?;
        Ok(Arc::new(OddAsphere::new(base, &terms)?))
    }

    fn domain_mm(&self) -> f64 {
        self.base.domain_mm()
    }
}

const EVEN: &str = "even asphere";
const ODD: &str = "odd asphere";
