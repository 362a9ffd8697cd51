//! The spacing that is asked for: wide enough for the noise, narrow enough for ε.

use asphera_geometry::{PointMm, RANGE_MM};
use thiserror::Error;

use crate::noise::{Noise, SpacingCriteria, truest_mm};

/// What a reduced cloud must hold.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Target {
    criteria: SpacingCriteria,
    lfs_max_mm: f64,
    noise: Option<Noise>,
    keep: Keep,
}

/// Which of the spacings between what noise needs and what ε allows is taken.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Keep {
    /// The widest that ε allows: the fewest points.
    #[default]
    Fewest,
    /// The one at which the facets have the truest normals, see [`crate::noise::Advice`]; without
    /// noise all points, as the denser they are the better.
    Truest,
    /// The narrowest that the noise allows: as many points as can be meshed; without noise all. A
    /// single spacing is the bound for facets of any shape; [`super::reduce()`] tries narrower ones.
    Most,
}

/// Data known of the points measured about a point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct About {
    /// Every point of the surface has a measured one within this distance in mm. Infinite or NaN:
    /// too wide for ε.
    pub gap_mm: f64,
    /// The same for all points next to it as well, at least that and finite where that is.
    pub gap_nearby_mm: f64,
    /// The z component of the unit normal where the surface is steepest, above 0, up to 1.
    pub cosine: f64,
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
    /// As [`Keep`] asks for, no wider than ε and no narrower than the noise allows: the target is
    /// reached.
    Epsilon,
    /// From the noise: ε would need a narrower spacing than the noise allows.
    Noise,
    /// From the noise, or zero where that is not at odds with the measured points: they are
    /// themselves hardly dense enough for ε.
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
    /// The limit of the tilt by noise is no angle between level and upright.
    #[error("the limit of the tilt is {0} rad, expected an angle above 0 and below pi/2")]
    Tilt(f64),
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
        if epsilon > 1.0 {
            return Err(TargetError::Epsilon(epsilon));
        }
        let criteria = SpacingCriteria::new(epsilon, None);
        let criteria = criteria.map_err(|_| TargetError::Epsilon(epsilon))?;
        if !(lfs_max_mm > 0.0 && lfs_max_mm <= RANGE_MM) {
            return Err(TargetError::LfsMax(lfs_max_mm));
        }
        Ok(Target { criteria, lfs_max_mm, noise: None, keep: Keep::Fewest })
    }

    /// A target among points with noise, of up to 1e12 mm. Without it the noise is none.
    ///
    /// # Errors
    ///
    /// Where it is larger.
    pub fn with_noise(self, noise: Noise) -> Result<Target, TargetError> {
        if noise.sigma_mm() > RANGE_MM {
            return Err(TargetError::Noise(noise.sigma_mm()));
        }
        Ok(Target { noise: Some(noise), ..self })
    }

    /// A target with a limit in rad of the tilt of facets by noise, above 0 and below π/2. Without it
    /// that is as large as ε: see [`SpacingCriteria`].
    ///
    /// # Errors
    ///
    /// Where it is no such angle.
    pub fn with_tilt_limit(self, tilt_limit_rad: f64) -> Result<Target, TargetError> {
        let criteria = SpacingCriteria::new(self.epsilon(), Some(tilt_limit_rad));
        let criteria = criteria.map_err(|_| TargetError::Tilt(tilt_limit_rad))?;
        Ok(Target { criteria, ..self })
    }

    /// A target with another choice among the spacings that satisfy both conditions.
    #[must_use]
    pub fn keeping(self, keep: Keep) -> Target {
        Target { keep, ..self }
    }

    /// ε as given.
    pub fn epsilon(&self) -> f64 {
        self.criteria.epsilon_limit()
    }

    /// Which of the spacings that satisfy both conditions is taken.
    pub fn keep(&self) -> Keep {
        self.keep
    }

    /// The limits of ε and of the tilt by noise.
    pub fn criteria(&self) -> &SpacingCriteria {
        &self.criteria
    }

    /// The noise, if one was given.
    pub fn noise(&self) -> Option<Noise> {
        self.noise
    }

    /// The local feature size the target goes by: no more than its largest; `None` where it is not
    /// known or no positive number.
    pub fn lfs_mm(&self, lfs_mm: Option<f64>) -> Option<f64> {
        lfs_mm.filter(|&lfs_mm| lfs_mm > 0.0).map(|lfs_mm| lfs_mm.min(self.lfs_max_mm))
    }

    /// Spacing at a measured point with the local feature size `lfs_mm`: between
    /// [`SpacingCriteria::packed_bound_mm`] and equation (1) of the reduction.
    ///
    /// About a point whose gap is not known it is that of points without gaps that the noise bounds.
    pub fn spacing(&self, lfs_mm: Option<f64>, about: About) -> Spacing {
        self.from(lfs_mm, about, self.narrowest_mm(about))
    }

    /// The narrowest spacing that the noise allows.
    pub(super) fn narrowest_mm(&self, about: About) -> f64 {
        let About { gap_nearby_mm, cosine, .. } = about;
        let gap_mm = if gap_nearby_mm.is_finite() { gap_nearby_mm } else { 0.0 };
        self.noise
            .map_or(0.0, |noise| self.criteria.packed_bound_mm(noise, gap_mm, cosine).min(RANGE_MM))
    }

    /// A target among points none of whose facets is too dense for the noise: no spacing is forced
    /// on them where ε does not allow it, and with [`Keep::Most`] none at all.
    pub(super) fn spacing_where_not_overdense(&self, lfs_mm: Option<f64>, about: About) -> Spacing {
        let spacing = self.spacing(lfs_mm, about);
        let most = spacing.bound == Bound::Epsilon && self.keep == Keep::Most;
        match spacing.bound {
            Bound::Noise | Bound::Sparse => Spacing { mm: 0.0, bound: Bound::Sparse },
            _ if most => Spacing { mm: 0.0, ..spacing },
            _ => spacing,
        }
    }

    fn from(&self, lfs_mm: Option<f64>, about: About, narrowest_mm: f64) -> Spacing {
        let Some(lfs_mm) = self.lfs_mm(lfs_mm) else {
            return Spacing { mm: 0.0, bound: Bound::Unknown };
        };
        let About { gap_mm, cosine, .. } = about;
        let epsilon = self.epsilon();
        let widest_mm = epsilon * (lfs_mm - gap_mm) / (1.0 + epsilon) - gap_mm;
        if widest_mm > 0.0 && widest_mm >= narrowest_mm {
            let sigma_mm = self.noise.map_or(0.0, |noise| noise.along_normal_mm(cosine));
            let mm = match self.keep {
                Keep::Fewest => widest_mm,
                Keep::Truest => truest_mm(sigma_mm, lfs_mm).clamp(narrowest_mm, widest_mm),
                Keep::Most => narrowest_mm,
            };
            Spacing { mm, bound: Bound::Epsilon }
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

    pub(super) fn scaled(self, share: f64) -> Spacing {
        Spacing { mm: share * self.mm, ..self }
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

/// Squared distance of two points.
pub(super) fn squared_mm2(p: PointMm, q: PointMm) -> f64 {
    let [x, y, z] = [p[0] - q[0], p[1] - q[1], p[2] - q[2]];
    x * x + y * y + z * z
}
