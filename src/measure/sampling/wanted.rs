//! How dense samples are to be, and the target that makes of it for a surface.

use std::f64::consts::SQRT_2;

use asphera_surface::coverage::{Reach, Target};
use asphera_surface::noise::SpacingCriteria;

use crate::Part;

/// How dense samples are to be. Where several limits are given the tightest counts.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Wanted {
    /// Largest ε: gap over the local feature size there.
    pub epsilon: Option<f64>,
    /// Largest ρ: gap over the reach, the smallest local feature size of the whole surface.
    pub rho: Option<f64>,
    /// Largest gap in mm; none: four times the distance the points have on average.
    pub gap_mm: Option<f64>,
}

impl Wanted {
    /// The largest ε where nothing is said: what Cocone's guarantees ask.
    pub const EPSILON: f64 = Target::COCONE_EPSILON;

    /// Wishes by these limits: where neither ε nor ρ is given, [`Wanted::EPSILON`] is.
    pub fn new(epsilon: Option<f64>, rho: Option<f64>, gap_mm: Option<f64>) -> Wanted {
        let epsilon = epsilon.or_else(|| rho.is_none().then_some(Wanted::EPSILON));
        Wanted { epsilon, rho, gap_mm }
    }

    /// Wishes of a part.
    pub(crate) fn of(part: &Part) -> Wanted {
        let Part { epsilon_limit, rho_limit, gap_limit_mm, .. } = *part;
        Wanted { epsilon: epsilon_limit, rho: rho_limit, gap_mm: gap_limit_mm }
    }

    /// The target where the largest gap is `gap_mm` and the reach `reach_mm`, infinite over a plane, none if it is
    /// not known.
    pub(super) fn target(&self, gap_mm: Option<f64>, reach_mm: Option<f64>) -> Target {
        Target {
            epsilon: self.epsilon,
            reach: self.rho.map(|ratio| Reach { ratio, lfs_min_mm: reach_mm }),
            spacing_mm: gap_mm.map(|gap_mm| SQRT_2 * gap_mm),
        }
    }

    /// The limits of density: noise may turn a facet by as much as the surface may turn over a gap, which is ε rad,
    /// and nowhere more than ρ rad. None where a limit is no share.
    pub(super) fn criteria(&self) -> Option<SpacingCriteria> {
        let share = self.epsilon.unwrap_or(f64::INFINITY).min(self.rho.unwrap_or(f64::INFINITY));
        SpacingCriteria::new(share, None).ok()
    }
}

impl Default for Wanted {
    fn default() -> Wanted {
        Wanted::new(None, None, None)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn without_a_share_it_is_that_of_cocone() {
        assert_eq!(Wanted::default().epsilon, Some(0.05));
        assert_eq!(Wanted::new(None, None, Some(1.0)).epsilon, Some(0.05));
        assert_eq!(Wanted::new(None, Some(0.2), None).epsilon, None);
        assert_eq!(Wanted::new(Some(0.1), Some(0.2), None).epsilon, Some(0.1));
    }

    #[test]
    fn the_smaller_share_is_the_limit_of_the_tilt() {
        let tilt_rad =
            |epsilon, rho| Wanted::new(epsilon, rho, None).criteria().map(|c| c.tilt_limit_rad());
        assert_eq!(tilt_rad(None, None), Some(0.05));
        assert_eq!(tilt_rad(None, Some(0.2)), Some(0.2));
        assert_eq!(tilt_rad(Some(0.1), Some(0.2)), Some(0.1));
        assert_eq!(tilt_rad(Some(0.1), Some(0.02)), Some(0.02));
        assert_eq!(tilt_rad(Some(-0.1), None), None);
    }
}
