//! The mesh looked at as a whole: folds, sampling, area. What takes time in proportion to the triangles.

use asphera_form::Pose;
use asphera_surface::{
    Criteria, Kind, Mesh, Plane, PointMm, Region, Relief, State, Survey, Topography, VertexId,
    area, assess, islands, projectable_along, topography,
};

use super::figures::{gap_limit_mm, lfs_mm};
use crate::config::Part;
use crate::report::{MeshFigures, RegionFigures, ReliefFigures, RepeatFigures, SamplingFigures};

/// What was seen.
pub(super) struct Look {
    /// All triangles of the mesh.
    pub(super) triangles: Vec<[VertexId; 3]>,
    /// Those whose centre lies in the aperture, but for folds, and their sampling.
    pub(super) survey: Survey,
    pub(super) mesh: MeshFigures,
    pub(super) sampling: SamplingFigures,
}

/// Looks at a mesh in the frame of `plane` of a part that lies there at `pose`.
pub(super) fn look(mesh: &Mesh, part: &Part, pose: &Pose, plane: &Plane) -> Look {
    let points = mesh.points();
    let triangles = mesh.triangles();
    let whole = area(points, triangles.iter().copied());
    let inside: Vec<[VertexId; 3]> = triangles
        .iter()
        .copied()
        .filter(|corners| {
            let [x, y, _] = pose.to_part(centre_mm(points, corners));
            part.aperture.contains(x, y)
        })
        .collect();
    let relief = topography(points, &inside, &Relief::default());
    let mut folded = relief.triangles_of_folds().peekable();
    let sheet = inside
        .iter()
        .enumerate()
        .filter_map(|(index, &corners)| folded.next_if_eq(&index).is_none().then_some(corners));
    let aperture_mm2 = part.aperture.area_mm2() * foreshortening(pose, plane);
    let criteria = Criteria {
        gap_limit_mm: gap_limit_mm(part, points.len(), whole.projected_mm2),
        epsilon_limit: Some(part.epsilon_limit),
        aperture_area_mm2: aperture_mm2.is_finite().then_some(aperture_mm2),
    };
    let survey = assess(points, sheet, &criteria, lfs_mm(&part.nominal, pose));
    let sampling = sampling(mesh, part, &criteria, &survey);
    let seen = MeshFigures {
        area_mm2: whole.lifted_mm2,
        relief: relief_figures(&relief, plane),
        ..MeshFigures::default()
    };
    Look { mesh: with_counts(mesh, seen), triangles, survey, sampling }
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

impl Look {
    /// Adds what is worth its time only once all points have arrived.
    /// `measured_mm` are the vertices in the measured frame.
    pub(super) fn finish(&mut self, mesh: &Mesh, measured_mm: &[PointMm]) {
        let points = mesh.points();
        let (triangles, keep): (Vec<_>, Vec<_>) =
            self.survey.triangles().map(|(corners, state)| (corners, state == State::Good)).unzip();
        let islands = islands(points, &triangles, &keep);
        let holes = || islands.iter().flat_map(|island| &island.holes);
        self.sampling.islands = Some(islands.len() as u64);
        self.sampling.holes = Some(holes().count() as u64);
        self.sampling.hole_max_mm2 = holes().map(|hole| hole.area_mm2).reduce(f64::max);
        if !self.mesh.relief.folds.is_empty() {
            let found = projectable_along(measured_mm, &Relief::default());
            self.mesh.relief.projection =
                Some(found.map_or_else(|error| error.to_string(), |found| found.to_string()));
        }
        self.mesh.repeats = repeats(mesh);
    }
}

/// What becomes of an area across the part's axis in the projection. A plane that was fitted from some rows
/// of a curved part may lie far askew; along z a part lies straight but for less than counts.
fn foreshortening(pose: &Pose, plane: &Plane) -> f64 {
    if *plane == Plane::XY { 1.0 } else { pose.rotation()[2][2].abs() }
}

fn centre_mm(points: &[PointMm], corners: &[VertexId; 3]) -> PointMm {
    [0, 1, 2]
        .map(|axis| corners.iter().map(|corner| points[*corner as usize][axis]).sum::<f64>() / 3.0)
}

fn sampling(mesh: &Mesh, part: &Part, criteria: &Criteria, survey: &Survey) -> SamplingFigures {
    let sampling = survey.sampling();
    SamplingFigures {
        gap_limit_mm: criteria.gap_limit_mm,
        epsilon_limit: part.epsilon_limit,
        gap_max_mm: sampling.gap_max_mm,
        epsilon_max: sampling.epsilon_max.filter(|epsilon| epsilon.is_finite()),
        epsilon_p99: sampling.epsilon_p99.filter(|epsilon| epsilon.is_finite()),
        coverage: sampling.coverage,
        undersampled_area_mm2: sampling.gap_max_mm.map(|_| sampling.undersampled_area_mm2),
        as_of_points: mesh.counts().pushed,
        ..SamplingFigures::default()
    }
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
    corners.fold([[f64::INFINITY; 3], [f64::NEG_INFINITY; 3]], |[low, high], corner| {
        [
            std::array::from_fn(|axis| low[axis].min(corner[axis])),
            std::array::from_fn(|axis| high[axis].max(corner[axis])),
        ]
    })
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
