//! Broken and repeated lines: regions that close over gaps, and lines drawn several times made one.
//!
//! Points are samples of lines: outlines with gaps, or edges that were passed more than once. [`triangle_growing`] finds regions by itself;
//! [`delaunay_painting`] and [`colour_by_numbers`] take hints that name places within regions. After A. D. Parakkat and others: a Delaunay triangulation
//! based approach for cleaning rough sketches, Computers & Graphics 74 (2018); Delaunay painting, Computer Graphics Forum 41 (2022); Color by numbers,
//! CHI 2021. The texts were not at hand; the description is that of a lecture, and what it leaves open is our choice.

mod axis;
mod fit;
mod groups;
mod hints;

use self::axis::lines_of;
pub use self::fit::beziers_of;
use self::groups::{Groups, is_fat};
pub use self::hints::{Hint, HintError, hints_of};
use crate::graphs::spanning_by_length;
use crate::triangulation::EdgeId;
use crate::{PlaceMm, Region, SampleId, Triangulation};

/// Regions between lines, and the lines.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Strokes {
    /// The regions: their parts have the numbers of labels.
    pub region: Region,
    /// The labels of numbers 1, 2 and so on; without hints the numbers themselves.
    pub labels: Vec<String>,
    /// Sides between two regions that close gaps, the narrowest first: those longer than half of [`closing_gap_mm`]. A gap beside triangles without a
    /// label, within a stroke, is not among them; [`delaunay_painting`] has no such triangles.
    pub gaps: Vec<[SampleId; 2]>,
    /// The lines between regions; several passes are one.
    pub lines: Vec<StrokeLine>,
}

/// A line between regions.
#[derive(Clone, Debug, PartialEq)]
pub struct StrokeLine {
    /// Its places in order, mm; of a closed one the first is not repeated.
    pub places_mm: Vec<PlaceMm>,
    /// Whether the last place is joined to the first.
    pub closed: bool,
}

/// The regions of a drawing, grown from fat triangles; what stays thin is line.
///
/// Triangles belong together across sides longer than a gap. Such a group is a region if a triangle of it has no angle above 90°, and an area
/// above mask². What lies beyond the hull is one triangle of a region of its own, which is not listed. All other triangles lie within strokes: their middle is the
/// line. Sides up to the gap between two regions, or within one, are lines, too. n·log n time.
pub fn triangle_growing(triangulation: &Triangulation, gap_mm: f64, mask_mm: f64) -> Strokes {
    let mut groups = Groups::new(triangulation);
    groups.join_above(gap_mm);
    let fat = |triangle: u32| is_fat(triangulation, triangle, mask_mm);
    let count = groups.seed_where(fat);
    let labels = (1..=count).map(|number| number.to_string()).collect();
    strokes(triangulation, &groups.labels(), labels, gap_mm)
}

/// The regions that hints name, closed over gaps: each triangle has the label that reaches it through the widest gaps.
///
/// A side lets through as much as it is long; a way as much as its shortest side. Labels start in the triangles of the hints. What lies beyond the hull is one
/// triangle, and a region of its own unless a hint lies there. Between two triangles without a side above `brush_mm`, as in hatching, a side lets through
/// `brush_mm` at least. n·log n time.
///
/// # Errors
///
/// No hint; a hint on a point or a line between two; hints of different labels in one triangle.
pub fn delaunay_painting(
    triangulation: &Triangulation,
    hints: &[Hint],
    brush_mm: f64,
) -> Result<Strokes, HintError> {
    let mut groups = Groups::new(triangulation);
    let labels = groups.seed(triangulation, hints)?;
    groups.paint(brush_mm, 0.0);
    Ok(strokes(triangulation, &groups.labels(), labels, 0.0))
}

/// The lines between regions that hints name: as [`delaunay_painting`], but labels pass sides longer than a gap only. What no label reaches lies within
/// strokes. So several passes between two hints become one line.
///
/// # Errors
///
/// As [`delaunay_painting`].
pub fn colour_by_numbers(
    triangulation: &Triangulation,
    hints: &[Hint],
    gap_mm: f64,
) -> Result<Strokes, HintError> {
    let mut groups = Groups::new(triangulation);
    let labels = groups.seed(triangulation, hints)?;
    groups.paint(0.0, gap_mm);
    Ok(strokes(triangulation, &groups.labels(), labels, 0.0))
}

/// The widest gap that is closed where none is given: three times the edge of the spanning tree that nine of ten do not exceed. None without edges.
pub fn closing_gap_mm(triangulation: &Triangulation) -> Option<f64> {
    let tree = spanning_by_length(triangulation);
    tree.get(tree.len() * 9 / 10).map(|&edge| 3.0 * triangulation.length_mm(edge))
}

/// Labels of triangles as regions and lines; sides up to `faint_mm` within a region are lines.
fn strokes(
    triangulation: &Triangulation,
    of_triangles: &[Option<u32>],
    labels: Vec<String>,
    faint_mm: f64,
) -> Strokes {
    let numbers: Vec<u32> = of_triangles.iter().map(|label| label.unwrap_or(0)).collect();
    let label = |triangle: Option<u32>| triangle.map_or(Some(0), |it| of_triangles[it as usize]);
    let listed_mm = closing_gap_mm(triangulation).map_or(f64::INFINITY, |gap_mm| 0.5 * gap_mm);
    let is_gap = |&edge: &EdgeId| {
        let [left, right] = triangulation.edges()[edge as usize].triangles().map(label);
        left.is_some()
            && right.is_some()
            && left != right
            && triangulation.length_mm(edge) > listed_mm
    };
    Strokes {
        region: Region::labelled(triangulation, &numbers),
        labels,
        gaps: triangulation
            .by_length()
            .iter()
            .filter(|edge| is_gap(edge))
            .map(|&edge| triangulation.ends(edge))
            .collect(),
        lines: lines_of(triangulation, of_triangles, faint_mm),
    }
}
