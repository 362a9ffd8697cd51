//! Local feature size from a nominal: curvature where the surface bends most, medial balls everywhere.
//!
//! The nominal is sampled on a raster. Onto each of its places a ball is shrunk on both sides, from the radius of
//! curvature down, first against the raster, then against the surface itself: the nearest place of
//! the surface to the centre is found by Newton's method, and the ball through it is the next one.
//! The local feature size at a place is its distance to the nearest centre; since that is the least over a raster of centres, it is
//! followed down between them by a compass search (R. Hooke, T. A. Jeeves, Journal of the ACM 8 (1961)
//! 212-229, doi:10.1145/321062.321069).
//!
//! The surface ends where its domain ends; what an optic looks like beyond its aperture does not count.

use asphera_geometry::PointMm;
use nalgebra::{Matrix2, SymmetricEigen};

use super::axis::{Limits, MedialAxis, MedialBall, Side, entered_mm};
use super::ball::{LARGEST, Root, Search, Tolerance};
use super::error::{LfsError, positive};
use super::octree::Octree;
use super::value::{Lfs, Why};
use super::vector::{along, distance, dot, minus};

/// A nominal z(x, y) over a domain of any shape.
pub trait Nominal {
    /// Height, slopes and second derivatives over (x, y); `None` outside the domain.
    fn jet(&self, x_mm: f64, y_mm: f64) -> Option<Jet>;

    /// The lowest and the highest x and y of the domain, in mm.
    fn extent_mm(&self) -> [[f64; 2]; 2];
}

/// A height with its first and second derivatives.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Jet {
    /// z in mm.
    pub height_mm: f64,
    /// ∂z/∂x and ∂z/∂y.
    pub slope: [f64; 2],
    /// ∂²z/∂x², ∂²z/∂x∂y and ∂²z/∂y² in 1/mm.
    pub bend_per_mm: [f64; 3],
}

impl Jet {
    fn is_finite(&self) -> bool {
        let [xx, xy, yy] = self.bend_per_mm;
        [self.height_mm, self.slope[0], self.slope[1], xx, xy, yy]
            .iter()
            .all(|part| part.is_finite())
    }

    /// The unit normal, upward.
    pub fn normal(&self) -> [f64; 3] {
        let [p, q] = self.slope;
        let length = (1.0 + p * p + q * q).sqrt();
        [-p / length, -q / length, 1.0 / length]
    }

    /// The principal curvatures in 1/mm, the smaller first, positive where the surface bends
    /// upward.
    pub fn curvatures_per_mm(&self) -> [f64; 2] {
        let [p, q] = self.slope;
        let [xx, xy, yy] = self.bend_per_mm;
        // Along the steepest ascent and across it the first form is diagonal, 1 + g² and 1, however steep the place is.
        let slope = p.hypot(q);
        let (cos, sin) = if slope > 0.0 { (p / slope, q / slope) } else { (1.0, 0.0) };
        let along = xx * cos * cos + 2.0 * xy * cos * sin + yy * sin * sin;
        let across = xx * sin * sin - 2.0 * xy * cos * sin + yy * cos * cos;
        let mixed = (yy - xx) * cos * sin + xy * (cos * cos - sin * sin);
        let stretch = slope.hypot(1.0);
        let shape =
            Matrix2::new(along / stretch / stretch, mixed / stretch, mixed / stretch, across);
        let [a, b] = SymmetricEigen::new(shape / stretch).eigenvalues.into();
        [a.min(b), a.max(b)]
    }
}

/// The local feature size of a nominal.
#[derive(Clone, Debug)]
pub struct NominalLfs<N> {
    nominal: N,
    step_mm: f64,
    tolerance: f64,
    points: Vec<PointMm>,
    tree: Octree,
    axis: MedialAxis,
}

impl<N: Nominal> NominalLfs<N> {
    /// Samples a nominal every `step_mm` and finds its medial balls. Features of the nominal narrower than two steps are
    /// not seen. Values are refined until they change by less than the fraction `tolerance`.
    ///
    /// # Errors
    ///
    /// When the step is not above zero, the tolerance not between 1e-9 and 0.1, the extent is not finite or empty, there would be more than
    /// 16 million samples, or the nominal is not finite within its domain.
    pub fn new(nominal: N, step_mm: f64, tolerance: f64) -> Result<NominalLfs<N>, LfsError> {
        positive("step_mm", step_mm)?;
        if !(1e-9..=0.1).contains(&tolerance) {
            let allowed = "between 1e-9 and 0.1";
            return Err(LfsError::Argument { name: "tolerance", found: tolerance, allowed });
        }
        let places = raster(nominal.extent_mm(), step_mm)?;
        let mut tree = Octree::new(0.5 * step_mm);
        let (mut points, mut jets) = (Vec::new(), Vec::new());
        for [x, y] in places {
            let Some(jet) = nominal.jet(x, y) else { continue };
            if !jet.is_finite() {
                return Err(LfsError::Nominal { x, y });
            }
            points.push([x, y, jet.height_mm]);
            jets.push(jet);
            tree.insert(&points, points.len() as u32 - 1);
        }
        let nothing = points.is_empty().then_some(Why::NoPoints);
        let limits = Limits { beside: 0.0, hidden_mm: f64::INFINITY, floor_mm: step_mm };
        let axis = MedialAxis::new(Vec::new(), limits, nothing);
        let mut found = NominalLfs { nominal, step_mm, tolerance, points, tree, axis };
        let mut search = found.search();
        let mut balls = Vec::new();
        for (&point, jet) in found.points.iter().zip(&jets) {
            let both = Side::BOTH.map(|side| found.ball(&mut search, point, jet, side));
            balls.extend(both.into_iter().flatten());
        }
        let largest_mm = found.largest_mm();
        found.axis = MedialAxis::new(balls, Limits { hidden_mm: largest_mm, ..limits }, nothing);
        Ok(found)
    }

    /// The medial balls of the raster: a quick answer at any place, never too small, too large by
    /// second order in the step.
    pub fn axis(&self) -> &MedialAxis {
        &self.axis
    }

    /// The local feature size over (x, y). The lower bound leaves out what the raster might not have
    /// seen of the surface between its places. Takes some hundred searches of a ball.
    pub fn at(&self, x_mm: f64, y_mm: f64) -> Lfs {
        let jet = self.nominal.jet(x_mm, y_mm).filter(Jet::is_finite);
        let (Some(jet), true) = (jet, x_mm.is_finite() && y_mm.is_finite()) else {
            return Lfs::Unknown(Why::Outside);
        };
        let place = [x_mm, y_mm, jet.height_mm];
        let mut search = self.search();
        let near = self.axis.nearest(place, CANDIDATES).into_iter();
        let starts = near.map(|index| {
            let MedialBall { at_mm, side, .. } = self.axis.balls()[index as usize];
            ([at_mm[0], at_mm[1]], side)
        });
        let own = Side::BOTH.map(|side| ([x_mm, y_mm], side));
        let least = starts
            .chain(own)
            .filter_map(|(start, side)| self.follow(&mut search, place, start, side))
            .reduce(f64::min);
        let Some(mm) = least else { return Lfs::Beyond { lower_mm: self.largest_mm() } };
        let lower_mm = (1.0 - self.tolerance) * mm - entered_mm(mm, self.step_mm);
        let upper_mm = (1.0 + self.tolerance) * mm;
        if lower_mm > 0.0 {
            Lfs::Known { mm, lower_mm, upper_mm }
        } else {
            Lfs::Hidden { upper_mm }
        }
    }

    /// The least distance in mm from a place to the centres of balls about a start.
    fn follow(
        &self,
        search: &mut Search<'_>,
        place: PointMm,
        start: [f64; 2],
        side: Side,
    ) -> Option<f64> {
        let mut way_mm = |[x, y]: [f64; 2]| {
            let jet = self.nominal.jet(x, y).filter(Jet::is_finite)?;
            let ball = self.ball(search, [x, y, jet.height_mm], &jet, side)?;
            Some(distance(ball.centre_mm(), place))
        };
        let (mut best, mut best_mm) = (start, way_mm(start)?);
        let mut step_mm = self.step_mm;
        // A centre moves by no more than about the way of its foot, and the distance to it by less: near
        // the least one by second order.
        let finest_mm = self.step_mm * self.tolerance.sqrt().min(0.1);
        while step_mm > finest_mm {
            let around = [[step_mm, 0.0], [-step_mm, 0.0], [0.0, step_mm], [0.0, -step_mm]];
            let next = around
                .into_iter()
                .map(|[x, y]| [best[0] + x, best[1] + y])
                .filter_map(|foot| way_mm(foot).map(|mm| (foot, mm)))
                .filter(|&(_, mm)| mm < best_mm * (1.0 - 0.01 * self.tolerance))
                .reduce(|a, b| if b.1 < a.1 { b } else { a });
            match next {
                Some((foot, mm)) => (best, best_mm) = (foot, mm),
                None => step_mm *= 0.5,
            }
        }
        Some(best_mm)
    }

    /// The ball on one side of a place of the nominal; `None` if it has no end.
    fn ball(
        &self,
        search: &mut Search<'_>,
        at_mm: PointMm,
        jet: &Jet,
        side: Side,
    ) -> Option<MedialBall> {
        let direction = side.direction(jet.normal());
        let [lower, upper] = jet.curvatures_per_mm();
        let bend_per_mm = if side == Side::Outer { upper } else { -lower };
        let largest_mm = self.largest_mm();
        let bent_mm =
            if bend_per_mm > 0.0 { largest_mm.min(1.0 / bend_per_mm) } else { largest_mm };
        let root = Root { at_mm, direction };
        let (radius_mm, witness_mm) = match search.shrink(root, bent_mm) {
            Some(shrunk) => {
                let seen = self.points[shrunk.witness as usize];
                self.refine(root, shrunk.radius_mm, seen)
            }
            None if bent_mm < largest_mm => (bent_mm, at_mm),
            None => return None,
        };
        Some(MedialBall {
            at_mm,
            side,
            direction,
            radius_mm,
            lower_mm: (radius_mm - entered_mm(radius_mm, self.step_mm)).max(0.0),
            upper_mm: radius_mm,
            witness_mm,
        })
    }

    /// Shrinks a ball that was found on the raster onto the surface, and the place it then touches.
    fn refine(&self, root: Root, radius_mm: f64, witness_mm: PointMm) -> (f64, PointMm) {
        let (mut radius_mm, mut witness_mm) = (radius_mm, witness_mm);
        for _ in 0..ROUNDS {
            let centre = along(root.at_mm, root.direction, radius_mm);
            let Some(foot) = self.nearest(centre, witness_mm) else { break };
            let Some(next_mm) = root.radius_through_mm(foot) else { break };
            // Too near its root a foot is rounding; the radius of curvature was the start there.
            if next_mm >= radius_mm || distance(foot, root.at_mm) < 1e-3 * radius_mm {
                break;
            }
            let settled = radius_mm - next_mm < 0.01 * self.tolerance * radius_mm;
            (radius_mm, witness_mm) = (next_mm, foot);
            if settled {
                break;
            }
        }
        (radius_mm, witness_mm)
    }

    /// The place of the surface nearest to a centre, by Newton's method from `from`; `None` if that leads
    /// out of the domain or not down.
    fn nearest(&self, centre: PointMm, from: PointMm) -> Option<PointMm> {
        let mut foot = from;
        for _ in 0..STEPS {
            let jet = self.nominal.jet(foot[0], foot[1])?;
            let [p, q] = jet.slope;
            let [xx, xy, yy] = jet.bend_per_mm;
            let [x, y, z] = minus(foot, centre);
            let downhill = [x + z * p, y + z * q];
            let a = 1.0 + p * p + z * xx;
            let b = p * q + z * xy;
            let c = 1.0 + q * q + z * yy;
            let determinant = a * c - b * b;
            if !(determinant > 0.0 && a > 0.0) {
                return None;
            }
            let step = [
                (c * downhill[0] - b * downhill[1]) / determinant,
                (a * downhill[1] - b * downhill[0]) / determinant,
            ];
            let place = [foot[0] - step[0], foot[1] - step[1]];
            let next = [place[0], place[1], self.nominal.jet(place[0], place[1])?.height_mm];
            let way = minus(next, centre);
            if dot(way, way) >= x * x + y * y + z * z {
                break;
            }
            foot = next;
        }
        Some(foot)
    }

    fn search(&self) -> Search<'_> {
        let rounding_mm = self.tree.rounding_mm();
        Search {
            points: &self.points,
            tree: &self.tree,
            tolerance: Tolerance { mm: rounding_mm, share: 0.0, tilt: 0.0, blind_mm: 0.0 },
            rounding_mm,
            queue: Vec::new(),
        }
    }

    fn largest_mm(&self) -> f64 {
        LARGEST * self.tree.root().map_or(0.0, |root| root.side_mm)
    }
}

/// The places of a raster over an extent, borders included, at most `step_mm` apart.
fn raster(
    [low, high]: [[f64; 2]; 2],
    step_mm: f64,
) -> Result<impl Iterator<Item = [f64; 2]>, LfsError> {
    let extent = [high[0] - low[0], high[1] - low[1]];
    for found in extent {
        positive("extent of the nominal in mm", found)?;
    }
    let [columns, rows] = extent.map(|extent| (extent / step_mm).ceil());
    let found = (columns + 1.0) * (rows + 1.0);
    if found > MOST_SAMPLES {
        return Err(LfsError::Samples { found, most: MOST_SAMPLES });
    }
    let place = move |row: u32, column: u32| {
        [
            low[0] + extent[0] * (f64::from(column) / columns),
            low[1] + extent[1] * (f64::from(row) / rows),
        ]
    };
    let columns = columns as u32;
    Ok((0..=rows as u32).flat_map(move |row| (0..=columns).map(move |column| place(row, column))))
}

const MOST_SAMPLES: f64 = 16e6;

/// How many of the nearest centres are followed down.
const CANDIDATES: usize = 3;

/// How often a ball is made anew; each halves what is left, at least.
const ROUNDS: usize = 40;

/// Newton's steps for the nearest place.
const STEPS: usize = 20;

#[cfg(test)]
mod tests {
    use super::*;

    /// A sphere has one curvature, however steep the place is.
    #[test]
    fn a_steep_sphere_bends_by_its_radius() {
        for slope in [0.0_f64, 1e-8, 0.7, 1e3, 1e9, 1e60] {
            for angle in [0.0_f64, 0.4, 2.0] {
                let (sin, cos) = angle.sin_cos();
                let stretch = slope.hypot(1.0);
                let (along, across) = (stretch.powi(3) / 20.0, stretch / 20.0);
                let bend_per_mm = [
                    along * cos * cos + across * sin * sin,
                    (along - across) * cos * sin,
                    along * sin * sin + across * cos * cos,
                ];
                let slope_of = [slope * cos, slope * sin];
                let jet = Jet { height_mm: 0.0, slope: slope_of, bend_per_mm };
                let [low, high] = jet.curvatures_per_mm();
                // Beside the axes the bend across a steep slope is lost in the rounding of that along it.
                let known = angle == 0.0 || slope < 1e4;
                let is_near = |per_mm: f64| (20.0 * per_mm - 1.0).abs() < 1e-8;
                assert!(low.is_finite() && high.is_finite(), "{slope} {angle}");
                assert!(!known || is_near(low) && is_near(high), "{slope} {angle}: {low} {high}");
            }
        }
    }
}
