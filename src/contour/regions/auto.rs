//! A region without parameters, with its border moved to where the area is expected to end.

use super::alpha::alpha_shape;
use crate::{Region, SampleId, Triangulation};

/// The α-shape of twice the median edge, with its border moved out by 0.33 to 0.40 of that edge.
///
/// Samples within an area end before its border does. The gap is 0.33 of the median edge on a raster and 0.40 for points at random; in
/// between it follows the spread of the distances to nearest samples:
///
/// gap = (0.33 + 0.07·min(1, s / 0.52))·median edge
///
/// s is the standard deviation of those distances over their mean, 0.52 for points at random (J. G. Skellam 1952). Holes shrink as the
/// outline grows. Nothing is moved where the border itself was sampled: where the middle length of border edges is below 0.9 of the
/// median edge and the spread of the middle half of them is below a quarter of it. The rule and its figures are ours, from discs, rings
/// and rectangles of 8,000 points. The gap is for borders that do not run along the rows of a raster: there it is anything from 0 to a
/// row. n·log n time.
pub fn auto_shape(triangulation: &Triangulation) -> Region {
    let by_length = triangulation.by_length();
    let median_mm = by_length.get(by_length.len() / 2).map(|&edge| triangulation.length_mm(edge));
    let Some(median_mm) = median_mm.filter(|_| !triangulation.triangles().is_empty()) else {
        return Region::default();
    };
    let region = alpha_shape(triangulation, 2.0 * median_mm);
    match is_border_sampled(triangulation, &region, median_mm) {
        true => region,
        false => region.moved(median_mm * (0.33 + 0.07 * (spread(triangulation) / 0.52).min(1.0))),
    }
}

/// Whether the edges of the border are shorter than those within, and alike.
fn is_border_sampled(triangulation: &Triangulation, region: &Region, median_mm: f64) -> bool {
    let edges = region.border().edges().iter();
    let mut ranks: Vec<(u32, u32)> = edges
        .filter_map(|&[p, q]| triangulation.edge_between(p, q))
        .map(|edge| (triangulation.length_class(edge), edge))
        .collect();
    ranks.sort_unstable();
    let at = |quarters: usize| {
        let rank = ranks.get(quarters * ranks.len() / 4);
        rank.map_or(f64::INFINITY, |&(_, edge)| triangulation.length_mm(edge))
    };
    at(2) < 0.9 * median_mm && at(3) - at(1) < 0.25 * at(2)
}

/// The standard deviation of the distances to nearest samples over their mean.
fn spread(triangulation: &Triangulation) -> f64 {
    let nearest =
        (0..triangulation.len() as SampleId).filter_map(|sample| triangulation.nearest(sample));
    let mut distances_mm: Vec<f64> =
        nearest.map(|spoke| triangulation.length_mm(spoke.edge)).collect();
    // In the order of their sizes the sums do not depend on the numbers of the samples.
    distances_mm.sort_by(f64::total_cmp);
    let count = distances_mm.len() as f64;
    let mean_mm = distances_mm.iter().sum::<f64>() / count;
    let squares = distances_mm.iter().map(|distance| (distance - mean_mm).powi(2)).sum::<f64>();
    (squares / count).sqrt() / mean_mm
}
