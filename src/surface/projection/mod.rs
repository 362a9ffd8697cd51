//! In which plane a surface is projectable, if it is not in the present one.

mod directions;
mod plane;
mod principal;

use std::fmt;

use asphera_geometry::{PointMm, VertexId};
use asphera_mesh::Mesh;

use self::directions::{over_half_sphere, upwards};
use self::plane::principal;
pub use self::plane::{Plane, PlaneError};
use crate::relief::sides;
use crate::{Kind, Region, Relief, topography};

/// In which plane points are projectable.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Projectability {
    /// No fold was found in the projection on this plane, the best of those tried.
    Projectable {
        /// The plane, through the mean of the points.
        plane: Plane,
        /// 95 % of the triangles have no side that is steeper, in rad.
        slope_p95_rad: f64,
        /// Share of the projected area that lies in walls and spikes, 0 to 1.
        steep_share: f64,
    },
    /// A fold was found in every projection.
    Nowhere {
        /// The plane with the least fold.
        best: Plane,
        /// What stands against it.
        why: Obstacle,
    },
}

/// Why a projection is not one-to-one.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Obstacle {
    /// The largest fold, in the coordinates u, v, w of the plane.
    Fold(Region),
    /// So many of the points tried stand exactly above others.
    Conflicts(u64),
}

impl fmt::Display for Projectability {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Projectability::Projectable { plane, slope_p95_rad, .. } => {
                let slope_deg = slope_p95_rad.to_degrees();
                write!(f, "projectable on the plane with {plane}; 95 % slope below {slope_deg:.1}°")
            }
            Projectability::Nowhere { best, why } => {
                write!(f, "projectable on no plane tried; on the best, with {best}: {why}")
            }
        }
    }
}

impl fmt::Display for Obstacle {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Obstacle::Fold(region) => write!(f, "{region}"),
            Obstacle::Conflicts(points) => write!(f, "{points} points exactly above others"),
        }
    }
}

/// Tries in which plane the points are projectable.
///
/// Tried are the planes normal to the principal axes of the points and to 81 directions over the half
/// sphere, no direction being farther than 12° from one of them. Each is tried on at most
/// [`THINNED_POINTS`] points, taken at equal steps in their order, by triangulating the projection
/// and asking [`topography`]. The best plane has the smallest share of folds and of points exactly
/// above others, and of those without any the gentlest slope on average.
///
/// Thinning makes the samples sparse, and [`topography`] does not see sheets nearer than about four
/// of their spacings, nor overhangs of one: ask it again with all points in the plane found.
/// `Nowhere` means that none of the directions tried will do. One that is projectable in a narrow
/// cone only, of less than 12° about its axis, may have been missed.
///
/// Some 84 triangulations of at most [`THINNED_POINTS`] points, whatever the number given. Points
/// that do not determine a plane are refused, but a single curve is not: any plane may do for it.
pub fn projectable_along(
    points: &[PointMm],
    relief: &Relief,
) -> Result<Projectability, PlaneError> {
    let step = points.len().div_ceil(THINNED_POINTS).max(1);
    let thinned: Vec<PointMm> = points.iter().copied().step_by(step).collect();
    let principal = principal(&thinned)?;
    let axes = principal.axes.into_iter().rev().map(upwards);
    let mut best: Option<Trial> = None;
    for normal in axes.chain(over_half_sphere()) {
        let trial = Trial::of(&thinned, Plane::new(principal.centre_mm, normal)?, relief);
        if best.as_ref().is_none_or(|best| trial.is_better_than(best)) {
            best = Some(trial);
        }
    }
    Ok(best.expect("the principal axes are tried").verdict())
}

/// Points on which a plane is tried, at most.
pub const THINNED_POINTS: usize = 5_000;

/// A projection and what became of it.
struct Trial {
    plane: Plane,
    conflicts: u64,
    /// The largest fold.
    fold: Option<Region>,
    /// Share of the projected area in folds, and share of the points in conflict.
    folded_share: f64,
    /// Share of the projected area in walls and spikes.
    steep_share: f64,
    slope_mean_rad: f64,
    slope_p95_rad: f64,
}

impl Trial {
    fn of(points: &[PointMm], plane: Plane, relief: &Relief) -> Trial {
        let mut mesh = Mesh::with_conflict_tolerance(relief.step_mm());
        mesh.extend(points.iter().map(|&point| plane.to_plane(point)));
        mesh.flush();
        let triangles: Vec<[VertexId; 3]> = mesh.triangles();
        let found = topography(mesh.points(), &triangles, relief);
        let area_mm2 = mesh.area().projected_mm2;
        let share = |kept: &dyn Fn(&Region) -> bool| {
            let regions = found.regions().iter().filter(|region| kept(region));
            let steep_mm2: f64 = regions.map(|region| region.projected_area_mm2).sum();
            if area_mm2 > 0.0 { steep_mm2 / area_mm2 } else { 0.0 }
        };
        let [slope_mean_rad, slope_p95_rad] = slopes_rad(mesh.points(), &triangles);
        Trial {
            plane,
            conflicts: mesh.counts().conflicts,
            fold: found.regions().first().copied().filter(|region| region.kind == Kind::Fold),
            folded_share: share(&|region| region.kind == Kind::Fold)
                + mesh.counts().conflicts as f64 / points.len() as f64,
            steep_share: share(&|region| region.kind != Kind::Fold),
            slope_mean_rad,
            slope_p95_rad,
        }
    }

    /// Whether it ranks before `other`; the earlier one stays where they are equal.
    fn is_better_than(&self, other: &Trial) -> bool {
        let folds = |trial: &Trial| trial.conflicts > 0 || trial.fold.is_some();
        let ordering = folds(self)
            .cmp(&folds(other))
            .then(self.folded_share.total_cmp(&other.folded_share))
            .then(self.slope_mean_rad.total_cmp(&other.slope_mean_rad));
        ordering.is_lt()
    }

    fn verdict(self) -> Projectability {
        let Trial { plane, slope_p95_rad, steep_share, .. } = self;
        match (self.fold, self.conflicts) {
            (Some(fold), _) => Projectability::Nowhere { best: plane, why: Obstacle::Fold(fold) },
            (None, 0) => Projectability::Projectable { plane, slope_p95_rad, steep_share },
            (None, conflicts) => {
                Projectability::Nowhere { best: plane, why: Obstacle::Conflicts(conflicts) }
            }
        }
    }
}

/// Mean over the triangles of the slope of their steepest sides in rad, and the slope that 95 % of
/// them do not pass; upright if there are no triangles.
fn slopes_rad(points: &[PointMm], triangles: &[[VertexId; 3]]) -> [f64; 2] {
    let slope = |[p, q]: [VertexId; 2]| {
        let [p, q] = [p, q].map(|end| points[end as usize]);
        (q[2] - p[2]).abs().atan2((q[0] - p[0]).hypot(q[1] - p[1]))
    };
    let mut slopes: Vec<f64> = triangles
        .iter()
        .map(|&corners| sides(corners).into_iter().map(slope).fold(0.0, f64::max))
        .collect();
    if slopes.is_empty() {
        return [std::f64::consts::FRAC_PI_2; 2];
    }
    let mean = slopes.iter().sum::<f64>() / slopes.len() as f64;
    let wanted = (slopes.len() - 1) * 95 / 100;
    [mean, *slopes.select_nth_unstable_by(wanted, f64::total_cmp).1]
}
