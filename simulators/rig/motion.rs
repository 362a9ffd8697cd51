//! Where the machine stops for each trigger, and what its encoders say there.

use std::f64::consts::{PI, TAU};

use crate::noise::standard_normal;
use crate::section::Section;

/// How the machine moves over the part.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Motion {
    /// A turning part and a radial stage: an Archimedean spiral from the centre outwards whose
    /// points stand for about equal areas.
    Spiral {
        /// Radius the points stay within, mm.
        radius_mm: f64,
        /// Counts of the rotary encoder in one turn.
        counts_per_turn: u32,
        /// Step of the radial transducer, nm.
        step_nm: u32,
    },
    /// An XY stage: lines along x, to and fro, from −y to +y over a square about the centre.
    Raster {
        /// Half the side of the square, mm.
        half_width_mm: f64,
        /// Step of both transducers, nm.
        step_nm: u32,
    },
    /// An XY stage once round the section of an airfoil, as a line scanner sees its edge: x along the chord.
    Section {
        /// The section.
        section: Section,
        /// Standard deviation of each coordinate, nm.
        noise_nm: f64,
        /// Step of both transducers, nm.
        step_nm: u32,
    },
    /// Once round and round a whole ball, from pole to pole: [`crate::ball`] computes its stops.
    Ball {
        /// Step of both transducers, nm.
        step_nm: u32,
    },
}

/// What the encoders say at one trigger.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Stop {
    /// Counts of the rotary encoder; 0 on a raster.
    pub rotary_counts: i32,
    /// Positions of the transducers on the bus, in their order: radial, or x and y; in steps.
    pub stage_steps: [i32; 2],
}

impl Motion {
    /// The encoders at all triggers, in their order.
    pub(crate) fn stops(&self, points: u64) -> Box<dyn Iterator<Item = Stop> + '_> {
        let Motion::Section { section, step_nm, .. } = *self else {
            return Box::new((0..points).map(move |k| self.stop(k, points)));
        };
        let stop = move |place_mm: [f64; 2]| Stop {
            rotary_counts: 0,
            stage_steps: place_mm.map(|mm| steps(mm, step_nm)),
        };
        Box::new(section.path_mm(points).into_iter().map(stop))
    }

    /// The encoders at trigger `k` of `points`; of a section the whole way round is computed for it.
    ///
    /// Spiral: ρ_k = ρmax·√((k+½)/N) and θ = 2πρ/p with p = √(π·ρmax²/N), so that the distance
    /// of the turns is about that of the points along a turn. Each encoder is rounded on its own;
    /// what a scene may ask for keeps within 32 bits ([`Motion::rotary_end_counts`]).
    pub(crate) fn stop(&self, k: u64, points: u64) -> Stop {
        match *self {
            Motion::Spiral { radius_mm, counts_per_turn, step_nm } => {
                let rho_mm = radius_mm * ((k as f64 + 0.5) / points as f64).sqrt();
                let turns = rho_mm / pitch_mm(radius_mm, points);
                Stop {
                    rotary_counts: (turns * f64::from(counts_per_turn)).round() as i32,
                    stage_steps: [steps(rho_mm, step_nm), 0],
                }
            }
            Motion::Raster { half_width_mm, step_nm } => {
                let columns = columns(points);
                let rows = points.div_ceil(columns);
                let (row, along) = (k / columns, k % columns);
                let column = if row.is_multiple_of(2) { along } else { columns - 1 - along };
                let place = |index: u64, count: u64| {
                    let share = if count > 1 { index as f64 / (count - 1) as f64 } else { 0.5 };
                    steps(half_width_mm * (2.0 * share - 1.0), step_nm)
                };
                Stop { rotary_counts: 0, stage_steps: [place(column, columns), place(row, rows)] }
            }
            Motion::Ball { .. } => NOWHERE,
            Motion::Section { .. } => self.stops(points).nth(k as usize).unwrap_or(NOWHERE),
        }
    }

    /// The stop with the noise of its place; `seed` is that of the scene.
    pub(crate) fn scattered(&self, stop: Stop, seed: u64, k: u64) -> Stop {
        let Motion::Section { noise_nm, step_nm, .. } = *self else { return stop };
        let [x, y] = stop.stage_steps;
        let off = |salt: u64| {
            let nm = noise_nm * standard_normal(seed.wrapping_add(salt), k);
            (nm / f64::from(step_nm)).round() as i32
        };
        Stop { stage_steps: [x + off(X_SALT), y + off(Y_SALT)], ..stop }
    }

    /// Where the machine is, (x, y) in mm, as the encoders say.
    pub(crate) fn position_mm(&self, stop: &Stop) -> [f64; 2] {
        let [first, second] = stop.stage_steps.map(f64::from);
        match *self {
            Motion::Spiral { counts_per_turn, step_nm, .. } => {
                let rho_mm = first * f64::from(step_nm) / NM_PER_MM;
                let theta_rad = f64::from(stop.rotary_counts) * (TAU / f64::from(counts_per_turn));
                [rho_mm * theta_rad.cos(), rho_mm * theta_rad.sin()]
            }
            Motion::Raster { step_nm, .. }
            | Motion::Section { step_nm, .. }
            | Motion::Ball { step_nm } => {
                [first, second].map(|steps| steps * f64::from(step_nm) / NM_PER_MM)
            }
        }
    }

    /// Largest distance of a stop from the centre, mm.
    pub(crate) fn reach_mm(&self) -> f64 {
        match *self {
            Motion::Spiral { radius_mm, .. } => radius_mm,
            Motion::Raster { half_width_mm, .. } => half_width_mm * std::f64::consts::SQRT_2,
            // No normal number is above 8.6.
            Motion::Section { section, noise_nm, .. } => {
                0.5 * section.chord_mm + 10.0 * noise_nm / NM_PER_MM
            }
            // It is where the part is.
            Motion::Ball { .. } => 0.0,
        }
    }

    /// Step of the transducers, nm.
    pub(crate) fn step_nm(&self) -> u32 {
        match *self {
            Motion::Spiral { step_nm, .. }
            | Motion::Raster { step_nm, .. }
            | Motion::Section { step_nm, .. }
            | Motion::Ball { step_nm } => step_nm,
        }
    }

    /// Counts of the rotary encoder at the end of a scan of `points`, not rounded; 0 on a raster.
    pub(crate) fn rotary_end_counts(&self, points: u64) -> f64 {
        match *self {
            Motion::Spiral { radius_mm, counts_per_turn, .. } => {
                radius_mm / pitch_mm(radius_mm, points) * f64::from(counts_per_turn)
            }
            Motion::Raster { .. } | Motion::Section { .. } | Motion::Ball { .. } => 0.0,
        }
    }

    /// How many transducers the stage has.
    pub(crate) fn transducers(&self) -> usize {
        match self {
            Motion::Spiral { .. } => 1,
            Motion::Raster { .. } | Motion::Section { .. } | Motion::Ball { .. } => 2,
        }
    }
}

/// Distance of the turns of the spiral, mm: the side of a square of the area one point stands for.
fn pitch_mm(radius_mm: f64, points: u64) -> f64 {
    (PI * radius_mm * radius_mm / points as f64).sqrt()
}

/// Points of a line of the raster. The last line may be shorter.
fn columns(points: u64) -> u64 {
    ((points as f64).sqrt().round() as u64).max(1)
}

fn steps(length_mm: f64, step_nm: u32) -> i32 {
    (length_mm * NM_PER_MM / f64::from(step_nm)).round() as i32
}

const NM_PER_MM: f64 = 1e6;
const NOWHERE: Stop = Stop { rotary_counts: 0, stage_steps: [0, 0] };

/// Added to the seed, so that x, y and the probe have noise of their own.
const X_SALT: u64 = 0x5EC7_1001;
const Y_SALT: u64 = 0x5EC7_1002;

#[cfg(test)]
mod tests {
    use super::*;

    const SPIRAL: Motion =
        Motion::Spiral { radius_mm: 8.95, counts_per_turn: 3_600_000, step_nm: 1 };

    /// Encoders are within half a count of the ideal place, at the first, a middle and the last
    /// trigger, computed here from the turns themselves.
    #[test]
    fn encoders_are_rounded_to_whole_counts() {
        let n = 100_000;
        for k in [0, 1, 54_321, n - 1] {
            let rho_mm = 8.95 * ((k as f64 + 0.5) / n as f64).sqrt();
            // ρ/p = √((k+½)/N)·ρmax / (ρmax·√(π/N)) = √((k+½)/π)
            let turns = ((k as f64 + 0.5) / PI).sqrt();
            let stop = SPIRAL.stop(k, n);
            assert!((f64::from(stop.stage_steps[0]) - rho_mm * 1e6).abs() <= 0.5 + 1e-6);
            assert!((f64::from(stop.rotary_counts) - turns * 3.6e6).abs() <= 0.5 + 1e-6);
        }
    }

    #[test]
    fn the_spiral_goes_outwards_and_stays_inside() {
        let n = 5_000;
        let radius =
            |k| SPIRAL.position_mm(&SPIRAL.stop(k, n)).iter().map(|v| v * v).sum::<f64>().sqrt();
        assert!((1..n).all(|k| radius(k) > radius(k - 1)));
        assert!(radius(n - 1) < 8.95);
        // Equal areas: half of the points lie within 1/√2 of the radius.
        let inside = (0..n).filter(|&k| radius(k) < 8.95 / 2_f64.sqrt()).count();
        assert_eq!(inside, n as usize / 2);
    }

    #[test]
    fn the_raster_goes_to_and_fro() {
        let raster = Motion::Raster { half_width_mm: 1.0, step_nm: 1 };
        let stops: Vec<[i32; 2]> = (0..8).map(|k| raster.stop(k, 8).stage_steps).collect();
        let (low, high) = (-1_000_000, 1_000_000);
        assert_eq!(
            stops,
            [
                [low, low],
                [0, low],
                [high, low],
                [high, 0],
                [0, 0],
                [low, 0],
                [low, high],
                [0, high]
            ]
        );
        assert_eq!(raster.position_mm(&raster.stop(7, 8)), [0.0, 1.0]);
    }

    #[test]
    fn one_point_is_a_scan() {
        let raster = Motion::Raster { half_width_mm: 1.0, step_nm: 1 };
        assert_eq!(raster.stop(0, 1).stage_steps, [0, 0]);
        assert!(SPIRAL.stop(0, 1).stage_steps[0] > 0);
    }
}
