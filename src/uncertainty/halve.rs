//! Places parted into two halves that lie apart.

/// Parts the indices of places in two across the longer side of their extent. Coordinates that are as good as equal go by
/// their other one and then by index: in the part frame heights move the places of a raster by as little, and the halves must
/// not depend on heights. The order within them depends on more. `O(n)`.
pub(super) fn halve<'a>(
    order: &'a mut [usize],
    places_mm: &[[f64; 2]],
) -> (&'a mut [usize], &'a mut [usize]) {
    let (axis, extent_mm) = longer_side(order, places_mm);
    let middle = order.len() / 2;
    let at = |index: usize, axis: usize| places_mm[index][axis];
    if order.len() > 1 {
        let by = |axis: usize| {
            move |&a: &usize, &b: &usize| at(a, axis).total_cmp(&at(b, axis)).then(a.cmp(&b))
        };
        let (_, &mut of_middle, _) = order.select_nth_unstable_by(middle, by(axis));
        let (cut_mm, equal_mm) = (at(of_middle, axis), EQUAL * extent_mm);
        let below = part(order, |index| at(index, axis) < cut_mm - equal_mm);
        let alike = part(&mut order[below..], |index| at(index, axis) <= cut_mm + equal_mm);
        order[below..below + alike].select_nth_unstable_by(middle - below, by(1 - axis));
    }
    order.split_at_mut(middle)
}

/// Puts those first that belong there, and counts them.
fn part(order: &mut [usize], belongs: impl Fn(usize) -> bool) -> usize {
    let mut first = 0;
    for index in 0..order.len() {
        if belongs(order[index]) {
            order.swap(first, index);
            first += 1;
        }
    }
    first
}

/// The axis, 0 or 1, along which places reach farther, and how far.
pub(super) fn longer_side(order: &[usize], places_mm: &[[f64; 2]]) -> (usize, f64) {
    let extent = |axis: usize| {
        let range = order.iter().fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], &index| {
            let value = places_mm[index][axis];
            [low.min(value), high.max(value)]
        });
        range[1] - range[0]
    };
    let [x, y] = [extent(0), extent(1)];
    if y > x { (1, y) } else { (0, x) }
}

/// Share of the extent up to which coordinates are as good as equal.
const EQUAL: f64 = 1e-6;

#[cfg(test)]
mod tests {
    use super::*;

    /// Heights of nanometres times a tilt of the part move the columns of a raster by less than a picometre.
    #[test]
    fn columns_that_are_as_good_as_straight_are_cut_along_them() {
        let shaken = |index: usize| 1e-12 * ((index * 7919) % 101) as f64;
        let place = |index: usize| [(index % 5) as f64 + shaken(index), 0.5 * (index / 5) as f64];
        let places: Vec<[f64; 2]> = (0..25).map(place).collect();
        let mut order: Vec<usize> = (0..25).rev().collect();
        let (low, high) = halve(&mut order, &places);
        low.sort_unstable();
        high.sort_unstable();
        // Two columns, and of the third the two that lie lowest.
        assert_eq!(low, [0, 1, 2, 5, 6, 7, 10, 11, 15, 16, 20, 21]);
        assert_eq!(high.len(), 13);
    }

    #[test]
    fn one_place_none_and_the_same() {
        for count in [0, 1, 2, 5] {
            let mut order: Vec<usize> = (0..count).collect();
            let (low, high) = halve(&mut order, &[[1.0, 2.0]; 5]);
            assert_eq!((low.len(), high.len()), (count / 2, count - count / 2));
            assert!(low.iter().all(|a| high.iter().all(|b| a < b)));
        }
    }
}
