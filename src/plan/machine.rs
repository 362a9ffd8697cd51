//! Machines: axes with limits, and how a piece of a path moves them.

use std::f64::consts::TAU;

use crate::error::positive;
use crate::piece::Motion;
use crate::{Piece, PlanError};

/// Limits of an axis: in mm, or of a rotary axis in rad.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Axis {
    /// Lowest position; negative infinity where there is none.
    pub low: f64,
    /// Highest position; infinity where there is none.
    pub high: f64,
    /// Largest speed, per s.
    pub speed: f64,
    /// Largest acceleration, per s².
    pub acceleration: f64,
}

/// A machine with two axes under the probe.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Machine {
    /// Two stages.
    Cartesian {
        /// Along x, mm.
        x: Axis,
        /// Along y, mm.
        y: Axis,
    },
    /// A turning table about the origin, and a stage away from its axis.
    Polar {
        /// Distance from the axis, mm.
        r: Axis,
        /// Angle of the table, rad.
        c: Axis,
    },
}

impl Axis {
    /// An axis from -half to half that has no ends where `half` is infinite.
    pub fn about_zero(half: f64, speed: f64, acceleration: f64) -> Axis {
        Axis { low: -half, high: half, speed, acceleration }
    }

    fn validate(&self, keys: [&'static str; 3]) -> Result<(), PlanError> {
        positive(keys[1], self.speed, "give the speed of the axis")?;
        positive(keys[2], self.acceleration, "give the acceleration of the axis")?;
        if self.low < self.high {
            return Ok(());
        }
        let found = format!("{} to {}", self.low, self.high);
        Err(PlanError::new(keys[0], "a lower and a higher position", found, "exchange the ends"))
    }

    fn allows(&self, at: f64) -> bool {
        let slack = 1e-9 * (1.0 + at.abs());
        at >= self.low - slack && at <= self.high + slack
    }
}

impl Machine {
    /// Its axes.
    pub(crate) fn axes(&self) -> [Axis; 2] {
        match *self {
            Machine::Cartesian { x, y } => [x, y],
            Machine::Polar { r, c } => [r, c],
        }
    }

    pub(crate) fn is_polar(&self) -> bool {
        matches!(self, Machine::Polar { .. })
    }

    /// Fails unless the limits of each axis can be.
    ///
    /// # Errors
    ///
    /// With the key of the limit.
    pub fn validate(&self) -> Result<(), PlanError> {
        let keys = match self {
            Machine::Cartesian { .. } => [
                ["x.travel", "x.speed", "x.acceleration"],
                ["y.travel", "y.speed", "y.acceleration"],
            ],
            Machine::Polar { .. } => [
                ["r.travel", "r.speed", "r.acceleration"],
                ["c.travel", "c.speed", "c.acceleration"],
            ],
        };
        self.axes().iter().zip(keys).try_for_each(|(axis, keys)| axis.validate(keys))
    }

    /// How a piece moves the axes after a length of way in mm, without what turns `c` by whole turns.
    pub(crate) fn motion(&self, piece: &Piece, way_mm: f64) -> Motion {
        match self {
            Machine::Cartesian { .. } => piece.cartesian(way_mm),
            Machine::Polar { .. } => piece.polar(way_mm),
        }
    }

    /// Fails where a piece leaves the travel, or where the machine cannot follow it. Gives the angle that is added to `c`: whole turns,
    /// as few from `c_rad` as the travel allows.
    pub(crate) fn enter(&self, piece: &Piece, c_rad: f64) -> Result<f64, PlanError> {
        match *self {
            Machine::Cartesian { x, y } => {
                for place in piece.extremes() {
                    inside("x.travel", x, place[0], place)?;
                    inside("y.travel", y, place[1], place)?;
                }
                Ok(0.0)
            }
            Machine::Polar { r, c } => {
                followed(piece)?;
                let [begin, end] = [0.0, piece.length_mm()].map(|way| piece.polar(way).at);
                for [radius, _] in [begin, end] {
                    inside(
                        "r.travel",
                        r,
                        radius,
                        piece.at(if radius == begin[0] { 0.0 } else { piece.length_mm() }),
                    )?;
                }
                let [from, to] = [begin[1].min(end[1]), begin[1].max(end[1])];
                turns(c, [from, to], begin[1], c_rad).ok_or_else(|| {
                    PlanError::new(
                        "c.travel",
                        format!("{:.1}° to {:.1}°", c.low.to_degrees(), c.high.to_degrees()),
                        format!(
                            "a piece of {:.1}° at {}",
                            (to - from).to_degrees(),
                            place(piece.at(0.0))
                        ),
                        "take rings or meridians instead of a spiral, or an axis without ends",
                    )
                })
            }
        }
    }
}

/// Fails for what a polar machine does not follow: what has another centre, and lines that miss the axis.
fn followed(piece: &Piece) -> Result<(), PlanError> {
    match *piece {
        Piece::Stop { .. } => Ok(()),
        Piece::Line { from_mm: [ax, ay], to_mm: [bx, by] } => {
            let reach = ax.hypot(ay).max(bx.hypot(by));
            let aside = (ax * by - ay * bx).abs();
            let is_ray =
                aside <= 1e-9 * reach * reach && ax * bx + ay * by >= -1e-9 * reach * reach;
            if is_ray {
                return Ok(());
            }
            Err(PlanError::new(
                "path",
                "lines from the axis of a polar machine",
                format!("a line from {} to {}", place([ax, ay]), place([bx, by])),
                "take spiral, rings or meridians",
            ))
        }
        Piece::Arc { centre_mm, .. } | Piece::Spiral { centre_mm, .. } => {
            if centre_mm == [0.0; 2] {
                return Ok(());
            }
            Err(PlanError::new(
                "centre",
                "the axis of a polar machine, 0,0 mm",
                place(centre_mm),
                "leave the centre out, or take a cartesian machine",
            ))
        }
    }
}

/// The whole turns to add so that a range of angles lies within the travel, fewest from where the axis stands.
fn turns(c: Axis, [from, to]: [f64; 2], begin: f64, c_rad: f64) -> Option<f64> {
    let nearest = ((c_rad - begin) / TAU).round();
    let lowest = ((c.low - from) / TAU - 1e-9).ceil();
    let highest = ((c.high - to) / TAU + 1e-9).floor();
    (lowest <= highest).then(|| nearest.clamp(lowest, highest) * TAU)
}

fn inside(key: &'static str, axis: Axis, at: f64, near: [f64; 2]) -> Result<(), PlanError> {
    if axis.allows(at) {
        return Ok(());
    }
    Err(PlanError::new(
        key,
        format!("{} to {} mm", axis.low, axis.high),
        format!("{at:.6} mm at {}", place(near)),
        "plan a smaller aperture, move its centre, or give the travel the machine has",
    ))
}

fn place([x, y]: [f64; 2]) -> String {
    format!("x {x:.6}, y {y:.6} mm")
}
