//! The A-shape: an α-shape whose α follows the density of the samples.

use asphera_geometry::{RANGE_MM, WeightedTree};

use super::alpha::{connecting, connecting_alpha_mm};
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
    let count = triangulation.triangles().len();
    let scales = scales(triangulation, t);
    let is_in_set: Vec<bool> = (0..count)
        .map(|triangle| {
            radius_mm(triangulation, triangle as TriangleId) > alpha_mm * scales[triangle]
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

/// An α for the A-shape in mm: the larger of the smallest with which the triangles outside the set are one part with all samples, and
/// [`connecting_alpha_mm`]; none without triangles.
///
/// Circles that hold a place of the set may still cut the shape. The rule is ours. n·log n time.
///
/// # Panics
///
/// If t is not from 0 to 1.
pub fn connecting_a_mm(triangulation: &Triangulation, t: f64) -> Option<f64> {
    let scales = scales(triangulation, t);
    let scaled_mm = connecting(triangulation, |triangle| {
        radius_mm(triangulation, triangle) / scales[triangle as usize]
    });
    Some(scaled_mm?.max(connecting_alpha_mm(triangulation)?))
}

/// The factor of α at each triangle: (1 - t) + t·h/h'.
fn scales(triangulation: &Triangulation, t: f64) -> Vec<f64> {
    assert!((0.0..=1.0).contains(&t), "expected t from 0 to 1, found {t}");
    let around_mm: Vec<f64> = (0..triangulation.len() as SampleId)
        .map(|sample| {
            let spokes = triangulation.spokes(sample);
            let mut lengths: Vec<f64> =
                spokes.iter().map(|spoke| triangulation.length_mm(spoke.edge)).collect();
            // In the order of their sizes the sum does not depend on the numbers of the samples.
            lengths.sort_by(f64::total_cmp);
            lengths.iter().sum::<f64>() / spokes.len().max(1) as f64
        })
        .collect();
    let mut sorted_mm = around_mm.clone();
    sorted_mm.sort_by(f64::total_cmp);
    let median_mm = sorted_mm.get(sorted_mm.len() / 2).copied().unwrap_or(0.0);
    let scale = |corners: &[SampleId; 3]| {
        let mut at_corners = corners.map(|corner| around_mm[corner as usize]);
        at_corners.sort_by(f64::total_cmp);
        (1.0 - t) + t * at_corners.iter().sum::<f64>() / 3.0 / median_mm
    };
    triangulation.triangles().iter().map(scale).collect()
}
