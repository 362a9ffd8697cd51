//! Limits of a reduction, and the refusal where its result falls short of them.

use asphera_surface::reduce::{Shortfall, Target};

use crate::cli::output::Failure;

/// How near to a kept point every place of the surface is to be.
pub(super) struct Limits {
    /// As a share of the local feature size there.
    pub(super) epsilon: Option<f64>,
    /// As a share of the reach.
    pub(super) rho: Option<f64>,
    /// The smaller of both.
    pub(super) share: f64,
}

impl Limits {
    /// One of both has to be given. Fails where one is no share.
    pub(super) fn new(epsilon: Option<f64>, rho: Option<f64>) -> Result<Limits, Failure> {
        for (name, value) in [("epsilon", epsilon), ("rho", rho)] {
            if let Some(value) = value.filter(|value| !(*value > 0.0 && *value <= 1.0)) {
                let found = format!("{name} is {value}, expected a number above 0 and up to 1");
                return Err(found.into());
            }
        }
        let share = epsilon.unwrap_or(f64::INFINITY).min(rho.unwrap_or(f64::INFINITY));
        Ok(Limits { epsilon, rho, share })
    }

    /// The local feature size in mm a share of which is the smaller of both limits, at a place where it is `lfs_mm`. It
    /// changes by no more than the way gone, as that does: what ρ asks for is the same everywhere, and where that
    /// is the smaller share, it is the smaller limit everywhere.
    pub(super) fn limiting_mm(&self, lfs_mm: Option<f64>, reach_mm: Option<f64>) -> Option<f64> {
        let by_rho_mm = match self.rho {
            Some(rho) => rho / self.share * reach_mm?,
            None => f64::INFINITY,
        };
        match self.epsilon {
            Some(epsilon) => Some(by_rho_mm.min(epsilon / self.share * lfs_mm?)),
            None => Some(by_rho_mm),
        }
    }

    /// The refusal of a result that falls short: by how much, why, and the cure.
    pub(super) fn shortfall(&self, name: &str, target: &Target, found: Shortfall) -> Failure {
        let Shortfall { facets, epsilon_max } = found;
        let times = epsilon_max / self.share;
        let wider = |limit: &str, share: Option<f64>| {
            share.map(|share| format!("--{limit} {:.3}", 1.01 * times * share))
        };
        let wider: Vec<String> = [wider("epsilon", self.epsilon), wider("rho", self.rho)]
            .into_iter()
            .flatten()
            .collect();
        let sigma_nm = target.noise().map_or(0.0, |noise| noise.sigma_mm() * 1e6);
        let tilt_rad = target.criteria().tilt_limit_rad();
        format!(
            "{name}: {facets} facets of the kept points have gaps up to {times:.3} times the limit. Noise of {sigma_nm:.3} nm would tilt smaller facets by more than {tilt_rad:.4} rad. Allow {}, or more than --tilt {tilt_rad:.4}",
            wider.join(" and ")
        )
        .into()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_smaller_limit_is_a_share_of_what_limits() {
        let limiting = |epsilon, rho, lfs_mm| {
            let limits = Limits::new(epsilon, rho).unwrap();
            limits.limiting_mm(lfs_mm, Some(8.0)).map(|mm| limits.share * mm)
        };
        for (lfs_mm, gap_mm) in [(8.0, 1.0), (9.0, 1.125), (16.0, 2.0), (20.0, 2.0)] {
            // 0.125 of the local feature size, 2 mm.
            assert_eq!(limiting(Some(0.125), Some(0.25), Some(lfs_mm)), Some(gap_mm), "{lfs_mm}");
            assert_eq!(limiting(Some(0.5), Some(0.125), Some(lfs_mm)), Some(1.0), "{lfs_mm}");
            assert_eq!(limiting(None, Some(0.125), Some(lfs_mm)), Some(1.0), "{lfs_mm}");
            assert_eq!(limiting(Some(0.125), None, Some(lfs_mm)), Some(0.125 * lfs_mm));
        }
        assert_eq!(limiting(None, Some(0.125), None), Some(1.0));
        assert_eq!(limiting(Some(0.1), Some(0.1), None), None);
        assert_eq!(Limits::new(None, Some(0.1)).unwrap().limiting_mm(Some(9.0), None), None);
    }

    #[test]
    fn shares_are_above_0_and_up_to_1() {
        for value in [0.0, -0.1, 2.0, f64::NAN, f64::INFINITY] {
            for (epsilon, rho, name) in [
                (Some(value), None, "epsilon"),
                (Some(0.1), Some(value), "rho"),
                (None, Some(value), "rho"),
            ] {
                let Err(found) = Limits::new(epsilon, rho) else { panic!("{value}") };
                let found = found.to_string();
                assert!(found.starts_with(name) && found.contains("up to 1"), "{found}");
            }
        }
    }
}
