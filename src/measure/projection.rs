//! On which plane the points are projected: given, or fitted from the first of them.
//!
//! The points of a part are turned into the frame u, v, w of the plane, and everything that is made of them
//! (mesh, sampling, fit) takes u, v and w for what x, y and z are where the projection is along z: the
//! nominal's axis is taken to point along the normal at first, and its aperture to lie about it. Every
//! nominal is a height over its own x and y, so a part that needs another direction of projection than z is
//! one whose axis points there. What is reported with a place is turned back into the measured frame.
//!
//! Every plane's u and v are zero at the origin of the measured frame, as x and y are.

use std::borrow::Cow;
use std::str::FromStr;

use asphera_geometry::{Point, PointMm, RANGE_MM};
use asphera_mesh::Mesh;
use asphera_report::{PlaneFigures, ProjectionFigures};
use asphera_surface::{Plane, PlaneError};
use thiserror::Error;

use super::space::When;

/// How the plane of projection is found.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Along(How);

#[derive(Clone, Copy, Debug, PartialEq)]
enum How {
    Given(Plane),
    Fitted {
        points: usize,
    },
    /// No plane: in space.
    Space,
    /// Along z, in space where that folds.
    Auto,
}

/// Why a projection is none.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum AlongError {
    /// The direction has no length, or a coordinate is not finite.
    #[error("expected a direction of finite length above 0, as 0,0.5,0.866; found {normal:?}")]
    Direction {
        /// Its coordinates.
        normal: [f64; 3],
    },
    /// So few points determine no plane, so many would wait too long.
    #[error("expected {MIN_POINTS} to {MAX_POINTS} points to fit a plane from, found {points}")]
    Points {
        /// How many were asked for.
        points: usize,
    },
    /// No word that is known, and no three numbers.
    #[error("expected z, fitted, none, auto or three numbers nx,ny,nz, found `{found}`")]
    Word {
        /// Given text.
        found: String,
    },
}

impl Along {
    /// Along z of the measured frame.
    pub const Z: Along = Along(How::Given(Plane::XY));
    /// Along nothing: the points are meshed in space.
    pub const NONE: Along = Along(How::Space);
    /// Along z, and in space where the points fold over that plane.
    pub const AUTO: Along = Along(How::Auto);

    /// Along a direction of the measured frame, of any length, from the side it points to.
    ///
    /// # Errors
    ///
    /// When it is zero or not finite.
    pub fn direction(normal: [f64; 3]) -> Result<Along, AlongError> {
        match Plane::new([0.0; 3], normal) {
            Ok(plane) => Ok(Along(How::Given(plane))),
            Err(_) => Err(AlongError::Direction { normal }),
        }
    }

    /// Along the normal of the plane through the first `points` good points; of the two normals the one
    /// with positive z.
    ///
    /// # Errors
    ///
    /// Below [`MIN_POINTS`] and above [`MAX_POINTS`].
    pub fn fitted(points: usize) -> Result<Along, AlongError> {
        if (MIN_POINTS..=MAX_POINTS).contains(&points) {
            Ok(Along(How::Fitted { points }))
        } else {
            Err(AlongError::Points { points })
        }
    }
}

impl Along {
    /// The direction, where it is given and not fitted.
    pub fn normal(&self) -> Option<[f64; 3]> {
        match self.0 {
            How::Given(plane) => Some(plane.normal()),
            How::Fitted { .. } | How::Space | How::Auto => None,
        }
    }

    /// Whether contacts of a ball tip can be found: with a plane in any case, seen from above as the probe comes.
    pub fn suits_tip(&self) -> bool {
        self.has_plane() && self.normal().is_none_or(|normal| normal[2] > 0.0)
    }

    /// Whether the points are projected onto a plane in any case, and never meshed in space.
    pub fn has_plane(&self) -> bool {
        self.in_space().is_none()
    }

    /// When the points are meshed in space; `None`: never.
    pub(super) fn in_space(&self) -> Option<When> {
        match self.0 {
            How::Given(_) | How::Fitted { .. } => None,
            How::Space => Some(When::Always),
            How::Auto => Some(When::Folded),
        }
    }
}

impl Default for Along {
    /// Along z.
    fn default() -> Along {
        Along::Z
    }
}

impl FromStr for Along {
    type Err = AlongError;

    /// `z`, `fitted` (from [`DEFAULT_POINTS`] points), `none`, `auto` or `nx,ny,nz`.
    fn from_str(word: &str) -> Result<Along, AlongError> {
        let numbers = || -> Option<[f64; 3]> {
            let numbers: Option<Vec<f64>> =
                word.split(',').map(|number| number.trim().parse().ok()).collect();
            numbers?.try_into().ok()
        };
        match word {
            "z" => Ok(Along::Z),
            "fitted" => Along::fitted(DEFAULT_POINTS),
            "none" => Ok(Along::NONE),
            "auto" => Ok(Along::AUTO),
            _ => match numbers() {
                Some(normal) => Along::direction(normal),
                None => Err(AlongError::Word { found: word.to_owned() }),
            },
        }
    }
}

/// The plane of one part, from before it is known until the end.
#[derive(Clone, Debug)]
pub(super) enum Projector {
    /// It was given.
    Given(Plane),
    /// Points wait for it.
    Fitting {
        /// How many were asked for.
        wanted: usize,
        /// At how many it is tried next.
        next: usize,
        waiting: Vec<Point>,
    },
    /// It goes through the first points.
    Fitted { plane: Plane, points: usize },
    /// The first points determine none: projected along z.
    Unfitted { points: usize, why: PlaneError },
}

impl Projector {
    pub(super) fn new(along: Along) -> Projector {
        match along.0 {
            How::Given(plane) => Projector::Given(plane),
            How::Space | How::Auto => Projector::Given(Plane::XY),
            How::Fitted { points } => {
                Projector::Fitting { wanted: points, next: points, waiting: Vec::new() }
            }
        }
    }

    /// Takes the next point; gives those whose u, v and w are known now to `out`, in their order, with the plane.
    pub(super) fn take(&mut self, point: Point, mut out: impl FnMut(Point, &Plane)) {
        let Projector::Fitting { next, waiting, .. } = self else {
            let plane = self.plane();
            return out(laid(point, &plane), &plane);
        };
        // One that no mesh admits must not turn the plane, nor fill the memory.
        if !point.at_mm.iter().all(|coordinate| coordinate.abs() <= RANGE_MM) {
            return out(point, &Plane::XY);
        }
        waiting.push(point);
        if waiting.len() < *next {
            return;
        }
        match through(waiting) {
            Ok(plane) => self.settle(Ok(plane), out),
            // A line or a curve, which is what a scan may begin with: more of it may do.
            Err(_) if 2 * *next <= MOST_WAITING => *next *= 2,
            Err(why) => self.settle(Err(why), out),
        }
    }

    /// There are no more points: those that wait have to do.
    pub(super) fn finish(&mut self, out: impl FnMut(Point, &Plane)) {
        if let Projector::Fitting { waiting, .. } = self {
            let found = through(waiting);
            self.settle(found, out);
        }
    }

    /// The plane; z = 0 as long as it is not known.
    pub(super) fn plane(&self) -> Plane {
        match self {
            Projector::Given(plane) | Projector::Fitted { plane, .. } => *plane,
            Projector::Fitting { .. } | Projector::Unfitted { .. } => Plane::XY,
        }
    }

    /// How many points wait for the plane.
    pub(super) fn waiting(&self) -> u64 {
        match self {
            Projector::Fitting { waiting, .. } => waiting.len() as u64,
            _ => 0,
        }
    }

    /// As reports write it; `None` where the projection is along z and nothing else was asked for.
    pub(super) fn figures(&self) -> Option<ProjectionFigures> {
        match self {
            Projector::Given(plane) if *plane == Plane::XY => None,
            Projector::Given(plane) => Some(ProjectionFigures::Given { plane: figures(plane) }),
            Projector::Fitting { wanted, next, waiting } => Some(ProjectionFigures::Fitting {
                points: waiting.len() as u64,
                wanted: *next as u64,
                tried: next > wanted,
            }),
            Projector::Fitted { plane, points } => {
                Some(ProjectionFigures::Fitted { plane: figures(plane), points: *points as u64 })
            }
            Projector::Unfitted { points, why } => Some(ProjectionFigures::Unfitted {
                plane: figures(&Plane::XY),
                points: *points as u64,
                reason: why.to_string(),
            }),
        }
    }

    fn settle(&mut self, found: Result<Plane, PlaneError>, mut out: impl FnMut(Point, &Plane)) {
        let Projector::Fitting { waiting, .. } = self else { return };
        let waiting = std::mem::take(waiting);
        let points = waiting.len();
        *self = match found {
            Ok(plane) => Projector::Fitted { plane, points },
            Err(why) => Projector::Unfitted { points, why },
        };
        let plane = self.plane();
        waiting.into_iter().for_each(|point| out(laid(point, &plane), &plane));
    }
}

/// A point in the frame of a plane.
fn laid(point: Point, plane: &Plane) -> Point {
    Point { at_mm: plane.to_plane(point.at_mm), ..point }
}

/// The vertices of a mesh in the measured frame.
pub(super) fn measured<'a>(mesh: &'a Mesh, plane: &Plane) -> Cow<'a, [PointMm]> {
    if *plane == Plane::XY {
        return Cow::Borrowed(mesh.points());
    }
    mesh.points().iter().map(|point| plane.from_plane(*point)).collect()
}

/// The least-squares plane, with u and v zero at the origin of the measured frame.
fn through(points: &[Point]) -> Result<Plane, PlaneError> {
    let places_mm: Vec<PointMm> = points.iter().map(|point| point.at_mm).collect();
    let fitted = Plane::fitted(&places_mm)?;
    let (normal, centre_mm) = (fitted.normal(), fitted.origin_mm());
    let height_mm: f64 = (0..3).map(|axis| normal[axis] * centre_mm[axis]).sum();
    Plane::new(normal.map(|coordinate| height_mm * coordinate), normal)
}

fn figures(plane: &Plane) -> PlaneFigures {
    let [u, v, normal] = plane.axes();
    PlaneFigures { normal, origin_mm: plane.origin_mm(), u, v }
}

/// Points a plane is fitted from, where nothing else is said.
pub const DEFAULT_POINTS: usize = 1000;
/// Points that a plane needs.
pub const MIN_POINTS: usize = 3;
/// Points of a fitted plane at most.
pub const MAX_POINTS: usize = 1_000_000;
/// Points that may wait: 25 MB of them.
const MOST_WAITING: usize = 1 << 20;

#[cfg(test)]
mod tests;
