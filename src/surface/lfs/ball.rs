//! The largest ball that touches a point of a surface from one side and holds no other.
//!
//! Such a ball is shrunk onto its point (J. Ma, S. W. Bae, S. Choi, The Visual Computer 28 (2012)
//! 7-19, doi:10.1007/s00371-011-0594-7): as long as another point lies in it, it is replaced by the
//! ball that touches both. Its centre is then a point of the medial axis.
//!
//! **Noise.** A point q at the distance d from p, higher by h over the tangent plane at p, is touched
//! by the ball of curvature 1/r = 2h/d². An error e of h is an error 2e/d² of it: near neighbours say
//! nothing. R. Peters (Geographical point cloud modelling with the 3D medial axis transform, thesis,
//! TU Delft 2018, doi:10.4233/uuid:f3a5f5af-ea54-40ba-8702-e193a087f243) stops shrinking when the
//! angle p-centre-q becomes small. Here the ball may instead be pierced as deeply as the noise
//! explains, the *tolerance* t: q counts if it lies in the ball about the same centre with radius
//! r - t, that is if d² - t² < 2r (h - t). Then the curvature found is the largest that is sure,
//! max over q of 2(h - t)/(d² - t²), and the angle settles itself: small balls may have
//! near witnesses, large ones have far ones. That ball is an upper bound. The ball through the
//! witness itself, 1/r = 2h/d², is the estimate.
//!
//! **Tilt.** A normal wrong by δ lifts near neighbours on one side by δd. Given the tolerance t, the
//! curvature this feigns is at most max over d of 2(δd - t)/d² = δ²/2t. So a tolerance in proportion to
//! the radius, t = δ²r/2f, keeps the fault of the radius below the fraction f. It need not exceed what
//! the tilt lifts, δd.
//!
//! **Resolution.** Cubes of a [`FINENESS`]th of the radius are seen by one point each. A surface that
//! is smooth on that scale hides no more of itself between such points than second order:
//! 0.4 % of the radius.

use asphera_geometry::PointMm;

use super::octree::{Cube, Octree};
use super::vector::{dot, minus};

/// The radius of a ball over the side of the cubes its search looks at.
pub(super) const FINENESS: f64 = 16.0;

/// How deeply a ball may be pierced.
#[derive(Clone, Copy, Debug)]
pub(super) struct Tolerance {
    /// By noise, in mm.
    pub(super) mm: f64,
    /// By tilt, for each mm of the radius...
    pub(super) share: f64,
    /// ...but no more than so many mm for each mm of the way from the root.
    pub(super) tilt: f64,
    /// Points nearer to the root than this many mm say nothing: the root's own among them, beside
    /// which it may lie.
    pub(super) blind_mm: f64,
}

impl Tolerance {
    /// For a point `way_mm` from the root.
    fn at_mm(&self, radius_mm: f64, way_mm: f64) -> f64 {
        self.mm + (self.share * radius_mm).min(self.tilt * way_mm)
    }
}

/// Where a ball begins: in `at_mm`, growing along the unit vector `direction`.
#[derive(Clone, Copy, Debug)]
pub(super) struct Root {
    pub(super) at_mm: PointMm,
    pub(super) direction: [f64; 3],
}

/// A ball that was shrunk onto a point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Shrunk {
    /// The largest radius the noise allows, in mm.
    pub(super) radius_mm: f64,
    /// The point that forbids a larger one.
    pub(super) witness: u32,
}

impl Root {
    /// The radius in mm of the ball through a point; `None` if the point is not on its side.
    pub(super) fn radius_through_mm(&self, point: PointMm) -> Option<f64> {
        let way = minus(point, self.at_mm);
        let height_mm = dot(way, self.direction);
        (height_mm > 0.0).then(|| 0.5 * dot(way, way) / height_mm)
    }

    /// The radius in mm to which a point that pierces a ball beyond the tolerance shrinks it; `None`
    /// if it does not pierce it.
    ///
    /// Where the tolerance t does not depend on r that is (d² - t²) / 2(h - t). Where t = m + sr it is the
    /// smaller root of (2s - s²) r² - 2(h - m + sm) r + d² - m²; between its roots the point pierces.
    fn shrunk_mm(&self, radius_mm: f64, point: PointMm, tolerance: &Tolerance) -> Option<f64> {
        let Tolerance { mm, share, blind_mm, .. } = *tolerance;
        let way = minus(point, self.at_mm);
        let (squared, height_mm) = (dot(way, way), dot(way, self.direction));
        let way_mm = squared.sqrt();
        let now_mm = tolerance.at_mm(radius_mm, way_mm);
        let over = squared - now_mm * now_mm;
        let pierced = over < 2.0 * radius_mm * (height_mm - now_mm);
        if !pierced || over <= 0.0 || way_mm < blind_mm {
            return None;
        }
        let constant_mm = 0.5 * over / (height_mm - now_mm);
        let constant = share * constant_mm.min(radius_mm) >= tolerance.tilt * way_mm;
        let shrunk_mm = if constant {
            constant_mm
        } else {
            let square = share * (2.0 - share);
            let half = height_mm - mm + share * mm;
            let over = squared - mm * mm;
            over / (half + (half * half - square * over).max(0.0).sqrt())
        };
        (shrunk_mm < radius_mm).then_some(shrunk_mm)
    }

    /// Whether a ball pierced by `tolerance_mm` may have a witness in a cube.
    ///
    /// With s the way from the root, the ball is |s|² - 2r s·u < t² - 2rt. The left side is a sum over
    /// the axes, so its least value over a cube is the sum of the least values, exactly; no
    /// centre far away takes part.
    fn may_hold(
        &self,
        radius_mm: f64,
        cube: &Cube,
        tolerance: &Tolerance,
        rounding_mm: f64,
    ) -> bool {
        let mut tolerance_mm = tolerance.mm;
        if tolerance.share > 0.0 {
            let way_mm = (cube.distance_mm(self.at_mm) - 2.0 * rounding_mm).max(0.0);
            tolerance_mm = tolerance.at_mm(radius_mm, way_mm);
        }
        let mut least = 0.0;
        for axis in 0..3 {
            let low = cube.low_mm[axis] - self.at_mm[axis] - rounding_mm;
            let high = low + cube.side_mm + 2.0 * rounding_mm;
            let bottom = radius_mm * self.direction[axis];
            let nearest = bottom.clamp(low, high);
            least += nearest * (nearest - 2.0 * bottom);
        }
        least < tolerance_mm * tolerance_mm - 2.0 * radius_mm * tolerance_mm
    }
}

/// What a search needs besides the ball: the points in their tree, and room to work in.
pub(super) struct Search<'a> {
    pub(super) points: &'a [PointMm],
    pub(super) tree: &'a Octree,
    pub(super) tolerance: Tolerance,
    /// How far rounding may put a cube beside its points, in mm.
    pub(super) rounding_mm: f64,
    /// Cubes still to be looked at.
    pub(super) queue: Vec<Cube>,
}

impl Search<'_> {
    /// Shrinks the ball of radius `from_mm`; `None` if nothing pierces it.
    ///
    /// It is the largest ball up to that radius which no point pierces that the search sees, at the
    /// first resolution fine enough for the ball itself. Points that do not pierce the
    /// result do not change it, whether they are there or not.
    pub(super) fn shrink(&mut self, root: Root, from_mm: f64) -> Option<Shrunk> {
        let whole = self.tree.root()?;
        let mut finest_mm = whole.side_mm / FINENESS;
        let mut ball = Shrunk { radius_mm: from_mm, witness: whole.point };
        let mut touched = false;
        loop {
            let shrunk = self.pass(root, &mut ball, finest_mm, 0);
            touched |= shrunk;
            let finest = finest_mm <= self.tree.smallest_mm();
            if !finest && finest_mm > ball.radius_mm / FINENESS {
                finest_mm *= 0.5;
            } else if !shrunk || self.tolerance.share == 0.0 {
                return touched.then_some(ball);
            }
            // Else it is looked at again: with a share for tilt a smaller ball may be pierced where
            // a larger one was not.
        }
    }

    /// Whether a point numbered `since` or later pierces the ball.
    pub(super) fn is_pierced_since(&mut self, root: Root, radius_mm: f64, since: u32) -> bool {
        let Some(whole) = self.tree.root() else { return false };
        let mut finest_mm = whole.side_mm / FINENESS;
        while finest_mm > radius_mm / FINENESS && finest_mm > self.tree.smallest_mm() {
            finest_mm *= 0.5;
        }
        self.pass(root, &mut Shrunk { radius_mm, witness: 0 }, finest_mm, since)
    }

    /// Goes through the cubes the ball meets, large ones first, down to the side `finest_mm`, and
    /// shrinks it where it is pierced.
    fn pass(&mut self, root: Root, ball: &mut Shrunk, finest_mm: f64, since: u32) -> bool {
        let mut touched = false;
        self.queue.clear();
        self.queue.extend(self.tree.root());
        let mut next = 0;
        while let Some(&cube) = self.queue.get(next) {
            next += 1;
            let Search { tolerance, rounding_mm, .. } = &*self;
            if cube.newest < since || !root.may_hold(ball.radius_mm, &cube, tolerance, *rounding_mm)
            {
                continue;
            }
            let point = self.points[cube.point as usize];
            if let Some(radius_mm) = root.shrunk_mm(ball.radius_mm, point, &self.tolerance) {
                *ball = Shrunk { radius_mm, witness: cube.point };
                touched = true;
            }
            if cube.side_mm > finest_mm {
                self.queue.extend(self.tree.children(cube));
            }
        }
        touched
    }
}

/// The largest radius that is looked for over the extent of the points.
pub(super) const LARGEST: f64 = 1e4;
