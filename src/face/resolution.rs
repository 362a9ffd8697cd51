//! The waves of a form that come through blur and its correction.

use std::f64::consts::TAU;

/// What a face keeps of a wave of its form, by the length of the wave.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Response {
    /// Standard deviation of the blur, mm.
    pub(crate) blur_mm: f64,
    /// Reach of the paraboloids that tell the Laplacian, mm.
    pub(crate) reach_mm: f64,
    /// Factor of the correction.
    pub(crate) taken: f64,
}

impl Response {
    /// The height that is found of a wave, as a share of its own: 1 where nothing is lost.
    ///
    /// Blur leaves exp(−k²σ²/2). The correction adds `taken`·k²σ²/2 times what a paraboloid over a disc finds of the Laplacian,
    /// 48·J₃(kR)/(kR)³, which follows from the Fourier transform of the Zernike polynomial of defocus (Noll 1976, eq. 8).
    pub(crate) fn of_wave(self, length_mm: f64) -> f64 {
        let k_per_mm = TAU / length_mm;
        let half = 0.5 * (k_per_mm * self.blur_mm).powi(2);
        (-half).exp() * (1.0 + self.taken * half * share_of_laplacian(k_per_mm * self.reach_mm))
    }

    /// The length, mm, above which all waves keep their height to `share`; 0 without blur.
    pub(crate) fn least_mm(self, share: f64) -> f64 {
        let steps = 4000;
        let lengths =
            (1..=steps).map(|step| LONGEST * self.blur_mm * f64::from(step) / f64::from(steps));
        lengths
            .rev()
            .find(|&length_mm| (self.of_wave(length_mm) - 1.0).abs() > share)
            .unwrap_or(0.0)
    }
}

/// 48·J₃(z)/z³ by its series, for z up to some 20.
fn share_of_laplacian(z: f64) -> f64 {
    let square = -0.25 * z * z;
    // 48/2³ over 3!.
    let (mut term, mut sum) = (1.0, 0.0);
    for m in 1..=TERMS {
        sum += term;
        let m = f64::from(m);
        term *= square / (m * (m + 3.0));
    }
    sum
}

/// Waves longer than this many standard deviations of the blur lose nothing.
const LONGEST: f64 = 60.0;
/// Terms of the series.
const TERMS: u32 = 60;

#[cfg(test)]
mod tests {
    use asphera_form::{Aperture, Nominal};
    use asphera_measure::Part;

    use super::*;
    use crate::{Body, Lattice, Scan, Settings, Threshold};

    /// J₃ of Abramowitz and Stegun, Handbook of Mathematical Functions, table 9.2: J₃(2) = 0.12894 32495, J₃(5) = 0.36483 12306.
    #[test]
    fn the_share_is_that_of_bessel_tables() {
        for (z, j3) in [(2.0_f64, 0.128_943_249_5), (5.0, 0.364_831_230_6)] {
            assert!((share_of_laplacian(z) - 48.0 * j3 / z.powi(3)).abs() < 1e-8, "{z}");
        }
        assert_eq!(share_of_laplacian(0.0), 1.0);
    }

    /// Waves on a plane, whose blurred values are known for a low wave: the part of the height that is found is the one expected.
    #[test]
    fn waves_have_the_height_that_the_response_says() {
        for length in [12.0, 15.0, 20.0, 30.0] {
            let (sigma, height, h_mm) = (1.0_f64, 0.02, 0.1);
            let k = TAU / length;
            let kept = height * (-0.5 * (k * sigma).powi(2)).exp();
            let size = [80, 80, 48];
            let mut values = Vec::new();
            for z in 0..size[2] {
                for _ in 0..size[1] {
                    for x in 0..size[0] {
                        let above = z as f64 - 23.4 - kept * (k * x as f64).cos();
                        let share = 0.5 * (1.0 - libm::erf(above / (sigma * 2.0_f64.sqrt())));
                        values.push((1000.0 + 20_000.0 * share) as f32);
                    }
                }
            }
            let steps_mm = [[h_mm, 0.0, 0.0], [0.0, h_mm, 0.0], [0.0, 0.0, h_mm]];
            let lattice = Lattice { origin_mm: [0.0; 3], steps_mm };
            let body = Body::new(Scan { values, size, lattice }, 1.0);
            let part = Part {
                aperture: Aperture::Circle { radius_mm: 2.2 },
                centre_mm: [3.9, 3.9],
                ..Part::new(Nominal::Plane)
            };
            let settings = Settings {
                threshold: Threshold::Halfway(11_000.0),
                u_threshold: None,
                along: Some([0.0, 0.0, 1.0]),
            };
            let face = body.face(&part, &settings).unwrap();
            // The wave by least squares over the points, of which those near the border have no whole disc about them.
            let (mut sum, mut squares) = (0.0, 0.0);
            for [x, y, z] in &face.points_mm {
                if (x - 3.9).hypot(y - 3.9) < 1.5 {
                    let wave = (k * x / h_mm).cos();
                    sum += wave * (z - 2.34) / h_mm;
                    squares += wave * wave;
                }
            }
            let found = sum / squares / height;
            let blur_mm = 1e-3 * face.figures.blur_um;
            let response = Response { blur_mm, reach_mm: (4.0 * blur_mm).max(0.5), taken: 1.2 };
            let expected = response.of_wave(length * h_mm);
            assert!((found - expected).abs() < 0.01, "{length}: {found} {expected}");
            let said = face.figures.reasons.join(" ");
            assert!(said.contains("loses more than 1 %"), "{said}");
        }
    }

    #[test]
    fn long_waves_are_kept_and_short_ones_lost() {
        let response = Response { blur_mm: 1.0, reach_mm: 4.0, taken: 1.2 };
        assert!((response.of_wave(100.0) - 1.0).abs() < 1e-3);
        assert!(response.of_wave(3.0) < 0.2);
        let [one, five] = [0.01, 0.05].map(|share| response.least_mm(share));
        assert!(one > five && (response.of_wave(five) - 0.95).abs() < 2e-3, "{one} {five}");
        assert_eq!(Response { blur_mm: 0.0, ..response }.least_mm(0.01), 0.0);
    }
}
