//! The minimum zone of simulated measurements.
//!
//! A zone is held by few points. To first order its width under errors is the answer to the same linear minimax problem as
//! in the search, with each distance larger by the error of its point ([`LinearZone`]); the points that hold it may be
//! others in each draw. Only points near the borders can come to hold it, so that a draw costs the same however many
//! points there are. The draws are those of the PV: the same simulated measurements.

use rayon::prelude::*;

use super::budget::UncertaintyError;
use super::linear::dot;
use super::philox::Numbers;
use super::simulate::{Draws, POINTS, Simulated, Source, factors, near_ends};
use crate::deviation::NM_PER_MM;
use crate::minimum_zone::LinearZone;
use crate::{FitSettings, ZoneFit, deviations};

impl Source<'_> {
    /// Width of the minimum zone in nm; `None` for one without a width. `O(n)` once, `O(c·(p + m))` an exchange of each draw
    /// for c points near the borders.
    pub(super) fn minimum_zone_nm(
        &self,
        zone: &ZoneFit,
        draws: &Draws,
    ) -> Result<Option<Simulated>, UncertaintyError> {
        draws.validate()?;
        let Source { linear, modes, budget, noise_mm2, .. } = self;
        let distances_mm = deviations(&linear.points, &zone.nominal, &zone.pose);
        // A zone that is laid anew gives way where a point sticks out, and others come nearer.
        let (near, capped) = near_ends(&distances_mm, GIVES_WAY * self.reach_mm(), MOST_NEAR);
        let rank_tolerance = FitSettings::default().rank_tolerance;
        let Some(problem) = LinearZone::new(&linear.points, &near, zone, rank_tolerance) else {
            return Ok(None);
        };
        let functions: Vec<Vec<f64>> =
            near.par_iter().map(|&place| modes.raw_at(place, linear, budget)).collect();
        let of_draw = |draw: u32| {
            let noise = Numbers::new(draws.seed, draw, POINTS);
            let factors = factors(draws.seed, draw, modes.functions());
            let error_mm = |(&place, functions): (&usize, &Vec<f64>)| {
                noise_mm2[place].sqrt() * noise.normal(place) + dot(functions, &factors)
            };
            let errors_mm: Vec<f64> = near.iter().zip(&functions).map(error_mm).collect();
            Some(problem.width_mm(&errors_mm) * NM_PER_MM)
        };
        let found: Vec<Option<f64>> = (0..draws.count).into_par_iter().map(of_draw).collect();
        Ok(Simulated::new(zone.zone_mm * NM_PER_MM, &found, (near.len(), capped)))
    }
}

/// How much farther from a border than for the PV a point may lie and yet come to hold the zone.
const GIVES_WAY: f64 = 2.0;
/// Points at either border that a draw looks at.
const MOST_NEAR: usize = 1024;
