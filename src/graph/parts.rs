//! Parts of a scene: the τ-components of the cloud, islands of few points apart.

use crate::cloud::{Cloud, PlaceId};
use crate::graph::{GraphError, tau_components};

/// A part.
#[derive(Clone, Debug, PartialEq)]
pub struct Part<const D: usize> {
    /// Its places, ascending.
    pub places: Vec<PlaceId>,
    /// Points in them.
    pub points: u64,
    /// The box along the axes: least and largest coordinates in mm.
    pub box_mm: [[f64; D]; 2],
    /// The mean of the places in mm.
    pub centre_mm: [f64; D],
}

/// The parts of a cloud and what is too small to be one.
#[derive(Clone, Debug, PartialEq)]
pub struct Parts<const D: usize> {
    /// The parts, the one of most points first; of equal ones that of the smaller centre by coordinates.
    pub parts: Vec<Part<D>>,
    /// Islands of few points, in the same order.
    pub islands: Vec<Part<D>>,
}

/// The parts of a cloud for τ. A piece is an island if it has fewer points than `min_points`. Some n·log n time.
///
/// # Errors
///
/// τ as in [`PointGraph::new`](crate::PointGraph::new).
pub fn parts<const D: usize>(
    cloud: &Cloud<D>,
    tau_mm: f64,
    min_points: u64,
) -> Result<Parts<D>, GraphError> {
    let (of_place, count) = tau_components(cloud, tau_mm)?;
    let mut places: Vec<Vec<PlaceId>> = vec![Vec::new(); count as usize];
    for (place, &piece) in (0..).zip(&of_place) {
        places[piece as usize].push(place);
    }
    let copies = cloud.copies();
    let mut all: Vec<Part<D>> =
        places.into_iter().map(|places| part(cloud, &copies, places)).collect();
    all.sort_by(|a, b| {
        b.points
            .cmp(&a.points)
            .then_with(|| crate::tree::by_coordinates(&a.centre_mm, &b.centre_mm))
    });
    let (parts, islands) = all.into_iter().partition(|part| part.points >= min_points);
    Ok(Parts { parts, islands })
}

/// Points that make a part rather than an island: a hundredth of those of the largest piece, but 20 or more.
///
/// # Errors
///
/// τ as in [`PointGraph::new`](crate::PointGraph::new).
pub fn auto_min_points<const D: usize>(cloud: &Cloud<D>, tau_mm: f64) -> Result<u64, GraphError> {
    let largest = parts(cloud, tau_mm, 0)?.parts.first().map_or(0, |part| part.points);
    Ok((largest / ISLAND_SHARE).max(ISLAND_POINTS))
}

fn part<const D: usize>(cloud: &Cloud<D>, copies: &[u32], places: Vec<PlaceId>) -> Part<D> {
    let all = cloud.places();
    let origin = all[places[0] as usize];
    let mut box_mm = [origin; 2];
    let mut sum = [0.0; D];
    let mut points = 0;
    for &place in &places {
        let position = &all[place as usize];
        points += u64::from(copies[place as usize]);
        for axis in 0..D {
            box_mm[0][axis] = box_mm[0][axis].min(position[axis]);
            box_mm[1][axis] = box_mm[1][axis].max(position[axis]);
            sum[axis] += position[axis] - origin[axis];
        }
    }
    let count = places.len() as f64;
    let centre_mm = std::array::from_fn(|axis| origin[axis] + sum[axis] / count);
    Part { places, points, box_mm, centre_mm }
}

/// Points of the largest piece over those of the largest island.
const ISLAND_SHARE: u64 = 100;

/// A part has so many points at least.
const ISLAND_POINTS: u64 = 20;
