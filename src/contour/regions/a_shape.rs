//! The A-shape: an α-shape whose α follows the density of the samples.

use asphera_geometry::{RANGE_MM, WeightedTree};

use super::radius_mm;
use crate::inside::Inside;
use crate::triangulation::{TriangleId, distance_mm};
use crate::{PlaceMm, Region, SampleId, Triangulation};

/// The A-shape: the triangles whose circumcircle holds none of a set of Voronoi vertices.
///
/// The set is that of triangles with a radius above α·((1 - t) + t·h/h'): h is the mean length of the edges at the triangle's corners,
/// h' the median of that of all samples. So t = 0 asks the same everywhere and t = 1 goes wholly by density. The region is made of the
/// triangles of the Delaunay triangulation of samples and set together that have three samples as corners. M. Melkemi, M.
/// Djebali, *Computing the shape of a planar points set*, Pattern Recognition 33 (2000) 1423-1436, for the shape of a set; the text
/// was not at hand, and how α and t choose the set is our choice. Computed in doubles. n·log n time.
///
/// # Panics
///
/// If α is not above 0 or not finite, or t is not from 0 to 1.
pub fn a_shape(triangulation: &Triangulation, alpha_mm: f64, t: f64) -> Region {
    assert!(
        alpha_mm.is_finite() && alpha_mm > 0.0,
        "expected a finite α above 0, found {alpha_mm}"
    );
    assert!((0.0..=1.0).contains(&t), "expected t from 0 to 1, found {t}");
    let count = triangulation.triangles().len();
    let around_mm: Vec<f64> = (0..triangulation.len() as SampleId)
        .map(|sample| {
            let spokes = triangulation.spokes(sample);
            let lengths = spokes.iter().map(|spoke| triangulation.length_mm(spoke.edge));
            lengths.sum::<f64>() / spokes.len().max(1) as f64
        })
        .collect();
    let mut sorted_mm = around_mm.clone();
    sorted_mm.sort_by(f64::total_cmp);
    let median_mm = sorted_mm.get(sorted_mm.len() / 2).copied().unwrap_or(0.0);
    let is_in_set: Vec<bool> = (0..count)
        .map(|triangle| {
            let corners = triangulation.triangles()[triangle];
            let mean_mm =
                corners.map(|corner| around_mm[corner as usize]).iter().sum::<f64>() / 3.0;
            let most_mm = alpha_mm * ((1.0 - t) + t * mean_mm / median_mm);
            radius_mm(triangulation, triangle as TriangleId) > most_mm
        })
        .collect();
    let centres = triangulation.centres_mm();
    // One farther off lies in circles of its own size only.
    let is_near = |place: &PlaceMm| place.iter().all(|value| value.abs() <= RANGE_MM);
    let set =
        centres.iter().zip(&is_in_set).filter(|&(place, is_in_set)| *is_in_set && is_near(place));
    let set = WeightedTree::new(set.map(|(&[x, y], _)| ([x, y, 0.0], 0.0)));
    let keeps = |triangle: usize| {
        if is_in_set[triangle] {
            return false;
        }
        let [x, y] = centres[triangle];
        let corner = triangulation.place(triangulation.triangles()[triangle][0]);
        let radius_mm = distance_mm([x, y], corner);
        set.least([x, y, 0.0]).is_none_or(|distance_mm| distance_mm >= radius_mm)
    };
    Region::of(triangulation, &Inside::of((0..count).map(keeps).collect()))
}
