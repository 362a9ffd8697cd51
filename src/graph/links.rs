//! Links between near places: what hangs together at the finest scale that the points allow.

use rayon::prelude::*;

use crate::cloud::{Cloud, CloudError, PlaceId};
use crate::nearest::Nearest;
use crate::tree::by_coordinates;

/// Pairs of near places, each once, the smaller number first, sorted. They are nearer than `reach_mm`.
///
/// A place is linked with its twelve nearest, and with farther ones where it has no nearer link within 45° of their direction. So
/// links bridge gaps of the sampling, and are short elsewhere. Which links there are does not hang on the numbers of places.
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
        let mut found = Vec::with_capacity(run.len() * NEAREST * 3 / 2);
        let mut near = Vec::new();
        for &place in run {
            sort_near(cloud, &nearest, (place, reach_mm), &mut near);
            let mut directions: Vec<[f64; D]> = Vec::with_capacity(near.len());
            let last_mm = near.get(NEAREST - 1).map_or(f64::INFINITY, |&(mm, _)| mm);
            let from = cloud.places()[place as usize];
            for &(mm, other) in &near {
                let to = cloud.places()[other as usize];
                let direction = std::array::from_fn(|axis| (to[axis] - from[axis]) / mm);
                let is_aside = |known: &[f64; D]| {
                    (0..D).map(|axis| known[axis] * direction[axis]).sum::<f64>() < COSINE
                };
                if mm <= last_mm || directions.iter().all(is_aside) {
                    directions.push(direction);
                    found.push([place.min(other), place.max(other)]);
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

/// The places near one with their distances in mm, nearest first, equally near ones by their coordinates. Places as far away as one
/// that the list of neighbours lacks are left out.
fn sort_near<const D: usize>(
    cloud: &Cloud<D>,
    nearest: &Nearest,
    (place, reach_mm): (PlaceId, f64),
    near: &mut Vec<(f64, PlaceId)>,
) {
    let distances_mm = nearest.distances_mm(place);
    let end_mm = distances_mm.get(NEIGHBOURS).copied().unwrap_or(f64::INFINITY).min(reach_mm);
    near.clear();
    let all = distances_mm.iter().copied().zip(nearest.neighbours(place).iter().copied());
    near.extend(all.take_while(|&(mm, _)| mm < end_mm));
    if near.windows(2).any(|pair| pair[0].0 == pair[1].0) {
        let at = |of: &(f64, PlaceId)| &cloud.places()[of.1 as usize];
        near.sort_by(|a, b| a.0.total_cmp(&b.0).then_with(|| by_coordinates(at(a), at(b))));
    }
}

/// The nearest places that a place is linked with at any rate; more where several are equally near.
const NEAREST: usize = 12;

/// The nearest places that it may be linked with.
const NEIGHBOURS: usize = 36;

/// Cosine of the angle between links beyond the nearest: 45°.
const COSINE: f64 = std::f64::consts::FRAC_1_SQRT_2;

/// Places that one job takes.
const RUN: usize = 1024;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn links_bridge_a_gap_and_are_short_elsewhere() {
        // A lattice without two columns in the middle.
        let columns = (0..21).filter(|x| !(9..11).contains(x));
        let points: Vec<[f64; 2]> =
            columns.flat_map(|x| (0..21).map(move |y| [f64::from(x), f64::from(y)])).collect();
        let cloud = Cloud::new(&points).unwrap();
        let across = |reach_mm: f64| {
            let sides = |link: &&[PlaceId; 2]| {
                let [a, b] = link.map(|place| cloud.places()[place as usize][0] < 10.0);
                a != b
            };
            links(&cloud, reach_mm).unwrap().iter().filter(sides).count()
        };
        // The twelve nearest of a place at the gap lie on its side, within √5; over the gap it is 3.
        assert_eq!((across(3.0), across(3.1)), (0, 21));
        // Every inner place is linked with the twelve within 2 steps; the next ones lie in directions that are taken.
        let inner = cloud.places().iter().position(|place| *place == [4.0, 10.0]).unwrap() as u32;
        let count = |reach_mm| {
            links(&cloud, reach_mm).unwrap().iter().filter(|link| link.contains(&inner)).count()
        };
        assert_eq!((count(2.1), count(1.1)), (12, 4));
    }
}
