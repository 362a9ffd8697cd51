//! Pieces of a path: where a probe is after a length of way, and how the axes move there.

use std::f64::consts::FRAC_PI_2;

/// A piece of a path. Angles count from +x towards +y.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Piece {
    /// A place at which the machine stands still.
    Stop {
        /// The place in mm.
        at_mm: [f64; 2],
    },
    /// A straight line.
    Line {
        /// First place in mm.
        from_mm: [f64; 2],
        /// Last place in mm.
        to_mm: [f64; 2],
    },
    /// A piece of a circle; of a whole turn the last place is the first.
    Arc {
        /// Centre in mm.
        centre_mm: [f64; 2],
        /// Radius in mm.
        radius_mm: f64,
        /// First angle.
        from_rad: f64,
        /// Last angle, above the first.
        to_rad: f64,
    },
    /// A spiral of Archimedes: the radius grows, or falls, in proportion to the angle.
    Spiral {
        /// Centre in mm.
        centre_mm: [f64; 2],
        /// First radius in mm.
        from_radius_mm: f64,
        /// Last radius in mm.
        to_radius_mm: f64,
        /// First angle.
        from_rad: f64,
        /// Last angle, above the first.
        to_rad: f64,
    },
}

/// Two axes on the way: positions, and their first and second derivatives by the length of way in mm.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Motion {
    pub(crate) at: [f64; 2],
    pub(crate) rate: [f64; 2],
    pub(crate) bend: [f64; 2],
}

impl Piece {
    /// Its length in mm.
    pub fn length_mm(&self) -> f64 {
        match *self {
            Piece::Stop { .. } => 0.0,
            Piece::Line { from_mm, to_mm } => distance_mm(from_mm, to_mm),
            Piece::Arc { radius_mm, from_rad, to_rad, .. } => radius_mm * (to_rad - from_rad),
            Piece::Spiral { from_radius_mm, to_radius_mm, .. } => {
                let slope = self.slope_mm_rad().abs();
                (way_to(to_radius_mm, slope) - way_to(from_radius_mm, slope)).abs()
            }
        }
    }

    /// The place after a length of way in mm.
    pub fn at(&self, way_mm: f64) -> [f64; 2] {
        match *self {
            Piece::Stop { at_mm } => at_mm,
            Piece::Line { from_mm, to_mm } => {
                let length_mm = self.length_mm();
                let share = if length_mm > 0.0 { way_mm / length_mm } else { 0.0 };
                if share >= 1.0 {
                    return to_mm;
                }
                [0, 1].map(|axis| from_mm[axis] + share * (to_mm[axis] - from_mm[axis]))
            }
            Piece::Arc { centre_mm, .. } | Piece::Spiral { centre_mm, .. } => {
                let [radius_mm, angle] = self.polar(way_mm).at;
                let (sin, cos) = angle.sin_cos();
                [centre_mm[0] + radius_mm * cos, centre_mm[1] + radius_mm * sin]
            }
        }
    }

    /// Its last place.
    pub fn end(&self) -> [f64; 2] {
        self.at(self.length_mm())
    }

    /// Whether its last place is the first.
    pub(crate) fn is_closed(&self) -> bool {
        let whole = std::f64::consts::TAU - 1e-9;
        matches!(*self, Piece::Arc { from_rad, to_rad, .. } if to_rad - from_rad > whole)
    }

    /// The angle it turns by.
    pub(crate) fn turned_rad(&self) -> f64 {
        match *self {
            Piece::Stop { .. } | Piece::Line { .. } => 0.0,
            Piece::Arc { from_rad, to_rad, .. } | Piece::Spiral { from_rad, to_rad, .. } => {
                to_rad - from_rad
            }
        }
    }

    /// The way in mm to a share of its angle; of a line to a share of its length.
    pub(crate) fn way_at_mm(&self, share: f64) -> f64 {
        match *self {
            Piece::Spiral { from_radius_mm, to_radius_mm, .. } => {
                let slope = self.slope_mm_rad().abs();
                let radius = from_radius_mm + share * (to_radius_mm - from_radius_mm);
                (way_to(radius, slope) - way_to(from_radius_mm, slope)).abs()
            }
            Piece::Stop { .. } | Piece::Line { .. } | Piece::Arc { .. } => share * self.length_mm(),
        }
    }

    /// Radius in mm and angle about its own centre. Of a line these are about the frame's origin, which it must lead through or to.
    pub(crate) fn polar(&self, way_mm: f64) -> Motion {
        match *self {
            Piece::Stop { at_mm: [x, y] } => {
                Motion { at: [x.hypot(y), y.atan2(x)], rate: [0.0; 2], bend: [0.0; 2] }
            }
            Piece::Line { from_mm, to_mm } => {
                let radius = |[x, y]: [f64; 2]| x.hypot(y);
                let far = if radius(to_mm) > radius(from_mm) { to_mm } else { from_mm };
                let outwards = radius(to_mm) > radius(from_mm);
                let rate = if outwards { 1.0 } else { -1.0 };
                let at = [radius(from_mm) + rate * way_mm, far[1].atan2(far[0])];
                Motion { at, rate: [rate, 0.0], bend: [0.0; 2] }
            }
            Piece::Arc { radius_mm, from_rad, .. } => Motion {
                at: [radius_mm, from_rad + way_mm / radius_mm],
                rate: [0.0, radius_mm.recip()],
                bend: [0.0; 2],
            },
            Piece::Spiral { from_radius_mm, from_rad, .. } => {
                let slope = self.slope_mm_rad();
                let along = if slope < 0.0 { -way_mm } else { way_mm };
                let way = (way_to(from_radius_mm, slope.abs()) + along).max(0.0);
                let radius = radius_after(way, slope.abs());
                // ds = √(r² + b²) dc for r = b·c.
                let stretch = radius.hypot(slope);
                let bend = -radius * slope / stretch.powi(4);
                Motion {
                    at: [radius, from_rad + (radius - from_radius_mm) / slope],
                    rate: [slope / stretch, stretch.recip()],
                    bend: [slope * bend, bend],
                }
            }
        }
    }

    /// x and y in mm on the way.
    pub(crate) fn cartesian(&self, way_mm: f64) -> Motion {
        let at = self.at(way_mm);
        match *self {
            Piece::Stop { .. } => Motion { at, rate: [0.0; 2], bend: [0.0; 2] },
            Piece::Line { from_mm, to_mm } => {
                let length_mm = self.length_mm().max(f64::MIN_POSITIVE);
                let rate = [0, 1].map(|axis| (to_mm[axis] - from_mm[axis]) / length_mm);
                Motion { at, rate, bend: [0.0; 2] }
            }
            Piece::Arc { .. } | Piece::Spiral { .. } => {
                let Motion { at: [r, c], rate: [dr, dc], bend: [ddr, ddc] } = self.polar(way_mm);
                let (sin, cos) = c.sin_cos();
                // Along the radius and across it.
                let [along, across] = [dr, r * dc];
                let [bend_along, bend_across] = [ddr - r * dc * dc, r * ddc + 2.0 * dr * dc];
                Motion {
                    at,
                    rate: [along * cos - across * sin, along * sin + across * cos],
                    bend: [
                        bend_along * cos - bend_across * sin,
                        bend_along * sin + bend_across * cos,
                    ],
                }
            }
        }
    }

    /// Places between which it lies: its ends, and where it runs farthest in x and y.
    pub(crate) fn extremes(&self) -> Vec<[f64; 2]> {
        let mut places = vec![self.at(0.0), self.end()];
        let (centre, from, to) = match *self {
            Piece::Stop { .. } | Piece::Line { .. } => return places,
            Piece::Arc { centre_mm, from_rad, to_rad, .. }
            | Piece::Spiral { centre_mm, from_rad, to_rad, .. } => (centre_mm, from_rad, to_rad),
        };
        // The largest turn counts: the last of a spiral that grows, the first of one that falls.
        let outermost = [to - 4.0 * FRAC_PI_2, from].map(|at| at.max(from));
        for begin in outermost {
            let first = (begin / FRAC_PI_2).ceil();
            for quarter in (0..5).map(|k| (first + f64::from(k)) * FRAC_PI_2) {
                if quarter > to {
                    break;
                }
                let radius = self.radius_at(quarter);
                let (sin, cos) = quarter.sin_cos();
                places.push([centre[0] + radius * cos, centre[1] + radius * sin]);
            }
        }
        places
    }

    /// The radius at an angle in mm.
    fn radius_at(&self, angle: f64) -> f64 {
        match *self {
            Piece::Spiral { from_radius_mm, from_rad, .. } => {
                from_radius_mm + self.slope_mm_rad() * (angle - from_rad)
            }
            Piece::Arc { radius_mm, .. } => radius_mm,
            Piece::Stop { .. } | Piece::Line { .. } => 0.0,
        }
    }

    /// Growth of the radius of a spiral in mm/rad; 0 of other pieces.
    fn slope_mm_rad(&self) -> f64 {
        match *self {
            Piece::Spiral { from_radius_mm, to_radius_mm, from_rad, to_rad, .. } => {
                (to_radius_mm - from_radius_mm) / (to_rad - from_rad)
            }
            Piece::Stop { .. } | Piece::Line { .. } | Piece::Arc { .. } => 0.0,
        }
    }
}

/// Length in mm of the spiral r = b·c from its centre to a radius: b/2·(c·√(1 + c²) + asinh c).
fn way_to(radius_mm: f64, slope_mm_rad: f64) -> f64 {
    let turn = radius_mm / slope_mm_rad;
    0.5 * slope_mm_rad * (turn * turn.hypot(1.0) + turn.asinh())
}

/// The radius in mm of that spiral after a length, by Newton's method from above: the length is convex in the radius.
fn radius_after(way_mm: f64, slope_mm_rad: f64) -> f64 {
    let scaled = way_mm / slope_mm_rad;
    // The scaled length is above the turn, and above half its square.
    let mut turn = (2.0 * scaled).sqrt().min(scaled);
    for _ in 0..60 {
        let miss = 0.5 * (turn * turn.hypot(1.0) + turn.asinh()) - scaled;
        let next = turn - miss / turn.hypot(1.0);
        if (next - turn).abs() <= 1e-15 * turn {
            break;
        }
        turn = next.max(0.0);
    }
    turn * slope_mm_rad
}

/// The distance of two places in mm.
pub(crate) fn distance_mm(p: [f64; 2], q: [f64; 2]) -> f64 {
    (q[0] - p[0]).hypot(q[1] - p[1])
}
