//! A surface in space, to be cut by planes.

use std::fmt;
use std::sync::Arc;

use asphera_geometry::{PointMm, VertexId};
use asphera_report::{PathFigures, Refusal, SectionReport, SectionRequest};
use asphera_surface::sections::{CuttingPlane, SectionError, cut_facets};

use super::meshed::Meshed;
use super::shape::Laid;
use crate::section::{Deviations, of_facets};

/// A surface that was meshed in space. Its deviation is that from the fitted shape, where one was fitted.
#[derive(Clone)]
pub struct SurfaceInSpace {
    points_mm: Arc<[PointMm]>,
    facets: Arc<[[VertexId; 3]]>,
    laid: Option<Laid>,
    gap_limit_mm: Option<f64>,
}

impl SurfaceInSpace {
    /// The mesh of points of which nothing else is known. The largest gap allowed is four times their mean distance.
    ///
    /// # Errors
    ///
    /// Why they cannot be meshed, in words.
    pub(crate) fn of_points(points_mm: &[PointMm]) -> Result<SurfaceInSpace, String> {
        let meshed = Meshed::of(points_mm)?;
        let vertices = meshed.used().iter().filter(|used| **used).count();
        let distance_mm = (meshed.proof.area_mm2 / vertices as f64).sqrt();
        let gap_limit_mm = Some(super::sampled::GAP * distance_mm).filter(|mm| mm.is_normal());
        Ok(SurfaceInSpace::new(&meshed, None, gap_limit_mm))
    }

    pub(super) fn new(
        meshed: &Meshed,
        laid: Option<Laid>,
        gap_limit_mm: Option<f64>,
    ) -> SurfaceInSpace {
        SurfaceInSpace {
            points_mm: meshed.points_mm.as_slice().into(),
            facets: meshed.facets.as_slice().into(),
            laid,
            gap_limit_mm,
        }
    }

    /// Its facets, by their corners.
    pub fn facets(&self) -> &[[VertexId; 3]] {
        &self.facets
    }

    /// Cuts it by a plane. Facets with a larger gap than the limit are not bridged; without a limit its own holds. The deviation
    /// is left out unless it is wanted.
    ///
    /// Takes time in proportion to the facets.
    ///
    /// # Errors
    ///
    /// If the limit makes no sense.
    pub fn cut(
        &self,
        plane: &CuttingPlane,
        gap_limit_mm: Option<f64>,
        with_deviation: bool,
    ) -> Result<SectionReport, SectionError> {
        let SurfaceInSpace { points_mm, facets, .. } = self;
        let laid = self.laid.as_ref().filter(|_| with_deviation);
        cut(points_mm, facets, laid, gap_limit_mm.or(self.gap_limit_mm), plane)
    }

    /// The section of a request.
    ///
    /// # Errors
    ///
    /// If it asks for no plane, or the plane makes no sense.
    pub(crate) fn section(&self, request: &SectionRequest) -> Result<SectionReport, Refusal> {
        let plane = plane_of(request)?;
        self.cut(&plane, None, true).map_err(Refusal::new)
    }
}

impl fmt::Debug for SurfaceInSpace {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("SurfaceInSpace")
            .field("points", &self.points_mm.len())
            .field("facets", &self.facets.len())
            .field("laid", &self.laid)
            .field("gap_limit_mm", &self.gap_limit_mm)
            .finish()
    }
}

/// Cuts facets by a plane, with the deviation from the shape that is laid into them.
pub(super) fn cut(
    points_mm: &[PointMm],
    facets: &[[VertexId; 3]],
    laid: Option<&Laid>,
    gap_limit_mm: Option<f64>,
    plane: &CuttingPlane,
) -> Result<SectionReport, SectionError> {
    let found = cut_facets(points_mm, facets, plane, gap_limit_mm)?;
    let deviations_nm = laid.map(|laid| {
        move |vertices: &[VertexId]| {
            let of = |vertex: &VertexId| 1e6 * laid.off(points_mm[*vertex as usize]).0;
            vertices.iter().map(of).collect::<Vec<f64>>()
        }
    });
    let deviations_nm = deviations_nm.as_ref().map(|of| of as &Deviations);
    let path = PathFigures::Plane { normal: plane.normal(), offset_mm: plane.offset_mm() };
    Ok(of_facets(&found, path, gap_limit_mm, deviations_nm))
}

/// The plane of a request.
///
/// # Errors
///
/// If it asks for another path: then it says which plane would do.
pub(super) fn plane_of(request: &SectionRequest) -> Result<CuttingPlane, Refusal> {
    match *request {
        SectionRequest::Plane { normal, offset_mm } => {
            CuttingPlane::new(normal, offset_mm).map_err(Refusal::new)
        }
        SectionRequest::Line { from_mm, to_mm } => Err(refuse_path(Some((from_mm, to_mm)))),
        SectionRequest::Radius { centre_mm, angle_rad } => {
            let [x, y] = centre_mm.unwrap_or_default();
            let (sin, cos) = angle_rad.sin_cos();
            Err(refuse_path(Some(([x, y], [x + cos, y + sin]))))
        }
        SectionRequest::Circle { .. } => Err(refuse_path(None)),
    }
}

/// Why a surface in space is not cut along a path, and the upright plane through two places of it.
pub fn refuse_path(through_mm: Option<([f64; 2], [f64; 2])>) -> Refusal {
    let upright = through_mm.map(|([x1, y1], [x2, y2])| {
        let [a, b] = [y1 - y2, x2 - x1];
        // Enough digits to be copied, and no tails of rounding; plus zero makes a negative zero positive.
        let [a, b, d] = [a, b, a * x1 + b * y1].map(|number| (1e9 * number).round() / 1e9 + 0.0);
        format!("; the upright plane there is {a},{b},0,{d}")
    });
    let upright = upright.unwrap_or_default();
    Refusal(format!(
        "a surface in space is cut by planes alone: expected plane A,B,C,D of a·x + b·y + c·z = d{upright}"
    ))
}
