//! Places parted into two halves that lie apart.

/// Parts the indices of places in two across the longer side of their extent. Equal coordinates go by their other one
/// and then by index, so the halves depend on nothing else; the order within them does. `O(n)`.
pub(super) fn halve<'a>(
    order: &'a mut [usize],
    places_mm: &[[f64; 2]],
) -> (&'a mut [usize], &'a mut [usize]) {
    let axis = longer_side(order, places_mm);
    let middle = order.len() / 2;
    order.select_nth_unstable_by(middle, |&a, &b| {
        let (p, q) = (places_mm[a], places_mm[b]);
        p[axis].total_cmp(&q[axis]).then(p[1 - axis].total_cmp(&q[1 - axis])).then(a.cmp(&b))
    });
    order.split_at_mut(middle)
}

/// The axis, 0 or 1, along which places reach farther.
pub(super) fn longer_side(order: &[usize], places_mm: &[[f64; 2]]) -> usize {
    let extent = |axis: usize| {
        let range = order.iter().fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], &index| {
            let value = places_mm[index][axis];
            [low.min(value), high.max(value)]
        });
        range[1] - range[0]
    };
    usize::from(extent(1) > extent(0))
}
