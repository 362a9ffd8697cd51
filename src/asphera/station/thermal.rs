//! Thermal expansion of the part and of the scales of the machine: points as they are at 20 °C.

use std::time::Duration;

use asphera_link::{Flags, Nanos, Reading};
use asphera_report::ThermalFigures;

use super::kinematics::Point;

/// Temperature at which lengths are stated, °C (ISO 1:2022).
const REFERENCE_DEGC: f64 = 20.0;

/// Thermal expansion of a station.
///
/// A length L that the machine indicates is, at 20 °C,
///
/// ```text
/// L₂₀ = L · (1 + αs·(Ts − 20)) / (1 + αp·(Tp − 20))
/// ```
///
/// with coefficient α in 1/K and temperature T in °C of the scales (s) and the part (p).
#[derive(Clone, Debug, PartialEq)]
pub struct ThermalSettings {
    /// Expansion of the part; `None`: it is at 20 °C.
    pub part: Option<Expansion>,
    /// Expansion of the scales; `None`: they are at 20 °C.
    pub scales: Option<Expansion>,
    /// Age at which a measured temperature counts no more.
    pub stale: Duration,
    /// Lowest and highest temperature that a thermometer is believed, °C.
    pub range_degc: (f64, f64),
    /// Whether the first coordinate of a point is an angle, which does not expand.
    pub starts_with_angle: bool,
}

/// Linear expansion of a body.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Expansion {
    /// Source of its temperature.
    pub temperature: Temperature,
    /// Coefficient of linear expansion, 1/K.
    pub per_k: f64,
    /// Standard uncertainty of the coefficient, 1/K.
    pub u_per_k: f64,
    /// Standard uncertainty of the temperature, K.
    pub u_k: f64,
}

/// Source of a temperature.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Temperature {
    /// A temperature that is stated, °C.
    Constant(f64),
    /// A channel in °C of a device, both by their places in the configuration.
    Channel {
        /// Which device.
        device: usize,
        /// Which of its channels.
        channel: usize,
    },
}

/// Temperatures of a station as they come, and the expansion that follows.
#[derive(Clone, Debug)]
pub struct Thermal {
    settings: ThermalSettings,
    /// Line and device on that line of each device of the configuration.
    places: Vec<(usize, usize)>,
    part: Body,
    scales: Body,
    /// Smallest and largest relative change of lengths so far.
    changes: Option<(f64, f64)>,
    /// Largest relative standard uncertainty so far.
    u: f64,
}

/// A body whose temperature is known or not.
#[derive(Clone, Copy, Debug, Default)]
struct Body {
    /// Latest temperature in °C, and when it reached the host; a stated one is of no time.
    latest: Option<(f64, Option<Nanos>)>,
    /// Smallest and largest temperature that points were computed with, °C.
    range_degc: Option<(f64, f64)>,
}

impl Thermal {
    /// Expansion by `settings`; `places` are line and device on that line of each device of the configuration.
    pub fn new(settings: ThermalSettings, places: Vec<(usize, usize)>) -> Thermal {
        let body = |expansion: &Option<Expansion>| match expansion {
            Some(Expansion { temperature: Temperature::Constant(degc), .. }) => {
                Body { latest: Some((*degc, None)), range_degc: None }
            }
            _ => Body::default(),
        };
        let (part, scales) = (body(&settings.part), body(&settings.scales));
        Thermal { settings, places, part, scales, changes: None, u: 0.0 }
    }

    /// Takes a reading of a device: its temperature, if one is asked for and within the range that is believed.
    pub(super) fn take(&mut self, line: usize, device: usize, reading: &Reading) {
        let ThermalSettings { part, scales, range_degc: (low, high), .. } = &self.settings;
        for (body, expansion) in [(&mut self.part, part), (&mut self.scales, scales)] {
            let Some(Expansion {
                temperature: Temperature::Channel { device: of, channel }, ..
            }) = expansion
            else {
                continue;
            };
            if self.places.get(*of) != Some(&(line, device)) {
                continue;
            }
            let degc = reading.values.get(*channel).filter(|degc| (*low..=*high).contains(degc));
            body.latest = degc.map(|degc| (degc, Some(reading.host))).or(body.latest);
        }
    }

    /// Whether every temperature is known.
    pub(super) fn is_ready(&self) -> bool {
        let is_known = |expansion: &Option<Expansion>, body: &Body| {
            expansion.is_none() || body.latest.is_some()
        };
        is_known(&self.settings.part, &self.part) && is_known(&self.settings.scales, &self.scales)
    }

    /// Takes a point to 20 °C. It is flagged where a temperature is not known, or not since long.
    pub(super) fn apply(&mut self, point: &mut Point) {
        let stale = self.settings.stale;
        let excess = |expansion: &Option<Expansion>, body: &Body| match expansion {
            None => Some(0.0),
            Some(_) => {
                let (degc, at) = body.latest?;
                let age = at.map_or(Duration::ZERO, |at| point.host.since(at));
                (age <= stale).then_some(degc - REFERENCE_DEGC)
            }
        };
        let part_k = excess(&self.settings.part, &self.part);
        let scales_k = excess(&self.settings.scales, &self.scales);
        let Some((part_k, scales_k)) = part_k.zip(scales_k) else {
            point.flags |= Flags::NO_TEMPERATURE;
            return;
        };
        let per_k = |expansion: &Option<Expansion>| expansion.map_or(0.0, |known| known.per_k);
        let factor = (1.0 + per_k(&self.settings.scales) * scales_k)
            / (1.0 + per_k(&self.settings.part) * part_k);
        let first = usize::from(self.settings.starts_with_angle);
        point.position_mm[first..].iter_mut().for_each(|length_mm| *length_mm *= factor);
        if point.is_good() {
            self.note(factor - 1.0, part_k, scales_k);
        }
    }

    /// Notes what a good point was computed with.
    fn note(&mut self, change: f64, part_k: f64, scales_k: f64) {
        let widened = |range: Option<(f64, f64)>, value: f64| {
            let (low, high) = range.unwrap_or((value, value));
            Some((low.min(value), high.max(value)))
        };
        self.changes = widened(self.changes, change);
        self.part.range_degc = widened(self.part.range_degc, REFERENCE_DEGC + part_k);
        self.scales.range_degc = widened(self.scales.range_degc, REFERENCE_DEGC + scales_k);
        self.u = self.u.max(self.relative_u(part_k, scales_k));
    }

    /// Relative standard uncertainty of lengths at these temperatures above 20 °C (JCGM 100:2008, 5.1.2; of one thermometer
    /// for both, 5.2.2 with full correlation).
    fn relative_u(&self, part_k: f64, scales_k: f64) -> f64 {
        let ThermalSettings { part, scales, .. } = &self.settings;
        let of_coefficient = |expansion: &Option<Expansion>, excess_k: f64| {
            expansion.map_or(0.0, |known| known.u_per_k * excess_k)
        };
        let of_temperature =
            |expansion: &Option<Expansion>| expansion.map_or(0.0, |known| known.per_k * known.u_k);
        let coefficients = of_coefficient(part, part_k).hypot(of_coefficient(scales, scales_k));
        let is_one = part.zip(*scales).is_some_and(|(part, scales)| {
            part.temperature == scales.temperature
                && matches!(part.temperature, Temperature::Channel { .. })
        });
        let temperatures = match is_one {
            true => of_temperature(part) - of_temperature(scales),
            false => of_temperature(part).hypot(of_temperature(scales)),
        };
        coefficients.hypot(temperatures)
    }

    /// What good points were computed with; `None` before the first.
    pub(super) fn figures(&self) -> Option<ThermalFigures> {
        let (least, most) = self.changes?;
        let range = |expansion: &Option<Expansion>, body: &Body| {
            body.range_degc.filter(|_| expansion.is_some()).map(|(low, high)| [low, high])
        };
        Some(ThermalFigures {
            part_degc: range(&self.settings.part, &self.part),
            scales_degc: range(&self.settings.scales, &self.scales),
            lengths_um_per_m: [least * UM_PER_M, most * UM_PER_M],
            u_um_per_m: self.u * UM_PER_M,
        })
    }
}

const UM_PER_M: f64 = 1e6;

#[cfg(test)]
mod tests;
