//! The mesh of points of which nothing else is known: in the plane, or in space.

use asphera_geometry::{PointMm, VertexId};
use asphera_mesh::Mesh;
use asphera_surface::{Plane, Relief, topography};

use super::folded::still_true;
use super::projection::{Along, Projector, measured};
use super::space::{SurfaceInSpace, When};

/// Points as their direction says.
pub(super) enum Meshing {
    /// A mesh in the frame of its plane of projection.
    InPlane {
        mesh: Box<Mesh>,
        triangles: Vec<[VertexId; 3]>,
        plane: Plane,
        /// Why it is none of its surface.
        folded: Option<String>,
    },
    /// To be meshed in space, because they fold where that is said.
    InSpace { points_mm: Vec<PointMm>, folded: Option<String> },
}

impl Meshing {
    /// Meshes points as `along` says. Points that are not finite are left out of a mesh.
    pub(super) fn of(points: impl IntoIterator<Item = PointMm>, along: Along) -> Meshing {
        let when = along.in_space();
        if when == Some(When::Always) {
            return Meshing::InSpace { points_mm: points.into_iter().collect(), folded: None };
        }
        let mut points_mm = Vec::new();
        let (mut mesh, mut projector) = (Mesh::new(), Projector::new(along));
        for point in points {
            if when.is_some() {
                points_mm.push(point);
            }
            projector.take(point.into(), |point, _| mesh.push(point.at_mm));
        }
        projector.finish(|point, _| mesh.push(point.at_mm));
        mesh.flush();
        let (triangles, plane) = (mesh.triangles(), projector.plane());
        let folded = fold_of(&mesh, &triangles, &plane);
        if when.is_some() && folded.is_some() {
            return Meshing::InSpace { points_mm, folded };
        }
        Meshing::InPlane { mesh: Box::new(mesh), triangles, plane, folded }
    }
}

fn fold_of(mesh: &Mesh, triangles: &[[VertexId; 3]], plane: &Plane) -> Option<String> {
    super::folded::folded(mesh, &topography(mesh.points(), triangles, &Relief::default()), plane)
}

/// Why a mesh in the frame of a plane is none of its surface, and what to do; `None` where nothing says so.
pub fn folded(mesh: &Mesh, triangles: &[[VertexId; 3]], plane: &Plane) -> Option<String> {
    let why = fold_of(mesh, triangles, plane)?;
    let (_, advice) = still_true(&measured(mesh, plane));
    Some(format!("{why}. {advice}"))
}

/// The surface of points of which nothing else is known.
pub enum PointsSurface {
    /// Projected.
    InPlane {
        /// The mesh, in the frame of the plane.
        mesh: Box<Mesh>,
        /// The plane of projection.
        plane: Plane,
    },
    /// Meshed in space.
    InSpace(SurfaceInSpace),
}

/// The surface of points, meshed as `along` says.
///
/// # Errors
///
/// Why there is none, in words: the points fold over the plane, or make no mesh in space.
pub fn surface_of_points(
    points: impl IntoIterator<Item = PointMm>,
    along: Along,
) -> Result<PointsSurface, String> {
    match Meshing::of(points, along) {
        Meshing::InSpace { points_mm, .. } => {
            SurfaceInSpace::of_points(&points_mm).map(PointsSurface::InSpace)
        }
        Meshing::InPlane { mesh, plane, folded: None, .. } => {
            Ok(PointsSurface::InPlane { mesh, plane })
        }
        Meshing::InPlane { mesh, plane, folded: Some(why), .. } => {
            let (_, advice) = still_true(&measured(&mesh, &plane));
            Err(format!("{why}. {advice}"))
        }
    }
}
