//! Sections of a mesh for the outputs: pieces, points, and figures of the profiles.
//!
//! Nothing here reads a file or a clock: it is for whoever has a mesh, finished or still growing.

use asphera_geometry::VertexId;
use asphera_mesh::Mesh;
use asphera_report::{
    CircleFigures, Columns, DeviationProfile, HeightFigures, LineFigures, PathFigures,
    PieceFigures, SECTION_FORMAT, SectionReport, SectionRequest,
};
use asphera_surface::Plane;
use asphera_surface::sections::{
    CircleFit, CuttingPlane, Limit, PolynomialFit, Profile, ProfileError, Section, SectionError,
    SectionPath, cut, section,
};

/// Along what a mesh in the plane is cut.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Way {
    /// A line in the plane of projection.
    Path(SectionPath),
    /// A plane in the frame of the plane of projection.
    Plane(CuttingPlane),
}

/// The way of a request, where the nominal's centre lies at `fitted_mm`, through a mesh in the frame of a plane of projection.
///
/// # Errors
///
/// If the plane of a request is none.
pub fn way(
    request: &SectionRequest,
    fitted_mm: [f64; 2],
    projection: &Plane,
) -> Result<Way, SectionError> {
    Ok(Way::Path(match *request {
        SectionRequest::Plane { normal, offset_mm } => {
            return in_frame_of(projection, normal, offset_mm).map(Way::Plane);
        }
        SectionRequest::Line { from_mm, to_mm } => SectionPath::Segment { from_mm, to_mm },
        SectionRequest::Circle { centre_mm, radius_mm } => {
            SectionPath::Circle { centre_mm, radius_mm, start_rad: 0.0 }
        }
        SectionRequest::Radius { centre_mm, angle_rad } => {
            SectionPath::Radius { centre_mm: centre_mm.unwrap_or(fitted_mm), angle_rad }
        }
    }))
}

/// A plane n·p = d of the measured frame in the frame of the plane of projection.
///
/// # Errors
///
/// If the normal has no direction, or a number is not finite or out of range.
pub fn in_frame_of(
    projection: &Plane,
    [a, b, c]: [f64; 3],
    offset_mm: f64,
) -> Result<CuttingPlane, SectionError> {
    if *projection == Plane::XY {
        return CuttingPlane::new([a, b, c], offset_mm);
    }
    let along = |[x, y, z]: [f64; 3]| a * x + b * y + c * z;
    CuttingPlane::new(projection.axes().map(along), offset_mm - along(projection.origin_mm()))
}

/// Gives the deviations of vertices in nm, in their order.
pub type Deviations<'a> = dyn Fn(&[VertexId]) -> Vec<f64> + 'a;

/// Cuts a mesh along a path. `deviations_nm` gives the deviations of the vertices it is asked for, those of
/// the triangles met, in their order; NaN where there is none.
///
/// Takes time in proportion to the triangles met: it may be asked for while measuring.
///
/// # Errors
///
/// If the path or the limit makes no sense.
pub fn report(
    mesh: &Mesh,
    path: &SectionPath,
    gap_limit_mm: Option<f64>,
    deviations_nm: Option<&Deviations>,
) -> Result<SectionReport, SectionError> {
    let found = section(mesh, path, gap_limit_mm)?;
    let straight = !matches!(path, SectionPath::Circle { .. });
    Ok(told_of(&found, path_figures(path), straight, gap_limit_mm, deviations_nm))
}

/// Cuts a mesh by a plane of any direction, in as many pieces as that gives. Lines and circles are not fitted to
/// them.
///
/// Takes time in proportion to all triangles.
///
/// # Errors
///
/// If the limit makes no sense.
pub fn report_of_plane(
    mesh: &Mesh,
    plane: &CuttingPlane,
    gap_limit_mm: Option<f64>,
    deviations_nm: Option<&Deviations>,
) -> Result<SectionReport, SectionError> {
    let found = cut(mesh, plane, gap_limit_mm)?;
    let path = PathFigures::Plane { normal: plane.normal(), offset_mm: plane.offset_mm() };
    Ok(told_of(&found, path, false, gap_limit_mm, deviations_nm))
}

/// What a section of a surface in space tells. It has no height: no direction is one.
pub(crate) fn of_facets(
    found: &Section,
    path: PathFigures,
    gap_limit_mm: Option<f64>,
    deviations_nm: Option<&Deviations>,
) -> SectionReport {
    SectionReport { height: None, ..told_of(found, path, false, gap_limit_mm, deviations_nm) }
}

fn told_of(
    found: &Section,
    path: PathFigures,
    straight: bool,
    gap_limit_mm: Option<f64>,
    deviations_nm: Option<&Deviations>,
) -> SectionReport {
    let met = deviations_nm.map(|of| Met::new(found, of));
    let mut reasons = Vec::new();
    let height = height(&Profile::heights(found), straight, &mut reasons);
    let deviation = met.as_ref().and_then(|met| {
        let profile = Profile::along(found, |vertex| met.deviation_nm(vertex) * 1e-6);
        told(deviation(&profile), "deviation", &mut reasons)
    });
    SectionReport {
        format: SECTION_FORMAT,
        path,
        gap_limit_mm,
        length_mm: found.length_mm(),
        pieces: pieces(found),
        height,
        deviation,
        reasons,
        points: Some(columns(found, met.as_ref())),
    }
}

/// The vertices of the triangles met, ascending, and their deviations.
struct Met {
    vertices: Vec<VertexId>,
    deviations_nm: Vec<f64>,
}

impl Met {
    fn new(found: &Section, deviations_nm: &Deviations) -> Met {
        let points = found.pieces.iter().flat_map(|piece| &piece.points);
        let mut vertices: Vec<VertexId> =
            points.flat_map(|point| point.source.weights().map(|(vertex, _)| vertex)).collect();
        vertices.sort_unstable();
        vertices.dedup();
        let deviations_nm = deviations_nm(&vertices);
        Met { vertices, deviations_nm }
    }

    fn deviation_nm(&self, vertex: VertexId) -> f64 {
        let found = self.vertices.binary_search(&vertex).ok();
        found.and_then(|index| self.deviations_nm.get(index)).copied().unwrap_or(f64::NAN)
    }
}

fn path_figures(path: &SectionPath) -> PathFigures {
    match *path {
        SectionPath::Segment { from_mm, to_mm } => PathFigures::Line { from_mm, to_mm },
        SectionPath::Circle { centre_mm, radius_mm, start_rad } => {
            PathFigures::Circle { centre_mm, radius_mm, start_deg: start_rad.to_degrees() }
        }
        SectionPath::Radius { centre_mm, angle_rad } => {
            PathFigures::Radius { centre_mm, angle_deg: angle_rad.to_degrees() }
        }
    }
}

fn pieces(found: &Section) -> Vec<PieceFigures> {
    let piece = |piece: &asphera_surface::sections::Piece| {
        let (first, last) = piece.points.first().zip(piece.points.last())?;
        Some(PieceFigures {
            from_s_mm: first.s_mm,
            to_s_mm: last.s_mm,
            points: piece.points.len(),
            begins: limit(piece.begins),
            ends: limit(piece.ends),
        })
    };
    found.pieces.iter().filter_map(piece).collect()
}

fn limit(limit: Limit) -> &'static str {
    match limit {
        Limit::Path => "path",
        Limit::Hull => "hull",
        Limit::Border => "border",
        Limit::Gap => "gap",
        Limit::Junction => "junction",
        Limit::Closed => "closed",
    }
}

fn height(profile: &Profile, straight: bool, reasons: &mut Vec<String>) -> Option<HeightFigures> {
    let figures = told(profile.figures(), "height", reasons)?;
    let (line, circle) = if straight {
        (
            told(profile.line().and_then(|fit| line(&fit, profile)), "line", reasons),
            told(profile.circle().and_then(|fit| circle(&fit, profile)), "circle", reasons),
        )
    } else {
        (None, None)
    };
    Some(HeightFigures {
        pv_mm: figures.pv_mm,
        mean_mm: figures.mean_mm,
        rms_about_mean_mm: figures.rms_about_mean_mm,
        line,
        circle,
    })
}

fn line(fit: &PolynomialFit, profile: &Profile) -> Result<LineFigures, ProfileError> {
    let left = fit.residual(profile).figures()?;
    let (pv_nm, rms_nm) = (left.pv_mm * 1e6, left.rms_mm * 1e6);
    Ok(LineFigures { slope: fit.slope, u_slope: fit.u_slope, pv_nm, rms_nm })
}

fn circle(fit: &CircleFit, profile: &Profile) -> Result<CircleFigures, ProfileError> {
    let left = fit.residual(profile).figures()?;
    let (radius_mm, u_radius_mm) = fit.radius_mm().unzip();
    Ok(CircleFigures {
        curvature_per_mm: fit.curvature_per_mm,
        u_curvature_per_mm: fit.u_curvature_per_mm,
        radius_mm,
        u_radius_mm,
        pv_nm: left.pv_mm * 1e6,
        rms_nm: left.rms_mm * 1e6,
    })
}

fn deviation(profile: &Profile) -> Result<DeviationProfile, ProfileError> {
    let figures = profile.figures()?;
    Ok(DeviationProfile {
        length_mm: figures.length_mm,
        pv_nm: figures.pv_mm * 1e6,
        rms_nm: figures.rms_mm * 1e6,
        mean_nm: figures.mean_mm * 1e6,
    })
}

/// The figure, or a note why there is none.
fn told<T>(figure: Result<T, ProfileError>, name: &str, reasons: &mut Vec<String>) -> Option<T> {
    figure.map_err(|error| reasons.push(format!("no {name}: {error}"))).ok()
}

fn columns(found: &Section, met: Option<&Met>) -> Columns {
    let mut columns = Columns { deviation_nm: met.map(|_| Vec::new()), ..Columns::default() };
    for (index, piece) in found.pieces.iter().enumerate() {
        for point in &piece.points {
            columns.piece.push(index);
            columns.s_mm.push(point.s_mm);
            let [x, y, z] = point.at_mm;
            columns.x_mm.push(x);
            columns.y_mm.push(y);
            columns.z_mm.push(z);
            if let (Some(column), Some(met)) = (&mut columns.deviation_nm, met) {
                let nm = point.interpolate(|vertex| met.deviation_nm(vertex));
                column.push(nm.is_finite().then_some(nm));
            }
        }
    }
    columns
}

#[cfg(test)]
mod tests {
    use super::*;

    fn along(request: &SectionRequest) -> Result<SectionReport, SectionError> {
        let mut mesh = Mesh::new();
        mesh.insert(&[[0.0, 0.0, 0.0], [2.0, 0.0, 2.0], [0.0, 2.0, 4.0]]);
        match way(request, [0.0; 2], &Plane::XY)? {
            Way::Path(path) => report(&mesh, &path, None, None),
            Way::Plane(plane) => report_of_plane(&mesh, &plane, None, None),
        }
    }

    #[test]
    fn a_plane_is_cut_as_far_as_it_reaches() {
        let line = |from_mm, to_mm| SectionRequest::Line { from_mm, to_mm };
        let points = along(&line([0.5, 0.5], [5.0, 0.5])).unwrap().points.unwrap();
        assert_eq!((points.s_mm, points.z_mm), (vec![0.0, 1.0], vec![1.5, 2.5]));
        let upright = SectionRequest::Plane { normal: [0.0, 2.0, 0.0], offset_mm: 1.0 };
        let points = along(&upright).unwrap().points.unwrap();
        assert_eq!((points.y_mm, points.z_mm), (vec![0.5, 0.5], vec![1.0, 2.5]));
        assert_eq!(along(&line([5.0, 5.0], [6.0, 6.0])).unwrap().pieces, []);
        let refused = |request| along(&request).unwrap_err().to_string();
        assert!(refused(line([1.0, 2.0], [1.0, 2.0])).contains("has no length"));
        let none = SectionRequest::Plane { normal: [0.0; 3], offset_mm: 1.0 };
        assert!(refused(none).contains("plane with normal (0, 0, 0)"));
        let circle = SectionRequest::Circle { centre_mm: [0.0; 2], radius_mm: -1.0 };
        assert!(refused(circle).contains("radius -1 mm"));
    }
}
