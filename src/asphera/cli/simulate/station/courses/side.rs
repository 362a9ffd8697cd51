//! A shaft or a ball that turns beside a line scanner.

use asphera_form::form_error::FormError;
use asphera_geometry::Numbers;
use asphera_measure::Part;

use super::super::super::super::output::Failure;
use super::MM_PER_NM;
use crate::cli::simulate::station::PartArgs;
use crate::config::Config;

/// A part that turns about z, seen along its radius: a cylinder along z, or a ball about the origin.
pub(super) struct Side {
    radius_mm: f64,
    is_ball: bool,
    form: FormError,
    /// Amount by which the form error is taken.
    share: f64,
    noise_nm: f64,
    noise: Numbers,
}

impl Side {
    /// The part of a configuration before a scanner that sees distances from the axis in this range, mm.
    pub(super) fn new(
        config: &Config,
        args: &PartArgs,
        range_mm: [f64; 2],
    ) -> Result<Side, Failure> {
        let radius_mm = Side::radius_mm(&config.part)?;
        let [low_mm, high_mm] = range_mm;
        if !(low_mm..=high_mm).contains(&radius_mm) {
            return Err(format!("the part has a radius of {radius_mm:.3} mm, and the scanner sees {low_mm:.3} to {high_mm:.3} mm from the axis of rotation: set offset_mm of [kinematics] height").into());
        }
        let mut side = Side {
            radius_mm,
            is_ball: config.part.nominal.kind() == BALL,
            form: FormError::typical(radius_mm),
            share: 1.0,
            noise_nm: args.noise_nm,
            noise: Numbers::new(args.seed, 0, 0),
        };
        let steps = || (0..SAMPLES).map(|k| f64::from(k) / f64::from(SAMPLES));
        let errors = steps().flat_map(|turn| steps().map(move |along| (turn, along)));
        let (lowest, highest) = errors
            .map(|(turn, along)| {
                side.error_nm(turn * std::f64::consts::TAU, (2.0 * along - 1.0) * radius_mm)
            })
            .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), nm| {
                (low.min(nm), high.max(nm))
            });
        side.share = if highest > lowest { args.form_nm / (highest - lowest) } else { 0.0 };
        Ok(side)
    }

    /// Radius of a cylinder or a sphere, mm: (d² + z²) / 2z of its height z beside its vertex by d.
    pub(super) fn radius_mm(part: &Part) -> Result<f64, Failure> {
        let kind = part.nominal.kind();
        if ![BALL, "cylinder"].contains(&kind) {
            return Err(format!("[kinematics]: expected a cylinder or a sphere for profile = \"axial\", found the nominal {kind}, which is not simulated from its side: with profile = \"radial\" it is").into());
        }
        let heights = [[1.0, 0.0], [0.0, 1.0]].into_iter().flat_map(|[x, y]| {
            (0..DOUBLINGS).map_while(move |k| {
                let beside_mm = FIRST_MM * f64::from(1_u32 << k);
                let height_mm = part.nominal.height_mm(x * beside_mm, y * beside_mm)?;
                Some((beside_mm, height_mm.abs()))
            })
        });
        let farthest = heights.filter(|(_, z)| *z > 0.0).max_by(|(a, _), (b, _)| a.total_cmp(b));
        let radius = farthest.map(|(beside_mm, z)| (beside_mm * beside_mm + z * z) / (2.0 * z));
        radius.ok_or_else(|| "[nominal.surface]: expected a radius".into())
    }

    /// Distance from the axis of rotation at which a beam towards it meets the part, mm. The beam passes the axis by `tangential_mm` at
    /// `along_mm` along it; the part stands at `angle_rad`. `None` where the beam meets no part.
    pub(super) fn distance_mm(
        &self,
        index: usize,
        angle_rad: f64,
        tangential_mm: f64,
        along_mm: f64,
    ) -> Option<f64> {
        // Its radius at this height: of a ball that of a circle.
        let radius_mm = match self.is_ball {
            true if along_mm.abs() > STEEP * self.radius_mm => return None,
            true => (self.radius_mm * self.radius_mm - along_mm * along_mm).sqrt(),
            false => self.radius_mm,
        };
        let chord_mm = |radius_mm: f64| {
            let square = radius_mm * radius_mm - tangential_mm * tangential_mm;
            (square > 0.0).then(|| square.sqrt())
        };
        let beside_rad = tangential_mm.atan2(chord_mm(radius_mm)?);
        let error_mm = MM_PER_NM * self.error_nm(angle_rad + beside_rad, along_mm);
        let noise_mm = MM_PER_NM * self.noise_nm * self.noise.normal(index);
        Some(chord_mm(radius_mm + error_mm)? + noise_mm)
    }

    /// Form error along the radius, nm. It is the same after a turn.
    fn error_nm(&self, angle_rad: f64, along_mm: f64) -> f64 {
        let (sin, cos) = angle_rad.sin_cos();
        let wave = (along_mm / self.radius_mm).cos();
        let at_mm = 0.7 * self.radius_mm;
        self.share * self.form.height_nm(at_mm * wave * cos, at_mm * sin)
    }
}

/// Kind of a nominal that is a ball.
const BALL: &str = "sphere";
/// Share of the radius of a ball beyond which its side is too steep to be seen.
const STEEP: f64 = 0.95;
/// Places each way that are looked at for the height of the form error.
const SAMPLES: u32 = 64;
/// Distances from the vertex at which heights are looked for, mm: each twice the one before.
const FIRST_MM: f64 = 1e-3;
const DOUBLINGS: u32 = 24;

#[cfg(test)]
mod tests {
    use asphera_form::Nominal;

    use super::*;

    fn side(radius_mm: f64, is_ball: bool) -> Side {
        let form = FormError::typical(radius_mm);
        let noise = Numbers::new(1, 0, 0);
        Side { radius_mm, is_ball, form, share: 0.0, noise_nm: 0.0, noise }
    }

    /// Points of a flawless part lie on its circle, wherever the laser line passes the axis: x² + y² (+ z²) = R².
    #[test]
    fn points_lie_on_the_part() {
        for (is_ball, along_mm) in [(false, 40.0), (true, 0.0), (true, -7.5)] {
            let side = side(12.5, is_ball);
            for (angle_rad, tangential_mm) in [(0.0, 0.0), (1.0, 3.0), (-2.0, -4.5)] {
                let distance_mm = side.distance_mm(0, angle_rad, tangential_mm, along_mm).unwrap();
                let z_mm = if is_ball { along_mm } else { 0.0 };
                let found_mm = distance_mm.hypot(tangential_mm).hypot(z_mm);
                assert!((found_mm - 12.5).abs() < 1e-12, "{found_mm}");
            }
        }
        assert_eq!(side(12.5, false).distance_mm(0, 0.0, 12.6, 0.0), None, "beside it");
        assert_eq!(side(12.5, true).distance_mm(0, 0.0, 0.0, 12.4), None, "too steep");
    }

    #[test]
    fn a_form_error_is_one_of_the_radius_and_closes_after_a_turn() {
        let bent = Side { share: 1000.0, ..side(12.5, false) };
        let at = |angle_rad: f64| bent.distance_mm(0, angle_rad, 0.0, 3.0).unwrap();
        assert!((at(0.3) - at(0.3 + std::f64::consts::TAU)).abs() < 1e-9);
        let expected_mm = MM_PER_NM * bent.error_nm(0.3, 3.0);
        assert!(expected_mm.abs() > 1e-3 && (at(0.3) - 12.5 - expected_mm).abs() < 1e-12);
        // Past the axis the beam meets another place of the turn.
        let tangential_mm = 5.0_f64;
        let distance_mm = bent.distance_mm(0, 0.3, tangential_mm, 3.0).unwrap();
        let angle_rad = 0.3 + (tangential_mm / 12.5).asin();
        let off_mm = distance_mm.hypot(tangential_mm) - 12.5;
        assert!((off_mm - MM_PER_NM * bent.error_nm(angle_rad, 3.0)).abs() < 1e-12);
    }

    #[test]
    fn radii_are_those_of_the_nominal() {
        for radius_mm in [12.5, -30.0, 0.004] {
            let part = Part::new(Nominal::Sphere { radius_mm });
            let found_mm = Side::radius_mm(&part).unwrap();
            assert!((found_mm - radius_mm.abs()).abs() < 1e-6 * radius_mm.abs(), "{found_mm}");
        }
        let said = Side::radius_mm(&Part::new(Nominal::Plane)).unwrap_err().to_string();
        assert!(said.contains("a cylinder or a sphere") && said.contains("radial"), "{said}");
    }
}
