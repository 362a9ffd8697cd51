//! A section of a mesh as the outputs write it: its pieces, their points, and the figures of its profiles.
//!
//! Nothing here reads a file or a clock: it is for whoever has a mesh, finished or still growing.

use asphera_geometry::VertexId;
use asphera_mesh::Mesh;
use asphera_surface::sections::{
    CircleFit, CuttingPlane, Limit, PolynomialFit, Profile, ProfileError, Section, SectionError,
    SectionPath, cut, section,
};
use serde::Serialize;

/// Version of the layout.
pub const FORMAT: &str = "asphera.section/1";

/// What is asked of a mesh that is cut. Lengths in mm, in the frame of the mesh: u and v of the plane of
/// projection, which along z are x and y of the measured frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum SectionRequest {
    /// From one place to another.
    Line {
        /// Where it starts.
        from_mm: [f64; 2],
        /// Where it ends.
        to_mm: [f64; 2],
    },
    /// Around a centre, counter-clockwise from its right.
    Circle {
        /// The centre.
        centre_mm: [f64; 2],
        /// The radius.
        radius_mm: f64,
    },
    /// From a centre outwards.
    Radius {
        /// The centre; without it that of the nominal as fitted, or before a fit the origin.
        centre_mm: Option<[f64; 2]>,
        /// The direction, counter-clockwise from x.
        angle_rad: f64,
    },
}

/// What comes of a request: a section, or why the mesh cannot be cut like that; `None` while no point has
/// landed.
pub type Cut = Option<Result<SectionReport, SectionError>>;

impl SectionRequest {
    /// The path, where the nominal's centre lies at `fitted_mm`.
    pub fn path(&self, fitted_mm: [f64; 2]) -> SectionPath {
        match *self {
            SectionRequest::Line { from_mm, to_mm } => SectionPath::Segment { from_mm, to_mm },
            SectionRequest::Circle { centre_mm, radius_mm } => {
                SectionPath::Circle { centre_mm, radius_mm, start_rad: 0.0 }
            }
            SectionRequest::Radius { centre_mm, angle_rad } => {
                SectionPath::Radius { centre_mm: centre_mm.unwrap_or(fitted_mm), angle_rad }
            }
        }
    }
}

/// A section and its figures.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct SectionReport {
    /// [`FORMAT`].
    pub format: &'static str,
    /// Along what the surface was cut.
    pub path: PathFigures,
    /// Triangles with a larger gap are not bridged, mm; `None`: only what lies outside the hull is not.
    pub gap_limit_mm: Option<f64>,
    /// How much of the path lies on measured surface, mm.
    pub length_mm: f64,
    /// The pieces without a break, in order.
    pub pieces: Vec<PieceFigures>,
    /// The profile of the heights; `None` without a piece.
    pub height: Option<HeightFigures>,
    /// The profile of the deviation; `None` where no deviation is known.
    pub deviation: Option<DeviationProfile>,
    /// Why figures are missing.
    pub reasons: Vec<String>,
    /// The points of all pieces.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub points: Option<Columns>,
}

/// Along what the surface was cut; lengths in mm, measured frame.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[serde(rename_all = "lowercase", tag = "kind")]
pub enum PathFigures {
    /// A segment.
    Line {
        /// Where it starts.
        from_mm: [f64; 2],
        /// Where it ends.
        to_mm: [f64; 2],
    },
    /// A circle, counter-clockwise.
    Circle {
        /// Its centre.
        centre_mm: [f64; 2],
        /// Its radius.
        radius_mm: f64,
        /// Where it starts, counter-clockwise from x.
        start_deg: f64,
    },
    /// From a centre outwards.
    Radius {
        /// The centre.
        centre_mm: [f64; 2],
        /// The direction, counter-clockwise from x.
        angle_deg: f64,
    },
    /// A plane, n·p = d.
    Plane {
        /// Its unit normal.
        normal: [f64; 3],
        /// Its distance from the origin along the normal, mm.
        offset_mm: f64,
    },
}

/// A piece of a section without a break.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct PieceFigures {
    /// Arc position of its beginning, mm.
    pub from_s_mm: f64,
    /// Arc position of its end, mm.
    pub to_s_mm: f64,
    /// Its points.
    pub points: usize,
    /// Why it begins there: `path`, `hull`, `gap`, `closed`, or of a plane `junction`.
    pub begins: &'static str,
    /// Why it ends there.
    pub ends: &'static str,
}

/// Figures of the heights along a section. Means are over the arc position.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct HeightFigures {
    /// Largest less smallest height, mm.
    pub pv_mm: f64,
    /// Mean height, mm.
    pub mean_mm: f64,
    /// Root of the mean square of what differs from the mean, mm.
    pub rms_about_mean_mm: f64,
    /// The straight line that fits best; of straight sections only.
    pub line: Option<LineFigures>,
    /// The circle that fits best; of straight sections only.
    pub circle: Option<CircleFigures>,
}

/// A straight line fitted to the heights.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct LineFigures {
    /// Slope, mm a mm.
    pub slope: f64,
    /// Its standard uncertainty, where it is known.
    pub u_slope: Option<f64>,
    /// PV of what is left, nm.
    pub pv_nm: f64,
    /// RMS of what is left, nm.
    pub rms_nm: f64,
}

/// A circle fitted to the heights.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct CircleFigures {
    /// Curvature, 1/mm; positive in a hollow.
    pub curvature_per_mm: f64,
    /// Its standard uncertainty, where it is known.
    pub u_curvature_per_mm: Option<f64>,
    /// Radius with the sign of the curvature, mm; `None` where that is not told from zero.
    pub radius_mm: Option<f64>,
    /// Its standard uncertainty, mm.
    pub u_radius_mm: Option<f64>,
    /// PV of the distances from the circle, nm.
    pub pv_nm: f64,
    /// RMS of the distances from the circle, nm.
    pub rms_nm: f64,
}

/// Figures of the deviation along a section. Means are over the arc position.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct DeviationProfile {
    /// How much of the section has a deviation, mm.
    pub length_mm: f64,
    /// Largest less smallest deviation, nm.
    pub pv_nm: f64,
    /// Root of the mean square, nm.
    pub rms_nm: f64,
    /// Mean, nm.
    pub mean_nm: f64,
}

/// The points of all pieces, a column each.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Columns {
    /// The piece, from 0 on.
    pub piece: Vec<usize>,
    /// Arc position, mm; of a plane the length in space from the beginning of the piece.
    pub s_mm: Vec<f64>,
    /// Measured frame, mm.
    pub x_mm: Vec<f64>,
    /// Measured frame, mm.
    pub y_mm: Vec<f64>,
    /// Measured frame, mm.
    pub z_mm: Vec<f64>,
    /// Deviation, nm; `None` (null) outside the aperture. `None` where no deviation is known.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub deviation_nm: Option<Vec<Option<f64>>>,
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
        let profile = Profile::of(found, |vertex| met.deviation_nm(vertex) * 1e-6);
        told(deviation(&profile), "deviation", &mut reasons)
    });
    SectionReport {
        format: FORMAT,
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

impl Columns {
    /// As CSV with a header that names the units; an unknown deviation is an empty field.
    pub fn csv(&self) -> String {
        let mut text = String::from("piece,s_mm,x_mm,y_mm,z_mm");
        text.push_str(if self.deviation_nm.is_some() { ",deviation_nm\n" } else { "\n" });
        for index in 0..self.s_mm.len() {
            let fields = [&self.s_mm, &self.x_mm, &self.y_mm, &self.z_mm]
                .map(|column| column[index].to_string());
            text.push_str(&format!("{},{}", self.piece[index], fields.join(",")));
            if let Some(deviations_nm) = &self.deviation_nm {
                text.push(',');
                text.extend(deviations_nm[index].map(|nm| nm.to_string()));
            }
            text.push('\n');
        }
        text
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

/// Cuts the mesh of some points, for tests that have no other.
#[cfg(test)]
pub(crate) fn cut_points(points: &[[f64; 3]], request: &SectionRequest) -> Cut {
    let mut mesh = Mesh::new();
    mesh.insert(points);
    (!points.is_empty()).then(|| report(&mesh, &request.path([0.0; 2]), None, None))
}
