//! How densely a surface is to be sampled.

use std::f64::consts::{FRAC_1_SQRT_2, SQRT_2};

use thiserror::Error;

/// How far a place of the surface may lie from the nearest sample. Where several limits are given
/// the tightest counts.
///
/// The spacing that goes with a gap is that of a square raster: its gap is half the diagonal, so a
/// gap of g mm is met by a spacing of √2·g mm, in space, along the surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Target {
    /// Largest ε: gap over local feature size.
    pub epsilon: Option<f64>,
    /// Largest gap over the smallest local feature size of the whole surface, wherever it is.
    pub reach: Option<Reach>,
    /// Largest spacing of samples in mm.
    pub spacing_mm: Option<f64>,
}

/// A limit that holds everywhere alike: ρ = gap / reach. As no local feature size is below the reach, ε is
/// nowhere above ρ.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Reach {
    /// Largest ρ.
    pub ratio: f64,
    /// The reach: the smallest local feature size of the whole surface, in mm; infinite over a plane. None: it
    /// is not known, and so nothing is known to be within the target.
    pub lfs_min_mm: Option<f64>,
}

/// Why a target is none.
#[derive(Clone, Copy, Debug, Error, PartialEq)]
pub enum TargetError {
    /// A limit that is not a positive finite number.
    #[error("target {name} is {value}, expected a positive finite number")]
    Limit {
        /// Which limit.
        name: &'static str,
        /// Its value.
        value: f64,
    },
    /// No limit at all.
    #[error("a target needs a largest ε, a largest share of the reach or a largest spacing")]
    Nothing,
}

/// The spacing of samples that meets a target somewhere.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Spacing {
    /// At most so many mm.
    Mm(f64),
    /// Any: the surface is flat there, and nothing but ε is asked for.
    Any,
    /// The local feature size there is not known, or the reach.
    Unknown,
}

impl Target {
    /// Cocone's bound: the surface is reconstructed rightly if ε is below it (see
    /// [`crate::assess`]).
    pub const COCONE_EPSILON: f64 = 0.05;

    /// A target of ε alone.
    pub fn epsilon(epsilon: f64) -> Target {
        Target { epsilon: Some(epsilon), reach: None, spacing_mm: None }
    }

    /// A target of one spacing everywhere, in mm.
    pub fn spacing_mm(spacing_mm: f64) -> Target {
        Target { epsilon: None, reach: None, spacing_mm: Some(spacing_mm) }
    }

    /// A target of a gap that is a share of the reach everywhere.
    pub fn reach(ratio: f64, lfs_min_mm: f64) -> Target {
        let reach = Reach { ratio, lfs_min_mm: Some(lfs_min_mm) };
        Target { epsilon: None, reach: Some(reach), spacing_mm: None }
    }

    pub(super) fn validate(&self) -> Result<(), TargetError> {
        let reach = self.reach;
        let reach_mm = reach.and_then(|reach| reach.lfs_min_mm);
        let limits = [
            ("ε", self.epsilon),
            ("share of the reach", reach.map(|reach| reach.ratio)),
            // That of a plane is no limit, and no mistake.
            ("reach in mm", reach_mm.filter(|reach_mm| *reach_mm != f64::INFINITY)),
            ("spacing in mm", self.spacing_mm),
        ];
        for (name, value) in limits {
            if let Some(value) = value.filter(|value| !(value.is_finite() && *value > 0.0)) {
                return Err(TargetError::Limit { name, value });
            }
        }
        if (self.epsilon, self.reach, self.spacing_mm) == (None, None, None) {
            return Err(TargetError::Nothing);
        }
        Ok(())
    }

    /// The largest gap in mm where the local feature size is `lfs_mm`; infinite if any will do, none
    /// if that, or the reach, would have to be known.
    pub(super) fn gap_mm(&self, lfs_mm: Option<f64>) -> Option<f64> {
        let of_reach_mm = match self.reach {
            Some(reach) => reach.gap_mm()?,
            None => f64::INFINITY,
        };
        let of_epsilon_mm = match self.epsilon {
            Some(epsilon) => epsilon * lfs_mm?,
            None => f64::INFINITY,
        };
        Some(self.gap_of_spacing_mm().min(of_reach_mm).min(of_epsilon_mm))
    }

    /// The largest gap in mm whatever the local feature size; infinite if any will do, 0 if none is known to.
    pub(super) fn gap_anywhere_mm(&self) -> f64 {
        let of_reach_mm = self.reach.map_or(f64::INFINITY, |reach| reach.gap_mm().unwrap_or(0.0));
        self.gap_of_spacing_mm().min(of_reach_mm)
    }

    /// The local feature size at which a share of `epsilon` of it is the largest gap that ε and ρ allow
    /// everywhere, where `lfs_min_mm` is the smallest; none if that is not known.
    pub(super) fn tightest_lfs_mm(&self, epsilon: f64, lfs_min_mm: Option<f64>) -> Option<f64> {
        let Some(reach) = self.reach else { return lfs_min_mm };
        let of_reach_mm = reach.gap_mm()? / epsilon;
        match self.epsilon {
            Some(largest) => Some(of_reach_mm.min(largest / epsilon * lfs_min_mm?)),
            None => Some(of_reach_mm),
        }
    }

    fn gap_of_spacing_mm(&self) -> f64 {
        self.spacing_mm.map_or(f64::INFINITY, |mm| mm * FRAC_1_SQRT_2)
    }
}

impl Reach {
    /// The largest gap in mm, infinite over a plane; none if the reach is not known.
    fn gap_mm(&self) -> Option<f64> {
        self.lfs_min_mm.map(|lfs_min_mm| self.ratio * lfs_min_mm)
    }
}

impl Default for Target {
    /// ε up to [`Target::COCONE_EPSILON`].
    fn default() -> Target {
        Target::epsilon(Target::COCONE_EPSILON)
    }
}

impl Spacing {
    /// The spacing that goes with a largest gap.
    pub(super) fn of_gap(gap_mm: Option<f64>) -> Spacing {
        match gap_mm {
            None => Spacing::Unknown,
            Some(gap_mm) if gap_mm.is_finite() => Spacing::Mm(SQRT_2 * gap_mm),
            Some(_) => Spacing::Any,
        }
    }

    /// In mm, if it is a number.
    pub fn mm(self) -> Option<f64> {
        match self {
            Spacing::Mm(mm) => Some(mm),
            Spacing::Any | Spacing::Unknown => None,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_tightest_limit_counts() {
        let target = Target {
            epsilon: Some(0.05),
            reach: Some(Reach { ratio: 0.1, lfs_min_mm: Some(8.0) }),
            spacing_mm: Some(SQRT_2),
        };
        assert_eq!(target.gap_mm(Some(10.0)), Some(0.5));
        assert_eq!(target.gap_mm(Some(1000.0)), Some(0.8));
        assert_eq!(target.gap_mm(None), None);
        let target = Target { reach: None, ..target };
        assert_eq!(target.gap_mm(Some(f64::INFINITY)).map(f32_of), Some(1.0));
        assert_eq!(Target::default().gap_mm(Some(f64::INFINITY)), Some(f64::INFINITY));
        assert_eq!(Target::spacing_mm(2.0).gap_mm(None), Some(2.0 * FRAC_1_SQRT_2));
        assert_eq!(Target::reach(0.5, 3.0).gap_mm(None), Some(1.5));
        assert_eq!(Target::reach(0.5, f64::INFINITY).gap_mm(None), Some(f64::INFINITY));
    }

    #[test]
    fn with_a_reach_that_is_not_known_nothing_is_within() {
        let reach = Some(Reach { ratio: 0.1, lfs_min_mm: None });
        for spacing_mm in [None, Some(2.0)] {
            let target = Target { epsilon: None, reach, spacing_mm };
            assert_eq!(target.validate(), Ok(()));
            assert_eq!((target.gap_mm(Some(5.0)), target.gap_anywhere_mm()), (None, 0.0));
            assert_eq!(target.tightest_lfs_mm(0.1, Some(5.0)), None);
        }
    }

    #[test]
    fn the_tightest_local_feature_size_is_that_of_the_tighter_limit() {
        let target = |epsilon, ratio| {
            let reach = Some(Reach { ratio, lfs_min_mm: Some(8.0) });
            Target { epsilon, reach, spacing_mm: None }
        };
        let lfs_min_mm = Some(10.0);
        let tightest = |target: Target, epsilon| target.tightest_lfs_mm(epsilon, lfs_min_mm);
        assert_eq!(tightest(target(None, 0.125), 0.125), Some(8.0));
        // 0.5 mm by ε, 1 mm by ρ; then 2.5 mm by ε, 1 mm by ρ.
        assert_eq!(tightest(target(Some(0.0625), 0.125), 0.0625), Some(10.0));
        assert_eq!(tightest(target(Some(0.25), 0.125), 0.125), Some(8.0));
        assert_eq!(tightest(Target::epsilon(0.25), 0.25), lfs_min_mm);
    }

    fn f32_of(value: f64) -> f32 {
        value as f32
    }

    #[test]
    fn what_is_no_target() {
        for value in [0.0, -0.05, f64::NAN, f64::INFINITY] {
            for target in [
                Target::epsilon(value),
                Target::spacing_mm(value),
                Target::reach(value, 1.0),
                Target::reach(1.0, if value == f64::INFINITY { -value } else { value }),
            ] {
                assert!(matches!(target.validate(), Err(TargetError::Limit { .. })), "{target:?}");
            }
        }
        let nothing = Target { epsilon: None, reach: None, spacing_mm: None };
        assert_eq!(nothing.validate(), Err(TargetError::Nothing));
        let message = Target::epsilon(-1.0).validate().unwrap_err().to_string();
        assert_eq!(message, "target ε is -1, expected a positive finite number");
        assert_eq!(Target::default().validate(), Ok(()));
    }

    #[test]
    fn spacings_of_gaps() {
        assert_eq!(Spacing::of_gap(None).mm(), None);
        assert_eq!(Spacing::of_gap(Some(f64::INFINITY)), Spacing::Any);
        assert_eq!(Spacing::of_gap(Some(2.0)), Spacing::Mm(2.0 * SQRT_2));
    }
}
