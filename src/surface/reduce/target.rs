//! The spacing that is asked for: wide enough for the noise, narrow enough for ε.

use thiserror::Error;

use crate::area::Sum;
use crate::triangle::Triangle;
use crate::{PointMm, RANGE_MM, VertexId};

/// What a reduced cloud must hold.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Target {
    epsilon: f64,
    lfs_max_mm: f64,
    noise_sigma_mm: Option<f64>,
}

/// How near a point to be kept may come to one kept before, and what it follows from.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Spacing {
    mm: f64,
    bound: Bound,
}

/// What a spacing follows from.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Bound {
    /// From ε and the local feature size: the target is reached.
    Epsilon,
    /// From the noise: ε would need a narrower spacing than the noise allows.
    Noise,
    /// From the noise or zero: the measured points themselves are hardly dense enough for ε.
    Sparse,
    /// Zero: the local feature size is not known.
    Unknown,
    /// Given as a length.
    Given,
}

/// Why a reduction cannot be asked for.
#[derive(Clone, Copy, Debug, Error, PartialEq)]
pub enum TargetError {
    /// ε is not a number above 0 and up to 1.
    #[error("epsilon is {0}, expected a number above 0 and up to 1")]
    Epsilon(f64),
    /// The largest local feature size is not a length.
    #[error(
        "the largest local feature size is {0} mm, expected a length above 0 and up to 1e12 mm"
    )]
    LfsMax(f64),
    /// The noise is not a length.
    #[error("the noise is {0} mm, expected a standard deviation of at least 0 and up to 1e12 mm")]
    Noise(f64),
    /// A spacing is not a length.
    #[error("the spacing is {0} mm, expected a length of at least 0 and up to 1e12 mm")]
    Spacing(f64),
}

impl Target {
    /// A target for `epsilon`, above 0 and up to 1. The local feature size is taken as no more than
    /// `lfs_max_mm`, above 0 and finite: over a plane, where the local feature size is
    /// infinite, two points would do, which is hardly what is wanted.
    ///
    /// # Errors
    ///
    /// Where an argument is out of its range.
    pub fn new(epsilon: f64, lfs_max_mm: f64) -> Result<Target, TargetError> {
        if !(epsilon > 0.0 && epsilon <= 1.0) {
            return Err(TargetError::Epsilon(epsilon));
        }
        if !(lfs_max_mm > 0.0 && lfs_max_mm <= RANGE_MM) {
            return Err(TargetError::LfsMax(lfs_max_mm));
        }
        Ok(Target { epsilon, lfs_max_mm, noise_sigma_mm: None })
    }

    /// The same with a noise limit for heights of standard deviation `sigma_mm`, at least 0.
    ///
    /// # Errors
    ///
    /// Where that is not a length.
    pub fn with_noise(self, sigma_mm: f64) -> Result<Target, TargetError> {
        if !(0.0..=RANGE_MM).contains(&sigma_mm) {
            return Err(TargetError::Noise(sigma_mm));
        }
        Ok(Target { noise_sigma_mm: Some(sigma_mm), ..self })
    }

    /// ε as given.
    pub fn epsilon(&self) -> f64 {
        self.epsilon
    }

    /// Standard deviation of the noise in mm, if one was given.
    pub fn noise_sigma_mm(&self) -> Option<f64> {
        self.noise_sigma_mm
    }

    /// The local feature size the target goes by: no more than its largest; `None` where it is not
    /// known or no positive number.
    pub fn lfs_mm(&self, lfs_mm: Option<f64>) -> Option<f64> {
        lfs_mm.filter(|&lfs_mm| lfs_mm > 0.0).map(|lfs_mm| lfs_mm.min(self.lfs_max_mm))
    }

    /// Spacing at a measured point with the local feature size `lfs_mm`, where every point of the
    /// surface about it has a measured one within `gap_mm`: equations (1) and (3) of the reduction.
    ///
    /// A gap that is infinite or NaN is one too wide for ε.
    pub fn spacing(&self, lfs_mm: Option<f64>, gap_mm: f64) -> Spacing {
        let Some(lfs_mm) = self.lfs_mm(lfs_mm) else {
            return Spacing { mm: 0.0, bound: Bound::Unknown };
        };
        let widest_mm = self.epsilon * (lfs_mm - gap_mm) / (1.0 + self.epsilon) - gap_mm;
        let narrowest_mm =
            self.noise_sigma_mm.map_or(0.0, |sigma_mm| noise_limit_mm(sigma_mm, lfs_mm));
        if widest_mm > 0.0 && widest_mm >= narrowest_mm {
            Spacing { mm: widest_mm, bound: Bound::Epsilon }
        } else if widest_mm > 0.0 {
            Spacing { mm: narrowest_mm, bound: Bound::Noise }
        } else {
            Spacing { mm: narrowest_mm, bound: Bound::Sparse }
        }
    }
}

impl Spacing {
    /// A spacing given as a length in mm. With 0 a point is kept in any case.
    ///
    /// # Errors
    ///
    /// Where it is negative, not finite or above 1e12 mm.
    pub fn given(mm: f64) -> Result<Spacing, TargetError> {
        if (0.0..=RANGE_MM).contains(&mm) {
            Ok(Spacing { mm, bound: Bound::Given })
        } else {
            Err(TargetError::Spacing(mm))
        }
    }

    /// The length in mm, from 0 to twice 1e12.
    pub fn mm(&self) -> f64 {
        self.mm
    }

    /// What it follows from.
    pub fn bound(&self) -> Bound {
        self.bound
    }
}

/// The side in mm from which on noise of `sigma_mm` tilts no facet more than the bending of a
/// surface of local feature size `lfs_mm` does: equation (3) of the reduction.
pub fn noise_limit_mm(sigma_mm: f64, lfs_mm: f64) -> f64 {
    (2.0 * 3.0_f64.sqrt() * sigma_mm * lfs_mm).sqrt()
}

/// The share, by area in space, of those `triangles` that noise of `sigma_mm` tilts more than their
/// own bending does: that break equation (2) of the reduction, with the smallest local feature size
/// at their corners. `None` without triangles of known local feature size.
///
/// Only this part of a cloud is too dense for its noise. Linear time.
///
/// # Panics
///
/// When a corner is not the index of a point.
pub fn crumpled_fraction(
    points: &[PointMm],
    triangles: impl IntoIterator<Item = [VertexId; 3]>,
    target: &Target,
    sigma_mm: f64,
    lfs_mm: impl Fn(PointMm) -> Option<f64>,
) -> Option<f64> {
    let (mut crumpled, mut all) = (Sum::default(), Sum::default());
    for corners in triangles {
        let places = corners.map(|corner| points[corner as usize]);
        let known = places.map(|place| target.lfs_mm(lfs_mm(place)));
        let [Some(p), Some(q), Some(r)] = known else { continue };
        let lfs_mm = p.min(q).min(r);
        let area_mm2 = Triangle::new(points, corners).area_mm2();
        all.add(area_mm2);
        if tilts(places, sigma_mm, lfs_mm) {
            crumpled.add(area_mm2);
        }
    }
    (all.total() > 0.0).then(|| crumpled.total() / all.total())
}

/// Whether a facet breaks equation (2). One at the noise limit does not, whatever rounding says.
fn tilts([p, q, r]: [PointMm; 3], sigma_mm: f64, lfs_mm: f64) -> bool {
    let squares = [(p, q), (q, r), (r, p)].map(|(from, to)| squared_mm2(from, to));
    let sum: f64 = squares.iter().sum();
    let product: f64 = squares.iter().product();
    2.0 * sigma_mm * lfs_mm * sum.sqrt() > product.sqrt() * (1.0 + 1e-8)
}

/// Squared distance of two points.
pub(super) fn squared_mm2(p: PointMm, q: PointMm) -> f64 {
    let [x, y, z] = [p[0] - q[0], p[1] - q[1], p[2] - q[2]];
    x * x + y * y + z * z
}
