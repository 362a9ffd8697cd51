//! Numerical artefacts: data whose least-squares fit is known exactly.
//!
//! Forbes & Minh, Int. J. Metrol. Qual. Eng. 3 (2012) 145: choose the solution and points x* on the
//! surface with normals n; take any deviations e and remove from them the columns of the Jacobian J of the
//! orthogonal distance; the data x* + d·n then have the chosen solution as their exact least-squares fit,
//! because Jᵀ·d = 0. J does not depend on d (see the derivatives of the fit: the foot of x* + d·n is x*).
//!
//! The columns of J are smooth functions of the place, so d(x, y) = e(x, y) − Σ c_j·J_j(x, y) is a smooth
//! function too and can be evaluated anywhere; but only the sample it was made from, whole, has the known
//! solution.

use thiserror::Error;

use crate::fit::model::Model;
use crate::fit::refine::priority;
use crate::fit::solve::System;
use crate::fit::triangle::Triangle;
use crate::nominal::NominalError;
use crate::nominal::foot::{MeridianFoot, SurfaceFoot};
use crate::nominal::freeform;
use crate::{Nominal, Parameter, PointMm, Pose};

/// A part with a known solution and a known form error.
///
/// `E` gives the wanted form error in mm at a place (x, y) of the part frame in mm.
#[derive(Clone, Debug)]
pub struct Artefact<E> {
    nominal: Nominal,
    pose: Pose,
    free: Vec<Parameter>,
    coefficients: Vec<f64>,
    error_mm: E,
}

/// Why there is no artefact.
#[derive(Clone, Copy, Debug, Error, PartialEq)]
pub enum ArtefactError {
    /// The nominal is none.
    #[error("the nominal is not usable")]
    Nominal(#[from] NominalError),
    /// The nominal has no such parameter.
    #[error("a {kind} has no parameter {parameter}")]
    NoSuchParameter {
        /// The parameter.
        parameter: Parameter,
        /// Kind of the nominal.
        kind: &'static str,
    },
    /// A place outside the domain of the nominal.
    #[error("the nominal has no place ({x_mm}, {y_mm}) mm")]
    OutsideDomain {
        /// x in mm.
        x_mm: f64,
        /// y in mm.
        y_mm: f64,
    },
    /// A form error that is not finite.
    #[error("the form error at ({x_mm}, {y_mm}) mm is not finite")]
    NotFinite {
        /// x in mm.
        x_mm: f64,
        /// y in mm.
        y_mm: f64,
    },
}

impl<E: Fn(f64, f64) -> f64> Artefact<E> {
    /// An artefact whose fit with the parameters `free` over the sample of places (x, y), in mm in the part
    /// frame, is `nominal` at `pose`. `O(n·p²)` for n places and p parameters.
    ///
    /// Exactness ends with the rounding of the coordinates.
    pub fn new(
        nominal: Nominal,
        pose: Pose,
        free: &[Parameter],
        sample_mm: &[[f64; 2]],
        error_mm: E,
    ) -> Result<Artefact<E>, ArtefactError> {
        nominal.validate()?;
        if let Some(&parameter) = free.iter().find(|&&parameter| !nominal.has(parameter)) {
            return Err(ArtefactError::NoSuchParameter { parameter, kind: nominal.kind() });
        }
        let coefficients = vec![0.0; free.len()];
        let mut artefact = Artefact { nominal, pose, free: free.to_vec(), coefficients, error_mm };
        let order = priority(free, &artefact.nominal);
        // The second pass removes what rounding left of the first.
        for _ in 0..2 {
            let system = artefact.linearise(sample_mm)?;
            let kept = system.determinate(&order, RANK_TOLERANCE);
            let step = system.solve(&kept, 0.0);
            for (&index, change) in kept.iter().zip(&step.change) {
                // The step makes J·δ + d orthogonal to J, and d is e − Σ c·J.
                artefact.coefficients[index] -= change;
            }
        }
        Ok(artefact)
    }

    /// The form deviation in mm at a place of the part frame in mm; `None` outside the domain.
    pub fn deviation_mm(&self, x_mm: f64, y_mm: f64) -> Option<f64> {
        self.evaluate(x_mm, y_mm).map(|(_, deviation_mm)| deviation_mm)
    }

    /// The point of the part over the place (x, y) of the nominal, in the measured frame: foot plus
    /// deviation along the normal. `None` outside the domain.
    ///
    /// Places are those of the foot; on a slope the point itself stands beside it by the deviation times
    /// the sine of the slope.
    pub fn point_mm(&self, x_mm: f64, y_mm: f64) -> Option<PointMm> {
        let (foot, deviation_mm) = self.evaluate(x_mm, y_mm)?;
        let normal = foot.normal();
        let on_surface = [x_mm, y_mm, foot.point_height_mm()];
        Some(
            self.pose
                .to_measured(std::array::from_fn(|i| on_surface[i] + deviation_mm * normal[i])),
        )
    }

    /// The solution's shape.
    pub fn nominal(&self) -> &Nominal {
        &self.nominal
    }

    /// The solution's pose.
    pub fn pose(&self) -> &Pose {
        &self.pose
    }

    fn linearise(&self, sample_mm: &[[f64; 2]]) -> Result<System, ArtefactError> {
        let model = Model::new(&self.nominal, &self.pose, &self.free);
        let mut triangle = Triangle::new(model.columns());
        let mut row = vec![0.0; model.columns()];
        for &[x_mm, y_mm] in sample_mm {
            let (foot, deviation_mm) =
                self.evaluate(x_mm, y_mm).ok_or(ArtefactError::OutsideDomain { x_mm, y_mm })?;
            if !deviation_mm.is_finite() {
                return Err(ArtefactError::NotFinite { x_mm, y_mm });
            }
            model
                .derivatives(&foot, &mut row)
                .ok_or(ArtefactError::OutsideDomain { x_mm, y_mm })?;
            row[self.free.len()] = deviation_mm;
            triangle.push(&row);
        }
        triangle.flush();
        Ok(System::new(&triangle))
    }

    fn evaluate(&self, x_mm: f64, y_mm: f64) -> Option<(SurfaceFoot, f64)> {
        let foot = on_surface(&self.nominal, x_mm, y_mm)?;
        let model = Model::new(&self.nominal, &self.pose, &self.free);
        let mut derivatives = vec![0.0; self.free.len()];
        model.derivatives(&foot, &mut derivatives)?;
        let removed: f64 = derivatives.iter().zip(&self.coefficients).map(|(j, c)| j * c).sum();
        Some((foot, (self.error_mm)(x_mm, y_mm) - removed))
    }
}

/// The place (x, y) of the surface as its own foot.
fn on_surface(nominal: &Nominal, x_mm: f64, y_mm: f64) -> Option<SurfaceFoot> {
    if let Nominal::Freeform(shape) = nominal {
        return freeform::on_surface(shape.as_ref(), x_mm, y_mm).map(SurfaceFoot::Free);
    }
    let rho_mm = (x_mm * x_mm + y_mm * y_mm).sqrt();
    let profile = nominal.profile(rho_mm);
    if !profile.z_mm.is_finite() || !profile.slope.is_finite() {
        return None;
    }
    let n_z = (1.0 + profile.slope * profile.slope).sqrt().recip();
    let (cos, sin) = if rho_mm > 0.0 { (x_mm / rho_mm, y_mm / rho_mm) } else { (1.0, 0.0) };
    Some(SurfaceFoot::Meridian(MeridianFoot {
        rho_mm,
        zeta_mm: profile.z_mm,
        cos,
        sin,
        s_mm: rho_mm,
        n_r: -profile.slope * n_z,
        n_z,
        distance_mm: 0.0,
    }))
}

/// As in the fit: parameters the sample does not determine need no projection.
const RANK_TOLERANCE: f64 = 1e-10;
