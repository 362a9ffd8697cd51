//! Links between near places: what hangs together at the finest scale that the points allow.

use rayon::prelude::*;

use crate::cloud::{Cloud, CloudError, PlaceId};

/// Pairs of places, one of which is among the [`NEIGHBOURS`] nearest of the other, nearer than `reach_mm`. Each pair once, the
/// smaller number first, sorted. Places as far away as the last of the nearest count too, so ties do not hang on numbers.
///
/// # Errors
///
/// Neighbours that cannot be listed.
pub(crate) fn links<const D: usize>(
    cloud: &Cloud<D>,
    reach_mm: f64,
) -> Result<Vec<[PlaceId; 2]>, CloudError> {
    let nearest = cloud.nearest(NEIGHBOURS + 1)?;
    let places: Vec<PlaceId> = (0..cloud.len() as u32).collect();
    let of_run = |run: &[PlaceId]| {
        let mut found = Vec::with_capacity(run.len() * NEIGHBOURS);
        for &place in run {
            let mut add = |other: PlaceId| found.push([place.min(other), place.max(other)]);
            let (ids, distances_mm) = (nearest.neighbours(place), nearest.distances_mm(place));
            match distances_mm.get(NEIGHBOURS - 1..) {
                Some(&[last_mm, next_mm]) if next_mm <= last_mm * SAME && next_mm < reach_mm => {
                    let within_mm = (last_mm * SAME).min(reach_mm);
                    cloud.visit_within(place, within_mm, |other, _| add(other));
                }
                _ => {
                    let near = ids.iter().zip(distances_mm).take(NEIGHBOURS);
                    near.filter(|&(_, &mm)| mm < reach_mm).for_each(|(&other, _)| add(other));
                }
            }
        }
        found
    };
    let mut links: Vec<[PlaceId; 2]> = places.par_chunks(RUN).flat_map_iter(of_run).collect();
    links.par_sort_unstable();
    links.dedup();
    Ok(links)
}

/// The nearest places that a place is linked with.
const NEIGHBOURS: usize = 24;

/// Distances that differ by less than this factor are the same.
const SAME: f64 = 1.0 + 1e-9;

/// Places that one job takes.
const RUN: usize = 1024;
