//! Limits of the width of a minimum zone.
//!
//! Means over windows lie within any zone that holds the places themselves, so that the zone of such means, each nearer by
//! its margin, is no wider than that of the form ([`super::extremes`], with the zone as range). To first order its width
//! is the answer to the same linear minimax problem as in the search ([`LinearZone`]); means that are left out make it
//! narrower still. Above: with the multipliers λ of the points that hold the zone of the form, that zone is
//! Σ λ·s·d of its distances d, and the measured one no less than Σ λ·s·d of those measured (s = ±1 being the side): the difference
//! is the error of that sum.

use rayon::prelude::*;

use super::Uncertainty;
use super::budget::UncertaintyError;
use super::extremes::{Datum, End, Extremes, Outer};
use super::linear::dot;
use super::simulate::{Draws, OfDistances, Simulated};
use asphera_form::{FitSettings, LinearZone, NM_PER_MM, Side, ZoneFit, deviations};

impl Uncertainty {
    /// The width of a minimum zone of the same points in nm, at the measured places, by simulated measurements. `None` for a
    /// zone without a width.
    ///
    /// To first order: the errors must be small beside what bends the surface, which they are unless the fit
    /// itself is in doubt. `O(n log n)` once, `O(c·(p + m))` an exchange of each draw for c windows.
    pub fn minimum_zone_nm(
        &self,
        zone: &ZoneFit,
        draws: &Draws,
    ) -> Result<Option<Simulated>, UncertaintyError> {
        draws.validate()?;
        let linear = &self.linear;
        let distances_mm = deviations(&linear.points, &zone.nominal, &zone.pose);
        let known = OfDistances::new(self, &distances_mm);
        let errors = known.errors(self);
        let extremes = Extremes::new(&errors, Datum::Moving);
        let factors = extremes.range_factors(draws);
        let largest = factors.iter().copied().fold(0.0, f64::max);
        let rows: Vec<(f64, Outer)> = [(End::High, 1.0), (End::Low, -1.0)]
            .into_iter()
            .flat_map(|(end, sign)| {
                let outer = extremes.outermost(&errors, end, 0.5 * largest, MOST_WINDOWS);
                outer.into_iter().map(move |outer| (sign, outer))
            })
            .collect();
        let middles: Vec<usize> = rows.iter().map(|(_, outer)| outer.middle).collect();
        let rank_tolerance = FitSettings::default().rank_tolerance;
        let Some(problem) = LinearZone::new(&linear.points, &middles, zone, rank_tolerance) else {
            return Ok(None);
        };
        let measured = zone.zone_mm * NM_PER_MM;
        // So far apart, no mean of one end can come to hold the other.
        let widest = rows.iter().map(|(_, outer)| outer.margin).fold(0.0, f64::max);
        let apart_nm = 2.0 * (measured + largest * widest);
        let width_nm = |c: &f64| {
            let moved = rows.iter().map(|(sign, outer)| {
                let outwards = outer.height - c * outer.margin + apart_nm;
                sign * outwards / NM_PER_MM - distances_mm[outer.middle]
            });
            let width_nm = problem.width_mm(&moved.collect::<Vec<f64>>()) * NM_PER_MM;
            (width_nm - 2.0 * apart_nm).clamp(0.0, measured)
        };
        let limits = factors.par_iter().map(width_nm).collect();
        let above = vec![(measured, self.of_holding_nm(zone))];
        Ok(Some(Simulated::of_extremes(measured, limits, above, extremes.looked_at())))
    }

    /// Standard deviation in nm of the sum of distances that the multipliers make. Noise counts as if each point that holds a
    /// border held it alone, which is the most it may be.
    fn of_holding_nm(&self, zone: &ZoneFit) -> f64 {
        let Uncertainty { linear, modes, noise_mm2, budget, .. } = self;
        let mut waves_mm = vec![0.0; modes.functions()];
        let (mut noise, mut held) = (0.0, 0.0);
        for contact in &zone.contacts {
            // A zone of points that the fit does not have is none of its.
            let Ok(place) = linear.indices.binary_search(&contact.index) else { continue };
            let sign = if contact.side == Side::High { 1.0 } else { -1.0 };
            let share = 2.0 * contact.multiplier;
            noise += share.max(share * share) * noise_mm2[place];
            held += share;
            for (sum, value) in waves_mm.iter_mut().zip(modes.raw_at(place, linear, budget)) {
                *sum += sign * share * value;
            }
        }
        let most = noise_mm2.iter().copied().fold(0.0, f64::max);
        let noise = if held > 0.0 { noise * 2.0 / held } else { 2.0 * most };
        (noise + dot(&waves_mm, &waves_mm)).sqrt() * NM_PER_MM
    }
}

/// Windows at either border that a draw looks at.
const MOST_WINDOWS: usize = 1024;
