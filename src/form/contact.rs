//! Places where a ball touches a nominal surface: contacts of a stylus with a ball tip.
//!
//! The centre of a ball of radius r that touches a surface lies on its offset surface, at distance r along the normal:
//!
//! ```text
//! contact = centre − r·n
//! ```
//!
//! n is the unit normal of the nominal at the foot of the centre, on the side of the ball. With it in the place of the normal
//! of the real surface, the deviation at the contact is in error by r·θ²/2. θ is the slope of the real surface against the
//! nominal, rad: 0.5 nm where r is 1 mm and θ is 1 mrad.

use asphera_geometry::vector::{dot, plus};

use crate::shape::Jet;
use crate::{Motion, Nominal, PointMm, Pose};

/// A ball that touches a nominal in its pose, from one side.
#[derive(Clone, Copy, Debug)]
pub struct Touch<'a> {
    nominal: &'a Nominal,
    motion: Motion,
    radius_mm: f64,
    up: [f64; 3],
    /// 1 where the ball lies on the +z side of the nominal, −1 on the other.
    side: f64,
}

/// A place where a ball touches.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Touched {
    /// The contact in the measured frame, mm.
    pub at_mm: PointMm,
    /// Unit normal from the contact to the centre of the ball, measured frame.
    pub normal: [f64; 3],
    /// Largest curvature of the nominal at the foot towards the ball, 1/mm; positive where the nominal is hollow.
    pub hollow_per_mm: f64,
}

/// Why a ball touches nowhere.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Untouched {
    /// The centre stands over no place of the nominal.
    BeyondNominal,
    /// The nominal is upright there, or overhangs: the probe cannot approach it.
    Upright,
    /// The nominal is hollow with a smaller radius of curvature than the ball.
    TooHollow,
}

impl<'a> Touch<'a> {
    /// A ball of `radius_mm`, 0 or more, that approaches against `up`, a unit vector of the measured frame.
    pub fn new(nominal: &'a Nominal, pose: &Pose, radius_mm: f64, up: [f64; 3]) -> Touch<'a> {
        let motion = pose.motion();
        let side = if dot(motion.turn_to_measured([0.0, 0.0, 1.0]), up) < 0.0 { -1.0 } else { 1.0 };
        Touch { nominal, motion, radius_mm, up, side }
    }

    /// The contact of a ball with this centre, measured frame, mm. `near_mm` is a place near the contact: its foot serves where
    /// the centre has none, as beyond the edge of a hollow nominal. `O(1)`.
    ///
    /// # Errors
    ///
    /// Where the ball touches nowhere.
    pub fn contact(&self, centre_mm: PointMm, near_mm: PointMm) -> Result<Touched, Untouched> {
        let foot = |at_mm: PointMm| self.nominal.foot(self.motion.to_part(at_mm));
        let foot = foot(centre_mm).or_else(|| foot(near_mm)).ok_or(Untouched::BeyondNominal)?;
        let [x_mm, y_mm, _] = foot.foot_mm;
        let jet = self.nominal.jet(x_mm, y_mm).ok_or(Untouched::BeyondNominal)?;
        self.touched(centre_mm, foot.normal, &jet)
    }

    /// The contact of a ball with this centre, moved along the nominal into the plane that holds the centre and is square to
    /// `across`, a unit vector of the measured frame. It serves profiles, whose points stay on their line. The deviation from the
    /// nominal stays as it is at the contact. `O(1)`.
    ///
    /// # Errors
    ///
    /// As [`Touch::contact`].
    pub fn contact_in_plane(
        &self,
        centre_mm: PointMm,
        near_mm: PointMm,
        across: [f64; 3],
    ) -> Result<Touched, Untouched> {
        let found = self.contact(centre_mm, near_mm)?;
        let wanted_mm = dot(across, centre_mm);
        if (dot(across, found.at_mm) - wanted_mm).abs() <= IN_PLANE_MM {
            return Ok(Touched { at_mm: into_plane(found.at_mm, across, wanted_mm), ..found });
        }
        let foot = self.nominal.foot(self.motion.to_part(found.at_mm));
        let foot = foot.ok_or(Untouched::BeyondNominal)?;
        let [mut x_mm, mut y_mm, _] = foot.foot_mm;
        let along = self.motion.turn_to_part(across);
        let square = along[0] * along[0] + along[1] * along[1];
        let mut at_mm = found.at_mm;
        for _ in 0..STEPS {
            let miss_mm = wanted_mm - dot(across, at_mm);
            if miss_mm.abs() <= IN_PLANE_MM || square < UPRIGHT {
                break;
            }
            x_mm += miss_mm * along[0] / square;
            y_mm += miss_mm * along[1] / square;
            let jet = self.nominal.jet(x_mm, y_mm).ok_or(Untouched::BeyondNominal)?;
            let place_mm = plus([x_mm, y_mm, jet.z_mm], foot.distance_mm, normal_of(&jet));
            at_mm = self.motion.to_measured(place_mm);
        }
        Ok(Touched { at_mm: into_plane(at_mm, across, wanted_mm), ..found })
    }

    /// The contact with a nominal whose height is not known yet, so that only its place across z counts; the lowest point of the
    /// ball where there is none. `O(1)`.
    pub fn contact_at_any_height(&self, centre_mm: PointMm) -> PointMm {
        let lowest_mm = plus(centre_mm, -self.radius_mm, self.up);
        let mut at_mm = lowest_mm;
        for _ in 0..STEPS {
            let [x_mm, y_mm, _] = self.motion.to_part(at_mm);
            let Some(jet) = self.nominal.jet(x_mm, y_mm) else { return lowest_mm };
            let Ok(next) = self.touched(centre_mm, normal_of(&jet), &jet) else { return lowest_mm };
            let moved_mm = (0..3).map(|axis| (next.at_mm[axis] - at_mm[axis]).abs());
            let moved_mm = moved_mm.fold(0.0, f64::max);
            at_mm = next.at_mm;
            if moved_mm <= IN_PLANE_MM {
                break;
            }
        }
        at_mm
    }

    /// The contact where the nominal has this normal, part frame, z positive.
    fn touched(
        &self,
        centre_mm: PointMm,
        normal: [f64; 3],
        jet: &Jet,
    ) -> Result<Touched, Untouched> {
        let normal = self.motion.turn_to_measured(normal).map(|along| self.side * along);
        let hollow_per_mm = hollow_per_mm(jet, self.side);
        if dot(normal, self.up) < UPRIGHT {
            return Err(Untouched::Upright);
        }
        if self.radius_mm * hollow_per_mm >= 1.0 {
            return Err(Untouched::TooHollow);
        }
        Ok(Touched { at_mm: plus(centre_mm, -self.radius_mm, normal), normal, hollow_per_mm })
    }
}

/// Upward unit normal of a graph.
fn normal_of(jet: &Jet) -> [f64; 3] {
    let [p, q] = jet.gradient;
    let stretch = (1.0 + p * p + q * q).sqrt();
    [-p / stretch, -q / stretch, 1.0 / stretch]
}

/// Largest principal curvature towards the side, 1/mm.
fn hollow_per_mm(jet: &Jet, side: f64) -> f64 {
    let [mean, beyond] = jet.mean_curvature();
    side * mean + beyond
}

/// The place with its distance along `across` exactly as wanted, where that is x or y.
fn into_plane(at_mm: PointMm, across: [f64; 3], wanted_mm: f64) -> PointMm {
    plus(at_mm, wanted_mm - dot(across, at_mm), across)
}

/// A normal that rises less than this, as its sine, is that of an upright wall: 89.94°.
const UPRIGHT: f64 = 1e-3;
/// Steps at most.
const STEPS: usize = 40;
/// A shorter way is rounding.
const IN_PLANE_MM: f64 = 1e-12;
