//! A section of the surface: what is asked for, its pieces, their points, and the figures of its profiles.

use serde::Serialize;

use crate::Refusal;

/// Version of the layout of [`SectionReport`].
pub const SECTION_FORMAT: &str = "asphera.section/1";

/// Request for a cut through a mesh. Lengths in mm, in the frame of the mesh: u and v of the plane of
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
    /// All of the surface in a plane, n·p = d, of the measured frame. A surface in space is cut like that alone.
    Plane {
        /// A normal of any length.
        normal: [f64; 3],
        /// d, in mm times that length.
        offset_mm: f64,
    },
}

/// The answer to a request: a section, or why the mesh cannot be cut like that; `None` while no point has landed.
pub type Cut = Option<Result<SectionReport, Refusal>>;

/// A section and its figures.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct SectionReport {
    /// [`SECTION_FORMAT`].
    pub format: &'static str,
    /// Along what the surface was cut.
    pub path: PathFigures,
    /// Triangles with a larger gap are not bridged, mm; `None`: only what lies outside the hull is not.
    pub gap_limit_mm: Option<f64>,
    /// How much of the path lies on measured surface, mm.
    pub length_mm: f64,
    /// The pieces without a break, in order.
    pub pieces: Vec<PieceFigures>,
    /// The profile of the heights; `None` without a piece, and of a surface in space.
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
    /// Why it begins there: `path`, `hull`, `gap`, `closed`, of a plane `junction`, and in space `border`.
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

impl Columns {
    /// CSV with a header that names the units; an unknown deviation is an empty field.
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
