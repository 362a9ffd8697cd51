//! τ and strips that fit the points.

use crate::cloud::Cloud;
use crate::functions::Field;

/// τ from the points in mm; `None` of fewer than two places.
///
/// 1.3 times the distance to the tenth neighbour where points lie thinnest: 98 of 100 places have no larger one. Of points scattered
/// evenly on a surface that is six spacings. So τ does not depend on how points that lie next to each other fall, and bridges the thin regions of
/// uneven samplings.
pub fn auto_tau_mm<const D: usize>(cloud: &Cloud<D>) -> Option<f64> {
    let mut reach = cloud.reach_of_some(NEIGHBOURS, SOME);
    reach.sort_unstable_by(f64::total_cmp);
    let at = (reach.len() as f64 * SHARE) as usize;
    let thin_mm = *reach.get(at.min(reach.len().checked_sub(1)?))?;
    Some(OF_REACH * thin_mm)
}

/// How many strips of equal width there are for τ: as many as are at least `STRIP`·τ wide in space.
pub fn auto_strips<const D: usize>(cloud: &Cloud<D>, field: &Field, tau_mm: f64) -> usize {
    let Some([low, high]) = field.range() else { return 1 };
    let slope = if field.is_length { 1.0 } else { slope_of(cloud, field) };
    let count = (high - low) / (STRIP * tau_mm * slope);
    if count.is_finite() { (count as usize).clamp(1, MOST) } else { 1 }
}

/// The median of |f(p) − f(q)| / ‖p − q‖ of places p and their first neighbours in the order of places.
fn slope_of<const D: usize>(cloud: &Cloud<D>, field: &Field) -> f64 {
    let pairs = cloud.places().windows(2).zip(field.values.windows(2));
    let mut slopes: Vec<f64> = pairs
        .map(|(places, values)| {
            let square = crate::tree::squared_distance(&places[0], &places[1]);
            (values[1] - values[0]).abs() / square.sqrt()
        })
        .collect();
    if slopes.is_empty() {
        return 1.0;
    }
    let middle = slopes.len() / 2;
    *slopes.select_nth_unstable_by(middle, f64::total_cmp).1
}

/// The neighbour whose distance tells how thin the points lie.
const NEIGHBOURS: usize = 10;

/// Places that are looked at.
const SOME: usize = 50_000;

/// Share of the places that lie denser than the thinnest ones.
const SHARE: f64 = 0.98;

/// τ over the distance to the tenth neighbour of thin places.
const OF_REACH: f64 = 1.3;

/// Widths of strips over τ.
const STRIP: f64 = 1.5;

/// Automatic strips at most.
const MOST: usize = 10_000;
