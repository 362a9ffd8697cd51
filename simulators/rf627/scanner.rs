//! The scanner without a network: surfaces in, datagrams out.

use std::f64::consts::TAU;

use asphera_rf627::wire::{EncodeError, Format, Header, RawPoint, encode};
use rand_core::{Rng as _, SeedableRng as _};
use rand_pcg::Pcg64Mcg;

/// What does not change while a scanner runs.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Optics {
    /// Serial number.
    pub serial: u32,
    /// Width of the measuring range at its far end, mm.
    pub x_range_mm: u16,
    /// Measuring range in z, mm.
    pub z_range_mm: u16,
    /// Steps of a range.
    pub range_steps: u16,
    /// Points of a profile.
    pub points: usize,
    /// Length of the laser line in mm.
    pub line_mm: f64,
    /// Distance of the height 0 in mm.
    pub standoff_mm: f64,
    /// Standard deviation of the noise of z in µm.
    pub noise_um: f64,
    /// Profiles a second.
    pub rate_hz: f64,
}

impl Default for Optics {
    /// A small one, with 640 points on 10 mm.
    fn default() -> Optics {
        Optics {
            serial: 180_000,
            x_range_mm: 11,
            z_range_mm: 10,
            range_steps: 16_384,
            points: 640,
            line_mm: 10.0,
            standoff_mm: 5.0,
            noise_um: 0.0,
            rate_hz: 500.0,
        }
    }
}

/// A scanner that counts its datagrams and measurements.
#[derive(Clone, Debug)]
pub struct Scanner {
    optics: Optics,
    random: Pcg64Mcg,
    packet_count: u32,
    measure_count: u32,
    time_ns: u64,
}

impl Scanner {
    /// A scanner whose counters stand at zero. The same seed gives the same bytes.
    pub fn new(optics: Optics, seed: u64) -> Scanner {
        let random = Pcg64Mcg::seed_from_u64(seed);
        Scanner { optics, random, packet_count: 0, measure_count: 0, time_ns: 1_000_000_000 }
    }

    /// Time from one profile to the next in ns.
    pub fn period_ns(&self) -> u64 {
        (1e9 / self.optics.rate_hz) as u64
    }

    /// Switched off and on again: all counts begin anew.
    pub fn restart(&mut self) {
        (self.packet_count, self.measure_count, self.time_ns) = (0, 0, 0);
    }

    /// A measurement that is not sent, as of a scanner that is overrun.
    pub fn skip(&mut self) {
        self.measure_count = self.measure_count.wrapping_add(1);
        self.time_ns += self.period_ns();
    }

    /// Measures and gives the datagram. `height_mm` is the surface along the laser line; the encoder is at `step_count`.
    ///
    /// # Errors
    ///
    /// When the profile has too many points for a datagram.
    pub fn measure(
        &mut self,
        step_count: u32,
        height_mm: impl Fn(f64) -> Option<f64>,
    ) -> Result<Vec<u8>, EncodeError> {
        let header = Header {
            format: Format::Profile,
            serial: self.optics.serial,
            time_ns: self.time_ns,
            version: (1, 0),
            packet_count: self.packet_count,
            measure_count: self.measure_count,
            z_range_mm: self.optics.z_range_mm,
            x_range_mm: self.optics.x_range_mm,
            range_steps: self.optics.range_steps,
            licence_hash: 0,
            exposure_ns: 100_000,
            laser: 42,
            step_count,
            direction: 0,
        };
        let points: Vec<RawPoint> =
            (0..self.optics.points).map(|index| self.point(index, &height_mm)).collect();
        let mut datagram = Vec::new();
        encode(&header, &points, None, &mut datagram)?;
        self.skip();
        self.packet_count = self.packet_count.wrapping_add(1);
        Ok(datagram)
    }

    /// The surface is met at the rounded x, so that x has no error. Beyond the range there is no value.
    fn point(&mut self, index: usize, height_mm: impl Fn(f64) -> Option<f64>) -> RawPoint {
        let Optics { x_range_mm, z_range_mm, range_steps, points, line_mm, standoff_mm, .. } =
            self.optics;
        let [x_range_mm, z_range_mm, steps] = [x_range_mm, z_range_mm, range_steps].map(f64::from);
        let place = (index as f64 + 0.5) / points as f64 - 0.5;
        let x = (place * line_mm / x_range_mm * steps).round();
        let noise_mm = self.optics.noise_um * 1e-3 * self.normal();
        let z = height_mm(x * x_range_mm / steps)
            .map(|height_mm| (standoff_mm - height_mm + noise_mm) / z_range_mm * steps)
            .map(f64::round)
            .filter(|z| (1.0..=steps).contains(z));
        z.map_or(RawPoint { x: 0, z: 0 }, |z| RawPoint { x: x as i16, z: z as u16 })
    }

    /// A standard normal number: Box and Muller, A Note on the Generation of Random Normal Deviates,
    /// Ann. Math. Statist. 29 (1958), doi:10.1214/aoms/1177706645.
    fn normal(&mut self) -> f64 {
        // In (0, 1], so that the logarithm is finite.
        let mut uniform = || ((self.random.next_u64() >> 11) + 1) as f64 / (1_u64 << 53) as f64;
        (-2.0 * uniform().ln()).sqrt() * (TAU * uniform()).cos()
    }
}

#[cfg(test)]
mod tests {
    use asphera_rf627::wire::Packet;

    use super::*;

    #[test]
    fn points_lie_on_the_surface_to_half_a_step() {
        let mut scanner = Scanner::new(Optics::default(), 1);
        let datagram = scanner.measure(7, |x_mm| (x_mm < 4.0).then_some(0.1 * x_mm)).unwrap();
        let packet = Packet::decode(&datagram).unwrap();
        assert_eq!((packet.len(), packet.header.step_count), (640, 7));
        let half_step_mm = 0.5 * 10.0 / 16_384.0 + 1e-12;
        let points: Vec<_> = packet.points_mm().collect();
        assert!(points.iter().flatten().all(|[x, z]| (5.0 - 0.1 * x - z).abs() <= half_step_mm));
        // A tenth of the line is beyond 4 mm.
        assert_eq!(points.iter().flatten().count(), 576);
        let next = scanner.measure(8, |_| None).unwrap();
        let next = Packet::decode(&next).unwrap();
        assert_eq!((next.header.measure_count, next.header.packet_count), (1, 1));
        assert_eq!(next.header.time_ns - packet.header.time_ns, 2_000_000);
    }

    #[test]
    fn noise_has_the_spread_asked_for_and_repeats_with_its_seed() {
        let optics = Optics { noise_um: 20.0, points: 16_000, ..Optics::default() };
        let measure = |seed| Scanner::new(optics, seed).measure(0, |_| Some(0.0)).unwrap();
        assert_eq!(measure(3), measure(3));
        assert_ne!(measure(3), measure(4));
        let bytes = measure(3);
        let packet = Packet::decode(&bytes).unwrap();
        let squares: f64 = packet.points_mm().flatten().map(|[_, z]| (z - 5.0).powi(2)).sum();
        let spread_um = (squares / 16_000.0).sqrt() * 1e3;
        // Five standard errors of the spread.
        assert!((spread_um - 20.0).abs() < 5.0 * 20.0 / 32_000_f64.sqrt(), "{spread_um}");
    }
}
