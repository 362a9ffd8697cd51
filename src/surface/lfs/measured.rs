//! Local feature size from measured points with normals, kept up while they arrive.

use std::collections::HashMap;

use asphera_geometry::{PointMm, admit};
use nalgebra::{Matrix3, SymmetricEigen, Vector3};

use super::axis::{Limits, MedialAxis, MedialBall, Side, entered_mm};
use super::ball::{FINENESS, LARGEST, Root, Search, Shrunk, Tolerance};
use super::error::{LfsError, not_negative, positive};
use super::footing::{Footing, Oriented, footing};
use super::octree::{Cube, Octree};
use super::value::Why;
use super::vector::{minus, unit};

/// How well the points show the surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Accuracy {
    /// No point of the surface is farther from the nearest measured point than this many mm: the
    /// largest gap of [`assess`](crate::assess) among the triangles that count. About 0.7 of the pitch of a
    /// raster.
    pub gap_mm: f64,
    /// Standard deviation of the points along the normal, in mm.
    pub position_mm: f64,
    /// Standard deviation of the tilt of the normals, in rad: noise as well as what the way by which
    /// they were had gets wrong.
    pub normal_rad: f64,
}

/// The medial balls of a measured surface.
///
/// Points and normals are inserted as they come, in cheap steps; [`MeasuredLfs::refresh`] then grows
/// balls where there are new points, and shrinks those that new points pierce. Balls are shrunk onto a thinned
/// set of the points, as dense as the surface bends: cubes of an 8th of the smaller radius found
/// hold one each. So their number depends on area over lfs², not on the number of points.
///
/// **What new points do.** A ball is kept from growing by points, so more of them only shrink it: its
/// radius, and with it the local feature size at its own point, can only sink, and what is kept from before is where the
/// search goes on. At other places the local feature size may also rise, when a ball whose centre was
/// near is found to be pierced. So values at places are had from the [`MedialAxis`] of the last
/// refresh, not remembered.
///
/// **The border.** Points there hold balls back like all others; the surface is what was measured.
#[derive(Clone, Debug)]
pub struct MeasuredLfs {
    accuracy: Accuracy,
    tree: Octree,
    /// The points in the tree, with their number as the caller counts and their normals.
    points: Vec<PointMm>,
    numbers: Vec<u32>,
    normals: Vec<Option<[f64; 3]>>,
    taken: usize,
    spread: Spread,
    balls: HashMap<u32, Known>,
}

/// Data known of a point.
#[derive(Clone, Copy, Debug)]
struct Known {
    footing: Footing,
    /// The balls of both sides; where there is none nothing was found up to the largest radius.
    balls: [Option<Shrunk>; 2],
    /// The points there were when they were found.
    points: u32,
    /// The side of the cube of all points then.
    extent_mm: f64,
}

impl MeasuredLfs {
    /// Without any points yet.
    ///
    /// # Errors
    ///
    /// When a figure is not finite, a standard deviation negative, the gap not above zero, or the
    /// tilt above 0.1 rad.
    pub fn new(accuracy: Accuracy) -> Result<MeasuredLfs, LfsError> {
        let gap_mm = positive("gap_mm", accuracy.gap_mm)?;
        not_negative("position_mm", accuracy.position_mm)?;
        not_negative("normal_rad", accuracy.normal_rad)?;
        if accuracy.normal_rad > 0.1 {
            let found = accuracy.normal_rad;
            return Err(LfsError::Argument { name: "normal_rad", found, allowed: "at most 0.1" });
        }
        Ok(MeasuredLfs {
            accuracy,
            tree: Octree::new(0.5 * gap_mm),
            points: Vec::new(),
            numbers: Vec::new(),
            normals: Vec::new(),
            taken: 0,
            spread: Spread::default(),
            balls: HashMap::new(),
        })
    }

    /// Takes points with their normals, of any length; `None` where a normal is not known, as on the border: such a
    /// point holds balls back but none is shrunk onto it. Points are counted from 0 over all calls.
    ///
    /// Of points nearer to each other than half a gap some are left out: 24 bytes for the point, 36 for its
    /// number and normal and some 50 for its place in the tree are only needed for the others.
    ///
    /// # Errors
    ///
    /// When the lists differ in length, a coordinate or normal is not finite, or a normal is zero;
    /// then none of the points is taken.
    pub fn insert(
        &mut self,
        points: &[PointMm],
        normals: &[Option<[f64; 3]>],
    ) -> Result<(), LfsError> {
        if points.len() != normals.len() {
            return Err(LfsError::Lengths { points: points.len(), normals: normals.len() });
        }
        let total = self.taken + points.len();
        if total >= u32::MAX as usize {
            return Err(LfsError::TooMany { found: total });
        }
        for (index, (&point, &normal)) in points.iter().zip(normals).enumerate() {
            let [x, y, z] = point;
            admit(point).map_err(|_| LfsError::Point { index, x, y, z })?;
            normal.map(|normal| direction(index, normal)).transpose()?;
        }
        for (&point, &normal) in points.iter().zip(normals) {
            self.spread.add(point);
            self.points.push(point);
            if self.tree.insert(&self.points, self.points.len() as u32 - 1) {
                self.numbers.push(self.taken as u32);
                self.normals.push(normal.and_then(unit));
            } else {
                self.points.pop();
            }
            self.taken += 1;
        }
        Ok(())
    }

    /// Gives point `number` another normal: one that was unknown, or got better as the mesh grew.
    /// No effect if there is no such point or it was left out.
    ///
    /// # Errors
    ///
    /// When the normal is not finite or zero.
    pub fn orient(&mut self, number: u32, normal: Option<[f64; 3]>) -> Result<(), LfsError> {
        let normal = normal.map(|normal| direction(number as usize, normal)).transpose()?;
        if let Ok(index) = self.numbers.binary_search(&number)
            && self.normals[index] != normal
        {
            self.normals[index] = normal;
            self.balls.remove(&(index as u32));
        }
        Ok(())
    }

    /// How many points were taken.
    pub fn len(&self) -> usize {
        self.taken
    }

    /// Whether none were.
    pub fn is_empty(&self) -> bool {
        self.taken == 0
    }

    /// The medial axis of all points so far. Same points in the same order, same bits, whatever the
    /// batches and whenever it was asked for before.
    pub fn refresh(&mut self) -> MedialAxis {
        let nothing = self.nothing();
        let mut found = Vec::new();
        if let (Some(root), None) = (self.tree.root(), nothing) {
            let rounding_mm = self.tree.rounding_mm();
            let tolerance_mm = (SURE_POSITION * self.accuracy.position_mm).max(rounding_mm);
            let mut growth = Growth {
                of: Oriented { points: &self.points, normals: &self.normals, tree: &self.tree },
                accuracy: self.accuracy,
                extent_mm: root.side_mm,
                search: Search {
                    points: &self.points,
                    tree: &self.tree,
                    tolerance: Tolerance { mm: tolerance_mm, share: 0.0, tilt: 0.0, blind_mm: 0.0 },
                    rounding_mm,
                    queue: Vec::new(),
                },
                before: &mut self.balls,
                found: &mut found,
            };
            growth.descend(root, None);
        }
        let balls = found.iter().map(|found| self.ball(found)).collect();
        let tilts = self.balls.values().map(|known| known.footing.tilt_rad);
        let hidden = self.hidden_curvature(tilts.fold(0.0, f64::max));
        let largest_mm = LARGEST * self.tree.root().map_or(0.0, |root| root.side_mm);
        let hidden_mm = largest_mm.min(1.0 / hidden);
        let limits =
            Limits { beside: self.accuracy.normal_rad, hidden_mm, floor_mm: self.accuracy.gap_mm };
        MedialAxis::new(balls, limits, nothing)
    }

    /// Why nothing can be known, if so.
    fn nothing(&self) -> Option<Why> {
        if self.points.is_empty() {
            Some(Why::NoPoints)
        } else if self.normals.iter().all(Option::is_none) {
            Some(Why::NoNormals)
        } else if self.spread.breadth_mm() < self.accuracy.gap_mm {
            Some(Why::Narrow)
        } else {
            None
        }
    }

    /// The curvature in 1/mm that noise and tilt may hide: that of a wave with a half length of four gaps,
    /// as high as the tolerance.
    fn hidden_curvature(&self, tilt_rad: f64) -> f64 {
        let half_wave_mm = 4.0 * self.accuracy.gap_mm;
        let tolerance_mm =
            SURE_POSITION * self.accuracy.position_mm + SURE_TILT * tilt_rad * half_wave_mm;
        2.0 * tolerance_mm / (half_wave_mm * half_wave_mm)
    }

    /// What a shrunk ball tells.
    fn ball(&self, found: &Found) -> MedialBall {
        let Found { footing, side, shrunk } = *found;
        let root = footing.root(side);
        let witness_mm = self.points[shrunk.witness as usize];
        // The ball through the witness is the better one of the two unless the witness is so near
        // that noise decides how much smaller it is.
        let through_mm = root.radius_through_mm(witness_mm).unwrap_or(shrunk.radius_mm);
        let radius_mm = through_mm.clamp((1.0 - NEARER) * shrunk.radius_mm, shrunk.radius_mm);
        let fault = footing.fault();
        let upper_mm = (1.0 + fault) * shrunk.radius_mm + SURE_POSITION * self.accuracy.position_mm;
        // Between the samples that the search saw the surface may enter the ball.
        let hidden = self.hidden_curvature(footing.tilt_rad);
        let bent_mm = 1.0 / ((1.0 + fault) / radius_mm + hidden);
        let seen_mm = std::f64::consts::FRAC_1_SQRT_2 * bent_mm / FINENESS;
        let gap_mm = self.accuracy.gap_mm.max(seen_mm);
        let lower_mm = (bent_mm - entered_mm(bent_mm, gap_mm)).max(0.0);
        let Root { at_mm, direction } = root;
        MedialBall { at_mm, side, direction, radius_mm, lower_mm, upper_mm, witness_mm }
    }
}

impl Footing {
    fn root(&self, side: Side) -> Root {
        Root { at_mm: self.at_mm, direction: side.direction(self.normal) }
    }

    /// The tolerance of balls from here: that for noise in mm, and what the tilt needs.
    fn tolerance(&self, mm: f64, blind_mm: f64) -> Tolerance {
        Tolerance { mm, share: self.share(), tilt: SURE_TILT * self.tilt_rad, blind_mm }
    }

    /// The share of the radius by which a ball may be pierced for the tilt.
    fn share(&self) -> f64 {
        let tilt_rad = SURE_TILT * self.tilt_rad;
        (tilt_rad * tilt_rad / (2.0 * TILT_FAULT)).min(LARGEST_SHARE)
    }

    /// The fraction of the radius by which it may be false for all that.
    fn fault(&self) -> f64 {
        let tilt_rad = SURE_TILT * self.tilt_rad;
        if tilt_rad > 0.0 { tilt_rad * tilt_rad / (2.0 * self.share()) } else { 0.0 }
    }
}

/// A ball found in a refresh.
struct Found {
    footing: Footing,
    side: Side,
    shrunk: Shrunk,
}

/// The balls being found in a refresh.
struct Growth<'a> {
    of: Oriented<'a>,
    accuracy: Accuracy,
    extent_mm: f64,
    search: Search<'a>,
    before: &'a mut HashMap<u32, Known>,
    found: &'a mut Vec<Found>,
}

impl Growth<'_> {
    /// Shrinks balls onto the point of a cube, and if they are small against it, onto those of the
    /// cubes in it. `above` is the point of the cube around it, whose balls are known already, with
    /// the smaller radius in mm.
    fn descend(&mut self, cube: Cube, above: Option<(u32, f64)>) {
        let smaller_mm = match (above, self.of.normals[cube.point as usize]) {
            (Some((point, smaller_mm)), _) if point == cube.point => Some(smaller_mm),
            (_, None) => None,
            (_, Some(normal)) => Some(self.balls(cube.point, normal)),
        };
        if cube.side_mm > smaller_mm.map_or(0.0, |smaller_mm| smaller_mm / ONTO) {
            let tree = self.of.tree;
            let above = smaller_mm.map(|smaller_mm| (cube.point, smaller_mm));
            for child in tree.children(cube) {
                self.descend(child, above);
            }
        }
    }

    /// Shrinks both balls onto a point; the smaller radius in mm.
    fn balls(&mut self, point: u32, normal: [f64; 3]) -> f64 {
        let queue = &mut self.search.queue;
        let footing = footing(self.of, point, normal, &self.accuracy, queue);
        let mm = self.search.tolerance.mm;
        self.search.tolerance = footing.tolerance(mm, self.of.tree.smallest_mm());
        // What was found before still holds if it was looked for in the same way.
        let extent_mm = self.extent_mm;
        let before = self.before.get(&point).copied();
        let before =
            before.filter(|known| known.footing == footing && known.extent_mm == extent_mm);
        let largest_mm = LARGEST * extent_mm;
        let balls = [0, 1].map(|side| {
            let root = footing.root(Side::BOTH[side]);
            if let Some(Known { balls, points, .. }) = before {
                let radius_mm = balls[side].map_or(largest_mm, |ball| ball.radius_mm);
                if !self.search.is_pierced_since(root, radius_mm, points) {
                    return balls[side];
                }
            }
            self.search.shrink(root, largest_mm)
        });
        let points = self.of.points.len() as u32;
        self.before.insert(point, Known { footing, balls, points, extent_mm });
        for (side, ball) in Side::BOTH.into_iter().zip(balls) {
            self.found.extend(ball.map(|shrunk| Found { footing, side, shrunk }));
        }
        let radii = balls.iter().flatten().map(|ball| ball.radius_mm);
        radii.fold(largest_mm, f64::min)
    }
}

/// How widely points are spread, summed up as they come.
#[derive(Clone, Debug, Default)]
struct Spread {
    first_mm: Option<PointMm>,
    count: f64,
    sum: Vector3<f64>,
    squares: Matrix3<f64>,
}

impl Spread {
    fn add(&mut self, point: PointMm) {
        let way = Vector3::from(minus(point, *self.first_mm.get_or_insert(point)));
        self.count += 1.0;
        self.sum += way;
        self.squares += way * way.transpose();
    }

    /// The second largest standard deviation along the principal axes, in mm: zero on a line.
    fn breadth_mm(&self) -> f64 {
        let mean = self.sum / self.count;
        let mut variances =
            SymmetricEigen::new(self.squares / self.count - mean * mean.transpose()).eigenvalues;
        variances.as_mut_slice().sort_by(f64::total_cmp);
        variances[1].max(0.0).sqrt()
    }
}

fn direction(index: usize, normal: [f64; 3]) -> Result<[f64; 3], LfsError> {
    let [x, y, z] = normal;
    unit(normal).ok_or(LfsError::Normal { index, x, y, z })
}

/// So many standard deviations of height, of a point and its witness together, a ball may be
/// pierced: √2 for the two, times 2.8.
const SURE_POSITION: f64 = 4.0;

/// The smaller radius of a point's balls over the side of the cubes that one ball a side is shrunk
/// onto.
const ONTO: f64 = 8.0;

/// So many standard deviations of tilt are taken into account.
const SURE_TILT: f64 = 3.0;

/// The fraction of a radius by which such a tilt may falsify it; see [`super::ball`].
const TILT_FAULT: f64 = 0.02;

/// The estimate of a radius is at most this fraction below its upper bound before faults.
const NEARER: f64 = 0.01;

/// Balls pierced by more of their radius than this would say nothing.
const LARGEST_SHARE: f64 = 0.25;
