//! Sections of a part, while it is measured and afterwards, and what else its finished mesh can be asked.

use std::fmt;
use std::sync::{Arc, OnceLock};

use asphera_form::{Aperture, Grid as MapGrid, Nominal, Pose, deviations};
use asphera_geometry::{BoundsMm, PointMm, VertexId, place};
use asphera_mesh::Mesh;
use asphera_report::{
    Cut, FormViewAnswer, Refusal, SamplingMaps, SectionReport, SectionRequest, Term,
};
use asphera_surface::Plane;

use super::assessment::assess;
use super::details::sample;
use super::maps::{Raster, maps};
use super::removal::{RemovalError, of_points};
use super::sampling::Remembered;
use super::space::SurfaceInSpace;
use crate::Part;
use crate::section::{Deviations, Way, report, report_of_plane, way};

/// Cuts a mesh that grows, of a part in the frame of a plane of projection. `lies` is where the nominal lies in it, if there is
/// a fit.
pub(super) fn cut(
    mesh: &Mesh,
    (part, projection): (&Part, &Plane),
    lies: Option<(&Nominal, &Pose)>,
    gap_limit_mm: Option<f64>,
    request: &SectionRequest,
) -> Result<SectionReport, Refusal> {
    let centre_mm = lies.map_or([0.0; 2], |(_, pose)| [pose.tx_mm, pose.ty_mm]);
    let deviations_nm = lies.map(|(nominal, pose)| {
        move |vertices: &[VertexId]| {
            let met: Vec<PointMm> =
                vertices.iter().map(|vertex| mesh.points()[*vertex as usize]).collect();
            let mut all_nm = deviations(&met, nominal, pose);
            for (point, deviation) in met.iter().zip(&mut all_nm) {
                let [x, y, _] = pose.to_part(*point);
                let inside = part.aperture.contains(x, y);
                *deviation = if inside { *deviation * 1e6 } else { f64::NAN };
            }
            all_nm
        }
    });
    let deviations_nm = deviations_nm.as_ref().map(|of| of as &Deviations);
    let found = way(request, centre_mm, projection).and_then(|way| match way {
        Way::Path(path) => report(mesh, &path, gap_limit_mm, deviations_nm),
        Way::Plane(plane) => report_of_plane(mesh, &plane, gap_limit_mm, deviations_nm),
    });
    found.map_err(Refusal::new)
}

/// A finished mesh, to be cut and mapped.
#[derive(Clone)]
pub struct FinishedMesh {
    mesh: Arc<Mesh>,
    setting: Setting,
    maps: Arc<OnceLock<Option<Arc<SamplingMaps>>>>,
}

/// Circumstances of a finished mesh.
#[derive(Clone)]
pub(super) struct Setting {
    pub(super) part: Part,
    pub(super) plane: Plane,
    /// The nominal as fitted, if there is a fit.
    pub(super) lies: Option<(Nominal, Pose)>,
    pub(super) gap_limit_mm: Option<f64>,
    /// The area each point stands for.
    pub(super) areas_mm2: Arc<[f64]>,
    /// The cells of the maps.
    pub(super) grid: Option<MapGrid>,
    /// Tells the maps from those made before.
    pub(super) maps_version: u64,
    /// The local feature size of the last look.
    pub(super) remembered: Remembered,
    /// Of points that were meshed in space their surface, if they have one; `None` of others.
    pub(super) in_space: Option<Option<SurfaceInSpace>>,
}

impl FinishedMesh {
    pub(super) fn new(mesh: Mesh, setting: Setting) -> FinishedMesh {
        FinishedMesh { mesh: Arc::new(mesh), setting, maps: Arc::default() }
    }

    /// The mesh, in the frame of the plane of projection.
    pub fn mesh(&self) -> &Mesh {
        &self.mesh
    }

    /// The plane of projection.
    pub fn plane(&self) -> &Plane {
        &self.setting.plane
    }

    /// How to tell [`FinishedMesh::maps`] from others of the same part; `None` where there are none.
    pub fn maps_version(&self) -> Option<u64> {
        self.setting.grid.map(|_| self.setting.maps_version)
    }

    /// Maps of the sampling; `None` where there are too few points for a grid. Made when first asked for, in
    /// time in proportion to the points, so that nobody waits for them who does not look.
    pub fn maps(&self) -> Option<Arc<SamplingMaps>> {
        let Setting { part, plane, lies, grid, maps_version, remembered, .. } = &self.setting;
        let make = || {
            let pose = lies.as_ref().map(|(_, pose)| *pose).unwrap_or_default();
            let mut remembered = remembered.clone();
            let seen = assess(&self.mesh, part, &pose, plane, &mut remembered);
            let lfs_mm = remembered.lfs_mm(&pose);
            let raster = Raster { grid: grid.as_ref()?, version: *maps_version };
            maps(&self.mesh, &seen, part, &pose, raster, lfs_mm).ok().map(Arc::new)
        };
        self.maps.get_or_init(make).clone()
    }

    /// Where a place of the part frame lies in the frame of the mesh, mm; `None` without a fit.
    pub fn on_plane(&self, part_mm: PointMm) -> Option<PointMm> {
        self.setting.lies.as_ref().map(|(_, pose)| pose.to_measured(part_mm))
    }

    /// Smallest and largest u and v of the vertices, mm; `None` without a vertex.
    pub(crate) fn extent_mm(&self) -> Option<[[f64; 2]; 2]> {
        BoundsMm::about(self.mesh.points().iter().map(|&point| place(point))).corners()
    }

    /// Smallest and largest u and v of the aperture of the part as fitted, mm: as [`FinishedMesh::counts_at`],
    /// at the height of the vertex. `None` without a fit and where every point counts.
    pub(crate) fn aperture_extent_mm(&self) -> Option<[[f64; 2]; 2]> {
        let (_, pose) = self.setting.lies.as_ref()?;
        let aperture = &self.setting.part.aperture;
        let mut half_mm = aperture.half_extents_mm()?;
        if !aperture.is_round() {
            // The corners of a turned rectangle, the one or the other pair.
            let (sin, cos) = pose.rz_rad.sin_cos();
            let [half_x, half_y] = half_mm;
            half_mm =
                [half_x * cos.abs() + half_y * sin.abs(), half_x * sin.abs() + half_y * cos.abs()];
        }
        let centre_mm = [pose.tx_mm, pose.ty_mm];
        Some([
            [centre_mm[0] - half_mm[0], centre_mm[1] - half_mm[1]],
            [centre_mm[0] + half_mm[0], centre_mm[1] + half_mm[1]],
        ])
    }

    /// Whether a place of the plane of projection, mm, lies in the aperture of the part as fitted; not
    /// where every point counts. It is taken at the height of the vertex: a tilt moves the border by its
    /// sine times the height of the surface there.
    pub(crate) fn counts_at(&self, [u, v]: [f64; 2]) -> bool {
        let Setting { part, lies, .. } = &self.setting;
        lies.as_ref().is_some_and(|(_, pose)| {
            let [x, y, _] = pose.to_part([u, v, pose.tz_mm]);
            part.aperture != Aperture::None && part.aperture.contains(x, y)
        })
    }

    /// The final deviation without `terms`, of every point; `None` without a fit. Takes time in proportion to
    /// the points.
    pub fn without(&self, terms: &[Term]) -> FormViewAnswer {
        let Setting { part, lies, areas_mm2, grid, .. } = &self.setting;
        let ((nominal, pose), grid) = (lies.as_ref()?, grid.as_ref()?);
        let points = self.mesh.points();
        let deviations_mm = deviations(points, nominal, pose);
        let sample = sample(part, pose, points, &deviations_mm, areas_mm2);
        let view = sample.map_err(RemovalError::from);
        Some(view.and_then(|sample| of_points(&sample, grid, terms)).map_err(Refusal::new))
    }

    /// The surface of points that were meshed in space.
    pub fn in_space(&self) -> Option<&SurfaceInSpace> {
        self.setting.in_space.as_ref()?.as_ref()
    }

    /// Cuts it; `None` without a vertex. Takes time in proportion to the triangles met, and of a plane to all.
    ///
    /// # Errors
    ///
    /// When the path makes no sense.
    pub fn section(&self, request: &SectionRequest) -> Cut {
        let Setting { part, plane, lies, gap_limit_mm, in_space, .. } = &self.setting;
        if let Some(surface) = in_space {
            return surface.as_ref().map(|surface| surface.section(request));
        }
        let lies = lies.as_ref().map(|(nominal, pose)| (nominal, pose));
        (!self.mesh.points().is_empty())
            .then(|| cut(&self.mesh, (part, plane), lies, *gap_limit_mm, request))
    }
}

impl fmt::Debug for FinishedMesh {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("FinishedMesh")
            .field("counts", &self.mesh.counts())
            .field("gap_limit_mm", &self.setting.gap_limit_mm)
            .finish_non_exhaustive()
    }
}
