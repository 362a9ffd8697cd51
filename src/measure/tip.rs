//! Compensation of the radius of a ball tip: from centres of the ball to contacts on the surface.
//!
//! The normals are those of the fitted nominal, and of the surface that the points make where none is known. While points
//! arrive, the nominal lies as designed and its height counts as unknown; such contacts are provisional. At the end fits
//! and contacts alternate until no contact moves. All figures are then those of the contacts.

mod figures;
mod solve;

pub(crate) use figures::conclude;

use std::fmt;

use asphera_form::Touch;
use asphera_geometry::vector::plus;
use asphera_geometry::{Point, PointMm};
use asphera_surface::Plane;
use thiserror::Error;

use crate::projection::{Along, Projector};
use crate::{Part, origin};

/// The ball at the end of a stylus.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tip {
    radius_mm: f64,
    u_radius_mm: f64,
    reads: TipReads,
}

/// Place of the ball that a reading gives.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum TipReads {
    /// Its lowest point along the probe: the reading was set to zero there. The usual stylus instrument.
    #[default]
    Lowest,
    /// Its centre.
    Centre,
}

/// Why a tip is none.
#[derive(Clone, Copy, Debug, Error, PartialEq)]
pub enum TipError {
    /// The radius is no length of a ball.
    #[error("radius {0} mm, expected 0 to {LARGEST_MM} mm, the radius of the ball")]
    Radius(f64),
    /// Its uncertainty is none.
    #[error("standard uncertainty of the radius {0} mm, expected 0 to {LARGEST_MM} mm")]
    Uncertainty(f64),
}

impl Tip {
    /// A ball of this radius and its standard uncertainty, mm. A radius of 0 is a point, which needs no compensation.
    ///
    /// # Errors
    ///
    /// Numbers that are negative, not finite, or above [`LARGEST_MM`].
    pub fn new(radius_mm: f64, u_radius_mm: f64, reads: TipReads) -> Result<Tip, TipError> {
        if !(0.0..=LARGEST_MM).contains(&radius_mm) {
            return Err(TipError::Radius(radius_mm));
        }
        if !(0.0..=LARGEST_MM).contains(&u_radius_mm) {
            return Err(TipError::Uncertainty(u_radius_mm));
        }
        Ok(Tip { radius_mm, u_radius_mm, reads })
    }

    /// Radius of the ball, mm.
    pub fn radius_mm(&self) -> f64 {
        self.radius_mm
    }

    /// Its standard uncertainty, mm; 0 where none was stated.
    pub(crate) fn u_radius_mm(&self) -> f64 {
        self.u_radius_mm
    }

    /// Whether readings are those of the lowest point of the ball.
    pub(crate) fn is_lowest(&self) -> bool {
        self.reads == TipReads::Lowest
    }

    /// The centre of the ball at a reading, both mm in one frame; `up` is the unit vector along the probe, away from the part.
    pub fn centre_mm(&self, reading_mm: PointMm, up: [f64; 3]) -> PointMm {
        match self.reads {
            TipReads::Lowest if self.radius_mm > 0.0 => plus(reading_mm, self.radius_mm, up),
            TipReads::Lowest | TipReads::Centre => reading_mm,
        }
    }
}

impl TipReads {
    /// Its word in configurations and reports.
    pub fn word(self) -> &'static str {
        match self {
            TipReads::Lowest => "lowest",
            TipReads::Centre => "centre",
        }
    }
}

impl fmt::Display for TipReads {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        out.write_str(self.word())
    }
}

/// Contacts of a ball with a part, in the order of the centres, which lie in the measured frame, mm; centres without a contact are
/// left out. Where the part cannot be fitted they are the lowest points of the ball.
pub fn contacts(
    centres_mm: impl IntoIterator<Item = PointMm>,
    part: &Part,
    along: Along,
    tip: Tip,
) -> Vec<PointMm> {
    let centres_mm = centres_mm.into_iter();
    let Some(mut centres) = Centres::new(tip, part, along) else { return centres_mm.collect() };
    let mut projector = Projector::new(along);
    for centre_mm in centres_mm {
        projector.take(centres.take(Point::from(centre_mm)), |_, _| {});
    }
    projector.finish(|_, _| {});
    let solved = centres.solve(part, &projector.plane());
    solved.contacts.into_iter().map(|point| point.at_mm).collect()
}

/// Centres of the ball as they were measured, and where contacts are put until all are known.
pub(crate) struct Centres {
    tip: Tip,
    centres: Vec<Point>,
    /// Plane of projection; `None` where it is not known yet.
    plane: Option<Plane>,
    /// The design; `None` where there is none.
    design: Option<Part>,
}

impl Centres {
    /// `None` of a tip that is a point.
    pub(crate) fn new(tip: Tip, part: &Part, along: Along) -> Option<Centres> {
        let plane = along.normal().and_then(|normal| Plane::new([0.0; 3], normal).ok());
        let design = part.reference.is_none().then(|| part.clone());
        (tip.radius_mm > 0.0).then_some(Centres { tip, centres: Vec::new(), plane, design })
    }

    /// Takes the next centre, measured frame, and gives its provisional contact.
    pub(crate) fn take(&mut self, centre: Point) -> Point {
        self.centres.push(centre);
        let plane = self.plane.unwrap_or(Plane::XY);
        let centre_mm = plane.to_plane(centre.at_mm);
        let at_mm = match &self.design {
            Some(part) => {
                let pose = origin::start(part, || [0.0; 2]);
                let touch = Touch::new(&part.nominal, &pose, self.tip.radius_mm, UP);
                touch.contact_at_any_height(centre_mm)
            }
            None => plus(centre_mm, -self.tip.radius_mm, UP),
        };
        Point { at_mm: plane.from_plane(at_mm), ..centre }
    }
}

/// Normal of the plane of projection in its own frame.
const UP: [f64; 3] = [0.0, 0.0, 1.0];
/// Largest radius of a ball, mm.
pub const LARGEST_MM: f64 = 50.0;
/// Caution of running figures.
pub(crate) const PROVISIONAL: &str = "while points arrive, contacts of the ball tip are those with the nominal as designed. At the end they are found anew with the fitted one";
/// Doubt of an outlook.
pub(crate) const FOUND_ANEW: &str =
    "contacts of the ball tip are found anew from all points at the end";

#[cfg(test)]
mod tests;
