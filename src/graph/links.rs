//! Links between near places: what hangs together at the finest scale that the points allow.

use rayon::prelude::*;

use crate::cloud::{Cloud, CloudError, PlaceId};
use crate::nearest::Entry;
use crate::tree::by_coordinates;

/// Pairs of near places by numbers that each place has, each once, the smaller number first, sorted. They are nearer than
/// `reach_mm`.
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
    number_of: impl Fn(PlaceId) -> u32 + Sync,
) -> Result<Vec<[u32; 2]>, CloudError> {
    let runs = cloud.of_nearest(NEIGHBOURS + 1, |place, nearest, found| {
        let a = number_of(place);
        linked(cloud, (place, reach_mm), nearest, |other| {
            let b = number_of(other);
            // One number sorts faster than two.
            found.push(u64::from(a.min(b)) << 32 | u64::from(a.max(b)));
        });
    });
    let mut links = runs.concat();
    drop(runs);
    links.par_sort_unstable();
    links.dedup();
    Ok(links.into_iter().map(|link| [(link >> 32) as u32, link as u32]).collect())
}

/// The places that one is linked with. Places as far away as one that the list of neighbours lacks are none.
fn linked<const D: usize>(
    cloud: &Cloud<D>,
    (place, reach_mm): (PlaceId, f64),
    nearest: &[Entry],
    mut take: impl FnMut(PlaceId),
) {
    let all = cloud.places();
    let from = &all[place as usize];
    let way = |of: u32| -> [f64; D] {
        let to = &all[of as usize];
        std::array::from_fn(|axis| to[axis] - from[axis])
    };
    let end_mm = match nearest.last() {
        Some(last) if nearest.len() > NEIGHBOURS => last.square().sqrt().min(reach_mm),
        _ => reach_mm,
    };
    let (mut near, mut inside) = ([(0.0, 0); NEIGHBOURS + 1], 0);
    for entry in nearest {
        near[inside] = (entry.square().sqrt(), entry.id());
        inside += usize::from(near[inside].0 < end_mm);
    }
    let near = &mut near[..inside];
    let last_mm = if near.len() < NEAREST {
        f64::INFINITY
    } else {
        near.select_nth_unstable_by(NEAREST - 1, |a, b| a.0.total_cmp(&b.0)).1.0
    };
    let (mut known, mut count) = ([[0.0; D]; NEIGHBOURS + 1], 0);
    // The nearest ones are linked anyhow; so most of the farther ones need not be sorted.
    for &(mm, other) in near.iter().filter(|(mm, _)| *mm <= last_mm) {
        known[count] = way(other).map(|side| side / mm);
        count += 1;
        take(other);
    }
    let base = &known[..count];
    let is_aside = |&&(mm, other): &&(f64, PlaceId)| {
        let way = way(other);
        // Most are near a direction for certain, and need no division.
        let surely = COSINE * (1.0 + 1e-9) * mm;
        mm > last_mm
            && !base.iter().any(|known| dot(known, &way) > surely)
            && base.iter().all(|known| dot(known, &way.map(|side| side / mm)) < COSINE)
    };
    let mut farther: Vec<(f64, PlaceId)> = near.iter().filter(is_aside).copied().collect();
    let place_of = |of: &(f64, PlaceId)| &all[of.1 as usize];
    farther
        .sort_by(|a, b| a.0.total_cmp(&b.0).then_with(|| by_coordinates(place_of(a), place_of(b))));
    let base = count;
    for (mm, other) in farther {
        let direction = way(other).map(|side| side / mm);
        if known[base..count].iter().all(|known| dot(known, &direction) < COSINE) {
            known[count] = direction;
            count += 1;
            take(other);
        }
    }
}

fn dot<const D: usize>(a: &[f64; D], b: &[f64; D]) -> f64 {
    (0..D).map(|axis| a[axis] * b[axis]).sum()
}

/// The nearest places that a place is linked with at any rate; more where several are equally near.
const NEAREST: usize = 12;

/// The nearest places that it may be linked with.
const NEIGHBOURS: usize = 36;

/// Cosine of the angle between links beyond the nearest: 45°.
const COSINE: f64 = std::f64::consts::FRAC_1_SQRT_2;

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
            links(&cloud, reach_mm, |place| place).unwrap().iter().filter(sides).count()
        };
        // The twelve nearest of a place at the gap lie on its side, within √5; over the gap it is 3.
        assert_eq!((across(3.0), across(3.1)), (0, 21));
        // Every inner place is linked with the twelve within 2 steps; the next ones lie in directions that are taken.
        let inner = cloud.places().iter().position(|place| *place == [4.0, 10.0]).unwrap() as u32;
        let count = |reach_mm| {
            links(&cloud, reach_mm, |place| place)
                .unwrap()
                .iter()
                .filter(|link| link.contains(&inner))
                .count()
        };
        assert_eq!((count(2.1), count(1.1)), (12, 4));
    }
}
