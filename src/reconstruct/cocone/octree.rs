//! Cells of an octree: points in boxes that are halved along all three axes until they hold few.

use asphera_geometry::{BoxMm, PointMm};

/// The points of each leaf, by number. The places must differ.
pub(super) fn leaves(places_mm: &[PointMm], most: usize) -> Vec<Vec<u32>> {
    let mut leaves = Vec::new();
    let mut branches = vec![(0..places_mm.len() as u32).collect::<Vec<u32>>()];
    while let Some(points) = branches.pop() {
        if points.len() <= most.max(1) {
            leaves.push(points);
            continue;
        }
        // About the points rather than half of the box above: so every cut parts some.
        let about = BoxMm::about(points.iter().map(|&at| places_mm[at as usize]));
        let middle = [0, 1, 2].map(|axis| 0.5 * about.low[axis] + 0.5 * about.high[axis]);
        let mut octants: [Vec<u32>; 8] = Default::default();
        for at in points {
            let place = places_mm[at as usize];
            let octant = (0..3).filter(|&axis| place[axis] > middle[axis]);
            octants[octant.fold(0, |octant, axis| octant | 1 << axis)].push(at);
        }
        branches.extend(octants.into_iter().filter(|octant| !octant.is_empty()));
    }
    leaves
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_point_is_in_one_leaf_even_where_places_are_neighbours() {
        // Places that differ in the last bit, and some far away.
        let mut places = vec![[1.0_f64, 2.0, 3.0]];
        for step in 1..40 {
            let [x, y, z] = places[step - 1];
            places.push([x.next_up(), y, z]);
        }
        places.extend((0..200).map(|at| [f64::from(at), f64::from(at % 7), 1e9]));
        let leaves = leaves(&places, 5);
        assert!(leaves.iter().all(|leaf| (1..=5).contains(&leaf.len())));
        let mut all: Vec<u32> = leaves.concat();
        all.sort_unstable();
        assert_eq!(all, (0..240).collect::<Vec<u32>>());
    }
}
