//! τ and strips that fit the points.

use rayon::prelude::*;

use crate::cloud::{Cloud, PlaceId};
use crate::extract::ExtractError;
use crate::functions::Field;
use crate::strips::{Strips, StripsError};

/// τ from the points in mm; `None` of fewer than two places.
///
/// 1.3 times the distance to the tenth neighbour where points lie thinnest: 98 of 100 places have no larger one. Of points scattered
/// evenly on a surface that is six spacings. So τ does not depend on how points that lie next to each other fall, and bridges the thin regions of
/// uneven samplings.
pub fn auto_tau_mm<const D: usize>(cloud: &Cloud<D>) -> Option<f64> {
    tau_by(cloud.reach_of_some(NEIGHBOURS, SOME))
}

/// τ by the distances of some places to their tenth neighbours, in mm.
pub(crate) fn tau_by(mut reach: Vec<f64>) -> Option<f64> {
    reach.sort_unstable_by(f64::total_cmp);
    let at = (reach.len() as f64 * SHARE) as usize;
    let thin_mm = *reach.get(at.min(reach.len().checked_sub(1)?))?;
    Some(OF_REACH * thin_mm)
}

/// Strips for τ: as many as are at least `STRIP`·τ wide in space.
///
/// Of lengths they are of equal width. Of another function a strip is as wide as its steepest places need, so strips are wider in
/// value where the function is steep. Steep are places with a larger slope than 19 of 20 with about the same value.
///
/// # Errors
///
/// Values that are not finite; neighbours that cannot be listed.
pub fn auto_strips<const D: usize>(
    cloud: &Cloud<D>,
    field: &Field,
    tau_mm: f64,
) -> Result<Strips, ExtractError> {
    let Some([low, high]) = field.range() else {
        return Err(StripsError::Range { low: f64::NAN, high: f64::NAN }.into());
    };
    if field.is_length {
        let count = (high - low) / (STRIP * tau_mm);
        let count = if count.is_finite() { (count as usize).clamp(1, MOST) } else { 1 };
        return Ok(Strips::uniform(low, high, count)?);
    }
    let mut steep = steepness(cloud, field, tau_mm)?;
    steep.sort_unstable_by(|a, b| a.0.total_cmp(&b.0).then(a.1.total_cmp(&b.1)));
    let (mut inner, mut begins, mut width) = (Vec::new(), low, 0.0_f64);
    for alike in steep.chunks_mut(ALIKE) {
        let ends = alike.last().map_or(high, |last| last.0);
        let at = (alike.len() * STEEP_OF_20) / 20;
        let steepest = alike.select_nth_unstable_by(at, |a, b| a.1.total_cmp(&b.1)).1;
        width = width.max(STRIP * steepest.1);
        if ends - begins >= width && inner.len() < MOST {
            inner.push(ends);
            (begins, width) = (ends, 0.0);
        }
    }
    // What is left at the end is too narrow for a strip.
    inner.pop();
    Ok(Strips::between(low, high, &inner)?)
}

/// The value of every place, and how much the function changes there over τ: by its neighbours.
fn steepness<const D: usize>(
    cloud: &Cloud<D>,
    field: &Field,
    tau_mm: f64,
) -> Result<Vec<(f64, f64)>, ExtractError> {
    let nearest = cloud.nearest(NEIGHBOURS)?;
    let of = |place: usize| {
        let value = field.values[place];
        let change = |&other: &PlaceId| (field.values[other as usize] - value).abs();
        let most = nearest.neighbours(place as PlaceId).iter().map(change).fold(0.0, f64::max);
        let reach_mm = nearest.distances_mm(place as PlaceId).last().copied();
        (value, reach_mm.map_or(0.0, |reach_mm| most * tau_mm / reach_mm))
    };
    Ok((0..cloud.len()).into_par_iter().map(of).collect())
}

/// The neighbour whose distance tells how thin the points lie.
pub(crate) const NEIGHBOURS: usize = 10;

/// Places that are looked at.
pub(crate) const SOME: usize = 50_000;

/// Share of the places that lie denser than the thinnest ones.
const SHARE: f64 = 0.98;

/// τ over the distance to the tenth neighbour of thin places.
const OF_REACH: f64 = 1.3;

/// Places with about the same value.
const ALIKE: usize = 60;

/// Of 20 of them so many are not steep.
const STEEP_OF_20: usize = 19;

/// Widths of strips over τ.
pub(crate) const STRIP: f64 = 1.5;

/// Automatic strips at most.
const MOST: usize = 10_000;
