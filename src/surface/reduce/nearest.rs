//! The nearest of a fixed set of points.

use super::target::squared_mm2;
use crate::PointMm;

/// A balanced tree of points, cut at the middle of the longest side of each part's box (J. L.
/// Bentley, Communications of the ACM 18 (1975) 509-517, doi:10.1145/361002.361007).
///
/// Built in n·log n time; a query takes log n on average, for points on a surface in any order.
pub(super) struct Tree<'a> {
    points: &'a [PointMm],
    /// The points in the order of the tree: of each part the middle one is its root.
    order: Vec<u32>,
    /// The axis along which each part is cut, at the place of its root.
    axes: Vec<u8>,
}

impl<'a> Tree<'a> {
    /// A tree of finite points, fewer than 2³².
    pub(super) fn new(points: &'a [PointMm]) -> Tree<'a> {
        let mut order: Vec<u32> = (0..points.len() as u32).collect();
        let mut axes = vec![0; points.len()];
        cut(points, &mut order, &mut axes);
        Tree { points, order, axes }
    }

    /// The point nearest to `place` for which `wanted` is true, and its squared distance in mm²; of
    /// several the one of the smallest number.
    pub(super) fn nearest(
        &self,
        place: PointMm,
        wanted: impl Fn(u32) -> bool,
    ) -> Option<(u32, f64)> {
        let mut best: Option<(u32, f64)> = None;
        // Parts still to be looked at, with the squared distance to the plane that cuts them off.
        let mut parts = vec![(0, self.order.len(), 0.0)];
        while let Some((from, to, off_mm2)) = parts.pop() {
            if from == to || best.is_some_and(|(_, mm2)| off_mm2 > mm2) {
                continue;
            }
            let middle = usize::midpoint(from, to);
            let root = self.order[middle];
            let at = self.points[root as usize];
            let candidate = (root, squared_mm2(at, place));
            let nearer = |(number, mm2): (u32, f64)| {
                candidate.1 < mm2 || (candidate.1 == mm2 && candidate.0 < number)
            };
            if wanted(root) && best.is_none_or(nearer) {
                best = Some(candidate);
            }
            let axis = usize::from(self.axes[middle]);
            let beyond_mm = place[axis] - at[axis];
            let (lower, upper) = ((from, middle), (middle + 1, to));
            let (near, far) = if beyond_mm < 0.0 { (lower, upper) } else { (upper, lower) };
            parts.push((far.0, far.1, beyond_mm * beyond_mm));
            parts.push((near.0, near.1, off_mm2));
        }
        best
    }
}

fn cut(points: &[PointMm], order: &mut [u32], axes: &mut [u8]) {
    let mut parts = vec![(0, order.len())];
    while let Some((from, to)) = parts.pop() {
        if to - from < 2 {
            continue;
        }
        let (mut low, mut high) = ([f64::INFINITY; 3], [f64::NEG_INFINITY; 3]);
        for &number in &order[from..to] {
            for (axis, &coordinate) in points[number as usize].iter().enumerate() {
                low[axis] = low[axis].min(coordinate);
                high[axis] = high[axis].max(coordinate);
            }
        }
        let side = |axis: &usize| high[*axis] - low[*axis];
        let axis = (0..3).max_by(|a, b| side(a).total_cmp(&side(b))).unwrap_or(0);
        let middle = usize::midpoint(from, to);
        let along = |number: &u32| points[*number as usize][axis];
        // By number where places agree: one set of points makes one tree.
        order[from..to].select_nth_unstable_by(middle - from, |a, b| {
            along(a).total_cmp(&along(b)).then(a.cmp(b))
        });
        axes[middle] = axis as u8;
        parts.push((from, middle));
        parts.push((middle + 1, to));
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;
    use crate::regressions::beside_source;

    proptest! {
        #![proptest_config(beside_source())]

        #[test]
        fn agrees_with_looking_at_all(
            // A coarse lattice, so that many distances are equal.
            points in prop::collection::vec(prop::array::uniform3(-4_i8..4), 0..60),
            place in prop::array::uniform3(-5_i8..5),
            without in 0_u32..60,
        ) {
            let points: Vec<PointMm> = points.into_iter().map(|p| p.map(f64::from)).collect();
            let place = place.map(f64::from);
            let expected = (0..).zip(&points)
                .filter(|&(number, _)| number != without)
                .map(|(number, &point)| (number, squared_mm2(point, place)))
                .min_by(|a, b| a.1.total_cmp(&b.1));
            prop_assert_eq!(Tree::new(&points).nearest(place, |n| n != without), expected);
        }
    }
}
