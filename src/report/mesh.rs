//! The mesh, the plane it is projected on, and where the surface is steep.

use std::fmt;

use serde::{Deserialize, Serialize};

use crate::ReconstructionFigures;

/// The mesh.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct MeshFigures {
    /// Vertices.
    pub vertices: u64,
    /// Triangles.
    pub triangles: u64,
    /// Edges.
    pub edges: u64,
    /// Vertices on the convex hull of the projection.
    pub hull: u64,
    /// Area of the lifted triangles in mm²; in a snapshot as of `sampling.current.as_of_points`. Absent where the
    /// surface does not project.
    #[serde(default)]
    pub area_mm2: Option<f64>,
    /// Whether no two points stand above each other at different heights, and no fold was found. Never of a mesh in space.
    pub projectable: bool,
    /// The plane of projection; absent where it is along z and nothing else was asked for.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub projection: Option<ProjectionFigures>,
    /// Where the surface is steep or folded; in a snapshot as of `sampling.as_of_points`.
    #[serde(default)]
    pub relief: ReliefFigures,
    /// Places measured more than once.
    #[serde(default)]
    pub repeats: RepeatFigures,
    /// Where plane or space was to be chosen by the points: what was chosen, and why.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub decision: Option<String>,
    /// The mesh in space; absent where the points were meshed in a plane.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub reconstruction: Option<ReconstructionFigures>,
}

/// On which plane the points are projected, and how it came about.
///
/// The fit is made in the frame of the plane: its `parameters` are shifts along and turns about u, v and the
/// normal, and areas called projected are areas on the plane. Places and the pose are given in the measured
/// frame all the same.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(tag = "how", rename_all = "lowercase")]
pub enum ProjectionFigures {
    /// It was given.
    Given {
        /// The plane.
        plane: PlaneFigures,
    },
    /// It is to be fitted, and points wait for it: never in a report.
    Fitting {
        /// How many points wait.
        points: u64,
        /// At how many it is fitted.
        wanted: u64,
        /// Whether fewer were tried and lay on a line or a curve.
        tried: bool,
    },
    /// It was fitted from the first good points.
    Fitted {
        /// The plane.
        plane: PlaneFigures,
        /// From how many.
        points: u64,
    },
    /// It should have been fitted, but the first good points determine none; projected along z.
    Unfitted {
        /// The plane z = 0.
        plane: PlaneFigures,
        /// How many points were looked at.
        points: u64,
        /// Why they determine none.
        reason: String,
    },
}

/// A plane of projection in the measured frame.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct PlaneFigures {
    /// Its unit normal, on the side from which the surface is seen.
    pub normal: [f64; 3],
    /// The place where u, v and the height are zero, mm: on the normal through the origin.
    pub origin_mm: [f64; 3],
    /// Unit vector of u.
    pub u: [f64; 3],
    /// Unit vector of v; u, v and the normal are right-handed.
    pub v: [f64; 3],
}

/// Where the surface is steep or folded, inside the aperture. See `asphera_surface::topography` for what
/// points can tell.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct ReliefFigures {
    /// Where the projection is not one-to-one, the largest first. Their triangles join different sheets and
    /// count as not sampled.
    pub folds: Vec<RegionFigures>,
    /// Steps and steep flanks.
    pub walls: u64,
    /// Single readings off their surroundings.
    pub spikes: u64,
    /// If there are folds: in which plane the points would be projectable, or that none was found;
    /// directions in the measured frame.
    pub projection: Option<String>,
}

/// A region of steep triangles.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct RegionFigures {
    /// The middle of its steepest rise, measured frame, mm.
    pub at_mm: [f64; 3],
    /// Smallest coordinates of its steep sides, measured frame, mm; where the projection is not along z, of
    /// the box about them that stands on the plane.
    pub min_mm: [f64; 3],
    /// Largest coordinates, in the same way.
    pub max_mm: [f64; 3],
    /// Vertices.
    pub vertices: u64,
    /// Triangles.
    pub triangles: u64,
    /// Projected area in mm².
    pub projected_area_mm2: f64,
    /// Largest slope of a side against the plane of projection in degrees.
    pub slope_max_deg: f64,
}

/// Places measured more than once.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct RepeatFigures {
    /// How many places.
    pub places: u64,
    /// How many measurements in them.
    pub measurements: u64,
    /// Standard deviation of the heights about the mean of their place, pooled over all, in nm.
    pub spread_nm: Option<f64>,
}

impl fmt::Display for ProjectionFigures {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            ProjectionFigures::Given { plane } => write!(f, "{plane}, as given"),
            ProjectionFigures::Fitting { points, wanted, tried } => {
                write!(f, "fitting the plane: {points} of {wanted}")?;
                if *tried {
                    f.write_str("; fewer determined none")?;
                }
                Ok(())
            }
            ProjectionFigures::Fitted { plane, points } => {
                write!(f, "{plane}, fitted from {points} points")
            }
            ProjectionFigures::Unfitted { points, reason, .. } => {
                write!(f, "along z, for no plane could be fitted from {points} points: {reason}")
            }
        }
    }
}

impl fmt::Display for PlaneFigures {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let ([nx, ny, nz], [x, y, z]) = (self.normal, self.origin_mm);
        // Adding zero keeps a rounded negative zero from being written with its sign.
        let rounded = |value: f64, places: f64| (value * places).round() / places + 0.0;
        let [nx, ny, nz] = [nx, ny, nz].map(|coordinate| rounded(coordinate, 1e6));
        let [x, y, z] = [x, y, z].map(|coordinate| rounded(coordinate, 1e6));
        write!(f, "normal ({nx}, {ny}, {nz}), through ({x}, {y}, {z}) mm")
    }
}
