//! The mesh looked at as a whole: folds, sampling, area. What takes time in proportion to the triangles.

use asphera_form::Pose;
use asphera_geometry::{BoxMm, PointMm, VertexId};
use asphera_mesh::Mesh;
use asphera_report::{MeshFigures, RegionFigures, ReliefFigures, RepeatFigures, SamplingFigures};
use asphera_surface::{Kind, Plane, Region, Relief, Topography, topography};

use super::folded::{folded, still_true};
use super::sampling::{self, Findings, Next, Remembered, Sampled, Wanted, ZoneSampling};
use crate::Part;

/// Figures of a mesh, its sampling and its folds.
pub(super) struct Assessment {
    /// All triangles of the mesh.
    pub(super) triangles: Vec<[VertexId; 3]>,
    /// For each of them whether it is sampled densely enough and has a part in the aperture.
    pub(super) covered: Vec<bool>,
    pub(super) mesh: MeshFigures,
    pub(super) sampling: SamplingFigures,
    /// Why its noise is not known.
    pub(super) noise_unknown: Option<String>,
    /// That of zones that have a limit.
    pub(super) zones: Vec<ZoneSampling>,
    /// Next measurements.
    pub(super) next: Option<Next>,
    /// Why the mesh is none of the surface, if it is not.
    pub(super) folded: Option<String>,
}

/// Looks at a mesh in the frame of `plane` of a part that lies there at `pose`.
pub(super) fn assess(
    mesh: &Mesh,
    part: &Part,
    pose: &Pose,
    plane: &Plane,
    remembered: &mut Remembered,
) -> Assessment {
    let points = mesh.points();
    let triangles = mesh.triangles();
    let relief = relief_inside(points, &triangles, part, pose);
    let sampled = Sampled { mesh, triangles: &triangles, plane };
    if let Some(folded) = folded(mesh, &relief, plane) {
        let Findings { figures, covered, .. } =
            sampling::of_folded(sampled, Wanted::of(part), vec![folded.clone()]);
        let seen = MeshFigures { relief: relief_figures(&relief, plane), ..MeshFigures::default() };
        let (mesh, zones) = (with_counts(mesh, seen), Vec::new());
        let folded = Some(folded);
        return Assessment {
            mesh,
            triangles,
            covered,
            sampling: figures,
            noise_unknown: None,
            zones,
            next: None,
            folded,
        };
    }
    let mut findings = sampling::of_part(sampled, part, pose, remembered);
    let next = findings.next(plane, part, pose);
    let Findings { figures, noise_unknown, covered, area_mm2, zones, .. } = findings;
    let seen = MeshFigures {
        area_mm2: Some(area_mm2),
        relief: relief_figures(&relief, plane),
        ..MeshFigures::default()
    };
    let (mesh, folded) = (with_counts(mesh, seen), None);
    Assessment { mesh, triangles, covered, sampling: figures, noise_unknown, zones, next, folded }
}

/// The regions of steep triangles whose centres lie in the aperture.
fn relief_inside(
    points: &[PointMm],
    triangles: &[[VertexId; 3]],
    part: &Part,
    pose: &Pose,
) -> Topography {
    // Nearly always there is nothing steep anywhere, which is told without asking what is inside.
    let anywhere = topography(points, triangles, &Relief::default());
    if anywhere.regions().is_empty() {
        return anywhere;
    }
    let inside = triangles.iter().copied().filter(|corners| {
        let [x, y, _] = pose.to_part(centre_mm(points, corners));
        part.aperture.contains(x, y)
    });
    topography(points, &inside.collect::<Vec<_>>(), &Relief::default())
}

/// The figures of a mesh of which all but the counts were seen some time ago.
pub(super) fn with_counts(mesh: &Mesh, seen: MeshFigures) -> MeshFigures {
    let counts = mesh.counts();
    MeshFigures {
        vertices: counts.vertices,
        triangles: counts.triangles,
        edges: counts.edges,
        hull: counts.hull,
        projectable: mesh.projectable() && seen.relief.folds.is_empty(),
        ..seen
    }
}

impl Assessment {
    /// Adds what is worth its time only once all points have arrived.
    /// `measured_mm` are the vertices in the measured frame.
    pub(super) fn finish(&mut self, mesh: &Mesh, measured_mm: &[PointMm]) {
        if self.folded.is_some() {
            let (extents, advice) = still_true(measured_mm);
            self.mesh.relief.projection = Some(advice.clone());
            self.sampling.unknown.extend([extents, advice]);
        }
        self.mesh.repeats = repeats(mesh);
    }
}

fn centre_mm(points: &[PointMm], corners: &[VertexId; 3]) -> PointMm {
    [0, 1, 2]
        .map(|axis| corners.iter().map(|corner| points[*corner as usize][axis]).sum::<f64>() / 3.0)
}

fn relief_figures(relief: &Topography, plane: &Plane) -> ReliefFigures {
    let of_kind = |kind| relief.regions().iter().filter(move |region| region.kind == kind);
    ReliefFigures {
        folds: of_kind(Kind::Fold).map(|region| region_figures(region, plane)).collect(),
        walls: of_kind(Kind::Wall).count() as u64,
        spikes: of_kind(Kind::Spike).count() as u64,
        projection: None,
    }
}

fn region_figures(region: &Region, plane: &Plane) -> RegionFigures {
    let [min_mm, max_mm] = measured_box(plane, region.min_mm, region.max_mm);
    RegionFigures {
        at_mm: plane.from_plane(region.at_mm),
        min_mm,
        max_mm,
        vertices: region.vertices,
        triangles: region.triangles,
        projected_area_mm2: region.projected_area_mm2,
        slope_max_deg: region.slope_max_rad.to_degrees(),
    }
}

/// Smallest and largest coordinates, in the measured frame, of a box in that of the plane.
fn measured_box(plane: &Plane, min_mm: PointMm, max_mm: PointMm) -> [PointMm; 2] {
    let corners = (0..8_u8).map(|corner| {
        plane.from_plane(std::array::from_fn(|axis| {
            if corner >> axis & 1 == 0 { min_mm[axis] } else { max_mm[axis] }
        }))
    });
    let BoxMm { low, high } = BoxMm::about(corners);
    [low, high]
}

fn repeats(mesh: &Mesh) -> RepeatFigures {
    let (mut places, mut measurements, mut squares_mm2) = (0, 0, 0.0);
    for (_, repeats) in mesh.all_repeats() {
        places += 1;
        measurements += repeats.count();
        squares_mm2 += repeats.spread_mm().powi(2) * (repeats.count() - 1) as f64;
    }
    let freedom = measurements - places;
    RepeatFigures {
        places,
        measurements,
        spread_nm: (freedom > 0).then(|| 1e6 * (squares_mm2 / freedom as f64).sqrt()),
    }
}
