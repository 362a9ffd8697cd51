//! How much of an aperture is covered by samples, and what to measure next.
//!
//! **Covered** is the area of the aperture inside triangles of the mesh whose gap is within the
//! target (for gap and ε see [`crate::assess`]). **Undersampled** is that inside triangles whose gap
//! is not, where the surface was scanned all the same: at one of the corners at least, the samples
//! are about as far apart as here. **Uncovered** is all the rest: what lies outside the hull of the
//! mesh, and inside triangles that bridge what nobody scanned, whose gap is above the target and more
//! than three times the smallest gap at each of their corners. A stripe scanned too coarsely is
//! undersampled, a hole in a fine scan is uncovered, whatever the target. The three add up to the area
//! of the aperture.
//!
//! The area of a triangle inside the aperture is exact but for rounding. A triangle between samples
//! that are dense and one that is not belongs to what is not covered: a region reaches to the
//! outermost samples of what is.
//!
//! **Regions.** Triangles that are not covered are joined across the sides they share inside the
//! aperture, and so is what lies outside the hull. A region smaller than one square of the spacing it
//! needs is not listed but counted in the remainder. Regions are drawn as polygons on a border that
//! runs inside a circle by up to 1e-5 of its radius, else by some 1e-9 of the size; their areas are
//! sums over triangles.
//!
//! **Without an aperture** the outline of the data stands in: the mesh without the bridges that
//! reach to its hull. What is missing at the edge of a part then cannot be told from what is not part
//! of it, and is not counted; holes inside are.
//!
//! The gap outside the hull is not known: how far the farthest place there is from all samples is
//! left out of the figures of gap and ε.

mod aperture;
mod border;
mod clip;
mod density;
mod draw;
mod frame;
mod gauge;
mod patches;
mod plan;
mod polygon;
mod simple;
mod spread;
mod tally;
mod target;
mod without;

use thiserror::Error;

pub use self::aperture::{Aperture, ApertureError};
use self::border::{Border, Whereabouts};
use self::clip::common_area_mm2;
use self::density::Facet;
pub use self::density::{Dense, Density};
use self::draw::{Open, Scene};
use self::frame::{Frame, hull};
use self::gauge::{Gauged, Gauger, Gauges, Standing, lfs_at_points_mm, sound_lfs};
pub use self::patches::Patch;
use self::patches::{Patches, patches};
pub use self::plan::{
    Completion, PlanError, Progress, Waypoint, completion, waypoints, write_waypoints,
};
pub use self::polygon::{Polygon, Ring};
pub use self::spread::Spread;
pub use self::target::{Reach, Spacing, Target, TargetError};
use crate::outline::{IslandCounts, island_counts};
use crate::rim::{Outline, refined_gaps_along};
use crate::triangle::Triangle;
use crate::{PointMm, VertexId};

/// What the areas of a coverage refer to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Reference {
    /// The aperture that was given.
    Aperture,
    /// The outline of the data, as no aperture was given.
    DataOutline,
}

/// The areas of a coverage, in the plane, in mm². The first is the sum of the next three.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CoveredAreas {
    /// Of the aperture.
    pub aperture_mm2: f64,
    /// Covered: sampled as densely as the target asks.
    pub covered_mm2: f64,
    /// Scanned, but not densely enough.
    pub undersampled_mm2: f64,
    /// Not scanned.
    pub uncovered_mm2: f64,
    /// The part of what is not covered where that is only because its local feature size, which the
    /// target needs, is not known.
    pub lfs_unknown_mm2: f64,
}

/// How many triangles with a part in the aperture are what.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct CoverageCounts {
    /// Within the target.
    pub covered: u64,
    /// Beyond the target, on the surface.
    pub undersampled: u64,
    /// Beyond the target, across what was not scanned.
    pub bridging: u64,
}

/// How much of an aperture is covered, and the regions that are not.
#[derive(Clone, Debug, PartialEq)]
pub struct Coverage {
    /// What the areas refer to.
    pub reference: Reference,
    /// The areas; none if there is neither an aperture nor a triangle.
    pub areas: Option<CoveredAreas>,
    /// How many triangles there are.
    pub triangles: CoverageCounts,
    /// Gaps in mm, by area in space inside the aperture; none without triangles there.
    pub gap_mm: Option<Spread>,
    /// Where the largest gap is.
    pub gap_max_at_mm: Option<PointMm>,
    /// ε of the triangles where the local feature size is known, by area.
    pub epsilon: Option<Spread>,
    /// Where the largest ε is.
    pub epsilon_max_at_mm: Option<PointMm>,
    /// The smallest local feature size at samples and gaps in the aperture, in mm; none if it is not
    /// known anywhere, infinite over a plane.
    pub lfs_min_mm: Option<f64>,
    /// The regions that are not covered, the largest first: what to measure next.
    pub patches: Vec<Patch>,
    /// The area in mm² of the regions too small to be listed.
    pub remainder_mm2: f64,
    /// How many those are.
    pub remainder_patches: u64,
}

impl Coverage {
    /// Covered area over that of the aperture, 0 to 1; none if there is nothing to refer to.
    pub fn coverage(&self) -> Option<f64> {
        let areas = self.areas?;
        (areas.aperture_mm2 > 0.0).then(|| (areas.covered_mm2 / areas.aperture_mm2).clamp(0.0, 1.0))
    }
}

/// Why there is no coverage.
#[derive(Clone, Copy, Debug, Error, PartialEq)]
pub enum CoverageError {
    /// The target is none.
    #[error("the sampling target cannot be used")]
    Target(#[from] TargetError),
    /// A point is not finite.
    #[error("point {vertex} is not finite")]
    Point {
        /// Its number.
        vertex: VertexId,
    },
    /// The triangles do not fill an outline.
    #[error(
        "the {triangles} triangles are not those of a whole mesh: their outline is not one closed line about its centre"
    )]
    NotAMesh {
        /// How many triangles there are.
        triangles: usize,
    },
    /// The regions could not be drawn.
    #[error("the border of the aperture coincides with sides of triangles wherever it is drawn")]
    Coincidence,
}

/// Says how much of the aperture is covered and which regions are not.
///
/// `triangles` are all those of a mesh of `points`, in the frame of the aperture, counter-clockwise;
/// the indices of those in `left_out`, ascending, count as bridges whatever their gap, such as
/// [`crate::Topography::triangles_of_folds`]. `lfs_mm(x, y)` is the local feature size of the surface
/// in mm: infinite over a plane, none where it is not known; what is not a positive number is not
/// known either. It is asked for at each point and each triangle.
///
/// Linear time but for sorting what is near the hull and the border, and for what is not covered the
/// sides about each vertex. The same triangles give the same bits.
///
/// # Errors
///
/// When a limit of the target is not a positive finite number, a point is not finite, or the
/// triangles are not those of a whole mesh. No triangles are no error: nothing is covered then.
///
/// # Panics
///
/// When a corner is not the index of a point.
pub fn cover(
    points: &[PointMm],
    triangles: &[[VertexId; 3]],
    left_out: &[usize],
    aperture: Option<&Aperture>,
    target: &Target,
    lfs_mm: impl Fn(f64, f64) -> Option<f64> + Sync,
) -> Result<Coverage, CoverageError> {
    examine(points, triangles, left_out, aperture, target, None, lfs_mm)
        .map(|examination| examination.coverage)
}

/// All that one pass over the triangles tells.
#[derive(Clone, Debug, PartialEq)]
pub struct Examination {
    /// How much of the aperture is covered, and what is not.
    pub coverage: Coverage,
    /// For each triangle whether it is covered and has a part in the aperture.
    pub covered: Vec<bool>,
    /// How many pieces and holes the covered part has; triangles across the border of the aperture count as
    /// a whole.
    pub islands: IslandCounts,
    /// How dense the samples are, if that was asked.
    pub dense: Option<Dense>,
    /// Area in space of all triangles in mm², wherever they are.
    pub area_mm2: f64,
}

/// As [`cover`], with what else the same pass over the triangles tells: which are covered, and with
/// `density` whether samples are denser than their noise allows.
///
/// Where two threads help it works in the caller's rayon pool; the bits do not depend on them.
///
/// # Errors
///
/// As [`cover`].
///
/// # Panics
///
/// When a corner is not the index of a point.
pub fn examine(
    points: &[PointMm],
    triangles: &[[VertexId; 3]],
    left_out: &[usize],
    aperture: Option<&Aperture>,
    target: &Target,
    density: Option<&Density>,
    lfs_mm: impl Fn(f64, f64) -> Option<f64> + Sync,
) -> Result<Examination, CoverageError> {
    target.validate()?;
    let finite = |point: &PointMm| point.iter().all(|mm| mm.is_finite());
    if let Some(vertex) = points.iter().position(|point| !finite(point)) {
        return Err(CoverageError::Point { vertex: vertex as VertexId });
    }
    let ((outline, refined), (border, at_points_mm)) = rayon::join(
        || {
            let outline = Outline::new(points.len(), triangles);
            let refined = refined_gaps_along(points, triangles, &outline);
            (outline, refined)
        },
        || {
            let border = aperture.map(|aperture| Border::new(aperture, triangles.len(), 0));
            (border, lfs_at_points_mm(points, &lfs_mm))
        },
    );
    let aperture = aperture.zip(border.as_ref());
    let gauger = Gauger {
        points,
        triangles,
        left_out,
        refined: &refined,
        aperture,
        target,
        density,
        lfs_mm: &lfs_mm,
        at_points_mm: &at_points_mm,
    };
    let Gauges { mut columns, covered: mut tally, mut open, area_mm2 } = gauger.gauge();
    let measured = Measured { points, triangles, target };
    let hull = match triangles {
        [] => None,
        _ => Some(
            hull(triangles, &outline)
                .ok_or(CoverageError::NotAMesh { triangles: triangles.len() })?,
        ),
    };
    let mut outer = Vec::new();
    if let (Some(hull), None) = (&hull, aperture) {
        let (outside, sides) = without::outside(points.len(), triangles, &open, hull);
        outer = sides;
        for &index in &outside {
            columns.areas_mm2[index] = 0.0;
            columns.facets[index] = false;
        }
        open.retain(|gauged| outside.binary_search(&gauged.index).is_err());
    }
    for gauged in &open {
        if gauged.area_mm2 > 0.0 {
            tally.add_open(gauged, target.gap_mm(gauged.lfs_mm).is_none());
        }
        let is_facet = &mut columns.facets[gauged.index];
        if gauged.standing == Standing::Bridge {
            *is_facet = false;
        } else if let Some(density) = density.filter(|_| *is_facet) {
            let triangle = Triangle::new(points, triangles[gauged.index]);
            tally.add_facet(density, &Facet::of(&triangle));
        }
    }
    let islands = hull
        .as_deref()
        .map(|hull| island_counts(points, triangles, &columns.covered, hull))
        .unwrap_or_default();
    let found = match (aperture, hull) {
        (Some((aperture, border)), Some(hull)) if tally.meets() => {
            measured.inside(aperture, border, hull, open, &lfs_mm)?
        }
        (Some((aperture, border)), _) => Patches::whole(aperture, border, target, &lfs_mm),
        (None, Some(_)) => measured.inside_outline(open, &outer, &lfs_mm)?,
        (None, None) => Patches::none(),
    };
    let (reference, reference_mm2) = match aperture {
        Some((aperture, _)) => (Reference::Aperture, Some(aperture.area_mm2())),
        None => (Reference::DataOutline, (!triangles.is_empty()).then(|| tally.area_mm2())),
    };
    let [gaps_mm, epsilons, facets_mm2] = columns.quantiles();
    let dense = density.map(|density| {
        let median_mm2 = facets_mm2.map(|[median_mm2, _]| median_mm2);
        tally.crumpled().dense(density, median_mm2, tally.lfs_min_mm())
    });
    let coverage = tally.coverage(reference, reference_mm2, [gaps_mm, epsilons], found);
    Ok(Examination { coverage, covered: columns.covered, islands, dense, area_mm2 })
}

/// A mesh against a target.
struct Measured<'a> {
    points: &'a [PointMm],
    triangles: &'a [[VertexId; 3]],
    target: &'a Target,
}

impl Measured<'_> {
    fn inside(
        &self,
        aperture: &Aperture,
        border: &Border,
        hull: Vec<VertexId>,
        gauged: Vec<Gauged>,
        lfs_mm: &impl Fn(f64, f64) -> Option<f64>,
    ) -> Result<Patches, CoverageError> {
        let frame = Frame::new(self.points, hull, aperture.bounds_mm())
            .ok_or(CoverageError::NotAMesh { triangles: self.triangles.len() })?;
        let mut open = self.opened(&gauged);
        self.add_outside(&frame, aperture, border, &mut open);
        self.draw(aperture, border, &frame, (&open, &gauged), lfs_mm)
    }

    /// The triangles that are not covered, as they are drawn.
    fn opened(&self, gauged: &[Gauged]) -> Vec<Open> {
        let open = |gauged: &Gauged| Open {
            corners: self.triangles[gauged.index],
            standing: gauged.standing,
            whereabouts: gauged.whereabouts,
            area_mm2: gauged.area_mm2,
        };
        gauged.iter().map(open).collect()
    }

    fn add_outside(
        &self,
        frame: &Frame,
        aperture: &Aperture,
        border: &Border,
        open: &mut Vec<Open>,
    ) {
        let scene = self.scene(Some(border), Some(frame), &[]);
        let aperture_mm2 = aperture.area_mm2();
        for &corners in &frame.triangles {
            let places = scene.corners(corners);
            let whereabouts = border.whereabouts(places);
            if whereabouts != Whereabouts::Outside {
                let area_mm2 = common_area_mm2(aperture, aperture_mm2, border, places);
                let standing = Standing::Bridge;
                open.push(Open { corners, standing, whereabouts, area_mm2 });
            }
        }
    }

    fn draw(
        &self,
        aperture: &Aperture,
        border: &Border,
        frame: &Frame,
        (open, gauged): (&[Open], &[Gauged]),
        lfs_mm: &impl Fn(f64, f64) -> Option<f64>,
    ) -> Result<Patches, CoverageError> {
        let opening_mm = |vertex: VertexId| {
            let [x, y, _] = self.points[vertex as usize];
            let gap_mm = self.target.gap_mm(sound_lfs(lfs_mm(x, y)));
            gap_mm.filter(|gap_mm| gap_mm.is_finite()).unwrap_or(0.0)
        };
        let scene = self.scene(Some(border), Some(frame), &[]);
        if let Ok(drawing) = scene.draw(open, opening_mm) {
            return Ok(patches(&scene, (open, gauged), drawing, self.target, lfs_mm));
        }
        for attempt in 1..ATTEMPTS {
            let border = Border::new(aperture, self.triangles.len(), attempt);
            let open: Vec<Open> = open
                .iter()
                .map(|open| {
                    let whereabouts = border.whereabouts(scene.corners(open.corners));
                    Open { whereabouts, ..*open }
                })
                .collect();
            let scene = self.scene(Some(&border), Some(frame), &[]);
            if let Ok(drawing) = scene.draw(&open, opening_mm) {
                return Ok(patches(&scene, (&open, gauged), drawing, self.target, lfs_mm));
            }
        }
        Err(CoverageError::Coincidence)
    }

    fn inside_outline(
        &self,
        gauged: Vec<Gauged>,
        outer: &[[VertexId; 2]],
        lfs_mm: &impl Fn(f64, f64) -> Option<f64>,
    ) -> Result<Patches, CoverageError> {
        let open = self.opened(&gauged);
        let scene = self.scene(None, None, outer);
        let drawing = scene.draw(&open, |_| 0.0).map_err(|_| CoverageError::Coincidence)?;
        Ok(patches(&scene, (&open, &gauged), drawing, self.target, lfs_mm))
    }

    fn scene<'a>(
        &'a self,
        border: Option<&'a Border>,
        frame: Option<&'a Frame>,
        outer: &'a [[VertexId; 2]],
    ) -> Scene<'a> {
        Scene { points: self.points, border, frame, outer }
    }
}

#[cfg(test)]
pub(crate) fn hull_of(points: &[PointMm], triangles: &[[VertexId; 3]]) -> Option<Vec<VertexId>> {
    hull(triangles, &Outline::new(points.len(), triangles))
}

/// How often the border is drawn anew; once is hardly ever needed.
const ATTEMPTS: u32 = 8;

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Mesh;
    use crate::point::place;

    #[test]
    fn a_sample_right_on_the_drawn_border_is_no_obstacle() {
        let aperture = Aperture::circle([0.0; 2], 3.0).unwrap();
        let corner = |count: usize, index: u32| {
            let [x, y] = Border::new(&aperture, count, 0).place(index);
            [x, y, 0.0]
        };
        let mut mesh = Mesh::new();
        mesh.insert(&[[-9.0, -9.0, 0.0], [9.0, -9.0, 0.0], [9.0, 9.0, 0.0], [-9.0, 9.0, 0.0]]);
        mesh.insert(&[corner(0, 0), corner(0, 100), [0.1, 0.2, 0.0]]);
        let triangles = mesh.triangles();
        let border = Border::new(&aperture, triangles.len(), 0);
        assert!(mesh.points().iter().any(|&point| place(point) == border.place(100)));
        let target = Target::spacing_mm(0.1);
        let points = mesh.points();
        let measured = Measured { points, triangles: &triangles, target: &target };
        let hull = hull(&triangles, &Outline::new(points.len(), &triangles)).unwrap();
        let frame = Frame::new(points, hull, aperture.bounds_mm()).unwrap();
        let open: Vec<Open> = triangles
            .iter()
            .map(|&corners| Open {
                corners,
                standing: Standing::Undersampled,
                whereabouts: Whereabouts::Near,
                area_mm2: 1.0,
            })
            .collect();
        let scene = measured.scene(Some(&border), Some(&frame), &[]);
        assert!(scene.draw(&open, |_| 0.0).is_err(), "the border passes through samples");
        let found = cover(points, &triangles, &[], Some(&aperture), &target, |_, _| None).unwrap();
        assert_eq!(found.patches.len(), 1);
        assert_eq!(found.patches[0].polygons.len(), 1);
    }
}
