//! Medial balls and the distance to their centres.

use asphera_geometry::{PointMm, WeightedTree};

use super::value::{Lfs, Why};
use super::vector::along;

/// The side of the surface a ball lies on.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Side {
    /// The side to which the normal points.
    Outer,
    /// The other one.
    Inner,
}

impl Side {
    /// Both.
    pub const BOTH: [Side; 2] = [Side::Outer, Side::Inner];

    /// The way into that side, given the normal.
    pub(super) fn direction(self, normal: [f64; 3]) -> [f64; 3] {
        match self {
            Side::Outer => normal,
            Side::Inner => normal.map(|part| -part),
        }
    }
}

/// A ball that touches the surface in one point and is kept from growing in another.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MedialBall {
    /// The point it was shrunk onto, in mm.
    pub at_mm: PointMm,
    /// The side of the surface it lies on.
    pub side: Side,
    /// The unit vector from that point to the centre.
    pub direction: [f64; 3],
    /// The best value of its radius in mm.
    pub radius_mm: f64,
    /// The radius is hardly below this many mm: less than the noise, the sampling gap and the
    /// resolution of the search leave open. Zero if they leave all open.
    pub lower_mm: f64,
    /// The radius is hardly above this many mm.
    pub upper_mm: f64,
    /// The other point it touches, in mm: `at_mm` itself where curvature alone bounds it.
    pub witness_mm: PointMm,
}

impl MedialBall {
    /// The centre, a point of the medial axis, in mm.
    pub fn centre_mm(&self) -> PointMm {
        along(self.at_mm, self.direction, self.radius_mm)
    }

    /// The angle at the centre between the two points it touches, in rad: 0 where curvature
    /// bounds it, π between parallel sheets.
    pub fn separation_rad(&self) -> f64 {
        let chord_mm = super::vector::distance(self.at_mm, self.witness_mm);
        2.0 * (0.5 * chord_mm / self.radius_mm).min(1.0).asin()
    }
}

impl MedialBall {
    /// Balls that hold all places where the centre may be nearer than it seems: their centres and, as
    /// negative weights, radii. They shrink towards the lower bound, so that they say little less
    /// than the line they cover. Where nothing is known from below, nothing is known about the ball's
    /// point either.
    fn places(&self, beside: f64) -> impl Iterator<Item = (PointMm, f64)> {
        let MedialBall { at_mm, direction, lower_mm, .. } = *self;
        let last = PLACES - 1;
        let unknown_mm = if lower_mm > 0.0 { 0.0 } else { self.radius_mm };
        let mut far_mm = self.radius_mm;
        (0..PLACES).map_while(move |index| {
            let near_mm = if index == last { lower_mm } else { lower_mm.max(0.8 * far_mm) };
            let middle_mm = 0.5 * (near_mm + far_mm);
            let radius_mm = 0.5 * (far_mm - near_mm) + beside * far_mm + unknown_mm;
            let more = index == 0 || far_mm > near_mm;
            far_mm = near_mm;
            more.then(|| (along(at_mm, direction, middle_mm), -radius_mm))
        })
    }
}

/// How many balls cover the places of a centre, at most.
const PLACES: usize = 64;

/// What medial balls cannot tell.
#[derive(Clone, Copy, Debug)]
pub(super) struct Limits {
    /// How far a centre may lie to the side, for each mm of its radius.
    pub(super) beside: f64,
    /// Balls of this radius and more may have been missed, in mm.
    pub(super) hidden_mm: f64,
    /// What is smaller than this many mm is too fine for the samples.
    pub(super) floor_mm: f64,
}

/// The medial axis of a surface, as the centres of many medial balls.
///
/// The local feature size of a place is its distance to the nearest centre, which need not be that of
/// the ball at the place: over the flat of an ellipsoid the axis runs much nearer than the ball
/// reaches.
#[derive(Clone, Debug)]
pub struct MedialAxis {
    balls: Vec<MedialBall>,
    centres: WeightedTree,
    uppers: WeightedTree,
    lowers: WeightedTree,
    limits: Limits,
    nothing: Option<Why>,
}

impl MedialAxis {
    /// The axis of these balls.
    pub(super) fn new(balls: Vec<MedialBall>, limits: Limits, nothing: Option<Why>) -> MedialAxis {
        let beside = limits.beside;
        let centres = balls.iter().map(|ball| (ball.centre_mm(), 0.0));
        let uppers = balls.iter().map(|ball| {
            let further_mm = ball.upper_mm - ball.radius_mm + beside * ball.radius_mm;
            (ball.centre_mm(), further_mm)
        });
        let lowers = balls.iter().flat_map(|ball| ball.places(beside));
        MedialAxis {
            centres: WeightedTree::new(centres),
            uppers: WeightedTree::new(uppers),
            lowers: WeightedTree::new(lowers),
            balls,
            limits,
            nothing,
        }
    }

    /// The balls, in an order that depends on the points and their order alone.
    pub fn balls(&self) -> &[MedialBall] {
        &self.balls
    }

    /// The local feature size at a place on the surface. Takes time in proportion to the logarithm
    /// of the number of balls.
    pub fn at(&self, place_mm: PointMm) -> Lfs {
        if !place_mm.iter().all(|coordinate| coordinate.is_finite()) {
            return Lfs::Unknown(Why::Outside);
        }
        if let Some(why) = self.nothing {
            return Lfs::Unknown(why);
        }
        let Some(mm) = self.centres.least(place_mm) else {
            return Lfs::Beyond { lower_mm: self.limits.hidden_mm };
        };
        let upper_mm = self.uppers.least(place_mm).unwrap_or(f64::INFINITY);
        let lower_mm =
            self.lowers.least(place_mm).unwrap_or(0.0).min(self.limits.hidden_mm).min(mm);
        if lower_mm > 0.0 && mm >= self.limits.floor_mm {
            Lfs::Known { mm, lower_mm, upper_mm }
        } else {
            Lfs::Hidden { upper_mm }
        }
    }

    /// Half the width of the narrowest neck found, in mm: the least lower bound among the balls whose
    /// two points are at least a right angle apart; `None` if there is none.
    pub fn half_bottleneck_mm(&self) -> Option<f64> {
        let wide = self.balls.iter().filter(|ball| ball.separation_rad() >= RIGHT_ANGLE);
        wide.map(|ball| ball.lower_mm).reduce(f64::min)
    }

    /// The numbers of the balls whose centres are nearest to a place, nearest first.
    pub(super) fn nearest(&self, place_mm: PointMm, count: usize) -> Vec<u32> {
        self.centres.least_few(place_mm, count)
    }
}

/// How deeply a surface may enter a ball between samples no farther from it than `gap_mm`, in mm: the
/// height of a cap of that half width; all of the ball if it is no wider.
pub(super) fn entered_mm(radius_mm: f64, gap_mm: f64) -> f64 {
    if gap_mm < radius_mm {
        radius_mm - (radius_mm * radius_mm - gap_mm * gap_mm).sqrt()
    } else {
        radius_mm
    }
}

const RIGHT_ANGLE: f64 = std::f64::consts::FRAC_PI_2;
